/* Is a world as it should be: its balls, and its lists? */
#include <math.h>

#include "event/body.h"
#include "event/collapse.h"
#include "event/partition.h"

static bool fault(struct em_error *err, const struct em_world *w, uint32_t i, uint32_t partner,
                  double depth) {
  char with[64];
  em_collapse_partner(partner, with, sizeof with);
  const struct em_vec x = em_body_at(w, i, w->clock);
  em_error_set(err, EM_INPUT, w->scene->file, 0,
               "ball %u at (%.9g, %.9g, %.9g) m overlaps %s by %.3g m", i, x.x, x.y, x.z, with,
               depth);
  return false;
}

static bool clear_of_walls(const struct em_world *w, uint32_t i, double tolerance,
                           struct em_error *err) {
  const struct em_vec x = em_body_at(w, i, w->clock);
  const double r = w->body[i].radius;
  const double at[3] = {x.x, x.y, x.z}, low[3] = {w->low.x, w->low.y, w->low.z},
               high[3] = {w->high.x, w->high.y, w->high.z};
  for (uint32_t k = 0; k < 6; k++) {
    const double depth = k & 1 ? at[k / 2] + r - high[k / 2] : low[k / 2] - (at[k / 2] - r);
    if (w->wall[k] && !(depth <= tolerance)) return fault(err, w, i, EM_SURFACE + k, depth);
  }
  const double out = w->drum ? -em_body_drum_gap(w, x, r) : 0.0;
  if (!(out <= tolerance)) return fault(err, w, i, EM_SURFACE + EM_WALL_DRUM, out);
  for (uint32_t k = 0; k < w->blade_count; k++) {
    const struct em_blade *b = &w->blade[k].blade;
    if (b->tip == EM_TIP_NONE) continue;
    const double depth = -em_surface_blade_gap(b, x, r, b->angle + b->omega * w->clock);
    if (!(depth <= tolerance)) return fault(err, w, i, EM_SURFACE_BLADE(k), depth);
  }
  return true;
}

static bool clear_of_balls(struct em_world *w, uint32_t i, double tolerance, struct em_error *err) {
  uint32_t n;
  const uint32_t *id = w->partition_kind->candidates(w, i, &n);
  const struct em_vec x = em_body_at(w, i, w->clock);
  for (uint32_t k = 0; k < n; k++) {
    const struct em_vec d = em_body_nearest(w, em_vec_sub(em_body_at(w, id[k], w->clock), x));
    const double depth = w->body[i].radius + w->body[id[k]].radius - em_vec_norm(d);
    if (!(depth <= tolerance)) return fault(err, w, i, id[k], depth);
  }
  return true;
}

bool em_world_valid_balls(struct em_world *w, double tolerance, struct em_error *err) {
  for (uint32_t i = 0; i < w->count; i++) {
    const struct em_body *b = &w->body[i];
    if (!isfinite(b->x + b->y + b->z + b->vx + b->vy + b->vz + b->t)) {
      em_error_set(err, EM_INPUT, w->scene->file, 0, "ball %u has no finite state", i);
      return false;
    }
    if (!clear_of_walls(w, i, tolerance, err) || !clear_of_balls(w, i, tolerance, err))
      return false;
  }
  return true;
}

bool em_world_valid_lists(const struct em_world *w) {
  for (uint32_t i = 0; i < w->count; i++)
    if (!w->local_kind->is_valid(w->local, i)) return false;
  return w->queue_kind->is_valid(w->queue) && w->partition_kind->is_valid(w);
}

bool em_world_is_valid(const struct em_world *world, double tolerance, struct em_error *err) {
  struct em_world *w = (struct em_world *)(uintptr_t)world; /* candidates use scratch */
  if (!em_world_valid_balls(w, tolerance, err)) return false;
  if (em_world_valid_lists(w)) return true;
  em_error_set(err, EM_INTERNAL, NULL, 0, "the lists (%s, %s, %s) are inconsistent",
               w->local_kind->name, w->queue_kind->name, w->partition_kind->name);
  return false;
}
