/* Definitions of force elements, and what the stock ones share.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "forces/stock.h"

#include "base/cookie.h"

#include <limits.h>

mbsr_force_def mbsr_default_force_def(void)
{
    return (mbsr_force_def){.cookie = MBSRI_COOKIE, .body = {MBSR_NONE, MBSR_NONE}};
}

mbsr_force_def mbsr_force_custom(const mbsr_force_table *table, int count, const int *bodies,
                                 void *user)
{
    mbsr_force_def def = mbsr_default_force_def();
    def.table = table;
    def.bodies = count;
    def.body_list = bodies;
    def.user = user;
    return def;
}

mbsr_force_def mbsri_stock_force(const mbsr_force_table *table, int bodies, int a, int b)
{
    mbsr_force_def def = mbsr_default_force_def();
    def.table = table;
    def.bodies = bodies;
    def.body[0] = a;
    def.body[1] = b;
    return def;
}

int mbsri_refuse(char text[MBSR_TEXT_SIZE], int status, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    mbsri_vprint(text, MBSR_TEXT_SIZE, format, arguments);
    va_end(arguments);
    return status;
}

int mbsri_refuse_parameter(char text[MBSR_TEXT_SIZE], const mbsr_force_args *args, int k,
                           const char *wrong)
{
    return mbsri_refuse(text, MBSR_ERR_VALUE, "param[%d]%s is %g, %s", k,
                        args->force->table->parameter(k), args->force->param[k], wrong);
}

int mbsri_check_not_negative(const mbsr_force_args *args, int first, int count,
                             char text[MBSR_TEXT_SIZE])
{
    for (int k = first; k < first + count; ++k) {
        if (args->force->param[k] < 0.0) return mbsri_refuse_parameter(text, args, k, "negative");
    }
    return MBSR_OK;
}

int mbsri_check_friction(const mbsr_force_args *args, int force, int slip,
                         char text[MBSR_TEXT_SIZE])
{
    const int status = mbsri_check_not_negative(args, force, 1, text);
    if (status || args->force->param[slip] > 0.0) return status;
    return mbsri_refuse_parameter(text, args, slip, "not positive");
}

/* Stands in the last option. */
enum { GIVEN_NULL = INT_MIN };

mbsr_force_def mbsri_given_null(mbsr_force_def def)
{
    def.option[MBSR_FORCE_OPTIONS - 1] = GIVEN_NULL;
    return def;
}

int mbsri_check_shape(const mbsr_force_def *def, int bodies, int first_unused,
                      char text[MBSR_TEXT_SIZE])
{
    if (def->bodies != bodies)
        return mbsri_refuse(text, MBSR_ERR_VALUE, "bodies is %d, must be %d", def->bodies, bodies);
    if (def->option[MBSR_FORCE_OPTIONS - 1] == GIVEN_NULL)
        return mbsri_refuse(text, MBSR_ERR_NULL, "the law or contact it is made from is NULL");
    for (int k = first_unused; k < MBSR_FORCE_OPTIONS; ++k) {
        if (def->option[k] != 0) {
            return mbsri_refuse(text, MBSR_ERR_VALUE, "option[%d] is %d, must be 0", k,
                                def->option[k]);
        }
    }
    return MBSR_OK;
}

int mbsri_check_ends(const mbsr_force_args *args, char text[MBSR_TEXT_SIZE])
{
    if (args->body[0].id != args->body[1].id) return MBSR_OK;
    return mbsri_refuse(text, MBSR_ERR_ID, "both ends are on body %d", args->body[0].id);
}

int mbsri_no_slopes(const mbsr_force_args *args, const mbsr_force_derivatives *out)
{
    (void)args;
    (void)out;
    return MBSR_OK;
}
