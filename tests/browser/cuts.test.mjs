// SPDX-License-Identifier: MIT
// Cuts on the page: drawn on the part with the mouse, listed, moved by their tips, taken back.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import {
  ask,
  browser,
  daemon,
  drapeExample,
  drawn,
  idOf,
  openOnce,
  openPage,
  page,
  picture,
  violations,
} from './helper.mjs';

openOnce();

const EDGE = [
  [0, 0, -60],
  [0, 0, 0],
]; // of the example `corner`, where two walls meet
const hint = () => page.textContent('#hint');
const cutsOf = async () => (await ask(`v1/drapes/${idOf(page)}/request`)).cuts ?? [];
const points = (k) => page.inputValue(`#cut-list li:nth-child(${k}) input:nth-of-type(2)`);

/** Does something, and waits until another drape is shown. */
async function drapes(what) {
  const before = idOf(page);
  await what();
  await page.waitForFunction((id) => !location.hash.includes(id), before);
  await page.waitForFunction(() => document.querySelector('#stale').hidden);
  await drawn(page);
}

/** Opens a request with a cut as somebody's file. */
async function openRequest(request, on = page) {
  const buffer = Buffer.from(JSON.stringify(request));
  await on.setInputFiles('#file', { name: 'corner.json', mimeType: 'application/json', buffer });
  await on.waitForSelector('#cut-list li');
}

/** Where on the picture in 3D a share of its width and height is. */
async function at(x, y) {
  const box = await page.locator('#pane-solid').boundingBox();
  return [box.x + x * box.width, box.y + y * box.height];
}

/** Clicks from the left until the part is met, which is at its edge. */
async function clickEdge(y) {
  for (let x = 0.02; x < 0.5; x += 0.01) {
    await page.mouse.click(...(await at(x, y)));
    if (!/beside the part/.test(await hint())) return x;
  }
  throw new Error('no edge was met');
}

test('cuts: one is drawn from an edge to its tip, and the cloth is draped with it', async () => {
  await drapeExample(page, 'saddle');
  assert.deepEqual(await cutsOf(), []);
  await page.click('#cut-draw');
  assert.match(await hint(), /^Click on an edge/);
  await page.mouse.click(...(await at(0.5, 0.5)));
  assert.match(await hint(), /^A cut begins at an edge/);
  const x = await clickEdge(0.5);
  assert.match(await hint(), /^Click on an edge/);
  await drapes(async () => page.mouse.dblclick(...(await at(x + 0.12, 0.52))));
  assert.equal(await hint(), '');
  const [{ path }] = await cutsOf();
  const [[a, b, c]] = path;
  const [d, e, f] = path.at(-1);
  assert.ok(Math.abs(Math.max(Math.abs(a), Math.abs(b)) - 2) < 1e-4, `${a} ${b} ${c}`);
  assert.ok(Math.max(Math.abs(d), Math.abs(e)) < 1.9, `${d} ${e} ${f}`);
  const { cuts, rim } = await ask(`v1/drapes/${idOf(page)}/result`);
  assert.deepEqual(cuts.name, ['cut_1']);
  assert.deepEqual([...new Set(rim.cut)].sort(), [-1, 0, 1]);
  assert.match(
    await page.textContent('#cut-list li p'),
    /m long; .*° at the tip, .* m at the mouth/,
  );
  await picture(page, 'cuts');
  assert.deepEqual(await violations(page), []);
});

test('cuts: the tip is dragged, and moved by keys; undo takes it back', async () => {
  const drawnFirst = await points(1);
  const tip = page.locator('#cut-knobs .tip');
  const box = await tip.boundingBox();
  await drapes(async () => {
    await page.mouse.move(box.x + 7, box.y + 7);
    await page.mouse.down();
    await page.mouse.move(box.x + 30, box.y + 20, { steps: 4 });
    await page.mouse.up();
  });
  const dragged = await points(1);
  assert.notEqual(dragged, drawnFirst);
  const [{ path }] = await cutsOf();
  assert.equal(path.map((point) => point.join(' ')).join('; '), dragged);
  await tip.focus();
  await drapes(() => page.keyboard.press('ArrowRight'));
  assert.notEqual(await points(1), dragged);
  await drapes(() => page.click('#undo'));
  assert.equal(await points(1), dragged);
  await drapes(() => page.keyboard.press('Control+z'));
  assert.equal(await points(1), drawnFirst);
  await drapes(() => page.keyboard.press('Control+Shift+z'));
  assert.equal(await points(1), dragged);
  await drapes(() => page.keyboard.press('Control+z'));
  assert.ok(await page.isEnabled('#redo'));
});

test('cuts: the mouth is dragged along the edge, and Delete removes the line', async () => {
  const before = await points(1);
  const mouth = page.locator('#cut-knobs .corner').first();
  const box = await mouth.boundingBox();
  await drapes(async () => {
    await page.mouse.move(box.x + 5, box.y + 5);
    await page.mouse.down();
    await page.mouse.move(box.x + 25, box.y - 15, { steps: 4 });
    await page.mouse.up();
  });
  const [{ path }] = await cutsOf();
  const [a, b] = path[0].map(Math.abs);
  assert.notEqual(await points(1), before);
  assert.ok(Math.abs(Math.max(a, b) - 2) < 1e-4, `${a} ${b}`); // the saddle reaches from -2 to 2
  assert.equal(path.at(-1).join(' '), before.split('; ').at(-1));
  await page.locator('#cut-knobs .tip').focus();
  await drapes(() => page.keyboard.press('Delete'));
  assert.deepEqual(await cutsOf(), []);
  await drapes(() => page.click('#undo'));
  await drapes(() => page.click('#undo'));
  assert.equal(await points(1), before);
});

