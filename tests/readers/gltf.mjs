// SPDX-License-Identifier: MIT
// Asks the Khronos glTF validator about a .glb file; prints its issues and what the file holds.
// Exit status 1 when there is an error or a warning. Usage: node gltf.mjs FILE
import { readFileSync } from 'node:fs';
import validator from 'gltf-validator';

const report = await validator.validateBytes(new Uint8Array(readFileSync(process.argv[2])));
const { issues, info } = report;
console.log(JSON.stringify({ issues, info }, null, 1));
process.exit(issues.numErrors + issues.numWarnings > 0 ? 1 : 0);
