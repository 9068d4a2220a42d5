// SPDX-License-Identifier: MIT
// A part of many faces on the page: a CAD file, the faces of its tool side, the drape of these.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { test } from 'node:test';
import {
  browser,
  daemon,
  drawn,
  openOnce,
  openPage,
  page,
  picture,
  pictures,
  root,
  violations,
} from './helper.mjs';

openOnce();

const count = () => page.textContent('#faces-count');
const settled = () =>
  page.waitForFunction(() => /solved in/.test(document.querySelector('#state').textContent));

/** A place of the picture in 3D, as shares of its width and height. */
async function placeAt(x, y) {
  const box = await page.locator('#pane-solid').boundingBox();
  return [box.x + x * box.width, box.y + y * box.height];
}

test('part: a STEP file shows its faces, and that it is a solid', async () => {
  await page.setInputFiles('#file', join(root, 'api/examples/dome.step'));
  await page.waitForSelector('#faces:not([hidden])');
  await drawn(page);
  assert.match(await count(), /^None of 9 faces is chosen yet: click/);
  assert.match(await page.textContent('#about'), /^dome\.step: 0 of 9 faces; 200 × 200 × 120 mm$/);
  assert.match(await page.textContent('#faces-notes'), /a solid: its faces are both skins/);
  assert.equal(await page.inputValue('#unit'), 'mm');
  assert.equal(await page.inputValue('#spacing'), '10');
});

test('part: before a face is chosen, what drapes says what to do', async () => {
  await page.click('#ply-add');
  for (const [button, fault] of [
    ['#drape', '#fault-general'],
    ['#find', '#fault-find'],
    ['#stack-drape', '#fault-stack'],
  ]) {
    await page.click(button);
    assert.match(await page.textContent(fault), /^No face is chosen: click on/);
  }
  await page.click('#plies [data-do="delete"]');
});

test('part: a click chooses a face, a button all that is smooth from there', async () => {
  const [x, y] = await placeAt(0.5, 0.35);
  await page.mouse.move(x, y);
  await drawn(page);
  assert.match(await page.textContent('#chip'), /^face 6: sphere/);
  await page.mouse.click(x, y);
  assert.match(await count(), /^1 of 9 faces is chosen, 1939\d mm²\.$/);
  await page.click('#faces-smooth');
  assert.match(await count(), /^3 of 9 faces are chosen, 4998\d mm²\.$/);
  await page.waitForFunction(() => /3 of 9/.test(document.querySelector('#about').textContent));
  await drawn(page);
  await picture(page, 'faces');
  assert.deepEqual(await violations(page), []);
});

test('part: a double click takes all that is smooth, and choices are taken back', async () => {
  const chosen = () =>
    page.$$eval('#faces-list input:checked', (boxes) => boxes.map(({ value }) => value).join());
  await page.click('#faces-none');
  await page.mouse.dblclick(...(await placeAt(0.5, 0.35)));
  assert.equal(await chosen(), '0,1,6');
  await page.click('#faces-undo');
  assert.equal(await chosen(), '');
  await page.click('#faces-undo');
  assert.equal(await chosen(), '0,1,6');
  await page.waitForFunction(() => document.querySelector('#spacing').value === '5');
});

test('part: faces that are chosen move no picture, and leave a spacing that somebody has said', async () => {
  const taken = (count) =>
    page.waitForFunction(
      (text) => document.querySelector('#about').textContent.includes(text),
      `${count} of 9`,
    );
  const bar = async () => {
    await drawn(page);
    return page.locator('#ruler').evaluate((ruler) => ruler.getBoundingClientRect().width);
  };
  const before = await bar();
  await page.fill('#spacing', '5'); // what is suggested for the three
  await page.click('#faces-all');
  await taken(9);
  assert.equal(await page.inputValue('#spacing'), '5');
  await page.click('#faces-none');
  await page.mouse.click(...(await placeAt(0.5, 0.35)));
  await taken(1);
  assert.equal(await bar(), before);
  for (let k = 0; k < 3; k++) await page.click('#faces-undo');
  await taken(3);
});

