// Reads what the tests want of binary glTF, by hand.
'use strict';

const fs = require('node:fs');

/** The JSON and the binary part of a file. */
function read(file) {
  const bytes = fs.readFileSync(file);
  const length = bytes.readUInt32LE(12);
  const json = JSON.parse(bytes.subarray(20, 20 + length));
  return { json, binary: bytes.subarray(28 + length) };
}

function view({ json, binary }, index) {
  const { byteOffset = 0, byteLength } = json.bufferViews[index];
  return binary.subarray(byteOffset, byteOffset + byteLength);
}

/** The numbers of an accessor of 32-bit floats, so many together. */
function floats(glb, index) {
  const accessor = glb.json.accessors[index];
  const size = { SCALAR: 1, VEC3: 3 }[accessor.type];
  const bytes = view(glb, accessor.bufferView);
  return Array.from({ length: accessor.count }, (_, i) =>
    Array.from({ length: size }, (_, j) => bytes.readFloatLE((i * size + j) * 4)),
  );
}

/** The texts of a property. */
function texts(glb, table, property) {
  const { count, properties } = glb.json.extensions.EXT_structural_metadata.propertyTables[table];
  const bytes = view(glb, properties[property].values);
  const offsets = view(glb, properties[property].stringOffsets);
  return Array.from({ length: count }, (_, i) =>
    bytes.toString('utf8', offsets.readUInt32LE(i * 4), offsets.readUInt32LE(i * 4 + 4)),
  );
}

/** The ids of the features of a file. */
const ids = (file) => texts(read(file), 0, 'id');

/** Vertices of the file in geocentric metres with the ids of their features: `[{ id, class, position }]`. */
function vertices(glb, transform) {
  const names = texts(glb, 0, 'id');
  const [tx, ty, tz] = glb.json.nodes[0].translation;
  return glb.json.meshes[0].primitives.flatMap((primitive) => {
    const name = glb.json.materials[primitive.material].name;
    const ids = floats(glb, primitive.attributes._FEATURE_ID_0);
    return floats(glb, primitive.attributes.POSITION).map(([x, y, z], i) => {
      // glTF has y up, 3D Tiles z up.
      const local = [x + tx, -(z + tz), y + ty, 1];
      const position = [0, 1, 2].map((row) => local.reduce((sum, c, column) => sum + transform[column * 4 + row] * c, 0));
      return { id: names[ids[i][0]], class: name, position };
    });
  });
}

module.exports = { ids, read, texts, vertices };
