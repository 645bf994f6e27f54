/* The global lists: every kind against a plain scan, and against each other. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "event/body.h"
#include "event/queue.h"

enum { KINDS = EM_LISTS_COUNT, SMALL = 40 };

/* xorshift64*: the same numbers on every machine. */
static uint64_t draw_bits(uint64_t *state) {
  *state ^= *state >> 12;
  *state ^= *state << 25;
  *state ^= *state >> 27;
  return *state * UINT64_C(2685821657736338717);
}

static double draw(uint64_t *state) {
  return (double)(draw_bits(state) >> 11) * 0x1p-53;
}

static uint32_t draw_below(uint64_t *state, uint32_t n) {
  return (uint32_t)(draw_bits(state) % n);
}

/* Waiting times of several characters, chosen by `shape`. */
enum { SHAPES = 7 };
static double wait_time(uint64_t *state, int shape) {
  const double u = draw(state);
  switch (shape) {
  case 0:
    return -log1p(-u); /* a gas */
  case 1:
    return u; /* uniform */
  case 2:
    return floor(8.0 * u); /* many ties, zero among them */
  case 3:
    return 0.0; /* everything at once */
  case 4:
    return u < 0.5 ? 1e-9 * u : 1e6 * u; /* two scales, far apart */
  case 5:
    return pow(10.0, 40.0 * u - 30.0); /* all scales */
  default:
    return u < 0.1 ? INFINITY : u < 0.2 ? 1e300 : u; /* many without an event */
  }
}

static uint32_t scan_first(const double *time, uint32_t count) {
  uint32_t found = EM_QUEUE_NOBODY;
  for (uint32_t n = 0; n < count; n++)
    if (time[n] < INFINITY && (found == EM_QUEUE_NOBODY || time[n] < time[found])) found = n;
  return found;
}

static void check_tied(const struct em_queue_kind *kind, struct em_queue *queue, const double *time,
                       uint32_t count) {
  uint32_t ball[SMALL];
  const uint32_t earliest = scan_first(time, count);
  size_t expected = 0;
  for (uint32_t n = 0; n < count; n++)
    if (earliest != EM_QUEUE_NOBODY && time[n] == time[earliest]) expected++;
  assert_int_equal(kind->tied(queue, ball), expected);
  uint64_t seen = 0;
  for (size_t k = 0; k < expected; k++) {
    assert_true(ball[k] < count && time[ball[k]] == time[earliest]);
    seen |= UINT64_C(1) << ball[k];
  }
  assert_int_equal(__builtin_popcountll(seen), expected);
}

static void check_first(const struct em_queue_kind *kind, struct em_queue *queue,
                        const double *time, uint32_t count) {
  double t = -1.0;
  uint32_t rival = EM_QUEUE_NOBODY;
  const uint32_t ball = kind->first(queue, &t, &rival);
  assert_int_equal(ball, scan_first(time, count));
  if (ball == EM_QUEUE_NOBODY) return;
  assert_true(t == time[ball]);
  uint32_t equal = 0;
  for (uint32_t k = 0; k < count; k++)
    equal += time[k] == t;
  if (equal == 1) assert_int_equal(rival, ball);
  if (equal == 2) assert_true(rival > ball && rival < count && time[rival] == t);
  if (equal > 2) assert_int_equal(rival, EM_QUEUE_SEVERAL);
}

/* Of as many balls as any test has; the lists outlive none of it. */
static struct em_plan plans[100000];

