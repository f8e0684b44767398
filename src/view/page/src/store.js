// What a page shows at the moment, and who wants to know when that changes.

export class Store {
  constructor() {
    this.listeners = [];
  }

  /** Calls `act(changed)` after every change; `changed` has the names of what did. */
  listen(act) {
    this.listeners.push(act);
  }

  set(changes) {
    const changed = Object.keys(changes).filter((name) => this[name] !== changes[name]);
    Object.assign(this, changes);
    if (changed.length > 0) {
      this.listeners.forEach((act) => act(new Set(changed)));
    }
  }
}
