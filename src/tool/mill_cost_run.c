/* Runs of mill cost: each variant in turns with the scene as it is, from the same steady state. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "eventmill/recorder.h"
#include "tool/mill_cost.h"
#include "tool/mill_cost_walk.h"

/* A run goes in so many stretches, each of which is timed. */
enum { STRETCHES = 64 };
/* Where one run is so much slower than the other, few turns tell enough. */
static const double PLAIN = 4.0;
enum { FEW_TURNS = 3 };
/* s of computing, by default: of a variant's run; of the scene as it is, for the statistics. */
static const double RUN = 0.3, LONG_RUN = 4.0;

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

/* All balls get the smallest diameter, at which none overlap, and the mean mass. */
static void unmix(struct em_scene *scene) {
  double diameter = INFINITY, mass = 0.0, count = 0.0;
  for (size_t k = 0; k < scene->species_count; k++) {
    const struct em_species *s = &scene->species[k];
    diameter = fmin(diameter, s->diameter);
    mass += (double)s->count * s->density * pow(s->diameter, 3.0);
    count += (double)s->count;
  }
  for (size_t k = 0; k < scene->species_count; k++) {
    scene->species[k].diameter = diameter;
    scene->species[k].density = mass / (count * pow(diameter, 3.0));
  }
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
  if (variant->change == EM_COST_UNMIXED) unmix(*scene);
  if (variant->change == EM_COST_MIXED) status = mix(*scene, err);
  return status;
}

void em_mill_cost_run_free(struct em_scene *scene, size_t hidden) {
  if (scene && hidden) scene->rotor_count = hidden;
  em_scene_free(scene);
}

/* ---------------------------------------------------------------- the scene as it is */

enum em_status em_mill_cost_run_steady(struct em_cost *cost, struct em_error *err) {
  enum { PARTS = 40 };
  struct em_balls *balls = NULL;
  struct em_world *world = NULL;
  enum em_status status = em_recorder_start(&balls, cost->scene, NULL, err);
  if (!status) status = em_world_new(&world, cost->scene, balls, err);
  double spent = 0.0, taken = 0.0;
  for (int k = 1; k <= PARTS && !status; k++) {
    const double from = em_mill_cost_walk_clock();
    status = em_world_run(world, cost->steady * k / PARTS, NULL, err);
    if (2 * k > PARTS) {
      spent += em_mill_cost_walk_clock() - from;
      taken += cost->steady / PARTS;
    }
    em_mill_cost_tell(cost, 0.0, "to the steady state");
  }
  const double rate = spent > 0.0 && taken > 0.0 ? taken / spent : 0.1; /* s per s of computing */
  cost->long_time = cost->time > 0.0 ? 4.0 * cost->time : fmin(LONG_RUN * rate, 40.0);
  if (!(cost->time > 0.0)) cost->time = fmin(RUN * rate, 10.0);
  if (!status) status = em_world_snapshot(world, &cost->snapshot, err);
  em_world_free(world);
  em_start_free(balls);
  return status;
}

enum em_status em_mill_cost_run_base(struct em_cost *cost, struct em_error *err) {
  enum { BLOCKS = 4 * STRETCHES };
  struct em_walk w;
  double all = 0.0;
  enum em_status status = em_mill_cost_walk_begin(&w, cost->snapshot, cost->scene, err);
  for (int k = 0; k < BLOCKS && !status; k++) {
    double spent;
    status = em_mill_cost_walk_on(&w, cost->long_time / BLOCKS, true, &spent, err);
    all += spent;
    em_mill_cost_tell(cost, 0.0, "the scene as it is");
  }
  if (!status) {
    cost->cpu_per_time = all / w.done;
    cost->collisions_per_time = (double)em_world_collisions(w.world) / w.done;
    cost->energy = em_mill_cost_walk_energy(&w);
    em_mill_cost_walk_figures(&w, cost->figure);
    cost->precision = w.precision;
    w.precision = NULL;
  }
  em_mill_cost_walk_end(&w);
  return status;
}

/* ---------------------------------------------------------------- variants */

/* The scene as it is, and a variant of it. */
enum { PLAIN_RUN, VARIANT_RUN, RUNS };

struct pair {
  const struct em_cost *cost;
  const struct em_scene *scene[RUNS];
  struct em_walk walk[RUNS];
  struct em_error error[RUNS];
  double least[RUNS][STRETCHES]; /* s of computing, of all turns so far */
};

