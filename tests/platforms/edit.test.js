// The page of `gable edit`: wrong buildings of the quick start are mended as a person would, by mouse and keys alone. With
// $EDIT_PICTURES the pictures of docs/howto/edit-walkthrough.md are made on the way, into that folder.
'use strict';

const assert = require('node:assert/strict');
const fs = require('node:fs');
const path = require('node:path');
const { after, before, test } = require('node:test');
const { launch } = require('./browser.js');
const { draw, head, onScreen, openEditor, press, serve, settled, solved, tableOf } = require('./editing.js');
const tool = require('./gable.js');
const { PHONE, boxOf, text } = require('./page.js');
const { indexed } = require('./png.js');

const DATA = path.resolve(__dirname, '../../examples/data');
const TILE = path.join(DATA, 'delft_ahn3.laz');
const house = (end) => `NL.IMBAG.Pand.05031000000${end}`;

/** Of this house the front of the roof is missing: a row of points high over what is modelled. */
const MISSING = house('17311');
const FRONT = [
  [84926.3, 447489.2, 9.1],
  [84927.1, 447488.95, 9.1],
  [84927.7, 447488.7, 9.1],
];
/** Of this one a slope runs on over a lower roof: this place of the air is modelled. */
const RUNS_ON = house('17310');
const AIR = [84910.79, 447496.87, 8.4];
/** Of this one the attribute of the footprints with the floors is 3 m wrong. */
const RAISED = house('17303');
const FLOOR = -0.01;

let browser;
let folder;
let model;
let server;

before(async () => {
  folder = tool.folder();
  const footprints = JSON.parse(fs.readFileSync(path.join(DATA, 'footprints.geojson'), 'utf8'));
  footprints.features.forEach(({ properties }) => (properties.floor = properties.id === RAISED ? FLOOR + 3 : null));
  fs.writeFileSync(path.join(folder, 'footprints.geojson'), JSON.stringify(footprints));
  model = path.join(folder, 'delft.city.json');
  tool.gable(
    'reconstruct',
    TILE,
    '-f',
    path.join(folder, 'footprints.geojson'),
    '--ground-attribute',
    'floor',
    '-o',
    model,
    '--quiet',
  );
  server = await serve(model);
  browser = await launch();
});

after(async () => {
  await browser?.close();
  await server?.stop();
  fs.rmSync(folder, { recursive: true, force: true });
});

/** A picture of the documentation, if they are being made: of few colours, so that it is small. */
async function picture(page, name) {
  if (process.env.EDIT_PICTURES) {
    await settled(page);
    fs.writeFileSync(path.join(process.env.EDIT_PICTURES, `edit-${name}.png`), await indexed(page));
  }
}

/** All columns of a building as the server packs them: what is drawn, to the last bit. */
const drawnOf = (page) =>
  page.evaluate(async () => {
    const { id } = window.gable.state;
    const packed = await (await fetch(`api/building?id=${encodeURIComponent(id)}`)).text();
    const inflated = new Blob([Uint8Array.from(atob(packed), (c) => c.charCodeAt(0))])
      .stream()
      .pipeThrough(new DecompressionStream('deflate-raw'));
    const bytes = new Uint8Array(await new Response(inflated).arrayBuffer());
    const digest = await crypto.subtle.digest(
      'SHA-256',
      bytes.subarray(4 + new DataView(bytes.buffer).getUint32(0, true)),
    );
    return [...new Uint8Array(digest)].join();
  });

/** What is true of every building that was mended: valid, and nearer to its points. */
async function assertMended(page, actions) {
  const { before: was, now, valid, edits } = await head(page);
  assert.ok(actions <= 5, `${actions} actions`);
  assert.equal(valid, true);
  assert.deepEqual(
    edits.map(({ applied, note }) => [applied, note]),
    edits.map(() => [true, null]),
  );
  assert.ok(now.rmse < was.rmse, `RMSE ${was.rmse} → ${now.rmse}`);
  // What is told is what is so.
  const table = await tableOf(page);
  assert.deepEqual(
    table.rmse,
    [was.rmse, now.rmse].map((value) => String(Number(value.toFixed(3)))),
  );
  assert.match(table.lod[1], /LoD 2\.2/);
  assert.equal(await page.$eval('#figures [data-figure=rmse] td:nth-child(3)', ({ className }) => className), 'better');
}

