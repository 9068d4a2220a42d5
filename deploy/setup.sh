#!/bin/sh
# SPDX-License-Identifier: MIT
# Installs what is missing to build, run and test draped on Debian 12; does nothing on a machine
# that has it all. Usage: deploy/setup.sh build|test
set -eu

build='gcc g++ libmicrohttpd-dev libjansson-dev libsodium-dev libsqlite3-dev libpq-dev zlib1g-dev
    libzstd-dev python3-yaml curl jq'
# The second line: readers of result formats that others wrote.
tests='bats libcmocka-dev clang-format-14 procps postgresql-15 pgbouncer iproute2 util-linux
    python3-vtk9 python3-numpy python3-ezdxf python3-meshio librsvg2-bin unzip'
command -v npm >/dev/null || tests="$tests nodejs npm"

case "${1:-}" in
build) wanted=$build ;;
test) wanted="$build $tests" ;;
*)
    echo "usage: $0 build|test" >&2
    exit 2
    ;;
esac

missing=
for package in $wanted; do
    status=$(dpkg-query -W -f '${db:Status-Abbrev}' "$package" 2>/dev/null || true)
    case $status in
    ii*) ;;
    *) missing="$missing $package" ;;
    esac
done
[ -n "$missing" ] || exit 0

root=
if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null || {
        echo "$0: not root and no sudo; install:$missing" >&2
        exit 1
    }
    root=sudo
fi
echo "installing:$missing" >&2
log=$(mktemp)
trap 'rm -f "$log"' EXIT
{
    $root apt-get update &&
        $root env DEBIAN_FRONTEND=noninteractive \
            apt-get install --yes --no-install-recommends $missing
} >"$log" 2>&1 || {
    cat "$log" >&2
    echo "$0: could not install:$missing" >&2
    exit 1
}
