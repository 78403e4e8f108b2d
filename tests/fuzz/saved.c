/* What does the fuzz do with FMU states? It saves them, brings them back, and forges their bytes, sealed anew. */
#include "acts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

struct Saved saved[MOST_STATES];

void save_at(struct One *one, struct Saved *at)
{
    if (CALL(one, NAME("GetFMUstate", "GetFMUState"), ANY_MODE, MUST_PASS,
             EITHER(fmi2GetFMUstate(one->c, &at->state), fmi3GetFMUState(one->c, &at->state))) > WARNING)
        return;
    at->mode = one->mode;
    at->set_up = one->set_up;
    at->pending = one->pending;
    at->ramped = one->ramped;
    at->start = one->start;
    at->stop = one->stop;
}

void save(struct One *one) { save_at(one, &saved[below(MOST_STATES)]); }

static int set_state_of(struct One *one, void *state, enum Verdict verdict)
{
    return CALL(one, NAME("SetFMUstate", "SetFMUState"), ANY_MODE, verdict,
                EITHER(fmi2SetFMUstate(one->c, state), fmi3SetFMUState(one->c, state)));
}

void restore_from(struct One *one, const struct Saved *at)
{
    if (set_state_of(one, at->state, at->state ? MUST_PASS : MUST_FAIL) > WARNING)
        return;
    one->mode = at->mode;
    one->set_up = at->set_up;
    one->pending = at->pending;
    one->ramped = at->ramped;
    one->start = at->start;
    one->stop = at->stop;
    forget_given(one);
}

void restore(struct One *one)
{
    const struct Saved *at = &saved[below(MOST_STATES)];
    if (at->state || chance(0.05))
        restore_from(one, at);
}

void drop(struct One *one, void **state)
{
    CALL(one, NAME("FreeFMUstate", "FreeFMUState"), ANY_MODE, MUST_PASS,
         EITHER(fmi2FreeFMUstate(one->c, state), fmi3FreeFMUState(one->c, state)));
    if (*state)
        finding("leaves the pointer to a state that is freed");
}

/* Of a serialised state: magic, token, versions and sizes; the checksum; the life; the model. */
enum { SEAL = 64, LIFE = 72, MODEL = LIFE + sizeof(struct Life) };

static void seal(unsigned char *bytes, size_t size)
{
    uint64_t hash = 14695981039346656037u;
    memset(bytes + SEAL, 0, sizeof hash);
    for (size_t i = 0; i < size; ++i)
        hash = (hash ^ bytes[i]) * 1099511628211u;
    memcpy(bytes + SEAL, &hash, sizeof hash);
}

static double forged_number(double was)
{
    switch (below(5)) {
    case 0:
        return -was;
    case 1:
        return was * spread(1e-6, 1e6);
    case 2:
        return was + (double)(below(2001) - 1000);
    case 3:
        return (double)(below(601) - 300);
    default:
        return strange();
    }
}

/* Where the model keeps what no table bounds lies behind its values. */
static size_t drawn_place(size_t size, size_t width)
{
    const size_t hidden = MODEL + sizeof(double) * (size_t)variables, most = 1700;
    switch (below(8)) {
    case 0:
        return (size_t)below(MODEL) / width * width;
    case 1:
    case 2:
    case 3:
        return MODEL + (size_t)below(variables) * sizeof(double) + (width < 8 ? (size_t)below(2) * 4 : 0);
    case 4:
    case 5:
    case 6:
        return hidden + (size_t)below((int)(size - hidden < most ? size - hidden - 8 : most)) / width * width;
    default:
        return (size_t)below((int)size - 8) / width * width;
    }
}

static void forge_bytes(unsigned char *bytes, size_t size)
{
    for (int n = 1 + below(3); n > 0; --n)
        switch (below(4)) {
        case 0:
            bytes[drawn_place(size, 1)] ^= (unsigned char)(1 << below(8));
            break;
        case 1: {
            const uint32_t word = chance(0.5) ? (uint32_t)luck() : chance(0.5) ? 1u << below(32) : (uint32_t)below(4);
            memcpy(bytes + drawn_place(size, 4), &word, sizeof word);
            break;
        }
        default: {
            double number;
            unsigned char *place = bytes + drawn_place(size, 8);
            memcpy(&number, place, sizeof number);
            number = forged_number(number);
            memcpy(place, &number, sizeof number);
        }
        }
}

