// SPDX-License-Identifier: MIT
// The npm package: packed, installed where nothing else is, without a registry, and used there
// against a daemon.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { createServer } from 'node:http';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { pathToFileURL } from 'node:url';
import { after, before, test } from 'node:test';
import { root, startDaemon } from '../browser/helper.mjs';

const source = join(root, 'clients/typescript');
const example = (name) => JSON.parse(readFileSync(join(root, `api/examples/${name}.json`)));
const { version } = JSON.parse(readFileSync(join(source, 'package.json')));
const dome = readFileSync(join(root, 'api/examples/dome.step'));
let project, daemon, draped, client;

const npm = (folder, ...words) =>
  execFileSync('npm', [...words, '--offline', '--no-audit', '--no-fund', '--silent'], {
    cwd: folder,
    encoding: 'utf8',
  });

/** The error that a call ends with. */
const errorOf = (promise) =>
  promise.then(
    () => assert.fail('it succeeded'),
    (error) => error,
  );

before(async () => {
  project = mkdtempSync(join(tmpdir(), 'bare-'));
  npm(source, 'pack', '--pack-destination', project);
  writeFileSync(join(project, 'package.json'), '{"type": "module", "private": true}');
  npm(project, 'install', join(project, `draped-${version}.tgz`));
  daemon = await startDaemon({ flags: ['--workers', '2'] });
  draped = await import(pathToFileURL(join(project, 'node_modules/draped/dist/index.js')));
  client = new draped.Draped({ url: daemon.url });
});
after(async () => {
  await daemon?.stop();
  rmSync(project, { recursive: true, force: true });
});

test('typescript: a bare project compiles against the types, and what they refuse is refused', () => {
  const write = (name, text) => writeFileSync(join(project, name), text);
  write(
    'good.ts',
    `import { Draped, DrapedError, type Columns } from 'draped';
     import type { DrapedPart } from 'draped/part';
     const client = new Draped({ url: 'http://127.0.0.1:1' });
     const { summary } = await client.drape({ surface: { id: 'a' }, fabric: { spacing: 1 } });
     const shear: number | undefined = summary?.max_shear_deg;
     const { data } = await client.api.GET('/v1/drapes/{id}', { params: { path: { id: 'a' } } });
     const status: 'queued' | 'running' | 'succeeded' | 'failed' | 'cancelled' | undefined = data?.status;
     const columns: Columns = await client.columns('drapes', 'a');
     declare const part: DrapedPart;
     part.addEventListener('draped-pick', ({ detail }) => detail?.values);
     export { shear, status, columns, DrapedError };`,
  );
  write(
    'bad.ts',
    `import { Draped } from 'draped';
     const client = new Draped();
     client.drape({ surface: { id: 'a' }, fabric: { spacing: 1 }, method: 'gob' });
     client.api.GET('/v1/drapes/{id}');`,
  );
  const tsc = (file) =>
    execFileSync(
      process.execPath,
      [
        join(source, 'node_modules/typescript/bin/tsc'),
        '--noEmit',
        '--strict',
        '--module',
        'nodenext',
        '--target',
        'es2022',
        file,
      ],
      { cwd: project, encoding: 'utf8' },
    );
  assert.equal(tsc('good.ts'), '');
  assert.throws(
    () => tsc('bad.ts'),
    ({ stdout }) => {
      assert.match(stdout, /\(3,67\).*'"gob"' is not assignable/);
      assert.match(stdout, /\(4,17\).*Expected 2 arguments/);
      return true;
    },
  );
});

test('typescript: both entries load where there are no elements', async () => {
  const { DrapedPart } = await import(
    pathToFileURL(join(project, 'node_modules/draped/dist/part.js'))
  );
  assert.equal(typeof DrapedPart, 'function');
});

test('typescript: the version is that of the daemon', async () => {
  assert.equal(await client.version(), version);
  assert.equal(draped.VERSION, version);
});

