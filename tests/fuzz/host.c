/* How does the fuzz judge a call? See host.h. */
#include "host.h"

#include <math.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/time.h>

#if defined(__SANITIZE_ADDRESS__)
void __sanitizer_set_death_callback(void (*callback)(void));
#endif

enum { TICKS = 50 }; /* of the watch, per second of the processor */

struct Tally tally;
sigjmp_buf too_slow;
int verbose;

static struct {
    uint64_t seed, sequence;
    int call;
    const char *name;
} now;
static volatile sig_atomic_t within, ticks;
static int most_ticks;

static void where(FILE *to)
{
    fprintf(to, "sequence %llu %llu, call %d, %s", (unsigned long long)now.seed, (unsigned long long)now.sequence,
            now.call, now.name ? now.name : "-");
}

static void dying(void)
{
    fputs("DIED in ", stderr);
    where(stderr);
    fputc('\n', stderr);
}

/* The undefined-behaviour sanitizer has no such callback; it is told to abort. */
static void aborting(int signal)
{
    (void)signal;
    dying();
}

static void tick(int signal)
{
    (void)signal;
    if (within && most_ticks && ++ticks > most_ticks)
        siglongjmp(too_slow, 1);
}

void host_begin(double slow_after)
{
    const struct itimerval watch = {{0, 1000000 / TICKS}, {0, 1000000 / TICKS}};
    struct sigaction action;
    memset(&action, 0, sizeof action);
    action.sa_handler = tick;
    most_ticks = (int)(slow_after * TICKS);
    sigaction(SIGVTALRM, &action, NULL);
    setitimer(ITIMER_VIRTUAL, &watch, NULL);
    action.sa_handler = aborting;
    action.sa_flags = (int)SA_RESETHAND;
    sigaction(SIGABRT, &action, NULL);
#if defined(__SANITIZE_ADDRESS__)
    __sanitizer_set_death_callback(dying);
#endif
}

void sequence_begins(uint64_t seed, uint64_t sequence)
{
    now.seed = seed;
    now.sequence = sequence;
    now.call = 0;
    now.name = "";
    within = 0;
    tally.sequences += 1;
    luck_begin(seed, sequence);
}

void finding(const char *format, ...)
{
    va_list values;
    if (tally.findings++ < MOST_FINDINGS) {
        fputs("FOUND ", stdout);
        where(stdout);
        fputs(": ", stdout);
        va_start(values, format);
        vprintf(format, values);
        va_end(values);
        putchar('\n');
        fflush(stdout);
    }
}

void before(struct One *one, const char *name, unsigned legal)
{
    now.name = name;
    now.call += 1;
    one->lines = one->failed_within = 0;
    one->illegal = !(one->mode & legal);
    ticks = 0;
    within = 1;
    if (verbose)
        printf("%d %s in mode %u\n", now.call, name, one->mode);
}

int after(struct One *one, int status, enum Verdict verdict)
{
    within = 0;
    tally.calls += 1;
    const int illegal = one->illegal, due = status >= (one->logging ? DISCARD : ERROR) && !one->failed_within;
    if (verbose)
        printf("    answers %d%s\n", status, illegal ? ", illegal" : verdict == MUST_FAIL ? ", wrong" : "");
    if (status < OK || status > ERROR) {
        finding("answers %d", status);
        return ERROR;
    }
    tally.by_status[status] += 1;
    if (illegal && status != ERROR)
        finding("answers %d in mode %u, where it must be refused", status, one->mode);
    else if (!illegal && verdict == MUST_FAIL && status < DISCARD)
        finding("answers %d to arguments that must be refused", status);
    else if (!illegal && verdict == MUST_PASS && status > WARNING)
        finding("answers %d, where nothing is wrong", status);
    if (one->lines != due)
        finding("answers %d with %d log lines", status, one->lines);
    tally.refused += illegal;
    tally.passed += status <= WARNING;
    tally.failed += !illegal && status > WARNING;
    if (status >= ERROR)
        one->mode = FAILED;
    return status;
}

struct Outer aside(const struct One *one) { return (struct Outer){*one, ticks}; }

void resume(struct One *one, const struct Outer *outer)
{
    const int failed = one->mode == FAILED;
    one->mode = failed ? FAILED : outer->one.mode;
    one->lines = outer->one.lines;
    one->illegal = outer->one.illegal;
    one->failed_within = outer->one.failed_within || failed;
    ticks = outer->ticks;
    within = 1;
}

void judge(const struct One *one, int status, const char *what, const double *numbers, size_t count)
{
    if (status > WARNING)
        return;
    tally.numbers += (long long)count;
    for (size_t i = 0; i < count; ++i)
        if (!isfinite(numbers[i])) {
            finding("%s %zu is %g after %d in mode %u", what, i, numbers[i], status, one->mode);
            return;
        }
}

static void note(struct One *one, int status, const char *category, const char *text)
{
    if (verbose)
        printf("    says %d %s: %s\n", status, category, text);
    one->lines += status >= DISCARD;
    if (!category || !text || !*text)
        finding("logs an empty line");
}

void logger2(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status, fmi2String category,
             fmi2String text, ...)
{
    (void)name;
    note(environment, (int)status, category, text);
}

void logger3(fmi3InstanceEnvironment environment, fmi3Status status, fmi3String category, fmi3String text)
{
    note(environment, (int)status, category, text);
}
