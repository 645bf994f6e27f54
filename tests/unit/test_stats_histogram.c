/* Histograms and samples against sorting, closed forms and each other. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>
#include <gsl/gsl_randist.h>
#include <gsl/gsl_rng.h>
#include <gsl/gsl_sort.h>
#include <gsl/gsl_statistics_double.h>

#include "eventmill/distribution.h"
#include "eventmill/histogram.h"
#include "eventmill/sample.h"

#define assert_near(a, b, tolerance) assert_true(fabs((a) - (b)) <= (tolerance))

static double area(const struct em_histogram *h) {
  double sum = 0.0;
  for (size_t k = 0; k < h->bins; k++)
    sum += em_histogram_density(h, k) * (h->edge[k + 1] - h->edge[k]);
  return sum;
}

static void area_is_one(void **state) {
  (void)state;
  gsl_rng *rng = gsl_rng_alloc(gsl_rng_mt19937);
  struct em_histogram *h[] = {em_histogram_new(317, -6.0, 6.0),
                              em_histogram_new_octaves(64, -30, 40, true),
                              em_histogram_new_edges(3, (double[]){-10.0, -1.0, 0.5, 10.0})};
  for (int i = 0; i < 20000; i++) {
    const double x = gsl_ran_ugaussian(rng);
    for (int k = 0; k < 3; k++)
      em_histogram_add(h[k], x, 1.0);
  }
  for (int k = 0; k < 3; k++) {
    assert_near(area(h[k]), 1.0, 1e-12);
    struct em_histogram *r = em_histogram_rebin(h[k], 100, -20.0, 20.0);
    assert_near(area(r), 1.0, 1e-12);
    assert_near(r->total, h[k]->total, 1e-8);
    em_histogram_free(r);
    em_histogram_free(h[k]);
  }
  gsl_rng_free(rng);
}

/* Every value must lie between the edges of the bin that it is counted in. */
static void bins_hold_their_values(void **state) {
  (void)state;
  gsl_rng *rng = gsl_rng_alloc(gsl_rng_mt19937);
  struct em_histogram *h[] = {em_histogram_new(1000, 0.1, 0.7),
                              em_histogram_new_octaves(64, -30, 40, false),
                              em_histogram_new_octaves(7, -3, 5, true),
                              em_histogram_new_edges(4, (double[]){-1.0, 0.0, 0.01, 3.0, 4.0})};
  for (int k = 0; k < 4; k++) {
    for (size_t j = 0; j < h[k]->bins; j++) { /* an edge opens its own bin, except mirrored ones */
      assert_true(h[k]->edge[j] < h[k]->edge[j + 1]);
      if (h[k]->edge[j] >= 0.0)
        assert_int_equal(em_histogram_find(h[k], h[k]->edge[j]), (long long)j);
    }
    for (int i = 0; i < 100000; i++) {
      const double x = exp(gsl_ran_flat(rng, -25.0, 8.0)) * (i % 2 ? 1.0 : -1.0);
      const ptrdiff_t j = em_histogram_find(h[k], x);
      if (j < 0)
        assert_true(x < h[k]->edge[0]);
      else if (j >= (ptrdiff_t)h[k]->bins)
        assert_true(x >= h[k]->edge[h[k]->bins]);
      else
        assert_true(h[k]->edge[j] <= x && x <= h[k]->edge[j + 1]);
    }
    em_histogram_free(h[k]);
  }
  gsl_rng_free(rng);
}

static void quantiles_agree_with_sorting(void **state) {
  (void)state;
  enum { N = 50001 };
  gsl_rng *rng = gsl_rng_alloc(gsl_rng_mt19937);
  double *x = malloc(N * sizeof *x);
  struct em_histogram *h = em_histogram_new_octaves(64, -30, 40, false);
  for (int i = 0; i < N; i++) {
    x[i] = gsl_ran_rayleigh(rng, 0.7);
    em_histogram_add(h, x[i], 1.0);
  }
  gsl_sort(x, 1, N);
  for (double p = 0.25; p < 1.0; p += 0.25)
    assert_near(em_histogram_quantile(h, p), em_sample_quantile(x, N, p), 2e-3);
  assert_near(em_histogram_mean(h), gsl_stats_mean(x, 1, N), 1e-3);
  for (double p = 0.02; p < 1.0; p += 0.07)
    assert_near(em_histogram_share(h, em_histogram_quantile(h, p)), p, 1e-12);
  /* within the sample's own scatter: the median of Rayleigh is b √(2 ln 2) */
  assert_near(em_sample_median(x, N), 0.7 * sqrt(2.0 * log(2.0)), 0.01);
  em_histogram_free(h);
  free(x);
  gsl_rng_free(rng);
}

