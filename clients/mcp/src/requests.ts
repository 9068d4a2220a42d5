// SPDX-License-Identifier: MIT
// What tools take: the keys that most requests have, in words for who has not read the documents.
// What they do not name passes, and the daemon judges it: draped://schemas/NAME has every key.
import { z } from 'zod';

const point = z.array(z.number()).length(3);
const id = z.string().regex(/^[0-9a-f]{32}$/, 'an id of 32 hexadecimal digits');
const save_as = z.string().describe('Name of a new file below the folder of files');
const loose = (about: string) => z.looseObject({}).describe(about);

const surface = z
  .looseObject({
    id: id.optional().describe('Of import_part'),
    faces: z.array(z.int().min(0)).optional().describe('Only these faces, rising'),
    grow_from: z
      .union([z.int().min(0), z.looseObject({})])
      .optional()
      .describe('Instead of faces: this face and all that are reached over smooth edges'),
    up_to_deg: z.number().optional().describe('How far edges fold that are crossed; 20'),
  })
  .describe('A stored part or some faces of it, {"id", "faces" | "grow_from"}; or a NURBS surface');
const fabric = z
  .looseObject({
    spacing: z
      .union([z.number(), z.array(z.number()).length(2)], {
        error: 'must be a number, the distance of nodes, or two, along warp and along weft',
      })
      .describe('Distance of nodes, in the length unit of the part; about a 40th of its size'),
    thickness: z.number().optional().describe('In the same unit'),
    fiber_volume_fraction: z.number().optional(),
    locking_angle_deg: z.unknown().optional().describe('Shear beyond which it wrinkles, as 45'),
    material: z.unknown().optional().describe('Name of a fabric of draped://materials'),
  })
  .describe('The cloth');
const cloth = {
  fabric,
  start: loose('{"point": [x,y,z]} or {"face": k, "uv": [u,v]}; the middle without it').optional(),
  direction: loose('Of warp: {"angle_deg": a} or {"vector": [x,y,z]}').optional(),
  method: z.string().optional().describe('gib without it; basic, geodesic, mosaic, gib4'),
  generators: loose('Yarns through the start, as {"warp": "least_energy"}').optional(),
  cuts: z
    .array(z.looseObject({ path: z.array(point) }))
    .optional()
    .describe('Darts: [{"path": [[x,y,z]...]}], from an edge of the part to a tip inside'),
};
const drape = { surface, ...cloth };
const ply = {
  splits: z
    .array(z.looseObject({ path: z.array(point) }))
    .optional()
    .describe('Lines that divide the ply, from edge to edge: [{"path": [[x,y,z]...]}]'),
  seam: loose('{"overlap": w} or {"gap": w}; cloth meets cloth without it').optional(),
  pieces: z.array(z.looseObject({})).optional().describe('What differs: [{"at": [x,y,z], ...}]'),
  courses: loose('In place of splits: {"width": w}, strips of the width of the roll').optional(),
};

export const requests = {
  import_part: z.object({
    file: z
      .string()
      .optional()
      .describe('STEP, IGES, STL, OBJ or a mesh below the folder of files'),
    surface: loose('In place of a file: a NURBS surface as geomdl exports it').optional(),
    unit: z.enum(['m', 'mm', 'cm', 'um', 'in', 'ft']).optional().describe('Of a file without one'),
  }),
  list_faces: z.object({
    id,
    first: z.int().min(0).default(0).describe('The first face to list'),
    count: z.int().min(1).max(200).default(50),
    chosen: z.array(z.int().min(0)).optional().describe('Shows these in colour, all others grey'),
  }),
  drape: z.looseObject(drape),
  study: z.looseObject({
    drape: z.looseObject(drape).describe('As of the tool drape'),
    vary: loose(
      '{"start": {"grid": n}, "angle_deg": {"from","to","step"}, "pre_shear_deg": ...}, ' +
        'or {"splits": "proposed"}: where cuts are best, or {"courses": {"first_offset": {"from","to"}, ' +
        '"offsets": {"from","to"}, "width": [..]}} of the member courses',
    ),
    objectives: z
      .array(z.string())
      .describe('max_shear_deg, p95_shear_deg, locked_area, uncovered_area, waste_area, ...'),
    limits: loose('As {"max_shear_deg": {"max": 40}}').optional(),
    courses: loose('With vary.courses: those of a ply, {"width", "along", ..}').optional(),
    search: z.enum(['grid', 'optimise']).optional().describe('grid without it'),
    budget: z.int().optional().describe('The most variants, 20 or more'),
  }),
  pieces: z.looseObject({ surface, ...cloth, ...ply }),
  laminate: z.looseObject({
    surface,
    plies: z
      .array(z.looseObject({ name: z.string().optional(), ...cloth, ...ply }))
      .describe('The first on the tool'),
    cavity: z.unknown().optional().describe('"flexible", {"pressure": Pa} or {"height": h}'),
  }),
  pattern: z.object({
    id: id.describe('Of a drape or laminate'),
    format: z.enum(['svg', 'dxf', 'astm', 'hpgl']).default('svg').describe('Of the file saved'),
    allowance: z.number().min(0).optional().describe('A second line so far outside, of a drape'),
    width: z.number().optional().describe('Of the roll, of a laminate'),
    partial: z.literal(1).optional().describe('Writes a pattern of cloth that leaves some bare'),
    save_as: save_as.optional(),
  }),
  map: z.looseObject({
    id: id.describe('Of a drape or laminate'),
    file: z.string().optional().describe('A mesh below the folder of files'),
    points: z.array(point).optional().describe('In place of a file'),
    mesh: loose('In place of a file: {"vertices", "triangles"}').optional(),
    field: z.string().default('shear_deg').describe('That the picture shows'),
    format: z.string().default('vtu').describe('Of the file saved: vtu, csv, nastran, abaqus, ...'),
    save_as: save_as.optional(),
  }),
  report: z.object({ id: id.describe('Of a drape or laminate'), save_as: save_as.optional() }),
  wait: z.object({ id: id.describe('Of a drape, study or laminate that goes on') }),
};
