/* What is a saved FMU state, and which one may come back? The bytes of a model and of its place in the life cycle,
 * sealed.
 *
 * The seal names format, size, byte order and the model's tables, and in serialised form carries a checksum: what is
 * cut short, corrupt or of another binary is refused. Bytes may be forged and sealed anew, so that what they say is
 * looked at, too: a state is taken only where an instance could have come to it by itself. A serialised state is good
 * in any process and on any platform of the same byte order.
 */
#include "component.h"

#include <math.h>
#include <string.h>

enum { STATE_VERSION = 1, BYTE_ORDER_MARK = 0x01020304 };
static const char magic[8] = {'E', 'V', 'A', 'T', 'F', 'M', 'U', 'S'};

/* The record: this, and behind it the bytes of the model. */
struct Sealed {
    char magic[8], token[40];
    uint32_t version, byte_order;
    uint64_t size, checksum;
    struct Life life;
};

/* In memory: who frees it (another instance may be asked to), and the record. */
struct State {
    void (*release)(void *memory);
    struct Sealed seal;
};

static size_t record_size(void) { return sizeof(struct Sealed) + model_size(); }
static struct Model *model_in(struct State *state) { return (struct Model *)(state + 1); }
static const struct Model *model_of(const struct State *state) { return (const struct Model *)(state + 1); }

/* Over the record as if its checksum were 0. */
static uint64_t checksum(const struct Sealed *seal, const void *model)
{
    struct Sealed copy;
    memcpy(&copy, seal, sizeof copy);
    copy.checksum = 0;
    return hash_bytes(hash_bytes(HASH_BEGIN, &copy, sizeof copy), model, model_size());
}

static int is_ours(struct Component *c, const struct Sealed *seal)
{
    const char *what = memcmp(seal->magic, magic, sizeof magic) != 0 ? "it is not a state of this FMU"
                       : seal->byte_order != BYTE_ORDER_MARK ? "it was written on a machine of another byte order"
                       : seal->version != STATE_VERSION      ? "it is of another format version"
                       : seal->size != record_size()         ? "it is of another size"
                       : memcmp(seal->token, c->token, sizeof seal->token) != 0
                           ? "its token is that of another build of this FMU"
                           : NULL;
    if (what)
        report(c, ANSWER_ERROR, "the FMU state is refused: %s; allowed is a state that this build has saved.", what);
    return what == NULL;
}

static int fits(struct Component *c, const struct Life *life)
{
    const int other = life->interface != c->life.interface;
    const int eventful =
        life->interface == CO_SIMULATION && (life->mode == EVENT || life->event_pending) && !c->host.event_mode;
    if (other || eventful)
        report(c, ANSWER_ERROR,
               "the FMU state is refused: it is %s; allowed is a state of an instance of the same kind.",
               other ? "of the other interface (Model Exchange or Co-Simulation)"
                     : "in Event Mode, which this instance does not use");
    return !other && !eventful;
}

static int is_flag(uint32_t x) { return x <= 1; }

/* A place in the life cycle where an instance of this standard can be, whoever saved it. */
static const char *flaw_of_life(const struct Component *c, const struct Life *life)
{
    const int solver = life->interface == MODEL_EXCHANGE;
    const uint32_t modes = c->host.modes & ~(uint32_t)(solver ? STEPPING | STEP_FAILED : INTEGRATING);
    if ((life->interface != MODEL_EXCHANGE && life->interface != CO_SIMULATION) || !(life->mode & modes) ||
        (life->mode & (life->mode - 1)))
        return "there is no such state of an instance";
    if (!is_flag(life->stale) || !is_flag(life->set_up) || !is_flag(life->tolerance_set) || !is_flag(life->slope_set) ||
        !is_flag(life->slope_kept) || !is_flag(life->event_pending))
        return "a flag is neither 0 nor 1";
    if (!isfinite(life->start) || !isfinite(life->last_time) || !(life->stop >= life->start))
        return "a time is no number, or the stop time lies before the start time";
    if (!life->set_up && !(life->mode & (INSTANTIATED | CONFIGURING | FAILED)))
        return "it was never set up";
    if (life->slope_kept &&
        (solver || life->slope_set || !(life->mode & (RUNNING | STEP_FAILED | TERMINATED | FAILED))))
        return "inputs have kept derivatives of a step that they cannot have";
    if (life->event_pending && (solver || !(life->mode & (RUNNING | STEP_FAILED | TERMINATED | FAILED))))
        return "an event waits where there is none";
    return NULL;
}

