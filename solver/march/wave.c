/* SPDX-License-Identifier: MIT */
#include "wave.h"

#include "solver/wide.h"
#include <stddef.h>
#include <string.h>

_Static_assert(WAVE_NUMBERS == 29, "a point is its surface and as many numbers as a wave's");

/* A point's numbers lie in it one behind the other, as in `struct wave_point`. */
#define SAME_PLACE(member)                                                                         \
    _Static_assert(offsetof(struct surface_point, member) - offsetof(struct surface_point, uv) ==  \
                       offsetof(struct wave_point, member),                                        \
                   "a point's numbers are a wave's")
SAME_PLACE(jet);
SAME_PLACE(normal);
SAME_PLACE(first);
SAME_PLACE(second);
_Static_assert(sizeof(struct surface_jet) == 18 * sizeof(double), "a jet has no gaps");

enum { NUMBERS_AT = offsetof(struct surface_point, uv) };

void wave_put(struct wave_places *places, int slot, const struct surface_point *point) {
    const char *from = (const char *)point + NUMBERS_AT;
    _Pragma("GCC unroll 29") for (int n = 0; n < WAVE_NUMBERS; n++)
        memcpy(&places->of[n][slot], from + (size_t)n * sizeof(double), sizeof(double));
    places->surface[slot] = point->surface;
}

void wave_get(const struct wave_places *places, int slot, struct surface_point *point) {
    char *to = (char *)point + NUMBERS_AT;
    _Pragma("GCC unroll 29") for (int n = 0; n < WAVE_NUMBERS; n++)
        memcpy(to + (size_t)n * sizeof(double), &places->of[n][slot], sizeof(double));
    point->surface = places->surface[slot];
}

void wave_get_forms(const struct wave_places *places, int slot, struct surface_point *point) {
    enum {
        NORMAL = offsetof(struct wave_point, normal) / sizeof(double),
        FIRST = offsetof(struct wave_point, first) / sizeof(double),
        SECOND = offsetof(struct wave_point, second) / sizeof(double)
    };
    const double(*of)[WAVE_STRIDE] = places->of;
    point->surface = places->surface[slot];
    point->normal = vec3_make(of[NORMAL][slot], of[NORMAL + 1][slot], of[NORMAL + 2][slot]);
    for (int n = 0; n < 3; n++) {
        point->first[n] = of[FIRST + n][slot];
        point->second[n] = of[SECOND + n][slot];
    }
    for (int n = 0; n < 2; n++)
        point->uv[n] = of[n][slot];
}

const struct wave_kernel *wave_kernel_for(int lanes) {
    int most = lanes ? lanes : WAVE_LANES;
#if WIDE_FILES
    if (most >= 8 && wide_has(8))
        return &wave_kernel_8;
    if (most >= 4 && wide_has(4))
        return &wave_kernel_4;
#endif
    return most >= 2 ? &wave_kernel_2 : NULL;
}
