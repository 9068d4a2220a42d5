#!/bin/sh
# SPDX-License-Identifier: MIT
# The mutants of `make mutants` still apply: each one's text is in its file exactly once, and the
# tests that ought to notice it are there.
exec python3 tests/mutants/mutants.py check
