/* Collapses and jams: contacts without end. With a remedy the run goes on at a bounded cost and
 * says how often it acted; without, the engine notices, stops with a message, and the state stays
 * valid. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "event/collapse.h"
#include "eventmill/recorder.h"
#include "support/trial.h"

#define TABLE "balls={diameter=0.02;start=\"table\";table="

/* At most `most` collisions; 0: it has come to `until`. A run that needs more hangs. Overlaps may
 * be up to `overlap` radii. */
static enum em_status play_within(struct trial *t, double until, uint64_t most, double overlap) {
  const enum em_status status = em_world_run_collisions(t->world, until, most, NULL, &t->err);
  if (!status && em_world_time(t->world) < until)
    fail_msg("not done after %llu collisions, at %.9g s", (unsigned long long)most,
             em_world_time(t->world));
  trial_valid(t, overlap * t->balls->radius[0]);
  return status;
}

static enum em_status play(struct trial *t, double until, uint64_t most) {
  return play_within(t, until, most, 1e-12);
}

/* Eight slow pairs far from each other are taken for a collapse as well, with time between their
 * contacts: from the state in which the run ends another one can go on. */
static void slow_pairs(void **state) {
  (void)state;
  struct trial t;
  struct em_snapshot *s;
  trial_scene(&t,
              "gravity=\"none\";chamber={shape=\"box\";size=[1.0,1.0,1.0];};"
              "contact={rule=\"smooth\";normal=0.5;};balls={count=17;diameter=0.015625;};",
              "%s", "");
  trial_balls(&t);
  for (size_t i = 0; i < 17; i++) {
    const double pair = (double)(i / 2), gap = 1e-12 * (pair + 1.0);
    t.balls->position[i] =
        em_vec_make(0.1 * (pair + 1.0) + (i % 2 ? 0.015625 + gap : 0.0), 0.25, 0.25);
    t.balls->velocity[i] = em_vec_make(i == 16 ? 1.0 : i % 2 ? 0.0 : 5e-10, 0.0, 0.0);
  }
  trial_world(&t);
  assert_int_equal(em_world_run(t.world, 1.0, NULL, &t.err), EM_COLLAPSE);
  trial_valid(&t, 1e-12);
  assert_int_equal(em_world_snapshot(t.world, &s, &t.err), EM_OK);
  em_world_free(t.world);
  t.world = NULL;
  if (em_world_resume(&t.world, t.scene, s, &t.err)) fail_msg("%s", t.err.text);
  em_world_snapshot_free(s);
  trial_free(&t);
}

/* Below ε = 7 − 4√3 three balls in line touch without end: noticed while their speeds, which lose a
 * factor each time, still differ. Above it they part. */
static void three_in_line(void **state) {
  (void)state;
  static const char line[] =
      "gravity=\"none\";chamber={shape=\"box\";size=[1.0,0.1,0.1];};contact={rule=\"smooth\";}"
      ";" TABLE "((0.4,0.05,0.05,1.0,0.0,0.0),(0.5,0.05,0.05,0.0,0.0,0.0),"
      "(0.62,0.05,0.05,-0.9,0.0,0.0));};";
  const double threshold = 7.0 - 4.0 * sqrt(3.0);
  uint64_t most = 0, few = UINT64_MAX, noticed = 0;
  for (int k = 1; k <= 100; k++) {
    struct trial t;
    trial_open(&t, line, "contact.normal=%.17g", threshold * k / 50.0);
    const enum em_status status = play(&t, 0.5, 10000);
    if (k != 50) assert_int_equal(status, k < 50 ? EM_COLLAPSE : EM_OK); /* 50: the threshold */
    assert_true(status == EM_OK || strstr(t.err.text, "remedy.tc"));
    noticed += status == EM_COLLAPSE;
    const uint64_t n = em_world_collisions(t.world);
    if (k < 50) most = n > most ? n : most;
    trial_free(&t);
    trial_open(&t, line, "contact.normal=%.17g remedy.tc=1e-4", threshold * k / 50.0);
    assert_int_equal(play(&t, 0.5, 10000), EM_OK);
    if (k < 50) assert_true(em_world_tally(t.world)->tc > 0);
    few = em_world_collisions(t.world) < few ? em_world_collisions(t.world) : few;
    trial_free(&t);
  }
  assert_true(most > 10 && few < most);
  hard_row("three balls in line", "ε from 0 to twice 7 − 4√3", 200, "collapse is noticed; TC acts",
           "noticed %llu times, after at most %llu contacts, %llu with TC",
           (unsigned long long)noticed, (unsigned long long)most, (unsigned long long)few);
}

