/* Runs a scene and records it: leads the world from sampling time to sampling time. */
#include "eventmill/recorder.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>

#include "record/provenance.h"
#include "record/recorder_inside.h"
#include "record/recorder_start.h"

/* Collisions between two looks at the clock; share of the time that checkpoints may take. */
enum { CHUNK = 10000 };
static const double CHECKPOINT_SHARE = 0.1;
/* Whoever asks for checkpoints closer than this (s) wants one at every look. */
static const double AT_EVERY_LOOK = 1e-3;
/* Relative difference of two roundings of one time: of a rate, of k / rate, of a duration. */
static const double SAME_TIME = 1e-15;

_Static_assert((int)EM_PRECISION_PER_OCTAVE == (int)EM_TALLY_PER_OCTAVE &&
                   (int)EM_PRECISION_LOWEST == (int)EM_TALLY_LOWEST &&
                   (int)EM_PRECISION_OCTAVES == (int)EM_TALLY_OCTAVES,
               "a tally's bins are those of its precision");

static double wall_clock(void) {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static enum em_status no_memory(struct em_error *err) {
  return em_error_set(err, EM_MEMORY, NULL, 0, "out of memory");
}

/* ---------------------------------------------------------------- sampling */

/* Time of sample k; rates of 0 never sample. */
static double time_of(uint64_t k, double rate) {
  return rate > 0.0 ? (double)k / rate : INFINITY;
}

static void look(struct recorder *r, struct em_observe_state *state, double time) {
  *state = (struct em_observe_state){.world = r->world, .time = time};
  em_world_state(r->world, time, r->balls);
  em_observe_balls(state, r->scene, r->balls, r->speeds);
  state->interval = r->samples ? time - r->sample_before : 0.0;
  state->impulse_before = r->impulse;
}

static enum em_status sample(struct recorder *r, double time, struct em_error *err) {
  struct em_observe_state state;
  look(r, &state, time);
  enum em_status status = EM_OK;
  if (r->writer) status = em_writer_sample(r->writer, &state, err);
  for (size_t k = 0; k < em_world_blade_count(r->world); k++)
    r->impulse[k] = em_world_blade_tally(r->world, k)->angular_impulse;
  r->sample_before = time;
  r->samples++;
  if (!status && !em_summary_sample(&r->part, time, state.median_speed, em_observe_work(r->world),
                                    state.resting))
    status = no_memory(err);
  return status;
}

static enum em_status frame(struct recorder *r, double time, struct em_error *err) {
  r->frames++;
  if (!r->writer) return EM_OK;
  em_world_state(r->world, time, r->balls);
  return em_writer_frame(r->writer, time, r->balls, err);
}

/* Median speed and power of a block: the mean over the samples in it, and the work from the last
 * one before it to its own last one. With check_targets there is a sample in each. */
static void block_figures(const struct em_summary_part *part, double start, double end,
                          double *speed, double *power) {
  size_t after = part->samples;
  while (after > 0 && part->time[after - 1] > end)
    after--;
  size_t first = after;
  double sum = 0.0;
  while (first > 0 && part->time[first - 1] > start)
    sum += part->median[--first];
  *speed = first < after ? sum / (double)(after - first) : NAN;
  *power = NAN;
  if (0 < first && first < after)
    *power = (part->work[after - 1] - part->work[first - 1]) /
             (part->time[after - 1] - part->time[first - 1]);
}

enum em_status em_recorder_add_precision(struct recorder *r, double start, double end,
                                         struct em_error *err) {
  if (!r->precision || start < r->part.steady * (1.0 - 1e-12)) return EM_OK;
  double speed, power;
  block_figures(&r->part, start, end, &speed, &power);
  if (em_precision_add(r->precision, end - start, speed, power, r->block, EM_CLASS_COUNT))
    return no_memory(err);
  return EM_OK;
}

bool em_recorder_is_enough(const struct recorder *r) {
  const struct em_recorder_options *o = r->options;
  return r->precision && em_precision_judge(r->precision, o->target, o->target_count, o->found);
}

/* The counts since the block began, into r->block. An open block goes to the file alone. */
static enum em_status block(struct recorder *r, double time, bool open, struct em_error *err) {
  const uint64_t *now = &em_world_tally(r->world)->vn[0][0];
  const double start = r->blocks ? time_of(r->blocks, r->scene->record.histograms) : 0.0;
  if (open && !(time > start)) return EM_OK;
  for (size_t i = 0; i < COUNTS; i++)
    r->block[i] = now[i] - r->block_base[i];
  if (!open) {
    memcpy(r->block_base, now, COUNTS * sizeof *now);
    em_summary_block(&r->part, start, time, r->block);
    r->blocks++;
    const enum em_status status = em_recorder_add_precision(r, start, time, err);
    if (status) return status;
    if (r->precision && em_precision_is_due(r->precision)) r->enough = em_recorder_is_enough(r);
  }
  return r->writer ? em_writer_block(r->writer, start, time, open, r->block, err) : EM_OK;
}

/* ---------------------------------------------------------------- flushing */

/* The world's clock counts from its epoch: at a sampling time it may be a rounding error away. */
static double time_now(const struct recorder *r) {
  const double time = em_world_time(r->world);
  return fabs(time - r->reached) <= 1e-14 * r->reached ? r->reached : time;
}

static enum em_status flush(struct recorder *r, bool last, struct em_error *err) {
  r->state.time = time_now(r);
  r->state.collisions = em_world_collisions(r->world);
  if (!r->writer) return EM_OK;
  const double start = wall_clock();
  struct em_writer_flush what = {.state = r->state, .last = last};
  struct em_snapshot *snapshot = NULL;
  enum em_status status = block(r, r->state.time, true, err);
  if (!status) status = em_world_snapshot(r->world, &snapshot, err);
  if (!status) {
    em_provenance_update(&r->session, start - r->begun, r->state.time);
    what.session = r->session;
    what.snapshot = snapshot;
    status = em_writer_flush(r->writer, &what, err);
  }
  em_world_snapshot_free(snapshot);
  r->flushed = wall_clock();
  r->flush_cost = r->flushed - start;
  return status;
}

static bool is_flush_due(const struct recorder *r, double now) {
  const double asked = r->scene->record.checkpoint;
  const double least = asked >= AT_EVERY_LOOK ? r->flush_cost / CHECKPOINT_SHARE : 0.0;
  return now - r->flushed >= fmax(asked, least);
}

/* ---------------------------------------------------------------- running */

static void observe(void *self, const struct em_contact *contact) {
  em_writer_contact(((struct recorder *)self)->writer, contact);
}

static enum em_status begin_observing(struct recorder *r, struct em_error *err) {
  const struct em_observer table = {.self = r, .contact = observe}, *caller = r->options->observer;
  enum em_status status = EM_OK;
  if (r->writer && r->scene->record.collisions) status = em_world_observe(r->world, &table);
  if (!status && caller) status = em_world_observe(r->world, caller);
  return status ? no_memory(err) : EM_OK;
}

static void tell(struct recorder *r, double now) {
  const struct em_recorder_progress progress = {
      .time = em_world_time(r->world),
      .from = r->session.from,
      .duration = r->scene->duration,
      .wall = now - r->begun,
      .collisions = em_world_collisions(r->world),
      .at_begin = r->at_begin,
  };
  if (r->options->progress) r->options->progress(r->options->self, &progress);
}

/* Works off the events up to `until`; looks at the clock in between. */
static enum em_status advance(struct recorder *r, double until, struct em_error *err) {
  for (;;) {
    const uint64_t before = em_world_collisions(r->world);
    const enum em_status status =
        em_world_run_collisions(r->world, until, CHUNK, r->options->stop, err);
    if (status) return status;
    if (r->writer && em_writer_has_failed(r->writer)) return flush(r, false, err);
    const double now = wall_clock();
    const bool arrived = em_world_collisions(r->world) - before < CHUNK;
    tell(r, now);
    if (r->writer && is_flush_due(r, now)) {
      const enum em_status flushed = flush(r, false, err);
      if (flushed) return flushed;
    }
    if (arrived) r->reached = until;
    if (r->options->stop && *r->options->stop) /* the world may have had no event to notice it */
      return em_error_set(err, EM_STOPPED, NULL, 0, "stopped on request");
    if (arrived) return EM_OK;
  }
}

/* All samples whose time has come. */
static enum em_status take_samples(struct recorder *r, double time, struct em_error *err) {
  const struct em_recording *record = &r->scene->record;
  enum em_status status = EM_OK;
  if (time_of(r->frames, record->frames) <= time) status = frame(r, time, err);
  if (!status && time_of(r->samples, record->observables) <= time) status = sample(r, time, err);
  if (!status && time_of(r->blocks + 1, record->histograms) <= time)
    status = block(r, time, false, err);
  return status;
}

bool em_recorder_is_within(double time, double duration) {
  return time <= duration * (1.0 + SAME_TIME);
}

/* The duration, or a sampling time that only rounding has put beyond it: 21 / 2.8 is not 7.5. */
static double end_of(const struct recorder *r) {
  const struct em_recording *record = &r->scene->record;
  const double times[] = {time_of(r->frames, record->frames),
                          time_of(r->samples, record->observables),
                          time_of(r->blocks + 1, record->histograms)};
  double end = r->scene->duration;
  for (size_t k = 0; k < sizeof times / sizeof *times; k++)
    if (em_recorder_is_within(times[k], r->scene->duration)) end = fmax(end, times[k]);
  return end;
}

static double next_time(const struct recorder *r) {
  const struct em_recording *record = &r->scene->record;
  double next = fmin(end_of(r), time_of(r->frames, record->frames));
  next = fmin(next, time_of(r->samples, record->observables));
  return fmin(next, time_of(r->blocks + 1, record->histograms));
}

static enum em_status run(struct recorder *r, struct em_error *err) {
  double time = 0.0;
  enum em_status status = EM_OK;
  do {
    time = next_time(r);
    status = advance(r, time, err);
    if (!status) status = take_samples(r, time, err);
  } while (!status && time < end_of(r) && !r->enough);
  return status;
}

/* Why it ended; failures of the file itself cannot be stored in it. What ended the run counts more
 * than that its end is not in the file. */
static enum em_status conclude(struct recorder *r, enum em_status status, struct em_error *err) {
  r->state.end = status == EM_OK         ? EM_END_DONE
                 : status == EM_STOPPED  ? EM_END_INTERRUPTED
                 : status == EM_COLLAPSE ? EM_END_COLLAPSE
                 : status == EM_JAM      ? EM_END_JAM
                                         : EM_END_FAILED;
  if (status == EM_FILE) return status;
  if (r->state.end == EM_END_DONE)
    em_summary_warn(&r->part, r->scene, r->state.message, sizeof r->state.message);
  if (r->state.end > EM_END_INTERRUPTED && err)
    snprintf(r->state.message, sizeof r->state.message, "%.1000s", err->text);
  struct em_error inner = {0};
  const enum em_status stored = flush(r, true, &inner);
  if (!stored) return status;
  if (r->state.end > EM_END_INTERRUPTED)
    return em_error_add(err, status, NULL, 0, "nor is the end in the run file:\n%s", inner.text);
  if (err) *err = inner;
  return stored;
}

/* ---------------------------------------------------------------- starting */

static enum em_status make_room(struct recorder *r, struct em_error *err) {
  const size_t balls = em_scene_ball_count(r->scene), blades = em_scene_blade_count(r->scene);
  r->balls = em_start_new(balls);
  r->speeds = calloc(balls + 1, sizeof *r->speeds);
  r->impulse = calloc(blades + 1, sizeof *r->impulse);
  r->block_base = calloc(COUNTS, sizeof *r->block_base);
  r->block = calloc(COUNTS, sizeof *r->block);
  if (r->options->target_count > 0 && !(r->precision = em_precision_new())) return no_memory(err);
  if (!r->balls || !r->speeds || !r->impulse || !r->block_base || !r->block ||
      !em_summary_begin(&r->part, r->scene->duration))
    return no_memory(err);
  return EM_OK;
}

static void clear(struct recorder *r) {
  em_writer_free(r->writer);
  em_world_free(r->world);
  em_start_free(r->balls);
  em_summary_end(&r->part);
  em_precision_free(r->precision);
  em_scene_free(r->own);
  free(r->speeds);
  free(r->impulse);
  free(r->block_base);
  free(r->block);
}

static void remember_start(struct recorder *r) {
  struct em_observe_state state;
  look(r, &state, 0.0);
  const struct em_energy *e = &state.energy;
  r->state.kinetic_start = e->kinetic + e->spin;
  r->state.potential_start = e->potential;
  r->state.energy_start = r->state.kinetic_start + e->potential;
}

static enum em_status create_file(struct recorder *r, const struct em_balls *start,
                                  struct em_error *err) {
  struct em_snapshot *snapshot = NULL;
  enum em_status status = em_world_snapshot(r->world, &snapshot, err);
  if (!status) status = em_writer_begin(r->writer, r->scene, start, snapshot, err);
  em_world_snapshot_free(snapshot);
  return status;
}

static enum em_status start_new(struct recorder *r, struct em_error *err) {
  struct em_balls *start = NULL;
  enum em_status status = em_recorder_start_scene(&r->own, r->scene, err);
  if (r->own) r->scene = r->own;
  if (!status) status = em_recorder_start(&start, r->scene, r->options->stop, err);
  if (!status) status = em_world_new(&r->world, r->scene, start, err);
  if (!status) remember_start(r);
  em_provenance_begin(&r->session, r->options->command, 0.0);
  if (!status && r->writer) status = create_file(r, start, err);
  em_start_free(start);
  return status;
}

/* ---------------------------------------------------------------- all of it */

static void summarize(struct recorder *r, struct em_summary *summary) {
  struct em_observe_state now;
  r->state.time = time_now(r);
  look(r, &now, r->state.time);
  const double wall = wall_clock() - r->begun;
  em_summary_fill(summary, &r->part, r->scene, r->world, &r->state, &now);
  summary->begun = true;
  summary->resumed = r->resumed;
  summary->wall_time = wall;
  const uint64_t done = summary->collisions - r->at_begin;
  summary->collisions_per_second = wall > 0.0 ? (double)done / wall : NAN;
  summary->realtime_factor = wall > 0.0 ? (summary->simulated_time - r->session.from) / wall : NAN;
}

/* Is there anything to judge by at the end of each block? */
static enum em_status check_targets(const struct em_scene *scene,
                                    const struct em_recorder_options *options,
                                    struct em_error *err) {
  const double blocks = scene->record.histograms, samples = scene->record.observables;
  for (size_t k = 0; k < options->target_count; k++) {
    const enum em_precision_kind kind = options->target[k].kind;
    char name[64];
    em_precision_name(&options->target[k], name, sizeof name);
    if (!(blocks > 0.0))
      return em_error_set(err, EM_INPUT, scene->file, 0,
                          "record.histograms: 0; the precision of %s is judged from block to "
                          "block of it, expected a number above 0",
                          name);
    if ((kind == EM_PRECISION_SPEED || kind == EM_PRECISION_POWER) && !(samples >= blocks))
      return em_error_set(err, EM_INPUT, scene->file, 0,
                          "record.observables: %g; the precision of %s needs a sample in "
                          "each block of record.histograms, expected at least %g",
                          samples, name, blocks);
  }
  return EM_OK;
}

/* What is at the path is looked at when nobody else can change it any more. */
static enum em_status start(struct recorder *r, struct em_error *err) {
  const struct em_recorder_options *o = r->options;
  struct stat info;
  enum em_status status = check_targets(r->scene, o, err);
  if (!status && o->path) status = em_writer_new(&r->writer, o->path, err);
  if (status) return status;
  const bool exists = o->path && stat(o->path, &info) == 0;
  if (exists && !o->resume && !o->force)
    return em_error_set(err, EM_INPUT, o->path, 0,
                        "exists already: resume it, or force its replacement");
  status = make_room(r, err);
  if (status) return status;
  return exists && o->resume ? em_recorder_resume(r, err) : start_new(r, err);
}

enum em_status em_recorder_run(const struct em_scene *scene,
                               const struct em_recorder_options *options,
                               struct em_summary *summary, bool *created, struct em_error *err) {
  struct recorder r = {.scene = scene, .options = options};
  if (summary) *summary = (struct em_summary){.begun = false};
  enum em_status status = start(&r, err);
  if (!status) status = begin_observing(&r, err);
  if (!status) {
    r.begun = wall_clock();
    r.at_begin = em_world_collisions(r.world);
    r.state.end = EM_END_RUNNING;
    r.state.message[0] = '\0';
    if (!r.finished && !r.enough) {
      status = flush(&r, false, err);
      if (!status) status = run(&r, err);
      status = conclude(&r, status, err);
    } else {
      r.state.end = EM_END_DONE;
    }
    em_recorder_is_enough(&r);
    if (summary) summarize(&r, summary);
  }
  if (created) *created = r.resumed || (r.writer && em_writer_is_published(r.writer));
  clear(&r);
  return status;
}

void em_recorder_default_path(const struct em_scene *scene, char *path, size_t size) {
  const char *name = strrchr(scene->file, '/');
  name = name ? name + 1 : scene->file;
  size_t length = strlen(name);
  if (length > 4 && strcmp(name + length - 4, ".cfg") == 0) length -= 4;
  if (length == 0)
    snprintf(path, size, "run.h5");
  else
    snprintf(path, size, "%.*s.h5", (int)length, name);
}