test('part: what is chosen is draped, and its link shows it again', async () => {
  await page.click('#drape');
  await settled();
  await drawn(page);
  await picture(page, 'part');
  assert.match(await page.textContent('#summary'), /Outcomecomplete/);
  const id = /drape=(\w+)/.exec(page.url())[1];
  const sent = await (await fetch(new URL(`v1/drapes/${id}/request`, daemon.url))).json();
  assert.deepEqual(sent.surface.faces, [0, 1, 6]);
  const link = await openPage(browser, page.url());
  await link.waitForFunction(() => /solved in/.test(document.querySelector('#state').textContent));
  assert.match(await link.textContent('#faces-count'), /^3 of 9 faces are chosen/);
  assert.equal(await link.getAttribute('#faces-open', 'aria-pressed'), 'false');
  assert.deepEqual(link.faults, []);
  await link.context().close();
});

test('part: another choice marks the drape as stale, and a click on the part moves its start', async () => {
  await page.click('details:has(#faces-list) summary');
  await page.uncheck('#faces-list input[value="0"]');
  assert.ok(await page.isVisible('#stale'));
  await page.check('#faces-list input[value="0"]');
  assert.ok(await page.isHidden('#stale'));
  await page.click('#place');
  await page.mouse.click(...(await placeAt(0.35, 0.55)));
  await page.waitForFunction(() => document.querySelector('#start').value.split(',').length === 3);
  await page.waitForFunction(() =>
    /cells in \d+ ms/.test(document.querySelector('#state').textContent),
  );
  assert.equal(await page.textContent('#fault-general'), '');
});

test('part: sweeping over the picture chooses, without turning it', async () => {
  await page.click('#faces-open');
  await page.click('#faces-none');
  await page.check('#faces-sweep');
  const eye = new URL(page.url()).hash;
  await page.mouse.move(...(await placeAt(0.5, 0.35)));
  await page.mouse.down();
  for (let k = 0; k <= 30; k++) await page.mouse.move(...(await placeAt(0.5, 0.35 + 0.015 * k)));
  await page.mouse.up();
  assert.match(await count(), /^[3-9] of 9 faces are chosen/);
  await page.uncheck('#faces-sweep');
  assert.equal(new URL(page.url()).hash.includes('eye='), eye.includes('eye='));
  assert.doesNotMatch(await count(), /both skins/);
  await page.click('#faces-all');
  assert.match(await count(), /^9 of 9 faces are chosen.* both skins/);
});

test('part: three hundred faces stay quick', async (context) => {
  const faces = [];
  const height = (x, y) => (x * x - y * y) / 100;
  for (let a = 0; a < 20; a++)
    for (let b = 0; b < 15; b++) {
      const points = [
        [a, b],
        [a, b + 1],
        [a + 1, b],
        [a + 1, b + 1],
      ].map(([x, y]) => [x, y, height(x, y)]);
      faces.push({
        degree_u: 1,
        degree_v: 1,
        size_u: 2,
        size_v: 2,
        knotvector_u: [0, 0, 1, 1],
        knotvector_v: [0, 0, 1, 1],
        control_points: { points },
      });
    }
  const buffer = Buffer.from(JSON.stringify({ faces }));
  const begun = Date.now();
  await page.setInputFiles('#file', { name: 'many.json', mimeType: 'application/json', buffer });
  await page.waitForFunction(() =>
    /of 300 faces/.test(document.querySelector('#faces-count').textContent),
  );
  await drawn(page);
  context.diagnostic(`300 faces are shown after ${Date.now() - begun} ms`);
  await page.click('#faces-open');
  await page.click('#faces-none');
  const clicked = Date.now();
  await page.mouse.click(...(await placeAt(0.5, 0.5)));
  await page.waitForFunction(() =>
    /^1 of 300/.test(document.querySelector('#faces-count').textContent),
  );
  await page.click('#faces-smooth');
  await page.waitForFunction(() =>
    /^300 of 300/.test(document.querySelector('#faces-count').textContent),
  );
  context.diagnostic(`a click and a growth take ${Date.now() - clicked} ms`);
  await drawn(page);
  await picture(page, 'many');
});

