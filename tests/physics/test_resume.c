/* A run that was stopped, copied and continued goes on as if nothing had happened, to the last bit,
 * at whatever moment it was stopped and with every effect. */
#include <math.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>
#include <sys/time.h>

#include <cmocka.h>

#include "event/body.h"
#include "support/trial.h"

#define MILL "geometries/simoloyer-2l.cfg"

static void go_on_from(struct trial *t, struct em_snapshot *s) {
  em_world_free(t->world);
  t->world = NULL;
  if (em_world_resume(&t->world, t->scene, s, &t->err)) fail_msg("%s", t->err.text);
  em_world_snapshot_free(s);
}

/* Replaces the world by one made from its snapshot. */
static void restart(struct trial *t) {
  struct em_snapshot *s;
  assert_int_equal(em_world_snapshot(t->world, &s, &t->err), EM_OK);
  go_on_from(t, s);
}

struct after {
  uint64_t trail, state;
};

/* The last part of a run, from the time `from` on; restarts before it at each of `stops`. */
static struct after play(const char *scene, const char *overrides, const double *stop, int stops,
                         double from, double until) {
  struct trial t;
  struct trail trail;
  trial_open(&t, scene, "%s", overrides);
  for (int k = 0; k < stops; k++) {
    trial_run(&t, stop[k]);
    restart(&t);
  }
  trial_run(&t, from);
  trail_watch(&trail, t.world);
  trial_run(&t, until);
  assert_true(trail.count > 50);
  const struct after a = {trail.hash, trail_of_state(t.world)};
  trial_free(&t);
  return a;
}

/* Stops around the changes of epoch, where all times jump, and at random moments. */
static void compare(const char *scene, const char *overrides) {
  struct trial t;
  trial_open(&t, scene, "%s", overrides);
  const double epoch = t.world->epoch_length;
  trial_free(&t);
  const double until = 1.8 * epoch, from = 1.1 * epoch;
  const struct after whole = play(scene, overrides, NULL, 0, from, until);
  double stop[16];
  int stops = 0;
  uint64_t seed = 7;
  stop[stops++] = 0.0;
  double at = 0.0;
  while (stops < 6)
    stop[stops++] = at = dice_in(&seed, at, epoch);
  stop[stops++] = nextafter(epoch, 0.0);
  stop[stops++] = epoch;
  stop[stops++] = nextafter(epoch, INFINITY);
  stop[stops++] = from;
  const struct after parts = play(scene, overrides, stop, stops, from, until);
  if (parts.trail != whole.trail || parts.state != whole.state)
    fail_msg("%s %s: the continued run differs", scene, overrides);
  const struct after straight = play(scene, overrides, NULL, 0, 0.0, until);
  if (straight.state != whole.state) fail_msg("%s %s: a stop changes the run", scene, overrides);
}

static void test_mill(void **state) {
  (void)state;
  compare(MILL, "balls.count=700 rotor.rpm=1700");
  compare(MILL, "balls.count=700 rotor.rpm=800 rotor.tip=hemisphere contact.rule=friction");
  compare(MILL, "balls.count=700 rotor.tip=none contact.rule=reichardt2005");
}

static void test_structures(void **state) {
  (void)state;
  compare(MILL, "balls.count=500 engine.lists=tree engine.partition=cells");
  compare(MILL, "balls.count=500 engine.partition=slices");
  compare(MILL, "balls.count=300 engine.partition=none engine.simd=false");
}

/* Remedies remember how many contacts there were in a row. */
static void test_remedies(void **state) {
  (void)state;
  compare("geometries/ideal-gas-gravity.cfg",
          "balls.count=300 contact.normal=0.8 contact.rule=rough remedy.tc=1e-5");
  compare("geometries/ideal-gas-gravity.cfg",
          "balls.count=300 contact.normal=0.8 remedy.elastic_below=0.01");
  compare("geometries/ideal-gas-gravity.cfg",
          "balls.count=300 contact.normal=0.95 contact.rule=rough chamber.rpm=100");
}

static void test_ramps(void **state) {
  (void)state;
  compare(MILL, "balls.count=500 chamber.ramps.half_deg=10 chamber.ramps.tilt_deg=30");
}

static const char periodic[] =
    "gravity=\"none\";chamber={shape=\"box\";size=[0.05,0.06,0.07];periodic=[true,false,true];};"
    "contact={rule=\"rough\";normal=1.0;tangential=-1.0;};"
    "balls=({name=\"a\";count=500;diameter=0.005;},{name=\"b\";count=20;diameter=0.01;});";

static void test_boxes(void **state) {
  (void)state;
  compare(periodic, "");
  compare(periodic, "gravity=[1.0,-9.81,0.0] contact.rule=smooth");
  compare("geometries/two-rotors.cfg", "balls.count=1000");
}

/* Contacts are numbered; before the numbers run out, all begins anew. */
static uint64_t collide_from(uint32_t number, const char *overrides) {
  struct trial t;
  trial_open(&t, MILL, "balls.count=500 rotor.rpm=1700 %s", overrides);
  t.world->contacts = number;
  trial_collide(&t, 3000);
  assert_true((t.world->contacts < 3000) == (number > 0));
  const uint64_t state = trail_of_state(t.world);
  trial_free(&t);
  return state;
}

static void test_numbers(void **state) {
  (void)state;
  assert_true(collide_from(0, "") == collide_from(UINT32_MAX - 1000, ""));
  assert_true(collide_from(0, "") == collide_from(UINT32_MAX - 1000, "engine.lists=all"));
}

/* In another scene balls and blades go on from where they are, at the same time: with the paths
 * since their last contacts of the new one, they would overlap; its epochs may be longer. */
