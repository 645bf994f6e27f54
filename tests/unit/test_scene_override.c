/* KEY=VALUE: every path that scripts use, in scenes with one or several rotors, species, contacts.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "eventmill/scene.h"

#define BAR "radius = 0.006; reach = 0.058;"

static const char plain[] =
    "chamber = { diameter = 0.146; length = 0.135; };"
    "rotor = { rpm = 1300; " BAR " blades = ({ y = 0.03; }, { y = 0.06; reach = 0.05; }); };"
    "balls = { count = 100; diameter = 0.005; };"
    "contact = { ball-end = { rule = \"smooth\"; normal = 0.5; tangential = 0.1; }; };";

static const char several[] =
    "chamber = { shape = \"box\"; size = [0.3, 0.135, 0.146]; };"
    "rotor = ({ rpm = 1300; point = [0.073, 0, 0.073]; blades = ({ y = 0.03;" BAR "}); },"
    "{ rpm = -1000; point = [0.22, 0, 0.073]; blades = ({ y = 0.03;" BAR "},"
    "{ y = 0.06; rpm = 500;" BAR "}); });"
    "balls = ({ count = 10; diameter = 0.005; name = \"a\"; },"
    "{ count = 20; diameter = 0.006; name = \"b\"; }, { count = 40; diameter = 0.004; });";

/* Reads with up to four overrides, the rest NULL. */
static struct em_scene *with(const char *text, const char *a, const char *b, const char *c,
                             const char *d) {
  const char *const overrides[] = {a, b, c, d};
  size_t count = 0;
  while (count < 4 && overrides[count])
    ++count;
  struct em_scene *scene;
  struct em_error err = {0};
  if (em_scene_parse(&scene, text, "o.cfg", count, overrides, &err) != EM_OK)
    fail_msg("%s", err.text);
  return scene;
}

static void rejected(const char *text, const char *override, const char *message) {
  struct em_scene *scene;
  struct em_error err = {0};
  enum em_status status = em_scene_parse(&scene, text, "o.cfg", 1, &override, &err);
  if (status != EM_INPUT || strncmp(err.text, message, strlen(message)) != 0 ||
      strchr(err.text, '\n'))
    fail_msg("\n%s\nreport %s\nwanted %s", override, err.text, message);
}

static double rpm(const struct em_scene *s, size_t rotor, size_t blade) {
  return round(s->rotor[rotor].blade[blade].omega * 30.0 / M_PI * 1e6) / 1e6;
}

static void plain_entries(void **state) {
  (void)state;
  struct em_scene *s =
      with(plain, "duration=0.25", "seed=4000000000", "gravity=[0,0,-1.6]", "title=a b, c");
  assert_true(s->duration == 0.25 && s->seed == 4000000000u && s->gravity.z == -1.6);
  assert_string_equal(s->title, "a b, c");
  em_scene_free(s);
  s = with(plain, "gravity=none", "balls.count=7", "balls.diameter=0.004", "balls.density=2e3");
  assert_true(s->gravity.z == 0.0 && s->species[0].count == 7);
  assert_true(s->species[0].diameter == 0.004 && s->species[0].density == 2e3);
  em_scene_free(s);
  s = with(plain, "engine.lists=tree", "engine.partition=slices", "engine.accuracy=reference",
           "record.frames=12.5");
  assert_int_equal(s->engine.lists, EM_LISTS_TREE);
  assert_int_equal(s->engine.partition, EM_PARTITION_SLICES);
  assert_int_equal(s->engine.accuracy, EM_ACCURACY_REFERENCE);
  assert_true(s->record.frames == 12.5);
  em_scene_free(s);
  s = with(plain, "record.observables=5", "record.collisions=true", "chamber.ramps.half_deg=10",
           "title=\"with = and ;\"");
  assert_true(s->record.observables == 5.0 && s->record.collisions);
  assert_true(s->chamber.ramp_half == 10.0 * (M_PI / 180.0));
  assert_string_equal(s->title, "with = and ;");
  em_scene_free(s);
}

static void the_last_of_several_holds(void **state) {
  (void)state;
  struct em_scene *s = with(plain, "seed=5", "seed=6", "rotor.rpm=100", "rotor.rpm=200");
  assert_int_equal(s->seed, 6);
  assert_true(rpm(s, 0, 0) == 200.0 && rpm(s, 0, 1) == 200.0);
  em_scene_free(s);
}

