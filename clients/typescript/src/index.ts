// SPDX-License-Identifier: MIT
// A typed client of draped: every call of its OpenAPI document as `api`, and helpers for what takes
// more than one call: uploads, jobs that are waited for, events, results as typed arrays.
import { EventSourceParserStream } from 'eventsource-parser/stream';
import createClient, { type Client } from 'openapi-fetch';
import { readGlb } from '@viewer/glb.js';
import { readNpz } from '@viewer/npz.js';
import { readVtu } from '@viewer/vtu.js';
import { DrapedError, errorOf } from './errors.js';
import type { components, paths } from './schema.js';

export { DrapedError, type Problem } from './errors.js';
export type { components, operations, paths } from './schema.js';

type Schemas = components['schemas'];
export type StoredSurface = Schemas['StoredSurface'];
export type DrapeRequest = Schemas['DrapeRequest'];

/** What is posted and what is told of it, by the kind of job. */
export interface Jobs {
  drapes: { request: DrapeRequest; status: Schemas['Status'] };
  studies: { request: Schemas['StudyRequest']; status: Schemas['StudyStatus'] };
  laminates: { request: Schemas['LaminateRequest']; status: Schemas['LaminateStatus'] };
}
export type Kind = keyof Jobs;

/** A result by column: `nodes.x`, `cells.shear_deg`, ... */
export type Columns = Record<string, Float64Array>;

/** The columns of a result's file in NumPy's format. */
export const fromNpz: (buffer: ArrayBuffer) => Columns = readNpz;

/** The triangles of each face of a part, from its preview as `glb`. */
export const fromGlb: (
  buffer: ArrayBuffer,
) => { face: number; position: Float32Array; index: Uint32Array | Uint16Array }[] = readGlb;

/** A mapped mesh from its `vtu`: element k has the points `connectivity`, from `offsets[k - 1]` on. */
export const fromVtu: (buffer: ArrayBuffer) => {
  columns: Record<string, ArrayLike<number>>;
  points: Float64Array;
  connectivity: Float64Array;
  offsets: Float64Array;
} = readVtu;

export interface Settings {
  /** Where the daemon is; `http://127.0.0.1:8080` without it. */
  url?: string | URL;
  /** Sent as a bearer token. */
  token?: string;
  /** Milliseconds that one answer may take, 120 000 without it. */
  timeout?: number;
  /** In place of the platform's `fetch`. */
  fetch?: typeof fetch;
}

export interface Waiting<Status> {
  /** Called with the status whenever it has changed. */
  onStatus?: (status: Status) => void;
  /** Gives up waiting; the job goes on. */
  signal?: AbortSignal;
  /** Milliseconds after which waiting is given up, an hour without it. */
  limit?: number;
}

export interface FileOptions {
  /** The file's name, if `file` has none; its ending tells the format. */
  name?: string;
  /** Whatever the name says. */
  format?: keyof typeof MEDIA;
  /** Of a file that states none. */
  unit?: 'm' | 'mm' | 'cm' | 'um' | 'in' | 'ft';
  signal?: AbortSignal;
}

/** The version of this package, and of the daemon that it speaks with. */
export const VERSION: string = __VERSION__;
declare const __VERSION__: string; // of package.json, by build.mjs
const WAIT_S = 25; // that one call waits: fewer than proxies allow
const TIMEOUT_MS = 120e3; // of one answer
const HOUR_MS = 3600e3;
const ATTEMPTS = 4; // of a call that a full service puts off
const PATIENCE_S = 30; // that it may be put off
/** Of files: what the service calls them, and their media type. */
const MEDIA = {
  json: 'application/json',
  step: 'model/step',
  iges: 'model/iges',
  stl: 'model/stl',
  obj: 'model/obj',
  nastran: 'text/x-nastran',
  abaqus: 'text/x-abaqus',
  lsdyna: 'text/x-lsdyna',
  gmsh: 'text/x-gmsh',
  unv: 'text/x-unv',
  vtu: 'application/vnd.vtk',
};
const ENDINGS: Record<string, keyof typeof MEDIA> = {
  stp: 'step',
  p21: 'step',
  igs: 'iges',
  bdf: 'nastran',
  nas: 'nastran',
  dat: 'nastran',
  inp: 'abaqus',
  k: 'lsdyna',
  key: 'lsdyna',
  dyn: 'lsdyna',
  msh: 'gmsh',
};

const hasEnded = ({ status }: { status: string }) =>
  status === 'succeeded' || status === 'failed' || status === 'cancelled';

/** A format as the service calls it; what it does not know it says itself. */
function formatOf(file: unknown, { name, format }: FileOptions): string | undefined {
  const known = name ?? (file instanceof Blob && 'name' in file ? String(file.name) : '');
  const ending = known.toLowerCase().split('.').pop() ?? '';
  return format ?? ENDINGS[ending] ?? (ending || undefined);
}

export class Draped {
  /** Every call of the service by its path: `api.GET('/v1/drapes/{id}', {params: {path: {id}}})`.
   *  What is not a success is thrown as a DrapedError. */
  readonly api: Client<paths>;
  readonly url: string;
  readonly #settings: Settings;

