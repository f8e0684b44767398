// The page of `gable explain`, opened from the file system as a user would.
'use strict';

const assert = require('node:assert/strict');
const { spawnSync } = require('node:child_process');
const fs = require('node:fs');
const path = require('node:path');
const { after, before, test } = require('node:test');
const { launch } = require('./browser.js');
const tool = require('./gable.js');
const { PHONE, boxOf, drawn, openPage, text } = require('./page.js');

const DATA = path.resolve(__dirname, '../../examples/data');
const HOUSE = 'NL.IMBAG.Pand.0503100000017310';
const STEPS = ['points', 'found', 'refined', 'walls', 'cells', 'field', 'cut', 'surface', 'result'];

let browser;
let folder;
let house;

before(async () => {
  folder = tool.folder();
  house = path.join(folder, 'house.html');
  const [tile, footprints] = ['delft_ahn3.laz', 'footprints.geojson'].map((name) => path.join(DATA, name));
  tool.gable('explain', tile, '-f', footprints, '--id', HOUSE, '-o', house);
  browser = await launch();
});

after(async () => {
  await browser?.close();
  fs.rmSync(folder, { recursive: true, force: true });
});

/** How many different colours the canvas shows, roughly: an empty picture has a few greys. */
const colourful = (page) =>
  page.evaluate(async () => {
    const { picture } = window.gable;
    picture.draw(performance.now());
    const bitmap = await createImageBitmap(document.getElementById('canvas'));
    const canvas = new OffscreenCanvas(bitmap.width, bitmap.height);
    const context = canvas.getContext('2d');
    context.drawImage(bitmap, 0, 0);
    const { data } = context.getImageData(0, 0, bitmap.width, bitmap.height);
    let count = 0;
    for (let i = 0; i < data.length; i += 4) {
      const [r, g, b] = data.subarray(i, i + 3);
      count += Math.max(r, g, b) - Math.min(r, g, b) > 40 ? 1 : 0;
    }
    return count / (data.length / 4);
  });

test('every step of a building is shown, in both themes and without a network', async () => {
  for (const scheme of ['light', 'dark']) {
    const page = await openPage(browser, house, { scheme });
    assert.equal(await text(page, '#title'), HOUSE);
    assert.deepEqual(await page.$$eval('#steps button', (all) => all.map(({ dataset }) => dataset.step)), STEPS);
    assert.equal((await page.$$('#steps button:disabled')).length, 0);
    const seen = new Set();
    for (const [i, key] of STEPS.entries()) {
      await page.click(`#steps [data-step=${key}]`);
      await drawn(page);
      const title = await text(page, '#step h2');
      assert.equal(await text(page, '#now'), `${i + 1}. ${title}`);
      seen.add(title);
      assert.ok((await text(page, '#step .text')).length > 100, key);
      assert.ok((await page.$$('#step dl dt')).length >= 3, `${key} has figures`);
      assert.ok((await colourful(page)) > 0.003, `${scheme}: ${key} shows something`);
      assert.match(await page.evaluate(() => window.location.hash), i === 0 ? /^$/ : new RegExp(`step=${key}`));
    }
    assert.equal(seen.size, STEPS.length);
    assert.deepEqual(page.faults, []);
    assert.deepEqual(
      page.asked.filter((url) => !/^(file|data|blob):/.test(url)),
      [],
    );
    await page.close();
  }
});

test('what is drawn is what the figures say', async () => {
  const page = await openPage(browser, house);
  const figure = (name) =>
    page.$$eval(
      '#step dt',
      (all, name) => all.find((node) => node.textContent === name)?.nextSibling.textContent ?? null,
      name,
    );
  const triangles = () =>
    page.evaluate(() =>
      window.gable.picture.layers
        .flatMap(({ objects }) => objects)
        .filter(({ isMesh }) => isMesh)
        .reduce((sum, { geometry }) => sum + geometry.index.count / 3, 0),
    );
  const points = () =>
    page.evaluate(() =>
      window.gable.picture.layers
        .flatMap(({ objects }) => objects)
        .filter(({ isPoints }) => isPoints)
        .map(({ geometry }) => geometry.attributes.position.count),
    );
  // Around the building, and its own on top.
  assert.equal((await points())[1], Number(await figure('points of the building')));
  await page.keyboard.press('5');
  const cells = Number(await figure('cells'));
  const beyond = Number(await figure('cells beyond the footprint, which are outside'));
  const drawnCells = () => page.evaluate(() => new Set(window.gable.picture.layers[0].solid.owner).size);
  assert.equal(await drawnCells(), cells - beyond);
  await page.click('#step [data-choice=beyond]');
  assert.equal(await drawnCells(), cells);
  await page.keyboard.press('7');
  assert.equal(await drawnCells(), Number(await figure('cells inside')));
  await page.keyboard.press('8');
  const faces = Number(await figure('faces'));
  assert.equal(await page.evaluate(() => window.gable.building.faces.count), faces);
  assert.ok((await triangles()) >= faces);
  const entries = await page.$$eval('#step .entry b', (all) => all.map((node) => Number(node.textContent)));
  assert.equal(
    entries.reduce((sum, count) => sum + count),
    faces,
  );
  // Cells move apart, and back.
  await page.evaluate(() => (window.location.hash = '#step=cells&apart=0'));
  await page.waitForFunction(() => window.gable.state.step.key === 'cells' && window.gable.state.choices.apart === 0);
  const reach = () =>
    page.evaluate(() => Math.max(...window.gable.picture.layers[0].position.array.map((value) => Math.abs(value))));
  const together = await reach();
  await page.$eval('#step [data-choice=apart]', (node) => {
    node.value = '1';
    node.dispatchEvent(new Event('input'));
  });
  assert.ok((await reach()) > 1.5 * together, `${await reach()} and ${together}`);
  assert.match(await page.evaluate(() => window.location.hash), /apart=1/);
  assert.deepEqual(page.faults, []);
  await page.close();
});

