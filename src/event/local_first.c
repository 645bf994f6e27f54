/* Local lists that keep only the earliest prediction of each ball. */
#include <math.h>
#include <stdlib.h>

#include "event/local.h"

struct em_local {
  uint32_t count;
  struct em_prediction earliest[]; /* of each ball; INFINITY: none */
};

static void clear(struct em_local *local, uint32_t ball) {
  local->earliest[ball] = (struct em_prediction){INFINITY, UINT32_MAX, 0};
}

static struct em_local *make(uint32_t count) {
  struct em_local *local =
      malloc(sizeof(struct em_local) + (size_t)count * sizeof(struct em_prediction));
  if (!local) return NULL;
  local->count = count;
  for (uint32_t ball = 0; ball < count; ball++)
    clear(local, ball);
  return local;
}

static void free_local(struct em_local *local) {
  free(local);
}

/* Equal times: the smaller partner, so that the order of entry does not matter. */
static bool add(struct em_local *local, uint32_t ball, const struct em_prediction *prediction) {
  struct em_prediction *kept = &local->earliest[ball];
  if (prediction->time < kept->time ||
      (prediction->time == kept->time && prediction->partner < kept->partner))
    *kept = *prediction;
  return true;
}

static const struct em_prediction *first(const struct em_local *local, uint32_t ball) {
  const struct em_prediction *kept = &local->earliest[ball];
  return kept->time < INFINITY ? kept : NULL;
}

static size_t bytes(const struct em_local *local) {
  return sizeof *local + (size_t)local->count * sizeof(struct em_prediction);
}

static bool is_valid(const struct em_local *local, uint32_t ball) {
  return ball < local->count && !isnan(local->earliest[ball].time);
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
