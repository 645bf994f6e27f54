/* Key figures over blocks of time: their values, shifts between two runs, and what users ask for.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>
#include <gsl/gsl_randist.h>
#include <gsl/gsl_rng.h>

#include "eventmill/precision.h"
#include "eventmill/world.h"

enum { BLOCKS = 64 };

static uint64_t counts[EM_CLASS_COUNT][EM_TALLY_BINS];

/* `slow` contacts at 1 m/s and `fast` ones at 4 m/s. */
static void add(struct em_precision *p, double time, double speed, double power, uint64_t slow,
                uint64_t fast) {
  memset(counts, 0, sizeof counts);
  for (size_t k = 0; k < EM_TALLY_BINS; k++) {
    if (em_world_bin_edge(k) == 1.0) counts[0][k] = slow;
    if (em_world_bin_edge(k) == 4.0) counts[1][k] = fast;
  }
  assert_int_equal(em_precision_add(p, time, speed, power, &counts[0][0], EM_CLASS_COUNT), EM_OK);
}

static double value(const struct em_precision *p, enum em_precision_kind kind) {
  return em_precision_figure(p, em_precision_blocks(p), kind, 3.0, 0.95).value;
}

static void figures(void **state) {
  (void)state;
  struct em_precision *p = em_precision_new();
  for (int k = 0; k < BLOCKS; k++)
    add(p, 0.5, 2.0, k % 2 ? 3.0 : 5.0, 90, 10);
  assert_true(fabs(value(p, EM_PRECISION_SPEED) - 2.0) < 1e-12);
  assert_true(fabs(value(p, EM_PRECISION_POWER) - 4.0) < 1e-12);
  assert_true(fabs(value(p, EM_PRECISION_RATE) - 20.0) < 1e-9);
  assert_true(fabs(value(p, EM_PRECISION_VN) - 1.0) < 0.02);
  assert_true(fabs(em_precision_time(p, BLOCKS) - 0.5 * BLOCKS) < 1e-12);
  em_precision_free(p);
}

/* More blocks than there is room for are joined, and none is lost. */
static void joining(void **state) {
  (void)state;
  struct em_precision *p = em_precision_new();
  const int n = 5 * EM_PRECISION_BLOCKS + 3;
  for (int k = 0; k < n; k++)
    add(p, 0.25, k, 0.0, 1, (uint64_t)(k % 3));
  assert_true(em_precision_blocks(p) <= EM_PRECISION_BLOCKS);
  const double time = em_precision_time(p, em_precision_blocks(p));
  assert_true(fabs(time - 0.25 * n) < 1e-9);
  assert_true(fabs(value(p, EM_PRECISION_RATE) - 4.0) < 0.05);
  em_precision_free(p);
}

/* What two runs have in common cancels; the interval covers the shift as often as it says. */
static void shifts(void **state) {
  (void)state;
  enum { TRIES = 60 };
  gsl_rng *rng = gsl_rng_alloc(gsl_rng_mt19937);
  int covered = 0;
  for (int k = 0; k < TRIES; k++) {
    struct em_precision *a = em_precision_new(), *b = em_precision_new();
    for (int i = 0; i < BLOCKS; i++) {
      const double drift = 10.0 + i;
      add(a, 1.0, drift + gsl_ran_gaussian(rng, 0.1), drift, 10, 10);
      add(b, 1.0, drift + 0.83 + gsl_ran_gaussian(rng, 0.1), 1.5 * drift, 10, 15);
    }
    const struct em_interval s = em_precision_shift(a, b, EM_PRECISION_SPEED, 3.0, 0.95);
    const struct em_interval power = em_precision_shift(a, b, EM_PRECISION_POWER, 3.0, 0.95);
    const struct em_interval rate = em_precision_shift(a, b, EM_PRECISION_RATE, 3.0, 0.95);
    covered += fabs(s.value - 0.02) <= s.half; /* 0.83 of the mean, 41.5 */
    assert_true(s.half < 0.002);               /* the drift is from 10 to 73 */
    assert_true(fabs(power.value - 0.5) < 1e-12 && fabs(rate.value - 0.5) < 1e-9);
    assert_true(rate.half < 1e-9);
    em_precision_free(a);
    em_precision_free(b);
  }
  assert_true(covered > 0.85 * TRIES);
  gsl_rng_free(rng);
}

static void nothing_to_shift(void **state) {
  (void)state;
  struct em_precision *a = em_precision_new(), *b = em_precision_new();
  assert_true(isnan(em_precision_shift(a, b, EM_PRECISION_VN, 3.0, 0.95).value));
  add(a, 1.0, 1.0, 0.0, 0, 0);
  add(b, 1.0, 1.0, 1.0, 1, 0);
  assert_true(isnan(em_precision_shift(a, b, EM_PRECISION_POWER, 3.0, 0.95).value));
  assert_true(isnan(em_precision_shift(a, b, EM_PRECISION_VN, 3.0, 0.95).value));
  em_precision_free(a);
  em_precision_free(b);
}

