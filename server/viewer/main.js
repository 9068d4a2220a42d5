// SPDX-License-Identifier: MIT
// The page: what follows from what. The parts know nothing of each other; here they meet.
import * as api from './api.js';
import { readAddress, writeAddress } from './address.js';
import { Comparison } from './comparison.js';
import { drawDiagonals, drawHistogram, drawScale } from './charts.js';
import { element, say } from './dom.js';
import { fetchDrape, fetchRequest, toldOf } from './drape.js';
import {
  colouringOf,
  fieldOf,
  fields,
  format,
  ofNodes,
  rangeOf,
  valuesOf,
  withUnit,
} from './fields.js';
import { Form, numberOf } from './form.js';
import { Finder } from './finder.js';
import { nodeAt } from './lattice.js';
import { curlCommand, fileName, saveAs, showDownloads } from './links.js';
import { Drapes } from './list.js';
import { Lines } from './lines.js';
import { History } from './history.js';
import { Tracer } from './tracing.js';
import {
  blankReadout,
  briefSummary,
  cellAt,
  cornersOf,
  describeCell,
  placeOf,
  showReadout,
  showSummary,
} from './readout.js';
import { drawBar, Measure } from './measure.js';
import { Mapped } from './mapped.js';
import { Outline } from './outline.js';
import { Rosette } from './rosette.js';
import { Runner } from './run.js';
import { Pieces } from './pieces.js';
import { Proposals } from './proposals.js';
import { Steering } from './steering.js';
import { Stack } from './stack.js';
import { startTheme } from './theme.js';
import { Chooser } from './chooser.js';
import { Coursing } from './coursing.js';
import {
  chosenOf,
  formatOf,
  lookAtPart,
  shapeOf,
  storeDefinition,
  storePart,
  surfaceOf,
} from './part.js';
import { Share, showReadOnly } from './share.js';
import { askToken, startToken } from './token.js';
import { View } from './view.js';
import { readRequest } from './work.js';

const EXAMPLES = [
  ['saddle', 'Saddle'],
  ['octant', 'Sphere octant, from the pole'],
  ['hemisphere', 'Hemisphere, with permeability'],
  ['sphere', 'Spherical patch'],
  ['torus', 'Quarter torus'],
  ['freeform', 'Free-form part'],
  ['tray', 'Tray, a triangle mesh'],
  ['corner', 'Corner of a box, three faces'],
];
const NO_CELL =
  'The net has no cell here: choose a smaller spacing, or another start, and press Drape.';
const OLD_DRAPE = 'The request has changed: this is the previous drape. Press Drape.';
const OLD_PIECES =
  'The request has changed: these are the previous pieces. Press Drape the pieces.';
const RETRY = 'Check the address, or drape again.';
const MESHES = ['nastran', 'stl', 'obj']; // files that are mapped when they are dropped on a drape
const CHOOSE =
  'Click on faces of the tool side; a double click takes all that is smooth from there.';
const CHOOSING_MS = 150; // after the last choice, before the faces are put under the net
const IN_METRES = 20; // a part of a larger size without a unit is in millimetres
const NARROW = '(max-width: 720px)'; // as in style.css

const page = {
  field: fields[0],
  layout: 'both',
  one: null, // {id, lattice, summary, spacing, label} of the drape that is shown
  pinned: null, // [i, j]
  hovered: null,
  example: 'saddle',
  part: 'saddle', // what the surface is called
  opened: 0, // how many times something was opened: an example, a file, a drape
  limitsOf: {}, // of the colours, by field: [from, to] as far as given
  restoring: true, // of the address, which is not to be written meanwhile
};

api.token.link = readAddress().link ?? ''; // before anything is asked

/* ---- errors ---- */

function report(error) {
  if (error.name === 'AbortError') return;
  if (error.status === 401 && !api.token.link) askToken(Boolean(api.token.get()));
  if (error instanceof api.Problem) form.showErrors(error);
  else form.showErrors({ message: error.message });
}

function reportQuietly(error) {
  const asks = error.status === 401 && !api.token.link;
  element('message').textContent = asks ? 'This service asks for a token.' : error.message;
  if (asks) askToken(Boolean(api.token.get()));
}

/* ---- the request ---- */

