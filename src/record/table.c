/* The collision table: contacts are gathered in blocks and written by a second thread, in order. */
#include "record/table.h"

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>

#include "record/layout.h"

enum { CHUNK_ROWS = 32768 };

/* While one block is being filled, the other is being written. */
struct block {
  struct em_rows *rows;
  uint64_t first; /* row of the table with which it begins */
  size_t room;    /* rows that it takes: up to the next multiple of EM_ROWS_BLOCK */
};

struct em_table {
  struct block block[2];
  int filling;
  hid_t file;
  pthread_t thread;
  pthread_mutex_t mutex; /* guards what follows */
  pthread_cond_t changed;
  const struct block *pending; /* to be written, or being written */
  bool quit, failed;
  pthread_mutex_t hdf5; /* held by whoever uses HDF5 */
};

#define COLUMN(name, unit, bit, member, width)                     \
  {                                                                \
    name, unit, EM_COLUMN_##bit, offsetof(struct em_rows, member), \
        sizeof *((struct em_rows *)0)->member, width               \
  }

const struct em_table_column em_table_columns[] = {
    COLUMN("time", "s", TIME, time, 1),       COLUMN("class", NULL, CLASS, cls, 1),
    COLUMN("ball", NULL, BALL, ball, 1),      COLUMN("partner", NULL, PARTNER, partner, 1),
    COLUMN("place", "m", PLACE, place, 3),    COLUMN("normal", NULL, NORMAL, normal, 3),
    COLUMN("vn", "m s-1", VN, vn, 1),         COLUMN("vt", "m s-1", VT, vt, 1),
    COLUMN("dissipated", "J", LOST, lost, 1),
};
const size_t em_table_column_count = sizeof em_table_columns / sizeof em_table_columns[0];

hid_t em_table_memory_type(const struct em_table_column *column) {
  switch (column->bit) {
  case EM_COLUMN_TIME:
    return H5T_NATIVE_DOUBLE;
  case EM_COLUMN_CLASS:
    return H5T_NATIVE_UINT8;
  case EM_COLUMN_BALL:
  case EM_COLUMN_PARTNER:
    return H5T_NATIVE_UINT32;
  default:
    return H5T_NATIVE_FLOAT;
  }
}

static hid_t file_type(const struct em_table_column *column, size_t balls) {
  switch (column->bit) {
  case EM_COLUMN_TIME:
    return H5T_IEEE_F64LE;
  case EM_COLUMN_CLASS:
    return H5T_STD_U8LE;
  case EM_COLUMN_BALL:
  case EM_COLUMN_PARTNER:
    return balls <= UINT16_MAX ? H5T_STD_U16LE : H5T_STD_U32LE;
  default:
    return H5T_IEEE_F32LE;
  }
}

void **em_table_array(const struct em_table_column *column, struct em_rows *rows) {
  return (void **)((char *)rows + column->member);
}

static void path_of(const struct em_table_column *column, char *path, size_t size) {
  snprintf(path, size, EM_LAYOUT_TABLE "/%s", column->name);
}

static int level_of(const struct em_table_column *column, int deflate) {
  const unsigned whole = EM_COLUMN_TIME | EM_COLUMN_CLASS | EM_COLUMN_BALL | EM_COLUMN_PARTNER;
  return column->bit & whole ? deflate : em_h5_level_of_reals(deflate);
}

bool em_table_create(hid_t file, size_t balls, int deflate) {
  bool good = em_h5_group(file, EM_LAYOUT_TABLE);
  for (size_t i = 0; i < em_table_column_count && good; i++) {
    const struct em_table_column *column = &em_table_columns[i];
    const struct em_h5_shape shape = {column->width > 1 ? 2 : 1, {0, column->width}};
    char path[128];
    path_of(column, path, sizeof path);
    good = em_h5_create(file, path, file_type(column, balls), shape, CHUNK_ROWS,
                        level_of(column, deflate), column->unit);
  }
  return good;
}

/* ---------------------------------------------------------------- the writing thread */

static bool write_block(struct em_table *table, const struct block *block) {
  bool good = true;
  for (size_t i = 0; i < em_table_column_count && good; i++) {
    const struct em_table_column *column = &em_table_columns[i];
    char path[128];
    path_of(column, path, sizeof path);
    pthread_mutex_lock(&table->hdf5);
    good = em_h5_write_rows(table->file, path, em_table_memory_type(column), block->first,
                            block->rows->count, *em_table_array(column, block->rows));
    pthread_mutex_unlock(&table->hdf5);
  }
  return good;
}

