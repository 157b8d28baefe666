/* The benchmark bicycle: modes over speed.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "sheet.h"

#include "bicycle.h"

#include <mbsrank/linear.h>

enum { BICYCLE_MODES = 64 };

/* Modes at speed v, those of place and heading last of all left out. */
static int modes_at(const mbsr_model *m, mbsr_data *d, double v, mbsr_mode *mode)
{
    double q[BICYCLE_RATES], u[BICYCLE_RATES];
    mbsr_mode all[BICYCLE_MODES];
    mbsr_linear *l;
    mbsr_error error;
    int count, kept = 0;
    bicycle_ride(v, q, u);
    sheet_check(mbsr_linear_create(m, d, 0.0, q, u, NULL, &l, &error), &error);
    sheet_check(mbsr_linear_modes(l, all, &count), NULL);
    mbsr_linear_destroy(l);
    for (int k = 0; k < count; ++k)
        if (hypot(all[k].real, all[k].imaginary) > 1e-3) mode[kept++] = all[k];
    return kept;
}

/* Growth of the weave mode (imaginary part above 1) or of capsize (real, the slowest). */
static double growth(const mbsr_model *m, mbsr_data *d, double v, int weave)
{
    mbsr_mode mode[BICYCLE_MODES];
    const int count = modes_at(m, d, v, mode);
    double found = 1e9;
    for (int k = 0; k < count; ++k) {
        if ((mode[k].imaginary > 1.0) == weave && fabs(mode[k].real) < fabs(found))
            found = mode[k].real;
    }
    return found;
}

/* The speed at which it is zero, by inverse interpolation through speeds on both sides. */
static double speed_of_change(const mbsr_model *m, mbsr_data *d, double v0, int weave)
{
    enum { POINTS = 8 };
    double v[POINTS], g[POINTS], sum = 0.0;
    for (int k = 0; k < POINTS; ++k) {
        v[k] = v0 + 0.05 * (k - POINTS / 2 + 0.5);
        g[k] = growth(m, d, v[k], weave);
    }
    for (int k = 0; k < POINTS; ++k) {
        double term = v[k];
        for (int l = 0; l < POINTS; ++l)
            if (l != k) term *= g[l] / (g[l] - g[k]);
        sum += term;
    }
    return sum;
}

void sheet_bicycle(sheet *out)
{
    mbsr_model *m = bicycle_make();
    mbsr_data *d;
    mbsr_mode mode[BICYCLE_MODES];
    sheet_check(mbsr_data_create(m, &d, NULL), NULL);
    const int count = modes_at(m, d, 5.0, mode);
    sheet_problem(
        out, "Benchmark bicycle",
        "Modes when it rides upright, and the speeds between which it is stable. Meijaard, "
        "Papadopoulos, Ruina and Schwab, Proc. R. Soc. A 463, 2007, table 2.");
    sheet_add(out, "capsize at 5 m/s, 1/s", -0.32286642900409, mode[count - 3].real, 1e-10);
    sheet_add(out, "weave at 5 m/s, 1/s", -0.77534188219585, mode[count - 2].real, 1e-10);
    sheet_add(out, "weave at 5 m/s, rad/s", 4.46486771378823, mode[count - 2].imaginary, 1e-10);
    sheet_add(out, "castering at 5 m/s, 1/s", -14.07838969279822, mode[count - 1].real, 1e-10);
    sheet_add(out, "weave begins to die out, m/s", 4.29238253634111, speed_of_change(m, d, 4.3, 1),
              1e-6);
    sheet_add(out, "capsize begins to grow, m/s", 6.02426201538837, speed_of_change(m, d, 6.03, 0),
              1e-6);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}
