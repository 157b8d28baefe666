/* The front of one step: see assemble.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Everything stands over x of the body: fronts of earlier steps, elements, closures, its own
 * momentum.
 */
#include "newton/front/assemble.h"

#include "algebra/dense.h"
#include "model/query.h"
#include "newton/front/crowd.h"
#include "newton/linear/groups.h"
#include "newton/slopes/relation.h"
#include "recursion/closures.h"

#include <math.h>

typedef mbsri_front_build build;

static double *M_at(const build *b, int row, int column)
{
    return b->M + (size_t)column * (size_t)b->all_rows + row;
}

/* Whether the member's rows and columns are pending: its group is complete further up. */
static bool waits(const mbsri_front *f, int i)
{
    return !mbsri_linear_leads(f->linear, i);
}

/* ---- numbers ---- */

static void add_rows(build *b, int first, int count)
{
    for (int l = 0; l < count; ++l) {
        b->f->rows.at[first + l] = b->all_rows;
        b->row[b->all_rows++] = first + l;
    }
}

static void add_columns(build *b, int first, int count)
{
    for (int l = 0; l < count; ++l) {
        b->f->columns.at[first + l] = b->all_columns;
        b->column[b->all_columns++] = first + l;
    }
}

/* What the rows and columns of a body are: pending until its group is complete. */
static void sort_body(mbsri_front *f, int i, bool pending)
{
    const mbsri_front_names *at = f->names + i;
    const unsigned char own = pending ? MBSRI_FRONT_PENDING : MBSRI_FRONT_OWN;
    for (int l = 0; l < f->model->body[i].n; ++l) {
        f->rows.kind[at->a + l] = f->rows.kind[at->b + l] = f->columns.kind[at->u + l] = own;
        f->columns.kind[at->rates + l] = MBSRI_FRONT_PENDING;
    }
}

static void sort_own(build *b)
{
    const mbsri_group g = mbsri_linear_group(b->f->linear, b->i);
    const bool pending = waits(b->f, b->i);
    sort_body(b->f, b->i, pending);
    for (int l = 1; l < g.members && !pending; ++l) sort_body(b->f, g.member[l], false);
}

static bool lacks_mass(const build *b)
{
    const mbsri_front *f = b->f;
    return b->closes && f->linear->rank[b->i] < (mbsri_linear_group(f->linear, b->i).n);
}

/* Own rows and columns. */
static void list_own(build *b)
{
    const int n = b->b->n, nq = b->b->nq, rank = b->f->linear->rank[b->i];
    add_rows(b, b->at.place, nq);
    add_columns(b, b->at.q, nq);
    add_columns(b, b->at.u, n);
    if (!b->below_massless) {
        add_rows(b, b->at.a, n);
        return;
    }
    add_rows(b, b->at.b, n);
    if (b->closes) {
        add_rows(b, b->at.range_of_a, rank);
        add_columns(b, b->at.range, rank);
    } else {
        add_rows(b, b->at.a, n);
        add_columns(b, b->at.rates, n);
    }
}

/* Whether a number is among those of a body, from `first` on, whose group the step closes: its (a)
 * and u' give way to those in the range of D. */
static bool gives_way(const build *b, int owner, int first, int number)
{
    const mbsri_body *body = b->f->model->body + (owner > 0 ? owner : 0);
    return owner > 0 && b->closes && body->group.head == b->i && number >= first &&
           number < first + body->n;
}

static bool row_gives_way(const build *b, int row)
{
    const int owner = b->f->rows.owner[row];
    return gives_way(b, owner, b->f->names[owner > 0 ? owner : 0].a, row);
}

static bool column_gives_way(const build *b, int column)
{
    const int owner = b->f->columns.owner[column];
    return gives_way(b, owner, b->f->names[owner > 0 ? owner : 0].rates, column);
}

/* What earlier steps hand on. */
static void list_carried(build *b)
{
    const mbsri_front *f = b->f;
    for (int l = 0; l < b->step->children; ++l) {
        const int child = f->plan.child[b->step->first_child + l];
        const mbsri_front_left *left = f->left + child;
        const int *row = f->numbers + f->plan.step[child].numbers, *column = row + left->rows;
        for (int j = left->done; j < left->done + left->carried; ++j) {
            if (!row_gives_way(b, row[j])) add_rows(b, row[j], 1);
            if (!column_gives_way(b, column[j])) add_columns(b, column[j], 1);
        }
    }
}

