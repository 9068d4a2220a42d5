// SPDX-License-Identifier: MIT
// Light and dark: as the system has it, until one chooses.
import { element } from './dom.js';

const KEPT = 'draped-theme';

/** Calls `onChange` whenever the colours of the page have changed. */
export function startTheme(onChange) {
  const dark = matchMedia('(prefers-color-scheme: dark)');
  const show = () => {
    const theme = localStorage.getItem(KEPT) || (dark.matches ? 'dark' : 'light');
    document.documentElement.dataset.theme = theme;
    element('theme').textContent = theme === 'dark' ? 'Light' : 'Dark';
    onChange();
  };
  element('theme').addEventListener('click', () => {
    const now = document.documentElement.dataset.theme;
    localStorage.setItem(KEPT, now === 'dark' ? 'light' : 'dark');
    show();
  });
  dark.addEventListener('change', show);
  show();
}
