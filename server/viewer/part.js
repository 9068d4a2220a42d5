// SPDX-License-Identifier: MIT
// A part of several faces, or a file of CAD or mesh: stored with the service, which says what its
// faces are and where they join, and shows it as triangles.
import { Problem, preview, storeSurface } from './api.js';
import { format } from './fields.js';
import { readFaces, readShape } from './work.js';

const FORMATS = {
  step: ['step', 'stp', 'p21'],
  iges: ['iges', 'igs'],
  stl: ['stl'],
  obj: ['obj'],
  nastran: ['bdf', 'nas', 'dat'],
  abaqus: ['inp'],
  lsdyna: ['k', 'key'],
  gmsh: ['msh'],
  unv: ['unv'],
  vtu: ['vtu'],
};
const UNSUPPORTED = 415;

/** The service's name of the format that a file's name ends in; undefined for others. */
export function formatOf(name) {
  const ending = name.toLowerCase().split('.').pop();
  return Object.keys(FORMATS).find((format) => FORMATS[format].includes(ending));
}

/** The faces reached from one across joints that fold by no more than an angle. */
export function grow(joints, from, upToDeg) {
  const reached = new Set([from]);
  for (let before = 0; before < reached.size; ) {
    before = reached.size;
    for (const [a, b, fold] of joints)
      if (fold <= upToDeg && reached.has(a) !== reached.has(b)) reached.add(a).add(b);
  }
  return reached;
}

/** What there is to say of a mesh's free edges: the border of an open one, and holes. */
function openingsOf({ openings = [], opening_count: count = 0, length_unit: unit }) {
  if (!count) return [];
  const edges = openings.reduce((sum, { edges: own }) => sum + own, 0);
  const lengths = openings.map(({ length }) => `${format(length, 3)} ${unit}`);
  const several = count === 1 ? 'one loop' : `${count} loops`;
  const rest = count > openings.length ? ', …' : '';
  return [
    `open edges: ${edges} in ${several}, ${lengths.join(', ')}${rest} long: borders, or holes`,
  ];
}

async function describe(answer) {
  const body = await readFaces(await preview(answer.id));
  const { faces = [], edges, components, joints = [] } = answer;
  const notes = [...(answer.notes ?? []), ...openingsOf(answer)];
  const solid = faces.length > 1 && edges.free === 0;
  return {
    id: answer.id,
    unit: answer.length_unit,
    mesh: answer.triangles !== undefined,
    unitAssumed: notes.some((note) => note.includes('states no unit')),
    faces,
    joints,
    notes,
    body,
    solid,
    /** Nothing of a solid, which has both skins, or of several parts: somebody has to choose. */
    first: solid || components > 1 || edges?.faulty ? [] : faces.map(({ index }) => index),
  };
}

/** Whether all faces of a closed body are among those chosen. */
export function holdsBody({ solid, joints }, chosen) {
  const left = new Set(solid ? chosen : []);
  while (left.size) {
    const [first] = left;
    const body = grow(joints, first, Infinity);
    if ([...body].every((face) => chosen.has(face))) return true;
    for (const face of body) left.delete(face);
  }
  return false;
}

/** A file's content as a part; `unit` for a file that says none. Throws what is wrong with it. */
export async function storePart(file, format, unit) {
  const query = `?format=${format}${unit ? `&unit=${unit}` : ''}`;
  try {
    return await describe(await storeSurface(file, 'application/octet-stream', query));
  } catch (error) {
    if (error instanceof Problem && error.status === UNSUPPORTED)
      throw new Error(`${file.name}: ${error.message}`);
    throw error;
  }
}

/** The same of a definition as JSON text. */
export const storeDefinition = async (text) =>
  describe(await storeSurface(text, 'application/json'));

/** A stored part as its preview shows it, by a link that says no more of it. */
export async function lookAtPart(id) {
  const body = await readFaces(await preview(id));
  const faces = Array.from({ length: body.count }, (_, index) => ({ index }));
  return { id, faces, joints: [], notes: [], body, mesh: false };
}

/** The faces that the surface of a request chooses. */
export function chosenOf(part, { faces, grow_from: from, up_to_deg: upTo = 20 }) {
  if (faces) return new Set(faces);
  if (typeof from === 'number') return grow(part.joints, from, upTo);
  return new Set(part.faces.map(({ index }) => index));
}

/** Some faces as a shape to drape on. */
export async function shapeOf(part, chosen) {
  const faces = `${chosen.size} of ${part.faces.length} faces`;
  const triangles = `${(part.body.patch.length / 3).toLocaleString('en')} triangles`;
  const whole = `mesh, ${triangles}`;
  const about = !part.mesh ? faces : part.faces.length > 1 ? `${faces} of a ${whole}` : whole;
  const shape = await readShape(part.body, chosen, about);
  return part.mesh ? { ...shape, kind: 'mesh' } : shape;
}

/** What a drape request has for its surface. */
export function surfaceOf(part, chosen) {
  const all = chosen.size === part.faces.length;
  const faces = [...chosen].sort((a, b) => a - b);
  return JSON.stringify(all ? { id: part.id } : { id: part.id, faces });
}
