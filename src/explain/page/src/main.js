// The page of the steps: unpacks the building, and shows what each step made of it.

import { Camera } from '../../../view/page/src/camera.js';
import { showCompass } from '../../../view/page/src/compass.js';
import { byId, element, refill, showFailure } from '../../../view/page/src/dom.js';
import { fillHelp, listen } from '../../../view/page/src/keys.js';
import { unpack } from '../../../view/page/src/payload.js';
import { showRuler } from '../../../view/page/src/ruler.js';
import { Store } from '../../../view/page/src/store.js';
import { makeTheme } from '../../../view/page/src/theme.js';
import { Building } from './building.js';
import { Picture } from './picture.js';
import { showStep } from './side.js';
import { CHOICES, STEPS } from './steps.js';

const HELP = [
  ['drag', 'turn'],
  ['right drag, two fingers', 'move'],
  ['wheel, pinch', 'come nearer, towards the pointer'],
  ['point at something', 'what is known of a plane, a cell or a face'],
  ['N   B', 'next, previous step'],
  ['1 – 9', 'a step by its number'],
  ['arrow keys', 'move; with Shift turn'],
  ['+  −', 'nearer, farther'],
  ['F   O', 'show all; from above'],
  ['D   M', 'dark or light; panel'],
];

/** What is shown: the step, its choices, the theme. */
class State extends Store {
  constructor() {
    super();
    this.step = STEPS[0];
    this.choices = Object.fromEntries(Object.entries(CHOICES).map(([name, { initial }]) => [name, initial]));
    this.theme = 'light';
  }
}

/**
 * What the address asks for behind its `#`: `step` (its key or its number), `theme`, `side`, the choices, and `plain`: nothing
 * but the picture.
 */
function read(reached) {
  const asked = new URLSearchParams(window.location.hash.slice(1));
  const wanted = asked.get('step');
  const step = STEPS.find(({ key }, i) => key === wanted || String(i + 1) === wanted);
  const choices = {};
  for (const [name, { initial, isShare }] of Object.entries(CHOICES)) {
    const own = asked.get(name);
    const share = Number(own);
    choices[name] =
      own === null ? initial : isShare ? (share >= 0 && share <= 1 ? share : initial) : own === 'on' || own === '1';
  }
  return {
    step: step && reached.has(step.key) ? step : STEPS[0],
    choices,
    theme: ['dark', 'light'].includes(asked.get('theme')) ? asked.get('theme') : null,
    isSideClosed: asked.get('side') === 'closed',
    isPlain: asked.get('plain') === 'on',
  };
}

