/* Roots of polynomials: closed forms and brackets against roots chosen beforehand. */
#include <float.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "num/poly.h"

enum { CASES = 100000 };

static double uniform(double low, double high) {
  return low + (high - low) * drand48();
}

static int rising(const void *a, const void *b) {
  const double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

/* a = lead ∏ (x − root[k]), rounded from long double. */
static void expand(const double *root, int degree, double lead, double *a) {
  long double b[EM_POLY_DEGREE + 1] = {lead};
  for (int n = 0; n < degree; n++)
    for (int k = n + 1; k >= 0; k--)
      b[k] = (k > 0 ? b[k - 1] : 0.0L) - (k <= n ? b[k] * root[n] : 0.0L);
  for (int k = 0; k <= degree; k++)
    a[k] = (double)b[k];
}

/* Roots at least `apart` from each other. */
static void choose(double *root, int degree, double low, double high, double apart) {
  for (bool near = true; near;) {
    for (int k = 0; k < degree; k++)
      root[k] = uniform(low, high);
    qsort(root, (size_t)degree, sizeof(*root), rising);
    near = false;
    for (int k = 1; k < degree; k++)
      near = near || root[k] - root[k - 1] < apart;
  }
}

static void value(void **state) {
  (void)state;
  const double a[5] = {1, -2, 3, -4, 5};
  assert_true(em_poly_value(a, 4, 2.0) == 57.0);
  assert_true(em_poly_value(a, 0, 2.0) == 1.0);
}

static void quadratic(void **state) {
  (void)state;
  double x[2];
  assert_int_equal(em_poly_quadratic(1.0, 0.0, 1.0, x), 0);
  assert_int_equal(em_poly_quadratic(1.0, 0.0, 0.0, x), 0);
  assert_int_equal(em_poly_quadratic(-4.0, 2.0, 0.0, x), 1);
  assert_true(x[0] == 2.0);
  assert_int_equal(em_poly_quadratic(1.0, -2.0, 1.0, x), 1);
  assert_true(x[0] == 1.0);
  assert_int_equal(em_poly_quadratic(1.0, -1e9, 1.0, x), 2); /* no cancellation */
  assert_true(fabs(x[0] * 1e9 - 1.0) < 1e-15 && fabs(x[1] * 1e-9 - 1.0) < 1e-15);
}

static void closed_forms(void **state) {
  (void)state;
  srand48(1);
  for (int n = 0; n < CASES; n++) {
    double root[4], a[5], found[4];
    const int degree = 3 + n % 2;
    choose(root, degree, -2.0, 2.0, 0.02);
    expand(root, degree, uniform(0.1, 10.0), a);
    const int count = degree == 3 ? em_poly_cubic(a, found) : em_poly_quartic(a, found);
    assert_int_equal(count, degree);
    qsort(found, (size_t)count, sizeof(*found), rising);
    for (int k = 0; k < degree; k++)
      assert_true(fabs(found[k] - root[k]) < 1e-7);
  }
}

/* (x² + b²)(x − p)(x − q), (x² + b²)(x − p): one pair is not real. */
static void complex_pairs(void **state) {
  (void)state;
  srand48(2);
  for (int n = 0; n < CASES; n++) {
    const double p = uniform(-2, 0), q = uniform(0.01, 2), b2 = uniform(0.05, 2);
    double found[4];
    const double four[5] = {b2 * p * q, -b2 * (p + q), b2 + p * q, -(p + q), 1.0};
    assert_int_equal(em_poly_quartic(four, found), 2);
    assert_true(fabs(fmin(found[0], found[1]) - p) < 1e-7);
    assert_true(fabs(fmax(found[0], found[1]) - q) < 1e-7);
    const double three[4] = {-b2 * p, b2, -p, 1.0};
    assert_int_equal(em_poly_cubic(three, found), 1);
    assert_true(fabs(found[0] - p) < 1e-9);
  }
}

static void changes(void **state) {
  (void)state;
  srand48(3);
  for (int n = 0; n < CASES; n++) {
    double root[4], a[5], found[4];
    const int degree = 1 + n % 4;
    choose(root, degree, -2.0, 2.0, 1e-3);
    expand(root, degree, uniform(-1.0, 1.0), a);
    assert_int_equal(em_poly_changes(a, degree, -3.0, 3.0, found), degree);
    for (int k = 0; k < degree; k++)
      assert_true(fabs(found[k] - root[k]) < 1e-5);
    assert_true(em_poly_root_bound(a, degree) >= fmax(fabs(root[0]), fabs(root[degree - 1])));
  }
}

static void first_rise(void **state) {
  (void)state;
  srand48(4);
  for (int n = 0; n < CASES; n++) {
    double root[4], a[5];
    const int degree = 1 + n % 4;
    choose(root, degree, -1.0, 3.0, 1e-3);
    const double lead = n & 4 ? 1.0 : -1.0;
    expand(root, degree, lead, a);
    double truth = INFINITY;
    for (int k = degree - 1; k >= 0; k--)
      if (root[k] > 0.0 && ((degree - 1 - k) % 2 == 0) == (lead > 0.0)) truth = root[k];
    const double found = em_poly_first_rise(a, degree);
    if (a[0] >= 0.0) continue; /* checked below */
    assert_true(found == truth || fabs(found - truth) < 1e-5);
  }
  const double up[3] = {1.0, 1.0, 1.0}, dip[3] = {1.0, -1.0, 1.0}, fall[2] = {1.0, -1.0};
  assert_true(em_poly_first_rise(up, 2) == 0.0);  /* above and rising: now */
  assert_true(em_poly_first_rise(dip, 2) == 0.5); /* above, falling, never below: where it turns */
  assert_true(em_poly_first_rise(fall, 1) == INFINITY);
  const double below[3] = {1.0, -3.0, 1.0}, zero[5] = {0};
  assert_true(fabs(em_poly_first_rise(below, 2) - (1.5 + sqrt(1.25))) < 1e-15);
  assert_true(em_poly_first_rise(zero, 4) == INFINITY);
  const double cube[4] = {-1e-30, 3e-20, -3e-10, 1.0}; /* (x − 1e-10)³: a threefold root */
  assert_true(fabs(em_poly_first_rise(cube, 3) - 1e-10) < 1e-14);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(value),         cmocka_unit_test(quadratic), cmocka_unit_test(closed_forms),
      cmocka_unit_test(complex_pairs), cmocka_unit_test(changes),   cmocka_unit_test(first_rise),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