static void go_on(const char *scene, const char *overrides, const char *others, double after) {
  struct trial from, to;
  struct em_snapshot *s;
  trial_open(&from, scene, "%s", overrides);
  trial_run(&from, after);
  assert_int_equal(em_world_snapshot_now(from.world, &s, &from.err), EM_OK);
  trial_open(&to, scene, "%s gravity=[-3,0,-9.81] contact.normal=0.9 %s", overrides, others);
  assert_true(!*others || to.world->epoch_length != from.world->epoch_length);
  go_on_from(&to, s);
  const double t = em_world_time(from.world);
  assert_true(em_world_time(to.world) == t);
  em_world_state(from.world, t, from.balls);
  em_world_state(to.world, t, to.balls);
  for (size_t i = 0; i < from.balls->count; i++) {
    const struct em_vec d = em_vec_sub(from.balls->position[i], to.balls->position[i]);
    assert_true(em_vec_norm(d) <= 1e-15);
    assert_true(em_vec_norm(em_vec_sub(from.balls->velocity[i], to.balls->velocity[i])) == 0.0);
  }
  trial_valid(&to, 1e-12);
  trial_run(&to, t + after);
  trial_valid(&to, 1e-12);
  trial_free(&from);
  trial_free(&to);
}

static void test_other_scenes(void **state) {
  (void)state;
  go_on("geometries/ideal-gas.cfg", "", "", 0.03);
  go_on(periodic, "contact.rule=smooth", "", 0.03);
  go_on(MILL, "gravity=none balls.count=700 rotor.rpm=800", "", 0.03);
  go_on(MILL, "gravity=none balls.count=700 rotor.rpm=800", "rotor.rpm=3000", 0.03);
  go_on(MILL, "gravity=none balls.count=700 rotor.rpm=3000 remedy.elastic_below=0.001",
        "rotor.rpm=-500", 0.03);
}

/* A copy with one number replaced is refused, by the name of what is wrong with it. */
static void refuse(struct em_snapshot *s, const struct em_scene *scene, const char *expected) {
  struct em_world *world = NULL;
  struct em_error err = {0};
  if (em_world_resume(&world, scene, s, &err) != EM_INPUT || world || !strstr(err.text, expected))
    fail_msg("\"%s\", expected \"%s\"", err.text, expected);
}

static void replace(struct em_snapshot *s, const struct em_scene *scene, double *number,
                    double wrong, const char *expected) {
  const double right = *number;
  *number = wrong;
  refuse(s, scene, expected);
  *number = right;
}

static void test_damaged(void **state) {
  (void)state;
  struct trial t;
  struct em_snapshot *s;
  trial_open(&t, MILL, "balls.count=300");
  trial_run(&t, 1.5 * t.world->epoch_length);
  assert_int_equal(em_world_snapshot(t.world, &s, &t.err), EM_OK);
  const double none[] = {NAN, INFINITY, -INFINITY, 1e300};
  for (size_t k = 0; k < sizeof none / sizeof *none; k++) {
    replace(s, t.scene, &s->velocity[7].y, none[k], "ball 7 of the checkpoint: expected a finite");
    replace(s, t.scene, &s->position[0].x, none[k], "ball 0 of the checkpoint: expected a place");
    replace(s, t.scene, &s->spin[299].z, none[k], "expected a finite spin");
    replace(s, t.scene, &s->time[9], none[k], "expected a last contact in the past");
    replace(s, t.scene, &s->blade_angle[1], none[k], "blade 1 of the checkpoint: found an angle");
  }
  replace(s, t.scene, &s->position[0].y, 1.0, "expected a place in the chamber");
  replace(s, t.scene, &s->time[9], nextafter(s->clock, 1.0), "expected a last contact");
  replace(s, t.scene, &s->time[9], -2.0 * t.world->epoch_length, "expected a last contact");
  replace(s, t.scene, &s->clock, NAN, "expected a time not below 0");
  const uint32_t code[] = {300, 299, 4000000000u, EM_SURFACE_BLADE(t.world->blade_count)};
  for (size_t k = 0; k < sizeof code / sizeof *code; k++) {
    const uint32_t right = s->last[299];
    s->last[299] = code[k];
    refuse(s, t.scene, "ball 299 of the checkpoint: expected a last partner");
    s->last[299] = right;
  }
  go_on_from(&t, s);
  trial_free(&t);
}

static volatile sig_atomic_t stop;

static void on_alarm(int number) {
  stop = number;
}

/* Whatever the state, a request to stop is heard. */
static void test_stops(void **state) {
  (void)state;
  static const char *const scene[] = {"geometries/ideal-gas.cfg",
                                      "geometries/ideal-gas-gravity.cfg"};
  static const double speed[] = {1e300, 1e200, 1e160};
  signal(SIGALRM, on_alarm);
  for (size_t k = 0; k < 6; k++) {
    struct trial t;
    trial_open(&t, scene[k % 2], "%s", "balls.count=300");
    trial_run(&t, 0.01);
    t.world->body[7].vx = speed[k / 2];
    t.world->body[8].t = 0.0;
    stop = 0;
    const struct itimerval soon = {.it_value = {.tv_usec = 50000}};
    setitimer(ITIMER_REAL, &soon, NULL);
    if (t.world->loop->predict_all(t.world)) em_world_run(t.world, 1e9, &stop, &t.err);
    trial_free(&t);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_mill),         cmocka_unit_test(test_structures),
      cmocka_unit_test(test_remedies),     cmocka_unit_test(test_ramps),
      cmocka_unit_test(test_boxes),        cmocka_unit_test(test_numbers),
      cmocka_unit_test(test_other_scenes), cmocka_unit_test(test_damaged),
      cmocka_unit_test(test_stops),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
