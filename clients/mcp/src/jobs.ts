// SPDX-License-Identifier: MIT
// Drapes, studies and laminates that have succeeded: what is told, drawn and saved of them.
import type { CallToolResult } from '@modelcontextprotocol/sdk/types.js';
import { DrapedError, type components, type Draped, type Kind } from 'draped';
import { answerOf } from './answer.js';
import type { Folder } from './folder.js';
import { drawn, drawnOf } from './picture.js';

type Schemas = components['schemas'];
const KINDS: Kind[] = ['drapes', 'laminates', 'studies'];

/** A row of columns. */
const rowOf = (columns: Record<string, unknown[]>, k: number) =>
  Object.fromEntries(Object.entries(columns).map(([name, values]) => [name, values[k]]));

export class Jobs {
  readonly #client: Draped;
  readonly #folder: Folder;

  constructor(client: Draped, folder: Folder) {
    this.#client = client;
    this.#folder = folder;
  }

  async #json<T>(path: string): Promise<T> {
    return (await (await this.#client.call(path)).json()) as T;
  }

  async kindOf(id: string): Promise<Kind> {
    for (const kind of KINDS)
      try {
        await this.#client.call(`/v1/${kind}/${id}`);
        return kind;
      } catch (error) {
        if (!(error instanceof DrapedError && error.status === 404)) throw error;
      }
    const detail = `There is no drape, laminate or study ${id}.`;
    throw new DrapedError({ slug: 'not-found', status: 404, detail });
  }

  /** Of what can be cut, mapped and reported. */
  async clothOf(id: string): Promise<'drapes' | 'laminates'> {
    const kind = await this.kindOf(id);
    if (kind !== 'studies') return kind;
    const detail = `${id} is a study: drape its best variant, whose id is in best_drape, and use that.`;
    throw new DrapedError({ slug: 'invalid-request', detail, pointer: '/id' });
  }

  tell(kind: Kind, id: string): Promise<CallToolResult> {
    return { drapes: this.#drape, laminates: this.#laminate, studies: this.#study }[kind].call(
      this,
      id,
    );
  }

  /** The picture of a drape: that of its report. */
  async #picture(id: string): Promise<Uint8Array> {
    return drawnOf(await (await this.#client.call(`/v1/drapes/${id}/report`)).text());
  }

  async #summary(id: string) {
    const { status, summary, error } = await this.#json<Schemas['Status']>(`/v1/drapes/${id}`);
    const { timing_ms: _, ...numbers } = summary ?? {};
    return { id, status, ...numbers, ...(error && { error }) };
  }

  async #drape(id: string): Promise<CallToolResult> {
    return answerOf(await this.#summary(id), () => this.#picture(id));
  }

  async #plies(id: string) {
    const { plies = [] } = await this.#json<Schemas['LaminateStatus']>(`/v1/laminates/${id}`);
    const told = async ({ name, id: drape, error }: Partial<(typeof plies)[number]>) =>
      drape ? { name, ...(await this.#summary(drape)) } : { name, ...(error && { error }) };
    return Promise.all(
      plies.map(async ({ pieces, ...ply }) =>
        pieces
          ? {
              name: ply.name,
              numbers_are:
                'of each cloth on the whole part, of which the piece is what its pattern has',
              pieces: await Promise.all(pieces.map((piece) => told(piece))),
            }
          : told(ply),
      ),
    );
  }

  async #laminate(id: string): Promise<CallToolResult> {
    const {
      status,
      links: _,
      ...rest
    } = await this.#json<Schemas['LaminateStatus']>(`/v1/laminates/${id}`);
    const { summary } = rest as { summary?: object };
    const numbers = { id, status, ...summary, plies: await this.#plies(id) };
    return answerOf(numbers, async () => drawn(await this.#client.pattern('laminates', id)));
  }

  /** The best variant by the first objective is draped, so that it can be seen and cut. */
  async #study(id: string): Promise<CallToolResult> {
    type Result = Schemas['StudyResult'] &
      Record<'variants' | 'proposed', Record<string, unknown[]>>;
    const { summary, best, variants, proposed } = await this.#json<Result>(
      `/v1/studies/${id}/result`,
    );
    const rows = Object.entries(best).map(([objective, k]) => [
      objective,
      k === null ? null : { variant: k, ...rowOf(variants, k) },
    ]);
    const first = Object.values(best)[0] ?? summary.verdict.variant;
    const { timing_ms: _, ...rest } = summary;
    const numbers = { id, ...rest, best: Object.fromEntries(rows) };
    if (first === null || first === undefined)
      return answerOf(numbers, () => Promise.reject(new Error('No variant could be draped.')));
    const request = await this.#json<Schemas['DrapeRequest']>(
      `/v1/studies/${id}/variants/${first}/request`,
    );
    const drape = await this.#client.drape(request);
    const { cuts } = request;
    return answerOf(
      {
        ...numbers,
        best_drape: { ...(await this.#summary(drape.id)), ...(proposed && { cuts }) },
        picture_is: 'of best_drape',
      },
      () => this.#picture(drape.id),
    );
  }

  async pattern(given: {
    id: string;
    format: 'svg' | 'dxf' | 'astm' | 'hpgl';
    save_as?: string | undefined;
    allowance?: number | undefined;
    width?: number | undefined;
    partial?: 1 | undefined;
  }): Promise<CallToolResult> {
    const { id, format, save_as, ...rest } = given;
    const kind = await this.clothOf(id);
    const options = JSON.parse(JSON.stringify(rest)) as object; // without what is not given
    const file = await this.#client.pattern(kind, id, { ...options, format });
    const saved = save_as === undefined ? undefined : await this.#folder.write(save_as, file);
    const numbers = kind === 'drapes' ? await this.#summary(id) : { plies: await this.#plies(id) };
    const { partial: _, ...seen } = options as { partial?: 1 };
    const svg = format === 'svg' ? file : await this.#client.pattern(kind, id, seen);
    return answerOf({ saved, format, ...numbers }, () => drawn(svg));
  }

  async report({ id, save_as = `${id}.html` }: { id: string; save_as?: string | undefined }) {
    const kind = await this.clothOf(id);
    const page = await (await this.#client.call(`/v1/${kind}/${id}/report`)).text();
    const saved = await this.#folder.write(save_as, page);
    const numbers = kind === 'drapes' ? await this.#summary(id) : { plies: await this.#plies(id) };
    return answerOf({ saved, ...numbers }, () => drawnOf(page));
  }
}
