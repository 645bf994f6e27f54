/* Quantiles of a plain sample. */
#include "eventmill/sample.h"

#include <gsl/gsl_statistics_double.h>
#include <math.h>

double em_sample_quantile(const double *sorted, size_t n, double p) {
  return n ? gsl_stats_quantile_from_sorted_data(sorted, 1, n, p) : NAN;
}

double em_sample_median(double *x, size_t n) {
  return n ? gsl_stats_median(x, 1, n) : NAN;
}
