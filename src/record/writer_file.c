/* The datasets of a run file: made for a new one, found in an old one. */
#include "record/writer_file.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "record/checkpoint.h"
#include "record/layout.h"
#include "record/provenance.h"

/* ---------------------------------------------------------------- logs */

static bool frame_logs(struct em_writer *w) {
  const hsize_t dims[2] = {em_scene_ball_count(w->scene), 3};
  const char *home = EM_LAYOUT_BALLS;
  char path[128];
#define INIT(log, ending, type, rank) \
  (snprintf(path, sizeof path, "%s/%s", home, ending), em_log_init(log, path, type, rank, dims))
  return INIT(&w->frame_step, "position/step", EM_LOG_STEP, 1) &&
         INIT(&w->frame_time, "position/time", EM_LOG_DOUBLE, 1) &&
         INIT(&w->position, "position/value", EM_LOG_DOUBLE, 3) &&
         INIT(&w->velocity, "velocity/value", EM_LOG_DOUBLE, 3) &&
         (!w->has_spin || INIT(&w->spin, "angular_velocity/value", EM_LOG_DOUBLE, 3));
#undef INIT
}

/* The first observable owns step and time; the others share them. */
static bool sample_logs(struct em_writer *w) {
  char path[128];
  bool good = true;
  snprintf(path, sizeof path, EM_LAYOUT_OBSERVABLES "/%s/step", em_observe_list[0].name);
  good = em_log_init(&w->sample_step, path, EM_LOG_STEP, 1, NULL);
  snprintf(path, sizeof path, EM_LAYOUT_OBSERVABLES "/%s/time", em_observe_list[0].name);
  good = good && em_log_init(&w->sample_time, path, EM_LOG_DOUBLE, 1, NULL);
  for (size_t i = 0; i < em_observe_count && good; i++) {
    const struct em_observable *o = &em_observe_list[i];
    const hsize_t width = o->width(w->scene);
    w->has_observable[i] = width > 0;
    if (!width) continue;
    snprintf(path, sizeof path, EM_LAYOUT_OBSERVABLES "/%s/value", o->name);
    good = em_log_init(&w->observable[i], path, o->is_count ? EM_LOG_COUNT : EM_LOG_DOUBLE,
                       o->is_vector ? 2 : 1, &width);
  }
  return good;
}

bool em_writer_file_logs(struct em_writer *w) {
  w->has_spin = (em_scene_effects(w->scene) & EM_EFFECT_SPIN) != 0;
  return em_observe_count <= EM_WRITER_OBSERVABLES && frame_logs(w) && sample_logs(w);
}

void em_writer_file_free_logs(struct em_writer *w) {
  em_log_clear(&w->frame_step);
  em_log_clear(&w->frame_time);
  em_log_clear(&w->position);
  em_log_clear(&w->velocity);
  em_log_clear(&w->spin);
  em_log_clear(&w->sample_step);
  em_log_clear(&w->sample_time);
  for (size_t i = 0; i < EM_WRITER_OBSERVABLES; i++)
    em_log_clear(&w->observable[i]);
}

/* ---------------------------------------------------------------- a new file */

static bool put_version(hid_t file, const char *path) {
  const int32_t version[2] = {1, 1};
  return em_h5_put_numbers(file, path, "version", H5T_STD_I32LE, H5T_NATIVE_INT32, 2, version);
}

static bool create_h5md(hid_t file) {
  char author[256] = "";
  if (getlogin_r(author, sizeof author) != 0 || !author[0])
    snprintf(author, sizeof author, "unknown");
  return em_h5_group(file, EM_LAYOUT_H5MD) && put_version(file, EM_LAYOUT_H5MD) &&
         em_h5_group(file, EM_LAYOUT_H5MD "/author") &&
         em_h5_put_text(file, EM_LAYOUT_H5MD "/author", "name", author) &&
         em_h5_group(file, EM_LAYOUT_H5MD "/creator") &&
         em_h5_put_text(file, EM_LAYOUT_H5MD "/creator", "name", "eventmill") &&
         em_h5_put_text(file, EM_LAYOUT_H5MD "/creator", "version", em_provenance_version()) &&
         em_h5_group(file, EM_LAYOUT_H5MD "/modules") &&
         em_h5_group(file, EM_LAYOUT_H5MD "/modules/units") &&
         put_version(file, EM_LAYOUT_H5MD "/modules/units") &&
         em_h5_put_text(file, EM_LAYOUT_H5MD "/modules/units", "system", "SI");
}

