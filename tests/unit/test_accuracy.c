/* The knobs of accuracy: levels, solvers against each other, and contact times of `reference`
 * against 60 digits: right to 1 ulp. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>
#include <mpfr.h>

#include "eventmill/scene.h"
#include "eventmill/surface_roots.h"
#include "reference.h"

/* test_long_accuracy.c has more of them; shared evenly among pairs, planes, drums and blades. */
#ifndef CASES
#define CASES 10000
#endif

static struct reference ref;
static const struct em_roots best = {.polish = EM_POLISH_QUAD};

static double uniform(double low, double high) {
  return low + (high - low) * drand48();
}

static struct em_vec in_box(double half) {
  return em_vec_make(uniform(-half, half), uniform(-half, half), uniform(-half, half));
}

static void add(int k, double x, double y) {
  mpfr_set_d(ref.x, x, MPFR_RNDN);
  mpfr_mul_d(ref.x, ref.x, y, MPFR_RNDN);
  mpfr_add(ref.a[k], ref.a[k], ref.x, MPFR_RNDN);
}

static void clear(void) {
  for (int k = 0; k <= REFERENCE_DEGREE; k++)
    mpfr_set_zero(ref.a[k], 1);
}

/* How many representable numbers t is away from the truth, which is rounded to nearest. */
static double ulps(double t, double truth) {
  if (t == truth) return 0.0;
  return fabs(t - truth) / (nextafter(truth, INFINITY) - truth);
}

static double worst[4];
static long hits[4];

static void settle(int kind, double t) {
  const double truth = ref.rises ? mpfr_get_d(ref.rise, MPFR_RNDN) : INFINITY;
  if (t == truth) {
    hits[kind] += t < INFINITY;
    return;
  }
  assert_true(t < INFINITY && truth < INFINITY);
  hits[kind]++;
  worst[kind] = fmax(worst[kind], ulps(t, truth));
  assert_true(ulps(t, truth) <= 1.0);
}

static void pairs(void **state) {
  (void)state;
  const struct em_vec none = {0, 0, 0};
  for (int n = 0; n < CASES / 4; n++) {
    const struct em_surface_path a = {in_box(0.01), in_box(3.0), 0.0};
    struct em_surface_path b = {in_box(0.01), in_box(3.0), 0.0};
    const double sigma = 0.005;
    const struct em_vec d = em_vec_sub(b.r, a.r);
    if (n % 8) b.v = em_vec_axpy(b.v, -uniform(300.0, 1000.0), d);
    if (em_vec_norm(d) <= 1.000001 * sigma) continue;
    clear();
    add(0, sigma, sigma);
    const double x[3] = {a.r.x, a.r.y, a.r.z}, y[3] = {b.r.x, b.r.y, b.r.z};
    const double u[3] = {a.v.x, a.v.y, a.v.z}, w[3] = {b.v.x, b.v.y, b.v.z};
    for (int k = 0; k < 3; k++) {
      /* (y − x)(y − x), 2 (y − x)(w − u), (w − u)(w − u), each product exact */
      add(0, -y[k], y[k]), add(0, 2.0 * y[k], x[k]), add(0, -x[k], x[k]);
      add(1, -2.0 * y[k], w[k]), add(1, 2.0 * y[k], u[k]);
      add(1, 2.0 * x[k], w[k]), add(1, -2.0 * x[k], u[k]);
      add(2, -w[k], w[k]), add(2, 2.0 * w[k], u[k]), add(2, -u[k], u[k]);
    }
    reference_solve(&ref, 2, 10.0 * em_vec_norm(d) / em_vec_norm(em_vec_sub(b.v, a.v)));
    settle(0, em_surface_roots_pair(&best, &a, &b, none, none, sigma));
  }
}

