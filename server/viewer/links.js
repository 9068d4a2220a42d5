// SPDX-License-Identifier: MIT
// What one can take away: downloads in every format, and the request as a curl command.
import { address, read, token } from './api.js';

const INLINE_MAX = 6000; // characters of a request that still make a command to copy
const DOWNLOADS = [
  ['JSON', 'result?format=json', 'json'],
  ['CSV of nodes', 'result?format=csv&table=nodes', 'nodes.csv'],
  ['CSV of cells', 'result?format=csv&table=cells', 'cells.csv'],
  ['VTP (ParaView)', 'result?format=vtp', 'vtp'],
  ['GLB', 'result?format=glb', 'glb'],
  ['NPZ (NumPy)', 'result?format=npz', 'npz'],
  ['Pattern SVG', 'pattern?format=svg', 'svg'],
  ['Pattern DXF', 'pattern?format=dxf', 'dxf'],
  ['Report to print', 'report', 'report.html'],
  ['Request', 'request', 'request.json'],
];

const percent = (share) => `${Number((100 * share).toPrecision(2))} %`;

/** Offers bytes as a file. */
export function saveAs(blob, name) {
  const link = Object.assign(document.createElement('a'), {
    href: URL.createObjectURL(blob),
    download: name,
  });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60000);
}

/** Links to all formats; with a token they are fetched, because a link cannot carry it. Without an
 *  id their names alone. `title` names the files. Of a drape that leaves `bare`, a share of the part,
 *  the pattern for machines says so, for it is refused unless it is asked for. */
export function showDownloads(list, id, onError, title = id, bare = 0) {
  const items = DOWNLOADS.map(([named, whole, ending]) => {
    const partial = bare > 0 && ending === 'dxf';
    const label = partial ? `${named}, ${percent(bare)} bare` : named;
    const path = partial ? `${whole}&partial=1` : whole;
    const item = document.createElement('li');
    const link = document.createElement('a');
    const name = `${title}.${ending}`;
    link.textContent = label;
    item.append(link);
    if (!id) return item;
    Object.assign(link, { href: address(`v1/drapes/${id}/${path}`), download: name });
    link.addEventListener('click', (event) => {
      if (!token.get()) return;
      event.preventDefault();
      read(`v1/drapes/${id}/${path}`, 'blob').then((blob) => saveAs(blob, name), onError);
    });
    return item;
  });
  list.replaceChildren(...items);
}

/** Of words a name for a file that every system takes. */
export const fileName = (text) =>
  text
    .replaceAll('°', 'deg')
    .replaceAll('×', 'x')
    .replace(/[^\w.+-]+/g, '-')
    .replace(/^-+|-+$/g, '')
    .slice(0, 80);

const quote = (text) => `'${text.replaceAll("'", "'\\''")}'`;

/** The command that does what the button does. */
export function curlCommand(body) {
  const small = body.length <= INLINE_MAX;
  const lines = [
    `curl -sS ${quote(address('v1/drapes'))}`,
    ...(token.get() ? ['  -H "Authorization: Bearer $DRAPED_TOKEN"'] : []),
    "  -H 'Content-Type: application/json' -H 'Prefer: wait=60'",
    `  -o result.json --data-binary ${small ? quote(body) : '@request.json'}`,
  ];
  return lines.join(' \\\n');
}
