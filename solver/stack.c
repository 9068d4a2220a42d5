/* SPDX-License-Identifier: MIT */
#include "stack.h"

#include "power.h"
#include <math.h>

enum { STEPS = 60 }; /* Newton's method takes 4 to 7 */

static const double enough = 1e-15; /* of the thickness */

/* p^b for one ply after the other, of which many have the exponent of the one before. */
struct raised {
    double log_pressure, b, value;
};

static struct raised raised_begin(double log_pressure) {
    return (struct raised){.log_pressure = log_pressure, .value = 1};
}

static double raised_to(struct raised *last, double b) {
    if (b != last->b)
        *last = (struct raised){last->log_pressure, b, power_exp(b * last->log_pressure)};
    return last->value;
}

/* The ln p at which the plies with a law are as thick as `wanted` together, V / (a p^b) each. From
 * where the first of them alone would be, so that all are thicker than wanted: the greatest of
 * these. */
static double find_pressure(size_t count, const struct stack_ply *plies, double wanted) {
    double at = -HUGE_VAL;
    for (size_t k = 0; k < count; k++) {
        const struct stack_ply *ply = &plies[k];
        if (!(ply->a > 0))
            continue;
        double alone = ply->thickness * ply->fraction / (ply->a * wanted);
        at = fmax(at, power_log(alone) / ply->b);
    }
    for (int step = 0; step < STEPS; step++) {
        struct raised power = raised_begin(at);
        double sum = 0, slope = 0;
        for (size_t k = 0; k < count; k++) {
            const struct stack_ply *ply = &plies[k];
            if (!(ply->a > 0))
                continue;
            double volume = ply->thickness * ply->fraction;
            double own = volume / ply->a * raised_to(&power, -ply->b);
            sum += own;
            slope -= ply->b * own;
        }
        double excess = sum - wanted;
        if (!(excess > enough * wanted))
            break;
        at -= excess / slope;
    }
    return at;
}

double stack_press(const struct stack_cavity *cavity, size_t count, struct stack_ply *plies) {
    double all = 0, with_law = 0, log_pressure = 0;
    for (size_t k = 0; k < count; k++) {
        all += plies[k].thickness;
        with_law += plies[k].a > 0 ? plies[k].thickness : 0;
    }
    bool has_law = with_law > 0, height = cavity->kind == STACK_HEIGHT;
    if (count == 0 || cavity->kind == STACK_FLEXIBLE)
        return 0;
    double share = height ? cavity->height / all : 1;
    if (has_law)
        log_pressure =
            height ? find_pressure(count, plies, share * with_law) : power_log(cavity->pressure);
    struct raised power = raised_begin(log_pressure);
    for (size_t k = 0; k < count; k++) {
        struct stack_ply *ply = &plies[k];
        if (ply->a > 0) {
            double fraction = ply->a * raised_to(&power, ply->b);
            ply->thickness *= ply->fraction / fraction;
            ply->fraction = fraction;
        } else {
            ply->thickness *= share;
            ply->fraction /= share;
        }
    }
    return has_law ? power_exp(log_pressure) : 0;
}

/* K in the sum's frame: the matrix of the two axes, the principal tensor, and back. */
void stack_add(struct stack_sum *sum, double thickness, const struct permeability *k,
               const double along[2], const double across[2]) {
    double first[2], second[2];
    for (int n = 0; n < 2; n++) {
        first[n] = k->along * along[n] + k->across * across[n];
        second[n] = k->along * across[n] - k->across * along[n];
    }
    sum->thickness += thickness;
    sum->xx += thickness * (k->k1 * first[0] * first[0] + k->k2 * second[0] * second[0]);
    sum->xy += thickness * (k->k1 * first[0] * first[1] + k->k2 * second[0] * second[1]);
    sum->yy += thickness * (k->k1 * first[1] * first[1] + k->k2 * second[1] * second[1]);
    sum->resistance += thickness / k->k3;
}

struct permeability stack_permeability(const struct stack_sum *sum) {
    double t = sum->thickness;
    return permeability_principal(sum->xx / t, sum->xy / t, sum->yy / t, t / sum->resistance);
}
