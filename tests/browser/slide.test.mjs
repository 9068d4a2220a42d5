// SPDX-License-Identifier: MIT
// Fabrics that slide: their weft is drawn broken between fibres, by as much as these have slid.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import { browser, daemon, difference, drawn, openOnce, page, picture, root } from './helper.mjs';

openOnce();

const request = (kinematics) => {
  const sphere = JSON.parse(readFileSync(join(root, 'api/examples/sphere.json')));
  return { ...sphere, method: 'gib4', fabric: { ...sphere.fabric, kinematics } };
};

/** The result of a drape with parallel fibres, or another fabric. */
async function drapeOf(kinematics) {
  const answer = await fetch(new URL('v1/drapes', daemon.url), {
    method: 'POST',
    headers: { 'Content-Type': 'application/json', Prefer: 'wait=40' },
    body: JSON.stringify(request(kinematics)),
  });
  assert.equal(answer.status, 200);
  return answer.json();
}

/** The picture of a drape's net; without `tells` the page takes its fabric for a weave. */
async function pictureOf({ id }, tells = true) {
  const context = await browser.newContext({ viewport: { width: 1200, height: 800 } });
  if (!tells)
    await context.route(`**/v1/drapes/${id}/request`, async (route) => {
      const answer = await route.fetch();
      const told = await answer.json();
      delete told.fabric.kinematics;
      await route.fulfill({ response: answer, json: told });
    });
  const other = await context.newPage();
  await other.goto(`${daemon.url}#drape=${id}&view=solid&show=yarns,surface`);
  await other.waitForSelector('html[data-ready]');
  await drawn(other);
  const shot = await picture(other, tells ? 'slide' : 'no_slide', {
    clip: await other.locator('#pane-solid').boundingBox(),
  });
  await context.close();
  return shot;
}

test('slide: fibres have slid by the way of the weft along them', async () => {
  const { nodes, grid } = await drapeOf('parallel_fibers');
  const [a, b] = grid.spacing;
  const found = await page.evaluate(
    async ([shear, spacing]) => {
      const script = document.querySelector('script[src$="main.js"]').src;
      const { slipsOf } = await import(new URL('net.js', script));
      const lattice = { columns: { 'nodes.shear_deg': shear }, cellOfNode: [] };
      return [0, 0.5, 1].map((slide) => Array.from(slipsOf(lattice, slide, spacing) ?? []));
    },
    [nodes.shear_deg, grid.spacing],
  );
  assert.deepEqual(found[0], []);
  const at = new Map(nodes.i.map((i, n) => [`${i} ${nodes.j[n]}`, n]));
  const place = (n) => ['x', 'y', 'z'].map((axis) => nodes[axis][n]);
  const way = (from, to) => place(to).map((x, axis) => x - place(from)[axis]);
  let [most, seen, sum] = [0, 0, 0];
  nodes.i.forEach((i, n) => {
    const [left, right, below, above] = [
      [-1, 0],
      [1, 0],
      [0, -1],
      [0, 1],
    ].map(([p, q]) => at.get(`${i + p} ${nodes.j[n] + q}`));
    if ([left, right, below, above].includes(undefined)) return;
    const fibre = way(left, right);
    const weft = way(below, above);
    const along = weft.reduce((dot, x, axis) => dot + x * fibre[axis], 0) / Math.hypot(...fibre);
    const slid = along / 2 / a; // to the next fibre, in warp steps
    most = Math.max(most, Math.abs(found[2][n] - slid));
    assert.ok(Math.abs(found[1][n]) <= Math.abs(found[2][n]));
    sum += Math.abs(slid);
    seen++;
  });
  assert.ok(seen > 300 && sum / seen > 0.05, `${seen} nodes, slid by ${sum / seen}`);
  assert.ok(most < 0.02, `${most} warp steps off, with weft of ${b / a}`);
});

test('slide: the weft is broken in the picture where fibres slide, and nowhere in a weave', async () => {
  const differs = async (kinematics) => {
    const drape = await drapeOf(kinematics);
    return difference(page, await pictureOf(drape), await pictureOf(drape, false));
  };
  const weave = await differs('pin_jointed');
  const half = await differs({ slide: 0.5 });
  const parallel = await differs('parallel_fibers');
  assert.equal(weave, 0);
  assert.ok(half > 0.004, `${half}`);
  assert.ok(parallel > 1.2 * half, `${parallel} and ${half}`);
});
