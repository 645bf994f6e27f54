/* Local lists that keep only the earliest prediction of each ball. */
#include "event/local_first.h"

#include <stdlib.h>

static void clear(struct em_local *local, uint32_t ball) {
  em_local_first_clear(local, ball);
}

static struct em_local *make(uint32_t count, struct em_plan *plan) {
  struct em_local *local = malloc(sizeof *local);
  if (!local) return NULL;
  local->count = count;
  local->plan = plan;
  for (uint32_t ball = 0; ball < count; ball++)
    clear(local, ball);
  return local;
}

static void free_local(struct em_local *local) {
  free(local);
}

static bool add(struct em_local *local, uint32_t ball, const struct em_prediction *prediction) {
  return em_local_first_add(local, ball, prediction);
}

static const struct em_prediction *first(const struct em_local *local, uint32_t ball) {
  return em_local_first_get(local, ball);
}

static size_t bytes(const struct em_local *local) {
  return sizeof *local;
}

static bool is_valid(const struct em_local *local, uint32_t ball) {
  return ball < local->count && !isnan(local->plan[ball].first.time);
}

const struct em_local_kind em_local_first = {
    .name = "first",
    .keeps_all = false,
    .make = make,
    .free = free_local,
    .clear = clear,
    .add = add,
    .first = first,
    .pop = clear,
    .bytes = bytes,
    .is_valid = is_valid,
};
