/* Reads the collision table of a run file, block by block. */
#include <stdio.h>
#include <stdlib.h>

#include "record/layout.h"
#include "record/run_file_inside.h"
#include "record/table.h"

struct em_rows *em_run_file_rows_new(unsigned columns) {
  struct em_rows *rows = calloc(1, sizeof *rows);
  if (!rows) return NULL;
  for (size_t i = 0; i < em_table_column_count; i++) {
    const struct em_table_column *column = &em_table_columns[i];
    if (!(columns & column->bit)) continue;
    void *array = calloc(EM_ROWS_BLOCK, column->size);
    if (!array) {
      em_run_file_rows_free(rows);
      return NULL;
    }
    *em_table_array(column, rows) = array;
  }
  return rows;
}

void em_run_file_rows_free(struct em_rows *rows) {
  if (!rows) return;
  for (size_t i = 0; i < em_table_column_count; i++)
    free(*em_table_array(&em_table_columns[i], rows));
  free(rows);
}

static void path_of(const struct em_table_column *column, char *path, size_t size) {
  snprintf(path, size, EM_LAYOUT_TABLE "/%s", column->name);
}

bool em_run_file_rows_find(struct em_run_file *file) {
  file->has_rows = file->scene->record.collisions;
  for (size_t i = 0; i < em_table_column_count && file->has_rows; i++) {
    const struct em_table_column *column = &em_table_columns[i];
    struct em_h5_shape shape;
    char path[128];
    path_of(column, path, sizeof path);
    if (!em_h5_shape(file->file, path, &shape) || shape.rank != (column->width > 1 ? 2 : 1) ||
        (column->width > 1 && shape.dims[1] != column->width))
      return false;
    if (i == 0) file->rows = shape.dims[0];
    if (shape.dims[0] != file->rows) return false;
  }
  return true;
}

bool em_run_file_has_rows(const struct em_run_file *file) {
  return file->has_rows;
}

uint64_t em_run_file_row_count(const struct em_run_file *file) {
  return file->rows;
}

/* Readers use them as indices. */
static bool indices_are_valid(const struct em_run_file *file, const struct em_rows *rows) {
  bool good = true;
  for (size_t i = 0; i < rows->count && rows->cls; i++)
    good = good && rows->cls[i] < EM_CLASS_COUNT;
  for (size_t i = 0; i < rows->count && rows->ball; i++)
    good = good && rows->ball[i] < file->balls;
  for (size_t i = 0; i < rows->count && rows->cls && rows->partner; i++)
    good = good && (rows->cls[i] != EM_CLASS_BALL || rows->partner[i] < file->balls);
  return good;
}

enum em_status em_run_file_rows(const struct em_run_file *file, uint64_t first,
                                struct em_rows *rows, struct em_error *err) {
  const uint64_t left = first < file->rows ? file->rows - first : 0;
  rows->count = left < EM_ROWS_BLOCK ? (size_t)left : EM_ROWS_BLOCK;
  for (size_t i = 0; i < em_table_column_count && rows->count; i++) {
    const struct em_table_column *column = &em_table_columns[i];
    void *array = *em_table_array(column, rows);
    char path[128];
    if (!array) continue;
    path_of(column, path, sizeof path);
    if (!em_h5_read_rows(file->file, path, em_table_memory_type(column), first, rows->count, array))
      return em_run_file_damaged(file, "collision table", err);
  }
  return indices_are_valid(file, rows) ? EM_OK : em_run_file_damaged(file, "collision table", err);
}
