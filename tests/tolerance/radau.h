/* How is dy/dt = f(t, y) integrated to ten digits? By the five-stage Radau IIA method, of order 9. Hairer and Wanner
 * 1996, sections IV.5 and IV.8: stiffly accurate, so that a fast bristle costs no small steps. Knows nothing of
 * friction. */
#ifndef RADAU_H
#define RADAU_H

enum { STAGES_OF_RADAU = 5, MOST_STATES = 32, MOST_INTEGRALS = 16 };

/* Rates f of the states y and integrands g of the plain integrals at t; nonzero: there are none. */
typedef int Rates(void *what, double t, const double *y, double *f, double *g);

struct Radau {
    int states, integrals;
    double tolerance;                 /* of a step, relative to scale */
    double scale[MOST_STATES];        /* size of each state; grows with what is seen */
    double integral_scale[MOST_INTEGRALS]; /* size of each integrand */
    Rates *rates;
    void *what;
    double c[STAGES_OF_RADAU], a[STAGES_OF_RADAU][STAGES_OF_RADAU];
    double other[STAGES_OF_RADAU], first; /* a second quadrature, of the start too, less the first */
};

/* One step: the states at the nodes c h, of which the last is the end, and what the integrals gain. */
struct Step {
    double node[STAGES_OF_RADAU][MOST_STATES];
    double gain[MOST_INTEGRALS];
    double error, of_states; /* over the tolerance: of states and integrals, and of states alone */
};

void radau_begin(struct Radau *r);
/* From y with rates f and integrands g at t. Returns 0 where Newton's method has found no end. */
int radau_step(struct Radau *r, double t, double h, const double *y, const double *f, const double *g,
               struct Step *step);

/* A step too short for anything but its start to matter: along the rates there, of which those that fall steeply with a
 * state do so within it. 0: there are no rates. */
int radau_straight(struct Radau *r, double t, double h, const double *y, const double *f, const double *g,
                   struct Step *step);

#endif
