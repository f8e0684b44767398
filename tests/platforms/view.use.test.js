// The page of `gable view` as those use it who meet it for the first time: what they look for is there, and says what it means.
'use strict';

const assert = require('node:assert/strict');
const fs = require('node:fs');
const path = require('node:path');
const { after, before, test } = require('node:test');
const { launch } = require('./browser.js');
const tool = require('./gable.js');
const { PHONE, boxOf, colours, drawn, openPage, project, text } = require('./page.js');

const DATA = path.resolve(__dirname, '../../examples/data');
const DESKTOP = { width: 1440, height: 900 };

let browser;
let folder;
let delft;

before(async () => {
  folder = tool.folder();
  const model = tool.delft(folder, 'delft.city.json');
  tool.gable('view', model, '--points', path.join(DATA, 'delft_ahn3.laz'));
  delft = path.join(folder, 'delft.html');
  browser = await launch();
});

after(async () => {
  await browser?.close();
  fs.rmSync(folder, { recursive: true, force: true });
});

/** Makes the page of a model: one document, or the lines of a sequence. */
function view(model, name) {
  const file = path.join(folder, `${name}.city.${Array.isArray(model) ? 'jsonl' : 'json'}`);
  fs.writeFileSync(
    file,
    Array.isArray(model) ? model.map((line) => JSON.stringify(line)).join('\n') : JSON.stringify(model),
  );
  tool.gable('view', file);
  return path.join(folder, `${name}.html`);
}

/** The bundled buildings of the 3DBAG, a document and features. */
const of3dbag = () =>
  fs
    .readFileSync(path.join(DATA, 'reference_3dbag_lod22.city.jsonl'), 'utf8')
    .trim()
    .split('\n')
    .map((line) => JSON.parse(line));

const ofDelft = () => JSON.parse(fs.readFileSync(path.join(folder, 'delft.city.json'), 'utf8'));

/** Takes a face off the first solid at LoD 2.2 of an object. */
function damage(object) {
  const solid = object.geometry.find(({ lod }) => String(lod) === '2.2');
  solid.boundaries[0].shift();
  solid.semantics.values[0].shift();
}

const selected = (page) => page.evaluate(() => document.getElementById('selected-id')?.textContent ?? null);

/** Waits until a condition in the page holds. */
const until = (page, condition, ...args) => page.waitForFunction(condition, { timeout: 20_000 }, ...args);

async function opened(file, options, act) {
  const page = await openPage(browser, file, { size: DESKTOP, ...options });
  await act(page);
  assert.deepEqual(page.faults, []);
  await page.close();
}

/** Nine footprints of 8 m by 8 m on a slope, the one in the middle in a pit of 3 m. */
function slope() {
  const objects = {};
  const vertices = [];
  for (let i = 0; i < 9; i += 1) {
    const [x, y] = [(i % 3) * 20, Math.floor(i / 3) * 20];
    const z = x * 0.1 - (i === 4 ? 3 : 0);
    const first = vertices.length;
    [
      [0, 0],
      [8, 0],
      [8, 8],
      [0, 8],
    ].forEach(([dx, dy]) => vertices.push([x + dx, y + dy, z].map((metres) => Math.round(metres * 1000))));
    objects[`b${i}`] = {
      type: 'Building',
      geometry: [
        {
          type: 'MultiSurface',
          lod: '0',
          boundaries: [[[first, first + 1, first + 2, first + 3]]],
          semantics: { surfaces: [{ type: 'GroundSurface' }], values: [0] },
        },
      ],
    };
  }
  return {
    type: 'CityJSON',
    version: '2.0',
    transform: { scale: [0.001, 0.001, 0.001], translate: [85_000, 447_500, 2] },
    CityObjects: objects,
    vertices,
  };
}

test('the ground of the page covers no footprint', async () => {
  const model = slope();
  for (const scheme of ['light', 'dark']) {
    await opened(view(model, 'slope'), { scheme, hash: 'lod=0' }, async (page) => {
      await page.keyboard.press('o');
      await drawn(page);
      // Near the corners of each: there the ground between others is nearest.
      const corners = Object.values(model.CityObjects).flatMap(({ geometry }) => {
        const ring = geometry[0].boundaries[0][0].map((v) => model.vertices[v]);
        const middle = [0, 1, 2].map((axis) => ring.reduce((sum, v) => sum + v[axis], 0) / 4);
        return ring.map((v) =>
          v.map((value, axis) => (0.8 * value + 0.2 * middle[axis]) / 1000 + model.transform.translate[axis]),
        );
      });
      const all = await Promise.all(corners.map((place) => project(page, place)));
      const places = await page.evaluate(
        (all) => all.filter((place) => document.elementFromPoint(...place)?.id === 'canvas'),
        all,
      );
      assert.ok(places.length >= 30, `${places.length} places`);
      for (const [r, g, b] of await colours(page, places)) {
        assert.ok(g > r && g > b + 10, `${scheme}: a footprint is green, this is ${[r, g, b]}`);
      }
    });
  }
});

