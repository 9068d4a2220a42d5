// SPDX-License-Identifier: MIT
// "Find the best start": a study from the page, its map, its plots, and its variants as drapes.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import {
  ask,
  browser,
  colours,
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

const found = () =>
  page.waitForFunction(() =>
    /variants from/.test(document.querySelector('#find-state').textContent),
  );
/** The shear that a text of the page begins with or names. */
const shearIn = (text) => Number(/([\d.]+)°/.exec(text)[1]);

async function find(starts, step) {
  await page.fill('#find-starts', String(starts));
  await page.fill('#find-step', String(step));
  await page.click('#find');
  await found();
}

/** Moves a slider as somebody would. */
const slide = (selector, value) =>
  page.$eval(
    selector,
    (slider, wanted) => {
      slider.value = wanted;
      slider.dispatchEvent(new Event('input', { bubbles: true }));
    },
    value,
  );

test('study: the best of many starts is found, with a map over the part', async (context) => {
  await drapeExample(page, 'freeform');
  const begun = Date.now();
  await find(20, 30);
  context.diagnostic(`120 variants are shown after ${Date.now() - begun} ms`);
  assert.match(
    await page.textContent('#find-state'),
    /^120 variants from 20 starts in [\d.]+ s: (drapable in one piece|not .*one piece: .* at \()/,
  );
  assert.equal(await page.getAttribute('#find-map', 'aria-pressed'), 'true');
  await drawn(page);
  assert.ok((await colours(page, '#pane-solid')) > 100);
  const box = await page.locator('#pane-solid').boundingBox();
  await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
  await drawn(page);
  assert.match(await page.textContent('#chip'), /^best from this start: [\d.]+°, at −?[\d.]+°$/);
  assert.match(
    await page.textContent('#caption-map'),
    /^Greatest shear .* from each start \(dot\)/,
  );
  assert.ok(await page.isHidden('#caption-solid'));
  const least = Number(/^[\d.]+/.exec(await page.textContent('#map-scale text'))[0]);
  assert.ok(Math.abs(least - shearIn(await page.textContent('#find-best button'))) < 0.06);
  await picture(page, 'study');
  assert.deepEqual(await violations(page), []);
});

test('study: its best is what the service says', async () => {
  const { studies } = await ask('v1/studies?limit=1');
  const { variants } = await ask(`v1/studies/${studies[0].id}/result?format=json`);
  const whole = variants.max_shear_deg.filter((_, row) => variants.cloth_coverage[row] >= 0.99);
  const least = Math.min(...whole);
  const shown = shearIn(await page.textContent('#find-best button'));
  assert.ok(Math.abs(shown - least) < 0.06, `${shown} and ${least}`);
});

test('study: limits leave out variants, and say so when none is left', async () => {
  const most = Number(await page.getAttribute('#find-shear', 'max'));
  const points = () => page.locator('#find-front .faint').count();
  const all = await points();
  assert.ok(all > 50, `${all} points`);
  await slide('#find-shear', Math.round(0.7 * most));
  assert.ok((await points()) < all);
  await slide('#find-shear', await page.getAttribute('#find-shear', 'min'));
  assert.match(await page.textContent('#find-now'), /^No variant keeps these limits/);
  await slide('#find-shear', most);
  assert.equal(await points(), all);
});

test('study: its best is draped by a key, and compared with the drape before', async () => {
  const before = idOf(page);
  const { summary } = await ask(`v1/drapes/${before}`);
  const promised = shearIn(await page.textContent('#find-best button'));
  await page.focus('#find-best button');
  await page.keyboard.press('Enter');
  await page.waitForFunction((id) => !location.hash.includes(id), before);
  const best = (await ask(`v1/drapes/${idOf(page)}`)).summary;
  assert.ok(Math.abs(best.max_shear_deg - promised) < 0.1, `${best.max_shear_deg}, ${promised}`);
  assert.ok(best.max_shear_deg < summary.max_shear_deg);
  assert.equal(await page.getAttribute('#find-map', 'aria-pressed'), 'false');
  await page.click('#find-compare');
  await page.waitForFunction((id) => location.hash.includes(`compare=${id}`), before);
  await drawn(page);
  await picture(page, 'study_best');
  await page.click('#compare-end');
});

test('study: a click on the plots and on the map drapes that variant', async () => {
  for (const selector of ['#find-front .faint', '#find-polar .dot']) {
    const before = idOf(page);
    await page.locator(selector).nth(1).click({ force: true });
    await page.waitForFunction((id) => !location.hash.includes(id), before);
  }
  await page.click('#find-map');
  await drawn(page);
  const before = idOf(page);
  const box = await page.locator('#pane-solid').boundingBox();
  await page.mouse.click(box.x + 0.4 * box.width, box.y + 0.6 * box.height);
  await page.waitForFunction((id) => !location.hash.includes(id), before);
});

test('study: what is refined is better, and checked on the net of the drape', async () => {
  const before = shearIn(await page.textContent('#find-best button'));
  await page.check('#find-optimise');
  await page.click('#find');
  await page.waitForFunction(() =>
    /^240 variants/.test(document.querySelector('#find-state').textContent),
  );
  await page.uncheck('#find-optimise');
  const { studies } = await ask('v1/studies?limit=1');
  const { best, variants } = await ask(`v1/studies/${studies[0].id}/result?format=json`);
  assert.equal(variants.coarseness[best.max_shear_deg], 1);
  const refined = shearIn(await page.textContent('#find-best button'));
  assert.ok(Math.abs(refined - variants.max_shear_deg[best.max_shear_deg]) < 0.06);
  assert.ok(refined < before, `${refined} and ${before}`);
});

test('study: of what the request has a cavity and a permeability for, too', async () => {
  const other = await openPage(browser, daemon.url);
  const offered = (key) => other.isEnabled(`#find-objective option[value="${key}"]`);
  await drapeExample(other, 'hemisphere');
  await other.fill('#find-starts', '6');
  await other.fill('#find-step', '45');
  const search = async () => {
    await other.click('#find');
    await other.waitForFunction(() => document.querySelector('#find').textContent === 'Stop');
    await other.waitForFunction(() => document.querySelector('#find').textContent !== 'Stop');
  };
  await search();
  assert.deepEqual(
    [await offered('k1_ratio_p95'), await offered('fiber_volume_fraction_range')],
    [true, false],
  );
  await other.fill('#thickness', '0.5');
  await other.fill('#fraction', '0.4');
  await other.fill('#cavity', '0.5');
  await search();
  for (const [key, written] of [
    ['k1_ratio_p95', /^Best: [\d.]+ ×/],
    ['fiber_volume_fraction_range', /^Best: [\d.]+[.,;]/],
  ]) {
    await other.selectOption('#find-objective', key);
    assert.match(await other.textContent('#find-now'), written);
  }
  await picture(other, 'study_fraction');
  assert.deepEqual(other.faults, []);
  await other.context().close();
});

test('study: of a wanted direction of the warp, too', async () => {
  await page.fill('#find-starts', '5');
  await page.fill('#find-step', '30');
  await page.fill('#find-wanted', '1, 0');
  await page.click('#find');
  await page.waitForFunction(() => document.querySelector('#fault-find').textContent);
  assert.match(await page.textContent('#fault-find'), /has three numbers/);
  await page.fill('#find-wanted', '0, 1, 0');
  await find(5, 30);
  await page.selectOption('#find-objective', 'angle_deviation_deg');
  const { studies } = await ask('v1/studies?limit=1');
  const { variants } = await ask(`v1/studies/${studies[0].id}/result?format=json`);
  const whole = variants.angle_deviation_deg.filter((_, k) => variants.cloth_coverage[k] >= 0.99);
  const shown = shearIn(await page.textContent('#find-best button'));
  assert.ok(Math.abs(shown - Math.min(...whole)) < 0.06, `${shown} and ${Math.min(...whole)}`);
  assert.ok(shown < 45, `${shown}`);
  await page.selectOption('#find-objective', 'max_shear_deg');
  await page.fill('#find-wanted', '');
});

test('study: the picture of the docs', async () => {
  const small = await openPage(browser, daemon.url, {
    width: 1200,
    height: 700,
    deviceScaleFactor: 0.65,
  });
  await drapeExample(small, 'freeform');
  await small.click('#find');
  await small.waitForFunction(() =>
    /variants from/.test(document.querySelector('#find-state').textContent),
  );
  await small.locator('#find-best').evaluate((list) => list.scrollIntoView());
  await drawn(small);
  const shot = await picture(small, 'docs_study');
  assert.ok(shot.length < 150e3, `${shot.length} bytes`);
  await small.context().close();
});

test('study: it stops when it is told to, and says what is wrong with it', async () => {
  await page.fill('#find-starts', '400');
  await page.fill('#find-step', '1');
  await page.click('#find');
  await page.waitForFunction(() => document.querySelector('#find').textContent === 'Stop');
  await page.click('#find');
  await page.waitForFunction(() => document.querySelector('#find').textContent !== 'Stop');
  await page.fill('#find-starts', '0');
  await page.click('#find');
  await page.waitForFunction(() => document.querySelector('#fault-find').textContent);
  assert.match(await page.textContent('#fault-find'), /start/);
  const faults = page.faults.filter((fault) => !/status of 4\d\d/.test(fault));
  assert.deepEqual(faults, []);
});
