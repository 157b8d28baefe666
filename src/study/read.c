/* Study files: see study.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "base/error.h"
#include "files/numbers.h"
#include "study/record.h"

#include <limits.h>
#include <math.h>
#include <string.h>

/* Bounds of what a file may ask for. */
static const double MOST_RUNS = 1e9, MOST_LATIN_RUNS = 1e7, MOST_NUMBERS = 1e6;
enum { WORDS = 4096 };

typedef struct study_reader {
    mbsr_study *study;
    mbsr_study_sample *sample;
    mbsr_error *error;
    const char *name;
    int line, status;
    const char **word; /* of the line at hand */
    int words;
    mbsri_list parameters, outputs, listed;
    int sample_line, list_line; /* 0: not there */
    double samples;             /* that `sample` asks for */
} study_reader;

static int refuse_line(study_reader *r, const char *why, const char *word)
{
    if (!r->status)
        r->status =
            mbsri_fail_plain(r->error, MBSR_ERR_FILE, "%s:%d: %s%s%.100s%s", r->name, r->line, why,
                             word ? " '" : "", word ? word : "", word ? "'" : "");
    return r->status;
}

static int refuse_memory(study_reader *r)
{
    if (!r->status) r->status = mbsri_fail_plain(r->error, MBSR_ERR_NO_MEMORY, "no memory");
    return r->status;
}

static bool says(const char *word, const char *what)
{
    return strcmp(word, what) == 0;
}

/* ---- words of a line ---- */

/* Cuts the line at *text into words, which are copied; *text moves to the next line. */
static int cut_line(study_reader *r, const char **text, const char *end)
{
    const char *at = *text, *stop = memchr(at, '\n', (size_t)(end - at));
    if (!stop) stop = end;
    *text = stop < end ? stop + 1 : end;
    r->words = 0;
    while (at < stop) {
        if (*at == ' ' || *at == '\t' || *at == '\r') {
            ++at;
            continue;
        }
        if (*at == '#') break;
        if (*at == '\0') return refuse_line(r, "there is a NUL", NULL);
        const bool quoted = *at == '"';
        const char *from = quoted ? ++at : at;
        while (at < stop && *at && (quoted ? *at != '"' : !strchr(" \t\r", *at))) ++at;
        if (quoted && (at == stop || !*at)) return refuse_line(r, "a quote does not end", NULL);
        if (r->words == WORDS) return refuse_line(r, "there are more than 4096 words", NULL);
        r->word[r->words] = mbsri_arena_text(&r->sample->arena, from, (size_t)(at - from));
        if (!r->word[r->words++]) return refuse_memory(r);
        if (quoted) ++at;
    }
    return MBSR_OK;
}

/* Word k as a number. */
static double number_at(study_reader *r, int k)
{
    double value = 0.0;
    if (k >= r->words) {
        refuse_line(r, "a number is missing behind", r->word[r->words - 1]);
        return 0.0;
    }
    const char *text = r->word[k];
    if (!mbsri_read_number(&text, &value) || *text)
        refuse_line(r, "this is no number:", r->word[k]);
    return value;
}

/* Word k as a whole number of runs, steps or levels. */
static double count_at(study_reader *r, int k, double most)
{
    const double value = number_at(r, k);
    const bool whole = value >= 1.0 && value <= most && floor(value) == value;
    if (!r->status && !whole) refuse_line(r, "this is no whole number in its range:", r->word[k]);
    return whole ? value : 1.0;
}

static uint64_t seed_at(study_reader *r, int k)
{
    uint64_t seed = 0;
    const char *text = k < r->words ? r->word[k] : "";
    bool good = *text;
    for (; *text && good; ++text) {
        const uint64_t digit = (uint64_t)(*text - '0');
        good = mbsri_is_digit(*text) && seed <= (UINT64_MAX - digit) / 10;
        if (good) seed = 10 * seed + digit;
    }
    if (!good) refuse_line(r, "seed needs a whole number from 0 to 2^64 - 1", NULL);
    return seed;
}

/* Takes "unit U" from the end of the line. */
static const char *take_unit(study_reader *r)
{
    if (r->words < 4 - (r->sample_line && r->study->sampling == MBSR_SAMPLING_LIST) ||
        !says(r->word[r->words - 2], "unit"))
        return "";
    r->words -= 2;
    return r->word[r->words + 1];
}

/* ---- lines ---- */

static int read_model(study_reader *r)
{
    mbsr_study *s = r->study;
    if (r->words != 2) return refuse_line(r, "model needs one path", NULL);
    if (s->model_line) return refuse_line(r, "there is a second model", NULL);
    s->model = r->word[1];
    s->model_line = r->line;
    return MBSR_OK;
}

