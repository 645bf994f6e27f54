/* A run that is stuck: which balls hold each other, and whether a blade squeezes them. */
#include "event/collapse.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "event/partition.h"
#include "num/locale.h"

void em_collapse_partner(uint32_t partner, char *text, size_t room) {
  if (partner < EM_SURFACE)
    snprintf(text, room, "ball %u", partner);
  else if (partner >= EM_SURFACE_BLADE(0))
    snprintf(text, room, "blade %u", partner - EM_SURFACE_BLADE(0));
  else if (partner == EM_SURFACE + EM_WALL_DRUM)
    snprintf(text, room, "the drum");
  else
    snprintf(text, room, "the %s wall across %c", (partner - EM_SURFACE) & 1 ? "upper" : "lower",
             'x' + (int)(partner - EM_SURFACE) / 2);
}

/* A cluster and what it touches: balls hang together where they are closer than `near` (m). */
struct hold {
  uint32_t balls;
  bool wall, blade;
};

/* Does a ball of radius r overlap the blade? Beyond the reach of the tip `none` nothing is. */
static bool overlaps(const struct em_turning *k, struct em_vec x, double r, double t) {
  const struct em_blade *b = &k->blade;
  const double angle = b->angle + b->omega * t;
  if (em_surface_blade_gap(b, x, r, angle) >= 0.0) return false;
  const struct em_vec bar = em_vec_axpy(em_vec_scale(cos(angle), b->e1), sin(angle), k->e3);
  return b->tip != EM_TIP_NONE || fabs(em_vec_dot(em_vec_sub(x, b->centre), bar)) <= b->reach;
}

static void add_surfaces(const struct em_world *w, uint32_t i, double t, double near,
                         struct hold *hold) {
  const struct em_vec x = em_body_at(w, i, t);
  const double r = w->body[i].radius + near;
  const double at[3] = {x.x, x.y, x.z}, low[3] = {w->low.x, w->low.y, w->low.z},
               high[3] = {w->high.x, w->high.y, w->high.z};
  for (int k = 0; k < 3; k++)
    if (w->wall[2 * k] && (at[k] - r < low[k] || at[k] + r > high[k])) hold->wall = true;
  if (w->drum && em_body_drum_gap(w, x, r) < 0.0) hold->wall = true;
  for (uint32_t k = 0; k < w->blade_count; k++)
    if (overlaps(&w->blade[k], x, r, t)) hold->blade = true;
}

/* Follows the cluster of ball i, from ball to ball, as long as there is memory for it. */
static struct hold held(struct em_world *w, uint32_t i, double t) {
  struct hold hold = {0, false, false};
  const double near = 1e-4 * w->smallest;
  uint32_t *chain = calloc(w->count, sizeof *chain), length = 1;
  bool *seen = calloc(w->count, sizeof *seen);
  if (chain && seen) {
    chain[0] = i;
    seen[i] = true;
    for (uint32_t c = 0; c < length; c++) {
      uint32_t n;
      const uint32_t *id = w->partition_kind->candidates(w, chain[c], &n);
      const struct em_vec x = em_body_at(w, chain[c], t);
      add_surfaces(w, chain[c], t, near, &hold);
      for (uint32_t k = 0; k < n; k++) {
        const double reach = w->body[chain[c]].radius + w->body[id[k]].radius + near;
        const struct em_vec d = em_body_nearest(w, em_vec_sub(em_body_at(w, id[k], t), x));
        if (seen[id[k]] || em_vec_norm2(d) > reach * reach) continue;
        seen[id[k]] = true;
        chain[length++] = id[k];
      }
    }
    hold.balls = length;
  }
  free(chain);
  free(seen);
  return hold;
}

/* Speed (m/s) of a ball that glides or rolls along a wall, pressed to it by its own motion, or is
 * carried by a blade that presses on it; 0: it lies there, or others hold it. What its weight alone
 * would do is no gliding. */
static double gliding(const struct em_world *w, uint32_t i, double t, struct hold hold) {
  const double v2 = em_vec_norm2(em_body_velocity(w, i, t));
  const bool alone = hold.balls == 1 && hold.wall != hold.blade;
  return alone && v2 > w->fall * w->body[i].radius ? sqrt(v2) : 0.0;
}

/* A jam is what hangs between a blade and a wall; anything else has collapsed by itself. */
enum em_status em_collapse_report(const struct em_world *world, uint32_t i, uint32_t partner,
                                  double t, struct em_error *err) {
  EM_LOCALE_PLAIN;
  struct em_world *w = (struct em_world *)(uintptr_t)world; /* candidates use scratch */
  char with[64];
  em_collapse_partner(partner, with, sizeof with);
  const struct em_vec x = em_body_at(w, i, t);
  const struct hold hold = held(w, i, t);
  const bool jam = hold.wall && hold.blade;
  const double speed = gliding(w, i, t, hold);
  const char *advice = "hard spheres at rest on one another need remedy.tc or remedy.elastic_below";
  if (jam && w->scene->remedy.jam_after > 0) advice = "the balls have no way out";
  if (jam && w->scene->remedy.jam_after == 0) advice = "remedy.jam_after may open it";
  char glide[160];
  snprintf(
      glide, sizeof glide,
      "it %s at %.3g m/s in ever smaller hops; remedy.elastic_below=0.001, or remedy.tc, keeps "
      "them finite",
      hold.blade ? "goes along with the blade" : "glides along the wall", speed);
  if (speed > 0.0) advice = glide;
  return em_error_set(
      err, jam ? EM_JAM : EM_COLLAPSE, w->scene->file, 0,
      "%s at %.9g s: ball %u at (%.6g, %.6g, %.6g) m, now with %s, had %u contacts in a row, each "
      "within %.3g s of the one before; %s",
      jam ? "jam without exit, between a blade and a wall," : "inelastic collapse",
      em_body_absolute(w, t), i, x.x, x.y, x.z, with, w->scene->remedy.collapse_after, w->within,
      advice);
}

bool em_collapse_sticks(const struct em_world *w, const struct em_contact_law *law, double vn) {
  enum { SEVERAL = 8 };
  const struct em_remedy *r = &w->scene->remedy;
  const uint64_t n = w->tally.vn[EM_CLASS_BALL][0] + 1;
  if (n < SEVERAL || r->tc > 0.0 || r->elastic_below > 0.0) return false;
  if (n & (n - 1))
    return false; /* a gas that has cooled down makes many: not all balls each time */
  double square = 0.0;
  for (uint32_t i = 0; i < w->count; i++)
    square += em_vec_norm2(em_body_velocity(w, i, w->clock)) / w->count;
  return sqrt(square) > 1e-4 && em_contact_restitution(&law->normal, vn) < 0.99;
}

enum em_status em_collapse_stuck(const struct em_world *w, uint32_t i, uint32_t j, double t,
                                 double vn, struct em_error *err) {
  const struct em_vec x = em_body_at(w, i, t);
  return em_error_set(
      err, EM_COLLAPSE, w->scene->file, 0,
      "inelastic collapse at %.9g s: ball %u at (%.6g, %.6g, %.6g) m and ball %u hit each other "
      "ever more often, by now at %.3g m/s; remedy.tc or remedy.elastic_below prevents it",
      em_body_absolute(w, t), i, x.x, x.y, x.z, j, vn);
}