static void planes(void **state) {
  (void)state;
  for (int n = 0; n < CASES / 4; n++) {
    const double gap = uniform(1e-6, 0.1), rate = uniform(-3.0, 3.0);
    const double fall = n % 3 == 0 ? 0.0 : uniform(-9.81, 9.81);
    clear();
    add(0, -gap, 1.0), add(1, -rate, 1.0), add(2, -0.5 * fall, 1.0);
    reference_solve(&ref, fall != 0.0 ? 2 : 1, 1e6);
    if (ref.rises && mpfr_get_d(ref.rise, MPFR_RNDN) > 1e5) continue;
    settle(1, em_surface_roots_plane(&best, gap, rate, fall, false));
  }
}

static void drums(void **state) {
  (void)state;
  const double rho = 0.0705;
  for (int n = 0; n < CASES / 4; n++) {
    const double phi = uniform(0.0, 2.0 * M_PI), r = rho * sqrt(drand48()) * 0.9999;
    const struct em_vec p = {r * cos(phi), 0.0, r * sin(phi)}, v = in_box(3.0);
    const struct em_vec g = {0.0, 0.0, n % 2 ? -9.81 : uniform(-20.0, 20.0)};
    const bool touched = n % 4 == 3 && p.x * v.x + p.z * v.z < -1e-3 * rho;
    clear();
    add(0, p.x, p.x), add(0, p.z, p.z), add(0, -rho, rho);
    add(1, 2.0 * p.x, v.x), add(1, 2.0 * p.z, v.z);
    add(2, v.x, v.x), add(2, v.z, v.z), add(2, p.x, g.x), add(2, p.z, g.z);
    add(3, v.x, g.x), add(3, v.z, g.z);
    add(4, 0.25 * g.x, g.x), add(4, 0.25 * g.z, g.z);
    if (touched)
      for (int k = 0; k < 4; k++)
        mpfr_set(ref.a[k], ref.a[k + 1], MPFR_RNDN);
    reference_solve(&ref, touched ? 3 : 4, 10.0);
    settle(2, em_surface_roots_drum(&best, p, v, g, rho, 0.0025, touched, INFINITY));
  }
}

/* ---------------------------------------------------------------- blades */

struct bar {
  struct em_blade blade;
  struct em_vec r, v, g;
  double radius, angle;
};

enum { ROOM = 16 };
static mpfr_t mp[ROOM];

static void dot3(mpfr_t out, mpfr_t frame[3], struct em_vec b, mpfr_t term) {
  mpfr_mul_d(out, frame[0], b.x, MPFR_RNDN);
  mpfr_mul_d(term, frame[1], b.y, MPFR_RNDN);
  mpfr_add(out, out, term, MPFR_RNDN);
  mpfr_mul_d(term, frame[2], b.z, MPFR_RNDN);
  mpfr_add(out, out, term, MPFR_RNDN);
}

/* out = a b − c d */
static void cross1(mpfr_t out, double a, double b, double c, double d, mpfr_t term) {
  mpfr_set_d(out, a, MPFR_RNDN);
  mpfr_mul_d(out, out, b, MPFR_RNDN);
  mpfr_set_d(term, c, MPFR_RNDN);
  mpfr_mul_d(term, term, d, MPFR_RNDN);
  mpfr_sub(out, out, term, MPFR_RNDN);
}

