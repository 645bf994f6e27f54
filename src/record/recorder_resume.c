/* Goes on with a stored run: its scene, its world, and what the recorder had gathered of it. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "num/locale.h"
#include "record/provenance.h"
#include "record/recorder_inside.h"

static enum em_status no_memory(struct em_error *err) {
  return em_error_set(err, EM_MEMORY, NULL, 0, "out of memory");
}

/* Balls that started from a run are in the checkpoint, and so are the blades that it turned: which
 * run that was, and the blades' angles, are taken as they are stored. */
static void take_origin(struct em_scene *scene, const struct em_scene *stored) {
  bool from_run = false;
  for (size_t s = 0; s < scene->species_count && s < stored->species_count; s++) {
    struct em_species *species = &scene->species[s];
    if (species->start != EM_START_RUN || stored->species[s].start != EM_START_RUN) continue;
    memcpy(species->from, stored->species[s].from, sizeof species->from);
    from_run = true;
  }
  for (size_t k = 0; from_run && k < scene->rotor_count && k < stored->rotor_count; k++) {
    struct em_rotor *to = &scene->rotor[k];
    const struct em_rotor *from = &stored->rotor[k];
    for (size_t b = 0; b < to->blade_count && b < from->blade_count; b++)
      to->blade[b].angle = from->blade[b].angle;
  }
}

/* The texts must be the same; if not, the first line in which they differ is told. */
static enum em_status compare_texts(const char *stored, const char *wanted, const char *path,
                                    struct em_error *err) {
  if (strcmp(stored, wanted) == 0) return EM_OK;
  const char *a = stored, *b = wanted;
  for (size_t k = 0; stored[k] == wanted[k]; k++)
    if (stored[k] == '\n') a = stored + k + 1, b = wanted + k + 1;
  a += strspn(a, " #");
  b += strspn(b, " #");
  return em_error_set(err, EM_INPUT, path, 0,
                      "was made from another scene; only the duration may change on resuming: "
                      "\"%.*s\" there, \"%.*s\" now",
                      (int)strcspn(a, "#\n"), a, (int)strcspn(b, "#\n"), b);
}

/* The stored scene with the new duration, which must read as the new scene does. It is the one that
 * goes on. */
static enum em_status take_scene(struct recorder *r, const struct em_run_file *file,
                                 struct em_error *err) {
  EM_LOCALE_PLAIN;
  char duration[64];
  snprintf(duration, sizeof duration, "duration=%.17g", r->scene->duration);
  const char *overrides[1] = {duration}, *name = r->scene->file;
  struct em_scene *wanted = NULL;
  char *a = NULL, *b = em_scene_text(r->scene);
  enum em_status status = b ? em_scene_parse(&wanted, b, name, 0, NULL, err) : no_memory(err);
  free(b);
  b = NULL;
  if (!status)
    status = em_scene_parse(&r->own, em_run_file_scene_text(file), name, 1, overrides, err);
  if (!status) {
    take_origin(wanted, r->own);
    a = em_scene_text(r->own);
    b = em_scene_text(wanted);
    status = a && b ? compare_texts(a, b, em_run_file_path(file), err) : no_memory(err);
  }
  em_scene_free(wanted);
  free(a);
  free(b);
  if (!status) r->scene = r->own;
  return status;
}

