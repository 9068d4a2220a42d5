/* SPDX-License-Identifier: MIT */
#include "lamina.h"

#include "angle.h"

int lamina_is_sound(const struct lamina *lamina) {
    return lamina->e1 > 0 && lamina->e2 > 0 && lamina->g12 > 0 &&
           lamina->nu12 * lamina->nu12 * lamina->e2 < lamina->e1;
}

/* Q turned by the angle: with c and s its cosine and sine, the stiffness of a rotated layer. */
void lamina_add(const struct lamina *lamina, double angle_deg, double share,
                double q[LAMINA_ENTRIES]) {
    double s, c, rest = 1 - lamina->nu12 * lamina->nu12 * lamina->e2 / lamina->e1;
    double q11 = lamina->e1 / rest, q22 = lamina->e2 / rest, q12 = lamina->nu12 * q22;
    double q66 = lamina->g12, both = q12 + 2 * q66;
    angle_sincos_deg(angle_deg, &s, &c);
    double c2 = c * c, s2 = s * s, one = q11 - both, two = both - q22;
    const double turned[LAMINA_ENTRIES] = {
        q11 * c2 * c2 + 2 * both * s2 * c2 + q22 * s2 * s2,
        (q11 + q22 - 4 * q66) * s2 * c2 + q12 * (s2 * s2 + c2 * c2),
        one * s * c * c2 + two * s2 * s * c,
        q11 * s2 * s2 + 2 * both * s2 * c2 + q22 * c2 * c2,
        one * s2 * s * c + two * s * c * c2,
        (q11 + q22 - 2 * q12 - 2 * q66) * s2 * c2 + q66 * (s2 * s2 + c2 * c2)};
    for (int k = 0; k < LAMINA_ENTRIES; k++)
        q[k] += share * turned[k];
}

struct lamina lamina_of(const double q[LAMINA_ENTRIES]) {
    double rest = q[0] * q[3] - q[1] * q[1];
    return (struct lamina){.e1 = rest / q[3], .e2 = rest / q[0], .nu12 = q[1] / q[3], .g12 = q[5]};
}

void lamina_stack(struct lamina_abd *abd, const double q[LAMINA_ENTRIES], double z0, double z1) {
    for (int k = 0; k < LAMINA_ENTRIES; k++) {
        abd->a[k] += q[k] * (z1 - z0);
        abd->b[k] += q[k] * (z1 * z1 - z0 * z0) / 2;
        abd->d[k] += q[k] * (z1 * z1 * z1 - z0 * z0 * z0) / 3;
    }
}
