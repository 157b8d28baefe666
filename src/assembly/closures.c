/* Closures of a model that is being finished: bodies by index, checks, places of their rows.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "assembly/closures.h"

#include "base/error.h"
#include "base/memory.h"
#include "closures/coupling.h"
#include "closures/springs.h"
#include "model/locked.h"
#include "model/query.h"
#include "recursion/closures.h"

#include <limits.h>

#define REFUSE(status, ...) mbsri_fail(&m->error, status, MBSR_NONE, MBSR_NONE, __VA_ARGS__)

static int find_bodies(mbsr_model *m, int N, mbsri_closure *c, const char *label)
{
    const mbsr_closure_def *def = &c->def;
    for (int k = 0; k < def->bodies; ++k) {
        if (def->body[k] >= N)
            return REFUSE(MBSR_ERR_ID, "%s (%s): is on body %d, but there are only %d bodies",
                          label, def->table->name, def->body[k], N);
        c->body[k] = def->body[k] == MBSR_GROUND ? 0 : m->index[def->body[k]];
    }
    c->bodies = def->bodies;
    const bool moves = m->root.space == MBSR_SPACE_PLANAR || m->root.space == MBSR_SPACE_SPATIAL;
    if (moves && def->table->flags & MBSR_CLOSURE_ROOT) c->body[c->bodies++] = 0;
    c->columns = 0;
    for (int k = 0; k < c->bodies; ++k) {
        const mbsri_body *b = m->body + c->body[k];
        const int columns = b->d + (mbsri_reads_joints(c) ? b->n : 0);
        c->column[k] = columns > 0 ? c->columns : -1;
        c->columns += columns;
    }
    if (c->columns > m->most.columns) m->most.columns = c->columns;
    return MBSR_OK;
}

/* What the library must know of the bodies for what it does without the table's help. */
static int check_kinds(mbsr_model *m, const mbsri_closure *c, const char *label)
{
    const mbsr_closure_table *table = c->def.table;
    for (int k = 0; k < c->bodies; ++k) {
        const mbsri_body *b = m->body + c->body[k];
        if (b->joint.space == MBSR_SPACE_FLEXIBLE)
            return REFUSE(MBSR_ERR_SPACE,
                          "%s (%s): body %d is FLEXIBLE; put the closure on a marker of it", label,
                          table->name, b->id);
        if ((!table->jacobian || !table->bias) && b->joint.space == MBSR_SPACE_GENERAL)
            return REFUSE(MBSR_ERR_SPACE,
                          "%s (%s): body %d is in GENERAL space, where nothing can "
                          "be differenced: the table needs jacobian and bias",
                          label, table->name, b->id);
        const bool plain = (table->flags & MBSR_CLOSURE_PLAIN) ||
                           (mbsri_reads_joints(c) && (!table->jacobian || !table->bias));
        if (plain && c->body[k] > 0 && b->joint.table->coordinate_rates)
            return REFUSE(MBSR_ERR_SPACE,
                          "%s (%s): the coordinates of joint '%s' of body %d have "
                          "rates other than u",
                          label, table->name, b->joint.table->name, b->id);
    }
    return MBSR_OK;
}

/* Of the bodies that the definition names; a root that moves may stand behind them. */
static int common_predecessor(const mbsr_model *m, const mbsri_closure *c)
{
    int at = c->body[0];
    for (int k = 1; k < c->def.bodies; ++k) {
        int other = c->body[k];
        while (at != other) {
            if (at > other)
                at = m->body[at].parent;
            else
                other = m->body[other].parent;
        }
    }
    return at;
}

/* Whether the bodies between this one and those of the closure hand on all motions and forces:
 * POINT bodies know no rotation, and of GENERAL ones nothing is known. */
static bool hands_on(const mbsr_model *m, const mbsri_closure *c, int at)
{
    for (int k = 0; k < c->def.bodies; ++k) {
        for (int i = c->body[k] > at ? m->body[c->body[k]].parent : at; i > at;
             i = m->body[i].parent) {
            const mbsr_space space = m->body[i].joint.space;
            if (space == MBSR_SPACE_POINT || space == MBSR_SPACE_GENERAL) return false;
        }
    }
    return true;
}

/* Joint rates that move the bodies: on the paths from them to the root, or to their nearest common
 * predecessor. */