/* All bounces are over after t0 (1 + e)/(1 − e). */
static void bounce_to_rest(void **state) {
  (void)state;
  double worst = 0.0;
  uint64_t acted = 0;
  for (int k = 1; k <= 18; k++) {
    struct trial t;
    const double e = 0.05 * k, over = sqrt(2.0 * 0.5 / 9.81) * (1.0 + e) / (1.0 - e);
    const char *scene = "geometries/bouncing-ball.cfg";
    trial_open(&t, scene, "contact.normal=%.17g", e);
    assert_int_equal(play(&t, 2.0 * over, 1000000), EM_COLLAPSE);
    assert_non_null(strstr(t.err.text, "remedy.tc"));
    worst = fmax(worst, fabs(em_world_time(t.world) - over) / over);
    trial_free(&t);
    trial_open(&t, scene, "contact.normal=%.17g remedy.tc=1e-4", e);
    assert_int_equal(play(&t, 2.0 * over, 1000000), EM_OK);
    assert_true(em_world_tally(t.world)->tc > 0);
    acted += em_world_tally(t.world)->tc;
    trial_free(&t);
    trial_open(&t, scene, "contact.normal=%.17g remedy.elastic_below=1e-3", e);
    assert_int_equal(play(&t, 2.0 * over, 1000000), EM_OK);
    assert_true(em_world_tally(t.world)->elastic > 0);
    trial_free(&t);
  }
  assert_true(worst < 1e-6);
  hard_row("ball bouncing to rest", "ε 0.05…0.9, no remedy, TC, elastic below 1 mm/s", 54,
           "collapse is noticed, at the time of the closed form; with a remedy the run goes on",
           "time %.1e, TC acted %llu times", worst, (unsigned long long)acted);
}

static void heap(void **state) {
  (void)state;
  static const char scene[] =
      "gravity=[0.0,0.0,-9.81];chamber={shape=\"box\";size=[0.05,0.05,0.1];};"
      "contact={rule=\"smooth\";normal=0.9;};balls={count=300;diameter=0.005;};";
  static const char *const rules[] = {"contact.rule=smooth",
                                      "contact.rule=rough contact.tangential=0.3",
                                      "contact.rule=friction contact.friction=0.5"};
  uint64_t most = 0, acted = 0;
  for (int k = 0; k < 3; k++) {
    struct trial t;
    trial_open(&t, scene, "%s", rules[k]);
    assert_int_equal(play(&t, 5.0, 5000000), EM_COLLAPSE);
    trial_free(&t);
    trial_open(&t, scene, "%s remedy.tc=1e-3", rules[k]);
    const uint64_t seconds = TRIES(1, 10); /* each ball a few contacts per tc, at most */
    assert_int_equal(play(&t, (double)seconds, 300 * 4000 * seconds), EM_OK);
    const uint64_t each = em_world_collisions(t.world) / seconds;
    most = each > most ? each : most;
    acted += em_world_tally(t.world)->tc;
    assert_true(acted > 0);
    trial_free(&t);
  }
  hard_row("heap that cools", "300 balls at constant ε 0.9 under gravity, three rules", 6,
           "collapse is noticed; with TC the run goes on at a bounded cost",
           "%llu collisions per second of the heap, TC acted %llu times", (unsigned long long)most,
           (unsigned long long)acted);
}

