# SPDX-License-Identifier: MIT
# all, demo, test, bench, lint, format, install. See README.md.
.DEFAULT_GOAL := all
SHELL := /bin/bash
B ?= build
CC := gcc
CXX := g++
OPT ?= -O2
SANITIZE ?=
WARN := -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wsign-conversion -Wstrict-prototypes \
        -Wmissing-prototypes -Wvla -Wformat=2 -Wcast-qual -Wundef -Wdouble-promotion -Werror
# No contraction: the same bits on every machine. Four-lane vectors are passed between static
# functions only, so the ABI note about them does not matter.
NUMERIC := -ffp-contract=off -Wno-psabi
CPPFLAGS := -D_GNU_SOURCE -I$(B)/gen
CFLAGS := -std=gnu11 $(OPT) -g $(NUMERIC) $(WARN) $(SANITIZE)
CXXFLAGS := -std=c++17 $(OPT) -g -fno-exceptions -fno-rtti -Wall -Wextra -Wpedantic -Wshadow \
            -Wconversion -Werror $(SANITIZE)
DEPFLAGS = -MMD -MP
LDFLAGS := $(SANITIZE)

SOLVER_OBJ := $(patsubst %.c,$(B)/%.o,$(wildcard solver/*.c))
API_OBJ := $(patsubst %.c,$(B)/%.o,$(filter-out api/main.c,$(wildcard api/*.c))) \
           $(patsubst %.cc,$(B)/%.o,$(wildcard api/*.cc))
SERVER_OBJ := $(patsubst %.c,$(B)/%.o,$(filter-out server/main.c,$(wildcard server/*.c)))
API_LIBS := -ljansson -lsodium -lstdc++ -lpthread -lm
SERVER_LIBS := -lmicrohttpd -lsqlite3 $(API_LIBS)

$(B)/%.o: %.c
	@mkdir -p $(@D)
	$(CC) $(CPPFLAGS) $(CFLAGS) $(DEPFLAGS) -c -o $@ $<
$(B)/%.o: %.cc
	@mkdir -p $(@D)
	$(CXX) $(CPPFLAGS) $(CXXFLAGS) $(DEPFLAGS) -c -o $@ $<

$(B)/libdrape.a: $(SOLVER_OBJ)
	@rm -f $@
	ar rcs $@ $^
$(B)/libdrapeapi.a: $(API_OBJ)
	@rm -f $@
	ar rcs $@ $^

-include $(shell find $(B) -name '*.d' 2>/dev/null)
