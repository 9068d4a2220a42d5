// SPDX-License-Identifier: MIT
// Holds the answers that `keep_answer` of helper.bash has kept to api/openapi.yaml: the operation, the
// status, the type of content, the headers it promises and the body by its schema, compressed or not;
// of event streams each event. Of what came raw from a socket every answer, one after the other.
// Says what is wrong, and exits with 1 then. Usage: contract.mjs FOLDER
import { execFileSync } from 'node:child_process';
import { existsSync, readdirSync, readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { gunzipSync } from 'node:zlib';

const require = createRequire(new URL('../manifests/package.json', import.meta.url));
const Ajv = require('ajv/dist/2020.js').default;
const folder = process.argv[2];
const document = JSON.parse(
  execFileSync(
    'python3',
    [
      '-c',
      'import json, sys, yaml\n' +
        'json.dump(yaml.load(open("api/openapi.yaml"), getattr(yaml, "CSafeLoader", yaml.SafeLoader)), sys.stdout)',
    ],
    { maxBuffer: 1 << 26 },
  ),
);
const ajv = new Ajv({ strict: false, allErrors: false, validateFormats: false });
ajv.addSchema({ $id: 'draped', components: document.components });
const validators = new Map();
const faults = new Set();
const seen = new Set();

const resolve = (object) =>
  object?.$ref
    ? object.$ref
        .slice(2)
        .split('/')
        .reduce((at, key) => at[key], document)
    : object;

// References of a schema lead into the whole document.
function rebase(schema) {
  if (Array.isArray(schema)) return schema.map(rebase);
  if (schema === null || typeof schema !== 'object') return schema;
  return Object.fromEntries(
    Object.entries(schema).map(([key, value]) => [
      key,
      key === '$ref' ? `draped${value}` : rebase(value),
    ]),
  );
}

function validator(schema) {
  if (!validators.has(schema)) validators.set(schema, ajv.compile(rebase(schema)));
  return validators.get(schema);
}

// Columns are alike from end to end: of long ones the beginning and the end are looked at.
const shorten = (key, value) =>
  Array.isArray(value) && value.length > 40 ? [...value.slice(0, 30), ...value.slice(-10)] : value;

const templates = Object.keys(document.paths).map((path) => ({
  path,
  pattern: new RegExp(`^${path.replace(/[.]/g, '\\.').replace(/\{[^}]*\}/g, '[^/]+')}$`),
}));

// curl may have decoded it already: the first bytes tell.
function decode(bytes, coding) {
  if (coding === 'gzip' && bytes.readUInt16BE() === 0x1f8b) return gunzipSync(bytes);
  if (coding === 'zstd' && bytes.readUInt32BE() === 0x28b52ffd)
    return execFileSync('zstd', ['-dcq'], { input: bytes, maxBuffer: 1 << 30 });
  return bytes;
}

// The last head of the file: an interim answer or a redirect may come before it.
function parseHead(text) {
  const head = text
    .trimEnd()
    .split(/\r?\n\r?\n/)
    .at(-1)
    .split(/\r?\n/);
  const headers = new Map();
  for (const line of head.slice(1)) {
    const at = line.indexOf(':');
    headers.set(line.slice(0, at).toLowerCase(), line.slice(at + 1).trim());
  }
  return { status: head[0].split(' ')[1], headers };
}

// Events as `x-events` of the content names them, with the schema of their data. The last one may be
// cut off: the caller has gone.
function checkEvents(names, text, fault) {
  for (const event of text.split('\n\n').slice(0, -1)) {
    const field = (name) => new RegExp(`^${name}: (.*)$`, 'm').exec(event)?.[1];
    if (/^:/.test(event)) continue;
    const schema = names[field('event')];
    if (!schema || !field('id')) fault(`the event is ${event.slice(0, 80)}`);
    else if (!validator(schema)(JSON.parse(field('data'))))
      fault(`${field('event')}: ${ajv.errorsText(validator(schema).errors)}`);
  }
}

function checkBody(what, media, type, bytes, headers, fault) {
  if (!media) return fault(`${type} is not among its contents`);
  if (!bytes) return;
  if (media['x-events']) return checkEvents(media['x-events'], bytes.toString(), fault);
  if (!/json$/.test(type) || !media.schema) return;
  const text = decode(bytes, headers.get('content-encoding')).toString();
  const validate = validator(media.schema);
  let body;
  try {
    body = JSON.parse(text, shorten);
  } catch (error) {
    return fault(`its body is no JSON: ${error.message}`);
  }
  if (!validate(body)) fault(ajv.errorsText(validate.errors));
}

// The body that begins there as it came from a socket, and where it ends.
function takeBody(bytes, headers) {
  const length = Number(headers.get('content-length') ?? bytes.length);
  if (headers.get('transfer-encoding') !== 'chunked')
    return { body: bytes.subarray(0, length), end: Math.min(length, bytes.length) };
  const parts = [];
  for (let at = 0; ; ) {
    const line = bytes.indexOf('\r\n', at);
    const size = line < 0 ? 0 : parseInt(bytes.toString('latin1', at, line), 16);
    if (!size) return { body: Buffer.concat(parts), end: line < 0 ? bytes.length : line + 4 };
    parts.push(bytes.subarray(line + 2, line + 2 + size));
    at = line + 4 + size;
  }
}

// Of the answers on one connection the first is that of the request; what the others belong to is not
// known. The rest of one that was cut off is no answer.
function checkRaw(method, target, bytes) {
  while (bytes.length > 0) {
    const end = bytes.indexOf('\r\n\r\n');
    if (end < 0 || bytes.toString('latin1', 0, 5) !== 'HTTP/') return;
    const { status, headers } = parseHead(bytes.toString('latin1', 0, end));
    const rest = bytes.subarray(end + 4);
    const taken = status === '100' ? { end: 0 } : takeBody(rest, headers);
    if (status !== '100') checkAnswer(method, target, status, headers, taken.body);
    if (status !== '100') [method, target] = ['?', '?'];
    bytes = rest.subarray(taken.end);
  }
}

function check(name) {
  const [method, target, raw] = readFileSync(`${folder}/${name}`, 'utf8').trim().split(' ');
  const head = readFileSync(`${folder}/${name}.headers`, 'utf8');
  if (!head.trim()) return; // no answer: the caller gave up
  const file = `${folder}/${name}.body`;
  const bytes = existsSync(file) ? readFileSync(file) : undefined;
  if (raw) return checkRaw(method, target, Buffer.concat([Buffer.from(head, 'latin1'), bytes]));
  const { status, headers } = parseHead(head);
  if (status === '100') return; // cut off between "go on" and the answer
  checkAnswer(method, target, status, headers, bytes);
}

function checkAnswer(method, target, status, headers, bytes) {
  const type = (headers.get('content-type') ?? '').split(';')[0];
  const path = target.split('?')[0];
  const template = templates.find(({ pattern }) => pattern.test(path))?.path;
  const operation = document.paths[template]?.[(method === 'HEAD' ? 'GET' : method).toLowerCase()];
  const what = `${method} ${template ?? path} ${status} ${type} ${headers.get('content-encoding') ?? ''}`;
  const fault = (text) => faults.add(`${what}: ${text} (${target})`);
  seen.add(what);
  if (!headers.has('x-request-id')) fault('no X-Request-Id');
  const problem = { schema: { $ref: '#/components/schemas/Problem' } };
  if (!operation) {
    // There is no such path or method; or it was refused before that was looked at.
    if (method === 'OPTIONS' && status === '204') return;
    if (!/^[45]/.test(status)) return method === '?' || fault('there is no such operation');
    return method === 'HEAD' || checkBody(what, problem, type, bytes, headers, fault);
  }
  const response = resolve(operation.responses[status]);
  if (!response) return fault('the status is not documented');
  for (const [header, definition] of Object.entries(response.headers ?? {})) {
    const { required, schema } = resolve(definition);
    const value = headers.get(header.toLowerCase());
    if (required && value === undefined) fault(`${header} is missing`);
    if (value !== undefined && schema) {
      const validate = validator(schema);
      const typed = /integer|number/.test(schema.type) ? Number(value) : value;
      if (!validate(typed)) fault(`${header}: ${value}`);
    }
  }
  if (method === 'HEAD') return;
  if (!response.content) {
    if (type && !['204', '206', '304'].includes(status)) fault('it has a body');
    return;
  }
  checkBody(what, response.content[type], type, bytes, headers, fault);
}

const names = readdirSync(folder).filter((name) => !name.includes('.'));
names.forEach(check);
for (const fault of faults) console.log(fault);
console.log(`${names.length} answers, ${seen.size} kinds, ${faults.size} faults`);
process.exit(faults.size > 0 || names.length === 0 ? 1 : 0);