static bool counts(const mbsri_front *f, const mbsri_closure *c, int k)
{
    return !f->linear->dropped[c->row + k] || mbsri_is_stiff(c, k);
}

static bool holds(const mbsri_front *f, const mbsri_closure *c, int k)
{
    return k < c->position_rows && !f->linear->dropped[c->row + k];
}

/* Whether an element of the plan is a closure: behind forces, before pairs. */
static bool is_closure(const mbsri_front *f, int element)
{
    const int at = element - (int)f->model->forces.count;
    return at >= 0 && at < (int)f->model->closures.count;
}

static const mbsri_closure *closure_of(const mbsri_front *f, int element)
{
    return (const mbsri_closure *)f->model->closures.data + element - (int)f->model->forces.count;
}

static void list_multipliers(build *b)
{
    const mbsri_front *f = b->f;
    for (int l = 0; l < b->step->elements; ++l) {
        const int element = f->plan.element[b->step->first_element + l];
        if (!is_closure(f, element)) continue;
        const mbsri_closure *c = closure_of(f, element);
        for (int r = 0; r < c->rows; ++r) {
            if (!counts(f, c, r)) continue;
            add_rows(b, f->rows.count + c->row + r, 1);
            add_columns(b, f->columns.count + c->row + r, 1);
            if (!holds(f, c, r)) continue;
            add_rows(b, f->rows.count + f->model->rows + c->position_row + r, 1);
            add_columns(b, f->columns.count + f->model->rows + c->position_row + r, 1);
        }
    }
}

/* whole: with its impulse. */
static void list_body(build *b, int i, bool whole)
{
    const mbsri_front *f = b->f;
    const mbsri_body *body = f->model->body + i;
    const mbsri_front_names *at = f->names + i;
    const int impulse = whole ? 0 : body->d;
    add_rows(b, at->y + impulse, mbsri_linear_actions(f->linear, i) - impulse);
    if (f->model->position_rows > 0 && !b->plain) add_rows(b, at->kappa, body->d);
    add_columns(b, at->x, mbsri_linear_motions(f->linear, i));
    if (!f->plan.coordinates[i] || b->plain) return;
    add_rows(b, at->tau, body->n);
    add_rows(b, at->push, body->n);
    add_columns(b, at->q, body->nq);
    add_columns(b, at->u, body->n);
}

/* What the step takes away. */
static void list_rest(build *b)
{
    const mbsri_front *f = b->f;
    const mbsri_group g = mbsri_linear_group(f->linear, b->i);
    add_rows(b, b->at.y, mbsri_linear_actions(f->linear, b->i));
    if (!b->plain) {
        if (f->model->position_rows > 0) add_rows(b, b->at.kappa, b->b->d);
        add_rows(b, b->at.tau, b->b->n);
        add_rows(b, b->at.push, b->b->n);
    }
    add_rows(b, b->at.momentum, b->b->n);
    add_rows(b, b->at.rate, b->b->n);
    add_columns(b, b->at.x, mbsri_linear_motions(f->linear, b->i));
    for (int l = 0; l < g.members && b->closes; ++l) {
        add_rows(b, f->names[g.member[l]].a, f->model->body[g.member[l]].n);
        add_columns(b, f->names[g.member[l]].rates, f->model->body[g.member[l]].n);
    }
}

/* Whether all that is known of the body is y over x: nothing is carried, and there are no elements.
 */
static bool is_plain(const build *b)
{
    const mbsri_front *f = b->f;
    bool plain =
        b->step->elements == 0 && b->step->borders <= 1 && f->model->elements.anywhere == 0;
    for (int l = 0; l < b->step->children && plain; ++l) {
        const int child = f->plan.child[b->step->first_child + l];
        plain = f->left[child].plain;
    }
    return plain;
}

