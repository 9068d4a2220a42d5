// SPDX-License-Identifier: MIT
// The example's front-end as Vite builds it, on an origin of its own, in a real browser against a real
// daemon that allows that origin; and what the element does with what it cannot show.
import assert from 'node:assert/strict';
import { createReadStream, existsSync } from 'node:fs';
import { createServer } from 'node:http';
import { extname, join } from 'node:path';
import { after, before, test } from 'node:test';
import {
  colours,
  difference,
  picture,
  root,
  shareOf,
  startBrowser,
  startDaemon,
  violations,
  WAIT,
} from '../browser/helper.mjs';

const site = join(root, 'clients/typescript/example/dist');
const TYPES = { '.html': 'text/html', '.js': 'text/javascript' };
const dome = join(root, 'api/examples/dome.step');
let server, daemon, browser, page, faults;

before(async () => {
  server = createServer(({ url }, response) => {
    const path = new URL(url, 'http://localhost').pathname;
    const file = join(site, path === '/' ? 'index.html' : path);
    if (!existsSync(file)) return response.writeHead(404).end();
    response.writeHead(200, { 'Content-Type': TYPES[extname(file)] });
    createReadStream(file).pipe(response);
  });
  await new Promise((done) => server.listen(0, '127.0.0.1', done));
  const origin = `http://127.0.0.1:${server.address().port}`;
  daemon = await startDaemon({ flags: ['--cors-origin', origin] });
  browser = await startBrowser();
  page = await (await browser.newContext({ viewport: { width: 1100, height: 700 } })).newPage();
  page.setDefaultTimeout(WAIT);
  faults = [];
  page.on('pageerror', (error) => faults.push(error.message));
  page.on('console', (message) => message.type() === 'error' && faults.push(message.text()));
  page.on('request', (request) => {
    if (![origin, daemon.url, 'blob:', 'data:'].some((start) => request.url().startsWith(start)))
      faults.push(`outside: ${request.url()}`);
  });
  await page.goto(`${origin}/?url=${daemon.url.replace(/\/$/, '')}`);
});
after(async () => {
  await browser?.close();
  await daemon?.stop();
  server?.closeAllConnections();
  server?.close();
});

const says = (words) =>
  page.waitForFunction(
    (text) => document.querySelector('output[name=state]').value.includes(text),
    words,
  );
/** The next event of the element, by its name; ask before what causes it. */
const next = (name) =>
  page.evaluate(
    (event) =>
      new Promise((done) =>
        document
          .querySelector('draped-part')
          .addEventListener(event, ({ detail }) => done(detail?.message ?? detail), { once: true }),
      ),
    name,
  );
const drawn = () =>
  page.evaluate(
    () => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))),
  );
const view = () => page.locator('draped-part');
/** Where the middle of the element is in the window. */
async function middle() {
  const { x, y, width, height } = await view().boundingBox();
  return [x + width / 2, y + height / 2];
}

test('part: a STEP file is uploaded, its faces are shown, pointed at and chosen', async () => {
  const loaded = next('draped-load');
  await page.setInputFiles('input[type=file]', dome);
  const { kind, count } = await loaded;
  assert.deepEqual([kind, count], ['faces', 9]);
  await says('9 faces.');
  await drawn();
  assert.ok((await colours(page, 'draped-part')) > 20);
  const before = await view().screenshot();
  const picked = next('draped-pick');
  await page.mouse.click(...(await middle()));
  const { face } = await picked;
  assert.ok(face >= 0 && face < 9, `face ${face}`);
  await page.waitForFunction(() =>
    /^face \d$/.test(document.querySelector('output[name=place]').innerText),
  );
  await page.mouse.move(5, 5);
  await drawn();
  const after = await view().screenshot();
  assert.ok((await difference(page, before, after)) > 0.01, 'the chosen face is marked');
  await page.mouse.click(...(await middle()));
  assert.deepEqual(await page.evaluate(() => document.querySelector('draped-part').chosen), []);
});