/** The address of what is shown; what is as it is anyway is left out. */
function write(state, theme) {
  const parts = new URLSearchParams();
  if (state.step !== STEPS[0]) {
    parts.set('step', state.step.key);
  }
  for (const name of state.step.controls) {
    const { initial, isShare } = CHOICES[name];
    if (state.choices[name] !== initial) {
      parts.set(name, isShare ? String(state.choices[name]) : state.choices[name] ? 'on' : 'off');
    }
  }
  if (theme.chosen()) {
    parts.set('theme', theme.chosen());
  }
  if (document.body.classList.contains('closed')) {
    parts.set('side', 'closed');
  }
  if (document.body.classList.contains('plain')) {
    parts.set('plain', 'on');
  }
  const place = window.location.href.replace(/#.*$/s, '');
  try {
    window.history.replaceState(null, '', parts.size === 0 ? place : `${place}#${parts}`);
  } catch {
    // The page of a notebook's cell has no address.
  }
}

async function start() {
  const building = new Building(await unpack(byId('payload').textContent));
  const { head } = building;
  const reached = new Set(head.steps.filter((step) => step.is_reached).map(({ key }) => key));
  const state = new State();
  const asked = read(reached);
  Object.assign(state, { step: asked.step, choices: asked.choices });
  const canvas = byId('canvas');
  const picture = new Picture(canvas, building);
  const theme = makeTheme(state, byId('theme'), asked.theme);
  picture.setTheme(state.theme);
  const camera = new Camera(picture, canvas);

  refill(byId('title'), head.id);
  refill(byId('subtitle'), `How it was made · ${head.crs} · gable ${head.gable}`);
  byId('failure').hidden = head.failure === null;
  refill(byId('failure'), head.failure ? `Not a model in LoD 2.2: ${head.failure}` : '');
  const items = STEPS.map((step, i) =>
    element(
      'button',
      {
        type: 'button',
        'data-step': step.key,
        disabled: !reached.has(step.key),
        title: reached.has(step.key) ? step.title : 'The method did not get so far',
        onclick: () => state.set({ step }),
      },
      element('i', { 'aria-hidden': 'true' }, String(i + 1)),
      step.name,
    ),
  );
  refill(
    byId('steps'),
    items.map((button) => element('li', {}, button)),
  );
  fillHelp(byId('keys'), HELP, []);

  const choose = (name, value) => state.set({ choices: { ...state.choices, [name]: value } });
  const draw = () => {
    picture.clear();
    state.step.draw(picture, building, state.choices);
    camera.refit();
  };
  const present = STEPS.filter(({ key }) => reached.has(key));
  const by = (count) => {
    const next = present[present.indexOf(state.step) + count];
    if (next) {
      state.set({ step: next });
    }
  };
  const show = () => {
    items.forEach((button) => {
      const isNow = button.dataset.step === state.step.key;
      button.toggleAttribute('aria-current', isNow);
      if (isNow) {
        button.setAttribute('aria-current', 'step');
        button.scrollIntoView({ block: 'nearest', inline: 'nearest' });
      }
    });
    const at = present.indexOf(state.step);
    byId('previous').disabled = at === 0;
    byId('next').disabled = at === present.length - 1;
    refill(byId('now'), `${STEPS.indexOf(state.step) + 1}. ${state.step.title}`);
    showStep(byId('step'), building, state, choose);
  };
  let last = state.choices;
  const update = (changed) => {
    if (changed.has('theme')) {
      picture.setTheme(state.theme);
    }
    if (changed.has('step')) {
      show();
      draw();
    } else if (changed.has('choices')) {
      // Cells that only move need not be made anew.
      const others = Object.keys(state.choices).filter(
        (name) => name !== 'apart' && state.choices[name] !== last[name],
      );
      if (others.length === 0) {
        picture.moveApart(state.choices.apart);
        camera.refit();
      } else {
        draw();
      }
    }
    last = state.choices;
    write(state, theme);
  };

  const closeSide = (isClosed) => {
    document.body.classList.toggle('closed', isClosed);
    byId('menu').setAttribute('aria-expanded', String(!isClosed));
  };
  const toggleSide = () => {
    closeSide(!document.body.classList.contains('closed'));
    write(state, theme);
  };
  const actions = {
    f: () => camera.fit(false, 550),
    o: () => camera.fit(true, 550),
    d: theme.toggle,
    m: toggleSide,
    n: () => by(1),
    b: () => by(-1),
    '?': () => byId('keys').showModal(),
    '+': () => camera.zoom(0.8),
    '=': () => camera.zoom(0.8),
    '-': () => camera.zoom(1.25),
    ArrowLeft: () => camera.pan(-0.06, 0),
    ArrowRight: () => camera.pan(0.06, 0),
    ArrowUp: () => camera.pan(0, 0.06),
    ArrowDown: () => camera.pan(0, -0.06),
    'Shift+ArrowLeft': () => camera.turn(-0.12, 0),
    'Shift+ArrowRight': () => camera.turn(0.12, 0),
    'Shift+ArrowUp': () => camera.turn(0, -0.1),
    'Shift+ArrowDown': () => camera.turn(0, 0.1),
  };
  STEPS.forEach((step, i) => (actions[String(i + 1)] = () => reached.has(step.key) && state.set({ step })));
  listen(actions);
  const press = { fit: 'f', above: 'o', help: '?', previous: 'b', next: 'n', menu: 'm' };
  Object.entries(press).forEach(([id, key]) => byId(id).addEventListener('click', () => actions[key]()));

  const tip = byId('tip');
  canvas.addEventListener('pointerleave', () => (tip.hidden = true));
  canvas.addEventListener('pointermove', (event) => {
    const told = event.buttons === 0 && event.pointerType === 'mouse' ? picture.at(event.clientX, event.clientY) : null;
    tip.hidden = told === null;
    if (told) {
      refill(tip, told[0], element('span', {}, told[1]));
      const box = canvas.getBoundingClientRect();
      const x = Math.min(event.clientX - box.left + 14, box.width - tip.offsetWidth - 8);
      const y = Math.min(event.clientY - box.top + 16, box.height - tip.offsetHeight - 8);
      tip.style.transform = `translate(${Math.round(x)}px, ${Math.round(y)}px)`;
    }
  });
  window.addEventListener('hashchange', () => {
    const wanted = read(reached);
    closeSide(wanted.isSideClosed);
    document.body.classList.toggle('plain', wanted.isPlain);
    theme.choose(wanted.theme);
    state.set({ step: wanted.step, choices: wanted.choices });
  });

  closeSide(asked.isSideClosed);
  document.body.classList.toggle('plain', asked.isPlain);
  const resize = () => {
    picture.resize(canvas.clientWidth, canvas.clientHeight);
    camera.refit();
  };
  resize();
  camera.fit();
  show();
  draw();
  state.listen(update);
  new ResizeObserver(resize).observe(canvas);
  showRuler(picture, camera, byId('scale'));
  showCompass(picture, camera, byId('compass'));
  requestAnimationFrame(() => {
    byId('loading').hidden = true;
    // For the console and for tests: what is shown, and how to ask for more.
    window.gable = { building, state, picture, camera, steps: STEPS };
    document.documentElement.dataset.ready = 'true';
  });
}

start().catch((error) => showFailure(error, 'building'));
