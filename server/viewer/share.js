// SPDX-License-Identifier: MIT
// Showing the work to others: a link to what the service has of it, which reads and changes nothing,
// until it is taken back; and one file with all of it, to be opened at another service.
import { addressOf } from './address.js';
import { dropLink, explain, links, makeLink, token } from './api.js';
import { element } from './dom.js';

const describe = ({ of, created, expires }) => {
  const what = of.map((path) => path.split('/').slice(-2).join(' ').slice(0, 16)).join(', ');
  const date = (time) => new Date(time).toLocaleDateString();
  return `${what}, of ${date(created)}${expires ? `, until ${date(expires)}` : ''}`;
};

export class Share {
  /** `idsOf()`: of the jobs that the page shows; `save()` writes the file. */
  constructor({ idsOf, save }) {
    this.idsOf = idsOf;
    element('share').addEventListener('click', () => this.#try(() => this.#make()));
    element('share-list').addEventListener('toggle', ({ target }) => target.open && this.#list());
    element('share-copy').addEventListener('click', () => this.#copy());
    element('save-work').addEventListener('click', () => this.#try(save));
  }

  async #try(act) {
    element('fault-share').textContent = '';
    await act().catch((error) => (element('fault-share').textContent = explain(error)));
  }

  async #make() {
    const ids = this.idsOf();
    if (!ids.length)
      throw new Error('There is nothing to show yet: drape the part first, or its pieces.');
    const made = await makeLink(ids, Number(element('share-days').value) * 86400);
    element('share-address').value = addressOf(made.token);
    element('share-made').hidden = false;
    if (element('share-list').open) await this.#list();
  }

  #copy() {
    const field = element('share-address');
    field.select();
    return navigator.clipboard.writeText(field.value).catch(() => {});
  }

  /** The links there are, each with a button that takes it back. */
  #list() {
    return this.#try(async () => {
      const made = (await links()).links;
      const none = Object.assign(document.createElement('li'), { textContent: 'None.' });
      element('share-links').replaceChildren(...(made.length ? made.map(this.#row) : [none]));
    });
  }

  #row = (link) => {
    const item = document.createElement('li');
    const drop = Object.assign(document.createElement('button'), {
      type: 'button',
      textContent: 'Take back',
    });
    drop.setAttribute('aria-label', `Take back the link to ${describe(link)}`);
    drop.addEventListener('click', () =>
      this.#try(() => dropLink(link.id)).then(() => this.#list()),
    );
    item.append(describe(link), ' ', drop);
    return item;
  };
}

/** The page as it is opened by a link: nothing in it changes anything. */
export function showReadOnly() {
  const on = Boolean(token.link);
  document.documentElement.toggleAttribute('data-linked', on);
  element('request').tabIndex = on ? 0 : -1; // to be scrolled, for nothing in it has the focus
  for (const part of document.querySelectorAll('#request fieldset')) part.disabled = on;
  for (const id of ['drape', 'find', 'ply-add', 'stack-cavity']) element(id).disabled = on;
  for (const id of ['stack-height', 'stack-nominal', 'stack-other']) element(id).disabled = on;
  if (on) element('message').textContent = 'Opened by a link: to look at, not to change.';
}
