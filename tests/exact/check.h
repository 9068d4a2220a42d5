/* SPDX-License-Identifier: MIT */
/* cmocka with what it wants included before it. */
#ifndef DRAPE_TESTS_CHECK_H
#define DRAPE_TESTS_CHECK_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#endif