/** What was dragged is let go. */
function settle() {
  save();
  refreshCurl();
  refreshStale();
  runner.live(true);
}

const form = new Form({
  onLive: () => runner.live(false),
  onSettled: settle,
  onUnit: () => {
    refreshAbout();
    if (page.one) refreshNumbers();
  },
  isEmpty: () => chooser.isEmpty,
});

/** Puts a request into the form and its surface into the picture; forgets the drape that was shown. */
async function takeRequest(request) {
  page.note = '';
  page.restore = null; // stores the file of the part in another unit
  chooser.open(null);
  if (request.surfaceText !== form.surfaceText) stack.forget();
  form.load(request);
  history.clear();
  cuts.load();
  splits.load();
  steering.load();
  pieces.clear();
  proposals.clear();
  coursing.clear();
  if (request.fault) form.surfaceError(request.fault);
  refreshAbout();
  clear();
  measure.toggle(false);
  element('section').value = '';
  view.setShape(request.shape);
  view.cut('', 0);
  const ready = 'Press Drape. Click on the surface to choose where the net starts.';
  const unknown =
    'This surface cannot be shown. Press Drape: the service says what is wrong with it.';
  hint(request.shape ? ready : request.faces ? 'Fetching the faces …' : unknown, true);
  refreshCurl();
  if (!request.faces) return;
  const { id } = request.selection;
  if (api.token.link && !id) return; // the net alone: to show the faces they had to be stored
  const part = await (api.token.link ? lookAtPart(id) : storeDefinition(request.definition));
  const chosen = chosenOf(part, request.selection);
  const shown = await showChosen(part, chosen, request.surfaceText);
  if (shown && !api.token.link) showPart(part, chosen);
}

/** Shows a part's faces to choose from; those that are chosen lie under the net. */
function showPart(part, chosen) {
  chooser.open(part, chosen);
  if (!page.one) hint(chosen.size || part.mesh ? 'Press Drape.' : CHOOSE, true);
}

/** Puts the faces that are chosen under the net; false where others are chosen meanwhile. */
async function showChosen(part, chosen, surfaceText) {
  const shape = await shapeOf(part, chosen);
  if (form.surfaceText !== surfaceText) return false;
  form.setSurface(surfaceText, shape);
  view.setShape(shape, !page.one && !chooser.on);
  refreshAbout();
  return true;
}

/** The faces that are chosen have changed. */
function chooseFaces(part, chosen) {
  const surfaceText = surfaceOf(part, chosen);
  for (const id of ['general', 'find', 'stack']) element(`fault-${id}`).textContent = '';
  form.setSurface(surfaceText, form.shape);
  hint(chosen.size ? '' : CHOOSE, true);
  refreshStale();
  refreshCurl();
  clearTimeout(page.choosing);
  page.choosing = setTimeout(
    () => showChosen(part, chosen, surfaceText).catch(report),
    CHOOSING_MS,
  );
}

/** Something is opened: a function that says whether it still is what was opened last. */
function open() {
  const number = ++page.opened;
  return () => page.opened === number;
}

/** A file of CAD or mesh: the service reads it; false where something else was opened meanwhile. */
async function takePart(file, format, isLast, unit) {
  const part = await storePart(file, format, unit);
  const chosen = new Set(part.first);
  const shape = await shapeOf(part, chosen);
  if (!isLast()) return false;
  const settings = { fabric: {}, length_unit: part.unit, method: part.mesh ? 'mosaic' : undefined };
  await takeRequest({ settings, surfaceText: surfaceOf(part, chosen), shape });
  page.note = `${file.name}: ${part.unitAssumed ? `it states no unit; ${part.unit} is assumed. ` : ''}`;
  page.restore = part.mesh && ((other) => takePart(file, format, open(), other));
  showPart(part, chosen);
  return true;
}

/** What the surface is and how large, in the unit that is chosen. */
function refreshAbout() {
  const { shape } = form;
  const size = shape && shape.size.map((edge) => format(edge, 3)).join(' × ');
  element('about').textContent = shape
    ? `${page.note || ''}${shape.about}; ${size} ${form.unit}`
    : page.note || '';
}

