// SPDX-License-Identifier: MIT
// The page as a user meets it: drape, look, compare, take away.
import assert from 'node:assert/strict';
import { execFile } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { createServer, request } from 'node:http';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { test } from 'node:test';
import { promisify } from 'node:util';
import {
  ask,
  browser,
  colours,
  daemon,
  difference,
  drapeExample,
  drawn,
  idOf,
  openOnce,
  openPage,
  page,
  picture,
  root,
  shareOf,
  violations,
} from './helper.mjs';

openOnce();

test('page: loads with no error and asks nobody else', async () => {
  assert.deepEqual(page.faults, []);
  assert.match(await page.textContent('#about'), /NURBS, degree 2 × 2/);
  await picture(page, 'start');
  assert.deepEqual(await violations(page), []);
});

test('page: its headers let nothing in and let browsers keep its files', async () => {
  const answer = await fetch(daemon.url);
  const policy = answer.headers.get('content-security-policy');
  assert.match(policy, /default-src 'none'/);
  assert.doesNotMatch(policy, /unsafe|https?:|\*/);
  const script = /src="([^"]+main\.js)"/.exec(await answer.text())[1];
  const again = await fetch(daemon.url, {
    headers: { 'If-None-Match': answer.headers.get('etag') },
  });
  assert.equal(again.status, 304);
  const file = await fetch(new URL(script, daemon.url));
  assert.match(file.headers.get('cache-control'), /immutable/);
  assert.equal(file.headers.get('content-encoding'), 'gzip');
  assert.equal(file.headers.get('content-type'), 'text/javascript; charset=utf-8');
  const plain = await fetch(new URL(script, daemon.url), {
    headers: { 'Accept-Encoding': 'identity' },
  });
  assert.equal(plain.headers.get('content-encoding'), null);
  assert.equal(await plain.text(), await file.text());
  const stale = await fetch(
    new URL(script.replace(/viewer\/\w+/, 'viewer/0123456789abcdef'), daemon.url),
  );
  assert.equal(stale.status, 404);
});

test('page: drapes an example by a click and shows its net', async () => {
  const empty = await colours(page, '#panes');
  const tops = () =>
    page
      .locator('h2, h3, legend, label, #drape, #state')
      .evaluateAll((all) => all.map((one) => [one.textContent, one.getBoundingClientRect().top]));
  const before = await tops();
  await drapeExample(page, 'saddle');
  const moved = (await tops()).filter(([, top], k) => Math.abs(top - before[k][1]) > 3);
  assert.deepEqual(moved, [], 'nothing moves when the net comes');
  await drawn(page);
  const shot = await picture(page, 'draped');
  assert.ok(shot.length > 10000);
  const full = await colours(page, '#panes');
  assert.ok(full > 4 * empty, `${full} colours with the net, ${empty} without`);
  const { summary } = await ask(`v1/drapes/${idOf(page)}`);
  assert.match(
    await page.textContent('#summary'),
    new RegExp(`Cells${summary.cells.toLocaleString('en')}`),
  );
  assert.deepEqual(await violations(page), []);
});

test('page: the colours change with the field', async () => {
  const shear = await page.locator('#panes').screenshot();
  await page.selectOption('#field', 'shear_signed');
  await drawn(page);
  const signed = await page.locator('#panes').screenshot();
  assert.ok((await difference(page, shear, signed)) > 0.1);
  assert.match(await page.getAttribute('#scale svg', 'aria-label'), /signed: −52/);
  await page.selectOption('#field', 'thickness');
  await drawn(page);
  assert.match(await page.getAttribute('#scale svg', 'aria-label'), /Thickness, m: 5 × 10⁻⁴/);
  assert.ok((await difference(page, await page.locator('#panes').screenshot(), signed)) > 0.1);
  await page.selectOption('#field', 'shear');
});

test('page: the colour bar marks the locking angle, and its outline goes with a click', async () => {
  assert.match(await page.textContent('#scale'), /locks 40°/);
  await drawn(page);
  const outlined = await page.locator('#panes').screenshot();
  await page.uncheck('#show-locked');
  await drawn(page);
  assert.ok((await difference(page, outlined, await page.locator('#panes').screenshot())) > 0.005);
  await page.check('#show-locked');
});