static bool create_fixed(hid_t file, const char *path, hid_t file_type, hid_t memory_type,
                         size_t count, const char *unit, const void *data) {
  const struct em_h5_shape shape = {1, {count}};
  return em_h5_create(file, path, file_type, shape, 0, 0, unit) &&
         em_h5_write(file, path, memory_type, data);
}

/* The box of the chamber. Walls that are not periodic bound nothing in H5MD: there `edges` tells
 * the extent alone, and `offset` where it begins. */
static bool create_box(hid_t file, const struct em_scene *scene) {
  const bool box = scene->chamber.shape == EM_SHAPE_BOX;
  const char *boundary[3];
  for (int i = 0; i < 3; i++)
    boundary[i] = box && scene->chamber.periodic[i] ? "periodic" : "none";
  struct em_vec low, high;
  em_scene_extent(scene, &low, &high);
  const struct em_vec edges = em_vec_sub(high, low);
  const int32_t dimension = 3;
  return em_h5_group(file, EM_LAYOUT_BOX) &&
         em_h5_put_numbers(file, EM_LAYOUT_BOX, "dimension", H5T_STD_I32LE, H5T_NATIVE_INT32, 0,
                           &dimension) &&
         em_h5_put_texts(file, EM_LAYOUT_BOX, "boundary", 3, boundary) &&
         create_fixed(file, EM_LAYOUT_BOX "/edges", H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, 3, "m",
                      &edges) &&
         create_fixed(file, EM_LAYOUT_BOX "/offset", H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, 3, "m",
                      &low);
}

/* A time-dependent element that shares step and time with another one. */
static bool create_element(hid_t file, const char *path, const struct em_log *step,
                           const struct em_log *time) {
  char to_step[160], to_time[160];
  snprintf(to_step, sizeof to_step, "%s/step", path);
  snprintf(to_time, sizeof to_time, "%s/time", path);
  return em_h5_group(file, path) && em_h5_link(file, step->path, to_step) &&
         em_h5_link(file, time->path, to_time);
}

static bool create_frames(const struct em_writer *w) {
  const int deflate = em_h5_level_of_reals(w->scene->record.compression);
  if (w->scene->record.frames <= 0.0) return true;
  return em_h5_group(w->file, EM_LAYOUT_BALLS "/position") &&
         em_log_create(&w->frame_step, w->file, 0, NULL) &&
         em_log_create(&w->frame_time, w->file, 0, "s") &&
         em_log_create(&w->position, w->file, deflate, "m") &&
         create_element(w->file, EM_LAYOUT_BALLS "/velocity", &w->frame_step, &w->frame_time) &&
         em_log_create(&w->velocity, w->file, deflate, "m s-1") &&
         (!w->has_spin || (create_element(w->file, EM_LAYOUT_BALLS "/angular_velocity",
                                          &w->frame_step, &w->frame_time) &&
                           em_log_create(&w->spin, w->file, deflate, "s-1")));
}

static bool create_balls(const struct em_writer *w, const struct em_balls *balls) {
  const hid_t file = w->file;
  return em_h5_group(file, EM_LAYOUT_BALLS) && create_box(file, w->scene) && create_frames(w) &&
         create_fixed(file, EM_LAYOUT_BALLS "/mass", H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE,
                      balls->count, "kg", balls->mass) &&
         create_fixed(file, EM_LAYOUT_BALLS "/radius", H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE,
                      balls->count, "m", balls->radius) &&
         create_fixed(file, EM_LAYOUT_BALLS "/species", H5T_STD_I32LE, H5T_NATIVE_UINT16,
                      balls->count, NULL, balls->species);
}

static bool create_observables(const struct em_writer *w) {
  if (w->scene->record.observables <= 0.0) return true;
  bool good = em_h5_group(w->file, EM_LAYOUT_OBSERVABLES);
  for (size_t i = 0; i < em_observe_count && good; i++) {
    const struct em_observable *o = &em_observe_list[i];
    char path[128];
    if (!w->has_observable[i]) continue;
    snprintf(path, sizeof path, EM_LAYOUT_OBSERVABLES "/%s", o->name);
    if (i == 0)
      good = em_h5_group(w->file, path) && em_log_create(&w->sample_step, w->file, 0, NULL) &&
             em_log_create(&w->sample_time, w->file, 0, "s");
    else
      good = create_element(w->file, path, &w->sample_step, &w->sample_time);
    good = good && em_log_create(&w->observable[i], w->file, 0, o->unit);
  }
  return good;
}

