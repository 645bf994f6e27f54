/* Balls that touch at the start: gaps of nothing, of one rounding, of 1e-15…1e-9 m, at rest,
 * approaching, parting; walls just hit, corners, and blades with nothing to spare. */
#include <float.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>

#include <cmocka.h>

#include "support/trial.h"

static const double gap[] = {0.0,          DBL_EPSILON / 2, DBL_EPSILON, -DBL_EPSILON / 2,
                             -DBL_EPSILON, 1e-15,           -1e-15,      1e-13,
                             1e-12,        1e-11,           1e-10,       1e-9};
enum { GAPS = sizeof gap / sizeof *gap };

static const char cage[] =
    "gravity=\"none\";chamber={shape=\"box\";size=[1.0,1.0,1.0];};contact={rule=\"smooth\";};"
    "balls={count=2;diameter=0.01;start=\"lattice\";speed=1.0;};";

static void place(struct trial *t, size_t i, struct em_vec x, struct em_vec v) {
  t->balls->position[i] = x;
  t->balls->velocity[i] = v;
}

/* Two balls `gap` apart (in units of m or of their own rounding), in any direction. */
static void pairs(void **state) {
  (void)state;
  uint64_t seed = 1;
  double worst = 0.0;
  const uint64_t tries = TRIES(1800, 60000);
  for (uint64_t k = 0; k < tries; k++) {
    struct trial t;
    const double d = 0.01, apart = gap[k % GAPS], way = (double)(int)(k / GAPS % 3) - 1.0;
    trial_scene(&t, cage, "engine.partition=none contact.normal=%s", k & 1 ? "1.0" : "0.7");
    trial_balls(&t);
    const struct em_vec e = dice_direction(&seed), other = dice_direction(&seed);
    const struct em_vec at = em_vec_make(0.5, 0.5, 0.5);
    const struct em_vec v = em_vec_axpy(em_vec_scale(0.1, em_vec_cross(e, other)), way, e);
    place(&t, 0, at, em_vec_make(0, 0, 0));
    place(&t, 1, em_vec_axpy(at, d + (fabs(apart) < 1e-15 ? d * apart : apart), e), v);
    trial_world(&t);
    const double energy = trial_energy(&t);
    trial_run(&t, 0.2);
    trial_valid(&t, 1e-12 * d);
    const uint64_t hits = em_world_tally(t.world)->collisions[EM_CLASS_BALL];
    if (way < 0.0) assert_int_equal(hits, 1);
    if (way > 0.0) assert_int_equal(hits, 0);
    assert_true(hits <= 1);
    if (k & 1) worst = fmax(worst, fabs(trial_energy(&t) - energy) / energy);
    trial_free(&t);
  }
  assert_true(worst < 1e-14);
  hard_row("touching pairs", "gap 0, ± ulp, ± 1e-15…1e-9 m; at rest, approaching, parting",
           (double)tries, "one contact, or none; no overlap above 1e-12 d", "energy %.1e", worst);
}

/* At one, two, three walls at once, with every gap and direction. */
static void corners(void **state) {
  (void)state;
  uint64_t seed = 2;
  double worst = 0.0;
  const uint64_t tries = TRIES(1800, 60000);
  for (uint64_t k = 0; k < tries; k++) {
    struct trial t;
    const double r = 0.005, apart = gap[k % GAPS];
    const int walls = 1 + (int)(k / GAPS % 3);
    trial_scene(&t, cage, "engine.partition=none balls.count=1 contact.normal=1.0 gravity=%s",
                k & 1 ? "[0.0,0.0,-9.81]" : "[0.0,0.0,0.0]");
    trial_balls(&t);
    const double near = r + apart;
    const struct em_vec v = dice_direction(&seed);
    place(&t, 0, em_vec_make(near, walls > 1 ? near : 0.5, walls > 2 ? near : 0.5), v);
    trial_world(&t);
    const double energy = trial_energy(&t);
    for (int step = 1; step <= 10; step++) {
      trial_run(&t, 0.4 * step);
      trial_valid(&t, 1e-12 * 2.0 * r);
    }
    worst = fmax(worst, fabs(trial_energy(&t) - energy) / energy);
    assert_true(em_world_collisions(t.world) < 1000000);
    trial_free(&t);
  }
  assert_true(worst < 1e-13);
  hard_row("walls and corners", "at one, two, three walls with gap 0, ± ulp, ± 1e-15…1e-9 m",
           (double)tries, "never outside, finitely many contacts", "energy %.1e", worst);
}

/* A ball that touches the drum, with and without gravity, in all directions but exactly along it.
 */
