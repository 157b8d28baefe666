/* Plans as bytes: see plan.h. Each function below describes one record, for writing and for
 * reading.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "fmu/plan.h"

#include "base/error.h"
#include "fmu/stock.h"

#include <mbsrank/closure.h>

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

void mbsri_plan_open(mbsri_unit_plan *plan, const mbsr_allocator *allocator)
{
    *plan = (mbsri_unit_plan){.name = ""};
    mbsri_arena_open(&plan->arena, allocator);
}

void mbsri_plan_close(mbsri_unit_plan *plan)
{
    mbsri_arena_close(&plan->arena);
}

/* As many records as `count` says, which is written or read before them. */
#define PASS_ALL(s, count, list, pass)                                                             \
    do {                                                                                           \
        void *records = (list);                                                                    \
        mbsri_pass_records(s, &(count), &records, sizeof *(list));                                 \
        (list) = records;                                                                          \
        for (int k = 0; k < (count) && !(s)->failed; ++k) pass(s, (list) + k);                     \
    } while (0)

/* ---- parts ---- */

static void pass_link(mbsri_stream *s, mbsri_link *link)
{
    mbsri_pass_int(s, &link->kind);
    mbsri_pass_int(s, &link->index);
    mbsri_pass_int(s, &link->function);
}

static void pass_some_ints(mbsri_stream *s, int count, int *x)
{
    for (int k = 0; k < count; ++k) mbsri_pass_int(s, x + k);
}

/* A joint; its definition is of a fixed size, of which `params` numbers count. */
static void pass_joint(mbsri_stream *s, mbsr_joint *j)
{
    int table = s->writing ? mbsri_fmu_joint_number(j->table) : 0, space = (int)j->space;
    mbsri_pass_int(s, &table);
    mbsri_pass_int(s, &space);
    mbsri_pass_int(s, &j->d);
    mbsri_pass_int(s, &j->np);
    mbsri_pass_int(s, &j->n);
    mbsri_pass_int(s, &j->nq);
    mbsri_pass_int(s, &j->params);
    if (s->failed || j->params < 0 || j->params > MBSR_JOINT_PARAMS) {
        s->failed = true;
        return;
    }
    mbsri_pass_numbers(s, (size_t)j->params, j->param);
    pass_some_ints(s, MBSR_JOINT_OPTIONS, j->option);
    if (s->writing) return;
    j->space = (mbsr_space)space;
    j->table = mbsri_fmu_joint_table(table);
    s->failed = s->failed || !j->table;
}

static void pass_inertia(mbsri_stream *s, mbsr_inertia *i)
{
    int kind = (int)i->kind;
    mbsri_pass_int(s, &kind);
    i->kind = (mbsr_inertia_kind)kind;
    mbsri_pass_number(s, &i->mass);
    mbsri_pass_numbers(s, 3, i->com);
    mbsri_pass_number(s, &i->moment);
    mbsri_pass_numbers(s, 6, i->tensor);
    mbsri_pass_int(s, &i->unchecked);
    mbsri_pass_int(s, &i->exact);
    mbsri_pass_numbers(s, 3, i->com_rest);
    mbsri_pass_numbers(s, 6, i->tensor_rest);
    mbsri_pass_number(s, &i->lost);
    mbsri_pass_int(s, &i->d);
    if (i->d < 0 || i->d > MBSR_MAX_D) s->failed = true;
    if (!s->failed) mbsri_pass_array(s, (size_t)i->d * (size_t)i->d, &i->matrix);
}

static void pass_body(mbsri_stream *s, mbsri_plan_body *b)
{
    if (!s->writing) b->def = mbsr_default_body_def();
    mbsri_pass_text(s, &b->def.name);
    mbsri_pass_int(s, &b->def.parent);
    pass_joint(s, &b->def.joint);
    pass_inertia(s, &b->def.inertia);
    pass_link(s, &b->link);
    mbsri_pass_int(s, &b->flex);
    mbsri_pass_int(s, &b->joint_n);
    mbsri_pass_int(s, &b->drops);
    mbsri_pass_int(s, &b->armatures);
    const int d = b->def.joint.d;
    if (b->joint_n < 0 || b->joint_n > MBSR_MAX_D || d < 0 || d > MBSR_MAX_D || b->armatures < 0 ||
        b->armatures > MBSR_MAX_D)
        s->failed = true;
    if (s->failed) return;
    const double *armature = b->armature;
    mbsri_pass_array(s, (size_t)b->joint_n, &b->locked_at);
    mbsri_pass_array(s, (size_t)d * (size_t)d, &b->added);
    mbsri_pass_array(s, (size_t)b->armatures, &armature);
    b->armature = (double *)armature;
}

