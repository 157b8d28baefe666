/* mbsrank static, modes, linearise: where a model rests, and how it moves about that.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "program/hdf5.h"
#include "program/mat.h"
#include "program/mode_motion.h"
#include "program/touching.h"

#include <mbsrank/linear.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_NAMES = 64, SHOWN = 4, NAME = 200 };

/* What names between commas mean. */
typedef struct named {
    int count;
    mbsr_signal signal[MOST_NAMES];
} named;

typedef struct linear_options {
    program_options common;
    bool drawn; /* not from rest */
    const char *inputs, *outputs, *count, *trim, *hold, *response;
    const char *mode, *file; /* number of a mode, from 1, and where its motion goes */
} linear_options;

/* A model at rest, or as it starts. */
typedef struct scene {
    program_model m;
    touching contacts;
    double *q, *u; /* nq, nu */
    mbsr_equilibrium_info info;
    mbsr_parameters *list;
} scene;

static int read_options(int argc, char **argv, const char *command, linear_options *o)
{
    static const char *const names[] = {"--inputs", "--outputs",  "--count", "--trim",
                                        "--hold",   "--response", "--mode",  "-o"};
    const char **const text[] = {&o->inputs, &o->outputs,  &o->count, &o->trim,
                                 &o->hold,   &o->response, &o->mode,  &o->file};
    int code = DONE;
    for (int at = 0; at < argc && at >= 0 && !code; ++at) {
        bool taken = strcmp(argv[at], "--as-drawn") == 0;
        o->drawn = o->drawn || taken;
        for (int k = 0; k < 8 && !taken && !code; ++k) {
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

/* Of a joint, or of its body where it has none. */
static const char *joint_name(const mbsr_file *f, int joint)
{
    const mbsr_file_joint *j = f->joint + joint;
    return j->name[0] ? j->name : f->body_name[j->body];
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
    return best < 0 ? "?" : joint_name(m->file, best);
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

/* The next of names between commas, into `name`; NULL: there is no more. */
static const char *next_name(const char *names, char name[NAME])
{
    if (!names || !*names) return NULL;
    const size_t length = strcspn(names, ",");
    snprintf(name, NAME, "%.*s", (int)(length < NAME - 1 ? length : NAME - 1), names);
    names += length;
    return *names ? names + 1 : names;
}

/* The first rate of the joint of that name in u; -1: there is none. */
static int rate_named(const program_model *m, const char *name)
{
    for (int k = 0; k < mbsr_model_nu(m->model); ++k) {
        int own;
        if (strcmp(joint_of_rate(m, k, &own), name) == 0 && own == 0) return k;
    }
    return -1;
}

/* Inputs or outputs: joints of the file, or names of mbsr_signal_find; NULL: none. A code. */
static int signals_named(const program_model *m, const mbsr_parameters *list, const char *names,
                         named *out)
{
    char name[NAME];
    while ((names = next_name(names, name)) != NULL) {
        if (out->count == MOST_NAMES) return complain(USAGE, "more than %d names", MOST_NAMES);
        mbsr_signal *signal = out->signal + out->count++;
        const int rate = rate_named(m, name);
        mbsr_error error = {.text = ""};
        *signal = (mbsr_signal){.kind = MBSR_SIGNAL_JOINT, .id = rate};
        if (rate >= 0) continue;
        if (mbsr_signal_find(m->model, list, name, signal, &error))
            return complain(USAGE, "there is no joint '%s', and %s", name, error.text);
    }
    return DONE;
}

static void close_scene(scene *s)
{
    free(s->q);
    mbsr_parameters_destroy(s->list);
    close_model(&s->m);
    mbsr_model_destroy(s->contacts.model);
    touching_free(&s->contacts);
}

/* The model of the options, at rest unless they say otherwise. A code. */
static int open_scene(const linear_options *o, scene *s)
{
    const double *q, *u;
    *s = (scene){.info = {.worst = MBSR_NONE}};
    int code = open_model(&o->common, false, &s->m);
    if (!code) code = start_state(&o->common, &s->m, &q, &u);
    if (!code) code = touching_put(&s->m, q, o->common.contacts, false, &s->contacts);
    if (code) return code;
    const int nq = mbsr_model_nq(s->m.model), nu = mbsr_model_nu(s->m.model);
    s->q = calloc((size_t)(nq + nu) + 1, sizeof *s->q);
    if (!s->q) return complain(FAILED, "no memory");
    s->u = s->q + nq;
    memcpy(s->q, q, (size_t)nq * sizeof *q);
    mbsr_error error = {.text = ""};
    if (mbsr_parameters_create(s->m.model, &s->list, &error))
        return complain(FAILED, "%s", error.text);
    for (int k = 0; k < nu && u && o->drawn; ++k) s->u[k] = u[k];
    if (o->drawn || o->trim) return DONE;
    const int status =
        mbsr_equilibrium(s->m.model, s->m.data, 0.0, s->q, NULL, s->q, NULL, &s->info, &error);
    if (status)
        return complain(status == MBSR_UNDETERMINED ? UNDETERMINED : FAILED, "%s", error.text);
    return DONE;
}

/* ---- static ---- */

/* What trim has found beside positions. */
typedef struct trimmed {
    int count, which[MOST_NAMES];
    double value[MOST_NAMES];
    mbsr_trim_info info;
} trimmed;

static void put_joints(const scene *s)
{
    const mbsr_file *f = s->m.file;
    for (int j = 0; j < f->joints; ++j) {
        static const int numbers[] = {0, 1, 1, 4, 7};
        int q;
        if (f->joint[j].kind == 0) continue;
        mbsr_body_coordinates(s->m.model, f->joint[j].body, &q, NULL, NULL, NULL);
        say(stdout, "  %-24s", joint_name(f, j));
        for (int k = 0; k < numbers[f->joint[j].kind]; ++k)
            printf(" %.9g", s->q[q + f->joint[j].position + k]);
        putchar('\n');
    }
}

static void put_trimmed(const scene *s, const trimmed *t)
{
    for (int k = 0; k < t->count; ++k) {
        mbsr_parameter p;
        mbsr_parameter_get(s->list, t->which[k], &p);
        say(stdout, "  %s = %.9g %s\n", p.name, t->value[k], p.unit);
    }
    if (t->info.growth > 1e-6)
        printf("unstable: it leaves this rest as exp(%.4g t)\n", t->info.growth);
    if (t->info.loose > 0.0) puts("something is not determined, and has moved as little as it can");
}

static void put_rest(const scene *s, const trimmed *t, bool json)
{
    const int steps = t ? t->info.iterations : s->info.iterations;
    if (!json) {
        printf("at rest after %d steps:\n", steps);
        put_joints(s);
        if (t) put_trimmed(s, t);
        return;
    }
    printf("{\"steps\": %d, \"q\": ", steps);
    put_numbers(stdout, s->m.file->nq, s->q);
    for (int k = 0; t && k < t->count; ++k) {
        mbsr_parameter p;
        mbsr_parameter_get(s->list, t->which[k], &p);
        fputs(k > 0 ? ", " : ", \"parameters\": {", stdout);
        put_json(stdout, p.name);
        printf(": %.17g%s", t->value[k], k == t->count - 1 ? "}" : "");
    }
    if (t) {
        fputs(", \"growth\": ", stdout);
        put_number(stdout, t->info.growth);
    }
    puts("}");
}

/* Positions and the parameters named; joints named are held, "all" of them. A code. */
static int trim_scene(const linear_options *o, scene *s, trimmed *t)
{
    char name[NAME];
    int hold[MOST_NAMES];
    mbsr_trim_opt opt = mbsr_default_trim_opt();
    mbsr_error error = {.text = ""};
    opt.hold = hold;
    for (const char *at = o->trim; (at = next_name(at, name)) != NULL;) {
        const int which = mbsr_parameters_find(s->list, name);
        if (which < 0) return complain(USAGE, "--trim: there is no parameter '%s'", name);
        if (t->count == MOST_NAMES) return complain(USAGE, "more than %d names", MOST_NAMES);
        t->which[t->count++] = which;
    }
    const bool every = o->hold && strcmp(o->hold, "all") == 0;
    for (const char *at = every ? NULL : o->hold; (at = next_name(at, name)) != NULL;) {
        const int rate = rate_named(&s->m, name);
        if (rate < 0) return complain(USAGE, "--hold: there is no joint '%s'", name);
        if (opt.held == MOST_NAMES) return complain(USAGE, "more than %d names", MOST_NAMES);
        hold[opt.held++] = rate;
    }
    if (every) opt.held = -1;
    const int status =
        mbsr_trim(s->list, 0.0, s->q, t->count, t->which, &opt, s->q, t->value, &t->info, &error);
    return status ? complain(status == MBSR_UNDETERMINED ? UNDETERMINED : FAILED, "%s", error.text)
                  : DONE;
}

int run_static(int argc, char **argv)
{
    linear_options o = {.common = {.contacts = true}};
    trimmed t = {.count = 0};
    scene s;
    int code = read_options(argc, argv, "static", &o);
    if (code) return code;
    if (o.drawn || o.inputs || o.outputs || o.count || o.response)
        return complain(USAGE, "static: --as-drawn, --inputs, --outputs, --response and --count "
                               "are for modes and linearise");
    if (o.mode || o.file) return complain(USAGE, "static: --mode and -o are for modes");
    if (o.hold && !o.trim) return complain(USAGE, "static: --hold is for --trim");
    code = open_scene(&o, &s);
    if (!code && o.trim) code = trim_scene(&o, &s, &t);
    if (!code) put_rest(&s, o.trim ? &t : NULL, o.common.json);
    close_scene(&s);
    return code;
}

/* ---- modes ---- */

static int linearise_scene(const linear_options *o, const scene *s, mbsr_linear **linear)
{
    mbsr_error error = {.text = ""};
    named in = {0}, out = {0};
    int code = signals_named(&s->m, s->list, o->inputs, &in);
    if (!code) code = signals_named(&s->m, s->list, o->outputs, &out);
    if (code) return code;
    mbsr_linear_opt opt = mbsr_default_linear_opt();
    opt.inputs = in.count;
    opt.outputs = out.count;
    opt.input = in.signal;
    opt.output = out.signal;
    opt.list = s->list;
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

/* All modes of l, or without it the `wanted` slowest. */
static int put_modes(const scene *s, mbsr_linear *l, int wanted, bool json)
{
    mbsr_linear_info info = {.states = wanted};
    const int nu = mbsr_model_nu(s->m.model), forces = mbsr_model_forces(s->m.model),
              bodies = mbsr_model_bodies(s->m.model);
    int count = 0;
    if (l) mbsr_linear_get_info(l, &info);
    const size_t shapes = (size_t)nu * (size_t)(l ? 1 : wanted);
    mbsr_mode *mode = calloc((size_t)info.states + 1, sizeof *mode);
    double *first = calloc(2 * shapes + (size_t)nu + 3 * (size_t)forces + (size_t)bodies + 1,
                           sizeof *first),
           *kinetic = first ? first + 2 * shapes : NULL,
           *potential = first ? kinetic + bodies : NULL, *lost = first ? potential + forces : NULL;
    mbsr_error error = {.text = ""};
    int status = mode && first ? MBSR_OK : MBSR_ERR_NO_MEMORY;
    if (!status && l) status = mbsr_linear_modes(l, mode, &count);
    if (!status && !l) {
        mbsr_near_opt opt = mbsr_default_near_opt();
        opt.count = wanted;
        status = mbsr_modes_near(s->m.model, s->m.data, 0.0, s->q, &opt, mode, &count, first,
                                 first + shapes, &error);
    }
    if (json && l)
        printf("{\"states\": %d, \"eliminated\": %d, \"modes\": [", info.states,
               info.size - info.states);
    else if (json)
        printf("{\"modes\": [");
    else if (!l)
        puts("        Hz   damping %          1/s   moves");
    else
        printf("%d states; %d of %d equations eliminated\n"
               "        Hz   damping %%          1/s   moves\n",
               info.states, info.size - info.states, info.size);
    for (int k = 0; k < count && !status; ++k) {
        double *re = first + (l ? 0 : (size_t)k * (size_t)nu), *im = re + shapes;
        if (l) status = mbsr_linear_shape(l, k, re, im);
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
    free(first);
    if (!status) return DONE;
    return complain(FAILED, "%s", error.text[0] ? error.text : mbsr_status_text(status));
}

/* Of mode `number`, from 1, of those that are shown. */
static int put_motion(const scene *s, mbsr_linear *l, int number, const char *path)
{
    const int nu = mbsr_model_nu(s->m.model);
    mbsr_linear_info info;
    mbsr_linear_get_info(l, &info);
    mbsr_mode *mode = calloc((size_t)info.states + 1, sizeof *mode);
    double *re = calloc(2 * (size_t)nu + 1, sizeof *re), *im = re ? re + nu : NULL;
    int count = 0, code = DONE,
        status = mode && re ? mbsr_linear_modes(l, mode, &count) : MBSR_ERR_NO_MEMORY;
    if (!status && number > count) code = complain(USAGE, "modes: there are %d", count);
    if (!status && !code) status = mbsr_linear_shape(l, number - 1, re, im);
    if (!status && !code) code = mode_motion_write(&s->m, s->q, mode + number - 1, re, im, path);
    if (status) code = complain(FAILED, "%s", mbsr_status_text(status));
    free(mode);
    free(re);
    return code;
}

int run_modes(int argc, char **argv)
{
    linear_options o = {.common = {.contacts = true}};
    scene s;
    mbsr_linear *l = NULL;
    int code = read_options(argc, argv, "modes", &o);
    if (code) return code;
    if (o.inputs || o.outputs || o.response)
        return complain(USAGE, "modes: --inputs, --outputs and --response are for linearise");
    if (o.trim || o.hold) return complain(USAGE, "modes: --trim and --hold are for static");
    const int wanted = o.count ? atoi(o.count) : 0;
    if (o.count && (wanted < 1 || wanted > 1000 || o.drawn))
        return complain(USAGE, "modes: --count is 1 .. 1000, and not for --as-drawn");
    const int number = o.mode ? atoi(o.mode) : 0;
    if ((o.mode && number < 1) || !o.mode != !o.file || (o.mode && o.count))
        return complain(USAGE, "modes: --mode K from 1 on goes with -o FILE, and not with --count");
    code = open_scene(&o, &s);
    if (!code && wanted == 0) code = linearise_scene(&o, &s, &l);
    if (!code && number > 0) code = put_motion(&s, l, number, o.file);
    if (!code && number == 0) code = put_modes(&s, l, wanted, o.common.json);
    mbsr_linear_destroy(l);
    close_scene(&s);
    return code;
}

/* ---- linearise ---- */

/* Matrices by name: of the descriptor form, then of the reduced one. */
static void list_matrices(const mbsr_linear *l, hdf5_matrix list[MBSR_LINEAR_PARTS])
{
    static const char *const name[MBSR_LINEAR_PARTS] = {
        "descriptor_E", "descriptor_A", "descriptor_B", "A", "B", "C", "D"};
    for (int part = 0; part < MBSR_LINEAR_PARTS; ++part) {
        hdf5_matrix *m = list + part;
        m->name = name[part];
        m->x = mbsr_linear_matrix(l, (mbsr_linear_part)part, &m->rows, &m->columns);
    }
}

/* Matrices row by row: CSV with a head line for each, or JSON. */
static void put_matrices(FILE *to, int count, const hdf5_matrix *m, bool json)
{
    for (int part = 0; part < count; ++part, ++m) {
        if (json)
            fprintf(to, "%s\"%s\": [", part > 0 ? ", " : "{", m->name);
        else
            fprintf(to, "# %s %d %d\n", m->name, m->rows, m->columns);
        for (int i = 0; i < m->rows; ++i) {
            if (json) fputs(i > 0 ? ", [" : "[", to);
            for (int j = 0; j < m->columns; ++j)
                fprintf(to, "%s%.17g", j > 0 ? json ? ", " : "," : "", m->x[j * m->rows + i]);
            fputs(json ? "]" : "\n", to);
        }
        if (json) fputc(']', to);
    }
    if (json) fputs("}\n", to);
}

/* All matrices by their names as a file of MATLAB, HDF5 or CSV. */
static int write_matrices(const hdf5_matrix *m, const char *path)
{
    const bool mat = ends_in(path, ".mat");
    if (names_hdf5(path)) return hdf5_matrices(path, MBSR_LINEAR_PARTS, m);
    if (!mat && !ends_in(path, ".csv"))
        return complain(USAGE, "linearise: -o is a name in .mat, .h5, .hdf5 or .csv");
    FILE *to = fopen(path, "wb");
    if (!to) return complain_of_file(FAILED, path, "written");
    if (mat) mat_begin(to);
    for (int part = 0; part < MBSR_LINEAR_PARTS && mat; ++part, ++m)
        mat_put(to, m->name, m->rows, m->columns, m->x);
    if (!mat) put_matrices(to, MBSR_LINEAR_PARTS, m, false);
    const bool bad = fflush(to) != 0 || ferror(to);
    fclose(to);
    return bad ? complain(FAILED, "%s cannot be written", path) : DONE;
}

/* Lines of CSV: frequency, then real and imaginary part of each output for each input. */
static int put_response(const linear_options *o, mbsr_linear *l)
{
    double first, last, step;
    int count = 0, read = 0, outputs, inputs;
    if (sscanf(o->response, "%lf:%lf:%d%n", &first, &last, &count, &read) != 3 ||
        o->response[read] || !(first > 0.0) || !(last >= first) || !isfinite(last) || count < 1 ||
        count > 100000)
        return complain(USAGE, "--response is FROM:TO:COUNT in Hz, such as 0.1:10:50");
    (void)mbsr_linear_matrix(l, MBSR_LINEAR_DR, &outputs, &inputs);
    const size_t numbers = (size_t)outputs * (size_t)inputs;
    double *re = calloc(2 * numbers + 1, sizeof *re), *im = re ? re + numbers : NULL;
    if (!re) return complain(FAILED, "no memory");
    fputs("frequency", stdout);
    for (int j = 0; j < inputs; ++j)
        for (int i = 0; i < outputs; ++i) printf(",re%d.%d,im%d.%d", i + 1, j + 1, i + 1, j + 1);
    putchar('\n');
    int status = MBSR_OK;
    step = count > 1 ? log(last / first) / (count - 1) : 0.0;
    for (int k = 0; k < count && !status; ++k) {
        const double f = k == count - 1 && count > 1 ? last : first * exp(step * k);
        status = mbsr_linear_response(l, f, re, im);
        if (status) break;
        printf("%.9g", f);
        for (size_t at = 0; at < numbers; ++at) printf(",%.17g,%.17g", re[at], im[at]);
        putchar('\n');
    }
    free(re);
    return status ? complain(FAILED, "a frequency is an eigenvalue") : DONE;
}

int run_linearise(int argc, char **argv)
{
    linear_options o = {.common = {.contacts = true}};
    scene s;
    mbsr_linear *l = NULL;
    hdf5_matrix all[MBSR_LINEAR_PARTS];
    int code = read_options(argc, argv, "linearise", &o);
    if (code) return code;
    if (o.count) return complain(USAGE, "linearise: --count is for modes");
    if (o.mode) return complain(USAGE, "linearise: --mode is for modes");
    if (o.trim || o.hold) return complain(USAGE, "linearise: --trim and --hold are for static");
    code = open_scene(&o, &s);
    if (!code) code = linearise_scene(&o, &s, &l);
    if (!code) list_matrices(l, all);
    if (!code && o.file) code = write_matrices(all, o.file);
    if (!code && o.response) code = put_response(&o, l);
    if (!code && !o.response && !o.file)
        put_matrices(stdout, 4, all + MBSR_LINEAR_AR, o.common.json);
    mbsr_linear_destroy(l);
    close_scene(&s);
    return code;
}
