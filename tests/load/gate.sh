#!/bin/bash
# SPDX-License-Identifier: MIT
# The gate on SQLite, and with the roles api and worker over PostgreSQL; see gate.py. With STRICT it
# fails when a bound is missed.
# Usage: tests/load/gate.sh BUILD
set -eu
cd "$(dirname "$0")/../.."
. tests/postgres.bash
export BUILD=$1
ulimit -n "$(ulimit -Hn)"
work=$(mktemp -d)
chmod 711 "$work"
trap 'postgres_stop; rm -rf "$work"' EXIT
failed=0
echo '# SQLite'
python3 tests/load/gate.py || failed=1
postgres_make "$work/pg"
postgres_start "$work/pg" ''
echo '# PostgreSQL, roles api and worker'
python3 tests/load/gate.py --role api --store "postgresql://draped@/postgres?host=$work/pg" || failed=1
exit $failed
