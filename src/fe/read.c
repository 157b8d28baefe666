/* Models from Matrix Market files and lists of nodes, dofs and markers: mbsr_fe_read.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "base/error.h"
#include "fe/lines.h"
#include "files/arena.h"

#include <mbsrank/fe.h>

#include <limits.h>
#include <string.h>

/* With its memory. */
typedef struct full_input {
    mbsr_fe_input input;
    mbsri_arena arena;
} full_input;

static mbsri_lines open_text(const mbsr_fe_text *text, const char *name, char comment,
                             mbsr_error *error)
{
    return (mbsri_lines){.text = text->text,
                         .end = text->text + text->size,
                         .word = text->text,
                         .stop = text->text,
                         .file = text->name ? text->name : name,
                         .comment = comment,
                         .error = error};
}

/* ---- Matrix Market ---- */

/* The first line: %%MatrixMarket matrix coordinate real symmetric|general. */
static int read_banner(mbsri_lines *l, int *whole)
{
    static const char *const wanted[3] = {"%%MatrixMarket", "matrix", "coordinate"};
    char word[MBSRI_WORD];
    l->comment = '\0';
    if (!mbsri_next_line(l)) return mbsri_refuse_line(l, "the file is empty");
    for (int k = 0; k < 3; ++k) {
        if (!mbsri_next_word(l, word) || !mbsri_same_word(word, wanted[k]))
            return mbsri_refuse_line(l, "'%.40s' in the first line, where '%s' is wanted", word,
                                     wanted[k]);
    }
    if (!mbsri_next_word(l, word) ||
        (!mbsri_same_word(word, "real") && !mbsri_same_word(word, "integer")))
        return mbsri_refuse_line(l, "the matrix is '%.40s', where 'real' is wanted", word);
    const bool known = mbsri_next_word(l, word);
    *whole = known && mbsri_same_word(word, "general");
    if (!*whole && !(known && mbsri_same_word(word, "symmetric")))
        return mbsri_refuse_line(l, "the matrix is '%.40s', neither 'symmetric' nor 'general'",
                                 word);
    l->comment = '%';
    return mbsri_line_ends(l) ? MBSR_OK : MBSR_ERR_FILE;
}

static int read_matrix_entry(mbsri_lines *l, const mbsr_fe_matrix *A, int *row, int *column,
                             double *value)
{
    if (!mbsri_next_integer(l, "a row", row) || !mbsri_next_integer(l, "a column", column) ||
        !mbsri_next_number(l, "a value", value) || !mbsri_line_ends(l))
        return MBSR_ERR_FILE;
    if (*row < 1 || *row > A->rows || *column < 1 || *column > A->rows)
        return mbsri_refuse_line(l, "entry (%d,%d) of a matrix of %d rows", *row, *column, A->rows);
    if (!A->whole && *row < *column)
        return mbsri_refuse_line(l,
                                 "entry (%d,%d) above the diagonal of a matrix that is "
                                 "'symmetric', of which the lower triangle is stored",
                                 *row, *column);
    --*row;
    --*column;
    return MBSR_OK;
}

/* Rows, columns, and entries, as many as the file has room for. */
static int read_size(mbsri_lines *l, mbsr_fe_matrix *A, int *entries)
{
    enum { SHORTEST = 6 }; /* an entry with its end of line */
    int columns;
    if (!mbsri_next_line(l)) return mbsri_refuse_line(l, "the file ends before its size");
    if (!mbsri_next_integer(l, "the number of rows", &A->rows) ||
        !mbsri_next_integer(l, "the number of columns", &columns) ||
        !mbsri_next_integer(l, "the number of entries", entries) || !mbsri_line_ends(l))
        return MBSR_ERR_FILE;
    if (A->rows < 1 || A->rows != columns || *entries < 0)
        return mbsri_refuse_line(l, "a matrix of %d x %d with %d entries; it must be square",
                                 A->rows, columns, *entries);
    if ((size_t)*entries > (size_t)(l->end - l->text) / SHORTEST + 1)
        return mbsri_refuse_line(l,
                                 "%d entries cannot stand in the %zu bytes that follow; has the "
                                 "file been cut short?",
                                 *entries, (size_t)(l->end - l->text));
    return MBSR_OK;
}

static int read_matrix(mbsri_arena *arena, const mbsr_fe_text *text, const char *name,
                       mbsr_fe_matrix *A, mbsr_error *error)
{
    mbsri_lines l = open_text(text, name, '%', error);
    int entries;
    *A = (mbsr_fe_matrix){.rows = 0};
    int status = read_banner(&l, &A->whole);
    if (!status) status = read_size(&l, A, &entries);
    if (status) return status;
    const size_t count = (size_t)entries;
    int *row = mbsri_arena_take(arena, count * sizeof *row),
        *column = mbsri_arena_take(arena, count * sizeof *column);
    double *value = mbsri_arena_take(arena, count * sizeof *value);
    if (!row || !column || !value) return MBSR_ERR_NO_MEMORY;
    for (int k = 0; k < entries; ++k) {
        if (!mbsri_next_line(&l))
            return mbsri_refuse_line(&l, "the file ends after %d of %d entries", k, entries);
        status = read_matrix_entry(&l, A, row + k, column + k, value + k);
        if (status) return status;
    }
    if (mbsri_next_line(&l)) return mbsri_refuse_line(&l, "more than %d entries", entries);
    A->entries = count;
    A->row = row, A->column = column, A->value = value;
    return MBSR_OK;
}

