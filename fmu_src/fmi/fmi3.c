/* How does a host of FMI 3.0 reach an instance? Every function of the standard, in the order of its header, over
 * component.h.
 *
 * Long because the standard wants every function to be there, those for types and clocks that this FMU does not have,
 * too.
 */
#include "component.h"

#include <stdlib.h>

#include "fmi3Functions.h"

#define ENTER(modes)                                                                                                   \
    do {                                                                                                               \
        if (refuses(instance, __func__, modes))                                                                        \
            return fmi3Error;                                                                                          \
    } while (0)
#define ANSWER(answer) return (fmi3Status)(answer)

enum {
    SETTING = INSTANTIATED | INITIALIZING | RUNNING | ASKING,
    READING = SHOWING | INSTANTIATED | INTERMEDIATE | ASKING,
    SOLVING = INITIALIZING | EVENT | INTEGRATING | TERMINATED | FAILED
};

static const struct Access floats = {"Float64", FORM_DOUBLE, 1u << REAL};
static const struct Access integers = {"Int32", FORM_INT32, 1u << INTEGER};
static const struct Access enumerations = {"Enumeration", FORM_INT64, 1u << CHOICE};
static const struct Access booleans = {"Boolean", FORM_BOOL, 1u << BOOLEAN};

static void say(const struct Host *host, enum Answer answer, const char *category, const char *text)
{
    fmi3LogMessageCallback logger = (fmi3LogMessageCallback)host->logger;
    if (logger)
        logger(host->environment, (fmi3Status)answer, category, text);
}

/* The internal step is finished, values may be read, and before the end of the step inputs may be set. */
static int show(const struct Host *host, double time, int asks, double *until)
{
    fmi3IntermediateUpdateCallback update = (fmi3IntermediateUpdateCallback)host->intermediate_update;
    fmi3Boolean wants_return = fmi3False;
    update(host->environment, time, asks != 0, fmi3True, fmi3True, host->early_return != 0, &wants_return, until);
    return wants_return;
}

/* ---- common functions ---- */

const char *fmi3GetVersion(void) { return fmi3Version; }

fmi3Status fmi3SetDebugLogging(fmi3Instance instance, fmi3Boolean loggingOn, size_t nCategories,
                               const fmi3String categories[])
{
    ENTER(ANY_MODE);
    ANSWER(set_logging(instance, loggingOn, nCategories, categories));
}

static struct Host host_of(fmi3String name, fmi3Boolean logging, fmi3InstanceEnvironment environment,
                           fmi3LogMessageCallback logger)
{
    return (struct Host){.say = say,
                         .logger = (void (*)(void))logger,
                         .environment = environment,
                         .allocate = calloc,
                         .release = free,
                         .name = name ? name : "",
                         .categories = logging ? STATUS_CATEGORIES : ERROR_CATEGORIES,
                         .warned = ANSWER_WARNING,
                         .partial_step = ANSWER_ERROR,
                         .modes = ANY_MODE & ~(unsigned)STEP_FAILED};
}

fmi3Instance fmi3InstantiateModelExchange(fmi3String instanceName, fmi3String instantiationToken,
                                          fmi3String resourcePath, fmi3Boolean visible, fmi3Boolean loggingOn,
                                          fmi3InstanceEnvironment instanceEnvironment,
                                          fmi3LogMessageCallback logMessage)
{
    const struct Host host = host_of(instanceName, loggingOn, instanceEnvironment, logMessage);
    (void)resourcePath;
    (void)visible;
    return component_new(__func__, &host, MODEL_EXCHANGE, instanceName, instantiationToken);
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String instanceName, fmi3String instantiationToken,
                                         fmi3String resourcePath, fmi3Boolean visible, fmi3Boolean loggingOn,
                                         fmi3Boolean eventModeUsed, fmi3Boolean earlyReturnAllowed,
                                         const fmi3ValueReference requiredIntermediateVariables[],
                                         size_t nRequiredIntermediateVariables,
                                         fmi3InstanceEnvironment instanceEnvironment, fmi3LogMessageCallback logMessage,
                                         fmi3IntermediateUpdateCallback intermediateUpdate)
{
    struct Host host = host_of(instanceName, loggingOn, instanceEnvironment, logMessage);
    (void)resourcePath;
    (void)visible;
    (void)requiredIntermediateVariables; /* every variable can be read then */
    host.event_mode = eventModeUsed;
    host.early_return = earlyReturnAllowed;
    if (nRequiredIntermediateVariables && intermediateUpdate) {
        host.show = show;
        host.intermediate_update = (void (*)(void))intermediateUpdate;
    }
    return component_new(__func__, &host, CO_SIMULATION, instanceName, instantiationToken);
}

