/* What do all models do alike? Bounds, words for a status, hashes: see shared.h. */
#include "shared.h"

#include <math.h>

double bound_slack(const struct Variable *variable)
{
    const double nominal = variable->nominal > 0 ? variable->nominal : 1;
    return variable->causality == INPUT ? BOUND_SLACK * nominal : 0;
}

enum Status check_value(const struct Variable *variable, double value)
{
    if (!variable)
        return STATUS_NO_SUCH_VARIABLE;
    if (!isfinite(value))
        return STATUS_NOT_FINITE;
    if (value < variable->min || value > variable->max) {
        const double slack = bound_slack(variable);
        if (!(value >= variable->min - slack && value <= variable->max + slack) || slack == 0)
            return STATUS_OUT_OF_BOUNDS;
    }
    return variable->type != REAL && value != floor(value) ? STATUS_OUT_OF_BOUNDS : STATUS_OK;
}

double within_bounds(const struct Variable *variable, double value)
{
    return value < variable->min ? variable->min : value > variable->max ? variable->max : value;
}

static const char *const status_texts[STATUS_COUNT] = {
    [STATUS_OK] = "done",
    [STATUS_NO_SUCH_VARIABLE] = "there is no such variable",
    [STATUS_NOT_FINITE] = "the value is not a finite number",
    [STATUS_OUT_OF_BOUNDS] = "the value lies outside its bounds",
    [STATUS_BAD_STEP] = "the step is not a number above 0 and up to 1e9 s",
    [STATUS_TOO_MANY_STEPS] = "it takes internal steps without end, as where contact flickers: change what is on, or "
                              "loosen relative_tolerance",
    [STATUS_DIVERGED] = "a force, a state or another output is no longer a finite number",
    [STATUS_RIVALS] = "two effects are on that are rivals of each other: switch one of them off",
    [STATUS_HISTORY_SHORT] =
        "an effect looks back further than is kept: its time was raised by more than has been kept since, or it takes "
        "more than 256 pieces of the past, or corners of an input, within relative_tolerance; raise the time by "
        "little, "
        "or before the start, shorten it, or loosen relative_tolerance",
    [STATUS_STOPPED] = "stopped on request",
    [STATUS_NO_CYCLE] =
        "averaging = cycle needs a vibration cycle: use kinematics = internal or combined, or averaging = resolved",
    [STATUS_AHEAD] = "an effect asks for an input that comes later (its time is below 0), which a step cannot know: "
                     "follow a record, or shift the forces by that time",
    [STATUS_TEMPERATURES] = "reference_temperature must lie above ambient_temperature, by 0.001 K or more",
};
const char *status_text(enum Status status) { return status < STATUS_COUNT ? status_texts[status] : "unknown status"; }

uint64_t hash_bytes(uint64_t hash, const void *bytes, size_t size)
{
    for (size_t i = 0; i < size; ++i)
        hash = (hash ^ ((const unsigned char *)bytes)[i]) * 1099511628211u;
    return hash;
}

uint64_t hash_text(uint64_t hash, const char *text)
{
    for (; text && *text; ++text)
        hash = hash_bytes(hash, text, 1);
    return hash_bytes(hash, "", 1);
}

uint64_t hash_row(uint64_t hash, const struct Variable *v, int derivative_of, int of_contact)
{
    const double numbers[] = {v->start, v->min, v->max, v->nominal, v->neutral};
    const int32_t kinds[] = {(int32_t)v->type, (int32_t)v->causality, (int32_t)v->variability, derivative_of,
                             v->reference};
    hash = hash_text(hash_text(hash_text(hash, v->name), v->unit), v->display_unit);
    hash = hash_text(hash_text(hash, v->meaning), v->source);
    hash = of_contact ? hash_text(hash, v->required_with) : hash;
    hash = hash_bytes(hash, numbers, sizeof numbers - (of_contact ? 0 : sizeof *numbers));
    hash = hash_bytes(hash, kinds, sizeof kinds - (of_contact ? 0 : sizeof *kinds));
    for (const char *const *choice = v->choices; choice && *choice; ++choice)
        hash = hash_text(hash, *choice);
    return hash;
}

void write_token(uint64_t (*hash_tables)(uint64_t hash), char token[39])
{
    static const char form[] = "{xxxxxxxx-xxxx-xxxx-xxxx-xxxxxxxxxxxx}";
    uint64_t hash = HASH_BEGIN;
    int digit = 0;
    for (int i = 0; i < 39; ++i) {
        if (form[i] == 'x' && digit % 16 == 0)
            hash = hash_tables(hash);
        token[i] = form[i] == 'x' ? "0123456789abcdef"[hash >> 4 * (digit % 16) & 15] : form[i];
        digit += form[i] == 'x';
    }
}
