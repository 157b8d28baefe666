/* Messages of an instance, and what it may be asked: see instance.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "fmu/instance.h"

#include <math.h>
#include <string.h>

/* ---- messages ---- */

/* In the messages of the standard # begins a value reference, and ## is #. */
static void send(mbsri_instance *in, mbsri_result result, const char *format, va_list arguments)
{
    static const char *const categories[] = {"logEvents", "logStatusWarning", "logStatusDiscard",
                                             "logStatusError", "logStatusError"};
    char text[768], escaped[2 * sizeof text];
    const unsigned bit = 1u << (result > MBSRI_ERROR ? MBSRI_ERROR : result);
    if (!in->importer.logger || (!(in->importer.log & bit) && result < MBSRI_ERROR)) return;
    mbsri_vprint(text, sizeof text, format, arguments);
    char *to = escaped;
    for (const char *from = text; *from; ++from) {
        if (*from == '#') *to++ = '#';
        *to++ = *from;
    }
    *to = '\0';
    in->importer.logger(in, result, categories[result], escaped);
}

void mbsri_tell(mbsri_instance *in, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    send(in, MBSRI_OK, format, arguments);
    va_end(arguments);
}

mbsri_result mbsri_say(mbsri_instance *in, mbsri_result result, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    send(in, result, format, arguments);
    va_end(arguments);
    if (result >= MBSRI_ERROR) in->mode = MBSRI_TERMINATED;
    return result;
}

mbsri_result mbsri_failed(mbsri_instance *in, const char *what, int status, const mbsr_error *of)
{
    return mbsri_say(in, MBSRI_ERROR, "%s at t = %.9g: %s (%s)", what, in->t,
                     of && of->text[0] ? of->text : mbsr_status_text(status),
                     mbsr_status_name(status));
}

bool mbsri_update(mbsri_instance *in, double t, double *t_end)
{
    bool early = false;
    double wanted = t;
    in->t = t;
    in->evaluated = false;
    in->importer.intermediate(in, t, &early, &wanted);
    if (early && wanted > t) *t_end = fmin(wanted, *t_end);
    return in->mode != MBSRI_TERMINATED && !(early && wanted <= t);
}

mbsri_instance *mbsri_entered(void *c, int exchange, unsigned modes, const char *function)
{
    static const char *const names[] = {"instantiated",
                                        "in initialization mode",
                                        "in event mode",
                                        "in continuous-time mode",
                                        "in step mode",
                                        "terminated",
                                        "in intermediate update mode"};
    mbsri_instance *in = c;
    int k = 0;
    if (!in) return NULL;
    if (!((unsigned)in->mode & modes)) {
        while (k < 6 && (unsigned)in->mode != 1u << k) ++k;
        mbsri_say(in, MBSRI_ERROR, "%s: must not be called while the instance is %s", function,
                  names[k]);
        return NULL;
    }
    if (exchange == MBSRI_EITHER || in->exchange == exchange) return in;
    mbsri_say(in, MBSRI_ERROR, "%s: the instance is of %s", function,
              in->exchange ? "model exchange" : "co-simulation");
    return NULL;
}

bool mbsri_set_log(mbsri_instance *in, bool on, size_t count, const char *const *category)
{
    static const char *const names[] = {"logEvents", "logStatusWarning", "logStatusDiscard",
                                        "logStatusError", "logAll"};
    unsigned chosen = count > 0 ? 0u : MBSRI_LOG_ALL;
    for (size_t k = 0; k < count; ++k) {
        unsigned l = 0;
        while (l < 5 && (!category || !category[k] || strcmp(category[k], names[l]) != 0)) ++l;
        if (l == 5) {
            mbsri_say(in, MBSRI_ERROR, "there is no category '%.60s' of messages",
                      category && category[k] ? category[k] : "");
            return false;
        }
        chosen |= l == 4 ? MBSRI_LOG_ALL : 1u << l;
    }
    if (count == 0)
        in->importer.log = on ? MBSRI_LOG_ALL : 0u;
    else
        in->importer.log = on ? in->importer.log | chosen : in->importer.log & ~chosen;
    return true;
}

bool mbsri_has_events(const mbsri_instance *in)
{
    return in->variables.indicators > 0 && !(in->plan.steps.fixed_step > 0.0);
}
