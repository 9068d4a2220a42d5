// SPDX-License-Identifier: MIT
// The one folder that tools read parts from and write files to.
import { existsSync, realpathSync, statSync } from 'node:fs';
import { link, mkdtemp, readFile, rm, writeFile } from 'node:fs/promises';
import { basename, dirname, join, relative, resolve, sep } from 'node:path';
import { DrapedError } from 'draped';

const refused = (detail: string) => new DrapedError({ slug: 'file', detail });

export class Folder {
  readonly root: string;

  /** Throws if there is no such folder. */
  constructor(root: string) {
    if (!existsSync(root) || !statSync(root).isDirectory())
      throw new Error(`--folder: ${root} is no folder`);
    this.root = realpathSync(root);
  }

  /** The path of a file, whose own folder has to be there; links do not lead out. */
  #within(name: string): string {
    const path = resolve(this.root, name);
    const parent = dirname(path);
    if (!existsSync(parent)) throw refused(`There is no folder ${parent}.`);
    const real = existsSync(path) ? realpathSync(path) : join(realpathSync(parent), basename(path));
    const way = relative(this.root, real);
    if (way === '' || way === '..' || way.startsWith(`..${sep}`))
      throw refused(`${name} is not below ${this.root}, the folder of files (--folder).`);
    return real;
  }

  async read(name: string): Promise<Uint8Array<ArrayBuffer>> {
    const path = this.#within(name);
    if (!existsSync(path) || !statSync(path).isFile())
      throw refused(`There is no file ${name} below ${this.root}, the folder of files (--folder).`);
    return new Uint8Array(await readFile(path));
  }

  /** Writes a file that is not there yet, whole or not at all; gives its path. */
  async write(name: string, content: string | Uint8Array): Promise<string> {
    const path = this.#within(name);
    const draft = await mkdtemp(join(dirname(path), '.draped-'));
    try {
      await writeFile(join(draft, 'file'), content);
      await link(join(draft, 'file'), path); // unlike a rename it replaces nothing
    } catch (error) {
      if ((error as NodeJS.ErrnoException).code !== 'EEXIST') throw error;
      throw refused(`${name} is there already: save under another name.`);
    } finally {
      await rm(draft, { recursive: true });
    }
    return path;
  }
}
