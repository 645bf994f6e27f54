/* The knobs of accuracy: levels, tolerances, solvers against each other. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "eventmill/scene.h"
#include "eventmill/surface_roots.h"

static const struct em_roots best = {.polish = EM_POLISH_QUAD};

static double uniform(double low, double high) {
  return low + (high - low) * drand48();
}

static struct em_vec in_box(double half) {
  return em_vec_make(uniform(-half, half), uniform(-half, half), uniform(-half, half));
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

/* A scene printed in full says what its level means, and still takes another. */
static void printed_scenes_take_another_level(void **state) {
  (void)state;
  static const char *const other[] = {"engine.accuracy=reference"};
  struct em_scene *s = scene_with("engine.tolerance=1e-4"), *again = NULL;
  struct em_error err = {0};
  char *text = em_scene_text(s);
  assert_non_null(strstr(text, "# polish = \"none\";"));
  assert_int_equal(em_scene_parse(&again, text, "again.cfg", 1, other, &err), EM_OK);
  assert_int_equal(again->engine.roots.polish, EM_POLISH_QUAD);
  assert_true(again->engine.roots.tolerance == 1e-4);
  em_scene_free(again);
  free(text);
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

/* A contact is found with each horizon that is not before it, to the same bits, and with no other.
 */
static void horizons_decide_nothing(void **state) {
  (void)state;
  static const struct em_roots knobs[] = {{.tolerance = 0.0},
                                          {.tolerance = 1e-3},
                                          {.polish = EM_POLISH_EXTENDED, .tolerance = 1e-6},
                                          {.polish = EM_POLISH_QUAD}};
  const double rho = 0.0705, radius = 0.0025;
  const struct em_vec g = {0.0, 0.0, -9.81};
  for (int n = 0; n < 2000; n++) {
    const struct em_roots *how = &knobs[n % 4];
    const bool touched = n % 3 == 0;
    const double phi = uniform(0.0, 2.0 * M_PI), r = touched ? rho : rho * sqrt(drand48()) * 0.9;
    const struct em_vec p = {r * cos(phi), 0.0, r * sin(phi)}, any = in_box(3.0);
    const bool out = p.x * any.x + p.z * any.z > 0.0;
    const struct em_vec v = touched && out ? em_vec_scale(-1.0, any) : any;
    const struct em_blade blade = {.axis = {0.0, 1.0, 0.0},
                                   .e1 = {0.0, 0.0, 1.0},
                                   .omega = uniform(-200.0, 200.0),
                                   .radius = 0.006,
                                   .reach = 0.058,
                                   .tip = (enum em_tip)(n % EM_TIP_COUNT)};
    const double wall = em_surface_roots_drum(how, p, v, g, rho, radius, touched, INFINITY);
    const double bar = em_surface_roots_blade(how, &blade, p, v, g, radius, 0.3, false, 0.3, NULL);
    for (int k = 0; k < 4; k++) {
      const double share = k == 0 ? 1.0 : k == 1 ? 1.0 - 3e-16 : uniform(0.99, 1.01);
      double h = share * wall;
      double t = em_surface_roots_drum(how, p, v, g, rho, radius, touched, h);
      assert_true(t == (wall <= h ? wall : INFINITY));
      h = share * (bar < INFINITY ? bar : 0.29);
      t = em_surface_roots_blade(how, &blade, p, v, g, radius, 0.3, false, h, NULL);
      assert_true(t == (bar <= h ? bar : INFINITY));
    }
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
      cmocka_unit_test(tolerance_holds),
      cmocka_unit_test(solvers_agree),
      cmocka_unit_test(horizons_decide_nothing),
      cmocka_unit_test(levels_set_what_the_scene_does_not),
      cmocka_unit_test(printed_scenes_take_another_level),
  };
  srand48(7);
  return cmocka_run_group_tests(tests, NULL, NULL);
}
