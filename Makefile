# SPDX-License-Identifier: MIT
# all, demo, test, soak, hosts, fuzz, load, tsan, valgrind, coverage, bench, figures, lint, format,
# install, deb, sbom, clean. See README.md and CONTRIBUTING.md.
.DEFAULT_GOAL := all
SHELL := /bin/bash
B ?= build
CC := gcc
CXX := g++
OPT ?= -O3
SANITIZE ?=
WARN := -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wsign-conversion -Wstrict-prototypes \
        -Wmissing-prototypes -Wvla -Wformat=2 -Wcast-qual -Wundef -Wdouble-promotion -Werror
# No contraction: the same bits on every machine. Nobody asks for errno of a square root or for
# floating-point traps, which would keep loops from becoming vector instructions; outside loops such
# instructions cost more to fill than they save. Four-lane vectors are passed between static
# functions only, so the ABI note about them does not matter.
NUMERIC := -ffp-contract=off -fno-math-errno -fno-trapping-math -fno-tree-slp-vectorize -Wno-psabi
CPPFLAGS := -D_GNU_SOURCE -I. -I$(B)/gen -isystem /usr/include/postgresql
CFLAGS := -std=gnu11 $(OPT) -g $(NUMERIC) $(WARN) $(SANITIZE)
CXXFLAGS := -std=c++17 $(OPT) -g -fno-exceptions -fno-rtti -Wall -Wextra -Wpedantic -Wshadow \
            -Wconversion -Werror $(SANITIZE)
DEPFLAGS = -MMD -MP
LDFLAGS := $(SANITIZE)
CLANG_FORMAT := clang-format-14

