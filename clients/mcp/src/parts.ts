// SPDX-License-Identifier: MIT
// Parts: from files to faces with numbers.
import type { CallToolResult } from '@modelcontextprotocol/sdk/types.js';
import { DrapedError, fromGlb, type Draped, type FileOptions, type StoredSurface } from 'draped';
import { answerOf } from './answer.js';
import type { Folder } from './folder.js';
import { colourOf, pictured, type Facet } from './picture.js';

const LISTED = 50; // faces in the answer to an import
const PAGE = 100; // parts that are asked for at a time
const LABELLED = 120; // faces of a part whose numbers can still be read

/** A part's triangles, each face in its colour and with its number; all but `chosen` grey. */
function facetsOf(preview: ArrayBuffer, chosen?: number[]): Facet[] {
  const bodies = fromGlb(preview);
  return bodies.flatMap(({ face, position, index }) => {
    const shown = !chosen || chosen.includes(face);
    const label = shown && bodies.length <= LABELLED ? String(face) : '';
    const colour = shown ? colourOf(face) : ([0.8, 0.8, 0.8] satisfies Facet['colour']);
    const corner = (k: number) => Array.from(position.subarray(3 * k, 3 * k + 3));
    return Array.from({ length: index.length / 3 }, (_, k) => ({
      corners: Array.from(index.subarray(3 * k, 3 * k + 3), corner),
      colour,
      label,
    }));
  });
}

export class Parts {
  readonly #client: Draped;
  readonly #folder: Folder;
  readonly #known = new Map<string, StoredSurface>();

  constructor(client: Draped, folder: Folder) {
    this.#client = client;
    this.#folder = folder;
  }

  async take(given: {
    file?: string | undefined;
    surface?: object | undefined;
    unit?: FileOptions['unit'];
  }): Promise<CallToolResult> {
    const { file, surface, unit } = given;
    if ((file === undefined) === (surface === undefined)) {
      const detail = 'Give either file, the name of one, or surface, an object.';
      throw new DrapedError({ slug: 'invalid-request', detail, pointer: '/file' });
    }
    const body = file === undefined ? surface : await this.#folder.read(file);
    const part = await this.#client.upload(body as Parameters<Draped['upload']>[0], {
      ...(file !== undefined && { name: file }),
      ...(unit && { unit }),
    });
    this.#known.set(part.id, part);
    return this.#tell(part, 0, LISTED);
  }

  async list(given: {
    id: string;
    first: number;
    count: number;
    chosen?: number[] | undefined;
  }): Promise<CallToolResult> {
    return this.#tell(await this.#find(given.id), given.first, given.count, given.chosen);
  }

  /** What the daemon told when the part was stored, also by others. */
  async #find(id: string): Promise<StoredSurface> {
    let cursor: string | null | undefined;
    while (!this.#known.has(id)) {
      const query = { limit: PAGE, ...(cursor && { cursor }) };
      const { data } = await this.#client.api.GET('/v1/surfaces', { params: { query } });
      for (const part of data?.surfaces ?? []) this.#known.set(part.id, part);
      cursor = data?.next;
      if (cursor || this.#known.has(id)) continue;
      throw new DrapedError({ slug: 'not-found', status: 404, detail: `There is no part ${id}.` });
    }
    return this.#known.get(id)!;
  }

  #tell(part: StoredSurface, first: number, count: number, chosen?: number[]) {
    const { faces = [], joints = [], ...rest } = part;
    const listed = faces.slice(first, first + count);
    const numbers = {
      ...rest,
      face_count: faces.length,
      faces: listed.map(({ bounding_box: _, ...face }) => face),
      ...(first + listed.length < faces.length && { next_face: first + listed.length }),
      folds: joints.filter(([a, b]) => listed.some(({ index }) => index === a || index === b)),
      folds_are: 'two faces, and the greatest angle in degrees by which they fold where they meet',
    };
    return answerOf(numbers, async () => {
      const preview = await this.#client.call(`/v1/surfaces/${part.id}/preview`);
      const named = faces.length ? `${faces.length} faces, their numbers` : 'one face';
      return pictured(facetsOf(await preview.arrayBuffer(), chosen), named);
    });
  }
}
