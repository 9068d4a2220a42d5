// SPDX-License-Identifier: MIT
// For the tests of the page: a daemon of their own on a free port, and Chromium without a window.
import { spawn } from 'node:child_process';
import { once } from 'node:events';
import { existsSync, mkdirSync, mkdtempSync, readdirSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { dirname, join } from 'node:path';
import { createRequire } from 'node:module';
import { createInterface } from 'node:readline';
import { after, before } from 'node:test';
import { fileURLToPath } from 'node:url';
import { chromium } from 'playwright-core';

export const root = join(dirname(fileURLToPath(import.meta.url)), '../..');
const axe = readFileSync(createRequire(import.meta.url).resolve('axe-core/axe.min.js'), 'utf8');
const build = process.env.BUILD || 'build';
/** Where screenshots are kept. */
export const pictures = join(root, build, 'tests/browser');
export const WAIT = 60000; // how long a test waits for what must come

/** The workers of the daemon. */
function workersOf(pid) {
  const tasks = readdirSync(`/proc/${pid}/task`);
  const lists = tasks.map((task) => readFileSync(`/proc/${pid}/task/${task}/children`, 'utf8'));
  const children = lists.flatMap((list) => list.split(' ').filter(Boolean).map(Number));
  return children.filter((child) => {
    const line = readFileSync(`/proc/${child}/cmdline`, 'utf8');
    return line.startsWith('draped\0worker');
  });
}

/** Starts the daemon on `port` (0: a free one): {url, stop, kill}. */
export async function startDaemon({
  port = 0,
  data = mkdtempSync(join(tmpdir(), 'draped-')),
  flags = [],
} = {}) {
  const program = join(root, build, 'draped');
  const listen = ['--listen', `127.0.0.1:${port}`, '--data', data, '--log-level', 'error'];
  const child = spawn(program, [...listen, ...flags], { stdio: ['ignore', 'pipe', 'inherit'] });
  const ended = once(child, 'exit');
  const first = await Promise.race([once(createInterface({ input: child.stdout }), 'line'), ended]);
  const url = /http:\S+/.exec(String(first[0]))?.[0];
  if (!url) throw new Error(`the daemon did not start: ${first}`);
  const end = async (signal) => {
    child.kill(signal);
    await ended;
  };
  return {
    url: `${url}/`,
    data,
    port: Number(new URL(url).port),
    kill: () => end('SIGKILL'),
    stopWorkers: () => {
      for (const worker of workersOf(child.pid)) process.kill(worker, 'SIGSTOP');
    },
    stop: async () => {
      await end('SIGTERM');
      rmSync(data, { recursive: true, force: true });
    },
  };
}

/** Chromium with a software renderer, so that WebGL is there on every machine; `flags` beside. */
export async function startBrowser(flags = []) {
  const executablePath = [
    '/usr/bin/chromium',
    '/usr/bin/chromium-browser',
    '/usr/bin/google-chrome',
  ].find(existsSync);
  if (!executablePath) throw new Error('there is no chromium: deploy/setup.sh test installs it');
  mkdirSync(pictures, { recursive: true });
  const args = ['--use-angle=swiftshader', '--enable-unsafe-swiftshader', ...flags];
  if (process.getuid() === 0) args.push('--no-sandbox');
  return chromium.launch({ executablePath, args });
}

/** A page that notes errors of the console and requests to anywhere but the daemon. */
export async function openPage(browser, url, { width = 1440, height = 900, ...options } = {}) {
  const context = await browser.newContext({
    viewport: { width, height },
    colorScheme: 'light',
    ...options,
  });
  const page = await context.newPage();
  page.setDefaultTimeout(WAIT);
  page.faults = [];
  const origin = new URL(url).origin;
  page.on('pageerror', (error) => page.faults.push(`error: ${error.message}`));
  page.on('console', (message) => {
    if (message.type() === 'error') page.faults.push(`console: ${message.text()}`);
  });
  page.on('request', (request) => {
    const local =
      request.url().startsWith(`${origin}/`) || request.url().startsWith(`blob:${origin}`);
    if (!local) page.faults.push(`outside: ${request.url()}`);
  });
  await page.goto(url);
  await page.waitForSelector('html[data-ready]');
  return page;
}

/** What `openOnce` has started, for all tests of a file. */
export let daemon, browser, page;

/** Starts a daemon, a browser and a page before the tests of the file, and ends them after. */
export function openOnce() {
  before(async () => {
    daemon = await startDaemon();
    browser = await startBrowser();
    page = await openPage(browser, daemon.url);
  });
  after(async () => {
    await browser?.close();
    await daemon?.stop();
  });
}

/** What the daemon of `openOnce` answers to GET. */
export const ask = async (path) => (await fetch(new URL(path, daemon.url))).json();

export const picture = (page, name, options = {}) =>
  page.screenshot({ path: join(pictures, `${name}.png`), ...options });

/** Chooses an example, presses Drape, waits for the net. */
export async function drapeExample(page, name) {
  if ((await page.inputValue('#example')) !== name) {
    await page.selectOption('#example', name);
    await page.waitForFunction((hash) => location.hash.includes(hash), `example=${name}&`);
  }
  await page.click('#drape');
  await page.waitForFunction(() => /solved in/.test(document.querySelector('#state').textContent));
}

/** What the pointer is on has been found, and two frames later everything is drawn. */
export async function drawn(page) {
  await page.waitForSelector('#panes:not([data-looking])');
  await page.evaluate(
    () => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))),
  );
}