/* Where the life and the model must agree. */
static const char *flaw_between(const struct Life *life, const struct Model *model)
{
    const int failed = life->mode == FAILED, begun = (life->mode & (RUNNING | STEP_FAILED | TERMINATED)) != 0;
    const double now = model_get(model, MODEL_TIME);
    if (!failed && model_started(model) != begun)
        return "the model has begun before the instance, or not with it";
    if (!failed && !begun && life->last_time != life->start)
        return "a step was taken before the start";
    if (begun && life->interface == MODEL_EXCHANGE && model_solver_obstacle(model))
        return model_solver_obstacle(model);
    if (begun && life->interface == CO_SIMULATION && life->last_time != now)
        return "the last step has not ended where the model stands";
    if (begun && life->interface == CO_SIMULATION && !(model_next_event(model) >= now - 1e-9 * fabs(now)))
        return "the model's next event lies in the past";
    for (int place = 0; place < model_input_count() && !life->slope_set && !life->slope_kept; ++place)
        if (model_slope(model, model_input(place)) != 0)
            return "an input has a derivative that was not given";
    return NULL;
}

/* Bytes from outside steer no array index, and bring in nothing that the host could not have brought about. */
static int is_sound(struct Component *c, const struct Life *life, const struct Model *model)
{
    const char *flaw = flaw_of_life(c, life);
    for (int i = 0; i < model_variable_count() && !flaw; ++i) {
        const enum Causality role = model_variable(i)->causality;
        const int given = role == PARAMETER || role == INPUT;
        const enum Status status = given ? model_check(i, model_get(model, i)) : STATUS_OK;
        if (given && !reference_of(c, i) && model_get(model, i) != start_of(c->variant, i))
            flaw = "what this FMU does not show is not as it starts";
        if (status != STATUS_OK) {
            report(c, ANSWER_ERROR, "the FMU state is refused: %s = %g: %s.", model_variable(i)->name,
                   model_get(model, i), status_text(status));
            return 0;
        }
    }
    flaw = flaw ? flaw : model_flaw(model);
    flaw = flaw ? flaw : flaw_between(life, model);
    if (flaw)
        report(c, ANSWER_ERROR, "the FMU state is refused: %s; allowed is a state that this build has saved.", flaw);
    return flaw == NULL;
}

static struct State *state_memory(struct Component *c, void **state)
{
    if (state == NULL) {
        report(c, ANSWER_ERROR, "the pointer to the FMU state is NULL.");
        return NULL;
    }
    const size_t size = sizeof(struct State) + model_size();
    struct State *own = *state ? *state : c->host.allocate(1, size);
    if (own == NULL)
        report(c, ANSWER_ERROR, "no memory for an FMU state of %zu bytes.", size);
    else if (*state == NULL)
        own->release = c->host.release;
    else if (!is_ours(c, &own->seal))
        return NULL;
    return own;
}

enum Answer state_get(struct Component *c, void **state)
{
    struct State *own = state_memory(c, state);
    if (own == NULL)
        return ANSWER_ERROR;
    struct Sealed *seal = &own->seal;
    memset(seal, 0, sizeof *seal);
    memcpy(seal->magic, magic, sizeof magic);
    memcpy(seal->token, c->token, sizeof seal->token);
    seal->version = STATE_VERSION;
    seal->byte_order = BYTE_ORDER_MARK;
    seal->size = record_size();
    memcpy(&seal->life, &c->life, sizeof seal->life);
    memcpy(model_in(own), c->model, model_size());
    *state = own;
    return ANSWER_OK;
}

