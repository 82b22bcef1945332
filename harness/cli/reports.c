/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "cli/reports.h"

#include <string.h>

static const struct {
    const char *option;
    int (*print)(const struct report *, FILE *);
} forms[REPORT_FORMS] = {
    [REPORT_JSON] = { "--json", report_json },
    [REPORT_JUNIT] = { "--junit", report_junit },
    [REPORT_SARIF] = { "--sarif", report_sarif },
    [REPORT_HTML] = { "--html", report_html },
};

/* The earlier form that goes to the same place, REPORT_FORMS when none does. */
static int same_place(const struct report_files *files, int form)
{
    for (int i = 0; i < form; i++)
        if (files->paths[i] != NULL && strcmp(files->paths[i], files->paths[form]) == 0)
            return i;
    return REPORT_FORMS;
}

static int open_one(struct report_files *files, const struct command *command, const char *module,
                    int form)
{
    const char *path = files->paths[form];
    const int other = same_place(files, form);
    if (other != REPORT_FORMS)
        return complain(command, "%s and %s cannot both go to '%s'", forms[other].option,
                        forms[form].option, path);
    if (same_file(path, module))
        return complain(command, "%s '%s' is the module itself", forms[form].option, path);
    const int r = output_open(&files->outputs[form], path);
    return r != 0 ? complain(command, "cannot write '%s': %s", path, strerror(-r)) : 0;
}

int report_files_open(struct report_files *files, const struct command *command, const char *module)
{
    for (int i = 0; i < REPORT_FORMS; i++) {
        const int status = files->paths[i] != NULL ? open_one(files, command, module, i) : 0;
        if (status != 0) {
            report_files_drop(files);
            return status;
        }
    }
    return 0;
}

bool report_files_take_stdout(const struct report_files *files)
{
    for (int i = 0; i < REPORT_FORMS; i++)
        if (files->outputs[i].stream == stdout)
            return true;
    return false;
}

int report_files_write(struct report_files *files, const struct command *command,
                       const struct report *report)
{
    int status = 0;
    for (int i = 0; i < REPORT_FORMS; i++) {
        if (files->paths[i] == NULL)
            continue;
        const int written = forms[i].print(report, files->outputs[i].stream);
        const int closed = output_close(&files->outputs[i], written == 0);
        if (written != 0 || closed != 0)
            status = complain(command, "cannot write '%s': %s", files->paths[i],
                              strerror(written != 0 ? -written : -closed));
    }
    return status;
}

void report_files_drop(struct report_files *files)
{
    for (int i = 0; i < REPORT_FORMS; i++)
        output_close(&files->outputs[i], false);
}
