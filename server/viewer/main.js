// SPDX-License-Identifier: MIT
// The page: what follows from what. The parts know nothing of each other; here they meet.
import * as api from './api.js';
import { readAddress, writeAddress } from './address.js';
import { drawDiagonals, drawHistogram, drawScale } from './charts.js';
import { fetchDrape, fetchRequest, spacingOf } from './drape.js';
import { fieldOf, fields, format, isShear, ofNodes, rangeOf, scaleOf, valuesOf, withUnit } from './fields.js';
import { Form } from './form.js';
import { nodeAt, NO_VALUE } from './lattice.js';
import { curlCommand, saveAs, showDownloads } from './links.js';
import { Drapes } from './list.js';
import { REASON_TEXT } from './marks.js';
import { cellAt, cornersOf, placeOf, reasonAt, showReadout, showSummary } from './readout.js';
import { View } from './view.js';
import { readDifference, readRequest } from './work.js';

const EXAMPLES = [
  ['saddle', 'Saddle'],
  ['octant', 'Sphere octant, from the pole'],
  ['hemisphere', 'Hemisphere, with permeability'],
  ['sphere', 'Spherical patch'],
  ['torus', 'Quarter torus'],
  ['freeform', 'Free-form part'],
  ['tray', 'Tray, a triangle mesh'],
];
const LIVE_CELLS = 12000; // a drape this large answers while one drags
const LIVE_SECONDS = 20;
const RETRY = 'Check the address, or drape again.';

const element = (id) => document.getElementById(id);
const say = (text) => (element('state').textContent = text);

const page = {
  field: fields[0],
  layout: 'both',
  one: null, // {id, lattice, summary, spacing}
  two: null,
  pinned: null, // [i, j]
  hovered: null,
  example: 'saddle',
  busy: null, // AbortController of the drape that runs
};

/* ---- errors ---- */

function report(error) {
  if (error.name === 'AbortError') return;
  if (error instanceof api.Problem && error.status === 401) askToken();
  if (error instanceof api.Problem) form.showErrors(error);
  else form.showErrors({ message: error.message });
}

function reportQuietly(error) {
  element('message').textContent = error.message;
  if (error.status === 401) askToken();
}

/* ---- the request ---- */

const form = new Form({
  onLive: () => live(false),
  onSettled: () => {
    save();
    live(true);
  },
  onUnit: () => page.one && refreshNumbers(),
});

/** Puts a request into the form and its surface into the picture; forgets the drape that was shown. */
function takeRequest(request) {
  form.load(request);
  if (request.fault) form.surfaceError(request.fault);
  element('about').textContent = request.shape ? request.shape.about : '';
  clear();
  view.setShape(request.shape);
  const ready = 'Press Drape. Click on the surface to choose where the net starts.';
  hint(request.shape ? ready : 'This surface cannot be shown. Press Drape: the service says what is wrong with it.', true);
  refreshCurl();
}

function clear() {
  page.one = page.two = page.pinned = page.hovered = null;
  for (const slot of ['one', 'two', 'difference']) view.setNet(slot, null);
  view.setHandle(-1);
  element('downloads').replaceChildren();
  refresh();
  for (const id of ['cell-i', 'cell-j']) element(id).value = '';
}

function hint(text, low = false) {
  if (!view.stage) return;
  element('hint').textContent = text;
  element('hint').classList.toggle('low', low);
}

async function takeExample(name) {
  page.example = name;
  element('example').value = name;
  const response = await fetch(new URL(`./${name}.json`, import.meta.url));
  if (!response.ok) throw new api.Unreachable();
  takeRequest(await readRequest(await response.text()));
  save();
}

