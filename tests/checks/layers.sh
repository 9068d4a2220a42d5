#!/bin/bash
# SPDX-License-Identifier: MIT
# The layers: server -> api -> solver and never back; a library's header in one file alone.
set -u
bad=0

# forbid FOLDER PATTERN WHY: no include line in FOLDER may match.
forbid() {
    local found
    found=$(grep -rnE "^ *# *include +[<\"]($2)" "$1" --include='*.[ch]' --include='*.cc')
    [ -z "$found" ] || { echo "$3:"; echo "$found"; bad=1; }
}

# only HEADER FILES: the files, a pattern, that alone may include it.
only() {
    local found
    found=$(grep -rlE "^ *# *include +<$1>" solver api server | grep -vxE "$2")
    [ -z "$found" ] || { echo "$1 belongs in $2 alone, but is included in:" $found; bad=1; }
}

forbid solver '\.\./|.*/' 'the solver stands alone'
forbid solver 'stdio|time|locale|pthread|errno|unistd|signal|threads' 'the solver does no I/O'
forbid api '\.\./server|microhttpd|sqlite3|libpq' 'the api does not know the server'
only microhttpd.h 'server/http\.c'
only sqlite3.h 'server/db\.c'
only libpq-fe.h 'server/pg\.c'
only jansson.h 'api/tree(_parse)?\.c|server/documents\.c'
only zlib.h 'api/(encode_npz|lcmsim)\.c|server/pack\.c'
only zstd.h 'server/pack\.c'
only sodium.h 'api/digest\.c|server/(id|store_sqlite_jobs)\.c'
exit $bad
