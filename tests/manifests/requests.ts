// SPDX-License-Identifier: MIT
// Requests with the keys alone that have to be there, and one without: compiled with the types that
// openapi-typescript makes of the daemon's description.
import type { components } from './draped';

type Schemas = components['schemas'];
const surface = { id: 'x' };
const fabric = { spacing: 0.1 };

export const drape: Schemas['DrapeRequest'] = { surface, fabric };
export const chosen: Schemas['DrapeRequest'] = { surface: { id: 'x', grow_from: 3 }, fabric };
export const ply: Schemas['LaminateRequest'] = { surface, plies: [{ fabric }] };
export const study: Schemas['StudyRequest'] = { drape };
export const material: Schemas['Material'] = { name: 'twill', fabric: {} };
// @ts-expect-error: fabric is missing
export const bare: Schemas['DrapeRequest'] = { surface };
