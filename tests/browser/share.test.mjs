// SPDX-License-Identifier: MIT
// Work that is shown to others: by a link that reads and can be taken back, and as one file that is
// opened at another service.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import {
  colours,
  difference,
  drawn,
  openPage,
  picture,
  root,
  startBrowser,
  startDaemon,
  violations,
} from './helper.mjs';

const SPLIT = [
  [0, 80, 0],
  [0, 0, 0],
  [90, 0, 0],
]; // round the top of the example `corner`, along its folds
const CUT = [
  [90, 40, 0],
  [60, 40, 0],
];
const folder = mkdtempSync(join(tmpdir(), 'draped-share-'));
const tokens = join(folder, 'tokens');
let browser, one, other, page, saved, anna, part;

before(async () => {
  const program = join(root, process.env.BUILD || 'build', 'draped');
  anna = 'a-token-of-anna-that-nobody-guesses';
  writeFileSync(tokens, execFileSync(program, ['hash-token', 'anna', 'write'], { input: anna }));
  one = await startDaemon({ flags: ['--tokens', tokens] });
  other = await startDaemon();
  part = (await ask('surfaces', corner().surface)).id;
  browser = await startBrowser();
  page = await openAsAnna();
});

after(async () => {
  await browser?.close();
  await one?.stop();
  await other?.stop();
  rmSync(folder, { recursive: true });
});

/** What the first service answers to anna, to GET or, with a body, POST. */
async function ask(path, body) {
  const headers = {
    Authorization: `Bearer ${anna}`,
    'Content-Type': 'application/json',
    Prefer: 'wait=40',
  };
  const method = body === undefined ? 'GET' : 'POST';
  const answer = await fetch(new URL(`v1/${path}`, one.url), {
    method,
    headers,
    body: body && JSON.stringify(body),
  });
  assert.ok(answer.ok, await answer.clone().text());
  return answer.json();
}

const corner = () => JSON.parse(readFileSync(join(root, 'api/examples/corner.json')));

/** Work with everything in it: a cut, steered generators, a split, plies, a study that is asked. */
const work = () => ({
  format: 'draped-work',
  version: 1,
  surface: corner().surface,
  request: {
    ...corner(),
    surface: { id: part },
    cuts: [{ path: CUT, name: 'dart' }],
    generators: { warp: 'least_energy', weft: 'least_energy' },
  },
  pieces: { splits: [{ path: SPLIT }], seam: { overlap: 8 } },
  stack: {
    plies: [0, 45].map((angle_deg) => ({
      name: `at ${angle_deg}`,
      fabric: corner().fabric,
      start: corner().start,
      direction: { angle_deg },
      repeat: 2,
    })),
    side: -1,
  },
  study: { asked: { 'find-starts': '4', 'find-step': '90' } },
  view: { field: 'shear_signed', view: 'solid', over: 'pieces' },
  draped: { one: true, pieces: true, stack: true },
});

async function openWork(on, document, name = 'whole.draped.json') {
  const buffer = Buffer.from(JSON.stringify(document));
  await on.setInputFiles('#file', { name, mimeType: 'application/json', buffer });
  await on.waitForFunction(() =>
    /plies are draped/.test(document.querySelector('#stack-state').textContent),
  );
  await drawn(on);
}

async function savedWork(on) {
  const [download] = await Promise.all([on.waitForEvent('download'), on.click('#save-work')]);
  assert.equal(download.suggestedFilename(), 'whole.draped.json');
  return JSON.parse(readFileSync(await download.path()));
}

/** The page of whom the service asks for a token. */
async function openAsAnna() {
  const context = await browser.newContext({ viewport: { width: 1440, height: 900 } });
  const mine = await context.newPage();
  await mine.addInitScript((token) => sessionStorage.setItem('draped-token', token), anna);
  await mine.goto(one.url);
  await mine.waitForSelector('html[data-ready]');
  return mine;
}

/** What a page shows, in words and numbers. */
const told = (on) =>
  on.evaluate(() => {
    const text = (id) => document.getElementById(id).innerText;
    const plies = [...document.querySelectorAll('#plies li input')].map(({ value }) => value);
    const summary = text('summary').replace(/Queue, solve\n.*/, '');
    return {
      summary,
      plies,
      pieces: text('pieces-list').split('\n').length,
      seams: text('pieces-seams'),
      cuts: document.querySelectorAll('#cut-list li').length,
      splits: document.querySelectorAll('#split-list li').length,
      field: document.getElementById('field').value,
      found: text('find-state').replace(/ in [\d.]+ s/, ''),
      pressed: document.getElementById('pieces-show').ariaPressed,
    };
  });

test('share: a file with everything opens, is draped, and is saved as it was opened', async () => {
  await openWork(page, work());
  await page.click('#find');
  await page.waitForFunction(() =>
    /variants from/.test(document.querySelector('#find-state').textContent),
  );
  await page.click('#pieces-show');
  await drawn(page);
  saved = await savedWork(page);
  assert.deepEqual(saved.request.cuts, work().request.cuts);
  assert.ok(saved.request.generators);
  assert.deepEqual(saved.pieces.splits, work().pieces.splits);
  assert.deepEqual(saved.pieces.seam, { overlap: 8 });
  assert.deepEqual(
    saved.stack.plies.map(({ name, direction, repeat }) => [name, direction.angle_deg, repeat]),
    [
      ['at 0', 0, 2],
      ['at 45', 45, 2],
    ],
  );
  assert.equal(saved.stack.side, -1);
  assert.equal(saved.study.result.variants.x.length, 8);
  assert.equal(saved.view.over, 'pieces');
  assert.deepEqual(saved.request.surface, { id: part });
  assert.equal(saved.surface.faces.length, 3, 'the stored part goes along');
  await picture(page, 'share_own');
});

