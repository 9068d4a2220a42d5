// SPDX-License-Identifier: MIT
// Pieces on the page: splits drawn on a box, courses on the blade, each piece in its colour, seams.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import {
  ask,
  browser,
  daemon,
  difference,
  drapeExample,
  drawn,
  openOnce,
  openPage,
  page,
  picture,
  root,
  shareOf,
  violations,
} from './helper.mjs';

openOnce();

const BLUE = [86, 180, 233];
const FOLD = [
  [0, 80, 0],
  [0, 0, 0],
  [90, 0, 0],
]; // of the example `corner`, round its top
let stack = ''; // the laminate that the page asked for last

/** Notes the laminates that a page asks for. */
function watch(on) {
  on.on('response', async (response) => {
    const { pathname } = new URL(response.url());
    const posts = response.request().method() === 'POST' && pathname.endsWith('v1/laminates');
    if (posts && response.ok()) stack = (await response.json()).id;
  });
}

const plyOf = async () => (await ask(`v1/laminates/${stack}/request`)).plies[0];
const piecesOf = async () => (await ask(`v1/laminates/${stack}`)).plies[0].pieces;
const hint = () => page.textContent('#hint');

/** Does something, and waits until the pieces of another laminate are shown. */
async function drapes(what, on = page) {
  const before = stack;
  await on.evaluate(() => (document.querySelector('#pieces-state').textContent = ''));
  await what();
  await on.waitForFunction(() =>
    /are draped/.test(document.querySelector('#pieces-state').textContent),
  );
  assert.notEqual(stack, before);
  await drawn(on);
}

/** Opens a request as somebody's file. */
async function openRequest(request, on = page) {
  const buffer = Buffer.from(JSON.stringify(request));
  const name = `${Math.random()}.json`;
  await on.setInputFiles('#file', { name, mimeType: 'application/json', buffer });
  await on.waitForFunction(
    (told) => document.querySelector('#about').textContent.includes(told),
    name,
  );
}

/** Where places of the part are in the picture: the knobs of a cut through them. */
async function pixelsOf(request, path, on = page) {
  await openRequest({ ...request, cuts: [{ path }] }, on);
  await drawn(on);
  const knobs = await on.locator('#cut-knobs button').all();
  const boxes = await Promise.all(knobs.map((knob) => knob.boundingBox()));
  await openRequest(request, on);
  await drawn(on);
  return boxes.map(({ x, y, width, height }) => [x + width / 2, y + height / 2]);
}

/** Draws a split through places of the picture. */
async function draw(pixels, on = page) {
  await on.click('#split-draw');
  for (const place of pixels.slice(0, -1)) await on.mouse.click(...place);
  await on.mouse.dblclick(...pixels.at(-1));
}

const corner = () => JSON.parse(readFileSync(join(root, 'api/examples/corner.json')));
const blade = () => ({
  ...JSON.parse(readFileSync(join(root, 'tests/validation/blade.json'))),
  fabric: { spacing: 0.05 },
  direction: { vector: [1, 0, 0] },
});

/** Lays the blade in courses along its edge, as one clicks it. */
async function layCourses(on = page) {
  await openRequest(blade(), on);
  await on.click('#courses summary');
  await on.fill('#course-width', '0.4');
  await on.selectOption('#course-along', 'edge');
  const box = await on.locator('#pane-solid').boundingBox();
  await on.click('#course-draw');
  for (let y = 0.1; !(await on.inputValue('#course-path')) && y < 0.9; y += 0.02)
    await on.mouse.click(box.x + 0.5 * box.width, box.y + y * box.height);
  await drapes(() => on.click('#pieces-drape'), on);
}

