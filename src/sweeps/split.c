/* A tree in parts for several threads: see split.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "sweeps/split.h"

#include "base/error.h"
#include "base/memory.h"
#include "base/threads.h"

#include <stdint.h>
#include <string.h>

#if !defined(__STDC_NO_ATOMICS__)
#include <stdatomic.h>
#endif

/* Subtrees of fewer bodies are left to the trunk, those of more do not fit into a core's cache;
 * tasks of fewer are not worth a thread. */
enum { LEAST_CUT = 32, MOST_CUT = 1024, LEAST_TASK = 512, TASKS_A_WORKER = 4 };

/* A subtree, and where its sweep to the root stands. */
typedef struct cut {
    mbsri_part_state state;
    int first, last;
    int known; /* its motion is known */
    int idle[5];
} cut;
MBSRI_CHECK_LAYOUT(cut);

/* Subtrees that are swept by one thread one after the other; 0 or what was not served. */
typedef struct task {
    int first, last, status;
} task;

struct mbsr_split {
    const mbsr_model *model;
    const mbsri_sweeps *tree;
    mbsr_parallel parallel;
    mbsr_allocator allocator;
    int cuts, tasks;
    cut *cut;            /* cuts in the order of the sweeps, and where the trunk stands */
    task *task;          /* tasks */
    mbsri_carry *stack;  /* depth of each task, and of the trunk */
    mbsri_carry *noises; /* as many: W */
    mbsri_flow *flows;   /* as many: flows of the momentum form */
    void *block;         /* memory of these arrays */
};

/* What tasks raise and look at beside each other: no result depends on when they see it. */
#if !defined(__STDC_NO_ATOMICS__)
typedef atomic_bool flag;
#else
typedef volatile bool flag;
#endif

/* A sweep that is shared out. */
typedef struct sweep {
    const mbsri_sweep_run *run;
    mbsr_split *split;
    bool velocity, exact;
    flag *unclear; /* some rank: the others need not go on */
} sweep;

/* ---- where a tree is cut ---- */

/* What is known of a subtree. */
typedef struct branch {
    int last;          /* its last body */
    int heavy, second; /* bodies in the largest and in the next of the subtrees on its first body */
    int way, way_on; /* bodies on the way to where two large subtrees or many stand, or next to that
                      * way; of the largest subtree on it; NO_WAY where there is no such place */
} branch;

enum { NO_WAY = 1 << 30 };

static void measure_branches(const mbsri_sweeps *tree, branch *list)
{
    for (int i = 0; i <= tree->bodies; ++i) list[i] = (branch){.last = i, .way_on = NO_WAY};
    for (int i = tree->bodies; i >= 1; --i) {
        branch *b = list + i, *pred = list + tree->body[i].parent;
        const int size = b->last - i + 1;
        b->way = b->second >= LEAST_TASK || b->heavy < size / 2 ? 0
                 : b->way_on < NO_WAY                           ? size - b->heavy + b->way_on
                                                                : NO_WAY;
        if (pred->last < b->last) pred->last = b->last;
        if (size > pred->heavy) {
            pred->second = pred->heavy;
            pred->heavy = size;
            pred->way_on = b->way;
        } else if (size > pred->second) {
            pred->second = size;
        }
    }
}

/* Subtrees that are no part of such a one: of at most `most` bodies, or larger but in one piece;
 * returns how many, and the bodies in them. found may be NULL. */
static int find_cuts(const mbsri_sweeps *tree, const branch *list, int most, cut *found,
                     int *bodies)
{
    int cuts = 0;
    *bodies = 0;
    for (int i = 1; i <= tree->bodies; ++i) {
        const int size = list[i].last - i + 1;
        if (size < LEAST_CUT || (size > most && list[i].way <= size / 4)) continue;
        if (found) {
            found[cuts].first = i;
            found[cuts].last = list[i].last;
        }
        ++cuts;
        *bodies += size;
        i = list[i].last;
    }
    return cuts;
}

/* Cuts side by side until they are `enough` bodies; task may be NULL. */
static int find_tasks(const cut *found, int cuts, int enough, task *tasks)
{
    int count = 0, bodies = 0, first = 0;
    for (int k = 0; k < cuts; ++k) {
        bodies += found[k].last - found[k].first + 1;
        if (bodies < enough && k < cuts - 1) continue;
        if (tasks) tasks[count] = (task){first, k, 0};
        ++count;
        first = k + 1;
        bodies = 0;
    }
    return count;
}