static void pass_force(mbsri_stream *s, mbsri_plan_force *f)
{
    int table = s->writing ? mbsri_fmu_force_number(f->def.table) : 0;
    if (!s->writing) f->def = mbsr_default_force_def();
    mbsri_pass_int(s, &table);
    if (!s->writing) f->def.table = mbsri_fmu_force_table(table);
    mbsri_pass_text(s, &f->def.name);
    mbsri_pass_int(s, &f->def.bodies);
    if (f->def.bodies < 0 || !f->def.table) s->failed = true;
    if (s->failed) return;
    pass_some_ints(s, 2, f->def.body);
    mbsri_pass_ints(s, (size_t)f->def.bodies, &f->def.body_list);
    mbsri_pass_numbers(s, MBSR_FORCE_PARAMS, f->def.param);
    pass_some_ints(s, MBSR_FORCE_OPTIONS, f->def.option);
    mbsri_pass_int(s, &f->def.as_closure);
    pass_link(s, &f->link);
}

static void pass_closure(mbsri_stream *s, mbsri_plan_closure *c)
{
    int table = s->writing ? mbsri_fmu_closure_number(c->def.table) : 0;
    if (!s->writing) c->def = mbsr_default_closure_def();
    mbsri_pass_int(s, &table);
    if (!s->writing) c->def.table = mbsri_fmu_closure_table(table);
    mbsri_pass_text(s, &c->def.name);
    mbsri_pass_int(s, &c->def.rows);
    mbsri_pass_int(s, &c->def.position_rows);
    mbsri_pass_int(s, &c->def.bodies);
    pass_some_ints(s, MBSR_CLOSURE_BODIES, c->def.body);
    mbsri_pass_numbers(s, MBSR_CLOSURE_PARAMS, c->def.param);
    pass_some_ints(s, MBSR_CLOSURE_OPTIONS, c->def.option);
    mbsri_pass_numbers(s, MBSR_CLOSURE_ROWS, c->def.stiffness);
    mbsri_pass_numbers(s, MBSR_CLOSURE_ROWS, c->def.damping);
    mbsri_pass_int(s, &c->def.settled);
    pass_link(s, &c->link);
    if (!c->def.table) s->failed = true;
}

static void pass_table(mbsri_stream *s, mbsri_plan_table *t)
{
    int kind = (int)t->def.kind, beyond = (int)t->def.beyond;
    if (!s->writing) t->def = mbsr_default_table_def();
    mbsri_pass_int(s, &t->def.points);
    mbsri_pass_int(s, &t->def.columns);
    mbsri_pass_int(s, &kind);
    mbsri_pass_int(s, &beyond);
    t->def.kind = (mbsr_table_kind)kind;
    t->def.beyond = (mbsr_table_beyond)beyond;
    if (t->def.points < 2 || t->def.columns < 1 || t->def.columns > 256) s->failed = true;
    if (s->failed) return;
    mbsri_pass_array(s, (size_t)t->def.points, &t->def.x);
    mbsri_pass_array(s, (size_t)t->def.points * (size_t)t->def.columns, &t->def.value);
}

static void pass_marker(mbsri_stream *s, size_t shapes, mbsr_flex_marker *m)
{
    mbsri_pass_numbers(s, 3, m->frame.x);
    mbsri_pass_numbers(s, 9, m->frame.R);
    mbsri_pass_array(s, 3 * shapes, &m->Phi);
    mbsri_pass_array(s, 3 * shapes, &m->Psi);
}

