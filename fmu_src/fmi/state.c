/* What is a saved FMU state, and which one may come back? The bytes of a contact and of its place in the life cycle,
 * sealed.
 *
 * The seal names format, size, byte order and the kernel's tables, and in serialised form carries a checksum: what is
 * cut short, corrupt or of another binary is refused. Bytes may be forged and sealed anew, so that what they say is
 * looked at, too: a state is taken only where an instance could have come to it by itself. A serialised state is good
 * in any process and on any platform of the same byte order.
 */
#include "component.h"

#include <math.h>
#include <string.h>

enum { STATE_VERSION = 1, BYTE_ORDER_MARK = 0x01020304 };
static const char magic[8] = {'E', 'V', 'A', 'T', 'F', 'M', 'U', 'S'};

struct Sealed {
    char magic[8], token[40];
    uint32_t version, byte_order;
    uint64_t size, checksum;
    struct Life life;
    struct Contact contact;
};

/* In memory: the record, and who frees it (another instance may be asked to). */
struct State {
    struct Sealed record;
    void (*release)(void *memory);
};

/* FNV-1a, 64 bits, over the record as if its checksum were 0. */
static uint64_t checksum(const struct Sealed *record)
{
    struct Sealed copy;
    const unsigned char *bytes = (const unsigned char *)&copy;
    uint64_t hash = 14695981039346656037u;
    memcpy(&copy, record, sizeof copy);
    copy.checksum = 0;
    for (size_t i = 0; i < sizeof copy; ++i)
        hash = (hash ^ bytes[i]) * 1099511628211u;
    return hash;
}

static int is_ours(struct Component *c, const struct Sealed *record)
{
    const char *what = memcmp(record->magic, magic, sizeof magic) != 0 ? "it is not a state of this FMU"
                       : record->byte_order != BYTE_ORDER_MARK ? "it was written on a machine of another byte order"
                       : record->version != STATE_VERSION      ? "it is of another format version"
                       : record->size != sizeof *record        ? "it is of another size"
                       : memcmp(record->token, c->token, sizeof record->token) != 0
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
        !is_flag(life->event_pending) || life->reserved)
        return "a flag is neither 0 nor 1";
    if (!isfinite(life->start) || !isfinite(life->last_time) || !(life->stop >= life->start))
        return "a time is no number, or the stop time lies before the start time";
    if (!life->set_up && !(life->mode & (INSTANTIATED | CONFIGURING | FAILED)))
        return "it was never set up";
    if (life->event_pending && (solver || !(life->mode & (RUNNING | STEP_FAILED | TERMINATED | FAILED))))
        return "an event waits where there is none";
    return NULL;
}

/* Where the life and the model must agree. */
static const char *flaw_between(const struct Life *life, const struct Contact *contact)
{
    const int failed = life->mode == FAILED, begun = (life->mode & (RUNNING | STEP_FAILED | TERMINATED)) != 0;
    const double now = contact->value[VAR_TIME][0];
    if (!failed && contact->started != (uint32_t)begun)
        return "the model has begun before the instance, or not with it";
    if (!failed && !begun && life->last_time != life->start)
        return "a step was taken before the start";
    if (begun && life->interface == MODEL_EXCHANGE && kernel_averages(contact))
        return "it averages over cycles in Model Exchange";
    if (begun && life->interface == CO_SIMULATION && life->last_time != now)
        return "the last step has not ended where the model stands";
    if (begun && life->interface == CO_SIMULATION && !(kernel_next_event(contact) >= now - 1e-9 * fabs(now)))
        return "the model's next event lies in the past";
    for (int k = 0; k < INPUT_END - INPUT_FIRST && !life->slope_set; ++k)
        if (contact->slope[k][0] != 0)
            return "an input has a derivative that was not given";
    return NULL;
}

