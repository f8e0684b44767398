// The steps of the method: what is told of each, what it draws, and what can be set.
//
// `draw(picture, building, choices)` fills the picture; `legend(building, choices)` are its entries, [colour, name, count], or a
// ramp { ramp, low, high }. `choices` are the controls that a step has, by the names of the CHOICES.

import { CLASSES, LABELS, NOTHING, RAMPS } from '../../../view/page/src/palette.js';
import { decimal, whole } from '../../../view/page/src/format.js';
import { CUT, INSIDE, MARK, OUTLINE, PLANES, many } from './colours.js';

/** The controls: a checkbox, or a slider from 0 to 1. */
export const CHOICES = {
  points: { name: 'points', initial: true },
  planes: { name: 'planes', initial: true },
  beyond: { name: 'cells beyond the footprint', initial: false },
  outside: { name: 'cells outside, as glass', initial: true },
  apart: { name: 'apart', initial: 0.25, isShare: true },
  least: { name: 'hide cells less likely than', initial: 0.05, isShare: true },
};

const slopeOf = (normals, i) => (Math.acos(Math.min(Math.abs(normals[i * 3 + 2]), 1)) * 180) / Math.PI;

const tellPlane = (polygons, counts) => (i) => [
  `plane ${i + 1}`,
  `${counts[i] ? `${whole(counts[i])} points, ` : ''}${decimal(slopeOf(polygons.normals, i), 1)}° from the horizontal`,
];

const tellCell =
  (building, ...more) =>
  (cell) => [
    `cell ${cell + 1}`,
    [`${decimal(building.cells.volumes[cell], 2)} m³`, ...more.map((of) => of(cell))].join(', '),
  ];

const likely =
  ({ cells }) =>
  (cell) =>
    `${decimal(100 * cells.occupancy[cell], 0)} % inside`;

/** The points of a building in the colours of their planes, and these. */
function drawPlanes(picture, building, choices, polygons, labels) {
  picture.addOutline(OUTLINE);
  if (choices.planes) {
    const tell = tellPlane(polygons, building.countsOf(labels));
    picture.addPolygons(polygons, (i) => many(i), { opacity: 0.4, tell });
  }
  if (choices.points) {
    picture.addPoints(building.points.positions, (i) => (labels[i] > 0 ? many(labels[i] - 1) : NOTHING), 3.4);
  }
}

function planesLegend(building, polygons, labels) {
  const none = labels.filter((label) => label === 0).length;
  return [
    [many(0), 'planes, each of its own colour', whole(polygons.count)],
    [NOTHING, 'points on no plane', whole(none)],
  ];
}

const isFixed = (building, cell) => building.cells.fixed[cell] === 1;

