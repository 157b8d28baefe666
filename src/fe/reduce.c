/* Reduction of a model: mbsr_fe_reduce.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "fe/data.h"
#include "base/error.h"
#include "fe/report.h"

#include <math.h>

enum { COOKIE = 0x6d626665 };

mbsr_fe_def mbsr_default_fe_def(void)
{
    return (mbsr_fe_def){
        .cookie = COOKIE, .modes = 10, .frequency = INFINITY, .rigid = 1e-8, .tolerance = 1e-10};
}

#define REFUSE(...) mbsri_fail_plain(error, MBSR_ERR_VALUE, "mbsr_fe_reduce: " __VA_ARGS__)
#define REFUSE_NULL(...) mbsri_fail_plain(error, MBSR_ERR_NULL, "mbsr_fe_reduce: " __VA_ARGS__)

static int check_limits(const mbsr_fe_def *def, mbsr_error *error)
{
    if (!(def->frequency >= 0.0) || !(def->cutoff >= 0.0))
        return REFUSE("frequency is %g, cutoff %g; neither may be negative", def->frequency,
                      def->cutoff);
    if (!(def->damping >= 0.0) || !isfinite(def->damping))
        return REFUSE("damping is %g, must be finite and not negative", def->damping);
    if (!(def->rigid >= 0.0) || !(def->rigid <= 1e-2))
        return REFUSE("rigid is %g, must be 0 .. 0.01", def->rigid);
    if (!(def->tolerance >= 1e-14) || !(def->tolerance <= 1e-2))
        return REFUSE("tolerance is %g, must be 1e-14 .. 0.01", def->tolerance);
    if (def->solver < MBSR_FE_AUTO || def->solver > MBSR_FE_SPARSE)
        return REFUSE("solver is %d, none of mbsr_fe_solver", (int)def->solver);
    if (!def->allocator.allocate != !def->allocator.release)
        return REFUSE("allocator has one of its two functions only");
    return MBSR_OK;
}

static int check_reduction(const mbsr_fe_def *def, mbsr_error *error)
{
    if (def->cookie != COOKIE)
        return mbsri_fail_plain(error, MBSR_ERR_NO_DEFAULT,
                                "mbsr_fe_reduce: def was not made by mbsr_default_fe_def");
    if (def->nodes < 1 || def->markers < 1)
        return REFUSE("nodes is %d, markers %d; there must be one of each", def->nodes,
                      def->markers);
    if (!def->x || !def->marker) return REFUSE_NULL("%s is NULL", !def->x ? "x" : "marker");
    if (!def->dof_node != !def->dof_direction)
        return REFUSE_NULL("one of dof_node and dof_direction is NULL");
    int loads = 0;
    for (int k = 1; k < def->markers; ++k)
        loads += def->marker[k].loaded && loads <= MBSR_MAX_MODES;
    if (def->modes < 0 || def->modes > MBSR_MAX_MODES || def->modes + 6 * loads > MBSR_MAX_MODES)
        return REFUSE(
            "modes is %d, %d markers are loaded; six modes for each of them and modes may "
            "be at most %d together",
            def->modes, loads, MBSR_MAX_MODES);
    return check_limits(def, error);
}

static int find_basis(mbsri_fe_statics *s, mbsri_fe_modes *modes, mbsri_fe_basis *basis)
{
    const mbsri_fe_body *body = s->body;
    if (body->def->free && !s->relief && body->def->modes > 0)
        return MBSRI_FE_REFUSE(
            "the body has no mass or no inertia about some axis, so that it has no "
            "normal modes when free; def.free is 1");
    int status = mbsri_fe_tell(body, "normal modes", 0.0);
    if (!status) status = mbsri_fe_find_modes(s, body->def->free ? s->relief : s->C, modes);
    return status ? status : mbsri_fe_make_basis(s, modes, basis);
}

static int reduce_body(mbsri_fe_body *body, mbsri_fe_statics *s, mbsr_flex **flex,
                       mbsr_fe_report **report)
{
    mbsri_fe_mass mass;
    mbsri_fe_modes modes;
    mbsri_fe_basis basis;
    int status = mbsri_fe_tell(body, "checks", 0.0);
    if (!status) status = mbsri_fe_body_make(body);
    if (status) return status;
    status = mbsri_fe_tell(body, "factorisation", 0.0);
    const int columns = MBSRI_FE_BLOCK > body->def->modes ? MBSRI_FE_BLOCK : body->def->modes;
    if (!status) status = mbsri_fe_statics_make(body, columns, s);
    if (!status) status = mbsri_fe_mass_make(body, s->solver, &mass);
    if (!status) status = find_basis(s, &modes, &basis);
    if (!status) status = mbsri_fe_tell(body, "integrals", 0.0);
    if (status) return status;
    const size_t size = 6 + (size_t)basis.count;
    double *B = mbsri_arena_take(body->arena, size * size * sizeof *B);
    if (!B)
        return mbsri_fail_plain(body->error, MBSR_ERR_NO_MEMORY,
                                "mbsr_fe_reduce: no memory for %d "
                                "modes",
                                basis.count);
    status = mbsri_fe_make_data(body, &mass, &basis, flex, B);
    if (!status && report) status = mbsri_fe_make_report(s, &modes, &basis, *flex, B, report);
    return status;
}

int mbsr_fe_reduce(const mbsr_fe_def *def, mbsr_flex **flex, mbsr_fe_report **report,
                   mbsr_error *error)
{
    if (flex) *flex = NULL;
    if (report) *report = NULL;
    if (!def || !flex)
        return mbsri_fail_plain(error, MBSR_ERR_NULL, "mbsr_fe_reduce: %s is NULL",
                                !def ? "def" : "flex");
    int status = check_reduction(def, error);
    if (status) return status;
    mbsri_arena arena;
    mbsri_arena_open(&arena, &def->allocator);
    mbsri_fe_body body = {.def = def, .arena = &arena, .error = error};
    mbsri_fe_statics statics = {.factor = NULL};
    status = reduce_body(&body, &statics, flex, report);
    mbsri_factor_destroy(statics.factor);
    mbsri_arena_close(&arena);
    if (status) {
        mbsr_flex_destroy(*flex);
        *flex = NULL;
    }
    if (status && error && error->status != status)
        (void)mbsri_fail_plain(error, status, "mbsr_fe_reduce: stopped by def.progress");
    return status;
}
