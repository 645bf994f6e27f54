/* Contacts at one and the same time: worked off by class, then by index, so that a run is a
 * function of its scene; what physics conserves is conserved, and where contacts do not depend on
 * each other the numbering of the balls does not matter. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "support/trial.h"

static const char lab[] = "gravity=\"none\";chamber={shape=\"box\";size=[1.28,1.28,1.28];};"
                          "contact={rule=\"smooth\";normal=1.0;};"
                          "balls={count=51;diameter=0.015625;start=\"lattice\";};";

static void still(struct trial *t, size_t i, double x, double y, double z) {
  t->balls->position[i] = em_vec_make(x, y, z);
  t->balls->velocity[i] = em_vec_make(0.0, 0.0, 0.0);
}

/* Fifty balls that touch in a row: the last one leaves with the speed of the first, whatever the
 * order in which they are numbered. */
static void cradle(void **state) {
  (void)state;
  uint64_t seed = 1;
  double worst = 0.0;
  for (int k = 0; k < 100; k++) {
    struct trial t;
    const double d = 0.015625; /* 2^-6: touching to the last bit */
    size_t place[51];
    trial_scene(&t, lab, "%s", "");
    trial_balls(&t);
    for (size_t i = 0; i < 51; i++)
      place[i] = i;
    for (size_t i = 50; k > 0 && i > 0; i--) {
      const size_t j = dice_bits(&seed) % (i + 1), swap = place[i];
      place[i] = place[j], place[j] = swap;
    }
    for (size_t i = 0; i < 51; i++)
      still(&t, place[i], 0.25 + d * (double)i, 0.5, 0.5);
    t.balls->position[place[0]].x -= 0.0625;
    t.balls->velocity[place[0]].x = 1.0;
    trial_world(&t);
    trial_run(&t, 0.09375);
    trial_state(&t);
    assert_int_equal(em_world_collisions(t.world), 50);
    for (size_t i = 0; i < 51; i++)
      worst = fmax(worst, fabs(t.balls->velocity[place[i]].x - (i == 50 ? 1.0 : 0.0)));
    trial_free(&t);
  }
  assert_true(worst == 0.0);
  hard_row("Newton's cradle of 50", "49 contacts at one time, 100 numberings", 100,
           "the last ball has the speed of the first, the others rest", "speed %.1e", worst);
}

/* A lattice of pairs that all meet at the same time: each exchanges its velocities. */
static void lattice(void **state) {
  (void)state;
  uint64_t first = 0;
  static const char *const engines[] = {"",
                                        "engine.lists=tree",
                                        "engine.partition=cells",
                                        "engine.partition=slices",
                                        "engine.simd=false",
                                        "engine.lists=tree engine.partition=none"};
  double worst = 0.0;
  for (size_t k = 0; k < sizeof engines / sizeof *engines; k++) {
    struct trial t;
    struct trail trail;
    trial_scene(&t, lab, "balls.count=2000 %s", engines[k]);
    trial_balls(&t);
    for (size_t i = 0; i < 2000; i++) {
      const size_t pair = i / 2;
      const double side = i % 2 ? 1.0 : -1.0;
      still(&t, i, 0.125 * (double)(pair % 10) + 0.0625 + side * 0.015625,
            0.125 * (double)(pair / 10 % 10) + 0.0625, 0.125 * (double)(pair / 100) + 0.0625);
      t.balls->velocity[i].x = -side;
    }
    trial_world(&t);
    trail_watch(&trail, t.world);
    trial_run(&t, 0.01);
    assert_int_equal(trail.count, 1000);
    trial_state(&t);
    for (size_t i = 0; i < 2000; i++)
      worst = fmax(worst, fabs(t.balls->velocity[i].x - (i % 2 ? 1.0 : -1.0)));
    trial_run(&t, 2.0);
    trial_valid(&t, 1e-12 * 0.015625);
    if (k == 0) first = trail.hash;
    assert_true(trail.hash == first);
    trial_free(&t);
  }
  assert_true(worst == 0.0);
  hard_row("lattice of pairs", "1000 contacts at one time, again and again, six engines", 6,
           "the same sequence with every engine; each pair exchanges its velocities", "speed %.1e",
           worst);
}