/* ---- nodes, dofs, markers ---- */

typedef struct node {
    int id;
    double x[3];
} node;

static int read_nodes(mbsri_arena *arena, const mbsr_fe_text *text, mbsr_fe_def *def,
                      mbsr_error *error)
{
    mbsri_lines l = open_text(text, "nodes", '#', error);
    mbsri_list list = {.items = NULL};
    while (mbsri_next_line(&l)) {
        node n;
        if (!mbsri_next_integer(&l, "the id of a node", &n.id) ||
            !mbsri_next_number(&l, "x", n.x) || !mbsri_next_number(&l, "y", n.x + 1) ||
            !mbsri_next_number(&l, "z", n.x + 2) || !mbsri_line_ends(&l))
            return MBSR_ERR_FILE;
        node *to = mbsri_list_add(arena, &list, sizeof *to);
        if (!to) return MBSR_ERR_NO_MEMORY;
        *to = n;
    }
    if (list.count == 0) return mbsri_refuse_line(&l, "there are no nodes");
    int *id = mbsri_arena_take(arena, (size_t)list.count * sizeof *id);
    double *x = mbsri_arena_take(arena, 3 * (size_t)list.count * sizeof *x);
    if (!id || !x) return MBSR_ERR_NO_MEMORY;
    for (int k = 0; k < list.count; ++k) {
        const node *from = (const node *)list.items + k;
        id[k] = from->id;
        memcpy(x + 3 * (size_t)k, from->x, sizeof from->x);
    }
    def->nodes = list.count;
    def->id = id, def->x = x;
    return MBSR_OK;
}

/* "node direction" or "node.direction". */
static int read_dof(mbsri_lines *l, int *id, int *direction)
{
    char word[MBSRI_WORD];
    const char *start = l->word;
    if (mbsri_next_word(l, word) && strchr(word, '.')) {
        mbsri_lines part = *l;
        char *point = strchr(word, '.');
        *point = ' ';
        part.word = word;
        part.stop = word + strlen(word);
        if (!mbsri_next_integer(&part, "a node", id) ||
            !mbsri_next_integer(&part, "a direction", direction) || !mbsri_line_ends(&part))
            return MBSR_ERR_FILE;
    } else {
        l->word = start;
        if (!mbsri_next_integer(l, "a node", id) ||
            !mbsri_next_integer(l, "a direction", direction))
            return MBSR_ERR_FILE;
    }
    if (*direction < 1 || *direction > 6)
        return mbsri_refuse_line(l, "direction %d, must be 1 .. 6", *direction);
    --*direction;
    return mbsri_line_ends(l) ? MBSR_OK : MBSR_ERR_FILE;
}

static int read_dofs(mbsri_arena *arena, const mbsr_fe_text *text, mbsr_fe_def *def,
                     mbsr_error *error)
{
    mbsri_lines l = open_text(text, "dofs", '#', error);
    const size_t rows = (size_t)def->K.rows;
    int count = 0;
    int *id = mbsri_arena_take(arena, rows * sizeof *id),
        *direction = mbsri_arena_take(arena, rows * sizeof *direction);
    if (!id || !direction) return MBSR_ERR_NO_MEMORY;
    for (; mbsri_next_line(&l); ++count) {
        if (count == def->K.rows)
            return mbsri_refuse_line(&l, "more dofs than the %d rows of K", def->K.rows);
        const int status = read_dof(&l, id + count, direction + count);
        if (status) return status;
    }
    if (count < def->K.rows)
        return mbsri_refuse_line(&l, "the file ends after %d dofs, but K has %d rows", count,
                                 def->K.rows);
    def->dof_node = id, def->dof_direction = direction;
    return MBSR_OK;
}

