/* Threaded red-black trees against a sorted array, and the checker against damaged trees. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "event/rbtree.h"

enum { SMALL = 64 };

/* xorshift64*: the same numbers on every machine. */
static uint64_t draw_bits(uint64_t *state) {
  *state ^= *state >> 12;
  *state ^= *state << 25;
  *state ^= *state >> 27;
  return *state * UINT64_C(2685821657736338717);
}

static uint32_t draw_below(uint64_t *state, uint32_t n) {
  return (uint32_t)((draw_bits(state) >> 32) % n);
}

/* The reference: indices in order; equal ones in the order in which they were entered. */
struct sorted {
  uint32_t index[SMALL];
  size_t size;
};

static int is_before(const struct em_rbnode *a, const struct em_rbnode *b) {
  return a->key < b->key || (a->key == b->key && a->rank < b->rank);
}

static void sorted_insert(struct sorted *sorted, const struct em_rbnode *node, uint32_t n) {
  size_t place = sorted->size++;
  while (place > 0 && is_before(&node[n], &node[sorted->index[place - 1]])) {
    sorted->index[place] = sorted->index[place - 1];
    place--;
  }
  sorted->index[place] = n;
}

static void sorted_remove(struct sorted *sorted, uint32_t n) {
  size_t place = 0;
  while (sorted->index[place] != n)
    place++;
  sorted->size--;
  memmove(&sorted->index[place], &sorted->index[place + 1],
          (sorted->size - place) * sizeof sorted->index[0]);
}

static void compare(const struct em_rbtree *tree, const struct em_rbnode *node,
                    const struct sorted *sorted) {
  size_t size, place = 0;
  assert_true(em_rbtree_is_valid(tree, node, SMALL, &size));
  assert_int_equal(size, sorted->size);
  for (uint32_t n = tree->first; n != EM_RBTREE_NONE; n = node[n].next)
    assert_int_equal(n, sorted->index[place++]);
  assert_int_equal(place, sorted->size);
  for (uint32_t n = tree->last; n != EM_RBTREE_NONE; n = node[n].previous)
    assert_int_equal(n, sorted->index[--place]);
  assert_int_equal(place, 0);
}

static void compare_find(const struct em_rbtree *tree, const struct em_rbnode *node,
                         const struct sorted *sorted, double key) {
  uint32_t expected = EM_RBTREE_NONE;
  for (size_t place = sorted->size; place-- > 0;)
    if (node[sorted->index[place]].key >= key) expected = sorted->index[place];
  assert_int_equal(em_rbtree_find(tree, node, key), expected);
}

/* Random operations with `keys` different keys and `ranks` different ranks, all checked. */
static void try_small(uint32_t keys, uint32_t ranks, uint64_t seed) {
  struct em_rbnode node[SMALL];
  bool inside[SMALL] = {false};
  struct em_rbtree tree;
  struct sorted sorted = {.size = 0};
  uint64_t state = seed;
  em_rbtree_init(&tree);
  compare(&tree, node, &sorted);
  for (int step = 0; step < 3000; step++) {
    /* the tree swells and shrinks */
    const uint32_t reach = step / 500 % 2 ? SMALL / 8 : SMALL;
    uint32_t n = draw_below(&state, SMALL);
    const double key = (double)draw_below(&state, keys);
    if (inside[n] && n < reach && draw_below(&state, 2)) {
      sorted_remove(&sorted, n);
      em_rbtree_move(&tree, node, n, key);
      sorted_insert(&sorted, node, n);
    } else if (inside[n]) {
      em_rbtree_remove(&tree, node, n);
      sorted_remove(&sorted, n);
      inside[n] = false;
    } else if (n < reach) {
      node[n].key = key;
      node[n].rank = draw_below(&state, ranks);
      em_rbtree_insert(&tree, node, n);
      sorted_insert(&sorted, node, n);
      inside[n] = true;
    }
    compare(&tree, node, &sorted);
    compare_find(&tree, node, &sorted, key);
    compare_find(&tree, node, &sorted, INFINITY);
  }
}

static void test_against_sorted_array(void **unused) {
  (void)unused;
  try_small(1u << 31, 1, 1);
  try_small(20, SMALL, 2);
  try_small(5, 3, 3);
  try_small(1, 1, 4);
}

/* Height and order stay right with a million operations. */
static void test_a_million_operations(void **unused) {
  (void)unused;
  enum { COUNT = 20000 };
  struct em_rbnode *node = calloc(COUNT, sizeof *node);
  bool *inside = calloc(COUNT, sizeof *inside);
  struct em_rbtree tree;
  uint64_t state = 7;
  size_t size = 0, found;
  assert_non_null(node);
  assert_non_null(inside);
  em_rbtree_init(&tree);
  for (int step = 0; step < 1000000; step++) {
    const uint32_t n = draw_below(&state, COUNT);
    if (inside[n]) {
      em_rbtree_remove(&tree, node, n);
      size--;
    } else {
      node[n].key = (double)draw_below(&state, 1u << 20);
      node[n].rank = n;
      em_rbtree_insert(&tree, node, n);
      size++;
    }
    inside[n] = !inside[n];
    if (step % 50000 == 0) {
      assert_true(em_rbtree_is_valid(&tree, node, COUNT, &found));
      assert_int_equal(found, size);
    }
  }
  while (tree.first != EM_RBTREE_NONE) {
    em_rbtree_remove(&tree, node, tree.first);
    size--;
  }
  assert_int_equal(size, 0);
  assert_true(em_rbtree_is_valid(&tree, node, COUNT, &found));
  free(node);
  free(inside);
}

static void build(struct em_rbtree *tree, struct em_rbnode *node) {
  em_rbtree_init(tree);
  for (uint32_t n = 0; n < SMALL; n++) {
    node[n].key = (double)(n * 37 % SMALL);
    node[n].rank = 0;
    em_rbtree_insert(tree, node, n);
  }
}

/* Each kind of damage is seen, at every node. */
static void test_damage_is_seen(void **unused) {
  (void)unused;
  struct em_rbnode node[SMALL];
  struct em_rbtree tree;
  build(&tree, node);
  for (uint32_t n = 0; n < SMALL; n++) {
    const struct em_rbnode whole = node[n];
    assert_true(em_rbtree_is_valid(&tree, node, SMALL, NULL));
    node[n].parent ^= 0x80000000u; /* colour */
    assert_false(em_rbtree_is_valid(&tree, node, SMALL, NULL));
    node[n] = whole;
    node[n].key = n == tree.first ? 1e9 : -1e9;
    assert_false(em_rbtree_is_valid(&tree, node, SMALL, NULL));
    node[n] = whole;
    node[n].next = n;
    assert_false(em_rbtree_is_valid(&tree, node, SMALL, NULL));
    node[n] = whole;
    node[n].previous = n;
    assert_false(em_rbtree_is_valid(&tree, node, SMALL, NULL));
    node[n] = whole;
    node[n].parent = (whole.parent & 0x80000000u) | n;
    assert_false(em_rbtree_is_valid(&tree, node, SMALL, NULL));
    node[n] = whole;
    if (whole.left == EM_RBTREE_NONE) continue;
    node[n].left = EM_RBTREE_NONE;
    assert_false(em_rbtree_is_valid(&tree, node, SMALL, NULL));
    node[n] = whole;
  }
  tree.last = tree.first;
  assert_false(em_rbtree_is_valid(&tree, node, SMALL, NULL));
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_against_sorted_array),
      cmocka_unit_test(test_a_million_operations),
      cmocka_unit_test(test_damage_is_seen),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
