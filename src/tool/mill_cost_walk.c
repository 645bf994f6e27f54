/* A world on its way from a state, with its books. */
#include "tool/mill_cost_walk.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "eventmill/sample.h"
#include "record/summary.h"
#include "tool/mill_cost.h"

enum { COUNTS = EM_CLASS_COUNT * EM_TALLY_BINS };

/* So few collisions are never too many. */
enum { FEW = 10000 };

double em_mill_cost_walk_clock(void) {
  struct timespec t;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static enum em_status resume(struct em_world **world, const struct em_snapshot *from,
                             const struct em_scene *scene, struct em_error *err) {
  const uint32_t n = from->count, blades = (uint32_t)em_scene_blade_count(scene);
  struct em_snapshot *s =
      em_world_snapshot_new(n, blades, em_scene_effects(scene) & EM_EFFECT_SPIN);
  if (!s) return em_mill_cost_no_memory(err);
  s->origin = from->origin;
  s->epoch = from->epoch;
  s->clock = from->clock;
  memcpy(s->position, from->position, n * sizeof *s->position);
  memcpy(s->velocity, from->velocity, n * sizeof *s->velocity);
  memcpy(s->time, from->time, n * sizeof *s->time);
  memcpy(s->last, from->last, n * sizeof *s->last);
  if (s->spin && from->spin) memcpy(s->spin, from->spin, n * sizeof *s->spin);
  for (uint32_t k = 0; k < blades && k < from->blade_count; k++)
    s->blade_angle[k] = from->blade_angle[k];
  const enum em_status status = em_world_resume(world, scene, s, err);
  em_world_snapshot_free(s);
  return status;
}

static double work_of(const struct em_world *world) {
  double work = em_world_tally(world)->drum_work;
  for (size_t k = 0; k < em_world_blade_count(world); k++)
    work += em_world_blade_tally(world, k)->work;
  return work;
}

enum em_status em_mill_cost_walk_begin(struct em_walk *w, const struct em_snapshot *from,
                                       const struct em_scene *scene,
                                       const volatile sig_atomic_t *stop, struct em_error *err) {
  *w = (struct em_walk){.stop = stop, .falls = em_summary_falls_for_ever(scene)};
  const enum em_status status = resume(&w->world, from, scene, err);
  if (status) return status;
  const size_t n = em_world_count(w->world);
  w->balls = em_start_new(n);
  w->speeds = calloc(n + 1, sizeof *w->speeds);
  w->precision = em_precision_new();
  w->vn = calloc(COUNTS, sizeof *w->vn);
  w->before = calloc(COUNTS, sizeof *w->before);
  if (!w->balls || !w->speeds || !w->precision || !w->vn || !w->before)
    return em_mill_cost_no_memory(err);
  w->start = em_world_time(w->world);
  em_world_state(w->world, w->start, w->balls);
  w->energy = em_world_energy(w->world, w->balls);
  return EM_OK;
}

void em_mill_cost_walk_end(struct em_walk *w) {
  em_world_free(w->world);
  em_start_free(w->balls);
  em_precision_free(w->precision);
  free(w->speeds);
  free(w->vn);
  free(w->before);
}

/* From here on the books of the next block are kept. */
static void open_books(struct em_walk *w) {
  w->work = work_of(w->world);
  memcpy(w->before, em_world_tally(w->world)->vn, COUNTS * sizeof *w->before);
}

/* Books of a block of time that is over. */
static enum em_status book(struct em_walk *w, double time, struct em_error *err) {
  em_world_state(w->world, w->start + w->done, w->balls);
  for (size_t i = 0; i < w->balls->count; i++)
    w->speeds[i] = em_vec_norm(w->balls->velocity[i]);
  const double work = work_of(w->world) - w->work;
  const uint64_t *now = &em_world_tally(w->world)->vn[0][0];
  for (size_t k = 0; k < COUNTS; k++)
    w->vn[k] = now[k] - w->before[k];
  if (em_precision_add(w->precision, time, em_sample_median(w->speeds, w->balls->count),
                       work / time, w->vn, EM_CLASS_COUNT))
    return em_mill_cost_no_memory(err);
  return EM_OK;
}

/* Runs until a time, unless there are too many collisions. */
static enum em_status run(struct em_walk *w, double time, struct em_error *err) {
  const uint64_t before = em_world_collisions(w->world);
  const uint64_t limit = w->most > 0.0 ? FEW + (uint64_t)(w->most * time) : UINT64_MAX;
  const enum em_status status =
      em_world_run_collisions(w->world, w->start + w->done + time, limit, w->stop, err);
  if (status) return status;
  if (*w->stop) /* the world may have had no event to notice it */
    return em_error_set(err, EM_STOPPED, NULL, 0, "stopped on request");
  if (em_world_collisions(w->world) - before < limit) return EM_OK;
  return em_error_set(err, EM_COLLAPSE, NULL, 0,
                      "comes to rest: more than %.2g collisions per second", w->most);
}

enum em_status em_mill_cost_walk_on(struct em_walk *w, double time, bool booked, double *spent,
                                    struct em_error *err) {
  const double from = em_mill_cost_walk_clock();
  enum em_status status = run(w, time, err);
  *spent = em_mill_cost_walk_clock() - from;
  if (status) return status;
  w->done += time;
  if (booked) status = book(w, time, err);
  open_books(w);
  return status;
}

double em_mill_cost_walk_energy(struct em_walk *w) {
  if (w->falls) return NAN;
  em_world_state(w->world, w->start + w->done, w->balls);
  const struct em_energy a = w->energy, b = em_world_energy(w->world, w->balls);
  const double work = work_of(w->world);
  double lost = 0.0;
  for (int c = 0; c < EM_CLASS_COUNT; c++)
    lost += em_world_tally(w->world)->lost[c];
  const double gap =
      (a.kinetic + a.spin + a.potential) + work - lost - (b.kinetic + b.spin + b.potential);
  const double scale = fmax(fmax(a.kinetic + a.spin, b.kinetic + b.spin), fmax(fabs(work), lost));
  return scale > 0.0 ? fabs(gap) / scale : 0.0;
}

void em_mill_cost_walk_figures(const struct em_walk *w, struct em_interval *figure) {
  const size_t blocks = em_precision_blocks(w->precision);
  for (int k = 0; k < EM_PRECISION_COUNT; k++)
    figure[k] = em_precision_figure(w->precision, blocks, (enum em_precision_kind)k, 3.0, 0.95);
}
