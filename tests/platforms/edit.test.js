// The page of `gable edit`: wrong buildings of the quick start are mended as a person would, by mouse and keys alone. With
// $EDIT_PICTURES the pictures of docs/howto/edit-walkthrough.md are made on the way, into that folder.
'use strict';

const assert = require('node:assert/strict');
const fs = require('node:fs');
const path = require('node:path');
const { after, before, test } = require('node:test');
const { launch } = require('./browser.js');
const editing = require('./editing.js');
const tool = require('./gable.js');
const { text } = require('./page.js');
const { indexed } = require('./png.js');

const { RAISED, draw, head, house, modelIn, onScreen, openEditor, press, serve, settled, solved, tableOf } = editing;

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

let browser;
let folder;
let model;
let made;
let server;

before(async () => {
  folder = tool.folder();
  ({ model, made } = modelIn(folder));
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
  const page = await openEditor(browser, server, { id: RAISED.id });
  const first = await head(page);
  assert.ok(Math.abs(first.floor - RAISED.floor - 3) < 0.02, `${first.floor}`);
  await picture(page, 'floor');
  await page.keyboard.press('z');
  // A drag for the eye, the number for the height.
  const [low, high] = await onScreen(
    page,
    [RAISED.floor, first.floor].map((z) => [...first.origin.slice(0, 2), z]),
  );
  await draw(page, [
    [700, 400],
    [700, 400 + low[1] - high[1]],
  ]);
  await page.waitForFunction(
    (floor) => Math.abs(Number(document.getElementById('floor-height').value) - floor) < 0.6,
    {},
    RAISED.floor,
  );
  await page.click('#floor-height', { count: 3 });
  await page.keyboard.type(String(RAISED.floor));
  await page.keyboard.press('Enter');
  const { edits, floor } = await solved(page, first);
  assert.deepEqual([edits[0].action, floor], [{ 'set-floor': { height: RAISED.floor } }, RAISED.floor]);
  await assertMended(page, 5);
  await picture(page, 'floor-set');
  await page.keyboard.press('a');
  await page.waitForFunction(() => window.gable.state.building.head.state === 'accepted');
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
  tool.gable('reconstruct', ...made, '--edits', edits, '-o', replayed, '--quiet');
  const bytes = [path.join(folder, 'delft.edited.city.json'), exported, replayed].map((name) =>
    fs.readFileSync(name, 'utf8'),
  );
  assert.equal(bytes[0] === bytes[1] && bytes[1] === bytes[2], true);
  const objects = JSON.parse(bytes[0]).CityObjects;
  assert.equal(objects[RUNS_ON].attributes.gable_edits, 1);
  assert.equal(objects[MISSING].attributes.gable_edits, undefined, 'it was not accepted');
  assert.equal(objects[RUNS_ON].attributes.gable_rmse_lod22, Number(now.rmse.toFixed(3)));
});
