/* A locale whose decimal separator is a comma.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef TEST_LOCALE_COMMA_H
#define TEST_LOCALE_COMMA_H

#include <locale.h>
#include <stddef.h>
#include <string.h>

/* Sets one for numbers; 0 where none is installed. */
static inline int test_locale_comma(void)
{
    static const char *const names[] = {"de_DE.UTF-8", "de_DE.utf8", "de_DE",       "fr_FR.UTF-8",
                                        "fr_FR.utf8",  "it_IT.utf8", "es_ES.utf8",  "ru_RU.utf8",
                                        "pl_PL.utf8",  "nl_NL.utf8", "pt_BR.utf8",  "sv_SE.utf8",
                                        "da_DK.utf8",  "fi_FI.utf8", "de_AT.UTF-8", "de_CH"};
    for (size_t k = 0; k < sizeof names / sizeof *names; ++k) {
        if (setlocale(LC_NUMERIC, names[k]) && strcmp(localeconv()->decimal_point, ",") == 0)
            return 1;
    }
    setlocale(LC_NUMERIC, "C");
    return 0;
}

static inline void test_locale_back(void)
{
    setlocale(LC_NUMERIC, "C");
}

#endif