static struct em_precision_target target(enum em_precision_kind kind, double wanted) {
  return (struct em_precision_target){.kind = kind, .above = 3.0, .wanted = wanted};
}

/* What was never seen is known to no precision, and a rate to one count at best. */
static void judging(void **state) {
  (void)state;
  const struct em_precision_target t[] = {target(EM_PRECISION_RATE, 0.01),
                                          target(EM_PRECISION_POWER, 0.01),
                                          target(EM_PRECISION_SPEED, 0.01)};
  struct em_precision_found found[3];
  for (uint64_t fast = 0; fast < 6; fast += 3) { /* 96 counts are too few for 1 %, 192 are enough */
    struct em_precision *p = em_precision_new();
    for (size_t k = 1; k <= EM_PRECISION_LEAST; k++) {
      assert_false(em_precision_judge(p, &t[2], 1, found));
      add(p, 1.0, 2.0, 0.0, 10, fast);
      assert_true(em_precision_is_due(p) == (k == EM_PRECISION_LEAST));
    }
    assert_false(em_precision_judge(p, t, 3, found));
    assert_false(found[0].reached || found[1].reached);
    assert_true(found[2].reached && found[2].figure.value == 2.0);
    assert_true(fabs(found[0].figure.value - (double)fast) < 1e-12);
    assert_true(found[0].figure.half == 1.0 / EM_PRECISION_LEAST);
    for (size_t k = 0; k < EM_PRECISION_LEAST; k++)
      add(p, 1.0, 2.0, 0.0, 10, fast);
    assert_true(em_precision_judge(p, t, 1, found) == (fast > 0));
    em_precision_free(p);
  }
}

/* Whoever stops as soon as an interval of a correlated series is narrow has one that still holds
 * the truth. */
static void stopping(void **state) {
  (void)state;
  enum { TRIES = 300 };
  static const double memory = 0.8, most = 4000;
  const struct em_precision_target t = target(EM_PRECISION_SPEED, 0.049);
  gsl_rng *rng = gsl_rng_alloc(gsl_rng_mt19937);
  int covered = 0;
  for (int k = 0; k < TRIES; k++) {
    struct em_precision *p = em_precision_new();
    struct em_precision_found found = {0};
    double x = gsl_ran_gaussian(rng, 0.1);
    for (int n = 0; n < most && !found.reached; n++) {
      x = memory * x + gsl_ran_gaussian(rng, 0.1 * sqrt(1.0 - memory * memory));
      assert_int_equal(em_precision_add(p, 1.0, 1.0 + x, 0.0, NULL, 0), EM_OK);
      if (em_precision_is_due(p)) em_precision_judge(p, &t, 1, &found);
    }
    assert_true(found.reached);
    covered += fabs(found.figure.value - 1.0) <= found.figure.half;
    em_precision_free(p);
  }
  assert_true(covered > 0.9 * TRIES);
  gsl_rng_free(rng);
}

static void reading(void **state) {
  (void)state;
  struct em_precision_target t[EM_PRECISION_TARGETS];
  size_t n;
  struct em_error err = {0};
  assert_int_equal(em_precision_read(t, &n, "rate(vn>2.5)=1%,power=0.02", &err), EM_OK);
  assert_int_equal(n, 2);
  assert_true(t[0].kind == EM_PRECISION_RATE && t[0].above == 2.5 && t[0].wanted == 0.01);
  assert_true(t[1].kind == EM_PRECISION_POWER && t[1].wanted == 0.02);
  assert_int_equal(em_precision_read(t, &n, " rate( vn > 3 ) = 1 % , median(speed) =5 %", &err),
                   EM_OK);
  assert_true(n == 2 && t[0].kind == EM_PRECISION_RATE && t[0].above == 3.0 && t[0].wanted == 0.01);
  assert_true(t[1].kind == EM_PRECISION_SPEED && t[1].wanted == 0.05);
  static const char *const bad[] = {
      "",          "power",         "power=0",      "power=2",           "mean=1%",
      "=1%",       "rate(vn>x)=1%", "rate(vn>3=1%", "rate(vn>3)zzz=1%",  "power=1%%",
      "power=1%x", "power=1% x",    "power=nan",    "rate(vn>3)=1%,x=1", "power power=1%"};
  for (size_t k = 0; k < sizeof bad / sizeof *bad; k++)
    assert_int_equal(em_precision_read(t, &n, bad[k], &err), EM_INPUT);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(figures),          cmocka_unit_test(joining), cmocka_unit_test(shifts),
      cmocka_unit_test(nothing_to_shift), cmocka_unit_test(judging), cmocka_unit_test(stopping),
      cmocka_unit_test(reading),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
