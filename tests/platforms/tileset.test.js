// 3D Tiles of one run over the bundled data: the glTF validator, the place on earth, and CesiumJS in a browser.
'use strict';

const assert = require('node:assert/strict');
const fs = require('node:fs');
const path = require('node:path');
const { after, before, test } = require('node:test');
const validator = require('gltf-validator');
const { launch, open, serve } = require('./browser.js');
const { CESIUM, PAGE } = require('./cesium.js');
const { edgeDistance, geographic, onEllipsoid } = require('./earth.js');
const { delft, folder, gable } = require('./gable.js');
const glb = require('./glb.js');

const BUILDINGS = 71;
let place, model, tileset, tiles;

before(() => {
  place = folder();
  const file = delft(place, 'delft.city.json');
  model = JSON.parse(fs.readFileSync(file));
  gable('convert', file, '-o', path.join(place, 'delft.3dtiles'));
  tileset = JSON.parse(fs.readFileSync(path.join(place, 'delft.3dtiles/tileset.json')));
  tiles = fs.readdirSync(path.join(place, 'delft.3dtiles/tiles')).map((name) => path.join(place, 'delft.3dtiles/tiles', name));
});

after(() => fs.rmSync(place, { recursive: true, force: true }));

/** The LoD 0 footprint of a building: its vertices in the CRS. */
function footprint(id) {
  const { scale, translate } = model.transform;
  const flat = model.CityObjects[id].geometry.find((geometry) => geometry.lod === '0');
  return flat.boundaries.flat(2).map((v) => model.vertices[v].map((c, i) => c * scale[i] + translate[i]));
}

const buildings = () => Object.keys(model.CityObjects).filter((id) => model.CityObjects[id].type === 'Building');

test('the glTF validator finds nothing to complain of', async () => {
  assert.ok(tiles.length >= 2);
  for (const file of tiles) {
    const { issues } = await validator.validateBytes(new Uint8Array(fs.readFileSync(file)), { maxIssues: 1000 });
    const known = ['UNSUPPORTED_EXTENSION', 'UNUSED_OBJECT'];
    const told = issues.messages.filter(({ code, severity }) => severity < 2 || !known.includes(code));
    assert.deepEqual(told, [], file);
  }
});

/** The edges of a footprint with these corners, one ring after the other. */
function edges(id, corners) {
  const flat = model.CityObjects[id].geometry.find((geometry) => geometry.lod === '0');
  let first = 0;
  return flat.boundaries.flat().flatMap(({ length }) => {
    const ring = corners.slice(first, first + length);
    first += length;
    return ring.map((corner, i) => [corner, ring[(i + 1) % length]]);
  });
}

/** Metres between a point and the nearest edge of a footprint. */
const outlineDistance = (point, outline) => Math.min(...outline.map(([a, b]) => edgeDistance(point, a, b)));

/** Whether a point lies within a footprint: a line from it to the east leaves it once more than it enters. */
function isWithin([x, y], outline) {
  const across = outline.filter(([a, b]) => a[1] > y !== b[1] > y);
  const crossed = across.filter(([a, b]) => x < a[0] + ((y - a[1]) / (b[1] - a[1])) * (b[0] - a[0]));
  return crossed.length % 2 === 1;
}

/** The vertices on the ground of every building: longitude, latitude, height. */
function grounds() {
  const fine = tiles.filter((file) => file.endsWith('_fine.glb'));
  const ground = new Map();
  for (const vertex of fine.flatMap((file) => glb.vertices(glb.read(file), tileset.root.transform))) {
    if (vertex.class === 'GroundSurface') {
      ground.set(vertex.id, [...(ground.get(vertex.id) ?? []), onEllipsoid(vertex.position)]);
    }
  }
  return ground;
}

