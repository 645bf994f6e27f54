/* Confidence intervals: Student's t, autoregression for correlated series, jackknife over blocks.
 */
#include "eventmill/interval.h"

#include <gsl/gsl_cdf.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* More successive values are averaged before they are looked at: memory of many values then takes
 * no more orders than that of few. */
enum { MOST_AVERAGES = 256 };
/* A series that remembers more cannot be told from a drift. */
static const double MOST_REFLECTION = 0.98;
/* What cannot be predicted is rounding below this share of the variance, and scatter below this
 * share of the value. */
static const double ROUNDING = 1e-14;

double em_interval_student(double level, double freedom) {
  if (!(freedom >= 1.0) || !(level > 0.0) || !(level < 1.0)) return NAN;
  return gsl_cdf_tdist_Pinv(0.5 + 0.5 * level, freedom);
}

static double mean_of(const double *x, size_t n) {
  double sum = 0.0;
  for (size_t i = 0; i < n; i++)
    sum += x[i];
  return sum / (double)n;
}

/* Σ (x_i − m)² / n */
static double variance_of(const double *x, size_t n, double mean) {
  double sum = 0.0;
  for (size_t i = 0; i < n; i++)
    sum += (x[i] - mean) * (x[i] - mean);
  return sum / (double)n;
}

static struct em_interval unknown(double value) {
  return (struct em_interval){value, NAN, NAN, 0.0, 1.0};
}

struct em_interval em_interval_mean(const double *x, size_t n, double level) {
  if (n == 0) return unknown(NAN);
  const double mean = mean_of(x, n);
  if (n < 2) return unknown(mean);
  const double freedom = (double)n - 1.0;
  const double error = sqrt(variance_of(x, n, mean) / freedom);
  return (struct em_interval){mean, em_interval_student(level, freedom) * error, error, freedom,
                              1.0};
}

/* Burg's fit of an autoregressive series: forward and backward errors of prediction, n of them. */
struct lattice {
  size_t n, order;
  double *ahead, *back;
  double noise;  /* variance of what cannot be predicted */
  double answer; /* Π (1 − k_j) over the reflections k_j: of the filter at frequency 0 */
  double spread; /* 1ᵀ R⁻¹ 1 with the covariances R of `order` successive values */
};

/* One order more. Knowing the mean from the series itself takes 1/n from the first reflection. */
static void extend(struct lattice *l) {
  double both = 0.0, all = 0.0;
  for (size_t i = l->order + 1; i < l->n; i++) {
    both += 2.0 * l->ahead[i] * l->back[i - 1];
    all += l->ahead[i] * l->ahead[i] + l->back[i - 1] * l->back[i - 1];
  }
  double k = all > 0.0 ? both / all : 0.0;
  if (l->order == 0) k += 1.0 / (double)l->n;
  k = fmin(k, MOST_REFLECTION);
  for (size_t i = l->n; i-- > l->order + 1;) {
    const double ahead = l->ahead[i];
    l->ahead[i] -= k * l->back[i - 1];
    l->back[i] = l->back[i - 1] - k * ahead;
  }
  l->spread += l->answer * l->answer / l->noise;
  l->answer *= 1.0 - k;
  l->noise *= 1.0 - k * k;
  l->order++;
}

/* Variance of the mean of n averages, and its degrees of freedom: n times it is the spectrum at
 * frequency 0 of the autoregressive series (Berk 1974) whose order has the least AICc. `ahead`
 * holds the averages less their mean, `back` the same; both are used up. */
static double variance_of_mean(double *ahead, double *back, size_t n, double *freedom) {
  const double size = (double)n, c0 = variance_of(ahead, n, 0.0);
  *freedom = size - 1.0;
  if (!(c0 > 0.0)) return c0;
  struct lattice l = {n, 0, ahead, back, c0, 1.0, 0.0};
  const size_t most = (size_t)fmin(size / 4.0, 10.0 * log10(size) + size / 20.0);
  double least = INFINITY, variance = NAN;
  while (l.order < most && (l.order == 0 || l.noise > ROUNDING * c0)) {
    extend(&l);
    const double p = (double)l.order, k = p + 2.0;
    const double aicc =
        size * log(l.noise) + 2.0 * k + 2.0 * k * (k + 1.0) / fmax(size - k - 1.0, 1.0);
    if (!(aicc < least)) continue;
    least = aicc;
    const double square = l.answer * l.answer;
    variance = l.noise / square / (size - p - 1.0);
    /* relative variance of `variance`, from those of noise and answer */
    const double relative = 2.0 / size + 4.0 * l.noise * l.spread / (size * square);
    *freedom = fmax(fmin(3.0, size - 1.0), 2.0 / relative - 1.0);
  }
  return variance;
}

/* Averages of `each` successive values, less their mean; what is left over comes first. */
static void average(double *y, const double *x, size_t n, size_t count, size_t each) {
  const size_t first = n - count * each;
  for (size_t k = 0; k < count; k++)
    y[k] = mean_of(x + first + k * each, each);
  const double mean = mean_of(y, count);
  for (size_t k = 0; k < count; k++)
    y[k] -= mean;
}

