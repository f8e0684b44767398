// A plane through three places: of points, or of the model.

import { element } from '../../../view/page/src/dom.js';
import { counted, decimal } from '../../../view/page/src/format.js';
import { CHOSEN } from './colours.js';
import { fitted, hullOf, lieOf } from './planes.js';
import { Tool, button, says } from './tool.js';

export class Triple extends Tool {
  constructor(app) {
    super(app);
    this.places = [];
    this.isUnseen = false;
  }

  leave() {
    this.places = [];
    this.draw();
  }

  click(event) {
    const place = this.app.places.placeAt(this.building, event.clientX, event.clientY);
    if (place) {
      this.places = [...this.places, place];
      this.draw();
      this.app.showOptions();
    }
  }

  draw() {
    const { picture } = this.app;
    this.plane = fitted(this.places);
    picture.drawPoints('corners', this.places, () => CHOSEN, 9, { isHidden: true });
    picture.drawRing('triple', this.plane ? hullOf(this.plane, this.places) : [], CHOSEN);
  }

  confirm() {
    if (!this.plane) {
      this.app.tell('Click at least three places that are not in one line.');
      return;
    }
    const places = this.places.map((place) => this.building.frame.toCrs(place));
    const action = this.isUnseen ? { places, unseen: true } : { places };
    this.app.act({ 'add-plane': action }).then((isDone) => isDone && this.cancel());
  }

  erase() {
    this.places = this.places.slice(0, -1);
    this.draw();
    this.app.showOptions();
  }

  cancel() {
    const isAny = this.places.length > 0;
    this.leave();
    this.app.showOptions();
    return isAny;
  }

  hover() {
    return this.places.length < 3 ? [`place ${this.places.length + 1} of 3`] : ['one more place', 'or Enter'];
  }

  options() {
    const box = element('input', {
      type: 'checkbox',
      id: 'unseen',
      checked: this.isUnseen,
      onchange: () => (this.isUnseen = box.checked),
    });
    return [
      says(
        this.plane
          ? `${counted(this.places.length, 'place')}; the plane lies at ${decimal(lieOf(this.plane).slope, 1)}°.`
          : 'Click three places or more, best the corners of the plane: points, faces, or the floor.',
      ),
      element(
        'label',
        { class: 'row', title: 'Without it at least three points must lie on the plane' },
        box,
        'it is there though nobody scanned it',
      ),
      element(
        'div',
        { class: 'does' },
        button('Add plane', 'Enter', 'A plane through the places', () => this.confirm(), {
          isMain: true,
          disabled: !this.plane,
        }),
        button('Take back', 'Del', 'Takes the last place back', () => this.erase(), {
          disabled: this.places.length === 0,
        }),
      ),
    ];
  }
}