static void list_all(build *b)
{
    const mbsri_front *f = b->f;
    b->all_rows = b->all_columns = 0;
    b->plain = is_plain(b);
    sort_own(b);
    list_own(b);
    b->own = b->all_columns;
    list_carried(b);
    list_multipliers(b);
    b->lacks_mass = lacks_mass(b);
    b->watched = b->watched || b->lacks_mass || b->all_columns > b->own || waits(f, b->i);
    b->size = b->all_columns;
    for (int l = 0; l < b->step->borders; ++l) {
        const mbsri_front_border *border = f->plan.border + b->step->first_border + l;
        list_body(b, border->body, border->whole);
    }
    b->rows = b->all_rows;
    b->columns = b->all_columns;
    list_rest(b);
}

/* ---- what is known over x ---- */

/* All to zero that is added to: column by column, few numbers at a time. */
static void clear(build *b)
{
    const int first = b->f->columns.at[b->at.x],
              behind = first + mbsri_linear_motions(b->f->linear, b->i);
    for (int j = 0; j < b->all_columns; ++j) {
        const bool motion = b->plain && j >= first && j < behind;
        const int row = motion ? b->f->rows.at[b->at.y] : 0,
                  rows = motion ? mbsri_linear_actions(b->f->linear, b->i) : b->all_rows;
        mbsri_zero((size_t)rows, M_at(b, row, j));
    }
}

/* What a plain step hands on. */
static void add_plain(build *b, const double *from)
{
    const int x = mbsri_linear_motions(b->f->linear, b->i),
              y = mbsri_linear_actions(b->f->linear, b->i);
    double *to = M_at(b, b->f->rows.at[b->at.y], b->f->columns.at[b->at.x]);
    for (int l = 0; l < x; ++l, from += y, to += b->all_rows) {
        for (int r = 0; r < y; ++r) to[r] += from[r];
    }
}

static void add_children(build *b)
{
    const mbsri_front *f = b->f;
    for (int l = 0; l < b->step->children; ++l) {
        const int child = f->plan.child[b->step->first_child + l];
        const mbsri_front_left *left = f->left + child;
        const int *row = f->numbers + f->plan.step[child].numbers, *column = row + left->rows;
        const double *from = f->matrices + f->plan.step[child].matrix;
        if (left->plain) {
            add_plain(b, from);
            continue;
        }
        for (int j = left->done; j < left->columns; ++j) {
            double *to = M_at(b, 0, f->columns.at[column[j]]);
            for (int r = left->done; r < left->rows; ++r) to[f->rows.at[row[r]]] += *from++;
        }
    }
}

/* Numbers of an element's columns at one of its bodies: `count` from `first` on. */
typedef struct span {
    int first, count;
} span;

/* Adds a block of an element's derivatives, rows x columns of `from` (stride): forces f on body
 * `on`, and loads on its joint from row d on, if it has any, along the columns. */
static void add_forces(build *b, int on, bool joint, const double *from, int stride, span column)
{
    const mbsri_front *f = b->f;
    const mbsri_body *body = f->model->body + on;
    const mbsri_front_names *at = f->names + on;
    const int d = body->d, sigma = f->rows.at[at->y + d];
    for (int l = 0; l < column.count; ++l) {
        double *to = M_at(b, 0, f->columns.at[column.first + l]);
        const double *force = from + (size_t)l * (size_t)stride;
        for (int r = 0; r < d; ++r) to[sigma + r] -= force[r];
        for (int r = 0; r < d && f->linear->below_massless[on]; ++r) to[sigma + d + r] += force[r];
        for (int r = 0; r < body->n && joint; ++r) to[f->rows.at[at->tau] + r] += force[d + r];
    }
}

/* Whether what body `on` feels by body `by` is for the step: all, or what stands between the body
 * and its predecessor, of whose joint nothing is; of a pair apart what stands on the body alone. */
static bool takes(const build *b, bool apart, int on, int by)
{
    const mbsri_front *f = b->f;
    if (on == 0 || by == 0) return false;
    if (apart) return on == b->i && by == b->i;
    if (!f->served) return true;
    const mbsri_relation relation = mbsri_relate(f->model, on, by);
    return relation != MBSRI_APART && (relation == MBSRI_ABOVE ? by : on) == b->i;
}

