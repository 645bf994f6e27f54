/* Chooses times and balls for a view, and packs positions and velocities. */
#include "draw/view_frames.h"

#include <stdlib.h>
#include <string.h>

static enum em_status no_memory(struct em_error *err) {
  return em_error_set(err, EM_MEMORY, NULL, 0, "no memory for the frames of a view");
}

/* limit of count balls, evenly. */
static enum em_status choose_balls(struct em_view_frames *f, size_t limit, struct em_error *err) {
  f->balls = limit > 0 && limit < f->total ? limit : f->total;
  f->chosen = calloc(f->balls + 1, sizeof *f->chosen);
  if (f->chosen == NULL) return no_memory(err);
  for (size_t k = 0; k < f->balls; k++)
    f->chosen[k] = (size_t)(((double)k + 0.5) * (double)f->total / (double)f->balls);
  return EM_OK;
}

/* Times from `from` to `to`: at even steps, or those of the stored frames (step NAN). */
static enum em_status list_times(struct em_view_frames *f, const struct em_run_file *run,
                                 double from, double to, double step, struct em_error *err) {
  const double slack = 1e-9 * (to - from);
  const size_t stored = em_run_file_frame_count(run);
  const double steps = isnan(step) ? (double)stored : floor((to - from + slack) / step) + 2.0;
  if (steps > 1e8)
    return em_error_set(err, EM_INPUT, NULL, 0, "%g frames of a view are too many", steps);
  f->time = calloc((size_t)steps + 1, sizeof *f->time);
  if (f->time == NULL) return no_memory(err);
  if (isnan(step)) {
    for (size_t k = 0; k < stored; k++) {
      const double t = em_run_file_frame_time(run, k);
      if (t >= from - slack && t <= to + slack) f->time[f->count++] = t;
    }
  } else {
    for (double k = 0.0; from + k * step <= to + slack; k += 1.0)
      f->time[f->count++] = fmin(from + k * step, to);
  }
  if (f->count == 0)
    return em_error_set(err, EM_INPUT, NULL, 0, "no stored frame from %g to %g s", from, to);
  return EM_OK;
}

/* Keeps every n-th frame, so that the file stays below its limit. */
static void thin(struct em_view_frames *f, size_t ball_bytes, size_t most_bytes) {
  const size_t each = f->balls * ball_bytes, encoded = (each + 2) / 3 * 4;
  const size_t room = encoded > 0 ? most_bytes / encoded : f->count;
  f->wanted = f->count;
  if (f->count <= room || f->count < 3) return;
  const size_t every = room > 1 ? (f->count - 1 + room - 2) / (room - 1) : f->count - 1;
  size_t kept = 0;
  for (size_t k = 0; k < f->count; k += every)
    f->time[kept++] = f->time[k];
  f->count = kept;
}

static void put16(uint8_t *to, int value) {
  to[0] = (uint8_t)(value & 0xff);
  to[1] = (uint8_t)((value >> 8) & 0xff);
}

static void pack(struct em_view_frames *f, size_t frame, const struct em_balls *balls,
                 struct em_vec low, struct em_vec high) {
  uint8_t *place = f->bytes + frame * f->balls * EM_VIEW_BALL_BYTES, *rate = place + 6 * f->balls;
  double most = 0.0;
  for (size_t k = 0; k < f->balls; k++)
    for (int a = 0; a < 3; a++)
      most = fmax(most, fabs(em_vec_component(balls->velocity[f->chosen[k]], a)));
  f->scale[frame] = most / 32767.0;
  for (size_t k = 0; k < f->balls; k++)
    for (int a = 0; a < 3; a++) {
      const struct em_vec p = balls->position[f->chosen[k]], v = balls->velocity[f->chosen[k]];
      const double u = (em_vec_component(p, a) - em_vec_component(low, a)) /
                       (em_vec_component(high, a) - em_vec_component(low, a));
      put16(place + 6 * k + 2 * a, (int)lround(65535.0 * fmin(fmax(u, 0.0), 1.0)));
      put16(rate + 6 * k + 2 * a,
            most > 0.0 ? (int)lround(32767.0 * em_vec_component(v, a) / most) : 0);
    }
}

