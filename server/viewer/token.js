// SPDX-License-Identifier: MIT
// Asks for the access token when the service wants one, or when the user does.
import { token } from './api.js';
import { element } from './dom.js';

/** `refused`: because it did not take the one that it got. */
export function askToken(refused = false) {
  element('token').value = token.get();
  element('fault-token').textContent = refused ? 'The service does not accept this token.' : '';
  if (!element('token-dialog').open) element('token-dialog').showModal();
}

/** Calls `onToken` when there is a new one. */
export function startToken(onToken) {
  element('token-open').addEventListener('click', () => askToken());
  element('token-dialog').addEventListener('close', () => {
    if (element('token-dialog').returnValue !== 'ok') return;
    token.set(element('token').value.trim());
    onToken();
  });
}
