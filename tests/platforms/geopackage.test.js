// The GeoPackage of one run over the bundled data, opened by GDAL.
'use strict';

const assert = require('node:assert/strict');
const { execFileSync, spawnSync } = require('node:child_process');
const fs = require('node:fs');
const path = require('node:path');
const { after, before, test } = require('node:test');
const { delft, folder } = require('./gable.js');

let place, file;

before(() => {
  place = folder();
  file = delft(place, 'delft.gpkg');
});

after(() => fs.rmSync(place, { recursive: true, force: true }));

const ogrinfo = (...args) => execFileSync('ogrinfo', ['-ro', ...args], { encoding: 'utf8', stdio: ['ignore', 'pipe', 'pipe'] });

test('GDAL finds both tables with their types, their CRS and their extent', () => {
  const footprints = ogrinfo('-so', file, 'footprints');
  assert.match(footprints, /Geometry: Multi Polygon/);
  assert.match(footprints, /Feature Count: 71/);
  assert.match(footprints, /Amersfoort \/ RD New/);
  assert.match(footprints, /gable_rmse_lod22: Real/);
  assert.match(footprints, /gable_points: Integer64/);
  assert.match(footprints, /gable_success: Integer\(Boolean\)/);
  const faces = ogrinfo('-so', file, 'faces');
  assert.match(faces, /Geometry: 3D Multi Polygon/);
  assert.match(faces, /slope: Real/);
  assert.match(faces, /on_footprint_edge: Integer\(Boolean\)/);
  const [x0, y0, x1, y1] = footprints.match(/Extent: \(([\d.]+), ([\d.]+)\) - \(([\d.]+), ([\d.]+)\)/).slice(1).map(Number);
  assert.ok(x0 > 84_000 && x1 < 86_000 && y0 > 446_000 && y1 < 448_000 && x1 - x0 > 50 && y1 - y0 > 50);
});

test('GDAL has nothing to warn of, and the id stands there once', () => {
  const told = (command, ...args) => {
    const { stderr, status } = spawnSync(command, args, { encoding: 'utf8', maxBuffer: 2 ** 26 });
    assert.equal(status, 0, stderr);
    return stderr;
  };
  assert.equal(told('ogrinfo', '-ro', '-al', file), '');
  assert.equal(told('ogr2ogr', path.join(place, 'told.gpkg'), file), '');
  const layer = ogrinfo('-so', file, 'footprints');
  assert.match(layer, /FID Column = fid/);
  const names = [...layer.matchAll(/^(\w+): /gm)].map(([, name]) => name);
  assert.ok(names.includes('id'));
  assert.deepEqual(
    names.filter((name) => /_\d$|^source_/.test(name)),
    [],
  );
  const row = ogrinfo('-q', '-where', 'fid = 1', file, 'footprints');
  assert.match(row, /id \(String\) = NL\.IMBAG\.Pand\./);
});

test('the spatial index can be trusted after an edit', () => {
  const copy = path.join(place, 'edited.gpkg');
  fs.copyFileSync(file, copy);
  const edit = (sql) => execFileSync('ogrinfo', ['-q', '-sql', sql, copy], { stdio: ['ignore', 'ignore', 'pipe'] });
  edit('UPDATE footprints SET geom = (SELECT geom FROM footprints WHERE fid = 2) WHERE fid = 1');
  edit('UPDATE footprints SET fid = 1000 WHERE fid = 3');
  edit('UPDATE footprints SET geom = NULL WHERE fid = 4');
  edit('DELETE FROM footprints WHERE fid = 5');
  const count = (sql) => execFileSync('ogrinfo', ['-q', '-ro', '-sql', sql, copy], { encoding: 'utf8' }).match(/= (\d+)/)[1];
  assert.equal(
    count(`SELECT count(*) AS n FROM rtree_footprints_geom a JOIN rtree_footprints_geom b
      ON a.id = 1 AND b.id = 2 AND a.minx = b.minx AND a.maxy = b.maxy`),
    '1',
  );
  assert.equal(count('SELECT count(*) AS n FROM rtree_footprints_geom WHERE id IN (3, 4, 5)'), '0');
  assert.equal(count('SELECT count(*) AS n FROM rtree_footprints_geom WHERE id = 1000'), '1');
});

test('the spatial index and the geometries agree', () => {
  const query = (sql) => ogrinfo('-q', '-dialect', 'SQLite', '-sql', sql, file).match(/= ([\d.e+-]+)/)[1];
  assert.equal(query('SELECT count(*) AS n FROM footprints WHERE ST_IsValid(geom)'), '71');
  const indexed = (sql) => execFileSync('ogrinfo', ['-q', '-ro', '-sql', sql, file], { encoding: 'utf8' }).match(/= ([\d.e+-]+)/)[1];
  const differing = `SELECT count(*) AS n FROM faces f JOIN rtree_faces_geom r ON r.id = f.fid
    WHERE abs(ST_MinX(f.geom) - r.minx) > 0.1 OR abs(ST_MaxY(f.geom) - r.maxy) > 0.1`;
  assert.equal(indexed(differing), '0');
  const whole = indexed('SELECT count(*) AS n FROM faces');
  assert.equal(indexed('SELECT count(*) AS n FROM rtree_faces_geom'), whole);
  // What stands on the ground stands on the footprints without their open ground; the model simplifies both by up to a
  // decimetre.
  const area = query("SELECT sum(ST_Area(geom)) AS a FROM faces WHERE lod = '2.2' AND surface_type = 'GroundSurface'");
  const drawn = query(
    "SELECT sum(ST_Area(geom) - coalesce(gable_open_ground_area, 0)) AS a FROM footprints WHERE lod = '2.2'",
  );
  assert.ok(Math.abs(area - drawn) < 0.01 * drawn, `${area} m² of ground, ${drawn} m² of footprints`);
});

test('GDAL carries it over to another format', () => {
  const copy = path.join(place, 'copy.gpkg');
  execFileSync('ogr2ogr', [copy, file], { stdio: ['ignore', 'ignore', 'pipe'] });
  assert.match(ogrinfo('-so', copy, 'faces'), /3D Multi Polygon/);
});
