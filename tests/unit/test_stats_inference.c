/* Intervals, steady state, goodness of fit and curve fits on data whose truth is known. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>
#include <gsl/gsl_cdf.h>
#include <gsl/gsl_fit.h>
#include <gsl/gsl_randist.h>
#include <gsl/gsl_rng.h>

#include "eventmill/fit.h"
#include "eventmill/goodness.h"
#include "eventmill/interval.h"
#include "eventmill/steady.h"

#define assert_near(a, b, tolerance) assert_true(fabs((a) - (b)) <= (tolerance))

static gsl_rng *rng;

static int make_rng(void **state) {
  (void)state;
  rng = gsl_rng_alloc(gsl_rng_mt19937);
  return 0;
}

static int free_rng(void **state) {
  (void)state;
  gsl_rng_free(rng);
  return 0;
}

/* AR(1): x_i = φ x_{i−1} + ε; variance 1/(1−φ²), error of the mean √((1+φ)/(1−φ)) σ/√n. */
static void autoregressive(double *x, size_t n, double phi) {
  double y = gsl_ran_ugaussian(rng) / sqrt(1.0 - phi * phi);
  for (size_t i = 0; i < n; i++) {
    x[i] = y;
    y = phi * y + gsl_ran_ugaussian(rng);
  }
}

static void series_know_the_error_of_ar1(void **state) {
  (void)state;
  enum { N = 4000, RUNS = 1000 };
  static double x[N];
  const double phis[] = {0.0, 0.5, 0.9};
  for (int k = 0; k < 3; k++) {
    const double phi = phis[k], truth = 1.0 / (1.0 - phi) / sqrt(N);
    double mean = 0.0, inside = 0.0, inefficiency = 0.0;
    gsl_rng_set(rng, 7);
    for (int r = 0; r < RUNS; r++) {
      autoregressive(x, N, phi);
      const struct em_interval i = em_interval_series(x, N, 0.95);
      mean += i.error / RUNS;
      inefficiency += i.inefficiency / RUNS;
      inside += fabs(i.value) <= i.half;
    }
    assert_near(mean / truth, 1.0, 0.01);
    assert_near(inefficiency * (1.0 - phi) / (1.0 + phi), 1.0, 0.15);
    assert_in_range((unsigned long)inside, (unsigned long)(0.94 * RUNS),
                    (unsigned long)(0.96 * RUNS));
    /* the formula for independent values would be wrong by √((1+φ)/(1−φ)) */
    if (phi == 0.9) assert_true(em_interval_mean(x, N, 0.95).error < 0.3 * truth);
  }
}

/* What sways and comes back, as balls in a drum do, is no error of the mean: a wave of 4.6, 10.7
 * and 24.6 values, three times as strong as noise with a memory, adds next to nothing. */
static void waves_are_no_error(void **state) {
  (void)state;
  enum { N = 256, RUNS = 1000 };
  static double x[N];
  const double periods[] = {4.6, 10.7, 24.6}, phi = 0.6;
  for (int k = 0; k < 3; k++) {
    double square = 0.0, mean_square = 0.0, inside = 0.0;
    gsl_rng_set(rng, 17);
    for (int r = 0; r < RUNS; r++) {
      const double phase = 2.0 * M_PI * gsl_rng_uniform(rng);
      double wave = 0.0;
      autoregressive(x, N, phi);
      for (int i = 0; i < N; i++) {
        const double w = 3.0 * M_SQRT2 / 0.8 * sin(2.0 * M_PI * i / periods[k] + phase);
        x[i] += w;
        wave += w / N;
      }
      const struct em_interval i = em_interval_series(x, N, 0.95);
      const double off = i.value - wave; /* without what is left of a period */
      square += i.error * i.error / RUNS;
      mean_square += off * off / RUNS;
      inside += fabs(off) <= i.half;
    }
    assert_near(sqrt(square / mean_square), 1.0, 0.12);
    assert_true(inside >= 0.87 * RUNS && inside <= 0.95 * RUNS);
  }
}

