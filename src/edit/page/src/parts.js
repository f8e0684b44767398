// Parts: split by a line, merged over gaps; and the parameters of the building.

import { element, refill } from '../../../view/page/src/dom.js';
import { decimal } from '../../../view/page/src/format.js';
import { GONE } from './colours.js';
import { chainOf } from './picture.js';
import { Tool, button, numberField, says } from './tool.js';

/** Corners of the footprint so near to the pointer are meant, pixels. */
const NEAR = 12;

export class Split extends Tool {
  constructor(app) {
    super(app);
    this.line = [];
  }

  leave() {
    this.line = [];
    this.app.picture.erase('split');
  }

  at(event) {
    const { places } = this.app;
    const [x, y] = places.inCanvas(event.clientX, event.clientY);
    const corner = this.building
      .footprint()
      .flat(2)
      .find((place) => {
        const [u, v] = places.onScreen(place);
        return Math.hypot(u - x, v - y) < NEAR;
      });
    return corner ?? places.placeAt(this.building, event.clientX, event.clientY);
  }

  draw(next) {
    const line = [...this.line, ...(next ? [next] : [])];
    this.app.picture.drawLines('split', chainOf(line), GONE, { width: 3.5, isHidden: true });
  }

  click(event) {
    const place = this.at(event);
    if (place) {
      this.line = [...this.line, place];
      this.draw();
      this.app.showOptions();
    }
  }

  hover(event) {
    if (this.line.length > 0) {
      this.draw(this.at(event));
    }
    return this.line.length < 2 ? [`place ${this.line.length + 1} of the line`] : ['Enter splits', 'or one more place'];
  }

  confirm() {
    if (this.line.length < 2) {
      this.app.tell('Click at least two places of the line, across the whole footprint.');
      return;
    }
    const line = this.line.map((place) => this.building.frame.toCrs(place).slice(0, 2));
    this.app.act({ 'split-parts': { line } });
  }

  erase() {
    this.line = this.line.slice(0, -1);
    this.draw();
    this.app.showOptions();
  }

  cancel() {
    const isAny = this.line.length > 0;
    this.leave();
    this.app.showOptions();
    return isAny;
  }

  options() {
    return [
      says(
        'Click the places of a line across the building. Corners of the footprint draw it to them. 6 looks from straight above.',
      ),
      element(
        'div',
        { class: 'does' },
        button('Split', 'Enter', 'The building has two parts, on either side of the line', () => this.confirm(), {
          isMain: true,
          disabled: this.line.length < 2,
        }),
        button('Take back', 'Del', 'Takes the last place back', () => this.erase(), {
          disabled: this.line.length === 0,
        }),
      ),
    ];
  }
}

export class Merge extends Tool {
  constructor(app) {
    super(app);
    this.gap = 0.5;
  }

  confirm() {
    if (this.gap > 0) {
      this.app.act({ 'merge-parts': { gap: this.gap } });
    }
  }

  options() {
    return [
      says('Parts of the footprint that are close to each other become one.'),
      numberField('gaps up to', this.gap, 'm', (gap) => (this.gap = gap), { id: 'merge-gap', min: 0 }),
      element(
        'div',
        { class: 'does' },
        button('Merge', 'Enter', 'Gaps up to this wide are closed', () => this.confirm(), { isMain: true }),
      ),
    ];
  }
}

/** λ is chosen in even steps of its logarithm; the left end of the slider is 0. */
const [LEAST, MOST, STEPS] = [0.005, 5, 120];
const lambdaAt = (step) => (step === 0 ? 0 : LEAST * (MOST / LEAST) ** ((step - 1) / (STEPS - 1)));
const stepAt = (lambda) =>
  lambda < LEAST / 2 ? 0 : Math.round((Math.log(lambda / LEAST) / Math.log(MOST / LEAST)) * (STEPS - 1)) + 1;
const rounded = (value) => Number(value.toPrecision(2));

export class Weights extends Tool {
  slider({ id, name, title, value, max, step, at, shown, key }) {
    const output = element('output', {}, shown(value));
    const input = element('input', {
      type: 'range',
      id,
      min: 0,
      max,
      step,
      value: at(value),
      title,
      oninput: () => refill(output, shown(key.of(input.valueAsNumber))),
      onchange: () => this.app.act({ 'set-parameters': { [key.name]: key.of(input.valueAsNumber) } }),
    });
    return element('label', { class: 'row slider', title }, element('span', {}, name), input, output);
  }

  /** What the parameters are of all buildings. */
  get reset() {
    const { lambda, minimum_feature: feature } = this.building.head.defaults;
    return { lambda, 'minimum-feature': feature };
  }

  erase() {
    this.app.act({ 'set-parameters': this.reset });
  }

  options() {
    if (!this.building) {
      return [];
    }
    const { reset } = this;
    const { head } = this.building;
    return [
      this.slider({
        id: 'lambda',
        name: 'λ',
        title: 'The weight of a small surface against the probabilities of the cells: more is simpler',
        value: head.lambda,
        max: STEPS,
        step: 1,
        at: stepAt,
        shown: (value) => decimal(value, 3),
        key: { name: 'lambda', of: (step) => rounded(lambdaAt(step)) },
      }),
      this.slider({
        id: 'feature',
        name: 'smallest feature',
        title: 'Spikes, slots and steps thinner than this are removed',
        value: head.minimum_feature,
        max: 2,
        step: 0.05,
        at: (value) => value,
        shown: (value) => `${decimal(value, 2)} m`,
        key: { name: 'minimum-feature', of: (value) => value },
      }),
      element(
        'div',
        { class: 'does' },
        button(
          'As in the run',
          'Del',
          `λ ${decimal(reset.lambda, 3)} and ${decimal(reset['minimum-feature'], 2)} m, as for all buildings`,
          () => this.erase(),
          { disabled: head.lambda === reset.lambda && head.minimum_feature === reset['minimum-feature'] },
        ),
      ),
    ];
  }
}
