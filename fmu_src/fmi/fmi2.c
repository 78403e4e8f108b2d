/* How does a host of FMI 2.0 reach an instance? Every function of the standard, in the order of its header, over
 * component.h. */
#include "component.h"

#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"

#define ENTER(modes)                                                                                                   \
    do {                                                                                                               \
        if (refuses(c, __func__, modes))                                                                               \
            return fmi2Error;                                                                                          \
    } while (0)
#define ANSWER(answer) return (fmi2Status)(answer)

enum { SETTING = INSTANTIATED | INITIALIZING | RUNNING };

static const struct Access reals = {"Real", FORM_DOUBLE, 1u << REAL};
static const struct Access integers = {"Integer or Enumeration", FORM_INT32, 1u << INTEGER | 1u << CHOICE};
static const struct Access booleans = {"Boolean", FORM_INT, 1u << BOOLEAN};

/* The text stands where printf's format stands, since many hosts read nothing behind it; a '%' must not be taken for a
 * format. */
static void say(const struct Host *host, enum Answer answer, const char *category, const char *text)
{
    fmi2CallbackLogger logger = (fmi2CallbackLogger)host->logger;
    if (logger)
        logger(host->environment, host->name, (fmi2Status)answer, category, strchr(text, '%') ? "%s" : text, text);
}

/* ---- common functions ---- */

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char *fmi2GetVersion(void) { return fmi2Version; }

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean loggingOn, size_t nCategories,
                               const fmi2String categories[])
{
    ENTER(ANY_MODE);
    ANSWER(set_logging(c, loggingOn, nCategories, categories));
}

fmi2Component fmi2Instantiate(fmi2String instanceName, fmi2Type fmuType, fmi2String fmuGUID,
                              fmi2String fmuResourceLocation, const fmi2CallbackFunctions *functions,
                              fmi2Boolean visible, fmi2Boolean loggingOn)
{
    (void)fmuResourceLocation;
    (void)visible;
    if (functions == NULL)
        return NULL;
    const int own_memory = functions->allocateMemory && functions->freeMemory;
    struct Host host = {
        .say = say,
        .logger = (void (*)(void))functions->logger,
        .environment = functions->componentEnvironment,
        .allocate = own_memory ? functions->allocateMemory : calloc,
        .release = own_memory ? functions->freeMemory : free,
        .name = instanceName ? instanceName : "",
        .categories = loggingOn ? STATUS_CATEGORIES : ERROR_CATEGORIES,
        .warned = ANSWER_OK, /* a line in the log is enough: some hosts take every other answer for a failure */
        .partial_step = ANSWER_DISCARD,
        .modes = ANY_MODE & ~(unsigned)CONFIGURING};
    if (fmuType != fmi2ModelExchange && fmuType != fmi2CoSimulation) {
        refuse_instance(&host, "%s: there is no FMU type %d; allowed are 0 (Model Exchange) and 1 (Co-Simulation).",
                        __func__, (int)fmuType);
        return NULL;
    }
    return component_new(__func__, &host, fmuType == fmi2ModelExchange ? MODEL_EXCHANGE : CO_SIMULATION, instanceName,
                         fmuGUID);
}

void fmi2FreeInstance(fmi2Component c) { component_free(c); }

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean toleranceDefined, fmi2Real tolerance, fmi2Real startTime,
                               fmi2Boolean stopTimeDefined, fmi2Real stopTime)
{
    ENTER(INSTANTIATED);
    ANSWER(component_set_up(c, toleranceDefined, tolerance, startTime, stopTimeDefined, stopTime));
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c)
{
    ENTER(INSTANTIATED);
    ANSWER(component_enter(c, INITIALIZING));
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c)
{
    ENTER(INITIALIZING);
    ANSWER(component_start(c));
}

fmi2Status fmi2Terminate(fmi2Component c)
{
    ENTER(RUNNING | STEP_FAILED);
    ANSWER(component_enter(c, TERMINATED));
}

