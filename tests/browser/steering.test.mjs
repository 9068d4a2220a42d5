// SPDX-License-Identifier: MIT
// Generators on the page: of least energy with what they save, and steered by knobs.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
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
  root,
  violations,
} from './helper.mjs';

openOnce();

const generatorsOf = async (on = page) => (await ask(`v1/drapes/${idOf(on)}/request`)).generators;
const summaryOf = async (on = page) => (await ask(`v1/drapes/${idOf(on)}`)).summary;

/** Does something, and waits until another drape is shown for good. */
async function drapes(what, on = page) {
  const before = idOf(on);
  await what();
  await on.waitForFunction((id) => !location.hash.includes(id), before);
  await on.waitForFunction(() => document.querySelector('#stale').hidden);
  await drawn(on);
}

const middle = ({ x, y, width, height }) => [x + width / 2, y + height / 2];

/** Drags a knob by pixels: how much of the pointer's way it goes that lies along its own. */
async function drag(knob, [right, down], on = page) {
  const [x, y] = middle(await knob.boundingBox());
  await drapes(async () => {
    await on.mouse.move(x, y);
    await on.mouse.down();
    await on.mouse.move(x + right, y + down, { steps: 3 });
    await on.mouse.up();
  }, on);
  const [a, b] = middle(await knob.boundingBox());
  const own = [a - x, b - y];
  return (own[0] * right + own[1] * down) / Math.hypot(...own) ** 2;
}

test('steering: generators of least energy cost less, and the page says by how much', async () => {
  await drapeExample(page, 'freeform');
  const before = await summaryOf();
  await drapes(() => page.selectOption('#generators', 'least_energy'));
  const { steering, max_shear_deg: shear } = await summaryOf();
  assert.ok(shear < 0.7 * before.max_shear_deg, `${shear} and ${before.max_shear_deg}`);
  assert.ok(steering.energy_after < 0.5 * steering.energy_before);
  const told = await page.textContent('#summary');
  const share = Math.round(100 * (1 - steering.energy_after / steering.energy_before));
  assert.match(told, /Energy, geodesics/);
  assert.ok(Math.abs(Number(/−([\d.]+) %/.exec(told)[1]) - share) <= 1, told);
  assert.deepEqual((await generatorsOf()).warp, { steered: { points: 4 } });
  assert.equal(await page.locator('#steer-knobs button').count(), 0);
});

test('steering: knobs begin with what was found, and that is the same drape', async () => {
  const found = await summaryOf();
  await drapes(() => page.selectOption('#generators', 'steered'));
  const { warp, weft } = await generatorsOf();
  assert.deepEqual(warp, found.steering.generators.warp);
  assert.deepEqual(weft, found.steering.generators.weft);
  const { max_shear_deg: shear } = await summaryOf();
  assert.ok(Math.abs(shear - found.max_shear_deg) < 1e-6, `${shear} ${found.max_shear_deg}`);
  assert.equal(await page.locator('#steer-knobs button').count(), 16);
  assert.deepEqual(await violations(page), []);
});

test('steering: a knob is dragged, its generator follows the pointer, and undo takes it back', async () => {
  await drapeExample(page, 'saddle');
  await drapes(() => page.selectOption('#generators', 'steered'));
  const flat = await generatorsOf();
  assert.ok(flat.warp.steered.values.every((value) => value === 0));
  for (const [kind, n, way] of [
    ['warp', 7, [0, -30]],
    ['warp', 1, [0, 20]],
    ['weft', 6, [25, 0]],
  ]) {
    const knob = page.locator(`#steer-knobs .${kind}`).nth(n);
    const share = await drag(knob, way);
    assert.ok(Math.abs(share - 1) < 0.25, `${kind} ${n}: ${share}`);
  }
  const { warp, weft } = await generatorsOf();
  const side = (values, from) => values.slice(from, from + 4).some((value) => value !== 0);
  assert.deepEqual([side(warp.steered.values, 0), side(warp.steered.values, 4)], [true, true]);
  assert.deepEqual([side(weft.steered.values, 0), side(weft.steered.values, 4)], [false, true]);
  await drapes(() => page.click('#undo'));
  assert.deepEqual((await generatorsOf()).weft, flat.weft);
  await drapes(() => page.keyboard.press('Control+z'));
  await drapes(() => page.keyboard.press('Control+z'));
  assert.deepEqual(await generatorsOf(), flat);
  const knob = page.locator('#steer-knobs .warp').nth(7);
  await knob.focus();
  await drapes(() => page.keyboard.press('ArrowUp'));
  assert.notDeepEqual(await generatorsOf(), flat);
  await drapes(() => page.selectOption('#generators', ''));
  assert.deepEqual(await generatorsOf(), { warp: 'geodesic', weft: 'geodesic' });
  assert.equal(await page.locator('#steer-knobs button').count(), 0);
});

test('steering: generators that a file says once are those of warp and of weft', async () => {
  const bent = { steered: { points: 2, values: [0, 5e-4, 2e-4, 0] } };
  const example = JSON.parse(readFileSync(join(root, 'api/examples/freeform.json')));
  for (const [generators, choice] of [
    ['least_energy', 'least_energy'],
    [bent, 'steered'],
  ]) {
    const buffer = Buffer.from(JSON.stringify({ ...example, generators }));
    await page.setInputFiles('#file', { name: 'part.json', mimeType: 'application/json', buffer });
    await page.waitForFunction(
      (value) => document.querySelector('#generators').value === value,
      choice,
    );
    await page.click('#drape');
    await page.waitForFunction(() => location.hash.includes('drape='));
    await drawn(page);
    const { warp, weft } = await generatorsOf();
    assert.deepEqual(warp.steered.values, generators.steered?.values);
    assert.deepEqual(weft, warp);
  }
});

test('steering: what cannot be steered is said at the choice', async () => {
  await drapeExample(page, 'tray');
  await page.selectOption('#generators', 'steered');
  await page.waitForSelector('#fault-of-generators');
  await drapes(() => page.click('#undo'));
});

test('steering: the picture of the docs', async () => {
  const options = { width: 1200, height: 700, deviceScaleFactor: 0.65 };
  const small = await openPage(browser, daemon.url, options);
  await drapeExample(small, 'freeform');
  await drapes(() => small.selectOption('#generators', 'least_energy'), small);
  await drapes(() => small.selectOption('#generators', 'steered'), small);
  await small.locator('#angle').evaluate((field) => field.scrollIntoView());
  await small.locator('#summary').evaluate((list) => list.scrollIntoView());
  await drawn(small);
  const shot = await picture(small, 'docs_steering');
  assert.ok(shot.length < 150e3, `${shot.length} bytes`);
  await small.context().close();
});
