// SPDX-License-Identifier: MIT
// A page of another origin, and one whose name was made to point to the daemon, in a real browser:
// neither makes, sees or deletes anything.
import assert from 'node:assert/strict';
import { once } from 'node:events';
import { readFileSync } from 'node:fs';
import { createServer } from 'node:http';
import { join } from 'node:path';
import { after, before, beforeEach, test } from 'node:test';
import { root, startBrowser, startDaemon, WAIT } from './helper.mjs';

const saddle = readFileSync(join(root, 'api/examples/saddle.json'), 'utf8');
let daemon, browser, other, page;

/** What the daemon holds, asked without a browser. */
const drapes = async () => (await (await fetch(`${daemon.url}v1/drapes`)).json()).drapes;

before(async () => {
  daemon = await startDaemon({ flags: ['--workers', '1'] });
  browser = await startBrowser(['--host-resolver-rules=MAP attacker.example 127.0.0.1']);
  other = createServer((request, response) => {
    response.writeHead(200, { 'Content-Type': 'text/html' });
    response.end('<!doctype html><title>another origin</title>');
  });
  other.listen(0, '127.0.0.1');
  await once(other, 'listening');
});
/* Each test has a page of its own: what the one before has still to load does not concern it. */
beforeEach(async () => {
  page = await (await browser.newContext()).newPage();
  page.setDefaultTimeout(WAIT);
});
after(async () => {
  await browser?.close();
  other?.close();
  await daemon?.stop();
});

test('origin: a page of another origin can make no drape', async () => {
  await page.goto(`http://127.0.0.1:${other.address().port}/`);
  const target = `${daemon.url}v1/drapes`;
  await page.evaluate(
    async ({ target, body }) => {
      const post = (sent, headers = {}) =>
        fetch(target, { method: 'POST', mode: 'no-cors', body: sent, headers }).catch(() => null);
      await post(new Blob([body]));
      await post(new Blob([body], { type: 'text/plain' }));
      await post(body);
      await post(new Blob([body], { type: 'application/json' }));
      navigator.sendBeacon(target, new Blob([body]));
    },
    { target, body: saddle },
  );
  const form = `<form method="post" enctype="text/plain" action="${target}"><input name='{"a":"'
      value='"}'></form>`;
  const answered = page.waitForResponse(target);
  await page.evaluate((html) => {
    document.body.innerHTML = html;
    document.querySelector('form').submit();
  }, form);
  assert.equal((await answered).status(), 403);
  assert.deepEqual(await drapes(), []);
});

test('origin: a name that was made to point here opens nothing', async () => {
  const posted = await fetch(`${daemon.url}v1/drapes`, { method: 'POST', body: saddle });
  assert.equal(posted.status, 415); // fetch sends a string as text/plain
  const made = await fetch(`${daemon.url}v1/drapes`, {
    method: 'POST',
    body: saddle,
    headers: { 'Content-Type': 'application/json' },
  });
  assert.equal(made.status, 202);
  const { id } = await made.json();
  const answer = await page.goto(`http://attacker.example:${daemon.port}/`);
  assert.equal(answer.status(), 403);
  const statuses = await page.evaluate(async (drape) => {
    const calls = [
      ['/v1/drapes', 'GET'],
      [`/v1/drapes/${drape}/result`, 'GET'],
      [`/v1/drapes/${drape}`, 'DELETE'],
      [`/v1/drapes/${drape}/cancel`, 'POST'],
    ];
    const ask = async ([path, method]) => (await fetch(path, { method })).status;
    return Promise.all(calls.map(ask));
  }, id);
  assert.deepEqual(statuses, [403, 403, 403, 403]);
  assert.deepEqual(
    (await drapes()).map((drape) => drape.id),
    [id],
  );
});
