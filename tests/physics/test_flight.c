/* Single balls against closed forms, and what a crowd of balls must keep. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "support/trial.h"

static const char drop[] =
    "gravity=[0.0,0.0,-9.81];chamber={shape=\"box\";size=[0.1,0.1,0.6];};"
    "contact={rule=\"smooth\";normal=0.9;};"
    "balls={diameter=0.02;start=\"table\";table=((0.05,0.05,0.51,0.0,0.0,0.0));};";

/* x(t) = x + v t + g t²/2 for a gravity in any direction, until the first contact. */
static void test_free_fall(void **state) {
  (void)state;
  struct trial t;
  trial_open(&t,
             "gravity=[0.3,-0.7,-9.81];chamber={shape=\"box\";size=[1.0,1.0,1.0];};"
             "contact={rule=\"smooth\";normal=1.0;};balls={diameter=0.02;start=\"table\";"
             "table=((0.5,0.5,0.5,0.2,0.1,1.0));};",
             "%s", "");
  const struct em_vec g = t.scene->gravity;
  for (int k = 1; k <= 20; k++) {
    const double s = 0.01 * k;
    trial_run(&t, s);
    trial_state(&t);
    const struct em_vec x = t.balls->position[0], v = t.balls->velocity[0];
    assert_true(fabs(x.x - (0.5 + 0.2 * s + 0.5 * g.x * s * s)) < 1e-15);
    assert_true(fabs(x.y - (0.5 + 0.1 * s + 0.5 * g.y * s * s)) < 1e-15);
    assert_true(fabs(x.z - (0.5 + 1.0 * s + 0.5 * g.z * s * s)) < 1e-15);
    assert_true(fabs(v.z - (1.0 + g.z * s)) < 1e-15);
  }
  assert_int_equal(em_world_collisions(t.world), 0);
  trial_free(&t);
}

struct bounces {
  double time[64], vn[64];
  int count;
};

static void bounce(void *self, const struct em_contact *c) {
  struct bounces *b = self;
  if (b->count < 64) {
    b->time[b->count] = c->time;
    b->vn[b->count++] = c->vn;
  }
}

/* Bounce k comes at t0 (1 + 2 (e + … + e^k)) with the speed g t0 e^k, t0 = √(2 h/g). */
static void test_bouncing_ball(void **state) {
  (void)state;
  struct trial t;
  struct bounces b = {.count = 0};
  const struct em_observer observer = {&b, bounce};
  trial_open(&t, drop, "%s", "");
  assert_int_equal(em_world_observe(t.world, &observer), EM_OK);
  trial_run(&t, 5.9);
  const double e = 0.9, g = 9.81, t0 = sqrt(2.0 * 0.5 / g);
  double when = t0, power = 1.0;
  assert_true(b.count > 30);
  for (int k = 0; k < b.count; k++) {
    assert_true(fabs(b.time[k] - when) < 1e-13 * when);
    assert_true(fabs(b.vn[k] - g * t0 * power) < 1e-12 * g * t0 * power);
    power *= e;
    when += 2.0 * t0 * power;
  }
  assert_true(when > 5.9);
  trial_free(&t);
}

/* In the mill: E = E0 + work − lost; and the work of a blade is its angular impulse times ω. */
static void test_energy_books(void **state) {
  (void)state;
  static const char *const rules[] = {"rough", "friction", "reichardt2005", "smooth"};
  for (size_t k = 0; k < sizeof rules / sizeof *rules; k++) {
    struct trial t;
    trial_open(&t, "geometries/simoloyer-2l.cfg", "balls.count=2000 contact.rule=%s", rules[k]);
    const double energy = trial_energy(&t);
    trial_collide(&t, 60000);
    const double miss = trial_books(&t, energy);
    if (!(fabs(miss) < 2e-13)) fail_msg("%s: the books miss %g", rules[k], miss);
    for (size_t i = 0; i < em_world_blade_count(t.world); i++) {
      const struct em_blade_tally *b = em_world_blade_tally(t.world, i);
      assert_true(b->contacts > 10);
      assert_true(b->work > 0.0);
      const double omega = 1300.0 * M_PI / 30.0;
      assert_true(fabs(b->work - omega * b->angular_impulse) < 1e-12 * b->work);
    }
    trial_free(&t);
  }
}

/* A turning drum does work on rough balls, and its books are kept, too. */
static void test_turning_drum_books(void **state) {
  (void)state;
  struct trial t;
  trial_open(&t, "geometries/ideal-gas-gravity.cfg",
             "balls.count=1000 contact.rule=rough contact.tangential=0.3 contact.normal=0.9 "
             "chamber.rpm=200");
  const double energy = trial_energy(&t);
  trial_collide(&t, 20000);
  assert_true(em_world_tally(t.world)->drum_work > 0.0);
  assert_true(fabs(trial_books(&t, energy)) < 1e-13);
  trial_free(&t);
}