/* Element `element` in the call of a body or pair; apart: of a pair apart. */
static int add_element(build *b, int element, int call, bool apart)
{
    const mbsri_front *f = b->f;
    const mbsri_linear *w = f->linear;
    const mbsri_force *force = (const mbsri_force *)f->model->forces.data + element;
    const bool joint = !(force->def.table->flags & MBSR_FORCE_NO_JOINT);
    const int *list, count = mbsri_linear_bodies(w, force, call, &list);
    int rows, columns, column = 0;
    const int status =
        w->whole ? MBSR_OK : mbsri_linear_force(f->linear, b->d, (size_t)element, call);
    if (status) return status;
    const double *matrix = mbsri_linear_element(w, (size_t)element, call, &rows, &columns);
    if (apart) mbsri_front_crowd_keep(b->f, call, b->i, matrix, rows);
    for (int l = 0; l < count; ++l) {
        if (list[l] == 0) continue;
        const mbsri_body *by = f->model->body + list[l];
        const mbsri_front_names *at = f->names + list[l];
        const int x = w->e[list[l]] + by->d;
        int row = 0;
        for (int j = 0; j < count; ++j) {
            const bool above = f->served && list[j] != b->i, below = f->served && list[l] != b->i;
            const double *from = matrix + (size_t)column * (size_t)rows + row;
            if (list[j] == 0) continue;
            if (takes(b, apart, list[j], list[l])) {
                add_forces(b, list[j], joint && !above, from, rows, (span){at->x, x});
                from += (size_t)x * (size_t)rows;
                const int nq = joint && !below ? by->nq : 0, n = joint && !below ? by->n : 0;
                add_forces(b, list[j], joint && !above, from, rows, (span){at->q, nq});
                from += (size_t)by->nq * (size_t)rows;
                add_forces(b, list[j], joint && !above, from, rows, (span){at->u, n});
            }
            row += f->model->body[list[j]].d + f->model->body[list[j]].n;
        }
        column += x + by->nq + by->n;
    }
    return MBSR_OK;
}

/* Row r of a closure: at its bodies, and what its multipliers exert there. */
static void add_row(build *b, const mbsri_closure *c, int r, int l, const double *slope,
                    const double *C)
{
    mbsri_front *f = b->f;
    const int i = c->body[l], first = c->column[l], rows = c->rows;
    const mbsri_body *body = f->model->body + i;
    const mbsri_front_names *at = f->names + i;
    const bool joint = mbsri_reads_joints(c), has_place = holds(f, c, r);
    const int velocity = f->rows.at[f->rows.count + c->row + r],
              lambda = f->columns.count + c->row + r,
              position =
                  has_place ? f->rows.at[f->rows.count + f->model->rows + c->position_row + r] : 0,
              eta = has_place
                        ? f->columns.at[f->columns.count + f->model->rows + c->position_row + r]
                        : 0;
    double *to = M_at(b, 0, f->columns.at[lambda]);
    const int count = body->d + (joint ? body->n : 0);
    for (int j = 0; j < count; ++j) {
        const double read = C[(size_t)(first + j) * (size_t)rows + (size_t)r],
                     turn = slope[(size_t)(first + j) * (size_t)rows + (size_t)r];
        const bool own = j >= body->d;
        const int place = f->columns.at[own ? at->q + j - body->d : at->x + j],
                  rate = f->columns.at[own ? at->u + j - body->d : at->x + f->linear->e[i] + j];
        *M_at(b, velocity, rate) += read;
        *M_at(b, velocity, place) += turn;
        if (has_place) *M_at(b, position, place) += read;
        if (has_place)
            *M_at(b, f->rows.at[own ? at->push + j - body->d : at->kappa + j], eta) += read;
        if (own) {
            to[f->rows.at[at->tau] + j - body->d] += read;
            continue;
        }
        to[f->rows.at[at->y + body->d] + j] -= read;
        if (f->linear->below_massless[i]) to[f->rows.at[at->y + body->d] + body->d + j] += read;
    }
}

static bool at_body(const mbsri_closure *c, int l)
{
    return c->body[l] > 0 && c->column[l] >= 0;
}

