// CesiumJS on a page of its own: `viewer` is its widget, without a globe and without anything from elsewhere.
'use strict';

const path = require('node:path');

/** The folder of its files, to be served as `/cesium/`. */
const CESIUM = path.join(path.dirname(require.resolve('cesium/package.json')), 'Build/Cesium');

const PAGE = `<!doctype html><meta charset="utf-8"><link rel="icon" href="data:,">
<style>html, body, #view { width: 100%; height: 100%; margin: 0 }</style><div id="view"></div>
<script>window.CESIUM_BASE_URL = '/cesium/';</script><script src="/cesium/Cesium.js"></script>
<script>
Cesium.Ion.defaultAccessToken = undefined;
const viewer = globalThis.viewer = new Cesium.CesiumWidget('view', { baseLayer: false, skyBox: false, skyAtmosphere: false,
  creditContainer: document.createElement('div') });
viewer.scene.globe.show = false;
</script>`;

module.exports = { CESIUM, PAGE };