/* Whether the sweeps of this tree are nothing but loops over its bodies. */
static bool may_be_split(const mbsri_sweeps *tree)
{
    return tree && tree->blocks == 0 && tree->users == 0 && !tree->whole && !tree->with_loops &&
           !tree->body_forces;
}

/* ---- memory ---- */

static void *next_place(uintptr_t *next, size_t size)
{
    void *here = (void *)*next;
    *next += (size + 63) / 64 * 64;
    return here;
}

/* From `base` on, a multiple of 64; returns the size. */
static size_t lay_out_split(mbsr_split *s, uintptr_t base)
{
    const size_t depth = (size_t)s->tree->depth * ((size_t)s->tasks + 1);
    uintptr_t next = base;
    s->cut = next_place(&next, ((size_t)s->cuts + 1) * sizeof *s->cut);
    s->stack = next_place(&next, depth * sizeof *s->stack);
    s->noises = next_place(&next, depth * sizeof *s->noises);
    s->flows = next_place(&next, depth * sizeof *s->flows);
    s->task = next_place(&next, (size_t)s->tasks * sizeof *s->task);
    return (size_t)(next - base);
}

/* False without memory. Trees of which less than a half would be in two or more tasks stay whole.
 */
static bool cut_up(mbsr_split *s)
{
    const mbsri_sweeps *tree = s->tree;
    const int shares = TASKS_A_WORKER * s->parallel.workers,
              share = tree->bodies / shares > LEAST_TASK ? tree->bodies / shares : LEAST_TASK,
              most = share < MOST_CUT ? share : MOST_CUT;
    branch *list = mbsri_allocate(&s->allocator, ((size_t)tree->bodies + 1) * sizeof *list);
    if (!list) return false;
    int bodies;
    size_t size;
    bool memory = true;
    measure_branches(tree, list);
    s->cuts = find_cuts(tree, list, most, NULL, &bodies);
    s->tasks = s->cuts; /* at most */
    if (s->cuts > 1 && bodies > tree->bodies / 2 && s->parallel.workers > 1) {
        size = lay_out_split(s, 0);
        s->block = mbsri_allocate(&s->allocator, size + 64);
        memory = s->block != NULL;
        if (memory) {
            lay_out_split(s, ((uintptr_t)s->block + 63) / 64 * 64);
            memset(s->cut, 0, ((size_t)s->cuts + 1) * sizeof *s->cut);
            find_cuts(tree, list, most, s->cut, &bodies);
            s->tasks = find_tasks(s->cut, s->cuts, share / 2, s->task);
        }
    } else {
        s->tasks = s->cuts = 0;
    }
    if (s->tasks < 2) s->tasks = 0;
    mbsri_release(&s->allocator, list);
    return memory;
}

int mbsr_split_create(const mbsr_model *model, const mbsr_parallel *parallel, mbsr_split **split,
                      mbsr_error *error)
{
    static const char function[] = "mbsr_split_create";
    if (split) *split = NULL;
    if (!model || !split) {
        return mbsri_fail(error, MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE, "%s: %s is NULL", function,
                          !model ? "model" : "split");
    }
    const int refused = mbsri_parallel_check(parallel, function, error);
    if (refused) return refused;
    if (!model->finished) {
        return mbsri_fail(error, MBSR_ERR_UNFINISHED, MBSR_NONE, MBSR_NONE,
                          "%s: the model is not finished", function);
    }
    mbsr_split *s = mbsri_allocate(&model->allocator, sizeof *s);
    if (s) {
        *s = (mbsr_split){.model = model,
                          .tree = model->tree.evaluated,
                          .parallel = *parallel,
                          .allocator = model->allocator};
    }
    if (!s || (may_be_split(s->tree) && !cut_up(s))) {
        mbsri_release(&model->allocator, s);
        return mbsri_fail(error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                          "%s: no memory for a tree of %d bodies", function, model->bodies);
    }
    *split = s;
    return MBSR_OK;
}

void mbsr_split_destroy(mbsr_split *split)
{
    if (!split) return;
    const mbsr_allocator allocator = split->allocator;
    mbsri_release(&allocator, split->block);
    mbsri_release(&allocator, split);
}