test('part: a mesh of triangles comes with mosaic and a likely unit', async () => {
  const corner = (x, y) => `vertex ${x} ${y} ${(x * y) / 400}`;
  const facets = [];
  for (let x = 0; x < 200; x += 20)
    for (let y = 0; y < 200; y += 20)
      for (const [p, q, r] of [
        [
          [0, 0],
          [20, 0],
          [20, 20],
        ],
        [
          [0, 0],
          [20, 20],
          [0, 20],
        ],
      ])
        facets.push(
          `facet normal 0 0 1\nouter loop\n${[p, q, r].map(([a, b]) => corner(x + a, y + b)).join('\n')}\nendloop\nendfacet`,
        );
  const buffer = Buffer.from(`solid s\n${facets.join('\n')}\nendsolid s\n`);
  await page.setInputFiles('#file', { name: 'twist.stl', mimeType: 'model/stl', buffer });
  await page.waitForFunction(() =>
    document.querySelector('#about').textContent.startsWith('twist.stl'),
  );
  assert.match(
    await page.textContent('#about'),
    /states no unit; mm is assumed\. mesh, 200 triangles; 200 × 200 × 100 mm/,
  );
  assert.equal(await page.inputValue('#method'), 'mosaic');
  assert.ok(await page.isHidden('#faces'));
  await page.click('#drape');
  await settled();
  assert.match(await page.textContent('#summary'), /Outcomecomplete/);
  assert.deepEqual(page.faults, []);
});

test('part: what is no STEP says so by the name of the file', async () => {
  const buffer = Buffer.from('This is no STEP file.');
  await page.setInputFiles('#file', { name: 'letter.step', mimeType: 'model/step', buffer });
  await page.waitForFunction(() => document.querySelector('#fault-surface').textContent);
  assert.match(await page.textContent('#fault-surface'), /^letter\.step: .*STEP/);
});

test('part: whoever goes on before a slow computer has read the file is not set back', async () => {
  const slow = await openPage(browser, daemon.url);
  await slow.evaluate(() => {
    const { postMessage } = Worker.prototype;
    Worker.prototype.postMessage = function (...message) {
      setTimeout(() => postMessage.apply(this, message), 2000);
    };
  });
  await slow.setInputFiles('#file', join(root, 'api/examples/dome.step'));
  await slow.waitForSelector('#faces:not([hidden])');
  await slow.click('details:has(#faces-list) summary');
  await slow.check('#faces-list input[value="6"]');
  await slow.click('#faces-smooth');
  await slow.click('#drape');
  await slow.waitForFunction(() => /solved in/.test(document.querySelector('#state').textContent));
  await slow.waitForFunction(() => /3 of 9/.test(document.querySelector('#about').textContent));
  await slow.waitForTimeout(2500); // what is still under way
  assert.match(await slow.textContent('#state'), /solved in/);
  assert.equal(await slow.textContent('#hint'), '');
  await slow.context().close();
});

test('part: what is opened last stays, though a file before it is read later', async () => {
  const file = join(root, 'api/examples/dome.step');
  await page.route('**/v1/surfaces?*', async (route) => {
    await new Promise((done) => setTimeout(done, 1500));
    await route.continue();
  });
  await page.setInputFiles('#file', file);
  await page.selectOption('#example', 'torus');
  const read = page.waitForResponse(/v1\/surfaces\/.*preview/);
  await page.waitForFunction(() => /^NURBS/.test(document.querySelector('#about').textContent));
  await read;
  await page.waitForTimeout(500); // what could follow
  assert.match(await page.textContent('#about'), /^NURBS/);
  assert.equal(await page.inputValue('#example'), 'torus');
  assert.ok(await page.isHidden('#faces'));
  await page.unroute('**/v1/surfaces?*');
  await page.setInputFiles('#file', file);
  await page.waitForSelector('#faces:not([hidden])');
});

test('part: the picture of the README', async () => {
  const folder = mkdtempSync(join(tmpdir(), 'parts-'));
  execFileSync(join(pictures, '../import/make_parts'), [folder]);
  const small = await openPage(browser, daemon.url, {
    width: 1200,
    height: 760,
    deviceScaleFactor: 0.8,
  });
  await small.setInputFiles('#file', join(folder, 'cover.step'));
  await small.waitForSelector('#faces:not([hidden])');
  rmSync(folder, { recursive: true });
  await small.click('details:has(#faces-list) summary');
  await small.click('#faces-list li:has-text("sphere") input');
  await small.click('#faces-smooth');
  assert.match(await small.textContent('#faces-count'), /^26 of 35 faces are chosen/);
  await small.click('details:has(#faces-list) summary');
  await small.fill('#spacing', '5');
  await small.fill('#locking', '30');
  await small.click('#drape');
  await small.waitForFunction(() => /solved in/.test(document.querySelector('#state').textContent));
  await drawn(small);
  assert.match(await small.textContent('#summary'), /Outcomecomplete.*Covered area100 %/s);
  const shot = await picture(small, 'readme_part');
  assert.ok(shot.length < 200e3, `${shot.length} bytes`);
  await small.context().close();
});

