/* A scene pays only for the effects that it calls for: bytes per ball, and the loop's variant. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

#include "event/body.h"
#include "support/trial.h"

#define GAS  "geometries/ideal-gas.cfg"
#define MILL "geometries/simoloyer-2l.cfg"

static void test_spins(void **state) {
  (void)state;
  struct trial smooth, rough;
  trial_open(&smooth, GAS, "%s", "");
  trial_open(&rough, GAS, "%s", "contact.rule=rough");
  assert_null(smooth.world->spin);
  assert_non_null(rough.world->spin);
  const double more = em_world_bytes_per_ball(rough.world) - em_world_bytes_per_ball(smooth.world);
  assert_true(fabs(more - sizeof(struct em_vec)) < 1e-9);
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
  has_flags(MILL, "balls.count=100",
            EM_LOOP_GRAVITY | EM_LOOP_SPIN | EM_LOOP_ROTOR | EM_LOOP_EXTRA);
  has_flags(MILL, "balls.count=100 remedy.jam_after=0",
            EM_LOOP_GRAVITY | EM_LOOP_SPIN | EM_LOOP_ROTOR);
  has_flags(MILL, "balls.count=100 contact.rule=smooth gravity=none", EM_LOOP_ROTOR);
}

/* There is no loop for other sets: a scene has no rotor in a periodic box. */
static bool has_loop(unsigned flags) {
  return !(flags & EM_LOOP_ROTOR) || !(flags & EM_LOOP_PERIODIC);
}

/* A variant has the effects that it is found by, and says so. */
static void test_names(void **state) {
  (void)state;
  static const struct {
    unsigned flag;
    const char *name;
  } effects[] = {{EM_LOOP_GRAVITY, "gravity+"},
                 {EM_LOOP_SPIN, "spin+"},
                 {EM_LOOP_ROTOR, "rotor+"},
                 {EM_LOOP_PERIODIC, "periodic+"},
                 {EM_LOOP_EXTRA, "remedies+"}};
  for (unsigned flags = 0; flags < 2 * EM_LOOP_EXTRA; flags++) {
    const struct em_loop_kind *kind = em_loop_find(flags, 1);
    char name[64] = "";
    for (size_t k = 0; k < sizeof effects / sizeof *effects; k++)
      if (flags & effects[k].flag) strcat(name, effects[k].name);
    if (*name) name[strlen(name) - 1] = '\0';
    assert_true((kind != NULL) == has_loop(flags));
    if (!kind) continue;
    assert_true(kind->flags == flags);
    assert_string_equal(kind->name, *name ? name : "plain");
  }
}

/* What is not called for may hold anything: the loop does not read it. (Partitions do: to them, no
 * gravity is a gravity of 0.) */
static void spoil(struct trial *t, struct em_scene *scene) {
  struct em_world *w = t->world;
  const struct em_vec none = {NAN, NAN, NAN};
  *scene = *w->scene;
  if (!(w->loop->flags & EM_LOOP_GRAVITY)) {
    w->gravity = none;
    w->fall = NAN;
  }
  if (!(w->loop->flags & EM_LOOP_PERIODIC)) w->period = w->per_period = none;
  if (!(w->loop->flags & EM_LOOP_EXTRA)) {
    w->drum_omega = NAN;
    scene->remedy.tc = scene->remedy.elastic_below = INFINITY;
    scene->remedy.jam_after = 1;
    scene->chamber.ramp_tilt = scene->chamber.ramp_half = 1.0;
    scene->chamber.rpm = NAN;
    scene->engine.roots.tolerance = scene->engine.roots.shortcut = NAN;
  }
  scene->gravity = none;
  w->scene = scene;
}

static void test_unread(void **state) {
  (void)state;
  static const struct {
    const char *scene, *words;
  } of[] = {{GAS, ""},
            {GAS, "gravity=[0.0,0.0,-9.81]"},
            {GAS, "contact.rule=rough"},
            {GAS, "contact.rule=friction contact.normal=spahn"},
            {MILL, "remedy.jam_after=0"}};
  for (size_t k = 0; k < sizeof of / sizeof *of; k++) {
    struct trial clean, spoilt;
    struct em_scene scene;
    trial_open(&clean, of[k].scene, "balls.count=200 engine.partition=none %s", of[k].words);
    trial_open(&spoilt, of[k].scene, "balls.count=200 engine.partition=none %s", of[k].words);
    spoil(&spoilt, &scene);
    trial_collide(&clean, 5000);
    trial_collide(&spoilt, 5000);
    assert_true(trail_of_state(clean.world) == trail_of_state(spoilt.world));
    spoilt.world->scene = spoilt.scene;
    trial_free(&clean);
    trial_free(&spoilt);
  }
}

/* A remedy that never acts changes nothing. */
static void test_idle_remedy(void **state) {
  (void)state;
  struct trial without, idle;
  trial_open(&without, MILL, "%s", "balls.count=200 remedy.jam_after=0");
  trial_open(&idle, MILL, "%s", "balls.count=200 remedy.jam_after=0 remedy.elastic_below=1e-300");
  assert_true(idle.world->loop->flags == (without.world->loop->flags | EM_LOOP_EXTRA));
  trial_collide(&without, 20000);
  trial_collide(&idle, 20000);
  assert_true(trail_of_state(without.world) == trail_of_state(idle.world));
  trial_free(&without);
  trial_free(&idle);
}

static double bytes(const char *scene, const char *overrides) {
  struct trial t;
  trial_open(&t, scene, "%s", overrides);
  const double bytes = em_world_bytes_per_ball(t.world);
  trial_free(&t);
  return bytes;
}

/* Of all effects, only spins and masses that differ have bytes per ball. */
static void test_bytes(void **state) {
  (void)state;
  static const char *const free[] = {"gravity=[0.0,0.0,-9.81]", "contact.normal=spahn",
                                     "remedy.tc=1e-6", "remedy.jam_after=5", "chamber.rpm=10"};
  const double plain = bytes(GAS, "");
  for (size_t k = 0; k < sizeof free / sizeof *free; k++)
    assert_true(bytes(GAS, free[k]) == plain);
  assert_true(bytes(GAS, "contact.rule=friction") == plain + sizeof(struct em_vec));
}

/* A dense gas, in which lists of neighbours are used, keeps within 400 bytes per ball, however long
 * it runs: lists that were long give their room back. */
static void test_lists_stay_small(void **state) {
  (void)state;
  static const char dense[] =
      "duration = 1e9; gravity = \"none\"; contact = { rule = \"smooth\"; normal = 1.0; };"
      "chamber = { shape = \"box\"; size = [10.16, 10.16, 10.16]; periodic = [true, true, true]; };"
      "balls = { count = 1000; diameter = 1.0; speed = 1.0; start = \"lattice\"; };";
  struct trial t;
  trial_open(&t, dense, "%s", "engine.partition=neighbours");
  trial_collide(&t, 600000);
  assert_true(em_world_bytes_per_ball(t.world) < 400.0);
  trial_valid(&t, 1e-12);
  trial_free(&t);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_spins),
      cmocka_unit_test(test_masses),
      cmocka_unit_test(test_variants),
      cmocka_unit_test(test_names),
      cmocka_unit_test(test_unread),
      cmocka_unit_test(test_bytes),
      cmocka_unit_test(test_lists_stay_small),
      cmocka_unit_test(test_idle_remedy),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
