// SPDX-License-Identifier: MIT
// The server of the Model Context Protocol, called by the protocol's own client, against a daemon:
// a part from STEP to its pattern, as docs/agents.md tells it (DRAPE_GOLDEN=write writes that page
// and its pictures anew), and all that goes wrong.
import assert from 'node:assert/strict';
import { execFileSync, spawn } from 'node:child_process';
import { once } from 'node:events';
import { cpSync, existsSync, mkdtempSync, readFileSync, readdirSync, rmSync } from 'node:fs';
import { symlinkSync, writeFileSync } from 'node:fs';
import { createServer } from 'node:http';
import { createRequire } from 'node:module';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { root, startDaemon } from '../browser/helper.mjs';

const source = join(root, 'clients/mcp');
const sdk = createRequire(join(source, 'package.json'));
const { Client } = sdk('@modelcontextprotocol/sdk/client/index.js');
const { StdioClientTransport } = sdk('@modelcontextprotocol/sdk/client/stdio.js');
const { PNG } = sdk('pngjs');
const { format } = createRequire(join(root, 'tests/browser/package.json'))('prettier');
const program = join(source, 'draped-mcp.js');
const folder = mkdtempSync(join(tmpdir(), 'agent-'));
const transcript = join(root, 'docs/agents.md');
const writes = process.env.DRAPE_GOLDEN === 'write';
let daemon, agent, part;

/** A session with its own server. */
async function session(...flags) {
  const client = new Client({ name: 'test', version: '1' });
  const args = [program, '--folder', folder, ...flags];
  await client.connect(
    new StdioClientTransport({ command: process.execPath, args, stderr: 'inherit' }),
  );
  return client;
}

/** The numbers and the picture of a tool's answer, or its error; a picture that has colours. */
async function call(client, name, given, options) {
  const { content, isError } = await client.callTool(
    { name, arguments: given },
    undefined,
    options,
  );
  const told = content[0].text.startsWith('{') ? JSON.parse(content[0].text) : content[0].text;
  if (isError) return { error: told };
  assert.equal(told.no_picture, undefined, name);
  const png = Buffer.from(content[1].data, 'base64');
  const { data, width, height } = PNG.sync.read(png);
  assert.ok(Math.max(width, height) === 1000, `${name} ${width} x ${height}`);
  assert.ok(new Set(new Uint32Array(data.buffer, data.byteOffset, width * height)).size > 10, name);
  return { ...told, png };
}

before(async () => {
  for (const name of ['dome.step', 'mould.bdf'])
    cpSync(join(root, 'api/examples', name), join(folder, name));
  writeFileSync(join(folder, 'letter.step'), 'no STEP');
  symlinkSync('/etc/hostname', join(folder, 'link.step'));
  daemon = await startDaemon({ flags: ['--workers', '2'] });
  agent = await session('--url', daemon.url);
  part = await call(agent, 'import_part', { file: 'dome.step' });
});
after(async () => {
  await agent?.close();
  await daemon?.stop();
  rmSync(folder, { recursive: true, force: true });
});

const fabric = { spacing: 5, thickness: 0.5, fiber_volume_fraction: 0.5 };
const dome = () => ({ id: part.id, grow_from: 6, up_to_deg: 20 });

/** What the page shows: some keys of an answer, numbers to four digits, ids of jobs by a name. */
async function shown(told, keys, names) {
  const picked = keys.length ? Object.fromEntries(keys.map((key) => [key, told[key]])) : told;
  const digits = (_, value) =>
    typeof value === 'number' ? Number(Number(value.toFixed(6)).toPrecision(4)) : value;
  const text = await format(JSON.stringify(picked, digits), { parser: 'json', printWidth: 100 });
  const named = [...names].reduce((all, [id, name]) => all.replaceAll(id, name), text);
  return named.replaceAll(folder, '.').trim();
}