static void slow_mill(void **state) {
  (void)state;
  struct trial t;
  trial_open(&t, "geometries/simoloyer-2l.cfg", "rotor.rpm=300 contact.normal=0.8");
  assert_int_equal(play(&t, 1.0, 5000000), EM_COLLAPSE);
  const double when = em_world_time(t.world);
  trial_free(&t);
  trial_open(&t, "geometries/simoloyer-2l.cfg", "rotor.rpm=300 contact.normal=0.8 remedy.tc=1e-5");
  const double until = 0.1 * (double)TRIES(1, 10);
  assert_int_equal(play(&t, until, 20000000), EM_OK);
  assert_true(em_world_tally(t.world)->tc > 0);
  hard_row("mill at 300 rpm", "balls that rest on one another, constant ε 0.8", 2,
           "noticed and said; with TC it goes on", "after %.3g s; TC acts in %.3g of the contacts",
           when, (double)em_world_tally(t.world)->tc / (double)em_world_collisions(t.world));
  trial_free(&t);
}

/* With few balls nothing throws them off the drum again: round they go, in hops that shrink. Each
 * touch adds a rounding to their places. */
static void gliding(void **state) {
  (void)state;
  const int few[] = {1, 10, 100, 300};
  double first = INFINITY;
  uint64_t acted = 0;
  for (int k = 0; k < 4; k++) {
    struct trial t;
    trial_open(&t, "geometries/simoloyer-2l.cfg", "rotor.rpm=1700 balls.count=%d", few[k]);
    assert_int_equal(play_within(&t, 5.0, 20000000, 1e-10), EM_COLLAPSE);
    assert_non_null(strstr(t.err.text, "glides along"));
    assert_non_null(strstr(t.err.text, "remedy.elastic_below=0.001"));
    first = fmin(first, em_world_time(t.world));
    const double until = em_world_time(t.world) + 0.2;
    trial_free(&t);
    trial_open(&t, "geometries/simoloyer-2l.cfg",
               "rotor.rpm=1700 balls.count=%d remedy.elastic_below=0.001", few[k]);
    assert_int_equal(play_within(&t, until, 20000000, 1e-10), EM_OK);
    acted += em_world_tally(t.world)->elastic;
    trial_free(&t);
  }
  assert_true(acted > 0);
  struct trial t;
  trial_open(&t, "geometries/simoloyer-2l.cfg", "rotor.rpm=20000");
  assert_int_equal(play_within(&t, 0.01, 20000000, 1e-10), EM_COLLAPSE);
  assert_non_null(strstr(t.err.text, "goes along with the blade"));
  trial_free(&t);
  hard_row("mill with few balls", "1…300 balls at 1700 rpm come to glide along the drum", 8,
           "noticed and said; with elastic contacts below 1 mm/s it goes on",
           "after %.3g s; the remedy acted %llu times", first, (unsigned long long)acted);
}

/* Runs a scene with its recorder; the warning has to be in the file as well. */
static enum em_status record(struct em_scene *scene, struct em_summary *summary) {
  struct em_error err;
  struct em_run_file *file;
  char path[] = "/tmp/eventmill-hard-XXXXXX";
  close(mkstemp(path));
  const struct em_recorder_options options = {.path = path, .force = true};
  const enum em_status status = em_recorder_run(scene, &options, summary, NULL, &err);
  assert_int_equal(em_run_file_open(&file, path, &err), EM_OK);
  assert_string_equal(em_run_file_state(file)->message, status ? err.text : summary->warning);
  em_run_file_close(file);
  unlink(path);
  return status;
}

/* With Spahn's law, whose ε tends to 1, the balls of a slow mill never come to rest on one another:
 * what rests is told from how high balls can rise. 0: nothing is said. */
static int said(double rpm, double duration) {
  struct em_scene *scene;
  struct em_error err;
  struct em_summary summary = {0};
  char rotor[32], time[32];
  snprintf(rotor, sizeof rotor, "rotor.rpm=%g", rpm);
  snprintf(time, sizeof time, "duration=%g", duration);
  const char *const overrides[] = {rotor, time};
  assert_int_equal(em_scene_read(&scene, "geometries/simoloyer-2l.cfg", 2, overrides, &err), EM_OK);
  record(scene, &summary);
  em_scene_free(scene);
  assert_true(!summary.warning[0] || strstr(summary.warning, "turns too slowly"));
  return atoi(summary.warning); /* it begins with the share, in percent */
}