/** The service's limits, asked once; a file that is too large is not even read. */
async function takeFile(file) {
  form.clearErrors();
  page.limits ||= await api.read('v1/limits');
  const { max_body: most } = page.limits;
  const size = (bytes) => `${(bytes / 1e6).toFixed(0)} MB`;
  if (file.size > most) {
    form.surfaceError(
      `${file.name} has ${size(file.size)}; this service takes ${size(most)}. Export a coarser surface, or start draped with a larger --max-body.`,
    );
    return;
  }
  say(`Reading ${file.name} …`);
  try {
    takeRequest(await readRequest(await file.text()));
    page.example = '';
    element('example').value = '';
    element('about').textContent = `${file.name}: ${element('about').textContent}`;
    say('');
    save();
  } catch (error) {
    say('');
    form.surfaceError(`${file.name}: ${error.message}`);
  }
}

function refreshCurl() {
  element('curl').textContent = form.surfaceText ? curlCommand(form.body()) : '';
}

/* ---- draping ---- */

function setBusy(controller) {
  page.busy = controller;
  element('drape').disabled = Boolean(controller);
  element('cancel').disabled = !controller;
  if (!controller) element('progress').value = 0;
}

function showProgress(status) {
  if (!status) {
    say('The service does not answer; trying again …');
    return;
  }
  element('progress').value = status.progress;
  const part = status.status === 'running' ? ` ${Math.round(100 * status.progress)} %` : '';
  say(`${status.status}${part}${status.attempts > 1 ? `, attempt ${status.attempts}` : ''}`);
}

/** Submits the form and follows the drape to its end. */
async function run() {
  const controller = new AbortController();
  form.clearErrors();
  refreshCurl();
  setBusy(controller);
  say('Sending …');
  try {
    const spacing = form.spacing;
    const { id } = await api.submit(form.body(), controller.signal);
    page.running = id;
    const last = await api.follow(id, showProgress, controller.signal);
    await finish(last, spacing, controller.signal);
  } catch (error) {
    say('');
    report(error);
  }
  page.running = null;
  setBusy(null);
  drapes.refresh(page.one?.id);
}

async function finish(last, spacing, signal) {
  if (last.status === 'failed') throw new api.Problem(last.error.status, last.error);
  if (last.status === 'cancelled') {
    say('Cancelled.');
    return;
  }
  say('Fetching the net …');
  showDrape({ ...(await fetchDrape(last.id, last, signal)), spacing });
}

async function cancelRun() {
  if (!page.running) return page.busy?.abort();
  element('cancel').disabled = true;
  try {
    await api.cancel(page.running);
  } catch (error) {
    report(error);
  }
}

/** Drapes what the form says while it changes: one call at a time, the last state always; the
 *  drapes on the way are deleted. */
async function live(settled) {
  page.wanted = { settled: settled || page.wanted?.settled };
  if (!page.one || page.busy || page.living) return;
  page.living = true;
  try {
    while (page.wanted) {
      const { settled: final } = page.wanted;
      page.wanted = null;
      await liveOnce(final);
    }
  } catch (error) {
    report(error);
  }
  page.wanted = null;
  page.living = false;
}

async function liveOnce(final) {
  form.clearErrors();
  const cells = page.cellsAtFull || page.one.lattice.cellOfNode.length;
  const coarser = final ? 1 : Math.max(1, Math.sqrt(cells / LIVE_CELLS));
  if (final && cells > 20 * LIVE_CELLS) return run();
  const begun = performance.now();
  const spacing = form.spacing.map((value) => value * coarser);
  const { id, columns } = await api.drapeNow(form.body(coarser), LIVE_SECONDS);
  if (!columns) throw new api.Problem(0, { detail: 'This takes too long to follow the pointer; press Drape.' });
  const { readNet } = await import('./work.js');
  const lattice = await readNet(columns);
  const before = page.liveId;
  page.liveId = final ? null : id;
  if (before) api.remove(before).catch(() => {});
  const summary = final ? (await api.status(id)).summary : page.one.summary;
  showDrape({ id: final ? id : page.one.id, lattice, summary, spacing }, !final);
  say(`${lattice.columns['cells.i'].length.toLocaleString('en')} cells in ${(performance.now() - begun).toFixed(0)} ms`);
  if (final) drapes.refresh(id);
}

