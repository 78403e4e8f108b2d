/* Which variables, laws and effects does the kernel have, and where does each keep its values? */
#include "kernel.h"
#include "registry.h"
#include "shared.h"
#include "stages.h"

#define DECLARE_LAW(name) extern const struct FrictionLaw friction_##name;
#define DECLARE_EFFECT(name) extern const struct Effect effect_##name;
FRICTION_LAWS(DECLARE_LAW)
EFFECTS(DECLARE_EFFECT)

#define LAW_NAME(name) #name,
#define LAW_ADDRESS(name) &friction_##name,
#define EFFECT_ADDRESS(name) &effect_##name,
const char *const law_names[LAW_COUNT + 1] = {FRICTION_LAWS(LAW_NAME) NULL};
static const struct FrictionLaw *const laws[LAW_COUNT] = {FRICTION_LAWS(LAW_ADDRESS)};
static const struct Effect *const effects[EFFECT_COUNT] = {EFFECTS(EFFECT_ADDRESS)};

int kernel_law_count(void) { return LAW_COUNT; }
int kernel_effect_count(void) { return EFFECT_COUNT; }
const struct FrictionLaw *kernel_law(int place) { return place >= 0 && place < LAW_COUNT ? laws[place] : NULL; }
const struct Effect *kernel_effect(int place) { return place >= 0 && place < EFFECT_COUNT ? effects[place] : NULL; }

int law_values(int place)
{
    int index = BASE_COUNT;
    for (int i = 0; i < place; ++i)
        index += laws[i]->count;
    return index;
}

int kernel_effect_switch(int place)
{
    int index = law_values(LAW_COUNT);
    for (int i = 0; i < place; ++i)
        index += effects[i]->count;
    return index;
}

int kernel_variable_count(void) { return kernel_effect_switch(EFFECT_COUNT); }

const struct Variable *kernel_variable(int index)
{
    if (index < 0)
        return NULL;
    if (index < BASE_COUNT)
        return &base_variables[index];
    index -= BASE_COUNT;
    for (int i = 0; i < LAW_COUNT; index -= laws[i++]->count)
        if (index < laws[i]->count)
            return &laws[i]->variables[index];
    for (int i = 0; i < EFFECT_COUNT; index -= effects[i++]->count)
        if (index < effects[i]->count)
            return &effects[i]->variables[index];
    return NULL;
}

const int integral_of[INTEGRALS] = {VAR_SLIDING_DISTANCE,
                                    VAR_DISSIPATED_ENERGY,
                                    VAR_SHEAR_ENERGY,
                                    VAR_FRICTION_IMPULSE,
                                    VAR_PRINCIPAL_IMPULSE,
                                    VAR_FEED_IMPULSE,
                                    VAR_NORMAL_IMPULSE,
                                    VAR_CONTACT_TIME,
                                    VAR_MEASURED_FRICTION_IMPULSE,
                                    VAR_MEASURED_PRINCIPAL_IMPULSE,
                                    VAR_MEASURED_FEED_IMPULSE};

static const int base_states[BASE_STATES] = {VAR_BRISTLE_DEFLECTION,
                                             VAR_SLIDING_DISTANCE,
                                             VAR_RECENT_DISSIPATED_ENERGY,
                                             VAR_RECENT_SHEAR_ENERGY,
                                             VAR_RECENT_FRICTION_IMPULSE,
                                             VAR_RECENT_PRINCIPAL_IMPULSE,
                                             VAR_RECENT_FEED_IMPULSE,
                                             VAR_RECENT_NORMAL_IMPULSE,
                                             VAR_RECENT_CONTACT_TIME,
                                             VAR_RECENT_MEASURED_FRICTION_IMPULSE,
                                             VAR_RECENT_MEASURED_PRINCIPAL_IMPULSE,
                                             VAR_RECENT_MEASURED_FEED_IMPULSE};

int kernel_state_count(void)
{
    int count = BASE_STATES;
    for (int n = 0; n < EFFECT_COUNT; ++n)
        count += effects[n]->states;
    return count;
}

int kernel_state(int place)
{
    if (place < BASE_STATES)
        return place >= 0 ? base_states[place] : -1;
    place -= BASE_STATES;
    for (int n = 0; n < EFFECT_COUNT; place -= effects[n++]->states)
        if (place < effects[n]->states)
            return kernel_effect_switch(n) + effects[n]->count - 2 * effects[n]->states + place;
    return -1;
}

int kernel_derivative_of(int index)
{
    if (index < 0 || index < BASE_COUNT)
        return index < 0 ? 0 : base_variables[index].derivative_of;
    for (int n = 0, end = kernel_effect_switch(0); n < EFFECT_COUNT; ++n) {
        end += effects[n]->count;
        if (index < end)
            return index >= end - effects[n]->states ? index - effects[n]->states : 0;
    }
    return 0;
}

int kernel_indicator(int place) { return place >= 0 && place < INDICATORS ? VAR_CONTACT_INDICATOR + place : -1; }

static uint64_t hash_tables(uint64_t hash)
{
    const int count = kernel_variable_count();
    for (int i = 0; i < count; ++i)
        hash = hash_row(hash, kernel_variable(i), kernel_derivative_of(i), 1);
    for (int i = 0; i < LAW_COUNT; ++i)
        hash = hash_text(hash_text(hash_text(hash_text(hash, laws[i]->meaning), laws[i]->equation), laws[i]->source),
                         laws[i]->reads);
    for (int i = 0; i < EFFECT_COUNT; ++i) {
        const struct Effect *const e = effects[i];
        hash = hash_text(hash_text(hash_text(hash, e->equation), e->signature), e->rivals);
        hash = hash_text(hash_text(hash_text(hash, e->needs), e->applies_to), e->family);
        hash = hash_text(hash_text(hash, e->unsteady ? "unsteady" : NULL), e->form_of_law ? "form of law" : NULL);
        hash = hash_text(hash_text(hash, e->keeps_mean ? "keeps mean" : NULL), e->irreversible ? "irreversible" : NULL);
    }
    return hash;
}

