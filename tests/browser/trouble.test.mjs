// SPDX-License-Identifier: MIT
// What goes wrong: bad files and values, a drape that is cancelled, a daemon that goes away, a
// browser without WebGL, a service that asks for a token. Each time a sentence, never a blank page.
import assert from 'node:assert/strict';
import {
  closeSync,
  ftruncateSync,
  mkdtempSync,
  openSync,
  readFileSync,
  rmSync,
  writeFileSync,
} from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import {
  colours,
  drapeExample,
  drawn,
  openPage,
  picture,
  root,
  startBrowser,
  startDaemon,
  WAIT,
} from './helper.mjs';

const folder = mkdtempSync(join(tmpdir(), 'draped-trouble-'));
const saddle = JSON.parse(readFileSync(join(root, 'api/examples/saddle.json')));
let daemon, browser, page;

before(async () => {
  daemon = await startDaemon({ flags: ['--max-body', '40M', '--workers', '1'] });
  browser = await startBrowser();
  page = await openPage(browser, daemon.url);
});
after(async () => {
  await browser?.close();
  await daemon?.stop();
  rmSync(folder, { recursive: true, force: true });
});

const textOf = (selector, where = page) => where.textContent(selector);
const becomes = (selector, pattern, where = page) =>
  where.waitForFunction(
    ([place, source]) => new RegExp(source).test(document.querySelector(place)?.textContent),
    [selector, pattern.source],
  );

/** Gives the page a file of that content. */
async function give(name, content) {
  const path = join(folder, name);
  writeFileSync(path, content);
  await page.setInputFiles('#file', path);
}

test('trouble: a file that is not JSON', async () => {
  await give('part.txt', 'ISO-10303-21; HEADER;');
  await becomes('#fault-surface', /part\.txt: 'txt' is not a format: .* must end in \.step, \.stp/);
  await give('part.json', 'ISO-10303-21; HEADER;');
  await becomes(
    '#fault-surface',
    /part\.json: This is not JSON.*Choose a surface or a drape request as a JSON file/,
  );
  page.faults.length = 0; // a refusal by the service is a line of the console
  assert.match(await textOf('#about'), /NURBS/, 'the surface before it is still there');
});

test('trouble: JSON that is no surface', async () => {
  await give('list.json', '{"rows": [1, 2, 3]}');
  await becomes('#fault-surface', /list\.json: This JSON is not a surface: that needs degree_u/);
  for (const [name, content] of [
    ['null.json', 'null'],
    ['number.json', '5'],
    ['empty.json', ''],
  ]) {
    await give(name, content);
    await becomes('#fault-surface', new RegExp(`${name}: This (is|JSON)`));
  }
});

test('trouble: half a surface', async () => {
  const whole = saddle.surface;
  const halves = [
    { degree_u: 2 },
    { ...whole, control_points: undefined },
    { ...whole, control_points: { points: whole.control_points.points.map(() => 1) } },
    { ...whole, control_points: { points: [[1, 2]] } },
    { vertices: [[0, 0, 0]] },
    { vertices: [1, 2], triangles: 3 },
  ];
  for (const [k, half] of halves.entries()) {
    await give(`half${k}.json`, JSON.stringify({ shape: { type: 'surface', data: [half] } }));
    await becomes('#about', new RegExp(`half${k}.json`));
    await becomes('#fault-surface', /cannot be shown|needs vertices/);
  }
  assert.deepEqual(page.faults, []);
});

test('trouble: a file of 50 MB', async () => {
  const path = join(folder, 'large.json');
  const file = openSync(path, 'w');
  ftruncateSync(file, 50e6);
  closeSync(file);
  await page.setInputFiles('#file', path);
  await becomes(
    '#fault-surface',
    /large\.json has 50 MB; this service takes 42 MB\. Export a coarser surface/,
  );
});

test('trouble: a dropped file of 50 MB', async () => {
  await give('null.json', 'null'); // another sentence than the one that is to come
  await becomes('#fault-surface', /null\.json/);
  await page.evaluate(() => {
    const transfer = new DataTransfer();
    transfer.items.add(new File([new Uint8Array(50e6)], 'dropped.json'));
    const event = new DragEvent('drop', {
      dataTransfer: transfer,
      bubbles: true,
      cancelable: true,
    });
    document.querySelector('#pane-solid').dispatchEvent(event);
    if (!event.defaultPrevented) throw new Error('the browser would open the file instead');
  });
  await becomes('#fault-surface', /dropped\.json has 50 MB; this service takes 42 MB/);
});