test('mcp: a part from STEP to its pattern is what docs/agents.md shows', async () => {
  const lines = [readFileSync(transcript, 'utf8').split('\n<!-- made')[0]];
  lines.push('<!-- made by tests/clients/mcp.test.mjs from what the tools answer -->\n');
  const names = new Map();
  const step = async (say, tool, given, keys, picture) => {
    const { png, ...told } = await call(agent, tool, given);
    if (told.best_drape) names.set(told.best_drape.id, 'ID-OF-BEST');
    if (!['import_part', 'list_faces', 'pattern'].includes(tool) && told.id)
      names.set(told.id, `ID-OF-${tool.toUpperCase()}`);
    lines.push(`${say}\n\n\`\`\`\n${tool} ${await shown(given, [], names)}\n`);
    lines.push(`${await shown(told.error ?? told, keys, names)}\n\`\`\`\n`);
    if (!picture) return told;
    lines.push(`![${tool}](figures/${picture}.png)\n`);
    if (writes) writeFileSync(join(root, `docs/figures/${picture}.png`), png);
    return told;
  };
  await step(
    'The part comes as a file of the folder that the server was started with.',
    'import_part',
    { file: 'dome.step' },
    ['id', 'length_unit', 'face_count', 'edges', 'notes'],
  );
  await step(
    'Which faces does cloth lie on? The picture has their numbers, from above and from below.',
    'list_faces',
    { id: part.id, first: 6, count: 1 },
    ['faces', 'folds'],
    'agent_faces',
  );
  await step(
    'What is wrong in a request has its place and what to send instead.',
    'drape',
    { surface: { ...dome(), faces: [6] }, fabric: { spacing: 4 } },
    ['problem', 'errors', 'remedy'],
  );
  const limited = { surface: dome(), fabric: { spacing: 4, locking_angle_deg: 45 } };
  await step(
    'The upper skin, from the dome over smooth edges, in a cloth that locks at 45 degrees.',
    'drape',
    limited,
    ['id', 'verdict', 'cloth_coverage', 'max_shear_deg', 'p95_shear_deg'],
    'agent_drape',
  );
  const { best_drape: best } = await step(
    'It does not bear that. One that locks at 55 degrees does; which angle wastes least of it?',
    'study',
    {
      drape: { ...limited, fabric: { spacing: 4, locking_angle_deg: 55 } },
      vary: { angle_deg: { from: 0, to: 75, step: 15 } },
      objectives: ['waste_area'],
      limits: { max_shear_deg: { max: 55 } },
    },
    ['id', 'variants', 'feasible', 'verdict', 'best'],
  );
  await step(
    'The best has been draped. Its pattern with an allowance of 10 mm goes to the cutter.',
    'pattern',
    { id: best.id, format: 'dxf', allowance: 10, save_as: 'dome.dxf' },
    ['saved', 'flat_area', 'max_shear_deg'],
    'agent_pattern',
  );
  assert.match(readFileSync(join(folder, 'dome.dxf'), 'latin1'), /ALLOWANCE/);
  const page = lines.join('\n');
  if (writes) writeFileSync(transcript, page);
  assert.equal(page, readFileSync(transcript, 'utf8'));
});

test('mcp: every tool is there, described, and takes what the daemon takes', async () => {
  const { tools } = await agent.listTools();
  const names = tools.map(({ name }) => name).sort();
  assert.equal(
    names.join(),
    'drape,import_part,laminate,list_faces,map,pattern,pieces,report,study,wait',
  );
  assert.ok(tools.every(({ description }) => description.length > 40));
  const text = async (name) =>
    JSON.parse((await agent.readResource({ uri: `draped://schemas/${name}` })).contents[0].text);
  const { DrapeRequest, Fabric } = await text('DrapeRequest');
  const { LaminateRequest } = await text('LaminateRequest');
  const properties = (name) => tools.find((tool) => tool.name === name).inputSchema.properties;
  const ply = LaminateRequest.properties.plies.items.properties;
  for (const key of Object.keys(properties('drape')))
    assert.ok(key in DrapeRequest.properties, key);
  for (const key of Object.keys(properties('drape').fabric.properties))
    assert.ok(key in Fabric.properties, key);
  for (const key of Object.keys(properties('pieces')))
    assert.ok(key in DrapeRequest.properties || key in ply, key);
  for (const key of Object.keys(properties('study')))
    assert.ok(key in (await text('StudyRequest')).StudyRequest.properties, key);
  const { contents } = await agent.readResource({ uri: 'draped://materials' });
  assert.ok(JSON.parse(contents[0].text).materials.length > 3);
});

