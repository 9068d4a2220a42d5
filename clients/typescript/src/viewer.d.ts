// SPDX-License-Identifier: MIT
// What the client and the element use of the daemon's page, which is JavaScript.
declare module '@viewer/npz.js' {
  export function readNpz(buffer: ArrayBuffer): Record<string, Float64Array>;
}
declare module '@viewer/glb.js' {
  export function readGlb(
    buffer: ArrayBuffer,
  ): { face: number; position: Float32Array; index: Uint32Array | Uint16Array }[];
}
declare module '@viewer/vtu.js' {
  export function readVtu(buffer: ArrayBuffer): {
    columns: Record<string, ArrayLike<number>>;
    points: Float64Array;
    connectivity: Float64Array;
    offsets: Float64Array;
  };
}
declare module '@viewer/lattice.js' {
  export interface Lattice {
    columns: Record<string, Float64Array>;
    position: Float32Array;
    normal: Float32Array;
    radius: number;
    origin: [number, number, number];
    cellOfNode: Int32Array;
    grid: object;
  }
  export function makeLattice(columns: Record<string, Float64Array>): Lattice;
}
declare module '@viewer/facets.js' {
  export interface Body {
    position: Float32Array;
    normal: Float32Array;
    radius: number;
    count: number;
  }
  export function facesOf(buffer: ArrayBuffer): Body;
}
declare module '@viewer/net.js' {
  import type { Lattice } from '@viewer/lattice.js';
  import type { At, Pane, Stage } from '@viewer/scene.js';
  export class Net {
    solid: object;
    fill(lattice: Lattice, spacing: [number, number]): void;
    setField(values: Float32Array, ofNodes: boolean, range: [number, number], map: string): void;
    show(shown: { yarns: boolean; locked: boolean }): void;
    mark(which: 'hovered' | 'pinned', cell: number | null): void;
    cellAt(stage: Stage, pane: Pane, at: At): number;
    coarsen(on: boolean): void;
    empty(): void;
  }
}
declare module '@viewer/patches.js' {
  import type { Body } from '@viewer/facets.js';
  import type { At, Pane, Stage } from '@viewer/scene.js';
  type Colour = [number, number, number];
  export class Patches {
    group: object;
    constructor(body: Body, tints: { ground: Colour; accent: Colour; line: Colour });
    choose(chosen: Set<number>): void;
    hover(patch: number): boolean;
    patchAt(stage: Stage, pane: Pane, at: At): number;
    coarsen(on: boolean): void;
    dispose(): void;
  }
}
declare module '@viewer/pointer.js' {
  import type { At, Pane, Stage } from '@viewer/scene.js';
  export function followPointer(
    stage: Stage,
    pane: Pane,
    handlers: { onHover(event: At | null): void; onClick(event: At): void },
  ): void;
}
declare module '@viewer/scene.js' {
  /** A place of the window. */
  export interface At {
    clientX: number;
    clientY: number;
  }
  export interface Pane {
    scene: { add(object: object): void };
    frame(body: { radius: number; position: Float32Array; normal: Float32Array }): void;
    home(): void;
  }
  export class Stage {
    renderer: { dispose(): void };
    onCoarse: (on: boolean) => void;
    constructor(canvas: HTMLCanvasElement);
    addPane(element: HTMLElement): Pane;
    redraw(): void;
  }
}
declare module '@viewer/fields.js' {
  export interface Field {
    key: string;
    label: string;
    column: string;
    signed?: boolean;
    unit(length: string): string;
  }
  export const fields: Field[];
  export function ofNodes(field: Field): boolean;
  export function valuesOf(
    columns: Record<string, Float64Array>,
    field: Field,
  ): Float32Array | null;
  export function rangeOf(values: Float32Array): [number, number];
  export interface Colouring {
    range: [number, number];
    map: string;
    unit: string;
    label: string;
    marks: number[];
  }
  export function colouringOf(
    field: Field,
    range: [number, number],
    how: { limits?: number[]; lockings: [number, number] | null; unit: string },
  ): Colouring;
}
declare module '@viewer/charts.js' {
  import type { Colouring } from '@viewer/fields.js';
  export function drawScale(parent: Element, scale: Colouring): void;
}