test('share: opened at another service the file shows the same', async () => {
  const far = await openPage(browser, other.url);
  await openWork(far, saved);
  assert.deepEqual(await told(far), await told(page));
  assert.deepEqual(far.faults, []);
  assert.ok((await colours(far, '#pane-solid')) > 30);
  const again = await savedWork(far);
  const without = ({ study, draped, ...rest }) => ({ ...rest, study: study.asked });
  assert.deepEqual(without(again), without(saved));
  await far.context().close();
});

test('share: a file of another version, or of nothing, says so', async () => {
  const far = await openPage(browser, other.url);
  for (const [document, words] of [
    [{ ...work(), version: 2 }, /another version/],
    [{ format: 'draped-work', version: 1 }, /not a surface|This JSON/],
  ]) {
    const buffer = Buffer.from(JSON.stringify(document));
    await far.setInputFiles('#file', { name: 'x.json', mimeType: 'application/json', buffer });
    await far.waitForFunction(() => document.querySelector('#fault-surface').textContent);
    assert.match(await far.textContent('#fault-surface'), words);
  }
  await far.context().close();
});

let address = '';

test('share: a link shows a colleague without a token the same, and changes nothing', async () => {
  await page.click('#share');
  await page.waitForSelector('#share-made:not([hidden])');
  address = await page.inputValue('#share-address');
  assert.match(
    address,
    /#link=draped-link-[\w-]{43}&drape=\w{32}&pieces=\w{32}&stack=\w{32}&study=/,
  );
  const colleague = await openPage(browser, address);
  const writes = [];
  colleague.on('request', (request) => {
    if (request.method() !== 'GET') writes.push(`${request.method()} ${request.url()}`);
  });
  await colleague.reload();
  await colleague.waitForSelector('html[data-ready]');
  await drawn(colleague);
  assert.deepEqual(await told(colleague), await told(page));
  assert.ok((await colours(colleague, '#pane-solid')) > 30);
  const [mine, hers] = await Promise.all(
    [page, colleague].map((on) => on.locator('#pane-solid').screenshot()),
  );
  assert.ok((await difference(page, mine, hers)) < 0.02);
  await picture(colleague, 'share_link');
  assert.deepEqual(await violations(colleague), []);
  for (const id of ['#drape', '#angle', '#method', '#find', '#stack-drape', '#ply-add'])
    assert.ok(await colleague.isDisabled(id), id);
  for (const id of ['#handle', '#cut-knobs', '#token-open', '#share', '#list'])
    assert.ok(await colleague.isHidden(id), id);
  await colleague.click('#pieces-list li:nth-child(2) button');
  await colleague.waitForFunction(() => /[?&#]drape=/.test(location.hash));
  const pane = await colleague.locator('#pane-solid').boundingBox();
  await colleague.mouse.dblclick(pane.x + pane.width / 2, pane.y + pane.height / 2);
  await colleague.click('#plies [data-do="look"]');
  await colleague.waitForSelector('#plies [data-do="look"][aria-pressed="true"]');
  await colleague.click('#find-best li button');
  const [download] = await Promise.all([
    colleague.waitForEvent('download'),
    colleague.click('#downloads a:text("CSV of cells")'),
  ]);
  assert.match(readFileSync(await download.path(), 'utf8'), /^i,j,shear_deg/);
  assert.deepEqual(
    writes.filter((call) => !/\/map\?/.test(call)),
    [],
  );
  assert.deepEqual(colleague.faults, []);
  await colleague.context().close();
});

test('share: a link that is taken back shows nothing any more, and says why', async () => {
  await page.click('#share-list summary');
  await page.waitForSelector('#share-links button');
  assert.match(await page.textContent('#share-links'), /drapes \w+, laminates \w+/);
  await page.click('#share-links button');
  await page.waitForFunction(() => document.querySelector('#share-links').textContent === 'None.');
  const late = await openPage(browser, address);
  assert.match(await late.textContent('#fault-general'), /has been taken back/);
  assert.ok(await late.isHidden('#token-dialog'));
  assert.match(await late.textContent('#readout'), /^Cell–/);
  await late.context().close();
});

test('share: of a part that is not stored a link shows the net alone', async () => {
  const { id } = await ask('drapes', corner());
  const { token } = await ask(`links?of=${id}`, null);
  const bare = await openPage(browser, `${one.url}#link=${token}&drape=${id}`);
  await drawn(bare);
  assert.ok((await colours(bare, '#pane-solid')) > 30);
  assert.deepEqual(bare.faults, []);
  await bare.context().close();
});

test('share: without a drape there is nothing to share', async () => {
  const far = await openPage(browser, other.url);
  await far.click('#share');
  await far.waitForFunction(() => document.querySelector('#fault-share').textContent);
  assert.match(await far.textContent('#fault-share'), /drape the part first/);
  await far.context().close();
});