test('every building stands on its footprint to the decimetre', () => {
  const ground = grounds();
  assert.equal(ground.size, BUILDINGS);
  // How far the vertices of each building are from its outline, and how far they stand outside.
  const [along, outside] = [[], []];
  // How far heights above the ellipsoid are from those of the CRS.
  const shifts = [];
  for (const id of buildings()) {
    const corners = geographic(footprint(id), 'EPSG:28992');
    const outline = edges(id, corners);
    const distances = ground.get(id).map((vertex) => outlineDistance(vertex, outline));
    along.push(Math.max(...distances));
    outside.push(...distances.filter((_, i) => !isWithin(ground.get(id)[i], outline)));
    shifts.push(...ground.get(id).map((vertex) => vertex[2] - corners[0][2]));
  }
  const farthest = Math.max(...outside);
  console.log(`# vertices on the ground are at most ${(farthest * 1000).toFixed(1)} mm outside their footprint,`);
  console.log(`# and ${Math.min(...shifts).toFixed(3)} to ${Math.max(...shifts).toFixed(3)} m above their height`);
  assert.ok(farthest < 0.1, `${farthest} m`);
  // A building may stand back from a part of its footprint that was seen to be open.
  const exact = along.filter((distance) => distance < 0.1).length;
  assert.ok(exact >= 0.95 * BUILDINGS, `${exact} of ${BUILDINGS} buildings stand on their outline`);
  assert.ok(Math.max(...shifts) - Math.min(...shifts) < 0.1);
});

test('every file of the tileset is reached, and boxes hold those below them', () => {
  const found = [];
  const inside = (tile, parent) => {
    const [box, around] = [tile, parent].map(({ boundingVolume: { box } }) =>
      [0, 1, 2].map((i) => [box[i] - box[3 + 4 * i], box[i] + box[3 + 4 * i]]),
    );
    assert.ok(box.every(([low, high], i) => low >= around[i][0] - 0.01 && high <= around[i][1] + 0.01));
    assert.ok(tile.geometricError <= parent.geometricError);
    if (tile.content) {
      found.push(path.join(place, 'delft.3dtiles', tile.content.uri));
    }
    (tile.children ?? []).forEach((child) => inside(child, tile));
  };
  inside(tileset.root, tileset.root);
  assert.deepEqual(found.sort(), [...tiles].sort());
});

/** Runs in the page: loads the tileset, waits for its finest tiles, and collects what their features say. */
async function collect(label) {
  const { Cesium, viewer } = globalThis;
  viewer.scene.primitives.removeAll();
  const tileset = await Cesium.Cesium3DTileset.fromUrl('/delft/tileset.json', {
    maximumScreenSpaceError: 0.01,
    featureIdLabel: label,
    skipLevelOfDetail: false,
  });
  viewer.scene.primitives.add(tileset);
  globalThis.tileset = tileset;
  const features = new Map();
  tileset.tileVisible.addEventListener((tile) => {
    if (!tile.content.url.endsWith('_fine.glb')) {
      return;
    }
    for (let i = 0; i < tile.content.featuresLength; i += 1) {
      const feature = tile.content.getFeature(i);
      const names = feature.getPropertyIds();
      features.set(`${tile.content.url} ${i}`, Object.fromEntries(names.map((name) => [name, feature.getProperty(name)])));
    }
  });
  viewer.camera.flyToBoundingSphere(tileset.boundingSphere, { duration: 0 });
  await new Promise((resolve, reject) => {
    const limit = setTimeout(() => reject(new Error('the tiles do not load')), 120_000);
    const remove = viewer.scene.postRender.addEventListener(() => {
      if (tileset.tilesLoaded && features.size > 0) {
        clearTimeout(limit);
        remove();
        resolve();
      }
    });
  });
  // One more frame shows the tiles that came last.
  await new Promise((resolve) => viewer.scene.postRender.addEventListener(resolve));
  return [...features.values()].map((feature) =>
    Object.fromEntries(Object.entries(feature).map(([name, value]) => [name, typeof value === 'bigint' ? Number(value) : value])),
  );
}

