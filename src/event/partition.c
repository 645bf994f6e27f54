/* What all partitions share: how long a ball stays near a point, and which blades reach there. */
#include "event/partition.h"

#include <math.h>

double em_partition_fraction(const struct em_world *w) {
  double balls = 0.0;
  for (uint32_t i = 0; i < w->count; i++)
    balls += pow(w->body[i].radius, 3.0);
  return balls * 4.0 / 3.0 * M_PI / em_scene_volume(w->scene);
}

/* Measured: where balls crowd, 27 cells hold twice as many as come near, which costs little with
 * wide vectors only, or where lists of those that come near don't fit into the caches; a rotor
 * makes balls crowd. Where sizes differ, cells fit the largest and hold too many of the small ones.
 */
static const struct em_partition_kind *fastest(const struct em_world *w) {
  const bool alike = w->largest < 1.3 * w->smallest, wide = w->loop->lanes >= 8;
  const bool large = w->count >= EM_FETCH_FROM;
  double most = w->blade_count ? 0.2 : 0.36;
  if (wide || large) most = wide && large ? 0.6 : 0.4;
  if (alike && em_partition_fraction(w) < most) return &em_partition_cells;
  return em_partition_neighbours_fit(w) ? &em_partition_neighbours : &em_partition_cells;
}

const struct em_partition_kind *em_partition_find(const struct em_world *w) {
  switch (w->scene->engine.partition) {
  case EM_PARTITION_AUTO:
    return fastest(w);
  case EM_PARTITION_NEIGHBOURS:
    return &em_partition_neighbours;
  case EM_PARTITION_CELLS:
    return &em_partition_cells;
  case EM_PARTITION_SLICES:
    return &em_partition_slices;
  case EM_PARTITION_NONE:
    return &em_partition_none;
  default:
    return NULL;
  }
}

static double nearest(double d, double period) {
  return period > 0.0 ? d - period * nearbyint(d / period) : d;
}

/* The straight path leaves a sphere of nine tenths of the room, or, where the ball is beyond that
 * already, of half of what is left; what gravity adds until the cap, ½ g τ², is the rest. */
double em_partition_stay(const struct em_world *w, uint32_t i, double from, struct em_vec c,
                         double room) {
  const struct em_vec x = em_body_at(w, i, from), v = em_body_velocity(w, i, from);
  const struct em_vec o = {nearest(x.x - c.x, w->period.x), nearest(x.y - c.y, w->period.y),
                           nearest(x.z - c.z, w->period.z)};
  const double oo = em_vec_norm2(o), b = em_vec_dot(o, v), vv = em_vec_norm2(v);
  double s = (w->fall > 0.0 ? 0.9 : 0.999999) * room;
  if (w->fall > 0.0 && oo >= s * s) s = 0.5 * (sqrt(oo) + room);
  const double c0 = s * s - oo, root = sqrt(fmax(0.0, b * b + vv * c0));
  double stay = b > 0.0 ? c0 / (b + root) : vv > 0.0 ? (root - b) / vv : INFINITY;
  if (w->fall > 0.0) stay = fmin(stay, sqrt(2.0 * fmax(0.0, room - s) / w->fall));
  return from + fmax(0.0, stay);
}

uint32_t em_partition_blades(const struct em_world *w, struct em_vec c, double radius,
                             struct em_vec half) {
  const double room = em_vec_norm(half);
  uint32_t mask = 0;
  for (uint32_t k = 0; k < w->blade_count; k++) {
    const struct em_blade *b = &w->blade[k].blade;
    const struct em_vec q = em_vec_sub(c, b->centre);
    const double axial = em_vec_dot(q, b->axis);
    const double spread =
        fabs(b->axis.x) * half.x + fabs(b->axis.y) * half.y + fabs(b->axis.z) * half.z;
    if (fabs(axial) > b->radius + radius + spread) continue;
    const double far = w->blade[k].hull + radius + room;
    if (em_vec_norm2(q) - axial * axial > far * far) continue;
    mask |= EM_NEAR_BLADE(k);
  }
  return mask;
}