test('page: the read-out is the number of the service', async () => {
  const { cells, nodes } = await ask(`v1/drapes/${idOf(page)}/result`);
  const row = cells.i.findIndex((i, k) => i === 7 && cells.j[k] === -5);
  await page.fill('#cell-i', '7');
  await page.fill('#cell-j', '-5');
  await page.press('#cell-j', 'Enter');
  const shown = async (name) =>
    Number(await page.getAttribute(`#readout dt:text-is("${name}") + dd data`, 'value'));
  assert.equal(await shown('Shear angle'), cells.shear_deg[row]);
  assert.equal(await shown('Thickness'), cells.thickness[row]);
  const node = nodes.i.findIndex((i, k) => i === 7 && nodes.j[k] === -5);
  assert.equal(await shown('x'), nodes.x[node]);
  assert.equal(await shown('Shear at the node'), nodes.shear_deg[node]);
});

test('page: what the pointer is on is read out, the same on the surface and in the pattern', async () => {
  const { cells } = await ask(`v1/drapes/${idOf(page)}/result`);
  const box = await page.locator('#pane-flat').boundingBox();
  const shear = {};
  cells.shear_deg.forEach(
    (value, row) => (shear[`${cells.i[row]}, ${cells.j[row]}`] = Math.abs(value)),
  );
  let seen = 0;
  for (const selector of ['#pane-flat', '#pane-solid']) {
    const { x, y, width, height } = await page.locator(selector).boundingBox();
    for (const [a, b] of [
      [0.4, 0.55],
      [0.6, 0.52],
      [0.45, 0.6],
    ]) {
      await page.mouse.move(x + a * width, y + b * height);
      await drawn(page);
      const text = (await page.textContent('#chip')).replaceAll('−', '-');
      const found = /cell \(([^)]*)\): ([\d.]+)°/.exec(text);
      if (!found || (await page.isHidden('#chip'))) continue;
      seen++;
      assert.ok(
        Math.abs(shear[found[1]] - Number(found[2])) < 1e-3 * Math.max(1, shear[found[1]]),
        text,
      );
    }
  }
  assert.ok(seen >= 4, `${seen} places had a cell under them`);
  // The cell at (i, j) of the pattern lies where i and j say: 59 cells a side about the middle.
  await page.mouse.move(box.x + box.width / 2 + 40, box.y + box.height / 2 - 60);
  await drawn(page);
  const [i, j] = /\(([^)]*)\)/
    .exec((await page.textContent('#chip')).replaceAll('−', '-'))[1]
    .split(',')
    .map(Number);
  assert.ok(i > 0 && j > i, `cell (${i}, ${j})`);
});

test('page: a link shows the same view', async () => {
  await page.selectOption('#field', 'shear_signed');
  await page.focus('#pane-solid');
  for (let k = 0; k < 4; k++) await page.keyboard.press('ArrowLeft');
  await page.keyboard.press('+');
  await page.mouse.move(5, 5);
  await drawn(page);
  const other = await openPage(browser, page.url());
  await other.waitForFunction(() => /solved in/.test(document.querySelector('#state').textContent));
  await drawn(other);
  assert.equal(other.url(), page.url());
  assert.equal(await other.inputValue('#field'), 'shear_signed');
  assert.equal(await other.inputValue('#cell-i'), '7');
  assert.equal(await other.textContent('#readout'), await page.textContent('#readout'));
  const [one, two] = [
    await page.locator('#panes').screenshot(),
    await other.locator('#panes').screenshot(),
  ];
  assert.ok((await difference(page, one, two)) < 0.02);
  assert.deepEqual(other.faults, []);
  await other.context().close();
  await page.selectOption('#field', 'shear');
  await page.click('#home');
});

test('page: dragging the angle drapes while it moves, and leaves one drape behind', async () => {
  const count = async () => (await ask('v1/drapes?limit=1000')).drapes.length;
  const first = idOf(page);
  const drapes = await count();
  await page.click('#cell-clear');
  await page.evaluate(() => {
    const { prototype } = WebGL2RenderingContext;
    const link = prototype.linkProgram;
    globalThis.linked = 0;
    prototype.linkProgram = function (program) {
      globalThis.linked++;
      return link.call(this, program);
    };
  });
  const slider = await page.locator('#angle-slider').boundingBox();
  await page.mouse.move(slider.x + slider.width / 2, slider.y + slider.height / 2);
  await page.mouse.down();
  const answered = () =>
    page.waitForResponse((answer) => answer.request().method() === 'POST' && answer.ok());
  for (let step = 1; step <= 5; step++) {
    const x = slider.x + slider.width * (0.5 + 0.05 * step);
    const [answer] = await Promise.all([
      answered(),
      page.mouse.move(x, slider.y + slider.height / 2),
    ]);
    assert.match(
      answer.url(),
      /fields=nodes\.i,/,
      'a net on the way comes without what is not shown',
    );
  }
  await drawn(page);
  assert.match(await page.textContent('#summary'), /^Outcomein progress.*Cells3,\d\d\d/);
  assert.equal(await page.evaluate(() => globalThis.linked), 0, 'shaders are not made anew');
  await page.mouse.up();
  await page.waitForFunction((id) => !location.hash.includes(id), first);
  await page.waitForFunction(() => document.querySelectorAll('#list [aria-current]').length === 1);
  await picture(page, 'turned');
  const angle = Number(await page.inputValue('#angle'));
  assert.ok(angle > 30 && angle < 60, `${angle} degrees`);
  const sent = await ask(`v1/drapes/${idOf(page)}/request`);
  assert.equal(sent.direction.angle_deg, angle);
  for (let k = 0; k < 600 && (await count()) > drapes + 1; k++) await page.waitForTimeout(100);
  assert.equal(await count(), drapes + 1);
});