/* More values than are looked at one by one, with a memory as long as those of a tenth of them. */
static void long_series(void **state) {
  (void)state;
  enum { N = 50000, RUNS = 40 };
  double *x = malloc(N * sizeof *x), square = 0.0;
  const double phi = 0.999, truth = 1.0 / (1.0 - phi) / sqrt(N);
  gsl_rng_set(rng, 19);
  for (int r = 0; r < RUNS; r++) {
    autoregressive(x, N, phi);
    const struct em_interval i = em_interval_series(x, N, 0.95);
    square += i.error * i.error / RUNS;
  }
  assert_near(sqrt(square) / truth, 1.0, 0.15);
  free(x);
}

static void student_and_simple_means(void **state) {
  (void)state;
  assert_near(em_interval_student(0.95, 10), 2.228139, 1e-5);
  assert_near(em_interval_student(0.95, 1e7), 1.959964, 1e-4);
  assert_true(isnan(em_interval_student(0.95, 0)));
  const double x[] = {1.0, 2.0, 3.0, 4.0};
  const struct em_interval i = em_interval_mean(x, 4, 0.95);
  assert_near(i.value, 2.5, 1e-15);
  assert_near(i.half, 3.182446 * sqrt(5.0 / 3.0) / 2.0, 1e-5);
  assert_true(isnan(em_interval_series(x, 1, 0.95).half));
  assert_true(isnan(em_interval_mean(x, 0, 0.95).value));
  const double same[8] = {2.0, 2.0, 2.0, 2.0, 2.0, 2.0, 2.0, 2.0};
  assert_near(em_interval_series(same, 8, 0.95).half, 0.0, 1e-15);
}

static double median(const struct em_histogram *h, double weight, void *self) {
  (void)weight;
  (void)self;
  return em_histogram_quantile(h, 0.5);
}

static double rate(const struct em_histogram *h, double weight, void *self) {
  (void)self;
  return h->total / weight;
}

/* Blocks of Rayleigh values whose parameter drifts slowly up and down: the interval of the pooled
 * median must hold the truth as often as it says, and that of the rate as well. */
static void jackknife_covers(void **state) {
  (void)state;
  enum { BLOCKS = 64, EACH = 500, RUNS = 120 };
  struct em_histogram *block[BLOCKS];
  double weight[BLOCKS], level[BLOCKS];
  int inside[2] = {0, 0}, naive = 0;
  gsl_rng_set(rng, 11);
  for (int r = 0; r < RUNS; r++) {
    autoregressive(level, BLOCKS, 0.6);
    double all = 0.0;
    for (int b = 0; b < BLOCKS; b++) {
      block[b] = em_histogram_new_octaves(64, -10, 14, false);
      weight[b] = 0.05;
      const unsigned n = gsl_ran_poisson(rng, EACH);
      for (unsigned i = 0; i < n; i++)
        em_histogram_add(block[b], gsl_ran_rayleigh(rng, exp(0.05 * level[b])), 1.0);
      all += n;
    }
    struct em_interval i;
    assert_int_equal(em_interval_figure(&i, BLOCKS, block, weight, median, NULL, 0.95), EM_OK);
    const double truth = sqrt(2.0 * log(2.0));
    inside[0] += fabs(i.value - truth) <= i.half;
    naive += fabs(i.value - truth) <= 1.96 * 0.849 / sqrt(all); /* 1/(2 f(m) √n), Rayleigh */
    assert_int_equal(em_interval_figure(&i, BLOCKS, block, weight, rate, NULL, 0.95), EM_OK);
    inside[1] += fabs(i.value - EACH / 0.05) <= i.half;
    for (int b = 0; b < BLOCKS; b++)
      em_histogram_free(block[b]);
  }
  assert_in_range(inside[0], 0.88 * RUNS, RUNS);
  assert_in_range(inside[1], 0.88 * RUNS, RUNS);
  assert_true(naive < 0.75 * RUNS);
}

static double above_two(const struct em_histogram *h, double weight, void *self) {
  (void)weight, (void)self;
  return 1.0 - em_histogram_share(h, 2.0);
}

