/* The reference's ramps (20.1.1): in two sectors at the top and the bottom the drum's normal is
 * turned against the ball's motion along x; elsewhere, and for the rest of the physics, nothing
 * changes. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "support/trial.h"

#define DEG (3.14159265358979323846 / 180.0)

/* A smooth elastic ball hits the drum at the angle `at` (rad, from the bottom towards +x), flying
 * at `slope` (rad) against the outward direction there. Its velocity afterwards. */
static struct em_vec bounce(double at, double slope, double half_deg, double tilt_deg,
                            struct em_vec *v) {
  const double rho = 0.05 - 0.0025, way = 0.004;
  const struct em_vec out = {sin(at), 0.0, -cos(at)}, along = {cos(at), 0.0, sin(at)};
  *v = em_vec_add(em_vec_scale(cos(slope), out), em_vec_scale(sin(slope), along));
  v->y = 0.25;
  const struct em_vec x = em_vec_axpy(em_vec_scale(rho, out), -way, *v);
  struct trial t;
  trial_scene(&t,
              "gravity=\"none\";chamber={shape=\"drum\";diameter=0.1;length=0.1;};"
              "contact={rule=\"smooth\";normal=1.0;};balls={count=1;diameter=0.005;};",
              "chamber.ramps.half_deg=%.17g chamber.ramps.tilt_deg=%.17g", half_deg, tilt_deg);
  trial_balls(&t);
  t.balls->position[0] = (struct em_vec){x.x, 0.05, x.z};
  t.balls->velocity[0] = *v;
  trial_world(&t);
  trial_collide(&t, 1);
  assert_true(fabs(em_world_time(t.world) - way) < 1e-14);
  trial_state(&t);
  const struct em_vec after = t.balls->velocity[0];
  trial_free(&t);
  return after;
}

static void is_mirrored(struct em_vec v, struct em_vec e, struct em_vec after) {
  const struct em_vec expected = em_vec_axpy(v, -2.0 * em_vec_dot(v, e), e);
  assert_true(em_vec_norm(em_vec_sub(after, expected)) < 1e-12);
}

static void turned_normal(void **state) {
  (void)state;
  size_t inside = 0, outside = 0;
  for (double at = -177.0 * DEG; at < 180.0 * DEG; at += 6.0 * DEG)
    for (double slope = -85.0 * DEG; slope < 86.0 * DEG; slope += 17.0 * DEG)
      for (double half = 0.0; half < 40.0; half += 10.0) {
        struct em_vec v;
        const struct em_vec after = bounce(at, slope, half, 30.0, &v);
        const double from_vertical = fabs(remainder(at, 180.0 * DEG));
        double turn = from_vertical < half * DEG ? 30.0 * DEG : 0.0;
        turn > 0.0 ? inside++ : outside++;
        /* The inward normal, turned about y by whichever sense takes it against v.x. */
        const struct em_vec n = {-sin(at), 0.0, cos(at)};
        if ((n.z > 0.0) == (v.x > 0.0)) turn = -turn;
        const struct em_vec e = {n.x * cos(turn) + n.z * sin(turn), 0.0,
                                 n.z * cos(turn) - n.x * sin(turn)};
        if (turn != 0.0) assert_true((e.x - n.x * cos(turn)) * v.x < 0.0);
        is_mirrored(v, e, after);
        assert_true(em_vec_dot(after, n) > 0.0); /* back into the chamber */
      }
  assert_true(inside > 100 && outside > 100);
}

/* No tilt, no ramps: the same run, to the last bit. */
static void without_tilt(void **state) {
  (void)state;
  uint64_t hash[2];
  for (int k = 0; k < 2; k++) {
    struct trial t;
    struct trail trail;
    trial_open(&t, "geometries/simoloyer-2l.cfg", "balls.count=300 %s",
               k ? "chamber.ramps.half_deg=10 chamber.ramps.tilt_deg=0" : "seed=1");
    trail_watch(&trail, t.world);
    trial_collide(&t, 3000);
    hash[k] = trail.hash;
    trial_free(&t);
  }
  assert_true(hash[0] == hash[1]);
}

/* Where the turned normal would let a ball go on outwards, the drum's own holds it. */
static void any_tilt(void **state) {
  (void)state;
  static const int tilt[] = {-89, -60, -10, 60, 89}, half[] = {30, 90};
  for (size_t k = 0; k < sizeof tilt / sizeof *tilt; k++)
    for (size_t h = 0; h < sizeof half / sizeof *half; h++) {
      struct trial t;
      trial_open(&t, "geometries/ideal-gas.cfg",
                 "balls.count=50 chamber.ramps.half_deg=%d chamber.ramps.tilt_deg=%d", half[h],
                 tilt[k]);
      const double energy = trial_energy(&t);
      trial_collide(&t, 3000);
      trial_valid(&t, 1e-12);
      assert_true(fabs(trial_energy(&t) / energy - 1.0) < 1e-12);
      trial_free(&t);
    }
}

/* Where a turning drum carries a ramp away from a ball, the drum's own normal holds it: there is no
 * contact without approach. */
static void turning_drum(void **state) {
  (void)state;
  static const int rpm[] = {-600, -60, 60, 600};
  for (size_t k = 0; k < sizeof rpm / sizeof *rpm; k++) {
    struct trial t;
    trial_open(&t,
               "chamber={diameter=0.2;length=0.1;ramps={half_deg=30.0;tilt_deg=30.0;};};"
               "gravity=[0.0,0.0,-9.81];contact={rule=\"rough\";normal=1.0;};"
               "balls={count=50;diameter=0.005;};",
               "chamber.rpm=%d", rpm[k]);
    const double energy = trial_energy(&t);
    trial_collide(&t, 1000);
    assert_int_equal(em_world_tally(t.world)->vn[EM_CLASS_DRUM][0], 0);
    trial_valid(&t, 1e-12);
    assert_true(fabs(trial_books(&t, energy)) < 1e-12);
    trial_free(&t);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(turned_normal),
                                     cmocka_unit_test(without_tilt), cmocka_unit_test(any_tilt),
                                     cmocka_unit_test(turning_drum)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
