/* Is the state that a snapshot gave a world one from which the engine can go on? A snapshot may
 * come from a damaged file. */
#include <math.h>

#include "event/body.h"

/* Balls far outside are lost to the lists; so are those of periodic boxes where as many periods are
 * not counted exactly. */
static const double PERIODS = 0x1p40;

static bool is_bounded(struct em_vec a, double scale) {
  return isfinite(em_vec_norm2(a) * scale * scale);
}

/* Was the ball in the chamber's box at its last event, and is it still near it? */
static bool is_near(const struct em_world *w, uint32_t i) {
  struct em_vec low, high;
  em_scene_extent(w->scene, &low, &high);
  const struct em_body *b = &w->body[i];
  const struct em_vec was = {b->x, b->y, b->z}, is = em_body_at(w, i, w->clock);
  for (int k = 0; k < 3; k++) {
    const double from = em_vec_component(low, k), to = em_vec_component(high, k);
    const double x = em_vec_component(was, k), y = em_vec_component(is, k);
    const double far = (to - from) * (em_vec_component(w->period, k) > 0.0 ? PERIODS : 1.0);
    if (!(x >= from - b->radius && x <= to + b->radius)) return false;
    if (!(y >= from - far && y <= to + far)) return false;
  }
  return true;
}

/* Events have happened, but not before the run began. */
static bool is_past(const struct em_world *w, double time) {
  return time <= w->clock && time >= -(double)w->epoch * w->epoch_length;
}

static bool is_partner(const struct em_world *w, uint32_t i, uint32_t code) {
  if (code < EM_SURFACE) return code < w->count && code != i;
  return code == EM_NOBODY || code < EM_SURFACE_BLADE(w->blade_count);
}

static const char *fault_of_ball(const struct em_world *w, uint32_t i) {
  const struct em_body *b = &w->body[i];
  const double size = em_vec_norm(em_vec_sub(w->high, w->low));
  if (!is_past(w, b->t)) return "a last contact in the past";
  if (!is_bounded((struct em_vec){b->vx, b->vy, b->vz}, size)) return "a finite velocity";
  if (!is_near(w, i)) return "a place in the chamber";
  if (w->spin && !is_bounded(w->spin[i], size)) return "a finite spin";
  if (!is_partner(w, i, w->plan[i].last)) return "a last partner that there is";
  return NULL;
}

/* Angles of blades stay within a turn, from the first epoch on; before, they are the scene's. */
static bool is_angle(double angle, double scene) {
  return fabs(angle) <= fmax(2.0 * M_PI, fabs(scene));
}

static bool valid_blades(const struct em_world *w, struct em_error *err) {
  uint32_t k = 0;
  for (size_t r = 0; r < w->scene->rotor_count; r++)
    for (size_t b = 0; b < w->scene->rotor[r].blade_count; b++, k++) {
      const double angle = w->blade[k].blade.angle;
      if (is_angle(angle, w->scene->rotor[r].blade[b].angle)) continue;
      em_error_set(
          err, EM_INPUT, w->scene->file, 0,
          "blade %u of the checkpoint: found an angle of %g rad, expected one within a turn", k,
          angle);
      return false;
    }
  return true;
}

bool em_world_valid_restart(const struct em_world *w, struct em_error *err) {
  if (!(w->clock >= 0.0 && isfinite(w->clock))) {
    em_error_set(err, EM_INPUT, w->scene->file, 0,
                 "the checkpoint: found %g s in its epoch, expected a time not below 0", w->clock);
    return false;
  }
  for (uint32_t i = 0; i < w->count; i++) {
    const char *expected = fault_of_ball(w, i);
    if (!expected) continue;
    em_error_set(err, EM_INPUT, w->scene->file, 0, "ball %u of the checkpoint: expected %s", i,
                 expected);
    return false;
  }
  return valid_blades(w, err);
}