test('a part that is missing is added by a plane through its points', async () => {
  const page = await openEditor(browser, server, { id: MISSING });
  await picture(page, 'missing');
  const first = await head(page);
  await page.keyboard.press('6');
  await settled(page);
  await page.keyboard.press('b');
  await draw(page, await onScreen(page, FRONT));
  assert.match(
    await text(page, '#options'),
    /^Brush\d+ points; a plane at [\d.]+° passes them with an rms of 0\.\d+ m\./,
  );
  await page.keyboard.press('h');
  assert.match(await text(page, '#options'), /a plane at 0° passes them with an rms of 0\.0\d+ m\./);
  await picture(page, 'brush');
  await page.keyboard.press('Enter');
  const { edits, now, state } = await solved(page, first);
  assert.deepEqual([edits.map(({ name }) => name), state], [['add-plane'], 'edited']);
  assert.ok(now.missing < first.now.missing, `missing ${first.now.missing} → ${now.missing} m²`);
  await assertMended(page, 5);
  await page.keyboard.press('f');
  await picture(page, 'added');
  assert.deepEqual(page.faults, []);
  await page.close();
});

test('a slope that ran on is cut by a mark; undo brings back what was, to the last bit', async () => {
  const page = await openEditor(browser, server, { id: RUNS_ON, scheme: 'dark' });
  const [first, untouched] = [await head(page), await drawnOf(page)];
  await page.keyboard.press('u');
  const [place] = await onScreen(page, [AIR]);
  await page.mouse.move(...place);
  await page.waitForFunction(() => !document.getElementById('tip').hidden);
  assert.equal(await text(page, '#tip'), 'click: outsidewhat lies behind this face');
  await picture(page, 'mark');
  await page.mouse.click(...place);
  const marked = await solved(page, first);
  assert.deepEqual(Object.keys(marked.edits[0].action), ['mark-place']);
  await assertMended(page, 2);
  await picture(page, 'cut');
  const cut = await drawnOf(page);
  assert.notEqual(cut, untouched);

  await press(page, 'Control', 'z');
  const undone = await solved(page, marked);
  assert.deepEqual([undone.edits.length, undone.undone, undone.state, undone.now], [0, 1, 'open', first.now]);
  assert.equal(await drawnOf(page), untouched);
  await press(page, 'Control', 'Shift', 'z');
  assert.deepEqual((await solved(page, undone)).now, marked.now);
  assert.equal(await drawnOf(page), cut);
  await page.keyboard.press('a');
  await page.waitForFunction(() => window.gable.state.building.head.state === 'accepted');
  assert.deepEqual(page.faults, []);
  await page.close();
});

test('a floor at a wrong height is set', async () => {
  const page = await openEditor(browser, server, { id: RAISED });
  const first = await head(page);
  assert.ok(Math.abs(first.floor - FLOOR - 3) < 0.02, `${first.floor}`);
  await picture(page, 'floor');
  await page.keyboard.press('z');
  // A drag for the eye, the number for the height.
  const [low, high] = await onScreen(
    page,
    [FLOOR, first.floor].map((z) => [...first.origin.slice(0, 2), z]),
  );
  await draw(page, [
    [700, 400],
    [700, 400 + low[1] - high[1]],
  ]);
  await page.waitForFunction(
    (floor) => Math.abs(Number(document.getElementById('floor-height').value) - floor) < 0.6,
    {},
    FLOOR,
  );
  await page.click('#floor-height', { count: 3 });
  await page.keyboard.type(String(FLOOR));
  await page.keyboard.press('Enter');
  const { edits, floor } = await solved(page, first);
  assert.deepEqual([edits[0].action, floor], [{ 'set-floor': { height: FLOOR } }, FLOOR]);
  await assertMended(page, 5);
  await picture(page, 'floor-set');
  await page.keyboard.press('a');
  await page.waitForFunction(() => window.gable.state.building.head.state === 'accepted');
  assert.deepEqual(page.faults, []);
  await page.close();
});

