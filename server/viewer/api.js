// SPDX-License-Identifier: MIT
// Calls to the service: every address relative to the page, so that it works behind a proxy too;
// every error an exception with a sentence for the user.

const TOKEN = 'draped-token';
const NOWHERE = 'The service does not answer. Check that draped runs and try again.';
const RETRY_MS = [250, 500, 1000, 2000, 4000, 8000];

/** What the service refuses (RFC 9457). `errors` are places in the body that was sent. */
export class Problem extends Error {
  constructor(status, document) {
    super(document.detail || document.title || `The service answered with status ${status}.`);
    this.status = status;
    this.slug = String(document.type || '').replace('/problems/', '');
    this.errors = document.errors || [];
    if (!this.errors.length && document.pointer) this.errors = [document];
  }
}

/** All that is wrong, each with its place. */
export const explain = ({ errors, message }) =>
  errors?.length
    ? errors.map(({ pointer = '', detail }) => `${pointer}: ${detail}`).join(' ')
    : message;

/** The service cannot be reached. */
export class Unreachable extends Error {
  constructor() {
    super(NOWHERE);
  }
}

/** `link`: of the link that the page was opened by, '' without; then nothing is changed. */
export const token = {
  link: '',
  get: () => token.link || sessionStorage.getItem(TOKEN) || '',
  set: (value) => (value ? sessionStorage.setItem(TOKEN, value) : sessionStorage.removeItem(TOKEN)),
};

/** The absolute address of a path such as 'v1/drapes'. */
export function address(path) {
  return new URL(path.replace(/^\//, ''), document.baseURI).href;
}

async function toProblem(response) {
  const text = await response.text().catch(() => '');
  try {
    return new Problem(response.status, JSON.parse(text));
  } catch {
    return new Problem(response.status, {});
  }
}

/** A response with a status of success; otherwise throws Problem, Unreachable or AbortError. */
export async function call(path, { method = 'GET', headers = {}, ...options } = {}) {
  const own = token.get();
  if (own) headers = { ...headers, Authorization: `Bearer ${own}` };
  let response;
  try {
    response = await fetch(address(path), { method, headers, ...options, cache: 'no-cache' });
  } catch (error) {
    if (error.name === 'AbortError') throw error;
    throw new Unreachable();
  }
  if (response.ok) return response;
  throw await toProblem(response);
}

/** As `call`, with the whole body read as 'json', 'text', 'arrayBuffer' or 'blob'. */
export async function read(path, kind = 'json', options = {}) {
  const response = await call(path, options);
  try {
    return await response[kind]();
  } catch (error) {
    if (error.name === 'AbortError') throw error;
    throw new Unreachable();
  }
}

function post(path, body, headers, signal) {
  const json = { 'Content-Type': 'application/json', ...headers };
  return call(path, { method: 'POST', body, headers: json, signal });
}

/** Stores a surface; what the service says of it. `type`: of the body; `query` as after '?'. */
export async function storeSurface(body, type, query = '') {
  return (await post(`v1/surfaces${query}`, body, { 'Content-Type': type })).json();
}

export const preview = (id) => read(`v1/surfaces/${id}/preview?format=glb`, 'arrayBuffer');

/** Submits a drape request (JSON text); its status document. */
export async function submit(body, signal) {
  return (await post('v1/drapes', body, {}, signal)).json();
}

/** Submits and waits for the columns in the same call: {id, columns}; columns null when it takes
 *  longer than `seconds`. `names`: the columns that are wanted, null for all. */
export async function drapeNow(body, seconds, names) {
  const path = `v1/drapes?format=npz${names ? `&fields=${names}` : ''}`;
  const response = await post(path, body, { Prefer: `wait=${seconds}` });
  const id = (response.headers.get('Location') || '').split('/').pop();
  return { id, columns: response.status === 200 ? await response.arrayBuffer() : null };
}

/** Submits a study (JSON text); its status document. */
export async function submitStudy(body, signal) {
  return (await post('v1/studies', body, {}, signal)).json();
}

/** Makes a link of jobs, by their ids; `seconds`: for how long, 0 until it is taken back. */
export const makeLink = (ids, seconds) =>
  read(`v1/links?of=${ids}${seconds ? `&expires_in=${seconds}` : ''}`, 'json', { method: 'POST' });
export const links = () => read('v1/links');
export const dropLink = (id) => call(`v1/links/${id}`, { method: 'DELETE' });

/** Submits a laminate (JSON text); its status document. */
export async function submitLaminate(body) {
  return (await post('v1/laminates', body, {})).json();
}

/** Of drapes, or of another kind of job. */
export const status = (id, signal) => read(`v1/drapes/${id}`, 'json', { signal });
export const cancel = (id, kind = 'drapes') => call(`v1/${kind}/${id}/cancel`, { method: 'POST' });
/** `leaving`: the call outlives the page. */
export const remove = (id, leaving = false) =>
  call(`v1/drapes/${id}`, { method: 'DELETE', keepalive: leaving });
export const list = (limit) => read(`v1/drapes?limit=${limit}`);

const pause = (ms) => new Promise((done) => setTimeout(done, ms));

/** Reads one stream of server-sent events to its end, calls `onStatus`; the last status. */
async function readEvents(id, kind, onStatus, signal) {
  const response = await call(`v1/${kind}/${id}/events`, { signal });
  const reader = response.body.pipeThrough(new TextDecoderStream()).getReader();
  let text = '';
  let last = null;
  for (;;) {
    const { value, done } = await reader.read();
    if (done) return last;
    const messages = (text + value).split('\n\n');
    text = messages.pop();
    for (const message of messages) {
      const data = message.split('\n').find((line) => line.startsWith('data: '));
      if (!data) continue;
      last = JSON.parse(data.slice(6));
      onStatus(last);
    }
  }
}

const ended = (document) => ['succeeded', 'failed', 'cancelled'].includes(document?.status);

/** Follows a job to its end, over a service that restarts meanwhile: the last status. */
export async function follow(id, onStatus, signal, kind = 'drapes') {
  for (let failures = 0; ; ) {
    try {
      const last = await readEvents(id, kind, onStatus, signal);
      if (ended(last)) return last;
      if (last) failures = 0;
    } catch (error) {
      if (error.name === 'AbortError' || (error instanceof Problem && error.status < 500))
        throw error;
    }
    if (failures === RETRY_MS.length) throw new Unreachable();
    onStatus(null);
    await pause(RETRY_MS[failures++]);
  }
}