test('units are units: none is called CRS', async () => {
  await opened(delft, { hash: `id=${ofDelftId()}` }, async (page) => {
    assert.match(await text(page, '#panel'), /height ground−?[\d.]+ m/);
    const names = await page.$$eval('#attribute option', (all) => all.map(({ value }) => value).filter(Boolean));
    assert.ok(names.includes('gable_height_roof_max'));
    for (const name of names) {
      await page.select('#attribute', name);
      assert.doesNotMatch(await text(page, '#legend'), /\bCRS\b/, name);
    }
    assert.doesNotMatch(await text(page, '#panel'), /\bCRS\b/);
  });
});

const ofDelftId = () => Object.entries(ofDelft().CityObjects).find(([, { type }]) => type === 'Building')[0];

test('each building is found once, by its own id and by those of its parts', async () => {
  const lines = of3dbag();
  await opened(view(lines, 'search'), {}, async (page) => {
    const find = async (what) => {
      await page.$eval('#search', (node) => (node.value = ''));
      await page.type('#search', what);
      return page.$$eval('#found li', (all) => all.map((node) => node.textContent));
    };
    const { id, CityObjects: objects } = lines[4];
    const part = Object.keys(objects).find((name) => objects[name].type === 'BuildingPart');
    assert.deepEqual(await find(id), [id]);
    assert.deepEqual(await find(part), [`${id}part ${part}`]);
    await page.keyboard.press('Enter');
    assert.equal(await selected(page), id);
    assert.equal((await find('05031')).length, 11);
  });
});

test('the panel covers no building that was clicked', async () => {
  await opened(delft, {}, async (page) => {
    // The building that reaches farthest to the right.
    const [x, y, f] = await page.evaluate(() => {
      const { camera, model, view } = window.gable;
      const reach = model.features.map((_, f) => camera.reachOnScreen(f)[1]);
      const f = reach.indexOf(Math.max(...reach));
      const box = model.boxes.subarray(f * 6, f * 6 + 6);
      const middle = [0, 1, 2].map((axis) => (box[axis] + box[axis + 3]) / 2);
      const place = view.camera.position.clone().fromArray(middle).project(view.camera);
      const canvas = document.getElementById('canvas').getBoundingClientRect();
      return [canvas.left + ((place.x + 1) / 2) * canvas.width, canvas.top + ((1 - place.y) / 2) * canvas.height, f];
    });
    assert.ok(x > DESKTOP.width - 352, `it is where the panel will be: ${x}`);
    await page.mouse.click(x, y);
    await drawn(page);
    const hit = await page.evaluate(() => window.gable.state.selection.feature);
    assert.equal(hit, f);
    const right = await page.evaluate(
      (f) => document.getElementById('canvas').getBoundingClientRect().left + window.gable.camera.reachOnScreen(f)[1],
      f,
    );
    const { left } = await boxOf(page, '#panel');
    assert.ok(right <= left, `it reaches to ${right}, the panel begins at ${left}`);
    await page.keyboard.press('Escape');
    await drawn(page);
    assert.equal(await page.evaluate(() => window.gable.camera.shift), 0);
  });
});