static void add_closure(build *b, int element)
{
    mbsri_front *f = b->f;
    const mbsri_closure *c = closure_of(f, element);
    const size_t columns = (size_t)c->columns;
    const mbsri_closure_part of =
        mbsri_linear_closure(f->linear, (size_t)(element - (int)f->model->forces.count));
    const bool joint = mbsri_reads_joints(c);
    for (int l = 0; l < c->bodies; ++l) {
        if (!at_body(c, l)) continue;
        const mbsri_front_names *at = f->names + c->body[l];
        const mbsri_body *by = f->model->body + c->body[l];
        for (int j = 0; j < c->bodies; ++j) {
            if (!at_body(c, j)) continue;
            const double *from = of.S + (size_t)c->column[l] * columns + c->column[j];
            add_forces(b, c->body[j], joint, from, c->columns, (span){at->x, by->d});
            from += (size_t)by->d * columns;
            if (joint) add_forces(b, c->body[j], joint, from, c->columns, (span){at->q, by->n});
        }
        for (int r = 0; r < c->rows; ++r) {
            if (counts(f, c, r)) add_row(b, c, r, l, of.slope, of.C);
        }
    }
    for (int r = 0; r < c->position_rows; ++r) {
        if (!mbsri_is_stiff(c, r)) continue;
        const double compliance = 1.0 / (c->def.stiffness[r] + f->c * c->def.damping[r]);
        const int lambda = f->columns.at[f->columns.count + c->row + r];
        *M_at(b, f->rows.at[f->rows.count + c->row + r], lambda) += f->c * compliance;
        if (holds(f, c, r))
            *M_at(b, f->rows.at[f->rows.count + f->model->rows + c->position_row + r], lambda) +=
                compliance;
    }
}

/* The body's own momentum. */
static void add_own(build *b)
{
    mbsri_front *f = b->f;
    const int x = mbsri_linear_motions(f->linear, b->i), y = mbsri_linear_actions(f->linear, b->i);
    for (int l = 0; l < x; ++l) {
        double *to = M_at(b, f->rows.at[b->at.y], f->columns.at[b->at.x + l]);
        for (int r = 0; r < y; ++r) to[r] += b->terms.P[l * y + r];
    }
}

/* mu over A is -Mbar, of which successors that something else passes have not handed on their part
 * (src/newton/sweeps/reaction.h). */
static void place_masses(build *b)
{
    const int d = b->b->d, mu = b->f->rows.at[b->at.y] + 2 * d,
              A = b->f->columns.at[b->at.x] + b->f->linear->e[b->i] + d;
    const double *Mbar = b->d->Mbar + b->b->dd;
    for (int l = 0; l < d; ++l) {
        double *to = M_at(b, mu, A + l);
        for (int r = 0; r < d; ++r) to[r] = -Mbar[l * d + r];
    }
}

/* Elements and closures that come with the body. A status. */
static int add_elements(build *b)
{
    const mbsri_front *f = b->f;
    int status = MBSR_OK;
    for (int k = 0; k < f->model->elements.anywhere && !status; ++k) {
        const mbsri_force *force = (const mbsri_force *)f->model->forces.data + k;
        if (force->def.table->flags & MBSR_FORCE_EVERY_BODY)
            status = add_element(b, k, b->i, false);
    }
    for (int l = 0; l < b->step->elements && !status; ++l) {
        const int element = f->plan.element[b->step->first_element + l],
                  pair = element - (int)(f->model->forces.count + f->model->closures.count);
        if (is_closure(f, element))
            add_closure(b, element);
        else if (pair >= 0)
            status = add_element(b, f->linear->pairs.pair[pair].force, pair,
                                 f->crowd && f->crowd->apart[pair]);
        else
            status = add_element(b, element, b->i, false);
    }
    return status;
}

int mbsri_front_assemble(mbsri_front *f, mbsr_data *d, int k, bool watched, mbsri_front_build *b)
{
    const mbsri_front_step *step = f->plan.step + k;
    const int i = step->body;
    *b = (mbsri_front_build){.f = f, .d = d, .step = step, .k = k, .i = i, .b = f->model->body + i};
    b->watched = watched;
    b->at = f->names[i];
    b->terms = mbsri_linear_terms(f->linear, i);
    b->below_massless = f->linear->below_massless[i];
    b->closes = b->below_massless && !waits(f, i);
    b->row = f->now.row;
    b->column = f->now.column;
    b->M = f->now.M;
    b->N = f->now.N;
    list_all(b);
    clear(b);
    add_children(b);
    add_own(b);
    if (f->served && b->below_massless) place_masses(b);
    return add_elements(b);
}