/* What was seen never, or in one block alone, is known to no precision. */
static void jackknife_admits_ignorance(void **state) {
  (void)state;
  enum { BLOCKS = 16 };
  struct em_histogram *block[BLOCKS];
  double weight[BLOCKS];
  for (int b = 0; b < BLOCKS; b++) {
    block[b] = em_histogram_new(100, 0.0, 10.0);
    weight[b] = 0.05;
  }
  struct em_interval i;
  em_interval_figure(&i, BLOCKS, block, weight, rate, NULL, 0.95);
  assert_true(i.value == 0.0 && isnan(i.half) && isnan(i.error));
  em_histogram_add(block[3], 1.0, 1.0);
  em_interval_figure(&i, BLOCKS, block, weight, median, NULL, 0.95);
  assert_true(i.value > 0.9 && isnan(i.half) && isnan(i.error));
  em_interval_figure(&i, BLOCKS, block, weight, rate, NULL, 0.95);
  assert_true(i.value > 0.0 && i.half > i.value);
  for (int b = 0; b < BLOCKS; b++)
    em_histogram_add(block[b], 0.01 * b, 1.0);
  em_interval_figure(&i, BLOCKS, block, weight, above_two, NULL, 0.95);
  assert_true(i.value == 0.0 && isnan(i.half) && isnan(i.error));
  for (int b = 0; b < BLOCKS; b++)
    em_histogram_free(block[b]);
}

/* Medians of few values: half a value, one, three per block. Without joining blocks, 82 … 89 % of
 * the intervals hold the truth. */
static void quantiles_of_few_values(void **state) {
  (void)state;
  enum { BLOCKS = 64, RUNS = 400, CASES = 3 };
  static const double each[CASES] = {0.5, 1.0, 3.0};
  struct em_histogram *block[BLOCKS];
  int inside = 0;
  gsl_rng_set(rng, 12);
  for (int r = 0; r < CASES * RUNS; r++) {
    for (int b = 0; b < BLOCKS; b++) {
      block[b] = em_histogram_new_octaves(64, -10, 14, false);
      for (unsigned n = gsl_ran_poisson(rng, each[r % CASES]); n > 0; n--)
        em_histogram_add(block[b], gsl_ran_rayleigh(rng, 1.0), 1.0);
    }
    struct em_interval i;
    assert_int_equal(em_interval_quantile(&i, BLOCKS, block, 0.5, 0.95), EM_OK);
    inside += fabs(i.value - sqrt(2.0 * log(2.0))) <= i.half;
    assert_true(i.inefficiency >= 4.0);
    for (int b = 0; b < BLOCKS; b++)
      em_histogram_free(block[b]);
  }
  assert_in_range(inside, 0.875 * CASES * RUNS, CASES * RUNS);
}

static void differences(void **state) {
  (void)state;
  const struct em_interval a = {1.0, 0.0, 0.1, 1e9, 1.0}, b = {1.3, 0.0, 0.1, 1e9, 1.0};
  assert_near(em_interval_difference(&a, &b), 2.0 * gsl_cdf_ugaussian_Q(0.3 / sqrt(0.02)), 1e-6);
  assert_near(em_interval_difference(&a, &a), 1.0, 1e-12);
  const struct em_interval unknown = {1.0, NAN, NAN, 0.0, 1.0};
  assert_true(isnan(em_interval_difference(&a, &unknown)));
}

/* A ramp or an exponential approach of known length, then noise. */
static void mser_finds_the_end_of_ramps(void **state) {
  (void)state;
  enum { N = 600 };
  double x[N];
  int late = 0;
  gsl_rng_set(rng, 3);
  for (int r = 0; r < 50; r++) {
    const int end = 60 + 4 * r / 2;
    for (int i = 0; i < N; i++) {
      const double ramp = i < end ? 3.0 * (end - i) / end : 0.0;
      x[i] = 2.0 + ramp + 0.1 * gsl_ran_ugaussian(rng);
    }
    const struct em_steady s = em_steady_find(x, N);
    assert_int_equal(s.found, EM_STEADY_YES);
    assert_true((int)s.start >= (int)(0.85 * end) - 5);
    late += (int)s.start > end + 60;
    assert_true(fabs(s.geweke) < 5.0);
    assert_true(fabs(em_steady_geweke(x, N)) > 8.0);
  }
  assert_true(late < 15); /* the criterion is flat: chance may cut more */
}

/* Noise that remembers a fifth of the series, and the same of which a hundred times as much is
 * known. */
