#!/bin/sh
# SPDX-License-Identifier: MIT
# The mutants of `make mutants` still apply: each one's text is in its file exactly once, the tests that
# ought to notice it are there, and the mistakes that nothing can notice are of lines that are there.
python3 tests/mutants/mutants.py check && exec python3 tests/mutants/generate.py --check
