// SPDX-License-Identifier: MIT
// The tools: each does one thing with the daemon and answers with numbers and a picture.
import { McpServer, ResourceTemplate } from '@modelcontextprotocol/sdk/server/mcp.js';
import type { RequestHandlerExtra } from '@modelcontextprotocol/sdk/shared/protocol.js';
import type {
  CallToolResult,
  ServerNotification,
  ServerRequest,
} from '@modelcontextprotocol/sdk/types.js';
import { Draped, DrapedError, VERSION, type Jobs, type Kind } from 'draped';
import type { z } from 'zod';
import { troubleOf } from './answer.js';
import type { Folder } from './folder.js';
import { Jobs as Told } from './jobs.js';
import { Maps } from './maps.js';
import { Parts } from './parts.js';
import { requests } from './requests.js';

export interface Setting {
  client: Draped;
  folder: Folder;
  /** Milliseconds that one tool call may take. */
  limit: number;
}
type Extra = RequestHandlerExtra<ServerRequest, ServerNotification>;
type Name = keyof typeof requests;
type Arguments<N extends Name> = z.output<(typeof requests)[N]>;

const INSTRUCTIONS = `Drapes woven fabric on parts: import_part, list_faces to see which faces are the
mould's, drape some of them; where it shears too much, study other starts and angles, or pieces with
cuts and splits; then pattern to cut by, laminate for a stack, map for a simulation's mesh, report to
file. Lengths are in the part's length unit, angles in degrees. An error says which arguments to
correct; parts and jobs that worked stay.`;
const GRACE_MS = 2000; // beyond the limit, for the answer to say so itself

const DESCRIPTIONS: Record<Name, string> = {
  import_part: 'Stores a part from a file of CAD or mesh: its id, faces and what was healed.',
  list_faces: 'Faces of a stored part: kind, area, centre, normal; the picture has their numbers.',
  drape: 'Lays cloth on chosen faces: coverage, shear, warnings, whether it can be laid at all.',
  study: 'Drapes many starts, angles or cuts and shows the best by the first objective.',
  pieces: 'Lays one ply of several cloths (splits, courses) or with cuts; patterns of all pieces.',
  laminate: 'Lays a stack of plies, each with its own cloth, direction and boundary.',
  pattern: 'The flat pattern to cut of a drape, or of all plies on a roll; saves it as a file.',
  map: 'Fields (thickness, fibre volume, permeability) on the mesh of a simulation or at points.',
  report: 'Saves the report of a drape or the ply book of a laminate as one page of HTML.',
  wait: 'Waits for a job that took longer than one call may, and answers as its tool does.',
};

/** Waits no longer than the limit allows, whatever hangs. */
async function within<T>(limit: number, work: Promise<T>): Promise<T> {
  let timer: NodeJS.Timeout | undefined;
  const late = new Promise<never>((_, reject) => {
    const detail = `The call took longer than ${limit / 1000} s.`;
    const fail = () => reject(new DrapedError({ slug: 'wait-timeout', detail }));
    timer = setTimeout(fail, limit + GRACE_MS);
  });
  return Promise.race([work, late]).finally(() => clearTimeout(timer));
}

/** A schema of the daemon's own document with all that it refers to. */
async function schemaOf(client: Draped, name: string): Promise<string> {
  const document = (await (await client.call('/v1/openapi.json')).json()) as {
    components: { schemas: Record<string, unknown> };
  };
  const all = document.components.schemas;
  const taken: Record<string, unknown> = {};
  const take = (key: string) => {
    if (key in taken || !(key in all)) return;
    taken[key] = all[key];
    const uses = JSON.stringify(all[key]).matchAll(/"#\/components\/schemas\/(\w+)"/g);
    for (const [, used] of uses) take(used!);
  };
  take(name);
  const known = Object.keys(all).filter((key) => key.endsWith('Request'));
  if (!(name in taken)) throw new Error(`There is no schema ${name}: ${known.join(', ')}.`);
  return JSON.stringify(taken);
}

export function serverOf({ client, folder, limit }: Setting): McpServer {
  const server = new McpServer(
    { name: 'draped', version: VERSION },
    { instructions: INSTRUCTIONS },
  );
  const parts = new Parts(client, folder);
  const jobs = new Told(client, folder);
  const maps = new Maps(client, folder, jobs);

  /** The daemon is known to be of this version. */
  let isKnown = false;
  const know = async () => {
    if (!isKnown) await client.version();
    isKnown = true;
  };

  /** `below`: where the daemon's request has what the tool takes as its arguments. */
  const tool = <N extends Name>(
    name: N,
    work: (given: Arguments<N>, extra: Extra) => Promise<CallToolResult>,
    below = '',
  ) => {
    const about = { description: DESCRIPTIONS[name], inputSchema: requests[name] as z.ZodType };
    server.registerTool(name, about, async (given: unknown, extra: Extra) => {
      try {
        return await within(
          limit,
          know().then(() => work(given as Arguments<N>, extra)),
        );
      } catch (error) {
        return troubleOf(error, below);
      }
    });
  };

  /** How a job is waited for: its progress is told to who asked for that. */
  const waiting = ({ signal, _meta, sendNotification }: Extra) => ({
    limit,
    signal,
    ...(_meta?.progressToken !== undefined && {
      onStatus: ({ progress }: { progress: number }) => {
        const params = { progressToken: _meta.progressToken!, progress, total: 1 };
        void sendNotification({ method: 'notifications/progress', params }).catch(() => {});
      },
    }),
  });
  const run = async <K extends Kind>(kind: K, request: unknown, extra: Extra) => {
    const status = await client.run(kind, request as Jobs[K]['request'], waiting(extra));
    return jobs.tell(kind, status.id);
  };

  tool('import_part', (given) => parts.take(given));
  tool('list_faces', (given) => parts.list(given));
  tool('drape', (request, extra) => run('drapes', request, extra));
  tool('study', (request, extra) => run('studies', request, extra));
  tool('laminate', (request, extra) => run('laminates', request, extra));
  tool(
    'pieces',
    ({ surface, ...ply }, extra) => run('laminates', { surface, plies: [ply] }, extra),
    '/plies/0',
  );
  tool('pattern', (given) => jobs.pattern(given));
  tool('report', (given) => jobs.report(given));
  tool('map', (given) => maps.map(given));
  tool('wait', async ({ id }, extra) => {
    const kind = await jobs.kindOf(id);
    await client.wait(kind, id, waiting(extra));
    return jobs.tell(kind, id);
  });

  const json = { mimeType: 'application/json' };
  server.registerResource(
    'schemas',
    new ResourceTemplate('draped://schemas/{name}', { list: undefined }),
    { description: 'Every key of a request: DrapeRequest, StudyRequest, LaminateRequest', ...json },
    async ({ href: uri }, { name }) => ({
      contents: [{ uri, ...json, text: await schemaOf(client, String(name)) }],
    }),
  );
  server.registerResource(
    'materials',
    'draped://materials',
    { description: 'Fabrics by name, for fabric.material', ...json },
    async ({ href: uri }) => ({
      contents: [{ uri, ...json, text: await (await client.call('/v1/materials')).text() }],
    }),
  );
  return server;
}
