// SPDX-License-Identifier: MIT
// The command `draped-mcp`: its settings, and the Model Context Protocol on stdio.
import { readFileSync } from 'node:fs';
import { parseArgs } from 'node:util';
import { StdioServerTransport } from '@modelcontextprotocol/sdk/server/stdio.js';
import { Draped, VERSION } from 'draped';
import { Folder } from './folder.js';
import { serverOf } from './server.js';

const HELP = `usage: draped-mcp.js [--url URL] [--token-file FILE] [--folder DIR] [--limit SECONDS]

Speaks the Model Context Protocol on stdin and stdout, and calls a draped daemon.

  --url URL           where the daemon is; DRAPED_URL, http://127.0.0.1:8080
  --token-file FILE   the token that the daemon asks for; else what DRAPED_TOKEN is
  --folder DIR        parts are read and files written below it only; DRAPED_FOLDER, .
  --limit SECONDS     that one tool call may take, 1 to 3600; DRAPED_LIMIT, 50: clients give up after 60
  --help, --version
`;

/** What the command line or the environment says; throws what is wrong with it. */
function settingsOf(words: string[]) {
  const text = { type: 'string' } as const;
  const flag = { type: 'boolean' } as const;
  const options = {
    ...{ url: text, 'token-file': text, folder: text, limit: text },
    ...{ help: flag, version: flag },
  };
  const { values } = parseArgs({ args: words, options });
  const { DRAPED_URL, DRAPED_TOKEN, DRAPED_FOLDER, DRAPED_LIMIT } = process.env;
  const url = values.url ?? DRAPED_URL ?? 'http://127.0.0.1:8080';
  if (!/^https?:$/.test(URL.canParse(url) ? new URL(url).protocol : ''))
    throw new Error(`--url: ${url} is no address; one is http://127.0.0.1:8080`);
  const limit = Number(values.limit ?? DRAPED_LIMIT ?? 50);
  if (!(limit >= 1 && limit <= 3600)) throw new Error('--limit: must be 1 to 3600 seconds');
  const file = values['token-file'];
  const token = file === undefined ? DRAPED_TOKEN : readFileSync(file, 'utf8').trim();
  const folder = new Folder(values.folder ?? DRAPED_FOLDER ?? '.');
  return { ...values, url, token, folder, limit };
}

/** Serves until stdin ends. */
export async function run(words: string[]): Promise<void> {
  try {
    const { help, version, url, token, folder, limit } = settingsOf(words);
    if (help || version) {
      process.stdout.write(help ? HELP : `draped-mcp ${VERSION}\n`);
      return;
    }
    const client = new Draped({ url, timeout: 1000 * (limit + 1), ...(token && { token }) });
    await serverOf({ client, folder, limit: 1000 * limit }).connect(new StdioServerTransport());
    process.stdin.once('end', () => process.exit(0));
  } catch (error) {
    process.stderr.write(`draped-mcp: ${(error as Error).message}\n`);
    process.exitCode = 2;
  }
}