static void few_independent_values_are_too_short_to_tell(void **state) {
  (void)state;
  enum { N = 500, LONG = 50000 };
  double *x = malloc(LONG * sizeof *x);
  gsl_rng_set(rng, 9);
  int brief = 0, found = 0;
  for (int r = 0; r < 20; r++) {
    autoregressive(x, N, 0.98);
    const struct em_steady s = em_steady_find(x, N);
    brief += s.found == EM_STEADY_BRIEF;
    autoregressive(x, LONG, 0.98);
    found += em_steady_find(x, LONG).found == EM_STEADY_YES;
  }
  assert_true(brief >= 10);
  assert_true(found >= 18);
  free(x);
}

static void mser_keeps_noise_and_refuses_drift(void **state) {
  (void)state;
  enum { N = 500 };
  double x[N];
  gsl_rng_set(rng, 5);
  int early = 0;
  for (int r = 0; r < 100; r++) {
    autoregressive(x, N, 0.5);
    early += em_steady_find(x, N).start <= N / 4;
  }
  assert_true(early >= 85);
  for (int i = 0; i < N; i++)
    x[i] = 0.01 * i + 0.05 * gsl_ran_ugaussian(rng);
  const struct em_steady s = em_steady_find(x, N);
  assert_true(s.found == EM_STEADY_NONE || (s.found == EM_STEADY_YES && fabs(s.geweke) > 5.0));
  assert_int_equal(em_steady_mser(x, 0), 0);
  assert_true(isnan(em_steady_find(x, 3).geweke));
}

static void geweke_is_normal_under_the_null(void **state) {
  (void)state;
  enum { N = 2000, RUNS = 300 };
  static double x[N];
  double u[RUNS];
  gsl_rng_set(rng, 13);
  for (int r = 0; r < RUNS; r++) {
    autoregressive(x, N, 0.5);
    u[r] = gsl_cdf_ugaussian_P(em_steady_geweke(x, N));
  }
  assert_true(em_goodness_ks(u, RUNS).p > 0.01);
}

enum { SEEDS = 200 };

static double draw(enum em_distribution law, double a) {
  const int k = em_distribution_freedom(law);
  if (k == 1) return gsl_ran_gaussian(rng, a);
  if (k > 1) return a * sqrt(gsl_ran_chisq(rng, k));
  const double u = gsl_rng_uniform(rng);
  return law == EM_DISTRIBUTION_LINEAR ? a * sqrt(u) : a * u;
}

/* p-values must be uniform when the law holds, and tiny when it does not. */
static void p_values_are_uniform(void **state) {
  (void)state;
  enum { N = 2000 };
  static double u[N], ks[SEEDS], chi2[SEEDS];
  for (int n = 0; n < EM_DISTRIBUTION_COUNT; n++) {
    const enum em_distribution law = (enum em_distribution)n;
    for (unsigned seed = 0; seed < SEEDS; seed++) {
      gsl_rng_set(rng, 100 + seed);
      for (int i = 0; i < N; i++)
        u[i] = em_distribution_cdf(law, 1.7, draw(law, 1.7));
      struct em_goodness g;
      assert_int_equal(em_goodness_chi2_uniform(&g, u, N, 0, 1), EM_OK);
      chi2[seed] = g.p;
      ks[seed] = em_goodness_ks(u, N).p;
    }
    assert_true(em_goodness_ks(ks, SEEDS).p > 0.01);
    assert_true(em_goodness_ks(chi2, SEEDS).p > 0.01);
    for (int i = 0; i < N; i++)
      u[i] = em_distribution_cdf(law, 2.0, draw(law, 1.7));
    struct em_goodness g;
    assert_int_equal(em_goodness_chi2_uniform(&g, u, N, 0, 1), EM_OK);
    const double p = em_goodness_ks(u, N).p;
    assert_true(g.p < 0.05 || p < 0.05);
  }
}