/* ---- what is shown ---- */

/** Shows a drape; `passing` for one on the way, whose numbers are not kept. */
function showDrape(drape, passing = false) {
  page.one = drape;
  page.hovered = null;
  hint('');
  view.setNet('one', drape.lattice, drape.spacing);
  view.setHandle(nodeAt(drape.lattice.grid, 0, 0));
  if (!passing) page.cellsAtFull = drape.lattice.columns['cells.i'].length;
  refresh(passing);
  if (passing) return;
  const { cells, timing_ms: time } = drape.summary;
  say(`${cells.toLocaleString('en')} cells, solved in ${format(time.solve, 3)} ms`);
  refreshCurl();
  showDownloads(element('downloads'), drape.id, reportQuietly);
  if (page.two) compareFields();
  save();
}

/** Everything that depends on the drape, the field and the marked cell. */
function refresh(passing = false) {
  refreshFields();
  refreshColours();
  refreshNumbers();
  if (!passing) refreshCharts();
  view.mark('pinned', page.pinned, cellAt);
}

function refreshFields() {
  const columns = page.one?.lattice.columns;
  const given = columns ? fields.filter((field) => columns[field.column]) : fields.slice(0, 2);
  if (!given.includes(page.field)) page.field = given[0];
  element('field').replaceChildren(...given.map(({ key, label }) => new Option(label, key, false, key === page.field.key)));
}

function refreshColours() {
  const { field, one, two } = page;
  const map = field.signed ? 'diverging' : 'sequential';
  const sets = { one, two };
  const values = {};
  for (const [slot, drape] of Object.entries(sets)) values[slot] = drape && valuesOf(drape.lattice.columns, field);
  const ranges = Object.values(values).filter((set) => set?.length).map(rangeOf);
  const range = ranges.length ? [Math.min(...ranges.map(([low]) => low)), Math.max(...ranges.map(([, high]) => high))] : [0, 60];
  const scale = scaleOf(field, range);
  for (const slot of Object.keys(sets))
    if (values[slot]) view.setField(slot, values[slot], ofNodes(field), scale, map);
  const locking = form.locking;
  const marks = isShear(field) && locking !== null ? (field.signed ? [-locking, locking] : [locking]) : [];
  page.scale = { range: scale, map, unit: field.unit(form.unit), label: field.label, marks };
  drawScale(element('scale'), page.scale);
}

function refreshNumbers() {
  const { one } = page;
  showSummary(element('summary'), one?.summary, form.unit);
  const place = page.pinned || page.hovered?.place;
  const cell = one && place ? cellAt(one.lattice, ...place) : -1;
  const node = page.pinned ? page.pinnedNode : page.hovered?.node;
  const corners = cell >= 0 ? cornersOf(one.lattice, cell) : [];
  const nearest = corners.includes(node) ? node : corners[0];
  showReadout(element('readout'), {
    lattice: one?.lattice,
    cell: cell >= 0 ? cell : null,
    node: nearest,
    front: frontOfOne(),
    unit: form.unit,
    isUv: form.shape?.kind !== 'mesh',
  });
}

const frontOfOne = () => view.slots.one?.front || new Map();

function refreshCharts() {
  const { one, two } = page;
  for (const id of ['histogram', 'diagonals']) element(id).replaceChildren();
  if (!one) return;
  drawHistogram(element('histogram'), one.lattice.columns['cells.shear_deg'], form.locking);
  drawDiagonals(element('diagonals'), [one, two].filter(Boolean).map(({ lattice }) => lattice), form.unit, form.locking);
}

/* ---- cells ---- */