struct em_interval em_interval_series(const double *x, size_t n, double level) {
  struct em_interval out = em_interval_mean(x, n, level);
  if (n < 4) return out;
  const size_t each = (n + MOST_AVERAGES - 1) / MOST_AVERAGES, count = n / each;
  double *y = malloc(2 * count * sizeof *y);
  if (!y) return unknown(out.value);
  average(y, x, n, count, each);
  memcpy(y + count, y, count * sizeof *y);
  const double alone = out.error, variance = variance_of_mean(y, y + count, count, &out.freedom);
  free(y);
  out.error = sqrt(variance);
  if (alone > 0.0) out.inefficiency = fmax(1.0, variance / (alone * alone));
  out.half = em_interval_student(level, out.freedom) * out.error;
  return out;
}

/* Pseudo-values θ_b = B θ − (B−1) θ without b; `sum` holds all blocks and does so again after. */
static void pseudo_values(double *pseudo, struct em_histogram *sum, size_t blocks,
                          struct em_histogram *const *block, const double *weight, double all,
                          double theta,
                          double (*figure)(const struct em_histogram *h, double weight, void *self),
                          void *self) {
  const double count = (double)blocks;
  for (size_t b = 0; b < blocks; b++) {
    em_histogram_merge(sum, block[b], -1.0);
    pseudo[b] = count * theta - (count - 1.0) * figure(sum, all - weight[b], self);
    em_histogram_merge(sum, block[b], 1.0);
  }
}

enum em_status em_interval_figure(struct em_interval *out, size_t blocks,
                                  struct em_histogram *const *block, const double *weight,
                                  double (*figure)(const struct em_histogram *h, double weight,
                                                   void *self),
                                  void *self, double level) {
  *out = unknown(NAN);
  if (blocks == 0) return EM_OK;
  struct em_histogram *sum = em_histogram_new_like(block[0]);
  double *pseudo = malloc(blocks * sizeof *pseudo);
  if (!sum || !pseudo) {
    em_histogram_free(sum);
    free(pseudo);
    return EM_MEMORY;
  }
  double all = 0.0;
  for (size_t b = 0; b < blocks; b++) {
    em_histogram_merge(sum, block[b], 1.0);
    all += weight[b];
  }
  const double theta = figure(sum, all, self);
  if (blocks > 1) {
    pseudo_values(pseudo, sum, blocks, block, weight, all, theta, figure, self);
    *out = em_interval_series(pseudo, blocks, level);
  }
  if (!(out->error > ROUNDING * fabs(theta))) *out = unknown(theta);
  out->value = theta;
  em_histogram_free(sum);
  free(pseudo);
  return EM_OK;
}

/* ---------------------------------------------------------------- quantiles */

/* The jackknife of a quantile is wrong where a block has few values: neighbours are joined until
 * they have so many on average, or so few blocks are left (docs/statistics.md). */
enum { LEAST_VALUES = 30, LEAST_BLOCKS = 16 };

static size_t neighbours(size_t blocks, struct em_histogram *const *block) {
  double values = 0.0;
  for (size_t b = 0; b < blocks; b++)
    values += em_histogram_weight(block[b]);
  size_t each = 1;
  while (blocks / (2 * each) >= LEAST_BLOCKS &&
         values * (double)each < LEAST_VALUES * (double)blocks)
    each *= 2;
  return each;
}

static double quantile(const struct em_histogram *h, double weight, void *self) {
  (void)weight;
  return em_histogram_quantile(h, *(const double *)self);
}

enum em_status em_interval_quantile(struct em_interval *out, size_t blocks,
                                    struct em_histogram *const *block, double p, double level) {
  *out = unknown(NAN);
  if (blocks == 0) return EM_OK;
  const size_t each = neighbours(blocks, block), count = (blocks + each - 1) / each;
  struct em_histogram **joined = calloc(count, sizeof *joined);
  double *weight = calloc(count, sizeof *weight);
  bool good = joined && weight;
  for (size_t k = 0; good && k < count; k++)
    good = (joined[k] = em_histogram_new_like(block[0])) != NULL;
  for (size_t b = 0; good && b < blocks; b++)
    em_histogram_merge(joined[b / each], block[b], 1.0);
  enum em_status status = EM_MEMORY;
  if (good) status = em_interval_figure(out, count, joined, weight, quantile, &p, level);
  out->inefficiency *= (double)each;
  for (size_t k = 0; joined && k < count; k++)
    em_histogram_free(joined[k]);
  free(joined);
  free(weight);
  return status;
}

double em_interval_difference(const struct em_interval *a, const struct em_interval *b) {
  const double va = a->error * a->error, vb = b->error * b->error, v = va + vb;
  if (!isfinite(v) || !(a->freedom >= 1.0) || !(b->freedom >= 1.0)) return NAN;
  if (v == 0.0) return a->value == b->value ? 1.0 : 0.0;
  const double freedom = v * v / (va * va / a->freedom + vb * vb / b->freedom);
  return 2.0 * gsl_cdf_tdist_Q(fabs(a->value - b->value) / sqrt(v), freedom);
}
