'use strict';

const assert = require('node:assert/strict');
const { test } = require('node:test');
const { launch, open, serve } = require('./browser.js');

test('the browser draws WebGL and tells what goes wrong', async () => {
  const page = '<canvas id="c"></canvas><script>fetch("missing.json"); console.error("told")</script>';
  const server = await serve({ '/page.html': `<!doctype html><link rel="icon" href="data:,">${page}` });
  const browser = await launch();
  try {
    const tab = await open(browser, `${server.origin}/page.html`);
    assert.ok(await tab.evaluate(() => document.getElementById('c').getContext('webgl2') !== null));
    await tab.waitForNetworkIdle();
    assert.ok(tab.faults.some((fault) => fault === 'told') && tab.faults.some((fault) => fault.includes('404')), tab.faults);
  } finally {
    await browser.close();
    server.close();
  }
});