function hover(hit) {
  const drape = hit && (hit.slot === 'two' ? page.two : page.one);
  page.hovered = drape ? { ...hit, place: placeOf(drape.lattice, hit.cell) } : null;
  view.mark('hovered', page.hovered?.place || null, cellAt);
  const chip = element('chip');
  chip.hidden = !page.hovered;
  if (page.hovered) chip.textContent = chipText(drape, hit);
  if (!page.pinned) refreshNumbers();
}

function chipText({ lattice }, { slot, cell }) {
  const place = `cell (${placeOf(lattice, cell).join(', ')})`.replaceAll('-', '−');
  const front = view.slots[slot]?.front || new Map();
  const reason = reasonAt(lattice, front, cell);
  const stop = reason ? `, the net stops: ${REASON_TEXT[reason]}` : '';
  if (slot === 'difference') {
    const value = page.difference?.[cell];
    return `${place}: ${value < NO_VALUE ? withUnit(format(value), page.field.unit(form.unit)) : 'not covered by the other'}`;
  }
  const { field } = page;
  if (ofNodes(field)) return `${place}${stop}`;
  const value = field.of(lattice.columns[field.column][cell]);
  return `${place}: ${withUnit(format(value), field.unit(form.unit))}${stop}`;
}

function pin(place, node) {
  page.pinned = place;
  page.pinnedNode = node;
  const [i, j] = place || ['', ''];
  element('cell-i').value = i;
  element('cell-j').value = j;
  view.mark('pinned', place, cellAt);
  refreshNumbers();
  save();
}

function pinFromFields() {
  const numbers = ['cell-i', 'cell-j'].map((id) => element(id).value.trim());
  if (numbers.some((text) => !/^-?\d+$/.test(text))) return;
  page.pinned = numbers.map(Number);
  view.mark('pinned', page.pinned, cellAt);
  refreshNumbers();
  save();
}

/* ---- comparing ---- */

async function compareWith(id) {
  try {
    const [request, drape] = await Promise.all([fetchRequest(id), fetchDrape(id)]);
    page.two = { ...drape, spacing: spacingOf(request.settings), settings: request.settings };
    view.setNet('two', page.two.lattice, page.two.spacing);
    view.setNet('difference', page.one.lattice, page.one.spacing);
    const { method, direction } = request.settings;
    element('caption-other').textContent = `The other: ${method}, ${direction?.angle_deg ?? 'vector'}°`;
    element('compare-end').hidden = false;
    view.arrange('compare');
    refresh();
    await compareFields();
    save();
  } catch (error) {
    reportQuietly(error);
  }
}

/** Colours the difference of the field that is shown; of the shear where that is one of nodes. */
async function compareFields() {
  const { one, two } = page;
  if (!one || !two) return;
  const field = ofNodes(page.field) ? fields[0] : page.field;
  const [first, second] = [one, two].map(({ lattice }) => ({ centres: lattice.centres, values: valuesOf(lattice.columns, field) }));
  if (!first.values || !second.values) return;
  if (view.slots.difference?.lattice !== one.lattice) view.setNet('difference', one.lattice, one.spacing);
  const shift = two.lattice.origin.map((value, axis) => value - one.lattice.origin[axis]);
  const values = await readDifference({ one: first, two: second, shift, reach: Math.max(...one.spacing, ...two.spacing) });
  page.difference = values;
  const sizes = values.filter((value) => value < NO_VALUE).map(Math.abs).sort();
  const most = sizes[Math.floor(0.99 * sizes.length)] || 1e-9;
  const greatest = withUnit(format(sizes.at(-1) ?? 0, 3), field.unit(form.unit));
  element('caption-difference').textContent = `Difference, this − other; greatest ${greatest}`;
  view.setField('difference', values, false, [-most, most], 'diverging');
  view.mark('pinned', page.pinned, cellAt);
  const scale = { range: [-most, most], map: 'diverging', unit: field.unit(form.unit), label: `${field.label}, this − other` };
  drawScale(element('difference-scale'), scale);
}

