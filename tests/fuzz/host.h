/* What does the fuzz ask of every call, whatever it calls? A host of FMI 2 and FMI 3 that judges each answer.
 *
 * After OK every number is finite; what must be refused is refused with fmi2Error; an answer from Discard on comes with
 * one log line and no other does; no call takes longer than SLOW seconds of the processor. What breaks a rule is a
 * finding, told with the sequence that led to it. The model and both shells are linked in; tables are read by model.h,
 * the rest is reached by functions of the standard only.
 */
#ifndef HOST_H
#define HOST_H

#include "component.h"

#include "fmi2Functions.h"
#include "fmi3Functions.h"

#include <setjmp.h>
#include <stdint.h>

enum { MOST_FINDINGS = 40 }; /* that are told; with them a run ends */
enum { CAPACITY = 512, STATES = 64 }; /* room for any model; main sees that it is enough */
enum { OK = ANSWER_OK, WARNING = ANSWER_WARNING, DISCARD = ANSWER_DISCARD, ERROR = ANSWER_ERROR };

/* What the host knows the answer must be. MAY_FAIL: the numbers, or the model, decide. */
enum Verdict { MUST_PASS, MAY_FAIL, MUST_FAIL };

/* One instance and what the standard says of it, kept here on the host's side. */
struct One {
    void *c;
    int version, interface, event_mode, early_return, watched, logging, updates;
    unsigned mode;
    int set_up, pending,
        ramped;         /* set up; an event waits to be handled; inputs have had derivatives since the last reset */
    int lines, illegal; /* of the present call: log lines from Discard on; it is made in the wrong mode */
    int failed_within;  /* a call from within this one has failed, and has had its line */
    double start, stop;
    double given[CAPACITY]; /* what was set last, NAN: nothing since the last reset or restore */
};

/* ---- luck.c: random numbers, the same for the same seed ---- */

void luck_begin(uint64_t seed, uint64_t sequence);
uint64_t luck(void);
int below(int n);         /* 0 .. n-1 */
int chance(double share); /* 1 in so many of 1 */
double between(double low, double high);
double spread(double low, double high);    /* even in the logarithm, low > 0 */
double strange(void);                      /* a number at an end of what a double can be */
double value_of(const struct Variable *v); /* within the bounds, mostly */

/* ---- host.c: judging ---- */

extern struct Tally {
    long long sequences, calls, refused, passed, failed, numbers, steps, steps_done, forged, forged_taken, slow,
        findings, by_status[5];
} tally;
extern sigjmp_buf too_slow; /* where a call that takes too long is left to */
extern int verbose;

void host_begin(double slow_after); /* [s]: a call that takes longer is left; 0: never */
void sequence_begins(uint64_t seed, uint64_t sequence);
void finding(const char *format, ...) __attribute__((format(printf, 1, 2)));
/* Between `before` and `after` stands one call of the standard: name, modes in which it is legal. */
void before(struct One *one, const char *name, unsigned legal);
int after(struct One *one, int status, enum Verdict verdict);
#define CALL(one, name, legal, verdict, expression) (before(one, name, legal), after(one, (int)(expression), verdict))
/* The same where the host is called from within a call, and makes calls itself: what the outer call has been through so
 * far. */
struct Outer {
    struct One one;
    int ticks;
};
struct Outer aside(const struct One *one);
void resume(struct One *one, const struct Outer *outer);
/* Numbers that an answer of OK or warning has brought. */
void judge(const struct One *one, int status, const char *what, const double *numbers, size_t count);

/* The host's callbacks. */
void logger2(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status, fmi2String category,
             fmi2String text, ...);
void logger3(fmi3InstanceEnvironment environment, fmi3Status status, fmi3String category, fmi3String text);

#endif