objects = $(patsubst %.c,$(B)/%.o,$(1))
# The C files of a folder and of those in it, two deep.
sources = $(wildcard $(1)/*.c $(1)/*/*.c $(1)/*/*/*.c)
SOLVER_OBJ := $(call objects,$(call sources,solver))
API_OBJ := $(call objects,$(filter-out api/clients/%,$(call sources,api))) \
           $(patsubst %.cc,$(B)/%.o,$(wildcard api/*/*.cc))
CLI_OBJ := $(call objects,$(call sources,cli))
SERVER_OBJ := $(call objects,$(filter-out server/main.c server/viewer/%,$(call sources,server)))
LIBS := $(B)/libdrapeserver.a $(B)/libdrapeapi.a $(B)/libdrape.a
API_LIBS := -ljansson -lsodium -lz -lstdc++ -lpthread -lm
SERVER_LIBS := -lmicrohttpd -lseccomp -lsqlite3 -lpq -lzstd $(API_LIBS)

# A test program is tests/KIND/test_NAME.c with the other files of its folder.
TEST_SRC := $(wildcard tests/unit/*.c tests/exact/*.c tests/store/*.c)
TEST_MAIN := $(filter $(addsuffix test_%,$(sort $(dir $(TEST_SRC)))),$(TEST_SRC))
TESTS := $(TEST_MAIN:%.c=$(B)/%)
test_helpers = $(call objects,$(filter-out $(dir $(1))test_%,$(wildcard $(dir $(1))*.c)))

# A fuzz target is tests/fuzz/fuzz_NAME.c; without a fuzzer it replays corpus/NAME.
FUZZ := $(patsubst tests/fuzz/fuzz_%.c,%,$(wildcard tests/fuzz/fuzz_*.c))
FUZZ_HELPERS := $(call objects,tests/fuzz/encode.c tests/fuzz/mesh.c tests/fuzz/service.c)
REPLAYS := $(FUZZ:%=$(B)/tests/fuzz/fuzz_%)
FUZZERS := $(FUZZ:%=$(B)/tests/fuzz/run_%)

.PHONY: all demo test tests golden soak fuzz fuzzers hosts load tsan valgrind coverage bench figures lint format install deb sbom clean
all: $(B)/draped $(B)/drape

# Installs what the build needs, once; `make test` asks for more.
$(B)/.setup: deploy/setup.sh
	@deploy/setup.sh build
	@mkdir -p $(B) && touch $@

$(B)/%.o: %.c Makefile | $(B)/.setup
	@mkdir -p $(@D)
	$(CC) $(CPPFLAGS) $(CFLAGS) $(DEPFLAGS) -c -o $@ $<
$(B)/%.o: %.cc Makefile | $(B)/.setup
	@mkdir -p $(@D)
	$(CXX) $(CPPFLAGS) $(CXXFLAGS) $(DEPFLAGS) -c -o $@ $<

# The contract in the binary: api/openapi.yaml as a C array of JSON.
$(B)/gen/openapi_json.h: api/openapi.yaml api/embed_openapi.py | $(B)/.setup
	@mkdir -p $(@D)
	python3 api/embed_openapi.py $< $@
$(B)/server/resources/meta.o: $(B)/gen/openapi_json.h

# The page at / in the binary: its files, the modules of three.js it draws with, the examples.
VIEWER := $(wildcard server/viewer/*.html server/viewer/*.css server/viewer/*.js server/viewer/*.svg) \
          $(wildcard api/examples/*.json)
THREE := server/viewer/node_modules/three
THREE_FILES := $(THREE)/build/three.module.min.js $(THREE)/build/three.core.min.js \
               $(THREE)/examples/jsm/controls/OrbitControls.js $(THREE)/examples/jsm/curves/NURBSUtils.js
$(THREE)/package.json: server/viewer/package-lock.json | $(B)/.setup
	@npm ci --silent --no-audit --no-fund --ignore-scripts --prefix server/viewer && touch $@
$(B)/gen/viewer_files.h: server/viewer/embed.py $(VIEWER) $(THREE)/package.json
	@mkdir -p $(@D)
	python3 $< $(@D) $(VIEWER) $(THREE_FILES)
$(B)/server/resources/viewer.o: $(B)/gen/viewer_files.h

# The powers of ten that the shortest decimals take.
$(B)/gen/powers.h: api/embed_powers.py | $(B)/.setup
	@mkdir -p $(@D)
	python3 $< $@
$(B)/api/json/shortest.o: $(B)/gen/powers.h

$(B)/libdrape.a: $(SOLVER_OBJ)
$(B)/libdrapeapi.a: $(API_OBJ)
$(B)/libdrapeserver.a: $(SERVER_OBJ)
$(B)/%.a:
	@rm -f $@
	ar rcs $@ $^

$(B)/draped: $(B)/server/main.o $(LIBS)
	$(CC) $(LDFLAGS) -o $@ $^ $(SERVER_LIBS)
$(B)/drape: $(CLI_OBJ) $(B)/libdrapeapi.a $(B)/libdrape.a
	$(CC) $(LDFLAGS) -o $@ $^ $(API_LIBS)

.SECONDEXPANSION:
$(TESTS): $(B)/%: $(B)/%.o $$(call test_helpers,$$*.c) $(LIBS)
	$(CC) $(LDFLAGS) -o $@ $^ -lcmocka $(SERVER_LIBS)

$(REPLAYS): $(B)/tests/fuzz/fuzz_%: $(B)/tests/fuzz/fuzz_%.o $(B)/tests/fuzz/replay.o \
        $(FUZZ_HELPERS) $(LIBS)
	$(CC) $(LDFLAGS) -o $@ $^ $(SERVER_LIBS)
$(FUZZERS): $(B)/tests/fuzz/run_%: $(B)/tests/fuzz/fuzz_%.o $(FUZZ_HELPERS) $(LIBS)
	$(CC) $(LDFLAGS) -fsanitize=fuzzer -o $@ $^ $(SERVER_LIBS)

# All tests, also of a build with sanitizers. The installation comes first, in a make of its own,
# because what is to be built depends on it.
SANITIZED := OPT=-O1 SANITIZE="-fsanitize=address,undefined -fno-sanitize-recover=all"
test:
	@deploy/setup.sh test
	@$(MAKE) --no-print-directory -s all tests $(TEST_MODULES)
	@$(MAKE) --no-print-directory -s B=$(B)/sanitized $(SANITIZED) all tests
	@tests/run.sh $(B) $(B)/sanitized
tests: $(TESTS) $(REPLAYS)
# Validators of glTF, manifests and bills of materials, and what drives the browser, as the lock
# files pin them.
TEST_MODULES := $(patsubst %,tests/%/node_modules,browser manifests readers)
$(TEST_MODULES): %/node_modules: %/package-lock.json
	@npm ci --silent --no-audit --no-fund --ignore-scripts --omit=optional --prefix $* && touch $@

# Writes down what tests compare with, after a change that is meant: the bytes of results and of
# small documents, the tables of docs/fields.md and docs/settings.md.
golden: all $(B)/tests/unit/test_formats $(B)/tests/unit/test_column_list
	@python3 tests/results/compare.py $(B) --write
	@for test in formats column_list; do DRAPE_GOLDEN=write $(B)/tests/unit/test_$$test 2>/dev/null || exit 1; done
	@$(B)/draped --help | awk -f docs/settings.awk >docs/settings.md
	@git --no-pager diff --stat tests docs

# The tests that hurt, at full length: 200 kills, a thousand slow clients for 30 s, ...
soak:
	@deploy/setup.sh test
	@$(MAKE) --no-print-directory -s all
	@for test in tests/faults/test_*.py; do LONG=1 BUILD=$(B) python3 $$test || exit 1; done

# Looks for inputs that break a promise, FUZZ_SECONDS for each target.
FUZZ_SECONDS ?= 60
fuzz:
	@deploy/setup.sh fuzz
	@$(MAKE) --no-print-directory -s B=$(B)/fuzz CC=clang-14 CXX=clang++-14 OPT=-O1 WARN=-w \
	    SANITIZE="-fsanitize=fuzzer-no-link,address,undefined -fno-sanitize-recover=all" fuzzers
	@tests/fuzz/fuzz.sh $(B)/fuzz $(FUZZ_SECONDS) $(FUZZ)
fuzzers: $(FUZZERS)

demo: all
	@deploy/demo.sh $(B)

lint: all
	@deploy/setup.sh test
	@$(MAKE) --no-print-directory -s $(TEST_MODULES)
	@for check in tests/checks/*.sh; do echo $$check; $$check $(B) || exit 1; done

format: tests/browser/node_modules
	find solver api cli server tests -name node_modules -prune -o \
	    \( -name '*.[ch]' -o -name '*.cc' \) -print | xargs $(CLANG_FORMAT) -i
	node $</prettier/bin/prettier.cjs --log-level warn --write server/viewer/*.js tests/*/*.mjs

PREFIX ?= /usr/local
UNITS ?= $(PREFIX)/lib/systemd/system
VERSION := $(shell sed -n 's/^\#define DRAPED_VERSION "\(.*\)"/\1/p' server/config.h)
OPERATORS := $(addprefix deploy/,nginx.conf Caddyfile prometheus grafana)
install: all sbom $(B)/draped.1 $(B)/drape.1
	install -D -t $(DESTDIR)$(PREFIX)/bin $(B)/draped $(B)/drape
	install -D -m 644 -t $(DESTDIR)$(PREFIX)/share/man/man1 $(B)/draped.1 $(B)/drape.1
	install -D -m 644 -t $(DESTDIR)$(UNITS) deploy/systemd/draped.socket
	sed 's|/usr/bin/|$(PREFIX)/bin/|' deploy/systemd/draped.service | \
	    install -m 644 /dev/stdin $(DESTDIR)$(UNITS)/draped.service
	install -D -m 644 -t $(DESTDIR)$(PREFIX)/share/doc/draped $(B)/draped.cdx.json
	cp -r $(OPERATORS) $(DESTDIR)$(PREFIX)/share/doc/draped
	for page in operations runbook; do \
	    sed 's|](\.\./deploy/|](|g' docs/$$page.md | \
	        install -m 644 /dev/stdin $(DESTDIR)$(PREFIX)/share/doc/draped/$$page.md; done

# Manual pages, their flags from --help.
$(B)/%.1: deploy/man/%.1.in deploy/man/options.awk $(B)/%
	awk -f deploy/man/options.awk <($(B)/$* --help) $< >$@

# The bill of materials.
sbom: $(B)/draped.cdx.json
$(B)/draped.cdx.json: deploy/sbom.py $(B)/draped $(B)/drape
	python3 $< $(VERSION) $(B)/draped $(B)/drape >$@.new && mv $@.new $@

# The Debian package, in $(B)/deb.
deb:
	@deploy/setup.sh package
	@deploy/deb.sh $(B) $(VERSION)

# Redraws docs/figures from the program's own results.
figures: $(B)/drape
	@tests/figures/figures.sh $(B)

bench: $(B)/tests/bench/bench_solver $(B)/tests/bench/bench_surfaces $(B)/tests/bench/bench_store $(B)/draped
	$<
	$(B)/tests/bench/bench_surfaces
	tests/bench/bench_formats.sh $(B)
	tests/bench/bench_map.sh $(B)
	@deploy/setup.sh test
	tests/bench/bench_store.sh $(B)
$(B)/tests/bench/bench_solver: $(B)/tests/bench/bench_solver.o $(B)/libdrapeapi.a $(B)/libdrape.a
	$(CC) $(LDFLAGS) -o $@ $^ $(API_LIBS)
$(B)/tests/bench/bench_surfaces: $(call objects,$(addprefix tests/,bench/bench_surfaces.c \
        bench/surfaces.c exact/shapes.c exact/spline.c)) $(B)/libdrape.a
	$(CC) $(LDFLAGS) -o $@ $^ -lm

$(B)/tests/bench/bench_store: $(B)/tests/bench/bench_store.o $(LIBS)
	$(CC) $(LDFLAGS) -o $@ $^ $(SERVER_LIBS)

# The test with six hosts, in its long form.
hosts: all
	@deploy/setup.sh test
	tests/hosts/hosts.sh $(B) 2000

# What the daemon bears, next to libmicrohttpd alone.
load: all
	@deploy/setup.sh test
	@$(MAKE) --no-print-directory -s $(B)/tests/load/bare
	@tests/load/load.sh $(B)
$(B)/tests/load/bare: $(B)/tests/load/bare.o
	$(CC) $(LDFLAGS) -o $@ $^ -lmicrohttpd

# What is threaded, under ThreadSanitizer.
tsan:
	@deploy/setup.sh test
	@$(MAKE) --no-print-directory -s B=$(B)/tsan OPT=-O1 SANITIZE=-fsanitize=thread all tests
	@tests/run_tsan.sh $(B)/tsan

# Lines of solver, api and server that the tests run.
coverage:
	@deploy/setup.sh test
	@$(MAKE) --no-print-directory -s $(TEST_MODULES)
	@$(MAKE) --no-print-directory -s B=$(B)/coverage OPT=-O0 SANITIZE="--coverage \
	    -fprofile-update=atomic -Wl,-u,__gcov_dump,--export-dynamic-symbol=__gcov_dump" all tests
	@tests/run_coverage.sh $(B)/coverage

# The daemon and the command, once each, under valgrind.
valgrind: all
	@deploy/setup.sh test
	@tests/run_valgrind.sh $(B)

clean:
	rm -rf $(B)

-include $(shell find $(B) -name '*.d' 2>/dev/null)