test('trouble: a surface whose sizes do not fit shows the error at its place', async () => {
  const { size_u, ...rest } = saddle.surface;
  await give('torn.json', JSON.stringify({ ...saddle, surface: { ...rest, size_u: size_u + 1 } }));
  await becomes('#fault-surface', /cannot be shown/);
  await page.click('#drape');
  await becomes('#fault-surface', /^\/surface.*: .*number/);
  await picture(page, 'bad-surface');
});

test('trouble: a valid surface that cannot be draped', async () => {
  const points = saddle.surface.control_points.points.map(() => [1, 2, 3]);
  await give(
    'point.json',
    JSON.stringify({ ...saddle, surface: { ...saddle.surface, control_points: { points } } }),
  );
  await becomes('#about', /point\.json/);
  await page.click('#drape');
  await page.waitForFunction(() =>
    [...document.querySelectorAll('#request .fault')].some((fault) => fault.textContent),
  );
  const said = await page.locator('#request .fault').allTextContents();
  assert.match(said.join(''), /surface|area|tangent|degenerate/i);
  assert.ok(await page.isEnabled('#drape'));
});

test('trouble: a value out of range is said at its field', async () => {
  await page.selectOption('#example', 'saddle');
  await becomes('#about', /^NURBS/);
  for (const [id, value, pattern] of [
    ['spacing', '-1', /must be a number between/],
    ['fraction', '1.5', /must be a number/],
    ['locking', 'steep', /must be a number/],
    ['start', '3, 3', /domain|outside|between|within/],
  ]) {
    const right = await page.inputValue(`#${id}`);
    await page.fill(`#${id}`, value);
    await page.click('#drape');
    await page.waitForSelector(`#${id}[aria-invalid="true"]`);
    const fault = await page.getAttribute(`#${id}`, 'aria-describedby');
    assert.match(await textOf(`#${fault}`), pattern);
    assert.equal(await page.evaluate(() => document.activeElement.id), id);
    if (id === 'spacing') await picture(page, 'bad-value');
    await page.fill(`#${id}`, right);
  }
  await drapeExample(page, 'saddle');
  assert.equal(await page.locator('[aria-invalid]').count(), 0);
});

test('trouble: a spacing that leaves no cell', async () => {
  await page.fill('#spacing', '50');
  await page.click('#drape');
  await page.waitForSelector('#spacing[aria-invalid="true"]');
  assert.match(
    await textOf('#fault-of-spacing'),
    /so large that the net has no cell: a spacing of 0\.44 m gives 144/,
  );
  await page.fill('#spacing', '0.00001');
  await page.click('#drape');
  await becomes('#fault-of-spacing', /is too small: .* nodes, and \d+ are allowed/);
  await page.fill('#spacing', '0.1');
  await drapeExample(page, 'saddle');
  assert.equal(await textOf('#hint'), '');
});

test('trouble: cancel stops a drape that runs', async () => {
  await page.fill('#spacing', '0.0032');
  await page.click('#drape');
  await becomes('#state', /running/);
  daemon.stopWorkers(); // so that it runs for as long as this takes
  await picture(page, 'running');
  await page.click('#cancel');
  await becomes('#state', /Cancelled/);
  const { drapes } = await (await fetch(new URL('v1/drapes?limit=1', daemon.url))).json();
  assert.equal(drapes[0].status, 'cancelled');
  assert.ok(await page.isEnabled('#drape'));
  assert.ok(await page.isDisabled('#cancel'));
});

test('trouble: a daemon that is restarted while it drapes', async () => {
  await page.selectOption('#method', 'geodesic'); // slow, with few cells to be drawn
  await page.fill('#spacing', '0.012');
  await page.click('#drape');
  await becomes('#state', /running/);
  await daemon.kill();
  await becomes('#state', /does not answer; trying again/);
  daemon = await startDaemon({ port: daemon.port, data: daemon.data, flags: ['--workers', '1'] });
  await becomes('#state', /solved in/);
  assert.match(await textOf('#summary'), /Outcomecomplete/);
  await page.selectOption('#method', 'gib');
});

test('trouble: a daemon that is gone', async () => {
  await page.fill('#spacing', '0.1');
  await daemon.kill();
  await page.click('#drape');
  await becomes('#fault-general', /The service does not answer\. Check that draped runs/);
  await picture(page, 'gone');
  daemon = await startDaemon({ port: daemon.port, data: daemon.data });
  await page.click('#drape');
  await becomes('#state', /solved in/);
  assert.equal(await textOf('#fault-general'), '');
});

test('trouble: a daemon that goes while one turns the angle, and comes back', async () => {
  await daemon.kill();
  await page.focus('#angle-slider');
  await page.keyboard.press('ArrowRight');
  await becomes('#fault-general', /The service does not answer/);
  daemon = await startDaemon({ port: daemon.port, data: daemon.data });
  const before = page.url();
  await page.keyboard.press('ArrowRight');
  await page.waitForFunction((url) => location.href !== url, before);
  await becomes('#state', /cells in \d+ ms/);
  assert.equal(await textOf('#fault-general'), '');
});