/* Distance of the surfaces at time t, into out. */
static void bar_gap(const struct bar *b, mpfr_t out, const mpfr_t t) {
  static mpfr_t frame[3][3], p[3], c[4], term;
  static bool made;
  if (!made) {
    for (int k = 0; k < 3; k++) {
      mpfr_inits2(REFERENCE_BITS, frame[k][0], frame[k][1], frame[k][2], p[k], (mpfr_ptr)0);
    }
    mpfr_inits2(REFERENCE_BITS, c[0], c[1], c[2], c[3], term, (mpfr_ptr)0);
    made = true;
  }
  const struct em_vec a = b->blade.axis, e = b->blade.e1;
  mpfr_set_d(frame[0][0], e.x, MPFR_RNDN);
  mpfr_set_d(frame[0][1], e.y, MPFR_RNDN);
  mpfr_set_d(frame[0][2], e.z, MPFR_RNDN);
  cross1(frame[1][0], a.y, e.z, a.z, e.y, term);
  cross1(frame[1][1], a.z, e.x, a.x, e.z, term);
  cross1(frame[1][2], a.x, e.y, a.y, e.x, term);
  mpfr_set_d(frame[2][0], a.x, MPFR_RNDN);
  mpfr_set_d(frame[2][1], a.y, MPFR_RNDN);
  mpfr_set_d(frame[2][2], a.z, MPFR_RNDN);
  for (int k = 0; k < 3; k++) { /* p = (r − c) + t (v + t g / 2) */
    dot3(p[k], frame[k], b->g, term);
    mpfr_div_2ui(p[k], p[k], 1, MPFR_RNDN);
    mpfr_mul(p[k], p[k], t, MPFR_RNDN);
    dot3(c[0], frame[k], b->v, term);
    mpfr_add(p[k], p[k], c[0], MPFR_RNDN);
    mpfr_mul(p[k], p[k], t, MPFR_RNDN);
    dot3(c[0], frame[k], b->r, term);
    mpfr_add(p[k], p[k], c[0], MPFR_RNDN);
    dot3(c[0], frame[k], b->blade.centre, term);
    mpfr_sub(p[k], p[k], c[0], MPFR_RNDN);
  }
  mpfr_mul_d(c[0], t, b->blade.omega, MPFR_RNDN);
  mpfr_add_d(c[0], c[0], b->angle, MPFR_RNDN);
  mpfr_sin_cos(c[0], c[1], c[0], MPFR_RNDN);
  mpfr_mul(c[2], p[0], c[1], MPFR_RNDN);
  mpfr_mul(term, p[1], c[0], MPFR_RNDN);
  mpfr_add(c[2], c[2], term, MPFR_RNDN); /* x */
  mpfr_abs(c[2], c[2], MPFR_RNDN);
  mpfr_mul(c[3], p[1], c[1], MPFR_RNDN);
  mpfr_mul(term, p[0], c[0], MPFR_RNDN);
  mpfr_sub(c[3], c[3], term, MPFR_RNDN);   /* z */
  mpfr_hypot(c[3], c[3], p[2], MPFR_RNDN); /* ρ */
  const bool round = b->blade.tip == EM_TIP_HEMISPHERE, endless = b->blade.tip == EM_TIP_NONE;
  mpfr_set_d(c[0], b->blade.reach, MPFR_RNDN);
  if (round) mpfr_sub_d(c[0], c[0], b->blade.radius, MPFR_RNDN);
  mpfr_sub(c[2], c[2], c[0], MPFR_RNDN); /* beyond the end */
  if (!round) mpfr_sub_d(c[3], c[3], b->blade.radius, MPFR_RNDN);
  if (endless || (mpfr_sgn(c[2]) <= 0 && (round || mpfr_cmp(c[3], c[2]) > 0)))
    mpfr_set(out, c[3], MPFR_RNDN);
  else if (mpfr_sgn(c[3]) <= 0)
    mpfr_set(out, c[2], MPFR_RNDN);
  else
    mpfr_hypot(out, c[2], c[3], MPFR_RNDN);
  mpfr_sub_d(out, out, b->radius, MPFR_RNDN);
  if (round) mpfr_sub_d(out, out, b->blade.radius, MPFR_RNDN);
}

