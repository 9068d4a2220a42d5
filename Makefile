# SPDX-License-Identifier: MIT
# `make help` lists the targets; those for tests are in tests/tests.mk. V=1 shows whole commands.
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
# What makes a mistake in memory end the program rather than serve a stranger, read from the programs
# by tests/checks/hardening.sh. FORTIFY and sanitizers watch the same calls: one is enough.
MACHINE := $(shell uname -m)
HARDEN := -fPIE -fstack-protector-strong -fstack-clash-protection \
          $(if $(filter x86_64%,$(MACHINE)),-fcf-protection) \
          $(if $(filter aarch64%,$(MACHINE)),-mbranch-protection=standard) \
          $(if $(SANITIZE),,-D_FORTIFY_SOURCE=2)
HARDEN_LINK := -pie -Wl,-z,relro,-z,now,-z,noexecstack
CPPFLAGS := -D_GNU_SOURCE -I. -I$(B)/gen -isystem /usr/include/postgresql \
            -isystem /usr/include/hdf5/serial
# A sanitizer's report asks for lines alone; the rest would be half of the time of its build.
DEBUG := $(if $(SANITIZE),-g1,-g)
CFLAGS := -std=gnu11 $(OPT) $(DEBUG) $(NUMERIC) $(HARDEN) $(WARN) $(SANITIZE)
CXXFLAGS := -std=c++17 $(OPT) $(DEBUG) -fno-exceptions -fno-rtti -Wall -Wextra -Wpedantic -Wshadow \
            -Wconversion -Werror $(HARDEN) $(SANITIZE)
DEPFLAGS = -MMD -MP
LDFLAGS := $(SANITIZE)
LINK = $(CC) $(HARDEN_LINK) $(LDFLAGS)
CLANG_FORMAT := clang-format-14

# $(call say,WORD,FILE) begins a command: one short line in place of the command itself.
ifneq ($(V),1)
say = @$(if $(findstring s,$(firstword -$(MAKEFLAGS))),,echo '$(1) $(2)';)
endif

