// The building that is open, and what is asked of the server about it. One thing at a time: each answer has a revision that the
// next question names.

import { counted } from '../../../view/page/src/format.js';
import { api } from './api.js';
import { Building } from './building.js';

export class Session {
  constructor(state, messages) {
    Object.assign(this, { state, messages, isBusy: false });
  }

  /** Opens a building; what was asked for before and comes later is not shown. */
  async open(id) {
    this.wanted = id;
    this.state.set({ id });
    try {
      const packed = await this.messages.during(`Opening ${id}…`, api.building(id));
      if (this.wanted === id) {
        this.take(packed, null);
      }
      return this.wanted === id;
    } catch (error) {
      this.messages.fail(`${id} cannot be opened: ${error.message}`);
      return false;
    }
  }

  take(packed, last) {
    const building = new Building(packed, last);
    const plane = last && last.head.id === building.head.id ? this.samePlane(last, building) : -1;
    this.state.set({ building, plane });
    this.follow(building.head);
  }

  /** The plane of a building after an edit that is the one that was chosen before; -1 where none is. */
  samePlane(last, building) {
    const chosen = last.planes[this.state.plane];
    if (!chosen) {
      return -1;
    }
    const text = JSON.stringify(chosen.at);
    const same = building.planes.findIndex(({ at }) => JSON.stringify(at) === text);
    if (same >= 0) {
      return same;
    }
    // It was moved or turned: it is the one that most of its points are on.
    const counts = new Map();
    const own = last.pointsOn(this.state.plane);
    own.forEach((i) => counts.set(building.points.on[i], (counts.get(building.points.on[i]) ?? 0) + 1));
    const [label, count] = [...counts].reduce((most, one) => (one[1] > most[1] ? one : most), [0, 0]);
    return count * 2 > own.length ? label - 1 : -1;
  }

  /** Brings the row of the list up to date. */
  follow(head) {
    const of = (row) => {
      const { rmse, missing, excess, confidence, faces, failure, lod } = head.now;
      const own = {
        state: head.state,
        edits: head.edits.length,
        rmse,
        missing,
        excess,
        confidence,
        faces,
        failure,
        lod,
      };
      return head.row ?? { ...row, ...own };
    };
    this.state.set({ rows: this.state.rows.map((row) => (row.id === head.id ? of(row) : row)) });
  }

  /** Asks for a change of the building; whether it was done. */
  async change(text, ask) {
    const { state, messages } = this;
    const { building } = state;
    if (!building || this.isBusy) {
      messages.tell(building ? 'The building is still being solved.' : 'No building is open.');
      return false;
    }
    this.isBusy = true;
    const { id, revision } = building.head;
    try {
      const packed = await messages.during(text, ask(id, revision));
      if (this.wanted === id) {
        this.take(packed, building);
      }
      return true;
    } catch (error) {
      messages.fail(error.message);
      if (error.status === 409) {
        messages.tell('The building was changed elsewhere: it is shown as it is now.');
        await this.open(id);
      }
      return false;
    } finally {
      this.isBusy = false;
    }
  }

  async act(action) {
    const isDone = await this.change('Solving…', (id, revision) => api.edit(id, revision, action));
    const last = this.state.building?.head.edits.at(-1);
    if (isDone && last && !last.applied) {
      this.messages.tell(`The edit does not apply: ${last.note}. Ctrl+Z takes it back.`);
    }
    return isDone;
  }

  undo() {
    return this.state.building?.head.edits.length > 0 && this.change('Undoing…', api.undo);
  }

  redo() {
    return this.state.building?.head.undone > 0 && this.change('Doing it again…', api.redo);
  }

  clear() {
    return this.state.building?.head.edits.length > 0 && this.change('Undoing all…', api.clear);
  }

  /** Sets the state of the building that is open. */
  async decide(name) {
    const { state, messages } = this;
    const { building } = state;
    if (!building) {
      return;
    }
    try {
      const { row } = await messages.during('Saving…', api.state(building.head.id, name));
      // Another object, or nobody would be told.
      const head = { ...building.head, state: row.state, row };
      state.set({ building: Object.assign(Object.create(Object.getPrototypeOf(building)), building, { head }) });
      this.follow(head);
    } catch (error) {
      messages.fail(error.message);
    }
  }

  async export() {
    try {
      const { path, buildings, warnings = [] } = await this.messages.during('Writing what was accepted…', api.export());
      this.messages.tell(`${path}: the model with what was accepted; ${counted(buildings, 'building')} made anew.`);
      warnings.forEach((warning) => this.messages.note(warning));
    } catch (error) {
      this.messages.fail(error.message);
    }
  }
}
