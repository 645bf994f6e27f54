/* Reads run files: opening, scene, state, frames, observables, histograms. */
#include "eventmill/run_file.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "eventmill/world.h"
#include "record/checkpoint.h"
#include "record/layout.h"
#include "record/observe.h"
#include "record/provenance.h"
#include "record/run_file_inside.h"

static const char *const end_name[EM_END_COUNT] = {
#define NAME(code, text) [EM_END_##code] = text,
    EM_END_LIST(NAME)
#undef NAME
};

const char *em_run_file_end_name(enum em_end end) {
  return (unsigned)end < EM_END_COUNT ? end_name[end] : "unknown";
}

enum em_status em_run_file_damaged(const struct em_run_file *file, const char *what,
                                   struct em_error *err) {
  return em_error_set(err, EM_FORMAT, file->path, 0, "%s: damaged or missing", what);
}

static enum em_status no_memory(const struct em_run_file *file, struct em_error *err) {
  return em_error_set(err, EM_MEMORY, file->path, 0, "out of memory");
}

/* ---------------------------------------------------------------- opening */

/* Tells apart what HDF5 calls by one name: no such file, no HDF5 file, a cut or damaged one. */
static enum em_status open_hdf5(struct em_run_file *file, struct em_error *err) {
  const int fd = open(file->path, O_RDONLY | O_CLOEXEC);
  if (fd < 0)
    return em_error_set(err, EM_FILE, file->path, 0, "cannot be read: %s", strerror(errno));
  unsigned char start[8];
  static const unsigned char signature[8] = {0x89, 'H', 'D', 'F', '\r', '\n', 0x1a, '\n'};
  const ssize_t n = pread(fd, start, sizeof start, 0);
  const int error = n < 0 ? errno : 0;
  close(fd);
  if (n < 0)
    return em_error_set(err, EM_FILE, file->path, 0, "cannot be read: %s", strerror(error));
  if (n != sizeof start || memcmp(start, signature, sizeof start) != 0)
    return em_error_set(err, EM_FORMAT, file->path, 0, "is not an HDF5 file");
  file->file = H5Fopen(file->path, H5F_ACC_RDONLY, H5P_DEFAULT);
  if (file->file < 0)
    return em_error_set(err, EM_FORMAT, file->path, 0,
                        "cannot be opened by HDF5: truncated, damaged or locked");
  return EM_OK;
}

static bool read_state(struct em_run_file *file) {
  const hid_t h = file->file;
  struct em_run_state *s = &file->state;
  const char *home = EM_LAYOUT_HOME;
  char end[32] = "";
  if (!em_h5_get_text(h, home, "end", end, sizeof end) ||
      !em_h5_get_text(h, home, "message", s->message, sizeof s->message) ||
      !em_h5_get_numbers(h, home, "time", H5T_NATIVE_DOUBLE, 0, &s->time) ||
      !em_h5_get_numbers(h, home, "collisions", H5T_NATIVE_UINT64, 0, &s->collisions) ||
      !em_h5_get_numbers(h, home, "energy_start", H5T_NATIVE_DOUBLE, 0, &s->energy_start) ||
      !em_h5_get_numbers(h, home, "kinetic_start", H5T_NATIVE_DOUBLE, 0, &s->kinetic_start) ||
      !em_h5_get_numbers(h, home, "potential_start", H5T_NATIVE_DOUBLE, 0, &s->potential_start))
    return false;
  for (int k = 0; k < EM_END_COUNT; k++)
    if (strcmp(end, end_name[k]) == 0) {
      s->end = (enum em_end)k;
      return true;
    }
  return false;
}

