// What the page shows at the moment: the list, the building, and how both are looked at.

import { Store } from '../../../view/page/src/store.js';
import { LAYERS } from './layers.js';

export class State extends Store {
  constructor() {
    super();
    // The list: all rows, and what of them is shown.
    Object.assign(this, { rows: [], states: new Set(), reason: '', text: '', order: 'urgency' });
    // The building that is open, by its id and as it is.
    Object.assign(this, { id: null, building: null });
    // The plane of it that is chosen, or -1, and the tool.
    Object.assign(this, { plane: -1, tool: 'select' });
    this.layers = Object.fromEntries(LAYERS.map(({ key, isShown }) => [key, isShown]));
    Object.assign(this, { colouring: 'residual', opacity: 0.6, least: 0.5, section: null });
    this.theme = 'light';
  }
}