test('page: the drape of a link follows the angle, too', async () => {
  const other = await openPage(browser, page.url());
  await other.focus('#angle-slider');
  await other.keyboard.press('ArrowRight');
  await other.waitForFunction((id) => !location.hash.includes(id), idOf(page));
  const sent = await ask(`v1/drapes/${idOf(other)}/request`);
  assert.equal(sent.direction.angle_deg, Number(await page.inputValue('#angle')) + 1);
  await other.context().close();
});

test('page: the start follows its handle, and a click when asked to', async () => {
  const handle = await page.locator('#handle').boundingBox();
  const [x, y] = [handle.x + handle.width / 2, handle.y + handle.height / 2];
  await page.mouse.move(x, y);
  await page.mouse.down();
  for (let step = 1; step <= 5; step++) await page.mouse.move(x - 8 * step, y + 8 * step);
  const before = idOf(page);
  await page.mouse.up();
  await page.waitForFunction((id) => !location.hash.includes(id), before);
  const moved = (await ask(`v1/drapes/${idOf(page)}/request`)).start.uv;
  assert.ok(Math.hypot(moved[0] - 0.5, moved[1] - 0.5) > 0.03, `start ${moved}`);
  const after = idOf(page);
  await page.click('#place');
  await page.mouse.click(x, y);
  await page.waitForFunction((id) => !location.hash.includes(id), after);
  const back = (await ask(`v1/drapes/${idOf(page)}/request`)).start.uv;
  assert.ok(Math.hypot(back[0] - 0.5, back[1] - 0.5) < 0.03, `start ${back}`);
  assert.equal(await page.getAttribute('#place', 'aria-pressed'), 'false');
});

test('page: permeability has its fields, its crosses and its numbers', async () => {
  await drapeExample(page, 'hemisphere');
  await page.selectOption('#field', 'k1');
  await drawn(page);
  const without = await page.locator('#pane-solid').screenshot();
  await page.check('#show-crosses');
  await page.check('#show-front');
  await drawn(page);
  assert.ok(
    (await difference(page, without, await page.locator('#pane-solid').screenshot())) > 0.01,
  );
  await picture(page, 'permeability');
  const { cells } = await ask(`v1/drapes/${idOf(page)}/result?fields=cells.i,cells.j,cells.k1`);
  const row = cells.i.findIndex((i, k) => i === 10 && cells.j[k] === 9);
  await page.fill('#cell-i', '10');
  await page.fill('#cell-j', '9');
  await page.press('#cell-j', 'Enter');
  assert.equal(
    Number(await page.getAttribute('#readout dt:text-is("Permeability k1") + dd data', 'value')),
    cells.k1[row],
  );
  const link = await openPage(browser, page.url());
  assert.equal(await link.inputValue('#field'), 'k1');
  assert.ok(await link.isChecked('#show-crosses'));
  await link.context().close();
  await page.uncheck('#show-crosses');
  await page.selectOption('#field', 'shear');
});

test('page: a material says what the form leaves empty', async () => {
  const own = { name: 'own', fabric: { thickness: 0.002, fiber_volume_fraction: 0.4 } };
  await page.evaluate(
    (body) =>
      fetch('v1/materials', {
        method: 'POST',
        headers: { 'Content-Type': 'application/json' },
        body,
      }),
    JSON.stringify(own),
  );
  const other = await openPage(browser, page.url().split('#')[0]);
  await other.waitForSelector('#material option[value="own"]', { state: 'attached' });
  await other.selectOption('#material', 'own');
  await other.selectOption('#unit', 'mm');
  for (const id of ['thickness', 'fraction', 'locking', 'cavity']) await other.fill(`#${id}`, '');
  await other.selectOption('#permeability', '');
  await other.waitForFunction(() => document.getElementById('thickness').placeholder === '2');
  await other.fill('#fraction', '0.45');
  await other.click('#drape');
  await other.waitForFunction(() => location.hash.includes('drape='));
  const { fabric, permeability } = await ask(`v1/drapes/${idOf(other)}/request`);
  assert.equal(fabric.thickness, 2);
  assert.equal(fabric.fiber_volume_fraction, 0.45);
  assert.equal(permeability, undefined);
  await other.context().close();
});