static void pass_flex(mbsri_stream *s, mbsri_plan_flex *f)
{
    mbsr_flex_def *def = &f->def;
    void *markers = (void *)def->marker;
    if (!s->writing) *def = mbsr_default_flex_def();
    mbsri_pass_int(s, &def->modes);
    mbsri_pass_int(s, &def->dependent);
    mbsri_pass_number(s, &def->mass);
    mbsri_pass_numbers(s, 3, def->c0);
    mbsri_pass_numbers(s, 9, def->N0);
    if (def->modes < 0 || def->modes > MBSR_MAX_MODES || def->dependent < 0 ||
        def->dependent > MBSR_MAX_MODES)
        s->failed = true;
    if (s->failed) return;
    const size_t n = (size_t)def->modes, shapes = n + (size_t)def->dependent;
    mbsri_pass_array(s, 3 * shapes, &def->Ct0);
    mbsri_pass_array(s, 9 * shapes, &def->P0);
    mbsri_pass_array(s, 9 * shapes * shapes, &def->P);
    mbsri_pass_array(s, shapes * shapes, &def->Mf);
    mbsri_pass_array(s, n * n * (size_t)def->dependent, &def->Y);
    mbsri_pass_array(s, n * n, &def->K);
    mbsri_pass_array(s, n * n, &def->D);
    mbsri_pass_records(s, &def->markers, &markers, sizeof(mbsr_flex_marker));
    for (int k = 0; k < def->markers && !s->failed; ++k)
        pass_marker(s, shapes, (mbsr_flex_marker *)markers + k);
    def->marker = markers;
}

static void pass_law(mbsri_stream *s, mbsr_contact_law *law)
{
    double *const numbers[] = {&law->stiffness, &law->exponent, &law->damping,
                               &law->friction,  &law->slip,     &law->torsional,
                               &law->rolling,   &law->spin,     &law->margin};
    for (size_t k = 0; k < sizeof numbers / sizeof *numbers; ++k) mbsri_pass_number(s, numbers[k]);
}

static void pass_shape(mbsri_stream *s, mbsr_shape *shape)
{
    int kind = (int)shape->kind, groups = (int)shape->groups, mask = (int)shape->mask;
    if (!s->writing) *shape = mbsr_default_shape();
    mbsri_pass_text(s, &shape->name);
    mbsri_pass_int(s, &shape->body);
    mbsri_pass_int(s, &kind);
    mbsri_pass_numbers(s, 3, shape->frame.x);
    mbsri_pass_numbers(s, 9, shape->frame.R);
    mbsri_pass_numbers(s, 3, shape->size);
    mbsri_pass_number(s, &shape->rounding);
    mbsri_pass_int(s, &groups);
    mbsri_pass_int(s, &mask);
    pass_law(s, &shape->law);
    shape->kind = (mbsr_shape_kind)kind;
    shape->groups = (unsigned)groups;
    shape->mask = (unsigned)mask;
    if (kind == MBSR_SHAPE_MESH) {
        mbsri_pass_int(s, &shape->vertices);
        mbsri_pass_int(s, &shape->triangles);
        if (shape->vertices < 0 || shape->triangles < 0) s->failed = true;
        if (s->failed) return;
        mbsri_pass_array(s, 3 * (size_t)shape->vertices, &shape->vertex);
        mbsri_pass_ints(s, 3 * (size_t)shape->triangles, &shape->triangle);
    } else if (kind == MBSR_SHAPE_HEIGHTS) {
        mbsri_pass_int(s, &shape->rows);
        mbsri_pass_int(s, &shape->columns);
        if (shape->rows < 0 || shape->columns < 0) s->failed = true;
        if (s->failed) return;
        mbsri_pass_array(s, (size_t)shape->rows * (size_t)shape->columns, &shape->height);
    }
}

static void pass_shape_pair(mbsri_stream *s, mbsr_shape_pair *pair)
{
    mbsri_pass_int(s, &pair->a);
    mbsri_pass_int(s, &pair->b);
    mbsri_pass_int(s, &pair->never);
    pass_law(s, &pair->law);
}

/* Two ids for each of `count`. */
static void pass_twos(mbsri_stream *s, int *count, const int **ids)
{
    mbsri_pass_int(s, count);
    if (*count < 0) s->failed = true;
    if (!s->failed) mbsri_pass_ints(s, 2 * (size_t)*count, ids);
}