static void drum(void **state) {
  (void)state;
  uint64_t seed = 3, most = 0;
  double worst = 0.0;
  const uint64_t tries = TRIES(1800, 60000);
  for (uint64_t k = 0; k < tries; k++) {
    struct trial t;
    const double rho = 0.07, r = 0.0025, apart = gap[k % GAPS];
    trial_scene(&t,
                "gravity=[0.0,0.0,-9.81];chamber={shape=\"drum\";diameter=0.14;length=0.1;};"
                "contact={rule=\"smooth\";normal=1.0;};"
                "balls={count=1;diameter=0.005;start=\"lattice\";};",
                "engine.partition=none gravity=%s", k % 2 ? "[0.0,0.0,-9.81]" : "[0.0,0.0,0.0]");
    trial_balls(&t);
    const double phi = dice_in(&seed, 0.0, 2.0 * M_PI), at = rho - r - apart;
    const struct em_vec e = {cos(phi), 0.0, sin(phi)}, side = {-e.z, 0.0, e.x};
    const double in = dice_power(&seed, 1e-4, 1.0) * (k % 3 ? 1.0 : -1.0);
    struct em_vec v = em_vec_axpy(em_vec_scale(dice(&seed), side), -in, e);
    v.y = 0.1 * dice(&seed);
    place(&t, 0, em_vec_axpy(em_vec_make(0.0, 0.05, 0.0), at, e), v);
    trial_world(&t);
    const double energy = trial_energy(&t);
    const double size = fabs(energy) + t.balls->mass[0] * (0.5 + 9.81 * rho);
    for (int step = 1; step <= 5; step++) {
      const enum em_status status =
          em_world_run_collisions(t.world, 0.02 * step, 500, NULL, &t.err);
      assert_int_equal(status, EM_OK);
      trial_valid(&t, 1e-12 * 2.0 * r);
    }
    most = em_world_collisions(t.world) > most ? em_world_collisions(t.world) : most;
    worst = fmax(worst, fabs(trial_energy(&t) - energy) / size);
    trial_free(&t);
  }
  assert_true(worst < 1e-12);
  hard_row("at the drum", "gap 0, ± ulp, ± 1e-15…1e-9 m; inwards, outwards, nearly along the wall",
           (double)tries, "never outside", "energy %.1e, at most %llu contacts", worst,
           (unsigned long long)most);
}

/* A ball just between a blade at rest and an end wall, with 1e-16…1e-12 m to spare, that shuttles
 * between both. */
static void blade_and_wall(void **state) {
  (void)state;
  uint64_t seed = 4, hits = 0;
  const uint64_t tries = TRIES(100, 3000);
  for (uint64_t k = 0; k < tries; k++) {
    struct trial t;
    const double d = 0.005, a = 0.006, spare = k % 7 ? dice_power(&seed, 1e-17, 1e-12) : 1e-17;
    trial_scene(&t,
                "gravity=\"none\";chamber={shape=\"drum\";diameter=0.146;length=0.1;};"
                "rotor={rpm=0.0;radius=0.006;reach=0.058;blades=({y=0.011;angle_deg=90.0;});};"
                "contact={rule=\"smooth\";normal=1.0;};"
                "balls={count=1;diameter=0.005;start=\"lattice\";};",
                "rotor.blades.y=%.17g rotor.rpm=%s", d + a + spare, k & 1 ? "0" : "1e-3");
    trial_balls(&t);
    /* Between wall and blade, right under the bar's axis or a little off. */
    const double off = k % 3 ? 0.0 : dice_power(&seed, 1e-9, 1e-6);
    place(&t, 0, em_vec_make(0.03, 0.5 * d + (k % 2 ? 0.0 : spare), off),
          em_vec_scale(1.0, dice_direction(&seed)));
    trial_world(&t);
    const enum em_status status = em_world_run_collisions(t.world, 0.02, 300000, NULL, &t.err);
    assert_true(status == EM_OK || status == EM_COLLAPSE || status == EM_JAM);
    trial_valid(&t, 1e-12 * d);
    hits += em_world_collisions(t.world);
    trial_free(&t);
  }
  hard_row("between blade and wall", "1e-17…1e-12 m to spare", (double)tries,
           "comes out, or is reported; no overlap above 1e-12 d", "%llu contacts",
           (unsigned long long)hits);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(pairs),
      cmocka_unit_test(corners),
      cmocka_unit_test(drum),
      cmocka_unit_test(blade_and_wall),
  };
  hard_choose();
  return cmocka_run_group_tests(tests, NULL, NULL);
}
