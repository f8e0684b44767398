// The page of editing: the list of buildings, one of them in 3D, and the tools to mend it.

import { showCompass } from '../../../view/page/src/compass.js';
import { byId, element, refill, showFailure } from '../../../view/page/src/dom.js';
import { showRuler } from '../../../view/page/src/ruler.js';
import { makeTheme } from '../../../view/page/src/theme.js';
import { api } from './api.js';
import { CHOSEN } from './colours.js';
import { showIntro } from './intro.js';
import { fillKeys, listenToKeys } from './keyboard.js';
import { drawLayers } from './layers.js';
import { List } from './list.js';
import { cutsOf, profileOf } from './look.js';
import { Messages } from './messages.js';
import { Panel } from './panel.js';
import { Picture } from './picture.js';
import { Places } from './places.js';
import { Session } from './session.js';
import { makeShow } from './show.js';
import { State } from './state.js';
import { SIDES, Station } from './station.js';
import { Toolbox } from './toolbox.js';
import { placesOf } from './where.js';

/** What the address asks for behind its `#`: a building and a theme. */
function asked() {
  const parts = new URLSearchParams(window.location.hash.slice(1));
  const theme = parts.get('theme');
  return { id: parts.get('id'), theme: ['dark', 'light'].includes(theme) ? theme : null };
}

function write(state, theme) {
  const parts = new URLSearchParams();
  if (state.id) {
    parts.set('id', state.id);
  }
  if (theme.chosen()) {
    parts.set('theme', theme.chosen());
  }
  window.history.replaceState(null, '', parts.size === 0 ? window.location.pathname : `#${parts}`);
}

function showModel(model) {
  refill(byId('title'), model.name);
  refill(byId('subtitle'), [model.crs, `gable ${model.gable ?? model.version}`].join(' · '));
  byId('subtitle').title = model.edits_file ? `Decisions: ${model.edits_file}` : '';
}

const VIEWS = [
  ['top', 'T', '6', 'Straight from above'],
  ['north', 'N', '7', 'Straight from the north'],
  ['east', 'E', '8', 'Straight from the east'],
  ['south', 'S', '9', 'Straight from the south'],
  ['west', 'W', '0', 'Straight from the west'],
];

