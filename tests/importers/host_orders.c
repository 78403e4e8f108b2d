/* What does the FMU make of odd but legal orders? Drives an FMI 3 library from C and shows its values at the end:
 * host LIBRARY TOKEN ORDER END FILE REFERENCE...
 *
 * whole: one step. steps: steps of 0.1 us. early: up to each event, which is handled. leave: the same up to the second
 * event; in event mode its state goes to FILE. resume: goes on from FILE, in event mode, in a process that has done
 * nothing before. refused: a step of size 0, which the standard does not allow, and a reset. The log is off.
 */
#include "fmi3FunctionTypes.h"

#include <dlfcn.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST = 16 };
static void *library;
static fmi3Instance instance;
static double now, end;

#define CALL(name) ((fmi3##name##TYPE *)function("fmi3" #name))
static void *function(const char *name)
{
    void *const there = dlsym(library, name);
    if (!there) {
        fprintf(stderr, "%s is not in the library\n", name);
        exit(2);
    }
    return there;
}

#define MUST(call) must(call, #call)
static void must(fmi3Status status, const char *what)
{
    if (status <= fmi3Warning)
        return;
    fprintf(stderr, "%s: status %d\n", what, (int)status);
    exit(3);
}

static void told(fmi3InstanceEnvironment environment, fmi3Status status, fmi3String category, fmi3String message)
{
    (void)environment;
    printf("log %d %s %s\n", (int)status, category, message);
}

static void handle_event(void)
{
    fmi3Boolean again = fmi3True, terminate, nominals, states, defined;
    fmi3Float64 next;
    while (again)
        MUST(CALL(UpdateDiscreteStates)(instance, &again, &terminate, &nominals, &states, &defined, &next));
    MUST(CALL(EnterStepMode)(instance));
}

/* One step; whether it has ended at an event. */
static int step_to(double target)
{
    fmi3Boolean event, terminate, early;
    MUST(CALL(DoStep)(instance, now, target - now, fmi3True, &event, &terminate, &early, &now));
    return event;
}

static void start(int with_events)
{
    MUST(CALL(EnterInitializationMode)(instance, fmi3False, 0, 0, fmi3False, 0));
    MUST(CALL(ExitInitializationMode)(instance));
    now = 0;
    if (with_events)
        handle_event();
}

/* Up to the end, or to the n-th event, which is not handled. */
static void follow(int n)
{
    while (now < end - 1e-13)
        if (step_to(end)) {
            MUST(CALL(EnterEventMode)(instance));
            if (--n == 0)
                return;
            handle_event();
        }
}

static void leave(const char *path)
{
    fmi3FMUState state = NULL;
    size_t size;
    MUST(CALL(GetFMUState)(instance, &state));
    MUST(CALL(SerializedFMUStateSize)(instance, state, &size));
    fmi3Byte *const bytes = malloc(size);
    MUST(CALL(SerializeFMUState)(instance, state, bytes, size));
    FILE *const file = fopen(path, "wb");
    if (!file || fwrite(&now, sizeof now, 1, file) != 1 || fwrite(bytes, 1, size, file) != size || fclose(file))
        exit(5);
    free(bytes);
    MUST(CALL(FreeFMUState)(instance, &state));
}

static void resume(const char *path)
{
    static fmi3Byte bytes[1 << 20];
    fmi3FMUState state = NULL;
    FILE *const file = fopen(path, "rb");
    if (!file || fread(&now, sizeof now, 1, file) != 1)
        exit(5);
    const size_t size = fread(bytes, 1, sizeof bytes, file);
    fclose(file);
    MUST(CALL(DeserializeFMUState)(instance, bytes, size, &state));
    MUST(CALL(SetFMUState)(instance, state));
    MUST(CALL(FreeFMUState)(instance, &state));
    handle_event();
}

int main(int argc, char **argv)
{
    library = argc > 6 && argc - 6 <= MOST ? dlopen(argv[1], RTLD_NOW | RTLD_LOCAL) : NULL;
    if (!library)
        return 1;
    const char *const order = argv[3], *const file = argv[5];
    const int with_events = !strcmp(order, "early") || !strcmp(order, "leave") || !strcmp(order, "resume");
    end = atof(argv[4]);
    instance = CALL(InstantiateCoSimulation)("orders", argv[2], "", fmi3False, fmi3False, with_events, with_events,
                                             NULL, 0, NULL, told, NULL);
    if (!instance)
        return 4;
    if (!strcmp(order, "resume"))
        resume(file);
    else
        start(with_events);
    if (!strcmp(order, "refused")) {
        fmi3Boolean flag[3];
        printf("status %d\n", (int)CALL(DoStep)(instance, 0, 0, fmi3True, &flag[0], &flag[1], &flag[2], &now));
        MUST(CALL(Reset)(instance));
        start(0);
    }
    if (!strcmp(order, "steps"))
        for (long n = 1, count = lround(end / 1e-7); n <= count; ++n)
            step_to((double)n * 1e-7);
    else if (with_events)
        follow(strcmp(order, "leave") ? -1 : 2);
    else
        step_to(end);
    if (!strcmp(order, "leave"))
        leave(file);
    for (int i = 6; i < argc; ++i) {
        const fmi3ValueReference reference = (fmi3ValueReference)strtoul(argv[i], NULL, 10);
        fmi3Float64 value;
        MUST(CALL(GetFloat64)(instance, &reference, 1, &value, 1));
        printf("%.17g\n", value);
    }
    CALL(FreeInstance)(instance);
    return 0;
}