fmi3Instance fmi3InstantiateScheduledExecution(fmi3String instanceName, fmi3String instantiationToken,
                                               fmi3String resourcePath, fmi3Boolean visible, fmi3Boolean loggingOn,
                                               fmi3InstanceEnvironment instanceEnvironment,
                                               fmi3LogMessageCallback logMessage, fmi3ClockUpdateCallback clockUpdate,
                                               fmi3LockPreemptionCallback lockPreemption,
                                               fmi3UnlockPreemptionCallback unlockPreemption)
{
    const struct Host host = host_of(instanceName, loggingOn, instanceEnvironment, logMessage);
    (void)instantiationToken;
    (void)resourcePath;
    (void)visible;
    (void)clockUpdate;
    (void)lockPreemption;
    (void)unlockPreemption;
    refuse_instance(&host,
                    "%s: this FMU has no Scheduled Execution; instantiate it for Co-Simulation or Model Exchange.",
                    __func__);
    return NULL;
}

void fmi3FreeInstance(fmi3Instance instance) { component_free(instance); }

fmi3Status fmi3EnterInitializationMode(fmi3Instance instance, fmi3Boolean toleranceDefined, fmi3Float64 tolerance,
                                       fmi3Float64 startTime, fmi3Boolean stopTimeDefined, fmi3Float64 stopTime)
{
    ENTER(INSTANTIATED);
    const enum Answer answer =
        component_set_up(instance, toleranceDefined, tolerance, startTime, stopTimeDefined, stopTime);
    ANSWER(answer == ANSWER_OK ? component_enter(instance, INITIALIZING) : answer);
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance instance)
{
    ENTER(INITIALIZING);
    ANSWER(component_start(instance));
}

fmi3Status fmi3EnterEventMode(fmi3Instance instance)
{
    ENTER(INTEGRATING | STEPPING);
    struct Component *c = instance;
    if (c->life.interface == CO_SIMULATION && !c->host.event_mode)
        ANSWER(report(c, ANSWER_ERROR,
                      "the instance was made with eventModeUsed = false; make it with true to use Event Mode."));
    ANSWER(component_enter(c, EVENT));
}

fmi3Status fmi3Terminate(fmi3Instance instance)
{
    ENTER(RUNNING | STEP_FAILED);
    ANSWER(component_enter(instance, TERMINATED));
}

fmi3Status fmi3Reset(fmi3Instance instance)
{
    ENTER(ANY_MODE);
    ANSWER(component_reset(instance));
}

/* ---- values ---- */

static int sizes_agree(struct Component *c, size_t references, size_t values)
{
    if (references == values)
        return 1;
    report(c, ANSWER_ERROR,
           "%zu value references come with %zu values; all variables are scalars, so both counts are the same.",
           references, values);
    return 0;
}

#define ACCESS(Type, access)                                                                                           \
    fmi3Status fmi3Get##Type(fmi3Instance instance, const fmi3ValueReference valueReferences[],                        \
                             size_t nValueReferences, fmi3##Type values[], size_t nValues)                             \
    {                                                                                                                  \
        ENTER(READING);                                                                                                \
        ANSWER(sizes_agree(instance, nValueReferences, nValues)                                                        \
                   ? get_values(instance, &(access), valueReferences, nValueReferences, values)                        \
                   : ANSWER_ERROR);                                                                                    \
    }                                                                                                                  \
    fmi3Status fmi3Set##Type(fmi3Instance instance, const fmi3ValueReference valueReferences[],                        \
                             size_t nValueReferences, const fmi3##Type values[], size_t nValues)                       \
    {                                                                                                                  \
        ENTER(SETTING);                                                                                                \
        ANSWER(sizes_agree(instance, nValueReferences, nValues)                                                        \
                   ? set_values(instance, &(access), valueReferences, nValueReferences, values)                        \
                   : ANSWER_ERROR);                                                                                    \
    }