static int is_given(struct Component *c, const void *pointer, const char *what)
{
    if (pointer == NULL)
        report(c, ANSWER_ERROR, "%s is NULL.", what);
    return pointer != NULL;
}

enum Answer state_set(struct Component *c, const void *state)
{
    const struct State *own = state;
    if (!is_given(c, state, "the FMU state") || !is_ours(c, &own->seal) || !fits(c, &own->seal.life))
        return ANSWER_ERROR;
    for (int i = 0; i < c->state_count; ++i)
        c->tuned |= model_nominal(c->model, c->state[i]) != model_nominal(model_of(own), c->state[i]);
    memcpy(&c->life, &own->seal.life, sizeof c->life);
    memcpy(c->model, model_of(own), model_size());
    c->wired = 0;
    c->life.stale |= c->life.mode == INITIALIZING; /* the preview is not part of the state */
    return ANSWER_OK;
}

enum Answer state_free(struct Component *c, void **state)
{
    if (state == NULL || *state == NULL)
        return ANSWER_OK;
    struct State *own = *state;
    if (!is_ours(c, &own->seal))
        return ANSWER_ERROR;
    memset(own->seal.magic, 0, sizeof own->seal.magic);
    own->release(own);
    *state = NULL;
    return ANSWER_OK;
}

enum Answer state_size(struct Component *c, const void *state, size_t *size)
{
    const struct State *own = state;
    if (!is_given(c, state, "the FMU state") || !is_given(c, size, "the pointer to the size") ||
        !is_ours(c, &own->seal))
        return ANSWER_ERROR;
    *size = record_size();
    return ANSWER_OK;
}

enum Answer state_serialize(struct Component *c, const void *state, void *bytes, size_t size)
{
    const struct State *own = state;
    if (!is_given(c, state, "the FMU state") || !is_given(c, bytes, "the byte vector") || !is_ours(c, &own->seal))
        return ANSWER_ERROR;
    if (size != record_size())
        return report(c, ANSWER_ERROR, "the byte vector has %zu bytes; %zu are needed.", size, record_size());
    struct Sealed seal;
    memcpy(&seal, &own->seal, sizeof seal);
    seal.checksum = checksum(&seal, model_of(own));
    memcpy(bytes, &seal, sizeof seal);
    memcpy((unsigned char *)bytes + sizeof seal, model_of(own), model_size());
    return ANSWER_OK;
}

enum Answer state_deserialize(struct Component *c, const void *bytes, size_t size, void **state)
{
    struct Sealed seal;
    if (!is_given(c, bytes, "the byte vector"))
        return ANSWER_ERROR;
    if (size != record_size())
        return report(
            c, ANSWER_ERROR,
            "the serialised FMU state has %zu bytes; a state of this FMU has %zu: it is cut short or foreign.", size,
            record_size());
    const unsigned char *behind = (const unsigned char *)bytes + sizeof seal;
    memcpy(&seal, bytes, sizeof seal);
    if (!is_ours(c, &seal))
        return ANSWER_ERROR;
    if (seal.checksum != checksum(&seal, behind))
        return report(c, ANSWER_ERROR, "the serialised FMU state is corrupt: its checksum does not match its content.");
    struct Model *model =
        c->host.allocate(1, model_size()); /* the host's bytes may lie anywhere, and a model may not */
    if (model == NULL)
        return report(c, ANSWER_ERROR, "no memory for an FMU state of %zu bytes.", model_size());
    memcpy(model, behind, model_size());
    struct State *own = is_sound(c, &seal.life, model) ? state_memory(c, state) : NULL;
    if (own) {
        seal.checksum = 0;
        memcpy(&own->seal, &seal, sizeof seal);
        memcpy(model_in(own), model, model_size());
        *state = own;
    }
    c->host.release(model);
    return own ? ANSWER_OK : ANSWER_ERROR;
}