static enum em_status read_scene(struct em_run_file *file, struct em_error *err) {
  uint64_t layout = 0;
  if (!em_h5_get_numbers(file->file, EM_LAYOUT_HOME, "layout", H5T_NATIVE_UINT64, 0, &layout))
    return em_error_set(err, EM_FORMAT, file->path, 0, "is not a run file: it has no group %s",
                        EM_LAYOUT_HOME);
  if (layout != EM_LAYOUT_VERSION)
    return em_error_set(err, EM_FORMAT, file->path, 0,
                        "has layout %llu, this program reads layout %d", (unsigned long long)layout,
                        EM_LAYOUT_VERSION);
  file->text = em_h5_get_document(file->file, EM_LAYOUT_SCENE, EM_LAYOUT_TEXT_LIMIT);
  if (!file->text) return em_run_file_damaged(file, "scene", err);
  struct em_error inner = {0};
  if (em_scene_parse(&file->scene, file->text, file->path, 0, NULL, &inner) != EM_OK)
    return em_error_set(err, EM_FORMAT, file->path, 0, "its scene is not valid:\n%.3000s",
                        inner.text);
  return EM_OK;
}

/* A one-dimensional dataset of doubles, with its length. */
static bool read_times(const struct em_run_file *file, const char *path, size_t *count,
                       double **times) {
  struct em_h5_shape shape;
  if (!em_h5_shape(file->file, path, &shape) || shape.rank != 1) return false;
  *count = (size_t)shape.dims[0];
  *times = malloc((*count + 1) * sizeof **times);
  return *times && em_h5_read(file->file, path, H5T_NATIVE_DOUBLE, *times);
}

static bool are_rising(const double *times, size_t count) {
  for (size_t i = 1; i < count; i++)
    if (!(times[i] > times[i - 1])) return false;
  return count == 0 || (times[0] >= 0.0 && times[count - 1] < INFINITY);
}

static bool is_vectors(const struct em_run_file *file, const char *path) {
  struct em_h5_shape shape;
  return em_h5_shape(file->file, path, &shape) && shape.rank == 3 &&
         shape.dims[0] == file->frames && shape.dims[1] == file->balls && shape.dims[2] == 3;
}

static bool is_row(const struct em_run_file *file, const char *path, size_t count) {
  struct em_h5_shape shape;
  return em_h5_shape(file->file, path, &shape) && shape.rank == 1 && shape.dims[0] == count;
}

static bool find_frames(struct em_run_file *file) {
  file->balls = em_scene_ball_count(file->scene);
  file->has_spin = (em_scene_effects(file->scene) & EM_EFFECT_SPIN) != 0;
  if (!is_row(file, EM_LAYOUT_BALLS "/mass", file->balls) ||
      !is_row(file, EM_LAYOUT_BALLS "/radius", file->balls) ||
      !is_row(file, EM_LAYOUT_BALLS "/species", file->balls))
    return false;
  if (!(file->scene->record.frames > 0.0)) return true;
  return read_times(file, EM_LAYOUT_BALLS "/position/time", &file->frames, &file->frame_time) &&
         are_rising(file->frame_time, file->frames) &&
         is_vectors(file, EM_LAYOUT_BALLS "/position/value") &&
         is_vectors(file, EM_LAYOUT_BALLS "/velocity/value") &&
         (!file->has_spin || is_vectors(file, EM_LAYOUT_BALLS "/angular_velocity/value"));
}

/* All observables that the scene calls for, in one length: an unreadable one is not an absent one.
 */
static bool find_observables(const struct em_run_file *file) {
  uint64_t samples = 0;
  if (!(file->scene->record.observables > 0.0)) return true;
  if (!em_h5_get_numbers(file->file, EM_LAYOUT_CHECKPOINT, "samples", H5T_NATIVE_UINT64, 0,
                         &samples))
    return false;
  for (size_t i = 0; i < em_observe_count; i++) {
    const struct em_observable *o = &em_observe_list[i];
    const size_t width = o->width(file->scene);
    struct em_h5_shape shape;
    char path[256];
    snprintf(path, sizeof path, EM_LAYOUT_OBSERVABLES "/%s/value", o->name);
    if (width && (!em_h5_shape(file->file, path, &shape) || shape.dims[0] != samples ||
                  shape.rank != (o->is_vector ? 2 : 1) || (o->is_vector && shape.dims[1] != width)))
      return false;
  }
  return true;
}

