/* A growing dataset that gathers rows in memory. */
#include "record/log.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { HELD_BYTES = 1 << 20, HELD_ROWS = 1024, CHUNK_BYTES = 1 << 16, CHUNK_ROWS = 512 };

/* Rows of `size` bytes that fit into `bytes`, from 1 to most. */
static size_t rows_in(size_t bytes, size_t size, size_t most) {
  const size_t fit = size ? bytes / size : most;
  return fit < 1 ? 1 : fit > most ? most : fit;
}

bool em_log_init(struct em_log *log, const char *path, enum em_log_type type, int rank,
                 const hsize_t *dims) {
  memset(log, 0, sizeof *log);
  snprintf(log->path, sizeof log->path, "%s", path);
  log->type = type;
  log->shape.rank = rank;
  log->width = 1;
  for (int i = 1; i < rank; i++) {
    log->shape.dims[i] = dims[i - 1];
    log->width *= (size_t)dims[i - 1];
  }
  log->room = rows_in(HELD_BYTES, log->width * sizeof *log->cells, HELD_ROWS);
  log->cells = calloc(log->room * log->width + 1, sizeof *log->cells);
  return log->cells;
}

void em_log_clear(struct em_log *log) {
  free(log->cells);
  memset(log, 0, sizeof *log);
}

static hid_t file_type(enum em_log_type type) {
  return type == EM_LOG_DOUBLE  ? H5T_IEEE_F64LE
         : type == EM_LOG_COUNT ? H5T_STD_U64LE
                                : H5T_STD_I64LE;
}

static hid_t memory_type(enum em_log_type type) {
  return type == EM_LOG_DOUBLE  ? H5T_NATIVE_DOUBLE
         : type == EM_LOG_COUNT ? H5T_NATIVE_UINT64
                                : H5T_NATIVE_INT64;
}

bool em_log_create(const struct em_log *log, hid_t file, int deflate, const char *unit) {
  const size_t chunk = rows_in(CHUNK_BYTES, log->width * sizeof *log->cells, CHUNK_ROWS);
  struct em_h5_shape shape = log->shape;
  shape.dims[0] = 0;
  return em_h5_create(file, log->path, file_type(log->type), shape, chunk, deflate, unit);
}

void *em_log_next(struct em_log *log) {
  return em_log_is_full(log) ? NULL : log->cells + log->width * log->held++;
}

bool em_log_is_full(const struct em_log *log) {
  return log->held == log->room;
}

bool em_log_write(struct em_log *log, hid_t file) {
  if (log->held == 0) return true;
  if (!em_h5_write_rows(file, log->path, memory_type(log->type), log->rows, log->held, log->cells))
    return false;
  log->rows += log->held;
  log->held = 0;
  return true;
}
