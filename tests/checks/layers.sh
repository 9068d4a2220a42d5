#!/bin/bash
# SPDX-License-Identifier: MIT
# The layers, by folder: what each may include, and which one file a library's header belongs to.
# Includes are written from the top of the tree, within a folder by the bare name.
set -u
bad=0

# The tops of the libraries and programs: what lies in their folders may not include these, and
# they may include all of their own tree. What else lies directly in solver/, api/ or server/ is
# the ground that their folders stand on.
tops='solver/(drape|courses).c|api/(run|problem|check).c|server/(main|config|flags|healthcheck|backup|status).c'

# FOLDER, and those whose headers its files may include besides its own.
rules='
solver                 -
solver/surface         solver
solver/shell           solver|solver/surface
solver/path            solver|solver/surface|solver/shell
solver/course          solver|solver/surface|solver/shell|solver/path
solver/mesh            solver|solver/surface|solver/shell
solver/net             solver|solver/surface|solver/shell
solver/fishnet         solver|solver/surface|solver/shell|solver/path|solver/net
solver/march           solver|solver/surface|solver/shell|solver/path|solver/mesh|solver/net|solver/fishnet
solver/rim             solver|solver/surface|solver/shell|solver/path|solver/net|solver/fishnet|solver/march
solver/steer           solver|solver/surface|solver/shell|solver/path|solver/net|solver/fishnet|solver/march
solver/report          solver|solver/surface|solver/net|solver/fishnet|solver/march|solver/rim
api                    solver
api/json               api|solver
api/request            api|api/json|solver|solver/surface|solver/shell|solver/mesh
api/result             api|api/json|api/request|solver
api/format             api|api/json|api/request|api/result|solver
api/files              api|api/json|api/request|api/map|solver
api/map                api|api/json|api/request|api/result|api/format|solver|solver/surface|solver/mesh
api/laminate           api|api/json|api/request|api/result|api/format|api/map|solver|solver/surface|solver/mesh|solver/net|solver/shell
api/study              api|api/json|api/laminate|api/map|api/request|api/result|solver|solver/surface|solver/mesh
cli                    api|api/[a-z]*
library                api|api/[a-z]*
import                 api|api/[a-z]*|cli|solver/surface|server/work
server                 api|api/json
server/store           api|server
server/store/sqlite   server|server/store
server/store/postgres server|server/store
server/http            api|server
server/work            api|api/[a-z]*|server|server/store
server/resources       api|api/[a-z]*|server|server/store|server/work|server/http
'

# Of the headers of drape.h and run.h the folders that they are the top of take none.
forbidden='^(solver/[a-z]+/.* solver/drape.h|api/(json|request|result|format|map)/.* api/run.h|solver/.* (stdio|time|locale|pthread|errno|unistd|signal|threads).h)$'

# Every include line of our own, as "FILE HEADER".
includes() {
    find solver api library cli import server -name node_modules -prune -o \
        \( -name '*.[ch]' -o -name '*.cc' \) -print |
        xargs grep -oE '^ *# *include +[<"][^>"]+' | sed -E 's/: *# *include +[<"]/ /'
}

while read -r file header; do
    if [[ "$file $header" =~ $forbidden ]]; then
        echo "$file may not include $header"
        bad=1
    fi
    [[ $header == */* && -e $header && ! $file =~ ^($tops)$ ]] || continue
    may=$(awk -v folder="${file%/*}" '$1 == folder {print $2}' <<<"$rules")
    [[ ${header%/*} =~ ^($may)$ ]] && continue
    [ "$header" = solver/version.h ] && continue # is everybody's
    # drape.h and its like gather the folders below them.
    [[ $file =~ ^(solver/drape|api/run|api/check)\.h$ ]] && continue
    echo "$file may not include $header: ${file%/*} may include ${may//|/, }"
    bad=1
done < <(includes)

# only HEADER FILES: the files, a pattern, that alone may include it.
only() {
    local found
    found=$(grep -rlE "^ *# *include +<$1>" solver api library cli import server | grep -vxE "$2")
    [ -z "$found" ] || { echo "$1 belongs in $2 alone, but is included in:" $found; bad=1; }
}

only microhttpd.h 'server/http/(http|exchange|suspension|interpose)\.c'
only sqlite3.h 'server/store/sqlite/(db|backup)\.c' # copies need the library's own back-up
only libpq-fe.h 'server/store/postgres/(pool|statement|notify|backup)\.c' # COPY is no statement of query.h
only jansson.h 'api/json/(value|parse)\.c|server/resources/documents\.c'
only zlib.h 'api/format/(npz|lcmsim|png|zip_writer)\.c|api/map/vtk_xml\.c|server/http/compress\.c'
only hdf5.h 'api/format/hdf5\.c'
only seccomp.h 'server/work/sandbox\.c'
only zstd.h 'server/http/compress\.c'
only xxhash.h 'api/checksum\.c'
only geos_c.h 'api/laminate/plane\.c'
only sodium.h 'api/request/digest\.c|api/map/vtk_xml\.c|server/store/cursor\.c|server/id\.c|server/store/sqlite/jobs\.c|server/http/tokens\.c'
only expat.h 'api/map/vtk_xml\.c'
exit $bad
