/* A growing dataset of eight-byte numbers that gathers rows in memory and writes many at once. */
#ifndef EVENTMILL_LOG_H
#define EVENTMILL_LOG_H

#include "record/h5.h"

enum em_log_type { EM_LOG_DOUBLE, EM_LOG_COUNT, EM_LOG_STEP };

struct em_log {
  char path[128];
  enum em_log_type type;
  struct em_h5_shape shape; /* of the dataset; dims[0] is not used */
  size_t width;             /* numbers per row */
  hsize_t rows;             /* in the file */
  size_t held, room;        /* rows in memory */
  uint64_t *cells;          /* owned */
};

/* rank: of the dataset; dims: its further dimensions. false: no memory. */
bool em_log_init(struct em_log *log, const char *path, enum em_log_type type, int rank,
                 const hsize_t *dims);
void em_log_clear(struct em_log *log);

/* Makes the dataset. */
bool em_log_create(const struct em_log *log, hid_t file, int deflate, const char *unit);

/* Room for the next row, to be filled by the caller; NULL: full, write first. */
void *em_log_next(struct em_log *log);
bool em_log_is_full(const struct em_log *log);
bool em_log_write(struct em_log *log, hid_t file);

#endif