static enum em_status reload_samples(struct recorder *r, const struct em_run_file *file,
                                     struct em_error *err) {
  struct em_series *median = NULL, *work = NULL, *impulse = NULL, *drum = NULL, *resting = NULL;
  if (!(r->scene->record.observables > 0.0)) return EM_OK;
  enum em_status status = em_run_file_series(file, "median_speed", &median, err);
  if (!status && em_run_file_has(file, "blade_work"))
    status = em_run_file_series(file, "blade_work", &work, err);
  if (!status && em_run_file_has(file, "blade_angular_impulse"))
    status = em_run_file_series(file, "blade_angular_impulse", &impulse, err);
  if (!status && em_run_file_has(file, "drum_work"))
    status = em_run_file_series(file, "drum_work", &drum, err);
  if (!status && em_run_file_has(file, "resting_share"))
    status = em_run_file_series(file, "resting_share", &resting, err);
  for (size_t i = 0; !status && i < median->count; i++) {
    double sum = drum && i < drum->count ? drum->value[i] : 0.0;
    for (size_t k = 0; work && i < work->count && k < work->width; k++)
      sum += work->value[i * work->width + k];
    const double rest = resting && i < resting->count ? resting->value[i] : 0.0;
    if (!em_summary_sample(&r->part, median->time[i], median->value[i], sum, rest))
      status = no_memory(err);
  }
  if (!status && median->count) {
    r->samples = median->count;
    r->sample_before = median->time[median->count - 1];
    for (size_t k = 0;
         impulse && impulse->count && k < em_scene_blade_count(r->scene) && k < impulse->width; k++)
      r->impulse[k] = impulse->value[(impulse->count - 1) * impulse->width + k];
  }
  em_run_file_series_free(median);
  em_run_file_series_free(work);
  em_run_file_series_free(impulse);
  em_run_file_series_free(drum);
  em_run_file_series_free(resting);
  return status;
}

/* Complete blocks add up to the counts with which the next one begins. */
static enum em_status reload_blocks(struct recorder *r, const struct em_run_file *file,
                                    struct em_error *err) {
  if (em_run_file_bins(file) != EM_TALLY_BINS)
    return em_error_set(err, EM_FORMAT, em_run_file_path(file), 0, "has other histogram bins");
  enum em_status status = EM_OK;
  r->blocks = em_writer_blocks(r->writer);
  for (size_t k = 0; k < r->blocks && !status; k++) {
    status = em_run_file_block(file, k, r->block, err);
    for (size_t i = 0; i < COUNTS && !status; i++)
      r->block_base[i] += r->block[i];
    if (!status)
      em_summary_block(&r->part, em_run_file_block_start(file, k), em_run_file_block_end(file, k),
                       r->block);
    if (!status)
      status = em_recorder_add_precision(r, em_run_file_block_start(file, k),
                                         em_run_file_block_end(file, k), err);
  }
  return status;
}

static enum em_status reload_world(struct recorder *r, const struct em_run_file *file,
                                   struct em_error *err) {
  struct em_snapshot *snapshot = NULL;
  const double said = r->state.time;
  enum em_status status = em_run_file_checkpoint(file, &snapshot, err);
  if (!status) status = em_world_resume(&r->world, r->scene, snapshot, err);
  em_world_snapshot_free(snapshot);
  if (!status && !(fabs(em_world_time(r->world) - said) <= 1e-14 * said))
    return em_error_set(err, EM_FORMAT, em_run_file_path(file), 0,
                        "its checkpoint is not of %.9g s, as expected", said);
  return status;
}

static enum em_status go_on(struct recorder *r, const struct em_run_file *file,
                            struct em_error *err) {
  r->state = *em_run_file_state(file);
  enum em_status status = take_scene(r, file, err);
  if (status) return status;
  if (!em_recorder_is_within(r->state.time, r->scene->duration))
    return em_error_set(err, EM_INPUT, em_run_file_path(file), 0,
                        "has gone to %g s already, beyond the duration of %g s", r->state.time,
                        r->scene->duration);
  r->finished = r->state.end == EM_END_DONE && r->scene->duration <= r->state.time;
  status = reload_world(r, file, err);
  if (!status) status = em_writer_resume(r->writer, r->scene, err);
  if (!status) status = reload_samples(r, file, err);
  if (!status) status = reload_blocks(r, file, err);
  if (status) return status;
  if (r->state.end == EM_END_DONE) r->enough = em_recorder_is_enough(r);
  r->frames = em_writer_frames(r->writer);
  r->samples = em_writer_samples(r->writer);
  r->reached = r->state.time;
  em_provenance_begin(&r->session, r->options->command, r->state.time);
  return EM_OK;
}

enum em_status em_recorder_resume(struct recorder *r, struct em_error *err) {
  struct em_run_file *file = NULL;
  enum em_status status = em_run_file_open(&file, r->options->path, err);
  r->resumed = true;
  if (!status) status = go_on(r, file, err);
  em_run_file_close(file);
  return status;
}
