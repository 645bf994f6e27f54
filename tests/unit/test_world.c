/* What a world takes from whoever makes and leads it. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

#include "support/trial.h"

static const char two_kinds[] =
    "chamber = { shape = \"box\"; size = [0.1, 0.1, 0.1]; }; gravity = \"none\";"
    "balls = ( { name = \"large\"; count = 3; diameter = 0.01; },"
    "          { name = \"small\"; count = 4; diameter = 0.005; } );"
    "contact = { rule = \"smooth\"; normal = 1.0; };";

static void refused(struct trial *t, const char *why) {
  assert_int_equal(em_world_new(&t->world, t->scene, t->balls, &t->err), EM_INPUT);
  if (!strstr(t->err.text, why)) fail_msg("%s", t->err.text);
}

/* Masses, spins and periods are worked out from the scene: other balls than its own have no place
 * in it. */
static void test_foreign_balls(void **state) {
  (void)state;
  struct trial t;
  trial_scene(&t, two_kinds, "%s", "");
  trial_balls(&t);
  const double r = t.balls->radius[3], m = t.balls->mass[2];
  t.balls->radius[3] = 0.9 * r;
  refused(&t, "ball 3 has a radius of 0.00225 m");
  t.balls->radius[3] = r;
  t.balls->mass[2] = 1.0;
  refused(&t, "as the species \"large\" has");
  t.balls->mass[2] = m;
  t.balls->count = 6;
  refused(&t, "6 balls, expected the scene's 7");
  t.balls->count = 7;
  trial_world(&t);
  trial_free(&t);
}

static void test_no_time(void **state) {
  (void)state;
  struct trial t;
  trial_open(&t, two_kinds, "%s", "");
  assert_int_equal(em_world_run(t.world, NAN, NULL, &t.err), EM_INPUT);
  assert_true(em_world_time(t.world) == 0.0);
  trial_run(&t, 0.01);
  trial_free(&t);
}

/* Balls at rest have no events: a run without end is over. */
static void test_no_events(void **state) {
  (void)state;
  static const char *const engines[] = {"engine.partition=cells", "engine.partition=neighbours",
                                        "engine.lists=tree engine.partition=slices"};
  for (size_t k = 0; k < sizeof engines / sizeof *engines; k++) {
    struct trial t;
    trial_scene(&t, two_kinds, "%s", engines[k]);
    trial_balls(&t);
    for (size_t i = 0; i < t.balls->count; i++)
      t.balls->velocity[i] = em_vec_make(0.0, 0.0, 0.0);
    trial_world(&t);
    trial_run(&t, INFINITY);
    trial_run(&t, 1.0);
    assert_true(em_world_time(t.world) == 1.0);
    trial_free(&t);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_foreign_balls),
      cmocka_unit_test(test_no_time),
      cmocka_unit_test(test_no_events),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
