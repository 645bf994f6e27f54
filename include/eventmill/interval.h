/* Figures with confidence intervals, for independent values and for series that are correlated in
 * time. Sources: Reichardt 2005 (16-1 … 16-3); Burg 1975 (autoregression), its order by Hurvich &
 * Tsai 1989, its spectrum at frequency 0 by Berk 1974; jackknife over blocks of time (Quenouille,
 * Tukey). */
#ifndef EVENTMILL_INTERVAL_H
#define EVENTMILL_INTERVAL_H

#include <stdbool.h>
#include <stddef.h>

#include "eventmill/error.h"
#include "eventmill/histogram.h"

#ifdef __cplusplus
extern "C" {
#endif

/* value ± half at the level asked for. */
struct em_interval {
  double value;
  double half;         /* half width of the confidence interval; NAN when it cannot be told */
  double error;        /* standard error of `value`; NAN when it cannot be told */
  double freedom;      /* degrees of freedom of `error` */
  double inefficiency; /* how many successive values count as one independent value, ≥ 1 */
};

/* Student's t for a two-sided interval: t(P, ν). NAN for freedom < 1. */
double em_interval_student(double level, double freedom);

/* Mean of n independent values: half = t(P, n−1) σ/√n (16-3). */
struct em_interval em_interval_mean(const double *x, size_t n, double level);

/* Mean of n successive values of a stationary series: its error follows from the autoregressive
 * series that fits best, so that neither memory nor waves mislead it. Waves of which there are less
 * than four, and memory of more than a tenth of the series, cannot be told well. half = NAN for n <
 * 2. */
struct em_interval em_interval_series(const double *x, size_t n, double level);

/* A figure of the sum of blocks of successive counts, e.g. the median over the whole time. The
 * pseudo-values of the jackknife, B θ − (B−1) θ without block b, are a series to which
 * em_interval_series applies. figure(h, weight, self): h is a sum of blocks, weight the sum of
 * their weights (e.g. durations in s). half = NAN where the pseudo-values tell nothing: one does
 * not exist, because all values lie in one block, or none differs from the others, because nothing
 * was seen. Errors: EM_MEMORY. */
enum em_status em_interval_figure(struct em_interval *out, size_t blocks,
                                  struct em_histogram *const *block, const double *weight,
                                  double (*figure)(const struct em_histogram *h, double weight,
                                                   void *self),
                                  void *self, double level);

/* The quantile p of the sum of blocks of successive counts, likewise; neighbouring blocks are
 * joined where they have few values. Errors: EM_MEMORY. */
enum em_status em_interval_quantile(struct em_interval *out, size_t blocks,
                                    struct em_histogram *const *block, double p, double level);

/* Probability that two figures differ by as much as these do when they are equal in truth
 * (Welch's test, two-sided); NAN when an error is unknown. */
double em_interval_difference(const struct em_interval *a, const struct em_interval *b);

#ifdef __cplusplus
}
#endif

#endif
