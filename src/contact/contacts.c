/* The object of all shapes: adding, and what may touch what.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "algebra/space3.h"
#include "base/cookie.h"
#include "contact/core.h"
#include "contact/error.h"
#include "contact/near.h"

#include <stdlib.h>
#include <string.h>

mbsr_shape mbsr_default_shape(void)
{
    return (mbsr_shape){
        .cookie = MBSRI_COOKIE,
        .body = MBSR_GROUND,
        .frame = {{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0}},
        .groups = 1,
        .mask = 1,
        .law = {.stiffness = INFINITY, .exponent = 1.5, .slip = 1e-3, .spin = 1e-2}};
}

int mbsr_contacts_create(mbsr_contacts **contacts, mbsr_error *error)
{
    if (!contacts)
        return mbsri_contact_fail(error, MBSR_ERR_NULL, "mbsr_contacts_create: contacts is NULL");
    *contacts = calloc(1, sizeof **contacts);
    return *contacts
               ? MBSR_OK
               : mbsri_contact_fail(error, MBSR_ERR_NO_MEMORY, "mbsr_contacts_create: no memory");
}

void mbsr_contacts_destroy(mbsr_contacts *contacts)
{
    if (!contacts) return;
    for (int k = 0; k < contacts->count; ++k) {
        free(contacts->shape[k].memory);
        free((void *)contacts->given[k].name);
    }
    void *const memory[] = {contacts->shape, contacts->given, contacts->exclude, contacts->couple,
                            contacts->body,  contacts->first, contacts->member,  contacts->joined};
    for (size_t k = 0; k < sizeof memory / sizeof memory[0]; ++k) free(memory[k]);
    free(contacts);
}

/* Room for one more of `size` bytes. */
static bool make_room(void **data, int count, int *room, size_t size)
{
    if (count < *room) return true;
    const int more = *room > 0 ? 2 * *room : 16;
    void *larger = realloc(*data, (size_t)more * size);
    if (!larger) return false;
    *data = larger;
    *room = more;
    return true;
}

static int lacks_memory(mbsr_error *error, const char *function)
{
    return mbsri_contact_fail(error, MBSR_ERR_NO_MEMORY, "%s: no memory", function);
}

static int check_open(const mbsr_contacts *c, mbsr_error *error, const char *function)
{
    if (!c) return mbsri_contact_fail(error, MBSR_ERR_NULL, "%s: contacts is NULL", function);
    if (c->made)
        return mbsri_contact_fail(error, MBSR_ERR_FINISHED, "%s: the element has been made",
                                  function);
    return MBSR_OK;
}

/* ---- adding ---- */

/* The name of a number of a law that is out of range, and the number; NULL: none is. */
static const char *wrong_in_law(const mbsr_contact_law *law, double *value)
{
    const struct {
        const char *name;
        double value;
        bool good;
    } part[] = {
        {"stiffness", law->stiffness, law->stiffness > 0.0},
        {"exponent", law->exponent, law->exponent >= 1.0 && isfinite(law->exponent)},
        {"damping", law->damping, law->damping >= 0.0 && isfinite(law->damping)},
        {"friction", law->friction, law->friction >= 0.0 && isfinite(law->friction)},
        {"slip", law->slip, (law->slip > 0.0 || law->friction == 0.0) && isfinite(law->slip)},
        {"torsional", law->torsional, law->torsional >= 0.0 && isfinite(law->torsional)},
        {"rolling", law->rolling, law->rolling >= 0.0 && isfinite(law->rolling)},
        {"spin", law->spin,
         (law->spin > 0.0 || (law->torsional == 0.0 && law->rolling == 0.0)) &&
             isfinite(law->spin)},
        {"margin", law->margin, law->margin >= 0.0 && isfinite(law->margin)},
    };
    for (size_t k = 0; k < sizeof part / sizeof part[0]; ++k) {
        *value = part[k].value;
        if (!part[k].good) return part[k].name;
    }
    return NULL;
}