static void too_slow(void **state) {
  (void)state;
  const double duration = (double)TRIES(4, 20) / 10.0;
  const int slow = said(300.0, duration), fast = said(1700.0, duration);
  assert_true(slow >= 20 && fast == 0);
  hard_row("mill at 300 rpm, Spahn's law", "balls that are not held up, and never quite at rest", 2,
           "said in log and run file; at 1700 rpm nothing is", "%d %% of the balls rest", slow);
}

/* A collapse stops the run with a message, and the run file is whole up to there. */
static void three_said(void **state) {
  (void)state;
  static const char line[] =
      "gravity=\"none\";duration=0.5;chamber={shape=\"box\";size=[1.0,0.1,0.1];};"
      "contact={rule=\"smooth\";normal=0.05;};" TABLE
      "((0.4,0.05,0.05,1.0,0.0,0.0),(0.5,0.05,0.05,0.0,0.0,0.0),(0.62,0.05,0.05,-0.8,0.0,0.0));};";
  static const char *const overrides[] = {"contact.normal=0.05", "contact.normal=0.2",
                                          "remedy.tc=1e-4"};
  static const bool collapses[] = {true, false, false};
  for (int k = 0; k < 3; k++) {
    struct em_scene *scene;
    struct em_error err;
    struct em_summary summary = {0};
    assert_int_equal(em_scene_parse(&scene, line, "line", 1, &overrides[k], &err), EM_OK);
    assert_int_equal(record(scene, &summary), collapses[k] ? EM_COLLAPSE : EM_OK);
    em_scene_free(scene);
  }
  hard_row("three balls, recorded", "ε above and below the threshold, and with TC", 3,
           "the collapse stops the run and is said in the run file, and only there", "0");
}

/* --- jams ------------------------------------------------------------------------------------- */

/* A blade that passes an end wall with `gap` to spare, and balls before it. */
static void open_jam(struct trial *t, double gap, size_t balls, const char *rule, int jam_after,
                     uint64_t *seed) {
  const double a = 0.006;
  trial_scene(t,
              "gravity=\"none\";chamber={shape=\"drum\";diameter=0.06;length=0.1;};"
              "rotor={rpm=1700.0;radius=0.006;reach=0.02;blades=({y=0.05;angle_deg=0.0;});};"
              "contact={tangential=0.9;};"
              "balls={count=4;diameter=0.005;speed=0.0;region={low=[-0.03,0.0,-0.03];"
              "high=[0.03,0.02,0.03];};};",
              "chamber.length=%.17g rotor.blades.y=%.17g contact.rule=%s balls.count=%zu "
              "remedy.jam_after=%d seed=%llu",
              0.1, gap + a, rule, balls, jam_after,
              (unsigned long long)(dice_bits(seed) >> 40) + 1);
  trial_balls(t);
  trial_world(t);
}

static void squeezed(void **state) {
  (void)state;
  static const char *const rules[] = {"rough", "friction", "reichardt2005", "smooth"};
  uint64_t seed = 5, acted = 0, contacts = 0, frozen = 0;
  const uint64_t tries = TRIES(40, 2000);
  for (uint64_t k = 0; k < tries; k++) {
    struct trial t;
    const double gap = 0.005 * (1.0 + dice_power(&seed, 1e-12, 2.0));
    const uint64_t same = seed;
    open_jam(&t, gap, 1 + k % 40, rules[k % 4], 5, &seed);
    assert_int_equal(play(&t, 0.1, 2000000), EM_OK);
    acted += em_world_tally(t.world)->jam;
    contacts += em_world_collisions(t.world);
    trial_free(&t);
    seed = same;
    open_jam(&t, gap, 1 + k % 40, rules[k % 4], 0, &seed);
    const enum em_status status = play(&t, 0.1, 2000000);
    assert_true(status == EM_OK || status == EM_JAM || status == EM_COLLAPSE);
    frozen += status != EM_OK;
    trial_free(&t);
  }
  hard_row("balls squeezed at an end wall", "1…40 balls, gap of 1 + 1e-12…3 diameters, four rules",
           (double)tries, "opens after finitely many contacts, and is counted",
           "remedy in %.2g of the contacts; %llu freeze without it",
           (double)acted / (double)contacts, (unsigned long long)frozen);
}