#define ABSENT(Type)                                                                                                   \
    fmi3Status fmi3Get##Type(fmi3Instance instance, const fmi3ValueReference valueReferences[],                        \
                             size_t nValueReferences, fmi3##Type values[], size_t nValues)                             \
    {                                                                                                                  \
        (void)valueReferences, (void)values, (void)nValues;                                                            \
        ENTER(READING);                                                                                                \
        ANSWER(no_variables(instance, #Type, nValueReferences));                                                       \
    }                                                                                                                  \
    fmi3Status fmi3Set##Type(fmi3Instance instance, const fmi3ValueReference valueReferences[],                        \
                             size_t nValueReferences, const fmi3##Type values[], size_t nValues)                       \
    {                                                                                                                  \
        (void)valueReferences, (void)values, (void)nValues;                                                            \
        ENTER(SETTING);                                                                                                \
        ANSWER(no_variables(instance, #Type, nValueReferences));                                                       \
    }

ABSENT(Float32)
ACCESS(Float64, floats)
ABSENT(Int8)
ABSENT(UInt8)
ABSENT(Int16)
ABSENT(UInt16)
ACCESS(Int32, integers)
ABSENT(UInt32)
ACCESS(Int64, enumerations)
ABSENT(UInt64)
ACCESS(Boolean, booleans)
ABSENT(String)

fmi3Status fmi3GetBinary(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                         size_t valueSizes[], fmi3Binary values[], size_t nValues)
{
    (void)valueReferences, (void)valueSizes, (void)values, (void)nValues;
    ENTER(READING);
    ANSWER(no_variables(instance, "Binary", nValueReferences));
}

fmi3Status fmi3SetBinary(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                         const size_t valueSizes[], const fmi3Binary values[], size_t nValues)
{
    (void)valueReferences, (void)valueSizes, (void)values, (void)nValues;
    ENTER(SETTING);
    ANSWER(no_variables(instance, "Binary", nValueReferences));
}

fmi3Status fmi3GetClock(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                        fmi3Clock values[])
{
    (void)valueReferences, (void)values;
    ENTER(READING);
    ANSWER(no_variables(instance, "Clock", nValueReferences));
}

fmi3Status fmi3SetClock(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                        const fmi3Clock values[])
{
    (void)valueReferences, (void)values;
    ENTER(SETTING);
    ANSWER(no_variables(instance, "Clock", nValueReferences));
}

/* providesPerElementDependencies = false: the variables are scalars and their dependencies stand in
 * modelDescription.xml. */
static fmi3Status no_dependencies(struct Component *c)
{
    ANSWER(report(c, ANSWER_ERROR,
                  "dependencies per element are not provided; those of each variable stand in modelDescription.xml."));
}

fmi3Status fmi3GetNumberOfVariableDependencies(fmi3Instance instance, fmi3ValueReference valueReference,
                                               size_t *nDependencies)
{
    (void)valueReference, (void)nDependencies;
    ENTER(ANY_MODE);
    return no_dependencies(instance);
}

fmi3Status fmi3GetVariableDependencies(fmi3Instance instance, fmi3ValueReference dependent,
                                       size_t elementIndicesOfDependent[], fmi3ValueReference independents[],
                                       size_t elementIndicesOfIndependents[], fmi3DependencyKind dependencyKinds[],
                                       size_t nDependencies)
{
    (void)dependent, (void)elementIndicesOfDependent, (void)independents, (void)elementIndicesOfIndependents;
    (void)dependencyKinds, (void)nDependencies;
    ENTER(ANY_MODE);
    return no_dependencies(instance);
}

/* ---- FMU state ---- */

fmi3Status fmi3GetFMUState(fmi3Instance instance, fmi3FMUState *FMUState)
{
    ENTER(ANY_MODE);
    ANSWER(state_get(instance, FMUState));
}

fmi3Status fmi3SetFMUState(fmi3Instance instance, fmi3FMUState FMUState)
{
    ENTER(ANY_MODE);
    ANSWER(state_set(instance, FMUState));
}

fmi3Status fmi3FreeFMUState(fmi3Instance instance, fmi3FMUState *FMUState)
{
    ENTER(ANY_MODE);
    ANSWER(state_free(instance, FMUState));
}

fmi3Status fmi3SerializedFMUStateSize(fmi3Instance instance, fmi3FMUState FMUState, size_t *size)
{
    ENTER(ANY_MODE);
    ANSWER(state_size(instance, FMUState, size));
}

fmi3Status fmi3SerializeFMUState(fmi3Instance instance, fmi3FMUState FMUState, fmi3Byte serializedState[], size_t size)
{
    ENTER(ANY_MODE);
    ANSWER(state_serialize(instance, FMUState, serializedState, size));
}

fmi3Status fmi3DeserializeFMUState(fmi3Instance instance, const fmi3Byte serializedState[], size_t size,
                                   fmi3FMUState *FMUState)
{
    ENTER(ANY_MODE);
    ANSWER(state_deserialize(instance, serializedState, size, FMUState));
}

/* ---- derivatives ---- */

static fmi3Status derivative(struct Component *c, int adjoint, const fmi3ValueReference unknowns[], size_t nUnknowns,
                             const fmi3ValueReference knowns[], size_t nKnowns, const fmi3Float64 seed[], size_t nSeed,
                             fmi3Float64 sensitivity[], size_t nSensitivity)
{
    const size_t seeds = adjoint ? nUnknowns : nKnowns, results = adjoint ? nKnowns : nUnknowns;
    if (!sizes_agree(c, seeds, nSeed) || !sizes_agree(c, results, nSensitivity))
        return fmi3Error;
    ANSWER(get_derivative(c, adjoint, unknowns, nUnknowns, knowns, nKnowns, seed, sensitivity));
}

fmi3Status fmi3GetDirectionalDerivative(fmi3Instance instance, const fmi3ValueReference unknowns[], size_t nUnknowns,
                                        const fmi3ValueReference knowns[], size_t nKnowns, const fmi3Float64 seed[],
                                        size_t nSeed, fmi3Float64 sensitivity[], size_t nSensitivity)
{
    ENTER(SHOWING);
    return derivative(instance, 0, unknowns, nUnknowns, knowns, nKnowns, seed, nSeed, sensitivity, nSensitivity);
}

fmi3Status fmi3GetAdjointDerivative(fmi3Instance instance, const fmi3ValueReference unknowns[], size_t nUnknowns,
                                    const fmi3ValueReference knowns[], size_t nKnowns, const fmi3Float64 seed[],
                                    size_t nSeed, fmi3Float64 sensitivity[], size_t nSensitivity)
{
    ENTER(SHOWING);
    return derivative(instance, 1, unknowns, nUnknowns, knowns, nKnowns, seed, nSeed, sensitivity, nSensitivity);
}

/* ---- configuration: there are no structural parameters, so there is nothing to do in it ---- */

fmi3Status fmi3EnterConfigurationMode(fmi3Instance instance)
{
    ENTER(INSTANTIATED);
    ANSWER(component_enter(instance, CONFIGURING));
}

fmi3Status fmi3ExitConfigurationMode(fmi3Instance instance)
{
    ENTER(CONFIGURING);
    ANSWER(component_enter(instance, INSTANTIATED));
}

/* ---- clocks: there are none ---- */

#define CLOCKED(Name, ...)                                                                                             \
    fmi3Status fmi3##Name(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,  \
                          __VA_ARGS__)

CLOCKED(GetIntervalDecimal, fmi3Float64 intervals[], fmi3IntervalQualifier qualifiers[])
{
    (void)valueReferences, (void)intervals, (void)qualifiers;
    ENTER(ANY_MODE);
    ANSWER(no_variables(instance, "Clock", nValueReferences));
}

CLOCKED(GetIntervalFraction, fmi3UInt64 counters[], fmi3UInt64 resolutions[], fmi3IntervalQualifier qualifiers[])
{
    (void)valueReferences, (void)counters, (void)resolutions, (void)qualifiers;
    ENTER(ANY_MODE);
    ANSWER(no_variables(instance, "Clock", nValueReferences));
}

CLOCKED(GetShiftDecimal, fmi3Float64 shifts[])
{
    (void)valueReferences, (void)shifts;
    ENTER(ANY_MODE);
    ANSWER(no_variables(instance, "Clock", nValueReferences));
}

CLOCKED(GetShiftFraction, fmi3UInt64 counters[], fmi3UInt64 resolutions[])
{
    (void)valueReferences, (void)counters, (void)resolutions;
    ENTER(ANY_MODE);
    ANSWER(no_variables(instance, "Clock", nValueReferences));
}

CLOCKED(SetIntervalDecimal, const fmi3Float64 intervals[])
{
    (void)valueReferences, (void)intervals;
    ENTER(ANY_MODE);
    ANSWER(no_variables(instance, "Clock", nValueReferences));
}

CLOCKED(SetIntervalFraction, const fmi3UInt64 counters[], const fmi3UInt64 resolutions[])
{
    (void)valueReferences, (void)counters, (void)resolutions;
    ENTER(ANY_MODE);
    ANSWER(no_variables(instance, "Clock", nValueReferences));
}

CLOCKED(SetShiftDecimal, const fmi3Float64 shifts[])
{
    (void)valueReferences, (void)shifts;
    ENTER(ANY_MODE);
    ANSWER(no_variables(instance, "Clock", nValueReferences));
}

CLOCKED(SetShiftFraction, const fmi3UInt64 counters[], const fmi3UInt64 resolutions[])
{
    (void)valueReferences, (void)counters, (void)resolutions;
    ENTER(ANY_MODE);
    ANSWER(no_variables(instance, "Clock", nValueReferences));
}

/* ---- events ---- */

/* providesEvaluateDiscreteStates = false: the standard has such an FMU ignore the call. */
fmi3Status fmi3EvaluateDiscreteStates(fmi3Instance instance)
{
    ENTER(INITIALIZING | EVENT);
    return fmi3OK;
}

fmi3Status fmi3UpdateDiscreteStates(fmi3Instance instance, fmi3Boolean *discreteStatesNeedUpdate,
                                    fmi3Boolean *terminateSimulation, fmi3Boolean *nominalsOfContinuousStatesChanged,
                                    fmi3Boolean *valuesOfContinuousStatesChanged, fmi3Boolean *nextEventTimeDefined,
                                    fmi3Float64 *nextEventTime)
{
    struct News news;
    ENTER(EVENT);
    if (!discreteStatesNeedUpdate || !terminateSimulation || !nominalsOfContinuousStatesChanged ||
        !valuesOfContinuousStatesChanged || !nextEventTimeDefined || !nextEventTime)
        ANSWER(report(instance, ANSWER_ERROR, "a pointer to a result is NULL."));
    const enum Answer answer = component_event(instance, &news);
    if (answer <= ANSWER_WARNING) {
        *discreteStatesNeedUpdate = *terminateSimulation = fmi3False;
        *nominalsOfContinuousStatesChanged = news.nominals_changed != 0;
        *valuesOfContinuousStatesChanged = news.states_changed != 0;
        *nextEventTimeDefined = news.next_event_defined != 0;
        *nextEventTime = news.next_event;
    }
    ANSWER(answer);
}

/* ---- model exchange ---- */

fmi3Status fmi3EnterContinuousTimeMode(fmi3Instance instance)
{
    ENTER(EVENT);
    struct Component *c = instance;
    if (c->life.interface != MODEL_EXCHANGE)
        ANSWER(report(c, ANSWER_ERROR, "the instance is for Co-Simulation; call fmi3EnterStepMode."));
    ANSWER(component_enter(c, INTEGRATING));
}

fmi3Status fmi3CompletedIntegratorStep(fmi3Instance instance, fmi3Boolean noSetFMUStatePriorToCurrentPoint,
                                       fmi3Boolean *enterEventMode, fmi3Boolean *terminateSimulation)
{
    (void)noSetFMUStatePriorToCurrentPoint;
    ENTER(INTEGRATING);
    if (enterEventMode == NULL || terminateSimulation == NULL)
        ANSWER(report(instance, ANSWER_ERROR, "a pointer to a result is NULL."));
    *enterEventMode = *terminateSimulation = fmi3False;
    ANSWER(complete_step(instance));
}

fmi3Status fmi3SetTime(fmi3Instance instance, fmi3Float64 time)
{
    ENTER(INTEGRATING);
    ANSWER(set_time(instance, time));
}

fmi3Status fmi3SetContinuousStates(fmi3Instance instance, const fmi3Float64 continuousStates[],
                                   size_t nContinuousStates)
{
    ENTER(INTEGRATING);
    ANSWER(set_states(instance, continuousStates, nContinuousStates));
}

static int is_model_exchange(struct Component *c)
{
    if (c->life.interface == MODEL_EXCHANGE)
        return 1;
    report(c, ANSWER_ERROR, "the instance is for Co-Simulation; this function belongs to Model Exchange.");
    return 0;
}

fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance instance, fmi3Float64 derivatives[], size_t nContinuousStates)
{
    ENTER(SOLVING);
    ANSWER(is_model_exchange(instance) ? get_rates(instance, derivatives, nContinuousStates) : ANSWER_ERROR);
}

fmi3Status fmi3GetEventIndicators(fmi3Instance instance, fmi3Float64 eventIndicators[], size_t nEventIndicators)
{
    ENTER(SOLVING);
    ANSWER(is_model_exchange(instance) ? get_indicators(instance, eventIndicators, nEventIndicators) : ANSWER_ERROR);
}

fmi3Status fmi3GetContinuousStates(fmi3Instance instance, fmi3Float64 continuousStates[], size_t nContinuousStates)
{
    ENTER(SOLVING);
    ANSWER(is_model_exchange(instance) ? get_states(instance, continuousStates, nContinuousStates) : ANSWER_ERROR);
}

fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance instance, fmi3Float64 nominals[], size_t nContinuousStates)
{
    ENTER(SOLVING | INSTANTIATED);
    ANSWER(is_model_exchange(instance) ? get_nominals(instance, nominals, nContinuousStates) : ANSWER_ERROR);
}

static fmi3Status count_of(struct Component *c, size_t count, size_t *result)
{
    if (!is_model_exchange(c))
        return fmi3Error;
    if (result == NULL)
        ANSWER(report(c, ANSWER_ERROR, "the pointer to the count is NULL."));
    *result = count;
    return fmi3OK;
}

fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance instance, size_t *nEventIndicators)
{
    ENTER(ANY_MODE);
    return count_of(instance, (size_t)((struct Component *)instance)->indicator_count, nEventIndicators);
}

fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance instance, size_t *nContinuousStates)
{
    ENTER(ANY_MODE);
    return count_of(instance, (size_t)((struct Component *)instance)->state_count, nContinuousStates);
}

/* ---- co-simulation ---- */

fmi3Status fmi3EnterStepMode(fmi3Instance instance)
{
    ENTER(EVENT);
    struct Component *c = instance;
    if (c->life.interface != CO_SIMULATION)
        ANSWER(report(c, ANSWER_ERROR, "the instance is for Model Exchange; call fmi3EnterContinuousTimeMode."));
    if (c->life.event_pending)
        ANSWER(report(c, ANSWER_ERROR, "the event is not handled yet; call fmi3UpdateDiscreteStates first."));
    ANSWER(component_enter(c, STEPPING));
}

fmi3Status fmi3GetOutputDerivatives(fmi3Instance instance, const fmi3ValueReference valueReferences[],
                                    size_t nValueReferences, const fmi3Int32 orders[], fmi3Float64 values[],
                                    size_t nValues)
{
    ENTER(STEPPING | STEP_FAILED | TERMINATED | FAILED | INTERMEDIATE | ASKING);
    ANSWER(sizes_agree(instance, nValueReferences, nValues)
               ? get_output_slopes(instance, valueReferences, nValueReferences, orders, values)
               : ANSWER_ERROR);
}

fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 currentCommunicationPoint, fmi3Float64 communicationStepSize,
                      fmi3Boolean noSetFMUStatePriorToCurrentPoint, fmi3Boolean *eventHandlingNeeded,
                      fmi3Boolean *terminateSimulation, fmi3Boolean *earlyReturn, fmi3Float64 *lastSuccessfulTime)
{
    struct StepEnd end;
    (void)noSetFMUStatePriorToCurrentPoint;
    ENTER(STEPPING);
    if (!eventHandlingNeeded || !terminateSimulation || !earlyReturn || !lastSuccessfulTime)
        ANSWER(report(instance, ANSWER_ERROR, "a pointer to a result is NULL."));
    const enum Answer answer = component_step(instance, currentCommunicationPoint, communicationStepSize, &end);
    *eventHandlingNeeded = end.event != 0;
    *terminateSimulation = fmi3False;
    *earlyReturn = end.early != 0;
    *lastSuccessfulTime = end.last_time;
    ANSWER(answer);
}

/* ---- scheduled execution: not provided ---- */

fmi3Status fmi3ActivateModelPartition(fmi3Instance instance, fmi3ValueReference clockReference,
                                      fmi3Float64 activationTime)
{
    (void)clockReference, (void)activationTime;
    ENTER(ANY_MODE);
    ANSWER(report(instance, ANSWER_ERROR, "this FMU has no Scheduled Execution and so no model partitions."));
}
