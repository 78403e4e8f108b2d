/* Which laws and effects are there? One line each; everything else is asked of their own files. */
#ifndef REGISTRY_H
#define REGISTRY_H

#define FRICTION_LAWS(LINE)                                                                                            \
    LINE(coulomb)                                                                                                      \
    LINE(lugre)                                                                                                        \
    LINE(dahl)                                                                                                         \
    LINE(karnopp)                                                                                                      \
    LINE(bristle)                                                                                                      \
    LINE(reset_integrator)                                                                                             \
    LINE(amontons)

/* In the order of their stages, so that no file order matters but this one. */
#define EFFECTS(LINE)                                                                                                  \
    LINE(holder_compliance)                                                                                            \
    LINE(amplitude_loss)                                                                                               \
    LINE(ellipse_phase_error)                                                                                          \
    LINE(run_out)                                                                                                      \
    LINE(regenerative)                                                                                                 \
    LINE(backlash)                                                                                                     \
    LINE(input_delay)                                                                                                  \
    LINE(proxy_lag)                                                                                                    \
    LINE(size_effect)                                                                                                  \
    LINE(flow_stress_softening)                                                                                        \
    LINE(edge_force)                                                                                                   \
    LINE(minimum_chip_thickness)                                                                                       \
    LINE(flank_wear)                                                                                                   \
    LINE(process_damping)                                                                                              \
    LINE(thermal_softening)                                                                                            \
    LINE(thermal_damping)                                                                                              \
    LINE(thermal_viscosity)                                                                                            \
    LINE(direction_asymmetry)                                                                                          \
    LINE(load_dependence)                                                                                              \
    LINE(viscous_friction)                                                                                             \
    LINE(stribeck)                                                                                                     \
    LINE(dwell_strengthening)                                                                                          \
    LINE(rate_and_state)                                                                                               \
    LINE(position_dependence)                                                                                          \
    LINE(sticking_limit)                                                                                               \
    LINE(friction_wear)                                                                                                \
    LINE(elasto_plastic)                                                                                               \
    LINE(maxwell_slip)                                                                                                 \
    LINE(kienzle_force)                                                                                                \
    LINE(sensor_delay)                                                                                                 \
    LINE(cross_talk)                                                                                                   \
    LINE(dynamometer_resonance)                                                                                        \
    LINE(sensor_lowpass)                                                                                               \
    LINE(sensor_gain)                                                                                                  \
    LINE(sensor_offset)                                                                                                \
    LINE(sensor_drift)                                                                                                 \
    LINE(line_disturbance)

#define COUNT_LINE(name) +1
enum { LAW_COUNT = 0 FRICTION_LAWS(COUNT_LINE), EFFECT_COUNT = 0 EFFECTS(COUNT_LINE) };

/* In tables: a parameter that may change during a run. */
#define TUNED .causality = PARAMETER, .variability = TUNABLE

extern const char *const law_names[LAW_COUNT + 1];
extern const struct Variable base_variables[];

/* Index of the first value of the place-th law's own table. */
int law_values(int place);

#endif
