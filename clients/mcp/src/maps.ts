// SPDX-License-Identifier: MIT
// Fields of a drape or laminate on the mesh of a simulation, or at points.
import type { CallToolResult } from '@modelcontextprotocol/sdk/types.js';
import { DrapedError, fromVtu, type components, type Draped } from 'draped';
import { answerOf } from './answer.js';
import type { Folder } from './folder.js';
import type { Jobs } from './jobs.js';
import { pictured, viridis, type Facet } from './picture.js';

/** Fields by name, and each element's corners, or each point. */
interface Mapped {
  columns: Record<string, ArrayLike<number | boolean>>;
  places: number[][][];
}

/** The least, mean and greatest value that is a number. */
function spanOf(values: ArrayLike<number | boolean>): {
  least: number;
  mean: number;
  greatest: number;
} {
  const numbers = Array.from(values, Number).filter(Number.isFinite);
  const least = numbers.reduce((a, b) => Math.min(a, b), Infinity);
  const greatest = numbers.reduce((a, b) => Math.max(a, b), -Infinity);
  const mean = numbers.reduce((a, b) => a + b, 0) / numbers.length;
  return { least, mean, greatest };
}

function mappedMesh(buffer: ArrayBuffer): Mapped {
  const { columns, points, connectivity, offsets } = fromVtu(buffer);
  const corner = (k: number) => Array.from(points.subarray(3 * k, 3 * k + 3));
  const places = Array.from(offsets, (end, k) =>
    Array.from(connectivity.subarray(k ? offsets[k - 1] : 0, end), corner),
  );
  return { columns, places };
}

export class Maps {
  readonly #client: Draped;
  readonly #folder: Folder;
  readonly #jobs: Jobs;

  constructor(client: Draped, folder: Folder, jobs: Jobs) {
    this.#client = client;
    this.#folder = folder;
    this.#jobs = jobs;
  }

  async map(given: {
    id: string;
    file?: string | undefined;
    points?: number[][] | undefined;
    field: string;
    format: string;
    save_as?: string | undefined;
  }): Promise<CallToolResult> {
    const { id, file, field, format, save_as, ...request } = given;
    const kind = await this.#jobs.clothOf(id);
    const mesh = file === undefined ? request : await this.#folder.read(file);
    const answer = (as: string) =>
      this.#client.map(kind, id, mesh as components['schemas']['MapRequest'], {
        as,
        ...(file !== undefined && { name: file }),
      });
    const { points } = request;
    const { columns, places } = points
      ? { ...(await this.#atPoints(await answer('json'))), places: points.map((each) => [each]) }
      : mappedMesh(await (await answer('vtu')).arrayBuffer());
    if (!(field in columns)) {
      const detail = `is no field of this map: ${Object.keys(columns).join(', ')}`;
      throw new DrapedError({ slug: 'invalid-request', detail, pointer: '/field' });
    }
    const saved =
      save_as === undefined
        ? undefined
        : await this.#folder.write(
            save_as,
            new Uint8Array(await (await answer(format)).arrayBuffer()),
          );
    const fields = Object.fromEntries(
      Object.entries(columns).map(([name, values]) => [name, spanOf(values)]),
    );
    const extrapolated = Array.from(columns.extrapolated ?? []).filter(Boolean).length;
    const numbers = { saved, count: places.length, extrapolated, fields };
    return answerOf(numbers, () => picture(columns[field]!, places, field));
  }

  async #atPoints(response: Response): Promise<Pick<Mapped, 'columns'>> {
    const { cells } = (await response.json()) as { cells: Mapped['columns'] };
    return { columns: cells };
  }
}

function picture(values: Mapped['columns'][string], places: number[][][], field: string) {
  const { least, greatest } = spanOf(values);
  const facets: Facet[] = places.map((corners, k) => {
    const share = (Number(values[k]) - least) / (greatest - least || 1);
    return {
      corners,
      colour: Number.isFinite(share) ? viridis(share) : [0.8, 0.8, 0.8],
      label: '',
    };
  });
  const [low, high] = [least, greatest].map((value) => Number(value.toPrecision(4)));
  return pictured(facets, `${field}: ${low} (dark) to ${high} (yellow)`);
}