  constructor(settings: Settings = {}) {
    this.#settings = settings;
    this.url = String(settings.url ?? 'http://127.0.0.1:8080').replace(/\/+$/, '');
    this.api = createClient<paths>({
      baseUrl: this.url,
      fetch: (request) => this.#fetch(request),
    });
  }

  /** One call with the token; again where the service is full and says when to come back. */
  async #fetch(request: Request): Promise<Response> {
    if (this.#settings.token)
      request.headers.set('Authorization', `Bearer ${this.#settings.token}`);
    for (let attempt = 1; ; attempt++) {
      const response = await this.#send(request.clone());
      if (response.ok) return response;
      const error = await errorOf(response);
      const seconds = Number(response.headers.get('Retry-After') ?? NaN);
      if (attempt === ATTEMPTS || !(seconds <= PATIENCE_S)) throw error;
      await new Promise((done) => setTimeout(done, 1000 * seconds));
      request.signal.throwIfAborted();
    }
  }

  /** One request under the time limit, which is for the whole answer. */
  async #send(request: Request): Promise<Response> {
    const { timeout = TIMEOUT_MS, fetch: send = globalThis.fetch } = this.#settings;
    const late = AbortSignal.timeout(timeout);
    try {
      return await send(request, { signal: AbortSignal.any([request.signal, late]) });
    } catch (error) {
      if (request.signal.aborted) throw error;
      const why = late.aborted ? `did not answer within ${timeout / 1000} s` : 'cannot be reached';
      const remedy = 'Check the address, that draped runs, and that it allows this origin.';
      const detail = `${new URL(request.url).origin} ${why}. ${remedy}`;
      throw new DrapedError({ slug: 'unreachable', detail }, { cause: error });
    }
  }

  /** A call by its path below the service, for what is not JSON. */
  call(path: string, options: RequestInit = {}): Promise<Response> {
    return this.#fetch(new Request(this.url + path, options));
  }

  /** The daemon's version; throws `other-version` if its calls may differ from those known here. */
  async version(): Promise<string> {
    const { data } = await this.api.GET('/version');
    const version = data?.version ?? '';
    const series = (text: string) => text.split('.').slice(0, 2).join('.');
    if (series(version) === series(VERSION)) return version;
    const detail =
      `${this.url} is ${data?.name ?? 'no draped'} ${version}, this client is for ${VERSION}: ` +
      `install draped@${series(version)} with npm.`;
    throw new DrapedError({ slug: 'other-version', detail });
  }

  /** Stores a part: a file of CAD or mesh, or a surface as an object. Its id goes into requests as
   *  `surface: {id}`, some of its faces as `{id, faces}`. */
  async upload(
    file: Blob | ArrayBuffer | Uint8Array<ArrayBuffer> | Schemas['SurfaceDefinition'],
    options: FileOptions = {},
  ): Promise<StoredSurface> {
    const raw = file instanceof Blob || file instanceof ArrayBuffer || ArrayBuffer.isView(file);
    const format = raw ? formatOf(file, options) : 'json';
    const query = new URLSearchParams({
      ...(format && { format }),
      ...(options.unit && { unit: options.unit }),
    });
    const response = await this.call(`/v1/surfaces?${query}`, {
      method: 'POST',
      body: raw ? file : JSON.stringify(file),
      headers: { 'Content-Type': raw ? 'application/octet-stream' : 'application/json' },
      ...(options.signal && { signal: options.signal }),
    });
    return (await response.json()) as StoredSurface;
  }

  /** Posts a job and waits until it has succeeded; throws its own problem if it has not. */
  async run<K extends Kind>(
    kind: K,
    request: Jobs[K]['request'],
    waiting: Waiting<Jobs[K]['status']> = {},
  ): Promise<Jobs[K]['status']> {
    const response = await this.call(`/v1/${kind}`, {
      method: 'POST',
      body: JSON.stringify(request),
      headers: { 'Content-Type': 'application/json' },
      ...(waiting.signal && { signal: waiting.signal }),
    });
    const status = (await response.json()) as Jobs[K]['status'];
    return this.wait(kind, status.id, waiting);
  }

  drape = (request: DrapeRequest, waiting?: Waiting<Jobs['drapes']['status']>) =>
    this.run('drapes', request, waiting);
  study = (request: Jobs['studies']['request'], waiting?: Waiting<Jobs['studies']['status']>) =>
    this.run('studies', request, waiting);
  laminate = (
    request: Jobs['laminates']['request'],
    waiting?: Waiting<Jobs['laminates']['status']>,
  ) => this.run('laminates', request, waiting);

  /** Waits until a job has succeeded: its status. Progress comes as events; where these break off,
   *  by a proxy or a service that restarts, the status is asked for. */
  async wait<K extends Kind>(
    kind: K,
    id: string,
    { onStatus, signal, limit = HOUR_MS }: Waiting<Jobs[K]['status']> = {},
  ): Promise<Jobs[K]['status']> {
    const end = Date.now() + limit;
    const { timeout = TIMEOUT_MS } = this.#settings;
    const hold = Math.min(WAIT_S, Math.max(1, Math.floor(timeout / 2000))); // well within one answer
    if (onStatus) await this.#watch(kind, id, onStatus, limit, signal);
    for (;;) {
      const left = Math.ceil((end - Date.now()) / 1000);
      if (left <= 0) {
        const detail = `${kind}/${id} has not ended within ${limit / 1000} s; it goes on.`;
        throw new DrapedError({ slug: 'wait-timeout', detail });
      }
      const path = `/v1/${kind}/${id}?wait=${Math.min(hold, left)}`;
      const response = await this.call(path, { ...(signal && { signal }) });
      const status = (await response.json()) as Jobs[K]['status'];
      if (status.status === 'succeeded') return status;
      if (!hasEnded(status)) continue;
      const cancelled = { slug: status.status, detail: `${kind}/${id} is ${status.status}.` };
      throw new DrapedError(status.error ?? cancelled);
    }
  }

  /** Tells every status until the job ends, the stream breaks off or the time is up. */
  async #watch<K extends Kind>(
    kind: K,
    id: string,
    onStatus: (status: Jobs[K]['status']) => void,
    limit: number,
    signal?: AbortSignal,
  ): Promise<void> {
    const late = AbortSignal.timeout(limit);
    try {
      const either = signal ? AbortSignal.any([signal, late]) : late;
      for await (const status of this.events(kind, id, either)) onStatus(status);
    } catch (error) {
      if (signal?.aborted || error instanceof DrapedError) throw error;
    }
  }

  /** The status of a job at once and whenever it changes, to its end. */
  async *events<K extends Kind>(
    kind: K,
    id: string,
    signal?: AbortSignal,
  ): AsyncGenerator<Jobs[K]['status']> {
    const { fetch: send = globalThis.fetch, token } = this.#settings;
    const response = await send(`${this.url}/v1/${kind}/${id}/events`, {
      ...(signal && { signal }),
      headers: token ? { Authorization: `Bearer ${token}` } : {},
    });
    if (!response.ok) throw await errorOf(response);
    if (!response.body) return; // it had ended, and the caller knew
    const messages = response.body
      .pipeThrough(new TextDecoderStream() as ReadableWritablePair<string, Uint8Array<ArrayBuffer>>)
      .pipeThrough(new EventSourceParserStream());
    const reader = messages.getReader();
    try {
      for (;;) {
        const { value, done } = await reader.read();
        if (done) return;
        yield JSON.parse(value.data) as Jobs[K]['status'];
        if (value.event === 'end') return;
      }
    } finally {
      await reader.cancel().catch(() => {});
    }
  }

  /** The columns of a result; `fields` for some of them: `['nodes.x', 'cells.shear_deg']`. */
  async columns(
    kind: 'drapes' | 'studies',
    id: string,
    { fields, signal }: { fields?: string[]; signal?: AbortSignal } = {},
  ): Promise<Columns> {
    const query = new URLSearchParams({
      format: 'npz',
      ...(fields && { fields: fields.join(',') }),
    });
    const response = await this.call(`/v1/${kind}/${id}/result?${query}`, {
      ...(signal && { signal }),
    });
    return readNpz(await response.arrayBuffer());
  }

  /** The fields of a drape or laminate at points or on a mesh, `json` or another format of maps. A
   *  file's ending, or `format`, tells what it is. */
  async map(
    kind: 'drapes' | 'laminates',
    id: string,
    mesh: Blob | Uint8Array<ArrayBuffer> | Schemas['MapRequest'],
    { as = 'json', ...options }: Omit<FileOptions, 'unit'> & { as?: string } = {},
  ): Promise<Response> {
    const raw = mesh instanceof Blob || ArrayBuffer.isView(mesh);
    const format = raw ? formatOf(mesh, options) : 'json';
    const type = MEDIA[format as keyof typeof MEDIA] ?? `application/x-${format}`;
    return this.call(`/v1/${kind}/${id}/map?${new URLSearchParams({ format: as })}`, {
      method: 'POST',
      body: raw ? mesh : JSON.stringify(mesh),
      headers: { 'Content-Type': type },
      ...(options.signal && { signal: options.signal }),
    });
  }

  /** All that leaves the house of a laminate, as a zip with a manifest. */
  async bundle(id: string): Promise<Blob> {
    return (await this.call(`/v1/laminates/${id}/bundle.zip`)).blob();
  }

  /** The flat cut pattern of a drape as a drawing, of a laminate all of them on a roll. */
  async pattern(
    kind: 'drapes' | 'laminates',
    id: string,
    options: {
      format?: 'svg' | 'dxf' | 'astm' | 'hpgl';
      allowance?: number;
      width?: number;
      partial?: 0 | 1;
    } = {},
  ): Promise<string> {
    const given = Object.entries(options).map(([key, value]) => [key, String(value)]);
    const path = kind === 'drapes' ? 'pattern' : 'patterns';
    return (await this.call(`/v1/${kind}/${id}/${path}?${new URLSearchParams(given)}`)).text();
  }
}
