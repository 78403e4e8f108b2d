/* What does the library of another system compute? Loads an FMI 2 library, steps it and shows its outputs:
 * host LIBRARY GUID STEP COUNT REFERENCE... prints the time and a number for each value reference, after each step. */
#include "fmi2FunctionTypes.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

#ifdef _WIN32
#include <windows.h>
static void *opened(const char *path) { return (void *)LoadLibraryA(path); }
static void *symbol(void *library, const char *name) { return (void *)GetProcAddress((HMODULE)library, name); }
#else
#include <dlfcn.h>
static void *opened(const char *path) { return dlopen(path, RTLD_NOW | RTLD_LOCAL); }
static void *symbol(void *library, const char *name) { return dlsym(library, name); }
#endif

enum { MOST = 16 };

static void told(fmi2ComponentEnvironment environment, fmi2String instance, fmi2Status status, fmi2String category,
                 fmi2String message, ...)
{
    va_list rest;
    va_start(rest, message);
    fprintf(stderr, "%s %d %s: ", instance, (int)status, category);
    vfprintf(stderr, message, rest);
    fputc('\n', stderr);
    va_end(rest);
    (void)environment;
}

static void *function(void *library, const char *name)
{
    void *const address = symbol(library, name);
    if (!address) {
        fprintf(stderr, "%s is not in the library\n", name);
        exit(2);
    }
    return address;
}

static void must(fmi2Status status, const char *what)
{
    if (status > fmi2Warning) {
        fprintf(stderr, "%s: status %d\n", what, (int)status);
        exit(3);
    }
}

int main(int argc, char **argv)
{
    void *const library = argc > 5 && argc - 5 <= MOST ? opened(argv[1]) : NULL;
    if (!library) {
        fprintf(stderr, "%s cannot be loaded, or too few or many arguments were given\n",
                argc > 1 ? argv[1] : "nothing");
        return 1;
    }
    const fmi2CallbackFunctions callbacks = {told, calloc, free, NULL, NULL};
    const double step = atof(argv[3]);
    const long count = atol(argv[4]);
    const size_t shown = (size_t)(argc - 5);
    fmi2ValueReference reference[MOST];
    fmi2Real value[MOST];
    for (size_t i = 0; i < shown; ++i)
        reference[i] = (fmi2ValueReference)strtoul(argv[5 + i], NULL, 10);
    fmi2Component c = ((fmi2InstantiateTYPE *)function(library, "fmi2Instantiate"))(
        "platform", fmi2CoSimulation, argv[2], "", &callbacks, fmi2False, fmi2False);
    if (!c)
        return 4;
    must(((fmi2SetupExperimentTYPE *)function(library, "fmi2SetupExperiment"))(c, fmi2False, 0, 0, fmi2False, 0),
         "set up");
    must(((fmi2EnterInitializationModeTYPE *)function(library, "fmi2EnterInitializationMode"))(c), "enter");
    must(((fmi2ExitInitializationModeTYPE *)function(library, "fmi2ExitInitializationMode"))(c), "exit");
    fmi2DoStepTYPE *const do_step = (fmi2DoStepTYPE *)function(library, "fmi2DoStep");
    fmi2GetRealTYPE *const get_real = (fmi2GetRealTYPE *)function(library, "fmi2GetReal");
    for (long n = 0; n < count; ++n) {
        must(do_step(c, (double)n * step, step, fmi2True), "step");
        must(get_real(c, reference, shown, value), "get");
        printf("%.17g", (double)(n + 1) * step);
        for (size_t i = 0; i < shown; ++i)
            printf(" %.17g", value[i]);
        putchar('\n');
    }
    ((fmi2FreeInstanceTYPE *)function(library, "fmi2FreeInstance"))(c);
    return 0;
}
