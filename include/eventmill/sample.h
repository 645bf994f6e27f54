/* Key figures of a plain sample: mean, standard deviation, quantiles (Reichardt 2005, 16.3; the
 * even and odd cases of (16-4), exchanged in print, are set right). */
#ifndef EVENTMILL_SAMPLE_H
#define EVENTMILL_SAMPLE_H

#include <stddef.h>

struct em_sample {
  size_t n;
  double mean, sigma; /* sigma with n − 1 */
  double low, q25, median, q75, high;
};

/* Sorts x in place and describes it; all NAN for n = 0, sigma NAN for n = 1. */
struct em_sample em_sample_describe(double *x, size_t n);

/* Quantile p of sorted values, interpolated between neighbours; NAN for n = 0. */
double em_sample_quantile(const double *sorted, size_t n, double p);

/* The median of unsorted values; reorders x. NAN for n = 0. */
double em_sample_median(double *x, size_t n);

#endif
