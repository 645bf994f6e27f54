/* The key figures of a run. */
#include "record/summary.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "eventmill/histogram.h"

static const double STEADY_FROM = 0.2;  /* s */
static const double HARD_FROM = 3.0;    /* m/s; an edge of a bin */
static const double RESTING = 0.1;      /* share of the balls from which it is said */
static const double TIME_SLACK = 1e-12; /* relative, for k / rate against a time */

bool em_summary_begin(struct em_summary_part *part, double duration) {
  memset(part, 0, sizeof *part);
  part->steady = fmin(STEADY_FROM, 0.5 * duration);
  part->vn = calloc(EM_TALLY_BINS, sizeof *part->vn);
  return part->vn;
}

void em_summary_end(struct em_summary_part *part) {
  free(part->time);
  free(part->median);
  free(part->work);
  free(part->resting);
  free(part->vn);
  memset(part, 0, sizeof *part);
}

static bool grow(double **array, size_t room) {
  double *more = realloc(*array, room * sizeof *more);
  if (more) *array = more;
  return more;
}

bool em_summary_sample(struct em_summary_part *part, double time, double median, double work,
                       double resting) {
  if (part->samples == part->room) {
    const size_t room = part->room ? 2 * part->room : 256;
    if (!grow(&part->time, room) || !grow(&part->median, room) || !grow(&part->work, room) ||
        !grow(&part->resting, room))
      return false;
    part->room = room;
  }
  part->time[part->samples] = time;
  part->median[part->samples] = median;
  part->resting[part->samples] = resting;
  part->work[part->samples++] = work;
  return true;
}

static bool is_steady(const struct em_summary_part *part, double time) {
  return time >= part->steady * (1.0 - TIME_SLACK);
}

void em_summary_block(struct em_summary_part *part, double start, double end,
                      const uint64_t *counts) {
  if (!is_steady(part, start)) return;
  for (size_t i = 0; i < EM_CLASS_COUNT * (size_t)EM_TALLY_BINS; i++)
    part->vn[i % EM_TALLY_BINS] += counts[i];
  part->covered += end - start;
}

/* ---------------------------------------------------------------- v_n */

static double median_of(const uint64_t *vn, uint64_t total) {
  double edge[EM_TALLY_BINS + 1], count[EM_TALLY_BINS];
  for (size_t k = 0; k <= EM_TALLY_BINS; k++)
    edge[k] = em_world_bin_edge(k);
  for (size_t k = 0; k < EM_TALLY_BINS; k++)
    count[k] = (double)vn[k];
  const double open = count[EM_TALLY_BINS - 1]; /* the last bin holds what lies above as well */
  const struct em_histogram h = {.bins = EM_TALLY_BINS - 1,
                                 .edge = edge,
                                 .count = count,
                                 .total = (double)total - open,
                                 .above = open};
  return em_histogram_quantile(&h, 0.5);
}

static void fill_vn(struct em_summary *summary, const uint64_t *vn, double time) {
  uint64_t total = 0, hard = 0;
  for (size_t k = 0; k < EM_TALLY_BINS; k++) {
    total += vn[k];
    if (em_world_bin_edge(k) >= HARD_FROM) hard += vn[k];
  }
  summary->median_vn = median_of(vn, total);
  summary->rate_above_3 = time > 0.0 ? (double)hard / time : NAN;
  summary->share_above_3 = total ? (double)hard / (double)total : NAN;
}

static void fill_histogram(struct em_summary *summary, const struct em_summary_part *part,
                           const struct em_tally *tally) {
  if (part->covered > 0.0) {
    fill_vn(summary, part->vn, part->covered);
    return;
  }
  uint64_t all[EM_TALLY_BINS] = {0};
  for (int c = 0; c < EM_CLASS_COUNT; c++)
    for (size_t k = 0; k < EM_TALLY_BINS; k++)
      all[k] += tally->vn[c][k];
  fill_vn(summary, all, summary->simulated_time);
}

/* ---------------------------------------------------------------- the others */

