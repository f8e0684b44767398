// Marking places inside or outside: a cell that is shown, or what lies before or behind a face of the result.

import { decimal } from '../../../view/page/src/format.js';
import { CHOSEN } from './colours.js';
import { along } from './planes.js';
import { Tool, says } from './tool.js';

/** So far from a face the place is marked, metres. */
const FROM_FACE = 0.25;

export class Mark extends Tool {
  constructor(app, isInside) {
    super(app);
    this.isInside = isInside;
  }

  /** The place that a click marks, with the cell that is there where cells are shown. */
  at(event) {
    const { app } = this;
    const hit = app.places.itemAt(event.clientX, event.clientY, app.state.layers.cells ? ['cell'] : ['result']);
    if (!hit) {
      return null;
    }
    if (hit.kind === 'cell') {
      return { cell: hit.item, place: this.building.middleOf(hit.item) };
    }
    // What is inside lies behind the face, what is to be inside before it.
    return { face: hit.item, place: along(hit.place, hit.normal, this.isInside ? FROM_FACE : -FROM_FACE) };
  }

  leave() {
    this.app.picture.erase('marked');
  }

  out() {
    this.leave();
  }

  click(event) {
    const hit = this.at(event);
    if (hit) {
      this.app.act({ 'mark-place': { place: this.building.frame.toCrs(hit.place), inside: this.isInside } });
    }
  }

  hover(event) {
    const hit = this.at(event);
    this.app.picture.drawLines('marked', hit ? this.edgesOf(hit) : [], CHOSEN, { width: 3, isHidden: true });
    if (!hit) {
      return null;
    }
    const wanted = this.isInside ? 'click: inside' : 'click: outside';
    if (hit.cell === undefined) {
      return [wanted, this.isInside ? 'what lies before this face' : 'what lies behind this face'];
    }
    const { cells } = this.building;
    const share = decimal(100 * (cells.occupancy[hit.cell] ?? 0), 0);
    return [wanted, `cell ${hit.cell + 1}: ${share} % inside, ${cells.cut[hit.cell] ? 'inside' : 'outside'} now`];
  }

  edgesOf({ cell, face }) {
    const { cells, faces } = this.building;
    const at = (positions, corner) => [...positions.subarray(corner * 3, corner * 3 + 3)];
    if (cell === undefined) {
      return faces.edges
        .filter((_, i) => faces.edgeOwner[i >> 1] === face)
        .map((corner) => at(faces.positions, corner));
    }
    return cells.facets[cell].flatMap((ring) =>
      ring.flatMap((corner, i) => [at(cells.positions, corner), at(cells.positions, ring[(i + 1) % ring.length])]),
    );
  }

  options() {
    const { cells } = this.app.state.layers;
    return [
      says(
        cells
          ? `Click a cell: it is ${this.isInside ? 'inside' : 'outside'}, whatever the field says.`
          : this.isInside
            ? 'Click a face: what lies before it is inside.'
            : 'Click a face: what lies behind it is outside.',
      ),
      says(
        cells ? 'Shift+C hides the cells: then faces are clicked.' : 'Shift+C shows the cells, to click one of them.',
      ),
    ];
  }
}