function endComparison() {
  page.two = null;
  for (const slot of ['two', 'difference']) view.setNet(slot, null);
  element('compare-end').hidden = true;
  view.arrange(page.layout);
  refresh();
  save();
}

/* ---- the address ---- */

function save() {
  const shown = Object.entries(view.shown).filter(([, on]) => on).map(([name]) => name);
  writeAddress({
    drape: page.one?.id,
    compare: page.two?.id,
    example: page.example,
    ...form.main,
    field: page.field.key,
    view: page.layout,
    show: shown.join(',') || 'none',
    cell: page.pinned?.join(','),
    eye: view.eye,
  });
}

async function openDrape(id) {
  const request = await fetchRequest(id);
  takeRequest(request);
  hint('Fetching the net …', true);
  showDrape({ ...(await fetchDrape(id)), spacing: spacingOf(request.settings) });
  drapes.refresh(id);
}

function restoreChoices(state) {
  page.field = fieldOf(state.field);
  page.layout = ['solid', 'both', 'flat'].includes(state.view) ? state.view : 'both';
  document.querySelector(`[name="view"][value="${page.layout}"]`).checked = true;
  view.arrange(page.layout);
  if (state.show) {
    for (const name of Object.keys(view.shown)) {
      view.shown[name] = state.show.split(',').includes(name);
      element(`show-${name}`).checked = view.shown[name];
    }
    view.show(view.shown);
  }
}

function restoreCell(state) {
  const place = state.cell?.split(',').map(Number);
  if (place?.length === 2 && place.every(Number.isInteger)) pin(place);
  if (state.eye) view.eye = state.eye;
  save();
}

async function restore() {
  const state = readAddress();
  restoreChoices(state);
  try {
    if (state.drape && /^\w+$/.test(state.drape)) {
      page.example = EXAMPLES.some(([name]) => name === state.example) ? state.example : '';
      element('example').value = page.example;
      await openDrape(state.drape);
      if (state.compare && /^\w+$/.test(state.compare)) await compareWith(state.compare);
      restoreCell(state);
      return;
    }
  } catch (error) {
    if (!(error instanceof api.Problem) || ![404, 410].includes(error.status)) return report(error);
    await restoreExample(state);
    element('fault-general').textContent = `The drape of this link is gone: ${error.message}. ${RETRY}`;
    return;
  }
  await restoreExample(state);
  restoreCell(state);
}

async function restoreExample(state) {
  const known = EXAMPLES.some(([name]) => name === state.example);
  await takeExample(known ? state.example : 'saddle').catch(report);
  if (!known) return;
  const given = ['method', 'spacing', 'angle', 'start'].filter((key) => state[key] !== undefined);
  form.main = Object.fromEntries(given.map((key) => [key, state[key]]));
  refreshCurl();
}

/* ---- token and theme ---- */

function askToken() {
  element('token').value = api.token.get();
  if (!element('token-dialog').open) element('token-dialog').showModal();
}

function listenToken() {
  element('token-open').addEventListener('click', askToken);
  element('token-dialog').addEventListener('close', () => {
    if (element('token-dialog').returnValue !== 'ok') return;
    api.token.set(element('token').value.trim());
    element('message').textContent = '';
    form.clearErrors();
    restore();
    drapes.refresh();
  });
}

function setTheme(theme) {
  document.documentElement.dataset.theme = theme;
  localStorage.setItem('draped-theme', theme);
  element('theme').textContent = theme === 'dark' ? 'Light' : 'Dark';
  view.retint();
}

function startTheme() {
  const kept = localStorage.getItem('draped-theme');
  const dark = matchMedia('(prefers-color-scheme: dark)');
  setTheme(kept || (dark.matches ? 'dark' : 'light'));
  if (!kept) localStorage.removeItem('draped-theme');
  element('theme').addEventListener('click', () =>
    setTheme(document.documentElement.dataset.theme === 'dark' ? 'light' : 'dark'),
  );
}