/** Binary STL of a closed box, 40 by 30 by 5, with FreeCAD's head; without its first facets a hole. */
function box(without = 0) {
  const facets = [];
  const sides = [
    [
      [0, 0, 5],
      [40, 0, 0],
      [0, 30, 0],
    ],
    [
      [0, 0, 0],
      [0, 30, 0],
      [40, 0, 0],
    ],
    [
      [0, 0, 0],
      [40, 0, 0],
      [0, 0, 5],
    ],
    [
      [0, 30, 0],
      [0, 0, 5],
      [40, 0, 0],
    ],
    [
      [0, 0, 0],
      [0, 0, 5],
      [0, 30, 0],
    ],
    [
      [40, 0, 0],
      [0, 30, 0],
      [0, 0, 5],
    ],
  ];
  for (const [o, u, v] of sides)
    for (let k = 0; k < 100; k++) {
      const at = (s, t) => o.map((x, c) => x + (u[c] * s + v[c] * t) / 10);
      const [i, j] = [k % 10, Math.floor(k / 10)];
      const [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
      facets.push([a, b, c], [a, c, d]);
    }
  const kept = facets.slice(without);
  const bytes = Buffer.alloc(84 + 50 * kept.length);
  bytes.write('MESH-'.repeat(16));
  bytes.writeUInt32LE(kept.length, 80);
  kept.forEach((facet, k) =>
    facet.flat().forEach((x, c) => bytes.writeFloatLE(x, 84 + 50 * k + 12 + 4 * c)),
  );
  return bytes;
}

const choose = (name, buffer) =>
  page.setInputFiles('#file', { name, mimeType: 'application/octet-stream', buffer });
const about = (words) =>
  page.waitForFunction(
    (text) => document.querySelector('#about').textContent.includes(text),
    words,
  );

test('part: a closed mesh offers its faces, and one of them is draped', async () => {
  await choose('box.stl', box());
  await about('it states no unit; mm is assumed. 0 of 6 faces of a mesh');
  assert.match(await count(), /^None of 6 faces is chosen yet/);
  await page.mouse.click(...(await placeAt(0.5, 0.45)));
  assert.match(await count(), /^1 of 6 faces is chosen, 1200 mm²\.$/);
  await drawn(page);
  await picture(page, 'mesh-faces');
  await page.click('#drape');
  await settled();
  assert.match(await page.textContent('#summary'), /Outcomecomplete/);
});

test('part: a mesh without a unit is stored in another one when that is chosen', async () => {
  await page.selectOption('#unit', 'm');
  await about('0 of 6 faces of a mesh, 1,200 triangles; 40 × 30 × 5 m');
  await page.click('#faces-all');
  assert.match(await count(), /^6 of 6 faces are chosen, 3100 m²/);
});

test('part: holes of a mesh are told with their lengths', async () => {
  await choose('hole.stl', box(4));
  await about('6 of 6 faces of a mesh');
  await page.waitForSelector('#faces-notes:not(:empty)', { state: 'attached' });
  assert.match(
    await page.textContent('#faces-notes'),
    /open edges: 6 in one loop, 2\d mm long: borders, or holes/,
  );
});

test('part: files of other programs get the words of the service', async () => {
  for (const [name, words] of [
    [
      'seat.FCStd',
      "a file that ends in .FCStd is FreeCAD's own document: export the part from FreeCAD",
    ],
    ['part.sldprt', "a CAD system's own document: export the part as STEP"],
    [
      'notes.txt',
      'must end in .step, .stp, .p21, .iges, .igs, .stl, .obj, .bdf, .nas, .dat, .inp, .k, .key, .msh, .unv or .vtu',
    ],
  ]) {
    await choose(name, Buffer.from('PK'));
    await page.waitForFunction(
      (text) => document.querySelector('#fault-surface').textContent.includes(text),
      words,
    );
  }
});
