/* Runs of mill cost: each variant in turns with the scene as it is, from the same steady state. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "eventmill/recorder.h"
#include "eventmill/sample.h"
#include "tool/mill_cost.h"

enum { BLOCKS_PER_ROUND = 8 };

/* Computing time (s) of this process. */
static double cpu(void) {
  struct timespec t;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static enum em_status no_memory(struct em_error *err) {
  return em_error_set(err, EM_MEMORY, NULL, 0, "out of memory");
}

/* ---------------------------------------------------------------- scenes */

/* Half of the first species gets a density that differs in the 12th digit. */
static enum em_status mix(struct em_scene *scene, struct em_error *err) {
  const size_t n = scene->species_count;
  if (n == 0 || scene->species[0].count < 2) return EM_OK;
  struct em_species *more = realloc(scene->species, (n + 1) * sizeof *more);
  if (!more) return no_memory(err);
  scene->species = more;
  memmove(more + 1, more, n * sizeof *more);
  scene->species_count++;
  more[0].count = more[1].count / 2;
  more[1].count -= more[0].count;
  more[0].density *= 1.0 + 1e-12;
  /* The balls come from the snapshot; rows of a table stay with the other half. */
  if (more[0].start == EM_START_TABLE) more[0].speed = 0.0;
  more[0].start = EM_START_UNIFORM;
  more[0].position = more[0].velocity = more[0].spin = NULL;
  return EM_OK;
}

enum em_status em_mill_cost_run_scene(const struct em_cost *cost,
                                      const struct em_cost_variant *variant,
                                      struct em_scene **scene, size_t *hidden,
                                      struct em_error *err) {
  const size_t words = variant ? variant->words : 0, all = cost->override_count + words;
  const char **list = calloc(all + 1, sizeof *list);
  if (!list) return no_memory(err);
  for (size_t k = 0; k < cost->override_count; k++)
    list[k] = cost->overrides[k];
  for (size_t k = 0; k < words; k++)
    list[cost->override_count + k] = variant->word[k];
  *hidden = 0;
  enum em_status status = em_scene_read(scene, cost->path, all, list, err);
  free(list);
  if (!status) status = em_run_file_turn(*scene, err);
  if (status || !variant) return status;
  if (variant->change == EM_COST_NO_ROTOR) {
    *hidden = (*scene)->rotor_count;
    (*scene)->rotor_count = 0;
  }
  if (variant->change == EM_COST_MIXED) status = mix(*scene, err);
  return status;
}

void em_mill_cost_run_free(struct em_scene *scene, size_t hidden) {
  if (scene && hidden) scene->rotor_count = hidden;
  em_scene_free(scene);
}

/* ---------------------------------------------------------------- worlds */

/* The steady state in the shape that a scene needs. */
static enum em_status resume(const struct em_cost *cost, const struct em_scene *scene,
                             struct em_world **world, struct em_error *err) {
  const struct em_snapshot *from = cost->snapshot;
  const uint32_t n = from->count, blades = (uint32_t)em_scene_blade_count(scene);
  struct em_snapshot *s =
      em_world_snapshot_new(n, blades, em_scene_effects(scene) & EM_EFFECT_SPIN);
  if (!s) return no_memory(err);
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

/* A world on its way, with its books. */
struct walker {
  struct em_world *world;
  struct em_balls *balls;
  double *speeds;
  struct em_precision *precision;
  uint64_t *vn, *before; /* counts of a block; before it */
  double start, done;    /* s: simulated */
  double work;           /* J, before the block */
  struct em_energy energy;
};

enum { COUNTS = EM_CLASS_COUNT * EM_TALLY_BINS };

static double work_of(const struct em_world *world) {
  double work = em_world_tally(world)->drum_work;
  for (size_t k = 0; k < em_world_blade_count(world); k++)
    work += em_world_blade_tally(world, k)->work;
  return work;
}

static void stop(struct walker *w) {
  em_world_free(w->world);
  em_start_free(w->balls);
  em_precision_free(w->precision);
  free(w->speeds);
  free(w->vn);
  free(w->before);
}

static enum em_status begin(struct walker *w, const struct em_cost *cost,
                            const struct em_scene *scene, struct em_error *err) {
  memset(w, 0, sizeof *w);
  const enum em_status status = resume(cost, scene, &w->world, err);
  if (status) return status;
  const size_t n = em_world_count(w->world);
  w->balls = em_start_new(n);
  w->speeds = calloc(n + 1, sizeof *w->speeds);
  w->precision = em_precision_new();
  w->vn = calloc(COUNTS, sizeof *w->vn);
  w->before = calloc(COUNTS, sizeof *w->before);
  if (!w->balls || !w->speeds || !w->precision || !w->vn || !w->before) return no_memory(err);
  w->start = em_world_time(w->world);
  em_world_state(w->world, w->start, w->balls);
  w->energy = em_world_energy(w->world, w->balls);
  return EM_OK;
}

/* Books of a block of time that is over. */
static enum em_status book(struct walker *w, double time, struct em_error *err) {
  em_world_state(w->world, w->start + w->done, w->balls);
  for (size_t i = 0; i < w->balls->count; i++)
    w->speeds[i] = em_vec_norm(w->balls->velocity[i]);
  const double work = work_of(w->world);
  const uint64_t *now = &em_world_tally(w->world)->vn[0][0];
  for (size_t k = 0; k < COUNTS; k++)
    w->vn[k] = now[k] - w->before[k];
  memcpy(w->before, now, COUNTS * sizeof *now);
  if (em_precision_add(w->precision, time, em_sample_median(w->speeds, w->balls->count),
                       (work - w->work) / time, w->vn, EM_CLASS_COUNT))
    return no_memory(err);
  w->work = work;
  return EM_OK;
}

/* One round: `time` in blocks; *spent: computing time of the events alone. */
static enum em_status advance(struct walker *w, double time, double *spent, struct em_error *err) {
  *spent = 0.0;
  for (int k = 0; k < BLOCKS_PER_ROUND; k++) {
    const double step = time / BLOCKS_PER_ROUND, from = cpu();
    w->done += step;
    enum em_status status = em_world_run(w->world, w->start + w->done, NULL, err);
    *spent += cpu() - from;
    if (!status) status = book(w, step, err);
    if (status) return status;
  }
  return EM_OK;
}

/* What the books of energy miss, relative to the largest amount in them. */
static double energy_error(struct walker *w) {
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

static void take_figures(const struct em_precision *p, struct em_interval *figure) {
  for (int k = 0; k < EM_PRECISION_COUNT; k++)
    figure[k] =
        em_precision_figure(p, em_precision_blocks(p), (enum em_precision_kind)k, 3.0, 0.95);
}

/* ---------------------------------------------------------------- the scene as it is */

enum em_status em_mill_cost_run_steady(struct em_cost *cost, struct em_error *err) {
  struct em_balls *previous = NULL, *balls = NULL;
  struct em_world *world = NULL;
  enum em_status status = EM_OK;
  for (size_t i = 0; i < cost->scene->species_count && !status && !previous; i++)
    if (cost->scene->species[i].start == EM_START_RUN)
      status = em_run_file_last(cost->scene->species[i].from, &previous, err);
  if (!status) status = em_start_make(&balls, cost->scene, previous, err);
  if (!status) status = em_world_new(&world, cost->scene, balls, err);
  double spent = 0.0, taken = 0.0;
  enum { PARTS = 40 };
  for (int k = 1; k <= PARTS && !status; k++) {
    const double from = cpu();
    status = em_world_run(world, cost->steady * k / PARTS, NULL, err);
    if (2 * k > PARTS) {
      spent += cpu() - from;
      taken += cost->steady / PARTS;
    }
    em_mill_cost_tell(cost, 0.0, "to the steady state");
  }
  /* A second of computing where the user does not say. */
  if (!status && !(cost->time > 0.0))
    cost->time = spent > 0.0 && taken > 0.0 ? fmin(taken / spent, 10.0) : 0.1;
  if (!status) status = em_world_snapshot(world, &cost->snapshot, err);
  em_world_free(world);
  em_start_free(previous);
  em_start_free(balls);
  return status;
}

enum em_status em_mill_cost_run_base(struct em_cost *cost, struct em_error *err) {
  struct walker w;
  double all = 0.0;
  /* Four times as long as the others, for the statistics. */
  const int rounds = 4 * cost->rounds;
  enum em_status status = begin(&w, cost, cost->scene, err);
  for (int r = 0; r < rounds && !status; r++) {
    double spent;
    status = advance(&w, cost->time / cost->rounds, &spent, err);
    all += spent;
    em_mill_cost_tell(cost, 0.0, "the scene as it is");
  }
  if (!status) {
    cost->cpu_per_time = all / w.done;
    cost->collisions_per_time = (double)em_world_collisions(w.world) / w.done;
    cost->energy = energy_error(&w);
    take_figures(w.precision, cost->figure);
    cost->precision = w.precision;
    w.precision = NULL;
  }
  stop(&w);
  return status;
}

/* ---------------------------------------------------------------- variants */

static void settle(struct em_cost_result *result, double *ratio, size_t n) {
  result->time = em_sample_median(ratio, n);
  const struct em_sample sample = em_sample_describe(ratio, n);
  result->time_low = sample.q25;
  result->time_high = sample.q75;
}

/* In turns: AB, BA, AB, … on the same stretch of time. */
static enum em_status compare(struct em_cost *cost, const struct em_scene *scene,
                              struct em_cost_result *result, struct em_error *err) {
  struct walker a, b;
  double ratio[256], spent_a = 0.0, spent_b = 0.0;
  struct em_error inner = {0};
  enum em_status status = begin(&a, cost, cost->scene, err);
  memset(&b, 0, sizeof b);
  enum em_status bad = status ? EM_OK : begin(&b, cost, scene, &inner);
  int r = 0;
  for (; r < cost->rounds && !status && !bad; r++) {
    const double step = cost->time / cost->rounds;
    if (r % 2) bad = advance(&b, step, &spent_b, &inner);
    if (!bad) status = advance(&a, step, &spent_a, err);
    if (!status && !(r % 2)) bad = advance(&b, step, &spent_b, &inner);
    if (!status && !bad) ratio[r] = spent_b / spent_a;
  }
  if (bad) {
    result->failed = true;
    snprintf(result->why, sizeof result->why, "%.150s", inner.text);
  } else if (!status) {
    settle(result, ratio, (size_t)r);
    const double more = (double)em_world_collisions(b.world) / (double)em_world_collisions(a.world);
    result->collision = result->time / more;
    result->energy = energy_error(&b);
    take_figures(b.precision, result->figure);
    take_figures(a.precision, result->plain);
  }
  stop(&a);
  stop(&b);
  return status;
}

/* Computing time of a recorded run from the scene's start, less that of starting. */
static enum em_status record(const struct em_cost *cost, const struct em_cost_variant *variant,
                             double *spent, struct em_error *err) {
  static const char *const bare[] = {"record.frames=0.0", "record.observables=0.0",
                                     "record.histograms=0.0", "record.collisions=false",
                                     "record.checkpoint=1e9"};
  enum { BARE = sizeof bare / sizeof *bare };
  const char *list[64];
  char path[] = "/tmp/mill-cost-XXXXXX", duration[64];
  const int file = mkstemp(path);
  if (file < 0) return em_error_set(err, EM_FILE, path, 0, "cannot be created");
  close(file);
  enum em_status status = EM_OK;
  for (int pass = 0; pass < 2 && !status; pass++) {
    size_t n = 0;
    snprintf(duration, sizeof duration, "duration=%.17g", pass ? cost->time : 0.0);
    for (size_t k = 0; k < cost->override_count && n < 48; k++)
      list[n++] = cost->overrides[k];
    for (int k = 0; k < BARE; k++)
      list[n++] = bare[k];
    for (size_t k = 0; variant && k < variant->words; k++)
      list[n++] = variant->word[k];
    list[n++] = duration;
    struct em_scene *scene = NULL;
    status = em_scene_read(&scene, cost->path, n, list, err);
    if (!status) status = em_run_file_turn(scene, err);
    const struct em_recorder_options options = {.path = path, .force = true};
    const double from = cpu();
    if (!status) status = em_recorder_run(scene, &options, NULL, NULL, err);
    *spent = pass ? cpu() - from - *spent : cpu() - from;
    em_scene_free(scene);
  }
  remove(path);
  return status;
}

static enum em_status compare_recording(const struct em_cost *cost, struct em_cost_result *result,
                                        struct em_error *err) {
  double ratio[256], least = INFINITY;
  const int rounds = cost->rounds < 3 ? cost->rounds : 3;
  for (int r = 0; r < rounds; r++) {
    double a = 0.0, b = 0.0;
    enum em_status status = record(cost, NULL, &a, err);
    if (!status) status = record(cost, &result->variant, &b, err);
    if (status) return status;
    ratio[r] = b / a;
    least = fmin(least, a);
  }
  settle(result, ratio, (size_t)rounds);
  /* Starting takes some 10 ms more or less; a run must take much longer to tell anything. */
  if (least < 0.1) result->time = result->time_low = result->time_high = NAN;
  result->collision = result->time;
  for (int k = 0; k < EM_PRECISION_COUNT; k++)
    result->figure[k] = result->plain[k] = (struct em_interval){NAN, NAN, NAN, 0.0, 1.0};
  result->energy = NAN;
  return EM_OK;
}

enum em_status em_mill_cost_run_variant(struct em_cost *cost, struct em_cost_result *result,
                                        struct em_error *err) {
  if (result->variant.group == EM_COST_RECORDING) return compare_recording(cost, result, err);
  struct em_scene *scene = NULL;
  size_t hidden = 0;
  enum em_status status = em_mill_cost_run_scene(cost, &result->variant, &scene, &hidden, err);
  if (!status) status = compare(cost, scene, result, err);
  em_mill_cost_run_free(scene, hidden);
  return status;
}
