/* Tables of numbers and words by column: read from CSV, written as a report or as HDF5. */
#ifndef EVENTMILL_GRID_H
#define EVENTMILL_GRID_H

#include <stdbool.h>
#include <stddef.h>

#include "eventmill/error.h"
#include "record/h5.h"
#include "tool/report.h"

/* A column holds numbers (word NULL) or words (number NULL). */
struct em_grid_column {
  char key[96], unit[16];
  double *number; /* NAN: unknown */
  char **word;
};

struct em_grid {
  size_t rows, columns;
  struct em_grid_column *column;
};

/* Reads comma-separated values: a line of keys, then rows of as many fields, without quotes; lines
 * that begin with # are passed over. A column whose fields all are numbers becomes one of numbers.
 * em_grid_free also after an error. Errors: EM_INPUT, EM_MEMORY. */
enum em_status em_grid_read(struct em_grid *grid, const char *path, struct em_error *err);
void em_grid_free(struct em_grid *grid);

/* Index of the column of that name, -1: none. */
int em_grid_find(const struct em_grid *grid, const char *key);

/* A new column, filled with NAN or with empty words. NULL: no memory. Earlier pointers to columns
 * become invalid. */
struct em_grid_column *em_grid_add(struct em_grid *grid, const char *key, const char *unit,
                                   bool words);
/* Replaces a word; false: no memory. */
bool em_grid_put(struct em_grid_column *column, size_t row, const char *word);

/* As the report's next table. */
void em_grid_report(const struct em_grid *grid, struct em_report *report, const char *name);
/* As a group of the file, one dataset per column, units as attributes. */
bool em_grid_write(const struct em_grid *grid, hid_t file, const char *group);

#endif