test('tools do what their keys say, and drop what was begun', async () => {
  const page = await openEditor(browser, server, { id: house('17304') });
  const first = await head(page);
  // Every tool has its key and its button, and Esc leaves it.
  const tools = await page.$$eval('#tools button', (all) =>
    all.map(({ dataset, title }) => [dataset.tool, title.match(/\(([^)]+)\)$/)[1]]),
  );
  assert.equal(tools.length, 16);
  const chosen = () => page.$eval('#tools [aria-checked=true]', ({ dataset }) => dataset.tool);
  for (const [name, key] of tools.filter(([name]) => !['select', 'move', 'parallel'].includes(name))) {
    await press(page, ...key.split('+').map((part) => (part.length === 1 ? `Key${part}` : part)));
    assert.equal(await chosen(), name);
    assert.match(await text(page, '#hint'), /·|Enter/);
    await page.keyboard.press('Escape');
    await page.keyboard.press('Escape');
    assert.equal(await chosen(), 'select');
  }
  await page.keyboard.press('?');
  const help = await text(page, '#keys');
  tools.forEach(([, key]) => assert.ok(help.includes(key.replace('Shift+', '⇧')), key));
  await page.keyboard.press('Escape');

  // A plane: chosen by a click, switched off, and on again.
  await press(page, 'Shift', 'KeyL');
  const corner = await page.evaluate(() => {
    const { planes, state } = window.gable;
    const canvas = document.getElementById('canvas').getBoundingClientRect();
    for (let x = canvas.left + 60; x < canvas.right - 60; x += 12) {
      for (let y = canvas.top + 80; y < canvas.bottom - 60; y += 12) {
        const hit = window.gable.places.itemAt(x, y, ['plane']);
        if (hit && state.building.planes[hit.item].by === 'scan') {
          return [x, y];
        }
      }
    }
    return planes;
  });
  await page.mouse.click(...corner);
  assert.match(await text(page, '#plane-title'), /^(roof|wall|underside) \d+$/);
  await page.keyboard.press('x');
  const off = await solved(page, first);
  assert.deepEqual([off.edits.length, off.edits[0].applied, off.planes.filter(({ on }) => !on).length], [1, true, 1]);
  assert.match(await text(page, '#plane-title'), /switched off$/);
  await page.keyboard.press('x');
  const on = await solved(page, off);
  assert.deepEqual([on.now, on.planes.every((plane) => plane.on)], [first.now, true]);
  // Moved by a number.
  await page.keyboard.press('g');
  await page.click('#move-by', { count: 3 });
  await page.keyboard.type('0.2');
  assert.match(await text(page, '#moved-told'), /rms of its points: 0\.\d+ m → 0\.2\d* m/);
  await page.keyboard.press('Enter');
  const moved = await solved(page, on);
  assert.deepEqual([moved.edits.at(-1).name, moved.edits.at(-1).applied], ['move-plane', true]);
  // All of it is taken back, and the section hides and shows.
  await press(page, 'Control', 'Shift', 'Backspace');
  const cleared = await solved(page, moved);
  assert.deepEqual([cleared.edits.length, cleared.undone, cleared.now], [0, 3, first.now]);
  await page.keyboard.press('c');
  assert.equal(await page.evaluate(() => window.gable.picture.cuts.length), 1);
  await page.keyboard.press('Delete');
  assert.equal(await page.evaluate(() => window.gable.picture.cuts.length), 0);
  assert.deepEqual(page.faults, []);
  await page.close();
});

test('the list finds, filters and goes on; what another page changed is shown', async () => {
  const page = await openEditor(browser, server);
  const shown = () => page.$$eval('#list [data-id]', (all) => all.map(({ dataset }) => dataset.id));
  const all = await shown();
  assert.equal(all.length, 71);
  assert.equal(await page.evaluate(() => window.gable.state.id), all[0], 'the first one is open');
  await page.keyboard.press('j');
  await page.waitForFunction((id) => window.gable.state.building.head.id === id, {}, all[1]);
  await page.keyboard.press('k');
  await page.waitForFunction((id) => window.gable.state.building.head.id === id, {}, all[0]);
  await page.keyboard.press('/');
  await page.keyboard.type('17310');
  assert.deepEqual(await shown(), [RUNS_ON]);
  await page.keyboard.press('Enter');
  await page.waitForFunction((id) => window.gable.state.building.head.id === id, {}, RUNS_ON);
  await page.keyboard.press('/');
  await page.keyboard.press('Escape');
  await page.click('#states [data-state=accepted]');
  assert.deepEqual((await shown()).sort(), [RAISED, RUNS_ON].sort());
  await page.click('#states [data-state=accepted]');
  await page.select('#reason', 'missing part');
  const missing = await page.$$eval('#list .what', (nodes) => nodes.map(({ textContent }) => textContent));
  assert.ok(missing.length > 2 && missing.every((what) => /missing part/.test(what)), missing.join());
  await page.select('#reason', '');
  await page.select('#order', 'id');
  assert.deepEqual(await shown(), [...all].sort());

  // Two pages, one building: the one that comes late is told, and shows what is.
  const other = await openEditor(browser, server, { id: RUNS_ON });
  const first = await head(other);
  await press(other, 'Control', 'z');
  const undone = await solved(other, first);
  assert.equal((await head(page)).revision, first.revision);
  // A page behind another one draws nothing.
  await page.bringToFront();
  await press(page, 'Control', 'z');
  await page.waitForFunction((revision) => window.gable.state.building.head.revision === revision, {}, undone.revision);
  assert.match(await text(page, '#told'), /changed elsewhere/);
  // The message stays until it is dismissed.
  assert.equal((await page.$$('#messages .message')).length, 1);
  await page.click('#messages .close');
  assert.equal((await page.$$('#messages .message')).length, 0);
  await other.bringToFront();
  await press(other, 'Control', 'Shift', 'z');
  await solved(other, undone);
  await other.keyboard.press('a');
  await other.waitForFunction(() => window.gable.state.building.head.state === 'accepted');
  assert.deepEqual(other.faults, []);
  assert.equal(page.faults.filter((fault) => !/409/.test(fault)).length, 0, page.faults.join());
  // Nothing was asked but of this server.
  const { origin } = new URL(server.address);
  assert.deepEqual(
    page.asked.filter((url) => !url.startsWith(origin) && !/^(data|blob):/.test(url)),
    [],
  );
  await other.close();
  await page.close();
});

