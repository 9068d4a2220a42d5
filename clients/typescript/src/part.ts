// SPDX-License-Identifier: MIT
// <draped-part src="...">: a draped net coloured by a field, or the faces of a part, to turn, point
// at and click. It draws with the code of the daemon's own page.
import { drawScale } from '@viewer/charts.js';
import { facesOf, type Body } from '@viewer/facets.js';
import { colouringOf, fields, ofNodes, rangeOf, valuesOf, type Field } from '@viewer/fields.js';
import { makeLattice, type Lattice } from '@viewer/lattice.js';
import { Net } from '@viewer/net.js';
import { readNpz } from '@viewer/npz.js';
import { Patches } from '@viewer/patches.js';
import { followPointer } from '@viewer/pointer.js';
import { Stage, type At, type Pane } from '@viewer/scene.js';
import { Draped, type Columns } from './index.js';

/** What `draped-load` says. */
export interface Loaded {
  kind: 'net' | 'faces';
  /** Of a net the fields that it can be coloured by. */
  fields: { key: string; label: string }[];
  /** Of a net its columns. */
  columns?: Columns;
  /** How many cells or faces there are. */
  count: number;
}

/** What the pointer is on: of a net a cell with its numbers, of a part a face. */
export interface Place {
  face?: number;
  cell?: number;
  i?: number;
  j?: number;
  /** Every column of cells there: `shear_deg`, `thickness`, ... */
  values?: Record<string, number>;
}

const SERVED = /^(.*)\/v1\/(drapes|surfaces)\/([0-9a-f]+)/;
const TINTS: { ground: Tint; accent: Tint; line: Tint } = {
  ground: [0.72, 0.76, 0.82],
  accent: [0.12, 0.45, 0.95],
  line: [0.25, 0.28, 0.33],
};
type Tint = [number, number, number];

const TEMPLATE = `
  <style>
    :host { display: block; position: relative; min-height: 120px; font: 12px system-ui, sans-serif; }
    :host([hidden]) { display: none; }
    canvas, #pane { position: absolute; inset: 0; width: 100%; height: 100%; }
    #pane { touch-action: none; outline-offset: -2px; }
    #scale { position: absolute; inset: auto 8px 8px; height: 36px; pointer-events: none; }
    #scale svg { width: 100%; height: 36px; overflow: visible; }
    #scale text { fill: currentColor; font: inherit; }
    #scale .mark { stroke: currentColor; }
    #state { position: absolute; inset: 8px 8px auto; margin: 0; pointer-events: none; }
  </style>
  <canvas></canvas>
  <div id="pane" role="img" tabindex="0"></div>
  <div id="scale" part="legend"></div>
  <p id="state" part="state" role="status"></p>`;

const isZip = (bytes: Uint8Array) => bytes[0] === 0x50 && bytes[1] === 0x4b;
const isGltf = (bytes: Uint8Array) => new TextDecoder().decode(bytes.subarray(0, 4)) === 'glTF';

/** A net or faces, from the service's address of a drape or a surface, else from a file. */
async function fetchPart(source: string, token: string, signal: AbortSignal) {
  const [, base, kind, id] = SERVED.exec(source) ?? [];
  const client = new Draped({ url: base ?? new URL(source).origin, ...(token && { token }) });
  if (id && kind === 'drapes') {
    await client.wait('drapes', id, { signal });
    return makeLattice(await client.columns('drapes', id, { signal }));
  }
  const address = id ? `/v1/surfaces/${id}/preview?format=glb` : '';
  const response = address
    ? await client.call(address, { signal })
    : await fetch(source, { signal });
  if (!response.ok) throw new Error(`${source} answered with status ${response.status}.`);
  const buffer = await response.arrayBuffer();
  const bytes = new Uint8Array(buffer);
  if (isZip(bytes)) return makeLattice(readNpz(buffer));
  if (isGltf(bytes)) return facesOf(buffer);
  throw new Error(`${source} is neither a drape, a surface, a result as npz nor a preview as glb.`);
}

const isNet = (part: Lattice | Body): part is Lattice => 'cellOfNode' in part;

// Where pages are made on a server there are no elements; there the module only must load.
const Base = globalThis.HTMLElement ?? (class {} as typeof HTMLElement);

export class DrapedPart extends Base {
  static observedAttributes = ['src', 'field', 'unit', 'locking', 'no-yarns'];

  #stage: Stage | null = null;
  #pane: Pane | null = null;
  #net: Net | null = null;
  #patches: Patches | null = null;
  #part: Lattice | Body | null = null;
  #loading: AbortController | null = null;
  #token = '';
  #chosen = new Set<number>();

  /** A token of the service, for drapes and surfaces; not an attribute, so that it is in no markup. */
  get token(): string {
    return this.#token;
  }
  set token(token: string) {
    this.#token = token;
    if (this.#stage) this.#load();
  }

  /** Of a part the faces that are marked. */
  get chosen(): number[] {
    return [...this.#chosen];
  }
  set chosen(faces: Iterable<number>) {
    this.#chosen = new Set(faces);
    this.#patches?.choose(this.#chosen);
    this.#stage?.redraw();
  }

  connectedCallback() {
    const root = this.shadowRoot ?? this.attachShadow({ mode: 'open' });
    root.innerHTML = TEMPLATE;
    const pane = this.#element('pane');
    try {
      this.#stage = new Stage(root.querySelector('canvas')!);
    } catch (error) {
      this.#fail(
        new Error('This browser shows no 3D: WebGL 2 is missing or turned off.', { cause: error }),
      );
      return;
    }
    this.#stage.onCoarse = (on) => (this.#net ?? this.#patches)?.coarsen(on);
    this.#pane = this.#stage.addPane(pane);
    followPointer(this.#stage, this.#pane, {
      onHover: (event) => this.#stage && this.#hover(event && this.#at(event)),
      onClick: (event) => this.#pick(this.#at(event)),
    });
    this.#load();
  }

