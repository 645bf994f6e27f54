/* Writes a run file: opens it, takes in what is to be recorded, and flushes. */
#include "record/writer.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "record/checkpoint.h"
#include "record/layout.h"
#include "record/provenance.h"
#include "record/writer_file.h"

static enum em_status failed(const struct em_writer *writer, struct em_error *err) {
  const int error = em_twin_errno(writer->twin);
  return em_error_set(err, EM_FILE, writer->path, 0, "cannot be written: %s",
                      error ? strerror(error) : "HDF5 failed");
}

static enum em_status no_memory(const char *path, struct em_error *err) {
  return em_error_set(err, EM_MEMORY, path, 0, "out of memory");
}

/* ---------------------------------------------------------------- beginning and end */

enum em_status em_writer_new(struct em_writer **out, const char *path, struct em_error *err) {
  em_h5_quiet();
  struct em_writer *writer = calloc(1, sizeof *writer);
  if (!writer) return no_memory(path, err);
  writer->file = -1;
  writer->path = strdup(path);
  const enum em_status status =
      writer->path ? em_twin_new(&writer->twin, path, err) : no_memory(path, err);
  if (status) {
    em_writer_free(writer);
    return status;
  }
  *out = writer;
  return EM_OK;
}

static enum em_status begin(struct em_writer *writer, const struct em_scene *scene, bool resume,
                            struct em_error *err) {
  writer->scene = scene;
  if (!em_writer_file_logs(writer)) return no_memory(writer->path, err);
  return em_twin_begin(writer->twin, resume, err);
}

static hid_t open_file(const struct em_writer *writer, bool create) {
  const hid_t fapl = em_twin_access(writer->twin);
  if (fapl < 0) return -1;
  H5Pset_libver_bounds(fapl, H5F_LIBVER_V110, H5F_LIBVER_V110);
  H5Pset_fclose_degree(fapl, H5F_CLOSE_STRONG);
  const char *name = em_twin_name(writer->twin);
  const hid_t file = create ? H5Fcreate(name, H5F_ACC_TRUNC, H5P_DEFAULT, fapl)
                            : H5Fopen(name, H5F_ACC_RDWR, fapl);
  H5Pclose(fapl);
  return file;
}

static bool make_table(struct em_writer *writer, uint64_t rows) {
  if (!writer->scene->record.collisions) return true;
  writer->table = em_table_new(rows);
  if (writer->table) em_table_open(writer->table, writer->file);
  return writer->table;
}

enum em_status em_writer_begin(struct em_writer *writer, const struct em_scene *scene,
                               const struct em_balls *balls, const struct em_snapshot *snapshot,
                               struct em_error *err) {
  const enum em_status status = begin(writer, scene, false, err);
  if (status) return status;
  writer->file = open_file(writer, true);
  if (writer->file < 0 || !em_writer_file_create(writer, balls, snapshot) ||
      em_twin_errno(writer->twin))
    return failed(writer, err);
  return make_table(writer, 0) ? EM_OK : no_memory(writer->path, err);
}

enum em_status em_writer_resume(struct em_writer *writer, const struct em_scene *scene,
                                struct em_error *err) {
  const enum em_status status = begin(writer, scene, true, err);
  if (status) return status;
  writer->file = open_file(writer, false);
  char fault[256] = "/";
  if (writer->file < 0 || !em_h5_is_whole(writer->file, fault, sizeof fault))
    return em_error_set(err, EM_FORMAT, writer->path, 0, "%s: damaged", fault);
  if (!em_writer_file_resume(writer))
    return em_error_set(err, EM_FORMAT, writer->path, 0, "its datasets do not fit its checkpoint");
  if (em_twin_errno(writer->twin)) return failed(writer, err);
  return make_table(writer, writer->rows) ? EM_OK : no_memory(writer->path, err);
}

void em_writer_free(struct em_writer *writer) {
  if (!writer) return;
  em_table_free(writer->table);
  if (writer->file >= 0) H5Fclose(writer->file);
  em_twin_free(writer->twin);
  em_writer_file_free_logs(writer);
  free(writer->path);
  free(writer);
}

uint64_t em_writer_frames(const struct em_writer *writer) {
  return writer->frame_step.rows + writer->frame_step.held;
}

uint64_t em_writer_samples(const struct em_writer *writer) {
  return writer->sample_step.rows + writer->sample_step.held;
}

uint64_t em_writer_blocks(const struct em_writer *writer) {
  return writer->blocks;
}

bool em_writer_is_published(const struct em_writer *writer) {
  return writer->twin && em_twin_is_published(writer->twin);
}

/* ---------------------------------------------------------------- taking in */

static void lock(struct em_writer *writer) {
  if (writer->table) em_table_lock(writer->table);
}

static void unlock(struct em_writer *writer) {
  if (writer->table) em_table_unlock(writer->table);
}

static bool write_logs(struct em_writer *writer, struct em_log *const *logs, size_t count) {
  bool good = true;
  lock(writer);
  for (size_t i = 0; i < count && good; i++)
    good = em_log_write(logs[i], writer->file);
  unlock(writer);
  return good;
}

