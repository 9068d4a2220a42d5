#!/bin/sh
# SPDX-License-Identifier: MIT
# All C is formatted by the project's .clang-format.
find solver api server tests -name '*.[ch]' -o -name '*.cc' |
    xargs clang-format-14 --dry-run -Werror