static void *work(void *self) {
  struct em_table *table = self;
  em_h5_quiet();
  pthread_mutex_lock(&table->mutex);
  for (;;) {
    while (!table->pending && !table->quit)
      pthread_cond_wait(&table->changed, &table->mutex);
    if (!table->pending) break;
    pthread_mutex_unlock(&table->mutex);
    const bool good = write_block(table, table->pending);
    pthread_mutex_lock(&table->mutex);
    table->failed = table->failed || !good;
    table->pending = NULL;
    pthread_cond_broadcast(&table->changed);
  }
  pthread_mutex_unlock(&table->mutex);
  return NULL;
}

/* Called with the mutex held. */
static void wait_idle(struct em_table *table) {
  while (table->pending)
    pthread_cond_wait(&table->changed, &table->mutex);
}

static void begin(struct block *block, uint64_t first) {
  block->first = first;
  block->room = (size_t)(EM_ROWS_BLOCK - first % EM_ROWS_BLOCK);
  block->rows->count = 0;
}

/* Gives the full block to the thread and goes on with the other. */
static void hand_over(struct em_table *table) {
  struct block *full = &table->block[table->filling];
  pthread_mutex_lock(&table->mutex);
  wait_idle(table);
  table->pending = full;
  pthread_cond_broadcast(&table->changed);
  pthread_mutex_unlock(&table->mutex);
  table->filling = 1 - table->filling;
  begin(&table->block[table->filling], full->first + full->rows->count);
}

/* ---------------------------------------------------------------- the table */

struct em_table *em_table_new(uint64_t rows) {
  struct em_table *table = calloc(1, sizeof *table);
  if (!table) return NULL;
  table->block[0].rows = em_run_file_rows_new(EM_COLUMN_ALL);
  table->block[1].rows = em_run_file_rows_new(EM_COLUMN_ALL);
  pthread_mutex_init(&table->mutex, NULL);
  pthread_mutex_init(&table->hdf5, NULL);
  pthread_cond_init(&table->changed, NULL);
  bool good = table->block[0].rows && table->block[1].rows;
  if (good) {
    begin(&table->block[0], rows);
    good = pthread_create(&table->thread, NULL, work, table) == 0;
  }
  if (good) return table;
  em_run_file_rows_free(table->block[0].rows);
  em_run_file_rows_free(table->block[1].rows);
  free(table);
  return NULL;
}

void em_table_free(struct em_table *table) {
  if (!table) return;
  pthread_mutex_lock(&table->mutex);
  table->quit = true;
  pthread_cond_broadcast(&table->changed);
  pthread_mutex_unlock(&table->mutex);
  pthread_join(table->thread, NULL);
  pthread_cond_destroy(&table->changed);
  pthread_mutex_destroy(&table->hdf5);
  pthread_mutex_destroy(&table->mutex);
  em_run_file_rows_free(table->block[0].rows);
  em_run_file_rows_free(table->block[1].rows);
  free(table);
}

void em_table_open(struct em_table *table, hid_t file) {
  table->file = file;
}

void em_table_lock(struct em_table *table) {
  pthread_mutex_lock(&table->hdf5);
}

void em_table_unlock(struct em_table *table) {
  pthread_mutex_unlock(&table->hdf5);
}

static void put(float to[3], struct em_vec from) {
  to[0] = (float)from.x;
  to[1] = (float)from.y;
  to[2] = (float)from.z;
}

void em_table_add(struct em_table *table, const struct em_contact *contact) {
  struct block *block = &table->block[table->filling];
  struct em_rows *rows = block->rows;
  const size_t i = rows->count++;
  rows->time[i] = contact->time;
  rows->cls[i] = (uint8_t)contact->cls;
  rows->ball[i] = contact->ball;
  rows->partner[i] = contact->partner;
  put(rows->place[i], contact->place);
  put(rows->normal[i], contact->normal);
  rows->vn[i] = (float)contact->vn;
  rows->vt[i] = (float)contact->vt;
  rows->lost[i] = (float)contact->lost;
  if (rows->count == block->room) hand_over(table);
}

/* The block that is being filled is written as far as it is; it will be written again when full, so
 * that each chunk is compressed once as a whole. */
bool em_table_flush(struct em_table *table) {
  pthread_mutex_lock(&table->mutex);
  wait_idle(table);
  const bool failed = table->failed;
  pthread_mutex_unlock(&table->mutex);
  const struct block *block = &table->block[table->filling];
  if (failed || block->rows->count == 0) return !failed;
  table->failed = !write_block(table, block);
  return !table->failed;
}

bool em_table_has_failed(struct em_table *table) {
  pthread_mutex_lock(&table->mutex);
  const bool failed = table->failed;
  pthread_mutex_unlock(&table->mutex);
  return failed;
}

uint64_t em_table_rows(const struct em_table *table) {
  const struct block *block = &table->block[table->filling];
  return block->first + block->rows->count;
}
