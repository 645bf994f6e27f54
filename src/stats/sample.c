/* Key figures of a plain sample. */
#include "eventmill/sample.h"

#include <gsl/gsl_sort.h>
#include <gsl/gsl_statistics_double.h>
#include <math.h>

double em_sample_quantile(const double *sorted, size_t n, double p) {
  return n ? gsl_stats_quantile_from_sorted_data(sorted, 1, n, p) : NAN;
}

double em_sample_median(double *x, size_t n) {
  return n ? gsl_stats_median(x, 1, n) : NAN;
}

struct em_sample em_sample_describe(double *x, size_t n) {
  struct em_sample s = {n, NAN, NAN, NAN, NAN, NAN, NAN, NAN};
  if (n == 0) return s;
  gsl_sort(x, 1, n);
  s.mean = gsl_stats_mean(x, 1, n);
  if (n > 1) s.sigma = gsl_stats_sd_m(x, 1, n, s.mean);
  s.low = x[0];
  s.q25 = em_sample_quantile(x, n, 0.25);
  s.median = em_sample_quantile(x, n, 0.5);
  s.q75 = em_sample_quantile(x, n, 0.75);
  s.high = x[n - 1];
  return s;
}