fmi2Status fmi2Reset(fmi2Component c)
{
    ENTER(ANY_MODE);
    ANSWER(component_reset(c));
}

/* The standard asks for values after instantiation only; what has been set may be read before, too. */
fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2Real value[])
{
    ENTER(SHOWING | INSTANTIATED);
    ANSWER(get_values(c, &reals, vr, nvr, value));
}

fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2Integer value[])
{
    ENTER(SHOWING | INSTANTIATED);
    ANSWER(get_values(c, &integers, vr, nvr, value));
}

fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2Boolean value[])
{
    ENTER(SHOWING | INSTANTIATED);
    ANSWER(get_values(c, &booleans, vr, nvr, value));
}

fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2String value[])
{
    (void)vr;
    (void)value;
    ENTER(SHOWING | INSTANTIATED);
    ANSWER(no_variables(c, "String", nvr));
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2Real value[])
{
    ENTER(SETTING);
    ANSWER(set_values(c, &reals, vr, nvr, value));
}

fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2Integer value[])
{
    ENTER(SETTING);
    ANSWER(set_values(c, &integers, vr, nvr, value));
}

fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2Boolean value[])
{
    ENTER(SETTING);
    ANSWER(set_values(c, &booleans, vr, nvr, value));
}

fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2String value[])
{
    (void)vr;
    (void)value;
    ENTER(SETTING);
    ANSWER(no_variables(c, "String", nvr));
}

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *FMUstate)
{
    ENTER(ANY_MODE);
    ANSWER(state_get(c, FMUstate));
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate FMUstate)
{
    ENTER(ANY_MODE);
    ANSWER(state_set(c, FMUstate));
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *FMUstate)
{
    ENTER(ANY_MODE);
    ANSWER(state_free(c, FMUstate));
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate FMUstate, size_t *size)
{
    ENTER(ANY_MODE);
    ANSWER(state_size(c, FMUstate, size));
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate FMUstate, fmi2Byte serializedState[], size_t size)
{
    ENTER(ANY_MODE);
    ANSWER(state_serialize(c, FMUstate, serializedState, size));
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte serializedState[], size_t size,
                                   fmi2FMUstate *FMUstate)
{
    ENTER(ANY_MODE);
    ANSWER(state_deserialize(c, serializedState, size, FMUstate));
}

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference vUnknown_ref[], size_t nUnknown,
                                        const fmi2ValueReference vKnown_ref[], size_t nKnown, const fmi2Real dvKnown[],
                                        fmi2Real dvUnknown[])
{
    ENTER(SHOWING);
    ANSWER(get_derivative(c, 0, vUnknown_ref, nUnknown, vKnown_ref, nKnown, dvKnown, dvUnknown));
}

/* ---- model exchange ---- */

fmi2Status fmi2EnterEventMode(fmi2Component c)
{
    ENTER(INTEGRATING | EVENT);
    ANSWER(component_enter(c, EVENT));
}

fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo *info)
{
    struct News news;
    ENTER(EVENT);
    if (info == NULL)
        ANSWER(report(c, ANSWER_ERROR, "the pointer to the event information is NULL."));
    const enum Answer answer = component_event(c, &news);
    if (answer <= ANSWER_WARNING)
        *info = (fmi2EventInfo){.nominalsOfContinuousStatesChanged = news.nominals_changed,
                                .valuesOfContinuousStatesChanged = news.states_changed,
                                .nextEventTimeDefined = news.next_event_defined,
                                .nextEventTime = news.next_event};
    ANSWER(answer);
}

fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c)
{
    ENTER(EVENT);
    ANSWER(component_enter(c, INTEGRATING));
}

fmi2Status fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean noSetFMUStatePriorToCurrentPoint,
                                       fmi2Boolean *enterEventMode, fmi2Boolean *terminateSimulation)
{
    (void)noSetFMUStatePriorToCurrentPoint;
    ENTER(INTEGRATING);
    if (enterEventMode == NULL || terminateSimulation == NULL)
        ANSWER(report(c, ANSWER_ERROR, "a pointer to a result is NULL."));
    *enterEventMode = *terminateSimulation = fmi2False;
    ANSWER(complete_step(c));
}