static bool put_classes(hid_t file, const char *path) {
  const char *names[EM_CLASS_COUNT];
  for (int c = 0; c < EM_CLASS_COUNT; c++)
    names[c] = em_contact_class_name((enum em_class)c);
  return em_h5_put_texts(file, path, "classes", EM_CLASS_COUNT, names);
}

static bool create_histogram(const struct em_writer *w) {
  double *edges = malloc((EM_TALLY_BINS + 1) * sizeof *edges);
  if (!edges) return false;
  for (size_t k = 0; k <= EM_TALLY_BINS; k++)
    edges[k] = em_world_bin_edge(k);
  const struct em_h5_shape times = {1, {0}}, counts = {3, {0, EM_CLASS_COUNT, EM_TALLY_BINS}};
  const int deflate = w->scene->record.compression > 0 ? w->scene->record.compression : 1;
  const char *home = EM_LAYOUT_HISTOGRAM;
  const bool good =
      em_h5_group(w->file, home) && put_classes(w->file, home) &&
      create_fixed(w->file, EM_LAYOUT_HISTOGRAM "/edges", H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE,
                   EM_TALLY_BINS + 1, "m s-1", edges) &&
      em_h5_create(w->file, EM_LAYOUT_HISTOGRAM "/start", H5T_IEEE_F64LE, times, 512, 0, "s") &&
      em_h5_create(w->file, EM_LAYOUT_HISTOGRAM "/end", H5T_IEEE_F64LE, times, 512, 0, "s") &&
      em_h5_create(w->file, EM_LAYOUT_HISTOGRAM "/counts", H5T_STD_U64LE, counts, 1, deflate, NULL);
  free(edges);
  return good;
}

static bool put_effects(hid_t file, const struct em_scene *scene) {
  const char *names[EM_EFFECT_COUNT];
  size_t count = 0;
  const unsigned effects = em_scene_effects(scene);
  for (int k = 0; k < EM_EFFECT_COUNT; k++)
    if (effects >> k & 1) names[count++] = em_scene_effect_name((enum em_effect_bit)k);
  return em_h5_put_texts(file, EM_LAYOUT_HOME, "effects", count, names);
}

/* The text is both ours and, under its H5MD name, a parameter. */
static bool put_scene(hid_t file, const struct em_scene *scene) {
  const char *parameter = EM_LAYOUT_PARAMETERS "/scene";
  char *text = em_scene_text(scene);
  if (!text) return false;
  bool good = em_h5_put_document(file, EM_LAYOUT_SCENE, text);
  if (good && em_h5_exists(file, parameter)) good = H5Ldelete(file, parameter, H5P_DEFAULT) >= 0;
  good = good && em_h5_link(file, EM_LAYOUT_SCENE, parameter);
  free(text);
  return good;
}

static bool create_home(const struct em_writer *w) {
  const hid_t file = w->file;
  return em_h5_group(file, EM_LAYOUT_HOME) && em_h5_group(file, EM_LAYOUT_PARAMETERS) &&
         em_h5_group(file, EM_LAYOUT_SESSIONS) &&
         em_h5_put_count(file, EM_LAYOUT_HOME, "layout", EM_LAYOUT_VERSION) &&
         put_effects(file, w->scene) && put_scene(file, w->scene) &&
         create_fixed(file, EM_LAYOUT_PARAMETERS "/seed", H5T_STD_U64LE, H5T_NATIVE_UINT64, 1, NULL,
                      &w->scene->seed);
}

bool em_writer_file_create(struct em_writer *w, const struct em_balls *balls,
                           const struct em_snapshot *snapshot) {
  return create_h5md(w->file) && create_home(w) && create_balls(w, balls) &&
         create_observables(w) && create_histogram(w) &&
         (!w->scene->record.collisions ||
          (em_table_create(w->file, balls->count, w->scene->record.compression) &&
           put_classes(w->file, EM_LAYOUT_TABLE))) &&
         em_checkpoint_create(w->file, snapshot);
}

/* ---------------------------------------------------------------- the state */

/* Lengths of the datasets at the checkpoint. */
#define EACH_LENGTH(X) X(frames) X(samples) X(blocks) X(rows)
struct lengths {
  uint64_t frames, samples, blocks, rows;
};

