/* How does an instance tell its host what went wrong? One log line per matter: what was asked, what was found, what is
 * allowed. */
#include "component.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

enum { CATEGORY_COUNT = 6, LOG_ALL = 5, TEXT_SIZE = 1024 };

/* The standard's names; the first five stand at the place of the answer that they belong to. */
static const char *const categories[CATEGORY_COUNT] = {"logEvents",      "logStatusWarning", "logStatusDiscard",
                                                       "logStatusError", "logStatusFatal",   "logAll"};

void refuse_instance(const struct Host *host, const char *format, ...)
{
    char text[TEXT_SIZE];
    va_list values;
    va_start(values, format);
    vsnprintf(text, sizeof text, format, values);
    va_end(values);
    host->say(host, ANSWER_ERROR, categories[ANSWER_ERROR], text);
}

enum Answer report(struct Component *c, enum Answer answer, const char *format, ...)
{
    char text[TEXT_SIZE];
    va_list values;
    if (answer >= ANSWER_ERROR)
        c->life.mode = FAILED;
    if (!(c->host.categories & (1u << answer | 1u << LOG_ALL)))
        return answer;
    const int used = snprintf(text, sizeof text, "%s: ", c->function);
    const size_t start = used > 0 && used < TEXT_SIZE ? (size_t)used : 0;
    va_start(values, format);
    vsnprintf(text + start, sizeof text - start, format, values);
    va_end(values);
    c->host.say(&c->host, answer, categories[answer], text);
    return answer;
}

enum Answer report_status(struct Component *c, enum Answer answer, enum Status status)
{
    char why[TEXT_SIZE / 2];
    model_explain(c->model, status, why, sizeof why);
    return report(c, answer, "at time %.17g s: %s.", present_time(c), why);
}

static const char *const mode_names[] = {"Instantiated",
                                         "Configuration Mode",
                                         "Initialization Mode",
                                         "Event Mode",
                                         "Continuous-Time Mode",
                                         "Step Mode",
                                         "Step Failed",
                                         "Terminated",
                                         "Error",
                                         "Intermediate Update Mode",
                                         "Intermediate Update Mode before the end of a step"};
enum { MODE_COUNT = sizeof mode_names / sizeof *mode_names };

void list_modes(unsigned modes, char *text, size_t size)
{
    size_t used = 0;
    text[0] = '\0';
    for (int i = 0; i < MODE_COUNT; ++i)
        if (modes >> i & 1u && used < size) {
            const int more = snprintf(text + used, size - used, "%s%s", used ? ", " : "", mode_names[i]);
            used += more > 0 ? (size_t)more : 0;
        }
}

int wrong_mode(struct Component *c, unsigned modes)
{
    const int failed = c->life.mode == FAILED;
    char now[64], allowed[256];
    list_modes(c->life.mode, now, sizeof now);
    list_modes(modes & ~(unsigned)FAILED, allowed, sizeof allowed);
    report(c, ANSWER_ERROR, "called in state %s; allowed in: %s.%s", now, allowed,
           failed ? " An earlier call failed: reset the instance or restore an FMU state first." : "");
    return 1;
}

static int category_of(const char *name)
{
    for (int i = 0; name && i < CATEGORY_COUNT; ++i)
        if (strcmp(name, categories[i]) == 0)
            return i;
    return -1;
}

enum Answer set_logging(struct Component *c, int on, size_t count, const char *const names[])
{
    uint32_t chosen = count ? 0 : (1u << CATEGORY_COUNT) - 1;
    for (size_t i = 0; i < count; ++i) {
        const int place = names ? category_of(names[i]) : -1;
        if (place < 0) {
            char allowed[160] = "";
            size_t used = 0;
            for (int k = 0; k < CATEGORY_COUNT; ++k)
                used += (size_t)snprintf(allowed + used, sizeof allowed - used, "%s%s", k ? ", " : "", categories[k]);
            return report(c, ANSWER_ERROR, "entry %zu of the categories is unknown; allowed are %s.", i, allowed);
        }
        chosen |= 1u << place;
    }
    c->host.categories = on ? c->host.categories | chosen : c->host.categories & ~chosen;
    return ANSWER_OK;
}
