/* First contacts of pairs, planes and drums against 60 digits: no root missed, none invented. */
#include <float.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "eventmill/surface.h"
#include "reference.h"

/* test_long_surface.c has more of them. */
#ifndef CASES
#define CASES 20000
#endif

static struct reference ref;

static double uniform(double low, double high) {
  return low + (high - low) * drand48();
}

static double spread(double low, double high) {
  return low * pow(high / low, drand48());
}

static double sign(void) {
  return drand48() < 0.5 ? -1.0 : 1.0;
}

/* a[k] += x y */
static void add(int k, double x, double y) {
  mpfr_set_d(ref.x, x, MPFR_RNDN);
  mpfr_mul_d(ref.x, ref.x, y, MPFR_RNDN);
  mpfr_add(ref.a[k], ref.a[k], ref.x, MPFR_RNDN);
}

static void clear(void) {
  for (int k = 0; k <= REFERENCE_DEGREE; k++)
    mpfr_set_zero(ref.a[k], 1);
}

/* What the checks found. */
struct tally {
  long hits, grazes;
  double worst_time, worst_place; /* relative; in units of the scale times epsilon */
};

/* Is t the first rise of the solved reference, up to rounding of its terms? shift: how many powers
 * of t were divided out; size: the sum of the terms' magnitudes at time t, by the caller. */
static void verify(double t, double (*size)(double), int shift, struct tally *tally) {
  const double slack = 32.0 * DBL_EPSILON;
  assert_true(t == t);
  assert_true(t >= 0.0);
  const double truth = ref.rises ? mpfr_get_d(ref.rise, MPFR_RNDN) : INFINITY;
  if (t == truth) {
    tally->hits += t < INFINITY;
    return;
  }
  /* Nothing may have risen above rounding before t. */
  const double until = fmin(t, 1e300);
  for (int k = 0; k < ref.turns; k++) {
    const double at = mpfr_get_d(ref.turn[k], MPFR_RNDN);
    const double height = mpfr_get_d(ref.height[k], MPFR_RNDN) * pow(at, shift);
    if (at < until && truth < at) assert_true(height <= slack * size(at));
  }
  if (t == INFINITY) {
    tally->grazes++;
    return;
  }
  const double residual = reference_at(&ref, 0, t) * pow(t, shift) / size(t);
  assert_true(fabs(residual) <= slack);
  tally->hits++;
  tally->worst_place = fmax(tally->worst_place, fabs(residual) / DBL_EPSILON);
  const double error = fabs(t - truth) / truth;
  if (error < 1e-9)
    tally->worst_time = fmax(tally->worst_time, error);
  else
    tally->grazes++;
}

static void report(const char *what, const struct tally *tally) {
  printf("  %-34s %7ld hits, %5ld grazing, worst %.1e of the time, %.1f eps of the place\n", what,
         tally->hits, tally->grazes, tally->worst_time, tally->worst_place);
}

/* ---------------------------------------------------------------- pairs */
static struct em_vec pair_r, pair_v;
static double pair_sigma;

static double pair_size(double t) {
  const double d = em_vec_norm(pair_r) + em_vec_norm(pair_v) * t;
  return d * d + pair_sigma * pair_sigma;
}

/* −(|r + v t|² − σ²) rises where the balls meet. */
static void pair_reference(void) {
  clear();
  add(0, pair_sigma, pair_sigma);
  const double r[3] = {pair_r.x, pair_r.y, pair_r.z}, v[3] = {pair_v.x, pair_v.y, pair_v.z};
  for (int k = 0; k < 3; k++) {
    add(0, -r[k], r[k]);
    add(1, -2.0 * r[k], v[k]);
    add(2, -v[k], v[k]);
  }
  reference_solve(&ref, 2, 4.0 * em_vec_norm(pair_r) / em_vec_norm(pair_v));
}

static struct em_vec direction(void) {
  for (;;) {
    const struct em_vec a = {uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)};
    const double n = em_vec_norm(a);
    if (n > 0.1 && n < 1.0) return em_vec_scale(1.0 / n, a);
  }
}

