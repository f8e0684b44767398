// Where things are on earth, by a road of its own: GDAL for the CRS, a formula for the ellipsoid.
'use strict';

const { execFileSync } = require('node:child_process');

/** Longitude and latitude in degrees and height in metres of points of a CRS. */
function geographic(points, crs) {
  const input = points.map((point) => point.join(' ')).join('\n');
  const args = ['-s_srs', crs, '-t_srs', 'OGC:CRS84', '-output_xy'];
  const lines = execFileSync('gdaltransform', args, { input, encoding: 'utf8' }).trim().split('\n');
  return lines.map((line, i) => [...line.trim().split(/\s+/).map(Number), points[i][2]]);
}

/** Longitude and latitude in degrees and ellipsoidal height in metres of a geocentric point of WGS 84. */
function onEllipsoid([x, y, z]) {
  const [a, f] = [6378137, 1 / 298.257223563];
  const e2 = f * (2 - f);
  const flat = Math.hypot(x, y);
  let [latitude, height] = [Math.atan2(z, flat * (1 - e2)), 0];
  for (let i = 0; i < 10; i += 1) {
    const n = a / Math.sqrt(1 - e2 * Math.sin(latitude) ** 2);
    height = flat / Math.cos(latitude) - n;
    latitude = Math.atan2(z, flat * (1 - (e2 * n) / (n + height)));
  }
  return [(Math.atan2(y, x) * 180) / Math.PI, (latitude * 180) / Math.PI, height];
}

/** Metres along the ground from a point to the edge between two others, all near each other and in degrees. */
function edgeDistance([longitude, latitude], ...ends) {
  const degree = (Math.PI / 180) * 6378137;
  const local = ([x, y]) => [(x - longitude) * degree * Math.cos((latitude * Math.PI) / 180), (y - latitude) * degree];
  const [[x0, y0], [x1, y1]] = ends.map(local);
  const [dx, dy] = [x1 - x0, y1 - y0];
  const along = Math.min(1, Math.max(0, -(x0 * dx + y0 * dy) / (dx * dx + dy * dy || 1)));
  return Math.hypot(x0 + along * dx, y0 + along * dy);
}

module.exports = { edgeDistance, geographic, onEllipsoid };