static void pass_shapes(mbsri_stream *s, mbsri_plan_shapes *p)
{
    mbsr_contacts_def *def = &p->def;
    mbsr_shape *shape = (mbsr_shape *)def->shape;
    mbsr_shape_pair *pair = (mbsr_shape_pair *)def->pair;
    mbsri_pass_int(s, &def->max_pairs);
    PASS_ALL(s, def->shapes, shape, pass_shape);
    PASS_ALL(s, def->pairs, pair, pass_shape_pair);
    pass_twos(s, &def->excluded, &def->exclude);
    pass_twos(s, &def->bodies, &def->joined);
    def->shape = shape;
    def->pair = pair;
}

/* ---- what an importer sees ---- */

static void pass_input(mbsri_stream *s, mbsri_plan_input *i)
{
    mbsri_pass_text(s, &i->name);
    mbsri_pass_text(s, &i->unit);
    mbsri_pass_number(s, &i->start);
    mbsri_pass_numbers(s, 2, i->range);
}

static void pass_motion(mbsri_stream *s, mbsri_plan_motion *m)
{
    mbsri_pass_int(s, &m->input);
    mbsri_pass_int(s, &m->count);
}

static void pass_site(mbsri_stream *s, mbsri_plan_site *site)
{
    mbsri_pass_text(s, &site->name);
    mbsri_pass_int(s, &site->body);
    mbsri_pass_numbers(s, 3, site->frame.x);
    mbsri_pass_numbers(s, 9, site->frame.R);
}

static void pass_coordinate(mbsri_stream *s, mbsri_plan_coordinate *c)
{
    mbsri_pass_text(s, &c->joint);
    mbsri_pass_int(s, &c->place);
    mbsri_pass_int(s, &c->kind);
    mbsri_pass_number(s, &c->start);
}

/* ---- all of it ---- */

/* Whether links and numbers of inputs lead to what is there. */
static bool plan_leads(const mbsri_unit_plan *p, const mbsri_link *link)
{
    const int most[] = {0, p->tables, p->flexes, p->contacts, p->inputs, p->motions};
    if (link->kind == MBSRI_LINK_NONE) return true;
    return link->kind > 0 && link->kind <= MBSRI_LINK_MOTION && link->index >= 0 &&
           link->index < most[link->kind];
}

static bool is_whole(const mbsri_unit_plan *p)
{
    for (int k = 0; k < p->bodies; ++k)
        if (!plan_leads(p, &p->body[k].link) || p->body[k].flex >= p->flexes) return false;
    for (int k = 0; k < p->forces; ++k) {
        const mbsri_plan_force *f = p->force + k;
        const bool shapes = f->def.table == mbsr_contacts_table();
        if (!plan_leads(p, &f->link) || (f->link.kind == MBSRI_LINK_SHAPES) != shapes) return false;
    }
    for (int k = 0; k < p->closures; ++k)
        if (!plan_leads(p, &p->closure[k].link)) return false;
    for (int k = 0; k < p->motions; ++k) {
        const mbsri_plan_motion *m = p->motion + k;
        if (m->count < 1 || m->count > MBSR_FMU_MOTION_MOST || m->input < 0 ||
            m->input > p->inputs - 3 * m->count)
            return false;
    }
    for (int k = 0; k < p->sites; ++k)
        if (p->site[k].body < 0 || p->site[k].body >= p->bodies) return false;
    return true;
}

static void pass_plan(mbsri_stream *s, mbsri_unit_plan *p)
{
    mbsri_pass_text(s, &p->name);
    mbsri_pass_number(s, &p->rank_tolerance);
    mbsri_pass_number(s, &p->steps.rtol);
    mbsri_pass_number(s, &p->steps.atol);
    mbsri_pass_number(s, &p->steps.fixed_step);
    mbsri_pass_int(s, &p->steps.order);
    mbsri_pass_int(s, &p->outputs);
    mbsri_pass_int(s, &p->model_exchange);
    PASS_ALL(s, p->bodies, p->body, pass_body);
    PASS_ALL(s, p->forces, p->force, pass_force);
    PASS_ALL(s, p->closures, p->closure, pass_closure);
    PASS_ALL(s, p->tables, p->table, pass_table);
    PASS_ALL(s, p->flexes, p->flex, pass_flex);
    PASS_ALL(s, p->contacts, p->shapes, pass_shapes);
    PASS_ALL(s, p->inputs, p->input, pass_input);
    PASS_ALL(s, p->motions, p->motion, pass_motion);
    PASS_ALL(s, p->sites, p->site, pass_site);
    PASS_ALL(s, p->nq, p->q, pass_coordinate);
    PASS_ALL(s, p->nu, p->u, pass_coordinate);
}