test('typescript: a STEP file is uploaded by its name and some faces draped', async () => {
  const part = await client.upload(new Blob([dome]), { name: 'dome.STP' });
  assert.equal(part.faces.length, 9);
  const seen = [];
  const status = await client.drape(
    { surface: { id: part.id, grow_from: 6, up_to_deg: 20 }, fabric: { spacing: 5 } },
    { onStatus: ({ progress }) => seen.push(progress) },
  );
  assert.equal(status.status, 'succeeded');
  assert.equal(seen.at(-1), 1);
  const columns = await client.columns('drapes', status.id);
  assert.equal(columns['nodes.x'].length, status.summary.nodes);
  assert.ok(columns['cells.shear_deg'] instanceof Float64Array);
  const some = await client.columns('drapes', status.id, { fields: ['cells.shear_deg'] });
  assert.deepEqual(Object.keys(some), ['cells.shear_deg']);
  assert.deepEqual(some['cells.shear_deg'], columns['cells.shear_deg']);
  assert.match(await client.pattern('drapes', status.id), /^<\?xml|^<svg/);
});

test('typescript: faces of a preview and fields on a mesh are arrays', async () => {
  const { id, faces } = await client.upload(new Blob([dome]), { name: 'dome.step' });
  const preview = await (await client.call(`/v1/surfaces/${id}/preview`)).arrayBuffer();
  const numbers = draped.fromGlb(preview).map(({ face }) => face);
  assert.deepEqual(
    numbers,
    faces.map(({ index }) => index),
  );
  const drape = await client.drape(example('saddle'));
  const mesh = readFileSync(join(root, 'api/examples/mould.bdf'));
  const options = { name: 'mould.bdf', as: 'vtu' };
  const vtu = await client.map('drapes', drape.id, new Blob([mesh]), options);
  const { columns, offsets } = draped.fromVtu(await vtu.arrayBuffer());
  assert.deepEqual([offsets.length, columns.shear_deg.length], [144, 144]);
  const point = await client.map('drapes', drape.id, { points: [[0, 0, 0]] });
  assert.equal((await point.json()).cells.distance[0], 0);
});

test('typescript: columns are those of the JSON to the last bit', async () => {
  const { id } = await client.drape(example('hemisphere'));
  const { data } = await client.api.GET('/v1/drapes/{id}/result', { params: { path: { id } } });
  const columns = await client.columns('drapes', id);
  for (const table of ['nodes', 'cells'])
    for (const [name, values] of Object.entries(data[table]))
      assert.deepEqual(Array.from(columns[`${table}.${name}`]), values, `${table}.${name}`);
});

test('typescript: events come in their order to the end', async () => {
  const request = { ...example('saddle'), fabric: { spacing: 0.013 } };
  const { data } = await client.api.POST('/v1/drapes', { body: request });
  const seen = [];
  for await (const status of client.events('drapes', data.id)) seen.push(status);
  assert.ok(seen.length >= 1);
  assert.equal(seen.at(-1).status, 'succeeded');
  const progress = seen.map((status) => status.progress);
  assert.deepEqual(
    progress,
    [...progress].sort((a, b) => a - b),
  );
});

test('typescript: studies and laminates are run like drapes', async () => {
  const saddle = { ...example('saddle'), fabric: { spacing: 0.4 } };
  const study = await client.study({
    drape: saddle,
    vary: { angle_deg: [0, 30, 45] },
    objectives: ['max_shear_deg'],
  });
  const variants = await client.columns('studies', study.id);
  assert.deepEqual([...variants['variants.angle_deg']], [0, 30, 45]);
  const { surface, fabric } = saddle;
  const laminate = await client.laminate({
    surface,
    plies: [
      { name: 'a', fabric },
      { name: 'b', fabric, direction: { angle_deg: 45 } },
    ],
  });
  assert.deepEqual(
    laminate.plies.map(({ status }) => status),
    ['succeeded', 'succeeded'],
  );
  assert.match(await client.pattern('laminates', laminate.id, { width: 8 }), /<svg/);
});

test('typescript: what the service refuses has its place and its words', async () => {
  const error = await errorOf(
    client.drape({ surface: example('saddle').surface, fabric: { spacing: -1 } }),
  );
  assert.ok(error instanceof draped.DrapedError);
  assert.deepEqual([error.slug, error.status], ['invalid-request', 422]);
  assert.equal(error.errors[0].pointer, '/fabric/spacing');
  const letter = await errorOf(client.upload(new Blob(['no STEP']), { name: 'letter.step' }));
  assert.equal(letter.slug, 'unreadable-file');
  const other = await errorOf(client.upload(new Blob(['PK']), { name: 'part.sldprt' }));
  assert.match(other.message, /export the part as STEP/);
  const far = { ...example('saddle'), start: { point: [50, 0, 0] } };
  assert.equal((await errorOf(client.drape(far))).slug, 'start-off-surface');
});

