/* The text of a SID file: see sid.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   part
 *     new modal =
 *       refmod   mass, nelastq, ielastq (1) = ...   end refmod
 *       frame    new node = 7   rframe, origin, phi, psi, AP   end node ...   end frame
 *       mdCM     order, nrow, ncol, nq, nqn, structure, m0(i,j) = ..., m1(i,k,j) = ...   end mdCM
 *       ...
 *     end modal
 *   end part
 *
 * Blanks do not count, nor do lower and upper case. Entries that are not there are zero. */
#include "fe/sid.h"

#include <stddef.h>
#include <string.h>

enum { STRUCTURES = 5, SYMMETRIC = 2, UNIT = 4 };

typedef struct parser {
    mbsri_arena *arena;
    mbsri_lines *l;
    mbsri_sid *sid;
    char key[MBSRI_WORD]; /* key of the line: its text before the =, without blanks */
} parser;

/* The key of the next line; what follows the = stays to be read. */
static int next_key(parser *p)
{
    mbsri_lines *l = p->l;
    size_t used = 0;
    if (!mbsri_next_line(l)) return mbsri_refuse_line(l, "the file ends before 'end part'");
    while (l->word < l->stop && *l->word != '=') {
        const char c = *l->word++;
        if (c != ' ' && c != '\t' && c != '\r' && used + 1 < sizeof p->key) p->key[used++] = c;
    }
    if (l->word < l->stop) ++l->word;
    p->key[used] = '\0';
    return MBSR_OK;
}

static bool has_key(const parser *p, const char *key)
{
    return mbsri_same_word(p->key, key);
}

static int wanted(const parser *p, const char *key)
{
    return mbsri_refuse_line(p->l, "'%.40s' where '%s' is wanted", p->key, key);
}

static int expect(parser *p, const char *key)
{
    const int status = next_key(p);
    return status || has_key(p, key) ? status : wanted(p, key);
}

/* The text behind the =. */
static const char *rest_of_line(parser *p)
{
    const char *start = p->l->word, *stop = p->l->stop;
    while (start < stop && (*start == ' ' || *start == '\t')) ++start;
    while (stop > start && (stop[-1] == ' ' || stop[-1] == '\t' || stop[-1] == '\r')) --stop;
    return mbsri_arena_text(p->arena, start, (size_t)(stop - start));
}

/* Indices "(1,2,3)" from `text` on, `count` of them, from 0 below most[]; false: not so. */
static bool read_indices(const char *text, int count, const int *most, int *index)
{
    for (int k = 0; k < count; ++k) {
        if (*text++ != (k ? ',' : '(')) return false;
        int value = 0;
        for (; *text >= '0' && *text <= '9'; ++text) {
            if (value > 100000) return false;
            value = 10 * value + (*text - '0');
        }
        if (value < 1 || value > most[k]) return false;
        index[k] = value - 1;
    }
    return text[0] == ')' && text[1] == '\0';
}

/* ---- matrices ---- */

/* order, nrow, ncol, nq, nqn, structure */
static int read_head(parser *p, const char *name, mbsri_taylor *t, bool first, int *structure)
{
    static const char *const keys[6] = {"order", "nrow", "ncol", "nq", "nqn", "structure"};
    int value[6];
    const int n = p->sid->modes;
    for (int k = 0; k < 6; ++k) {
        const int status = expect(p, keys[k]);
        if (status) return status;
        if (!mbsri_next_integer(p->l, keys[k], value + k) || !mbsri_line_ends(p->l))
            return MBSR_ERR_FILE;
    }
    if (value[1] != t->rows || value[2] != t->columns || value[3] != n)
        return mbsri_refuse_line(p->l, "%s is %d x %d with %d modes, must be %d x %d with %d", name,
                                 value[1], value[2], value[3], t->rows, t->columns, n);
    if (value[5] < 0 || value[5] >= STRUCTURES)
        return mbsri_refuse_line(p->l, "the structure of %s is %d, must be 0 .. 4", name, value[5]);
    *structure = value[5];
    const size_t size = (size_t)t->rows * (size_t)t->columns;
    t->m0 = mbsri_arena_take(p->arena, size * sizeof *t->m0);
    if (!t->m0) return MBSR_ERR_NO_MEMORY;
    if (first && value[0] > 0) {
        t->m1 = mbsri_arena_take(p->arena, size * (size_t)n * sizeof *t->m1);
        if (!t->m1) return MBSR_ERR_NO_MEMORY;
    }
    for (int k = 0; k < t->rows && k < t->columns && *structure == UNIT; ++k)
        t->m0[k * (t->rows + 1)] = 1.0;
    return MBSR_OK;
}

