// Runs the gable that scripts/test-platforms.sh has built.
'use strict';

const fs = require('node:fs');
const os = require('node:os');
const path = require('node:path');
const { execFileSync } = require('node:child_process');

const DATA = path.resolve(__dirname, '../../examples/data');

/** What the command prints; throws with its complaints where it fails. */
function gable(...args) {
  return execFileSync(process.env.GABLE, args, { encoding: 'utf8', stdio: ['ignore', 'pipe', 'pipe'] });
}

/** A folder for the files of a test. */
function folder() {
  return fs.mkdtempSync(path.join(os.tmpdir(), 'gable-platforms-'));
}

/** The city model of the bundled corner of Delft, 71 buildings, as a file of this name in the folder. */
function delft(folder, name, ...options) {
  const output = path.join(folder, name);
  const [tile, footprints] = ['delft_ahn3.laz', 'footprints.geojson'].map((file) => path.join(DATA, file));
  gable('reconstruct', tile, '-f', footprints, '-o', output, '--quiet', ...options);
  return output;
}

module.exports = { delft, folder, gable };