/* impact: the distance at which the straight path passes, in units of σ. */
static void pair_make(double impact) {
  pair_sigma = spread(1e-3, 1e-2);
  const struct em_vec e = direction();
  const struct em_vec other = em_vec_cross(e, direction());
  const struct em_vec side = em_vec_scale(1.0 / em_vec_norm(other), other);
  pair_v = em_vec_scale(spread(1e-3, 1e2), e);
  pair_r =
      em_vec_axpy(em_vec_scale(-pair_sigma * spread(1.001, 50.0), e), impact * pair_sigma, side);
}

static void pairs(void **state) {
  (void)state;
  srand48(1);
  struct tally tally = {0};
  for (int n = 0; n < CASES; n++) {
    pair_make(uniform(0.0, 1.5));
    if (n % 7 == 0) pair_r = em_vec_scale(pair_sigma * (1.0 + spread(1e-15, 1e-3)), direction());
    if (em_vec_norm2(pair_r) <= pair_sigma * pair_sigma) continue;
    pair_reference();
    verify(em_surface_pair(pair_r, pair_v, pair_sigma), pair_size, 0, &tally);
  }
  report("pairs", &tally);
  assert_true(tally.hits > CASES / 3);
}

static void pairs_grazing(void **state) {
  (void)state;
  srand48(2);
  struct tally tally = {0};
  for (int n = 0; n < CASES; n++) {
    pair_make(1.0 + sign() * spread(1e-16, 1e-12));
    pair_reference();
    verify(em_surface_pair(pair_r, pair_v, pair_sigma), pair_size, 0, &tally);
  }
  report("pairs, grazing", &tally);
}

static void pairs_overlapping(void **state) {
  (void)state;
  const struct em_vec r = {1.0 - DBL_EPSILON, 0.0, 0.0};
  assert_true(em_surface_pair(r, em_vec_make(-1, 0, 0), 1.0) == 0.0);
  assert_true(em_surface_pair(r, em_vec_make(1, 0, 0), 1.0) == INFINITY);
  assert_true(em_surface_pair(r, em_vec_make(0, 0, 0), 1.0) == INFINITY);
}

/* ---------------------------------------------------------------- planes */
static double plane_gap, plane_rate, plane_fall;

static double plane_size(double t) {
  return fabs(plane_gap) + fabs(plane_rate) * t + 0.5 * fabs(plane_fall) * t * t;
}

static void plane_reference(bool touched) {
  clear();
  if (!touched) add(0, -1.0, plane_gap);
  add(touched ? 0 : 1, -1.0, plane_rate);
  add(touched ? 1 : 2, -0.5, plane_fall);
  const double far = 1e3 * (fabs(plane_rate / plane_fall) + sqrt(fabs(plane_gap / plane_fall)) +
                            fabs(plane_gap / plane_rate));
  reference_solve(&ref, touched ? 1 : 2, isfinite(far) ? far : 1e6);
}

static void planes(void **state) {
  (void)state;
  srand48(3);
  struct tally tally = {0};
  for (int n = 0; n < CASES; n++) {
    plane_gap = spread(1e-18, 1.0);
    plane_rate = sign() * spread(1e-9, 1e2);
    plane_fall = sign() * spread(1e-12, 1e6);
    if (n % 5 == 0) plane_fall = 0.0;
    if (n % 11 == 0) plane_gap = -plane_gap * 1e-9;
    if (n % 3 == 0 && plane_fall > 0.0) /* turns just at the plane */
      plane_rate = -sqrt(2.0 * plane_gap * plane_fall) * (1.0 + sign() * spread(1e-17, 1e-12));
    plane_reference(false);
    const double t = em_surface_plane(plane_gap, plane_rate, plane_fall, false);
    if (plane_gap < 0.0 && plane_rate < 0.0)
      assert_true(t == 0.0);
    else
      verify(t, plane_size, 0, &tally);
    if (plane_gap > 0.0 && ref.turns == 1 && mpfr_sgn(ref.height[0]) != 0)
      assert_true((t < INFINITY) == ref.rises); /* the sign of the discriminant is exact */
  }
  report("planes", &tally);
}