objects = $(patsubst %.c,$(B)/%.o,$(1))
# The C files of a folder and of those in it, two deep.
sources = $(wildcard $(1)/*.c $(1)/*/*.c $(1)/*/*/*.c)
SOLVER_OBJ := $(call objects,$(call sources,solver))
API_OBJ := $(call objects,$(call sources,api)) \
           $(patsubst %.cc,$(B)/%.o,$(wildcard api/*/*.cc))
CLI_OBJ := $(call objects,$(wildcard cli/*.c))
IMPORT_OBJ := $(call objects,$(wildcard import/*.c) cli/files.c) \
              $(patsubst %.cc,$(B)/%.o,$(wildcard import/*.cc))
SERVER_OBJ := $(call objects,$(filter-out server/main.c server/viewer/%,$(call sources,server)))
API_ARCHIVES := $(B)/libdrapeapi.a $(B)/libdrape.a
LIBS := $(B)/libdrapeserver.a $(API_ARCHIVES)
# HDF5 from its archive: the shared library brings 30 others, HTTP clients among them.
HDF5_LIBS := -l:libhdf5_serial.a -l:libsz.a -l:libaec.a
API_LIBS := $(HDF5_LIBS) -lgeos_c -ljansson -lsodium -lexpat -lz -lstdc++ -lpthread -lm
SERVER_LIBS := -lmicrohttpd -lseccomp -lsqlite3 -lpq -lzstd $(API_LIBS)

.PHONY: all library help demo check test lint format install install-import install-library deb sbom \
    release clean
all: $(B)/draped $(B)/drape $(B)/drape-import ## build/draped, build/drape and build/drape-import

# Installs what the build needs, once; `make test` asks for more. One step after the other, since dpkg
# takes one at a time; what needs the first alone is compiled beside the others.
$(B)/.setup: deploy/setup.sh
	@deploy/setup.sh compile
	@mkdir -p $(B) && touch $@
$(B)/.setup-import: $(B)/.setup
	@deploy/setup.sh import && touch $@
$(B)/.setup-page: $(B)/.setup-import
	@deploy/setup.sh page && touch $@

$(B)/%.o: %.c Makefile | $(B)/.setup
	@mkdir -p $(@D)
	$(call say,CC,$<)$(CC) $(CPPFLAGS) $(CFLAGS) $(DEPFLAGS) -c -o $@ $<
$(B)/%.o: %.cc Makefile | $(B)/.setup
	@mkdir -p $(@D)
	$(call say,CXX,$<)$(CXX) $(CPPFLAGS) $(CXXFLAGS) $(DEPFLAGS) -c -o $@ $<

# The contract in the binary: api/openapi.yaml as a C array of JSON.
$(B)/gen/openapi_json.h: api/openapi.yaml api/embed_openapi.py | $(B)/.setup
	@mkdir -p $(@D)
	$(call say,EMBED,$<)python3 api/embed_openapi.py $< $@
$(B)/server/resources/meta.o: $(B)/gen/openapi_json.h

# The page at / in the binary: its files, the modules of three.js it draws with, the examples.
VIEWER := $(wildcard server/viewer/*.html server/viewer/*.css server/viewer/*.js server/viewer/*.svg) \
          $(wildcard api/examples/*.json)
THREE := server/viewer/node_modules/three
THREE_FILES := $(THREE)/build/three.module.min.js $(THREE)/build/three.core.min.js \
               $(THREE)/examples/jsm/controls/OrbitControls.js $(THREE)/examples/jsm/curves/NURBSUtils.js
$(THREE)/package.json: server/viewer/package-lock.json | $(B)/.setup-page
	@npm ci --silent --no-audit --no-fund --ignore-scripts --prefix server/viewer && touch $@
$(B)/gen/viewer_files.h: server/viewer/embed.py $(VIEWER) $(THREE)/package.json
	@mkdir -p $(@D)
	$(call say,EMBED,server/viewer)python3 $< $(@D) $(VIEWER) $(THREE_FILES)
$(B)/server/resources/viewer.o: $(B)/gen/viewer_files.h

# What encodes results, as a part of their entity tags: other encoders may give other bytes.
ENCODERS := $(sort $(wildcard api/format/*.[ch] api/json/*.[ch] api/json/*.cc api/result/*.[ch]))
$(B)/gen/encoders_digest.h: $(ENCODERS) api/embed_powers.py
	@mkdir -p $(@D)
	@echo "#define ENCODERS_DIGEST \"$$(cat $^ | sha256sum | cut -c1-8)\"" >$@
$(B)/server/resources/results.o: $(B)/gen/encoders_digest.h

# What the structures of prepared forms look like and mean, as a part of their version: all of the
# solver and what decodes requests.
PREPARED := $(sort $(wildcard solver/*.[ch] solver/*/*.[ch] api/request/*.[ch]))
$(B)/gen/prepared_form_build.h: $(PREPARED)
	@mkdir -p $(@D)
	@echo "#define PREPARED_FORM_BUILD \"$(MACHINE) $$(cat $^ | sha256sum | cut -c1-16)\"" >$@
$(B)/api/request/prepared_form.o: $(B)/gen/prepared_form_build.h

# The library of fabrics.
MATERIALS := $(sort $(wildcard api/materials/*.json))
$(B)/gen/materials.h: api/embed_materials.py $(MATERIALS) | $(B)/.setup
	@mkdir -p $(@D)
	$(call say,EMBED,api/materials)python3 $< $@ $(MATERIALS)
$(B)/api/request/material.o: $(B)/gen/materials.h

# The powers of ten that the shortest decimals take.
$(B)/gen/powers.h: api/embed_powers.py | $(B)/.setup
	@mkdir -p $(@D)
	$(call say,EMBED,$<)python3 $< $@
$(B)/api/json/shortest.o: $(B)/gen/powers.h

$(B)/libdrape.a: $(SOLVER_OBJ)
$(B)/libdrapeapi.a: $(API_OBJ)
$(B)/libdrapeserver.a: $(SERVER_OBJ)
$(B)/%.a:
	@rm -f $@
	$(call say,AR,$@)ar rcs $@ $^

$(B)/draped: $(B)/server/main.o $(LIBS)
	$(call say,LINK,$@)$(LINK) -o $@ $^ $(SERVER_LIBS)
$(B)/drape: $(CLI_OBJ) $(API_ARCHIVES)
	$(call say,LINK,$@)$(LINK) -o $@ $^ $(API_LIBS)

# The library for programs of others. Its code can lie anywhere in memory and what is not in
# libdrape.map is seen by nobody; HDF5, for one format of maps, would bring 30 libraries into them,
# and of laminates it knows the courses of a study alone.
# It stays loaded: jansson calls it back.
SONAME := libdrape.so.1
PIC := $(patsubst $(B)/%,$(B)/pic/%,$(filter-out %/hdf5.o %/lcmsim_h5.o $(B)/api/laminate/%,$(SOLVER_OBJ) $(API_OBJ)) \
           $(call objects,library/library.c $(addprefix api/laminate/,courses.c course_limits.c normalise.c)))
PIC_FLAGS := -fPIC -fvisibility=hidden -DWITHOUT_HDF5
$(B)/pic/%.o: %.c Makefile | $(B)/.setup
	@mkdir -p $(@D)
	$(call say,CC,$< for $(SONAME))$(CC) $(CPPFLAGS) $(CFLAGS) $(PIC_FLAGS) $(DEPFLAGS) -c -o $@ $<
$(B)/pic/%.o: %.cc Makefile | $(B)/.setup
	@mkdir -p $(@D)
	$(call say,CXX,$< for $(SONAME))$(CXX) $(CPPFLAGS) $(CXXFLAGS) $(PIC_FLAGS) $(DEPFLAGS) -c -o $@ $<
$(PIC): | $(addprefix $(B)/gen/,prepared_form_build.h materials.h powers.h)
$(B)/$(SONAME): library/libdrape.map $(PIC)
	$(call say,LINK,$@)$(CC) -shared -Wl,-soname,$(SONAME) -Wl,--version-script=$< $(LDFLAGS) \
	    -Wl,-z,relro,-z,now,-z,noexecstack,-z,defs,-z,nodelete -o $@ $(PIC) \
	    -ljansson -lsodium -lexpat -lz -lstdc++ -lpthread -lm
$(B)/libdrape.so: $(B)/$(SONAME)
	@ln -sf $(SONAME) $@

# The importer of CAD files alone has Open CASCADE.
OCC_LIBS := -lTKXDESTEP -lTKXDEIGES -lTKSTEP -lTKSTEPBase -lTKIGES -lTKXSBase -lTKXCAF -lTKLCAF \
            -lTKCDF -lTKShHealing -lTKTopAlgo -lTKBRep -lTKGeomBase -lTKGeomAlgo -lTKG3d -lTKG2d \
            -lTKMath -lTKernel
$(B)/import/%.o: CXXFLAGS := $(filter-out -fno-exceptions -fno-rtti $(OPT),$(CXXFLAGS)) -O1 \
                                 -isystem /usr/include/opencascade
$(patsubst %.cc,$(B)/%.o,$(wildcard import/*.cc)): | $(B)/.setup-import
$(B)/drape-import: $(IMPORT_OBJ) $(LIBS)
	$(call say,LINK,$@)$(LINK) -o $@ $^ $(OCC_LIBS) -lseccomp $(API_LIBS)

library: $(B)/libdrape.so ## build/libdrape.so, the solver for programs in C and what calls C

# What npm makes: the package `draped` with its example, and the server for agents. What esbuild, Vite
# and resvg run is an optional package, one for each machine.
CLIENTS := clients/typescript clients/typescript/example clients/mcp
$(CLIENTS:%=%/node_modules): %/node_modules: %/package-lock.json | $(B)/.setup-page
	@npm ci --silent --no-audit --no-fund --ignore-scripts --prefix $* && touch $@
# One after the other: the others link to the package.
$(filter-out clients/typescript/node_modules,$(CLIENTS:%=%/node_modules)): | clients/typescript/node_modules
clients/typescript/dist/index.js: clients/typescript/node_modules api/openapi.yaml $(VIEWER) \
        $(wildcard clients/typescript/*.mjs clients/typescript/*.json) \
        $(filter-out %/schema.ts,$(wildcard clients/typescript/src/*.ts))
	$(call say,BUILD,clients/typescript)node clients/typescript/build.mjs
EXAMPLE := clients/typescript/example
$(EXAMPLE)/dist/index.html: clients/typescript/dist/index.js $(EXAMPLE)/node_modules \
        $(EXAMPLE)/index.html $(EXAMPLE)/main.ts
	@cd $(EXAMPLE) && node ../node_modules/typescript/bin/tsc -p . && npx vite build --logLevel error
clients/mcp/dist/index.js: clients/typescript/dist/index.js clients/mcp/node_modules \
        clients/mcp/tsconfig.json $(wildcard clients/mcp/src/*.ts)
	@node clients/mcp/node_modules/typescript/bin/tsc -p clients/mcp && touch $@
.PHONY: clients
clients: $(EXAMPLE)/dist/index.html clients/mcp/dist/index.js ## the npm package draped, its example, the server for agents

include tests/tests.mk

help: ## this list
	@awk -F ':.*## ' '/^[a-z-]+:.*## / {printf "%-16s%s\n", $$1, $$2}' $(MAKEFILE_LIST)

demo: ## builds, starts a daemon, drapes the examples and compares them with exact answers
	@$(MAKE) --no-print-directory -j$(JOBS) all
	@deploy/demo.sh $(B)

check: ## every day: build, checks of the source, unit tests, short exact ones, drapes over HTTP
	@$(MAKE) --no-print-directory -s .test-tools
	@$(MAKE) --no-print-directory -s -j$(JOBS) all tests
	@tests/run.py check $(B)

test: ## everything, as built and where that tells more with sanitizers (ONLY=: a pattern)
	@$(MAKE) --no-print-directory -s .test-tools
	@echo 'building $(B); $(B)/sanitized is built beside the first tests'
	@$(MAKE) --no-print-directory -s -j$(JOBS) .plain
	@tests/run.py all $(B) $(B)/sanitized $(ONLY)

lint: all .test-tools ## the checks of the source alone: format, layers, what the solver may call, documents
	@for check in tests/checks/*.sh; do echo $$check; $$check $(B) || exit 1; done

format: tests/browser/node_modules ## clang-format 14, prettier
	find solver api library cli import server tests -name node_modules -prune -o \
	    \( -name '*.[ch]' -o -name '*.cc' \) -print | xargs $(CLANG_FORMAT) -i
	node $</prettier/bin/prettier.cjs --log-level warn --write server/viewer/*.js tests/*/*.mjs \
	    $$(git ls-files 'clients/*.ts' 'clients/*.js' 'clients/*.mjs')

PREFIX ?= /usr/local
UNITS ?= $(PREFIX)/lib/systemd/system
VERSION := $(shell deploy/version.py)
OPERATORS := $(addprefix deploy/,nginx.conf Caddyfile prometheus grafana systemd kubernetes container \
             compose.yaml)
PAGES := fields formats handover laminates mathematics operations pieces runbook scaling settings shop \
         small-radii studies threat-model
install: all sbom $(B)/draped.1 $(B)/drape.1 ## below $(PREFIX) (/usr/local) and DESTDIR
	install -D -t $(DESTDIR)$(PREFIX)/bin $(B)/draped $(B)/drape
	install -D -m 644 -t $(DESTDIR)$(PREFIX)/share/man/man1 $(B)/draped.1 $(B)/drape.1
	install -D -m 644 -t $(DESTDIR)$(UNITS) deploy/systemd/draped.socket \
	    deploy/systemd/draped-backup.timer
	for unit in draped draped-backup; do \
	    sed 's|/usr/bin/|$(PREFIX)/bin/|' deploy/systemd/$$unit.service | \
	        install -m 644 /dev/stdin $(DESTDIR)$(UNITS)/$$unit.service; done
	install -D -m 644 -t $(DESTDIR)$(PREFIX)/share/doc/draped $(B)/draped.cdx.json
	cp -r $(OPERATORS) $(DESTDIR)$(PREFIX)/share/doc/draped
	for page in $(PAGES); do \
	    sed 's|](\.\./deploy/|](|g' docs/$$page.md | \
	        install -m 644 /dev/stdin $(DESTDIR)$(PREFIX)/share/doc/draped/$$page.md; done
	for figure in $$(grep -ohE '\]\(figures/[^)]+' $(PAGES:%=docs/%.md) | cut -c3- | sort -u); do \
	    install -D -m 644 docs/$$figure $(DESTDIR)$(PREFIX)/share/doc/draped/$$figure; done

# The importer of CAD files is a package of its own, for it brings Open CASCADE.
install-import: $(B)/drape-import $(B)/drape-import.1 ## drape-import, which reads STEP and IGES, likewise
	install -D -t $(DESTDIR)$(PREFIX)/bin $(B)/drape-import
	install -D -m 644 -t $(DESTDIR)$(PREFIX)/share/man/man1 $(B)/drape-import.1

LIBDIR ?= $(PREFIX)/lib
install-library: library ## libdrape.so, drape.h and drape.pc, likewise (LIBDIR: PREFIX/lib)
	install -D -m 644 -t $(DESTDIR)$(LIBDIR) $(B)/$(SONAME)
	ln -sf $(SONAME) $(DESTDIR)$(LIBDIR)/libdrape.so
	install -D -m 644 -t $(DESTDIR)$(PREFIX)/include library/drape.h
	mkdir -p $(DESTDIR)$(LIBDIR)/pkgconfig
	sed 's|@PREFIX@|$(PREFIX)|; s|@LIBDIR@|$(LIBDIR)|; s|@VERSION@|$(VERSION)|' library/drape.pc.in \
	    >$(DESTDIR)$(LIBDIR)/pkgconfig/drape.pc
	install -D -m 644 -t $(DESTDIR)$(PREFIX)/share/doc/libdrape-dev/examples library/examples/cloth.[cp]*

# Manual pages, their flags from --help.
$(B)/%.1: deploy/man/%.1.in deploy/man/options.awk $(B)/%
	awk -f deploy/man/options.awk <($(B)/$* --help) $< >$@

sbom: $(B)/draped.cdx.json ## the bill of materials, in build
$(B)/draped.cdx.json: deploy/sbom.py $(B)/draped $(B)/drape
	python3 $< $(VERSION) $(B)/draped $(B)/drape >$@.new && mv $@.new $@

deb: all library sbom $(B)/draped.1 $(B)/drape.1 $(B)/drape-import.1 ## the Debian packages, in build/deb
	@deploy/setup.sh package
	@deploy/deb.sh $(B) $(VERSION)

# docs/operations.md, Releases
release: ## source archive, packages, bill of materials and checksums, in build/release; built twice and compared
	@deploy/release.sh $(B) $(VERSION)

tag: ## dates the changelog's entry, commits, tags
	@deploy/version.py --release
	git commit -m 'release: $(VERSION)' CHANGELOG.md
	git tag -a -m 'draped $(VERSION)' v$(VERSION)

clean: ## removes the build
	rm -rf $(B)

-include $(shell find $(B) -name '*.d' 2>/dev/null)
