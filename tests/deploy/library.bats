# SPDX-License-Identifier: MIT
# libdrape as it is installed: what it gives away, programs that are built with drape.h and
# pkg-config alone, one that is not built at all, and the bits of the command.
load helper

setup_file() {
    make -s install-library B="${BUILD:-build}" DESTDIR="$BATS_FILE_TMPDIR" PREFIX=/usr >/dev/null
    LIBRARY=$BATS_FILE_TMPDIR/usr
    export LIBRARY LD_LIBRARY_PATH=$LIBRARY/lib PKG_CONFIG_SYSROOT_DIR=$BATS_FILE_TMPDIR \
        PKG_CONFIG_LIBDIR=$LIBRARY/lib/pkgconfig
}

# use FLAGS...: compiles the example in C, away from the source.
use() {
    cd "$BATS_TEST_TMPDIR"
    # shellcheck disable=SC2046
    gcc -std=c11 -Wall -Wextra -Werror "$@" "$LIBRARY"/share/doc/libdrape-dev/examples/cloth.c \
        -o cloth $(pkg-config --cflags --libs drape) -lm
}

@test "library: it gives away the symbols that were released, under their versions, and no other" {
    nm -D --defined-only --with-symbol-versions "$LIBRARY/lib/libdrape.so.1" |
        sed -E 's/.* (\S+)$/\1/; s/@@/@/; s/^(DRAPE_.*)$/\1@\1/' | sort >"$BATS_TEST_TMPDIR/given"
    grep -oE '^ \S+' deploy/debian/libdrape1.symbols | tr -d ' ' | sort |
        diff - "$BATS_TEST_TMPDIR/given"
    # And the header declares all of them.
    for name in $(grep -oE '^drape_[a-z_]+' "$BATS_TEST_TMPDIR/given"); do
        grep -qE "\b$name\(" "$LIBRARY/include/drape.h" || { echo "drape.h lacks $name"; false; }
    done
    readelf -d "$LIBRARY/lib/libdrape.so" | grep -qF 'Library soname: [libdrape.so.1]'
}

@test "library: it brings no libraries along but for these" {
    readelf -d "$LIBRARY/lib/libdrape.so" | sed -nE 's/.*NEEDED.*\[(.*)\]/\1/p' | sort >"$BATS_TEST_TMPDIR/needed"
    run grep -vE '^(libc|libm|libstdc\+\+|libgcc_s|libexpat|libjansson|libsodium|libz|ld-linux.*)\.so\.' \
        "$BATS_TEST_TMPDIR/needed"
    echo "$output"
    [ "$status" = 1 ]
}

@test "library: drape.h stands alone, in C and in C++" {
    for compiler in 'gcc -std=c99 -x c' 'g++ -std=c++11 -x c++'; do
        echo '#include <drape.h>
        int main(void) { return drape_version()[0] == 0; }' |
            $compiler -Wall -Wextra -Wpedantic -Werror -I"$LIBRARY/include" - -o "$BATS_TEST_TMPDIR/a" \
                -L"$LIBRARY/lib" -ldrape
        "$BATS_TEST_TMPDIR/a"
    done
}

@test "library: the example in C drapes, and writes the pattern that the command writes" {
    cut=$BATS_TEST_TMPDIR/command.svg examples=$PWD/$EXAMPLES
    "$DRAPE" $EXAMPLES/hemisphere.json --format svg --allowance 0.01 -o "$cut"
    [ "$(wc -l <library/examples/cloth.c)" -le 60 ]
    use
    run ./cloth "$examples/hemisphere.json" pattern.svg
    echo "$output"
    [ "$status" = 0 ]
    [[ $output =~ ^[0-9]+\ cells,\ sheared\ by\ up\ to\ [0-9]+\.[0-9]+\ degrees$ ]]
    cmp pattern.svg "$cut"
    # What is wrong is told with its place, and nothing is written.
    sed 's/"spacing"/"spacings"/' "$examples/hemisphere.json" >wrong.json
    run ./cloth wrong.json wrong.svg
    [ "$status" = 1 ]
    [[ $output == *'"pointer":"/fabric/spacings"'* ]]
    [ ! -e wrong.svg ]
}

@test "library: the example by ctypes maps, with the bytes of the command" {
    "$DRAPE" $EXAMPLES/hemisphere.json --map $EXAMPLES/mould.bdf --format vtu -o "$BATS_TEST_TMPDIR/command.vtu" 2>/dev/null
    run python3 "$LIBRARY/share/doc/libdrape-dev/examples/cloth.py" $EXAMPLES/hemisphere.json \
        $EXAMPLES/mould.bdf "$BATS_TEST_TMPDIR/fields.vtu"
    echo "$output"
    [ "$status" = 0 ]
    cmp "$BATS_TEST_TMPDIR/fields.vtu" "$BATS_TEST_TMPDIR/command.vtu"
    echo '{"surface": {}}' >"$BATS_TEST_TMPDIR/wrong.json"
    run python3 library/examples/cloth.py "$BATS_TEST_TMPDIR/wrong.json" $EXAMPLES/mould.bdf \
        "$BATS_TEST_TMPDIR/wrong.vtu"
    [ "$status" = 1 ]
    [ ! -e "$BATS_TEST_TMPDIR/wrong.vtu" ]
}
