/* The global list: every ball once, by the time of its earliest event. */
#ifndef EVENTMILL_QUEUE_H
#define EVENTMILL_QUEUE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "event/plan.h"
#include "eventmill/scene.h"

struct em_queue; /* opaque; each kind has its own */

#define EM_QUEUE_NOBODY  UINT32_MAX
#define EM_QUEUE_SEVERAL (UINT32_MAX - 1)

/* An exchangeable global list. Times never lie before that of the last `first`, except after
 * `clear`. */
struct em_queue_kind {
  const char *name;
  /* plan: of each of count balls, outlives the list; spacing: expected time between successive
   * events (s), a hint. NULL: no memory. */
  struct em_queue *(*make)(uint32_t count, struct em_plan *plan, double spacing);
  void (*free)(struct em_queue *queue);
  /* Empties the list; times may start anew at `from`. */
  void (*clear)(struct em_queue *queue, double from);
  /* Enters a ball, or moves it. INFINITY takes it out. */
  void (*set)(struct em_queue *queue, uint32_t ball, double time);
  /* The earliest ball and its time; EM_QUEUE_NOBODY when the list is empty. Stays in the list.
   * *rival: the ball itself when it is the only one at that time, the other one of two (the ball
   * has the smaller number), EM_QUEUE_SEVERAL when there are more. */
  uint32_t (*first)(struct em_queue *queue, double *time, uint32_t *rival);
  /* All balls whose time equals that of the earliest exactly, in any order: `ball` has room for
   * all that there are. Returns how many; as many steps, at most some tens more. */
  size_t (*tied)(struct em_queue *queue, uint32_t *ball);
  size_t (*bytes)(const struct em_queue *queue);
  bool (*is_valid)(const struct em_queue *queue);
};

extern const struct em_queue_kind em_queue_tree;     /* threaded red-black tree */
extern const struct em_queue_kind em_queue_calendar; /* bounded-increasing queue, O(1) */

const struct em_queue_kind *em_queue_find(enum em_lists lists);

#endif