static bool find_blocks(struct em_run_file *file) {
  struct em_h5_shape shape;
  size_t edges = 0, ends = 0;
  if (!read_times(file, EM_LAYOUT_HISTOGRAM "/edges", &edges, &file->edges) || edges < 2 ||
      !are_rising(file->edges, edges) ||
      !read_times(file, EM_LAYOUT_HISTOGRAM "/start", &file->blocks, &file->block_start) ||
      !read_times(file, EM_LAYOUT_HISTOGRAM "/end", &ends, &file->block_end))
    return false;
  file->bins = edges - 1;
  return ends == file->blocks && are_rising(file->block_start, ends) &&
         em_h5_shape(file->file, EM_LAYOUT_HISTOGRAM "/counts", &shape) && shape.rank == 3 &&
         shape.dims[0] == ends && shape.dims[1] == EM_CLASS_COUNT && shape.dims[2] == file->bins;
}

static enum em_status open_parts(struct em_run_file *file, struct em_error *err) {
  enum em_status status = open_hdf5(file, err);
  if (!status) status = read_scene(file, err);
  if (status) return status;
  if (!read_state(file)) return em_run_file_damaged(file, "state of the run", err);
  if (!find_frames(file)) return em_run_file_damaged(file, "frames", err);
  if (!find_observables(file)) return em_run_file_damaged(file, "observables", err);
  if (!find_blocks(file)) return em_run_file_damaged(file, "histograms", err);
  if (!em_run_file_rows_find(file)) return em_run_file_damaged(file, "collision table", err);
  return EM_OK;
}

enum em_status em_run_file_open(struct em_run_file **out, const char *path, struct em_error *err) {
  em_h5_quiet();
  struct em_run_file *file = calloc(1, sizeof *file);
  if (!file) return em_error_set(err, EM_MEMORY, path, 0, "out of memory");
  file->file = -1;
  file->path = strdup(path);
  const enum em_status status = file->path ? open_parts(file, err) : no_memory(file, err);
  if (status) {
    em_run_file_close(file);
    return status;
  }
  *out = file;
  return EM_OK;
}

void em_run_file_close(struct em_run_file *file) {
  if (!file) return;
  if (file->file >= 0) H5Fclose(file->file);
  em_scene_free(file->scene);
  free(file->text);
  free(file->frame_time);
  free(file->edges);
  free(file->block_start);
  free(file->block_end);
  free(file->path);
  free(file);
}

const char *em_run_file_path(const struct em_run_file *file) {
  return file->path;
}

const struct em_scene *em_run_file_scene(const struct em_run_file *file) {
  return file->scene;
}

const char *em_run_file_scene_text(const struct em_run_file *file) {
  return file->text;
}

const struct em_run_state *em_run_file_state(const struct em_run_file *file) {
  return &file->state;
}

size_t em_run_file_session_count(const struct em_run_file *file) {
  return em_provenance_count(file->file);
}

enum em_status em_run_file_session(const struct em_run_file *file, size_t k,
                                   struct em_run_session *session, struct em_error *err) {
  memset(session, 0, sizeof *session);
  return em_provenance_read(file->file, k, session) ? EM_OK
                                                    : em_run_file_damaged(file, "session", err);
}

/* ---------------------------------------------------------------- frames */

size_t em_run_file_ball_count(const struct em_run_file *file) {
  return file->balls;
}

size_t em_run_file_frame_count(const struct em_run_file *file) {
  return file->frames;
}

double em_run_file_frame_time(const struct em_run_file *file, size_t k) {
  return file->frame_time[k];
}

