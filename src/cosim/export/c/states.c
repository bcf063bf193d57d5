/* The whole state: that of every component, and the points that the coupling remembers. */

#include <stdlib.h>
#include <string.h>

#include "system.h"

typedef struct {
    State s;
    void *components[AT_LEAST_ONE(N_COMPONENTS)];
} Saved;

static Status save_components(System *m, void **saved) {
    for (int i = 0; i < N_COMPONENTS; i++) {
        Status status = judged(m, i, "GetFMUstate", m->components[i].f->GetFMUstate(m->components[i].instance, &saved[i]));
        if (status != OK) return status;
    }
    return OK;
}

static Status restore_components(System *m, void **saved) {
    for (int i = 0; i < N_COMPONENTS; i++) {
        Status status = judged(m, i, "SetFMUstate", m->components[i].f->SetFMUstate(m->components[i].instance, saved[i]));
        if (status != OK) return status;
    }
    return OK;
}

static void discard_components(System *m, void **saved) {
    for (int i = 0; i < N_COMPONENTS; i++)
        if (saved[i] && !m->components[i].dead) m->components[i].f->FreeFMUstate(m->components[i].instance, &saved[i]);
}

static Status save(System *m, const char *function, void **state) {
    if (!ALL_RESTORE) return fail(m, function, "a component cannot save its state");
    if (!state) return fail(m, function, "no place for the state");
    if (!*state) *state = calloc(1, sizeof(Saved));
    if (!*state) return fail(m, function, "out of memory");
    Saved *saved = *state;
    saved->s = m->s;
    memset(saved->s.Y, 0, sizeof saved->s.Y), memset(saved->s.t, 0, sizeof saved->s.t); /* equal states have equal bytes */
    memcpy(saved->s.Y, m->Y, (size_t)m->s.known * N_Y * sizeof(double));
    memcpy(saved->s.t, m->t, (size_t)m->s.known * sizeof(double));
    return save_components(m, saved->components);
}

static int fits(const State *s) { return s->zero == 0 && s->fingerprint == FINGERPRINT && s->known >= 0 && s->known <= BEFORE; }

static Status restore(System *m, const char *function, const void *state) {
    const Saved *saved = state;
    void *components[AT_LEAST_ONE(N_COMPONENTS)];
    if (!saved || !fits(&saved->s)) return fail(m, function, "this is no state of this system");
    memcpy(components, saved->components, sizeof components);
    Status status = restore_components(m, components);
    if (status != OK) return status;
    m->s = saved->s;
    memcpy(m->Y, saved->s.Y, sizeof saved->s.Y), memcpy(m->t, saved->s.t, sizeof saved->s.t);
    prepare_loop(m);
    return OK;
}

static void discard_state(System *m, void **state) {
    if (!state || !*state) return;
    discard_components(m, ((Saved *)*state)->components);
    free(*state);
    *state = NULL;
}

/* The bytes: State, then of each component the number of its bytes and these. */
static Status serialized_size(System *m, const char *function, void *state, size_t *size) {
    Saved *saved = state;
    if (!ALL_SERIALIZE) return fail(m, function, "a component cannot write its state");
    if (!saved || !size) return fail(m, function, "no state");
    *size = sizeof(State);
    for (int i = 0; i < N_COMPONENTS; i++) {
        size_t more = 0;
        Component *c = &m->components[i];
        const int answer = c->f->SerializedFMUstateSize(c->instance, saved->components[i], &more);
        Status status = judged(m, i, "SerializedFMUstateSize", answer);
        if (status != OK) return status;
        *size += sizeof(uint64_t) + more;
    }
    return OK;
}

static Status serialize(System *m, const char *function, void *state, unsigned char *bytes, size_t size) {
    size_t needed = 0;
    Status status = serialized_size(m, function, state, &needed);
    if (status != OK) return status;
    if (size < needed) return fail(m, function, "too few bytes for the state");
    Saved *saved = state;
    memcpy(bytes, &saved->s, sizeof(State)), bytes += sizeof(State);
    for (int i = 0; i < N_COMPONENTS; i++) {
        Component *c = &m->components[i];
        size_t more = 0;
        c->f->SerializedFMUstateSize(c->instance, saved->components[i], &more);
        const uint64_t count = more;
        memcpy(bytes, &count, sizeof count), bytes += sizeof count;
        const int answer = c->f->SerializeFMUstate(c->instance, saved->components[i], (fmi2Byte *)bytes, more);
        status = judged(m, i, "SerializeFMUstate", answer);
        if (status != OK) return status;
        bytes += more;
    }
    return OK;
}

static Status deserialize(System *m, const char *function, const unsigned char *bytes, size_t size, void **state) {
    State s;
    const unsigned char *end = bytes + size;
    if (!ALL_SERIALIZE) return fail(m, function, "a component cannot write its state");
    if (!state || !bytes || size < sizeof s) return fail(m, function, "these bytes are no state of this system");
    memcpy(&s, bytes, sizeof s), bytes += sizeof s;
    if (!fits(&s)) return fail(m, function, "these bytes are no state of this system");
    if (!*state) *state = calloc(1, sizeof(Saved));
    if (!*state) return fail(m, function, "out of memory");
    Saved *saved = *state;
    saved->s = s;
    for (int i = 0; i < N_COMPONENTS; i++) {
        Component *c = &m->components[i];
        uint64_t count = 0;
        if ((size_t)(end - bytes) < sizeof count) return fail(m, function, "these bytes are cut off");
        memcpy(&count, bytes, sizeof count), bytes += sizeof count;
        if ((uint64_t)(end - bytes) < count) return fail(m, function, "these bytes are cut off");
        void **state_of = &saved->components[i];
        const int answer = c->f->DeSerializeFMUstate(c->instance, (const fmi2Byte *)bytes, (size_t)count, state_of);
        Status status = judged(m, i, "DeSerializeFMUstate", answer);
        if (status != OK) return status;
        bytes += count;
    }
    return OK;
}