test('cuts: Ctrl+Z in a field is the field its own', async () => {
  await page.focus('#cut-name-0');
  await page.keyboard.press('Control+z');
  assert.equal(await page.locator('#cut-list li').count(), 1);
});

test('cuts: they have names, and what is wrong is said at the cut', async () => {
  await drapes(async () => {
    await page.fill('#cut-name-0', 'corner');
    await page.press('#cut-name-0', 'Enter');
  });
  assert.equal((await cutsOf())[0].name, 'corner');
  const field = page.locator('#cut-list li input:nth-of-type(2)');
  await field.fill('0.5 0.5 0; 0.1 0.1 0');
  await field.press('Enter');
  await page.waitForSelector('#fault-of-cut-name-0');
  assert.match(await page.textContent('#fault-of-cut-name-0'), /begins inside|passes the start/);
  await drapes(() => page.click('#undo'));
  await drapes(() => page.click('#cut-list li button'));
  assert.deepEqual(await cutsOf(), []);
  assert.equal(await page.locator('#cut-knobs .tip').count(), 0);
  await page.click('#cut-draw');
  await clickEdge(0.5);
  await page.keyboard.press('Escape');
  assert.equal(await page.locator('#cut-list li').count(), 0);
});

test('cuts: a line over an edge of a box stays on the part', async () => {
  await drapeExample(page, 'corner');
  await page.click('#cut-draw');
  await clickEdge(0.5);
  const [x, y] = await at(0.5, 0.5);
  await drapes(() => page.mouse.dblclick(x, y));
  const [{ path }] = await cutsOf();
  assert.ok(path.length > 2);
  for (const [a, b, c] of path)
    assert.ok(Math.min(Math.abs(a), Math.abs(b), Math.abs(c)) < 0.05, `${a} ${b} ${c}`);
});

test('cuts: points snap to the folds of a box, and to their ends', async () => {
  await drapes(() => page.click('#cut-list li button'));
  const request = await ask(`v1/drapes/${idOf(page)}/request`);
  await openRequest({ ...request, cuts: [{ path: EDGE }] });
  await page.click('#drape');
  await page.waitForFunction(() => document.querySelector('#cut-list li p').textContent);
  const boxes = await page.locator('#cut-knobs button').all();
  const [mouth, tip] = await Promise.all(boxes.map((knob) => knob.boundingBox()));
  await drapes(() => page.click('#cut-list li button'));
  await page.click('#cut-draw');
  await page.mouse.click(mouth.x + 2, mouth.y + 1);
  await drapes(() => page.mouse.dblclick(tip.x + 4, tip.y + 10));
  const [{ path }] = await cutsOf();
  for (const [k, point] of [path[0], path.at(-1)].entries())
    assert.ok(
      point.every((x, axis) => Math.abs(x - EDGE[k][axis]) < 1e-4),
      `${point}`,
    );
});

test('cuts: a study proposes some, which are ghosts until they are taken', async () => {
  await openRequest({ ...(await ask(`v1/drapes/${idOf(page)}/request`)), cuts: [{ path: EDGE }] });
  await page.click('#cut-list li button');
  await page.click('#drape');
  await page.waitForFunction(() =>
    /cells, solved/.test(document.querySelector('#state').textContent),
  );
  const before = (await ask(`v1/drapes/${idOf(page)}`)).summary;
  assert.equal(before.outcome, 'partial');
  await page.click('#propose');
  await page.waitForSelector('#proposed-list li');
  assert.match(await page.textContent('#propose-state'), /^With all of these: shear up to /);
  assert.match(await page.getAttribute('#proposed-lines', 'd'), /^M[\d.]+,/);
  assert.deepEqual(await cutsOf(), []);
  await drapes(() => page.click('#proposed-all'));
  const after = (await ask(`v1/drapes/${idOf(page)}`)).summary;
  assert.equal(after.outcome, 'complete');
  assert.ok(after.max_shear_deg <= 45 && before.max_shear_deg > 45, `${after.max_shear_deg}`);
  assert.ok((await cutsOf()).every(({ name }) => /^proposed_/.test(name)));
  assert.ok(await page.isHidden('#proposed'));
  await drapes(() => page.click('#undo'));
  assert.deepEqual(await cutsOf(), []);
});

test('cuts: the picture of the docs', async () => {
  const small = await openPage(browser, daemon.url, {
    width: 1200,
    height: 700,
    deviceScaleFactor: 0.65,
  });
  await drapeExample(small, 'corner');
  const request = await ask(`v1/drapes/${idOf(small)}/request`);
  await openRequest({ ...request, cuts: [{ path: EDGE, name: 'edge' }] }, small);
  await small.click('#drape');
  await small.waitForFunction(() => document.querySelector('#cut-list li p').textContent);
  assert.match(await small.textContent('#cut-list li p'), /dart, 90° at the tip/);
  await small.locator('#cut-draw').evaluate((button) => button.scrollIntoView());
  await small.locator('#pane-solid').focus();
  for (let k = 0; k < 8; k++) await small.keyboard.press('ArrowLeft');
  await drawn(small);
  const shot = await picture(small, 'docs_cuts');
  assert.ok(shot.length < 150e3, `${shot.length} bytes`);
  await small.context().close();
});