static void speed_of_all_rotors(void **state) {
  (void)state;
  struct em_scene *s = with(plain, "rotor.rpm=-800", NULL, NULL, NULL);
  assert_true(rpm(s, 0, 0) == -800.0 && s->rotor[0].rpm == -800.0);
  em_scene_free(s);
  /* Each keeps its sense, a blade of its own speed its ratio. */
  s = with(several, "rotor.rpm=2000", NULL, NULL, NULL);
  assert_true(rpm(s, 0, 0) == 2000.0 && rpm(s, 1, 0) == -2000.0 && rpm(s, 1, 1) == 1000.0);
  em_scene_free(s);
  s = with(several, "rotor.rpm=-2000", NULL, NULL, NULL);
  assert_true(rpm(s, 0, 0) == -2000.0 && rpm(s, 1, 0) == 2000.0 && rpm(s, 1, 1) == -1000.0);
  em_scene_free(s);
  s = with(several, "rotor.1.rpm=300", NULL, NULL, NULL);
  assert_true(rpm(s, 0, 0) == 1300.0 && rpm(s, 1, 0) == 300.0 && rpm(s, 1, 1) == -150.0);
  em_scene_free(s);
  s = with(plain, "rotor.0.rpm=300", NULL, NULL, NULL);
  assert_true(rpm(s, 0, 1) == 300.0);
  em_scene_free(s);
  /* Counter-turning blades on one axis, whose rotor has no speed. */
  s = with("chamber = { diameter = 0.146; length = 0.135; };"
           "rotor = { blades = ({ y = 0.03; rpm = 400;" BAR "}, { y = 0.06; rpm = -400;" BAR "},"
           "{ y = 0.09; rpm = -200;" BAR "}); }; balls = ();",
           "rotor.rpm=1000", NULL, NULL, NULL);
  assert_true(rpm(s, 0, 0) == 1000.0 && rpm(s, 0, 1) == -1000.0 && rpm(s, 0, 2) == -500.0);
  em_scene_free(s);
  /* The fastest counts, not the first. */
  s = with("chamber = { diameter = 0.146; length = 0.135; };"
           "rotor = { blades = ({ y = 0.03; rpm = 200;" BAR "}, { y = 0.06; rpm = -400;" BAR
           "}); };"
           "balls = ();",
           "rotor.rpm=1000", NULL, NULL, NULL);
  assert_true(rpm(s, 0, 0) == 500.0 && rpm(s, 0, 1) == -1000.0);
  em_scene_free(s);
}

static void number_of_all_balls(void **state) {
  (void)state;
  static const struct {
    const char *override;
    size_t count[3];
  } cases[] = {{"balls.count=700", {100, 200, 400}},
               {"balls.count=8", {1, 2, 5}},
               {"balls.count=1", {0, 0, 1}},
               {"balls.count=0", {0, 0, 0}},
               {"balls.1.count=5", {10, 5, 40}}};
  for (size_t k = 0; k < sizeof cases / sizeof cases[0]; ++k) {
    struct em_scene *s = with(several, cases[k].override, NULL, NULL, NULL);
    for (size_t i = 0; i < 3; ++i)
      assert_int_equal(s->species[i].count, cases[k].count[i]);
    em_scene_free(s);
  }
  /* Any total is met exactly. */
  for (int n = 0; n < 200; ++n) {
    char override[32];
    snprintf(override, sizeof override, "balls.count=%d", n);
    struct em_scene *s = with(several, override, NULL, NULL, NULL);
    assert_int_equal(em_scene_ball_count(s), n);
    em_scene_free(s);
  }
}

static void entries_of_all_balls_and_blades(void **state) {
  (void)state;
  struct em_scene *s = with(several, "balls.diameter=0.003", "balls.density=1000", "balls.2.name=c",
                            "rotor.1.blades.0.angle_deg=90");
  for (size_t k = 0; k < 3; ++k)
    assert_true(s->species[k].diameter == 0.003 && s->species[k].density == 1000.0);
  assert_string_equal(s->species[2].name, "c");
  assert_true(s->rotor[1].blade[0].angle == 90.0 * (M_PI / 180.0));
  assert_true(s->rotor[1].blade[1].angle == 0.0);
  em_scene_free(s);
  s = with(several, "rotor.blades.radius=0.005", NULL, NULL, NULL);
  assert_true(s->rotor[0].blade[0].radius == 0.005 && s->rotor[1].blade[1].radius == 0.005);
  em_scene_free(s);
  /* What is set for a rotor holds for all its blades. */
  s = with(several, "rotor.radius=0.004", "rotor.1.reach=0.04", "rotor.tip=none", NULL);
  assert_true(s->rotor[0].blade[0].radius == 0.004 && s->rotor[1].blade[1].radius == 0.004);
  assert_true(s->rotor[0].blade[0].reach == 0.058 && s->rotor[1].blade[1].reach == 0.04);
  assert_int_equal(s->rotor[1].blade[0].tip, EM_TIP_NONE);
  em_scene_free(s);
}