  disconnectedCallback() {
    this.#loading?.abort();
    this.#empty();
    this.#stage?.renderer.dispose();
    this.#stage = this.#pane = null;
  }

  attributeChangedCallback(name: string) {
    if (!this.#stage) return;
    if (name === 'src') this.#load();
    else this.#colour();
  }

  /** Shows all of the part, from where it is seen best. */
  home() {
    this.#pane?.home();
  }

  #element(id: string): HTMLElement {
    return this.shadowRoot!.getElementById(id)!;
  }

  #tell(name: string, detail: unknown) {
    this.dispatchEvent(
      new CustomEvent(`draped-${name}`, { detail, bubbles: true, composed: true }),
    );
  }

  #fail(error: unknown) {
    const { message } = error as Error;
    this.#element('state').textContent = message;
    this.#tell('error', error);
  }

  async #load() {
    this.#loading?.abort();
    this.#empty();
    const source = this.getAttribute('src');
    if (!source) return;
    const { signal } = (this.#loading = new AbortController());
    this.#element('state').textContent = 'Loading …';
    try {
      const part = await fetchPart(new URL(source, document.baseURI).href, this.#token, signal);
      if (signal.aborted) return;
      this.#element('state').textContent = '';
      this.#show(part);
    } catch (error) {
      if (!signal.aborted) this.#fail(error);
    }
  }

  #empty() {
    this.#net?.empty();
    this.#patches?.dispose();
    this.#net = this.#patches = this.#part = null;
    if (!this.#stage) return;
    this.#element('scale').replaceChildren();
    this.#stage.redraw();
  }

  #show(part: Lattice | Body) {
    this.#part = part;
    if (isNet(part)) {
      this.#net = new Net();
      this.#net.fill(part, [1, 1]);
      this.#pane!.scene.add(this.#net.solid);
    } else {
      this.#patches = new Patches(part, TINTS);
      this.#patches.choose(this.#chosen);
      this.#pane!.scene.add(this.#patches.group);
    }
    this.#pane!.frame(part);
    this.#pane!.home();
    this.#colour();
    const given = isNet(part) ? this.#fieldsOf(part) : [];
    const loaded: Loaded = {
      kind: isNet(part) ? 'net' : 'faces',
      fields: given.map(({ key, label }) => ({ key, label })),
      count: isNet(part) ? part.columns['cells.i']!.length : part.count,
      ...(isNet(part) && { columns: part.columns }),
    };
    this.#element('pane').ariaLabel =
      loaded.kind === 'net' ? `Draped net, ${loaded.count} cells` : `Part, ${loaded.count} faces`;
    this.#tell('load', loaded);
  }

  #fieldsOf = ({ columns }: Lattice): Field[] => fields.filter(({ column }) => columns[column]);

  /** The net by the field that is asked for, with the scale of its colours. */
  #colour() {
    const part = this.#part;
    if (!part || !isNet(part)) return;
    const given = this.#fieldsOf(part);
    const field = given.find(({ key }) => key === this.getAttribute('field')) ?? given[0]!;
    const values = valuesOf(part.columns, field)!;
    const locking = Number(this.getAttribute('locking') ?? NaN);
    const colours = colouringOf(field, rangeOf(values), {
      lockings: locking > 0 ? [locking, locking] : null,
      unit: this.getAttribute('unit') ?? '',
    });
    this.#net!.setField(values, ofNodes(field), colours.range, colours.map);
    this.#net!.show({ yarns: !this.hasAttribute('no-yarns'), locked: true });
    drawScale(this.#element('scale'), colours);
    this.#stage!.redraw();
  }

  /* ---- the pointer ---- */

  /** The cell or the face at a place of the window; null beside the part. */
  #at(event: At): Place | null {
    const [stage, pane, part] = [this.#stage, this.#pane, this.#part];
    if (!stage || !pane || !part) return null;
    if (!isNet(part)) {
      const face = this.#patches!.patchAt(stage, pane, event);
      return face < 0 ? null : { face };
    }
    const cell = this.#net!.cellAt(stage, pane, event);
    if (cell < 0) return null;
    const values = Object.fromEntries(
      Object.entries(part.columns)
        .filter(([name]) => name.startsWith('cells.'))
        .map(([name, column]) => [name.slice('cells.'.length), column[cell]!]),
    );
    return { cell, i: values['i']!, j: values['j']!, values };
  }

  #hover(place: Place | null) {
    this.#net?.mark('hovered', place?.cell ?? null);
    this.#patches?.hover(place?.face ?? -1);
    this.#stage?.redraw();
    this.#tell('hover', place);
  }

  #pick(place: Place | null) {
    this.#net?.mark('pinned', place?.cell ?? null);
    this.#stage?.redraw();
    this.#tell('pick', place);
  }
}

declare global {
  interface HTMLElementEventMap {
    'draped-load': CustomEvent<Loaded>;
    'draped-hover': CustomEvent<Place | null>;
    'draped-pick': CustomEvent<Place | null>;
    'draped-error': CustomEvent<Error>;
  }
  interface HTMLElementTagNameMap {
    'draped-part': DrapedPart;
  }
}

if (globalThis.customElements && !customElements.get('draped-part'))
  customElements.define('draped-part', DrapedPart);
