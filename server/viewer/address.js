// SPDX-License-Identifier: MIT
// The state of the page in its address, behind the '#', so that a link shows the same view.

const KEYS = [
  'link',
  'drape',
  'compare',
  'pieces',
  'stack',
  'study',
  'over',
  'example',
  'method',
  'spacing',
  'angle',
  'start',
  'field',
  'limits',
  'view',
  'show',
  'cell',
  'eye',
];

/** {drape: id, cell: '3,4', ...} of what the address has. */
export function readAddress() {
  const known = [...new URLSearchParams(location.hash.slice(1))].filter(([key]) =>
    KEYS.includes(key),
  );
  return Object.fromEntries(known);
}

/** The page's address with a link's token before its state. */
export const addressOf = (link) =>
  `${location.href.split('#')[0]}#link=${link}&${location.hash.slice(1)}`;

/** Replaces the address; empty values are left out. Another drape than the one before is a step
 *  that Back undoes. */
export function writeAddress(state) {
  const { drape } = readAddress();
  const given = KEYS.filter((key) => state[key]).map((key) => {
    const value = encodeURIComponent(state[key]).replaceAll('%2C', ',').replaceAll('%20', '');
    return `${key}=${value}`;
  });
  const hash = `#${given.join('&')}`;
  if (hash === location.hash) return;
  if (drape && state.drape && drape !== state.drape) history.pushState(null, '', hash);
  else history.replaceState(null, '', hash);
}