static bool is_frame(const mbsr_frame *f)
{
    double z[3], worst = 0.0;
    for (int k = 0; k < 3; ++k) {
        if (!isfinite(f->x[k])) return false;
        for (int l = 0; l <= k; ++l)
            worst = fmax(worst, fabs(mbsri_dot3(f->R + 3 * k, f->R + 3 * l) - (k == l)));
    }
    for (int k = 0; k < 9; ++k) {
        if (!isfinite(f->R[k])) return false;
    }
    mbsri_cross3(f->R, f->R + 3, z);
    return worst < 1e-6 && mbsri_dot3(z, f->R + 6) > 0.0;
}

static int check_shape(const mbsr_shape *shape, const char *name, mbsr_error *error)
{
    const char *const function = "mbsr_contacts_add";
    double value;
    const char *wrong = wrong_in_law(&shape->law, &value);
    const bool fields = shape->kind == MBSR_SHAPE_HEIGHTS;
    if (shape->kind < MBSR_SHAPE_BOX || shape->kind > MBSR_SHAPE_HEIGHTS)
        return mbsri_contact_fail(error, MBSR_ERR_VALUE, "%s: %s: kind is %d", function, name,
                                  (int)shape->kind);
    if (shape->body < MBSR_GROUND)
        return mbsri_contact_fail(error, MBSR_ERR_ID,
                                  "%s: %s: body is %d, neither a body nor MBSR_GROUND", function,
                                  name, shape->body);
    if (mbsri_is_ground(shape->kind) && shape->body != MBSR_GROUND)
        return mbsri_contact_fail(error, MBSR_ERR_VALUE,
                                  "%s: %s: %s on body %d, but %s are on the ground", function, name,
                                  fields ? "a height field" : "a plane", shape->body,
                                  fields ? "height fields" : "planes");
    if (!is_frame(&shape->frame))
        return mbsri_contact_fail(error, MBSR_ERR_VALUE,
                                  "%s: %s: frame is not right-handed and orthonormal to 1e-6",
                                  function, name);
    if (wrong)
        return mbsri_contact_fail(error, MBSR_ERR_VALUE, "%s: %s: law.%s is %g, out of range",
                                  function, name, wrong, value);
    return MBSR_OK;
}

static void *copy_bytes(unsigned char **at, const void *from, size_t size)
{
    unsigned char *to = *at;
    if (size > 0) memcpy(to, from, size);
    *at += size;
    return size > 0 ? to : NULL;
}

/* The shape with arrays and a name of its own, in one block that begins with the name. */
static bool keep_given(const mbsr_shape *shape, mbsr_shape *given)
{
    const bool mesh = shape->kind == MBSR_SHAPE_MESH, fields = shape->kind == MBSR_SHAPE_HEIGHTS;
    const char *name = shape->name ? shape->name : "";
    const size_t align = sizeof(double), letters = (strlen(name) + align) / align * align,
                 vertices = mesh ? 3 * (size_t)shape->vertices * sizeof(double) : 0,
                 sides = mesh ? 3 * (size_t)shape->triangles * sizeof(int) : 0,
                 heights =
                     fields ? (size_t)shape->rows * (size_t)shape->columns * sizeof(double) : 0;
    unsigned char *at = calloc(1, letters + vertices + sides + heights);
    if (!at) return false;
    *given = *shape;
    given->name = memcpy(at, name, strlen(name));
    at += letters;
    given->vertex = copy_bytes(&at, shape->vertex, vertices);
    given->height = copy_bytes(&at, shape->height, heights);
    given->triangle = copy_bytes(&at, shape->triangle, sides);
    return true;
}

