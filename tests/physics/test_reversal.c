/* Mechanics without losses runs backwards: turn all velocities round, and the balls return. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

#include "support/trial.h"

/* Runs for the time `span`, turns round, runs as long; the largest distance (m) from the start.
 * Rounding grows by about a factor λ/R per collision of a ball, so the runs are short. */
static double come_back(const char *scene, const char *overrides, double span, uint64_t *count) {
  struct trial t;
  trial_open(&t, scene, "%s", overrides);
  const size_t n = t.balls->count;
  struct em_vec *from = calloc(n, sizeof *from);
  assert_non_null(from);
  for (size_t i = 0; i < n; i++)
    from[i] = t.balls->position[i];
  trial_run(&t, span);
  *count = em_world_collisions(t.world);
  trial_state(&t);
  for (size_t i = 0; i < n; i++) {
    t.balls->velocity[i] = em_vec_scale(-1.0, t.balls->velocity[i]);
    t.balls->spin[i] = em_vec_scale(-1.0, t.balls->spin[i]);
  }
  em_world_free(t.world);
  t.world = NULL;
  trial_world(&t);
  trial_run(&t, span);
  trial_state(&t);
  double worst = 0.0;
  for (size_t i = 0; i < n; i++)
    worst = fmax(worst, em_vec_norm(em_vec_sub(t.balls->position[i], from[i])));
  free(from);
  trial_free(&t);
  return worst;
}

static void test_returns(void **state) {
  (void)state;
  static const char *const overrides[] = {
      "balls.count=200", "balls.count=200 contact.rule=rough contact.tangential=-1.0",
      "balls.count=200 gravity=[2.0,-3.0,-9.81]"};
  for (size_t k = 0; k < sizeof overrides / sizeof *overrides; k++) {
    uint64_t count;
    const double worst = come_back("geometries/ideal-gas-gravity.cfg", overrides[k], 0.1, &count);
    print_message("# %s: back after %llu collisions to %.2g m\n", overrides[k],
                  (unsigned long long)count, worst);
    assert_true(count > 200);
    assert_true(worst < 1e-9);
  }
}

/* With losses they do not: the test can fail. */
static void test_losses_do_not(void **state) {
  (void)state;
  uint64_t count;
  assert_true(come_back("geometries/ideal-gas-gravity.cfg", "balls.count=200 contact.normal=0.999",
                        0.1, &count) > 1e-5);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_returns),
      cmocka_unit_test(test_losses_do_not),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