static size_t first_steady(const struct em_summary_part *part) {
  size_t first = 0;
  while (first < part->samples && !is_steady(part, part->time[first]))
    first++;
  return first;
}

static double mean(const double *values, size_t first, size_t end) {
  double sum = 0.0;
  for (size_t i = first; i < end; i++)
    sum += values[i];
  return sum / (double)(end - first);
}

void em_summary_warn(const struct em_summary_part *part, const struct em_scene *scene, char *text,
                     size_t size) {
  const size_t first = first_steady(part);
  const unsigned driven = EM_EFFECT_ROTOR | EM_EFFECT_TURNING, effects = em_scene_effects(scene);
  const bool rests = effects & EM_EFFECT_GRAVITY && effects & driven && first < part->samples;
  const double share = rests ? mean(part->resting, first, part->samples) : 0.0;
  text[0] = '\0';
  if (share >= RESTING)
    snprintf(text, size,
             "%.0f %% of the balls rest: they are too slow to rise by their own diameter. The mill "
             "turns too slowly to hold them up, or they lie where nothing stirs them; where balls "
             "lie on one another, a contact that lasts is counted as many short ones",
             100.0 * share);
}

/* Mean of the median over the samples of the steady part, and the work between its first and last
 * one; the state now when there are too few. */
static void fill_samples(struct em_summary *summary, const struct em_summary_part *part,
                         const struct em_world *world, const struct em_observe_state *now) {
  const size_t first = first_steady(part), count = part->samples - first;
  summary->median_speed = count ? mean(part->median, first, part->samples) : now->median_speed;
  const size_t last = part->samples - 1;
  if (count > 1)
    summary->power =
        (part->work[last] - part->work[first]) / (part->time[last] - part->time[first]);
  else
    summary->power =
        summary->simulated_time > 0.0 ? em_observe_work(world) / summary->simulated_time : NAN;
}

bool em_summary_falls_for_ever(const struct em_scene *scene) {
  const double g[3] = {scene->gravity.x, scene->gravity.y, scene->gravity.z};
  for (int i = 0; i < 3; i++)
    if (scene->chamber.shape == EM_SHAPE_BOX && scene->chamber.periodic[i] && g[i] != 0.0)
      return true;
  return false;
}

double em_summary_energy_scale(double kinetic_start, double kinetic, double rise, double work,
                               double lost) {
  return fmax(fmax(kinetic_start, kinetic), fmax(fabs(rise), fmax(fabs(work), fabs(lost))));
}

static double energy_error(const struct em_scene *scene, const struct em_world *world,
                           const struct em_run_state *state, const struct em_energy *now) {
  if (em_summary_falls_for_ever(scene)) return NAN;
  const double kinetic = now->kinetic + now->spin;
  const double work = em_observe_work(world), lost = em_observe_lost(world);
  const double rise = now->potential - state->potential_start;
  const double gap = (state->kinetic_start - kinetic) - rise + work - lost;
  const double scale = em_summary_energy_scale(state->kinetic_start, kinetic, rise, work, lost);
  return scale > 0.0 ? fabs(gap) / scale : 0.0;
}

void em_summary_fill(struct em_summary *summary, const struct em_summary_part *part,
                     const struct em_scene *scene, const struct em_world *world,
                     const struct em_run_state *state, const struct em_observe_state *now) {
  const struct em_tally *tally = em_world_tally(world);
  summary->end = state->end;
  summary->collisions = em_world_collisions(world);
  memcpy(summary->by_class, tally->collisions, sizeof summary->by_class);
  summary->simulated_time = state->time;
  summary->steady = part->steady;
  summary->tc = tally->tc;
  summary->elastic = tally->elastic;
  summary->jam = tally->jam;
  em_summary_warn(part, scene, summary->warning, sizeof summary->warning);
  fill_samples(summary, part, world, now);
  fill_histogram(summary, part, tally);
  summary->energy_error = energy_error(scene, world, state, &now->energy);
}
