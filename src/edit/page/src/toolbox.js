// The tools: which there are, which is chosen, and how the pointer gets to it.

import { element, refill } from '../../../view/page/src/dom.js';
import { Floor } from './floor.js';
import { Measure, Section } from './look.js';
import { Mark } from './mark.js';
import { Move } from './move.js';
import { Edge, Redraw } from './outline.js';
import { Merge, Split, Weights } from './parts.js';
import { Pick } from './pick.js';
import { Parallel, Select } from './select.js';
import { Triple } from './triple.js';

/** The tools in the order of the panel: the key of each, what it is for, and what is said while it is chosen. */
export const TOOLS = [
  {
    key: 'select',
    name: 'Select',
    press: 'S',
    title: 'Choose a plane: switch it, level it, move it',
    hint: 'click a plane · X off or on · H level · V vertical · Y parallel to… · G move or turn',
    make: (app) => new Select(app),
  },
  {
    key: 'move',
    name: 'Move',
    press: 'G',
    title: 'Move the chosen plane along its normal, or turn it',
    hint: 'drag along the normal · Shift+drag turns · Enter moves it · Esc leaves',
    make: (app) => new Move(app),
  },
  {
    key: 'parallel',
    name: 'Parallel',
    press: 'Y',
    title: 'Turn the chosen plane parallel to another',
    hint: 'click the other plane · Esc leaves',
    make: (app) => new Parallel(app),
  },
  {
    key: 'brush',
    name: 'Brush',
    press: 'B',
    title: 'Pick points by painting over them: for a new plane, or to leave them out',
    hint: 'drag over points · Alt+drag unpicks · H level · V vertical · Enter: plane · Del: exclude',
    isDrag: true,
    make: (app) => new Pick(app, false),
  },
  {
    key: 'lasso',
    name: 'Lasso',
    press: 'L',
    title: 'Pick points by drawing around them',
    hint: 'draw around points · Shift more, Alt fewer · H level · V vertical · Enter: plane · Del: exclude',
    isDrag: true,
    make: (app) => new Pick(app, true),
  },
  {
    key: 'triple',
    name: '3 points',
    press: 'T',
    title: 'A plane through three places or more',
    hint: 'click three places · Enter adds the plane · Del takes the last back · Esc leaves',
    make: (app) => new Triple(app),
  },
  {
    key: 'inside',
    name: 'Inside',
    press: 'I',
    title: 'Mark a place that is inside the building',
    hint: 'click a face: what lies before it is inside · Shift+C to click cells · Esc leaves',
    make: (app) => new Mark(app, true),
  },
  {
    key: 'outside',
    name: 'Outside',
    press: 'U',
    title: 'Mark a place that is outside the building',
    hint: 'click a face: what lies behind it is outside · Shift+C to click cells · Esc leaves',
    make: (app) => new Mark(app, false),
  },
  {
    key: 'floor',
    name: 'Floor',
    press: 'Z',
    title: 'The height of the floor',
    hint: 'drag up or down, or click a point · Enter sets the floor · Esc leaves',
    isDrag: true,
    make: (app) => new Floor(app),
  },
  {
    key: 'edge',
    name: 'Edge',
    press: 'E',
    title: 'Offset an edge of the footprint',
    hint: 'drag an edge of the footprint · Enter offsets it · Esc leaves',
    make: (app) => new Edge(app),
  },
  {
    key: 'redraw',
    name: 'Redraw',
    press: 'Shift+E',
    title: 'Draw the footprint anew, or move its corners',
    hint: 'drag corners, or an edge for a new one · Del takes one away · Enter redraws · Esc leaves',
    make: (app) => new Redraw(app),
  },
  {
    key: 'split',
    name: 'Split',
    press: 'Shift+S',
    title: 'Split the building along a line',
    hint: 'click the places of the line · Enter splits · Esc leaves',
    make: (app) => new Split(app),
  },
  {
    key: 'merge',
    name: 'Merge',
    press: 'Shift+M',
    title: 'Merge parts that are close to each other',
    hint: 'Enter merges parts whose gap is not wider · Esc leaves',
    make: (app) => new Merge(app),
  },
  {
    key: 'weights',
    name: 'Weights',
    press: 'Shift+W',
    title: 'λ and the smallest feature of this building',
    hint: 'the building is solved when a slider is let go · Esc leaves',
    make: (app) => new Weights(app),
  },
  {
    key: 'measure',
    name: 'Measure',
    press: 'W',
    title: 'Measure between two places',
    hint: 'click two places · Esc leaves',
    make: (app) => new Measure(app),
  },
  {
    key: 'section',
    name: 'Section',
    press: 'C',
    title: 'Cut away what is in front, or all but a slab',
    hint: 'click two places for a section through them · Del takes it away · Esc leaves it there',
    make: (app) => new Section(app),
  },
];

