/* Operators of expressions of xacro: see xacro_arithmetic.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "files/xacro_arithmetic.h"

#include <math.h>
#include <string.h>

static const double pi = 3.14159265358979323846;

static bool give_real(mbsri_xacro *x, double real, bool was_finite, mbsri_value *out)
{
    if (was_finite && !isfinite(real))
        return mbsri_xacro_refuse(x, "the result of an expression is no finite number");
    *out = mbsri_value_real(real);
    return true;
}

static bool refuse_large(mbsri_xacro *x)
{
    return mbsri_xacro_refuse(x, "a whole number is beyond 64 bits");
}

static bool refuse_zero(mbsri_xacro *x)
{
    return mbsri_xacro_refuse(x, "an expression divides by zero");
}

/* ---- whole numbers ---- */

static bool multiply_whole(int64_t a, int64_t b, int64_t *product)
{
    const bool minus = (a < 0) != (b < 0);
    const uint64_t u = a < 0 ? 0 - (uint64_t)a : (uint64_t)a,
                   v = b < 0 ? 0 - (uint64_t)b : (uint64_t)b;
    if (u > 0 && v > (uint64_t)INT64_MAX / u) return false;
    *product = minus ? -(int64_t)(u * v) : (int64_t)(u * v);
    return true;
}

static bool add_whole(int64_t a, int64_t b, int64_t *sum)
{
    if (b > 0 ? a > INT64_MAX - b : a < INT64_MIN - b) return false;
    *sum = a + b;
    return true;
}

static bool power_whole(int64_t base, int64_t exponent, int64_t *power)
{
    *power = 1;
    for (; exponent > 0; exponent /= 2) {
        if (exponent % 2 && !multiply_whole(*power, base, power)) return false;
        if (exponent > 1 && !multiply_whole(base, base, &base)) return false;
    }
    return true;
}

/* Towards minus infinity, the remainder with the sign of b. */
static bool divide_whole(int64_t a, int64_t b, int64_t *quotient, int64_t *remainder)
{
    if (a == INT64_MIN && b == -1) return false;
    *quotient = a / b;
    *remainder = a % b;
    if (*remainder != 0 && (*remainder < 0) != (b < 0)) {
        *quotient -= 1;
        *remainder += b;
    }
    return true;
}

static bool on_whole(mbsri_xacro *x, char mark, int64_t a, int64_t b, mbsri_value *out)
{
    int64_t result = 0, other;
    bool fits = true;
    if (strchr("/%", mark) && b == 0) return refuse_zero(x);
    switch (mark) {
    case '+': fits = add_whole(a, b, &result); break;
    case '-': fits = b > INT64_MIN && add_whole(a, -b, &result); break;
    case '*': fits = multiply_whole(a, b, &result); break;
    case '%': fits = divide_whole(a, b, &other, &result); break;
    case '/': fits = divide_whole(a, b, &result, &other); break;
    default: fits = power_whole(a, b, &result);
    }
    *out = mbsri_value_whole(result);
    return fits || refuse_large(x);
}

/* ---- real numbers ---- */

/* Python's a // b and a % b: a = quotient b + remainder, the remainder with the sign of b. */
static void divide_real(double a, double b, double *quotient, double *remainder)
{
    double rest = fmod(a, b), ratio = (a - rest) / b;
    if (rest == 0.0) {
        rest = copysign(0.0, b);
    } else if ((b < 0.0) != (rest < 0.0)) {
        rest += b;
        ratio -= 1.0;
    }
    *remainder = rest;
    *quotient = floor(ratio);
    if (ratio == 0.0)
        *quotient = copysign(0.0, a / b);
    else if (ratio - *quotient > 0.5)
        *quotient += 1.0;
}

static bool on_real(mbsri_xacro *x, const char *mark, double a, double b, mbsri_value *out)
{
    const bool was_finite = isfinite(a) && isfinite(b), power = strcmp(mark, "**") == 0;
    double result = 0.0, other;
    if (b == 0.0 && strchr("/%", *mark)) return refuse_zero(x);
    if (power && a == 0.0 && b < 0.0) return refuse_zero(x);
    if (power)
        result = pow(a, b);
    else if (strcmp(mark, "//") == 0)
        divide_real(a, b, &result, &other);
    else if (*mark == '%')
        divide_real(a, b, &other, &result);
    else
        result = *mark == '+' ? a + b : *mark == '-' ? a - b : *mark == '*' ? a * b : a / b;
    return give_real(x, result, was_finite, out);
}