test('mcp: pieces, laminates, maps and reports answer with numbers and pictures', async () => {
  const arc = Array.from({ length: 23 }, (_, k) => ((k - 11) * Math.PI) / 24);
  const path = arc.map((a) => [0, 60 * Math.sin(a), 60 * Math.cos(a)]);
  const pieces = await call(agent, 'pieces', {
    surface: { id: part.id, faces: [6] },
    fabric,
    splits: [{ path }],
    seam: { overlap: 10 },
  });
  assert.equal(pieces.plies[0].pieces.length, 2);
  assert.ok(pieces.plies[0].pieces.every(({ max_shear_deg: shear }) => shear > 10));
  const stack = await call(agent, 'laminate', {
    surface: dome(),
    plies: [
      { name: 'a', fabric },
      { name: 'b', fabric, direction: { angle_deg: 45 } },
    ],
  });
  assert.deepEqual(
    stack.plies.map(({ name, cloth_coverage: share }) => [name, share > 0.999]),
    [
      ['a', true],
      ['b', true],
    ],
  );
  const mesh = { file: 'mould.bdf', field: 'thickness', format: 'csv', save_as: 'map.csv' };
  const mapped = await call(agent, 'map', { id: stack.id, ...mesh });
  assert.ok(mapped.count === 144 && mapped.fields.thickness.least > 1);
  assert.equal(readFileSync(mapped.saved, 'utf8').trim().split('\n').length, 145);
  const points = [
    [0, 0, 60],
    [0, 0, 900],
  ];
  const there = await call(agent, 'map', { id: stack.plies[0].id, points });
  assert.deepEqual([there.count, there.fields.distance.greatest], [2, 840]);
  const other = await call(agent, 'map', { id: stack.id, points, field: 'colour' });
  assert.match(other.error.errors[0].detail, /is no field of this map: .*thickness/);
  for (const id of [stack.id, stack.plies[1].id]) {
    const report = await call(agent, 'report', { id });
    assert.match(readFileSync(report.saved, 'utf8'), /<\/html>/);
  }
  const roll = await call(agent, 'pattern', { id: pieces.id, width: 300 });
  assert.equal(roll.saved, undefined);
});

test('mcp: faces are listed by pages, also of a part that another session stored', async () => {
  const other = await session('--url', daemon.url);
  try {
    const page = await call(other, 'list_faces', { id: part.id, first: 3, count: 2, chosen: [6] });
    assert.deepEqual(
      page.faces.map(({ index }) => index),
      [3, 4],
    );
    assert.equal(page.next_face, 5);
    const none = await call(other, 'list_faces', { id: '0'.repeat(32) });
    assert.equal(none.error.problem, 'not-found');
  } finally {
    await other.close();
  }
});

test('mcp: a broken part, a wrong request, a file elsewhere: each is told, the session goes on', async () => {
  const broken = await call(agent, 'import_part', { file: 'letter.step' });
  assert.equal(broken.error.problem, 'unreadable-file');
  assert.match(broken.error.remedy, /Export the part again/);
  for (const file of ['/etc/hostname', '../x.step', 'link.step', 'none.step', '.'])
    assert.equal((await call(agent, 'import_part', { file })).error.problem, 'file', file);
  const both = await call(agent, 'import_part', {});
  assert.equal(both.error.errors[0].pointer, '/file');
  const wrong = await call(agent, 'drape', { surface: dome(), fabric: { spacing: -1 }, colour: 1 });
  assert.deepEqual(wrong.error.errors.map(({ pointer }) => pointer).sort(), [
    '/colour',
    '/fabric/spacing',
  ]);
  const text = await call(agent, 'drape', { surface: dome(), fabric: { spacing: '4 mm' } });
  assert.match(text.error, /must be a number.* at fabric\.spacing/);
  const far = [
    [0, -70, 0],
    [0, 70, 0],
  ];
  const split = await call(agent, 'pieces', { surface: dome(), fabric, splits: [{ path: far }] });
  assert.equal(split.error.errors[0].pointer, '/splits/0');
  const study = await call(agent, 'study', {
    drape: { surface: dome(), fabric },
    vary: { angle_deg: [0, 45] },
    objectives: ['max_shear_deg'],
  });
  assert.match((await call(agent, 'report', { id: study.id })).error.detail, /is a study/);
  const again = await call(agent, 'wait', { id: study.id });
  assert.deepEqual(again.best, study.best);
});

test('mcp: files are written whole, once, and nothing else is left', async () => {
  const drape = await call(agent, 'drape', { surface: dome(), fabric });
  const save = { id: drape.id, save_as: 'cut.svg' };
  await call(agent, 'pattern', save);
  const first = readFileSync(join(folder, 'cut.svg'), 'utf8');
  assert.match(first, /<\/svg>\s*$/);
  const second = await call(agent, 'pattern', { ...save, allowance: 5 });
  assert.match(second.error.detail, /cut\.svg is there already/);
  assert.equal(readFileSync(join(folder, 'cut.svg'), 'utf8'), first);
  const deep = await call(agent, 'pattern', { ...save, save_as: 'no/cut.svg' });
  assert.match(deep.error.detail, /There is no folder/);
  assert.deepEqual(
    readdirSync(folder).filter((name) => name.startsWith('.')),
    [],
  );
});