static void pack_spins(struct em_view_frames *f, size_t frame, const struct em_balls *balls) {
  uint8_t *spin = f->spins + frame * f->balls * EM_VIEW_SPIN_BYTES;
  double most = 0.0;
  for (size_t k = 0; k < f->balls; k++)
    most = fmax(most, em_vec_norm(balls->spin[f->chosen[k]]));
  f->spin_scale[frame] = most / 65535.0;
  for (size_t k = 0; k < f->balls; k++)
    put16(spin + EM_VIEW_SPIN_BYTES * k,
          most > 0.0 ? (int)lround(65535.0 * em_vec_norm(balls->spin[f->chosen[k]]) / most) : 0);
}

static void pack_classes(struct em_view_frames *f, size_t frame, const uint8_t *last) {
  for (size_t k = 0; k < f->balls; k++)
    f->classes[frame * f->balls + k] = last ? last[f->chosen[k]] : EM_CLASS_COUNT;
}

static bool make_room(struct em_view_frames *f, bool spins, bool classes) {
  f->scale = calloc(f->count, sizeof *f->scale);
  f->bytes = malloc(f->count * f->balls * EM_VIEW_BALL_BYTES + 1);
  if (spins) {
    f->spin_scale = calloc(f->count, sizeof *f->spin_scale);
    f->spins = malloc(f->count * f->balls * EM_VIEW_SPIN_BYTES + 1);
  }
  if (classes) f->classes = malloc(f->count * f->balls + 1);
  return f->scale && f->bytes && (!spins || (f->spin_scale && f->spins)) &&
         (!classes || f->classes);
}

static enum em_status pack_all(struct em_view_frames *f, struct em_motion *motion,
                               const struct em_scene *scene, struct em_error *err) {
  struct em_vec low, high;
  em_scene_extent(scene, &low, &high);
  for (size_t k = 0; k < f->count; k++) {
    const enum em_status status = em_motion_seek(motion, f->time[k], err);
    if (status != EM_OK) return status;
    const struct em_balls *balls = em_motion_balls(motion);
    for (size_t b = 0; b < balls->count; b++)
      if (!isfinite(em_vec_norm2(balls->position[b])) ||
          !isfinite(em_vec_norm2(balls->velocity[b])))
        return em_error_set(err, EM_INPUT, NULL, 0,
                            "ball %zu has no place or velocity that is a number", b);
    pack(f, k, balls, low, high);
    if (f->spins) pack_spins(f, k, balls);
    if (f->classes) pack_classes(f, k, em_motion_classes(motion));
  }
  return EM_OK;
}

enum em_status em_view_frames_fill(struct em_view_frames *frames, const struct em_run_file *run,
                                   struct em_motion *motion, const struct em_view_options *options,
                                   struct em_error *err) {
  const double first = em_motion_first(motion), last = em_motion_last(motion);
  const double from = fmax(first, isnan(options->from) ? first : options->from);
  const double to = fmin(last, isnan(options->to) ? last : options->to);
  if (!(from <= to))
    return em_error_set(err, EM_INPUT, em_run_file_path(run), 0,
                        "nothing to show from %g to %g s: the run has frames from %g to %g s",
                        isnan(options->from) ? first : options->from,
                        isnan(options->to) ? last : options->to, first, last);
  const double step = isnan(options->step) && em_motion_is_exact(motion) ? 0.001 : options->step;
  frames->total = em_run_file_ball_count(run);
  enum em_status status = choose_balls(frames, options->balls, err);
  if (status == EM_OK) status = list_times(frames, run, from, to, step, err);
  if (status != EM_OK) return status;
  const struct em_scene *scene = em_run_file_scene(run);
  const bool spins = (em_scene_effects(scene) & EM_EFFECT_SPIN) != 0;
  const bool classes = em_motion_is_exact(motion);
  size_t ball_bytes = EM_VIEW_BALL_BYTES;
  if (spins) ball_bytes += EM_VIEW_SPIN_BYTES;
  if (classes) ball_bytes++;
  thin(frames, ball_bytes, options->largest > 0 ? options->largest : (size_t)48 << 20);
  if (!make_room(frames, spins, classes)) return no_memory(err);
  return pack_all(frames, motion, scene, err);
}

void em_view_frames_clear(struct em_view_frames *frames) {
  free(frames->time);
  free(frames->scale);
  free(frames->chosen);
  free(frames->spin_scale);
  free(frames->bytes);
  free(frames->spins);
  free(frames->classes);
  memset(frames, 0, sizeof *frames);
}
