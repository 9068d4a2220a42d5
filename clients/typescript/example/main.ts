// SPDX-License-Identifier: MIT
// A front-end in a hundred lines: a file of CAD is uploaded, faces are clicked, the part is draped.
// The daemon has to allow this page's origin: draped --cors-origin http://localhost:5173
import { Draped, type StoredSurface } from 'draped';
import 'draped/part';

const url = new URLSearchParams(location.search).get('url') ?? 'http://127.0.0.1:8080';
const client = new Draped({ url });
const view = document.querySelector('draped-part')!;
const form = document.querySelector('form')!;
const button = form.querySelector('button')!;
const bar = form.querySelector('progress')!;
const link = form.querySelector('a')!;
const control = <T extends Element>(name: string) => form.elements.namedItem(name) as Element as T;
const state = control<HTMLOutputElement>('state');
const place = control<HTMLOutputElement>('place');
const field = control<HTMLSelectElement>('field');
let part: StoredSurface | null = null;
let shown: 'faces' | 'net' = 'faces';

/** What takes long, with its error in the place of its result. */
async function attempt(work: () => Promise<void>) {
  button.disabled = true;
  try {
    await work();
  } catch (error) {
    state.value = (error as Error).message;
  } finally {
    button.disabled = !part;
    bar.hidden = true;
  }
}

control<HTMLInputElement>('file').addEventListener('change', ({ target }) =>
  attempt(async () => {
    const file = (target as HTMLInputElement).files?.[0];
    if (!file) return;
    state.value = `Reading ${file.name} …`;
    await client.version();
    part = await client.upload(file, { unit: 'mm' });
    view.chosen = [];
    view.setAttribute('src', `${url}/v1/surfaces/${part.id}`);
    const notes = part.notes?.join('\n') ?? '';
    state.value = `${part.faces?.length ?? 1} faces. Click on those to drape; none: all.\n${notes}`;
  }),
);

view.addEventListener('draped-pick', (event) => {
  const face = event.detail?.face;
  if (shown !== 'faces' || face === undefined) return;
  const chosen = new Set(view.chosen);
  if (!chosen.delete(face)) chosen.add(face);
  view.chosen = chosen;
});

form.addEventListener('submit', (event) => {
  event.preventDefault();
  void attempt(async () => {
    if (!part) return;
    const faces = view.chosen.sort((a, b) => a - b);
    const data = new FormData(form);
    bar.hidden = false;
    const { id, summary } = await client.drape(
      {
        surface: faces.length ? { id: part.id, faces } : { id: part.id },
        fabric: {
          spacing: Number(data.get('spacing')),
          locking_angle_deg: Number(data.get('locking')),
        },
        ...(part.triangles !== undefined && { method: 'mosaic' as const }),
      },
      { onStatus: ({ progress }) => (bar.value = progress) },
    );
    view.setAttribute('locking', String(data.get('locking')));
    view.setAttribute('src', `${url}/v1/drapes/${id}`);
    if (!summary) return;
    const covered = (100 * summary.cloth_coverage).toFixed(1);
    state.value =
      `${summary.outcome}: ${summary.cells} cells, ${covered} % covered, ` +
      `greatest shear ${summary.max_shear_deg.toFixed(1)}°\n${summary.verdict.detail}`;
    const drawing = await client.pattern('drapes', id, { format: 'dxf', partial: 1 });
    link.href = URL.createObjectURL(new Blob([drawing], { type: 'image/vnd.dxf' }));
    link.hidden = false;
  });
});

view.addEventListener('draped-load', (event) => {
  const { kind, fields } = event.detail;
  shown = kind;
  field.replaceChildren(...fields.map(({ key, label }) => new Option(label, key)));
  field.disabled = kind === 'faces';
});
field.addEventListener('change', () => view.setAttribute('field', field.value));
view.addEventListener('draped-hover', (event) => {
  const { face, i, j, values } = event.detail ?? {};
  if (face !== undefined) place.value = `face ${face}`;
  else place.value = values ? `cell (${i}, ${j}): ${values['shear_deg']?.toFixed(2)}°` : '';
});
