# SPDX-License-Identifier: MIT
# Test programs and what is run now and then; included by Makefile.

.PHONY: tests golden mould-quality soak seeds fuzz fuzzers mutants mutable mutant hosts load image tsan valgrind coverage bench figures page-figures filling validate blade \
    benchmark benchmark-cases freecad \
    .test-tools .plain .sanitized
JOBS ?= $(shell nproc)

# A test program is tests/KIND/test_NAME.c with the other files of its folder; those of server/ have a
# store to work on, too.
TEST_SRC := $(wildcard tests/unit/*.c tests/exact/*.c tests/store/*.c tests/server/*.c)
TEST_MAIN := $(filter $(addsuffix test_%,$(sort $(dir $(TEST_SRC)))),$(TEST_SRC))
TESTS := $(TEST_MAIN:%.c=$(B)/%)
helper_folders = $(dir $(1)) $(if $(filter tests/server/%,$(1)),tests/store/)
test_helpers = $(call objects,$(foreach folder,$(call helper_folders,$(1)),\
                   $(filter-out $(folder)test_%,$(wildcard $(folder)*.c)))) \
               $(if $(filter %/test_library.c,$(1)),$(B)/library/library.o)

# A fuzz target is tests/fuzz/fuzz_NAME.c; without a fuzzer it replays corpus/NAME.
FUZZ := $(patsubst tests/fuzz/fuzz_%.c,%,$(wildcard tests/fuzz/fuzz_*.c))
FUZZ_HELPERS := $(call objects,tests/fuzz/encode.c tests/fuzz/mesh.c tests/fuzz/service.c)
REPLAYS := $(FUZZ:%=$(B)/tests/fuzz/fuzz_%)
FUZZERS := $(FUZZ:%=$(B)/tests/fuzz/run_%)

PARSERS := tests/fuzz/parsers

.SECONDEXPANSION:
$(TESTS): $(B)/%: $(B)/%.o $$(call test_helpers,$$*.c) $(LIBS)
	$(call say,LINK,$@)$(LINK) -o $@ $^ -lcmocka $(SERVER_LIBS)

$(REPLAYS): $(B)/tests/fuzz/fuzz_%: $(B)/tests/fuzz/fuzz_%.o $(B)/tests/fuzz/replay.o \
        $(FUZZ_HELPERS) $(LIBS)
	$(call say,LINK,$@)$(LINK) -o $@ $^ $(SERVER_LIBS)
$(FUZZERS): $(B)/tests/fuzz/run_%: $(B)/tests/fuzz/fuzz_%.o $(FUZZ_HELPERS) $(LIBS)
	$(call say,LINK,$@)$(LINK) -fsanitize=fuzzer -o $@ $^ $(SERVER_LIBS)

# The exact answers are computed as in the plain build everywhere: sanitizers are to watch the drapes,
# and four fifths of what the exact tests took with them were the answers.
ANSWERS := $(call objects,$(addprefix tests/exact/,chebyshev.c geodesic.c goursat.c reference.c spline.c))
$(ANSWERS): CFLAGS := $(filter-out $(OPT) $(SANITIZE),$(CFLAGS)) -O3

tests: $(TESTS) $(REPLAYS) $(B)/tests/import/make_parts $(B)/tests/import/make_splits

# What writes the CAD files that the importer is tested with; no part of what is tested.
$(B)/tests/import/make_parts $(B)/tests/import/make_splits: $(B)/%: %.cc | $(B)/.setup-import
	@mkdir -p $(@D)
	$(call say,LINK,$@)$(CXX) -std=c++17 -O1 -isystem /usr/include/opencascade -o $@ $< -lTKXDESTEP \
	    -lTKFillet -lTKOffset -lTKBO -lTKBool -lTKPrim $(OCC_LIBS)

# Both builds in one make. What both would fetch or install is there already.
SANITIZED := OPT=-O1 SANITIZE="-fsanitize=address,undefined -fno-sanitize-recover=all"
.plain: all library tests sbom $(B)/draped.1 $(B)/drape.1 $(B)/drape-import.1
.sanitized:
	@$(MAKE) --no-print-directory B=$(B)/sanitized $(SANITIZED) all tests
# What the tests need beside the build; the installation in a make of its own, because what is to be
# built depends on it.
.test-tools:
	@deploy/setup.sh test
	@$(MAKE) --no-print-directory -s $(THREE)/package.json $(TEST_MODULES) clients

# Validators of glTF, manifests and bills of materials, and what drives the browser, as the lock
# files pin them.
TEST_MODULES := $(patsubst %,tests/%/node_modules,browser manifests readers)
$(TEST_MODULES) $(PARSERS)/node_modules: %/node_modules: %/package-lock.json
	@npm ci --silent --no-audit --no-fund --ignore-scripts --omit=optional --prefix $* && touch $@

# What tests compare with: the bytes of results and of small documents, the tables of docs/fields.md,
# docs/formats.md and docs/settings.md, and what deploy/render.py writes.
GOLDEN := $(addprefix $(B)/tests/unit/test_,formats lists)
golden: all $(GOLDEN) ## when results change and should: writes anew what they are compared with
	@python3 tests/results/compare.py $(B) --write
	@for test in $(GOLDEN); do DRAPE_GOLDEN=write $$test >/dev/null 2>&1; done # their other tests may fail
	@$(B)/draped --help | awk -f docs/settings.awk >docs/settings.md
	@deploy/render.py $(B)/draped
	@python3 tests/checks/messages.py --write
	@git --no-pager diff --stat -- tests docs deploy

# The tests that hurt, at full length: 200 kills, a thousand slow clients for 30 s, ...
soak: $(B)/tests/exact/test_exact_estimates $(B)/tests/import/make_parts $(B)/tests/import/make_splits ## 200 kills under load, a thousand slow clients, damaged files, the gate, all estimates
	@deploy/setup.sh test
	@$(MAKE) --no-print-directory -s all
	@LONG=1 $(B)/tests/exact/test_exact_estimates
	@for test in tests/faults/test_*.py; do LONG=1 BUILD=$(B) python3 $$test || exit 1; done
	@for test in tests/import/test_*.py; do LONG=1 BUILD=$(B) /usr/bin/python3 $$test || exit 1; done
	@STRICT=1 tests/load/gate.sh $(B)

# Random tests begin with the same seeds every time, so that a run says of a tree what the one before
# said.
SEEDS ?= 10
seeds: tests ## after a change in solver/: random tests with SEEDS (10) seeds that nobody has tried
	@tests/seeds.sh $(B) $(SEEDS)

# Looks for inputs that break a promise, and for connections that other parsers of HTTP read in another
# way, FUZZ_SECONDS for each target.
FUZZ_SECONDS ?= 60
fuzz: ## after a change in what reads requests: FUZZ_SECONDS (60) for each target
	@deploy/setup.sh fuzz
	@$(MAKE) --no-print-directory -s B=$(B)/fuzz CC=clang-14 CXX=clang++-14 OPT=-O1 WARN=-w \
	    SANITIZE="-fsanitize=fuzzer-no-link,address,undefined -fno-sanitize-recover=all" fuzzers
	@$(MAKE) --no-print-directory -s $(PARSERS)/node_modules $(B)/$(PARSERS)/wire
	@tests/fuzz/fuzz.sh $(B)/fuzz $(FUZZ_SECONDS) $(FUZZ)
	@/usr/bin/python3 $(PARSERS)/parsers.py $(B)/$(PARSERS)/wire $(FUZZ_SECONDS) # with Debian's h11
fuzzers: $(FUZZERS)
$(B)/$(PARSERS)/wire: $(B)/$(PARSERS)/wire.o $(B)/server/http/wire.o
	$(call say,LINK,$@)$(LINK) -o $@ $^

# Whether the tests notice mistakes: those of tests/mutants/mutants.toml, one at a time, each in a copy
# of the tree (ONLY: those in whose file or reason the pattern is found), and without ONLY 100 that
# tests/mutants/generate.py makes at random, SEED again the same.
mutants: ## before a release: small mistakes that tests have to notice, written ones and 100 at random (ONLY=: a pattern)
	@$(MAKE) --no-print-directory -s .test-tools
	@status=0; tests/mutants/mutants.py run '$(ONLY)' || status=1; \
	    [ -n '$(ONLY)' ] || tests/mutants/generate.py --build $(B)/mutable $(SEED:%=--seed %) || status=1; \
	    exit $$status

# For mistakes made at random: all of the program in one shared library, which counts lines. The
# programs load it from loaded/, where one with a mistake takes its place: FILE with the text of
# mutant.c, which compilers need not like the looks of.
MUTABLE := $(B)/libmutable.so
MUTABLE_OBJ := $(SOLVER_OBJ) $(API_OBJ) $(SERVER_OBJ)
MUTABLE_LINK = $(CC) -shared -fuse-ld=gold -Wl,-soname,libmutable.so,-u,__gcov_dump --coverage
MUTABLE_FLAGS := HARDEN=-fPIC HDF5_LIBS=-lhdf5_serial
$(MUTABLE): $(MUTABLE_OBJ)
	$(call say,LINK,$@)$(MUTABLE_LINK) -o $@ $^ $(SERVER_LIBS)
$(B)/watched.so: tests/watched.c
	$(call say,LINK,$@)$(CC) -shared -fPIC -D_GNU_SOURCE -o $@ $<
mutable:
	@$(MAKE) --no-print-directory -s -j$(JOBS) $(MUTABLE_FLAGS) OPT=-O1 WARN=-w API_ARCHIVES=$(MUTABLE) \
	    LIBS=$(MUTABLE) HARDEN_LINK='-Wl,-rpath,$(abspath $(B))/loaded' SANITIZE=--coverage \
	    $(B)/draped $(B)/drape $(B)/drape-import $(B)/watched.so $(TESTS) \
	    $(B)/tests/import/make_parts
mutant:
	@$(MAKE) --no-print-directory -s $(MUTABLE_FLAGS) OPT='-O2 -Wno-empty-body -Wno-parentheses' \
	    DEBUG= $(B)/loaded/libmutable.so
$(B)/loaded/libmutable.so:
	@$(CC) $(CPPFLAGS) $(CFLAGS) -iquote $(dir $(FILE)) -c -o $(B)/mutant.o $(B)/mutant.c
	@$(MUTABLE_LINK) -o $@ $(filter-out $(B)/$(FILE:.c=.o),$(MUTABLE_OBJ)) $(B)/mutant.o $(SERVER_LIBS)

figures: all $(B)/tests/exact/test_exact_estimates $(B)/tests/import/make_parts ## redraws docs/figures from the program's own results, and pictures of the page
	@tests/figures/figures.sh $(B)
	@$(MAKE) --no-print-directory -s page-figures
page-figures: all $(B)/tests/import/make_parts tests/browser/node_modules # the page's pictures alone
	@tests/figures/page.sh $(B)

filling: all ## fills a mould with DOLFINx, with draped and with flat fields: docs/filling.md
	@deploy/setup.sh filling
	@tests/figures/filling.sh $(B)

validate: all ## drapes what others have draped, prints both beside each other: docs/validation.md
	@mkdir -p $(B)/validation
	@tests/validation/validate.py $(B)/drape $(B)/validation
	@gnuplot -e "data = '$(B)/validation'" tests/validation/course.gp
	@awk -f tests/figures/compact.awk $(B)/validation/course.svg >docs/figures/course.svg

blade: $(B)/drape ## a layer of courses on the blade-like mould, searched by three studies: docs/validation.md
	@tests/validation/blade.sh $< tests/validation/blade.json

# The open benchmark: its cases, written by programs that share no code with the solver's march, and
# the scores of all methods here.
CASE_HELPERS := $(call objects,$(filter-out tests/exact/test_%,$(wildcard tests/exact/*.c)))
$(B)/tests/benchmark/make_cases: $(B)/tests/benchmark/make_cases.o $(CASE_HELPERS) $(B)/libdrape.a
	$(call say,LINK,$@)$(LINK) -o $@ $^ -lcmocka -ljansson -lm
$(B)/tests/benchmark/make_steps: tests/benchmark/make_steps.cc | $(B)/.setup-import
	@mkdir -p $(@D)
	$(call say,LINK,$@)$(CXX) -std=c++17 -O1 -isystem /usr/include/opencascade -o $@ $< -lTKSTEP \
	    $(OCC_LIBS)
benchmark-cases: $(B)/tests/benchmark/make_cases $(B)/tests/benchmark/make_steps ## writes the cases of benchmark/ anew
	@mkdir -p $(addprefix benchmark/cases/,cylinder cone hat folds torus dome sphere saddle mould \
	    rational freeform blade)
	@$(B)/tests/benchmark/make_cases benchmark/cases tests/validation/blade.json
	@$(B)/tests/benchmark/make_steps benchmark/cases
benchmark: all ## drapes and scores the cases of benchmark/ by all methods: benchmark/README.md
	@python3 tests/benchmark/run.py $(B)/drape $(B)/benchmark

# Not in `make test`: FreeCAD is 800 MB. What of the workbench needs no FreeCAD is tests/http/workbench.bats.
freecad: all ## after a change of the import or the workbench: parts that FreeCAD makes, and drapes in FreeCAD
	@deploy/setup.sh freecad
	@BUILD=$(B) /usr/bin/python3 tests/import/freecad.py
	@BUILD=$(B) /usr/bin/python3 tests/clients/freecad.py

BENCHES := $(addprefix $(B)/tests/bench/bench_,solver surfaces shell courses cuts parts store)
bench: $(BENCHES) all $(B)/tests/import/make_parts ## after a change in solver/ or the store: ratios within one run
	$<
	$(B)/tests/bench/bench_surfaces
	$(B)/tests/bench/bench_shell
	$(B)/tests/bench/bench_courses
	$(B)/tests/bench/bench_cuts
	tests/bench/bench_parts.sh $(B)
	tests/bench/bench_formats.sh $(B)
	tests/bench/bench_map.sh $(B)
	tests/bench/bench_study.sh $(B)
	tests/bench/bench_variants.sh $(B)
	@deploy/setup.sh test
	tests/bench/bench_store.sh $(B)
$(B)/tests/bench/bench_solver: $(B)/tests/bench/bench_solver.o $(B)/libdrapeapi.a $(B)/libdrape.a
	$(call say,LINK,$@)$(LINK) -o $@ $^ $(API_LIBS)
$(B)/tests/bench/bench_parts: $(B)/tests/bench/bench_parts.o $(B)/libdrapeapi.a $(B)/libdrape.a
	$(call say,LINK,$@)$(LINK) -o $@ $^ $(API_LIBS)
$(B)/tests/bench/bench_surfaces: $(call objects,$(addprefix tests/,bench/bench_surfaces.c \
        bench/surfaces.c exact/shapes.c exact/spline.c)) $(B)/libdrape.a
	$(call say,LINK,$@)$(LINK) -o $@ $^ -lm

$(B)/tests/bench/bench_shell $(B)/tests/bench/bench_courses $(B)/tests/bench/bench_cuts: $(B)/%: $(B)/%.o \
        $(call objects,tests/exact/shapes.c tests/exact/spline.c) $(B)/libdrape.a
	$(call say,LINK,$@)$(LINK) -o $@ $^ -lm

$(B)/tests/bench/bench_store: $(B)/tests/bench/bench_store.o $(LIBS)
	$(call say,LINK,$@)$(LINK) -o $@ $^ $(SERVER_LIBS)

# Random parts number PARTS and the examples, on nets of NODES, by MEASURE; figures are kept in KEEP.
PARTS ?= 0:20
MEASURE ?= optimise,long
NODES ?= 900
KEEP ?= $(B)/study_quality
study-quality: $(B)/drape ## after a change of searches: how near `optimise` comes to long searches and grids
	nice -n 19 tests/bench/study_quality.py $(B) --parts $(PARTS) --examples --nodes $(NODES) \
		--measure $(MEASURE) --keep $(KEEP)

# Parts with fillets, against a grid of VARIANTS; others as CAD="PART.step:FACE".
VARIANTS ?= 20000
ROUNDED := 0,1,3,4,6,7,10,11,12,14,15,18,19,20,22,23,25 # all but its bottom and what rounds that
mould-quality: $(B)/drape $(B)/drape-import $(B)/tests/bench/make_moulds $(B)/tests/import/make_parts ## after a change of searches: the same on CAD parts, against grids
	@mkdir -p $(B)/moulds $(B)/parts
	@$(B)/tests/bench/make_moulds $(B)/moulds && $(B)/tests/import/make_parts $(B)/parts >/dev/null
	nice -n 19 tests/bench/study_quality.py $(B) --parts 0:0 --moulds $(B)/moulds \
		--cad $(addprefix $(B)/parts/,cover.step:0 pillar.step:0 dome.step:0 rounded.step:$(strip $(ROUNDED))) \
		$(CAD) --nodes $(NODES) --near 0.5 --measure optimise,brute --brute $(VARIANTS) --keep $(B)/mould_quality
$(B)/tests/bench/make_moulds: tests/bench/make_moulds.cc | $(B)/.setup-import
	@mkdir -p $(@D)
	$(call say,LINK,$@)$(CXX) -std=c++17 -O1 -isystem /usr/include/opencascade -o $@ $< -lTKFillet \
	    -lTKOffset -lTKBO -lTKBool -lTKPrim $(OCC_LIBS)

hosts: all ## after a change in the store: six hosts, 2,000 drapes
	@deploy/setup.sh test
	tests/hosts/hosts.sh $(B) 2000

load: all ## after a change in server/: rates, latency and memory, beside libmicrohttpd alone
	@deploy/setup.sh test
	@$(MAKE) --no-print-directory -s $(B)/tests/load/bare
	@tests/load/load.sh $(B)
	@tests/load/gate.sh $(B)
$(B)/tests/load/bare: $(B)/tests/load/bare.o
	$(call say,LINK,$@)$(LINK) -o $@ $^ -lmicrohttpd

# As root, with a mirror of Debian; FULL=1 has the image compile everything itself.
image: all $(B)/tests/import/make_parts ## before a release: the container image, built by buildah without a registry, and run
	@deploy/setup.sh image
	@tests/deploy/image.sh $(B)

tsan: ## after a change of threads in server/: its tests under ThreadSanitizer
	@deploy/setup.sh test
	@$(MAKE) --no-print-directory -s B=$(B)/tsan OPT=-O1 SANITIZE=-fsanitize=thread all tests
	@tests/run_tsan.sh $(B)/tsan

coverage: ## lines of solver, api and server that the tests run, by folder
	@deploy/setup.sh test
	@$(MAKE) --no-print-directory -s $(TEST_MODULES)
	@$(MAKE) --no-print-directory -s B=$(B)/coverage OPT=-O0 SANITIZE="--coverage \
	    -fprofile-update=atomic -Wl,-u,__gcov_dump,--export-dynamic-symbol=__gcov_dump" all tests
	@tests/run_coverage.sh $(B)/coverage

# The daemon and the command, once each, under valgrind.
valgrind: all ## after a change of memory: a drape by the command and by the daemon
	@deploy/setup.sh test
	@tests/run_valgrind.sh $(B)

