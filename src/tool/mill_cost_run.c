/* Runs of mill cost. Each variant settles into its own steady state; from there it keeps its books,
 * and is timed in turns with the scene as it is. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "eventmill/recorder.h"
#include "tool/mill_cost.h"
#include "tool/mill_cost_walk.h"

/* A run goes in so many stretches, each of which is timed. */
enum { STRETCHES = 64 };
/* Blocks of time that the books have. */
enum { BLOCKS = 4 * STRETCHES };
/* Where one run is so much slower than the other, few turns and blocks have to be enough. */
static const double PLAIN = 4.0;
enum { FEW_TURNS = 3, FEW_BLOCKS = BLOCKS / 16 };
/* A variant that collides so many times as often as the scene as it is comes to rest, in a heap
 * that no simulation by events gets through. */
static const double TOO_MANY = 30.0;
/* s of computing, by default: of a variant's run; of the scene as it is, for the statistics. */
static const double RUN = 0.3, LONG_RUN = 4.0;

/* ---------------------------------------------------------------- the scene as it is */

enum em_status em_mill_cost_run_steady(struct em_cost *cost, struct em_error *err) {
  enum { PARTS = 40 };
  struct em_balls *balls = NULL;
  struct em_world *world = NULL;
  enum em_status status = em_recorder_start(&balls, cost->scene, cost->stop, err);
  if (!status) status = em_world_new(&world, cost->scene, balls, err);
  double spent = 0.0, taken = 0.0;
  for (int k = 1; k <= PARTS && !status; k++) {
    const double from = em_mill_cost_walk_clock();
    status = em_world_run(world, cost->steady * k / PARTS, cost->stop, err);
    if (2 * k > PARTS) {
      spent += em_mill_cost_walk_clock() - from;
      taken += cost->steady / PARTS;
    }
    em_mill_cost_tell(cost, "to its steady state");
  }
  const double rate = spent > 0.0 && taken > 0.0 ? taken / spent : 0.1; /* s per s of computing */
  cost->long_time = cost->time > 0.0 ? 4.0 * cost->time : fmin(LONG_RUN * rate, 40.0);
  if (!(cost->time > 0.0)) cost->time = fmin(RUN * rate, 10.0);
  if (!status) status = em_world_snapshot_now(world, &cost->snapshot, err);
  em_world_free(world);
  em_start_free(balls);
  return status;
}

/* What a scene comes to after the steady state of the scene as it is: `walk` has its books. */
struct course {
  struct em_walk walk;
  struct em_snapshot *settled; /* where its turns begin */
  int blocks;                  /* booked */
  double spent, slow;          /* s of computing, for all of the walk; per s, at last */
};

static void end_course(struct course *c) {
  em_mill_cost_walk_end(&c->walk);
  em_world_snapshot_free(c->settled);
}

/* Settles for as long as the scene as it is took to its steady state. */
static enum em_status settle(const struct em_cost *cost, const struct em_scene *scene,
                             struct course *c, struct em_error *err) {
  enum { PARTS = 16 };
  enum em_status status = em_mill_cost_walk_begin(&c->walk, cost->snapshot, scene, cost->stop, err);
  for (int k = 0; k < PARTS && cost->steady > 0.0 && !status; k++) {
    double spent;
    c->walk.most = TOO_MANY * cost->collisions_per_time;
    status = em_mill_cost_walk_on(&c->walk, cost->steady / PARTS, false, &spent, err);
    c->spent += spent;
    c->slow = spent * PARTS / cost->steady;
    em_mill_cost_tell(cost, "settles");
  }
  return status ? status : em_world_snapshot(c->walk.world, &c->settled, err);
}

/* Keeps books of so many blocks; after an error, of those that are over. */
static enum em_status keep_books(const struct em_cost *cost, struct course *c, int blocks,
                                 struct em_error *err) {
  enum em_status status = EM_OK;
  for (c->blocks = 0; c->blocks < blocks && !status; c->blocks += !status) {
    double spent;
    status = em_mill_cost_walk_on(&c->walk, cost->long_time / BLOCKS, true, &spent, err);
    c->spent += spent;
    em_mill_cost_tell(cost, "figures");
  }
  return status;
}

/* The times of a scene that cannot go on end a little before it did, or with its duration. */
static bool cut(struct em_cost *cost, const struct course *c, const struct em_error *err) {
  if ((err->code != EM_COLLAPSE && err->code != EM_JAM) || !c->walk.world || cost->cut[0])
    return false;
  const double settled = c->walk.start + cost->steady, left = cost->scene->duration - settled;
  double most = 0.99 * (em_world_time(c->walk.world) - settled);
  if (left > 0.0) most = fmin(most, left);
  if (!(most > 0.0)) return false;
  snprintf(cost->cut, sizeof cost->cut, "%.150s", err->text);
  cost->long_time = fmin(cost->long_time, most);
  cost->time = fmin(cost->time, cost->long_time);
  return true;
}

static void take_base(struct em_cost *cost, struct course *c) {
  cost->cpu_per_time = c->spent / c->walk.done;
  cost->collisions_per_time = (double)em_world_collisions(c->walk.world) / c->walk.done;
  cost->energy = em_mill_cost_walk_energy(&c->walk);
  em_mill_cost_walk_figures(&c->walk, cost->figure);
  cost->precision = c->walk.precision;
  cost->settled = c->settled;
  c->walk.precision = NULL;
  c->settled = NULL;
}

enum em_status em_mill_cost_run_base(struct em_cost *cost, struct em_error *err) {
  enum em_status status;
  bool again = false;
  do {
    struct course c = {0};
    status = settle(cost, cost->scene, &c, err);
    if (!status) status = keep_books(cost, &c, BLOCKS, err);
    again = status && cut(cost, &c, err);
    if (!status) take_base(cost, &c);
    end_course(&c);
  } while (again);
  return status;
}