/* Both runs over the same time, stretch by stretch: AB, BA, AB, … *ratio: of their computing times.
 * The first turn keeps books. Returns the run that failed, or RUNS. */
static int turn(struct pair *p, int number, double *ratio) {
  const double time = p->cost->time / STRETCHES;
  double all[RUNS] = {0.0};
  /* Where in memory a world comes to lie counts: each is made first in every other turn. */
  for (int n = 0; n < RUNS; n++) {
    const int k = (number + n) % RUNS;
    if (em_mill_cost_walk_begin(&p->walk[k], p->cost->snapshot, p->scene[k], &p->error[k]))
      return k;
  }
  for (int s = 0; s < STRETCHES; s++)
    for (int n = 0; n < RUNS; n++) {
      const int k = (s + number + n) % 2;
      double spent;
      if (em_mill_cost_walk_on(&p->walk[k], time, number == 0, &spent, &p->error[k])) return k;
      p->least[k][s] = number == 0 ? spent : fmin(p->least[k][s], spent);
      all[k] += spent;
    }
  *ratio = all[VARIANT_RUN] / all[PLAIN_RUN];
  return RUNS;
}

static void end_turn(struct pair *p) {
  for (int k = 0; k < RUNS; k++) {
    em_mill_cost_walk_end(&p->walk[k]);
    memset(&p->walk[k], 0, sizeof p->walk[k]);
  }
}

static void take_figures(struct pair *p, struct em_cost_result *result) {
  struct em_walk *plain = &p->walk[PLAIN_RUN], *variant = &p->walk[VARIANT_RUN];
  for (int k = 0; k < EM_PRECISION_COUNT; k++)
    result->shift[k] = em_precision_shift(plain->precision, variant->precision,
                                          (enum em_precision_kind)k, 3.0, 0.95);
  result->energy = em_mill_cost_walk_energy(variant);
  result->collisions =
      (double)em_world_collisions(variant->world) / (double)em_world_collisions(plain->world);
}

/* Every turn repeats the same events: what makes one slower than another is the machine's doing, so
 * the least time of each stretch counts. */
static void settle(const struct pair *p, struct em_cost_result *result, const double *ratio,
                   int turns) {
  double least[RUNS] = {0.0};
  for (int k = 0; k < RUNS; k++)
    for (int s = 0; s < STRETCHES; s++)
      least[k] += p->least[k][s];
  result->time = least[VARIANT_RUN] / least[PLAIN_RUN];
  result->time_low = result->time_high = result->time;
  for (int k = 0; k < turns; k++) {
    result->time_low = fmin(result->time_low, ratio[k]);
    result->time_high = fmax(result->time_high, ratio[k]);
  }
  result->collision = result->time / result->collisions;
}

static enum em_status compare(struct em_cost *cost, const struct em_scene *scene,
                              struct em_cost_result *result, struct em_error *err) {
  struct pair *p = calloc(1, sizeof *p);
  if (!p) return no_memory(err);
  double ratio[EM_COST_ROUNDS];
  int turns = 0, bad = RUNS;
  p->cost = cost;
  p->scene[PLAIN_RUN] = cost->scene;
  p->scene[VARIANT_RUN] = scene;
  while (turns < cost->rounds && bad == RUNS) {
    bad = turn(p, turns, &ratio[turns]);
    if (bad == RUNS && turns == 0) take_figures(p, result);
    end_turn(p);
    if (bad == RUNS && ratio[turns++] > PLAIN && turns >= FEW_TURNS) break;
  }
  enum em_status status = EM_OK;
  if (bad == RUNS) {
    settle(p, result, ratio, turns);
  } else if (bad == VARIANT_RUN) {
    result->failed = true;
    snprintf(result->why, sizeof result->why, "%.150s", p->error[VARIANT_RUN].text);
  } else {
    if (err) *err = p->error[PLAIN_RUN];
    status = p->error[PLAIN_RUN].code;
  }
  free(p);
  return status;
}

enum em_status em_mill_cost_run_variant(struct em_cost *cost, struct em_cost_result *result,
                                        struct em_error *err) {
  if (result->variant.group == EM_COST_RECORDING) return em_mill_cost_record(cost, result, err);
  struct em_scene *scene = NULL;
  size_t hidden = 0;
  enum em_status status = em_mill_cost_run_scene(cost, &result->variant, &scene, &hidden, err);
  if (!status) status = compare(cost, scene, result, err);
  em_mill_cost_run_free(scene, hidden);
  return status;
}
