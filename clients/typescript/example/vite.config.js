// SPDX-License-Identifier: MIT
// three.js makes one chunk of 600 kB, as large as it has to be.
export default { build: { chunkSizeWarningLimit: 700 } };