static int read_taylor_entry(parser *p, const char *name, mbsri_taylor *t, int structure)
{
    const bool zeroth = strncmp(p->key, "m0", 2) == 0;
    const int most[3] = {t->rows, zeroth ? t->columns : p->sid->modes, t->columns};
    int index[3];
    double value;
    if ((!zeroth && strncmp(p->key, "m1", 2) != 0) ||
        !read_indices(p->key + 2, zeroth ? 2 : 3, most, index))
        return mbsri_refuse_line(p->l, "'%.40s' is no entry of %s, which is %d x %d", p->key, name,
                                 t->rows, t->columns);
    if (!mbsri_next_number(p->l, "a value", &value) || !mbsri_line_ends(p->l)) return MBSR_ERR_FILE;
    if (zeroth) {
        t->m0[(size_t)index[1] * (size_t)t->rows + (size_t)index[0]] = value;
        if (structure == SYMMETRIC && t->rows == t->columns)
            t->m0[(size_t)index[0] * (size_t)t->rows + (size_t)index[1]] = value;
        return MBSR_OK;
    }
    t->more = t->more || value != 0.0;
    const size_t size = (size_t)t->rows * (size_t)t->columns;
    if (t->m1)
        t->m1[size * (size_t)index[1] + (size_t)index[2] * (size_t)t->rows + (size_t)index[0]] =
            value;
    return MBSR_OK;
}

static int read_matrix(parser *p, const char *name, int rows, int columns, bool first,
                       mbsri_taylor *t)
{
    char end[MBSRI_WORD] = "end";
    int structure;
    if (t->there) return mbsri_refuse_line(p->l, "%s is there twice", name);
    *t = (mbsri_taylor){.there = true, .rows = rows, .columns = columns};
    strncat(end, name, sizeof end - 4);
    int status = read_head(p, name, t, first, &structure);
    while (!status) {
        status = next_key(p);
        if (status || has_key(p, end)) break;
        status = read_taylor_entry(p, name, t, structure);
    }
    return status;
}

/* ---- refmod and frame ---- */

static int read_mode_name(parser *p)
{
    int index;
    if (strlen(p->key) < 7 || !read_indices(p->key + 7, 1, &p->sid->modes, &index))
        return mbsri_refuse_line(p->l, "'%.40s' is no mode of the %d", p->key, p->sid->modes);
    p->sid->name[index] = rest_of_line(p);
    return p->sid->name[index] ? MBSR_OK : MBSR_ERR_NO_MEMORY;
}

static int read_refmod(parser *p)
{
    bool mass = false;
    for (;;) {
        int status = next_key(p), modes;
        if (status) return status;
        if (has_key(p, "endrefmod")) break;
        if (has_key(p, "mass")) {
            mass = true;
            if (!mbsri_next_number(p->l, "the mass", &p->sid->mass) || !mbsri_line_ends(p->l))
                return MBSR_ERR_FILE;
        } else if (has_key(p, "nelastq")) {
            if (!mbsri_next_integer(p->l, "the number of modes", &modes) || !mbsri_line_ends(p->l))
                return MBSR_ERR_FILE;
            if (modes != p->sid->modes)
                return mbsri_refuse_line(p->l, "nelastq is %d, but the first line says %d modes",
                                         modes, p->sid->modes);
        } else if (strncmp(p->key, "ielastq", 7) == 0) {
            status = read_mode_name(p);
            if (status) return status;
        } else {
            return wanted(p, "mass, nelastq, ielastq or end refmod");
        }
    }
    return mass ? MBSR_OK : mbsri_refuse_line(p->l, "refmod has no mass");
}