size_t em_run_file_frame_before(const struct em_run_file *file, double time) {
  size_t low = 0, high = file->frames;
  while (high - low > 1) {
    const size_t middle = low + (high - low) / 2;
    if (file->frame_time[middle] <= time)
      low = middle;
    else
      high = middle;
  }
  return low;
}

static bool read_balls(const struct em_run_file *file, struct em_balls *balls) {
  const hid_t h = file->file;
  return em_h5_read(h, EM_LAYOUT_BALLS "/mass", H5T_NATIVE_DOUBLE, balls->mass) &&
         em_h5_read(h, EM_LAYOUT_BALLS "/radius", H5T_NATIVE_DOUBLE, balls->radius) &&
         em_h5_read(h, EM_LAYOUT_BALLS "/species", H5T_NATIVE_UINT16, balls->species);
}

enum em_status em_run_file_balls(const struct em_run_file *file, struct em_balls **out,
                                 struct em_error *err) {
  struct em_balls *balls = em_start_new(file->balls);
  if (!balls) return no_memory(file, err);
  if (!read_balls(file, balls)) {
    em_start_free(balls);
    return em_run_file_damaged(file, "balls", err);
  }
  *out = balls;
  return EM_OK;
}

enum em_status em_run_file_frame(const struct em_run_file *file, size_t k, struct em_balls *balls,
                                 struct em_error *err) {
  if (k >= file->frames || balls->count != file->balls)
    return em_error_set(err, EM_INPUT, file->path, 0, "has no frame %zu of %zu balls", k,
                        balls->count);
  const hid_t h = file->file, type = H5T_NATIVE_DOUBLE;
  if (!em_h5_read_rows(h, EM_LAYOUT_BALLS "/position/value", type, k, 1, balls->position) ||
      !em_h5_read_rows(h, EM_LAYOUT_BALLS "/velocity/value", type, k, 1, balls->velocity))
    return em_run_file_damaged(file, "frame", err);
  if (!file->has_spin)
    memset(balls->spin, 0, balls->count * sizeof *balls->spin);
  else if (!em_h5_read_rows(h, EM_LAYOUT_BALLS "/angular_velocity/value", type, k, 1, balls->spin))
    return em_run_file_damaged(file, "frame", err);
  return EM_OK;
}

enum em_status em_run_file_last(const char *path, struct em_balls **out, struct em_error *err) {
  struct em_run_file *file = NULL;
  struct em_balls *balls = NULL;
  enum em_status status = em_run_file_open(&file, path, err);
  if (!status && file->frames == 0)
    status = em_error_set(err, EM_INPUT, path, 0, "has no frames to start from");
  if (!status) status = em_run_file_balls(file, &balls, err);
  if (!status) status = em_run_file_frame(file, file->frames - 1, balls, err);
  em_run_file_close(file);
  if (status)
    em_start_free(balls);
  else
    *out = balls;
  return status;
}

static void turn_blades(struct em_scene *scene, const struct em_scene *old, double time) {
  struct em_rotor *rotor = scene->rotor;
  size_t b = 0;
  for (size_t r = 0; r < old->rotor_count; r++)
    for (size_t k = 0; k < old->rotor[r].blade_count; k++, b++) {
      const struct em_blade *from = &old->rotor[r].blade[k];
      while (b == rotor->blade_count) {
        rotor++;
        b = 0;
      }
      rotor->blade[b].angle = fmod(from->angle + from->omega * time, 2.0 * M_PI);
    }
}

const char *em_run_file_origin(const struct em_scene *scene) {
  for (size_t s = 0; s < scene->species_count; s++)
    if (scene->species[s].start == EM_START_RUN) return scene->species[s].from;
  return NULL;
}