static int freedoms(const mbsr_model *m, const mbsri_closure *c)
{
    int at[MBSR_CLOSURE_BODIES + 1], sum = 0;
    const bool relative =
        (c->def.table->flags & MBSR_CLOSURE_RELATIVE) && hands_on(m, c, common_predecessor(m, c));
    for (int k = 0; k < c->bodies; ++k) at[k] = c->body[k];
    for (int k = 0; k < c->bodies && !relative; ++k) {
        for (int i = at[k]; i > 0; i = m->body[i].parent) sum += m->body[i].n;
    }
    if (!relative) return sum;
    for (;;) {
        int last = 0; /* the one that stands farthest on, which is no predecessor of the others */
        bool same = true;
        for (int k = 1; k < c->bodies; ++k) {
            same = same && at[k] == at[0];
            if (at[k] > at[last]) last = k;
        }
        if (same) return sum;
        const int i = at[last];
        sum += m->body[i].n;
        for (int k = 0; k < c->bodies; ++k) {
            if (at[k] == i) at[k] = m->body[i].parent;
        }
    }
}

/* Whether the forces of its rows balance among its bodies, so that above these nothing is left. */
static bool balances(const mbsri_closure *c)
{
    const unsigned flags = c->def.table->flags;
    bool fixed = c->def.motion != NULL;
    for (int k = 0; k < c->rows; ++k) fixed = fixed || c->def.stiffness[k] > 0.0;
    if (mbsri_is_coupling(c)) return true;
    return (flags & MBSR_CLOSURE_BALANCED) && !((flags & MBSR_CLOSURE_ROOT) && fixed);
}

/* Where its rows are complete: one that reads the joint of a body waits for that to be passed. */
static int place_of_closing(const mbsr_model *m, const mbsri_closure *c)
{
    const int common = common_predecessor(m, c),
              at = balances(c) && (mbsri_is_coupling(c) || hands_on(m, c, common)) ? common : 0;
    for (int k = 0; k < c->def.bodies && at > 0 && mbsri_reads_joints(c); ++k) {
        if (c->body[k] == at) return m->body[at].parent;
    }
    return at;
}

/* The bodies from those of the closure to where it closes. */
static void mark_loop(mbsr_model *m, mbsri_closure *c)
{
    c->meets = place_of_closing(m, c);
    for (int k = 0; k < c->def.bodies; ++k) {
        for (int i = c->body[k]; i > c->meets; i = m->body[i].parent) m->body[i].loop.spans = true;
    }
    m->body[c->meets].loop.closes = true;
}

/* Those of couplings with the coordinates that their joints have, locked or not. */
static void view_bodies(const mbsr_model *m, const mbsri_closure *c, mbsr_force_body *body)
{
    const mbsri_body_entry *entry = m->entries.data;
    const bool named = mbsri_is_linear_coupling(&c->def);
    for (int k = 0; k < c->bodies; ++k) {
        const mbsri_body *b = m->body + c->body[k];
        body[k] = (mbsr_force_body){.id = b->id,
                                    .space = b->joint.space,
                                    .d = b->d,
                                    .np = b->np,
                                    .n = b->n,
                                    .nq = b->nq,
                                    .locked_at = b->lock.given_at};
        if (named && c->body[k] > 0) body[k].n = entry[b->id].joint.n;
    }
}

static int check_rows_of_table(mbsr_model *m, mbsri_closure *c, const char *label)
{
    const mbsr_closure_table *table = c->def.table;
    mbsr_force_body body[MBSR_CLOSURE_BODIES + 1];
    const mbsr_closure_args args = {.closure = &c->def, .bodies = c->bodies, .body = body};
    char text[MBSR_TEXT_SIZE] = "";
    view_bodies(m, c, body);
    c->rows = c->def.rows;
    c->position_rows = c->def.position_rows;
    int status = table->check ? table->check(&args, text) : MBSR_OK;
    if (!status && table->count) status = table->count(&args, &c->rows, &c->position_rows);
    if (status)
        return REFUSE(status, "%s (%s): %.150s", label, table->name,
                      text[0] ? text : mbsr_status_text(status));
    if (c->rows < 1 || c->rows > MBSR_CLOSURE_ROWS || c->position_rows < 0 ||
        c->position_rows > c->rows || (c->position_rows > 0 && !table->position) ||
        (c->position_rows < c->rows && !table->jacobian))
        return REFUSE(MBSR_ERR_VALUE, "%s (%s): count gave %d rows, %d of them position rows",
                      label, table->name, c->rows, c->position_rows);
    if (c->def.compliant != 0 && c->def.compliant != c->position_rows)
        return REFUSE(MBSR_ERR_VALUE, "%s (%s): compliant is %d, but it has %d position rows",
                      label, table->name, c->def.compliant, c->position_rows);
    c->mix = c->mixture > 0 ? (const double *)m->stored.matrices.data + c->mixture : NULL;
    for (int k = c->position_rows; k < MBSR_CLOSURE_ROWS; ++k) {
        if (c->def.stiffness[k] > 0.0)
            return REFUSE(MBSR_ERR_VALUE,
                          "%s (%s): stiffness[%d] is %g, but it has %d position "
                          "rows",
                          label, table->name, k, c->def.stiffness[k], c->position_rows);
    }
    return MBSR_OK;
}

