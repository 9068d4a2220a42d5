/* SPDX-License-Identifier: MIT */
#include "wave.h"

#include "solver/wide.h"
#include <stddef.h>
#include <string.h>

_Static_assert(WAVE_NUMBERS == 29, "a station is its surface and as many numbers as a wave's");

void wave_put(struct wave_places *places, int slot, const struct station *station) {
    double of[WAVE_NUMBERS];
    struct wave_station numbers = {.jet = station->jet, .normal = station->normal};
    memcpy(numbers.uv, station->uv, sizeof numbers.uv);
    memcpy(numbers.first, station->first, sizeof numbers.first);
    memcpy(numbers.second, station->second, sizeof numbers.second);
    memcpy(of, &numbers, sizeof of);
    for (int n = 0; n < WAVE_NUMBERS; n++)
        places->of[n][slot] = of[n];
    places->surface[slot] = station->surface;
}

void wave_get(const struct wave_places *places, int slot, struct station *station) {
    double of[WAVE_NUMBERS];
    struct wave_station numbers;
    for (int n = 0; n < WAVE_NUMBERS; n++)
        of[n] = places->of[n][slot];
    memcpy(&numbers, of, sizeof numbers);
    station->surface = places->surface[slot];
    station->jet = numbers.jet;
    station->normal = numbers.normal;
    memcpy(station->uv, numbers.uv, sizeof numbers.uv);
    memcpy(station->first, numbers.first, sizeof numbers.first);
    memcpy(station->second, numbers.second, sizeof numbers.second);
}

void wave_get_forms(const struct wave_places *places, int slot, struct station *station) {
    enum {
        NORMAL = offsetof(struct wave_station, normal) / sizeof(double),
        FIRST = offsetof(struct wave_station, first) / sizeof(double),
        SECOND = offsetof(struct wave_station, second) / sizeof(double)
    };
    const double(*of)[WAVE_STRIDE] = places->of;
    station->surface = places->surface[slot];
    station->normal = vec3_make(of[NORMAL][slot], of[NORMAL + 1][slot], of[NORMAL + 2][slot]);
    for (int n = 0; n < 3; n++) {
        station->first[n] = of[FIRST + n][slot];
        station->second[n] = of[SECOND + n][slot];
    }
    for (int n = 0; n < 2; n++)
        station->uv[n] = of[n][slot];
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