test('part: the chosen faces are draped, coloured with a scale, and a cell tells its numbers', async () => {
  await page.evaluate(() => (document.querySelector('draped-part').chosen = [6, 7, 8]));
  const loaded = next('draped-load');
  await page.click('button');
  const { kind, count, fields } = await loaded;
  assert.equal(kind, 'net');
  assert.deepEqual(
    fields.map(({ key }) => key),
    ['shear', 'shear_signed'],
  );
  await says(`: ${count} cells, `);
  const [drape] = (await (await fetch(`${daemon.url}v1/drapes`)).json()).drapes;
  assert.equal(drape.summary.cells, count);
  const request = await (await fetch(`${daemon.url}v1/drapes/${drape.id}/request`)).json();
  assert.deepEqual(request.fabric.spacing, [5, 5]);
  const scale = page.locator('draped-part #scale svg');
  assert.match(await scale.getAttribute('aria-label'), /^Shear angle, absolute: 0 to [\d.]+°$/);
  const picked = next('draped-pick');
  await page.mouse.click(...(await middle()));
  const { i, j, cell, values } = await picked;
  const { cells } = await (await fetch(`${daemon.url}v1/drapes/${drape.id}/result`)).json();
  assert.deepEqual([cells.i[cell], cells.j[cell]], [i, j]);
  assert.equal(values.shear_deg, cells.shear_deg[cell]);
  await drawn();
  await picture(page, 'example');
  assert.ok((await colours(page, 'draped-part')) > 60);
});

test('part: another field has other colours and another scale', async () => {
  await page.mouse.move(5, 5);
  await drawn();
  const before = await view().screenshot();
  await page.selectOption('select', 'shear_signed');
  await drawn();
  const label = await page.locator('draped-part #scale svg').getAttribute('aria-label');
  assert.match(label, /^Shear angle, signed: −[\d.]+ to [\d.]+°$/);
  assert.ok((await difference(page, before, await view().screenshot())) > 0.05);
});

test('part: it turns with the pointer and with the keys', async () => {
  const before = await view().screenshot();
  const [x, y] = await middle();
  await page.mouse.move(x, y);
  await page.mouse.down();
  await page.mouse.move(x + 120, y, { steps: 4 });
  await page.mouse.up();
  await page.mouse.move(5, 5);
  await page.waitForTimeout(600); // what was coarse while it moved is drawn in full
  const turned = await view().screenshot();
  assert.ok((await difference(page, before, turned)) > 0.02);
  await page.locator('draped-part #pane').focus();
  await page.keyboard.press('Home');
  await page.waitForTimeout(600);
  assert.ok((await difference(page, turned, await view().screenshot())) > 0.02);
});

test('part: the pattern is offered as a file', async () => {
  const text = await page.evaluate(async () =>
    (await fetch(document.querySelector('a[download]').href)).text(),
  );
  assert.match(text, /AC1009[\s\S]*CUT/);
});

test('part: what is no part says so in the page and as an event', async () => {
  await page.setInputFiles('input[type=file]', {
    name: 'letter.step',
    mimeType: 'model/step',
    buffer: Buffer.from('This is no STEP file.'),
  });
  await says('STEP');
  assert.match(await page.locator('output[name=state]').innerText(), /STEP/);
  for (const [source, words] of [
    [`${daemon.url}v1/drapes/${'0'.repeat(32)}`, /no drape/],
    [`${daemon.url}version`, /cannot be reached|neither a drape/],
    ['http://127.0.0.1:9/v1/drapes/00', /cannot be reached/],
  ]) {
    const failed = next('draped-error');
    await page.evaluate(
      (src) => document.querySelector('draped-part').setAttribute('src', src),
      source,
    );
    assert.match(await failed, words, source);
    assert.match(await page.locator('draped-part #state').innerText(), words);
  }
  faults = faults.filter(
    (fault) =>
      !/status of 4|ERR_UNSAFE_PORT|ERR_CONNECTION|outside: http:\/\/127.0.0.1:9/.test(fault),
  );
});

test('part: taken out and put back it shows its part again; twenty times over no context is lost', async () => {
  const { drapes } = await (await fetch(`${daemon.url}v1/drapes`)).json();
  const source = `${daemon.url}v1/drapes/${drapes[0].id}`;
  const counts = await page.evaluate(async (src) => {
    const element = document.querySelector('draped-part');
    element.setAttribute('src', src);
    const counts = [];
    for (let k = 0; k < 20; k++) {
      const { parentNode } = element;
      element.remove();
      const loaded = new Promise((done) =>
        element.addEventListener('draped-load', ({ detail }) => done(detail.count), { once: true }),
      );
      parentNode.append(element);
      counts.push(await loaded);
    }
    return counts;
  }, source);
  assert.deepEqual(new Set(counts).size, 1);
  await drawn();
  assert.ok((await colours(page, 'draped-part')) > 60);
  const grey = await shareOf(page, await view().screenshot(), [128, 128, 128]);
  assert.ok(grey < 0.05);
});

test('part: the page keeps the rules of accessibility, without an error in the console', async () => {
  assert.deepEqual(await violations(page), []);
  assert.deepEqual(faults, []);
});