fmi2Status fmi2SetTime(fmi2Component c, fmi2Real time)
{
    ENTER(EVENT | INTEGRATING);
    ANSWER(set_time(c, time));
}

fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t nx)
{
    ENTER(INTEGRATING);
    ANSWER(set_states(c, x, nx));
}

fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real derivatives[], size_t nx)
{
    ENTER(SHOWING & ~(unsigned)(STEPPING | STEP_FAILED));
    ANSWER(get_rates(c, derivatives, nx));
}

fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real eventIndicators[], size_t ni)
{
    ENTER(SHOWING & ~(unsigned)(STEPPING | STEP_FAILED));
    ANSWER(get_indicators(c, eventIndicators, ni));
}

fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t nx)
{
    ENTER(SHOWING & ~(unsigned)(STEPPING | STEP_FAILED));
    ANSWER(get_states(c, x, nx));
}

fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real x_nominal[], size_t nx)
{
    ENTER(ANY_MODE & ~(unsigned)(STEPPING | STEP_FAILED));
    ANSWER(get_nominals(c, x_nominal, nx));
}

/* ---- co-simulation ---- */

static int is_co_simulation(struct Component *c)
{
    if (c->life.interface == CO_SIMULATION)
        return 1;
    report(c, ANSWER_ERROR, "the instance is for Model Exchange; this function belongs to Co-Simulation.");
    return 0;
}

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                                       const fmi2Integer order[], const fmi2Real value[])
{
    ENTER(INSTANTIATED | INITIALIZING | STEPPING);
    ANSWER(is_co_simulation(c) ? set_slopes(c, vr, nvr, order, value) : ANSWER_ERROR);
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                                        const fmi2Integer order[], fmi2Real value[])
{
    ENTER(STEPPING | STEP_FAILED | TERMINATED | FAILED);
    ANSWER(get_output_slopes(c, vr, nvr, order, value));
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real currentCommunicationPoint, fmi2Real communicationStepSize,
                      fmi2Boolean noSetFMUStatePriorToCurrentPoint)
{
    struct StepEnd end;
    (void)noSetFMUStatePriorToCurrentPoint;
    ENTER(STEPPING);
    ANSWER(component_step(c, currentCommunicationPoint, communicationStepSize, &end));
}

/* No step runs while another function can be called: there is nothing to cancel and no pending status. */
fmi2Status fmi2CancelStep(fmi2Component c)
{
    ENTER(ANY_MODE);
    ANSWER(
        report(c, ANSWER_ERROR,
               "no step is in progress; allowed only after fmi2DoStep has answered fmi2Pending, which it never does."));
}

static fmi2Status no_status(struct Component *c, int kind)
{
    ANSWER(report(c, ANSWER_DISCARD,
                  "status kind %d is not of this type; allowed are fmi2GetRealStatus of fmi2LastSuccessfulTime (2) and "
                  "fmi2GetBooleanStatus of fmi2Terminated (3): no step is ever pending.",
                  kind));
}

#define NO_STATUS                                                                                                      \
    (void)value;                                                                                                       \
    ENTER(ANY_MODE);                                                                                                   \
    return no_status(c, (int)s)

fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind s, fmi2Status *value) { NO_STATUS; }
fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind s, fmi2Integer *value) { NO_STATUS; }
fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind s, fmi2String *value) { NO_STATUS; }

fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind s, fmi2Real *value)
{
    ENTER(ANY_MODE);
    if (s != fmi2LastSuccessfulTime || value == NULL)
        return no_status(c, (int)s);
    *value = ((struct Component *)c)->life.last_time;
    return fmi2OK;
}

fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind s, fmi2Boolean *value)
{
    ENTER(ANY_MODE);
    if (s != fmi2Terminated || value == NULL)
        return no_status(c, (int)s);
    *value = fmi2False;
    return fmi2OK;
}
