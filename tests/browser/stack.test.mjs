// SPDX-License-Identifier: MIT
// A stack of plies on the page: its table, the drapes of all, and looking through them.
import assert from 'node:assert/strict';
import { join } from 'node:path';
import { test } from 'node:test';
import {
  ask,
  drapeExample,
  drawn,
  idOf,
  openOnce,
  page,
  picture,
  root,
  violations,
} from './helper.mjs';

openOnce();

const angles = () =>
  page.locator('#plies li input:nth-child(2)').evaluateAll((all) => all.map(({ value }) => value));
const press = (ply, what) => page.click(`#plies li:nth-child(${ply}) [data-do="${what}"]`);

test('stack: plies are added, copied, moved and mirrored', async () => {
  await drapeExample(page, 'saddle');
  await page.click('#ply-add');
  await press(1, 'copy');
  await page.fill('#plies li:nth-child(2) input:nth-child(2)', '45');
  await page.press('#plies li:nth-child(2) input:nth-child(2)', 'Enter');
  assert.deepEqual(await angles(), ['0', '45']);
  await press(1, 'down');
  assert.deepEqual(await angles(), ['45', '0']);
  assert.equal(
    await page.evaluate(() => document.activeElement.getAttribute('aria-label')),
    'down ply 2',
  );
  await page.click('#ply-mirror');
  assert.deepEqual(await angles(), ['45', '0', '0', '45']);
  await press(4, 'delete');
  assert.deepEqual(await angles(), ['45', '0', '0']);
});

test('stack: it is draped, equal plies once, and each can be looked at', async () => {
  await page.click('#stack-drape');
  await page.waitForFunction(() =>
    /plies are draped/.test(document.querySelector('#stack-state').textContent),
  );
  assert.equal(
    await page.textContent('#stack-state'),
    '3 of 3 plies are draped, 2 of them different.',
  );
  await page.waitForSelector('#plies li:nth-child(1) [aria-pressed="true"]');
  await drawn(page);
  const first = idOf(page);
  assert.equal((await ask(`v1/drapes/${first}/request`)).direction.angle_deg, 45);
  assert.equal(await page.inputValue('#angle'), '45');
  await press(2, 'look');
  await page.waitForFunction((id) => !location.hash.includes(id), first);
  assert.equal((await ask(`v1/drapes/${idOf(page)}/request`)).direction.angle_deg, 0);
  assert.equal(await page.locator('#plies [aria-pressed="true"]').count(), 2);
  assert.ok(await page.isHidden('#stale'));
  await picture(page, 'stack');
  assert.deepEqual(await violations(page), []);
});

test('stack: every ply has its pattern', async () => {
  const links = await page.locator('#plies a').evaluateAll((all) => all.map(({ href }) => href));
  assert.equal(links.length, 3);
  for (const link of links) assert.match(await (await fetch(link)).text(), /ENTITIES[^]*EOF/);
});

