/* No ball is ever outside, none in another, no blade is entered: looked at in many moments. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "support/trial.h"

#ifdef LONG_FORM
enum { MOMENTS = 2000, EACH = 500 };
#else
enum { MOMENTS = 60, EACH = 250 };
#endif

static void watch(const char *scene, const char *overrides) {
  struct trial t;
  trial_open(&t, scene, "%s", overrides);
  double smallest = INFINITY;
  for (size_t i = 0; i < t.balls->count; i++)
    smallest = fmin(smallest, t.balls->radius[i]);
  const double tolerance = 1e-12 * 2.0 * smallest;
  uint64_t seed = 3;
  trial_valid(&t, tolerance);
  for (int k = 0; k < MOMENTS; k++) {
    trial_collide(&t, EACH + dice_bits(&seed) % EACH);
    trial_valid(&t, tolerance);
    /* Between two events as well. */
    const double mean = em_world_time(t.world) / (double)em_world_collisions(t.world);
    trial_run(&t, em_world_time(t.world) + dice(&seed) * mean);
    trial_valid(&t, tolerance);
  }
  trial_free(&t);
}

#define MILL "geometries/simoloyer-2l.cfg"

static void test_speeds(void **state) {
  (void)state;
  watch(MILL, "rotor.rpm=800");
  watch(MILL, "rotor.rpm=1300");
  watch(MILL, "rotor.rpm=1700");
  watch(MILL, "rotor.rpm=2000");
  watch(MILL, "rotor.rpm=-2000");
}

static void test_rules(void **state) {
  (void)state;
  watch(MILL, "rotor.rpm=1700 contact.rule=reichardt2005");
  watch(MILL, "rotor.rpm=1700 contact.rule=friction contact.friction=0.3");
  watch(MILL, "rotor.rpm=1700 contact.rule=smooth");
  watch(MILL, "rotor.rpm=1700 contact.tangential=-1.0");
}

static void test_tips(void **state) {
  (void)state;
  watch(MILL, "rotor.rpm=1700 rotor.tip=hemisphere");
  watch(MILL, "rotor.rpm=1700 rotor.tip=none contact.rule=reichardt2005");
}

static void test_others(void **state) {
  (void)state;
  watch("geometries/two-rotors.cfg", "balls.count=2000");
  watch("geometries/ideal-gas-gravity.cfg", "");
  watch("geometries/ideal-gas-gravity.cfg", "engine.quartic=ferrari+newton");
  watch("geometries/ideal-gas-gravity.cfg", "engine.quartic=bracket");
  watch("geometries/ideal-gas.cfg", "balls.count=3500");
}

/* A ball that falls into a corner of facets meets both of them. */
static void test_corner(void **state) {
  (void)state;
  struct trial t;
  trial_open(&t,
             "gravity = [9.81, 0.0, 0.0]; contact = { rule = \"smooth\"; normal = 0.9; };"
             "chamber = { shape = \"drum\"; diameter = 0.1; length = 0.05; facets = 6; };"
             "balls = { diameter = 0.01; start = \"table\";"
             "  table = ( (0.0, 0.025, 0.0, 0.0, 0.0, 0.0) ); };"
             "remedy = { elastic_below = 0.001; };",
             "%s", "");
  trial_run(&t, 2.0);
  trial_valid(&t, 1e-14);
  assert_true(em_world_collisions(t.world) > 20);
  trial_free(&t);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_speeds), cmocka_unit_test(test_rules),  cmocka_unit_test(test_tips),
      cmocka_unit_test(test_others), cmocka_unit_test(test_corner),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
