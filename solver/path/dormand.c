/* SPDX-License-Identifier: MIT */
#include "dormand.h"

#include "solver/wide.h"

/* Hairer, Norsett, Wanner: Solving Ordinary Differential Equations I, 2nd edition, section II.10,
 * the coefficients of DOP853; row i gives stage i + 1 from those before it. */
static const double stages[DORMAND_STAGES - 1][DORMAND_STAGES - 1] = {
    {0.05260015195876773},
    {0.0197250569845379, 0.0591751709536137},
    {0.02958758547680685, 0, 0.08876275643042054},
    {0.2413651341592667, 0, -0.8845494793282861, 0.924834003261792},
    {0.037037037037037035, 0, 0, 0.17082860872947386, 0.12546768756682242},
    {0.037109375, 0, 0, 0.17025221101954405, 0.06021653898045596, -0.017578125},
    {0.03709200011850479, 0, 0, 0.17038392571223998, 0.10726203044637328, -0.015319437748624402,
     0.008273789163814023},
    {0.6241109587160757, 0, 0, -3.3608926294469414, -0.868219346841726, 27.59209969944671,
     20.154067550477894, -43.48988418106996},
    {0.47766253643826434, 0, 0, -2.4881146199716677, -0.590290826836843, 21.230051448181193,
     15.279233632882423, -33.28821096898486, -0.020331201708508627},
    {-0.9371424300859873, 0, 0, 5.186372428844064, 1.0914373489967295, -8.149787010746927,
     -18.52006565999696, 22.739487099350505, 2.4936055526796523, -3.0467644718982196},
    {2.273310147516538, 0, 0, -10.53449546673725, -2.0008720582248625, -17.9589318631188,
     27.94888452941996, -2.8589982771350235, -8.87285693353063, 12.360567175794303,
     0.6433927460157636},
};
/* The share of the step at which stages 1, 2, .. are. */
static const double places[DORMAND_STAGES - 1] = {0.05260015195876773,
                                                  0.0789002279381516,
                                                  0.1183503419072274,
                                                  0.2816496580927726,
                                                  1.0 / 3,
                                                  0.25,
                                                  4.0 / 13,
                                                  127.0 / 195,
                                                  0.6,
                                                  6.0 / 7,
                                                  1};
static const double weights[DORMAND_STAGES] = {0.054293734116568765,
                                               0,
                                               0,
                                               0,
                                               0,
                                               4.450312892752409,
                                               1.8915178993145003,
                                               -5.801203960010585,
                                               0.3111643669578199,
                                               -0.1521609496625161,
                                               0.20136540080403034,
                                               0.04471061572777259};

/* The solution less one of order 5, and less one of order 3. */
static const double fifth[DORMAND_STAGES] = {0.01312004499419488,
                                             0,
                                             0,
                                             0,
                                             0,
                                             -1.2251564463762044,
                                             -0.4957589496572502,
                                             1.6643771824549864,
                                             -0.35032884874997366,
                                             0.3341791187130175,
                                             0.08192320648511571,
                                             -0.022355307863886294};
static const double third[DORMAND_STAGES] = {-0.18980075407240762,
                                             0,
                                             0,
                                             0,
                                             0,
                                             4.450312892752409,
                                             1.8915178993145003,
                                             -5.801203960010585,
                                             -0.42268232132379197,
                                             -0.1521609496625161,
                                             0.20136540080403034,
                                             0.022651792198360825};

/* J. R. Cash, A. H. Karp, A variable order Runge-Kutta method for initial value problems with
 * rapidly varying right-hand sides, ACM Transactions on Mathematical Software 16, 1990: the same of
 * order 5, and the solution less one of order 4. */
enum { ROUGH_STAGES = 6 };
static const double rough_stages[ROUGH_STAGES - 1][ROUGH_STAGES - 1] = {
    {1.0 / 5},
    {3.0 / 40, 9.0 / 40},
    {3.0 / 10, -9.0 / 10, 6.0 / 5},
    {-11.0 / 54, 5.0 / 2, -70.0 / 27, 35.0 / 27},
    {1631.0 / 55296, 175.0 / 512, 575.0 / 13824, 44275.0 / 110592, 253.0 / 4096},
};
static const double rough_places[ROUGH_STAGES - 1] = {1.0 / 5, 3.0 / 10, 3.0 / 5, 1, 7.0 / 8};
static const double rough_weights[ROUGH_STAGES] = {37.0 / 378,  0, 250.0 / 621,
                                                   125.0 / 594, 0, 512.0 / 1771};
static const double fourth[ROUGH_STAGES] = {37.0 / 378 - 2825.0 / 27648,
                                            0,
                                            250.0 / 621 - 18575.0 / 48384,
                                            125.0 / 594 - 13525.0 / 55296,
                                            -277.0 / 14336,
                                            512.0 / 1771 - 1.0 / 4};

/* Unrolled, the zeros above cost nothing. */
#define UNROLL _Pragma("GCC unroll 12")

/* y + h sum_k a_k slope_k */
INLINE vec4 combine(const double *a, int count, const vec4 *slope, vec4 y, double h) {
    vec4 sum = a[0] * slope[0];
    UNROLL for (int k = 1; k < count; k++) if (a[k] != 0) sum += a[k] * slope[k];
    return y + h * sum;
}

INLINE void end_step(const vec4 *slope, const struct dormand_task *task) {
    const vec4 zero = {0};
    task->error->fifth = combine(fifth, DORMAND_STAGES, slope, zero, task->h);
    task->error->third = combine(third, DORMAND_STAGES, slope, zero, task->h);
    *task->to = combine(weights, DORMAND_STAGES, slope, task->from[0], task->h);
}

WIDE_CLONES
void dormand_step(dormand_slope *slope_at, const void *context, double h, const vec4 *from,
                  vec4 *to, struct dormand_error *error) {
    const struct dormand_task task = {context, h, from, to, error};
    vec4 slope[DORMAND_STAGES] = {from[1]};
    UNROLL for (int k = 1; k < DORMAND_STAGES; k++) {
        vec4 y = combine(stages[k - 1], k, slope, from[0], h);
        slope_at(context, places[k - 1] * h, &y, &slope[k]);
    }
    end_step(slope, &task);
}

WIDE_CLONES
void dormand_two_steps(dormand_slope *slope_at, const struct dormand_task task[2]) {
    vec4 slope[2][DORMAND_STAGES] = {{task[0].from[1]}, {task[1].from[1]}};
    UNROLL for (int k = 1; k < DORMAND_STAGES; k++) {
        vec4 y[2];
        for (int n = 0; n < 2; n++)
            y[n] = combine(stages[k - 1], k, slope[n], task[n].from[0], task[n].h);
        for (int n = 0; n < 2; n++)
            slope_at(task[n].context, places[k - 1] * task[n].h, &y[n], &slope[n][k]);
    }
    for (int n = 0; n < 2; n++)
        end_step(slope[n], &task[n]);
}

WIDE_CLONES
void dormand_rough_step(dormand_slope *slope_at, const void *context, double h, const vec4 *from,
                        vec4 *to, struct dormand_error *error) {
    const vec4 zero = {0};
    vec4 slope[ROUGH_STAGES] = {from[1]};
    UNROLL for (int k = 1; k < ROUGH_STAGES; k++) {
        vec4 y = combine(rough_stages[k - 1], k, slope, from[0], h);
        slope_at(context, rough_places[k - 1] * h, &y, &slope[k]);
    }
    *error = (struct dormand_error){combine(fourth, ROUGH_STAGES, slope, zero, h), zero};
    *to = combine(rough_weights, ROUGH_STAGES, slope, from[0], h);
}
