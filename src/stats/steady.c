/* When is a series stationary? MSER and Geweke's test. */
#include "eventmill/steady.h"

#include <gsl/gsl_cdf.h>
#include <math.h>
#include <stdlib.h>

#include "eventmill/interval.h"

/* A steady state cannot be told from slow waves with fewer independent values than this. */
static const double LEAST_INDEPENDENT = 10.0;

static size_t batch_length(size_t n) {
  return n >= 100 ? 5 : n >= 40 ? 2 : 1;
}

/* The cut d that minimises Σ_{i≥d} (x_i − mean)² / (n−d)², over all that leave at least half of the
 * values: a calm stretch at the end would win otherwise. */
static size_t least_error(const double *x, size_t n) {
  double best = INFINITY, mean = 0.0, m2 = 0.0;
  size_t cut = 0;
  for (size_t i = n; i-- > 0;) { /* Welford's sums from the end */
    const double count = (double)(n - i), step = x[i] - mean;
    mean += step / count;
    m2 += step * (x[i] - mean);
    if (i > n / 2) continue;
    const double value = m2 / (count * count);
    if (value <= best) {
      best = value;
      cut = i;
    }
  }
  return cut;
}

/* The last cut that least_error can make, among the values themselves. */
static size_t last_cut(size_t n) {
  const size_t length = batch_length(n), batches = n / length;
  return n - batches * length + batches / 2 * length;
}

size_t em_steady_mser(const double *x, size_t n) {
  const size_t length = batch_length(n), batches = n / length;
  if (batches == 0) return 0;
  double *mean = malloc(batches * sizeof *mean);
  if (!mean) return n;
  const size_t offset = n - batches * length; /* the remainder is left out at the start */
  for (size_t b = 0; b < batches; b++) {
    mean[b] = 0.0;
    for (size_t i = 0; i < length; i++)
      mean[b] += x[offset + b * length + i] / (double)length;
  }
  const size_t cut = least_error(mean, batches);
  free(mean);
  return cut == 0 ? 0 : offset + cut * length;
}

double em_steady_geweke(const double *x, size_t n) {
  const size_t first = n / 10 < 4 ? n / 4 : n / 10, last = n / 2;
  if (first < 4 || last < 4) return NAN;
  const struct em_interval a = em_interval_series(x, first, 0.95);
  const struct em_interval b = em_interval_series(x + (n - last), last, 0.95);
  /* The error per value is the same in both parts when the series is stationary; the longer part
   * tells it better. */
  const double per_value = b.error * b.error * (double)last;
  const double variance = per_value / (double)first + b.error * b.error;
  return variance > 0.0 ? (a.value - b.value) / sqrt(variance) : a.value == b.value ? 0.0 : NAN;
}

struct em_steady em_steady_find(const double *x, size_t n) {
  struct em_steady out = {.start = em_steady_mser(x, n), .geweke = NAN, .p = NAN};
  if (out.start < last_cut(n)) {
    const size_t rest = n - out.start;
    const struct em_interval mean = em_interval_series(x + out.start, rest, 0.95);
    const bool enough = (double)rest >= LEAST_INDEPENDENT * mean.inefficiency;
    out.found = enough ? EM_STEADY_YES : EM_STEADY_BRIEF;
  }
  if (out.start < n) out.geweke = em_steady_geweke(x + out.start, n - out.start);
  if (isfinite(out.geweke)) out.p = 2.0 * gsl_cdf_ugaussian_Q(fabs(out.geweke));
  return out;
}
