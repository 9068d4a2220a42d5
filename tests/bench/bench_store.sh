#!/bin/bash
# SPDX-License-Identifier: MIT
# What the store costs on this machine, SQLite and PostgreSQL, both of them waiting for the disk.
# Usage: tests/bench/bench_store.sh BUILD
set -eu
cd "$(dirname "$0")/../.."
. tests/postgres.bash
work=$(mktemp -d /tmp/draped-bench-XXXXXX)
trap 'postgres_stop; rm -rf "$work"' EXIT
chmod 755 "$work"
echo "store: SQLite"
"$1/tests/bench/bench_store" "$work/store.db"
echo "store: PostgreSQL $("$PG_BIN/postgres" --version | grep -oE '[0-9.]+' | head -n 1), by a socket"
postgres_make "$work/pg"
postgres_start "$work/pg" ''
"$1/tests/bench/bench_store" "postgresql://draped@/postgres?host=$work/pg"
