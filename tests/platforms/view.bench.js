// How fast the page of 5 000 buildings loads and turns: the quick start beside itself 71 times, in software WebGL.
// bash scripts/test-platforms.sh tests/platforms/view.bench.js
'use strict';

const assert = require('node:assert/strict');
const fs = require('node:fs');
const path = require('node:path');
const { test } = require('node:test');
const { pathToFileURL } = require('node:url');
const { launch } = require('./browser.js');
const tool = require('./gable.js');

const COPIES = 71;

/** A sequence of copies of the buildings of another, beside each other. */
function replicate(from, to) {
  const lines = fs.readFileSync(from, 'utf8').trim().split('\n');
  const out = [lines[0]];
  const { scale } = JSON.parse(lines[0]).transform;
  for (let copy = 0; copy < COPIES; copy += 1) {
    const shift = [(copy % 9) * 120, Math.floor(copy / 9) * 150, 0].map((metres, axis) =>
      Math.round(metres / scale[axis]),
    );
    for (const line of lines.slice(1)) {
      const feature = JSON.parse(line);
      const renamed = (id) => `${id}/${copy}`;
      const objects = Object.entries(feature.CityObjects).map(([id, object]) => {
        const family = {
          ...(object.children && { children: object.children.map(renamed) }),
          ...(object.parents && { parents: object.parents.map(renamed) }),
        };
        const { geographicalExtent, ...rest } = object;
        return [renamed(id), { ...rest, ...family }];
      });
      const vertices = feature.vertices.map((v) => v.map((n, axis) => n + shift[axis]));
      out.push(
        JSON.stringify({ ...feature, id: renamed(feature.id), CityObjects: Object.fromEntries(objects), vertices }),
      );
    }
  }
  fs.writeFileSync(to, `${out.join('\n')}\n`);
}

test('5 000 buildings', async (t) => {
  const folder = tool.folder();
  const browser = await launch();
  try {
    const [many, html] = ['many.city.jsonl', 'many.html'].map((name) => path.join(folder, name));
    replicate(tool.delft(folder, 'one.city.jsonl'), many);
    const started = performance.now();
    tool.gable('view', many);
    t.diagnostic(
      `${(fs.statSync(many).size / 1e6).toFixed(1)} MB of CityJSONSeq: page of ${(fs.statSync(html).size / 1e6).toFixed(1)} MB written in ${((performance.now() - started) / 1000).toFixed(1)} s`,
    );
    const page = await browser.newPage();
    await page.setViewport({ width: 1400, height: 900 });
    await page.goto(pathToFileURL(html).href);
    await page.waitForSelector('html[data-ready]', { timeout: 240_000 });
    const figures = await page.evaluate(async () => {
      const { model, view, camera, pointer, state, colourings, loadMilliseconds } = window.gable;
      const timed = async (count, act) => {
        const started = performance.now();
        for (let i = 0; i < count; i += 1) {
          await act(i);
        }
        return (performance.now() - started) / count;
      };
      const gl = view.renderer.getContext();
      const pixel = new Uint8Array(4);
      const frame = async () => {
        camera.turn(0.05, 0);
        view.draw(performance.now());
        // The frame is done when a pixel of it can be read.
        gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
      };
      await frame();
      return {
        buildings: model.features.length,
        triangles: view.solid.drawRange.count / 3,
        loadMilliseconds,
        frame: await timed(10, frame),
        // What the processor does for a frame, without the software that stands in for a graphics card.
        submit: await timed(10, async () => view.draw(performance.now())),
        pick: await timed(50, async (i) => pointer.at(400 + i * 15, 300 + i * 5)),
        colour: await timed(6, async (i) => state.set({ colouring: colourings[i] })),
        calls: view.renderer.info.render.calls,
      };
    });
    assert.equal(figures.buildings, 71 * COPIES);
    t.diagnostic(
      JSON.stringify(figures, (_, value) => (typeof value === 'number' ? Math.round(value * 10) / 10 : value)),
    );
  } finally {
    await browser.close();
    fs.rmSync(folder, { recursive: true, force: true });
  }
});
