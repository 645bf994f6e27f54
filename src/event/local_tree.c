/* Local lists that keep all predictions of each ball, in threaded red-black trees whose nodes
 * come from one pool. */
#include <math.h>
#include <stdlib.h>

#include "event/local.h"
#include "event/rbtree.h"

struct em_local {
  uint32_t count;
  uint32_t room;                    /* nodes in the pool */
  uint32_t used;                    /* nodes that were ever in use */
  uint32_t spare;                   /* chain of nodes that were given back, along `next` */
  struct em_rbtree *tree;           /* one per ball */
  struct em_rbnode *node;           /* key: time, rank: partner */
  struct em_prediction *prediction; /* of each node */
};

static void free_local(struct em_local *local) {
  if (!local) return;
  free(local->tree);
  free(local->node);
  free(local->prediction);
  free(local);
}

static bool grow(struct em_local *local, size_t room) {
  if (room > EM_RBTREE_NONE) room = EM_RBTREE_NONE;
  if (room <= local->room) return false;
  struct em_rbnode *node = realloc(local->node, room * sizeof *node);
  if (!node) return false;
  local->node = node;
  struct em_prediction *prediction = realloc(local->prediction, room * sizeof *prediction);
  if (!prediction) return false;
  local->prediction = prediction;
  local->room = (uint32_t)room;
  return true;
}

static struct em_local *make(uint32_t count, struct em_plan *plan) {
  (void)plan;
  enum { PER_BALL = 4, LEAST = 16 };
  struct em_local *local = calloc(1, sizeof *local);
  if (!local) return NULL;
  local->count = count;
  local->spare = EM_RBTREE_NONE;
  local->tree = malloc(((size_t)count + 1) * sizeof *local->tree);
  if (!local->tree || !grow(local, (size_t)count * PER_BALL + LEAST)) {
    free_local(local);
    return NULL;
  }
  for (uint32_t ball = 0; ball < count; ball++)
    em_rbtree_init(&local->tree[ball]);
  return local;
}

/* The whole thread goes to the chain of spare nodes at once. */
static void clear(struct em_local *local, uint32_t ball) {
  struct em_rbtree *tree = &local->tree[ball];
  if (tree->first == EM_RBTREE_NONE) return;
  local->node[tree->last].next = local->spare;
  local->spare = tree->first;
  em_rbtree_init(tree);
}

/* A node nobody uses; EM_RBTREE_NONE: no memory. */
static uint32_t take(struct em_local *local) {
  const uint32_t n = local->spare;
  if (n != EM_RBTREE_NONE) {
    local->spare = local->node[n].next;
    return n;
  }
  if (local->used == local->room && !grow(local, 2 * (size_t)local->room)) return EM_RBTREE_NONE;
  return local->used++;
}

static bool add(struct em_local *local, uint32_t ball, const struct em_prediction *prediction) {
  if (!(prediction->time < INFINITY)) return true;
  const uint32_t n = take(local);
  if (n == EM_RBTREE_NONE) return false;
  local->prediction[n] = *prediction;
  local->node[n].key = prediction->time;
  local->node[n].rank = prediction->partner;
  em_rbtree_insert(&local->tree[ball], local->node, n);
  return true;
}

static const struct em_prediction *first(const struct em_local *local, uint32_t ball) {
  const uint32_t n = local->tree[ball].first;
  return n == EM_RBTREE_NONE ? NULL : &local->prediction[n];
}

static void pop(struct em_local *local, uint32_t ball) {
  const uint32_t n = local->tree[ball].first;
  if (n == EM_RBTREE_NONE) return;
  em_rbtree_remove(&local->tree[ball], local->node, n);
  local->node[n].next = local->spare;
  local->spare = n;
}

static size_t bytes(const struct em_local *local) {
  return sizeof *local + (size_t)local->count * sizeof *local->tree +
         (size_t)local->room * (sizeof *local->node + sizeof *local->prediction);
}

static bool is_valid(const struct em_local *local, uint32_t ball) {
  if (ball >= local->count || local->used > local->room) return false;
  const struct em_rbtree *tree = &local->tree[ball];
  if (!em_rbtree_is_valid(tree, local->node, local->used, NULL)) return false;
  for (uint32_t n = tree->first; n != EM_RBTREE_NONE; n = local->node[n].next) {
    if (local->node[n].key != local->prediction[n].time) return false;
    if (local->node[n].rank != local->prediction[n].partner) return false;
  }
  return true;
}

const struct em_local_kind em_local_tree = {
    .name = "tree",
    .keeps_all = true,
    .make = make,
    .free = free_local,
    .clear = clear,
    .add = add,
    .first = first,
    .pop = pop,
    .bytes = bytes,
    .is_valid = is_valid,
};