test('stack: the roll and the ply book are of the stack', async () => {
  const hrefs = () =>
    page.locator('#stack-links a').evaluateAll((all) => all.map(({ href }) => href));
  assert.match(await (await fetch((await hrefs())[0])).text(), /3 patterns on/);
  await page.fill('#stack-width', '9');
  await page.press('#stack-width', 'Enter');
  assert.match(await (await fetch((await hrefs())[1])).text(), /x 9 m of roll/);
  assert.match(await (await fetch((await hrefs())[2])).text(), /ASTM/);
  assert.match(await (await fetch((await hrefs())[3])).text(), /"layers":\[/);
  assert.match(await (await fetch((await hrefs())[4])).text(), /^PK[^]*manifest\.json/);
  assert.match(await (await fetch((await hrefs())[5])).text(), /3 plies, 3 layers.*draped on the/);
});

test('stack: the whole stack is mapped onto a mesh', async () => {
  await page.setInputFiles('#mesh-file', join(root, 'api/examples/mould.bdf'));
  await page.waitForSelector('#mesh-tools:not([hidden])');
  await page.selectOption('#field', 'thickness');
  const range = () => page.textContent('#mesh-range');
  await page.waitForFunction(() =>
    /Thickness/.test(document.querySelector('#mesh-range').textContent),
  );
  const one = await range();
  await page.check('#mesh-whole');
  await page.waitForFunction(
    (text) => document.querySelector('#mesh-range').textContent !== text,
    one,
  );
  // Three plies of 0.5 mm, each at least as thick as it was laid.
  const [, low] = /^Thickness: ([\d.]+)(?: × 10⁻³)? m? ?to/.exec(await range());
  assert.ok(Number(low) === 1.5 || Number(low) >= 0.0015, await range());
  // The legend is the scale of both: from the thinnest ply to the thickest stack.
  const powers = { '⁻³': 'e-3', '⁻⁴': 'e-4' };
  const ends = (text) =>
    text
      .replace(/ × 10(⁻[³⁴])/g, (_, power) => powers[power])
      .match(/[\d.]+(?:e-\d)?(?= )/g)
      .map(Number);
  const legend = await page.getAttribute('#scale svg', 'aria-label');
  const [thin, most] = [ends(one)[0], ends(await range())[1]];
  const [from, to] = ends(legend);
  assert.ok(
    Math.abs(from - thin) < 1e-5 && Math.abs(to - most) < 1e-4,
    `${legend}; ${one}; ${await range()}`,
  );
  const before = await range();
  await press(3, 'delete');
  await page.waitForFunction(
    (text) => document.querySelector('#mesh-range').textContent !== text,
    before,
  );
  assert.ok(await page.isHidden('#mesh-stack'));
});

test('stack: layers, laws, boundaries, offset and cavity are taken', async () => {
  const more = (ply, key) => page.locator(`#plies li:nth-child(${ply}) [data-key="${key}"]`);
  await page.click('#plies li:nth-child(1) summary');
  for (const [key, text] of [
    ['repeat', '2'],
    ['law', '0.2, 0.08'],
    ['boundary', '-1 -1 0; 1 -1 0; 1 1 0; −1 1 0'],
  ]) {
    await more(1, key).fill(text);
    await more(1, key).press('Enter');
  }
  await page.check('#stack-nominal');
  await page.check('#stack-other');
  await page.selectOption('#stack-cavity', 'height');
  await page.fill('#stack-height', '0.0014');
  assert.ok(await page.isHidden('#stack-roll'));
  const [answer] = await Promise.all([
    page.waitForResponse((response) => /v1.laminates$/.test(response.url())),
    page.click('#stack-drape'),
  ]);
  await page.waitForSelector('#stack-roll:not([hidden])');
  const asked = await ask(`v1/laminates/${(await answer.json()).id}/request`);
  assert.deepEqual(asked.cavity, { height: 0.0014 });
  assert.equal(asked.offset, 'nominal');
  assert.equal(asked.side, -1);
  assert.equal(asked.plies[0].repeat, 2);
  assert.deepEqual(asked.plies[0].compaction, { a: 0.2, b: 0.08 });
  assert.equal(asked.plies[0].boundary.polygons[0].length, 4);
  assert.equal(asked.plies[1].repeat, 1);
  await picture(page, 'stack-more');
  assert.deepEqual(await violations(page), []);
  await page.selectOption('#stack-cavity', 'flexible');
});

test('stack: a boundary is drawn on the part, and taken', async () => {
  const box = await page.locator('#pane-solid').boundingBox();
  const at = (x, y) => [box.x + x * box.width, box.y + y * box.height];
  await page.click('#mesh-close');
  const field = page.locator('#plies li:nth-child(1) [data-key="boundary"]');
  await page.click('#plies li:nth-child(1) [data-do="draw"]');
  assert.match(await page.textContent('#hint'), /^Click the corners/);
  for (const place of [at(0.35, 0.45), at(0.47, 0.5), at(0.5, 0.65)])
    await page.mouse.click(...place);
  await drawn(page);
  assert.equal((await page.getAttribute('#outline', 'd')).split(' ').length, 3);
  await page.mouse.click(...at(0.05, 0.05));
  assert.match(await page.textContent('#hint'), /^That is beside the part/);
  await page.mouse.dblclick(...at(0.38, 0.65));
  assert.equal(await page.textContent('#hint'), '');
  const corners = (await field.inputValue()).split('; ').map((text) => text.split(' ').map(Number));
  assert.equal(corners.length, 4);
  for (const [x, y, z] of corners)
    assert.ok(Math.abs(z - (x * x - y * y) / 2) < 0.05, `${x} ${y} ${z}`);
  await picture(page, 'stack-outline');
  await page.click('#plies li:nth-child(1) [data-do="draw"]');
  await page.mouse.click(...at(0.4, 0.4));
  await page.keyboard.press('Escape');
  assert.equal((await field.inputValue()).split('; ').length, 4);
  await page.click('#stack-drape');
  await page.waitForSelector('#stack-roll:not([hidden])');
  assert.equal(await page.textContent('#fault-stack'), '');
});

test('stack: what is wrong is said with its place', async () => {
  await page.fill('#spacing', '0');
  await page.click('#ply-add');
  await page.click('#stack-drape');
  await page.waitForFunction(() => document.querySelector('#fault-stack').textContent);
  assert.match(await page.textContent('#fault-stack'), /^\/plies\/2\/fabric\/spacing: /);
  const faults = page.faults.filter((fault) => !/status of 4\d\d/.test(fault));
  assert.deepEqual(faults, []);
});