static size_t frame_logs(struct em_writer *writer, struct em_log **logs) {
  size_t count = 0;
  logs[count++] = &writer->frame_step;
  logs[count++] = &writer->frame_time;
  logs[count++] = &writer->position;
  logs[count++] = &writer->velocity;
  if (writer->has_spin) logs[count++] = &writer->spin;
  return count;
}

static size_t sample_logs(struct em_writer *writer, struct em_log **logs) {
  size_t count = 0;
  logs[count++] = &writer->sample_step;
  logs[count++] = &writer->sample_time;
  for (size_t i = 0; i < em_observe_count; i++)
    if (writer->has_observable[i]) logs[count++] = &writer->observable[i];
  return count;
}

/* All logs of a set are filled in step; room for a frame may be less than for its time. */
static bool make_room(struct em_writer *writer, struct em_log *const *logs, size_t count) {
  for (size_t i = 0; i < count; i++)
    if (em_log_is_full(logs[i])) return write_logs(writer, logs, count);
  return true;
}

static void put_vectors(struct em_log *log, const struct em_vec *vectors, size_t count) {
  memcpy(em_log_next(log), vectors, count * sizeof *vectors);
}

_Static_assert(sizeof(struct em_vec) == 3 * sizeof(double), "vectors are stored as rows of three");

enum em_status em_writer_frame(struct em_writer *writer, double time, const struct em_balls *balls,
                               struct em_error *err) {
  struct em_log *logs[EM_WRITER_FRAME_LOGS];
  if (!make_room(writer, logs, frame_logs(writer, logs))) return failed(writer, err);
  const int64_t step = (int64_t)em_writer_frames(writer);
  *(int64_t *)em_log_next(&writer->frame_step) = step;
  *(double *)em_log_next(&writer->frame_time) = time;
  put_vectors(&writer->position, balls->position, balls->count);
  put_vectors(&writer->velocity, balls->velocity, balls->count);
  if (writer->has_spin) put_vectors(&writer->spin, balls->spin, balls->count);
  return EM_OK;
}

enum em_status em_writer_sample(struct em_writer *writer, const struct em_observe_state *state,
                                struct em_error *err) {
  struct em_log *logs[EM_WRITER_SAMPLE_LOGS];
  if (!make_room(writer, logs, sample_logs(writer, logs))) return failed(writer, err);
  const int64_t step = (int64_t)em_writer_samples(writer);
  *(int64_t *)em_log_next(&writer->sample_step) = step;
  *(double *)em_log_next(&writer->sample_time) = state->time;
  for (size_t i = 0; i < em_observe_count; i++)
    if (writer->has_observable[i])
      em_observe_list[i].fill(state, em_log_next(&writer->observable[i]));
  return EM_OK;
}

enum em_status em_writer_block(struct em_writer *writer, double start, double end, bool open,
                               const uint64_t *counts, struct em_error *err) {
  lock(writer);
  const hid_t file = writer->file;
  const hsize_t k = writer->blocks;
  const bool good =
      em_h5_write_rows(file, EM_LAYOUT_HISTOGRAM "/start", H5T_NATIVE_DOUBLE, k, 1, &start) &&
      em_h5_write_rows(file, EM_LAYOUT_HISTOGRAM "/end", H5T_NATIVE_DOUBLE, k, 1, &end) &&
      em_h5_write_rows(file, EM_LAYOUT_HISTOGRAM "/counts", H5T_NATIVE_UINT64, k, 1, counts);
  unlock(writer);
  if (!good) return failed(writer, err);
  writer->blocks += !open;
  return EM_OK;
}

void em_writer_contact(struct em_writer *writer, const struct em_contact *contact) {
  if (writer->table) em_table_add(writer->table, contact);
}

bool em_writer_has_failed(struct em_writer *writer) {
  return em_twin_errno(writer->twin) || (writer->table && em_table_has_failed(writer->table));
}

/* ---------------------------------------------------------------- flushing */

/* The table first: after that its thread does not use HDF5, whatever fails. */
static bool write_held(struct em_writer *writer) {
  struct em_log *logs[EM_WRITER_SAMPLE_LOGS];
  return (!writer->table || em_table_flush(writer->table)) &&
         write_logs(writer, logs, frame_logs(writer, logs)) &&
         write_logs(writer, logs, sample_logs(writer, logs));
}

static bool reopen(struct em_writer *writer) {
  writer->file = open_file(writer, false);
  if (writer->table) em_table_open(writer->table, writer->file);
  return writer->file >= 0;
}

enum em_status em_writer_flush(struct em_writer *writer, const struct em_writer_flush *flush,
                               struct em_error *err) {
  bool good = write_held(writer);
  if (writer->table) writer->rows = em_table_rows(writer->table);
  good = good && em_writer_file_state(writer, &flush->state) &&
         em_provenance_write(writer->file, writer->session, &flush->session) &&
         em_checkpoint_write(writer->file, flush->snapshot);
  good = H5Fclose(writer->file) >= 0 && good;
  writer->file = -1;
  if (!good) return failed(writer, err);
  const enum em_status status = em_twin_publish(writer->twin, flush->last, err);
  if (status || flush->last) return status;
  return reopen(writer) ? EM_OK : failed(writer, err);
}