/* 40 000 balls fall onto the floor from one height, and half of them meet in threes before, the
 * outer ones running into the one at rest. Where each contact looked through all others at its
 * time, this would take minutes. */
static void crowd(void **state) {
  (void)state;
  enum { SIDE = 200, BALLS = SIDE * SIDE, THREES = 99 };
  static const char *const engines[] = {"", "engine.lists=tree", "engine.lists=all",
                                        "engine.partition=cells engine.simd=false"};
  uint64_t first = 0, all = 0;
  for (size_t k = 0; k < sizeof engines / sizeof *engines; k++) {
    struct trial t;
    struct trail trail;
    trial_scene(&t, lab, "balls.count=%d gravity=[0,0,-1] chamber.size=[25,25,1] %s", BALLS,
                engines[k]);
    trial_balls(&t);
    for (size_t i = 0; i < BALLS; i++) {
      const double x = 0.125 * (double)(i % SIDE) + 0.0625, y = 0.125 * (double)(i / SIDE) + 0.0625;
      still(&t, i, x, y, 0.25);
      if (i % SIDE < THREES) t.balls->velocity[i].x = 1.0 - (double)(i % SIDE % 3);
    }
    trial_world(&t);
    trail_watch(&trail, t.world);
    trial_run(&t, 2.0);
    trial_valid(&t, 1e-12 * 0.015625);
    if (k == 0) first = trail.hash, all = trail.count;
    assert_true(trail.hash == first && trail.count == all);
    trial_free(&t);
  }
  assert_true(all > 4 * BALLS / 2);
  hard_row("crowd", "40000 balls fall, half of them meet in threes: all at one time", 4,
           "the same sequence with four engines, as fast as contacts apart", "%llu contacts",
           (unsigned long long)all);
}

/* Balls that run symmetrically into one point, n at once: momentum and energy. */
static void stars(void **state) {
  (void)state;
  double worst = 0.0;
  int tries = 0;
  for (size_t n = 2; n <= 12; n++) {
    for (int turn = 0; turn < 20; turn++, tries++) {
      struct trial t;
      trial_scene(&t, lab, "balls.count=%zu", n);
      trial_balls(&t);
      for (size_t i = 0; i < n; i++) {
        const double phi = 2.0 * M_PI * (double)i / (double)n + 0.1 * turn;
        const struct em_vec e = {cos(phi), sin(phi), 0.0};
        t.balls->position[i] = em_vec_axpy(em_vec_make(0.5, 0.5, 0.5), 0.125, e);
        t.balls->velocity[i] = em_vec_scale(-1.0, e);
      }
      trial_world(&t);
      const double energy = trial_energy(&t);
      trial_run(&t, 0.3);
      struct em_vec sum = {0.0, 0.0, 0.0};
      trial_state(&t);
      for (size_t i = 0; i < n; i++)
        sum = em_vec_add(sum, t.balls->velocity[i]);
      assert_true(em_world_collisions(t.world) >= n / 2);
      trial_valid(&t, 1e-12 * 0.015625);
      worst = fmax(worst, em_vec_norm(sum) / (double)n);
      worst = fmax(worst, fabs(trial_energy(&t) - energy) / energy);
      trial_free(&t);
    }
  }
  assert_true(worst < 1e-14);
  hard_row("stars", "2…12 balls run into one point at once", tries,
           "momentum and energy; no overlap", "%.1e", worst);
}

/* Head on, three in a row: the outer ones run into the one at rest. Which contact comes first is a
 * choice (the pair with the smaller index); speeds go through the middle, and come out mirrored. */
