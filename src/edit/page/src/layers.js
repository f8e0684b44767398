// The layers of the picture: what each draws of a building.

import { LABELS } from '../../../view/page/src/palette.js';
import { decimal, whole } from '../../../view/page/src/format.js';
import { INSIDE, OUTLINE, PLANES, many } from '../../../explain/page/src/colours.js';
import { BEFORE, COLOURINGS, CHOSEN, FAR, GONE, MARKS, QUIET, signed } from './colours.js';
import { distance } from './planes.js';

/** The layers: their keys on the keyboard, and whether they are shown at first. */
export const LAYERS = [
  {
    key: 'points',
    name: 'Points',
    press: 'P',
    isShown: true,
    title: 'The points of the building, and those around it',
  },
  {
    key: 'around',
    name: 'Around',
    press: 'Shift+P',
    isShown: false,
    title: 'Points of the tiles that are none of the building',
  },
  { key: 'result', name: 'Result', press: 'Shift+R', isShown: true, title: 'The model as it is now' },
  { key: 'planes', name: 'Planes', press: 'Shift+L', isShown: false, title: 'The planes that were detected or added' },
  {
    key: 'footprint',
    name: 'Footprint',
    press: 'Shift+F',
    isShown: true,
    title: 'The footprint at the height of the floor',
  },
  {
    key: 'walls',
    name: 'Walls',
    press: 'Shift+V',
    isShown: false,
    title: 'The planes that stand on edges of the footprint and on jumps in height',
  },
  { key: 'cells', name: 'Cells', press: 'Shift+C', isShown: false, title: 'The cells by how likely they are inside' },
  { key: 'before', name: 'Before', press: 'Shift+B', isShown: false, title: 'The edges of the model without any edit' },
];

const tellPlane = (building) => (i) => {
  const plane = building.planes[i];
  const place = `${decimal(plane.tilt, 1)}° from the level`;
  return [
    `${plane.kind} ${i + 1}${plane.on ? '' : ', off'}`,
    `${whole(plane.points)} points, rms ${decimal(plane.rms, 3)} m, ${place}`,
  ];
};

const slopeOf = (normals, i) => (Math.acos(Math.min(Math.abs(normals[i * 3 + 2]), 1)) * 180) / Math.PI;

/** Marks a layer's meshes as of a kind that can be picked. */
function pickable(layer, kind) {
  layer.kind = kind;
  layer.objects.filter(({ isMesh }) => isMesh).forEach((mesh) => (mesh.userData.kind = kind));
}

function drawPoints(picture, building, state) {
  const colouring = COLOURINGS.find(({ key }) => key === state.colouring).of(building);
  const { points, cloud } = building;
  if (state.layers.around) {
    picture.addPoints(cloud.positions, colouring(cloud), 2);
  }
  if (!state.layers.points) {
    return;
  }
  const plane = building.planes[state.plane];
  const of = colouring(points);
  const own = (i) => {
    if (points.excluded[i]) {
      return null;
    }
    // Of a plane that is chosen the points tell how far they are from it.
    if (plane && points.on[i] === state.plane + 1) {
      return signed(Math.round((distance(plane, building.pointAt(i)) / FAR) * 200) / 100);
    }
    return of(i);
  };
  picture.addPoints(points.positions, own, 3.4);
  if (points.excluded.some((is) => is)) {
    picture.addPoints(points.positions, (i) => (points.excluded[i] ? '#8a8f96' : null), 2);
  }
}

function drawPlanes(picture, building, state) {
  const { hulls, planes } = building;
  const tell = tellPlane(building);
  const shown = (i) => (planes[i].on && i !== state.plane ? many(i) : null);
  pickable(picture.addPolygons(hulls, shown, { opacity: 0.42, tell }), 'plane');
  if (planes.some(({ on }) => !on)) {
    const off = (i) => (!planes[i].on && i !== state.plane ? '#9aa1a9' : null);
    pickable(picture.addPolygons(hulls, off, { opacity: 0.12, edges: 0.35, tell }), 'plane');
  }
}

function drawChosen(picture, building, state) {
  const { hulls, planes } = building;
  const only = (i) => (i === state.plane ? (planes[i].on ? CHOSEN : GONE) : null);
  pickable(picture.addPolygons(hulls, only, { opacity: 0.3, edges: 0.9, tell: tellPlane(building) }), 'plane');
}

function drawCells(picture, building, state) {
  const { cells } = building;
  const of = (cell) => {
    const share = cells.occupancy[cell] ?? 0;
    // What is inside against its own probability is what one looks for.
    return cells.fixed[cell] || (share < state.least && !cells.cleaned[cell]) ? null : INSIDE(share);
  };
  const tell = (cell) => [
    `cell ${cell + 1}`,
    `${decimal(cells.volumes[cell], 2)} m³, ${decimal(100 * (cells.occupancy[cell] ?? 0), 0)} % inside, cut: ${cells.cut[cell] ? 'inside' : 'outside'}`,
  ];
  pickable(picture.addCells(of, 0, { opacity: 0.5, edges: 0.35, tell }), 'cell');
}

function drawResult(picture, building, state) {
  const { faces, head } = building;
  const name = (i) => head.surfaces[faces.kinds[i]];
  const colours = state.layers.points && state.colouring !== 'class' ? QUIET[state.theme] : LABELS;
  const tell = (i) => [name(i), `${decimal(slopeOf(faces.normals, i), 1)}° from the level`];
  const options = { opacity: state.opacity, edges: 0.75, casts: true, tell };
  pickable(
    picture.addPolygons(faces, (i) => colours[name(i)], options),
    'result',
  );
}

/** Places that edits name: marks, and lines along which parts are split. */
function drawEdits(picture, building) {
  const { frame, head } = building;
  const actions = head.edits.filter(({ applied }) => applied).flatMap(({ action }) => action ?? []);
  const marks = actions.flatMap((action) => action['mark-place'] ?? []);
  const places = marks.map(({ place }) => frame.toScene(place));
  picture.drawPoints('marks', places, (i) => (marks[i].inside ? MARKS.inside : MARKS.outside), 11, { isHidden: true });
  const splits = actions.flatMap((action) => action['split-parts'] ?? []);
  const pairs = splits.flatMap(({ line }) => {
    const along = line.map((place) => frame.planToScene(place, building.floor));
    return along.slice(1).flatMap((place, i) => [along[i], place]);
  });
  picture.drawLines('splits', pairs, GONE, { width: 3, isHidden: true });
}

/** Fills the picture with what is chosen to be shown. */
export function drawLayers(picture, building, state) {
  picture.clear();
  const { layers } = state;
  if (layers.result) {
    drawResult(picture, building, state);
  }
  if (layers.cells) {
    drawCells(picture, building, state);
  }
  if (layers.walls) {
    const { walls } = building;
    const isUpright = (i) => walls.kinds[i] >= 3;
    picture.addPolygons(walls, (i) => (isUpright(i) ? PLANES[walls.kinds[i]] : null), { opacity: 0.12, edges: 0.3 });
  }
  if (layers.footprint) {
    picture.addOutline(OUTLINE);
  }
  if (layers.planes) {
    drawPlanes(picture, building, state);
  }
  if (state.plane >= 0) {
    drawChosen(picture, building, state);
  }
  drawPoints(picture, building, state);
  const { before } = building;
  const edges = layers.before
    ? before.edges.map((corner) => [...before.positions.subarray(corner * 3, corner * 3 + 3)])
    : [];
  picture.drawLines('before', edges, BEFORE[state.theme], { width: 2, isHidden: true, opacity: 0.8 });
  drawEdits(picture, building);
}
