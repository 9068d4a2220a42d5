#!/usr/bin/env node
// SPDX-License-Identifier: MIT
import { run } from './dist/index.js';
await run(process.argv.slice(2));
