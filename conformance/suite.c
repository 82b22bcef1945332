/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "conformance/suite.h"

#include <inttypes.h>

#include "conformance/rule_book.h"

static const struct suite suites[] = {
    { .name = "cert-1", .seed = 0x6365727431, .instrumented = true },
};

const struct suite *suite_at(size_t index)
{
    return index < sizeof suites / sizeof *suites ? &suites[index] : NULL;
}

const struct suite *suite_latest(void)
{
    return &suites[sizeof suites / sizeof *suites - 1];
}

void suite_write(const struct suite *suite, FILE *out)
{
    fprintf(out, "suite %s seed=0x%" PRIx64 " instrumented=%d\n", suite->name, suite->seed,
            suite->instrumented);
    rule_book_write(out);
}

void suite_apply(const struct suite *suite, struct check_options *options)
{
    options->seed = suite->seed;
    options->instrumented = suite->instrumented;
    options->cycles = 0;
    options->rules = NULL;
    options->strict = false;
    options->waivers = NULL;
    options->around = NULL;
    options->around_path = NULL;
    options->scenarios = NULL;
    options->scenario_count = 0;
}
