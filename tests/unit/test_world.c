/* What a world takes from whoever makes and leads it. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

#include "event/body.h"
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

struct apart {
  struct em_world *world;
  double most; /* m, between surfaces at contacts of the balls */
};

static void measure(void *self, const struct em_contact *contact) {
  struct apart *a = self;
  const struct em_body *b = a->world->body;
  if (contact->cls != EM_CLASS_BALL) return;
  const struct em_vec d = {b[0].x - b[1].x, b[0].y - b[1].y, b[0].z - b[1].z};
  a->most = fmax(a->most, fabs(em_vec_norm(d) - b[0].radius - b[1].radius));
}

/* Balls that have just missed each other go on apart when times are moved back, and are rounded. */
static void test_past_grazes(void **state) {
  (void)state;
  static const char *const engines[] = {"", "engine.simd=false", "engine.lists=all"};
  const double d = 0.015625;
  uint64_t seed = 3;
  for (size_t k = 0; k < 3000; k++) {
    struct trial t;
    struct apart apart = {NULL, 0.0};
    trial_scene(&t,
                "gravity=\"none\";chamber={shape=\"box\";size=[1.28,1.28,1.28];};"
                "contact={rule=\"smooth\";normal=1.0;};balls={count=2;diameter=0.015625;};",
                "%s", engines[k % 3]);
    trial_balls(&t);
    t.balls->position[0] = em_vec_make(dice_in(&seed, 0.02, 0.05), 0.64, 0.64);
    t.balls->velocity[0] = em_vec_make(-dice_in(&seed, 0.5, 1.0), 0.0, 0.0);
    t.balls->position[1] = em_vec_make(dice_in(&seed, 0.2, 0.3), 0.64 + d, 0.64);
    t.balls->velocity[1] = em_vec_make(-dice_in(&seed, 0.05, 0.1), 0.0, 0.0);
    trial_world(&t);
    apart.world = t.world;
    const struct em_observer observer = {.self = &apart, .contact = measure};
    assert_int_equal(em_world_observe(t.world, &observer), EM_OK);
    trial_run(&t, 1.05 * t.world->epoch_length);
    assert_true(apart.most < 1e-12 * d);
    trial_free(&t);
  }
}

/* A ball's first contact is the first in a row, however soon it comes. */
static void test_first_in_a_row(void **state) {
  (void)state;
  struct trial t;
  trial_scene(&t, two_kinds, "%s",
              "contact.rule=rough contact.tangential=0.5 remedy.jam_after=1 remedy.jam_within=1");
  trial_balls(&t);
  for (size_t i = 0; i < t.balls->count; i++)
    t.balls->velocity[i] = em_vec_make(0.0, 0.0, 0.0);
  t.balls->velocity[0] = em_vec_make(1.0, 2.0, 3.0);
  trial_world(&t);
  trial_collide(&t, 1);
  assert_int_equal(em_world_tally(t.world)->jam, 0);
  trial_run(&t, 0.5);
  assert_true(em_world_tally(t.world)->jam > 0);
  trial_free(&t);
}

/* Balls that come to rest touch without approach, by rounding even parting: no case for a remedy
 * that is off. */
static void test_remedy_off(void **state) {
  (void)state;
  for (int seed = 1; seed <= 20; seed++) {
    struct trial t;
    trial_open(&t,
               "gravity=[0.3,-0.2,-9.81];chamber={shape=\"box\";size=[0.06,0.05,0.04];};"
               "contact={rule=\"rough\";normal=0.5;};balls={count=1;diameter=0.005;};"
               "remedy={tc=1e-300;};",
               "seed=%d", seed);
    assert_int_equal(em_world_run_collisions(t.world, INFINITY, 500, NULL, &t.err), EM_OK);
    assert_int_equal(em_world_tally(t.world)->elastic, 0);
    trial_free(&t);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_foreign_balls),  cmocka_unit_test(test_no_time),
      cmocka_unit_test(test_no_events),      cmocka_unit_test(test_past_grazes),
      cmocka_unit_test(test_first_in_a_row), cmocka_unit_test(test_remedy_off),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