/* Random operations on a few balls, everything checked after every one of them. */
static void try_small(const struct em_queue_kind *kind, uint32_t count, int shape, double spacing,
                      uint64_t seed) {
  double time[SMALL];
  uint64_t state = seed;
  struct em_queue *queue = kind->make(count, plans, spacing);
  assert_non_null(queue);
  for (uint32_t n = 0; n < count; n++)
    time[n] = INFINITY;
  double now = 0.0;
  for (int step = 0; step < 400; step++) {
    const uint32_t dice = draw_below(&state, 100);
    const uint32_t earliest = scan_first(time, count);
    if (dice == 0) {
      now = draw(&state) * 10.0 - 5.0;
      kind->clear(queue, now);
      for (uint32_t n = 0; n < count; n++)
        time[n] = INFINITY;
    } else {
      uint32_t ball = draw_below(&state, count);
      double t = now + wait_time(&state, shape);
      if (dice < 50 && earliest != EM_QUEUE_NOBODY) {
        ball = earliest;
        now = time[earliest];
        t = now + wait_time(&state, shape);
      } else if (dice < 60) {
        t = INFINITY;
      } else if (dice < 65) {
        t = now - 1e-9 * draw(&state); /* slightly in the past */
      }
      time[ball] = t;
      kind->set(queue, ball, t);
    }
    assert_true(kind->is_valid(queue));
    if (draw_below(&state, 3)) {
      check_first(kind, queue, time, count);
      assert_true(kind->is_valid(queue));
      check_tied(kind, queue, time, count);
    }
  }
  kind->free(queue);
}

static void test_random_operations(void **unused) {
  (void)unused;
  static const uint32_t counts[] = {1, 2, 3, 7, SMALL};
  static const double spacings[] = {0.03, 1e-200, 1e9, 0.0, INFINITY};
  uint64_t seed = 1;
  for (int k = 0; k < KINDS; k++)
    for (size_t c = 0; c < sizeof counts / sizeof counts[0]; c++)
      for (int shape = 0; shape < SHAPES; shape++)
        for (size_t s = 0; s < sizeof spacings / sizeof spacings[0]; s++)
          for (int again = 0; again < 3; again++)
            try_small(em_queue_find((enum em_lists)k), counts[c], shape, spacings[s], seed++);
}

/* Holds `count` balls for `steps` events, and returns a fingerprint of the sequence. */
static uint64_t fingerprint(const struct em_queue_kind *kind, uint32_t count, uint32_t steps,
                            int shape, double spacing) {
  uint64_t state = 99, print = 0;
  struct em_queue *queue = kind->make(count, plans, spacing);
  assert_non_null(queue);
  for (uint32_t n = 0; n < count; n++)
    kind->set(queue, n, wait_time(&state, shape));
  double last = 0.0;
  for (uint32_t step = 0; step < steps; step++) {
    double now;
    uint32_t rival;
    const uint32_t ball = kind->first(queue, &now, &rival);
    if (ball == EM_QUEUE_NOBODY) break;
    assert_true(now >= last);
    last = now;
    uint64_t bits;
    memcpy(&bits, &now, sizeof bits);
    print = (print ^ bits ^ ball) * UINT64_C(0x9e3779b97f4a7c15);
    print ^= print >> 29;
    kind->set(queue, ball, now + wait_time(&state, shape));
    kind->set(queue, draw_below(&state, count), now + wait_time(&state, shape));
    if (step % (steps / 4) == 0) assert_true(kind->is_valid(queue));
  }
  assert_true(kind->is_valid(queue));
  kind->free(queue);
  return print;
}

static void test_all_kinds_agree(void **unused) {
  (void)unused;
  for (int shape = 0; shape < SHAPES; shape++) {
    const uint64_t tree = fingerprint(&em_queue_tree, 3000, 100000, shape, 1.0);
    for (int k = 0; k < KINDS; k++)
      for (double spacing = 1e-9; spacing < 1e6; spacing *= 1e3)
        assert_true(fingerprint(em_queue_find((enum em_lists)k), 3000, 100000, shape, spacing) ==
                    tree);
  }
}

static void test_a_million_events(void **unused) {
  (void)unused;
  const uint64_t tree = fingerprint(&em_queue_tree, 100000, 1000000, 0, 1e-5);
  assert_true(fingerprint(&em_queue_calendar, 100000, 1000000, 0, 1e-5) == tree);
  assert_true(fingerprint(&em_queue_calendar, 100000, 1000000, 0, 10.0) == tree);
  assert_true(fingerprint(&em_queue_calendar, 100000, 1000000, 0, 1e-20) == tree);
}

