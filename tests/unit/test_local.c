/* The local lists: every kind against a plain array of all predictions. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "event/local.h"

enum { KINDS = EM_LISTS_COUNT, BALLS = 5, ROOM = 4000 };

/* xorshift64*: the same numbers on every machine. */
static uint32_t draw_below(uint64_t *state, uint32_t n) {
  *state ^= *state >> 12;
  *state ^= *state << 25;
  *state ^= *state >> 27;
  return (uint32_t)((*state * UINT64_C(2685821657736338717) >> 32) % n);
}

/* All predictions of one ball, in the order in which they were entered. */
struct plain {
  struct em_prediction entry[ROOM];
  size_t size;
};

static size_t plain_first(const struct plain *plain) {
  size_t found = 0;
  for (size_t k = 1; k < plain->size; k++) {
    const struct em_prediction *a = &plain->entry[k], *b = &plain->entry[found];
    if (a->time < b->time || (a->time == b->time && a->partner < b->partner)) found = k;
  }
  return found;
}

static void plain_pop(struct plain *plain, bool keeps_all) {
  if (plain->size == 0) return;
  const size_t gone = plain_first(plain);
  plain->size--;
  memmove(&plain->entry[gone], &plain->entry[gone + 1],
          (plain->size - gone) * sizeof plain->entry[0]);
  if (!keeps_all) plain->size = 0;
}

static void check(const struct em_local_kind *kind, const struct em_local *local,
                  const struct plain *plain, uint32_t ball) {
  assert_true(kind->is_valid(local, ball));
  const struct em_prediction *first = kind->first(local, ball);
  if (plain->size == 0) {
    assert_null(first);
    return;
  }
  const struct em_prediction *expected = &plain->entry[plain_first(plain)];
  assert_non_null(first);
  assert_true(first->time == expected->time);
  assert_int_equal(first->partner, expected->partner);
  assert_int_equal(first->made, expected->made);
}

static struct em_plan plans[BALLS];

static void try_random(const struct em_local_kind *kind, uint32_t times, uint32_t partners,
                       uint64_t seed) {
  static struct plain plain[BALLS];
  struct em_local *local = kind->make(BALLS, plans);
  assert_non_null(local);
  uint64_t state = seed;
  for (uint32_t ball = 0; ball < BALLS; ball++)
    plain[ball].size = 0;
  for (uint32_t step = 0; step < 20000; step++) {
    const uint32_t ball = draw_below(&state, BALLS);
    const uint32_t dice = draw_below(&state, 100);
    struct plain *p = &plain[ball];
    if (dice < 2 || p->size == ROOM) {
      kind->clear(local, ball);
      p->size = 0;
    } else if (dice < 30) {
      kind->pop(local, ball);
      plain_pop(p, kind->keeps_all);
    } else if (dice < 33) {
      const struct em_prediction never = {INFINITY, 1, step};
      assert_true(kind->add(local, ball, &never));
    } else {
      const struct em_prediction entry = {(double)draw_below(&state, times),
                                          draw_below(&state, partners), step};
      assert_true(kind->add(local, ball, &entry));
      p->entry[p->size++] = entry;
    }
    for (uint32_t n = 0; n < BALLS; n++)
      check(kind, local, &plain[n], n);
  }
  kind->free(local);
}

static void test_against_plain_array(void **unused) {
  (void)unused;
  for (int k = 0; k < KINDS; k++) {
    const struct em_local_kind *kind = em_local_find((enum em_lists)k);
    try_random(kind, 1u << 30, 1000, 1);
    try_random(kind, 10, 100, 2);
    try_random(kind, 3, 2, 3);
    try_random(kind, 1, 1, 4);
  }
}

/* Entered in either order, equal times give the smaller partner. */
static void test_order_of_entry_does_not_matter(void **unused) {
  (void)unused;
  const struct em_prediction a = {1.0, 7, 0}, b = {1.0, 3, 0}, wall = {1.0, UINT32_MAX, 0};
  for (int k = 0; k < KINDS; k++) {
    const struct em_local_kind *kind = em_local_find((enum em_lists)k);
    struct em_local *local = kind->make(2, plans);
    const struct em_prediction *order[2][3] = {{&a, &b, &wall}, {&wall, &b, &a}};
    for (uint32_t ball = 0; ball < 2; ball++)
      for (int n = 0; n < 3; n++)
        assert_true(kind->add(local, ball, order[ball][n]));
    for (uint32_t ball = 0; ball < 2; ball++)
      assert_int_equal(kind->first(local, ball)->partner, 3);
    kind->clear(local, 0);
    assert_null(kind->first(local, 0));
    assert_true(kind->add(local, 0, &wall));
    assert_int_equal(kind->first(local, 0)->partner, UINT32_MAX);
    kind->free(local);
  }
}

/* The pool grows when needed, and what was given back is used again. */
static void test_pool_is_reused(void **unused) {
  (void)unused;
  const struct em_local_kind *kind = &em_local_tree;
  struct em_local *local = kind->make(3, plans);
  const size_t before = kind->bytes(local);
  size_t grown = 0;
  for (int round = 0; round < 50; round++) {
    for (uint32_t n = 0; n < 1000; n++) {
      const struct em_prediction entry = {(double)(n * 7919 % 1000), n, n};
      assert_true(kind->add(local, n % 3, &entry));
    }
    for (uint32_t ball = 0; ball < 3; ball++) {
      double last = -1.0;
      for (int n = 0; n < 100; n++) {
        const double t = kind->first(local, ball)->time;
        assert_true(t > last);
        last = t;
        kind->pop(local, ball);
      }
      kind->clear(local, ball);
      assert_null(kind->first(local, ball));
      assert_true(kind->is_valid(local, ball));
    }
    if (round == 0) grown = kind->bytes(local);
  }
  assert_true(grown > before);
  assert_int_equal(kind->bytes(local), grown);
  kind->free(local);
}

static void test_kinds_have_names(void **unused) {
  (void)unused;
  assert_null(em_local_find(EM_LISTS_COUNT));
  for (int k = 0; k < KINDS; k++)
    assert_non_null(em_local_find((enum em_lists)k)->name);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_against_plain_array),
      cmocka_unit_test(test_order_of_entry_does_not_matter),
      cmocka_unit_test(test_pool_is_reused),
      cmocka_unit_test(test_kinds_have_names),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
