// The page of `gable view`, opened from the file system as a user would.
'use strict';

const assert = require('node:assert/strict');
const fs = require('node:fs');
const path = require('node:path');
const { after, before, test } = require('node:test');
const { launch } = require('./browser.js');
const tool = require('./gable.js');
const { colours, drawn, openPage: openIn, project, text } = require('./page.js');

const DATA = path.resolve(__dirname, '../../examples/data');

let browser;
let folder;

before(async () => {
  folder = tool.folder();
  const [tile, footprints] = ['delft_ahn3.laz', 'footprints.geojson'].map((name) => path.join(DATA, name));
  tool.gable('reconstruct', tile, '-f', footprints, '-o', path.join(folder, 'delft.city.json'), '--view', '--quiet');
  browser = await launch();
});

after(async () => {
  await browser?.close();
  fs.rmSync(folder, { recursive: true, force: true });
});

const openPage = (file, scheme) => openIn(browser, file, { scheme });

/** Makes the page of a model. */
function view(model, name) {
  const file = path.join(folder, `${name}.city.json`);
  fs.writeFileSync(file, typeof model === 'string' ? model : JSON.stringify(model));
  tool.gable('view', file);
  return path.join(folder, `${name}.html`);
}

/** The largest roof of each building as the file has it: { id, place in CRS coordinates, area of its box }. */
function roofs(model) {
  const { scale, translate } = model.transform;
  const place = (v) => model.vertices[v].map((n, axis) => n * scale[axis] + translate[axis]);
  const found = [];
  for (const [id, object] of Object.entries(model.CityObjects)) {
    const solid = object.geometry?.find((geometry) => geometry.type === 'Solid' && geometry.lod === '2.2');
    solid?.boundaries[0].forEach((rings, face) => {
      const surface = solid.semantics.surfaces[solid.semantics.values[0][face]];
      // The middle of a flat triangle or quadrangle is on it.
      if (surface.type === 'RoofSurface' && surface.slope < 1 && rings.length === 1 && rings[0].length === 4) {
        const ring = rings[0].map(place);
        const middle = [0, 1, 2].map((axis) => ring.reduce((sum, p) => sum + p[axis], 0) / ring.length);
        const [dx, dy] = [0, 1].map(
          (axis) => Math.max(...ring.map((p) => p[axis])) - Math.min(...ring.map((p) => p[axis])),
        );
        found.push({ id: object.parents?.[0] ?? id, place: middle, area: dx * dy });
      }
    });
  }
  return found.sort((a, b) => b.area - a.area);
}

test('the quick start: counts, clicks, colours, both themes', async () => {
  const model = JSON.parse(fs.readFileSync(path.join(folder, 'delft.city.json'), 'utf8'));
  const buildings = Object.values(model.CityObjects).filter((object) => object.type === 'Building').length;
  for (const scheme of ['light', 'dark']) {
    const page = await openPage(path.join(folder, 'delft.html'), scheme);
    assert.equal(await text(page, '#building-count'), String(buildings));
    assert.equal(await page.evaluate(() => document.documentElement.dataset.theme), scheme);
    await page.keyboard.press('o');
    await drawn(page);
    const seen = roofs(model).slice(0, 6);
    const places = [];
    for (const { id, place } of seen) {
      const [x, y] = await project(page, place);
      places.push([x, y]);
      await page.mouse.click(x, y);
      assert.equal(await text(page, '#selected-id'), id);
      assert.match(await text(page, '#panel'), /RoofSurface/);
      await page.keyboard.press('Escape');
    }
    await page.mouse.move(600, 790);
    await drawn(page);
    for (const [r, g, b] of await colours(page, places)) {
      assert.ok(r > 120 && r > 1.6 * g && r > 2 * b, `a roof is red, this is ${[r, g, b]}`);
    }
    const [[back]] = [await colours(page, [[330, 790]])];
    assert.ok(scheme === 'light' ? Math.min(...back) > 200 : Math.max(...back) < 80, `${scheme}: ${back}`);
    await page.click('#theme');
    assert.notEqual(await page.evaluate(() => document.documentElement.dataset.theme), scheme);
    assert.deepEqual(page.faults, []);
    assert.deepEqual(
      page.asked.filter((url) => !/^(file|data|blob):/.test(url)),
      [],
    );
    await page.close();
  }
});

