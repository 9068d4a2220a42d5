/* SPDX-License-Identifier: MIT */
#include "damped_step.h"

/* Of the greatest diagonal element: what is added to all of them, so that values on which hardly
 * anything depends stay. */
static const double least_diagonal = 1e-9;

static double element(const struct steer_slope *slope, int n, int m) {
    return slope->matrix[n < m ? n : m][n < m ? m : n];
}

/* x = -(L L^T)^-1 b for the free values alone, the others 0; false where the matrix is not positive
 * definite. */
static bool solve_free(double matrix[STEER_PARAMETERS][STEER_PARAMETERS], const double *b,
                       const bool *fixed, int count, double *x) {
    for (int n = 0; n < count; n++) {
        for (int m = 0; m <= n; m++) {
            double sum = matrix[n][m];
            for (int k = 0; k < m; k++)
                sum -= matrix[n][k] * matrix[m][k];
            if (n == m && !(sum > 0))
                return false;
            matrix[n][m] = n == m ? sqrt(sum) : sum / matrix[m][m];
        }
        x[n] = fixed[n] ? 0 : -b[n];
        for (int k = 0; k < n; k++)
            x[n] -= matrix[n][k] * x[k];
        x[n] /= matrix[n][n];
    }
    for (int n = count - 1; n >= 0; n--) {
        for (int k = n + 1; k < count; k++)
            x[n] -= matrix[k][n] * x[k];
        x[n] /= matrix[n][n];
    }
    return true;
}

double steer_damped_step(const struct steer_slope *slope, const double *value, double most,
                         double damping, double *step) {
    int count = slope->variation.parameters;
    double matrix[STEER_PARAMETERS][STEER_PARAMETERS], greatest = 0, fall = 0;
    bool fixed[STEER_PARAMETERS];
    for (int n = 0; n < count; n++) {
        greatest = fmax(greatest, slope->matrix[n][n]);
        fixed[n] = slope->gradient[n] < 0 ? value[n] >= most : value[n] <= -most;
    }
    for (int n = 0; n < count; n++) {
        for (int m = 0; m < n; m++)
            matrix[n][m] = fixed[n] || fixed[m] ? 0 : element(slope, n, m);
        matrix[n][n] =
            fixed[n] ? 1 : (1 + damping) * slope->matrix[n][n] + least_diagonal * greatest;
    }
    if (!(greatest > 0) || !solve_free(matrix, slope->gradient, fixed, count, step))
        return 0;
    for (int n = 0; n < count; n++)
        step[n] = fmin(fmax(value[n] + step[n], -most), most) - value[n];
    for (int n = 0; n < count; n++) {
        fall -= slope->gradient[n] * step[n];
        for (int m = 0; m < count; m++)
            fall -= step[n] * element(slope, n, m) * step[m] / 2;
    }
    return fmax(fall, 0);
}
