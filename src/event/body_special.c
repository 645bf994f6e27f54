/* Contacts beyond the loop's own formulas: drums with facets, and the searches that a scene's knobs
 * ask for. */
#include <math.h>

#include "event/body.h"
#include "eventmill/surface_roots.h"

static struct em_surface_path path(const struct em_body *b) {
  return (struct em_surface_path){{b->x, b->y, b->z}, {b->vx, b->vy, b->vz}, b->t};
}

double em_body_exact_pair(const struct em_world *w, uint32_t i, uint32_t j, struct em_vec shift) {
  /* i < j, so that it does not matter who asks. */
  const uint32_t a = i < j ? i : j, b = i < j ? j : i;
  const struct em_surface_path pa = path(&w->body[a]), pb = path(&w->body[b]);
  if (i > j) shift = em_vec_scale(-1.0, shift);
  return em_surface_roots_pair(&w->scene->engine.roots, &pa, &pb, w->gravity, shift,
                               w->body[b].radius + w->body[a].radius);
}

struct em_vec em_body_facet(const struct em_world *w, struct em_vec x) {
  const struct em_vec *best = &w->facet[0];
  for (uint32_t k = 1; k < w->facets; k++)
    if (em_vec_dot(w->facet[k], x) < em_vec_dot(*best, x)) best = &w->facet[k];
  return *best;
}

struct em_vec em_body_facet_met(const struct em_world *w, struct em_vec x, struct em_vec v) {
  const struct em_vec nearest = em_body_facet(w, x), *met = &nearest;
  for (uint32_t k = 0; k < w->facets; k++) {
    const struct em_vec *e = &w->facet[k];
    const double further = em_vec_dot(*e, x) - em_vec_dot(nearest, x);
    if (further <= 1e-12 * w->rho && em_vec_dot(*e, v) < em_vec_dot(*met, v)) met = e;
  }
  return *met;
}

double em_body_drum_gap(const struct em_world *w, struct em_vec x, double r) {
  const double from = w->facets ? -em_vec_dot(em_body_facet(w, x), x) : hypot(x.x, x.z);
  return w->rho - r - from;
}

/* The first of the planes that touch the drum from outside. */
static double facets(const struct em_world *w, uint32_t i, bool touched, double horizon) {
  const struct em_body *b = &w->body[i];
  const struct em_vec r = {b->x, b->y, b->z}, v = {b->vx, b->vy, b->vz};
  const struct em_vec last = em_body_facet(w, r);
  double first = INFINITY;
  for (uint32_t k = 0; k < w->facets; k++) {
    const struct em_vec e = w->facet[k];
    const double gap = em_vec_dot(e, r) + (w->rho - b->radius), rate = em_vec_dot(e, v);
    const double fall = em_vec_dot(e, w->gravity);
    const double way = (rate - 0.5 * fabs(fall) * horizon) * horizon;
    if (gap > 0.0 && gap + way > EM_CLEARLY * b->radius) continue;
    const bool same = touched && e.x == last.x && e.z == last.z;
    first = fmin(first, em_surface_roots_plane(&w->scene->engine.roots, gap, rate, fall, same));
  }
  return first <= horizon ? first : INFINITY;
}

double em_body_special_drum(const struct em_world *w, uint32_t i, bool touched, double horizon) {
  const struct em_body *b = &w->body[i];
  if (w->facets) return facets(w, i, touched, horizon);
  return em_surface_roots_drum(&w->scene->engine.roots, em_vec_make(b->x, b->y, b->z),
                               em_vec_make(b->vx, b->vy, b->vz), w->gravity, w->rho - b->radius,
                               b->radius, touched, horizon);
}