/* The order of entry does not matter: equal times come by the number of the ball. */
static void test_ties_come_by_number(void **unused) {
  (void)unused;
  enum { COUNT = 1000 };
  uint32_t ball[COUNT];
  for (int k = 0; k < KINDS; k++) {
    const struct em_queue_kind *kind = em_queue_find((enum em_lists)k);
    struct em_queue *queue = kind->make(COUNT, plans, 1.0);
    for (uint32_t n = 0; n < COUNT; n++)
      kind->set(queue, n * 7 % COUNT, 3.0);
    for (uint32_t n = 0; n < COUNT; n++) {
      double t;
      uint32_t rival;
      assert_int_equal(kind->first(queue, &t, &rival), n);
      assert_true(t == 3.0);
      assert_int_equal(kind->tied(queue, ball), COUNT - n);
      kind->set(queue, n, INFINITY);
    }
    double t;
    uint32_t rival;
    assert_int_equal(kind->first(queue, &t, &rival), EM_QUEUE_NOBODY);
    assert_int_equal(kind->tied(queue, ball), 0);
    kind->free(queue);
  }
}

/* As many at one time as there are balls, twice over: where each of them looked through all others,
 * this would take minutes. */
static void test_many_at_one_time(void **unused) {
  (void)unused;
  enum { COUNT = 100000 };
  static uint32_t ball[COUNT];
  for (int k = 0; k < KINDS; k++) {
    const struct em_queue_kind *kind = em_queue_find((enum em_lists)k);
    struct em_queue *queue = kind->make(COUNT, plans, 1.0);
    for (uint32_t n = 0; n < COUNT; n++)
      kind->set(queue, n * 7 % COUNT, 3.0);
    for (uint32_t n = 0; n < 2 * COUNT; n++) {
      double t;
      uint32_t rival;
      assert_int_equal(kind->first(queue, &t, &rival), n % COUNT);
      assert_true(t == (n < COUNT ? 3.0 : 4.0));
      if (n % COUNT == COUNT / 2) assert_int_equal(kind->tied(queue, ball), COUNT / 2);
      kind->set(queue, n % COUNT, t + 1.0);
    }
    kind->free(queue);
  }
}

/* So many entries in one bin, most of which do not hold any more, that all are filed anew: while
 * balls are being put by, and when the next bin begins. */
static void test_no_ball_is_lost(void **unused) {
  (void)unused;
  enum { COUNT = EM_FETCH_FROM, ROOM = 2 * COUNT };
  static uint32_t ball[COUNT];
  struct em_queue *queue = em_queue_calendar.make(COUNT, plans, 1.0);
  for (uint32_t entries = ROOM + 96; entries < ROOM + 192; entries++) {
    double t;
    uint32_t rival;
    em_queue_calendar.clear(queue, 0.0);
    em_queue_calendar.set(queue, 0, 1.0);
    assert_int_equal(em_queue_calendar.first(queue, &t, &rival), 0);
    em_queue_calendar.set(queue, 1, 100.0);
    for (uint32_t k = 0; k < entries; k++)
      em_queue_calendar.set(queue, 2 + k % (COUNT - 2), 20.0);
    em_queue_calendar.set(queue, 0, INFINITY);
    assert_int_equal(em_queue_calendar.tied(queue, ball), COUNT - 2);
  }
  em_queue_calendar.free(queue);
}

static void test_kinds_have_names(void **unused) {
  (void)unused;
  assert_null(em_queue_find(EM_LISTS_COUNT));
  for (int k = 0; k < KINDS; k++)
    assert_non_null(em_queue_find((enum em_lists)k)->name);
  struct em_queue *queue = em_queue_calendar.make(100000, plans, 1.0);
  assert_non_null(queue);
  assert_true(em_queue_calendar.bytes(queue) <= 48 * 100000 + 4096);
  em_queue_calendar.free(queue);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_random_operations), cmocka_unit_test(test_all_kinds_agree),
      cmocka_unit_test(test_a_million_events),  cmocka_unit_test(test_ties_come_by_number),
      cmocka_unit_test(test_many_at_one_time),  cmocka_unit_test(test_no_ball_is_lost),
      cmocka_unit_test(test_kinds_have_names),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