test('on a phone one can look: everything is large enough for fingers', async () => {
  const page = await openEditor(browser, server, { id: RAISED, size: PHONE });
  const small = () =>
    page.evaluate(() => {
      const found = [];
      for (const node of document.querySelectorAll('button, input, select, summary')) {
        const { width, height } = (node.closest('label') ?? node).getBoundingClientRect();
        if (width > 0 && height > 0 && height < 43.5) {
          found.push(`${node.id || node.className || node.textContent}: ${width} by ${height}`);
        }
      }
      return found;
    });
  for (const [tab, panel] of [
    [1, '#side'],
    [2, '#work'],
  ]) {
    await page.click(`#tabs button:nth-child(${tab})`);
    assert.deepEqual(await small(), [], panel);
    const [side, main] = [await boxOf(page, panel), await boxOf(page, 'main')];
    assert.ok(side.top >= main.bottom - 1 && side.width === PHONE.width, JSON.stringify([side, main]));
  }
  // A finger turns the building and edits nothing.
  const first = await head(page);
  await page.click('#tools [data-tool=outside]');
  await page.touchscreen.tap(195, 200);
  assert.deepEqual((await head(page)).edits.length, first.edits.length);
  assert.deepEqual(page.faults, []);
  await page.close();
});

test('a restart goes on from there; export and replay give the same bytes', async () => {
  const states = (page) =>
    page.evaluate(() => window.gable.state.rows.map(({ id, state, edits }) => `${id} ${state} ${edits}`));
  let page = await openEditor(browser, server, { id: RUNS_ON });
  const [told, drawn, { now }] = [await states(page), await drawnOf(page), await head(page)];
  assert.equal(told.filter((row) => row.endsWith(' accepted 1')).length, 2);
  assert.equal(told.filter((row) => row.endsWith(' edited 1')).length, 1);
  const { edits_file: file } = await page.evaluate(() => window.gable.model);
  await page.close();
  await server.stop();
  server = await serve(model);
  page = await openEditor(browser, server, { id: RUNS_ON });
  assert.deepEqual((await states(page)).sort(), told.sort());
  assert.equal(await drawnOf(page), drawn);
  assert.deepEqual((await head(page)).now, now);

  // By the page, by the command, and by a run with the same edits.
  await press(page, 'Control', 's');
  await page.waitForFunction(() => /made anew/.test(document.getElementById('told').textContent), { timeout: 60_000 });
  await page.close();
  const edits = path.resolve(folder, file);
  const [exported, replayed] = ['exported.city.json', 'replayed.city.json'].map((name) => path.join(folder, name));
  tool.gable('edit', model, '--export', exported, '--quiet');
  const footprints = path.join(folder, 'footprints.geojson');
  tool.gable(
    'reconstruct',
    TILE,
    '-f',
    footprints,
    '--ground-attribute',
    'floor',
    '--edits',
    edits,
    '-o',
    replayed,
    '--quiet',
  );
  const bytes = [path.join(folder, 'delft.edited.city.json'), exported, replayed].map((name) =>
    fs.readFileSync(name, 'utf8'),
  );
  assert.equal(bytes[0] === bytes[1] && bytes[1] === bytes[2], true);
  const objects = JSON.parse(bytes[0]).CityObjects;
  assert.equal(objects[RUNS_ON].attributes.gable_edits, 1);
  assert.equal(objects[MISSING].attributes.gable_edits, undefined, 'it was not accepted');
  assert.equal(objects[RUNS_ON].attributes.gable_rmse_lod22, Number(now.rmse.toFixed(3)));
});