test('typescript: a token is asked for and refused by name', async () => {
  const folder = mkdtempSync(join(tmpdir(), 'tokens-'));
  const file = join(folder, 'tokens');
  const program = join(root, process.env.BUILD || 'build', 'draped');
  const line = execFileSync(program, ['hash-token', 'ann', 'write'], {
    input: 'secret-of-ann-0123456789',
  });
  writeFileSync(file, line, { mode: 0o600 });
  const guarded = await startDaemon({ flags: ['--tokens', file] });
  try {
    const without = await errorOf(new draped.Draped({ url: guarded.url }).drape(example('saddle')));
    assert.deepEqual([without.slug, without.status], ['unauthorized', 401]);
    const own = new draped.Draped({ url: guarded.url, token: 'secret-of-ann-0123456789' });
    assert.equal((await own.drape(example('saddle'))).status, 'succeeded');
  } finally {
    await guarded.stop();
    rmSync(folder, { recursive: true });
  }
});

/** A server that answers as `answer` does, while `use` is called with its address. */
async function beside(answer, use) {
  const server = createServer(answer);
  await new Promise((done) => server.listen(0, '127.0.0.1', done));
  try {
    return await use(`http://127.0.0.1:${server.address().port}`);
  } finally {
    server.closeAllConnections();
    server.close();
  }
}

test('typescript: no connection, no answer and another version are errors of their own', async () => {
  const nobody = await errorOf(new draped.Draped({ url: 'http://127.0.0.1:9' }).version());
  assert.equal(nobody.slug, 'unreachable');
  await beside(
    () => {},
    async (url) => {
      const silent = await errorOf(new draped.Draped({ url, timeout: 200 }).version());
      assert.match(silent.message, /did not answer within 0\.2 s/);
    },
  );
  const old = (request, response) => {
    response.setHeader('Content-Type', 'application/json');
    response.end('{"name": "draped", "version": "7.1.0", "solver_version": "7.1.0"}');
  };
  const other = await beside(old, (url) => errorOf(new draped.Draped({ url }).version()));
  assert.equal(other.slug, 'other-version');
  assert.match(
    other.message,
    new RegExp(
      `is draped 7\\.1\\.0, this client is for ${version.replaceAll('.', '\\.')}: install draped@7\\.1`,
    ),
  );
});

test('typescript: a full service is asked again when it says, and given up after four times', async () => {
  let asked = 0;
  const full = (request, response) => {
    response.writeHead(++asked % 5 ? 429 : 200, {
      'Retry-After': '0',
      'Content-Type': 'application/json',
    });
    response.end(
      JSON.stringify({ type: '/problems/queue-full', title: 'full', status: 429, detail: 'full' }),
    );
  };
  const error = await beside(full, (url) => errorOf(new draped.Draped({ url }).version()));
  assert.deepEqual([error.slug, asked], ['queue-full', 4]);
});

test('typescript: waiting ends with its limit, and when it is given up', async () => {
  const idle = await startDaemon({ flags: ['--role', 'api'] }); // nobody drapes
  try {
    const own = new draped.Draped({ url: idle.url });
    const late = await errorOf(own.drape(example('saddle'), { limit: 300 }));
    assert.equal(late.slug, 'wait-timeout');
    const { id } = (await own.api.GET('/v1/drapes')).data.drapes[0];
    for (const onStatus of [undefined, () => {}]) {
      const signal = AbortSignal.timeout(50);
      const aborted = await errorOf(own.wait('drapes', id, { signal, onStatus }));
      assert.equal(aborted.name, 'TimeoutError');
    }
    await own.api.POST('/v1/drapes/{id}/cancel', { params: { path: { id } } });
    assert.equal((await errorOf(own.wait('drapes', id))).slug, 'cancelled');
  } finally {
    await idle.stop();
  }
});