/** Marks what is shown as the answer to another request than the form's. */
function refreshStale() {
  const { one } = page;
  const old = Boolean(one && !one.passing && !runner.living && one.body !== form.body());
  const oldPieces = pieces.tellStale();
  const stale = pieces.shown ? oldPieces : old;
  element('stale').hidden = !stale;
  element('stale').textContent = pieces.shown ? OLD_PIECES : OLD_DRAPE;
  element('panes').classList.toggle('stale', stale);
  element('results').classList.toggle('stale', old);
}

function clear() {
  page.one = page.pinned = page.hovered = null;
  mapped.setDrape(null);
  finder.clear();
  runner.forget();
  comparison.end();
  view.arrange(page.layout);
  view.setNet('one', null);
  view.setHandle(-1);
  rosette.set(null);
  steering.show(null);
  showDownloads(element('downloads'), null, reportQuietly);
  refresh();
  for (const id of ['cell-i', 'cell-j']) element(id).value = '';
}

function hint(text, low = false) {
  if (!view.stage) return;
  element('hint').textContent = text;
  element('hint').classList.toggle('low', low);
}

async function takeExample(name) {
  const isLast = open();
  element('example').value = name;
  const response = await fetch(new URL(`./${name}.json`, import.meta.url));
  if (!response.ok) throw new api.Unreachable();
  const request = await readRequest(await response.text());
  if (!isLast()) return;
  page.example = page.part = name;
  await takeRequest(request);
  save();
}

/** A file without a unit is not in metres when that would make a part of hundreds of metres. */
function assumeUnit({ settings, shape }) {
  if (settings.length_unit || !shape) return '';
  settings.length_unit = Math.max(...shape.size) > IN_METRES ? 'mm' : 'm';
  return `It states no unit; ${settings.length_unit} is assumed. `;
}

/** The service's limits, asked once; a file that is too large is not even read. */
async function takeFile(file) {
  if (api.token.link) return;
  const isLast = open();
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
  const reading = say(`Reading ${file.name} …`);
  const said = () => element('state').textContent === reading && say('');
  const format = formatOf(file.name);
  try {
    const taken = await (format ? takePart(file, format, isLast) : takeJson(file, isLast));
    said();
    if (!taken) return;
    page.example = '';
    page.part = file.name.replace(/(\.draped)?\.\w+$/i, '');
    element('example').value = '';
    refreshAbout();
    save();
  } catch (error) {
    const known = format || /\.json$/i.test(file.name);
    const why = known ? error.message : await refusalOf(file);
    said();
    if (isLast()) form.surfaceError(`${file.name}: ${why}`);
  }
}

/** What the service says of files whose names end like that. */
const refusalOf = ({ name }) =>
  api
    .storeSurface('', 'application/octet-stream', `?format=${name.split('.').pop()}`)
    .catch(({ message }) => message);

async function takeJson(file, isLast) {
  const request = await readRequest(await file.text());
  if (!isLast()) return false;
  if (request.work) return takeWork(request, isLast);
  const assumed = assumeUnit(request);
  await takeRequest(request);
  if (isLast()) page.note = `${file.name}: ${assumed}`;
  return isLast();
}

/* ---- the whole work ---- */

/** What is shown, to be shown again: here by its ids, elsewhere by what they are of. */
function viewState() {
  const shown = Object.entries(view.shown)
    .filter(([, on]) => on)
    .map(([name]) => name);
  return {
    field: page.field.key,
    limits: page.limitsOf[page.field.key]?.map((value) => value ?? '').join(','),
    view: page.layout,
    show: shown.join(',') || 'none',
    cell: page.pinned?.join(','),
    eye: view.eye,
    over: pieces.shown ? 'pieces' : finder.on ? 'study' : '',
  };
}

/** Which of what lies over the net is shown. */
function showOver(name) {
  pieces.show(name === 'pieces');
  finder.show(name === 'study');
}

