/* Pushes overlapping balls apart, ball by ball, until none overlaps: for packings that are too dense
 * for random insertion (beyond about a third of the volume) and not yet near the densest ones. */
#include <gsl/gsl_randist.h>
#include <math.h>

#include "scene/start_place.h"

/* Balls are pushed a little farther apart than they must be, so that the sweeps come to an end. */
static const double ROOM = 1e-4;

struct pushed {
  struct em_start_field *field;
  const bool *loose;
  struct em_vec r, move;
  double radius;
  size_t self;
  gsl_rng *rng;
  bool overlaps;
};

/* Half of the overlap with ball k if that gives way as well, else all of it. */
static bool push_from(void *self, size_t k) {
  struct pushed *p = self;
  if (k == p->self)
    return true;
  struct em_vec d = em_start_field_between(p->field, p->r, p->field->balls->position[k]);
  double sigma = p->radius + p->field->balls->radius[k], r2 = em_vec_norm2(d);
  double wide = sigma * (1.0 + ROOM), least = sigma * (1.0 + EM_START_CLEARANCE);
  p->overlaps = p->overlaps || r2 < least * least;
  if (r2 >= wide * wide)
    return true;
  double r = sqrt(r2);
  if (r > 1e-6 * sigma)
    d = em_vec_scale(1.0 / r, d);
  else
    gsl_ran_dir_3d(p->rng, &d.x, &d.y, &d.z);
  p->move = em_vec_axpy(p->move, (p->loose[k] ? 0.5 : 1.0) * (wide - r), d);
  return true;
}

static double clamp(double x, double low, double high) {
  return x < low ? low : x > high ? high : x;
}

/* Moves a position into its species' box and the drum. */
static struct em_vec inside(const struct em_start_field *f, struct em_vec r, double radius,
                            struct em_vec low, struct em_vec high) {
  r = em_start_field_wrap(f, r);
  double in = 1e-7 * radius;
  r.x = clamp(r.x, low.x + in, high.x - in);
  r.y = clamp(r.y, low.y + in, high.y - in);
  r.z = clamp(r.z, low.z + in, high.z - in);
  if (!f->drum)
    return r;
  double rho = 0.5 * f->scene->chamber.diameter - radius - in, s = hypot(r.x, r.z);
  if (s > rho) {
    r.x *= rho / s;
    r.z *= rho / s;
  }
  return r;
}

/* Moves a ball once; true when it had to be moved because it overlapped. */
static bool push_ball(struct em_start_field *f, const bool *loose, size_t k, gsl_rng *rng) {
  struct em_vec low, high, r = f->balls->position[k];
  double radius = f->balls->radius[k];
  struct pushed p = {.field = f, .loose = loose, .r = r, .radius = radius, .self = k, .rng = rng};
  em_start_field_each(f, r, push_from, &p);
  const struct em_blade *blade = NULL;
  double gap = em_start_field_blade_gap(f, r, radius, &blade);
  bool overlaps = p.overlaps || gap < EM_START_CLEARANCE * radius;
  if (gap < ROOM * radius) {
    struct em_vec n = em_surface_blade_normal(blade, r, blade->angle);
    p.move = em_vec_axpy(p.move, ROOM * radius - gap, n);
  }
  em_start_place_box(f, &f->scene->species[f->balls->species[k]], &low, &high);
  r = inside(f, em_vec_add(r, p.move), radius, low, high);
  f->balls->position[k] = r;
  return overlaps;
}

static void put_all(struct em_start_field *f) {
  em_start_field_clear(f);
  for (size_t k = 0; k < f->balls->count; ++k)
    em_start_field_put(f, k);
}

bool em_start_relax_push(struct em_start_field *field, const bool *loose, gsl_rng *rng) {
  enum { SWEEPS = 3000 };
  size_t n = field->balls->count;
  for (int sweep = 0; sweep < SWEEPS; ++sweep) {
    size_t overlaps = 0;
    put_all(field);
    for (size_t k = 0; k < n; ++k)
      if (loose[k])
        overlaps += push_ball(field, loose, k, rng);
    if (overlaps > 0)
      continue;
    /* No overlap was seen while balls moved; make sure that none is left now. */
    put_all(field);
    bool apart = true;
    for (size_t k = 0; k < n && apart; ++k)
      apart = !loose[k] ||
              em_start_field_fits(field, k, field->balls->position[k], EM_START_CLEARANCE);
    if (apart)
      return true;
  }
  return false;
}
