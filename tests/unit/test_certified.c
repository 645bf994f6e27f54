/* Contact times of the level `reference` are the first contacts to 1 ulp, in 60 digits, with a
 * certificate for each; where it finds none, there is none. */
#include <float.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

#include "certify.h"
#include "certify_blade.h"
#include "eventmill/surface_roots.h"

/* Contacts of each kind; test_long_certified.c has more of them. */
#ifndef CASES
#define CASES 5000
#endif

/* The levels reference and standard. */
static const struct em_roots best = {.polish = EM_POLISH_QUAD}, usual = {.polish = EM_POLISH_NONE};
static struct certify sure;
static struct certify_bar bar;

static double uniform(double low, double high) {
  return low + (high - low) * drand48();
}

static double spread(double low, double high) {
  return low * pow(high / low, drand48());
}

static struct em_vec in_box(double half) {
  return em_vec_make(uniform(-half, half), uniform(-half, half), uniform(-half, half));
}

/* ---------------------------------------------------------------- what is counted */

struct tally {
  long contacts, none, rounded; /* rounded: to the nearest double */
  double worst;                 /* ulp */
  double usual;                 /* s by which `standard` differs at most */
};

static void tell(const char *name, const struct tally *tally) {
  printf("  %-8s %8ld contacts, %8ld flights without; at most %.4f ulp off, %.4f %% not the "
         "nearest\n",
         name, tally->contacts, tally->none, tally->worst,
         100.0 * (1.0 - (double)tally->rounded / (double)tally->contacts));
  if (tally->usual > 0.0)
    printf("  %-8s standard: none missed, none invented; at most %.2g s away\n", "", tally->usual);
}

/* The level standard finds the same contact, or none as well; `doubt`: s that the rounding of the
 * ball's place makes. */
static void hold_usual(struct tally *tally, double t, double truth, double doubt) {
  assert_true((t < INFINITY) == (truth < INFINITY));
  if (t == truth) return;
  assert_true(fabs(t - truth) <= 1e-6 * truth + 1e-14 + doubt);
  tally->usual = fmax(tally->usual, fabs(t - truth));
}

/* Gaps at t and its neighbours. */
static void settle(struct tally *tally, double low, double here, double high, double t) {
  const double off = certify_ulps(low, here, high, t);
  assert_true(low * high < 0.0 && off <= 1.0);
  tally->worst = fmax(tally->worst, off);
  tally->rounded += off <= 0.5;
  tally->contacts++;
}

/* t against the first root of the polynomial up to the horizon. */
static void settle_root(struct tally *tally, double t, double horizon) {
  if (t == INFINITY) {
    assert_true(certify_is_clear(&sure, horizon));
    tally->none++;
    return;
  }
  double gap[3];
  for (int k = 0; k < 3; k++) {
    const double at = k == 0 ? nextafter(t, -INFINITY) : k == 1 ? t : nextafter(t, INFINITY);
    certify_value(&sure, at);
    gap[k] = mpfr_get_d(sure.y, MPFR_RNDN);
  }
  settle(tally, gap[0], gap[1], gap[2], t);
  assert_true(gap[0] < 0.0 && certify_is_clear(&sure, nextafter(t, -INFINITY)));
  assert_false(certify_is_clear(&sure, nextafter(t, INFINITY)));
}

/* ---------------------------------------------------------------- pairs */

/* x[0] + x[1] t = b's place less a's along one axis, from the later of their times. */
static void relative(mpfr_t x[2], const double *r, const double *v, const double *t, double g,
                     double later) {
  mpfr_t since, fall;
  mpfr_inits2(CERTIFY_BITS, since, fall, (mpfr_ptr)0);
  mpfr_set_zero(x[0], 1);
  mpfr_set_zero(x[1], 1);
  for (int ball = 1; ball >= 0; ball--) {
    mpfr_set_d(since, later, MPFR_RNDN);
    mpfr_sub_d(since, since, t[ball], MPFR_RNDN);
    mpfr_mul_d(fall, since, g, MPFR_RNDN);
    mpfr_add_d(x[1], x[1], v[ball], MPFR_RNDN);
    mpfr_add(x[1], x[1], fall, MPFR_RNDN);
    mpfr_div_2ui(fall, fall, 1, MPFR_RNDN);
    mpfr_add_d(fall, fall, v[ball], MPFR_RNDN);
    mpfr_mul(fall, fall, since, MPFR_RNDN);
    mpfr_add_d(x[0], x[0], r[ball], MPFR_RNDN);
    mpfr_add(x[0], x[0], fall, MPFR_RNDN);
    if (ball == 1) {
      mpfr_neg(x[0], x[0], MPFR_RNDN);
      mpfr_neg(x[1], x[1], MPFR_RNDN);
    }
  }
  mpfr_neg(x[0], x[0], MPFR_RNDN);
  mpfr_neg(x[1], x[1], MPFR_RNDN);
  mpfr_clears(since, fall, (mpfr_ptr)0);
}

