#!/bin/sh
# SPDX-License-Identifier: MIT
# The results of the examples and of the tests' requests are, byte for byte, as they have been.
exec python3 tests/results/compare.py "$1"
