// The page of `gable edit`: every tool, the list, and the hands of a person on it.
'use strict';

const assert = require('node:assert/strict');
const fs = require('node:fs');
const { after, before, test } = require('node:test');
const { launch } = require('./browser.js');
const editing = require('./editing.js');
const tool = require('./gable.js');
const { PHONE, boxOf, text } = require('./page.js');

const { RAISED, draw, head, house, modelIn, onScreen, openEditor, press, serve, solved } = editing;

const HOUSE = house('17310');

let browser;
let folder;
let server;

before(async () => {
  folder = tool.folder();
  server = await serve(modelIn(folder).model);
  browser = await launch();
});

after(async () => {
  await browser?.close();
  await server?.stop();
  fs.rmSync(folder, { recursive: true, force: true });
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

test('points are left out, the footprint is mended, parts are split and merged', async () => {
  // A shed under a tree.
  const page = await openEditor(browser, server, { id: house('18599') });
  const first = await head(page);
  let last = first;
  const done = async (name) => {
    const now = await solved(page, last);
    assert.equal(now.revision, last.revision + 1);
    const { name: found, applied, note } = now.edits.at(-1);
    assert.deepEqual([found, applied, note], [name, true, null]);
    last = now;
    return now;
  };
  const ring = () => last.footprint[0][0].slice(0, -1).map((place) => [...place, last.floor]);
  const between = (a, b, share = 0.5) => a.map((value, axis) => value + share * (b[axis] - value));
  const longest = () => {
    const corners = ring();
    const edges = corners.map((a, i) => [a, corners[(i + 1) % corners.length]]);
    return edges.reduce((best, own) => (length(own) > length(best) ? own : best));
  };
  const length = ([a, b]) => Math.hypot(a[0] - b[0], a[1] - b[1]);

  // The tree, from the south: all that is higher than the roof.
  await page.keyboard.press('9');
  await page.keyboard.press('l');
  const [west, east] = [0, 1].map((end) => [...ring()].sort((a, b) => a[0] - b[0]).at(-end));
  const around = [2.7, 4.2].flatMap((z, i) => (i === 0 ? [west, east] : [east, west]).map(([x, y]) => [x, y, z]));
  const sides = await onScreen(page, around);
  const aside = sides.map(([x, y], i) => [x + ([0, 3].includes(i) ? -15 : 15), y]);
  await draw(page, [...aside, aside[0]]);
  assert.match(await text(page, '#options'), /^Lasso\d+ points; a plane at/);
  await page.keyboard.press('Delete');
  const { now } = await done('exclude-points');
  assert.ok(now.rmse < 0.6 * first.now.rmse, `RMSE ${first.now.rmse} → ${now.rmse}`);

  await page.keyboard.press('6');
  await page.keyboard.press('e');
  const middle = between(...longest());
  const [from, centre] = await onScreen(page, [middle, between(ring()[0], ring()[2])]);
  await draw(page, [from, between(from, centre, -0.2)]);
  assert.ok((await page.$eval('#edge-by', ({ valueAsNumber }) => valueAsNumber)) > 0.1, 'outwards');
  await page.keyboard.press('Enter');
  assert.ok((await done('offset-edge')).now.volume > now.volume);

  await page.keyboard.press('6');
  await press(page, 'Shift', 'KeyE');
  const [corner, opposite] = await onScreen(page, [ring()[0], ring()[2]]);
  await draw(page, [corner, between(corner, opposite, 0.1)]);
  await page.keyboard.press('Enter');
  const redrawn = await done('redraw-footprint');
  assert.equal(redrawn.footprint[0][0].length, first.footprint[0][0].length);

  await page.keyboard.press('6');
  await press(page, 'Shift', 'KeyS');
  const [a, b] = longest();
  const side = between(ring()[0], ring()[2]);
  const cross = between(a, b);
  for (const place of await onScreen(page, [between(side, cross, 1.3), between(side, cross, -1.3)])) {
    await page.mouse.click(...place);
  }
  await page.keyboard.press('Enter');
  assert.equal((await done('split-parts')).now.solids, 2);

  // Two parts of a footprint that is one cannot be merged: that is said, and taken back.
  await press(page, 'Shift', 'KeyM');
  await page.keyboard.press('Enter');
  const merged = await solved(page, last);
  assert.deepEqual([merged.edits.at(-1).name, merged.edits.at(-1).applied], ['merge-parts', false]);
  assert.match(await text(page, '#edits li:last-child'), /does not apply: the footprint has one part/);
  await press(page, 'Control', 'z');
  last = await solved(page, merged);

  await press(page, 'Shift', 'KeyW');
  await page.focus('#feature');
  await page.keyboard.press('ArrowRight');
  assert.deepEqual((await done('set-parameters')).edits.at(-1).action, {
    'set-parameters': { 'minimum-feature': last.minimum_feature },
  });
  await press(page, 'Control', 'Shift', 'Backspace');
  assert.deepEqual((await solved(page, last)).now, first.now);
  assert.deepEqual(page.faults, []);
  await page.close();
});

test('the list finds, filters and goes on; what another page changed is shown', async () => {
  // Two are accepted, one of them with an edit.
  for (const id of [HOUSE, RAISED.id]) {
    const first = await openEditor(browser, server, { id });
    if (id === HOUSE) {
      const untouched = await head(first);
      await first.keyboard.press('z');
      await first.click('#floor-height', { count: 3 });
      await first.keyboard.type('0.1');
      await first.keyboard.press('Enter');
      await solved(first, untouched);
    }
    await first.keyboard.press('a');
    await first.waitForFunction(() => window.gable.state.building.head.state === 'accepted');
    await first.close();
  }
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
  assert.deepEqual(await shown(), [HOUSE]);
  await page.keyboard.press('Enter');
  await page.waitForFunction((id) => window.gable.state.building.head.id === id, {}, HOUSE);
  await page.keyboard.press('/');
  await page.keyboard.press('Escape');
  await page.click('#states [data-state=accepted]');
  assert.deepEqual((await shown()).sort(), [RAISED.id, HOUSE].sort());
  await page.click('#states [data-state=accepted]');
  await page.select('#reason', 'missing part');
  const missing = await page.$$eval('#list .what', (nodes) => nodes.map(({ textContent }) => textContent));
  assert.ok(missing.length > 2 && missing.every((what) => /missing part/.test(what)), missing.join());
  await page.select('#reason', '');
  await page.select('#order', 'id');
  assert.deepEqual(await shown(), [...all].sort());

  // Two pages, one building: the one that comes late is told, and shows what is.
  const other = await openEditor(browser, server, { id: HOUSE });
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
  const page = await openEditor(browser, server, { id: RAISED.id, size: PHONE });
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
