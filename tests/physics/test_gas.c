/* The elastic gas: its energy, its laws of speed, and how often balls meet. Seeds are fixed; a
 * p-value below 1e-4 in any of the tests is a fault. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

#include "eventmill/distribution.h"
#include "eventmill/goodness.h"
#include "support/trial.h"

#ifdef LONG_FORM
enum { ENERGY = 10000000 };
#else
enum { ENERGY = 1000000 };
#endif
static const double P = 1e-4;

/* --- energy ----------------------------------------------------------------------------------- */

/* Relative error of the energy after many collisions: at the level of rounding, without jumps. */
static void test_energy(void **state) {
  (void)state;
  static const char *const scene[] = {"geometries/ideal-gas.cfg",
                                      "geometries/ideal-gas-gravity.cfg"};
  for (int k = 0; k < 2; k++) {
    struct trial t;
    trial_open(&t, scene[k], "%s", "");
    const double energy = trial_energy(&t);
    double worst = 0.0, jump = 0.0, before = 0.0;
    for (int part = 0; part < 100; part++) {
      trial_collide(&t, (k ? 4u : 1u) * (uint64_t)ENERGY / 400u);
      const double error = (trial_energy(&t) - energy) / energy;
      worst = fmax(worst, fabs(error));
      jump = fmax(jump, fabs(error - before));
      before = error;
    }
    print_message("# %s: relative energy error %.2g, largest change in a hundredth %.2g\n",
                  scene[k], worst, jump);
    if (!(worst < 1e-11)) fail_msg("%s: the energy is off by %g", scene[k], worst);
    if (!(jump < 1e-12)) fail_msg("%s: the energy jumps by %g", scene[k], jump);
    trial_valid(&t, 1e-12 * t.balls->radius[0]);
    trial_free(&t);
  }
}

/* --- laws of speed ---------------------------------------------------------------------------- */

enum { SAMPLES = 40, MOST = 200000 };

struct impacts {
  double *vn;
  size_t count;
};

static void impact(void *self, const struct em_contact *c) {
  struct impacts *s = self;
  if (c->cls == EM_CLASS_BALL && s->count < MOST) s->vn[s->count++] = c->vn;
}

static void obeys(const char *what, enum em_distribution law, double a, double *x, size_t n) {
  struct em_goodness g;
  for (size_t i = 0; i < n; i++)
    x[i] = em_distribution_cdf(law, a, x[i]);
  assert_int_equal(em_goodness_chi2_uniform(&g, x, n, 0, 1), EM_OK);
  print_message("# %s: chi2 %.1f of %.0f, p = %.3g\n", what, g.statistic, g.freedom, g.p);
  if (!(g.p > P)) fail_msg("%s does not obey its law: p = %g", what, g.p);
}

/* σ is given by the energy: ½ m σ² per degree of freedom. Samples are taken several collisions per
 * ball apart, so that they do not know of each other. */
static void laws(const char *scene, const char *overrides) {
  struct trial t;
  struct impacts hits = {malloc(MOST * sizeof(double)), 0};
  const struct em_observer observer = {&hits, impact};
  trial_open(&t, scene, "%s", overrides);
  const size_t n = t.balls->count;
  double *speed = malloc(SAMPLES * n * sizeof *speed), *part = malloc(SAMPLES * n * sizeof *part);
  assert_non_null(hits.vn);
  assert_non_null(speed);
  assert_non_null(part);
  trial_collide(&t, 20 * n);
  assert_int_equal(em_world_observe(t.world, &observer), EM_OK);
  double sigma2 = 0.0;
  for (size_t s = 0; s < SAMPLES; s++) {
    trial_collide(&t, 4 * n);
    trial_state(&t);
    for (size_t i = 0; i < n; i++) {
      speed[s * n + i] = em_vec_norm(t.balls->velocity[i]);
      part[s * n + i] = s % 3 == 0   ? t.balls->velocity[i].x
                        : s % 3 == 1 ? t.balls->velocity[i].y
                                     : t.balls->velocity[i].z;
      sigma2 += em_vec_norm2(t.balls->velocity[i]) / (3.0 * (double)(n * SAMPLES));
    }
  }
  const double sigma = sqrt(sigma2);
  obeys("speed (Maxwell)", EM_DISTRIBUTION_MAXWELL, sigma, speed, SAMPLES * n);
  obeys("component (normal)", EM_DISTRIBUTION_NORMAL, sigma, part, SAMPLES * n);
  obeys("v_n at collisions (Rayleigh)", EM_DISTRIBUTION_RAYLEIGH, M_SQRT2 * sigma, hits.vn,
        hits.count);
  free(hits.vn);
  free(speed);
  free(part);
  trial_free(&t);
}