int mbsr_split_tasks(const mbsr_split *split)
{
    return split ? split->tasks : 0;
}

int mbsr_data_use_split(mbsr_data *data, mbsr_split *split)
{
    if (!data) return MBSR_ERR_NULL;
    if (split && split->model != data->model) {
        return mbsri_fail(&data->error, MBSR_ERR_MISMATCH, MBSR_NONE, MBSR_NONE,
                          "mbsr_data_use_split: the split belongs to another model");
    }
    data->split = split;
    return MBSR_OK;
}

mbsr_split *mbsri_split_of(const mbsri_sweep_run *run)
{
    mbsr_split *split = run->data->split;
    return split && split->tasks > 0 && split->tree == run->tree ? split : NULL;
}

/* ---- sweeps in parts ---- */

/* Angles of bodies first .. last. */
static void find_angles(const mbsri_sweep_run *run, int first, int last)
{
    const mbsri_sweeps *tree = run->tree;
    const int all = tree->first_angle + tree->angles;
    int from = tree->body[first].q, to = last < tree->bodies ? tree->body[last + 1].q : all;
    if (from < tree->first_angle) from = tree->first_angle;
    if (to > all) to = all;
    if (from < to) tree->kernels->trigonometry(to - from, run->q + from, run->sincos + 2 * from);
}

/* The trunk between cuts k - 1 and k: bodies *first .. *last, none where *first > *last. */
static void gap(const mbsr_split *s, int k, int *first, int *last)
{
    *first = k > 0 ? s->cut[k - 1].last + 1 : 1;
    *last = k < s->cuts ? s->cut[k].first - 1 : s->tree->bodies;
}

/* Empty stacks of the k-th task, or of the trunk after all. */
static void open_stacks(mbsr_split *s, int k, mbsri_part_state *state)
{
    state->stack = s->stack + (size_t)k * (size_t)s->tree->depth;
    state->noises = s->noises + (size_t)k * (size_t)s->tree->depth;
    state->flows = s->flows + (size_t)k * (size_t)s->tree->depth;
}

int mbsri_split_move(const mbsri_sweep_run *run, mbsr_split *split, bool velocity)
{
    int status = 0, first, last;
    for (int k = 0; k <= split->cuts && !status; ++k) {
        gap(split, k, &first, &last);
        if (first > last) continue;
        find_angles(run, first, last);
        status = run->tree->kernels->parts->move(run, first, last, velocity);
    }
    return status;
}

/* 0, 1 or MBSRI_NOT_SERVED, as mbsri_split_backward. */
static int backward_of(const sweep *w, cut *c)
{
    const mbsri_sweep_run *run = w->run;
    const mbsri_part_kernels *parts = run->tree->kernels->parts;
    if (!c->known) {
        find_angles(run, c->first, c->last);
        if (parts->move(run, c->first, c->last, w->velocity)) return MBSRI_NOT_SERVED;
        c->known = 1;
    }
    if (!parts->backward(run, c->first, c->last, w->exact, true, &c->state)) return 1;
    if (!run->p) return 0;
    parts->momentum(run, c->first, c->last, true, &c->state);
    parts->balance(run, c->first, c->last);
    return 0;
}

static void backward_task(void *arg, int k)
{
    const sweep *w = arg;
    task *t = w->split->task + k;
    t->status = 0;
    for (int l = t->first; l <= t->last; ++l) {
        cut *c = w->split->cut + l;
        if (!w->exact) c->known = 0; /* exact sweeps come second */
        if (*w->unclear) {
            t->status = t->status > 1 ? t->status : 1;
            continue;
        }
        open_stacks(w->split, k, &c->state);
        const int status = backward_of(w, c);
        if (status) *w->unclear = true;
        if (status > t->status) t->status = status;
    }
}

/* The largest status of all tasks. */
static int run_parts(const sweep *w, mbsr_task_fn work)
{
    const mbsr_split *s = w->split;
    int status = 0;
    s->parallel.run(s->parallel.user, s->tasks, work, (void *)w);
    for (int k = 0; k < s->tasks; ++k) {
        if (s->task[k].status > status) status = s->task[k].status;
    }
    return status;
}

