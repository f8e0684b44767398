// The page: unpacks the model, and ties what is shown to what is chosen.

import { keepInStep, read } from './address.js';
import { Camera } from './camera.js';
import { rangeOf, valueOf, valueText } from './colouring.js';
import { colourings } from './colourings.js';
import { showCompass } from './compass.js';
import { makeColourings, makeLods, makePoints, pointColours } from './controls.js';
import { byId, element, refill, showFailure } from './dom.js';
import { FaultList } from './faults.js';
import { fillHelp, listen } from './keys.js';
import { showLegend } from './legend.js';
import { Model } from './model.js';
import { GHOST, NOTHING } from './palette.js';
import { Panel } from './panel.js';
import { unpack } from './payload.js';
import { Pointer } from './pointer.js';
import { View } from './scene.js';
import { makeSearch } from './search.js';
import { State } from './state.js';
import { showRuler } from './ruler.js';
import { showSummary } from './summary.js';
import { makeTheme } from './theme.js';

/** Steps of a ramp: more than can be told apart. */
const STEPS = 128;

/** The colours of a colouring, and of each face the index of its own. */
function paintOf(model, state) {
  const { colouring, lod } = state;
  const ghost = GHOST[state.theme];
  const isRamp = colouring.kind === 'ramp';
  const own = isRamp
    ? Array.from({ length: STEPS }, (_, i) => colouring.ramp(i / (STEPS - 1)))
    : colouring.categories.map(({ colour }) => colour);
  const [nothing, out] = [own.length, own.length + 1];
  const [low, high] = rangeOf(state);
  const indexOf = (value) => {
    if (!isRamp) {
      return value >= 0 ? value : nothing;
    }
    return Number.isFinite(value)
      ? Math.round(Math.min(Math.max((value - low) / (high - low), 0), 1) * (STEPS - 1))
      : nothing;
  };
  const isOut = model.features.map((_, f) => !state.isIn(f));
  // A building is of one colour at one level of detail.
  const known = new Map();
  const ofFeature = (f, faceLod) => {
    const key = f * 256 + faceLod;
    if (!known.has(key)) {
      known.set(key, indexOf(colouring.of(model.features[f], faceLod, f)));
    }
    return known.get(key);
  };
  const of = (face) => {
    const f = model.faceFeature[face];
    if (isOut[f]) {
      return out;
    }
    return colouring.scope === 'face' ? indexOf(colouring.of(face)) : ofFeature(f, model.faceLod[face]);
  };
  return { colours: [...own, NOTHING, ghost], of, lod };
}

/** Says something for a while; nothing takes it away. */
function tell(text) {
  const node = byId('told');
  refill(node, text);
  node.hidden = text === '';
  if (text !== '') {
    setTimeout(() => node.textContent === text && (node.hidden = true), 8000);
  }
}

