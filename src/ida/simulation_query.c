/* Reading a simulation through functions.
 * SPDX-License-Identifier: BSD-3-Clause */
#include <mbsrank/simulation.h>

#include <math.h>

double mbsr_simulation_time(const mbsr_simulation *s)
{
    return s ? s->t : NAN;
}

const double *mbsr_simulation_q(const mbsr_simulation *s)
{
    return s ? s->q : NULL;
}

const double *mbsr_simulation_u(const mbsr_simulation *s)
{
    return s ? s->u : NULL;
}

mbsr_model *mbsr_simulation_model(const mbsr_simulation *s)
{
    return s ? s->model : NULL;
}

mbsr_data *mbsr_simulation_data(const mbsr_simulation *s)
{
    return s ? s->data : NULL;
}

mbsr_ida *mbsr_simulation_ida(const mbsr_simulation *s)
{
    return s ? s->ida : NULL;
}

int mbsr_simulation_status(const mbsr_simulation *s)
{
    return s ? s->status : MBSR_ERR_NULL;
}

const mbsr_error *mbsr_simulation_error(const mbsr_simulation *s)
{
    static const mbsr_error none = {MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE, "the simulation is NULL"};
    return s ? &s->error : &none;
}
