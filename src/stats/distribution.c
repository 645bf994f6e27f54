/* Densities and cumulative probabilities of the laws of an ideal gas. */
#include "eventmill/distribution.h"

#include <gsl/gsl_cdf.h>
#include <gsl/gsl_math.h>
#include <math.h>
#include <stddef.h>

const char *em_distribution_name(enum em_distribution law) {
#define NAME(code, text) text,
  static const char *const name[] = {EM_DISTRIBUTION_LIST(NAME)};
#undef NAME
  return (unsigned)law < EM_DISTRIBUTION_COUNT ? name[law] : NULL;
}

int em_distribution_freedom(enum em_distribution law) {
  static const int freedom[EM_DISTRIBUTION_COUNT] = {
      [EM_DISTRIBUTION_NORMAL] = 1,
      [EM_DISTRIBUTION_RAYLEIGH] = 2,
      [EM_DISTRIBUTION_MAXWELL] = 3,
      [EM_DISTRIBUTION_MAXWELL4] = 4,
  };
  return freedom[law];
}

double em_distribution_pdf(enum em_distribution law, double a, double x) {
  const double u = x / a, bell = exp(-0.5 * u * u);
  if (law == EM_DISTRIBUTION_NORMAL) return bell / (a * sqrt(2.0 * M_PI));
  if (x < 0.0) return 0.0;
  switch (law) {
  case EM_DISTRIBUTION_MAXWELL:
    return sqrt(2.0 / M_PI) * u * u * bell / a;
  case EM_DISTRIBUTION_MAXWELL4:
    return 0.5 * u * u * u * bell / a;
  case EM_DISTRIBUTION_RAYLEIGH:
    return u * bell / a;
  case EM_DISTRIBUTION_LINEAR:
    return u <= 1.0 ? 2.0 * u / a : 0.0;
  case EM_DISTRIBUTION_UNIFORM:
    return u <= 1.0 ? 1.0 / a : 0.0;
  case EM_DISTRIBUTION_NORMAL:
  case EM_DISTRIBUTION_COUNT:
    break;
  }
  return NAN;
}

double em_distribution_cdf(enum em_distribution law, double a, double x) {
  const double u = x / a, s = 0.5 * u * u;
  if (law == EM_DISTRIBUTION_NORMAL) return gsl_cdf_ugaussian_P(u);
  if (x <= 0.0) return 0.0;
  switch (law) {
  case EM_DISTRIBUTION_MAXWELL:
    return erf(u * M_SQRT1_2) - u * sqrt(2.0 / M_PI) * exp(-s);
  case EM_DISTRIBUTION_MAXWELL4:
    return -expm1(-s) - s * exp(-s);
  case EM_DISTRIBUTION_RAYLEIGH:
    return -expm1(-s);
  case EM_DISTRIBUTION_LINEAR:
    return fmin(u * u, 1.0);
  case EM_DISTRIBUTION_UNIFORM:
    return fmin(u, 1.0);
  case EM_DISTRIBUTION_NORMAL:
  case EM_DISTRIBUTION_COUNT:
    break;
  }
  return NAN;
}
