// SPDX-License-Identifier: MIT
// The rosette in the picture: shown, turned by the pointer and by keys, and the side of the plies.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { ask, difference, drapeExample, drawn, idOf, openOnce, page, picture } from './helper.mjs';

openOnce();

const RADIANS = Math.PI / 180;

/** The ends of an arm in the picture, pixels from the start. */
async function armOf(name) {
  await drawn(page);
  return page.locator(`#rosette-${name}`).evaluate((line) => {
    const at = (key) => Number(line.getAttribute(key));
    return [at('x2') - at('x1'), at('y2') - at('y1')];
  });
}

/** The request of the drape that is shown, when another is than `before`. */
async function requestAfter(before) {
  await page.waitForFunction((id) => !location.hash.includes(id), before);
  await page.waitForSelector('#stale', { state: 'hidden' });
  return ask(`v1/drapes/${idOf(page)}/request`);
}

const pictureOf = () => page.locator('#pane-solid').screenshot();

test('rosette: 0 degrees and the side are shown at the start, the default in words', async () => {
  assert.equal(await page.isVisible('#rosette-knob'), false);
  await drapeExample(page, 'saddle');
  await drawn(page);
  assert.ok(await page.isVisible('#rosette-knob'));
  const { summary } = await ask(`v1/drapes/${idOf(page)}`);
  assert.deepEqual(summary.start_axes, { zero: [1, 0, 0], side: [0, 0, 1] });
  assert.ok(await page.isVisible('#rosette-arm'));
  const arm = await armOf('arm');
  assert.ok(Math.hypot(...arm) > 20, `an arm of ${arm} pixels`);
  await page.click('#rosette summary');
  assert.match(await page.textContent('#rosette'), /does not depend on the face with the start/);
  await page.uncheck('#show-rosette');
  await drawn(page);
  assert.equal(await page.isVisible('#rosette-knob'), false);
  await page.check('#show-rosette');
  await drawn(page);
  await picture(page, 'rosette');
});

test('rosette: dragging the knob turns it, and the cloth with it', async () => {
  const before = idOf(page);
  const box = await page.locator('#rosette-knob').boundingBox();
  const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
  const [dx, dy] = await armOf('arm');
  await page.mouse.move(x, y);
  await page.mouse.down();
  await page.mouse.move(x - dx / 2 - dy, y - dy / 2 - dx / 2, { steps: 4 });
  await page.mouse.up();
  const { rosette } = await requestAfter(before);
  const along = rosette.x.map((value) => value / Math.hypot(...rosette.x));
  assert.ok(Math.abs(along[2]) < 1e-5 && along[0] < 0.99, `0 degrees along ${along}`);
  const { summary } = await ask(`v1/drapes/${idOf(page)}`);
  const off = Math.max(...summary.start_axes.zero.map((value, k) => Math.abs(value - along[k])));
  assert.ok(off < 1e-5, `the drape's 0 degrees are off by ${off}`);
  const turned = await armOf('arm');
  assert.ok(Math.hypot(turned[0] - dx, turned[1] - dy) > 20, 'the arm has turned');
  assert.deepEqual((await page.inputValue('#rosette-x')).split(', ').map(Number), rosette.x);
});

test('rosette: keys turn it by five degrees, with Shift by one', async () => {
  const angleOf = ({ rosette }) => Math.atan2(rosette.x[1], rosette.x[0]) / RADIANS;
  const before = angleOf(await ask(`v1/drapes/${idOf(page)}/request`));
  for (const [key, step] of [
    ['ArrowLeft', 5],
    ['Shift+ArrowRight', 4],
  ]) {
    const id = idOf(page);
    await page.focus('#rosette-knob');
    await page.keyboard.press(key);
    const after = angleOf(await requestAfter(id));
    assert.ok(Math.abs(after - before - step) < 1e-3, `${key}: from ${before} to ${after}`);
  }
});

test('rosette: an arrow and a preview show the side on which plies lie', async () => {
  const plain = await pictureOf();
  await page.click('#stack-preview');
  await drawn(page);
  const upper = await pictureOf();
  await picture(page, 'side');
  assert.ok((await difference(page, plain, upper)) > 0.02, 'the preview is seen');
  const [x, y] = await armOf('side');
  await page.check('#stack-other');
  const other = await armOf('side');
  assert.ok(
    Math.abs(other[0] + x) + Math.abs(other[1] + y) < 0.4 * Math.hypot(x, y),
    'turned over',
  );
  assert.ok(
    (await difference(page, upper, await pictureOf())) > 0.02,
    'the cloth is on the other side',
  );
  await page.click('#stack-preview');
  await page.uncheck('#stack-other');
  await drawn(page);
  assert.ok((await difference(page, plain, await pictureOf())) < 0.002, 'all is as before');
  assert.deepEqual(page.faults, []);
});