static int read_run_words(study_reader *r)
{
    mbsr_study *s = r->study;
    if (s->run_line) return refuse_line(r, "there is a second line of run", NULL);
    const size_t size = (size_t)r->words * sizeof *s->word;
    const char **word = mbsri_arena_take(&r->sample->arena, size);
    if (!word) return refuse_memory(r);
    memcpy(word, r->word + 1, size - sizeof *word);
    s->word = word;
    s->words = r->words - 1;
    s->run_line = r->line;
    return MBSR_OK;
}

static int read_limit(study_reader *r)
{
    mbsr_study *s = r->study;
    if (r->words == 3 && says(r->word[2], "steps") && !s->max_steps)
        s->max_steps = (long)count_at(r, 1, MOST_RUNS);
    else if (r->words == 3 && says(r->word[2], "s") && !(s->max_time > 0.0)) {
        s->max_time = number_at(r, 1);
        if (!r->status && !(s->max_time > 0.0)) refuse_line(r, "not positive:", r->word[1]);
    } else {
        refuse_line(r, "limit is a number of steps, or of s, each once", NULL);
    }
    return r->status;
}

const char *mbsr_sampling_name(mbsr_sampling sampling)
{
    static const char *const names[] = {[MBSR_SAMPLING_GRID] = "grid",
                                        [MBSR_SAMPLING_LIST] = "list",
                                        [MBSR_SAMPLING_RANDOM] = "random",
                                        [MBSR_SAMPLING_LATIN] = "latin",
                                        [MBSR_SAMPLING_SOBOL] = "sobol"};
    return sampling >= MBSR_SAMPLING_GRID && sampling <= MBSR_SAMPLING_SOBOL ? names[sampling]
                                                                             : NULL;
}

static int read_sample(study_reader *r)
{
    mbsr_study *s = r->study;
    int kind = 0;
    if (r->sample_line) return refuse_line(r, "there is a second line of sample", NULL);
    if (r->words < 2)
        return refuse_line(r, "sample needs grid, list, random, latin or sobol", NULL);
    while (kind <= MBSR_SAMPLING_SOBOL &&
           !says(r->word[1], mbsr_sampling_name((mbsr_sampling)kind)))
        ++kind;
    if (kind > MBSR_SAMPLING_SOBOL) return refuse_line(r, "there is no sampling", r->word[1]);
    s->sampling = (mbsr_sampling)kind;
    r->sample_line = r->line;
    int at = 2;
    if (kind >= MBSR_SAMPLING_RANDOM) {
        const double most = kind == MBSR_SAMPLING_LATIN ? MOST_LATIN_RUNS : MOST_RUNS;
        r->samples = count_at(r, at++, most);
        if (!r->status && at < r->words && says(r->word[at], "seed")) {
            s->seed = seed_at(r, at + 1);
            at += 2;
        }
    }
    if (!r->status && at < r->words) refuse_line(r, "sample does not take", r->word[at]);
    return r->status;
}

/* LOW HIGH [log] [levels N], normal MEAN DEVIATION [levels N]. */
static int read_range(study_reader *r, mbsr_study_parameter *p)
{
    const bool normal = r->words > 2 && says(r->word[2], "normal");
    int at = normal ? 3 : 2;
    p->low = number_at(r, at);
    p->high = number_at(r, at + 1);
    at += 2;
    p->spread = normal ? MBSR_SPREAD_NORMAL : MBSR_SPREAD_UNIFORM;
    if (r->status) return r->status;
    if (!normal && at < r->words && says(r->word[at], "log")) p->spread = MBSR_SPREAD_LOG, ++at;
    const bool levels = at < r->words && says(r->word[at], "levels");
    if (levels) {
        p->levels = (int)count_at(r, at + 1, 1e6);
        at += 2;
    }
    if (r->status) return r->status;
    if (at < r->words) return refuse_line(r, "vary does not take", r->word[at]);
    if (levels != (r->study->sampling == MBSR_SAMPLING_GRID))
        return refuse_line(r, levels ? "levels are for a grid" : "a grid needs levels of", p->name);
    if (p->spread == MBSR_SPREAD_NORMAL ? !(p->high > 0.0) : !(p->high > p->low))
        return refuse_line(r, normal ? "the deviation is not positive of" : "the range is empty of",
                           p->name);
    if (!(fmax(fabs(p->low), fabs(p->high)) <= 1e300))
        return refuse_line(r, "a number is beyond 1e300 of", p->name);
    if (p->spread == MBSR_SPREAD_LOG && !(p->low > 0.0))
        return refuse_line(r, "log needs positive numbers for", p->name);
    return MBSR_OK;
}

