/* Formatted text in which numbers have a point whatever the locale (LC_NUMERIC) is.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * In a header, since the component ida makes texts too and sees no internal function of the core.
 */
#ifndef MBSRI_FORMAT_H
#define MBSRI_FORMAT_H

#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#if defined(__MINGW_PRINTF_FORMAT) /* that of C, where stdio.h has another, too */
#define MBSRI_FORMAT(a, b) __attribute__((format(__MINGW_PRINTF_FORMAT, a, b)))
#elif defined(__GNUC__)
#define MBSRI_FORMAT(a, b) __attribute__((format(printf, a, b)))
#else
#define MBSRI_FORMAT(a, b)
#endif

/* Text of which `used` characters were written, or would have been had there been room. */
typedef struct mbsri_writer {
    char *text;
    size_t size, used;
} mbsri_writer;

static inline void mbsri_write(mbsri_writer *w, const char *piece, size_t length)
{
    if (w->used + 1 < w->size) {
        const size_t room = w->size - 1 - w->used, most = length < room ? length : room;
        memcpy(w->text + w->used, piece, most);
        w->text[w->used + most] = '\0';
    }
    w->used += length;
}

/* A number as printf wrote it: what is no digit, letter or sign separates the fraction. */
static inline void mbsri_write_number(mbsri_writer *w, const char *number)
{
    static const char plain[] = "0123456789+-ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz ";
    while (*number) {
        const size_t length = strspn(number, plain);
        mbsri_write(w, number, length);
        number += length;
        if (!*number) return;
        mbsri_write(w, ".", 1);
        number += strcspn(number, plain);
    }
}

/* A conversion: from its % to its letter. */
typedef struct mbsri_conversion {
    char text[24];
    char letter;
    int longs;     /* how many l */
    bool sized;    /* z */
    int precision; /* -1: none */
} mbsri_conversion;

/* Reads the conversion that begins at `format`; returns what follows it. */
static inline const char *mbsri_read_conversion(const char *format, mbsri_conversion *c)
{
    size_t used = 0;
    *c = (mbsri_conversion){.precision = -1};
    do {
        c->text[used++] = *format;
        c->longs += *format == 'l';
        c->sized = c->sized || *format == 'z';
        if (*format == '.')
            c->precision = 0;
        else if (c->precision >= 0 && *format >= '0' && *format <= '9')
            c->precision = 10 * c->precision + (*format - '0');
        ++format;
    } while (*format && strchr("-+ #0123456789.hlz", *format) && used + 2 < sizeof c->text);
    c->letter = *format ? *format++ : '%';
    c->text[used] = c->letter;
    return format;
}

/* vsnprintf for the conversions d i u x c p a e f g, with flags, width, precision and the lengths h
 * l ll z, and for s with a precision. */
static inline int mbsri_vprint(char *text, size_t size, const char *format, va_list arguments)
{
    mbsri_writer w = {text, size, 0};
    char piece[512];
    if (size > 0) text[0] = '\0';
    while (*format) {
        const size_t plain = strcspn(format, "%");
        mbsri_write(&w, format, plain);
        format += plain;
        if (!*format) break;
        mbsri_conversion c;
        format = mbsri_read_conversion(format, &c);
        if (c.letter == '%') {
            mbsri_write(&w, "%", 1);
        } else if (c.letter == 's') {
            const char *string = va_arg(arguments, const char *);
            size_t length = 0;
            while (string && (c.precision < 0 || length < (size_t)c.precision) && string[length])
                ++length;
            if (length > 0) mbsri_write(&w, string, length);
        } else if (strchr("aefgAEFG", c.letter)) {
            snprintf(piece, sizeof piece, c.text, va_arg(arguments, double));
            mbsri_write_number(&w, piece);
        } else {
            if (c.letter == 'p')
                snprintf(piece, sizeof piece, c.text, va_arg(arguments, void *));
            else if (c.sized)
                snprintf(piece, sizeof piece, c.text, va_arg(arguments, size_t));
            else if (c.longs > 1)
                snprintf(piece, sizeof piece, c.text, va_arg(arguments, long long));
            else if (c.longs > 0)
                snprintf(piece, sizeof piece, c.text, va_arg(arguments, long));
            else
                snprintf(piece, sizeof piece, c.text, va_arg(arguments, int));
            mbsri_write(&w, piece, strlen(piece));
        }
    }
    return (int)w.used;
}

#endif
