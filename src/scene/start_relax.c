/* Pushes overlapping balls apart, ball by ball, until none overlaps: for packings that are too
 * dense for random insertion (beyond about a third of the volume) and not yet near the densest
 * ones. */
#include <gsl/gsl_randist.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "scene/start_place.h"

/* Balls that overlap are pushed a little farther apart than they must be, so that the sweeps come
 * to an end. */
static const double ROOM = 1e-3;

/* Balls that are to be looked at in this sweep and in the next: those that moved, and all that
 * might now overlap them. */
struct pushing {
  struct em_start_field *field;
  const bool *loose;
  bool *now, *next; /* owned */
  gsl_rng *rng;
};

/* One ball and its way out. */
struct pushed {
  struct pushing *all;
  struct em_vec r;
  double radius;
  size_t self;
  bool overlaps;
};

/* Parts two balls: each gives way by half, or this one by all if the other is fixed. Both move at
 * once; a ball that moved alone could swing between two others for ever. */
static bool push_from(void *self, size_t k) {
  struct pushed *p = self;
  const struct em_start_field *f = p->all->field;
  if (k == p->self) return true;
  struct em_vec d = em_start_field_between(f, p->r, f->balls->position[k]);
  double sigma = p->radius + f->balls->radius[k], r2 = em_vec_norm2(d);
  double least = sigma * (1.0 + EM_START_CLEARANCE);
  if (r2 >= least * least) return true;
  p->overlaps = true;
  double r = sqrt(r2);
  if (r > 1e-6 * sigma)
    d = em_vec_scale(1.0 / r, d);
  else
    gsl_ran_dir_3d(p->all->rng, &d.x, &d.y, &d.z);
  double push = sigma * (1.0 + ROOM) - r;
  if (p->all->loose[k]) {
    push *= 0.5;
    f->balls->position[k] = em_vec_axpy(f->balls->position[k], -push, d);
    p->all->next[k] = true;
  }
  p->r = em_vec_axpy(p->r, push, d);
  return true;
}

/* Neighbours that the moved ball overlaps are to be looked at again. */
static bool wake(void *self, size_t k) {
  struct pushed *p = self;
  const struct em_start_field *f = p->all->field;
  struct em_vec d = em_start_field_between(f, p->r, f->balls->position[k]);
  double least = (p->radius + f->balls->radius[k]) * (1.0 + EM_START_CLEARANCE);
  if (em_vec_norm2(d) < least * least) p->all->next[k] = true;
  return true;
}

/* A range without extent gives its middle. */
static double clamp(double x, double low, double high) {
  if (low > high) return 0.5 * (low + high);
  return x < low ? low : x > high ? high : x;
}

/* Moves a position into its species' box and the drum; one that is there keeps its bits. */
static struct em_vec inside(const struct em_start_field *f, struct em_vec r, double radius,
                            struct em_vec low, struct em_vec high) {
  r = em_start_field_wrap(f, r);
  double in = 1e-7 * radius;
  r.x = clamp(r.x, low.x + in, high.x - in);
  r.y = clamp(r.y, low.y + in, high.y - in);
  r.z = clamp(r.z, low.z + in, high.z - in);
  if (!f->drum) return r;
  double rho = 0.5 * f->scene->chamber.diameter - radius - in, s = hypot(r.x, r.z);
  if (s > rho) {
    double shrink = (rho - in) / s;
    r.x *= shrink;
    r.z *= shrink;
  }
  return r;
}

/* Moves a ball out of what it overlaps and back to where it may be; true when it had to be moved.
 */
static bool push_ball(struct pushing *all, size_t k) {
  struct em_start_field *f = all->field;
  struct em_vec low, high, r = em_start_field_wrap(f, f->balls->position[k]);
  double radius = f->balls->radius[k], in = EM_START_CLEARANCE * radius;
  struct pushed p = {.all = all, .r = r, .radius = radius, .self = k};
  em_start_field_each(f, r, push_from, &p);
  const struct em_blade *blade = NULL;
  double gap = em_start_field_blade_gap(f, p.r, radius, &blade);
  if (gap < in)
    p.r = em_vec_axpy(p.r, ROOM * radius - gap, em_surface_blade_normal(blade, p.r, blade->angle));
  em_start_place_box(f, &f->scene->species[f->balls->species[k]], &low, &high);
  p.r = inside(f, p.r, radius, low, high);
  f->balls->position[k] = p.r;
  if (!p.overlaps && p.r.x == r.x && p.r.y == r.y && p.r.z == r.z) return false;
  all->next[k] = true;
  em_start_field_each(f, p.r, wake, &p);
  return true;
}

static void put_all(struct em_start_field *f) {
  em_start_field_clear(f);
  for (size_t k = 0; k < f->balls->count; ++k)
    em_start_field_put(f, k);
}

static bool all_fit(const struct em_start_field *f, const bool *loose) {
  for (size_t k = 0; k < f->balls->count; ++k)
    if (loose[k] && !em_start_field_fits(f, k, f->balls->position[k], EM_START_CLEARANCE))
      return false;
  return true;
}

/* Sweeps over the balls that are awake. Gives up when PATIENCE sweeps have not brought the number
 * of overlaps down by a fifth. */
static bool sweep_all(struct pushing *all) {
  enum { PATIENCE = 150 };
  size_t n = all->field->balls->count, least = n + 1;
  memcpy(all->next, all->loose, n * sizeof *all->next);
  for (int idle = 0; idle < PATIENCE; ++idle) {
    size_t overlaps = 0;
    bool *now = all->next;
    all->next = all->now;
    all->now = now;
    memset(all->next, 0, n * sizeof *all->next);
    put_all(all->field);
    for (size_t k = 0; k < n; ++k)
      if (now[k] && all->loose[k]) overlaps += push_ball(all, k);
    if (em_start_field_stops(all->field)) return false;
    if (overlaps == 0) {
      /* Cells are those at the sweep's beginning: make sure that nothing was overlooked. */
      put_all(all->field);
      if (all_fit(all->field, all->loose)) return true;
      memcpy(all->next, all->loose, n * sizeof *all->next);
    } else if (overlaps < least - least / 5) {
      least = overlaps;
      idle = 0;
    }
  }
  return false;
}

bool em_start_relax_push(struct em_start_field *field, const bool *loose, gsl_rng *rng) {
  size_t n = field->balls->count;
  struct pushing all = {field, loose, calloc(n, sizeof(bool)), calloc(n, sizeof(bool)), rng};
  bool apart = all.now && all.next && sweep_all(&all);
  free(all.now);
  free(all.next);
  return apart;
}