/* ---- strings and lists ---- */

static bool repeat(mbsri_xacro *x, const mbsri_value *of, int64_t times, mbsri_value *out)
{
    if (times < 0) times = 0;
    if (times > MBSRI_XACRO_TEXT) return mbsri_xacro_refuse(x, "an expression repeats too often");
    if (of->kind == MBSRI_STRING) {
        const size_t length = strlen(of->of.string), count = length > 0 ? (size_t)times : 0;
        if (length > 0 && count > MBSRI_XACRO_TEXT / length)
            return mbsri_xacro_refuse(x, "a text is too long");
        char *text = mbsri_xacro_take(x, length * count + 1);
        for (size_t k = 0; text && k < count; ++k) memcpy(text + k * length, of->of.string, length);
        *out = mbsri_value_string(text);
        return text != NULL;
    }
    mbsri_list *list = mbsri_value_begin(x, of->kind, out);
    for (int64_t k = 0; list && k < times && of->of.list->count > 0; ++k) {
        for (int l = 0; l < of->of.list->count; ++l) {
            if (!mbsri_value_add(x, list, mbsri_items(of) + l)) return false;
        }
    }
    return list != NULL;
}

static bool join_texts(mbsri_xacro *x, const mbsri_value *a, const mbsri_value *b, mbsri_value *out)
{
    if (a->kind == MBSRI_STRING) {
        const size_t first = strlen(a->of.string), second = strlen(b->of.string);
        if (first + second > MBSRI_XACRO_TEXT) return mbsri_xacro_refuse(x, "a text is too long");
        char *text = mbsri_xacro_take(x, first + second + 1);
        if (!text) return false;
        memcpy(text, a->of.string, first);
        memcpy(text + first, b->of.string, second);
        *out = mbsri_value_string(text);
        return true;
    }
    mbsri_list *list = mbsri_value_begin(x, a->kind, out);
    const mbsri_value *const both[] = {a, b};
    for (int part = 0; list && part < 2; ++part) {
        for (int k = 0; k < both[part]->of.list->count; ++k) {
            if (!mbsri_value_add(x, list, mbsri_items(both[part]) + k)) return false;
        }
    }
    return list != NULL;
}

static bool on_texts(mbsri_xacro *x, const char *mark, const mbsri_value *a, const mbsri_value *b,
                     mbsri_value *out)
{
    const bool first = a->kind == MBSRI_STRING || mbsri_is_sequence(a),
               second = b->kind == MBSRI_STRING || mbsri_is_sequence(b);
    int64_t times;
    if (strcmp(mark, "+") == 0 && first && a->kind == b->kind) return join_texts(x, a, b, out);
    if (strcmp(mark, "*") == 0 && first && mbsri_is_whole(b, &times))
        return repeat(x, a, times, out);
    if (strcmp(mark, "*") == 0 && second && mbsri_is_whole(a, &times))
        return repeat(x, b, times, out);
    if (strcmp(mark, "%") == 0 && a->kind == MBSRI_STRING)
        return mbsri_xacro_refuse(x, "formatting by %% is not read");
    return mbsri_xacro_refuse(x, "%s %s %s has no meaning", mbsri_kind_name(a), mark,
                              mbsri_kind_name(b));
}

bool mbsri_arithmetic(mbsri_xacro *x, const char *mark, const mbsri_value *a, const mbsri_value *b,
                      mbsri_value *out)
{
    int64_t i, j;
    double u, v;
    const bool ratio = strcmp(mark, "/") == 0, power = strcmp(mark, "**") == 0;
    if (!mbsri_is_number(a, &u) || !mbsri_is_number(b, &v)) return on_texts(x, mark, a, b, out);
    if (mbsri_is_whole(a, &i) && mbsri_is_whole(b, &j) && !ratio && !(power && j < 0))
        return on_whole(x, power ? '^' : *mark, i, j, out);
    return on_real(x, mark, u, v, out);
}

/* ---- functions ---- */

static bool call_one(mbsri_xacro *x, const mbsri_macro_call *c, mbsri_value *out)
{
    double a = 0.0;
    return mbsri_call_number(x, c, 0, &a) && give_real(x, c->function->one(a), isfinite(a), out);
}