static void planes_touched(void **state) {
  (void)state;
  srand48(4);
  struct tally tally = {0};
  for (int n = 0; n < CASES; n++) {
    plane_gap = 0.0;
    plane_rate = spread(1e-12, 1e2);
    plane_fall = sign() * spread(1e-12, 1e6);
    plane_reference(true);
    const double t = em_surface_plane(sign() * 1e-18, plane_rate, plane_fall, true);
    if (plane_fall > 0.0)
      assert_true(t == INFINITY);
    else
      verify(t, plane_size, 1, &tally);
  }
  report("planes, touched", &tally);
  assert_true(em_surface_plane(1e-18, -1e-9, 0.0, true) == 0.0);
  assert_true(em_surface_plane(0.0, 0.0, -9.81, true) == 0.0);
  assert_true(em_surface_plane(0.0, 0.0, 9.81, true) == INFINITY);
  assert_true(em_surface_plane(0.0, 0.0, 0.0, false) == INFINITY);
}

/* ---------------------------------------------------------------- drums */
struct drum {
  double px, pz, vx, vz, gx, gz, rho;
  bool touched;
};
static struct drum drum;

static double drum_size(double t) {
  const double p = hypot(drum.px, drum.pz), v = hypot(drum.vx, drum.vz);
  const double d = p + t * (v + 0.5 * t * hypot(drum.gx, drum.gz));
  return d * d + drum.rho * drum.rho;
}

static void drum_reference(void) {
  clear();
  const double p[2] = {drum.px, drum.pz}, v[2] = {drum.vx, drum.vz}, g[2] = {drum.gx, drum.gz};
  const int cut = drum.touched ? 1 : 0;
  if (!cut) add(0, -drum.rho, drum.rho);
  for (int k = 0; k < 2; k++) {
    if (!cut) add(0, p[k], p[k]);
    add(1 - cut, 2.0 * p[k], v[k]);
    add(2 - cut, v[k], v[k]);
    add(2 - cut, p[k], g[k]);
    add(3 - cut, v[k], g[k]);
    add(4 - cut, 0.25 * g[k], g[k]);
  }
  const double speed = hypot(v[0], v[1]), fall = hypot(g[0], g[1]);
  double far = 8.0 * drum.rho / speed;
  if (fall > 0.0) far = 8.0 * (speed + sqrt(speed * speed + 4.0 * fall * drum.rho)) / fall;
  reference_solve(&ref, (fall > 0.0 ? 4 : 2) - cut, far);
}

static double drum_time(enum em_quartic solver, double horizon) {
  return em_surface_drum(drum.px, drum.pz, drum.vx, drum.vz, drum.gx, drum.gz, drum.rho,
                         drum.touched, solver, horizon);
}

/* A contact at t exists for every horizon ≥ t, with the same bits, and for none below. */
static void drum_horizon(enum em_quartic solver, double t) {
  for (int k = 0; k < 3; k++) {
    const double horizon = t * (k == 0 ? 1.0 : uniform(0.0, 2.0));
    const double cut = drum_time(solver, horizon);
    if (horizon >= t)
      assert_true(cut == t);
    else
      assert_true(cut == INFINITY);
  }
  assert_true(drum_time(solver, nextafter(t, -1.0)) == INFINITY);
}

static void drum_check(struct tally *tally) {
  drum_reference();
  const bool gravity = drum.gx != 0.0 || drum.gz != 0.0;
  for (int k = 0; k < (gravity ? EM_QUARTIC_SURE : 1); k++) {
    const double t = drum_time((enum em_quartic)k, INFINITY);
    verify(t, drum_size, drum.touched, &tally[k]);
    if (t < INFINITY) drum_horizon((enum em_quartic)k, t);
  }
}

