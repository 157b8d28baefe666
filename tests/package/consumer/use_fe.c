/* Uses the component fe: a model without nodes is refused.
 * SPDX-License-Identifier: BSD-3-Clause */
#include <mbsrank/fe.h>

#include <stdio.h>

int main(void)
{
    const mbsr_fe_def def = mbsr_default_fe_def();
    mbsr_flex *flex;
    mbsr_error error;
    const int status = mbsr_fe_reduce(&def, &flex, NULL, &error);
    printf("%s: %s\n", mbsr_status_name(status), error.text);
    return status == MBSR_ERR_VALUE && !flex ? 0 : 1;
}