test('on a phone the attributes are in the sheet, and everything is large enough for fingers', async () => {
  await opened(delft, { size: PHONE }, async (page) => {
    await drawn(page);
    const small = () =>
      page.evaluate(() => {
        const found = [];
        for (const node of document.querySelectorAll(
          'button, select, input, summary, .histogram .bar .hit, #found li',
        )) {
          const { width, height } = (node.type === 'checkbox' ? node.parentElement : node).getBoundingClientRect();
          // What is not there takes no room.
          if (width > 0 && (width < 43.5 || height < 43.5)) {
            found.push(`${node.id || node.className || node.textContent}: ${width} by ${height}`);
          }
        }
        return found;
      });
    assert.deepEqual(await small(), []);
    await page.select('#attribute', 'gable_points');
    assert.deepEqual(await small(), []);
    await page.evaluate(() => (window.location.hash = `#id=${window.gable.model.features[3].id}`));
    await until(page, () => document.getElementById('selected-id'));
    await drawn(page);
    assert.deepEqual(await small(), []);
    const [panel, main, side] = [await boxOf(page, '#panel'), await boxOf(page, 'main'), await boxOf(page, '#side')];
    assert.ok(panel.top >= main.bottom - 1 && panel.bottom <= PHONE.height + 1, JSON.stringify([panel, main]));
    assert.deepEqual([panel.left, panel.width, side.height], [0, PHONE.width, 0]);
    await page.tap('#panel .close');
    await drawn(page);
    assert.equal((await boxOf(page, '#side')).width, PHONE.width);
  });
});

test('faults are to be seen without scrolling, and the next one is at the next building', async () => {
  const lines = of3dbag();
  const wrong = [3, 5, 8];
  for (const i of wrong) {
    // Faults at several levels of detail are several entries of one building.
    const part = Object.values(lines[i].CityObjects).find(({ type }) => type === 'BuildingPart');
    part.geometry.forEach((solid) => {
      solid.boundaries[0].shift();
      solid.semantics.values[0].shift();
    });
    Object.assign(lines[i].CityObjects[lines[i].id].attributes, {
      gable_success: false,
      gable_fallback_detail: 'by hand',
    });
  }
  await opened(view(lines, 'faults'), {}, async (page) => {
    const entries = await page.$$('#faults .list button');
    assert.ok(entries.length >= 2 * wrong.length, `${entries.length} entries`);
    const { top, bottom } = await boxOf(page, '#faults .list li');
    assert.ok(top > 0 && bottom < DESKTOP.height, `the first fault is at ${top} to ${bottom}`);
    await page.focus('#canvas');
    const met = [];
    for (let i = 0; i < 4; i += 1) {
      await page.keyboard.press('n');
      met.push(await selected(page));
    }
    const ids = wrong.map((i) => lines[i].id);
    assert.deepEqual(met, [...ids, ids[0]]);
    await page.keyboard.press('b');
    assert.equal(await selected(page), ids[2]);
  });
});

test('what is selected keeps the colours of its faults', async () => {
  const model = ofDelft();
  const [id, object] = Object.entries(model.CityObjects).find(([, { geometry }]) =>
    geometry?.some(({ lod }) => lod === '2.2'),
  );
  const solid = object.geometry.find(({ lod }) => lod === '2.2');
  const face = solid.semantics.values[0].findIndex((s) => solid.semantics.surfaces[s].type === 'RoofSurface');
  // A corner of the roof is lifted off its plane.
  const corner = solid.boundaries[0][face][0][0];
  model.vertices.push(model.vertices[corner].map((value, axis) => value + (axis === 2 ? 400 : 0)));
  solid.boundaries[0].forEach((rings) =>
    rings.forEach((ring) => ring.forEach((v, i) => v === corner && (ring[i] = model.vertices.length - 1))),
  );
  await opened(view(model, 'tint'), { hash: 'colour=validity&lod=2.2' }, async (page) => {
    const building = object.parents?.[0] ?? id;
    await page.keyboard.press('o');
    await drawn(page);
    // A place on a face at fault that is seen from above, off its edges.
    const place = await page.evaluate((building) => {
      const { model, pointer } = window.gable;
      const f = model.byId.get(building);
      const box = document.getElementById('canvas').getBoundingClientRect();
      for (let x = box.left + 5; x < box.right; x += 6) {
        for (let y = box.top + 60; y < box.bottom - 5; y += 6) {
          const hits = [0, 5, -5].flatMap((d) => [pointer.at(x + d, y), pointer.at(x, y + d)]);
          if (hits.every((hit) => hit?.feature === f && model.faceFaulty[hit.face] && hit.face === hits[0].face)) {
            return [x, y];
          }
        }
      }
      return null;
    }, building);
    assert.ok(place, 'a face at fault is to be seen');
    const [before] = await colours(page, [place]);
    await page.mouse.click(...place);
    await page.mouse.move(400, 880);
    assert.equal(await selected(page), building);
    await drawn(page);
    const moved = await page.evaluate(() => window.gable.camera.shift);
    const [after] = await colours(page, [[place[0] - moved, place[1]]]);
    assert.ok(before[0] > 1.8 * before[1], `a face at fault is red, this is ${before}`);
    before.forEach((value, i) => assert.ok(Math.abs(value - after[i]) <= 3, `${before} became ${after}`));
  });
});

