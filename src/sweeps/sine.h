/* Sine and cosine of several numbers side by side; a file that includes this says what `lanes`,
 * `lane_bits` and splat() are (lane.h, wide.h).
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Reduction by pi/2 in three parts, exact for |x| < 1e5, then the minimax polynomials of fdlibm. */
#ifndef MBSRI_SINE_H
#define MBSRI_SINE_H

enum { MBSRI_REDUCED = 100000 };

MBSRI_INLINE void sine_cosine(lanes x, lanes *s, lanes *c)
{
    const lanes magic = splat(6755399441055744.0); /* 1.5 2^52: adding it rounds to an integer */
    const lanes shifted = x * splat(0.63661977236758134308) + magic, n = shifted - magic;
    const lane_bits quadrant = (lane_bits)shifted;
    const lanes r =
        ((x - n * splat(1.57079632673412561417e+00)) - n * splat(6.07710050630396597660e-11)) -
        n * splat(2.02226624879595063154e-21);
    const lanes z = r * r;
    const lanes s_tail =
        splat(8.33333333332248946124e-03) +
        z * (splat(-1.98412698298579493134e-04) +
             z * (splat(2.75573137070700676789e-06) + z * (splat(-2.50507602534068634195e-08) +
                                                           z * splat(1.58969099521155010221e-10))));
    const lanes c_tail = splat(4.16666666666666019037e-02) +
                         z * (splat(-1.38888888888741095749e-03) +
                              z * (splat(2.48015872894767294178e-05) +
                                   z * (splat(-2.75573143513906633035e-07) +
                                        z * (splat(2.08757232129817482790e-09) +
                                             z * splat(-1.13596475577881948265e-11)))));
    const lanes sine = r + r * z * (splat(-1.66666666666666324348e-01) + z * s_tail);
    const lanes cosine = (splat(1.0) - splat(0.5) * z) + z * z * c_tail;
    /* quadrants 1 and 3 swap them; 2, 3 and 1, 2 change signs */
    const lane_bits swap = (quadrant & 1) != 0;
    const lane_bits as = (swap & (lane_bits)cosine) | (~swap & (lane_bits)sine),
                    ac = (swap & (lane_bits)sine) | (~swap & (lane_bits)cosine);
    *s = (lanes)(as ^ ((quadrant & 2) << 62));
    *c = (lanes)(ac ^ (((quadrant + 1) & 2) << 62));
}

#endif
