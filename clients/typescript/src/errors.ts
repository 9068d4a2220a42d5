// SPDX-License-Identifier: MIT
// Every way a call can fail, as one class of error.
import type { components } from './schema.js';

export type Problem = components['schemas']['Problem'];

/**
 * What the service refused (RFC 9457), or why there is no answer.
 *
 * `slug` names the kind: those of the service (`invalid-request`, `unauthorized`, `too-large`, ...),
 * the job's own (`start-off-surface`, ...), and three of the client: `unreachable` (no connection, or
 * no answer in time), `wait-timeout` (the job goes on), `other-version` (the daemon's).
 * `status` is that of HTTP, 0 without an answer. `errors` are the places in what was sent.
 */
export class DrapedError extends Error {
  override readonly name = 'DrapedError';
  readonly slug: string;
  readonly status: number;
  readonly errors: { pointer: string; detail: string }[];
  readonly requestId: string | undefined;

  constructor(problem: Partial<Problem> & { slug?: string }, options?: ErrorOptions) {
    const errors = problem.errors ?? [];
    const detail =
      problem.detail ?? problem.title ?? `The service answered with ${problem.status}.`;
    const places = errors
      .filter((place) => place.detail !== detail)
      .map(({ pointer, detail }) => `\n  ${pointer}: ${detail}`);
    super(detail + places.join(''), options);
    this.slug = problem.slug ?? problem.type?.replace('/problems/', '') ?? 'unknown';
    this.status = problem.status ?? 0;
    this.requestId = problem.request_id;
    this.errors = errors.length
      ? errors
      : problem.pointer === undefined
        ? []
        : [{ pointer: problem.pointer, detail }];
  }
}

/** The error that an answer without success is. */
export async function errorOf(response: Response): Promise<DrapedError> {
  const text = await response.text().catch(() => '');
  try {
    return new DrapedError({ ...(JSON.parse(text) as Problem), status: response.status });
  } catch {
    const detail = `${response.url} answered with status ${response.status} and not as draped does.`;
    return new DrapedError({ slug: 'unknown', status: response.status, detail });
  }
}
