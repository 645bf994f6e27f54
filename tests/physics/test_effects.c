/* A scene pays only for the effects that it calls for: bytes per ball, and the loop's variant. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

#include "event/body.h"
#include "support/trial.h"

#define GAS "geometries/ideal-gas.cfg"

static void test_spins(void **state) {
  (void)state;
  struct trial smooth, rough;
  trial_open(&smooth, GAS, "%s", "");
  trial_open(&rough, GAS, "%s", "contact.rule=rough");
  assert_null(smooth.world->spin);
  assert_non_null(rough.world->spin);
  const double more = em_world_bytes_per_ball(rough.world) - em_world_bytes_per_ball(smooth.world);
  assert_true(more == sizeof(struct em_vec));
  trial_free(&smooth);
  trial_free(&rough);
}

static void test_masses(void **state) {
  (void)state;
  struct trial t;
  trial_open(&t, GAS, "%s", "");
  assert_null(t.world->mass);
  trial_free(&t);
  trial_open(&t,
             "chamber={shape=\"box\";size=[0.1,0.1,0.1];};"
             "balls=({name=\"a\";count=5;diameter=0.01;},{name=\"b\";count=5;diameter=0.02;});",
             "%s", "");
  assert_non_null(t.world->mass);
  trial_free(&t);
}

static void has_flags(const char *scene, const char *overrides, unsigned flags) {
  struct trial t;
  trial_open(&t, scene, "%s", overrides);
  if (t.world->loop->flags != flags)
    fail_msg("%s %s: flags %#x, not %#x", scene, overrides, t.world->loop->flags, flags);
  trial_free(&t);
}

static void test_variants(void **state) {
  (void)state;
  has_flags(GAS, "", 0);
  has_flags(GAS, "gravity=[0.0,0.0,-1.0]", EM_LOOP_GRAVITY);
  has_flags(GAS, "contact.rule=rough", EM_LOOP_SPIN);
  has_flags(GAS, "remedy.tc=1e-6", EM_LOOP_EXTRA);
  has_flags(GAS, "remedy.elastic_below=1e-6", EM_LOOP_EXTRA);
  has_flags(GAS, "chamber.rpm=10", EM_LOOP_EXTRA);
  has_flags("chamber={shape=\"box\";size=[0.1,0.1,0.1];periodic=true;};gravity=\"none\";"
            "contact={rule=\"smooth\";};balls={count=5;diameter=0.01;};",
            "", EM_LOOP_PERIODIC);
  has_flags("geometries/simoloyer-2l.cfg", "balls.count=100",
            EM_LOOP_GRAVITY | EM_LOOP_SPIN | EM_LOOP_ROTOR | EM_LOOP_EXTRA);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_spins),
      cmocka_unit_test(test_masses),
      cmocka_unit_test(test_variants),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