/** Runs in the page: looks straight down on a point and says what is seen there. */
async function seen([longitude, latitude, height]) {
  const { Cesium, viewer, tileset } = globalThis;
  viewer.camera.setView({
    destination: Cesium.Cartesian3.fromDegrees(longitude, latitude, height + 80),
    orientation: { heading: 0, pitch: -Math.PI / 2, roll: 0 },
  });
  for (let frame = 0; frame < 3 || !tileset.tilesLoaded; frame += 1) {
    await new Promise((resolve) => requestAnimationFrame(resolve));
  }
  const { clientWidth, clientHeight } = viewer.scene.canvas;
  const centre = new Cesium.Cartesian2(clientWidth / 2, clientHeight / 2);
  return viewer.scene.pick(centre)?.getProperty?.('id');
}

test('CesiumJS shows every building where it stands, with its attributes', async () => {
  const server = await serve({ '/cesium/': CESIUM, '/delft/': path.join(place, 'delft.3dtiles'), '/index.html': PAGE });
  const browser = await launch();
  try {
    const page = await open(browser, `${server.origin}/index.html`);
    const features = await page.evaluate(collect, 'feature');
    assert.equal(features.length, BUILDINGS);
    const byId = new Map(features.map((feature) => [feature.id, feature]));
    for (const id of buildings()) {
      const { attributes } = model.CityObjects[id];
      const feature = byId.get(id);
      assert.equal(feature.type, 'Building');
      for (const [name, value] of Object.entries(attributes)) {
        if (value === null) {
          assert.equal(feature[name], undefined, name);
        } else if (typeof value === 'number') {
          assert.ok(Math.abs(feature[name] - value) < 1e-9 * Math.max(1, Math.abs(value)), `${name}: ${feature[name]} for ${value}`);
        } else if (typeof value === 'object') {
          assert.deepEqual(JSON.parse(feature[name]), value, name);
        } else if (value !== '') {
          assert.equal(String(feature[name]), String(value), name);
        }
      }
      if (attributes.gable_lod === '2.2') {
        assert.ok(feature.height > 2 && feature.height < 60, `${id} is ${feature.height} m high`);
      }
    }
    // Some of the largest footprints, looked at from above.
    let looked = 0;
    const ground = grounds();
    for (const id of buildings().slice(0, 12)) {
      const corners = footprint(id);
      const middle = [0, 1, 2].map((i) => corners.reduce((sum, corner) => sum + corner[i], 0) / corners.length);
      if (!isInside(middle, corners)) {
        continue;
      }
      const [point] = geographic([middle], 'EPSG:28992');
      assert.equal(await page.evaluate(seen, [point[0], point[1], ground.get(id)[0][2] + byId.get(id).height]), id);
      looked += 1;
    }
    assert.ok(looked >= 5);
    console.log(`# ${features.length} features, ${looked} of them seen from above`);

    const surfaces = await page.evaluate(collect, 'surface');
    const count = (type) => surfaces.filter((surface) => surface.surface_type === type).length;
    assert.ok(count('RoofSurface') > BUILDINGS / 2 && count('WallSurface') > count('RoofSurface'));
    const sloped = surfaces.find((surface) => surface.slope > 20);
    assert.ok(sloped.azimuth >= 0 && sloped.azimuth <= 360 && sloped.confidence >= 0 && sloped.object in model.CityObjects);
    assert.deepEqual(page.faults, []);
  } finally {
    await browser.close();
    server.close();
  }
});

/** Whether a point lies in a ring: crossings of a ray to the east. */
function isInside([x, y], ring) {
  const crosses = ([x0, y0], [x1, y1]) => y0 > y !== y1 > y && x < x0 + ((y - y0) / (y1 - y0)) * (x1 - x0);
  return ring.filter((corner, i) => crosses(corner, ring[(i + 1) % ring.length])).length % 2 === 1;
}
