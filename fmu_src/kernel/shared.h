/* What do all models do alike, the contact and its partners? They check a value against its row, say a status in words,
 * and hash tables and bytes.
 */
#ifndef SHARED_H
#define SHARED_H

#include "tables.h"

#include <stddef.h>
#include <stdint.h>

/* How far outside its bounds an input may be given, in units of its nominal value: so far a solver, a step of
 * extrapolation or rounding misses a bound at which it means to be. It then lies on the bound. */
#define BOUND_SLACK 1e-6
#define AS_TEXT_(number) #number
#define AS_TEXT(number) AS_TEXT_(number)
#define AT_BOUND_TEXT                                                                                                  \
    "an input was given a hair outside its bounds, by no more than " AS_TEXT(                                          \
        BOUND_SLACK) " of its nominal value, and "                                                                     \
                     "is held on them"
double bound_slack(const struct Variable *variable); /* in the variable's unit; 0 where it is no input */
/* May `variable` (NULL: there is none) have this value, of an input but for the slack? */
enum Status check_value(const struct Variable *variable, double value);
/* What a model holds where `value` is given and passes the check. */
double within_bounds(const struct Variable *variable, double value);
const char *status_text(enum Status status);

enum { DERIVATIVES_AT_ONCE = 64 }; /* outputs that are derived in one call */

/* FNV-1a, 64 bits. A hash begins as HASH_BEGIN and goes on from what it was. */
#define HASH_BEGIN 14695981039346656037u
uint64_t hash_bytes(uint64_t hash, const void *bytes, size_t size);
uint64_t hash_text(uint64_t hash, const char *text);
/* One row. `of_contact`: the columns that are read of the contact's rows alone (neutral, required_with, reference)
 * count too.
 */
uint64_t hash_row(uint64_t hash, const struct Variable *variable, int derivative_of, int of_contact);
/* "{8-4-4-4-12}": two rounds of `hash_tables` over all that makes a model what it is. */
void write_token(uint64_t (*hash_tables)(uint64_t hash), char token[39]);

#endif
