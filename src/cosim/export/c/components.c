/* The components of an instance: made, started over, freed. */

#include <stdlib.h>
#include <string.h>

#include "system.h"

static void *allocate(size_t n, size_t size) { return calloc(n, size); }
static void release(void *memory) { free(memory); }

static void free_component(Component *c) {
    if (c->instance && !c->dead) c->f->FreeInstance(c->instance);
#ifdef CARRIES
    if (c->library) close_library(c->library);
#endif
    free(c->name), free(c->resources);
    memset(c, 0, sizeof *c);
}

static void free_components(System *m) {
    for (int i = 0; i < N_COMPONENTS; i++) free_component(&m->components[i]);
}

/* Makes component i, with the values that the system gives it. */
static int make_component(System *m, int i) {
    Component *c = &m->components[i];
    c->system = m, c->data = &COMPONENTS[i];
    c->callbacks = (fmi2CallbackFunctions){log_of_component, allocate, release, NULL, c};
    c->name = joined_text(m->name, ".", c->data->name);
    c->f = c->data->linked;
    if (!c->name) return 0;
#ifdef CARRIES
    if (!c->f) {
        if (!load(m, c)) return 0;
#if CARRIES_3
        if (c->data->version == 3) return make_3(m, c);
#endif
        if (!find_functions(m, c)) return 0;
    }
#endif
    c->instance = c->f->Instantiate(c->name, fmi2CoSimulation, c->data->token, c->resources ? c->resources : "", &c->callbacks,
                                    fmi2False, fmi2True);
    return c->instance != NULL;
}

static Status give(System *m, const char *function, int i, Type type, uint32_t reference, double number, const char *text) {
    Component *c = &m->components[i];
    const fmi2Integer integer = (fmi2Integer)number;
    int status = ERROR;
    switch (type) {
        case TYPE_REAL: status = c->f->SetReal(c->instance, &reference, 1, &number); break;
        case TYPE_INTEGER: status = c->f->SetInteger ? c->f->SetInteger(c->instance, &reference, 1, &integer) : ERROR; break;
        case TYPE_BOOLEAN: status = c->f->SetBoolean ? c->f->SetBoolean(c->instance, &reference, 1, &integer) : ERROR; break;
        case TYPE_STRING: status = c->f->SetString ? c->f->SetString(c->instance, &reference, 1, &text) : ERROR; break;
    }
    return judged(m, i, function, status);
}

/* The start: components as the system describes them, nothing known yet. What it cannot make it frees. */
static int to_start(System *m) {
    free_components(m);
    memset(&m->s, 0, sizeof m->s); /* the padding too, so that equal states have equal bytes */
    m->s.fingerprint = FINGERPRINT;
    m->s.mode = INSTANTIATED;
    m->s.algorithm = START_ALGORITHM, m->s.degree = START_DEGREE, m->s.step = START_STEP;
    for (int i = 0; i < N_EXTERNALS; i++) m->s.external[i] = EXTERNALS[i].start;
    for (int i = 0; i < N_COMPONENTS; i++) {
        if (make_component(m, i)) continue;
        tell(m, ERROR, LOG_ERROR, "component %s cannot be instantiated", COMPONENTS[i].name);
        free_components(m);
        return 0;
    }
    for (int k = 0; k < N_GIVEN; k++) {
        const Given *g = &GIVEN[k];
        if (give(m, "Instantiate", g->component, g->type, g->reference, g->number, g->text) == OK) continue;
        free_components(m);
        return 0;
    }
    return 1;
}

static System *make_system(const char *name, const char *resources) {
    System *m = calloc(1, sizeof *m);
    if (!m) return NULL;
    m->name = joined_text(name, "", "");
    m->resources = joined_text(resources ? resources : "", "", "");
    if (m->name && m->resources) return m;
    free(m->name), free(m->resources), free(m);
    return NULL;
}

static void free_system(System *m) {
    if (!m) return;
    free_components(m);
    free(m->name), free(m->resources), free(m);
}

/* Terminates what runs; one that refuses is freed all the same. */
static void terminate_components(System *m) {
    for (int i = 0; i < N_COMPONENTS; i++)
        if (!m->components[i].dead) m->components[i].f->Terminate(m->components[i].instance);
}