void kernel_token(char token[39]) { write_token(hash_tables, token); }

const char *kernel_status_text(enum Status status) { return status_text(status); }

/* `more` behind what text holds, as far as it has room. */
static void append(char *text, size_t size, const char *more)
{
    size_t used = 0;
    while (used + 1 < size && text[used])
        ++used;
    while (used + 1 < size && *more)
        text[used++] = *more++;
    if (used < size)
        text[used] = '\0';
}

static void append_choice(const struct Contact *contact, int index, char *text, size_t size)
{
    const struct Variable *v = kernel_variable(index);
    append(text, size, v->name);
    append(text, size, " = ");
    append(text, size, v->choices[(int)contact->value[index][0]]);
}

void kernel_explain(const struct Contact *contact, enum Status status, char *text, size_t size)
{
    if (size > 0)
        text[0] = '\0';
    append(text, size, kernel_status_text(status));
    int rivals[2];
    if (status == STATUS_RIVALS && rivals_among(effects_switched_on(contact), rivals)) {
        append(text, size, " (");
        append(text, size, kernel_effect(rivals[0])->variables[0].name);
        append(text, size, " and ");
        append(text, size, kernel_effect(rivals[1])->variables[0].name);
        append(text, size, ")");
    }
    if (status != STATUS_TOO_MANY_STEPS && status != STATUS_DIVERGED && status != STATUS_HISTORY_SHORT)
        return;
    append(text, size, " (");
    append_choice(contact, VAR_FRICTION_LAW, text, size);
    append(text, size, ", ");
    append_choice(contact, VAR_KINEMATICS, text, size);
    append(text, size, ", ");
    append_choice(contact, VAR_CHIP_FLOW_ANGLE, text, size);
    for (int n = 0, any = 0; n < EFFECT_COUNT; ++n)
        if (contact->effects_on >> n & 1) {
            append(text, size, any++ ? ", " : "; on: ");
            append(text, size, kernel_effect(n)->variables[0].name);
        }
    append(text, size, ")");
}

static const char *const warning_texts[WARNING_COUNT] = {
    AT_BOUND_TEXT "; clamped_count counts the steps",
    "the thermally softened stiffness reached its floor (the paper's eq. 7, P > v^Q, is violated); clamped_count "
    "counts the steps",
    "a friction force lay outside the domain of the shear-angle principle and the normal force was kept at 0",
    "contact_temperature lies below ambient_temperature; the temperature proxy was kept at 0",
    "slip_velocity was set but kinematics = internal takes the slip from the ellipse; set kinematics = external to use "
    "the input",
    "no periodic steady state of the vibration cycle was found (not every law has one, external kinematics has none)",
    "the tool moves back below the surface that stands, and its clearance face is pressed on the work: that leaves a "
    "surface, but no force of it is modelled; turn the ellipse (phase_x, phase_y) or reduce feed",
    "the tool turns back along the cut but moves into the material throughout the cycle, so that no stroke begins: the "
    "thickness counts what it left until its slowest motion into the material; change rake_angle, phases or "
    "cutting_speed",
    "the clearance face stands in the surface that the tool leaves, by up to ",
    "flow_stress_softening would leave less than a hundredth of the shear stress, at which it is held: reduce "
    "flow_stress_softening.softening, or raise theta_ref, until softening (theta/theta_ref)^exponent stays below 1",
};

/* A length in micrometres, to the nanometre. */
static void append_length(double length, char *text, size_t size)
{
    char digits[24];
    size_t n = sizeof digits;
    digits[--n] = '\0';
    int place = 0;
    for (uint64_t nanometres = (uint64_t)(1e9 * length + 0.5); place < 4 || nanometres > 0; nanometres /= 10) {
        if (place++ == 3)
            digits[--n] = '.';
        digits[--n] = (char)('0' + nanometres % 10);
    }
    append(text, size, digits + n);
    append(text, size, " um");
}

void kernel_explain_warning(const struct Contact *contact, int bit, char *text, size_t size)
{
    if (size > 0)
        text[0] = '\0';
    append(text, size, bit >= 0 && bit < WARNING_COUNT ? warning_texts[bit] : "unknown warning");
    if (bit < 0 || bit >= WARNING_COUNT || 1u << bit != WARN_CLEARANCE)
        return;
    append_length(contact->flank_depth, text, size);
    append(text, size,
           " in a cycle of the ellipse with which that was first seen: it is pressed on the work there, and only "
           "process_damping models a force of that; check clearance_angle, turn the ellipse (phase_x, phase_y), cut "
           "faster or reduce amplitude_y");
}

static const char *const stage_names[STAGE_COUNT] = {
    [STAGE_PATH] = "path",
    [STAGE_ENGAGEMENT] = "engagement",
    [STAGE_TEMPERATURE] = "temperature",
    [STAGE_SHEAR] = "shear",
    [STAGE_LOAD] = "load",
    [STAGE_FRICTION] = "friction",
    [STAGE_BRISTLE] = "bristle",
    [STAGE_FORCES] = "forces",
    [STAGE_MEASUREMENT] = "measurement",
};
const char *kernel_stage_name(enum Stage stage) { return stage < STAGE_COUNT ? stage_names[stage] : "unknown stage"; }

int kernel_averages(const struct Contact *contact) { return (int)contact->value[VAR_AVERAGING][0] == CYCLE; }

size_t kernel_size(void) { return sizeof(struct Contact); }
int kernel_lanes(void) { return LANES; }
