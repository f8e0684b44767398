// 3D Tiles of a city: the corner of Delft laid side by side, with nested tilesets and an overview for each of their levels.
// GABLE_COPIES=1408 makes it 100 000 buildings.
'use strict';

const assert = require('node:assert/strict');
const fs = require('node:fs');
const path = require('node:path');
const { after, before, test } = require('node:test');
const validator = require('gltf-validator');
const { launch, open, serve } = require('./browser.js');
const { CESIUM, PAGE } = require('./cesium.js');
const { delft, folder, gable } = require('./gable.js');
const glb = require('./glb.js');

const BUILDINGS = 71;
const COPIES = Number(process.env.GABLE_COPIES ?? 300);
/** Files that the glTF validator is shown. */
const SHOWN = 60;
let place, city;

/** Writes the lines of a CityJSON text sequence so many times, side by side in a square, with new ids. */
function replicate(source, target, copies) {
  const [head, ...features] = fs.readFileSync(source, 'utf8').trim().split('\n').map((line) => JSON.parse(line));
  const vertices = features.flatMap((feature) => feature.vertices);
  const step = [0, 1].map((axis) => {
    const values = vertices.map((vertex) => vertex[axis]);
    return Math.max(...values) - Math.min(...values) + Math.round(10 / head.transform.scale[axis]);
  });
  const side = Math.ceil(Math.sqrt(copies));
  const out = fs.openSync(target, 'w');
  fs.writeSync(out, `${JSON.stringify(head)}\n`);
  for (let copy = 0; copy < copies; copy += 1) {
    const shift = [(copy % side) * step[0], Math.floor(copy / side) * step[1]];
    const name = (id) => `${copy}/${id}`;
    const lines = features.map((feature) => {
      const objects = Object.entries(feature.CityObjects).map(([id, object]) => {
        const kin = Object.fromEntries(['children', 'parents'].filter((kind) => object[kind]).map((kind) => [kind, object[kind].map(name)]));
        return [name(id), { ...object, ...kin }];
      });
      const moved = feature.vertices.map(([x, y, z]) => [x + shift[0], y + shift[1], z]);
      return `${JSON.stringify({ ...feature, id: name(feature.id), CityObjects: Object.fromEntries(objects), vertices: moved })}\n`;
    });
    fs.writeSync(out, lines.join(''));
  }
  fs.closeSync(out);
}

const read = (name) => JSON.parse(fs.readFileSync(path.join(city, name)));

/** Calls `see(tile, parent, transform)` for all tiles, those of nested tilesets in the place of what names them. */
function walk(name, see, around, files = new Set()) {
  assert.ok(!files.has(name), `${name} is named twice`);
  files.add(name);
  const down = (tile, parent) => {
    see(tile, parent);
    if (tile.content?.uri.endsWith('.json')) {
      walk(path.join(path.dirname(name), tile.content.uri), see, tile, files);
    }
    (tile.children ?? []).forEach((child) => down(child, tile));
  };
  const { root } = read(name);
  down(root, around ?? root);
  return files;
}

const bounds = ({ boundingVolume: { box } }) => [0, 1, 2].map((i) => [box[i] - box[3 + 4 * i], box[i] + box[3 + 4 * i]]);
const contents = (ending) => {
  const found = [];
  walk('tileset.json', ({ content }) => content?.uri.endsWith(ending) && found.push(content.uri));
  return found;
};

before(() => {
  place = folder();
  const [one, all] = ['delft.city.jsonl', 'city.city.jsonl'].map((name) => path.join(place, name));
  delft(place, 'delft.city.jsonl');
  replicate(one, all, COPIES);
  city = path.join(place, 'city.3dtiles');
  gable('convert', all, '-o', city);
});

after(() => fs.rmSync(place, { recursive: true, force: true }));

test('every building is in one fine tile, every file is reached, and errors and boxes shrink on the way down', () => {
  const files = new Set();
  let nested = 0;
  walk('tileset.json', (tile, parent) => {
    assert.ok(tile.geometricError <= parent.geometricError, `${JSON.stringify(tile.content)}`);
    const around = bounds(parent);
    assert.ok(bounds(tile).every(([low, high], i) => low >= around[i][0] - 0.02 && high <= around[i][1] + 0.02), `${JSON.stringify(tile.content)}`);
    if (tile.content) {
      files.add(tile.content.uri);
      nested += tile.content.uri.endsWith('.json') ? 1 : 0;
    }
  });
  const there = fs.readdirSync(path.join(city, 'tiles')).map((name) => `tiles/${name}`);
  const tilesets = fs.readdirSync(city).filter((name) => name.endsWith('.json') && name !== 'tileset.json');
  assert.deepEqual([...files].sort(), [...there, ...tilesets].sort());
  const ids = contents('_fine.glb').flatMap((uri) => glb.ids(path.join(city, uri)));
  assert.equal(ids.length, COPIES * BUILDINGS);
  assert.equal(new Set(ids).size, ids.length);
  console.log(`# ${ids.length} buildings, ${there.length} files of tiles, ${nested} nested tilesets`);
  assert.ok(nested > 0);
});

