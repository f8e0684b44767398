// Pages that gable writes, opened from the file system as a user would: `gable view`, `gable explain`.
'use strict';

const { pathToFileURL } = require('node:url');

const SIZE = { width: 1200, height: 800 };

/** A phone: 390 by 844, for fingers. */
const PHONE = { width: 390, height: 844, isMobile: true, hasTouch: true };

/**
 * A page opened from its file, ready, without flights; what goes wrong and what is asked for are kept. `hash` is what stands
 * behind the # of its address.
 */
async function openPage(browser, file, { scheme = 'light', size = SIZE, hash = '' } = {}) {
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
  page.on('dialog', (dialog) => (page.faults.push(`a dialog: ${dialog.message()}`), dialog.dismiss()));
  page.on('request', (request) => page.asked.push(request.url()));
  await page.goto(`${pathToFileURL(file).href}${hash ? `#${hash}` : ''}`, { waitUntil: 'load' });
  await page.waitForSelector('html[data-ready]', { timeout: 120_000 });
  return page;
}

/** Where a place in CRS coordinates is on the screen. */
const project = (page, place) =>
  page.evaluate((place) => {
    const { model, view } = window.gable;
    const { origin, metres_per_unit: unit, steps_per_metre: steps } = model.head;
    const local = place.map((value, axis) => (value - origin[axis]) * unit[axis] - model.centre[axis] / steps);
    const canvas = document.getElementById('canvas').getBoundingClientRect();
    view.camera.updateMatrixWorld();
    const { x, y } = view.camera.position.clone().fromArray(local).project(view.camera);
    return [canvas.left + ((x + 1) / 2) * canvas.width, canvas.top + ((1 - y) / 2) * canvas.height];
  }, place);

/** Two frames later everything is drawn. */
const drawn = (page) =>
  page.evaluate(() => new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve))));

/** The colours of a screenshot at some pixels. */
async function colours(page, places) {
  const png = await page.screenshot({ encoding: 'base64' });
  const blank = await page.browser().newPage();
  const found = await blank.evaluate(
    async (png, places) => {
      const image = new Image();
      image.src = `data:image/png;base64,${png}`;
      await image.decode();
      const canvas = new OffscreenCanvas(image.width, image.height);
      const context = canvas.getContext('2d');
      context.drawImage(image, 0, 0);
      // The median of 5 by 5 pixels: an edge may run through the very place.
      const middle = (values) => values.sort((a, b) => a - b)[values.length >> 1];
      return places.map(([x, y]) => {
        const { data } = context.getImageData(Math.round(x) - 2, Math.round(y) - 2, 5, 5);
        return [0, 1, 2].map((channel) => middle([...data].filter((_, i) => i % 4 === channel)));
      });
    },
    png,
    places,
  );
  await blank.close();
  return found;
}

/** The text of an element. */
const text = (page, selector) => page.$eval(selector, (node) => node.textContent);

/** Where an element is in the window. */
const boxOf = (page, selector) =>
  page.$eval(selector, (node) => {
    const { left, top, right, bottom, width, height } = node.getBoundingClientRect();
    return { left, top, right, bottom, width, height };
  });

module.exports = { PHONE, boxOf, colours, drawn, openPage, project, text };