test('pieces: a split is drawn round the top of a box along its folds, and both pieces are draped', async () => {
  watch(page);
  const pixels = await pixelsOf(corner(), FOLD);
  await page.selectOption('#seam', 'overlap');
  await page.fill('#seam-width', '8');
  await drapes(() => draw(pixels));
  const { splits, seam } = await plyOf();
  assert.deepEqual(seam, { overlap: 8 });
  const { path } = splits[0];
  for (const [k, point] of [path[0], path.at(-1)].entries())
    assert.ok(Math.hypot(...point.map((x, axis) => x - FOLD[2 * k][axis])) < 1e-4, `${point}`);
  for (const [x, y, z] of path) {
    assert.ok(Math.abs(z) < 0.1, `${z}`); // on the fold, straight as it is
    assert.ok(Math.min(Math.abs(x), Math.abs(y)) < 0.1, `${x} ${y}`);
  }
  assert.equal(await page.locator('#pieces-list li').count(), 2);
  const seams = await page.textContent('#pieces-seams');
  assert.match(seams, /piece_1, piece_2/);
  const book = await (await fetch(new URL(`v1/laminates/${stack}/report`, daemon.url))).text();
  const [, length] = /piece_1, piece_2<\/td><td>([\d.]+)/.exec(book);
  assert.ok(Math.abs(length - 170) < 4, length); // 80 and 90
  assert.ok(seams.includes(length));
  const patterns = page.locator('#pieces-pattern .cut path');
  assert.equal(await patterns.count(), 2);
  const shot = await page.locator('#pane-flat').screenshot();
  assert.ok((await shareOf(page, shot, BLUE)) > 0.05);
  assert.deepEqual(await violations(page), []);
});

test('pieces: a knob of a split is moved, and undone; a click looks at a piece', async () => {
  const [before] = (await plyOf()).splits;
  const knob = page.locator('#split-knobs button').last();
  await knob.focus();
  await drapes(() => page.keyboard.press('ArrowDown'));
  const [moved] = (await plyOf()).splits;
  const [x, , z] = moved.path.at(-1);
  assert.ok(Math.abs(x - 90) < 1e-4 && z < -1, `${moved.path.at(-1)}`); // along the rim of the wall
  assert.deepEqual(moved.path[0], before.path[0]);
  await drapes(() => page.keyboard.press('Control+z'));
  assert.deepEqual((await plyOf()).splits[0].path, before.path);
  const [, second] = await piecesOf();
  await page.click('#pieces-list li:nth-child(2) button');
  await page.waitForFunction((id) => location.hash.includes(id), second.id);
  assert.equal(await page.getAttribute('#pieces-show', 'aria-pressed'), 'false');
  assert.ok(await page.isHidden('#pieces-pattern'));
  await page.click('#pieces-show');
  assert.ok(await page.isVisible('#pieces-pattern'));
});

test('pieces: those of the request before its last changes are marked', async () => {
  const isOld = () => page.isVisible('#pieces-stale');
  assert.equal(await isOld(), false);
  for (const [id, other] of [
    ['#seam-width', '9'],
    ['#spacing', '5'],
  ]) {
    const before = await page.inputValue(id);
    await page.fill(id, other);
    assert.ok(await isOld(), id);
    assert.match(await page.textContent('#stale'), /the previous pieces/);
    assert.ok(await page.isVisible('#stale'));
    await page.fill(id, before);
    assert.equal(await isOld(), false, id);
  }
  assert.ok(await page.isHidden('#stale'));
  await page.fill('#seam-width', '9');
  await drapes(() => page.click('#pieces-drape'));
  assert.equal(await isOld(), false);
  await page.fill('#seam-width', '8');
  await drapes(() => page.click('#pieces-drape'));
});

test('pieces: each has a name and a direction of its own, and colours may be those of the shear', async () => {
  const fields = page.locator('#pieces-list li:nth-child(1) input');
  await drapes(async () => {
    await fields.nth(0).fill('top');
    await fields.nth(0).press('Enter');
  });
  await drapes(async () => {
    await fields.nth(1).fill('30');
    await fields.nth(1).press('Enter');
  });
  const [first, second] = await piecesOf();
  assert.deepEqual([first.name, second.name], ['top', 'piece_2']);
  assert.deepEqual((await ask(`v1/drapes/${first.id}/request`)).direction, { angle_deg: 30 });
  assert.notDeepEqual((await ask(`v1/drapes/${second.id}/request`)).direction, { angle_deg: 30 });
  const solid = () => page.locator('#pane-solid').screenshot();
  const own = await solid();
  await page.uncheck('#pieces-own');
  await drawn(page);
  const changed = await difference(page, own, await solid());
  assert.ok(changed > 0.15, `${changed}`);
  await page.check('#pieces-own');
});

