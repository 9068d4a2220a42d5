#!/bin/sh
# SPDX-License-Identifier: MIT
# Installs what is missing to build, run and test draped on Debian 12; does nothing on a machine
# that has it all. Usage: deploy/setup.sh compile|import|page|package|image|fuzz|test|filling|freecad
set -eu

# In three steps, so that what needs the first alone is compiled while the others are fetched.
compile='gcc g++ libmicrohttpd-dev libjansson-dev libsodium-dev libsqlite3-dev libpq-dev zlib1g-dev
    libexpat1-dev libxxhash-dev libzstd-dev libseccomp-dev libhdf5-dev libgeos-dev python3-yaml curl jq'
import='libocct-data-exchange-dev'
page=
command -v npm >/dev/null || page='nodejs npm'
build="$compile $import $page"
package='build-essential debhelper' # for make deb
# The last lines: readers of result formats that others wrote, a solver that runs decks, the browser.
tests='bats libcmocka-dev clang-format-14 procps wrk gcovr valgrind
    man-db systemd lintian sqlite3 openssl zstd postgresql-15 postgresql-client-15 pgbouncer
    iproute2 util-linux mount e2fsprogs
    python3-pip python3-setuptools python3-venv python3-wheel
    python3-vtk9 python3-numpy pkg-config python3-ezdxf python3-meshio librsvg2-bin unzip
    calculix-ccx python3-h5py chromium'

case "${1:-}" in
compile) wanted=$compile ;;
import) wanted=$import ;;
page) wanted=$page ;;
package) wanted="$build $package" ;;
image) wanted="$build $package buildah mmdebstrap curl jq procps" ;;
fuzz) wanted="$build clang-14 libclang-rt-14-dev llvm-14 python3-h11" ;;
test) wanted="$build $package $tests" ;;
filling) wanted="$build python3-dolfinx-real python3-matplotlib" ;; # 800 MB of finite elements
freecad) wanted="$build python3-numpy freecad freecad-python3 xvfb xauth libgl1-mesa-dri" ;; # 800 MB, too
*)
    echo "usage: $0 compile|import|page|package|image|fuzz|test|filling|freecad" >&2
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

# Programs that deploy/ is tested with, whose packages would start a service on this machine: only
# the program is taken from each, into build/tools.
programs='nginx:usr/sbin/nginx caddy:usr/bin/caddy prometheus:usr/bin/promtool'
tools=$(dirname "$0")/../build/tools

fetch_tools() {
    mkdir -p "$tools"
    for entry in $programs; do
        program=${entry#*:}
        [ ! -x "$tools/${program##*/}" ] || continue
        (cd "$tools" && { apt-get download "${entry%%:*}" ||
            { $root apt-get update && apt-get download "${entry%%:*}"; }; }) >"$log" 2>&1 || {
            cat "$log" >&2
            echo "$0: could not fetch ${entry%%:*}" >&2
            exit 1
        }
        dpkg-deb --fsys-tarfile "$tools/${entry%%:*}"_*.deb |
            tar -xO "./$program" >"$tools/new"
        chmod +x "$tools/new"
        mv "$tools/new" "$tools/${program##*/}"
        rm "$tools/${entry%%:*}"_*.deb
    done
}

root=
[ "$(id -u)" -eq 0 ] || root=sudo
log=$(mktemp)
trap 'rm -f "$log"' EXIT
if [ -z "$missing" ]; then
    [ "$1" != test ] || fetch_tools
    exit
fi

if [ -n "$root" ] && ! command -v sudo >/dev/null; then
    echo "$0: not root and no sudo; install:$missing" >&2
    exit 1
fi
echo "installing:$missing" >&2
install() {
    $root env DEBIAN_FRONTEND=noninteractive \
        apt-get install --yes --no-install-recommends $missing
}
# The lists are read anew when they are missing or name packages that are gone.
{ install || { $root apt-get update && install; }; } >"$log" 2>&1 || {
    cat "$log" >&2
    echo "$0: could not install:$missing" >&2
    exit 1
}
[ "$1" != test ] || fetch_tools