static bool trunk_backward(const mbsri_sweep_run *run, mbsr_split *s, bool exact,
                           mbsri_part_state *at)
{
    const mbsri_part_kernels *parts = run->tree->kernels->parts;
    int first, last;
    for (int k = s->cuts; k >= 0; --k) {
        gap(s, k, &first, &last);
        if (first <= last && !parts->backward(run, first, last, exact, false, at)) return false;
        if (k == 0) break;
        at->carry = s->cut[k - 1].state.carry;
        at->noise = s->cut[k - 1].state.noise;
        parts->join_backward(run->tree->body[s->cut[k - 1].first].flags, exact, at);
    }
    return true;
}

static void trunk_momentum(const mbsri_sweep_run *run, mbsr_split *s, mbsri_part_state *at)
{
    const mbsri_part_kernels *parts = run->tree->kernels->parts;
    int first, last;
    for (int k = s->cuts; k >= 0; --k) {
        gap(s, k, &first, &last);
        if (first <= last) {
            parts->momentum(run, first, last, false, at);
            parts->balance(run, first, last);
        }
        if (k == 0) break;
        at->flow = s->cut[k - 1].state.flow;
        parts->join_momentum(run->tree->body[s->cut[k - 1].first].flags, at);
    }
}

static int back(const sweep *w)
{
    mbsr_split *s = w->split;
    *w->unclear = false;
    const int status = run_parts(w, backward_task);
    if (status) return status;
    mbsri_part_state *trunk = &s->cut[s->cuts].state;
    open_stacks(s, s->tasks, trunk);
    if (!trunk_backward(w->run, s, w->exact, trunk)) return 1;
    if (w->run->p) trunk_momentum(w->run, s, trunk);
    return 0;
}

int mbsri_split_backward(const mbsri_sweep_run *run, mbsr_split *split, bool velocity)
{
    flag unclear;
    sweep w = {run, split, velocity, false, &unclear};
    int status = back(&w);
    w.exact = true;
    if (status == 1) status = back(&w);
    return status;
}

static void forward_task(void *arg, int k)
{
    const sweep *w = arg;
    const task *t = w->split->task + k;
    for (int l = t->first; l <= t->last; ++l) {
        const cut *c = w->split->cut + l;
        w->run->tree->kernels->parts->forward(w->run, c->first, c->last);
    }
}

void mbsri_split_forward(const mbsri_sweep_run *run, mbsr_split *split)
{
    const sweep w = {run, split, false, false, NULL};
    int first, last;
    for (int k = 0; k <= split->cuts; ++k) {
        gap(split, k, &first, &last);
        if (first <= last) run->tree->kernels->parts->forward(run, first, last);
    }
    (void)run_parts(&w, forward_task);
}

/* ---- inverse dynamics ---- */

static void inverse_task(void *arg, int k)
{
    const sweep *w = arg;
    const mbsri_sweep_run *run = w->run;
    const mbsri_part_kernels *parts = run->tree->kernels->parts;
    task *t = w->split->task + k;
    t->status = 0;
    for (int l = t->first; l <= t->last; ++l) {
        cut *c = w->split->cut + l;
        open_stacks(w->split, k, &c->state);
        find_angles(run, c->first, c->last);
        const int status = parts->accelerate(run, c->first, c->last);
        if (status)
            t->status = MBSRI_NOT_SERVED;
        else
            parts->loads(run, c->first, c->last, true, &c->state);
    }
}

int mbsri_split_inverse(const mbsri_sweep_run *run, mbsr_split *split)
{
    const mbsri_part_kernels *parts = run->tree->kernels->parts;
    const sweep w = {run, split, false, false, NULL};
    int first, last, status = 0;
    for (int k = 0; k <= split->cuts && !status; ++k) {
        gap(split, k, &first, &last);
        if (first > last) continue;
        find_angles(run, first, last);
        status = parts->accelerate(run, first, last);
    }
    if (!status) status = run_parts(&w, inverse_task);
    if (status) return status;
    mbsri_part_state *at = &split->cut[split->cuts].state;
    open_stacks(split, split->tasks, at);
    for (int k = split->cuts; k >= 0; --k) {
        gap(split, k, &first, &last);
        if (first <= last) parts->loads(run, first, last, false, at);
        if (k == 0) break;
        at->flow = split->cut[k - 1].state.flow;
        parts->join_loads(run->tree->body[split->cut[k - 1].first].flags, at);
    }
    return 0;
}