test('pieces: what is wrong with a split is said where it is', async () => {
  const pixels = await pixelsOf(corner(), [FOLD[0], FOLD[1], [30, 40, 0]]);
  await draw(pixels);
  assert.match(await hint(), /^A split ends at an edge/);
  await page.keyboard.press('Escape');
  assert.equal(await page.locator('#split-list li').count(), 0);
  const whole = await pixelsOf(corner(), FOLD);
  await page.selectOption('#seam', '');
  await drapes(() => draw(whole));
  await page.selectOption('#seam', 'gap');
  await page.fill('#seam-width', '500');
  await page.click('#pieces-drape');
  await page.waitForSelector('#fault-of-seam');
});

test('pieces: the blade lies in courses from its edge, in two colours by turns', async () => {
  await layCourses();
  const pieces = await piecesOf();
  assert.equal(pieces.length, 5); // of 0.4 m each
  const { courses } = await plyOf();
  assert.deepEqual(courses.width, [0.4]);
  assert.equal(courses.along.edge.length, 3);
  const dots = await page.$$eval('#pieces-list li', (rows) =>
    rows.map((row) => getComputedStyle(row).getPropertyValue('--dot')),
  );
  assert.equal(new Set(dots).size, 2);
  assert.ok(dots.every((dot, k) => k === 0 || dot !== dots[k - 1]));
  const all = await page.$$eval('#pieces-courses tr:last-child td', (cells) =>
    cells.map(({ textContent }) => textContent),
  );
  assert.equal(all[4], '1'); // they cover the part
  const fills = await page.$$eval('#pieces-pattern .cut path', (paths) =>
    paths.map((path) => path.getAttribute('fill')),
  );
  assert.equal(fills.length, 5);
  assert.equal(new Set(fills).size, 2);
  const trimmed = async () =>
    Number(await page.textContent('#pieces-courses tr:last-child td:nth-child(4)'));
  const before = await trimmed();
  await page.click('#course-search');
  await page.waitForSelector('#course-take:visible');
  assert.match(
    await page.textContent('#course-search-state'),
    /^[\d.]+ m² trimmed off, .* % covered; as it was/,
  );
  assert.deepEqual((await plyOf()).courses.gap, courses.gap); // till they are taken
  await drapes(() => page.click('#course-take'));
  assert.ok((await plyOf()).courses.gap.flat().every((value) => value < 0 && value >= -0.1));
  assert.ok((await trimmed()) < before, `${await trimmed()} of ${before}`);
  assert.ok(await page.isHidden('#course-take'));
  await page.fill('#course-width', '9');
  await page.click('#pieces-drape');
  await page.waitForSelector('#fault-of-course-width');
  assert.deepEqual(await violations(page), []);
});

test('pieces: the picture of the docs', async () => {
  const options = { width: 1200, height: 700, deviceScaleFactor: 0.65 };
  const small = await openPage(browser, daemon.url, options);
  watch(small);
  const pixels = await pixelsOf(corner(), FOLD, small);
  await small.selectOption('#seam', 'overlap');
  await small.fill('#seam-width', '8');
  await drapes(() => draw(pixels, small), small);
  await small.locator('#split-draw').evaluate((button) => button.scrollIntoView());
  await small.locator('#pieces-result').evaluate((list) => list.scrollIntoView());
  const shot = await picture(small, 'docs_pieces');
  assert.ok(shot.length < 150e3, `${shot.length} bytes`);
  await layCourses(small);
  await small.locator('#course-along').evaluate((list) => list.scrollIntoView());
  await small.locator('#pieces-result').evaluate((list) => list.scrollIntoView());
  const other = await picture(small, 'docs_courses');
  assert.ok(other.length < 150e3, `${other.length} bytes`);
  await small.context().close();
});
