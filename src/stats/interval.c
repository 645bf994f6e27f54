/* Confidence intervals: Student's t, blocking of correlated series, jackknife over blocks. */
#include "eventmill/interval.h"

#include <gsl/gsl_cdf.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { LEVELS = 60 };

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

/* Σ (x_i − m)(x_{i+lag} − m) / n */
static double covariance(const double *x, size_t n, double mean, size_t lag) {
  double sum = 0.0;
  for (size_t i = 0; i + lag < n; i++)
    sum += (x[i] - mean) * (x[i + lag] - mean);
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
  const double error = sqrt(covariance(x, n, mean, 0) / freedom);
  return (struct em_interval){mean, em_interval_student(level, freedom) * error, error, freedom,
                              1.0};
}

/* One stage of blocking: its number of averages, their variance, what is left of correlation
 * between neighbours (not below 0; its bias −1/n taken out), and Jonsson's statistic, which is χ²
 * with one degree of freedom when the averages are independent. */
struct stage {
  size_t n;
  double variance, correlation, statistic;
};

static struct stage look(const double *x, size_t n) {
  const double size = (double)n, mean = mean_of(x, n), s2 = covariance(x, n, mean, 0);
  const double lag = covariance(x, n, mean, 1);
  const double excess = (size - 1.0) * s2 / (size * size) + lag;
  if (!(s2 > 0.0)) return (struct stage){n, s2, 0.0, 0.0};
  const double correlation = fmin(fmax(lag / s2 + 1.0 / size, 0.0), 0.9);
  return (struct stage){n, s2, correlation, size * excess * excess / (s2 * s2)};
}

/* The first stage after which all stages together look independent (99 %). */
static size_t choose(const struct stage *stage, size_t stages) {
  double sum = 0.0;
  size_t chosen = stages - 1;
  for (size_t k = stages; k-- > 0;) {
    sum += stage[k].statistic;
    if (sum < gsl_cdf_chisq_Pinv(0.99, (double)(stages - k))) chosen = k;
  }
  return chosen;
}

struct em_interval em_interval_series(const double *x, size_t n, double level) {
  if (n < 4) return em_interval_mean(x, n, level);
  double *y = malloc(n * sizeof *y);
  if (!y) return unknown(NAN);
  memcpy(y, x, n * sizeof *y);
  struct stage stage[LEVELS] = {look(y, n)};
  size_t stages = 1;
  for (size_t m = n / 2; m >= 4 && stages < LEVELS; m /= 2) {
    for (size_t i = 0; i < m; i++)
      y[i] = 0.5 * (y[2 * i] + y[2 * i + 1]);
    stage[stages++] = look(y, m);
  }
  free(y);
  const struct stage *best = &stage[choose(stage, stages)];
  /* The test may let a short series pass that still remembers: the factor of an AR(1) series. */
  const double memory = (1.0 + best->correlation) / (1.0 - best->correlation);
  const double variance = memory * best->variance / ((double)best->n - 1.0);
  const double least = fmin(3.0, (double)best->n - 1.0);
  const double freedom = fmax(least, (double)best->n / memory - 1.0);
  const double alone = stage[0].variance / ((double)n - 1.0);
  struct em_interval out = {mean_of(x, n), NAN, sqrt(variance), freedom, 1.0};
  if (alone > 0.0) out.inefficiency = fmax(1.0, variance / alone);
  out.half = em_interval_student(level, freedom) * out.error;
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
  out->value = theta;
  em_histogram_free(sum);
  free(pseudo);
  return EM_OK;
}

double em_interval_difference(const struct em_interval *a, const struct em_interval *b) {
  const double va = a->error * a->error, vb = b->error * b->error, v = va + vb;
  if (!isfinite(v) || !(a->freedom >= 1.0) || !(b->freedom >= 1.0)) return NAN;
  if (v == 0.0) return a->value == b->value ? 1.0 : 0.0;
  const double freedom = v * v / (va * va / a->freedom + vb * vb / b->freedom);
  return 2.0 * gsl_cdf_tdist_Q(fabs(a->value - b->value) / sqrt(v), freedom);
}
