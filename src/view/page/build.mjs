// Makes dist/page.html, the page without a model, from the sources beside this file. `--check` only says whether it is stale.
// Run by scripts/page.sh, which brings three.js and esbuild along.

import { createHash } from 'node:crypto';
import { readFileSync, readdirSync, mkdirSync, writeFileSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { createRequire } from 'node:module';

const here = dirname(fileURLToPath(import.meta.url));
const packages = process.env.PAGE_PACKAGES;
const require = createRequire(join(packages, 'package.json'));
const { build, transform } = require('esbuild');
const read = (name) => readFileSync(join(here, name), 'utf8');

const bundle = await build({
  absWorkingDir: here,
  entryPoints: ['src/main.js'],
  nodePaths: [join(packages, 'node_modules')],
  bundle: true,
  minify: true,
  format: 'iife',
  target: ['chrome109', 'firefox115', 'safari16.4'],
  charset: 'ascii',
  legalComments: 'none',
  write: false,
  metafile: true,
});
// What stands in a script must not end it.
const script = bundle.outputFiles[0].text
  .trim()
  .replace(/<\/(script)/gi, '<\\/$1')
  .replace(/<!--/g, '<\\!--');
const style = (await transform(read('style.css'), { loader: 'css', minify: true })).code.trim();

// The browser runs this script and no other, and asks nothing of any network.
const digest = (text) => `'sha256-${createHash('sha256').update(text).digest('base64')}'`;
const policy = `default-src 'none'; script-src ${digest(script)}; style-src ${digest(style)}; img-src data: blob:; base-uri 'none'; form-action 'none'`;

// FNV-1a over the sources: a test of gable finds a stale page without node (src/view/tests.rs).
const sources = [
  'build.mjs',
  'index.html',
  'package-lock.json',
  'package.json',
  ...readdirSync(join(here, 'src'))
    .sort()
    .map((name) => `src/${name}`),
  'style.css',
];
const hash = sources.reduce(
  (sum, name) =>
    [...readFileSync(join(here, name))].reduce(
      (value, byte) => BigInt.asUintN(64, (value ^ BigInt(byte)) * 0x100000001b3n),
      sum,
    ),
  0xcbf29ce484222325n,
);

const three = readFileSync(join(packages, 'node_modules/three/LICENSE'), 'utf8')
  .trim()
  .split('\n')
  .map((line) => line.trim())
  .filter(Boolean);
const licences = `<!--\nMade by gable, MIT or Apache-2.0. With three.js:\n${three.join('\n')}\nsources ${hash.toString(16).padStart(16, '0')}\n-->`;

const page = `${read('index.html')
  .replace('<html', () => `${licences}\n<html`)
  .replace('@policy@', () => policy)
  .replace('@style@', () => style)
  .replace('@script@', () => script)
  .trim()}\n`;
for (const place of ['<!--gable:name-->', '<!--gable:payload-->']) {
  if (page.split(place).length !== 2) {
    throw new Error(`${place} must stand in the page once`);
  }
}

const target = join(here, 'dist/page.html');
if (process.argv.includes('--check')) {
  if (readFileSync(target, 'utf8') !== page) {
    console.error('src/view/page/dist/page.html is stale: run `make page`');
    process.exit(1);
  }
  console.log('src/view/page/dist/page.html is what its sources make');
} else {
  mkdirSync(dirname(target), { recursive: true });
  writeFileSync(target, page);
  console.log(`src/view/page/dist/page.html: ${Math.round(page.length / 1000)} kB`);
}