static struct em_vec momentum(struct trial *t) {
  struct em_vec sum = {0.0, 0.0, 0.0};
  trial_state(t);
  for (size_t i = 0; i < t->balls->count; i++)
    sum = em_vec_axpy(sum, t->balls->mass[i], t->balls->velocity[i]);
  return sum;
}

/* Balls in a periodic box push only each other: P = P0 + M g t, whatever they lose. */
static void test_momentum(void **state) {
  (void)state;
  struct trial t;
  trial_open(&t,
             "gravity=[0.5,0.0,-2.0];chamber={shape=\"box\";size=[0.1,0.1,0.1];periodic=true;};"
             "contact={rule=\"rough\";normal=0.95;tangential=-0.3;};"
             "balls=({name=\"large\";count=200;diameter=0.008;density=7850.0;},"
             "{name=\"small\";count=800;diameter=0.004;density=2500.0;});",
             "%s", "");
  const struct em_vec p0 = momentum(&t), g = t.scene->gravity;
  double mass = 0.0, size = 0.0;
  for (size_t i = 0; i < t.balls->count; i++) {
    mass += t.balls->mass[i];
    size += t.balls->mass[i] * em_vec_norm(t.balls->velocity[i]);
  }
  trial_run(&t, 0.3);
  assert_true(em_world_collisions(t.world) > 2000);
  const double s = em_world_time(t.world);
  const struct em_vec p = em_vec_sub(momentum(&t), em_vec_axpy(p0, mass * s, g));
  assert_true(em_vec_norm(p) < 1e-12 * size);
  trial_free(&t);
}

static struct em_vec angular_momentum(struct trial *t) {
  struct em_vec sum = {0.0, 0.0, 0.0};
  trial_state(t);
  for (size_t i = 0; i < t->balls->count; i++) {
    const double m = t->balls->mass[i], r = t->balls->radius[i];
    sum = em_vec_axpy(sum, m, em_vec_cross(t->balls->position[i], t->balls->velocity[i]));
    sum = em_vec_axpy(sum, 0.4 * m * r * r, t->balls->spin[i]);
  }
  return sum;
}

/* A cloud that has not reached the walls keeps orbital plus spin angular momentum. */
static void test_angular_momentum(void **state) {
  (void)state;
  struct trial t;
  trial_open(&t,
             "gravity=\"none\";chamber={shape=\"box\";size=[10.0,10.0,10.0];};"
             "contact={rule=\"rough\";normal=0.9;tangential=-0.5;};"
             "balls=({count=200;diameter=0.01;region={low=[4.95,4.95,4.95];"
             "high=[5.05,5.05,5.05];};},"
             "{count=60;diameter=0.015;density=2500.0;region={low=[4.95,4.95,4.95];"
             "high=[5.05,5.05,5.05];};});",
             "%s", "");
  const struct em_vec before = angular_momentum(&t);
  trial_run(&t, 2.0);
  assert_true(em_world_tally(t.world)->collisions[EM_CLASS_BALL] > 300);
  assert_int_equal(em_world_collisions(t.world),
                   em_world_tally(t.world)->collisions[EM_CLASS_BALL]);
  const struct em_vec after = angular_momentum(&t);
  assert_true(em_vec_norm(em_vec_sub(after, before)) < 1e-12 * em_vec_norm(before));
  trial_free(&t);
}

/* A ball comes back from the wall, and meets one that has met nobody yet: what counts is the
 * shorter of the two times since their last contacts. */
static void test_contact_time(void **state) {
  (void)state;
  static const char two[] =
      "gravity=\"none\";chamber={shape=\"box\";size=[1.0,0.1,0.1];};"
      "contact={rule=\"smooth\";normal=0.5;};balls={diameter=0.02;start=\"table\";"
      "table=((0.02,0.05,0.05,-1.0,0.0,0.0),(0.0403,0.05,0.05,-1.0,0.0,0.0));};";
  static const double after = 0.0003 / 1.5; /* s: the gap over the speed at which it closes */
  for (int k = 0; k < 2; k++) {
    struct trial t;
    trial_open(&t, two, "remedy.tc=%.17g", (k ? 1.001 : 0.999) * after);
    trial_collide(&t, 2);
    const struct em_tally *tally = em_world_tally(t.world);
    assert_int_equal(tally->collisions[EM_CLASS_BALL], 1);
    assert_int_equal(tally->tc, k);
    assert_true(k ? tally->lost[EM_CLASS_BALL] == 0.0 : tally->lost[EM_CLASS_BALL] > 0.0);
    trial_free(&t);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_free_fall),    cmocka_unit_test(test_bouncing_ball),
      cmocka_unit_test(test_energy_books), cmocka_unit_test(test_turning_drum_books),
      cmocka_unit_test(test_momentum),     cmocka_unit_test(test_angular_momentum),
      cmocka_unit_test(test_contact_time),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