/** Writes all of it into one file; a surface that is stored goes along, for others lack it. */
async function saveWork() {
  const { id } = JSON.parse(form.surfaceText);
  const rest = {
    surface: id && (await api.read(`v1/surfaces/${id}`)),
    draped: { one: Boolean(page.one), pieces: Boolean(pieces.id), stack: Boolean(stack.id) },
    pieces: pieces.division,
    stack: stack.members,
    study: finder.state,
    view: viewState(),
  };
  const head = '{"format":"draped-work","version":1,"request":';
  const text = `${head}${form.body()},${JSON.stringify(rest).slice(1)}`;
  const name = `${fileName(page.part || 'part')}.draped.json`;
  saveAs(new Blob([text], { type: 'application/json' }), name);
}

/** Opens such a file, and drapes what was draped. */
async function takeWork({ stored, work, ...request }, isLast) {
  if (work.version !== 1)
    throw new Error(
      'another version of this page has saved it: open it with that, or a newer one.',
    );
  if (stored) await api.storeSurface(stored, 'application/json');
  await takeRequest(request);
  if (!isLast()) return false;
  pieces.load(work.pieces);
  splits.load();
  stack.load(work.stack);
  restoreChoices(work.view);
  await finder.load(work.study);
  if (work.draped.one) await runner.run();
  if (work.draped.pieces) await pieces.run();
  if (work.draped.stack) await stack.run(false);
  showOver(work.view.over);
  restoreCell(work.view);
  return isLast();
}

function refreshCurl() {
  element('curl').textContent = form.surfaceText ? curlCommand(form.body()) : '';
}

/* ---- what is shown ---- */

/** The columns of a net that is shown for a moment only; with a cell chosen all, for its numbers. */
function columnsOnTheWay(names) {
  if (page.pinned) return null;
  const shown = ['cells.shear_deg', 'cells.locked', page.field.column];
  const wanted = (name) =>
    /^(nodes\.[ijxyz]|cells\.[ij]|front\..*)$/.test(name) ||
    (view.shown.crosses && /^cells\.k[12]/.test(name)) ||
    shown.includes(name);
  return names.filter(wanted);
}

/** The unit that the text of a request states behind its surface. */
const unitIn = (body = '') =>
  /^"length_unit":"(\w+)"/.exec(body.slice(body.lastIndexOf('"length_unit"')))?.[1];

/** Shows a drape; `passing` for one on the way, which has no id and need not have all columns. */
function showDrape(drape, passing = false) {
  const { id, brief, summary } = page.one || {};
  page.one = passing
    ? { ...drape, id, passing, brief: briefSummary(drape.lattice, brief || summary) }
    : { ...drape, unit: unitIn(drape.body) || form.unit };
  page.hovered = null;
  element('chip').hidden = true;
  const { length } = drape.lattice.columns['cells.i'];
  hint(length ? '' : NO_CELL, true);
  if (measure.nodes.length) measure.toggle(measure.on); // its nodes were the net's before
  view.setNet('one', drape);
  view.setHandle(nodeAt(drape.lattice.grid, 0, 0));
  steering.show(page.one);
  if (!passing) rosette.set(page.one);
  refresh(passing);
  refreshStale();
  if (passing) return view.passing();
  chooser.show(false);
  finder.show(false);
  pieces.show(false);
  finder.refresh();
  stack.mark(page.one.id);
  cuts.show(page.one.lattice.columns, unitShown());
  mapped.setDrape(page.one, unitShown());
  const { cells, timing_ms: time } = drape.summary;
  say(`${cells.toLocaleString('en')} cells, solved in ${format(time.solve, 3)} ms`);
  refreshCurl();
  const title = fileName(`${page.part || 'part'} ${drape.label}`);
  const bare = drape.summary.outcome === 'partial' ? 1 - drape.summary.cloth_coverage : 0;
  showDownloads(element('downloads'), drape.id, reportQuietly, title, bare);
  drapes.name(drape.id, `${page.part || 'part'}: ${drape.label}`);
  compareFields();
  save();
}

/** Everything that depends on the drape, the field and the marked cell. */
function refresh(passing = false) {
  if (!passing) refreshFields();
  refreshColours();
  refreshNumbers();
  if (!passing) refreshCharts();
  view.mark('pinned', page.pinned, cellAt);
}

function refreshFields() {
  const columns = page.one?.lattice.columns;
  const given = columns ? fields.filter((field) => columns[field.column]) : fields.slice(0, 2);
  if (columns && !given.includes(page.field)) page.field = given[0];
  element('field').replaceChildren(
    ...given.map(({ key, label }) => new Option(label, key, false, key === page.field.key)),
  );
}

