/* A file of XML as a tree: see xml.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "files/xml.h"

#include "files/names.h"

#include <expat.h>

#include <limits.h>
#include <stdio.h>
#include <string.h>

typedef struct reading {
    XML_Parser parser;
    mbsri_arena *arena;
    const char *file;
    mbsri_element *root, *at;
    int depth;
    char *message; /* "" as long as all is well */
    char *text;    /* since the last tag */
    size_t size, room;
    mbsri_names names; /* of elements and attributes, each once */
} reading;

static int line_of(const reading *r)
{
    const XML_Size line = XML_GetCurrentLineNumber(r->parser);
    return line > INT_MAX ? INT_MAX : (int)line;
}

static void stop(reading *r, const char *reason)
{
    if (!r->message[0])
        snprintf(r->message, MBSR_TEXT_SIZE, "%.120s:%d: %.100s", r->file, line_of(r), reason);
    XML_StopParser(r->parser, XML_FALSE);
}

/* The same text for the same name: there are few. */
static const char *keep_name(reading *r, const char *name)
{
    const char *known = mbsri_names_same(&r->names, name);
    if (known) return known;
    const char *copy = mbsri_arena_text(r->arena, name, strlen(name));
    if (copy) mbsri_names_add(r->arena, &r->names, copy, 0);
    return copy;
}

static void XMLCALL start(void *user, const XML_Char *name, const XML_Char **attributes)
{
    reading *r = user;
    size_t count = 0;
    if (r->message[0]) return;
    if (++r->depth > MBSRI_XML_DEPTH) {
        stop(r, "elements stand in each other too deeply");
        return;
    }
    while (attributes[count]) ++count;
    mbsri_element *e = mbsri_arena_take(r->arena, sizeof *e);
    const char **list = mbsri_arena_take(r->arena, (count + 1) * sizeof *list);
    if (!e || !list) {
        stop(r, "no memory");
        return;
    }
    r->size = 0;
    e->name = keep_name(r, name);
    e->file = r->file;
    e->line = line_of(r);
    e->parent = r->at;
    e->attribute = list;
    for (size_t k = 0; k < count; ++k) {
        list[k] = k % 2 ? mbsri_arena_text(r->arena, attributes[k], strlen(attributes[k]))
                        : keep_name(r, attributes[k]);
    }
    if (!r->at)
        r->root = e;
    else if (r->at->last)
        r->at->last->next = e;
    else
        r->at->child = e;
    if (r->at) r->at->last = e;
    r->at = e;
    if (r->arena->failed) stop(r, "no memory");
}

static void XMLCALL end(void *user, const XML_Char *name)
{
    reading *r = user;
    (void)name;
    --r->depth;
    if (!r->at) return;
    bool blank = true;
    for (size_t k = 0; k < r->size && blank; ++k) blank = strchr(" \t\r\n", r->text[k]) != NULL;
    if (!r->at->child && !blank) r->at->text = mbsri_arena_text(r->arena, r->text, r->size);
    r->size = 0;
    r->at = r->at->parent;
}

static void XMLCALL text(void *user, const XML_Char *piece, int length)
{
    reading *r = user;
    if (r->message[0] || (r->at && r->at->child)) return;
    if (r->size + (size_t)length > r->room) {
        const size_t room = 2 * (r->size + (size_t)length) + 1024;
        char *larger = mbsri_arena_take(r->arena, room);
        if (!larger) {
            stop(r, "no memory");
            return;
        }
        if (r->size > 0) memcpy(larger, r->text, r->size);
        r->text = larger;
        r->room = room;
    }
    memcpy(r->text + r->size, piece, (size_t)length);
    r->size += (size_t)length;
}

static void XMLCALL entity(void *user, const XML_Char *name, int parameter, const XML_Char *value,
                           int length, const XML_Char *base, const XML_Char *system,
                           const XML_Char *public_id, const XML_Char *notation)
{
    (void)name, (void)parameter, (void)value, (void)length, (void)base, (void)system;
    (void)public_id, (void)notation;
    stop(user, "the file declares entities, which are not read");
}

mbsri_element *mbsri_xml_read(mbsri_arena *arena, const char *bytes, size_t size, const char *name,
                              char message[MBSR_TEXT_SIZE])
{
    reading r = {.arena = arena, .file = name, .message = message};
    message[0] = '\0';
    if (size > MBSRI_XML_SIZE) {
        snprintf(message, MBSR_TEXT_SIZE, "%.120s: the file is too large (%zu bytes)", name, size);
        return NULL;
    }
    r.parser = XML_ParserCreate(NULL);
    if (!r.parser) {
        arena->failed = true;
        return NULL;
    }
    XML_SetUserData(r.parser, &r);
    XML_SetElementHandler(r.parser, start, end);
    XML_SetCharacterDataHandler(r.parser, text);
    XML_SetEntityDeclHandler(r.parser, entity);
    const bool parsed = XML_Parse(r.parser, bytes, (int)size, XML_TRUE) != XML_STATUS_ERROR;
    if (!parsed && XML_GetErrorCode(r.parser) == XML_ERROR_NO_MEMORY) arena->failed = true;
    if (!parsed && !message[0]) {
        snprintf(message, MBSR_TEXT_SIZE, "%.120s:%d: this is not XML: %.100s", name, line_of(&r),
                 XML_ErrorString(XML_GetErrorCode(r.parser)));
    }
    XML_ParserFree(r.parser);
    if (arena->failed) snprintf(message, MBSR_TEXT_SIZE, "%.120s: no memory", name);
    return message[0] ? NULL : r.root;
}

const char *mbsri_attribute(const mbsri_element *e, const char *name)
{
    for (const char **a = e->attribute; *a; a += 2) {
        if (strcmp(a[0], name) == 0) return a[1];
    }
    return NULL;
}

const char *mbsri_text_of(const mbsri_element *e, const char *name)
{
    const mbsri_element *child = mbsri_child(e, name);
    return child ? child->text : NULL;
}

bool mbsri_is(const mbsri_element *e, const char *name)
{
    return strcmp(e->name, name) == 0;
}

const mbsri_element *mbsri_child(const mbsri_element *e, const char *name)
{
    const mbsri_element *child = e ? e->child : NULL;
    while (child && !mbsri_is(child, name)) child = child->next;
    return child;
}

const mbsri_element *mbsri_next(const mbsri_element *e)
{
    const mbsri_element *next = e->next;
    while (next && !mbsri_is(next, e->name)) next = next->next;
    return next;
}
