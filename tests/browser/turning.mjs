// SPDX-License-Identifier: MIT
// How many pictures a second the page draws while a part is turned by the pointer, in Chromium
// without a graphics card: nets, and meshes that a drape is mapped on. Each picture is waited for
// before the next move, so that none is counted that was not drawn. Beside it the time of processors
// that Chromium takes for one, which depends less on what else the machine does.
// Run it by itself: node tests/browser/turning.mjs
import { drapeExample, openPage, startBrowser, startDaemon } from './helper.mjs';

const MOVES = 40;
const LIMIT_MS = 20000; // of a case, whatever it has drawn until then
const NETS = [
  ['saddle', '0.06'],
  ['saddle', '0.0185'],
  ['freeform', ''],
  ['saddle', '0.0058'],
];
const MESHES = [
  ['quads', 100],
  ['quads', 316],
  ['triangles', 224],
];

/** A mesh of `count` by `count` quads, or of twice as many triangles, on the saddle. */
function meshOf(kind, count) {
  const lines = [];
  const at = (k) => -2 + (4 * k) / count;
  const number = (value) => value.toFixed(5).slice(0, 8);
  for (let j = 0; j <= count; j++)
    for (let i = 0; i <= count; i++) {
      const place = [at(i), at(j), (at(i) ** 2 - at(j) ** 2) / 2];
      lines.push(`GRID,${j * (count + 1) + i + 1},,${place.map(number).join(',')}`);
    }
  let id = 1;
  for (let j = 0; j < count; j++)
    for (let i = 0; i < count; i++) {
      const a = j * (count + 1) + i + 1;
      const [b, c, d] = [a + 1, a + count + 2, a + count + 1];
      if (kind === 'quads') lines.push(`CQUAD4,${id++},1,${a},${b},${c},${d}`);
      else lines.push(`CTRIA3,${id++},1,${a},${b},${c}`, `CTRIA3,${id++},1,${a},${c},${d}`);
    }
  return lines.join('\n');
}

/** In the page: waits for what was asked to be drawn. */
async function finish() {
  const gl = document.querySelector('#canvas').getContext('webgl2');
  await new Promise(requestAnimationFrame); // the page's own callback came first
  gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
}

/** Seconds of processors that all processes of the browser have taken. */
async function processorTime() {
  const { processInfo } = await session.send('SystemInfo.getProcessInfo');
  return processInfo.reduce((sum, { cpuTime }) => sum + cpuTime, 0);
}

/** ms of each picture while the pointer turns the part, and of processors for one. */
async function turn(page) {
  const box = await page.locator('#pane-solid').boundingBox();
  const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
  await page.mouse.move(x, y);
  await page.waitForTimeout(1500); // at rest, so that the cost of a picture in full is known
  await page.mouse.down();
  await page.mouse.move(x + 1, y);
  await page.evaluate(finish);
  const times = [];
  const taken = await processorTime();
  const begun = performance.now();
  let last = begun;
  for (let k = 1; k <= MOVES && last - begun < LIMIT_MS; k++) {
    await page.mouse.move(x + 4 * k, y + 2 * k);
    await page.evaluate(finish);
    const now = performance.now();
    times.push(now - last);
    last = now;
  }
  const each = (1000 * ((await processorTime()) - taken)) / times.length;
  await page.mouse.up();
  return { times, each };
}

function print(name, count, { times, each }) {
  const sorted = times.toSorted((a, b) => a - b);
  const at = (part) => sorted[Math.floor(part * sorted.length)].toFixed(0).padStart(6);
  const rate = (1000 * times.length) / times.reduce((sum, time) => sum + time, 0);
  console.log(
    `${name.padEnd(16)} ${count.padStart(17)} ${rate.toFixed(1).padStart(5)} a second; ms each: ` +
      `median ${at(0.5)}  95 % ${at(0.95)}  processors ${each.toFixed(0).padStart(6)}`,
  );
}

const [only = ''] = process.argv.slice(2);
const daemon = await startDaemon();
const browser = await startBrowser();
const session = await browser.newBrowserCDPSession();

async function withPage(act) {
  const page = await openPage(browser, daemon.url);
  await act(page);
  await page.context().close();
}

for (const [name, spacing] of NETS)
  if ('net'.includes(only))
    await withPage(async (page) => {
      if (spacing) await page.fill('#spacing', spacing); // of the example that is there at first
      await drapeExample(page, name);
      const [cells] = /[\d,]+ cells/.exec(await page.textContent('#state'));
      print(name, cells, await turn(page));
    });
for (const [kind, count] of MESHES)
  if (kind.includes(only))
    await withPage(async (page) => {
      await drapeExample(page, 'saddle');
      const buffer = Buffer.from(meshOf(kind, count));
      await page.setInputFiles('#mesh-file', { name: 'mesh.bdf', mimeType: 'text/plain', buffer });
      await page.waitForSelector('#mesh-tools:not([hidden])');
      const [elements] = /[\d,]+ elements/.exec(await page.textContent('#mesh-about'));
      print(`mapped ${kind}`, elements, await turn(page));
    });
await browser.close();
await daemon.stop();