test('page: how the fabric gives way and what it bears are in its panel', async () => {
  const other = await openPage(browser, page.url().split('#')[0]);
  const draped = async () => {
    const before = other.url();
    await other.click('#drape');
    await other.waitForFunction((url) => location.href !== url, before);
    return ask(`v1/drapes/${idOf(other)}/request`);
  };
  assert.ok(await other.isHidden('#slide'));
  await other.selectOption('#kinematics', 'slide');
  await other.fill('#slide', '0.25');
  await other.fill('#locking', '21, 11');
  await other.fill('#limit', '-35 1; 0 0; 50 1');
  const { fabric } = await draped();
  assert.deepEqual(fabric.kinematics, { slide: 0.25 });
  assert.deepEqual(fabric.locking_angle_deg, { positive: 21, negative: 11 });
  assert.deepEqual(fabric.limit_curve, { shear_deg: [-35, 0, 50], severity: [1, 0, 1] });
  await other.selectOption('#field', 'severity');
  await other.waitForFunction(() =>
    /Severity/.test(document.querySelector('#scale svg')?.getAttribute('aria-label')),
  );
  await other.selectOption('#field', 'shear_signed');
  await other.waitForFunction(() => document.getElementById('scale').textContent.includes('21°'));
  assert.match(await other.textContent('#scale'), /11°/);
  await other.selectOption('#kinematics', 'parallel_fibers');
  assert.equal((await draped()).fabric.kinematics, 'parallel_fibers');
  await other.fill('#limit', '0 0; 20');
  await other.click('#drape');
  await other.waitForSelector('#fault-of-limit');
  await other.context().close();
});

test('page: the front says why the net stops', async () => {
  const box = await page.locator('#pane-flat').boundingBox();
  // The outermost cell of a row, between a place that has one and a place that has none.
  let [inside, outside, said] = [box.x + box.width / 2, box.x + box.width - 4, ''];
  while (outside - inside > 2) {
    const x = (inside + outside) / 2;
    await page.mouse.move(x, box.y + box.height / 2 + 2);
    await drawn(page);
    if (await page.isHidden('#chip')) {
      outside = x;
      continue;
    }
    inside = x;
    said = await page.textContent('#chip');
  }
  assert.match(said, /the net stops: the surface ends here/);
  assert.equal(await page.textContent('#front-key'), 'boundary: the surface ends here');
});

test('page: a mesh is draped with mosaic', async () => {
  await drapeExample(page, 'tray');
  await drawn(page);
  await picture(page, 'mesh');
  assert.match(await page.textContent('#about'), /mesh, 425 vertices/);
  assert.ok((await colours(page, '#panes')) > 200);
});

test('page: the flat pattern has the edge to cut along', async () => {
  await page.uncheck('#show-yarns');
  await drawn(page);
  const text = [0x1b, 0x23, 0x30];
  const share = await shareOf(page, await page.locator('#pane-flat').screenshot(), text);
  await page.check('#show-yarns');
  assert.ok(share > 5e-4 && share < 0.02, `${share} of the picture`);
});