/** A click that moved farther is a drag, pixels. */
const STILL = 5;

export class Toolbox {
  constructor(app, canvas, { tip, hint, outline }) {
    Object.assign(this, { app, canvas, tip, hint, outline });
    this.tools = new Map(TOOLS.map((told) => [told.key, told.make(app)]));
    this.now = 'select';
    this.listen();
  }

  get tool() {
    return this.tools.get(this.now);
  }

  choose(key) {
    if (this.now !== key) {
      this.tool.leave(!(['brush', 'lasso'].includes(this.now) && ['brush', 'lasso'].includes(key)));
    }
    this.now = key;
    this.tell(null);
    const told = TOOLS.find((own) => own.key === key);
    this.canvas.dataset.tool = key;
    this.app.state.set({ tool: key });
    refill(this.hint, element('b', {}, told.name), ` ${told.hint}`);
    if (this.app.state.building) {
      this.tool.enter();
    }
  }

  /** The building changed: what was begun is dropped, and the tool begins anew. */
  anew() {
    this.tool.leave(true);
    this.tell(null);
    this.tool.enter();
  }

  /** Says something beside the pointer. */
  tell(told, event) {
    this.tip.hidden = told === null;
    if (told && event) {
      refill(this.tip, told[0], told[1] ? element('span', {}, told[1]) : null);
      const box = this.canvas.getBoundingClientRect();
      const x = Math.min(event.clientX - box.left + 14, box.width - this.tip.offsetWidth - 8);
      const y = Math.min(event.clientY - box.top + 16, box.height - this.tip.offsetHeight - 8);
      this.tip.style.transform = `translate(${Math.round(x)}px, ${Math.round(y)}px)`;
    }
  }

  /** Draws a line around what the brush or the lasso reaches, in pixels of the canvas. */
  outlineAt(ring) {
    const node = this.outline;
    node.toggleAttribute('hidden', ring === null);
    if (ring) {
      node.firstElementChild.setAttribute(
        'points',
        ring.map((place) => place.map((v) => v.toFixed(1)).join()).join(' '),
      );
    }
  }

  listen() {
    const { canvas, app } = this;
    const isReady = () => app.state.building !== null;
    let [down, isOwn, asked] = [null, false, false];
    // Before the camera, which would turn.
    canvas.parentElement.addEventListener(
      'pointerdown',
      (event) => {
        if (event.target !== canvas || !event.isPrimary || event.button !== 0 || !isReady()) {
          return;
        }
        down = [event.clientX, event.clientY];
        // Fingers look.
        isOwn = event.pointerType !== 'touch' && this.tool.down(event);
        app.station.controls.enabled = !isOwn;
        if (isOwn) {
          canvas.setPointerCapture(event.pointerId);
          canvas.focus({ preventScroll: true });
        }
        this.tell(null);
      },
      true,
    );
    canvas.addEventListener('pointermove', (event) => {
      if (!isReady()) {
        return;
      }
      if (isOwn && down) {
        const hasMoved = Math.hypot(event.clientX - down[0], event.clientY - down[1]) >= STILL;
        this.hasDragged = this.hasDragged || hasMoved;
        if (this.hasDragged) {
          this.tool.drag(event);
        }
        return;
      }
      if (event.pointerType !== 'mouse' || event.buttons !== 0 || asked) {
        return;
      }
      asked = true;
      requestAnimationFrame(() => {
        asked = false;
        if (isReady()) {
          this.tell(this.tool.hover(event), event);
        }
      });
    });
    const end = (event) => {
      if (!down) {
        return;
      }
      const isStill = Math.hypot(event.clientX - down[0], event.clientY - down[1]) < STILL;
      if (isOwn) {
        app.station.controls.enabled = true;
        this.tool.up(event);
      }
      // Fingers look: of the tools they have those that change nothing.
      const isMeant = event.pointerType !== 'touch' || ['select', 'measure'].includes(this.now);
      if (isStill && isMeant && !this.hasDragged && event.type === 'pointerup' && isReady()) {
        this.tool.click(event);
      }
      [down, isOwn, this.hasDragged] = [null, false, false];
    };
    canvas.addEventListener('pointerup', end);
    canvas.addEventListener('pointercancel', end);
    canvas.addEventListener('pointerleave', () => {
      this.tell(null);
      this.tool.out();
    });
  }
}