export const STEPS = [
  {
    key: 'points',
    name: 'Points',
    title: 'What was scanned',
    text: [
      'The points of the tiles around the building, by their class. Of the building are those of a building class inside its footprint; of the ground around them the height of the floor is taken.',
      'Everything that follows happens in a frame of metres whose origin is beside the building.',
    ],
    controls: [],
    draw: (picture, building) => {
      const { cloud, points } = building;
      picture.addPoints(cloud.positions, (i) => CLASSES[cloud.classes[i]]?.[1] ?? NOTHING);
      picture.addPoints(points.positions, () => MARK, 3.4);
      picture.addOutline(OUTLINE);
    },
    legend: (building) => {
      const { classes } = building.cloud;
      const counts = new Map();
      classes.forEach((code) => counts.set(code, (counts.get(code) ?? 0) + 1));
      const codes = [...counts.keys()].sort((a, b) => a - b);
      return [
        [MARK, 'points of this building', whole(building.points.positions.length / 3)],
        [OUTLINE, 'footprint, at the height of the floor', ''],
        ...codes.map((code) => [
          CLASSES[code]?.[1] ?? NOTHING,
          `around: ${CLASSES[code]?.[0] ?? 'class'} (${code})`,
          whole(counts.get(code)),
        ]),
      ];
    },
  },
  {
    key: 'found',
    name: 'Planes found',
    title: 'Planes, as they are found',
    text: [
      'Every point gets a normal from its neighbours. A plane starts where the points are smoothest and takes in neighbours that lie on it and share its normal (or RANSAC draws planes by lot). How near is near enough follows from the noise, which is measured in this building.',
      'A roof is often found in several pieces here, and planes that should be parallel are not quite.',
    ],
    controls: ['points', 'planes'],
    draw: (picture, building, choices) => drawPlanes(picture, building, choices, building.found, building.points.found),
    legend: (building) => planesLegend(building, building.found, building.points.found),
  },
  {
    key: 'refined',
    name: 'Planes refined',
    title: 'Planes, refined and made regular',
    text: [
      'The two planes with the smallest angle between them are merged if each part stays as near to the common plane as its own noise explains; then the next two, until none fit. Then planes that are nearly level, parallel, symmetric or at right angles become so, as far as the points allow.',
      'A roof that was seen in places far apart is a plane in several pieces, each of which cuts for itself.',
    ],
    controls: ['points', 'planes'],
    draw: (picture, building, choices) =>
      drawPlanes(picture, building, choices, building.refined, building.points.refined),
    legend: (building) => planesLegend(building, building.refined, building.points.refined),
  },
  {
    key: 'walls',
    name: 'Walls added',
    title: 'Planes that nobody scanned',
    text: [
      'From the air walls are hardly seen. So a wall is put on every edge of the footprint, simplified a little, and wherever the map of the roofs jumps in height; the floor is the bottom of the box. Each plane reaches as far as its own evidence, and cuts no farther.',
    ],
    controls: ['points'],
    draw: (picture, building, choices) => {
      const { planes } = building;
      const tell = (i) => [
        building.head.plane_kinds[planes.kinds[i]],
        `${decimal(slopeOf(planes.normals, i), 1)}° from the horizontal`,
      ];
      // Walls are many and stand before all else.
      const isUpright = (i) => planes.kinds[i] >= 2;
      const colour = (i) => PLANES[planes.kinds[i]];
      picture.addPolygons(planes, (i) => (isUpright(i) ? null : colour(i)), { opacity: 0.75, tell });
      picture.addPolygons(planes, (i) => (isUpright(i) ? colour(i) : null), { opacity: 0.26, tell });
      picture.addOutline(OUTLINE);
      if (choices.points) {
        picture.addPoints(building.points.positions, () => NOTHING, 2.4);
      }
    },
    legend: (building) =>
      building.head.plane_kinds
        .map((name, kind) => [PLANES[kind], name, building.planes.kinds.filter((own) => own === kind).length])
        .filter(([, , count]) => count > 0)
        .map(([colour, name, count]) => [colour, name, whole(count)]),
  },
  {
    key: 'cells',
    name: 'Cells',
    title: 'The planes cut space into cells',
    text: [
      'A box around the building is cut by one plane after the other, walls first, each only where it reaches. What is left are convex cells that share their faces. Every plane is rounded to whole numbers once, and from then on all is exact: no gap and no overlap can come of it.',
    ],
    controls: ['apart', 'beyond'],
    draw: (picture, building, choices) =>
      picture.addCells((cell) => (isFixed(building, cell) && !choices.beyond ? null : many(cell)), choices.apart, {
        tell: tellCell(building, (cell) => (isFixed(building, cell) ? 'beyond the footprint' : 'to be decided')),
      }),
    legend: (building) => [[many(0), 'cells to be decided', whole(building.cells.fixed.filter((f) => !f).length)]],
  },
  {
    key: 'field',
    name: 'Field',
    title: 'How likely is each cell inside?',
    text: [
      'A field answers for places in each cell. The vote asks which share of vertical lines through the cell lies below the roof that is seen there; it knows no overhangs. The network has learned from many buildings: it looks at the building from above once, then at the nearest points of each place, and answers with a probability. It is asked where the vote leaves something unexplained.',
    ],
    controls: ['apart', 'least'],
    draw: (picture, building, choices) =>
      picture.addCells(
        (cell) => {
          const share = building.cells.occupancy[cell] ?? 0;
          return isFixed(building, cell) || share < choices.least ? null : INSIDE(share);
        },
        choices.apart,
        { tell: tellCell(building, likely(building)) },
      ),
    legend: () => ({ ramp: INSIDE, low: 'outside, 0', high: '1, inside' }),
  },
  {
    key: 'cut',
    name: 'Cut',
    title: 'The cut decides',
    text: [
      'Inside or outside, so that the energy E = D + λ V is smallest: D asks every cell to follow its probability, by its volume; V asks the surface to be small, where no points ask for it. A minimum cut finds the very best answer, not a good one. A cell may go against its own probability where the surface is much simpler for it.',
    ],
    controls: ['apart', 'outside'],
    draw: (picture, building, choices) => {
      const { cut, occupancy } = building.cells;
      const colour = (cell) => {
        const isInside = cut[cell] === 1;
        const isOverruled = isInside !== occupancy[cell] > 0.5;
        return isInside ? (isOverruled ? CUT.overruledIn : CUT.inside) : isOverruled ? CUT.overruledOut : CUT.outside;
      };
      const tell = tellCell(building, likely(building), (cell) => (cut[cell] === 1 ? 'cut: inside' : 'cut: outside'));
      const isFree = (cell) => !isFixed(building, cell);
      picture.addCells((cell) => (isFree(cell) && cut[cell] === 1 ? colour(cell) : null), choices.apart, { tell });
      if (choices.outside) {
        const glass = { opacity: 0.12, edges: 0.18 };
        picture.addCells((cell) => (isFree(cell) && cut[cell] !== 1 ? colour(cell) : null), choices.apart, glass);
      }
    },
    legend: (building) => {
      const { cut, occupancy, fixed } = building.cells;
      const free = fixed.flatMap((isOut, cell) => (isOut ? [] : [cell]));
      const count = (isInside, isLikely) =>
        whole(free.filter((cell) => (cut[cell] === 1) === isInside && occupancy[cell] > 0.5 === isLikely).length);
      return [
        [CUT.inside, 'inside', count(true, true)],
        [CUT.overruledIn, 'inside, against its own probability', count(true, false)],
        [CUT.outside, 'outside', count(false, false)],
        [CUT.overruledOut, 'outside, against its own probability', count(false, true)],
      ];
    },
  },
  {
    key: 'surface',
    name: 'Surface',
    title: 'The surface between inside and outside',
    text: [
      'The faces between a cell inside and one outside are the building. Slivers and small features go by giving their cells the other label, which can never open the surface; where it touches itself it is mended. Coplanar faces become one, corners are rounded to the grid of the file, and every face gets its name: roof, wall, ground, outer ceiling.',
    ],
    controls: [],
    draw: (picture, building) => {
      const { faces, head } = building;
      const name = (i) => head.surfaces[faces.kinds[i]];
      const tell = (i) => [name(i), `${decimal(slopeOf(faces.normals, i), 1)}° from the horizontal`];
      picture.addPolygons(faces, (i) => LABELS[name(i)], { tell });
    },
    legend: (building) =>
      building.head.surfaces
        .map((name, kind) => [LABELS[name], name, building.faces.kinds.filter((own) => own === kind).length])
        .filter(([, , count]) => count > 0)
        .map(([colour, name, count]) => [colour, name, whole(count)]),
  },
  {
    key: 'result',
    name: 'Result',
    title: 'How well does it fit?',
    text: [
      'The model is held against the points that it was made from: here every point in the colour of its distance to the nearest face. Where a scanned part stays unexplained the model is made again with planes there; where it is invalid or fits worse than a block, with coarser tolerances, and at last it is the block. What is written has passed the check of its rings, polygons and shell.',
    ],
    controls: ['points'],
    draw: (picture, building, choices) => {
      const { faces, head, points } = building;
      picture.addPolygons(faces, (i) => LABELS[head.surfaces[faces.kinds[i]]], { opacity: 0.45, casts: true });
      if (choices.points && points.distances.length > 0) {
        picture.addPoints(points.positions, (i) => RAMPS.error(points.distances[i] / 0.5), 3.6);
      } else if (choices.points) {
        picture.addPoints(points.positions, () => NOTHING, 3);
      }
    },
    legend: (building) =>
      building.points.distances.length > 0
        ? { ramp: RAMPS.error, low: '0 m from the nearest face', high: '0.5 m and more' }
        : [[NOTHING, 'points; there is no model to be far from', '']],
  },
];