static void modes_are_found(void **state) {
  (void)state;
  gsl_rng *rng = gsl_rng_alloc(gsl_rng_mt19937);
  struct em_histogram *rayleigh = em_histogram_new_octaves(64, -30, 40, false);
  struct em_histogram *normal = em_histogram_new_octaves(64, -30, 40, true);
  struct em_histogram *falling = em_histogram_new_octaves(64, -30, 40, false);
  struct em_histogram *rising = em_histogram_new(1000, 0.0, 1.0); /* density 2 s */
  for (int i = 0; i < 400000; i++) {
    em_histogram_add(rayleigh, gsl_ran_rayleigh(rng, 0.5), 1.0);
    em_histogram_add(normal, -0.3 + gsl_ran_gaussian(rng, 0.8), 1.0);
    em_histogram_add(falling, gsl_ran_exponential(rng, 1.0), 1.0);
    em_histogram_add(rising, sqrt(gsl_rng_uniform(rng)), 1.0);
  }
  assert_near(em_histogram_mode(rayleigh, 0.0), 0.5, 0.03);
  assert_near(em_histogram_mode(normal, 0.0), -0.3, 0.05);
  assert_near(em_histogram_mode(falling, 0.0), 0.0, 1e-12);
  assert_near(em_histogram_mode(rising, 0.0), 1.0, 1e-12);
  em_histogram_free(rayleigh);
  em_histogram_free(normal);
  em_histogram_free(falling);
  em_histogram_free(rising);
  gsl_rng_free(rng);
}

/* 3000 values in [0, 1), 1000 above: what these decide is not told. */
static void values_beyond_the_edges_count(void **state) {
  (void)state;
  struct em_histogram *h = em_histogram_new(100, 0.0, 1.0);
  for (int i = 0; i < 4000; i++)
    em_histogram_add(h, (i + 0.5) / 3000.0, 1.0);
  assert_near(em_histogram_weight(h), 4000.0, 0.0);
  assert_near(em_histogram_share(h, 0.5), 0.375, 1e-12);
  assert_near(em_histogram_share(h, 0.0), 0.0, 0.0);
  assert_near(em_histogram_quantile(h, 0.6), 0.8, 1e-12);
  assert_true(isnan(em_histogram_share(h, 1.2)) && isnan(em_histogram_quantile(h, 0.8)));
  assert_true(isnan(em_histogram_mean(h)) && isnan(em_histogram_mode(h, 0.0)));
  h->below = h->above;
  h->above = 0.0;
  assert_near(em_histogram_share(h, 1.2), 1.0, 0.0);
  assert_true(isnan(em_histogram_share(h, -0.1)) && isnan(em_histogram_quantile(h, 0.2)));
  em_histogram_free(h);
}

static void empty_and_odd_input(void **state) {
  (void)state;
  struct em_histogram *h = em_histogram_new(4, 0.0, 1.0);
  assert_true(isnan(em_histogram_quantile(h, 0.5)));
  assert_true(isnan(em_histogram_mode(h, 0.0)));
  assert_true(isnan(em_histogram_mean(h)));
  em_histogram_add(h, NAN, 1.0);
  em_histogram_add(h, INFINITY, 1.0);
  em_histogram_add(h, -3.0, 1.0);
  em_histogram_add(h, 1.0, 1.0);
  assert_near(h->below + h->above, 2.0, 0.0);
  assert_near(h->total, 0.0, 0.0);
  assert_null(em_histogram_new(3, 1.0, 1.0));
  assert_null(em_histogram_new_edges(2, (double[]){0.0, 1.0, 1.0}));
  em_histogram_free(h);
  em_histogram_free(NULL);
  double x[] = {3.0, 1.0, 2.0, 4.0};
  assert_near(em_sample_median(x, 4), 2.5, 0.0);
  assert_near(em_sample_median(x, 3), 2.0, 0.0);
  assert_true(isnan(em_sample_median(x, 0)) && isnan(em_sample_quantile(x, 0, 0.5)));
}

/* Each law: area 1, cdf the integral of the pdf, moments of the laws in closed form. */
static void laws_integrate(void **state) {
  (void)state;
  for (int n = 0; n < EM_DISTRIBUTION_COUNT; n++) {
    const enum em_distribution law = (enum em_distribution)n;
    const double a = 0.37, low = law == EM_DISTRIBUTION_NORMAL ? -12.0 * a : 0.0;
    const double high = em_distribution_freedom(law) ? 12.0 * a : a;
    enum { N = 100000 };
    const double dx = (high - low) / N;
    double sum = 0.0, square = 0.0;
    for (int i = 0; i < N; i++) {
      const double x = low + (i + 0.5) * dx, f = em_distribution_pdf(law, a, x);
      sum += f * dx;
      square += f * dx * x * x;
      if (i % 5000 == 0) assert_near(sum, em_distribution_cdf(law, a, x + 0.5 * dx), 1e-8);
    }
    assert_near(sum, 1.0, 1e-8);
    const int k = em_distribution_freedom(law);
    const double expected = k ? k * a * a : law == EM_DISTRIBUTION_LINEAR ? a * a / 2 : a * a / 3;
    assert_near(square, expected, 1e-7);
    assert_non_null(em_distribution_name(law));
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(area_is_one),
      cmocka_unit_test(bins_hold_their_values),
      cmocka_unit_test(quantiles_agree_with_sorting),
      cmocka_unit_test(modes_are_found),
      cmocka_unit_test(values_beyond_the_edges_count),
      cmocka_unit_test(empty_and_odd_input),
      cmocka_unit_test(laws_integrate),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