static void contacts_of_all_classes(void **state) {
  (void)state;
  struct em_scene *s = with(plain, "contact.rule=reichardt2005", "contact.normal=0.9",
                            "contact.tangential=0.95", NULL);
  for (int k = 0; k < EM_CLASS_COUNT; ++k) {
    assert_int_equal(s->contact[k].rule, EM_RULE_REICHARDT2005);
    assert_int_equal(s->contact[k].normal.law, EM_LAW_CONSTANT);
    assert_true(s->contact[k].normal.p[0] == 0.9 && s->contact[k].tangential == 0.95);
  }
  em_scene_free(s);
  s = with(plain, "contact.ball-end.normal=spahn", "contact.ball-drum.tangential=-1",
           "contact.normal.A=0.9", "contact.friction=0.4");
  assert_int_equal(s->contact[EM_CLASS_END].normal.law, EM_LAW_SPAHN);
  assert_int_equal(s->contact[EM_CLASS_END].rule, EM_RULE_SMOOTH);
  assert_true(s->contact[EM_CLASS_DRUM].tangential == -1.0);
  assert_true(s->contact[EM_CLASS_BALL].tangential == 0.9);
  assert_true(s->contact[EM_CLASS_BALL].normal.p[0] == 0.9);
  assert_true(s->contact[EM_CLASS_BLADE].friction == 0.4);
  em_scene_free(s);
  s = with(plain, "contact.normal={law=\"salo\"; c=3;}", "contact.normal.c=4", NULL, NULL);
  assert_int_equal(s->contact[EM_CLASS_END].normal.law, EM_LAW_SALO);
  assert_true(s->contact[EM_CLASS_BALL].normal.p[0] == 4.0);
  em_scene_free(s);
}

static void bad_overrides(void **state) {
  (void)state;
  static const char no_rotor[] = "chamber = { diameter = 0.146; length = 0.135; }; balls = ();";
  rejected(plain, "seed", "command line: error: \"seed\": expected KEY=VALUE");
  rejected(plain, "=5", "command line: error: \"=5\": expected KEY=VALUE");
  rejected(plain, "seed=", "command line: error: seed: the value cannot be read, expected a");
  rejected(plain, "gravity=[0,0", "command line: error: gravity: the value cannot be read");
  rejected(plain, "sed=5", "command line: error: sed: unknown entry, expected \"seed\"?");
  rejected(plain, "duration=long",
           "command line: error: duration: found \"long\", expected a number not below 0 (s)");
  rejected(plain, "rotor.rpm=fast",
           "command line: error: rotor.rpm: found \"fast\", expected a number (1/min)");
  rejected(plain, "engine.lists=heap", "command line: error: engine.lists: found \"heap\"");
  rejected(plain, "rotor.rmp=5",
           "command line: error: rotor.rmp: unknown entry, expected \"rpm\"?");
  rejected(plain, "rotor.1.rpm=5", "command line: error: rotor.1.rpm: there is no such element");
  rejected(plain, "rotor.blades.2.y=5",
           "command line: error: rotor.blades.2.y: rotor.blades has 2 elements");
  rejected(plain, "rotor.blades.1=5", "command line: error: rotor.blades.1: is an element");
  rejected(plain, "duration.x=5", "command line: error: duration: found a group { }, expected a");
  rejected(plain, "balls.count.x=5",
           "command line: error: balls.count.x: goes into something that");
  rejected(plain, "seed={}", "command line: error: seed: found a group { }, expected an integer");
  rejected(plain, "rotor.0=5", "command line: error: rotor.0: there is no such element");
  rejected(plain, "a b=5", "command line: error: a b: cannot be set, expected a name made of");
  rejected(no_rotor, "rotor.rpm=5", "command line: error: rotor.rpm: the scene has no rotor");
  rejected(plain, "contact.ball-end.normal.A=1",
           "command line: error: contact.ball-end.normal.A: the law is a number");
  rejected(several, "balls.count=1.5",
           "command line: error: balls.count: expected an integer not below 0");
}

/* A fault of the machine that an override brought about is the command line's. */
static void overrides_are_checked_as_well(void **state) {
  (void)state;
  struct em_scene *scene;
  struct em_error err = {0};
  const char *const override = "rotor.blades.1.reach=0.08";
  assert_int_equal(em_scene_parse(&scene, plain, "o.cfg", 1, &override, &err), EM_INPUT);
  assert_non_null(strstr(err.text, "error: rotor.blades.1: touches the drum wall"));
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(plain_entries),
      cmocka_unit_test(the_last_of_several_holds),
      cmocka_unit_test(speed_of_all_rotors),
      cmocka_unit_test(number_of_all_balls),
      cmocka_unit_test(entries_of_all_balls_and_blades),
      cmocka_unit_test(contacts_of_all_classes),
      cmocka_unit_test(bad_overrides),
      cmocka_unit_test(overrides_are_checked_as_well),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