static const char box[] =
    "gravity=\"none\";chamber={shape=\"box\";size=[0.1,0.1,0.1];periodic=true;};"
    "contact={rule=\"smooth\";normal=1.0;};"
    "balls={count=4000;diameter=0.005;start=\"lattice\";};";

static void test_laws_periodic(void **state) {
  (void)state;
  laws(box, "balls.count=2000 seed=11");
}

static void test_laws_drum(void **state) {
  (void)state;
  laws("geometries/ideal-gas.cfg", "seed=12");
}

static void test_laws_drum_gravity(void **state) {
  (void)state;
  laws("geometries/ideal-gas-gravity.cfg", "balls.speed=3 seed=13");
}

/* --- how often balls meet --------------------------------------------------------------------- */

/* Collisions per second of n balls at packing fraction φ: ½ n · 4 σ² (n/V) g(σ) √(π T/m), with the
 * contact value (1 − φ/2)/(1 − φ)³ of Carnahan and Starling; T of a box at rest: 2 E/(3 (n − 1)).
 */
static void test_rate(void **state) {
  (void)state;
  static const double packing[] = {0.1, 0.3, 0.45};
  for (int k = 0; k < 3; k++) {
    struct trial t;
    const double phi = packing[k], n = 4000.0, d = 0.005;
    const double edge = cbrt(n * M_PI / 6.0 * d * d * d / phi);
    trial_open(&t, box, "chamber.size=[%.17g,%.17g,%.17g] seed=%d", edge, edge, edge, 21 + k);
    trial_collide(&t, 100000);
    trial_state(&t);
    const double begin = em_world_time(t.world);
    struct em_vec drift = {0.0, 0.0, 0.0};
    double square = 0.0;
    for (size_t i = 0; i < t.balls->count; i++) {
      drift = em_vec_axpy(drift, 1.0 / n, t.balls->velocity[i]);
      square += em_vec_norm2(t.balls->velocity[i]);
    }
    const double temperature = (square - n * em_vec_norm2(drift)) / (3.0 * (n - 1.0));
    trial_collide(&t, 400000);
    const double rate = 400000.0 / (em_world_time(t.world) - begin);
    const double g = (1.0 - 0.5 * phi) / pow(1.0 - phi, 3.0);
    const double density = (n - 1.0) / (edge * edge * edge);
    const double theory = 0.5 * n * 4.0 * d * d * density * g * sqrt(M_PI * temperature);
    print_message("# packing %.2f: rate %.5g per second, theory %.5g, ratio %.4f\n", phi, rate,
                  theory, rate / theory);
    if (!(fabs(rate / theory - 1.0) < 0.01))
      fail_msg("packing %g: %g of the rate of the theory", phi, rate / theory);
    trial_free(&t);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_energy),
#ifndef LONG_FORM
      cmocka_unit_test(test_laws_periodic),
      cmocka_unit_test(test_laws_drum),
      cmocka_unit_test(test_laws_drum_gravity),
      cmocka_unit_test(test_rate),
#endif
  };
  (void)test_laws_periodic, (void)test_laws_drum, (void)test_laws_drum_gravity, (void)test_rate;
  return cmocka_run_group_tests(tests, NULL, NULL);
}
