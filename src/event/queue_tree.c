/* The global list as a threaded red-black tree: one embedded node per ball. */
#include <assert.h>
#include <math.h>
#include <stdlib.h>

#include "event/queue.h"
#include "event/rbtree.h"

struct em_queue {
  struct em_rbtree tree;
  uint32_t count;
  struct em_rbnode node[]; /* of ball n; key INFINITY: not in the tree */
};

static void clear(struct em_queue *queue, double from) {
  (void)from;
  em_rbtree_init(&queue->tree);
  for (uint32_t n = 0; n < queue->count; n++)
    queue->node[n] = (struct em_rbnode){.key = INFINITY, .rank = n};
}

static struct em_queue *make(uint32_t count, struct em_plan *plan, double spacing) {
  (void)plan;
  (void)spacing;
  if (count >= EM_RBTREE_NONE) return NULL;
  struct em_queue *queue =
      malloc(sizeof(struct em_queue) + (size_t)count * sizeof(struct em_rbnode));
  if (!queue) return NULL;
  queue->count = count;
  clear(queue, 0.0);
  return queue;
}

static void free_queue(struct em_queue *queue) {
  free(queue);
}

static void set(struct em_queue *queue, uint32_t ball, double time) {
  struct em_rbnode *node = queue->node;
  const bool was_in = node[ball].key != INFINITY;
  assert(ball < queue->count && !isnan(time));
  if (was_in && time != INFINITY) {
    em_rbtree_move(&queue->tree, node, ball, time);
    return;
  }
  if (was_in) em_rbtree_remove(&queue->tree, node, ball);
  node[ball].key = time;
  if (time != INFINITY) em_rbtree_insert(&queue->tree, node, ball);
}

/* Equal keys stand in the order of the balls. */
static uint32_t first(struct em_queue *queue, double *time, uint32_t *rival) {
  const struct em_rbnode *node = queue->node;
  const uint32_t ball = queue->tree.first;
  if (ball == EM_RBTREE_NONE) return EM_QUEUE_NOBODY;
  const double t = node[ball].key;
  const uint32_t two = node[ball].next;
  *time = t;
  *rival = ball;
  if (two == EM_RBTREE_NONE || node[two].key != t) return ball;
  const uint32_t three = node[two].next;
  *rival = three == EM_RBTREE_NONE || node[three].key != t ? two : EM_QUEUE_SEVERAL;
  return ball;
}

static size_t tied(struct em_queue *queue, uint32_t *ball) {
  const struct em_rbnode *node = queue->node;
  size_t found = 0;
  uint32_t n = queue->tree.first;
  if (n == EM_RBTREE_NONE) return 0;
  const double time = node[n].key;
  for (; n != EM_RBTREE_NONE && node[n].key == time; n = node[n].next)
    ball[found++] = n;
  return found;
}

static size_t bytes(const struct em_queue *queue) {
  return sizeof *queue + (size_t)queue->count * sizeof(struct em_rbnode);
}

static bool is_valid(const struct em_queue *queue) {
  size_t size, expected = 0;
  for (uint32_t n = 0; n < queue->count; n++) {
    if (queue->node[n].key != INFINITY) expected++;
    if (queue->node[n].rank != n) return false;
  }
  return em_rbtree_is_valid(&queue->tree, queue->node, queue->count, &size) && size == expected;
}

const struct em_queue_kind em_queue_tree = {
    .name = "tree",
    .make = make,
    .free = free_queue,
    .clear = clear,
    .set = set,
    .first = first,
    .tied = tied,
    .bytes = bytes,
    .is_valid = is_valid,
};
