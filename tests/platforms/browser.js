// A headless Chromium of the system, and a web server on this machine that it may read from: shared by the tests here.
'use strict';

const fs = require('node:fs');
const http = require('node:http');
const path = require('node:path');
const { execFileSync } = require('node:child_process');
const puppeteer = require('puppeteer-core');

const TYPES = {
  '.css': 'text/css',
  '.glb': 'model/gltf-binary',
  '.html': 'text/html; charset=utf-8',
  '.js': 'text/javascript',
  '.json': 'application/json',
  '.wasm': 'application/wasm',
};

/** The Chromium of the system: `$CHROMIUM`, or the first on the path that has one of its names. */
function chromium() {
  const names = [process.env.CHROMIUM, 'chromium', 'chromium-browser', 'google-chrome'].filter(Boolean);
  for (const name of names) {
    try {
      return execFileSync('sh', ['-c', 'command -v -- "$1"', 'sh', name], { encoding: 'utf8' }).trim();
    } catch {
      // The next name.
    }
  }
  throw new Error('no Chromium on the path; scripts/test-platforms.sh installs one');
}

/** A browser that draws WebGL in software, so that it needs neither a screen nor a graphics card. */
async function launch() {
  return puppeteer.launch({
    executablePath: chromium(),
    headless: true,
    protocolTimeout: 240_000,
    args: [
      '--no-sandbox',
      '--disable-dev-shm-usage',
      '--use-gl=angle',
      '--use-angle=swiftshader',
      '--enable-unsafe-swiftshader',
      '--ignore-gpu-blocklist',
    ],
  });
}

/** A page that keeps what goes wrong on it in `page.faults`: errors of the console, exceptions, answers that are missing. */
async function open(browser, url) {
  const page = await browser.newPage();
  page.faults = [];
  page.on('console', (message) => message.type() === 'error' && page.faults.push(message.text()));
  page.on('pageerror', (error) => page.faults.push(String(error)));
  page.on('requestfailed', (request) => page.faults.push(`${request.url()}: ${request.failure()?.errorText}`));
  await page.goto(url, { waitUntil: 'load' });
  return page;
}

/** Serves folders, `{ '/prefix/': folder }`, and pages, `{ '/name.html': text }`, on a free port of 127.0.0.1. */
async function serve(mounts) {
  const prefixes = Object.keys(mounts).sort((a, b) => b.length - a.length);
  const server = http.createServer((request, response) => {
    const name = decodeURIComponent(new URL(request.url, 'http://localhost').pathname);
    const prefix = prefixes.find((prefix) => (prefix.endsWith('/') ? name.startsWith(prefix) : name === prefix));
    const refuse = () => response.writeHead(404).end(`no ${name}`);
    if (prefix === undefined) {
      return refuse();
    }
    const type = TYPES[path.extname(name)] ?? 'application/octet-stream';
    if (!prefix.endsWith('/')) {
      return response.writeHead(200, { 'content-type': type }).end(mounts[prefix]);
    }
    const root = path.resolve(mounts[prefix]);
    const file = path.resolve(root, `.${path.sep}${name.slice(prefix.length)}`);
    if (!file.startsWith(root + path.sep) || !fs.statSync(file, { throwIfNoEntry: false })?.isFile()) {
      return refuse();
    }
    response.writeHead(200, { 'content-type': type });
    return fs.createReadStream(file).pipe(response);
  });
  await new Promise((resolve) => server.listen(0, '127.0.0.1', resolve));
  return { origin: `http://127.0.0.1:${server.address().port}`, close: () => server.close() };
}

module.exports = { launch, open, serve };
