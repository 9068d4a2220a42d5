#!/bin/sh
# SPDX-License-Identifier: MIT
# All C is formatted by the project's .clang-format, all JavaScript by prettier.
find solver api library cli import server tests -name node_modules -prune -o \
    \( -name '*.[ch]' -o -name '*.cc' \) -print |
    xargs clang-format-14 --dry-run -Werror &&
    node tests/browser/node_modules/prettier/bin/prettier.cjs --log-level warn --check \
        server/viewer/*.js tests/*/*.mjs \
        $(git ls-files 'clients/*.ts' 'clients/*.js' 'clients/*.mjs')