int mbsr_contacts_add(mbsr_contacts *contacts, const mbsr_shape *shape, int *id, mbsr_error *error)
{
    const char *const function = "mbsr_contacts_add";
    mbsr_contacts *c = contacts;
    if (id) *id = MBSR_NONE;
    int status = check_open(c, error, function);
    if (status) return status;
    if (!shape) return mbsri_contact_fail(error, MBSR_ERR_NULL, "%s: shape is NULL", function);
    if (shape->cookie != MBSRI_COOKIE)
        return mbsri_contact_fail(error, MBSR_ERR_NO_DEFAULT,
                                  "%s: shape was not made by mbsr_default_shape", function);
    mbsri_shape now = {.id = c->count,
                       .body = shape->body,
                       .kind = shape->kind,
                       .groups = shape->groups,
                       .mask = shape->mask,
                       .law = shape->law};
    if (shape->name && shape->name[0])
        mbsri_contact_print(now.name, sizeof now.name, "shape '%.38s'", shape->name);
    else
        mbsri_contact_print(now.name, sizeof now.name, "shape %d", c->count);
    status = check_shape(shape, now.name, error);
    if (status) return status;
    memcpy(now.R, shape->frame.R, sizeof now.R);
    memcpy(now.x, shape->frame.x, sizeof now.x);
    char text[MBSR_TEXT_SIZE] = "no memory";
    status = mbsri_core_make(shape, &now, text);
    if (!status && (!make_room((void **)&c->shape, c->count, &c->room, sizeof now) ||
                    !make_room((void **)&c->given, c->count, &c->given_room, sizeof *c->given) ||
                    !keep_given(shape, c->given + c->count)))
        status = MBSR_ERR_NO_MEMORY;
    if (status) {
        free(now.memory);
        return mbsri_contact_fail(error, status, "%s: %s: %.150s", function, now.name, text);
    }
    if (id) *id = c->count;
    c->shape[c->count++] = now;
    return MBSR_OK;
}

int mbsr_contacts_exclude(mbsr_contacts *contacts, int body_a, int body_b, mbsr_error *error)
{
    const char *const function = "mbsr_contacts_exclude";
    const int status = check_open(contacts, error, function);
    if (status) return status;
    if (body_a < MBSR_GROUND || body_b < MBSR_GROUND)
        return mbsri_contact_fail(error, MBSR_ERR_ID, "%s: body_%c is %d", function,
                                  body_a < MBSR_GROUND ? 'a' : 'b',
                                  body_a < MBSR_GROUND ? body_a : body_b);
    if (!make_room((void **)&contacts->exclude, contacts->excluded, &contacts->excluded_room,
                   sizeof *contacts->exclude))
        return lacks_memory(error, function);
    int *to = contacts->exclude[contacts->excluded++];
    to[0] = body_a < body_b ? body_a : body_b;
    to[1] = body_a < body_b ? body_b : body_a;
    return MBSR_OK;
}

int mbsr_contacts_pair(mbsr_contacts *contacts, int shape_a, int shape_b,
                       const mbsr_contact_law *law, mbsr_error *error)
{
    const char *const function = "mbsr_contacts_pair";
    const int status = check_open(contacts, error, function);
    if (status) return status;
    if (shape_a < 0 || shape_b < 0 || shape_a >= contacts->count || shape_b >= contacts->count ||
        shape_a == shape_b)
        return mbsri_contact_fail(error, MBSR_ERR_ID, "%s: shape_a is %d, shape_b %d of %d shapes",
                                  function, shape_a, shape_b, contacts->count);
    double value;
    const char *wrong = law ? wrong_in_law(law, &value) : NULL;
    if (law && !wrong && !isfinite(law->stiffness)) wrong = "stiffness", value = law->stiffness;
    if (wrong)
        return mbsri_contact_fail(
            error, MBSR_ERR_VALUE, "%s: %s and %s: law.%s is %g, out of range", function,
            contacts->shape[shape_a].name, contacts->shape[shape_b].name, wrong, value);
    if (!make_room((void **)&contacts->couple, contacts->couples, &contacts->couples_room,
                   sizeof *contacts->couple))
        return lacks_memory(error, function);
    contacts->couple[contacts->couples++] =
        (mbsr_shape_pair){.a = shape_a < shape_b ? shape_a : shape_b,
                          .b = shape_a < shape_b ? shape_b : shape_a,
                          .never = law == NULL,
                          .law = law ? *law : contacts->shape[shape_a].law};
    return MBSR_OK;
}