/* A state that comes back from bytes is where it says it is, and that is a place where such an instance can be. */
static void take_place(struct One *one, const unsigned char *bytes)
{
    struct Life life;
    memcpy(&life, bytes + LIFE, sizeof life);
    const unsigned kinds = (one->interface == MODEL_EXCHANGE
                                ? INTEGRATING | EVENT
                                : STEPPING | (one->version == 2 ? STEP_FAILED : 0) | (one->event_mode ? EVENT : 0)) |
                           INSTANTIATED | INITIALIZING | TERMINATED | FAILED | (one->version == 3 ? CONFIGURING : 0);
    if ((life.mode & (life.mode - 1)) || !(life.mode & kinds)) {
        finding("takes a state in mode %u", life.mode);
        life.mode = FAILED;
    }
    if (life.interface != (unsigned)one->interface)
        finding("takes a state of interface %u", life.interface);
    one->mode = life.mode;
    one->set_up = (int)life.set_up;
    one->pending = life.event_pending != 0;
    one->ramped = 1;
    one->start = life.start;
    one->stop = life.stop;
    forget_given(one);
}

void serialise(struct One *one)
{
    struct Saved *from = &saved[below(MOST_STATES)];
    size_t size = 0, size_again = 0;
    void *state = NULL;
    if (!from->state) {
        save(one);
        return;
    }
    if (CALL(one, NAME("SerializedFMUstateSize", "SerializedFMUStateSize"), ANY_MODE, MUST_PASS,
             EITHER(fmi2SerializedFMUstateSize(one->c, from->state, &size),
                    fmi3SerializedFMUStateSize(one->c, from->state, &size))) > WARNING)
        return;
    unsigned char *bytes = malloc(size + 8), *again = malloc(size + 8);
    const size_t told = chance(0.02) ? size - 1 : size;
    /* bytes as bytes: nothing says that they lie where a double may lie */
    unsigned char *place = bytes + below(8);
    int status =
        CALL(one, NAME("SerializeFMUstate", "SerializeFMUState"), ANY_MODE, told == size ? MUST_PASS : MUST_FAIL,
             EITHER(fmi2SerializeFMUstate(one->c, from->state, (fmi2Byte *)place, told),
                    fmi3SerializeFMUState(one->c, from->state, place, told)));
    if (status <= WARNING) {
        const int forged = chance(0.6), sealed = chance(0.95);
        memcpy(again, place, size);
        if (forged)
            forge_bytes(place, size);
        const int changed = forged && memcmp(again, place, size) != 0;
        if (changed && sealed)
            seal(place, size);
        tally.forged += changed;
        const size_t given = chance(0.01) ? (size_t)below((int)size) : size;
        const int sane = from->mode & (INSTANTIATED | CONFIGURING | INITIALIZING | RUNNING | TERMINATED);
        const enum Verdict verdict = given != size || (changed && !sealed) ? MUST_FAIL
                                     : changed || !sane                    ? MAY_FAIL
                                                                           : MUST_PASS;
        status = CALL(one, NAME("DeSerializeFMUstate", "DeserializeFMUState"), ANY_MODE, verdict,
                      EITHER(fmi2DeSerializeFMUstate(one->c, (fmi2Byte *)place, given, &state),
                             fmi3DeserializeFMUState(one->c, place, given, &state)));
        if (status <= WARNING && set_state_of(one, state, changed ? MAY_FAIL : MUST_PASS) <= WARNING) {
            tally.forged_taken += changed;
            take_place(one, place);
            void *same = NULL;
            CALL(one, NAME("GetFMUstate", "GetFMUState"), ANY_MODE, MUST_PASS,
                 EITHER(fmi2GetFMUstate(one->c, &same), fmi3GetFMUState(one->c, &same)));
            CALL(one, NAME("SerializeFMUstate", "SerializeFMUState"), ANY_MODE, MUST_PASS,
                 EITHER(fmi2SerializeFMUstate(one->c, same, (fmi2Byte *)again, size),
                        fmi3SerializeFMUState(one->c, same, again, size)));
            size_again = one->mode == INITIALIZING ? 0 : size; /* what is stepped then is worked out anew */
            if (memcmp(again, place, size_again) != 0)
                finding("does not give back the bytes of a state that was taken from bytes");
            drop(one, &same);
        }
        if (state)
            drop(one, &state);
    }
    free(bytes);
    free(again);
}
