/* Nonlinear least squares (Levenberg–Marquardt) of a curve y = f(x; p) to a table. */
#ifndef EVENTMILL_FIT_H
#define EVENTMILL_FIT_H

#include <stdbool.h>
#include <stddef.h>

#include "eventmill/error.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { EM_FIT_PARAMETERS = 8 };

struct em_fit_model {
  int parameters;                                               /* 1 … EM_FIT_PARAMETERS */
  double (*value)(double x, const double *p, const void *self); /* NAN: p is not allowed */
  const void *self;
};

struct em_fit {
  int parameters;
  size_t n;
  double p[EM_FIT_PARAMETERS];
  double error[EM_FIT_PARAMETERS]; /* standard errors, from the scatter of the data; NAN where
                                      these do not determine the parameter */
  double residual;                 /* Σ (y − f)² */
  double sigma;                    /* √(residual/(n − parameters)) */
  double aic; /* n ln(residual/n) + 2 (parameters + 1), Akaike 1974; of y about 1: residual/n is
                 not taken below the square of DBL_EPSILON */
  int iterations;
  bool converged;
};

/* Fits from the start values p0. Errors: EM_INPUT (n ≤ parameters, or values that are not finite),
 * EM_MEMORY, EM_NUMERIC (no step can be made, or no error told). */
enum em_status em_fit_curve(struct em_fit *fit, const struct em_fit_model *model, size_t n,
                            const double *x, const double *y, const double *p0,
                            struct em_error *err);

#ifdef __cplusplus
}
#endif

#endif