test('page: two drapes side by side with their difference', async () => {
  await drapeExample(page, 'octant');
  const fine = idOf(page);
  await page.selectOption('#method', 'basic');
  await page.click('#drape');
  await page.waitForFunction((id) => !location.hash.includes(id), fine);
  await page.waitForFunction(() => document.querySelectorAll('#list li').length > 1);
  await page.locator('#list li:nth-child(2) button:text("Compare")').click();
  await page.waitForFunction((id) => location.hash.includes(`compare=${id}`), fine);
  await drawn(page);
  await picture(page, 'compare');
  assert.match(await page.textContent('#caption-other'), /gib4, 0°/);
  assert.match(await page.textContent('#caption-solid'), /^This: basic, 0°/);
  assert.match(await page.textContent('#diagonals'), /other/);
  const row = async (name) =>
    page
      .locator(`#summary dt:text-is("${name}") ~ dd`)
      .evaluateAll((all) => all.slice(0, 2).map((value) => value.textContent));
  assert.deepEqual((await row('Cells')).length, 2);
  assert.match(await page.textContent('#summary'), /the other: gib4, 0°/);
  // Where the nets agree to less than 0.1 degrees, so does the map: its range is the difference.
  assert.match(
    await page.getAttribute('#difference-scale svg', 'aria-label'),
    /this − other: −0\.0\d+ to 0\.0\d+°/,
  );
  assert.ok((await colours(page, '#pane-difference')) > 30);
  assert.match(await page.textContent('#caption-flat'), /edge of this and the other/);
  assert.deepEqual(await violations(page), []);
  const link = await openPage(browser, page.url());
  await link.waitForSelector('#pane-difference svg');
  assert.deepEqual(link.faults, []);
  await link.context().close();
  await page.click('#compare-end');
  assert.ok(await page.isHidden('#pane-other'));
});

test('page: every download is there, and the curl command gives the same net', async () => {
  const links = await page
    .locator('#downloads a')
    .evaluateAll((all) => all.map((link) => link.href));
  assert.equal(links.length, 10);
  for (const link of links) {
    const answer = await fetch(link);
    assert.equal(answer.status, 200, link);
    assert.ok((await answer.arrayBuffer()).byteLength > 200, link);
  }
  const folder = mkdtempSync(join(tmpdir(), 'draped-curl-'));
  try {
    const command = await page.textContent('#curl');
    await promisify(execFile)('bash', ['-c', command], { cwd: folder });
    const result = JSON.parse(readFileSync(join(folder, 'result.json')));
    const own = await ask(`v1/drapes/${idOf(page)}/result`);
    assert.deepEqual(result.nodes, own.nodes);
  } finally {
    rmSync(folder, { recursive: true });
  }
});

test('page: a surface dropped on it, with nothing else, can be draped', async () => {
  const { surface } = JSON.parse(readFileSync(join(root, 'api/examples/torus.json')));
  const text = JSON.stringify({ shape: { type: 'surface', count: 1, data: [surface] } });
  await page.evaluate((content) => {
    const transfer = new DataTransfer();
    transfer.items.add(new File([content], 'torus.json', { type: 'application/json' }));
    document
      .querySelector('#drop')
      .dispatchEvent(new DragEvent('drop', { dataTransfer: transfer, bubbles: true }));
  }, text);
  await page.waitForFunction(() =>
    document.querySelector('#about').textContent.startsWith('torus.json'),
  );
  assert.equal(await page.inputValue('#spacing'), '10');
  await page.click('#drape');
  await page.waitForFunction(() => /solved in/.test(document.querySelector('#state').textContent));
  assert.match(await page.textContent('#summary'), /Outcomecomplete/);
});

test('page: a file without a unit says which one is assumed, and how large that makes the part', async () => {
  assert.match(
    await page.textContent('#about'),
    /^torus\.json: It states no unit; mm is assumed\. NURBS.*; \d[\d.]* × \d[\d.]* × \d[\d.]* mm$/,
  );
  await page.selectOption('#unit', 'cm');
  assert.match(await page.textContent('#about'), / cm$/);
  await page.selectOption('#unit', 'mm');
});

test('page: what is shown is marked as soon as the request is another one', async () => {
  assert.ok(await page.isHidden('#stale'));
  const before = await page.inputValue('#thickness');
  await page.fill('#thickness', '0.3');
  assert.ok(await page.isVisible('#stale'));
  await page.fill('#thickness', before);
  assert.ok(await page.isHidden('#stale'));
  await page.selectOption('#method', 'basic');
  assert.ok(await page.isVisible('#stale'));
  await page.focus('#drape');
  await page.keyboard.press('Enter');
  await page.waitForFunction(() => document.querySelector('#stale').hidden);
  assert.equal(await page.evaluate(() => document.activeElement.id), 'drape');
  await page.waitForSelector('#list li:first-child .open:text("torus: basic, 0°, 10 mm")');
  assert.match(
    await page.getAttribute('#downloads a', 'download'),
    /^torus-basic-0deg-10-mm\.json$/,
  );
});

test('page: Enter in a field drapes once', async () => {
  const count = async () => (await ask('v1/drapes?limit=100')).drapes.length;
  const [drapes, shown] = [await count(), idOf(page)];
  await page.fill('#start', '0.4, 0.4');
  await page.press('#start', 'Enter');
  await page.waitForFunction((id) => !location.hash.includes(id), shown);
  await page.waitForFunction(() => document.querySelector('#stale').hidden);
  assert.equal(await count(), drapes + 1);
});

