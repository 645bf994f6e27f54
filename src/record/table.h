/* The collision table: contacts are gathered in blocks and written by a second thread, in order. */
#ifndef EVENTMILL_TABLE_H
#define EVENTMILL_TABLE_H

#include "eventmill/run_file.h"
#include "eventmill/world.h"
#include "record/h5.h"

struct em_table;

/* Makes the datasets of the table; indices are as short as `balls` allows. */
bool em_table_create(hid_t file, size_t balls, int deflate);

/* A table whose datasets hold `rows` rows already. NULL: no memory, or no thread. */
struct em_table *em_table_new(uint64_t rows);
void em_table_free(struct em_table *table);

/* The file to write to. While rows may be added, the caller uses HDF5 under the lock alone. */
void em_table_open(struct em_table *table, hid_t file);
void em_table_lock(struct em_table *table);
void em_table_unlock(struct em_table *table);

void em_table_add(struct em_table *table, const struct em_contact *contact);

/* Waits until all rows are in the datasets. false: HDF5 failed, now or before. */
bool em_table_flush(struct em_table *table);
bool em_table_has_failed(struct em_table *table);
uint64_t em_table_rows(const struct em_table *table);

/* The columns, for reader and writer alike. */
struct em_table_column {
  const char *name, *unit;
  unsigned bit;  /* enum em_column */
  size_t member; /* offset of the array in struct em_rows */
  size_t size;   /* bytes per row in memory */
  size_t width;  /* numbers per row */
};
extern const struct em_table_column em_table_columns[];
extern const size_t em_table_column_count;

/* HDF5's type of a column in memory. */
hid_t em_table_memory_type(const struct em_table_column *column);
/* The array of a column. */
void **em_table_array(const struct em_table_column *column, struct em_rows *rows);

#endif