test('the address follows what is chosen, and what is chosen follows the address', async () => {
  const ids = Object.entries(ofDelft().CityObjects)
    .filter(([, { type }]) => type === 'Building')
    .map(([id]) => id);
  await opened(delft, {}, async (page) => {
    const address = () => page.evaluate(() => Object.fromEntries(new URLSearchParams(window.location.hash.slice(1))));
    assert.deepEqual(await address(), {});
    await page.evaluate(
      (id) => window.gable.state.set({ selection: { feature: window.gable.model.byId.get(id), face: -1 } }),
      ids[7],
    );
    assert.deepEqual(await address(), { id: ids[7] });
    await page.click('#colourings [data-key=rmse]');
    await page.click('#lods [data-lod="1.2"]');
    assert.deepEqual(await address(), { id: ids[7], colour: 'rmse', lod: '1.2' });
    await page.evaluate((id) => (window.location.hash = `#id=${id}&colour=height`), ids[9]);
    await until(page, (id) => document.getElementById('selected-id')?.textContent === id, ids[9]);
    assert.equal(await page.$eval('#colourings [aria-checked=true]', ({ dataset }) => dataset.key), 'height');
    assert.equal(await page.$eval('#lods [aria-checked=true]', ({ dataset }) => dataset.lod), 'best');
    const away = await page.evaluate((id) => {
      const { model, camera } = window.gable;
      const box = model.boxes.subarray(model.byId.get(id) * 6, model.byId.get(id) * 6 + 6);
      return Math.hypot(
        camera.controls.target.x - (box[0] + box[3]) / 2,
        camera.controls.target.y - (box[1] + box[4]) / 2,
      );
    }, ids[9]);
    assert.ok(away < 8, `it looks at the building, ${away} m away`);
    // What is not there is said, and the address does not go on to claim it.
    await page.evaluate(() => (window.location.hash = '#id=nowhere'));
    await until(page, () => !document.getElementById('told').hidden);
    assert.match(await text(page, '#told'), /No building of this model has the id nowhere/);
    assert.equal(await selected(page), null);
    assert.deepEqual(await address(), {});
    await page.focus('#canvas');
    await page.keyboard.press('d');
    assert.deepEqual(await address(), { theme: 'dark' });
  });
});

test('colours mean the same in every model, until a scale is chosen', async () => {
  const scales = async (page) =>
    page.evaluate(() =>
      Object.fromEntries(
        window.gable.colourings.filter(({ isFixed }) => isFixed).map(({ key, range }) => [key, range]),
      ),
    );
  const other = view(of3dbag(), 'scales');
  let ofOther;
  await opened(other, {}, async (page) => (ofOther = await scales(page)));
  await opened(delft, { hash: 'colour=rmse' }, async (page) => {
    assert.deepEqual(await scales(page), ofOther);
    const pressed = () => page.$$eval('.scale [aria-pressed=true]', (all) => all.map((node) => node.textContent));
    assert.deepEqual(await pressed(), ['Fixed']);
    const painted = () => page.evaluate(() => window.gable.view.colour.array.reduce((sum, share) => sum + share, 0));
    const before = await painted();
    await page.$eval('.scale input:nth-of-type(2)', (node) => {
      node.value = '0.2';
      node.dispatchEvent(new Event('change'));
    });
    assert.deepEqual(await pressed(), []);
    assert.match(await page.evaluate(() => window.location.hash), /range=0%2C0\.2/);
    assert.match(await text(page, '.histogram'), /≥ 0\.2 m/);
    assert.notEqual(await painted(), before);
    await page.evaluate(() =>
      [...document.querySelectorAll('.scale button')].find((node) => node.textContent === 'Fixed').click(),
    );
    assert.equal(await painted(), before);
    assert.deepEqual(await pressed(), ['Fixed']);
  });
});

