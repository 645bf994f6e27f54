/* Quantiles of a plain sample (Reichardt 2005, 16.3; the even and odd cases of (16-4), exchanged in
 * print, are set right). */
#ifndef EVENTMILL_SAMPLE_H
#define EVENTMILL_SAMPLE_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Quantile p of sorted values, interpolated between neighbours; NAN for n = 0. */
double em_sample_quantile(const double *sorted, size_t n, double p);

/* The median of unsorted values; reorders x. NAN for n = 0. */
double em_sample_median(double *x, size_t n);

#ifdef __cplusplus
}
#endif

#endif
