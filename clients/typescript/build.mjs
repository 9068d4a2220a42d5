// SPDX-License-Identifier: MIT
// Makes dist/: types of the API from its OpenAPI document, the client, and the element, which is
// the code of the daemon's own page (server/viewer) with three.js in one file.
import { execFileSync } from 'node:child_process';
import { existsSync, mkdirSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { dirname, join } from 'node:path';
import { fileURLToPath, pathToFileURL } from 'node:url';

const here = dirname(fileURLToPath(import.meta.url));
const viewer = join(here, '../../server/viewer');
const document = join(here, '../../api/openapi.yaml');
if (!existsSync(document)) process.exit(0); // an installed package is built already

const { build } = await import('esbuild');
const { default: openapiTS, astToString } = await import('openapi-typescript');

/** The page names its libraries by their addresses; here they are those of npm. */
const pageImports = {
  name: 'page-imports',
  setup({ onResolve, resolve }) {
    const options = { kind: 'import-statement', resolveDir: here };
    onResolve({ filter: /^\.\/three\.module\.min\.js$/ }, () => resolve('three', options));
    onResolve({ filter: /^\.\/(OrbitControls|NURBSUtils)\.js$/ }, ({ path }) => {
      const folder = path.includes('Orbit') ? 'controls' : 'curves';
      return resolve(`three/examples/jsm/${folder}/${path.slice(2)}`, options);
    });
  },
};

const { version } = JSON.parse(readFileSync(join(here, 'package.json')));
rmSync(join(here, 'dist'), { recursive: true, force: true });
mkdirSync(join(here, 'dist'));
writeFileSync(
  join(here, 'src/schema.ts'),
  `/* Made from api/openapi.yaml by build.mjs. */\n${astToString(await openapiTS(pathToFileURL(document)))}`,
);
const common = {
  bundle: true,
  format: 'esm',
  target: 'es2022',
  outdir: join(here, 'dist'),
  define: { __VERSION__: JSON.stringify(version) },
  alias: { '@viewer': viewer },
  plugins: [pageImports],
  logLevel: 'warning',
};
await build({ ...common, entryPoints: [join(here, 'src/index.ts')], packages: 'external' });
await build({ ...common, entryPoints: [join(here, 'src/part.ts')], minify: true });
const tsc = createRequire(import.meta.url).resolve('typescript/bin/tsc');
execFileSync(process.execPath, [tsc, '-p', here], { stdio: 'inherit' });