static const char magic[] = "mbsrank FMU model";

const unsigned char *mbsri_plan_write(mbsri_unit_plan *plan, size_t *size)
{
    mbsri_stream s = mbsri_stream_write(&plan->arena);
    const char *name = magic, *version = mbsr_version();
    mbsri_pass_text(&s, &name);
    mbsri_pass_text(&s, &version);
    pass_plan(&s, plan);
    int crc = (int)(mbsri_crc32(s.data, s.failed ? 0 : s.size) >> 1);
    mbsri_pass_int(&s, &crc);
    *size = s.size;
    return s.failed ? NULL : s.data;
}

static int no_memory(mbsr_error *error)
{
    return mbsri_fail_plain(error, MBSR_ERR_NO_MEMORY, "no memory for it");
}

int mbsri_plan_read(mbsri_unit_plan *plan, const unsigned char *data, size_t size,
                    mbsr_error *error)
{
    mbsri_stream s = mbsri_stream_read(&plan->arena, data, size);
    const char *name, *version;
    int crc = 0;
    mbsri_pass_text(&s, &name);
    if (plan->arena.failed) return no_memory(error);
    if (s.failed || strcmp(name, magic) != 0)
        return mbsri_fail_plain(error, MBSR_ERR_FILE, "it is no model of an FMU of mbsrank");
    mbsri_pass_text(&s, &version);
    if (plan->arena.failed) return no_memory(error);
    if (strcmp(version, mbsr_version()) != 0)
        return mbsri_fail_plain(error, MBSR_ERR_FILE,
                                "it is of version '%.40s' of mbsrank, not of %s", version,
                                mbsr_version());
    pass_plan(&s, plan);
    const size_t end = s.at;
    mbsri_pass_int(&s, &crc);
    if (plan->arena.failed) return no_memory(error);
    if (s.failed || s.at != size || crc != (int)(mbsri_crc32(data, end) >> 1) || !is_whole(plan))
        return mbsri_fail_plain(error, MBSR_ERR_FILE, "it is damaged, near byte %zu of %zu", s.at,
                                size);
    return MBSR_OK;
}

static bool is_held(const mbsri_plan_body *b, int k)
{
    return b->locked_at && !isnan(b->locked_at[k]);
}

int mbsri_plan_rate(const mbsri_unit_plan *plan, int body, int coordinate)
{
    int at = 0;
    if (body < 0 || body >= plan->bodies || coordinate < 0 ||
        coordinate >= plan->body[body].joint_n || is_held(plan->body + body, coordinate))
        return -1;
    for (int b = 0; b <= body; ++b)
        for (int k = 0; k < (b < body ? plan->body[b].joint_n : coordinate); ++k)
            at += !is_held(plan->body + b, k);
    return at < plan->nu ? at : -1;
}

const char *mbsri_plan_effort(const mbsri_unit_plan *plan, int at)
{
    switch (at >= 0 && at < plan->nu ? plan->u[at].kind : MBSR_COORDINATE_OTHER) {
    case MBSR_COORDINATE_ROTATION: return "N.m";
    case MBSR_COORDINATE_TRANSLATION: return "N";
    default: return "";
    }
}

/* FNV-1a, 64 bits, from two starts */
void mbsri_plan_token(const unsigned char *data, size_t size, char token[MBSRI_TOKEN])
{
    uint64_t hash[2] = {UINT64_C(14695981039346656037), UINT64_C(88172645463325252)};
    for (size_t k = 0; k < size; ++k)
        for (int l = 0; l < 2; ++l) hash[l] = (hash[l] ^ data[k]) * UINT64_C(1099511628211);
    snprintf(token, MBSRI_TOKEN, "%016" PRIx64 "%016" PRIx64, hash[0], hash[1]);
}
