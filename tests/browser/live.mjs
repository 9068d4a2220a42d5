// SPDX-License-Identifier: MIT
// How long a drape takes that follows the pointer: from the event to the net in the page, and to
// the picture drawn, by Chromium without a graphics card. Prints median and 95th percentile, in ms.
// Run it by itself: node tests/browser/live.mjs
import { drapeExample, openPage, startBrowser, startDaemon } from './helper.mjs';

const TURNS = 60;
const CASES = [
  ['saddle', '0.1'],
  ['saddle', '0.05'],
  ['saddle', '0.2'],
  ['torus', ''],
  ['octant', ''],
  ['freeform', ''],
];

/** In the page: turns the warp by a degree at a time; [[answered, drawn], ...] in ms. */
async function turn(turns) {
  const slider = document.querySelector('#angle-slider');
  const state = document.querySelector('#state');
  const gl = document.querySelector('#canvas').getContext('webgl2');
  const frame = () => new Promise(requestAnimationFrame);
  const times = [];
  for (let k = 1; k <= turns; k++) {
    const begun = performance.now();
    const answer = new Promise((done) => {
      const observer = new MutationObserver(() => {
        observer.disconnect();
        done(performance.now());
      });
      observer.observe(state, { childList: true });
    });
    slider.value = k;
    slider.dispatchEvent(new Event('input', { bubbles: true }));
    const answered = (await answer) - begun;
    await frame(); // the page's own callback of this frame came first
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4)); // waits for the picture
    times.push([answered, performance.now() - begun]);
    await new Promise((done) => setTimeout(done, 50));
  }
  return times.slice(5);
}

const daemon = await startDaemon();
const browser = await startBrowser();
for (const [name, spacing] of CASES) {
  const page = await openPage(browser, daemon.url);
  if (spacing) await page.fill('#spacing', spacing); // of the example that is there at first
  await drapeExample(page, name);
  const times = await page.evaluate(turn, TURNS);
  const text = [0, 1].map((which) => {
    const sorted = times.map((pair) => pair[which]).sort((a, b) => a - b);
    const at = (part) => sorted[Math.floor(part * sorted.length)].toFixed(0).padStart(4);
    return `${at(0.5)} ${at(0.95)}`;
  });
  const cells = /[\d,]+ cells/.exec(await page.textContent('#state'))[0];
  console.log(`${name.padEnd(9)} ${cells.padStart(13)}  net ${text[0]}  drawn ${text[1]}`);
  await page.context().close();
}
await browser.close();
await daemon.stop();
