// SPDX-License-Identifier: MIT
// How llhttp (node.js's parser; the build in undici) reads inputs of standard input, as wire.c does.
import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';

const require = createRequire(import.meta.url);
const REQUEST = 1;
const PAUSED = 21;
const PAUSED_UPGRADE = 22;

let begun = false;
const nothing = () => 0;
const binary = require('undici/lib/llhttp/llhttp-wasm.js');
const module = new WebAssembly.Module(
  Buffer.isBuffer(binary) ? binary : Buffer.from(binary, 'base64'),
);
const { exports: llhttp } = new WebAssembly.Instance(module, {
  env: {
    wasm_on_url: nothing,
    wasm_on_status: nothing,
    wasm_on_message_begin: () => ((begun = true), 0),
    wasm_on_header_field: nothing,
    wasm_on_header_value: nothing,
    wasm_on_headers_complete: nothing,
    wasm_on_body: nothing,
    wasm_on_message_complete: () => PAUSED,
  },
});

function text(pointer) {
  const memory = new Uint8Array(llhttp.memory.buffer);
  return Buffer.from(memory.subarray(pointer, memory.indexOf(0, pointer))).toString('latin1');
}

// A parser for each message: what it remembers of the one before is not of interest.
function readMessage(address, length) {
  const parser = llhttp.llhttp_alloc(REQUEST);
  begun = false;
  const code = llhttp.llhttp_execute(parser, address, length);
  const end = llhttp.llhttp_get_error_pos(parser) - address;
  const reason = code ? text(llhttp.llhttp_get_error_reason(parser)) : '';
  llhttp.llhttp_free(parser);
  return { code, end, reason };
}

function verdict(bytes) {
  const ends = [];
  const address = llhttp.malloc(bytes.length + 1);
  new Uint8Array(llhttp.memory.buffer).set(bytes, address);
  let at = 0;
  let state = 'ok';
  while (at < bytes.length && state === 'ok') {
    const { code, end, reason } = readMessage(address + at, bytes.length - at);
    if (code === PAUSED || code === PAUSED_UPGRADE) ends.push((at += end));
    else if (code) state = reason || `code ${code}`;
    else if (begun) state = 'more';
    else break; // empty lines
  }
  llhttp.free(address);
  return [...ends, state].join(' ');
}

const input = readFileSync(0);
const lines = [];
for (let at = 0; at < input.length; ) {
  const length = input.readUInt32BE(at);
  lines.push(verdict(input.subarray(at + 4, at + 4 + length)));
  at += 4 + length;
}
process.stdout.write(lines.join('\n') + '\n');