/* Of couplings, what is left of them where coordinates are locked. */
static int hold(mbsr_model *m, int N, mbsri_closure *c, const char *label)
{
    char text[MBSR_TEXT_SIZE] = "";
    const int status = mbsri_coupling_left(m, c, text);
    if (status) return REFUSE(status, "%s (%s): %.150s", label, c->def.table->name, text);
    if (c->given == 0) return MBSR_OK;
    if (c->def.bodies == 0) c->rows = c->position_rows = 0;
    return find_bodies(m, N, c, label);
}

static int resolve(mbsr_model *m, int N, int id)
{
    mbsri_closure *c = (mbsri_closure *)m->closures.data + id;
    char label[MBSRI_LABEL];
    mbsri_closure_label(m, id, label);
    int status = find_bodies(m, N, c, label);
    if (!status) status = check_kinds(m, c, label);
    if (!status) status = check_rows_of_table(m, c, label);
    if (!status) status = hold(m, N, c, label);
    if (status) return status;
    if (c->rows > 0 && freedoms(m, c) == 0)
        return REFUSE(MBSR_ERR_VALUE,
                      "%s (%s): no joint with a freedom stands between its bodies, "
                      "which it can neither hold nor bring together",
                      label, c->def.table->name);
    if (m->rows > INT_MAX / 8 - c->rows)
        return REFUSE(MBSR_ERR_VALUE, "mbsr_model_finish: too many rows of closures");
    c->row = m->rows;
    c->position_row = m->position_rows;
    c->at = m->size_c;
    m->rows += c->rows;
    m->position_rows += c->position_rows;
    m->size_c += (size_t)c->rows * (size_t)c->columns;
    if (c->rows > 0) mark_loop(m, c);
    return MBSR_OK;
}

/* Springs that ask for it become closures, behind those that were added. */
static int add_springs(mbsr_model *m)
{
    mbsri_force *force = m->forces.data;
    for (size_t k = 0; k < m->forces.count; ++k, ++force) {
        if (force->def.as_closure == 0 || force->resting) continue;
        int body[2] = {MBSR_GROUND, MBSR_GROUND};
        mbsr_space space[2] = {MBSR_SPACE_FIXED, MBSR_SPACE_FIXED};
        for (int l = 0; l < force->def.bodies; ++l) {
            body[l] = ((const int *)m->stored.lists.data)[force->list + (size_t)l];
            space[l] = m->body[m->stored.list_index[force->list + (size_t)l]].joint.space;
        }
        if (!mbsri_reserve(&m->allocator, &m->closures, 1, sizeof(mbsri_closure)))
            return REFUSE(MBSR_ERR_NO_MEMORY, "mbsr_model_finish: no memory");
        force->closure = (int)m->closures.count;
        ((mbsri_closure *)m->closures.data)[m->closures.count++] =
            (mbsri_closure){.def = mbsri_spring_closure(&force->def, body, space),
                            .name = force->name,
                            .force = force->id};
    }
    return MBSR_OK;
}

void mbsri_closures_forget(mbsr_model *m)
{
    mbsri_closure *first = m->closures.data;
    for (size_t k = 0; k < m->closures.count; ++k) {
        first[k].def = *mbsri_closure_as_given(m, first + k);
        first[k].given = 0;
    }
    m->given.closures.count = 0;
    while (m->closures.count > 0 && first[m->closures.count - 1].force != MBSR_NONE)
        --m->closures.count;
}

int mbsri_closures_resolve(mbsr_model *m, int N)
{
    int status = add_springs(m);
    for (int id = 0; id < (int)m->closures.count && !status; ++id) status = resolve(m, N, id);
    return status;
}
