// SPDX-License-Identifier: MIT
// The materials that the service has, as a list. What the chosen one says stands in the empty
// fields of the form: it holds where the form says nothing itself.
import { read, token } from './api.js';
import { element } from './dom.js';

const METRES = { m: 1, cm: 0.01, mm: 1e-3, um: 1e-6, in: 0.0254, ft: 0.3048 };

const path = (name) => `v1/materials/${encodeURIComponent(name)}`;

const round = (value) => (value === undefined ? '' : String(Number(value.toPrecision(6))));

/** All of them, page by page. */
async function fetchHeads() {
  const heads = [];
  for (let query = ''; query !== null; ) {
    const page = await read(`v1/materials${query}`);
    heads.push(...page.materials);
    query = page.next ? `?cursor=${page.next}` : null;
  }
  return heads;
}

export class Materials {
  constructor() {
    this.list = element('material');
    this.figures = {};
    this.list.addEventListener('change', () => this.show());
    element('unit').addEventListener('change', () => this.#describe());
    this.list.addEventListener('focus', () => this.#fill().catch(() => {}));
    this.#fill().catch(() => {}); // a service that wants a token first: at the next focus
  }

  async #fill() {
    if (token.link) return;
    const heads = await fetchHeads();
    const there = new Set([...this.list.options].map((option) => option.value));
    for (const { name, about, own, example } of heads) {
      if (there.has(name)) continue;
      const option = new Option(name + (own ? ' (own)' : example ? ' (example)' : ''), name);
      option.title = about;
      this.list.add(option);
    }
  }

  get name() {
    return this.list.value;
  }

  /** Chooses that of a document: a name; whole ones stay in it. */
  set name(value) {
    const name = typeof value === 'string' ? value : '';
    if (name && ![...this.list.options].some((option) => option.value === name))
      this.list.add(new Option(name));
    this.list.value = name;
    this.show();
  }

  /** Fetches what the chosen one says, and shows it. */
  async show() {
    const { name } = this;
    this.figures = {};
    if (name && !token.link) this.figures = await read(path(name)).catch(() => ({}));
    if (name === this.name) this.#describe();
  }

  #describe() {
    const { fabric = {}, permeability } = this.figures;
    const metres = METRES[element('unit').value] ?? 1;
    element('thickness').placeholder = round(fabric.thickness && fabric.thickness / metres);
    element('fraction').placeholder = round(fabric.fiber_volume_fraction);
    const { positive, negative } = fabric.locking_angle_deg ?? {};
    element('locking').placeholder = positive
      ? `${positive}, ${negative}`
      : round(fabric.locking_angle_deg);
    element('permeability').options[0].text = permeability ? "the material's" : 'none';
  }
}
