/* Which laws and effects are there? One line each; everything else is asked of their own files. */
#ifndef REGISTRY_H
#define REGISTRY_H

#define FRICTION_LAWS(LINE) \
    LINE(coulomb) \
    LINE(lugre) \
    LINE(dahl) \
    LINE(karnopp) \
    LINE(bristle) \
    LINE(reset_integrator)

#define EFFECTS(LINE) \
    LINE(thermal_softening) \
    LINE(thermal_damping)

#define COUNT_LINE(name) +1
enum { LAW_COUNT = 0 FRICTION_LAWS(COUNT_LINE), EFFECT_COUNT = 0 EFFECTS(COUNT_LINE) };

extern const char *const law_names[LAW_COUNT + 1];
extern const struct Variable base_variables[];

/* Index of the first value of the place-th law's own table. */
int law_values(int place);

#endif
