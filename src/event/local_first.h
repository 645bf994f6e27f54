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

/* Equal times: the smaller partner, so that the order of entry does not matter. */
static inline bool em_local_first_add(struct em_local *local, uint32_t ball,
                                      const struct em_prediction *prediction) {
  struct em_prediction *kept = &local->plan[ball].first;
  if (prediction->time < kept->time ||
      (prediction->time == kept->time && prediction->partner < kept->partner))
    *kept = *prediction;
  return true;
}

static inline const struct em_prediction *em_local_first_get(const struct em_local *local,
                                                             uint32_t ball) {
  const struct em_prediction *kept = &local->plan[ball].first;
  return kept->time < INFINITY ? kept : NULL;
}

#endif