static void drum_report(const char *what, const struct tally *tally, int count) {
  for (int k = 0; k < count; k++) {
    char text[64];
    snprintf(text, sizeof(text), "%s, %s", what, em_surface_quartic_name((enum em_quartic)k));
    report(text, &tally[k]);
  }
}

static void place(double share) {
  const double phi = uniform(0.0, 2.0 * M_PI);
  drum.px = drum.rho * share * cos(phi);
  drum.pz = drum.rho * share * sin(phi);
}

static void aim(double speed, double fall) {
  const double phi = uniform(0.0, 2.0 * M_PI), psi = uniform(0.0, 2.0 * M_PI);
  drum.vx = speed * cos(phi);
  drum.vz = speed * sin(phi);
  drum.gx = fall * cos(psi);
  drum.gz = fall * sin(psi);
}

static void drums_as_in_a_mill(void **state) {
  (void)state;
  srand48(5);
  struct tally tally[EM_QUARTIC_SURE] = {0};
  for (int n = 0; n < CASES; n++) {
    drum = (struct drum){.rho = 0.0705};
    place(sqrt(drand48()) * (1.0 - 1e-12));
    aim(spread(1e-2, 10.0), 0.0);
    drum.gz = -9.81;
    drum_check(tally);
  }
  drum_report("drum", tally, EM_QUARTIC_SURE);
}

/* Sizes, speeds and gravity over many orders of magnitude; close to the wall; at rest. */
static void drums_extreme(void **state) {
  (void)state;
  srand48(6);
  struct tally tally[EM_QUARTIC_SURE] = {0};
  for (int n = 0; n < CASES; n++) {
    drum = (struct drum){.rho = spread(1e-3, 10.0)};
    place(n % 3 ? sqrt(drand48()) * 0.999 : 1.0 - spread(1e-15, 1e-3));
    aim(n % 17 ? spread(1e-6, 1e3) : 0.0, spread(1e-12, 1e6));
    if (hypot(drum.px, drum.pz) >= drum.rho) continue;
    drum_check(tally);
  }
  drum_report("drum, extreme", tally, EM_QUARTIC_SURE);
}

static void drums_without_gravity(void **state) {
  (void)state;
  srand48(7);
  struct tally tally[EM_QUARTIC_SURE] = {0};
  for (int n = 0; n < CASES; n++) {
    drum = (struct drum){.rho = spread(1e-3, 10.0), .touched = n % 4 == 3};
    place(drum.touched ? 1.0 : n % 4 ? sqrt(drand48()) * 0.999 : 1.0 - spread(1e-15, 1e-3));
    aim(spread(1e-6, 1e3), 0.0);
    const double out = drum.px * drum.vx + drum.pz * drum.vz;
    if (drum.touched ? out >= 0.0 : hypot(drum.px, drum.pz) >= drum.rho) continue;
    drum_check(tally);
  }
  drum_report("drum without gravity", tally, 1);
}

/* The ball has just hit this wall: the deflated polynomial. */
static void drums_touched(void **state) {
  (void)state;
  srand48(8);
  struct tally tally[EM_QUARTIC_SURE] = {0};
  for (int n = 0; n < CASES; n++) {
    drum = (struct drum){.rho = spread(1e-3, 10.0), .touched = true};
    place(1.0 + (n % 5 - 2) * DBL_EPSILON);
    aim(spread(1e-6, 1e2), n % 2 ? 9.81 : spread(1e-9, 1e4));
    if (n % 3 == 0) { /* almost along the wall */
      const double k = spread(1e-14, 1e-1), speed = hypot(drum.vx, drum.vz) / drum.rho;
      drum.vx = speed * (drum.pz - k * drum.px);
      drum.vz = speed * (-drum.px - k * drum.pz);
    }
    if (drum.px * drum.vx + drum.pz * drum.vz >= 0.0) continue;
    drum_check(tally);
  }
  drum_report("drum, touched", tally, EM_QUARTIC_SURE);
  drum.vx = drum.px;
  drum.vz = drum.pz;
  assert_true(drum_time(EM_QUARTIC_SAFE, INFINITY) == 0.0);
}