test('page: Back shows the drape before', async () => {
  const shown = idOf(page);
  await page.fill('#angle', '30');
  await page.press('#angle', 'Enter');
  await page.waitForFunction((id) => !location.hash.includes(id), shown);
  await page.goBack();
  await page.waitForFunction((id) => location.hash.includes(id), shown);
  await page.waitForFunction(() => /solved in/.test(document.querySelector('#state').textContent));
  assert.equal(await page.inputValue('#angle'), '0');
});

test('page: the worst cell is a click away, and a field of one value has one', async () => {
  await drapeExample(page, 'hemisphere');
  await page.click('#cell-worst');
  const shown = await page.getAttribute('#readout dt:text-is("Shear angle") + dd data', 'value');
  const { cells } = await ask(`v1/drapes/${idOf(page)}/result?fields=cells.shear_deg`);
  assert.equal(Math.abs(Number(shown)), Math.max(...cells.shear_deg.map(Math.abs)));
  await page.click('#cell-clear');
  await page.selectOption('#field', 'fiber_volume_fraction');
  assert.match(
    await page.getAttribute('#scale svg', 'aria-label'),
    /^Fibre volume fraction: 0\.\d+ everywhere$/,
  );
  await page.selectOption('#field', 'shear');
});

test('page: colours between limits, a section and a distance, which a link keeps or forgets', async () => {
  await drapeExample(page, 'freeform');
  await page.fill('#scale-low', '5');
  await page.fill('#scale-high', '30');
  await page.press('#scale-high', 'Enter');
  assert.match(await page.getAttribute('#scale svg', 'aria-label'), /: 5 to 30°$/);
  assert.match(page.url(), /limits=5,30/);
  assert.match(await page.textContent('#ruler'), /^[125]0* mm$/);
  const whole = await page.locator('#pane-solid').screenshot();
  await page.selectOption('#section', 'x');
  await drawn(page);
  const half = await page.locator('#pane-solid').screenshot();
  assert.ok((await difference(page, whole, half)) > 0.05);
  await page.selectOption('#section', '');
  await page.click('#measure');
  const box = await page.locator('#pane-solid').boundingBox();
  for (const [x, y] of [
    [0.4, 0.45],
    [0.5, 0.6],
  ])
    await page.mouse.click(box.x + x * box.width, box.y + y * box.height);
  const [, straight, warp, weft, flat] =
    /^([\d.]+) mm straight; (\d+) steps along the warp, (\d+) along the weft, ([\d.]+) mm in/.exec(
      await page.textContent('#measured'),
    );
  assert.ok(Math.abs(Math.hypot(5 * warp, 5 * weft) - flat) < 0.1);
  assert.ok(straight > 0 && straight < 2 * flat);
  await page.keyboard.press('Escape');
  assert.equal(await page.textContent('#measured'), '');
  await page.fill('#scale-low', '');
  await page.fill('#scale-high', '');
  await page.press('#scale-high', 'Enter');
  assert.deepEqual(await violations(page), []);
});

test('page: the drape of a part of several faces is opened, and draped again', async () => {
  const post = async (path, type, body) =>
    (
      await fetch(new URL(path, daemon.url), {
        method: 'POST',
        headers: { 'Content-Type': type, Prefer: 'wait=50' },
        body,
      })
    ).json();
  const part = readFileSync(join(root, 'api/examples/dome.step'));
  const { id: surface } = await post('v1/surfaces', 'model/step', part);
  const request = { surface: { id: surface, grow_from: 6 }, fabric: { spacing: 8 } };
  const { id } = await post('v1/drapes', 'application/json', JSON.stringify(request));
  const other = await openPage(browser, `${daemon.url}#drape=${id}`);
  await other.waitForFunction(() => /solved in/.test(document.querySelector('#state').textContent));
  assert.match(await other.textContent('#about'), /^3 of 9 faces/);
  await drawn(other);
  assert.ok((await colours(other, '#pane-solid')) > 100);
  await other.fill('#spacing', '10');
  await other.click('#drape');
  await other.waitForFunction((old) => !location.hash.includes(old), id);
  assert.match(await other.textContent('#summary'), /Outcomecomplete/);
  assert.deepEqual(other.faults, []);
  await other.context().close();
});