/* ---------------------------------------------------------------- variants */

/* The scene as it is, and a variant of it. */
enum { PLAIN_RUN, VARIANT_RUN, RUNS };

struct pair {
  const struct em_cost *cost;
  const struct em_scene *scene[RUNS];
  const struct em_snapshot *from[RUNS];
  struct em_walk walk[RUNS];
  struct em_error error[RUNS];
  double least[RUNS][STRETCHES]; /* s of computing, of all turns so far */
};

/* Both runs over the same time, stretch by stretch: AB, BA, AB, … *ratio: of their computing times.
 * Returns the run that failed, or RUNS. */
static int turn(struct pair *p, int number, double *ratio) {
  const double time = p->cost->time / STRETCHES;
  double all[RUNS] = {0.0};
  /* Where in memory a world comes to lie counts: each is made first in every other turn. */
  for (int n = 0; n < RUNS; n++) {
    const int k = (number + n) % RUNS;
    if (em_mill_cost_walk_begin(&p->walk[k], p->from[k], p->scene[k], p->cost->stop, &p->error[k]))
      return k;
    p->walk[k].most = TOO_MANY * p->cost->collisions_per_time;
  }
  for (int s = 0; s < STRETCHES; s++)
    for (int n = 0; n < RUNS; n++) {
      const int k = (s + number + n) % 2;
      double spent;
      if (em_mill_cost_walk_on(&p->walk[k], time, false, &spent, &p->error[k])) return k;
      p->least[k][s] = number == 0 ? spent : fmin(p->least[k][s], spent);
      all[k] += spent;
    }
  *ratio = all[VARIANT_RUN] / all[PLAIN_RUN];
  em_mill_cost_tell(p->cost, "turns");
  return RUNS;
}

static void end_turn(struct pair *p) {
  for (int k = 0; k < RUNS; k++) {
    em_mill_cost_walk_end(&p->walk[k]);
    memset(&p->walk[k], 0, sizeof p->walk[k]);
  }
}

/* Every turn repeats the same events: what makes one slower than another is the machine's doing, so
 * the least time of each stretch counts. */
static void take_times(const struct pair *p, struct em_cost_result *result, const double *ratio,
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

static enum em_status take_turns(struct pair *p, struct em_cost_result *result,
                                 struct em_error *err) {
  double ratio[EM_COST_ROUNDS];
  int turns = 0, bad = RUNS;
  while (turns < p->cost->rounds && bad == RUNS) {
    bad = turn(p, turns, &ratio[turns]);
    if (bad == RUNS && turns == 0) {
      const uint64_t plain = em_world_collisions(p->walk[PLAIN_RUN].world);
      result->collisions =
          plain > 0 ? (double)em_world_collisions(p->walk[VARIANT_RUN].world) / (double)plain : NAN;
    }
    end_turn(p);
    if (bad == RUNS && ratio[turns++] > PLAIN && turns >= FEW_TURNS) break;
  }
  if (bad != RUNS) {
    *err = p->error[bad];
    return err->code;
  }
  take_times(p, result, ratio, turns);
  return EM_OK;
}

/* The variant's own steady state, and its figures there. */
static enum em_status compare(const struct em_cost *cost, const struct em_scene *scene,
                              struct em_cost_result *result, struct course *c,
                              struct em_error *err) {
  enum em_status status = settle(cost, scene, c, err);
  if (status) return status;
  const bool slow = c->slow > PLAIN * cost->cpu_per_time;
  status = keep_books(cost, c, slow ? FEW_BLOCKS : BLOCKS, err);
  if (status) return status;
  for (int k = 0; k < EM_PRECISION_COUNT; k++)
    result->shift[k] = em_precision_shift(cost->precision, c->walk.precision,
                                          (enum em_precision_kind)k, 3.0, 0.95);
  result->energy = em_mill_cost_walk_energy(&c->walk);
  return EM_OK;
}

/* Its settled state, its figures, its times. */
static enum em_status measure(const struct em_cost *cost, const struct em_scene *scene,
                              struct em_cost_result *result, struct em_error *err) {
  struct course c = {0};
  struct pair *p = calloc(1, sizeof *p);
  if (!p) return em_mill_cost_no_memory(err);
  enum em_status status = compare(cost, scene, result, &c, err);
  if (!status) {
    *p = (struct pair){
        .cost = cost, .scene = {cost->scene, scene}, .from = {cost->settled, c.settled}};
    status = take_turns(p, result, err);
  }
  end_course(&c);
  free(p);
  return status;
}

static enum em_status run_variant(const struct em_cost *cost, struct em_cost_result *result,
                                  struct em_error *err) {
  if (result->variant.group == EM_COST_RECORDING) return em_mill_cost_record(cost, result, err);
  struct em_scene *scene = NULL;
  size_t hidden = 0;
  enum em_status status = em_mill_cost_scene(cost, &result->variant, &scene, &hidden, err);
  if (!status) status = measure(cost, scene, result, err);
  em_mill_cost_scene_free(scene, hidden);
  return status;
}

enum em_status em_mill_cost_run_variant(const struct em_cost *cost, struct em_cost_result *result,
                                        struct em_error *err) {
  struct em_error own = {0};
  const enum em_status status = run_variant(cost, result, &own);
  if (status == EM_STOPPED || status == EM_MEMORY) {
    if (err) *err = own;
    return status;
  }
  result->measured = true;
  result->failed = status != EM_OK;
  snprintf(result->why, sizeof result->why, "%.150s", own.text);
  return EM_OK;
}