test('keys go from step to step, and what is pointed at says what it is', async () => {
  const page = await openPage(browser, house);
  await page.focus('#canvas');
  for (const key of STEPS.slice(1)) {
    await page.keyboard.press('n');
    assert.equal(await page.evaluate(() => window.gable.state.step.key), key);
  }
  await page.keyboard.press('n');
  assert.equal(await page.evaluate(() => window.gable.state.step.key), 'result', 'there is no next one');
  await page.keyboard.press('b');
  await page.keyboard.press('o');
  await drawn(page);
  const place = await page.evaluate(() => {
    const { picture } = window.gable;
    const box = document.getElementById('canvas').getBoundingClientRect();
    for (let x = box.left + 20; x < box.right; x += 8) {
      for (let y = box.top + 60; y < box.bottom; y += 8) {
        if (picture.at(x, y)?.[0] === 'RoofSurface') {
          return [x, y];
        }
      }
    }
    return null;
  });
  await page.mouse.move(...place);
  await page.waitForFunction(() => !document.getElementById('tip').hidden);
  assert.match(await text(page, '#tip'), /RoofSurface[\d.]+° from the horizontal/);
  assert.deepEqual(page.faults, []);
  await page.close();
});

test('on a phone the steps are in the sheet, and everything is large enough for fingers', async () => {
  const page = await openPage(browser, house, { size: PHONE });
  for (const key of ['points', 'cells', 'result']) {
    await page.evaluate((key) => (window.location.hash = `#step=${key}`), key);
    await page.waitForFunction((key) => window.gable.state.step.key === key, {}, key);
    await drawn(page);
    const small = await page.evaluate(() => {
      const found = [];
      for (const node of document.querySelectorAll('button, input, summary')) {
        const { width, height } = (node.type === 'checkbox' ? node.parentElement : node).getBoundingClientRect();
        if (width > 0 && (width < 43.5 || height < 43.5)) {
          found.push(`${node.id || node.className || node.textContent}: ${width} by ${height}`);
        }
      }
      return found;
    });
    assert.deepEqual(small, [], key);
    const [side, main] = [await boxOf(page, '#side'), await boxOf(page, 'main')];
    assert.ok(side.top >= main.bottom - 1 && side.width === PHONE.width, JSON.stringify([side, main]));
  }
  assert.deepEqual(page.faults, []);
  await page.close();
});

test('a building without points shows what is around, and says why there is no more', async () => {
  const footprints = path.join(folder, 'yard.geojson');
  const ring = [
    [84958, 447523],
    [84961, 447523],
    [84961, 447526],
    [84958, 447526],
    [84958, 447523],
  ];
  const layer = {
    type: 'FeatureCollection',
    crs: { type: 'name', properties: { name: 'urn:ogc:def:crs:EPSG::28992' } },
    features: [{ type: 'Feature', properties: { id: 'yard' }, geometry: { type: 'Polygon', coordinates: [ring] } }],
  };
  fs.writeFileSync(footprints, JSON.stringify(layer));
  const yard = path.join(folder, 'yard.html');
  const tile = path.join(DATA, 'delft_ahn3.laz');
  const { status, stderr } = spawnSync(
    process.env.GABLE,
    ['explain', tile, '-f', footprints, '--id', 'yard', '-o', yard],
    { encoding: 'utf8' },
  );
  assert.equal(status, 2, stderr);
  const page = await openPage(browser, yard);
  assert.match(await text(page, '#failure'), /no building point lies in the footprint/);
  const there = await page.$$eval('#steps button:not(:disabled)', (all) => all.map(({ dataset }) => dataset.step));
  assert.deepEqual(there, ['points', 'result']);
  assert.match(await text(page, '#step .entries'), /around: /);
  await page.keyboard.press('n');
  assert.equal(await page.evaluate(() => window.gable.state.step.key), 'result');
  assert.deepEqual(page.faults, []);
  await page.close();
});
