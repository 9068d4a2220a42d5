/* SPDX-License-Identifier: MIT */
/* PNG (ISO/IEC 15948) of pixels that are numbers of at most 256 colours. */
#ifndef API_FORMAT_PNG_H
#define API_FORMAT_PNG_H

#include "raster.h"
#include <stddef.h>
#include <stdint.h>

/* The file, malloc'ed, and its length; NULL without memory. */
uint8_t *png_encode(const struct raster *raster, size_t *length);

#endif
