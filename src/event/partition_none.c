/* No partition: every ball is a candidate of every other. In a periodic box a ball still has a
 * place, a sphere small enough that only the nearest image of another ball can be met. */
#include <math.h>
#include <stdlib.h>

#include "event/partition.h"
#include "event/span.h"

struct em_places {
  uint32_t count;
  double room;           /* m, of the spheres; INFINITY: no periodic edge */
  struct em_vec *centre; /* of each ball's sphere; NULL when there are none */
  uint32_t *other;       /* all balls; the one asked for last stands at the end */
  uint32_t *position;    /* of each ball in `other` */
};

static void set_leave(struct em_world *w, uint32_t i, double from) {
  const struct em_places *p = w->places;
  w->plan[i].leave = em_span_limit(w, from);
  if (p->centre)
    w->plan[i].leave = fmin(w->plan[i].leave, em_partition_stay(w, i, from, p->centre[i], p->room));
}

static void moved(struct em_world *w, uint32_t i) {
  set_leave(w, i, w->body[i].t);
}

static const uint32_t *candidates(struct em_world *w, uint32_t i, uint32_t *count) {
  struct em_places *p = w->places;
  const uint32_t end = p->count - 1, hole = p->position[i], last = p->other[end];
  p->other[hole] = last;
  p->position[last] = hole;
  p->other[end] = i;
  p->position[i] = end;
  *count = end;
  return p->other;
}

static const uint32_t *cross(struct em_world *w, uint32_t i, double now, uint32_t *count) {
  struct em_places *p = w->places;
  if (p->centre) p->centre[i] = em_body_at(w, i, now);
  set_leave(w, i, now);
  if (p->centre) return candidates(w, i, count);
  *count = 0;
  return p->other;
}

static void free_places(struct em_places *p) {
  if (!p) return;
  free(p->centre);
  free(p->other);
  free(p->position);
  free(p);
}

static enum em_status make(struct em_world *w, struct em_error *err) {
  const double room = em_span_room(w);
  struct em_places *p = calloc(1, sizeof *p);
  const bool periodic = room < INFINITY;
  if (p) {
    p->count = w->count;
    p->room = room;
    p->other = em_body_array(w->count, sizeof *p->other);
    p->position = em_body_array(w->count, sizeof *p->position);
    if (periodic) p->centre = em_body_array(w->count, sizeof *p->centre);
  }
  if (!p || !p->other || !p->position || (periodic && !p->centre)) {
    free_places(p);
    return em_error_set(err, EM_MEMORY, NULL, 0, "no memory for the partition");
  }
  w->places = p;
  w->crosses_all = periodic;
  for (uint32_t i = 0; i < w->count; i++) {
    p->other[i] = p->position[i] = i;
    w->plan[i].near = UINT32_MAX;
    if (periodic) p->centre[i] = em_body_at(w, i, w->clock);
    set_leave(w, i, w->clock);
  }
  return EM_OK;
}

static size_t bytes(const struct em_places *p) {
  const size_t each = sizeof *p->other + sizeof *p->position + (p->centre ? sizeof *p->centre : 0);
  return sizeof *p + p->count * each;
}

static bool is_valid(const struct em_world *w) {
  const struct em_places *p = w->places;
  for (uint32_t i = 0; i < p->count; i++)
    if (p->position[i] >= p->count || p->other[p->position[i]] != i) return false;
  return true;
}

const struct em_partition_kind em_partition_none = {
    .name = "none",
    .make = make,
    .free = free_places,
    .candidates = candidates,
    .moved = moved,
    .cross = cross,
    .bytes = bytes,
    .is_valid = is_valid,
};