async function start() {
  const state = new State();
  const wanted = asked();
  const theme = makeTheme(state, byId('theme'), wanted.theme);
  const messages = new Messages({ stack: byId('messages'), told: byId('told'), busy: byId('busy') });
  const model = await api.model();
  showModel(model);
  const canvas = byId('canvas');
  const picture = new Picture(canvas);
  picture.setTheme(state.theme);
  const station = new Station(picture, canvas);
  const session = new Session(state, messages);

  // What the tools work with.
  const app = {
    state,
    picture,
    station,
    places: new Places(picture),
    picked: new Set(),
    act: (action) => session.act(action),
    tell: (text) => messages.tell(text),
    choose: (tool) => choose(tool),
    showOptions: () => panel.showTool(toolbox.tool),
    outlineAt: (ring) => toolbox.outlineAt(ring),
  };
  const toolbox = new Toolbox(app, canvas, { tip: byId('tip'), hint: byId('hint'), outline: byId('reach') });
  const choose = (tool) => {
    toolbox.choose(tool);
    canvas.focus({ preventScroll: true });
    panel.showTool(toolbox.tool);
  };
  const open = async (id) => {
    if (id && (await session.open(id))) {
      state.set({ section: null });
      station.take();
      document.body.classList.add('opened');
    }
  };
  const nodes = { text: 'text', states: 'states', reason: 'reason', order: 'order', count: 'count', list: 'list' };
  const list = new List(state, Object.fromEntries(Object.entries(nodes).map(([name, id]) => [name, byId(id)])), open);
  const beside = (by) => {
    const id = list.beside(by);
    return id === null ? messages.tell(by > 0 ? 'The list ends here.' : 'The list begins here.') : open(id);
  };
  const panel = new Panel(
    state,
    {
      work: byId('work'),
      id: byId('id'),
      why: byId('why'),
      failure: byId('failure'),
      states: byId('decisions'),
      figures: byId('figures-section'),
      tools: byId('tools'),
      options: byId('options'),
      edits: byId('edits'),
      undo: [byId('undo'), byId('undo-edit')],
      redo: [byId('redo'), byId('redo-edit')],
      clear: byId('clear'),
      took: byId('took'),
    },
    {
      state: (name) => session.decide(name),
      choose,
      point: (action) =>
        picture.drawPoints('edit-at', action ? placesOf(action, state.building) : [], () => CHOSEN, 10, {
          isHidden: true,
        }),
    },
  );
  const toggle = makeShow(state, {
    layers: byId('layers'),
    colourings: byId('colourings'),
    legendNode: byId('legend'),
    opacity: byId('opacity'),
    least: byId('least'),
  });

  const view = (name) => {
    station.lookFrom(SIDES[name]);
    canvas.focus({ preventScroll: true });
  };
  const parallel = () => station.setParallel(!station.isParallel);
  refill(
    byId('views'),
    VIEWS.map(([name, letter, press, title]) =>
      element(
        'button',
        {
          type: 'button',
          'data-view': name,
          title: `${title} (${press})`,
          'aria-label': title,
          onclick: () => view(name),
        },
        letter,
      ),
    ),
    element(
      'button',
      {
        type: 'button',
        id: 'parallel',
        title: 'Without perspective (.)',
        'aria-label': 'Without perspective',
        onclick: parallel,
      },
      '∥',
    ),
  );
  picture.beforeFrame.push(() => byId('parallel').setAttribute('aria-pressed', String(station.isParallel)));

  const draw = () => {
    const { building, section } = state;
    if (!building) {
      return;
    }
    drawLayers(picture, building, state);
    picture.setCuts(cutsOf(section));
    const profile =
      section && state.layers.result
        ? profileOf(building.faces, { normal: section.normal, offset: -section.at - 0.004 })
        : [];
    picture.drawLines('profile', profile, CHOSEN, { width: 2.5 });
  };
  let last = null;
  state.listen((changed) => {
    const any = (...names) => names.some((name) => changed.has(name));
    if (any('theme')) {
      picture.setTheme(state.theme);
    }
    if (any('building')) {
      const { building } = state;
      if (
        building &&
        (last?.centre !== building.centre ||
          last?.floor !== building.floor ||
          last?.head.revision !== building.head.revision)
      ) {
        picture.setBuilding(building);
        station.measure();
      }
      if (last?.head.id !== building?.head.id || last?.head.revision !== building?.head.revision) {
        draw();
        toolbox.anew();
      }
      last = building;
    } else if (any('layers', 'colouring', 'opacity', 'least', 'plane', 'section', 'theme')) {
      draw();
    }
    if (any('building', 'rows')) {
      panel.show();
    }
    if (any('building', 'tool', 'plane', 'layers', 'section')) {
      panel.showTool(toolbox.tool);
    }
    if (any('id', 'theme')) {
      refill(byId('now'), element('bdi', { dir: 'ltr' }, state.id ?? ''));
      byId('now').title = state.id ?? '';
      write(state, theme);
    }
  });

  const closeSide = () => {
    const isClosed = document.body.classList.toggle('closed');
    byId('menu').setAttribute('aria-expanded', String(!isClosed));
  };
  const actions = listenToKeys({
    app,
    session,
    toolbox,
    messages,
    beside,
    choose,
    view,
    parallel,
    toggle,
    closeSide,
    theme,
  });
  fillKeys(byId('keys'));
  const press = { fit: 'f', help: '?', previous: 'k', next: 'j', menu: 'm', undo: 'Ctrl+z', redo: 'Ctrl+Shift+z' };
  Object.assign(press, {
    'undo-edit': 'Ctrl+z',
    'redo-edit': 'Ctrl+Shift+z',
    clear: 'Ctrl+Shift+Backspace',
    export: 'Ctrl+s',
  });
  Object.entries(press).forEach(([id, key]) => byId(id).addEventListener('click', () => actions[key]()));
  const tabs = [
    ['Buildings', false],
    ['Building', true],
  ].map(([name, isWorking]) =>
    element('button', { type: 'button', 'aria-pressed': String(!isWorking), onclick: () => showTab(isWorking) }, name),
  );
  const showTab = (isWorking) => {
    document.body.classList.toggle('working', isWorking);
    tabs.forEach((tab, i) => tab.setAttribute('aria-pressed', String(isWorking === (i === 1))));
  };
  refill(byId('tabs'), tabs);
  window.addEventListener('hashchange', () => {
    const now = asked();
    theme.choose(now.theme);
    if (now.id && now.id !== state.id) {
      open(now.id);
    }
  });

  const resize = () => {
    picture.resize(canvas.clientWidth, canvas.clientHeight);
    station.refit();
  };
  resize();
  station.fit();
  new ResizeObserver(resize).observe(canvas);
  showRuler(picture, station, byId('scale'));
  showCompass(picture, station, byId('compass'));
  toolbox.choose('select');
  panel.showTool(toolbox.tool);
  (model.notes ?? []).forEach((note) => messages.note(note));
  state.set({ rows: model.buildings });
  byId('loading').hidden = true;
  await open(model.buildings.some(({ id }) => id === wanted.id) ? wanted.id : list.shown[0]?.id);
  if (model.buildings.every(({ state: name, edits }) => name === 'open' && edits === 0)) {
    showIntro(byId('intro'), () => canvas.focus({ preventScroll: true }));
  }
  // For the console and for tests: what is shown, and how to ask for more.
  window.gable = { model, state, session, picture, station, places: app.places, toolbox, list, app };
  document.documentElement.dataset.ready = 'true';
}

start().catch((error) => showFailure(error, 'model'));