int mbsr_contacts_join(mbsr_contacts *contacts, int bodies, const int *joined, mbsr_error *error)
{
    const char *const function = "mbsr_contacts_join";
    const int status = check_open(contacts, error, function);
    if (status) return status;
    if (bodies < 0 || (bodies > 0 && !joined))
        return mbsri_contact_fail(error, joined ? MBSR_ERR_VALUE : MBSR_ERR_NULL,
                                  joined ? "%s: bodies is %d" : "%s: joined is NULL", function,
                                  bodies);
    int(*kept)[2] = malloc(((size_t)bodies + 1) * sizeof *kept);
    if (!kept) return lacks_memory(error, function);
    if (bodies > 0) memcpy(kept, joined, (size_t)bodies * sizeof *kept);
    free(contacts->joined);
    contacts->joined = kept;
    contacts->joined_bodies = bodies;
    return MBSR_OK;
}

/* ---- making the element ---- */

/* Two that may touch need a finite stiffness. */
static int check_stiffness(const mbsr_contacts *c, mbsr_error *error)
{
    for (int a = 0; a < c->count; ++a) {
        if (isfinite(c->shape[a].law.stiffness)) continue;
        for (int b = a + 1; b < c->count; ++b) {
            if (!isfinite(c->shape[b].law.stiffness) && mbsri_may_touch(c, a, b) &&
                !isfinite(mbsri_law_of_shapes(c, a, b).stiffness))
                return mbsri_contact_fail(error, MBSR_ERR_VALUE,
                                          "mbsr_contacts_force: %s and %s may touch, but neither "
                                          "has a finite stiffness",
                                          c->shape[a].name, c->shape[b].name);
        }
    }
    return MBSR_OK;
}

/* How many pairs may touch, up to `most`. */
static int count_touches(const mbsr_contacts *c, size_t most)
{
    size_t pairs = 0;
    for (int a = 0; a < c->count && pairs < most; ++a) {
        for (int b = a + 1; b < c->count && pairs < most; ++b) pairs += mbsri_may_touch(c, a, b);
    }
    return (int)pairs;
}

/* What the shapes are part of, by their bodies, and excluded bodies in the order of a search. */
static void sort_parts(mbsr_contacts *c)
{
    for (int k = 0; k < c->count; ++k) {
        mbsri_shape *s = c->shape + k;
        const bool known = s->body >= 0 && s->body < c->joined_bodies;
        s->part = known ? c->joined[s->body][0] : s->body;
        s->carrier = known ? c->joined[s->body][1] : MBSR_NONE;
    }
    if (c->excluded > 0)
        qsort(c->exclude, (size_t)c->excluded, sizeof *c->exclude, mbsri_compare_excluded);
}

/* Sorts the laws of two shapes; two of the same shapes are refused. */
static int sort_couples(mbsr_contacts *c, mbsr_error *error)
{
    if (c->couples == 0) return MBSR_OK;
    qsort(c->couple, (size_t)c->couples, sizeof *c->couple, mbsri_compare_couples);
    for (int k = 1; k < c->couples; ++k) {
        const mbsr_shape_pair *now = c->couple + k;
        if (mbsri_compare_couples(now - 1, now) == 0)
            return mbsri_contact_fail(error, MBSR_ERR_VALUE,
                                      "mbsr_contacts_force: %s and %s have a law twice",
                                      c->shape[now->a].name, c->shape[now->b].name);
    }
    return MBSR_OK;
}

/* How far out of its surface forces of a shape begin at most. */
static void find_margins(mbsr_contacts *c)
{
    for (int k = 0; k < c->count; ++k) c->shape[k].margin = c->shape[k].law.margin;
    for (int k = 0; k < c->couples; ++k) {
        const mbsr_shape_pair *own = c->couple + k;
        if (own->never) continue;
        c->shape[own->a].margin = fmax(c->shape[own->a].margin, own->law.margin);
        c->shape[own->b].margin = fmax(c->shape[own->b].margin, own->law.margin);
    }
}

