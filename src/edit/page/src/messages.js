// What goes wrong stays until it is dismissed; what is only said goes by itself; and while something is waited for, it is seen.

import { element, refill } from '../../../view/page/src/dom.js';

export class Messages {
  constructor({ stack, told, busy }) {
    Object.assign(this, { stack, told, busy });
    this.waiting = 0;
  }

  /** An error. */
  fail(text) {
    this.stay(text, 'message');
  }

  /** What one should know, and is no error. */
  note(text) {
    this.stay(text, 'message mild');
  }

  /** The same text is not said twice. */
  stay(text, kind) {
    if ([...this.stack.children].some((node) => node.firstElementChild.textContent === text)) {
      return;
    }
    const close = element(
      'button',
      { type: 'button', class: 'close', 'aria-label': 'Dismiss', title: 'Dismiss (Esc)' },
      '×',
    );
    const node = element('div', { class: kind, role: 'alert' }, element('p', {}, text), close);
    close.addEventListener('click', () => node.remove());
    this.stack.append(node);
  }

  /** Takes the last error away; whether there was one. */
  dismiss() {
    const last = this.stack.lastElementChild;
    last?.remove();
    return Boolean(last);
  }

  tell(text) {
    refill(this.told, text);
    this.told.hidden = false;
    clearTimeout(this.going);
    this.going = setTimeout(() => (this.told.hidden = true), 6000);
  }

  /** Shows that something is waited for until the promise ends. */
  async during(text, promise) {
    this.waiting += 1;
    refill(this.busy.lastElementChild, text);
    // What is there at once need not be waited for.
    const late = setTimeout(() => (this.busy.hidden = false), 120);
    try {
      return await promise;
    } finally {
      clearTimeout(late);
      this.waiting -= 1;
      this.busy.hidden = this.waiting === 0 ? true : this.busy.hidden;
    }
  }
}