static int read_vary(study_reader *r)
{
    mbsr_study *s = r->study;
    if (!r->sample_line) return refuse_line(r, "sample comes before vary", NULL);
    if (r->list_line) return refuse_line(r, "vary comes before values", NULL);
    if (r->words < 2) return refuse_line(r, "vary needs the name of a parameter", NULL);
    if (s->sampling == MBSR_SAMPLING_SOBOL && s->parameters == MBSR_SOBOL_PARAMETERS)
        return refuse_line(r, "sobol is for 64 parameters; this is one more:", r->word[1]);
    for (int k = 0; k < s->parameters; ++k)
        if (says(s->parameter[k].name, r->word[1]))
            return refuse_line(r, "varied twice:", r->word[1]);
    mbsr_study_parameter p = {.unit = take_unit(r), .name = r->word[1], .line = r->line};
    if (s->sampling == MBSR_SAMPLING_LIST) {
        if (r->words > 2)
            return refuse_line(r, "values of a list have lines of their own; not", r->word[2]);
    } else if (read_range(r, &p)) {
        return r->status;
    }
    mbsr_study_parameter *new = mbsri_list_add(&r->sample->arena, &r->parameters, sizeof p);
    if (!new) return refuse_memory(r);
    *new = p;
    s->parameter = r->parameters.items;
    s->parameters = r->parameters.count;
    return MBSR_OK;
}

static int read_values(study_reader *r)
{
    mbsr_study *s = r->study;
    if (!r->sample_line || s->sampling != MBSR_SAMPLING_LIST)
        return refuse_line(r, "values are for sample list", NULL);
    if (s->parameters == 0) return refuse_line(r, "vary comes before values", NULL);
    if (r->words - 1 != s->parameters)
        return refuse_line(r, "there are not as many values as parameters", NULL);
    r->list_line = r->line;
    for (int k = 0; k < s->parameters; ++k) {
        double *value = mbsri_list_add(&r->sample->arena, &r->listed, sizeof *value);
        if (!value) return refuse_memory(r);
        *value = number_at(r, k + 1);
    }
    r->sample->listed = r->listed.items;
    return r->status;
}

/* Times of `at`, or 0, H, 2 H ... T. */
static int read_times(study_reader *r, mbsr_study_output *o)
{
    const bool every = says(r->word[2], "every");
    const double H = every ? number_at(r, 3) : 0.0, T = every ? number_at(r, 5) : 0.0;
    double count = (double)(r->words - 3);
    if (r->status) return r->status;
    if (every && (r->words != 6 || !says(r->word[4], "to")))
        return refuse_line(r, "this is written: every H to T; column", o->column);
    if (every && !(H > 0.0 && T >= 0.0)) return refuse_line(r, "not positive:", r->word[3]);
    if (every) count = floor(T / H * (1.0 + 1e-12)) + 1.0;
    if (!(count >= 1.0)) return refuse_line(r, "at needs times, for column", o->column);
    if (count > MOST_NUMBERS) return refuse_line(r, "there are more than 1e6 times of", o->column);
    double *time = mbsri_arena_take(&r->sample->arena, (size_t)count * sizeof *time);
    if (!time) return refuse_memory(r);
    o->kind = MBSR_KEEP_AT;
    o->time = time;
    o->times = (int)count;
    for (int k = 0; k < o->times; ++k) {
        time[k] = every ? fmin(k * H, T) : number_at(r, k + 3);
        if (r->status) return r->status;
        if (!(time[k] >= 0.0) || (k > 0 && !(time[k] > time[k - 1])))
            return refuse_line(r, "times must be positive and ascend, of column", o->column);
    }
    return MBSR_OK;
}

static int read_keep(study_reader *r)
{
    static const char *const names[] = {
        [MBSR_KEEP_AT] = "at",     [MBSR_KEEP_MAX] = "max",     [MBSR_KEEP_MIN] = "min",
        [MBSR_KEEP_MEAN] = "mean", [MBSR_KEEP_RISES] = "rises", [MBSR_KEEP_FALLS] = "falls"};
    mbsr_study *s = r->study;
    const char *unit = take_unit(r);
    if (r->words < 3) return refuse_line(r, "keep needs a column, and what of it", NULL);
    mbsr_study_output o = {
        .column = r->word[1], .unit = unit, .line = r->line, .count = 1, .first = s->numbers};
    int kind = 0;
    while (kind <= MBSR_KEEP_FALLS && !says(r->word[2], names[kind])) ++kind;
    if (says(r->word[2], "every")) kind = MBSR_KEEP_AT;
    if (kind > MBSR_KEEP_FALLS) return refuse_line(r, "keep does not know", r->word[2]);
    o.kind = (mbsr_study_kind)kind;
    int used = 3;
    if (kind == MBSR_KEEP_AT) {
        if (read_times(r, &o)) return r->status;
        o.count = o.times;
        used = r->words;
    } else if (kind >= MBSR_KEEP_RISES) {
        o.level = number_at(r, used++);
    }
    if (r->status) return r->status;
    if (used < r->words) return refuse_line(r, "keep does not take", r->word[used]);
    if ((double)s->numbers + o.count > MOST_NUMBERS)
        return refuse_line(r, "a run has more than 1e6 numbers", NULL);
    mbsr_study_output *new = mbsri_list_add(&r->sample->arena, &r->outputs, sizeof o);
    if (!new) return refuse_memory(r);
    *new = o;
    s->output = r->outputs.items;
    s->outputs = r->outputs.count;
    s->numbers += o.count;
    return MBSR_OK;
}

