/* Messages to the importer: the system's own, and those of its components. */

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "system.h"

static void tell(System *m, Status status, unsigned category, const char *format, ...) {
    char text[512], doubled[2 * sizeof text], *end = doubled;
    va_list arguments;
    int bit = 0;
    if (!m->log || !(m->log_categories & category)) return;
    while (!(category >> bit & 1u)) bit++;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    for (const char *c = text; *c; c++) { /* the text is FMI 2.0's format, and a component may have said anything */
        if (*c == '%') *end++ = '%';
        *end++ = *c;
    }
    *end = '\0';
    m->log(m, status, CATEGORIES[bit], doubled);
}

/* After an error only a reset, restoring a saved state or freeing the instance is allowed. */
static Status fail(System *m, const char *function, const char *why) {
    tell(m, ERROR, LOG_ERROR, "%s: %s", function, why);
    m->s.mode = FAILED;
    return ERROR;
}

static Status discard(System *m, const char *function, const char *why, const char *what) {
    tell(m, DISCARD, LOG_DISCARD, "%s: %s%s", function, why, what);
    return DISCARD;
}

static int allowed(System *m, const char *function, int modes) {
    if (m->s.mode & modes) return 1;
    fail(m, function, "must not be called in this state");
    return 0;
}

/* Chooses the categories that are logged from now on, besides those already chosen: all, or the named ones. */
static Status choose_categories(System *m, int on, size_t n, const char *const category[]) {
    if (on && n == 0) m->log_categories = LOG_ALL;
    for (size_t i = 0; i < n; i++) {
        unsigned bit = 0;
        for (unsigned k = 0; k < sizeof CATEGORIES / sizeof *CATEGORIES; k++)
            if (category[i] && strcmp(category[i], CATEGORIES[k]) == 0) bit = 1u << k;
        if (!bit) return fail(m, "SetDebugLogging", "unknown category");
        if (on) m->log_categories |= bit;
    }
    return OK;
}

/* What component `c` says, in the category of the status that it says it with. */
static void relay(const Component *c, int status, const char *text) {
    static const unsigned of_status[] = {LOG_EVENTS, LOG_WARNING, LOG_DISCARD, LOG_ERROR, LOG_ERROR};
    if (status < 0 || status > FATAL) return;
    tell(c->system, (Status)status, of_status[status], "%s: %s", c->data->name, text);
}

static void log_of_component(void *environment, const char *name, fmi2Status status, const char *category, const char *format,
                             ...) {
    char text[512];
    va_list arguments;
    (void)name, (void)category;
    if (!environment || !format) return;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    relay(environment, (int)status, text);
}

/* What to answer where component i has answered `status` to `function`; worse than a warning ends in a failed state. */
static Status judged(System *m, int i, const char *function, int status) {
    if (GOOD(status)) return OK;
    const Status known = status < 0 || status > FATAL ? ERROR : (Status)status;
    if (status >= FATAL) m->components[i].dead = 1;
    tell(m, known, status == DISCARD ? LOG_DISCARD : LOG_ERROR, "%s: %s answered %s", COMPONENTS[i].name, function,
         status == DISCARD ? "discard" : status >= FATAL ? "fatal" : "error");
    if (status != DISCARD) m->s.mode = FAILED;
    return known;
}

static char *joined_text(const char *a, const char *b, const char *c) {
    size_t n = strlen(a) + strlen(b) + strlen(c) + 1;
    char *text = malloc(n);
    if (text) snprintf(text, n, "%s%s%s", a, b, c);
    return text;
}
