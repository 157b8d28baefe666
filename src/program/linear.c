/* mbsrank static, modes, linearise: where a model rests, and how it moves about that.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "program/program.h"

#include <mbsrank/linear.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_NAMES = 64, SHOWN = 4 };

/* Joints by name; numbers are places in u. */
typedef struct rates {
    int count, place[MOST_NAMES];
} rates;

typedef struct linear_options {
    program_options common;
    bool drawn; /* not from rest */
    const char *inputs, *outputs;
} linear_options;

/* A model at rest, or as it starts. */
typedef struct scene {
    program_model m;
    double *q, *u; /* nq, nu */
    mbsr_equilibrium_info info;
} scene;

static int read_options(int argc, char **argv, const char *command, linear_options *o)
{
    static const char *const names[] = {"--inputs", "--outputs"};
    const char **const text[] = {&o->inputs, &o->outputs};
    int code = DONE;
    for (int at = 0; at < argc && at >= 0 && !code; ++at) {
        bool taken = strcmp(argv[at], "--as-drawn") == 0;
        o->drawn = o->drawn || taken;
        for (int k = 0; k < 2 && !taken && !code; ++k) {
            const char *value = option_value(argc, argv, &at, names[k]);
            if (at < 0) return USAGE;
            taken = value != NULL;
            if (value) *text[k] = value;
        }
        if (taken) continue;
        if (!common_option(argc, argv, &at, &o->common, &code))
            code = complain(USAGE, "%s: there is no option %s", command, argv[at]);
        if (at < 0) break;
    }
    return code;
}

/* The joint with rate k: the last that begins at k or before, and its own number of it. */
static const char *joint_of_rate(const program_model *m, int k, int *own)
{
    int best = -1, first = -1;
    for (int j = 0; j < m->file->joints; ++j) {
        int u;
        mbsr_body_coordinates(m->model, m->file->joint[j].body, NULL, NULL, &u, NULL);
        u += m->file->joint[j].coordinate;
        if (u > k || u < first || m->file->joint[j].kind == 0) continue;
        best = j;
        first = u;
    }
    *own = k - first;
    return best < 0 ? "?" : m->file->joint[best].name;
}

static void say_rate(const program_model *m, int k)
{
    int own;
    const char *name = joint_of_rate(m, k, &own);
    if (own > 0)
        say(stdout, "%s[%d]", name, own);
    else
        say(stdout, "%s", name);
}

/* Names between commas, as places in u; NULL: none. A code. */
static int places_named(const program_model *m, const char *names, rates *r)
{
    while (names && *names) {
        const size_t length = strcspn(names, ",");
        int found = -1;
        for (int k = 0; k < mbsr_model_nu(m->model) && found < 0; ++k) {
            int own;
            const char *name = joint_of_rate(m, k, &own);
            if (own == 0 && strlen(name) == length && strncmp(name, names, length) == 0) found = k;
        }
        if (found < 0) return complain(USAGE, "there is no joint '%.*s'", (int)length, names);
        if (r->count == MOST_NAMES) return complain(USAGE, "more than %d joints", MOST_NAMES);
        r->place[r->count++] = found;
        names += length;
        if (*names) ++names;
    }
    return DONE;
}

static void close_scene(scene *s)
{
    free(s->q);
    close_model(&s->m);
}

/* The model of the options, at rest unless they say otherwise. A code. */
static int open_scene(const linear_options *o, scene *s)
{
    const double *q, *u;
    *s = (scene){.info = {.worst = MBSR_NONE}};
    int code = open_model(&o->common, false, &s->m);
    if (!code) code = start_state(&o->common, &s->m, &q, &u);
    if (code) return code;
    const int nq = mbsr_model_nq(s->m.model), nu = mbsr_model_nu(s->m.model);
    s->q = calloc((size_t)(nq + nu) + 1, sizeof *s->q);
    if (!s->q) return complain(FAILED, "no memory");
    s->u = s->q + nq;
    memcpy(s->q, q, (size_t)nq * sizeof *q);
    if (o->drawn) {
        for (int k = 0; k < nu && u; ++k) s->u[k] = u[k];
        return DONE;
    }
    mbsr_error error;
    const int status =
        mbsr_equilibrium(s->m.model, s->m.data, 0.0, s->q, NULL, s->q, NULL, &s->info, &error);
    if (status)
        return complain(status == MBSR_UNDETERMINED ? UNDETERMINED : FAILED, "%s", error.text);
    return DONE;
}

