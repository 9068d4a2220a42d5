/* SPDX-License-Identifier: MIT */
/*
 * A worker engine that does what the request says, so that the dispatcher can be tested with real
 * processes that crash, hang and lie. The request is a word and perhaps a number:
 *
 *   echo             the result is the request
 *   pid              the result is the worker's process id, as text
 *   sleep MS         tells progress for so long, then echoes
 *   large BYTES      a result of so many bytes: byte k is engine_byte(k)
 *   crash            signal 11
 *   crash-used       crashes when this process has worked before, else echoes
 *   exit CODE        ends without a word
 *   hang             sleeps for ever without progress
 *   spin             works for ever without progress
 *   problem          fails with `start-off-surface`
 *   memory           asks for memory until there is none, then fails with `out-of-memory`
 *   headless         a result of which no summary can be told
 *   babble           sends a frame that no worker sends
 *   oversized        announces a frame beyond the limit
 *   inside           the result says what the process may do; see engine.c
 *   surface          the result is the surface's document
 *
 * A study is of ENGINE_ROUNDS rounds of ENGINE_TASKS tasks, of ENGINE_VARIANTS variants each. The
 * numbers of a task are its round, its number, and of each variant 1, or 0 if it was blamed; the
 * result are all numbers. The request says what the first task of the second round does besides:
 *
 *   well             nothing
 *   die K            crashes at variant K, unless it is blamed
 *   stall K          hangs there
 *   die-early        crashes before any variant
 *   fail             fails with `out-of-memory`
 *   slow MS          each task sleeps for so long
 */
#ifndef TESTS_ENGINE_H
#define TESTS_ENGINE_H

#include <stddef.h>

enum { ENGINE_ROUNDS = 3, ENGINE_TASKS = 4, ENGINE_VARIANTS = 5 };

unsigned char engine_byte(size_t k);

/* For main: when the arguments are those of a worker, serves and exits with its code. */
void engine_serve_if_worker(int argc, char **argv);

#endif
