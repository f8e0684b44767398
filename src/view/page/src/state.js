// What the page shows at the moment, and who wants to know when that changes.

export class State {
  constructor() {
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
    this.listeners = [];
  }

  /** Calls `act(changed)` after every change; `changed` has the names of what did. */
  listen(act) {
    this.listeners.push(act);
  }

  set(changes) {
    // Another colouring has a scale of its own.
    const all = 'colouring' in changes && changes.colouring !== this.colouring ? { range: null, ...changes } : changes;
    const changed = Object.keys(all).filter((name) => this[name] !== all[name]);
    Object.assign(this, all);
    if (changed.length > 0) {
      this.listeners.forEach((act) => act(new Set(changed)));
    }
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
