// Makes the pages without a model, dist/page.html of `gable view`, `gable explain` and `gable edit`, from their sources.
// `--check` only says whether they are stale. Run by scripts/page.sh, which brings three.js and esbuild along.

import { createHash } from 'node:crypto';
import { readFileSync, readdirSync, mkdirSync, writeFileSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { createRequire } from 'node:module';

const here = dirname(fileURLToPath(import.meta.url));
const root = join(here, '../../..');
const packages = process.env.PAGE_PACKAGES;
const require = createRequire(join(packages, 'package.json'));
const { build, transform } = require('esbuild');
const read = (name) => readFileSync(join(root, name), 'utf8');

/**
 * The pages: the folder of each, the folders of others whose modules and style it shares, and whether it asks the server that it
 * comes from.
 */
const PAGES = [
  { folder: 'src/view/page', shares: [] },
  { folder: 'src/explain/page', shares: ['src/view/page'] },
  { folder: 'src/edit/page', shares: ['src/view/page', 'src/explain/page'], asks: true },
];

const three = readFileSync(join(packages, 'node_modules/three/LICENSE'), 'utf8')
  .trim()
  .split('\n')
  .map((line) => line.trim())
  .filter(Boolean);

/** The sources of a page, in the order in which they are hashed. */
function sourcesOf({ folder, shares }) {
  const scripts = (place) =>
    readdirSync(join(root, place, 'src'))
      .sort()
      .map((name) => `${place}/src/${name}`);
  const common = ['build.mjs', 'package-lock.json', 'package.json'].map((name) => `src/view/page/${name}`);
  const of = (place) => [...scripts(place), `${place}/style.css`];
  return [...common, ...shares.flatMap(of), `${folder}/index.html`, ...of(folder)];
}

/** FNV-1a over the sources: tests of gable find a stale page without node (tests::named in src/view/page.rs). */
const hashOf = (sources) =>
  sources.reduce(
    (sum, name) =>
      [...readFileSync(join(root, name))].reduce(
        (value, byte) => BigInt.asUintN(64, (value ^ BigInt(byte)) * 0x100000001b3n),
        sum,
      ),
    0xcbf29ce484222325n,
  );

async function make(page) {
  const { folder, shares, asks } = page;
  const bundle = await build({
    absWorkingDir: join(root, folder),
    entryPoints: ['src/main.js'],
    nodePaths: [join(packages, 'node_modules')],
    bundle: true,
    minify: true,
    format: 'iife',
    target: ['chrome109', 'firefox115', 'safari16.4'],
    charset: 'ascii',
    legalComments: 'none',
    write: false,
  });
  // What stands in a script must not end it.
  const script = bundle.outputFiles[0].text
    .trim()
    .replace(/<\/(script)/gi, '<\\/$1')
    .replace(/<!--/g, '<\\!--');
  const styles = [...shares, folder].map((place) => read(`${place}/style.css`)).join('\n');
  const style = (await transform(styles, { loader: 'css', minify: true })).code.trim();

  // The browser runs this script and no other, and asks nothing of any network: at most of the server of the page.
  const digest = (text) => `'sha256-${createHash('sha256').update(text).digest('base64')}'`;
  const policy = `default-src 'none'; script-src ${digest(script)}; style-src ${digest(style)}; img-src data: blob:;${asks ? " connect-src 'self';" : ''} base-uri 'none'; form-action 'none'`;
  const hash = hashOf(sourcesOf(page)).toString(16).padStart(16, '0');
  const licences = `<!--\nMade by gable, MIT or Apache-2.0. With three.js:\n${three.join('\n')}\nsources ${hash}\n-->`;
  const html = `${read(`${folder}/index.html`)
    .replace('<html', () => `${licences}\n<html`)
    .replace('@policy@', () => policy)
    .replace('@style@', () => style)
    .replace('@script@', () => script)
    .trim()}\n`;
  for (const place of ['<!--gable:name-->', '<!--gable:payload-->']) {
    if (html.split(place).length !== 2) {
      throw new Error(`${place} must stand in the page of ${folder} once`);
    }
  }
  return html;
}

for (const page of PAGES) {
  const html = await make(page);
  const name = `${page.folder}/dist/page.html`;
  if (!process.argv.includes('--check')) {
    mkdirSync(join(root, page.folder, 'dist'), { recursive: true });
    writeFileSync(join(root, name), html);
    console.log(`${name}: ${Math.round(html.length / 1000)} kB`);
  } else if (read(name) === html) {
    console.log(`${name} is what its sources make`);
  } else {
    console.error(`${name} is stale: run \`make page\``);
    process.exitCode = 1;
  }
}