enum em_status em_run_file_turn(struct em_scene *scene, struct em_error *err) {
  const char *path = em_run_file_origin(scene);
  if (!path || em_scene_blade_count(scene) == 0) return EM_OK;
  struct em_run_file *file = NULL;
  const enum em_status status = em_run_file_open(&file, path, err);
  if (status) return status;
  const struct em_scene *old = em_run_file_scene(file);
  if (file->frames > 0 && em_scene_blade_count(old) == em_scene_blade_count(scene))
    turn_blades(scene, old, em_run_file_frame_time(file, file->frames - 1));
  em_run_file_close(file);
  return EM_OK;
}

/* ---------------------------------------------------------------- observables */

bool em_run_file_has(const struct em_run_file *file, const char *name) {
  char path[256];
  snprintf(path, sizeof path, EM_LAYOUT_OBSERVABLES "/%s/value", name);
  return em_h5_exists(file->file, path);
}

static bool read_series(const struct em_run_file *file, const char *name, struct em_series *s) {
  char path[256];
  struct em_h5_shape shape;
  snprintf(path, sizeof path, EM_LAYOUT_OBSERVABLES "/%s/time", name);
  if (!read_times(file, path, &s->count, &s->time) || !are_rising(s->time, s->count)) return false;
  snprintf(path, sizeof path, EM_LAYOUT_OBSERVABLES "/%s/value", name);
  if (!em_h5_shape(file->file, path, &shape) || shape.rank < 1 || shape.rank > 2 ||
      shape.dims[0] != s->count)
    return false;
  s->width = shape.rank == 2 ? (size_t)shape.dims[1] : 1;
  s->value = calloc(s->count * s->width + 1, sizeof *s->value);
  if (!em_h5_get_text(file->file, path, "unit", s->unit, sizeof s->unit)) s->unit[0] = '\0';
  return s->value && em_h5_read(file->file, path, H5T_NATIVE_DOUBLE, s->value);
}

enum em_status em_run_file_series(const struct em_run_file *file, const char *name,
                                  struct em_series **out, struct em_error *err) {
  if (!em_run_file_has(file, name))
    return em_error_set(err, EM_INPUT, file->path, 0, "has no observable \"%s\"", name);
  struct em_series *series = calloc(1, sizeof *series);
  if (!series) return no_memory(file, err);
  if (!read_series(file, name, series)) {
    em_run_file_series_free(series);
    return em_run_file_damaged(file, name, err);
  }
  *out = series;
  return EM_OK;
}

void em_run_file_series_free(struct em_series *series) {
  if (!series) return;
  free(series->time);
  free(series->value);
  free(series);
}

/* ---------------------------------------------------------------- histograms, checkpoint */

size_t em_run_file_bins(const struct em_run_file *file) {
  return file->bins;
}

const double *em_run_file_edges(const struct em_run_file *file) {
  return file->edges;
}

size_t em_run_file_block_count(const struct em_run_file *file) {
  return file->blocks;
}

double em_run_file_block_start(const struct em_run_file *file, size_t k) {
  return file->block_start[k];
}

double em_run_file_block_end(const struct em_run_file *file, size_t k) {
  return file->block_end[k];
}

enum em_status em_run_file_block(const struct em_run_file *file, size_t k, uint64_t *counts,
                                 struct em_error *err) {
  if (k >= file->blocks)
    return em_error_set(err, EM_INPUT, file->path, 0, "has no histogram block %zu", k);
  return em_h5_read_rows(file->file, EM_LAYOUT_HISTOGRAM "/counts", H5T_NATIVE_UINT64, k, 1, counts)
             ? EM_OK
             : em_run_file_damaged(file, "histogram", err);
}

enum em_status em_run_file_checkpoint(const struct em_run_file *file, struct em_snapshot **snapshot,
                                      struct em_error *err) {
  struct em_error inner = {0};
  *snapshot = em_checkpoint_read(file->file, file->path, file->balls,
                                 em_scene_blade_count(file->scene), file->has_spin, &inner);
  if (!*snapshot && err) *err = inner;
  return inner.code;
}