static int read_study_line(study_reader *r)
{
    static const struct {
        const char *word;
        int (*read)(study_reader *r);
    } lines[] = {{"model", read_model},  {"run", read_run_words}, {"limit", read_limit},
                 {"vary", read_vary},    {"values", read_values}, {"keep", read_keep},
                 {"sample", read_sample}};
    if (r->words == 0) return MBSR_OK;
    for (size_t k = 0; k < sizeof lines / sizeof *lines; ++k)
        if (says(r->word[0], lines[k].word)) return lines[k].read(r);
    return refuse_line(r, "no line of a study begins with", r->word[0]);
}

/* ---- all of it ---- */

static int finish_study(study_reader *r)
{
    mbsr_study *s = r->study;
    double runs = r->samples;
    if (!r->sample_line) return refuse_line(r, "there is no line of sample", NULL);
    if (s->outputs == 0) return refuse_line(r, "nothing is kept: there is no line of keep", NULL);
    if (s->sampling == MBSR_SAMPLING_LIST)
        runs = s->parameters > 0 ? r->listed.count / s->parameters : 0.0;
    if (s->sampling == MBSR_SAMPLING_GRID) {
        runs = s->parameters > 0;
        for (int k = 0; k < s->parameters; ++k) runs *= s->parameter[k].levels;
    }
    r->line = r->sample_line;
    if (s->parameters == 0)
        return refuse_line(r, "nothing is varied: there is no line of vary", NULL);
    if (!(runs >= 1.0)) return refuse_line(r, "a list needs lines of values", NULL);
    if (runs > MOST_RUNS) return refuse_line(r, "there are more than 1e9 runs", NULL);
    s->runs = (long)runs;
    return mbsri_study_prepare(s, r->sample) ? MBSR_OK : refuse_memory(r);
}

/* The study itself lies in its arena, as what it samples by. */
static mbsr_study *make_study(const mbsr_allocator *allocator, mbsr_study_sample **sample)
{
    static const mbsr_allocator usual;
    mbsri_arena arena;
    mbsri_arena_open(&arena, allocator ? allocator : &usual);
    mbsr_study *study = mbsri_arena_take(&arena, sizeof *study);
    *sample = mbsri_arena_take(&arena, sizeof **sample);
    if (!study || !*sample) {
        mbsri_arena_close(&arena);
        return NULL;
    }
    (*sample)->arena = arena;
    study->sample = *sample;
    return study;
}

int mbsr_study_read(const char *text, size_t size, const char *name,
                    const mbsr_allocator *allocator, mbsr_study **study, mbsr_error *error)
{
    if (study) *study = NULL;
    if (!text || !study) return mbsri_fail_plain(error, MBSR_ERR_NULL, "text or study is NULL");
    study_reader r = {.error = error, .name = name ? name : "study"};
    r.study = make_study(allocator, &r.sample);
    if (!r.study) return refuse_memory(&r);
    mbsri_arena *arena = &r.sample->arena;
    r.word = mbsri_arena_take(arena, WORDS * sizeof *r.word);
    r.study->name = mbsri_arena_text(arena, r.name, strlen(r.name));
    r.study->model = "";
    if (!r.word || !r.study->name) refuse_memory(&r);
    for (const char *at = text, *end = text + size; at < end && !r.status;) {
        if (r.line == INT_MAX) refuse_line(&r, "there are too many lines", NULL);
        ++r.line;
        if (!r.status && !cut_line(&r, &at, end)) read_study_line(&r);
    }
    if (!r.status) finish_study(&r);
    if (r.status)
        mbsr_study_destroy(r.study);
    else
        *study = r.study;
    return r.status;
}

void mbsr_study_destroy(mbsr_study *study)
{
    if (!study) return;
    mbsri_arena arena = study->sample->arena; /* which holds the study */
    mbsri_arena_close(&arena);
}