/** In the page: the pixels of PNG images. */
function pixelsOf(page, ...images) {
  return page.evaluateHandle(
    (sources) =>
      Promise.all(
        sources.map(async (source) => {
          const bytes = Uint8Array.from(atob(source), (letter) => letter.charCodeAt(0));
          const bitmap = await createImageBitmap(new Blob([bytes], { type: 'image/png' }));
          const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext('2d');
          context.drawImage(bitmap, 0, 0);
          return context.getImageData(0, 0, bitmap.width, bitmap.height).data;
        }),
      ),
    images.map((image) => image.toString('base64')),
  );
}

/** How many different colours, of 4096, an element shows: few when the picture is empty. */
export async function colours(page, selector) {
  const handle = await pixelsOf(page, await page.locator(selector).screenshot());
  return handle.evaluate(([data]) => {
    const seen = new Set();
    for (let k = 0; k < data.length; k += 4)
      seen.add(((data[k] >> 4) << 8) | ((data[k + 1] >> 4) << 4) | (data[k + 2] >> 4));
    return seen.size;
  });
}

/** The share of pixels in which two pictures differ clearly. */
export async function difference(page, one, two) {
  const handle = await pixelsOf(page, one, two);
  return handle.evaluate(([first, second]) => {
    let count = 0;
    for (let k = 0; k < first.length; k += 4)
      count += [0, 1, 2].some((c) => Math.abs(first[k + c] - second[k + c]) > 24);
    return count / (first.length / 4);
  });
}

/** The share of pixels that have nearly this colour, [red, green, blue]. */
export async function shareOf(page, image, colour) {
  const handle = await pixelsOf(page, image);
  return handle.evaluate(([data], wanted) => {
    let count = 0;
    for (let k = 0; k < data.length; k += 4)
      count += wanted.every((value, c) => Math.abs(data[k + c] - value) < 12);
    return count / (data.length / 4);
  }, colour);
}

/** Rules of axe-core that the page breaks. */
export async function violations(page) {
  await page.evaluate(axe);
  const { violations: found } = await page.evaluate(() => globalThis.axe.run());
  return found.map((rule) => `${rule.id}: ${rule.nodes.map((node) => node.target).join(' ')}`);
}

/** The drape that the page shows, by its address. */
export const idOf = (page) => /drape=(\w+)/.exec(page.url())[1];