static int read_node(parser *p)
{
    const int n = p->sid->modes;
    mbsri_sid_node *node = mbsri_list_add(p->arena, &p->sid->nodes, sizeof *node);
    if (!node) return MBSR_ERR_NO_MEMORY;
    if (!mbsri_next_integer(p->l, "the id of a node", &node->id) || !mbsri_line_ends(p->l))
        return MBSR_ERR_FILE;
    for (;;) {
        int status = next_key(p);
        if (status) return status;
        if (has_key(p, "endnode")) break;
        if (has_key(p, "rframe")) continue;
        if (has_key(p, "origin"))
            status = read_matrix(p, "origin", 3, 1, true, &node->origin);
        else if (has_key(p, "phi"))
            status = read_matrix(p, "phi", 3, n, false, &node->phi);
        else if (has_key(p, "psi"))
            status = read_matrix(p, "psi", 3, n, false, &node->psi);
        else if (has_key(p, "AP"))
            status = read_matrix(p, "AP", 3, 3, false, &node->AP);
        else
            status = wanted(p, "rframe, origin, phi, psi, AP or end node");
        if (status) return status;
    }
    if (!node->origin.there || !node->phi.there)
        return mbsri_refuse_line(p->l, "node %d has no %s", node->id,
                                 node->origin.there ? "phi" : "origin");
    return MBSR_OK;
}

static int read_frame(parser *p)
{
    for (;;) {
        int status = next_key(p);
        if (status || has_key(p, "endframe")) return status;
        status = has_key(p, "newnode") ? read_node(p) : wanted(p, "new node or end frame");
        if (status) return status;
    }
}

/* ---- all ---- */

static int read_block(parser *p)
{
    mbsri_sid *sid = p->sid;
    const int n = sid->modes;
#define READ(name, rows, columns, first, must)                                                     \
    if (has_key(p, #name)) return read_matrix(p, #name, rows, columns, first, &sid->name);
    MBSRI_SID_BLOCKS(READ)
#undef READ
    return mbsri_refuse_line(p->l, "'%.40s' is nothing that a SID file has", p->key);
}

/* "nodes modes: any text" */
static int read_first_line(parser *p, int *nodes)
{
    if (!mbsri_next_line(p->l)) return mbsri_refuse_line(p->l, "the file is empty");
    if (!mbsri_next_integer(p->l, "the number of nodes", nodes)) return MBSR_ERR_FILE;
    const char *colon = p->l->word;
    while (colon < p->l->stop && *colon != ':') ++colon;
    p->l->stop = colon;
    if (!mbsri_next_integer(p->l, "the number of modes", &p->sid->modes)) return MBSR_ERR_FILE;
    if (p->sid->modes < 0 || p->sid->modes > MBSR_MAX_MODES || *nodes < 1)
        return mbsri_refuse_line(p->l,
                                 "%d nodes and %d modes; there must be a node, and at most %d "
                                 "modes",
                                 *nodes, p->sid->modes, MBSR_MAX_MODES);
    p->sid->name = mbsri_arena_take(p->arena, (size_t)p->sid->modes * sizeof *p->sid->name);
    for (int k = 0; k < p->sid->modes && p->sid->name; ++k) p->sid->name[k] = "";
    return p->sid->name ? MBSR_OK : MBSR_ERR_NO_MEMORY;
}

static int check_there(const parser *p, int nodes)
{
    const mbsri_sid *sid = p->sid;
#define MUST(name, rows, columns, first, must)                                                     \
    if (must && !sid->name.there) return mbsri_refuse_line(p->l, "%s is not in the file", #name);
    MBSRI_SID_BLOCKS(MUST)
#undef MUST
    if (sid->nodes.count != nodes)
        return mbsri_refuse_line(p->l, "the first line says %d nodes, but there are %d", nodes,
                                 sid->nodes.count);
    for (int k = 0; k < sid->ksigma.rows && sid->ksigma.there; ++k) {
        if (sid->ksigma.m0[k] != 0.0)
            return mbsri_refuse_line(p->l,
                                     "ksigma(%d,1) is %g; forces of initial stress cannot be "
                                     "represented",
                                     k + 1, sid->ksigma.m0[k]);
    }
    return MBSR_OK;
}

int mbsri_sid_parse(mbsri_arena *arena, mbsri_lines *lines, mbsri_sid *sid)
{
    parser p = {.arena = arena, .l = lines, .sid = sid};
    int nodes;
    bool refmod = false;
    int status = read_first_line(&p, &nodes);
    if (!status) status = expect(&p, "part");
    if (!status) status = expect(&p, "newmodal");
    while (!status) {
        status = next_key(&p);
        if (status || has_key(&p, "endmodal")) break;
        if (has_key(&p, "refmod")) {
            refmod = true;
            status = read_refmod(&p);
        } else {
            status = has_key(&p, "frame") ? read_frame(&p) : read_block(&p);
        }
    }
    if (!status) status = expect(&p, "endpart");
    if (!status && !refmod) status = mbsri_refuse_line(p.l, "refmod is not in the file");
    return status ? status : check_there(&p, nodes);
}
