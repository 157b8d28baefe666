/* Multibody problems of the Test Set for IVP Solvers.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "sheet.h"

#include "car_axis.h"
#include "squeezer.h"

static void squeeze(sheet *out)
{
    static const char *const name[SQUEEZER_BODIES] = {"β, rad", "Θ, rad", "γ, rad", "δ, rad",
                                                      "ε, rad", "Φ, rad", "Ω, rad"};
    static const int order[SQUEEZER_BODIES] = {0, 1, 2, 3, 5, 4, 6}; /* of the names, by bodies */
    mbsr_simulation s = mbsr_simulation_begin(NULL);
    squeezer_add(s.model);
    sheet_start(&s, 1e-10, squeezer_start, NULL);
    sheet_run(&s, 0.03);
    sheet_problem(
        out, "Andrews' squeezer at 0.03 s",
        "Seven bodies, three loops. Test Set for IVP Solvers, problem *Andrews' squeezing "
        "mechanism*; also benchmark A03 of IFToMM.");
    for (int k = 0; k < SQUEEZER_BODIES; ++k)
        sheet_add(out, name[order[k]], squeezer_end[k], s.q[k], 1e-7);
    mbsr_simulation_end(&s);
}

static void drive(sheet *out)
{
    static const double theirs[8] = {
        .0493455784275402809,  .496989460230171154,   1.04174252488542152,  .373911027265361257,
        -.0770583684040972358, .00744686658723778553, .0175568157537232222, .770341043779251976};
    static const char *const name[8] = {"x of the left wheel, m",     "y of the left wheel, m",
                                        "x of the right wheel, m",    "y of the right wheel, m",
                                        "x′ of the left wheel, m/s",  "y′ of the left wheel, m/s",
                                        "x′ of the right wheel, m/s", "y′ of the right wheel, m/s"};
    const double q[2] = {0.5, 0.0}, u[2] = {0.0, 0.0};
    const telling absolute = {0, 0};
    double psi, rate, acceleration;
    mbsr_simulation s = mbsr_simulation_of(car_axis(0.01, &absolute));
    sheet_start(&s, 1e-12, q, u);
    sheet_run(&s, 3.0);
    ground_angle(NULL, s.t, &psi, &rate, &acceleration);
    const double along = s.q[0], phi = s.q[1];
    double w[8] = {-along * sin(psi), along * cos(psi)};
    w[2] = w[0] + L * cos(phi), w[3] = w[1] + L * sin(phi);
    w[4] = -s.u[0] * sin(psi) - along * rate * cos(psi);
    w[5] = s.u[0] * cos(psi) - along * rate * sin(psi);
    w[6] = w[4] - L * s.u[1] * sin(phi), w[7] = w[5] + L * s.u[1] * cos(phi);
    sheet_problem(
        out, "Car axis at 3 s",
        "Masses of 5·10⁻⁴ on springs over a bumpy road. Test Set for IVP Solvers, problem "
        "*Car axis*, ε = 0.01.");
    for (int k = 0; k < 8; ++k) sheet_add(out, name[k], theirs[k], w[k], 1e-7);
    mbsr_simulation_end(&s);
}

void sheet_ivp(sheet *out)
{
    squeeze(out);
    drive(out);
}