test('the glTF validator finds nothing to complain of in overviews, blocks and fine tiles', async () => {
  for (const kind of ['_overview.glb', '_block.glb', '_fine.glb']) {
    const all = contents(kind);
    assert.ok(all.length > 0, kind);
    for (const uri of all.filter((_, i) => i % Math.ceil((3 * all.length) / SHOWN) === 0)) {
      const { issues } = await validator.validateBytes(new Uint8Array(fs.readFileSync(path.join(city, uri))), { maxIssues: 100 });
      const known = ['UNSUPPORTED_EXTENSION', 'UNUSED_OBJECT'];
      assert.deepEqual(issues.messages.filter(({ code, severity }) => severity < 2 || !known.includes(code)), [], uri);
    }
  }
});

/** Runs in the page: looks at the whole city, then down on one place, and says which tiles are drawn. */
async function look(at) {
  const { Cesium, viewer } = globalThis;
  let { tileset } = globalThis;
  if (!tileset) {
    tileset = await Cesium.Cesium3DTileset.fromUrl('/city/tileset.json', { maximumScreenSpaceError: 16, featureIdLabel: 'feature' });
    globalThis.tileset = tileset;
    globalThis.drawn = new Set();
    viewer.scene.primitives.add(tileset);
    tileset.tileVisible.addEventListener((tile) => globalThis.drawn.add(tile));
  }
  // The window of these tests is small: what is near is asked for as a large one would.
  tileset.maximumScreenSpaceError = at ? 0.5 : 16;
  if (at) {
    const sphere = new Cesium.BoundingSphere(new Cesium.Cartesian3(...at), 60);
    viewer.camera.flyToBoundingSphere(sphere, { duration: 0 });
  } else {
    viewer.camera.flyToBoundingSphere(tileset.boundingSphere, { duration: 0 });
  }
  const frame = () =>
    new Promise((resolve) => {
      const remove = viewer.scene.postRender.addEventListener(() => resolve(remove()));
    });
  const limit = Date.now() + 100_000;
  for (let quiet = 0; quiet < 5 && Date.now() < limit; quiet = tileset.tilesLoaded && globalThis.drawn.size > 0 ? quiet + 1 : 0) {
    globalThis.drawn.clear();
    await frame();
  }
  const files = [...globalThis.drawn].map((tile) => tile.content.url.split('/').pop());
  const fine = [...globalThis.drawn].find((tile) => tile.content.url.endsWith('_fine.glb'));
  return { files, bytes: tileset.totalMemoryUsageInBytes, id: fine?.content.getFeature(0).getProperty('id') };
}

test('CesiumJS draws a city from overviews when it is far, and the fine tiles of a corner when it is near', async () => {
  const server = await serve({ '/cesium/': CESIUM, '/city/': city, '/index.html': PAGE });
  const browser = await launch();
  try {
    const page = await open(browser, `${server.origin}/index.html`);
    const far = await page.evaluate(look, null);
    assert.ok(far.files.length > 0 && far.files.length < 64, `${far.files.length} tiles`);
    assert.ok(far.files.every((name) => name.endsWith('_overview.glb')), far.files.join(' '));
    // The last file that a nested tileset leads to.
    const uri = contents('_fine.glb').at(-1);
    const middle = await page.evaluate(async ({ uri, sets }) => {
      const { Cesium } = globalThis;
      const find = (tile) => (tile.content?.uri === uri ? tile : (tile.children ?? []).map(find).find(Boolean));
      for (const name of sets) {
        const set = await (await fetch(`/city/${name}`)).json();
        const tile = find(set.root);
        if (tile) {
          const { transform } = (await (await fetch('/city/tileset.json')).json()).root;
          const local = new Cesium.Cartesian3(...tile.boundingVolume.box.slice(0, 3));
          const { x, y, z } = Cesium.Matrix4.multiplyByPoint(Cesium.Matrix4.fromArray(transform), local, new Cesium.Cartesian3());
          return [x, y, z];
        }
      }
      return null;
    }, { uri, sets: fs.readdirSync(city).filter((name) => name.endsWith('.json')) });
    const near = await page.evaluate(look, middle);
    assert.ok(near.files.includes(path.basename(uri)), `${uri} is not among ${near.files.join(' ')}`);
    assert.match(near.id, /^\d+\//);
    console.log(`# far: ${far.files.length} tiles, ${(far.bytes / 1e6).toFixed(1)} MB; near: ${near.files.length} tiles, ${(near.bytes / 1e6).toFixed(1)} MB`);
    assert.deepEqual(page.faults, []);
  } finally {
    await browser.close();
    server.close();
  }
});