bool em_writer_file_state(struct em_writer *w, const struct em_run_state *state) {
  const hid_t file = w->file;
  const struct lengths lengths = {em_writer_frames(w), em_writer_samples(w), w->blocks, w->rows};
  bool good = em_h5_put_text(file, EM_LAYOUT_HOME, "end", em_run_file_end_name(state->end)) &&
              em_h5_put_text(file, EM_LAYOUT_HOME, "message", state->message) &&
              em_h5_put_double(file, EM_LAYOUT_HOME, "time", state->time) &&
              em_h5_put_count(file, EM_LAYOUT_HOME, "collisions", state->collisions) &&
              em_h5_put_double(file, EM_LAYOUT_HOME, "energy_start", state->energy_start) &&
              em_h5_put_double(file, EM_LAYOUT_HOME, "kinetic_start", state->kinetic_start) &&
              em_h5_put_double(file, EM_LAYOUT_HOME, "potential_start", state->potential_start);
#define PUT(member) \
  good = good && em_h5_put_count(file, EM_LAYOUT_CHECKPOINT, #member, lengths.member);
  EACH_LENGTH(PUT)
#undef PUT
  return good;
}

/* ---------------------------------------------------------------- an old file */

static bool read_lengths(hid_t file, struct lengths *lengths) {
  bool good = true;
#define GET(member)                                                                           \
  good = good && em_h5_get_numbers(file, EM_LAYOUT_CHECKPOINT, #member, H5T_NATIVE_UINT64, 0, \
                                   &lengths->member);
  EACH_LENGTH(GET)
#undef GET
  return good;
}

static bool has_rows(hid_t file, const char *path, uint64_t rows) {
  struct em_h5_shape shape;
  return em_h5_shape(file, path, &shape) && shape.rank >= 1 && shape.dims[0] == rows;
}

static bool find_log(hid_t file, struct em_log *log, uint64_t rows) {
  log->rows = rows;
  struct em_h5_shape shape;
  if (!em_h5_shape(file, log->path, &shape) || shape.rank != log->shape.rank ||
      shape.dims[0] != rows)
    return false;
  for (int i = 1; i < shape.rank; i++)
    if (shape.dims[i] != log->shape.dims[i]) return false;
  return true;
}

static bool find_logs(struct em_writer *w, const struct lengths *lengths) {
  const hid_t file = w->file;
  bool good = true;
  if (w->scene->record.frames > 0.0)
    good = find_log(file, &w->frame_step, lengths->frames) &&
           find_log(file, &w->frame_time, lengths->frames) &&
           find_log(file, &w->position, lengths->frames) &&
           find_log(file, &w->velocity, lengths->frames) &&
           (!w->has_spin || find_log(file, &w->spin, lengths->frames));
  if (w->scene->record.observables > 0.0) {
    good = good && find_log(file, &w->sample_step, lengths->samples) &&
           find_log(file, &w->sample_time, lengths->samples);
    for (size_t i = 0; i < em_observe_count && good; i++)
      good = !w->has_observable[i] || find_log(file, &w->observable[i], lengths->samples);
  }
  return good;
}

/* An open block at the end goes: it will be counted again. */
static bool cut_blocks(struct em_writer *w) {
  struct em_h5_shape shape;
  if (!em_h5_shape(w->file, EM_LAYOUT_HISTOGRAM "/counts", &shape) || shape.rank != 3 ||
      shape.dims[0] < w->blocks || shape.dims[0] > w->blocks + 1 ||
      shape.dims[1] != EM_CLASS_COUNT || shape.dims[2] != EM_TALLY_BINS)
    return false;
  return em_h5_set_rows(w->file, EM_LAYOUT_HISTOGRAM "/counts", w->blocks) &&
         em_h5_set_rows(w->file, EM_LAYOUT_HISTOGRAM "/start", w->blocks) &&
         em_h5_set_rows(w->file, EM_LAYOUT_HISTOGRAM "/end", w->blocks);
}

bool em_writer_file_resume(struct em_writer *w) {
  struct lengths lengths;
  if (!read_lengths(w->file, &lengths)) return false;
  w->blocks = lengths.blocks;
  w->rows = lengths.rows;
  w->session = em_provenance_count(w->file);
  bool good = find_logs(w, &lengths) && cut_blocks(w);
  for (size_t i = 0; i < em_table_column_count && good && w->scene->record.collisions; i++) {
    char path[128];
    snprintf(path, sizeof path, EM_LAYOUT_TABLE "/%s", em_table_columns[i].name);
    good = has_rows(w->file, path, lengths.rows);
  }
  return good && put_scene(w->file, w->scene);
}
