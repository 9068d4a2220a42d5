#!/bin/bash
# SPDX-License-Identifier: MIT
# The programs are hardened: loaded anywhere, linked at their start with what the linker fills made
# read-only, no memory both written and executed, stacks with a canary and probed page by page,
# copies checked for their size. Flags are read from what the compiler noted of every file.
# Usage: hardening.sh BUILD
set -u
bad=0

# must PROGRAM WHAT PATTERN TEXT...: a line of the text has the pattern.
must() {
    grep -qE -- "$3" <<<"$4" || { echo "$1: $2"; bad=1; }
}

flags='-fPIE -fstack-protector-strong -fstack-clash-protection'
case $(uname -m) in
x86_64) flags="$flags -fcf-protection" ;;
aarch64) flags="$flags -mbranch-protection=standard" ;;
esac
for program in "$1/draped" "$1/drape" "$1/drape-import"; do
    headers=$(readelf -hldW "$program")
    must "$program" 'is not position independent' 'Type: +DYN' "$headers"
    must "$program" 'has no read-only relocations' 'GNU_RELRO' "$headers"
    must "$program" 'is not linked at its start' 'FLAGS.*BIND_NOW' "$headers"
    must "$program" 'has an executable stack' 'GNU_STACK .* RW +0x' "$headers"
    if grep -E 'LOAD .* RWE|TEXTREL' <<<"$headers"; then
        echo "$program: has memory that is both written and executed"
        bad=1
    fi
    symbols=$(nm -D --undefined-only "$program")
    must "$program" 'has no stack protector' ' __stack_chk_fail' "$symbols"
    must "$program" 'is not fortified' ' __(memcpy|snprintf)_chk' "$symbols"
    producers=$(readelf --debug-dump=info --dwarf-depth=1 "$program" | grep -E 'DW_AT_producer.*GNU C')
    must "$program" 'has no note of its flags' 'GNU C11' "$producers"
    for flag in $flags; do
        if grep -vE -- " $flag( |=|$)" <<<"$producers" | head -n 1 | grep .; then
            echo "$program: has files compiled without $flag"
            bad=1
        fi
    done
done
exit $bad