/** The limits in the fields, which are those of the shown field. */
function takeLimits() {
  const numbers = ['scale-low', 'scale-high'].map((id) => {
    const number = numberOf(element(id).value);
    return Number.isFinite(number) ? number : undefined;
  });
  page.limitsOf[page.field.key] = numbers;
  refreshColours();
  save();
}

function showLimits() {
  const limits = page.limitsOf[page.field.key] || [];
  ['scale-low', 'scale-high'].forEach((id, k) => (element(id).value = limits[k] ?? ''));
}

function refreshColours() {
  const { field, one } = page;
  const sets = { one, two: comparison.other };
  const values = {};
  for (const [slot, drape] of Object.entries(sets))
    values[slot] = drape && valuesOf(drape.lattice.columns, field);
  // One scale for all that is shown: a stack on a mesh is thicker than the ply beside it.
  const ranges = [...Object.values(values), mapped.valuesOf(field), pieces.valuesOf(field)]
    .filter((set) => set?.length)
    .map(rangeOf);
  const range = ranges.length
    ? [Math.min(...ranges.map(([low]) => low)), Math.max(...ranges.map(([, high]) => high))]
    : [0, 60];
  const limits = page.limitsOf[field.key];
  page.scale = colouringOf(field, range, { limits, lockings: form.lockings, unit: unitShown() });
  for (const slot of Object.keys(sets))
    if (values[slot])
      view.setField(slot, values[slot], ofNodes(field), page.scale.range, page.scale.map);
  drawScale(element('scale'), page.scale);
  mapped.colour(field, page.scale);
  pieces.colour(field, page.scale);
}

/** The unit of what is shown: of a drape that of its own request, whatever the form says since. */
const unitShown = () => page.one?.unit || form.unit;

function refreshNumbers() {
  const { one } = page;
  const other = comparison.other && [comparison.other.summary, comparison.other.label];
  showSummary(element('summary'), one?.passing ? one.brief : one?.summary, unitShown(), other);
  if (one && !one.lattice.columns['nodes.u']) return blankReadout(element('readout'));
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
    unit: unitShown(),
    isUv: form.shape?.kind !== 'mesh',
  });
}

const frontOfOne = () => view.slots.one?.front || new Map();

function refreshCharts() {
  const { one } = page;
  for (const id of ['histogram', 'diagonals']) element(id).replaceChildren();
  if (!one?.lattice.columns['cells.i'].length) return;
  drawHistogram(element('histogram'), one.lattice.columns['cells.shear_deg'], form.locking);
  drawDiagonals(
    element('diagonals'),
    [one, comparison.other].filter(Boolean).map(({ lattice }) => lattice),
    unitShown(),
    form.locking,
  );
}

/* ---- cells ---- */

function hover(hit) {
  const drape = hit && (hit.slot === 'two' ? comparison.other : page.one);
  page.hovered = drape ? { ...hit, place: placeOf(drape.lattice, hit.cell) } : null;
  view.mark('hovered', page.hovered?.place || null, cellAt);
  const chip = element('chip');
  chip.hidden = !page.hovered;
  if (page.hovered) chip.textContent = describeHit(drape.lattice, hit);
  if (!page.pinned) refreshNumbers();
}