test('figures tell of the end that needs attention', async () => {
  await opened(delft, { hash: 'colour=confidence' }, async (page) => {
    const figures = () => page.$$eval('.figures span', (all) => all.map(({ textContent }) => textContent.split(' ')));
    const confidence = await figures();
    assert.deepEqual(
      confidence.map(([name]) => name),
      ['min', '10', 'median'],
    );
    const least = await page.evaluate(() =>
      Math.min(...window.gable.model.features.map(({ attributes }) => attributes.gable_confidence)),
    );
    assert.equal(Number(confidence[0][1]), least);
    await page.click('#colourings [data-key=rmse]');
    assert.deepEqual(
      (await figures()).map(([name]) => name),
      ['median', '90', 'max'],
    );
  });
});

test('an arrow shows north and turns to it', async () => {
  await opened(delft, {}, async (page) => {
    const turned = () =>
      page.$eval('#compass svg', ({ style }) => Number(style.transform.match(/rotate\((-?[\d.]+)deg\)/)[1]));
    const direction = () =>
      page.evaluate(() => {
        const { camera } = window.gable;
        const ahead = camera.controls.target.clone().sub(camera.view.camera.position);
        return (Math.atan2(ahead.x, ahead.y) * 180) / Math.PI;
      });
    await drawn(page);
    // The view looks so far clockwise from north; the needle is turned back by as much.
    assert.ok(Math.abs((await turned()) + (await direction())) < 0.2, `${await turned()} ${await direction()}`);
    assert.ok(Math.abs(await direction()) > 5);
    await page.click('#compass');
    await drawn(page);
    const [ahead, needle] = [await direction(), await turned()];
    assert.ok(Math.abs(ahead) < 0.2 && Math.abs(needle) < 0.2, `it looks to ${ahead}, the needle to ${needle}`);
  });
});

test('a model of the 3DBAG of today is understood: types of roofs, heights, volumes, quality', async () => {
  const NOW = {
    dak_type: 'b3_dak_type',
    h_maaiveld: 'b3_h_maaiveld',
    h_dak_max: 'b3_h_dak_max',
    h_dak_min: 'b3_h_dak_min',
    rmse_lod22: 'b3_rmse_lod22',
    val3dity_codes_lod22: 'b3_val3dity_lod22',
  };
  const lines = of3dbag();
  lines.slice(1).forEach((line, i) => {
    const building = line.CityObjects[line.id];
    const all = Object.entries(building.attributes).filter(([name]) => NOW[name] || name === 'identificatie');
    building.attributes = {
      ...Object.fromEntries(all.map(([name, value]) => [NOW[name] ?? name, value])),
      b3_volume_lod22: 100 + i,
      b3_kwaliteitsindicator: i > 1,
      b3_nodata_fractie_ahn4: 0.01 * i,
      b3_extrusie: i === 0 ? 'lod11_fallback' : 'standard',
    };
  });
  await opened(view(lines, 'now'), {}, async (page) => {
    const disabled = await page.$$eval('#colourings button:disabled', (all) => all.map(({ dataset }) => dataset.key));
    assert.deepEqual(disabled, ['completeness']);
    const legend = async (key) => {
      await page.click(`#colourings [data-key=${key}]`);
      return text(page, '#legend');
    };
    assert.match(await legend('roof-type'), /multiple flat2slanted9/);
    assert.match(await legend('confidence'), /held for correct9possibly wrong2/);
    assert.match(await legend('ladder'), /LoD 2\.210a block1/);
    assert.match(await legend('volume'), /min 100 m³median 105 m³max 110 m³/);
    const heights = lines.slice(1).map(({ CityObjects: objects, id }) => {
      const { b3_h_dak_max: top, b3_h_maaiveld: ground } = objects[id].attributes;
      return top - ground;
    });
    assert.match(await legend('height'), new RegExp(`max ${String(Math.round(Math.max(...heights) * 1000) / 1000)} m`));
    await page.evaluate((id) => (window.location.hash = `#id=${id}`), lines[1].id);
    await until(page, () => document.getElementById('selected-id'));
    const panel = await text(page, '#panel');
    for (const part of [
      'Building, by the 3DBAG',
      'Building, from the source',
      'no data share, AHN4',
      'roof height, max',
    ]) {
      assert.ok(panel.includes(part), `${part} in ${panel}`);
    }
    assert.match(panel, /volume, LoD 2\.2100 m³/);
  });
  // The names of the 3DBAG before 2023 are those of today without their beginning.
  await opened(view(of3dbag(), 'before'), {}, async (page) => {
    const disabled = await page.$$eval('#colourings button:disabled', (all) => all.map(({ dataset }) => dataset.key));
    assert.deepEqual(disabled, ['confidence', 'completeness', 'volume']);
  });
});