static void head_on(void **state) {
  (void)state;
  double worst = 0.0;
  for (int order = 0; order < 6; order++) {
    struct trial t;
    static const size_t orders[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2},
                                        {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
    trial_scene(&t, lab, "%s", "balls.count=3");
    trial_balls(&t);
    const size_t *place = orders[order];
    for (size_t i = 0; i < 3; i++)
      still(&t, place[i], 0.25 + 0.0625 * (double)i, 0.5, 0.5);
    t.balls->velocity[place[0]].x = 1.0;
    t.balls->velocity[place[2]].x = -1.0;
    trial_world(&t);
    trial_run(&t, 0.15);
    trial_state(&t);
    worst = fmax(worst, fabs(t.balls->velocity[place[0]].x + 1.0));
    worst = fmax(worst, fabs(t.balls->velocity[place[1]].x));
    worst = fmax(worst, fabs(t.balls->velocity[place[2]].x - 1.0));
    trial_free(&t);
  }
  assert_true(worst == 0.0);
  hard_row("head-on three-body", "two contacts of one ball at one time, all numberings", 6,
           "mirrored, independent of the numbering", "speed %.1e", worst);
}

struct order {
  size_t count;
  struct em_contact contact[8];
};

static void note(void *self, const struct em_contact *contact) {
  struct order *order = self;
  assert_true(order->count < 8);
  order->contact[order->count++] = *contact;
}

/* Contacts at one time in their documented order: balls with balls first, by the smaller number,
 * then walls, by the wall and the ball. All times are powers of two, so that they are equal. */
static void order_of_contacts(void **state) {
  (void)state;
  enum { BALLS = 10, CONTACTS = 7, NUMBERINGS = 200 };
  uint64_t seed = 5;
  for (int k = 0; k < NUMBERINGS; k++) {
    struct trial t;
    struct order order = {.count = 0};
    const double r = 0.0078125, way = 0.125;
    size_t place[BALLS];
    trial_scene(&t, lab, "balls.count=%d", BALLS);
    trial_balls(&t);
    for (size_t i = 0; i < BALLS; i++)
      place[i] = i;
    for (size_t i = BALLS - 1; i > 0; i--) {
      const size_t j = dice_bits(&seed) % (i + 1), swap = place[i];
      place[i] = place[j], place[j] = swap;
    }
    for (size_t i = 0; i < 6; i++) { /* three pairs */
      const double side = i % 2 ? 1.0 : -1.0;
      still(&t, place[i], 0.5 + side * (way + r), 0.5, 0.25 * (double)(1 + i / 2));
      t.balls->velocity[place[i]].x = -side;
    }
    for (size_t i = 6; i < BALLS; i++) { /* two against each of two walls */
      const double at = 0.25 * (double)(1 + i % 2);
      still(&t, place[i], i < 8 ? r + way : at, i < 8 ? at + 0.25 : r + way, 0.875);
      if (i < 8)
        t.balls->velocity[place[i]].x = -1.0;
      else
        t.balls->velocity[place[i]].y = -1.0;
    }
    trial_world(&t);
    const struct em_observer observer = {.self = &order, .contact = note};
    assert_int_equal(em_world_observe(t.world, &observer), EM_OK);
    trial_run(&t, 0.1875);
    assert_int_equal(order.count, CONTACTS);
    for (size_t c = 0; c < CONTACTS; c++) {
      const struct em_contact *b = &order.contact[c];
      assert_true(b->time == way);
      assert_int_equal(b->cls == EM_CLASS_BALL, c < 3);
      if (c == 0 || c == 3) continue;
      const struct em_contact *a = b - 1;
      if (b->cls == EM_CLASS_BALL)
        assert_true(a->ball < b->ball);
      else
        assert_true(a->partner < b->partner || (a->partner == b->partner && a->ball < b->ball));
    }
    trial_free(&t);
  }
  hard_row("order at one time", "three pairs and four contacts with walls at one time, numberings",
           NUMBERINGS, "balls before walls, each by their numbers", "%s", "as documented");
}

static int by_pair(const void *a, const void *b) {
  const uint32_t *p = a, *q = b;
  return p[0] != q[0] ? (p[0] > q[0]) - (p[0] < q[0]) : (p[1] > q[1]) - (p[1] < q[1]);
}

/* The corners of a square run towards its middle: each meets two others at one time, and which of
 * them goes first must not depend on where they stand among its candidates. All numberings. */
static void square(void **state) {
  (void)state;
  static const char *const engines[] = {"engine.partition=cells", "engine.partition=neighbours",
                                        "engine.partition=cells engine.lanes=4",
                                        "engine.partition=cells engine.simd=false"};
  const size_t kinds = sizeof engines / sizeof *engines;
  for (size_t k = 0; k < 256 * kinds; k++) {
    const uint32_t place[4] = {k & 3, k >> 2 & 3, k >> 4 & 3, k >> 6 & 3};
    if ((1 << place[0] | 1 << place[1] | 1 << place[2] | 1 << place[3]) != 15) continue;
    struct trial t;
    struct order order = {.count = 0};
    uint32_t pair[4][2];
    trial_scene(&t, lab, "balls.count=4 balls.diameter=0.25 chamber.size=[1,1,1] %s",
                engines[k / 256]);
    trial_balls(&t);
    for (size_t i = 0; i < 4; i++) { /* one after the other round the square */
      const double x = i == 0 || i == 3 ? -1.0 : 1.0, y = i < 2 ? -1.0 : 1.0;
      const uint32_t next = place[(i + 1) % 4];
      still(&t, place[i], 0.5 + 0.25 * x, 0.5 + 0.25 * y, 0.5);
      t.balls->velocity[place[i]] = em_vec_make(-x, -y, 0.0);
      pair[i][0] = place[i] < next ? place[i] : next;
      pair[i][1] = place[i] ^ next ^ pair[i][0];
    }
    qsort(pair, 4, sizeof *pair, by_pair);
    trial_world(&t);
    const struct em_observer observer = {.self = &order, .contact = note};
    assert_int_equal(em_world_observe(t.world, &observer), EM_OK);
    trial_run(&t, 0.1875);
    assert_int_equal(order.count, 4);
    for (size_t c = 0; c < 4; c++) {
      assert_true(order.contact[c].time == 0.125);
      assert_int_equal(order.contact[c].ball, pair[c][0]);
      assert_int_equal(order.contact[c].partner, pair[c][1]);
    }
    trial_free(&t);
  }
  hard_row("square", "each of four meets two at one time, all numberings, four engines", 96,
           "the pairs by their numbers", "%s", "as documented");
}

/* Balls 0 and 1 run into ball 2 at one time. It has come to rest there since ball 0 was asked for
 * its events, and ball 1, back from a wall, was asked last: that ball 0 will be met ball 2 alone
 * may know. Whoever knows, and whether all are asked again or not, 0 goes before 1. */
static void unheard(void **state) {
  (void)state;
  static const char *const engines[] = {
      "engine.partition=cells",  "engine.partition=neighbours",
      "engine.partition=slices", "engine.partition=none engine.simd=false",
      "engine.lists=all",        "engine.lists=tree engine.partition=none"};
  static const double stops[] = {0.0, 0.1875, 0.375};
  const double d = 0.015625, speed = 4.0 - 6.0 * d, wall = 2.0 - 0.5 * d;
  const size_t kinds = sizeof engines / sizeof *engines;
  for (size_t k = 0; k < 3 * kinds; k++) {
    struct trial t;
    struct order order = {.count = 0};
    trial_scene(&t, lab, "balls.count=4 chamber.size=[2,2,2] %s", engines[k / 3]);
    trial_balls(&t);
    still(&t, 0, 0.5 - d, 1.0, 1.0);
    still(&t, 1, wall - 0.25 * speed, 1.0, 1.0);
    still(&t, 2, 1.0, 1.0, 1.125);
    still(&t, 3, 1.0, 1.0, 1.0 - d);
    t.balls->velocity[0].x = 1.0;
    t.balls->velocity[1].x = speed;
    t.balls->velocity[2].z = -1.0;
    trial_world(&t);
    const struct em_observer observer = {.self = &order, .contact = note};
    assert_int_equal(em_world_observe(t.world, &observer), EM_OK);
    trial_run(&t, stops[k % 3]);
    struct em_snapshot *s;
    assert_int_equal(em_world_snapshot(t.world, &s, &t.err), EM_OK);
    if (k % 3) {
      em_world_free(t.world);
      t.world = NULL;
      assert_int_equal(em_world_resume(&t.world, t.scene, s, &t.err), EM_OK);
      assert_int_equal(em_world_observe(t.world, &observer), EM_OK);
    }
    em_world_snapshot_free(s);
    trial_run(&t, 0.5625);
    assert_int_equal(order.count, 5);
    for (uint32_t c = 2; c < 5; c++) {
      assert_true(order.contact[c].time == 0.5);
      assert_int_equal(order.contact[c].ball, c == 3);
      assert_int_equal(order.contact[c].partner, 2);
    }
    trial_free(&t);
  }
  hard_row("unheard", "one of two contacts at one time is known to one ball alone, six engines",
           (double)(3 * kinds), "the pairs by their numbers", "%s", "as documented");
}

/* The chambers in which a ball is to meet a wall and another ball at once. */
static const struct chamber {
  const char *words; /* of its scene */
  bool box, flat;    /* flat: it has a floor */
  double fall;       /* m/s² */
} chambers[] = {
    {"gravity=[0,0,-9.81]", true, true, 9.81},
    {"chamber={shape=\"drum\";diameter=1;length=1;}", false, false, 0.0},
    {"chamber={shape=\"drum\";diameter=1;length=1;} engine.polish=quad", false, false, 0.0},
    {"gravity=[0,0,-9.81] chamber={shape=\"drum\";diameter=1;length=1;facets=6;}", false, true,
     9.81},
};

/* Ball 0 flies to the wall below in the time `way`, ball 1 to where it is then. */
static void meet_at_wall(struct trial *t, const struct chamber *c, double way, uint64_t *seed) {
  const double r = 0.03125, rho = 0.5 - r;
  const struct em_vec g = {0.0, 0.0, -c->fall};
  struct em_vec *x = t->balls->position, *v = t->balls->velocity, e;
  struct em_vec end = {dice_in(seed, -0.1, 0.1), dice_in(seed, 0.45, 0.55), -rho};
  if (!c->flat) end.z = -sqrt(rho * rho - end.x * end.x);
  if (c->box) end = em_vec_add(end, em_vec_make(0.5, 0.0, 0.5));
  do
    e = dice_direction(seed);
  while (e.z < 0.1);
  v[0] = em_vec_make(dice_in(seed, -0.5, 0.5), dice_in(seed, -0.5, 0.5), -1.0 - way * c->fall);
  v[1] = em_vec_axpy(v[0], -dice_in(seed, 0.8, 1.2), e);
  x[0] = em_vec_axpy(em_vec_axpy(end, -way, v[0]), -0.5 * way * way, g);
  x[1] = em_vec_axpy(em_vec_axpy(em_vec_axpy(end, 2.0 * r, e), -way, v[1]), -0.5 * way * way, g);
}

/* A wall and another ball at one time but for rounding: which of them goes first does not depend on
 * how far ahead an engine looks for walls. */
static void wall_and_ball(void **state) {
  (void)state;
  static const char *const engines[] = {
      "engine.lists=calendar engine.partition=none", "engine.lists=tree engine.partition=none",
      "engine.partition=cells", "engine.partition=slices", "engine.partition=neighbours"};
  const int kinds = sizeof chambers / sizeof *chambers;
  uint64_t seed = 9;
  enum { TRIES_EACH = 500 };
  for (int k = 0; k < TRIES_EACH * kinds; k++) {
    const struct chamber *c = &chambers[k % kinds];
    const double way = dice_in(&seed, 0.02, 0.15);
    const uint64_t dice_from = seed;
    uint64_t first = 0;
    for (size_t n = 0; n < sizeof engines / sizeof *engines; n++) {
      struct trial t;
      struct trail trail;
      trial_scene(&t, lab, "chamber.size=[1,1,1] balls.count=2 balls.diameter=0.0625 %s %s",
                  c->words, engines[n]);
      trial_balls(&t);
      seed = dice_from;
      meet_at_wall(&t, c, way, &seed);
      trial_world(&t);
      trail_watch(&trail, t.world);
      trial_run(&t, 1.02 * way);
      assert_true(trail.count >= 2);
      if (n == 0) first = trail.hash;
      assert_true(trail.hash == first);
      trial_free(&t);
    }
  }
  hard_row("wall and ball", "both at one time but for rounding, five engines", TRIES_EACH * kinds,
           "the same sequence with every engine", "%s", "none differs");
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(cradle), cmocka_unit_test(lattice), cmocka_unit_test(crowd),
      cmocka_unit_test(stars),  cmocka_unit_test(head_on), cmocka_unit_test(order_of_contacts),
      cmocka_unit_test(square), cmocka_unit_test(unheard), cmocka_unit_test(wall_and_ball),
  };
  hard_choose();
  return cmocka_run_group_tests(tests, NULL, NULL);
}
