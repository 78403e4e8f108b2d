/* Do random sequences of legal and illegal calls, with random numbers, break an FMU? Usage:
 *
 *     fuzz SEED FIRST COUNT SECONDS SLOW [verbose]
 *
 * runs the sequences FIRST .. FIRST + COUNT - 1 of SEED, or as many as begin within SECONDS of the clock, and leaves
 * any call that takes more than SLOW seconds of the processor (0: waits). A sequence depends on seed and number only:
 * one that was found is run alone by `fuzz SEED NUMBER 1 1e9 0 verbose`. With MOST_FINDINGS it ends. One line of
 * figures at the end; exit status 1 where there are findings.
 */
#include "acts.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

int variables, states;
int is_start[CAPACITY];
struct One *stepped;

static void look(struct One *one) { (void)get_all(one); }
static void set_strange_time(struct One *one) { set_time_of(one, chance(0.5) ? strange() : between(-1, 1)); }

static void evaluate_discrete(struct One *one)
{
    if (one->version == 3)
        CALL(one, "fmi3EvaluateDiscreteStates", INITIALIZING | EVENT, MUST_PASS, fmi3EvaluateDiscreteStates(one->c));
}

static void count_solver(struct One *one)
{
    size_t count = 0;
    if (one->version == 3)
        CALL(one, "fmi3GetNumberOfContinuousStates", ANY_MODE, one->interface == MODEL_EXCHANGE ? MUST_PASS : MUST_FAIL,
             fmi3GetNumberOfContinuousStates(one->c, &count));
}

static void ask_status_2(struct One *one)
{
    if (one->version == 2)
        ask_status(one);
}

/* In which modes an action is drawn, and how often. */
static const struct Action {
    void (*act)(struct One *one);
    unsigned modes;
    int weight;
} actions[] = {
    {step, STEPPING, 30},
    {integrate, INTEGRATING, 30},
    {update, EVENT, 12},
    {leave_event_mode, EVENT, 10},
    {set_some, SETTING, 8},
    {get_some, READING, 4},
    {look, READING, 4},
    {ramp_inputs, INSTANTIATED | INITIALIZING | STEPPING, 3},
    {enter_event_mode, INTEGRATING, 3},
    {look_as_solver, EVENT | INTEGRATING, 6},
    {completed, INTEGRATING, 1},
    {set_strange_states, INTEGRATING, 1},
    {set_strange_time, INTEGRATING, 1},
    {differentiate, SHOWING, 2},
    {save, ANY_MODE, 3},
    {restore, ANY_MODE, 3},
    {step_and_back, STEPPING, 3},
    {serialise, ANY_MODE, 4},
    {ask_status_2, 0, 1},
    {ask_what_is_not_there, 0, 1},
    {set_logging_of, ANY_MODE, 1},
    {configure, INSTANTIATED | CONFIGURING, 1},
    {initialise, INSTANTIATED, 20},
    {enter_unprepared, 0, 1},
    {exit_initialisation, INITIALIZING, 20},
    {terminate, 0, 1},
    {reset, TERMINATED | FAILED | STEP_FAILED, 6},
    {evaluate_discrete, EVENT, 1},
    {count_solver, 0, 1},
};
enum { ACTIONS = sizeof actions / sizeof *actions };

static void act_once(struct One *one)
{
    int total = 0;
    if (one->pending && one->mode == STEPPING && chance(0.9)) {
        enter_event_mode(one);
        return;
    }
    if (chance(0.02)) {
        actions[below(ACTIONS)].act(one);
        return;
    }
    for (int n = 0; n < ACTIONS; ++n)
        total += actions[n].modes & one->mode ? actions[n].weight : 0;
    int left = total ? below(total) : -1;
    for (int n = 0; n < ACTIONS && total; ++n) {
        left -= actions[n].modes & one->mode ? actions[n].weight : 0;
        if (left < 0) {
            actions[n].act(one);
            return;
        }
    }
}

static void *instantiate(struct One *one, const char *name, const char *token)
{
    static const fmi2CallbackFunctions plain = {NULL, NULL, NULL, NULL, NULL};
    fmi2CallbackFunctions *callbacks = malloc(sizeof *callbacks);
    const fmi3ValueReference wanted[1] = {0};
    void *c;
    *callbacks = plain;
    fmi2CallbackFunctions made = {logger2, chance(0.5) ? calloc : NULL, NULL, NULL, one};
    made.freeMemory = made.allocateMemory ? free : NULL;
    memcpy(callbacks, &made, sizeof made);
    before(one, "instantiate", ANY_MODE);
    if (one->version == 2)
        c = fmi2Instantiate(name, one->interface == MODEL_EXCHANGE ? fmi2ModelExchange : fmi2CoSimulation, token, NULL,
                            callbacks, 0, one->logging);
    else if (one->interface == MODEL_EXCHANGE)
        c = fmi3InstantiateModelExchange(name, token, NULL, false, one->logging, one, logger3);
    else
        c = fmi3InstantiateCoSimulation(name, token, NULL, false, one->logging, one->event_mode, one->early_return,
                                        wanted, one->watched ? 1 : 0, one, logger3,
                                        one->watched ? update_within : NULL);
    after(one, c ? OK : ERROR, MAY_FAIL);
    free(callbacks); /* earlier than FMI 2 asks of a host: what an FMU needs of it, it copies */
    return c;
}

