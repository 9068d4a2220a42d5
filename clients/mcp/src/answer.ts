// SPDX-License-Identifier: MIT
// What a tool answers: numbers as JSON, and a picture; or what went wrong, and what to send instead.
import type { CallToolResult } from '@modelcontextprotocol/sdk/types.js';
import { DrapedError } from 'draped';

/** Eight digits are more than any part is made to, and half as much to read. */
const shorter = (_key: string, value: unknown) =>
  typeof value === 'number' ? Number(value.toPrecision(8)) : value;

/** `picture` may fail; the numbers are told all the same. */
export async function answerOf(
  numbers: object,
  picture: () => Uint8Array | Promise<Uint8Array>,
): Promise<CallToolResult> {
  const told = (all: object) => ({ type: 'text', text: JSON.stringify(all, shorter) }) as const;
  try {
    const data = Buffer.from(await picture()).toString('base64');
    return { content: [told(numbers), { type: 'image', data, mimeType: 'image/png' }] };
  } catch (error) {
    return { content: [told({ ...numbers, no_picture: (error as Error).message })] };
  }
}

/** What to do about a problem, by its slug. */
const REMEDIES: Record<string, string> = {
  'invalid-request':
    'Correct what the pointers name, each a place in the arguments of this tool, and call it again. ' +
    'Resource draped://schemas/NAME (DrapeRequest, StudyRequest, LaminateRequest) has every key.',
  unreachable:
    'Start the daemon (draped --listen 127.0.0.1:8080), or start this server with --url and its address.',
  unauthorized:
    'Start this server with --token-file FILE, or DRAPED_TOKEN, and a token that the daemon knows.',
  forbidden: 'The token lacks the role: this server needs one with the role write.',
  'other-version': 'Use a daemon and a draped-mcp of the same version.',
  'wait-timeout': 'Call wait with its id, as often as needed; --limit is what one call may take.',
  'not-found': 'Ids are those that import_part, drape, study, pieces and laminate answered with.',
  'too-large': 'Send less: fewer faces, a coarser mesh or a larger fabric.spacing.',
  'start-off-surface':
    'Leave start out, or give a point of the chosen faces: list_faces has centres.',
  'unreadable-file':
    'Export the part again, as STEP (AP214 or AP242); other parts are not affected.',
  'queue-full': 'Call again in a minute.',
  'quota-exceeded': 'Call again when earlier jobs have ended.',
  'job-timeout': 'Choose a larger fabric.spacing or fewer faces.',
  'out-of-memory': 'Choose a larger fabric.spacing or fewer faces.',
  file: 'Name a file below the folder of files.',
};

/** `below`: where the daemon's request has what the tool takes as its arguments. */
export function troubleOf(error: unknown, below = ''): CallToolResult {
  const known = error instanceof DrapedError ? error : undefined;
  const trouble = {
    problem: known?.slug ?? 'unknown',
    ...(known?.status && { status: known.status }),
    detail: error instanceof Error ? error.message : String(error),
    errors: known?.errors.map(({ pointer, detail }) => ({
      pointer: pointer.startsWith(`${below}/`) ? pointer.slice(below.length) : pointer,
      detail,
    })),
    remedy: REMEDIES[known?.slug ?? ''] ?? 'What the detail says.',
  };
  return { isError: true, content: [{ type: 'text', text: JSON.stringify(trouble) }] };
}
