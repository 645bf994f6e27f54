/* Contacts at one time: the heap against a plain scan. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "event/body.h"
#include "support/trial.h"

enum { BALLS = 30, SURFACES = 4 };

/* Pairs before surfaces, each by their numbers. */
static uint64_t rank(uint32_t ball, uint32_t with) {
  const uint64_t low = ball < with ? ball : with, high = ball ^ with ^ low;
  if (with >= EM_SURFACE) return UINT64_C(1) << 62 | (uint64_t)(with - EM_SURFACE) << 32 | ball;
  return low << 32 | high;
}

static void check(const struct em_ties *ties, const uint32_t *with) {
  uint64_t least = UINT64_MAX;
  uint32_t count = 0;
  for (uint32_t i = 0; i < BALLS; i++) {
    uint32_t to_meet = 0, expected = 0;
    for (uint32_t k = 0; k < BALLS; k++)
      expected += with[k] == i;
    for (uint32_t k = ties->tie[i].met; k != EM_NOBODY; k = ties->tie[k].next, to_meet++)
      assert_int_equal(with[k], i);
    assert_int_equal(to_meet, expected);
    if (with[i] == EM_NOBODY) continue;
    count++;
    if (rank(i, with[i]) < least) least = rank(i, with[i]);
  }
  const uint32_t first = em_ties_first(ties);
  assert_int_equal(ties->count, count);
  assert_int_equal(first == EM_NOBODY, count == 0);
  if (count) assert_true(rank(first, with[first]) == least);
}

static void test_random_operations(void **unused) {
  (void)unused;
  struct em_ties ties = {0};
  uint32_t with[BALLS];
  uint64_t seed = 1;
  assert_true(em_ties_make(&ties, BALLS));
  for (int turn = 0; turn < 200; turn++) {
    em_ties_clear(&ties);
    for (uint32_t i = 0; i < BALLS; i++)
      with[i] = EM_NOBODY;
    for (int step = 0; step < 200; step++) {
      const uint32_t i = (uint32_t)(dice_bits(&seed) % BALLS);
      const uint32_t j = (uint32_t)(dice_bits(&seed) % (BALLS + SURFACES));
      em_ties_remove(&ties, i);
      with[i] = EM_NOBODY;
      if (j != i && dice(&seed) < 0.7) {
        with[i] = j < BALLS ? j : EM_SURFACE + (j - BALLS);
        em_ties_add(&ties, i, with[i]);
      }
      check(&ties, with);
    }
  }
  em_ties_free(&ties);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_random_operations)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