/* ---- static ---- */

static void put_rest(const scene *s, bool json)
{
    const mbsr_file *f = s->m.file;
    if (json) {
        printf("{\"steps\": %d, \"q\": ", s->info.iterations);
        put_numbers(stdout, f->nq, s->q);
        puts("}");
        return;
    }
    printf("at rest after %d steps:\n", s->info.iterations);
    for (int j = 0; j < f->joints; ++j) {
        static const int numbers[] = {0, 1, 1, 4, 7};
        int q;
        if (f->joint[j].kind == 0) continue;
        mbsr_body_coordinates(s->m.model, f->joint[j].body, &q, NULL, NULL, NULL);
        say(stdout, "  %-24s", f->joint[j].name);
        for (int k = 0; k < numbers[f->joint[j].kind]; ++k)
            printf(" %.9g", s->q[q + f->joint[j].position + k]);
        putchar('\n');
    }
}

int run_static(int argc, char **argv)
{
    linear_options o = {.drawn = false};
    scene s;
    int code = read_options(argc, argv, "static", &o);
    if (code) return code;
    if (o.drawn || o.inputs || o.outputs)
        return complain(USAGE, "static: --as-drawn, --inputs and --outputs are for modes and "
                               "linearise");
    code = open_scene(&o, &s);
    if (!code) put_rest(&s, o.common.json);
    close_scene(&s);
    return code;
}

/* ---- modes ---- */

static int linearise_scene(const linear_options *o, const scene *s, mbsr_linear **linear)
{
    mbsr_error error;
    rates in = {0}, out = {0};
    int code = places_named(&s->m, o->inputs, &in);
    if (!code) code = places_named(&s->m, o->outputs, &out);
    if (code) return code;
    mbsr_linear_opt opt = mbsr_default_linear_opt();
    opt.inputs = in.count;
    opt.outputs = out.count;
    opt.input = in.place;
    opt.output = out.place;
    const int status =
        mbsr_linear_create(s->m.model, s->m.data, 0.0, s->q, s->u, &opt, linear, &error);
    if (!status) return DONE;
    return complain(status == MBSR_UNDETERMINED ? UNDETERMINED : FAILED, "%s", error.text);
}

/* Of n sizes the largest that comes behind the one at `before` (-1: none), above least; or -1. */
static int next_largest(int n, const double *size, int before, double least)
{
    int best = -1;
    for (int k = 0; k < n; ++k) {
        const bool shown =
            before >= 0 && (size[k] > size[before] || (size[k] == size[before] && k <= before));
        if (shown || !(size[k] > least)) continue;
        best = k;
        least = size[k];
    }
    return best;
}

/* The joints that move most in a shape, and the elements that hold most of its energy; sizes: as
 * many numbers as joint rates and elements. */
static void say_shape(const scene *s, const double *re, const double *im, const double *share,
                      double *sizes)
{
    const int nu = mbsr_model_nu(s->m.model), forces = mbsr_model_forces(s->m.model);
    for (int k = 0; k < nu; ++k) sizes[k] = hypot(re[k], im[k]);
    for (int shown = 0, at = -1; shown < SHOWN; ++shown) {
        at = next_largest(nu, sizes, at, 0.05);
        if (at < 0) break;
        fputs(shown > 0 ? ", " : "  ", stdout);
        say_rate(&s->m, at);
        printf(" %.2f", sizes[at] * (re[at] < 0.0 ? -1.0 : 1.0));
    }
    for (int k = 0; k < forces; ++k) sizes[k] = fabs(share[k]);
    for (int shown = 0, at = -1; shown < SHOWN; ++shown) {
        mbsr_force_def force;
        at = next_largest(forces, sizes, at, 0.05);
        if (at < 0 || mbsr_force_definition(s->m.model, at, &force)) break;
        fputs(shown > 0 ? ", " : "; energy in ", stdout);
        if (force.name && force.name[0])
            say(stdout, "%s", force.name);
        else
            say(stdout, "%s %d", force.table->name, at);
        printf(" %.2f", share[at]);
    }
}

