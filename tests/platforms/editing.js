// `gable edit` as a person has it before them: a server of its own, its page in the browser, and places of the model as places of
// the window.
'use strict';

const { spawn } = require('node:child_process');
const fs = require('node:fs');
const path = require('node:path');
const tool = require('./gable.js');

const DATA = path.resolve(__dirname, '../../examples/data');

/** A house of the quick start by the end of its id. */
const house = (end) => `NL.IMBAG.Pand.05031000000${end}`;

/** Of this house the attribute of the footprints with the floors is 3 m wrong; that is its floor. */
const RAISED = { id: house('17303'), floor: -0.01 };

/** How long a building may take to be solved here, which is no promise: that is measured elsewhere. */
const PATIENCE = 60_000;

/** The city model of the bundled corner of Delft in a folder, and what it was made from, as options. */
function modelIn(folder) {
  const footprints = JSON.parse(fs.readFileSync(path.join(DATA, 'footprints.geojson'), 'utf8'));
  footprints.features.forEach(({ properties }) => {
    properties.floor = properties.id === RAISED.id ? RAISED.floor + 3 : null;
  });
  const layer = path.join(folder, 'footprints.geojson');
  fs.writeFileSync(layer, JSON.stringify(footprints));
  const made = [path.join(DATA, 'delft_ahn3.laz'), '-f', layer, '--ground-attribute', 'floor'];
  const model = path.join(folder, 'delft.city.json');
  tool.gable('reconstruct', ...made, '-o', model, '--quiet');
  return { model, made };
}

/** Starts `gable edit` with these arguments; gives its address, and how to end it. */
async function serve(...args) {
  const child = spawn(process.env.GABLE, ['edit', ...args, '--no-browser', '--quiet'], {
    stdio: ['ignore', 'pipe', 'pipe'],
  });
  let said = '';
  const address = await new Promise((resolve, reject) => {
    const look = (data) => {
      said += data;
      const found = said.match(/http:\/\/127\.0\.0\.1:\d+\/\S+/);
      if (found) {
        resolve(found[0]);
      }
    };
    child.stdout.on('data', look);
    child.stderr.on('data', look);
    child.on('exit', (code) => reject(new Error(`gable edit ended with ${code}: ${said}`)));
    setTimeout(() => reject(new Error(`gable edit told no address: ${said}`)), PATIENCE);
  });
  const ended = new Promise((resolve) => child.on('exit', resolve));
  const stop = async () => {
    child.kill('SIGINT');
    const late = setTimeout(() => child.kill('SIGKILL'), 10_000);
    await ended;
    clearTimeout(late);
  };
  return { address, stop, said: () => said };
}

/** The page, ready, of a server; `id` is the building that is opened. */
async function openEditor(browser, { address }, { id, scheme = 'light', size = { width: 1400, height: 900 } } = {}) {
  const page = await browser.newPage();
  await page.setViewport(size);
  await page.emulateMediaFeatures([
    { name: 'prefers-color-scheme', value: scheme },
    { name: 'prefers-reduced-motion', value: 'reduce' },
  ]);
  page.faults = [];
  page.asked = [];
  page.on('console', (message) => ['error', 'warn'].includes(message.type()) && page.faults.push(message.text()));
  page.on('pageerror', (error) => page.faults.push(String(error)));
  page.on('request', (request) => page.asked.push(request.url()));
  await page.goto(id ? `${address}#id=${encodeURIComponent(id)}` : address, { waitUntil: 'load' });
  await page.waitForSelector('html[data-ready]', { timeout: PATIENCE });
  await page.evaluate(() => document.getElementById('intro-close')?.click());
  return page;
}

/** What the page knows of the building that is open. */
const head = (page) => page.evaluate(() => window.gable.state.building.head);

/** Waits until the building has a later revision than `last`, which is no longer busy; gives its head. */
async function solved(page, last) {
  await page.waitForFunction(
    (id, revision) => {
      const { session, state } = window.gable;
      return !session.isBusy && (state.building.head.id !== id || state.building.head.revision > revision);
    },
    { timeout: PATIENCE, polling: 50 },
    last.id,
    last.revision,
  );
  return head(page);
}

/** Waits until the view rests and is drawn with all its pixels. */
async function settled(page) {
  await page.waitForFunction(
    () => {
      const { picture } = window.gable;
      const rests = performance.now() - (picture.movedAt ?? 0) > 800;
      return rests && !picture.isCoarse && !picture.asked;
    },
    { timeout: PATIENCE, polling: 100 },
  );
}

/** The table of figures, by their names: what was and what is. */
const tableOf = (page) =>
  page.$$eval('#figures [data-figure]', (rows) =>
    Object.fromEntries(
      rows.map((row) => [
        row.dataset.figure,
        [...row.querySelectorAll('td')].slice(0, 2).map((cell) => cell.textContent),
      ]),
    ),
  );

/** Where places of the CRS are in the window. */
const onScreen = (page, places) =>
  page.evaluate((places) => {
    const { places: under, state } = window.gable;
    const box = document.getElementById('canvas').getBoundingClientRect();
    return places.map((place) => {
      const [x, y] = under.onScreen(state.building.frame.toScene(place));
      return [x + box.left, y + box.top];
    });
  }, places);

/** Presses a key with others: `press(page, 'Control', 'Shift', 'z')`. */
async function press(page, ...keys) {
  for (const key of keys.slice(0, -1)) {
    await page.keyboard.down(key);
  }
  await page.keyboard.press(keys.at(-1));
  for (const key of keys.slice(0, -1).reverse()) {
    await page.keyboard.up(key);
  }
}

/** Draws with the left button through places of the window. */
async function draw(page, places) {
  await page.mouse.move(...places[0]);
  await page.mouse.down();
  for (const place of places.slice(1)) {
    await page.mouse.move(...place, { steps: 4 });
  }
  await page.mouse.up();
}

module.exports = {
  PATIENCE,
  RAISED,
  draw,
  head,
  house,
  modelIn,
  onScreen,
  openEditor,
  press,
  serve,
  settled,
  solved,
  tableOf,
};