test('page: a trimmed surface has its hole', async () => {
  const { surface, fabric } = JSON.parse(readFileSync(join(root, 'api/examples/saddle.json')));
  const hole = Array.from({ length: 40 }, (_, k) => [
    0.5 + 0.2 * Math.cos((k * Math.PI) / 20),
    0.25 + 0.2 * Math.sin((k * Math.PI) / 20),
  ]);
  const shots = [];
  for (const trims of [[], [{ type: 'freeform', points: hole }]]) {
    const buffer = Buffer.from(JSON.stringify({ surface: { ...surface, trims }, fabric }));
    const name = `trims-${trims.length}.json`;
    await page.setInputFiles('#file', { name, mimeType: 'application/json', buffer });
    await page.waitForFunction(
      (file) => document.querySelector('#about').textContent.startsWith(file),
      name,
    );
    await drawn(page);
    shots.push(await page.locator('#pane-solid').screenshot());
  }
  assert.ok((await difference(page, ...shots)) > 0.02);
  await page.click('#drape');
  await page.waitForFunction(() => /solved in/.test(document.querySelector('#state').textContent));
  await drawn(page);
  await picture(page, 'trimmed');
});

test('page: everything is within reach of the keyboard', async () => {
  const keyed = await openPage(browser, daemon.url);
  const focused = () =>
    keyed.evaluate(() => document.activeElement.id || document.activeElement.className);
  await keyed.keyboard.press('Tab');
  assert.equal(await focused(), 'skip');
  const reached = [];
  for (let k = 0; k < 60; k++) {
    await keyed.keyboard.press('Tab');
    reached.push(await focused());
  }
  for (const id of [
    'example',
    'file',
    'method',
    'spacing',
    'angle-slider',
    'start',
    'drape',
    'field',
    'pane-solid',
    'pane-flat',
    'cell-i',
    'curl',
    'copy',
  ])
    assert.ok(reached.includes(id), `${id} is reached by Tab`);
  await keyed.focus('#spacing');
  await keyed.keyboard.press('Enter');
  await keyed.waitForFunction(() => /solved in/.test(document.querySelector('#state').textContent));
  await keyed.focus('#pane-solid');
  await drawn(keyed);
  const before = await keyed.locator('#pane-solid').screenshot();
  await keyed.keyboard.press('ArrowRight');
  await drawn(keyed);
  assert.ok(
    (await difference(keyed, before, await keyed.locator('#pane-solid').screenshot())) > 0.02,
  );
  assert.deepEqual(keyed.faults, []);
  await keyed.context().close();
});

test('page: in the dark and on a phone', async () => {
  const dark = await openPage(browser, page.url(), { colorScheme: 'dark' });
  await dark.waitForFunction(() => /solved in/.test(document.querySelector('#state').textContent));
  await drawn(dark);
  await picture(dark, 'dark');
  assert.deepEqual(await violations(dark), []);
  await dark.context().close();
  const phone = await openPage(browser, page.url(), { width: 390, height: 844 });
  await phone.waitForFunction(() => /solved in/.test(document.querySelector('#state').textContent));
  await drawn(phone);
  await picture(phone, 'phone', { fullPage: true });
  assert.equal(await phone.evaluate(() => document.documentElement.scrollWidth), 390);
  await phone.click('[data-to="stage"]');
  await drawn(phone);
  await picture(phone, 'thumb');
  const low = await phone.evaluate(() => {
    const seen = [...document.querySelectorAll('button, select, .chips label, summary')];
    const heights = seen
      .filter((one) => one.offsetParent)
      .map((one) => [one.textContent, one.offsetHeight]);
    return heights.filter(([, height]) => height < 36);
  });
  assert.deepEqual(low, [], 'everything is large enough for a thumb');
  const box = await phone.locator('#pane-solid').boundingBox();
  assert.ok(box.y >= 0 && box.y < 400, 'the picture is brought up by the bar below');
  assert.deepEqual(await violations(phone), []);
  await phone.context().close();
});

test('page: a decimal comma is understood or refused, and never splits a number', async () => {
  const asked = await openPage(browser, daemon.url);
  await drapeExample(asked, 'saddle');
  const body = () =>
    asked.waitForRequest(
      (request) => request.method() === 'POST' && /v1.drapes/.test(request.url()),
    );
  const sent = async (id, text) => {
    await asked.fill(`#${id}`, text);
    const [request] = await Promise.all([body(), asked.click('#drape')]);
    return JSON.parse(request.postData());
  };
  assert.equal((await sent('spacing', '0,2')).fabric.spacing, 0.2);
  assert.deepEqual((await sent('spacing', '0,2, 0,1')).fabric.spacing, [0.2, 0.1]);
  assert.deepEqual((await sent('spacing', '0.2,0.1')).fabric.spacing, [0.2, 0.1]);
  assert.equal((await sent('spacing', '1.000,2')).fabric.spacing, '1.000,2');
  await asked.waitForSelector('#spacing[aria-invalid="true"]');
  await sent('spacing', '0.1');
  assert.deepEqual((await sent('start', '0,5; 0,5')).start.uv, [0.5, 0.5]);
  assert.equal((await sent('thickness', '0,0005')).fabric.thickness, 0.0005);
  await asked.fill('#scale-high', '8,5');
  await asked.press('#scale-high', 'Enter');
  assert.match(await asked.getAttribute('#scale svg', 'aria-label'), /to 8\.5°$/);
  await asked.context().close();
});

