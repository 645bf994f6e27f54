/* Lists, partitions and vector code are choices of speed: each must give the same collisions, to
 * the last bit of every figure that an observer sees, and the same state at the end. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>

#include <cmocka.h>

#include "support/trial.h"

#ifdef LONG_FORM
enum { MANY = 1000000, FEW = 100000, SLOW = 20000 };
#else
enum { MANY = 100000, FEW = 10000, SLOW = 2000 };
#endif

#define MILL "geometries/simoloyer-2l.cfg"

struct variant {
  const char *lists, *partition, *simd;
};
#define AVX2 "true engine.lanes=4"
static const struct variant variant[] = {
    {"calendar", "neighbours", "true"}, {"calendar", "neighbours", "false"},
    {"calendar", "cells", "true"},      {"calendar", "cells", "false"},
    {"calendar", "slices", "true"},     {"calendar", "slices", "false"},
    {"calendar", "none", "true"},       {"calendar", "none", "false"},
    {"tree", "neighbours", "true"},     {"tree", "cells", "true"},
    {"tree", "slices", "true"},         {"tree", "none", "true"},
    {"tree", "neighbours", "false"},    {"tree", "cells", "false"},
    {"tree", "slices", "false"},        {"tree", "none", "false"},
    {"calendar", "neighbours", AVX2},   {"calendar", "cells", AVX2},
};
enum { VARIANTS = sizeof variant / sizeof *variant };

struct outcome {
  uint64_t trail, state, count;
  double last;
};

static struct outcome play(const char *scene, const char *overrides, const struct variant *v,
                           uint64_t collisions) {
  struct trial t;
  struct trail trail;
  trial_open(&t, scene, "%s engine.lists=%s engine.partition=%s engine.simd=%s", overrides,
             v->lists, v->partition, v->simd);
  trail_watch(&trail, t.world);
  trial_collide(&t, collisions);
  trial_valid(&t, 1e-12 * t.balls->radius[0]);
  const struct outcome o = {trail.hash, trail_of_state(t.world), trail.count, trail.last};
  trial_free(&t);
  return o;
}

/* All variants whose bit is set in `which` against the first. */
static void compare(const char *scene, const char *overrides, uint64_t collisions, unsigned which) {
  const struct outcome first = play(scene, overrides, &variant[0], collisions);
  assert_int_equal(first.count, collisions);
  for (unsigned k = 1; k < VARIANTS; k++) {
    if (!(which >> k & 1)) continue;
    const struct outcome other = play(scene, overrides, &variant[k], collisions);
    if (other.trail != first.trail || other.state != first.state || other.count != first.count)
      fail_msg("%s %s: %s, %s, simd %s differs after %.17g s (%.17g s)", scene, overrides,
               variant[k].lists, variant[k].partition, variant[k].simd, other.last, first.last);
  }
}

enum { ALL = 0x3FFFF, NONE = 0x88C0, SLICES = 0x4430, CHEAP = ALL & ~NONE & ~SLICES };

static void test_mill(void **state) {
  (void)state;
#ifdef LONG_FORM
  compare(MILL, "rotor.rpm=1700", MANY, ALL);
#else
  compare(MILL, "rotor.rpm=1700", MANY, CHEAP);
  compare(MILL, "rotor.rpm=1700", FEW, SLICES);
  compare(MILL, "rotor.rpm=1700 balls.count=1000", SLOW, NONE);
#endif
}

static void test_reference_rule(void **state) {
  (void)state;
  compare(MILL, "rotor.rpm=1700 contact.rule=reichardt2005", FEW, CHEAP);
  compare(MILL, "contact.rule=reichardt2005 rotor.tip=none balls.count=1200", FEW, ALL & ~NONE);
}

/* Searches that are content with less find contacts where there are none yet: not more of them with
 * one engine than with another. */
static void test_knobs(void **state) {
  (void)state;
  const unsigned some = 1u << 2 | 1u << 8 | 1u << 9;
  compare(MILL, "rotor.rpm=1700 engine.tolerance=1e-3", 3 * FEW, some);
  compare(MILL, "rotor.rpm=1700 engine.shortcut=1", 3 * FEW, some);
}

static void test_tips(void **state) {
  (void)state;
  compare(MILL, "rotor.rpm=-800 rotor.tip=hemisphere contact.rule=friction", FEW, CHEAP);
  compare(MILL, "rotor.rpm=2000 contact.rule=smooth balls.count=600", SLOW, ALL);
}

static void test_two_rotors(void **state) {
  (void)state;
  compare("geometries/two-rotors.cfg", "balls.count=2500", FEW, CHEAP);
}

static void test_drum_gas(void **state) {
  (void)state;
  compare("geometries/ideal-gas.cfg", "balls.count=800", FEW, ALL & ~NONE);
  compare("geometries/ideal-gas-gravity.cfg", "balls.count=400", SLOW, ALL);
}

static const char periodic_box[] =
    "gravity=\"none\";chamber={shape=\"box\";size=[0.05,0.06,0.07];periodic=true;};"
    "contact={rule=\"smooth\";normal=1.0;};balls={count=1000;diameter=0.005;};";

static void test_periodic(void **state) {
  (void)state;
  compare(periodic_box, "", FEW, ALL & ~NONE);
  compare(periodic_box, "balls.count=200", SLOW, ALL);
  compare(periodic_box, "contact.rule=rough contact.tangential=-1.0", SLOW, CHEAP);
}

/* So large that memory is asked for ahead, or before a contact. */
static const char large_box[] =
    "gravity=\"none\";chamber={shape=\"box\";size=[0.16,0.16,0.16];periodic=true;};"
    "contact={rule=\"smooth\";normal=1.0;};balls={count=27000;diameter=0.005;};";

static void test_large(void **state) {
  (void)state;
  compare(large_box, "", 3 * FEW, CHEAP);
  compare(large_box, "balls.count=8000", FEW, CHEAP);
  compare(large_box, "balls.diameter=0.003 gravity=[0.0,0.0,-9.81]", FEW, CHEAP);
}

static const char mixed_box[] =
    "chamber={shape=\"box\";size=[0.08,0.05,0.06];};"
    "contact={rule=\"rough\";normal=0.999;tangential=0.98;};"
    "balls=({name=\"large\";count=40;diameter=0.01;density=7850.0;speed=2.0;},"
    "{name=\"small\";count=900;diameter=0.003;density=2500.0;speed=1.0;});";

static void test_mixed_box(void **state) {
  (void)state;
  compare(mixed_box, "", FEW, ALL & ~NONE);
  compare(mixed_box, "gravity=[3.0,-4.0,-9.81]", SLOW, ALL);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_mill),     cmocka_unit_test(test_reference_rule),
      cmocka_unit_test(test_tips),     cmocka_unit_test(test_two_rotors),
      cmocka_unit_test(test_drum_gas), cmocka_unit_test(test_periodic),
      cmocka_unit_test(test_large),    cmocka_unit_test(test_mixed_box),
      cmocka_unit_test(test_knobs),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