/* σ² − |d + u t|² */
static void pair_polynomial(const struct em_surface_path *p, struct em_vec g, double sigma) {
  const double *const r[2] = {&p[0].r.x, &p[1].r.x}, *const v[2] = {&p[0].v.x, &p[1].v.x};
  const double t[2] = {p[0].t, p[1].t}, fall[3] = {g.x, g.y, g.z}, later = fmax(t[0], t[1]);
  mpfr_t x[2];
  mpfr_inits2(CERTIFY_BITS, x[0], x[1], (mpfr_ptr)0);
  certify_begin(&sure, 2);
  sure.origin = later;
  certify_add(&sure, 0, sigma, sigma);
  for (int k = 0; k < 3; k++) {
    relative(x, (double[]){r[0][k], r[1][k]}, (double[]){v[0][k], v[1][k]}, t, fall[k], later);
    for (int i = 0; i < 2; i++)
      for (int j = 0; j < 2; j++) {
        mpfr_mul(sure.term, x[i], x[j], MPFR_RNDN);
        mpfr_sub(sure.a[i + j], sure.a[i + j], sure.term, MPFR_RNDN);
      }
  }
  mpfr_clears(x[0], x[1], (mpfr_ptr)0);
}

static void pairs(void **state) {
  (void)state;
  struct tally tally = {0};
  const struct em_vec none = {0, 0, 0};
  while (tally.contacts < CASES) {
    struct em_surface_path p[2];
    const bool fall = drand48() < 0.5, early = drand48() < 0.5;
    const struct em_vec g = fall ? in_box(9.81) : none;
    for (int k = 0; k < 2; k++)
      p[k] = (struct em_surface_path){in_box(0.01), in_box(3.0), early ? uniform(0.0, 0.01) : 0.0};
    const double sigma = spread(0.001, 0.01);
    const struct em_vec d = em_vec_sub(p[1].r, p[0].r);
    p[1].v = em_vec_axpy(p[1].v, -uniform(0.0, 1000.0), d);
    pair_polynomial(p, g, sigma);
    if (mpfr_sgn(sure.a[0]) > 0) continue; /* they overlap */
    settle_root(&tally, em_surface_roots_pair(&best, &p[0], &p[1], g, none, sigma), 10.0);
  }
  tell("pairs", &tally);
}

/* ---------------------------------------------------------------- planes and drums */

static void planes(void **state) {
  (void)state;
  struct tally tally = {0};
  while (tally.contacts < CASES) {
    const double gap = spread(1e-9, 0.1), rate = uniform(-3.0, 3.0);
    const double fall = drand48() < 0.3 ? 0.0 : uniform(-9.81, 9.81);
    certify_begin(&sure, 2);
    certify_add(&sure, 0, -gap, 1.0);
    certify_add(&sure, 1, -rate, 1.0);
    certify_add(&sure, 2, -0.5 * fall, 1.0);
    const double t = em_surface_roots_plane(&best, gap, rate, fall, false);
    settle_root(&tally, t, 1e3);
    hold_usual(&tally, em_surface_roots_plane(&usual, gap, rate, fall, false), t, 0.0);
  }
  tell("planes", &tally);
}

/* Who grazes the drum is long as near to it as the rounding of its place; but not that long. */
static double grazing_doubt(struct em_vec r, struct em_vec v, struct em_vec g, double rho,
                            double t) {
  if (t == INFINITY) return 0.0;
  const struct em_vec at = em_vec_axpy(em_vec_axpy(r, t, v), 0.5 * t * t, g);
  return fmin(1e-12, fabs(DBL_EPSILON * rho * rho / em_vec_dot(at, em_vec_axpy(v, t, g))));
}

static void drums(void **state) {
  (void)state;
  struct tally tally = {0};
  while (tally.contacts < CASES) {
    const double rho = spread(0.05, 0.2), phi = uniform(0.0, 2.0 * M_PI);
    const double r = rho * (drand48() < 0.5 ? sqrt(drand48()) : 1.0 - spread(1e-12, 0.1));
    const struct em_vec p = {r * cos(phi), 0.0, r * sin(phi)}, v = in_box(3.0);
    const double fall = drand48() < 0.2 ? 0.0 : uniform(-20.0, 20.0);
    const struct em_vec g = {drand48() < 0.5 ? 0.0 : 0.3 * fall, 0.0, fall};
    const bool touched = drand48() < 0.3 && p.x * v.x + p.z * v.z < -1e-3 * rho;
    certify_begin(&sure, 4);
    certify_add(&sure, 0, p.x, p.x), certify_add(&sure, 0, p.z, p.z);
    certify_add(&sure, 0, -rho, rho);
    certify_add(&sure, 1, 2.0 * p.x, v.x), certify_add(&sure, 1, 2.0 * p.z, v.z);
    certify_add(&sure, 2, v.x, v.x), certify_add(&sure, 2, v.z, v.z);
    certify_add(&sure, 2, p.x, g.x), certify_add(&sure, 2, p.z, g.z);
    certify_add(&sure, 3, v.x, g.x), certify_add(&sure, 3, v.z, g.z);
    certify_add(&sure, 4, 0.25 * g.x, g.x), certify_add(&sure, 4, 0.25 * g.z, g.z);
    if (mpfr_sgn(sure.a[0]) >= 0) continue; /* in the wall by rounding */
    if (touched) {                          /* the root at 0 is no event: t divides out */
      for (int k = 0; k < 4; k++)
        mpfr_set(sure.a[k], sure.a[k + 1], MPFR_RNDN);
      sure.degree = 3;
    }
    const double t = em_surface_roots_drum(&best, p, v, g, rho, 0.0025, touched, INFINITY);
    settle_root(&tally, t, 10.0);
    hold_usual(&tally, em_surface_roots_drum(&usual, p, v, g, rho, 0.0025, touched, INFINITY), t,
               grazing_doubt(p, v, g, rho, t));
  }
  tell("drums", &tally);
}