test('page: the worst cell is turned to, marked, and in the middle of the picture', async () => {
  const turned = await openPage(browser, daemon.url);
  await drapeExample(turned, 'hemisphere');
  await drawn(turned);
  const eye = turned.url();
  await turned.click('#cell-worst');
  await drawn(turned);
  assert.notEqual(turned.url(), eye);
  const [i, j] = [await turned.inputValue('#cell-i'), await turned.inputValue('#cell-j')];
  const box = await turned.locator('#pane-solid').boundingBox();
  await turned.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
  await drawn(turned);
  await turned.waitForFunction(() => !document.querySelector('#chip').hidden);
  const [, a, b] = /(−?\d+), (−?\d+)/.exec(await turned.textContent('#chip')) ?? [];
  const near = (text, cell) => Math.abs(Number(text.replace('−', '-')) - Number(cell)) <= 1;
  assert.ok(near(a, i) && near(b, j), `${await turned.textContent('#chip')}, not ${i}, ${j}`);
  await picture(turned, 'worst');
  await turned.context().close();
});

test('page: what is shown keeps the unit of its own request', async () => {
  const other = await openPage(browser, daemon.url);
  await drapeExample(other, 'saddle');
  await other.selectOption('#unit', 'mm');
  await drawn(other);
  assert.match(await other.textContent('#ruler'), / m$/);
  assert.match(await other.textContent('#stale'), /\S/);
  await other.context().close();
});

/** A proxy that has the service under /tools/draped/, as the README describes it for nginx. */
async function startProxy(port) {
  const prefix = '/tools/draped/';
  const server = createServer((incoming, outgoing) => {
    if (!incoming.url.startsWith(prefix)) return outgoing.writeHead(404).end();
    const { method, headers } = incoming;
    const path = incoming.url.slice(prefix.length - 1);
    const onward = request({ host: '127.0.0.1', port, method, path, headers }, (answer) => {
      outgoing.writeHead(answer.statusCode, answer.headers);
      answer.pipe(outgoing);
    });
    onward.on('error', () => outgoing.destroy());
    return incoming.pipe(onward);
  });
  await new Promise((done) => server.listen(0, '127.0.0.1', done));
  return { url: `http://127.0.0.1:${server.address().port}${prefix}`, server };
}

test('page: works below a path of a proxy', async () => {
  const { url, server } = await startProxy(daemon.port);
  try {
    const behind = await openPage(browser, url);
    const outside = [];
    behind.on('request', (call) => call.url().startsWith(url) || outside.push(call.url()));
    await drapeExample(behind, 'torus');
    assert.match(await behind.textContent('#curl'), /\/tools\/draped\/v1\/drapes'/);
    assert.match(await behind.getAttribute('#downloads a', 'href'), /\/tools\/draped\/v1\//);
    assert.deepEqual([...behind.faults, ...outside], []);
    await behind.context().close();
  } finally {
    server.closeAllConnections();
    server.close();
  }
});

test('page: the picture of the README', async () => {
  const small = await openPage(browser, daemon.url, {
    width: 1200,
    height: 700,
    deviceScaleFactor: 0.65,
  });
  await small.selectOption('#example', 'freeform');
  await small.waitForFunction(() => /8 × 7/.test(document.querySelector('#about').textContent));
  await small.fill('#spacing', '10');
  await small.click('#drape');
  await small.waitForFunction(() => /solved/.test(document.querySelector('#state').textContent));
  await small.fill('#cell-i', '-9');
  await small.fill('#cell-j', '-7');
  await small.press('#cell-j', 'Enter');
  await small.focus('#drape');
  await drawn(small);
  const shot = await picture(small, 'readme');
  assert.ok(shot.length < 150e3, `${shot.length} bytes`);
  await small.context().close();
});

test('page: nothing went wrong unseen', () => {
  assert.deepEqual(page.faults, []);
});