function describeHit(lattice, { slot, cell }) {
  const { field } = page;
  const values = slot === 'difference' ? comparison.values : lattice.columns[field.column];
  const of = slot === 'difference' ? (value) => value : field.of;
  const value = ofNodes(field) ? null : of(values[cell]);
  const front = view.slots[slot]?.front || new Map();
  return describeCell(lattice, cell, { value, unit: field.unit(unitShown()), front });
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

/** The cell with the most shear, whatever is shown. */
function pinWorst() {
  const { lattice } = page.one || {};
  if (!lattice?.columns['cells.i'].length) return;
  const shear = lattice.columns['cells.shear_deg'].map(Math.abs);
  const worst = shear.indexOf(rangeOf(shear)[1]);
  pin(placeOf(lattice, worst));
  view.lookAt(worst);
}

/* ---- laminates ---- */

/** Shows the drape of a ply, from where one looks now. */
async function lookAt(id, { angle, own }) {
  if (angle !== null) form.main = { angle: String(angle) };
  const settings = form.settings();
  const told = toldOf({ ...settings, fabric: (own ?? settings).fabric });
  showDrape({ ...(await fetchDrape(id)), ...told, body: form.body() });
  runner.follow(page.one);
}

/* ---- studies ---- */

/** Drapes a variant of a study; the drape that is shown can be compared with it. */
function drapeVariant({ start, angle }) {
  if (api.token.link) return;
  page.before = page.one?.id || page.before;
  element('find-compare').hidden = !page.before;
  form.setStart(start, 9);
  form.main = { angle: String(Number(angle.toPrecision(6))) };
  refreshCurl();
  if (page.one) runner.live(true);
  else runner.run();
}

/* ---- comparing ---- */

async function compareWith(id) {
  try {
    await comparison.start(id);
    refresh();
    await compareFields();
    save();
  } catch (error) {
    reportQuietly(error);
  }
}

async function compareFields() {
  if (!page.one || !comparison.other) return;
  await comparison.colour(page.one, page.field, unitShown());
  view.mark('pinned', page.pinned, cellAt);
}

function endComparison() {
  comparison.end();
  view.arrange(page.layout);
  refresh();
  save();
}

/* ---- the address ---- */

function save() {
  if (page.restoring) return;
  writeAddress({
    link: api.token.link,
    drape: page.one?.id,
    compare: comparison.other?.id,
    pieces: pieces.id,
    stack: stack.id,
    study: finder.done,
    example: page.example,
    ...form.main,
    ...viewState(),
  });
}

async function openDrape(id) {
  const isLast = open();
  const request = await fetchRequest(id);
  if (!isLast()) return;
  await takeRequest(request);
  hint('Fetching the net …', true);
  const told = { ...toldOf(request.settings), body: form.body() };
  const drape = { ...(await fetchDrape(id)), ...told };
  if (!isLast()) return;
  showDrape(drape);
  runner.follow(drape);
  drapes.refresh(id);
}

function restoreChoices(state) {
  page.field = fieldOf(state.field);
  const limits = state.limits?.split(',').map((text) => (text ? Number(text) : undefined));
  if (limits) page.limitsOf[page.field.key] = limits;
  showLimits();
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

/** The first drape of a laminate that there is. */
async function drapeIn(id) {
  const { plies } = await api.read(`v1/laminates/${id}`);
  const drapes = plies.flatMap(({ pieces: own, ...ply }) => own ?? [ply]);
  return drapes.find(({ status }) => status === 'succeeded')?.id;
}

/** Opens what an address has the ids of. False where it has none. */
async function openAll(state) {
  const of = (key) => (/^\w+$/.test(state[key]) ? state[key] : '');
  const laminates = ['pieces', 'stack'].map(of);
  const [first] = laminates.filter(Boolean);
  const drape = of('drape') || (first && (await drapeIn(first)));
  if (!drape) return false;
  page.example = EXAMPLES.some(([name]) => name === state.example) ? state.example : '';
  element('example').value = page.example;
  await openDrape(drape);
  if (of('compare')) await compareWith(of('compare'));
  if (of('study')) await finder.open(of('study'));
  const requests = await Promise.all(
    laminates.map((id) => id && api.read(`v1/laminates/${id}/request`)),
  );
  if (laminates[0]) await pieces.open(laminates[0], requests[0]);
  splits.load();
  if (laminates[1]) await stack.open(laminates[1], requests[1]);
  showOver(state.over);
  return true;
}

/** Shows what the address says, as far as it is there. */
async function restore() {
  const state = readAddress();
  api.token.link = state.link ?? '';
  showReadOnly();
  page.restoring = true;
  const shown = await restoreState(state);
  page.restoring = false;
  if (shown) restoreCell(state);
}

async function restoreState(state) {
  restoreChoices(state);
  try {
    if (await openAll(state)) return true;
  } catch (error) {
    const gone = error instanceof api.Problem && [404, 410].includes(error.status);
    if (!gone || api.token.link) {
      report(error);
      return false;
    }
    await restoreExample(state);
    element('fault-general').textContent =
      `The drape of this link is gone: ${error.message}. ${RETRY}`;
    return false;
  }
  await restoreExample(state);
  return true;
}

async function restoreExample(state) {
  const known = EXAMPLES.some(([name]) => name === state.example);
  await takeExample(known ? state.example : 'saddle').catch(report);
  if (!known) return;
  const given = ['method', 'spacing', 'angle', 'start'].filter((key) => state[key] !== undefined);
  form.main = Object.fromEntries(given.map((key) => [key, state[key]]));
  refreshCurl();
}

/* ---- the parts, and who listens to whom ---- */

const view = new View({
  onHover: hover,
  onPick: (hit) => {
    if (measure.on && hit?.slot === 'one') return pickMeasured(hit.node);
    if (!hit) return pin(null);
    const drape = hit.slot === 'two' ? comparison.other : page.one;
    pin(placeOf(drape.lattice, hit.cell), hit.slot === 'two' ? undefined : hit.node);
  },
  onStart: (place, settled) => {
    if (api.token.link) return;
    if (place) form.setStart(place);
    if (settled) {
      setPlacing(false);
      save();
      refreshCurl();
    }
    runner.live(settled);
  },
  onEye: save,
  onFrame: () => {
    drawBar(view.pixelsOfUnit, unitShown());
    measure.draw((node) => view.pixelsOf(node));
    outline.draw((place) => view.pixelsOfPlace(place));
    for (const lines of [cuts, splits]) lines.draw((place) => view.pixelsOfPlace(place));
    proposals.draw((place) => view.pixelsOfPlace(place));
    steering.draw((place) => view.pixelsOfPlace(place), Boolean(view.patches));
    rosette.draw();
  },
});

const measure = new Measure();
const outline = new Outline(view, (text) => hint(text, true));
const history = new History({
  read: () => form.drawn,
  write: (drawn) => {
    const before = form.drawn;
    form.drawn = drawn;
    cuts.load();
    splits.load();
    steering.load();
    if (drawn.splits === before.splits) settle();
    else pieces.follow();
  },
});
const tracer = new Tracer(view, form);
const drawing = { view, form, outline, history, tracer };
const cuts = new Lines('cut', drawing, {
  onLive: () => runner.live(false),
  onSettled: settle,
  onDraw: () => chooser.show(false),
});
const splits = new Lines('split', drawing, {
  onLive: () => {},
  onSettled: () => pieces.follow(),
  onDraw: () => chooser.show(false),
});
const rosette = new Rosette(view, form, {
  onTurn: (settled) => (settled ? settle() : runner.live(false)),
});
const chooser = new Chooser(view, { onChange: chooseFaces });
const finder = new Finder(view, form, {
  onDrape: drapeVariant,
  onEnd: save,
  onError: reportQuietly,
  current: () => page.one?.summary,
});
const mapped = new Mapped(view, { onShow: refreshColours, onError: reportQuietly });
const proposals = new Proposals(view, form, cuts, { onError: reportQuietly });
const steering = new Steering(view, form, history, {
  onLive: () => runner.live(false),
  onSettled: settle,
});
const pieces = new Pieces(view, form, {
  tracer,
  onLook: (id) => lookAt(id, { angle: null }).catch(report),
  onShow: () => {
    refreshColours();
    refreshStale();
    save();
  },
  onEnd: () => {
    refreshStale();
    save();
  },
  onDraw: (take, kind) => {
    chooser.show(false);
    outline.begin(take, kind);
  },
  onError: reportQuietly,
});
const coursing = new Coursing(form, { onTake: () => pieces.run(), onError: reportQuietly });
const stack = new Stack(form, {
  onLook: (id, ply) => lookAt(id, ply).catch(report),
  onDraw: (take) => {
    chooser.show(false);
    outline.begin(take);
  },
  onStack: (id) => {
    mapped.setStack(id);
    save();
  },
  onError: reportQuietly,
});
new Share({
  idsOf: () =>
    [page.one, comparison.other, pieces, stack]
      .map((one) => one?.id)
      .concat(finder.done)
      .filter(Boolean),
  save: saveWork,
});

function pickMeasured(node) {
  measure.pick(page.one, node, unitShown());
  view.stage.redraw();
}

function listenTools() {
  element('measure').addEventListener('click', () => {
    measure.toggle();
    view.stage?.redraw();
  });
  const cut = () => {
    element('section-at').hidden = !element('section').value;
    view.cut(element('section').value, Number(element('section-at').value));
  };
  for (const id of ['section', 'section-at']) element(id).addEventListener('input', cut);
  for (const id of ['scale-low', 'scale-high']) element(id).addEventListener('change', takeLimits);
}

const comparison = new Comparison(view);

const runner = new Runner(form, {
  onDrape: showDrape,
  onError: report,
  onEnd: () => drapes.refresh(page.one?.id),
  onSettled: refreshStale,
  columnsOnTheWay,
});

const drapes = new Drapes(element('list'), {
  isHidden: (id) => runner.passing.includes(id),
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
    refreshCurl();
    if (matchMedia(NARROW).matches) element('stage').scrollIntoView();
    runner.run();
  });
  element('request').addEventListener('input', refreshStale);
  element('request').addEventListener('change', () => {
    refreshCurl();
    refreshStale();
    save();
  });
  element('cancel').addEventListener('click', () => runner.cancel());
  element('place').addEventListener('click', () => setPlacing(!view.placing));
  element('example').replaceChildren(
    new Option('own file', ''),
    ...EXAMPLES.map(([name, label]) => new Option(label, name)),
  );
  element('example').addEventListener(
    'change',
    ({ target }) => target.value && takeExample(target.value).catch(report),
  );
  element('unit').addEventListener('change', () =>
    page.restore?.(form.unit).then(refreshAbout).catch(report),
  );
  element('file').addEventListener('change', ({ target }) => {
    const [file] = target.files;
    target.value = ''; // the same file again, written anew, is a change, too
    if (file) takeFile(file).catch(report);
  });
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
    if (!file) return;
    const onDrape = page.one?.id && event.target.closest('#stage');
    const wanted = event.target.closest('#mesh-drop');
    if (wanted || (onDrape && MESHES.includes(formatOf(file.name)))) mapped.open(file);
    else takeFile(file).catch(report);
  });
}

