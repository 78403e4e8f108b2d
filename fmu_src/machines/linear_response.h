/* How do linear states answer over a step? */
#ifndef LINEAR_RESPONSE_H
#define LINEAR_RESPONSE_H

/* once = integral of exp(A s) ds from 0 to h, twice = integral of that integral; all n by n, by rows, n at most STATES.
 */
void linear_response(int n, const double *A, double h, double *once, double *twice);

#endif