/* Of effects at most a few, or hardly any set of them goes together; and choices that leave something to see. */
static void draw_model(struct One *one)
{
    for (int n = below(14); n > 0 && one->mode != FAILED; --n)
        set_some(one);
    for (int n = below(4); n > 0 && one->mode != FAILED; --n) {
        const int index = below(variables);
        const struct Variable *v = model_variable(index);
        if (v->type == BOOLEAN && v->causality == PARAMETER)
            set_one(one, index, 1);
    }
}

/* Left in the middle of a call. No memory is being handed out there, so that the instance can be freed. */
static void too_slow_now(struct One *one)
{
    tally.slow += 1;
    one->mode = FAILED;
    one->logging = 0; /* the call that was left has had no end: what it has logged is not counted */
}

static void run_sequence(void)
{
    char token[39];
    model_token(token);
    struct One *one = calloc(1, sizeof *one);
    one->version = 2 + below(2);
    one->interface = chance(0.6) ? CO_SIMULATION : MODEL_EXCHANGE;
    one->event_mode = one->version == 3 && one->interface == CO_SIMULATION && chance(0.4);
    one->early_return = one->version == 3 && one->interface == CO_SIMULATION && chance(0.5);
    one->watched = one->version == 3 && chance(0.2);
    one->logging = one->version == 2 || chance(0.9);
    one->mode = INSTANTIATED;
    one->stop = INFINITY;
    stepped = one;
    forget_given(one);
    memset(saved, 0, sizeof saved);
    if (sigsetjmp(too_slow, 1))
        too_slow_now(one);
    else if (chance(0.02)) {
        const int kind = below(3);
        one->logging = 1; /* a refused instance says why, whatever is switched off */
        one->c = instantiate(one, kind == 0 ? NULL : kind == 1 ? " \t" : "one", kind == 2 ? "{no}" : token);
        if (one->c)
            finding("makes an instance from a wrong name or token");
    } else {
        one->c = instantiate(one, "one", token);
        if (!one->c)
            finding("makes no instance");
        else {
            draw_model(one);
            if (chance(0.95))
                initialise(one);
            if (chance(0.3))
                draw_model(one);
            if (chance(0.95))
                exit_initialisation(one);
            for (int n = 5 + below(60); n > 0; --n)
                act_once(one);
        }
    }
    for (int n = 0; n < MOST_STATES && one->c; ++n)
        drop(one, &saved[n].state);
    if (one->c && one->version == 2)
        fmi2FreeInstance(one->c);
    else if (one->c)
        fmi3FreeInstance(one->c);
    free(one);
}

static double clock_now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

int main(int count, char **argument)
{
    if (count < 6) {
        fputs("usage: fuzz SEED FIRST COUNT SECONDS SLOW [verbose]\n", stderr);
        return 2;
    }
    const uint64_t seed = strtoull(argument[1], NULL, 0), first = strtoull(argument[2], NULL, 0),
                   most = strtoull(argument[3], NULL, 0);
    const double seconds = atof(argument[4]), begin = clock_now();
    verbose = count > 6;
    variables = model_variable_count();
    states = model_state_count();
    if (variables > CAPACITY || states > STATES || model_indicator_count() > STATES) {
        fputs("the model has more variables, states or indicators than there is room for\n", stderr);
        return 2;
    }
    for (int n = 0; n < states; ++n)
        is_start[model_state(n)] = 1;
    host_begin(atof(argument[5]));
    for (uint64_t n = first; n < first + most && clock_now() - begin < seconds && tally.findings < MOST_FINDINGS; ++n) {
        sequence_begins(seed, n);
        run_sequence();
    }
    printf(
        "sequences %lld calls %lld ok %lld warning %lld discard %lld error %lld refused %lld numbers %lld steps %lld "
        "done %lld forged %lld taken %lld slow %lld findings %lld seconds %.1f\n",
        tally.sequences, tally.calls, tally.by_status[OK], tally.by_status[WARNING], tally.by_status[DISCARD],
        tally.by_status[ERROR], tally.refused, tally.numbers, tally.steps, tally.steps_done, tally.forged,
        tally.forged_taken, tally.slow, tally.findings, clock_now() - begin);
    fflush(stdout);
    return tally.findings != 0;
}