test('colourings, levels of detail, points, search and filters do what they say', async () => {
  const page = await openPage(path.join(folder, 'delft.html'));
  const triangles = () => page.evaluate(() => window.gable.view.solid.drawRange.count / 3);
  const all = await page.evaluate(() => window.gable.model.triangles.length / 3);
  const shown = {};
  for (const lod of ['0', '1.2', '2.2']) {
    await page.click(`#lods [data-lod="${lod}"]`);
    shown[lod] = await triangles();
  }
  assert.equal(shown['0'] + shown['1.2'] + shown['2.2'], all);
  assert.ok(shown['0'] < shown['1.2'] && shown['1.2'] < shown['2.2']);
  await page.click('#lods [data-lod="best"]');
  assert.equal(await triangles(), shown['2.2']);

  await page.focus('#canvas');
  await page.keyboard.press('2');
  assert.equal(await page.$eval('#colourings [aria-checked=true]', (node) => node.dataset.key), 'rmse');
  const counts = await page.$$eval('.histogram .bar', (bars) => bars.map((bar) => Number(bar.dataset.count)));
  assert.equal(
    counts.reduce((sum, count) => sum + count),
    71,
  );
  const most = counts.indexOf(Math.max(...counts));
  await page.evaluate(
    (most) => document.querySelectorAll('.histogram .bar')[most].dispatchEvent(new MouseEvent('click')),
    most,
  );
  const passing = () =>
    page.evaluate(() => window.gable.model.features.filter((_, f) => window.gable.state.isIn(f)).length);
  assert.equal(await passing(), counts[most]);
  await page.focus('#canvas');
  await page.keyboard.press('Escape');
  assert.equal(await passing(), 71);

  await page.keyboard.press('p');
  assert.ok(await page.evaluate(() => window.gable.view.points.visible && window.gable.model.classes.length > 50_000));
  const id = await page.evaluate(() => window.gable.model.features[40].id);
  await page.keyboard.press('/');
  await page.keyboard.type(id.slice(-9));
  await page.keyboard.press('Enter');
  assert.equal(await text(page, '#selected-id'), id);
  await drawn(page);
  const away = await page.evaluate(() => {
    const { model, camera } = window.gable;
    const box = model.boxes.subarray(40 * 6, 40 * 6 + 6);
    return Math.hypot(
      camera.controls.target.x - (box[0] + box[3]) / 2,
      camera.controls.target.y - (box[1] + box[4]) / 2,
    );
  });
  assert.ok(away < 8, `it looks at the building, ${away} m away`);
  assert.deepEqual(page.faults, []);
  await page.close();
});

test('a model of another maker: what it lacks is greyed out, its faults are listed and found', async () => {
  const lines = fs
    .readFileSync(path.join(DATA, 'reference_3dbag_lod22.city.jsonl'), 'utf8')
    .trim()
    .split('\n')
    .map(JSON.parse);
  const part = Object.values(lines[3].CityObjects).find((object) => object.type === 'BuildingPart');
  const solid = part.geometry.find((geometry) => geometry.lod === '2.2' || geometry.lod === 2.2);
  solid.boundaries[0].shift();
  solid.semantics.values[0].shift();
  const page = await openPage(view(lines.map((line) => JSON.stringify(line)).join('\n'), 'opened'));
  assert.equal(await text(page, '#building-count'), '11');
  assert.ok(
    await page.$eval(
      '#colourings [data-key=completeness]',
      (node) => node.disabled && node.title.includes('gable_missing_largest'),
    ),
  );
  assert.match(await text(page, '#reason'), /Greyed out: no building has .*gable_missing_largest/);
  assert.match(await text(page, '#faults'), /302 shell not closed/);
  await page.click('#faults .list button');
  assert.equal(await text(page, '#selected-id'), lines[3].id);
  await page.focus('#canvas');
  await page.keyboard.press('6');
  assert.match(await text(page, '#legend'), /valid10.*invalid1/);
  assert.deepEqual(page.faults, []);
  await page.close();
});

test('attributes are text, whatever stands in them', async () => {
  const evil = '</script><script>alert(1)</script><img src=x onerror=alert(2)>';
  const model = JSON.parse(fs.readFileSync(path.join(folder, 'delft.city.json'), 'utf8'));
  const [id, object] = Object.entries(model.CityObjects).find(([, object]) => object.type === 'Building');
  object.attributes = {
    ...object.attributes,
    [evil]: evil,
    gable_roof_type: evil,
    gable_success: false,
    gable_fallback_detail: evil,
  };
  model.CityObjects = { [evil]: { ...object }, ...model.CityObjects };
  delete model.CityObjects[id];
  (object.children ?? []).forEach((child) => (model.CityObjects[child].parents = [evil]));
  const page = await openPage(view(model, 'evil'));
  assert.equal(await text(page, '#building-count'), '71');
  await page.click('#faults .list button');
  assert.equal(await text(page, '#selected-id'), evil);
  await page.focus('#canvas');
  await page.keyboard.press('4');
  assert.ok((await text(page, '#panel')).includes(evil));
  assert.equal(await page.$('img'), null);
  assert.deepEqual(page.faults, []);
  await page.close();
});