/* With the parameter taken from the sample's own energy, and with its own mean as well. */
static void tied_p_values_are_uniform(void **state) {
  (void)state;
  enum { N = 1000, RUNS = 60 };
  static double x[N], ks[RUNS], chi2[RUNS];
  double kind = 0.0;
  const struct {
    enum em_distribution law;
    bool centred;
  } tie[] = {{EM_DISTRIBUTION_MAXWELL, false},
             {EM_DISTRIBUTION_NORMAL, false},
             {EM_DISTRIBUTION_NORMAL, true}};
  for (int l = 0; l < 3; l++) {
    for (unsigned seed = 0; seed < RUNS; seed++) {
      gsl_rng_set(rng, 900 + seed);
      double sum = 0.0, mean = 0.0;
      for (int i = 0; i < N; i++) {
        x[i] = draw(tie[l].law, 0.3);
        mean += x[i] / N;
      }
      for (int i = 0; i < N; i++) {
        if (tie[l].centred) x[i] -= mean;
        sum += x[i] * x[i];
      }
      const double a = sqrt(sum / (N * em_distribution_freedom(tie[l].law)));
      for (int i = 0; i < N; i++)
        x[i] = em_distribution_cdf(tie[l].law, a, x[i]);
      struct em_goodness g;
      assert_int_equal(em_goodness_chi2_uniform(&g, x, N, 0, tie[l].centred ? 3 : 2), EM_OK);
      chi2[seed] = g.p;
      assert_int_equal(em_goodness_ks_tied(&g, tie[l].law, tie[l].centred, x, N), EM_OK);
      ks[seed] = g.p;
      if (!tie[l].centred) kind += em_goodness_ks(x, N).p / (2.0 * RUNS);
    }
    assert_true(em_goodness_ks(ks, RUNS).p > 0.01);
    assert_true(em_goodness_ks(chi2, RUNS).p > 0.01);
  }
  assert_true(kind > 0.57); /* the plain test is too kind here: its mean should be 0.5 */
  struct em_goodness g;
  assert_int_equal(em_goodness_ks_tied(&g, EM_DISTRIBUTION_UNIFORM, false, x, N), EM_INPUT);
}

static void chi2_merges_thin_bins(void **state) {
  (void)state;
  const double expected[] = {1.0, 2.0, 3.0, 50.0, 40.0, 2.0, 1.0};
  const double observed[] = {0.0, 3.0, 5.0, 45.0, 43.0, 1.0, 2.0};
  const struct em_goodness g = em_goodness_chi2(observed, expected, 7, 1);
  /* cells {6}, {50}, {43} */
  assert_near(g.freedom, 2.0, 0.0);
  assert_near(g.statistic, 4.0 / 6.0 + 25.0 / 50.0 + 9.0 / 43.0, 1e-12);
  assert_near(em_goodness_kolmogorov(1.3581), 0.05, 1e-4);
  assert_near(em_goodness_kolmogorov(0.8276), 0.5, 1e-3);
  assert_near(em_goodness_kolmogorov(1.1799999), em_goodness_kolmogorov(1.18), 1e-6);
}

static double spahn(double v, const double *p, const void *self) {
  (void)self;
  return v + p[1] > 0.0 ? p[0] / pow(v + p[1], p[2]) : NAN;
}

/* The law of restitution that the source fitted, back from noisy data; errors must cover. */
static void fit_recovers_parameters(void **state) {
  (void)state;
  enum { N = 240, RUNS = 60 };
  double v[N], e[N];
  const double truth[] = {0.985, 0.9494, 0.291}, start[] = {1.0, 1.0, 0.25};
  const struct em_fit_model model = {3, spahn, NULL};
  int inside[3] = {0, 0, 0};
  for (unsigned r = 0; r < RUNS; r++) {
    gsl_rng_set(rng, r);
    for (int i = 0; i < N; i++) {
      v[i] = gsl_ran_flat(rng, 0.1, 50.0);
      e[i] = spahn(v[i], truth, NULL) + gsl_ran_gaussian(rng, 0.02);
    }
    struct em_fit fit;
    assert_int_equal(em_fit_curve(&fit, &model, N, v, e, start, NULL), EM_OK);
    assert_true(fit.converged);
    assert_near(fit.sigma, 0.02, 0.004);
    for (int k = 0; k < 3; k++)
      inside[k] += fabs(fit.p[k] - truth[k]) <= 1.97 * fit.error[k];
  }
  for (int k = 0; k < 3; k++)
    assert_in_range(inside[k], 0.85 * RUNS, RUNS);
  for (int i = 0; i < N; i++)
    e[i] = spahn(v[i], truth, NULL);
  struct em_fit fit;
  assert_int_equal(em_fit_curve(&fit, &model, N, v, e, start, NULL), EM_OK);
  for (int k = 0; k < 3; k++)
    assert_near(fit.p[k], truth[k], 1e-6);
}

