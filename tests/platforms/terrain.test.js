// A model with terrain: its 3D Tiles by the glTF validator and in CesiumJS, and the page in a browser.
'use strict';

const assert = require('node:assert/strict');
const fs = require('node:fs');
const path = require('node:path');
const { after, before, test } = require('node:test');
const { pathToFileURL } = require('node:url');
const validator = require('gltf-validator');
const { launch, open, serve } = require('./browser.js');
const { delft, folder, gable } = require('./gable.js');
const glb = require('./glb.js');

let place, model, tileset, tiles;

before(() => {
  place = folder();
  const file = delft(place, 'delft.city.json', '--terrain', '--terrain-tile', '100', '--view');
  model = JSON.parse(fs.readFileSync(file));
  gable('convert', file, '-o', path.join(place, 'delft.3dtiles'));
  tileset = JSON.parse(fs.readFileSync(path.join(place, 'delft.3dtiles/tileset.json')));
  tiles = fs.readdirSync(path.join(place, 'delft.3dtiles/tiles')).map((name) => path.join(place, 'delft.3dtiles/tiles', name));
});

after(() => fs.rmSync(place, { recursive: true, force: true }));

const terrain = () => Object.keys(model.CityObjects).filter((id) => model.CityObjects[id].type === 'TINRelief');

test('the glTF validator finds nothing to complain of', async () => {
  for (const file of tiles) {
    const { issues } = await validator.validateBytes(new Uint8Array(fs.readFileSync(file)), { maxIssues: 1000 });
    const known = ['UNSUPPORTED_EXTENSION', 'UNUSED_OBJECT'];
    const told = issues.messages.filter(({ code, severity }) => severity < 2 || !known.includes(code));
    assert.deepEqual(told, [], file);
  }
});

test('the ground of every building meets vertices of the terrain', () => {
  const fine = tiles.filter((file) => file.endsWith('_fine.glb'));
  const all = fine.flatMap((file) => glb.vertices(glb.read(file), tileset.root.transform));
  const [ground, relief] = ['GroundSurface', 'TINRelief'].map((name) => all.filter((vertex) => vertex.class === name));
  assert.deepEqual([...new Set(relief.map(({ id }) => id))].sort(), terrain().sort());
  const square = 1;
  const key = (position) => position.map((c) => Math.floor(c / square)).join(' ');
  const cells = new Map();
  relief.forEach(({ position }) => cells.set(key(position), [...(cells.get(key(position)) ?? []), position]));
  const near = (position) => {
    const steps = [-square, 0, square];
    const around = steps.flatMap((x) => steps.flatMap((y) => steps.map((z) => [x, y, z])));
    const found = around.flatMap((step) => cells.get(key(position.map((c, i) => c + step[i]))) ?? []);
    return Math.min(...found.map((other) => Math.hypot(...other.map((c, i) => c - position[i]))));
  };
  const distances = ground.map(({ position }) => near(position));
  const met = distances.filter((distance) => distance < 0.005).length;
  console.log(`# ${met} of ${distances.length} vertices of ground surfaces meet the terrain to 5 mm`);
  // The others lie between buildings that touch.
  assert.ok(met > 0.9 * distances.length);
});

test('CesiumJS reads the terrain beside the buildings, with its attributes', async () => {
  const cesium = path.join(path.dirname(require.resolve('cesium/package.json')), 'Build/Cesium');
  const html = `<!doctype html><meta charset="utf-8"><link rel="icon" href="data:,"><div id="view" style="width:800px;height:600px"></div>
<script>window.CESIUM_BASE_URL = '/cesium/';</script><script src="/cesium/Cesium.js"></script>
<script>
Cesium.Ion.defaultAccessToken = undefined;
globalThis.viewer = new Cesium.CesiumWidget('view', { baseLayer: false, skyBox: false, skyAtmosphere: false,
  creditContainer: document.createElement('div') });
viewer.scene.globe.show = false;
</script>`;
  const server = await serve({ '/cesium/': cesium, '/delft/': path.join(place, 'delft.3dtiles'), '/index.html': html });
  const browser = await launch();
  try {
    const page = await open(browser, `${server.origin}/index.html`);
    const found = await page.evaluate(async () => {
      const { Cesium, viewer } = globalThis;
      const options = { maximumScreenSpaceError: 0.01, skipLevelOfDetail: false };
      const tileset = await Cesium.Cesium3DTileset.fromUrl('/delft/tileset.json', options);
      viewer.scene.primitives.add(tileset);
      const features = new Map();
      tileset.tileVisible.addEventListener(({ content }) => {
        for (let i = 0; content.url.endsWith('_fine.glb') && i < content.featuresLength; i += 1) {
          const feature = content.getFeature(i);
          const names = ['type', 'gable_terrain_error', 'gable_terrain_points'];
          features.set(feature.getProperty('id'), names.map((name) => Number(feature.getProperty(name)) || feature.getProperty(name)));
        }
      });
      viewer.camera.flyToBoundingSphere(tileset.boundingSphere, { duration: 0 });
      for (let frame = 0; frame < 2000 && !(tileset.tilesLoaded && features.size > 0); frame += 1) {
        await new Promise((resolve) => setTimeout(resolve, 50));
      }
      await new Promise((resolve) => setTimeout(resolve, 500));
      return [...features];
    });
    const byId = new Map(found);
    for (const id of terrain()) {
      const { gable_terrain_error: error, gable_terrain_points: points } = model.CityObjects[id].attributes;
      assert.deepEqual(byId.get(id), ['TINRelief', error, points || undefined], id);
    }
    assert.equal([...byId.values()].filter(([type]) => type === 'Building').length, 71);
    assert.deepEqual(page.faults, []);
  } finally {
    await browser.close();
    server.close();
  }
});

test('the page shows the terrain at every level of detail, and no other ground', async () => {
  const browser = await launch();
  try {
    const page = await browser.newPage();
    await page.goto(pathToFileURL(path.join(place, 'delft.html')).href, { waitUntil: 'load' });
    await page.waitForSelector('html[data-ready]', { timeout: 120_000 });
    const shown = await page.evaluate(() => {
      const { model, view } = window.gable;
      const isShown = (feature, lod) => model.runs.slice(feature.firstRun, feature.endRun).some((run) => model.isShown(run, lod));
      const relief = model.features.filter((feature) => feature.isTerrain);
      const levels = [...document.querySelectorAll('#lods [data-lod]')].map((button) => button.dataset.lod);
      const always = model.lods.every((_, lod) => relief.every((feature) => isShown(feature, lod)));
      return { ground: view.ground, levels, always, relief: relief.length };
    });
    assert.equal(shown.ground, null);
    assert.deepEqual(shown.levels, ['best', '0', '1.2', '2.2']);
    assert.ok(shown.always && shown.relief === terrain().length);
  } finally {
    await browser.close();
  }
});