static bool call_two(mbsri_xacro *x, const mbsri_macro_call *c, mbsri_value *out)
{
    double a = 0.0, b = 0.0;
    return mbsri_call_number(x, c, 0, &a) && mbsri_call_number(x, c, 1, &b) &&
           give_real(x, c->function->two(a, b), isfinite(a) && isfinite(b), out);
}

bool mbsri_make_whole(mbsri_xacro *x, double real, double (*round)(double), mbsri_value *out)
{
    const double whole = round(real);
    if (!(fabs(whole) < 9.2e18)) return refuse_large(x);
    *out = mbsri_value_whole((int64_t)whole);
    return true;
}

static bool call_whole(mbsri_xacro *x, const mbsri_macro_call *c, mbsri_value *out)
{
    double a = 0.0;
    if (c->argument->kind == MBSRI_WHOLE) {
        *out = *c->argument;
        return true;
    }
    return mbsri_call_number(x, c, 0, &a) && mbsri_make_whole(x, a, c->function->one, out);
}

static bool call_log(mbsri_xacro *x, const mbsri_macro_call *c, mbsri_value *out)
{
    double a, base = 0.0;
    if (!mbsri_call_number(x, c, 0, &a)) return false;
    if (c->count == 1) return give_real(x, log(a), isfinite(a), out);
    if (!mbsri_call_number(x, c, 1, &base)) return false;
    if (log(base) == 0.0) return refuse_zero(x);
    return give_real(x, log(a) / log(base), isfinite(a) && isfinite(base), out);
}

static bool call_is(mbsri_xacro *x, const mbsri_macro_call *c, mbsri_value *out)
{
    double a = 0.0;
    if (!mbsri_call_number(x, c, 0, &a)) return false;
    const char *what = c->function->name + 2;
    *out = mbsri_value_truth(strcmp(what, "nan") == 0   ? isnan(a)
                             : strcmp(what, "inf") == 0 ? isinf(a)
                                                        : isfinite(a));
    return true;
}

static double degrees(double a)
{
    return a * (180.0 / pi);
}

static double radians(double a)
{
    return a * (pi / 180.0);
}

#define ONE(name)                                                                                  \
    {                                                                                              \
#name, MBSRI_EVERYWHERE | MBSRI_MATH, 1, 1, call_one, name, NULL                           \
    }
#define TWO(name)                                                                                  \
    {                                                                                              \
#name, MBSRI_EVERYWHERE | MBSRI_MATH, 2, 2, call_two, NULL, name                           \
    }
#define WHOLE(name)                                                                                \
    {                                                                                              \
#name, MBSRI_EVERYWHERE | MBSRI_MATH, 1, 1, call_whole, name, NULL                         \
    }
#define IS(name)                                                                                   \
    {                                                                                              \
#name, MBSRI_EVERYWHERE | MBSRI_MATH, 1, 1, call_is, NULL, NULL                            \
    }
static const mbsri_function functions[] = {
    ONE(acos),     ONE(acosh),
    ONE(asin),     ONE(asinh),
    ONE(atan),     TWO(atan2),
    ONE(atanh),    WHOLE(ceil),
    TWO(copysign), ONE(cos),
    ONE(cosh),     ONE(degrees),
    ONE(exp),      ONE(expm1),
    ONE(fabs),     WHOLE(floor),
    TWO(fmod),     TWO(hypot),
    IS(isfinite),  IS(isinf),
    IS(isnan),     {"log", MBSRI_EVERYWHERE | MBSRI_MATH, 1, 2, call_log, NULL, NULL},
    ONE(log10),    ONE(log1p),
    ONE(log2),     TWO(pow),
    ONE(radians),  TWO(remainder),
    ONE(sin),      ONE(sinh),
    ONE(sqrt),     ONE(tan),
    ONE(tanh),     WHOLE(trunc),
};

bool mbsri_math_find(const char *name, mbsri_value *value)
{
    static const char *const names[] = {"pi", "e", "tau", "inf", "nan"};
    const double constants[] = {pi, 2.71828182845904523536, 2.0 * pi, INFINITY, NAN};
    for (size_t k = 0; k < sizeof names / sizeof *names; ++k) {
        if (strcmp(names[k], name) != 0) continue;
        *value = mbsri_value_real(constants[k]);
        return true;
    }
    const mbsri_function *found =
        mbsri_function_find(functions, sizeof functions / sizeof *functions, MBSRI_MATH, name);
    *value = (mbsri_value){.kind = MBSRI_FUNCTION, .of.function = found};
    return found != NULL;
}
