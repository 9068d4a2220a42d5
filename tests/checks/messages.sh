#!/bin/sh
# SPDX-License-Identifier: MIT
# All sentences that the programs and the page say are those of messages.txt, none with a private word.
exec python3 tests/checks/messages.py