/* ---- the parts, and who listens to whom ---- */

const view = new View({
  onHover: hover,
  onPick: (hit) => {
    if (!hit) return pin(null);
    const drape = hit.slot === 'two' ? page.two : page.one;
    pin(placeOf(drape.lattice, hit.cell), hit.slot === 'two' ? undefined : hit.node);
  },
  onStart: (place, settled) => {
    if (place) form.setStart(place);
    if (settled) {
      setPlacing(false);
      save();
      refreshCurl();
    }
    live(settled);
  },
  onEye: save,
});

const drapes = new Drapes(element('list'), {
  onOpen: (id) => openDrape(id).catch(report),
  onCompare: (id) => page.one && compareWith(id),
  onError: reportQuietly,
});

function setPlacing(placing) {
  view.setPlacing(placing);
  element('place').setAttribute('aria-pressed', String(placing));
}

function listenRequest() {
  element('request').addEventListener('submit', (event) => {
    event.preventDefault();
    if (!page.busy) run();
  });
  element('request').addEventListener('change', () => {
    refreshCurl();
    save();
  });
  element('cancel').addEventListener('click', cancelRun);
  element('place').addEventListener('click', () => setPlacing(!view.placing));
  element('example').replaceChildren(new Option('own file', ''), ...EXAMPLES.map(([name, label]) => new Option(label, name)));
  element('example').addEventListener('change', ({ target }) => target.value && takeExample(target.value).catch(report));
  element('file').addEventListener('change', ({ target }) => target.files[0] && takeFile(target.files[0]).catch(report));
}

function listenDrop() {
  const over = (on) => element('drop').classList.toggle('over', on);
  document.addEventListener('dragover', (event) => {
    event.preventDefault();
    over(true);
  });
  document.addEventListener('dragleave', () => over(false));
  document.addEventListener('drop', (event) => {
    event.preventDefault();
    over(false);
    const [file] = event.dataTransfer.files;
    if (file) takeFile(file).catch(report);
  });
}

function listenView() {
  element('field').addEventListener('change', ({ target }) => {
    page.field = fieldOf(target.value);
    refreshColours();
    if (page.two) compareFields();
    save();
  });
  for (const name of Object.keys(view.shown))
    element(`show-${name}`).addEventListener('change', ({ target }) => {
      view.show({ ...view.shown, [name]: target.checked });
      save();
    });
  element('views').addEventListener('change', ({ target }) => {
    page.layout = target.value;
    if (page.two) endComparison();
    view.arrange(page.layout);
    save();
  });
  element('home').addEventListener('click', () => {
    view.home();
    save();
  });
  for (const id of ['cell-i', 'cell-j']) element(id).addEventListener('change', pinFromFields);
  element('cell-clear').addEventListener('click', () => pin(null));
  document.addEventListener('keydown', (event) => event.key === 'Escape' && (setPlacing(false), page.pinned && pin(null)));
  new ResizeObserver(() => page.scale && drawScale(element('scale'), page.scale)).observe(element('scale'));
}

function listenResults() {
  element('refresh').addEventListener('click', () => drapes.refresh());
  element('compare-end').addEventListener('click', endComparison);
  element('copy').addEventListener('click', async () => {
    await navigator.clipboard.writeText(element('curl').textContent).catch(() => getSelection().selectAllChildren(element('curl')));
    element('copy').textContent = 'Copied';
    setTimeout(() => (element('copy').textContent = 'Copy'), 1500);
  });
  element('save-request').addEventListener('click', () =>
    saveAs(new Blob([form.body()], { type: 'application/json' }), 'request.json'),
  );
}

listenRequest();
listenDrop();
listenView();
listenResults();
listenToken();
startTheme();
refresh();
await restore();
drapes.refresh();
addEventListener('hashchange', restore);
document.documentElement.dataset.ready = '';