async function start() {
  const started = performance.now();
  const model = new Model(await unpack(byId('payload').textContent));
  const state = new State();
  const canvas = byId('canvas');
  const all = colourings(model);
  const asked = read(model, all);
  state.set(asked.changes);
  const view = new View(canvas, model);
  const theme = makeTheme(state, byId('theme'), asked.theme);
  const camera = new Camera(view, canvas);

  const select = (f, face = -1) => state.set({ selection: f < 0 ? null : { feature: f, face } });
  // On narrow screens the panel is no cover: it takes the place of the side panel.
  const covered = () => (getComputedStyle(byId('panel')).position === 'absolute' ? byId('panel').offsetWidth : 0);
  const flyTo = (f, milliseconds) => {
    camera.keepFree(covered());
    camera.lookAt([f], milliseconds);
  };
  const go = (f, face = -1) => {
    select(f, face);
    flyTo(f);
  };
  const panel = new Panel(model, state, byId('panel'), { flyTo, close: () => select(-1) });
  showSummary(model, state, {
    title: byId('title'),
    subtitle: byId('subtitle'),
    summary: byId('summary'),
    run: byId('run'),
    runSection: byId('run-section'),
  });
  makeColourings(model, state, all, {
    node: byId('colourings'),
    select: byId('attribute'),
    row: byId('attribute-row'),
    reason: byId('reason'),
  });
  const lods = makeLods(model, state, byId('lods'), byId('lod-note'));
  makePoints(model, state, byId('points-controls'));
  const faults = new FaultList(model, byId('faults'), go);
  if (faults.isUrgent) {
    const section = byId('faults-section');
    section.classList.add('urgent');
    byId('summary-section').after(section);
  }
  makeSearch(model, byId('search'), byId('found'), go);
  fillHelp(byId('keys'));

  const paint = () => {
    const { colours, of } = paintOf(model, state);
    view.paint(colours, of);
  };
  const mark = () => {
    const { selection, lod } = state;
    const feature = selection && model.features[selection.feature];
    const runs = feature
      ? model.runs.slice(feature.firstRun, feature.endRun).filter((run) => model.isShown(run, lod))
      : [];
    const isFaceShown = selection && runs.some((run) => run.start <= selection.face && selection.face < run.end);
    view.mark(runs, isFaceShown ? selection.face : -1);
    panel.show();
    document.body.classList.toggle('selected', Boolean(feature));
    if (!feature) {
      camera.keepFree(0);
    }
    refill(byId('announce'), feature ? `${feature.kind} ${feature.id} selected` : '');
  };
  const update = (changed) => {
    const any = (...names) => names.some((name) => changed.has(name));
    if (any('theme')) {
      view.setTheme(state.theme);
    }
    if (any('lod', 'filter')) {
      view.show(state.lod, (f) => state.isIn(f));
    }
    if (any('lod', 'filter', 'colouring', 'range', 'theme')) {
      paint();
    }
    if (any('lod', 'filter', 'colouring', 'range')) {
      showLegend(model, state, byId('legend'));
    }
    if (any('selection', 'lod')) {
      mark();
    }
    if (any('arePointsShown', 'pointColouring')) {
      view.points.visible = state.arePointsShown;
      view.paintPoints(pointColours(model, state.pointColouring));
    }
  };
  update(new Set(['theme', 'lod', 'filter', 'colouring', 'selection', 'arePointsShown']));
  state.listen(update);

  const pointer = new Pointer(canvas, view, model, state);
  const tip = byId('tip');
  pointer.listen({
    click: (hit, x) => {
      select(hit ? hit.feature : -1, hit ? hit.face : -1);
      if (hit) {
        camera.reveal(hit.feature, covered(), x);
      }
    },
    doubleClick: (hit) => hit && go(hit.feature, hit.face),
    hover: (hit, event) => {
      canvas.classList.toggle('over', hit !== null);
      tip.hidden = hit === null;
      if (hit) {
        const value =
          state.colouring.scope === 'face' && state.colouring.kind === 'categories' && !state.colouring.ofFeature
            ? (state.colouring.categories[state.colouring.of(hit.face)]?.name ?? state.colouring.nothing)
            : `${state.colouring.name}: ${valueText(state.colouring, model, hit.feature, state.lod) || '–'}`;
        refill(tip, model.features[hit.feature].id, element('span', {}, value));
        const box = canvas.getBoundingClientRect();
        const x = Math.min(event.clientX - box.left + 14, box.width - tip.offsetWidth - 8);
        const y = Math.min(event.clientY - box.top + 16, box.height - tip.offsetHeight - 8);
        tip.style.transform = `translate(${Math.round(x)}px, ${Math.round(y)}px)`;
      }
    },
  });

  const closeSide = (isClosed) => {
    document.body.classList.toggle('closed', isClosed);
    byId('menu').setAttribute('aria-expanded', String(!isClosed));
  };
  const toggleSide = () => {
    closeSide(!document.body.classList.contains('closed'));
    follow();
  };
  const actions = {
    f: () => camera.fit(false, 550),
    o: () => camera.fit(true, 550),
    d: theme.toggle,
    m: toggleSide,
    l: () => state.set({ lod: lods[(lods.indexOf(state.lod) + 1) % lods.length] }),
    p: () => model.classes.length > 0 && state.set({ arePointsShown: !state.arePointsShown }),
    n: () => faults.step(1),
    b: () => faults.step(-1),
    '/': () => byId('search').focus(),
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
    Escape: () => state.set(state.selection ? { selection: null } : { filter: null }),
  };
  all.forEach((colouring, i) => (actions[String(i + 1)] = () => colouring.reason === null && state.set({ colouring })));
  listen(actions);
  byId('fit').addEventListener('click', actions.f);
  byId('above').addEventListener('click', actions.o);
  byId('menu').addEventListener('click', toggleSide);
  byId('help').addEventListener('click', actions['?']);

  const show = ({ feature, unknown }, milliseconds) => {
    select(feature);
    if (feature >= 0) {
      flyTo(feature, milliseconds);
    }
    tell(unknown === null ? '' : `No building of this model has the id ${unknown}`);
  };
  const follow = keepInStep(model, state, all, theme, (wanted) => {
    state.set(wanted.changes);
    theme.choose(wanted.theme);
    closeSide(wanted.isSideClosed);
    show(wanted);
  });
  closeSide(asked.isSideClosed);
  const resize = () => {
    view.resize(canvas.clientWidth, canvas.clientHeight);
    camera.refit();
  };
  resize();
  camera.fit();
  show(asked, 0);
  new ResizeObserver(resize).observe(canvas);
  showRuler(view, camera, byId('scale'));
  showCompass(view, camera, byId('compass'));
  requestAnimationFrame(() => {
    byId('loading').hidden = true;
    // For the console and for tests: what is shown, and how to ask for more.
    window.gable = {
      faults,
      model,
      state,
      view,
      camera,
      pointer,
      colourings: all,
      valueOf,
      loadMilliseconds: performance.now() - started,
    };
    document.documentElement.dataset.ready = 'true';
  });
}

start().catch((error) => showFailure(error, 'model'));