/* Two balls in line with a bar, between its tip and a facet, which holds them, or the corner
 * between two, which does not. */
static void before_a_corner(void **state) {
  (void)state;
  static const double angle_deg[] = {45.0, 90.0};
  for (int k = 0; k < 2; k++) {
    struct trial t;
    const double angle = angle_deg[k] * M_PI / 180.0;
    trial_scene(&t,
                "chamber={diameter=0.1;length=0.1;facets=4;};gravity=\"none\";"
                "contact={rule=\"smooth\";normal=0.5;};"
                "rotor={radius=0.006;reach=0.0439999;blades=({y=0.05;});};"
                "balls={count=2;diameter=0.003;};",
                "rotor.blades.angle_deg=%.17g", angle_deg[k]);
    trial_balls(&t);
    for (int b = 0; b < 2; b++) {
      const double out = 0.0485 - 1e-8 - (0.003 + 1e-12) * b;
      t.balls->position[b] = em_vec_make(out * sin(angle), 0.05, out * cos(angle));
    }
    trial_world(&t);
    assert_int_equal(em_collapse_report(t.world, 0, 1, 0.0, &t.err), k == 0 ? EM_COLLAPSE : EM_JAM);
    trial_free(&t);
  }
}

/* Packed so full that the blade has nowhere to go. */
static void no_exit(void **state) {
  (void)state;
  uint64_t most = 0;
  for (int k = 0; k < 3; k++) {
    struct trial t;
    trial_open(&t,
               "chamber={shape=\"drum\";diameter=0.06;length=0.05;};"
               "rotor={rpm=1700.0;radius=0.006;reach=0.02;blades=({y=0.025;});};"
               "contact={rule=\"rough\";normal=0.8;tangential=0.5;};"
               "balls={count=900;diameter=0.005;speed=0.1;start=\"lattice\";};",
               "balls.count=%d", 900 + 100 * k);
    assert_int_equal(play(&t, 1.0, 2000000), EM_JAM);
    assert_non_null(strstr(t.err.text, "between a blade and a wall"));
    most = em_world_collisions(t.world) > most ? em_world_collisions(t.world) : most;
    trial_free(&t);
  }
  hard_row("packed mill", "900…1100 balls in a drum that holds 1100: the blade has nowhere to go",
           3, "the jam is reported and the run stops, it never hangs", "at most %llu contacts",
           (unsigned long long)most);
}

/* A ball that rests below the end of a bar without tip is held by the drum alone. */
static void below_the_tip(void **state) {
  (void)state;
  struct trial t;
  trial_open(&t,
             "chamber={diameter=0.1;length=0.1;};gravity=[0.0,0.0,-9.81];"
             "contact={rule=\"smooth\";normal=0.5;};"
             "rotor={radius=0.006;reach=0.025;tip=\"none\";blades=({y=0.05;});};" TABLE
             "((0.0,0.05,-0.038,0.0,0.0,0.0));};",
             "%s", "");
  assert_int_equal(play(&t, 1.0, 2000000), EM_COLLAPSE);
  assert_null(strstr(t.err.text, "jam"));
  trial_free(&t);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(slow_pairs),     cmocka_unit_test(three_in_line),
      cmocka_unit_test(bounce_to_rest), cmocka_unit_test(heap),
      cmocka_unit_test(slow_mill),      cmocka_unit_test(too_slow),
      cmocka_unit_test(three_said),     cmocka_unit_test(gliding),
      cmocka_unit_test(squeezed),       cmocka_unit_test(no_exit),
      cmocka_unit_test(below_the_tip),  cmocka_unit_test(before_a_corner),
  };
  hard_choose();
  return cmocka_run_group_tests(tests, NULL, NULL);
}