/* ---------------------------------------------------------------- blades */

static const double HORIZON = 0.02; /* s */

static void throw_ball(long number) {
  bar.blade = (struct em_blade){.centre = {0.0, 0.0675, 0.0},
                                .axis = {0.0, 1.0, 0.0},
                                .e1 = {0.0, 0.0, 1.0},
                                .omega = drand48() < 0.1 ? 0.0 : uniform(-200.0, 200.0),
                                .radius = spread(0.002, 0.01),
                                .reach = uniform(0.02, 0.07),
                                .tip = (enum em_tip)(number % EM_TIP_COUNT)};
  if (number % 2) bar.blade.e1 = em_vec_make(0.6, 0.0, -0.8);
  if (number % 4 == 1) bar.blade.axis = em_vec_make(0.48, 0.8, 0.36);
  bar.v = in_box(3.0);
  bar.g = number % 7 ? em_vec_make(0.0, 0.0, -9.81) : in_box(9.81);
  bar.radius = spread(0.0005, 0.01);
  bar.angle = uniform(-3.0, 3.0);
  bar.r = em_vec_make(uniform(-0.06, 0.06), 0.0675 + uniform(-0.02, 0.02), uniform(-0.06, 0.06));
  bar.touched = false;
}

/* The ball that has flown for t bounces off the blade. */
static void bounce(double t) {
  const struct em_vec r = em_vec_axpy(em_vec_axpy(bar.r, t, bar.v), 0.5 * t * t, bar.g);
  const struct em_vec v = em_vec_axpy(bar.v, t, bar.g);
  bar.angle += bar.blade.omega * t;
  const struct em_vec n = em_surface_blade_normal(&bar.blade, r, bar.angle);
  const struct em_vec foot = em_vec_axpy(r, -bar.radius, n);
  const double vn = em_vec_dot(n, em_vec_sub(v, em_surface_blade_velocity(&bar.blade, foot)));
  bar.r = r;
  bar.v = em_vec_axpy(v, -1.9 * vn, n);
  bar.touched = vn < -1e-2;
}

static double search(const struct em_roots *how) {
  return em_surface_roots_blade(how, &bar.blade, bar.r, bar.v, bar.g, bar.radius, bar.angle,
                                bar.touched, HORIZON, NULL);
}

static double fly(struct tally *tally) {
  const double t = search(&best);
  hold_usual(tally, search(&usual), t, 0.0);
  if (t < INFINITY) {
    certify_bar_begin(&bar);
    const double low = certify_bar_gap(&bar, nextafter(t, -INFINITY));
    const double here = certify_bar_gap(&bar, t),
                 high = certify_bar_gap(&bar, nextafter(t, INFINITY));
    assert_true(low > 0.0 && high < 0.0);
    settle(tally, low, here, high, t);
    assert_false(certify_walk(&bar, HORIZON, false));
  } else {
    tally->none++;
  }
  assert_true(certify_walk(&bar, t < INFINITY ? t : HORIZON, t < INFINITY));
  return t;
}

static void blades(void **state) {
  (void)state;
  struct tally tally = {0};
  for (long number = 0; tally.contacts < CASES; number++) {
    throw_ball(number);
    if (em_surface_blade_gap(&bar.blade, bar.r, bar.radius, bar.angle) < 1e-5) continue;
    const double t = fly(&tally);
    if (t == INFINITY) continue;
    bounce(t);
    if (bar.touched) (void)fly(&tally);
  }
  tell("blades", &tally);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(pairs),
      cmocka_unit_test(planes),
      cmocka_unit_test(drums),
      cmocka_unit_test(blades),
  };
  srand48(7);
  certify_init(&sure);
  certify_bar_init(&bar);
  const int failed = cmocka_run_group_tests(tests, NULL, NULL);
  certify_clear(&sure);
  certify_bar_clear(&bar);
  return failed;
}