function listenView() {
  element('field').addEventListener('change', ({ target }) => {
    page.field = fieldOf(target.value);
    showLimits();
    refreshColours();
    compareFields();
    save();
  });
  for (const name of Object.keys(view.shown))
    element(`show-${name}`).addEventListener('change', ({ target }) => {
      view.show({ ...view.shown, [name]: target.checked });
      save();
    });
  element('views').addEventListener('change', ({ target }) => {
    page.layout = target.value;
    if (comparison.other) endComparison();
    view.arrange(page.layout);
    save();
  });
  for (const button of document.querySelectorAll('[data-to]'))
    button.addEventListener('click', () => element(button.dataset.to).scrollIntoView());
  element('home').addEventListener('click', () => {
    view.home();
    save();
  });
  for (const id of ['cell-i', 'cell-j']) element(id).addEventListener('change', pinFromFields);
  element('cell-clear').addEventListener('click', () => pin(null));
  element('cell-worst').addEventListener('click', pinWorst);
  document.addEventListener(
    'keydown',
    (event) =>
      event.key === 'Escape' &&
      (setPlacing(false), measure.toggle(false), view.stage?.redraw(), page.pinned && pin(null)),
  );
  new ResizeObserver(() => page.scale && drawScale(element('scale'), page.scale)).observe(
    element('scale'),
  );
}

function listenResults() {
  element('refresh').addEventListener('click', () => drapes.refresh());
  element('compare-end').addEventListener('click', endComparison);
  element('find-compare').addEventListener('click', () => compareWith(page.before));
  element('copy').addEventListener('click', async () => {
    await navigator.clipboard
      .writeText(element('curl').textContent)
      .catch(() => getSelection().selectAllChildren(element('curl')));
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
listenTools();
listenResults();
startToken(() => {
  element('message').textContent = '';
  form.clearErrors();
  if (!form.surfaceText) restore(); // the link's drape could not be fetched without it
  drapes.refresh();
});
startTheme(() => view.retint());
refresh();
await restore();
drapes.refresh();
addEventListener('hashchange', restore);
document.documentElement.dataset.ready = '';