static double first_two(double x, const double *p, const void *self) {
  (void)x;
  (void)self;
  return p[0] + p[1];
}

static double slope(double x, const double *p, const void *self) {
  (void)self;
  return p[0] + p[2] * x;
}

/* One that the curve does not know, two of which only the sum counts, and all at one place. */
static void what_data_do_not_determine_has_no_error(void **state) {
  (void)state;
  enum { N = 10 };
  const struct em_fit_model idle = {3, slope, NULL}, sum = {2, first_two, NULL};
  const struct em_fit_model law = {3, spahn, NULL};
  double x[N], y[N], one[N];
  for (int i = 0; i < N; i++) {
    x[i] = i;
    y[i] = 0.5 + 0.01 * (i * 7 % N);
    one[i] = 2.0;
  }
  struct em_fit fit;
  assert_int_equal(em_fit_curve(&fit, &idle, N, x, y, (double[]){1, 1, 1}, NULL), EM_OK);
  assert_true(fit.error[0] > 0.0 && isnan(fit.error[1]) && fit.error[2] > 0.0);
  double c0, c1, c00, c01, c11, square; /* of the straight line */
  gsl_fit_linear(x, 1, y, 1, N, &c0, &c1, &c00, &c01, &c11, &square);
  assert_near(fit.error[0], sqrt(c00 * (N - 2.0) / (N - 3.0)), 1e-6);
  assert_int_equal(em_fit_curve(&fit, &sum, N, x, y, (double[]){1, 1}, NULL), EM_OK);
  assert_true(isnan(fit.error[0]) && isnan(fit.error[1]));
  assert_int_equal(em_fit_curve(&fit, &law, N, one, y, (double[]){1, 1, 0.25}, NULL), EM_OK);
  for (int k = 0; k < 3; k++)
    assert_true(isnan(fit.error[k]));
}

static void fits_refuse_nonsense(void **state) {
  (void)state;
  const struct em_fit_model model = {3, spahn, NULL};
  const double x[] = {1.0, 2.0, 3.0, NAN}, y[] = {1.0, 1.0, 1.0, 1.0};
  struct em_fit fit;
  struct em_error err;
  assert_int_equal(em_fit_curve(&fit, &model, 3, x, y, (double[]){1, 1, 1}, &err), EM_INPUT);
  assert_int_equal(em_fit_curve(&fit, &model, 4, x, y, (double[]){1, 1, 1}, &err), EM_INPUT);
  const double z[] = {1.0, 2.0, 3.0, 4.0};
  assert_int_equal(em_fit_curve(&fit, &model, 4, z, y, (double[]){1, -9, 1}, &err), EM_NUMERIC);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(series_know_the_error_of_ar1),
      cmocka_unit_test(waves_are_no_error),
      cmocka_unit_test(long_series),
      cmocka_unit_test(student_and_simple_means),
      cmocka_unit_test(jackknife_covers),
      cmocka_unit_test(jackknife_admits_ignorance),
      cmocka_unit_test(quantiles_of_few_values),
      cmocka_unit_test(differences),
      cmocka_unit_test(mser_finds_the_end_of_ramps),
      cmocka_unit_test(few_independent_values_are_too_short_to_tell),
      cmocka_unit_test(mser_keeps_noise_and_refuses_drift),
      cmocka_unit_test(geweke_is_normal_under_the_null),
      cmocka_unit_test(p_values_are_uniform),
      cmocka_unit_test(tied_p_values_are_uniform),
      cmocka_unit_test(chi2_merges_thin_bins),
      cmocka_unit_test(fit_recovers_parameters),
      cmocka_unit_test(what_data_do_not_determine_has_no_error),
      cmocka_unit_test(fits_refuse_nonsense),
  };
  return cmocka_run_group_tests(tests, make_rng, free_rng);
}
