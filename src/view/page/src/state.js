// What the page shows at the moment.

import { Store } from './store.js';

export class State extends Store {
  constructor() {
    super();
    // Level of detail: a rank of Model.lods, or -1 for the best of each object.
    this.lod = -1;
    this.colouring = null;
    // The scale of the colours, [low, high], where another is chosen than that of the colouring; null for that.
    this.range = null;
    // { name, test(f) }, or null for all features.
    this.filter = null;
    // { feature, face } or null; the face is -1 when no face was pointed at.
    this.selection = null;
    this.theme = 'light';
    this.arePointsShown = false;
    this.pointColouring = 'class';
  }

  set(changes) {
    // Another colouring has a scale of its own.
    const isOther = 'colouring' in changes && changes.colouring !== this.colouring;
    super.set(isOther ? { range: null, ...changes } : changes);
  }

  /** Whether a feature passes the filter. */
  isIn(f) {
    return this.filter === null || this.filter.test(f);
  }

  /** Sets a filter, or takes it away when it is the one that is set. */
  toggleFilter(name, test) {
    this.set({ filter: this.filter?.name === name ? null : { name, test } });
  }
}
