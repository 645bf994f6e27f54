/* Local lists that keep only the earliest prediction of each ball. */
#ifndef EVENTMILL_EVENT_LOCAL_FIRST_H
#define EVENTMILL_EVENT_LOCAL_FIRST_H

#include <math.h>

#include "event/local.h"

struct em_local {
  uint32_t count;
  struct em_plan *plan; /* first: INFINITY, none */
};

/* See local.h. */
static inline void em_local_first_clear(struct em_local *local, uint32_t ball) {
  local->plan[ball].first = (struct em_prediction){INFINITY, UINT32_MAX, 0};
}

/* Does a come before b? Equal times: the smaller partner, so that the order does not matter in
 * which they are entered. */
static inline bool em_local_sooner(const struct em_prediction *a, const struct em_prediction *b) {
  return a->time < b->time || (a->time == b->time && a->partner < b->partner);
}

static inline bool em_local_first_add(struct em_local *local, uint32_t ball,
                                      const struct em_prediction *prediction) {
  struct em_prediction *kept = &local->plan[ball].first;
  if (em_local_sooner(prediction, kept)) *kept = *prediction;
  return true;
}

static inline const struct em_prediction *em_local_first_get(const struct em_local *local,
                                                             uint32_t ball) {
  const struct em_prediction *kept = &local->plan[ball].first;
  return kept->time < INFINITY ? kept : NULL;
}

#endif