test('trouble: the link of a drape that is gone', async () => {
  const url = page.url().replace(/drape=\w+/, `drape=${'0'.repeat(32)}`);
  const other = await openPage(browser, url);
  await becomes('#fault-general', /The drape of this link is gone/, other);
  assert.equal(await other.inputValue('#spacing'), '0.1');
  await other.click('#drape');
  await becomes('#state', /solved in/, other);
  await other.context().close();
});

// anna:write, of the token below.
const ANNA = 'anna:write:bd9bf43011eaca25159f897a6ebef895e75c3f33d6334e45a0004e9a3b22c97d\n';
const TOKEN = 'open-sesame-open-sesame-1234';

test('trouble: a service that asks for a token', async () => {
  const tokens = join(mkdtempSync(join(tmpdir(), 'draped-')), 'tokens');
  writeFileSync(tokens, ANNA);
  const locked = await startDaemon({ flags: ['--tokens', tokens] });
  const context = await browser.newContext({ viewport: { width: 1440, height: 900 } });
  const other = await context.newPage();
  other.setDefaultTimeout(WAIT);
  await other.goto(locked.url);
  await other.waitForSelector('#token-dialog[open]');
  assert.equal(await textOf('#message', other), 'This service asks for a token.');
  await other.fill('#token', `${TOKEN}5`);
  await other.press('#token', 'Enter');
  await becomes('#fault-token', /does not accept this token/, other);
  await other.waitForSelector('#token-dialog[open]');
  await other.fill('#token', TOKEN);
  await picture(other, 'token');
  await other.press('#token', 'Enter');
  await other.waitForSelector('#token-dialog:not([open])', { state: 'attached' });
  await drapeExample(other, 'saddle');
  assert.match(await other.textContent('#curl'), /Authorization: Bearer \$DRAPED_TOKEN/);
  const [download] = await Promise.all([
    other.waitForEvent('download'),
    other.click('#downloads a:text("CSV of cells")'),
  ]);
  assert.match(readFileSync(await download.path(), 'utf8'), /^i,j,shear_deg/);
  assert.equal(
    await other.evaluate((token) => JSON.stringify(localStorage).includes(token), TOKEN),
    false,
    'the token is not kept beyond the tab',
  );
  await context.close();
  await locked.stop();
});

test('trouble: a browser without WebGL', async () => {
  const blind = await startBrowser(['--disable-3d-apis']);
  try {
    const other = await openPage(blind, daemon.url);
    await becomes('#hint', /has no WebGL 2.*Turn on hardware acceleration/, other);
    await drapeExample(other, 'saddle');
    assert.match(await other.textContent('#summary'), /Outcomecomplete/);
    await other.fill('#cell-i', '3');
    await other.fill('#cell-j', '4');
    await other.press('#cell-j', 'Enter');
    assert.match(await other.textContent('#readout'), /Cell\(3, 4\)/);
    assert.ok((await colours(other, '#histogram')) > 10);
    await picture(other, 'no-webgl');
  } finally {
    await blind.close();
  }
});

test('trouble: a million cells are shown, and change their colours', async () => {
  const other = await openPage(browser, daemon.url);
  await other.evaluate(() => {
    globalThis.resized = 0; // which would wait for all that is being drawn
    new MutationObserver((changes) => (globalThis.resized += changes.length)).observe(
      document.querySelector('#canvas'),
      { attributeFilter: ['width'] },
    );
  });
  await other.fill('#spacing', '0.0058');
  await other.click('#drape');
  await becomes('#state', /1,0\d\d,\d\d\d cells, solved/, other);
  await drawn(other);
  await picture(other, 'million');
  assert.equal(await other.evaluate(() => globalThis.resized), 0);
  assert.ok((await colours(other, '#panes')) > 200);
  // While it turns it has fewer triangles, and is the same part; at rest it is whole again.
  const box = await other.locator('#pane-solid').boundingBox();
  const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
  await other.mouse.move(x, y);
  await other.mouse.down();
  await other.mouse.move(x + 40, y);
  await drawn(other);
  const turning = await colours(other, '#pane-solid');
  assert.ok(turning > 100, `${turning} colours while it turns`);
  await other.mouse.up();
  await other.selectOption('#field', 'thickness');
  await drawn(other);
  assert.match(await other.getAttribute('#scale svg', 'aria-label'), /Thickness/);
  assert.deepEqual(other.faults, []);
  await other.context().close();
});
