// SPDX-License-Identifier: MIT
// A drape on somebody's mesh: its elements in the fields' colours, the inlet, the files of the map.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import {
  daemon,
  difference,
  drapeExample,
  drawn,
  idOf,
  openOnce,
  page,
  picture,
  root,
  violations,
} from './helper.mjs';

const mould = readFileSync(join(root, 'api/examples/mould.bdf'), 'utf8');
openOnce();

const map = async (query) => {
  const headers = { 'Content-Type': 'text/x-nastran' };
  const address = new URL(`v1/drapes/${idOf(page)}/map?${query}`, daemon.url);
  return fetch(address, { method: 'POST', headers, body: mould });
};

/** Drops a file on an element of the page. */
const drop = (selector, name, content) =>
  page.evaluate(
    ([where, file, text]) => {
      const transfer = new DataTransfer();
      transfer.items.add(new File([text], file));
      document
        .querySelector(where)
        .dispatchEvent(new DragEvent('drop', { dataTransfer: transfer, bubbles: true }));
    },
    [selector, name, content],
  );

const middle = async () => {
  const box = await page.locator('#pane-solid').boundingBox();
  return [box.x + 0.5 * box.width, box.y + 0.5 * box.height];
};

test('mesh: a file that is dropped on a drape is mapped and shown', async () => {
  await drapeExample(page, 'saddle');
  await drawn(page);
  const net = await page.locator('#pane-solid').screenshot();
  await drop('#pane-solid', 'mould.bdf', mould);
  await page.waitForSelector('#mesh-tools:not([hidden])');
  await drawn(page);
  assert.match(
    await page.textContent('#mesh-about'),
    /^mould\.bdf: 144 elements, 0 beyond the cloth, the farthest [\d.]+ × 10⁻\S+ m from it/,
  );
  assert.ok((await difference(page, net, await page.locator('#pane-solid').screenshot())) > 0.1);
  await picture(page, 'mapped');
  assert.deepEqual(await violations(page), []);
});

test('mesh: an element under the pointer says the number of the service', async () => {
  const { cells } = await (await map('format=json')).json();
  await page.mouse.move(...(await middle()));
  await drawn(page);
  const [, id, value] = /^element (\d+): ([\d.]+)°$/.exec(await page.textContent('#chip'));
  const shear = Math.abs(cells.shear_deg[cells.id.indexOf(Number(id))]);
  assert.ok(Math.abs(shear - Number(value)) < 1e-3 * Math.max(1, shear), `${shear} and ${value}`);
});

test('mesh: clicks choose the inlet, and so do numbers', async () => {
  await page.mouse.click(...(await middle()));
  const first = await page.inputValue('#mesh-inlet');
  assert.match(first, /^\d+$/);
  await page.mouse.click(...(await middle()));
  assert.equal(await page.inputValue('#mesh-inlet'), '');
  await page.fill('#mesh-inlet', '17 3, 999');
  await page.press('#mesh-inlet', 'Enter');
  assert.equal(await page.inputValue('#mesh-inlet'), '3, 17');
  assert.match(await page.textContent('#fault-mesh'), /no element 999/);
});

test('mesh: every format of the service is a download', async () => {
  const description = await (await fetch(new URL('v1/openapi.json', daemon.url))).json();
  const { parameters } = description.paths['/v1/drapes/{id}/map'].post;
  const formats = parameters.find(({ name }) => name === 'format').schema.enum;
  const shown = await page
    .locator('#mesh-downloads button')
    .evaluateAll((all) => all.map((button) => button.textContent));
  assert.deepEqual(shown, formats);
  const [file, request] = await Promise.all([
    page.waitForEvent('download'),
    page.waitForRequest((asked) => asked.url().includes('format=vtu')),
    page.click('#mesh-downloads button:text-is("vtu")'),
  ]);
  assert.equal(file.suggestedFilename(), 'mould-draped.vtu');
  const query = new URL(request.url()).search.slice(1); // with the gates and the channel of the page
  const own = await (await map(query)).arrayBuffer();
  assert.equal(readFileSync(await file.path()).length, own.byteLength);
});

test('mesh: the cavity has the height that is given, and a wrong one says why', async () => {
  const type = async (id, text) => {
    await page.fill(id, text);
    await page.press(id, 'Enter');
  };
  const says = (id, pattern) =>
    page.waitForFunction(
      ([where, source]) => new RegExp(source).test(document.querySelector(where).textContent),
      [id, pattern],
    );
  await page.selectOption('#field', 'thickness');
  await says('#mesh-range', 'Thickness: (0.0005|5.*10⁻⁴)');
  await type('#mesh-height', 'pid:1:0.004');
  await says('#mesh-range', 'Thickness: (0.004|4.*10⁻³)');
  await says('#mesh-about', 'thinner than the cavity');
  await type('#mesh-punch', 'pid:99');
  await says('#fault-mesh', 'punch');
  await type('#mesh-punch', '');
  await type('#mesh-height', '');
  await says('#mesh-range', 'Thickness: (0.0005|5.*10⁻⁴)');
  assert.equal(await page.textContent('#fault-mesh'), '');
  await page.selectOption('#field', 'shear');
});

test('mesh: another drape is mapped anew, and the net comes back', async () => {
  const before = await page.locator('#pane-solid').screenshot();
  await page.fill('#angle', '30');
  await page.press('#angle', 'Enter');
  await page.waitForFunction((id) => !location.hash.includes(id), idOf(page));
  await page.waitForSelector('#mesh-show:checked');
  await drawn(page);
  assert.ok(
    (await difference(page, before, await page.locator('#pane-solid').screenshot())) > 0.02,
  );
  await page.uncheck('#mesh-show');
  await drawn(page);
  await page.mouse.move(...(await middle()));
  await drawn(page);
  assert.match(await page.textContent('#chip'), /^cell/);
  await page.check('#mesh-show');
  await page.click('#mesh-close');
  assert.ok(await page.isHidden('#mesh-tools'));
});

test('mesh: what cannot be mapped says why', async () => {
  await drop('#mesh-drop', 'broken.bdf', 'GRID,1,,0.,0.\nCTRIA3,1,1,1,2,3\n');
  await page.waitForFunction(() => document.querySelector('#fault-mesh').textContent);
  assert.match(await page.textContent('#fault-mesh'), /^broken\.bdf: /);
  const faults = page.faults.filter((fault) => !/status of 4\d\d/.test(fault));
  assert.deepEqual(faults, []);
});