test('mcp: a job longer than a call may take goes on and is waited for', async () => {
  const idle = await startDaemon({ flags: ['--role', 'api'] }); // nobody drapes
  const short = await session('--url', idle.url, '--limit', '1');
  try {
    const { surface, ...request } = JSON.parse(
      readFileSync(join(root, 'api/examples/saddle.json'), 'utf8'),
    );
    const heard = [];
    const options = { onprogress: ({ progress }) => heard.push(progress) };
    const late = await call(short, 'drape', { surface, ...request }, options);
    assert.equal(late.error.problem, 'wait-timeout');
    assert.match(late.error.remedy, /Call wait with its id/);
    assert.equal(heard[0], 0);
    const id = /drapes\/([0-9a-f]{32})/.exec(late.error.detail)[1];
    assert.equal((await call(short, 'wait', { id })).error.problem, 'wait-timeout');
    await fetch(new URL(`/v1/drapes/${id}/cancel`, idle.url), { method: 'POST' });
    assert.equal((await call(short, 'wait', { id })).error.problem, 'cancelled');
  } finally {
    await short.close();
    await idle.stop();
  }
});

/** What the first tool call is answered with, of a session with these flags. */
async function troubleOf(...flags) {
  const client = await session(...flags);
  try {
    return (await call(client, 'import_part', { file: 'dome.step' })).error;
  } finally {
    await client.close();
  }
}

/** What is told of a server that answers as `answer` does. */
async function troubleWith(answer) {
  const server = createServer(answer);
  await new Promise((done) => server.listen(0, '127.0.0.1', done));
  try {
    return await troubleOf('--limit', '1', '--url', `http://127.0.0.1:${server.address().port}`);
  } finally {
    server.closeAllConnections();
    server.close();
  }
}

test('mcp: no connection, no answer, another version and a refused token each say what to do', async () => {
  const nobody = await troubleOf('--url', 'http://127.0.0.1:9');
  assert.equal(nobody.problem, 'unreachable');
  assert.match(nobody.detail, /http:\/\/127\.0\.0\.1:9 cannot be reached/);
  assert.match(nobody.remedy, /--url/);
  const silent = await troubleWith(() => {});
  assert.match(silent.detail, /did not answer within 2 s/);
  const old = await troubleWith((request, response) => {
    response.setHeader('Content-Type', 'application/json');
    response.end('{"name": "draped", "version": "7.1.0"}');
  });
  assert.deepEqual([old.problem, /7\.1\.0/.test(old.detail)], ['other-version', true]);
  const tokens = join(folder, 'tokens');
  const words = ['hash-token', 'ann', 'write'];
  const input = 'secret-of-ann-0123456789';
  const line = execFileSync(join(root, process.env.BUILD || 'build', 'draped'), words, { input });
  writeFileSync(tokens, line, { mode: 0o600 });
  writeFileSync(join(folder, 'own'), `${input}\n`);
  writeFileSync(join(folder, 'wrong'), 'secret-of-bob-0123456789');
  const guarded = await startDaemon({ flags: ['--tokens', tokens] });
  try {
    const where = ['--url', guarded.url, '--token-file'];
    const refused = await troubleOf(...where, join(folder, 'wrong'));
    assert.deepEqual([refused.problem, refused.status], ['unauthorized', 401]);
    assert.match(refused.remedy, /--token-file/);
    assert.equal(await troubleOf(...where, join(folder, 'own')), undefined);
  } finally {
    await guarded.stop();
  }
});

test('mcp: settings that cannot be are refused at the start, and stdin ends the server', async () => {
  const started = (...flags) => {
    const child = spawn(process.execPath, [program, ...flags], { stdio: ['pipe', 'pipe', 'pipe'] });
    return { child, ended: once(child, 'exit') };
  };
  const wrong = [
    ['--url', 'daemon'],
    ['--limit', '0'],
    ['--folder', '/no/such'],
    ['--token-file', '/no/such'],
    ['--colour'],
  ];
  for (const flags of wrong) {
    const { child, ended } = started(...flags);
    const [said] = await once(child.stderr, 'data');
    assert.match(String(said), /^draped-mcp: .+\n$/s);
    assert.deepEqual(await ended, [2, null], flags.join(' '));
  }
  const help = execFileSync(process.execPath, [program, '--help'], { encoding: 'utf8' });
  const readme = readFileSync(join(source, 'README.md'), 'utf8');
  assert.ok(readme.includes(help.trim()), 'the README shows --help');
  const { child, ended } = started('--folder', folder);
  child.stdin.end();
  assert.deepEqual(await ended, [0, null]);
  assert.ok(existsSync(folder));
});