/* name kind node ... */
static int read_marker(mbsri_arena *arena, mbsri_lines *l, mbsr_fe_marker *marker)
{
    char name[MBSRI_WORD], word[MBSRI_WORD];
    mbsri_list ids = {.items = NULL};
    if (!mbsri_next_word(l, name) || !mbsri_next_word(l, word) ||
        (!mbsri_same_word(word, "node") && !mbsri_same_word(word, "average")))
        return mbsri_refuse_line(l,
                                 "'%.40s' where 'node' or 'average' is wanted, behind the name "
                                 "of a marker",
                                 word);
    const bool single = mbsri_same_word(word, "node");
    for (;;) {
        mbsri_lines ahead = *l;
        if (!mbsri_next_word(&ahead, word)) break;
        int *id = mbsri_list_add(arena, &ids, sizeof *id);
        if (!id) return MBSR_ERR_NO_MEMORY;
        if (!mbsri_next_integer(l, "the id of a node", id)) return MBSR_ERR_FILE;
    }
    if (single ? ids.count != 1 : ids.count < 3)
        return mbsri_refuse_line(l, "marker '%.40s' has %d nodes; %s", name, ids.count,
                                 single ? "'node' takes one" : "'average' takes three or more");
    *marker = (mbsr_fe_marker){
        .name = mbsri_arena_text(arena, name, strlen(name)), .nodes = ids.count, .node = ids.items};
    return marker->name ? MBSR_OK : MBSR_ERR_NO_MEMORY;
}

static int read_markers(mbsri_arena *arena, const mbsr_fe_text *text, mbsr_fe_input *input,
                        mbsr_error *error)
{
    mbsri_lines l = open_text(text, "markers", '#', error);
    mbsri_list list = {.items = NULL};
    while (mbsri_next_line(&l)) {
        mbsr_fe_marker *marker = mbsri_list_add(arena, &list, sizeof *marker);
        const int status = marker ? read_marker(arena, &l, marker) : MBSR_ERR_NO_MEMORY;
        if (status) return status;
        marker->loaded = list.count > 1;
    }
    if (list.count == 0)
        return mbsri_refuse_line(&l, "there are no markers; the first is the root");
    input->marker = list.items;
    input->def.marker = list.items;
    input->def.markers = list.count;
    return MBSR_OK;
}

/* ---- all ---- */

static int read_files(mbsri_arena *arena, const mbsr_fe_files *files, mbsr_fe_input *input,
                      mbsr_error *error)
{
    mbsr_fe_def *def = &input->def;
    const mbsr_fe_text *const text[3] = {&files->K, &files->M, &files->D};
    mbsr_fe_matrix *const A[3] = {&def->K, &def->M, &def->D};
    static const char *const name[3] = {"K", "M", "D"};
    for (int k = 0; k < 3; ++k) {
        if (!text[k]->text) continue;
        const int status = read_matrix(arena, text[k], name[k], A[k], error);
        if (status) return status;
        if (A[k]->rows != def->K.rows || (k == 0 && (size_t)A[k]->rows > A[k]->entries))
            return mbsri_fail_plain(
                error, MBSR_ERR_FILE,
                "%.60s: %s has %d rows and %zu entries, K %d rows; every row of K "
                "has entries",
                text[k]->name ? text[k]->name : name[k], name[k], A[k]->rows, A[k]->entries,
                def->K.rows);
    }
    int status = read_nodes(arena, &files->nodes, def, error);
    if (!status && files->dofs.text) status = read_dofs(arena, &files->dofs, def, error);
    return status ? status : read_markers(arena, &files->markers, input, error);
}

static int check_files(const mbsr_fe_files *files, mbsr_error *error)
{
    const char *missing = !files->K.text         ? "K"
                          : !files->M.text       ? "M"
                          : !files->nodes.text   ? "nodes"
                          : !files->markers.text ? "markers"
                                                 : NULL;
    return missing ? mbsri_fail_plain(error, MBSR_ERR_NULL, "mbsr_fe_read: files.%s.text is NULL",
                                      missing)
                   : MBSR_OK;
}

int mbsr_fe_read(const mbsr_fe_files *files, const mbsr_allocator *allocator, mbsr_fe_input **input,
                 mbsr_error *error)
{
    const mbsr_allocator standard = {.allocate = NULL};
    if (input) *input = NULL;
    if (!files || !input)
        return mbsri_fail_plain(error, MBSR_ERR_NULL, "mbsr_fe_read: %s is NULL",
                                !files ? "files" : "input");
    if (!allocator) allocator = &standard;
    if (!allocator->allocate != !allocator->release)
        return mbsri_fail_plain(error, MBSR_ERR_VALUE,
                                "mbsr_fe_read: allocator has one of its two functions only");
    int status = check_files(files, error);
    if (status) return status;
    mbsri_arena arena;
    mbsri_arena_open(&arena, allocator);
    full_input *full = mbsri_arena_take(&arena, sizeof *full);
    if (full) {
        full->arena = arena;
        full->input.def = mbsr_default_fe_def();
        full->input.def.allocator = *allocator;
        status = read_files(&full->arena, files, &full->input, error);
        if (!status)
            *input = &full->input;
        else
            mbsr_fe_input_destroy(&full->input);
    }
    if (!full || status == MBSR_ERR_NO_MEMORY)
        return mbsri_fail_plain(error, MBSR_ERR_NO_MEMORY, "mbsr_fe_read: no memory");
    return status;
}

void mbsr_fe_input_destroy(mbsr_fe_input *input)
{
    if (!input) return;
    mbsri_arena arena = ((full_input *)(void *)input)->arena;
    mbsri_arena_close(&arena);
}