/* Bytes from outside steer no array index, and bring in nothing that the host could not have brought about. */
static int is_sound(struct Component *c, const struct Life *life, const struct Contact *contact)
{
    const char *flaw = flaw_of_life(c, life);
    for (int i = 0; i < c->count && !flaw; ++i) {
        const enum Causality role = kernel_variable(i)->causality;
        const enum Status status =
            role == PARAMETER || role == INPUT ? kernel_check(i, contact->value[i][0]) : KERNEL_OK;
        if (status != KERNEL_OK) {
            report(c, ANSWER_ERROR, "the FMU state is refused: %s = %g: %s.", kernel_variable(i)->name,
                   contact->value[i][0], kernel_status_text(status));
            return 0;
        }
    }
    flaw = flaw ? flaw : kernel_flaw(contact);
    flaw = flaw ? flaw : flaw_between(life, contact);
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
    struct State *own = *state ? *state : c->host.allocate(1, sizeof *own);
    if (own == NULL)
        report(c, ANSWER_ERROR, "no memory for an FMU state of %zu bytes.", sizeof *own);
    else if (*state == NULL)
        own->release = c->host.release;
    else if (!is_ours(c, &own->record))
        return NULL;
    return own;
}

enum Answer state_get(struct Component *c, void **state)
{
    struct State *own = state_memory(c, state);
    if (own == NULL)
        return ANSWER_ERROR;
    struct Sealed *record = &own->record;
    memset(record, 0, sizeof *record);
    memcpy(record->magic, magic, sizeof magic);
    memcpy(record->token, c->token, sizeof record->token);
    record->version = STATE_VERSION;
    record->byte_order = BYTE_ORDER_MARK;
    record->size = sizeof *record;
    memcpy(&record->life, &c->life, sizeof record->life);
    memcpy(&record->contact, &c->contact, sizeof record->contact);
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
    if (!is_given(c, state, "the FMU state") || !is_ours(c, &own->record) || !fits(c, &own->record.life))
        return ANSWER_ERROR;
    memcpy(&c->life, &own->record.life, sizeof c->life);
    memcpy(&c->contact, &own->record.contact, sizeof c->contact);
    c->life.stale |= c->life.mode == INITIALIZING; /* the preview is not part of the state */
    return ANSWER_OK;
}

enum Answer state_free(struct Component *c, void **state)
{
    if (state == NULL || *state == NULL)
        return ANSWER_OK;
    struct State *own = *state;
    if (!is_ours(c, &own->record))
        return ANSWER_ERROR;
    memset(own->record.magic, 0, sizeof own->record.magic);
    own->release(own);
    *state = NULL;
    return ANSWER_OK;
}

enum Answer state_size(struct Component *c, const void *state, size_t *size)
{
    const struct State *own = state;
    if (!is_given(c, state, "the FMU state") || !is_given(c, size, "the pointer to the size") ||
        !is_ours(c, &own->record))
        return ANSWER_ERROR;
    *size = sizeof own->record;
    return ANSWER_OK;
}

enum Answer state_serialize(struct Component *c, const void *state, void *bytes, size_t size)
{
    const struct State *own = state;
    if (!is_given(c, state, "the FMU state") || !is_given(c, bytes, "the byte vector") || !is_ours(c, &own->record))
        return ANSWER_ERROR;
    if (size != sizeof own->record)
        return report(c, ANSWER_ERROR, "the byte vector has %zu bytes; %zu are needed.", size, sizeof own->record);
    struct Sealed record;
    memcpy(&record, &own->record, sizeof record);
    record.checksum = checksum(&record);
    memcpy(bytes, &record, sizeof record);
    return ANSWER_OK;
}

enum Answer state_deserialize(struct Component *c, const void *bytes, size_t size, void **state)
{
    struct Sealed record;
    if (!is_given(c, bytes, "the byte vector"))
        return ANSWER_ERROR;
    if (size != sizeof record)
        return report(
            c, ANSWER_ERROR,
            "the serialised FMU state has %zu bytes; a state of this FMU has %zu: it is cut short or foreign.", size,
            sizeof record);
    memcpy(&record, bytes, sizeof record);
    if (!is_ours(c, &record))
        return ANSWER_ERROR;
    if (record.checksum != checksum(&record))
        return report(c, ANSWER_ERROR, "the serialised FMU state is corrupt: its checksum does not match its content.");
    if (!is_sound(c, &record.life, &record.contact))
        return ANSWER_ERROR;
    record.checksum = 0;
    struct State *own = state_memory(c, state);
    if (own == NULL)
        return ANSWER_ERROR;
    memcpy(&own->record, &record, sizeof record);
    *state = own;
    return ANSWER_OK;
}
