// SPDX-License-Identifier: MIT
// The few words that every part of the page uses.

export const element = (id) => document.getElementById(id);

/** The line under the button that says what is going on. */
export const say = (text) => (element('state').textContent = text);