static int compare_ids(const void *x, const void *y)
{
    const int a = *(const int *)x, b = *(const int *)y;
    return (a > b) - (a < b);
}

/* The bodies, and the shapes of each. */
static void list_bodies(mbsr_contacts *c)
{
    int used = 0;
    for (int k = 0; k < c->count; ++k) c->body[k] = c->shape[k].body;
    qsort(c->body, (size_t)c->count, sizeof *c->body, compare_ids);
    for (int k = 0; k < c->count; ++k) {
        if (k == 0 || c->body[k] != c->body[used - 1]) c->body[used++] = c->body[k];
    }
    c->bodies = used;
    for (int k = 0; k <= used; ++k) c->first[k] = 0;
    for (int k = 0; k < c->count; ++k) {
        const int *here =
            bsearch(&c->shape[k].body, c->body, (size_t)used, sizeof *c->body, compare_ids);
        c->shape[k].place = (int)(here - c->body);
        ++c->first[c->shape[k].place + 1];
    }
    for (int k = 0; k < used; ++k) c->first[k + 1] += c->first[k];
    for (int k = 0; k < c->count; ++k) c->member[c->first[c->shape[k].place]++] = k;
    for (int k = used; k > 0; --k) c->first[k] = c->first[k - 1];
    c->first[0] = 0;
}

/* Anew where an attempt before failed, since shapes may have been added. */
static bool allocate_lists(mbsr_contacts *c)
{
    const size_t count = (size_t)c->count;
    free(c->body);
    free(c->first);
    free(c->member);
    c->body = calloc(count + 1, sizeof *c->body);
    c->first = calloc(count + 1, sizeof *c->first);
    c->member = calloc(count + 1, sizeof *c->member);
    return c->body && c->first && c->member;
}

int mbsr_contacts_force(mbsr_contacts *contacts, int max_pairs, mbsr_force_def *force,
                        mbsr_error *error)
{
    const char *const function = "mbsr_contacts_force";
    mbsr_contacts *c = contacts;
    if (!c || !force)
        return mbsri_contact_fail(error, MBSR_ERR_NULL, "%s: %s is NULL", function,
                                  c ? "force" : "contacts");
    if (max_pairs < 0 || max_pairs > 1 << 24)
        return mbsri_contact_fail(error, MBSR_ERR_VALUE, "%s: max_pairs is %d", function,
                                  max_pairs);
    if (!c->made) {
        if (!allocate_lists(c)) return lacks_memory(error, function);
        sort_parts(c);
        int status = sort_couples(c, error);
        if (!status) status = check_stiffness(c, error);
        if (status) return status;
        find_margins(c);
        list_bodies(c);
        for (int k = 0; k < c->count; ++k) c->grounds += mbsri_is_ground(c->shape[k].kind);
        const size_t most = max_pairs > 0 ? (size_t)max_pairs : 16 * (size_t)c->count + 64;
        c->most = count_touches(c, most);
        c->made = true;
    }
    *force = mbsr_force_custom(&mbsri_contacts_table, c->bodies, c->body, c);
    return MBSR_OK;
}

int mbsr_contacts_definition(const mbsr_contacts *contacts, mbsr_contacts_def *def)
{
    const mbsr_contacts *c = contacts;
    if (!c || !def) return MBSR_ERR_NULL;
    *def = (mbsr_contacts_def){.shapes = c->count,
                               .excluded = c->excluded,
                               .pairs = c->couples,
                               .bodies = c->joined_bodies,
                               .max_pairs = c->most,
                               .shape = c->given,
                               .exclude = c->excluded > 0 ? c->exclude[0] : NULL,
                               .pair = c->couple,
                               .joined = c->joined_bodies > 0 ? c->joined[0] : NULL};
    return MBSR_OK;
}

const mbsr_force_table *mbsr_contacts_table(void)
{
    return &mbsri_contacts_table;
}