/* The root between low and high, whose gaps differ in sign: Illinois's secants. */
static void bar_root(const struct bar *b, mpfr_t low, mpfr_t high, mpfr_t root) {
  bar_gap(b, mp[2], low);
  bar_gap(b, mp[3], high);
  for (int step = 0; step < 400; step++) {
    mpfr_sub(mp[4], high, low, MPFR_RNDN);
    mpfr_sub(mp[5], mp[3], mp[2], MPFR_RNDN);
    mpfr_div(mp[4], mp[4], mp[5], MPFR_RNDN);
    mpfr_mul(mp[4], mp[4], mp[2], MPFR_RNDN);
    mpfr_sub(root, low, mp[4], MPFR_RNDN);
    bar_gap(b, mp[6], root);
    if (mpfr_zero_p(mp[6]) || mpfr_get_exp(mp[6]) < -170) return;
    if (mpfr_sgn(mp[6]) == mpfr_sgn(mp[3])) {
      mpfr_set(high, root, MPFR_RNDN);
      mpfr_set(mp[3], mp[6], MPFR_RNDN);
      mpfr_div_2ui(mp[2], mp[2], 1, MPFR_RNDN);
    } else {
      mpfr_set(low, root, MPFR_RNDN);
      mpfr_set(mp[2], mp[6], MPFR_RNDN);
      mpfr_div_2ui(mp[3], mp[3], 1, MPFR_RNDN);
    }
  }
}

/* That the search finds the first contact is shown in test_surface_blade.c; here the contact that
 * it finds is held against the sign change next to it. */
static void blades(void **state) {
  (void)state;
  for (int k = 0; k < ROOM; k++)
    mpfr_init2(mp[k], REFERENCE_BITS);
  long tries = 0;
  while (hits[3] < CASES / 4 && tries++ < 20L * CASES) {
    struct bar b = {.blade = {.centre = {0.0, 0.0675, 0.0},
                              .axis = {0.0, 1.0, 0.0},
                              .e1 = {0.0, 0.0, 1.0},
                              .omega = uniform(-200.0, 200.0),
                              .radius = 0.006,
                              .reach = 0.058,
                              .tip = (enum em_tip)(tries % EM_TIP_COUNT)},
                    .v = in_box(3.0),
                    .g = {0.0, 0.0, -9.81},
                    .radius = 0.0025,
                    .angle = uniform(-3.0, 3.0)};
    if (tries % 2) b.blade.e1 = em_vec_make(0.6, 0.0, -0.8);
    b.r = em_vec_make(uniform(-0.06, 0.06), 0.0675 + uniform(-0.02, 0.02), uniform(-0.06, 0.06));
    if (em_surface_blade_gap(&b.blade, b.r, b.radius, b.angle) < 1e-5) continue;
    const double t = em_surface_roots_blade(&best, &b.blade, b.r, b.v, b.g, b.radius, b.angle,
                                            false, 0.02, NULL);
    if (!(t < INFINITY)) continue;
    mpfr_set_d(mp[0], t * (1.0 - 1e-6), MPFR_RNDN);
    mpfr_set_d(mp[1], t * (1.0 + 1e-6), MPFR_RNDN);
    bar_gap(&b, mp[2], mp[0]);
    bar_gap(&b, mp[3], mp[1]);
    if (mpfr_sgn(mp[2]) <= 0 || mpfr_sgn(mp[3]) >= 0) continue; /* grazing, or past the end */
    bar_root(&b, mp[0], mp[1], mp[7]);
    const double truth = mpfr_get_d(mp[7], MPFR_RNDN);
    worst[3] = fmax(worst[3], ulps(t, truth));
    assert_true(ulps(t, truth) <= 1.0);
    hits[3]++;
  }
  assert_true(hits[3] >= CASES / 4);
  for (int k = 0; k < ROOM; k++)
    mpfr_clear(mp[k]);
  static const char *const names[] = {"pairs", "planes", "drums", "blades"};
  for (int k = 0; k < 4; k++) {
    printf("  reference, %-7s %7ld contacts, at most %.2f ulp off\n", names[k], hits[k], worst[k]);
    assert_true(hits[k] > CASES / 40);
  }
}

/* ---------------------------------------------------------------- levels */

static struct em_scene *scene_with(const char *override) {
  struct em_scene *scene = NULL;
  struct em_error err = {0};
  const char *overrides[1] = {override};
  assert_int_equal(em_scene_parse(&scene,
                                  "chamber = { shape = \"drum\"; diameter = 0.1; length = 0.1; };"
                                  "balls = { count = 3; diameter = 0.01; };",
                                  "t.cfg", override ? 1 : 0, overrides, &err),
                   EM_OK);
  return scene;
}

