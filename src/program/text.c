/* Texts in and out.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "program/program.h"

#include <errno.h>
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

/* Bytes at `at` that move the cursor or worse: below the space but for the end of a line, DEL,
 * U+0080 to U+009F. */
static int control_at(const unsigned char *at)
{
    if ((at[0] < 0x20 && at[0] != '\n') || at[0] == 0x7f) return 1;
    return at[0] == 0xc2 && at[1] >= 0x80 && at[1] < 0xa0 ? 2 : 0;
}

static void say_list(FILE *to, const char *format, va_list arguments)
{
    char text[4096];
    vsnprintf(text, sizeof text, format, arguments);
    for (const char *at = text; *at; ++at) {
        const int control = control_at((const unsigned char *)at);
        fputc(control ? '?' : *at, to);
        if (control == 2) ++at;
    }
}

void say(FILE *to, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    say_list(to, format, arguments);
    va_end(arguments);
}

int complain(int code, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    fputs("mbsrank: ", stderr);
    say_list(stderr, format, arguments);
    fputc('\n', stderr);
    va_end(arguments);
    return code;
}

void put_json(FILE *to, const char *text)
{
    fputc('"', to);
    for (; *text; ++text) {
        const unsigned char c = (unsigned char)*text;
        if (c == '"' || c == '\\')
            fprintf(to, "\\%c", c);
        else if (c < 0x20 || c == '<') /* < for JSON in a page */
            fprintf(to, "\\u%04x", c);
        else
            fputc(c, to);
    }
    fputc('"', to);
}

void put_number(FILE *to, double x)
{
    if (isfinite(x))
        fprintf(to, "%.9g", x);
    else
        fputs("null", to);
}

void put_numbers(FILE *to, int n, const double *x)
{
    for (int k = 0; k < n; ++k) {
        fputc(k > 0 ? ',' : '[', to);
        put_number(to, x[k]);
    }
    fputs(n > 0 ? "]" : "[]", to);
}

int complain_of_file(int code, const char *path, const char *what)
{
    return complain(code, "%s cannot be %s: %s", path, what, strerror(errno));
}

enum { MOST_BYTES = 1 << 30 };

char *read_file(const char *path, size_t *size)
{
    FILE *file = strcmp(path, "-") == 0 ? stdin : fopen(path, "rb");
    char *text = NULL;
    size_t room = 0;
    bool large = false;
    *size = 0;
    if (!file) return NULL;
    for (size_t more = 1; more > 0 && !large;) {
        if (room - *size < 2) {
            room = room > 0 ? 2 * room : 1 << 16;
            char *larger = realloc(text, room);
            if (!larger) break;
            text = larger;
        }
        more = fread(text + *size, 1, room - *size - 1, file);
        *size += more;
        large = *size > MOST_BYTES;
    }
    const bool bad = large || ferror(file) != 0 || !text;
    const int reason = large ? EFBIG : errno;
    if (file != stdin) fclose(file);
    errno = reason;
    if (bad) {
        free(text);
        return NULL;
    }
    text[*size] = '\0';
    return text;
}

bool ends_in(const char *text, const char *ending)
{
    const size_t length = strlen(text), tail = strlen(ending);
    return length > tail && strcmp(text + length - tail, ending) == 0;
}

const char *option_value(int argc, char **argv, int *at, const char *name)
{
    const char *argument = argv[*at];
    const size_t length = strlen(name);
    if (strncmp(argument, name, length) != 0) return NULL;
    if (argument[length] == '=') return argument + length + 1;
    if (argument[length] != '\0') return NULL;
    if (*at + 1 == argc) {
        complain(USAGE, "%s needs a value", name);
        *at = -1;
        return NULL;
    }
    return argv[++*at];
}

bool option_number(const char *name, const char *value, double *number)
{
    char *end;
    *number = strtod(value, &end);
    if (*value && !*end && isfinite(*number) && *number > 0.0) return true;
    complain(USAGE, "%s: '%s' is not a positive number", name, value);
    return false;
}