/* A hair outside: moving out is a contact now, moving in is none. */
static void drums_outside(void **state) {
  (void)state;
  srand48(9);
  struct tally tally[EM_QUARTIC_SURE] = {0};
  for (int n = 0; n < CASES / 4; n++) {
    drum = (struct drum){.rho = spread(1e-3, 10.0)};
    place(1.0 + spread(1e-15, 1e-12));
    aim(spread(1e-3, 1e2), n % 3 ? spread(1e-9, 1e4) : 0.0);
    if (hypot(drum.px, drum.pz) <= drum.rho) continue;
    if (drum.px * drum.vx + drum.pz * drum.vz > 0.0)
      for (int k = 0; k < EM_QUARTIC_SURE; k++)
        assert_true(drum_time((enum em_quartic)k, INFINITY) == 0.0);
    else
      drum_check(tally);
  }
  drum_report("drum, outside by rounding", tally, EM_QUARTIC_SURE);
}

/* The apex of the path touches the top of the drum from inside, up to 1e-16 … 1e-12: roots that
 * are double, or just not there; with v² = g ρ at the apex, triple and fourfold ones. */
static void drums_apex(void **state) {
  (void)state;
  srand48(10);
  struct tally tally[EM_QUARTIC_SURE] = {0};
  for (int n = 0; n < CASES; n++) {
    drum = (struct drum){.rho = spread(1e-2, 1.0)};
    const double fall = spread(1e-2, 1e2),
                 share = n % 4 ? uniform(0.0, 1.0) : 1.0 - spread(1e-16, 1e-3);
    const double side = sqrt(share * fall * drum.rho),
                 before = uniform(0.01, 0.5) * sqrt(drum.rho / fall);
    drum.gz = -fall;
    drum.vx = side;
    drum.vz = fall * before;
    drum.px = -side * before;
    drum.pz = drum.rho * (1.0 + (n % 3 - 1) * spread(1e-16, 1e-12)) - 0.5 * fall * before * before;
    if (hypot(drum.px, drum.pz) >= drum.rho) continue;
    drum_check(tally);
  }
  drum_report("drum, apex at the wall", tally, EM_QUARTIC_SURE);
}

/* The weightless limit is approached continuously. */
static void drums_weightless(void **state) {
  (void)state;
  srand48(11);
  for (int n = 0; n < 1000; n++) {
    drum = (struct drum){.rho = 0.07};
    place(sqrt(drand48()) * 0.99);
    aim(1.0, 0.0);
    const double limit = drum_time(EM_QUARTIC_SAFE, INFINITY);
    for (double fall = 1e-30; fall < 1e-3; fall *= 10.0) {
      drum.gz = -fall;
      for (int k = 0; k < EM_QUARTIC_SURE; k++) {
        const double t = drum_time((enum em_quartic)k, INFINITY);
        assert_true(fabs(t - limit) < 2e-2 * fall + 4e-15);
      }
    }
  }
}

static int setup(void **state) {
  (void)state;
  reference_init(&ref);
  return 0;
}

static int teardown(void **state) {
  (void)state;
  reference_clear(&ref);
  mpfr_free_cache();
  return 0;
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(pairs),
      cmocka_unit_test(pairs_grazing),
      cmocka_unit_test(pairs_overlapping),
      cmocka_unit_test(planes),
      cmocka_unit_test(planes_touched),
      cmocka_unit_test(drums_without_gravity),
      cmocka_unit_test(drums_as_in_a_mill),
      cmocka_unit_test(drums_extreme),
      cmocka_unit_test(drums_touched),
      cmocka_unit_test(drums_outside),
      cmocka_unit_test(drums_apex),
      cmocka_unit_test(drums_weightless),
  };
  return cmocka_run_group_tests(tests, setup, teardown);
}