static void levels_set_what_the_scene_does_not(void **state) {
  (void)state;
  struct em_scene *s = scene_with("engine.accuracy=fast");
  assert_true(s->engine.roots.tolerance == 1e-6 && s->engine.roots.polish == EM_POLISH_NONE);
  em_scene_free(s);
  s = scene_with("engine={accuracy=\"fast\";tolerance=0.0;}");
  assert_true(s->engine.roots.tolerance == 0.0);
  char *text = em_scene_text(s);
  struct em_scene *again = NULL;
  struct em_error err = {0};
  assert_int_equal(em_scene_parse(&again, text, "again.cfg", 0, NULL, &err), EM_OK);
  assert_true(again->engine.roots.tolerance == 0.0);
  em_scene_free(again);
  free(text);
  em_scene_free(s);
  s = scene_with("engine.accuracy=reference");
  assert_true(s->engine.roots.tolerance == 0.0 && s->engine.roots.polish == EM_POLISH_QUAD);
  em_scene_free(s);
  s = scene_with(NULL);
  assert_false(em_surface_roots_special(&s->engine.roots));
  assert_int_equal(s->engine.roots.quartic, EM_QUARTIC_SAFE);
  em_scene_free(s);
}

/* Early by at most the tolerance, never late. */
static void tolerance_holds(void **state) {
  (void)state;
  const double rho = 0.0705, radius = 0.0025;
  for (int n = 0; n < 5000; n++) {
    const struct em_roots how = {.tolerance = pow(10.0, uniform(-9.0, -2.0))};
    const double phi = uniform(0.0, 2.0 * M_PI), r = rho * sqrt(drand48()) * 0.9;
    const struct em_vec p = {r * cos(phi), 0.0, r * sin(phi)}, v = in_box(3.0);
    const struct em_vec g = {0.0, 0.0, -9.81};
    const double t = em_surface_roots_drum(&how, p, v, g, rho, radius, false, INFINITY);
    const double sure = em_surface_roots_drum(&best, p, v, g, rho, radius, false, INFINITY);
    const double x = p.x + v.x * t, z = p.z + (v.z + 0.5 * g.z * t) * t;
    assert_true(t <= sure * (1.0 + 1e-12));
    assert_true(rho - hypot(x, z) <= how.tolerance * 2.0 * radius * 1.0001 + 1e-15);
  }
}

/* All solvers find most contacts; those that are sure find every one. */
static void solvers_agree(void **state) {
  (void)state;
  const double rho = 0.0705;
  long missed[EM_QUARTIC_COUNT] = {0};
  for (int n = 0; n < 5000; n++) {
    const double phi = uniform(0.0, 2.0 * M_PI), r = rho * sqrt(drand48()) * 0.99;
    const struct em_vec p = {r * cos(phi), 0.0, r * sin(phi)}, v = in_box(3.0);
    const double sure =
        em_surface_drum(p.x, p.z, v.x, v.z, 0.0, -9.81, rho, false, EM_QUARTIC_SAFE, INFINITY);
    for (int k = 0; k < EM_QUARTIC_COUNT; k++) {
      const double t =
          em_surface_drum(p.x, p.z, v.x, v.z, 0.0, -9.81, rho, false, (enum em_quartic)k, INFINITY);
      missed[k] += !(fabs(t - sure) <= 1e-6 * sure);
    }
  }
  for (int k = 0; k < EM_QUARTIC_COUNT; k++)
    assert_true(missed[k] <= (k < EM_QUARTIC_SURE ? 0 : 5));
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(pairs),
      cmocka_unit_test(planes),
      cmocka_unit_test(drums),
      cmocka_unit_test(blades),
      cmocka_unit_test(tolerance_holds),
      cmocka_unit_test(solvers_agree),
      cmocka_unit_test(levels_set_what_the_scene_does_not),
  };
  srand48(7);
  reference_init(&ref);
  const int failed = cmocka_run_group_tests(tests, NULL, NULL);
  reference_clear(&ref);
  return failed;
}
