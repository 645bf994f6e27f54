/* All of a world that a restart needs, as a copy of its own. */
#include <math.h>
#include <stdlib.h>

#include "event/body.h"

void em_world_snapshot_free(struct em_snapshot *s) {
  if (!s) return;
  free(s->position);
  free(s->velocity);
  free(s->spin);
  free(s->time);
  free(s->last);
  free(s->streak);
  free(s->blade_angle);
  free(s->blade);
  free(s);
}

struct em_snapshot *em_world_snapshot_new(uint32_t count, uint32_t blade_count, bool spin) {
  struct em_snapshot *s = calloc(1, sizeof *s);
  if (!s) return NULL;
  const size_t n = count ? count : 1, m = blade_count ? blade_count : 1;
  s->count = count;
  s->blade_count = blade_count;
  s->position = calloc(n, sizeof *s->position);
  s->velocity = calloc(n, sizeof *s->velocity);
  s->spin = spin ? calloc(n, sizeof *s->spin) : NULL;
  s->time = calloc(n, sizeof *s->time);
  s->last = calloc(n, sizeof *s->last);
  s->streak = calloc(n, sizeof *s->streak);
  s->blade_angle = calloc(m, sizeof *s->blade_angle);
  s->blade = calloc(m, sizeof *s->blade);
  if (s->position && s->velocity && (s->spin || !spin) && s->time && s->last && s->streak &&
      s->blade_angle && s->blade)
    return s;
  em_world_snapshot_free(s);
  return NULL;
}

enum em_status em_world_snapshot(const struct em_world *w, struct em_snapshot **snapshot,
                                 struct em_error *err) {
  struct em_snapshot *s = em_world_snapshot_new(w->count, w->blade_count, w->spin != NULL);
  if (!s) return em_error_set(err, EM_MEMORY, NULL, 0, "no memory for a checkpoint");
  s->origin = w->origin;
  s->epoch = w->epoch;
  s->clock = w->clock;
  for (uint32_t i = 0; i < w->count; i++) {
    const struct em_body *b = &w->body[i];
    s->position[i] = em_vec_make(b->x, b->y, b->z);
    s->velocity[i] = em_vec_make(b->vx, b->vy, b->vz);
    s->time[i] = b->t;
    s->last[i] = w->plan[i].last;
    s->streak[i] = w->plan[i].streak;
    if (w->spin) s->spin[i] = w->spin[i];
  }
  for (uint32_t k = 0; k < w->blade_count; k++) {
    s->blade_angle[k] = w->blade[k].blade.angle;
    s->blade[k] = w->blade_tally[k];
  }
  s->tally = w->tally;
  *snapshot = s;
  return EM_OK;
}

enum em_status em_world_snapshot_now(const struct em_world *w, struct em_snapshot **snapshot,
                                     struct em_error *err) {
  const enum em_status status = em_world_snapshot(w, snapshot, err);
  if (status) return status;
  struct em_snapshot *s = *snapshot;
  s->origin = em_world_time(w);
  s->epoch = 0;
  s->clock = 0.0;
  for (uint32_t i = 0; i < w->count; i++) {
    s->position[i] = em_body_wrap(w, em_body_at(w, i, w->clock));
    s->velocity[i] = em_body_velocity(w, i, w->clock);
    s->time[i] = 0.0;
    s->last[i] = EM_NOBODY;
    s->streak[i] = 0;
  }
  for (uint32_t k = 0; k < w->blade_count; k++)
    s->blade_angle[k] =
        fmod(w->blade[k].blade.angle + w->blade[k].blade.omega * w->clock, 2.0 * M_PI);
  return EM_OK;
}

enum em_status em_world_snapshot_balls(const struct em_scene *scene, const struct em_snapshot *s,
                                       struct em_balls **balls, struct em_error *err) {
  if (em_scene_ball_count(scene) != s->count || em_scene_blade_count(scene) != s->blade_count)
    return em_error_set(err, EM_INPUT, scene->file, 0,
                        "the checkpoint holds %u balls and %u blades, the scene %zu and %zu",
                        s->count, s->blade_count, em_scene_ball_count(scene),
                        em_scene_blade_count(scene));
  struct em_balls *b = em_start_new(s->count);
  if (!b) return em_error_set(err, EM_MEMORY, NULL, 0, "no memory for %u balls", s->count);
  size_t i = 0;
  for (size_t k = 0; k < scene->species_count; k++) {
    const struct em_species *species = &scene->species[k];
    const double r = 0.5 * species->diameter;
    for (size_t n = 0; n < species->count; n++, i++) {
      b->position[i] = s->position[i];
      b->velocity[i] = s->velocity[i];
      if (s->spin) b->spin[i] = s->spin[i];
      b->radius[i] = r;
      b->mass[i] = em_start_mass(species);
    }
  }
  *balls = b;
  return EM_OK;
}

void em_world_snapshot_restore(struct em_world *w, const struct em_snapshot *s) {
  w->origin = s->origin;
  w->epoch = s->epoch;
  w->clock = s->clock;
  w->tally = s->tally;
  for (uint32_t i = 0; i < w->count; i++) {
    w->body[i].t = s->time[i];
    w->plan[i].last = s->last[i];
    w->plan[i].streak = s->streak[i];
  }
  for (uint32_t k = 0; k < w->blade_count; k++) {
    w->blade[k].blade.angle = s->blade_angle[k];
    w->blade[k].cos = cos(s->blade_angle[k]);
    w->blade[k].sin = sin(s->blade_angle[k]);
    w->blade_tally[k] = s->blade[k];
  }
}