static int put_modes(const scene *s, mbsr_linear *l, bool json)
{
    mbsr_linear_info info;
    const int nu = mbsr_model_nu(s->m.model);
    int count = 0;
    mbsr_linear_get_info(l, &info);
    const int forces = mbsr_model_forces(s->m.model), bodies = mbsr_model_bodies(s->m.model);
    mbsr_mode *mode = calloc((size_t)info.states + 1, sizeof *mode);
    double *re = calloc(3 * (size_t)nu + 3 * (size_t)forces + (size_t)bodies + 1, sizeof *re),
           *im = re ? re + nu : NULL, *kinetic = im ? im + nu : NULL,
           *potential = im ? kinetic + bodies : NULL, *lost = im ? potential + forces : NULL;
    mbsr_error error = {.text = ""};
    int status = mode && re ? mbsr_linear_modes(l, mode, &count) : MBSR_ERR_NO_MEMORY;
    if (json)
        printf("{\"states\": %d, \"eliminated\": %d, \"modes\": [", info.states,
               info.size - info.states);
    else
        printf("%d states; %d of %d equations eliminated\n"
               "        Hz   damping %%          1/s   moves\n",
               info.states, info.size - info.states, info.size);
    for (int k = 0; k < count && !status; ++k) {
        status = mbsr_linear_shape(l, k, re, im);
        if (!status)
            status = mbsr_mode_participation(s->m.model, s->m.data, 0.0, s->q, mode + k, re, im,
                                             kinetic, potential, lost, &error);
        if (status) break;
        if (json) {
            printf("%s{\"frequency\": %.17g, \"damping\": %.17g, \"real\": %.17g, \"imaginary\": "
                   "%.17g, \"re\": ",
                   k > 0 ? ", " : "", mode[k].frequency, mode[k].damping, mode[k].real,
                   mode[k].imaginary);
            put_numbers(stdout, nu, re);
            printf(", \"im\": ");
            put_numbers(stdout, nu, im);
            printf(", \"kinetic\": ");
            put_numbers(stdout, bodies, kinetic);
            printf(", \"potential\": ");
            put_numbers(stdout, forces, potential);
            printf(", \"dissipated\": ");
            put_numbers(stdout, forces, lost);
            putchar('}');
            continue;
        }
        printf("%10.5g %11.4g %12.5g ", mode[k].frequency, 100.0 * mode[k].damping, mode[k].real);
        say_shape(s, re, im, potential, lost + forces);
        putchar('\n');
    }
    if (json) puts("]}");
    free(mode);
    free(re);
    if (!status) return DONE;
    return complain(FAILED, "%s", error.text[0] ? error.text : mbsr_status_text(status));
}

int run_modes(int argc, char **argv)
{
    linear_options o = {.drawn = false};
    scene s;
    mbsr_linear *l = NULL;
    int code = read_options(argc, argv, "modes", &o);
    if (code) return code;
    if (o.inputs || o.outputs)
        return complain(USAGE, "modes: --inputs and --outputs are for linearise");
    code = open_scene(&o, &s);
    if (!code) code = linearise_scene(&o, &s, &l);
    if (!code) code = put_modes(&s, l, o.common.json);
    mbsr_linear_destroy(l);
    close_scene(&s);
    return code;
}

/* ---- linearise ---- */

/* Matrices row by row: CSV with a head line for each, or JSON. */
static void put_matrices(const mbsr_linear *l, bool json)
{
    static const char *const name[] = {"A", "B", "C", "D"};
    for (int part = 0; part < 4; ++part) {
        int rows, columns;
        const double *x =
            mbsr_linear_matrix(l, (mbsr_linear_part)(MBSR_LINEAR_AR + part), &rows, &columns);
        if (json)
            printf("%s\"%s\": [", part > 0 ? ", " : "{", name[part]);
        else
            printf("# %s %d %d\n", name[part], rows, columns);
        for (int i = 0; i < rows; ++i) {
            if (json) fputs(i > 0 ? ", [" : "[", stdout);
            for (int j = 0; j < columns; ++j)
                printf("%s%.17g", j > 0 ? json ? ", " : "," : "", x[j * rows + i]);
            fputs(json ? "]" : "\n", stdout);
        }
        if (json) putchar(']');
    }
    if (json) puts("}");
}

int run_linearise(int argc, char **argv)
{
    linear_options o = {.drawn = false};
    scene s;
    mbsr_linear *l = NULL;
    int code = read_options(argc, argv, "linearise", &o);
    if (code) return code;
    code = open_scene(&o, &s);
    if (!code) code = linearise_scene(&o, &s, &l);
    if (!code) put_matrices(l, o.common.json);
    mbsr_linear_destroy(l);
    close_scene(&s);
    return code;
}
