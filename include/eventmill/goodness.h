/* Does a sample obey a law? χ² and Kolmogorov–Smirnov. */
#ifndef EVENTMILL_GOODNESS_H
#define EVENTMILL_GOODNESS_H

#include <stdbool.h>
#include <stddef.h>

#include "eventmill/distribution.h"
#include "eventmill/error.h"

#ifdef __cplusplus
extern "C" {
#endif

struct em_goodness {
  double statistic; /* χ², or the largest distance D */
  double freedom;   /* of χ²; the number of values for Kolmogorov–Smirnov */
  double p;         /* probability of a statistic this large when the law holds; NAN: cannot tell */
};

/* χ² of observed counts against expected ones; neighbouring bins are merged until each is expected
 * to hold at least 5. constraints: what was taken from the data (1 for the total, 1 more for each
 * parameter). */
struct em_goodness em_goodness_chi2(const double *observed, const double *expected, size_t bins,
                                    int constraints);

/* χ² of n values u that should be uniform in [0, 1] (u = cdf(x)), in equal bins: 0 chooses
 * 2 n^(2/5) (Mann & Wald 1942). Errors: EM_MEMORY. */
enum em_status em_goodness_chi2_uniform(struct em_goodness *out, const double *u, size_t n,
                                        size_t bins, int constraints);

/* Kolmogorov–Smirnov of n values in [0, 1] against the uniform law; sorts u. p by the asymptotic
 * law with Stephens' (1970) correction for finite n. */
struct em_goodness em_goodness_ks(double *u, size_t n);

/* The same for u = cdf(x) of a law whose parameter is tied to the data so that Σ x² = n k a² (its
 * energy is given: k = em_distribution_freedom). D is then smaller than for free data; its law is
 * sampled (2000 samples, fixed seed). centred: the mean of the values was subtracted as well (the
 * normal law). Errors: EM_INPUT (a law without
 * freedom), EM_MEMORY. */
enum em_status em_goodness_ks_tied(struct em_goodness *out, enum em_distribution law, bool centred,
                                   double *u, size_t n);

/* Probability that the limit law of √n D exceeds x. */
double em_goodness_kolmogorov(double x);

#ifdef __cplusplus
}
#endif

#endif
