/* Tables of numbers and words by column. */
#include "tool/grid.h"

#include <assert.h>
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void em_grid_free(struct em_grid *grid) {
  for (size_t c = 0; c < grid->columns; c++) {
    if (grid->column[c].word)
      for (size_t r = 0; r < grid->rows; r++)
        free(grid->column[c].word[r]);
    free(grid->column[c].word);
    free(grid->column[c].number);
  }
  free(grid->column);
  *grid = (struct em_grid){0};
}

int em_grid_find(const struct em_grid *grid, const char *key) {
  for (size_t c = 0; c < grid->columns; c++)
    if (strcmp(grid->column[c].key, key) == 0) return (int)c;
  return -1;
}

bool em_grid_put(struct em_grid_column *column, size_t row, const char *word) {
  assert(column->word != NULL);
  free(column->word[row]);
  column->word[row] = strdup(word);
  return column->word[row] != NULL;
}

struct em_grid_column *em_grid_add(struct em_grid *grid, const char *key, const char *unit,
                                   bool words) {
  struct em_grid_column *more = realloc(grid->column, (grid->columns + 1) * sizeof *grid->column);
  if (!more) return NULL;
  grid->column = more;
  struct em_grid_column *column = &more[grid->columns];
  *column = (struct em_grid_column){0};
  snprintf(column->key, sizeof column->key, "%s", key);
  snprintf(column->unit, sizeof column->unit, "%s", unit);
  const size_t rows = grid->rows > 0 ? grid->rows : 1;
  if (words)
    column->word = calloc(rows, sizeof *column->word);
  else
    column->number = calloc(rows, sizeof *column->number);
  if (!column->word && !column->number) return NULL;
  grid->columns++;
  for (size_t r = 0; r < grid->rows; r++) {
    if (!words)
      column->number[r] = NAN;
    else if (!em_grid_put(column, r, ""))
      return NULL;
  }
  return column;
}

/* ---------------------------------------------------------------- reading */

static bool is_row(const char *line) {
  return line[0] != '#' && line[strspn(line, " \t\r\n")] != '\0';
}

static void trim(char *line) {
  line[strcspn(line, "\r\n")] = '\0';
}

static enum em_status read_keys(struct em_grid *grid, char *line, const char *path,
                                struct em_error *err) {
  trim(line);
  for (char *key; (key = strsep(&line, ",")) != NULL;)
    if (!em_grid_add(grid, key, "", true))
      return em_error_set(err, EM_MEMORY, path, 0, "no memory for a table");
  return EM_OK;
}

static enum em_status read_row(struct em_grid *grid, size_t row, char *line, const char *path,
                               int number, struct em_error *err) {
  trim(line);
  size_t c = 0;
  for (char *field; (field = strsep(&line, ",")) != NULL; c++)
    if (c < grid->columns && !em_grid_put(&grid->column[c], row, field))
      return em_error_set(err, EM_MEMORY, path, 0, "no memory for a table");
  if (c == grid->columns) return EM_OK;
  return em_error_set(err, EM_INPUT, path, number, "%zu fields, expected %zu", c, grid->columns);
}

static bool is_number(const char *word) {
  char *end;
  const double x = strtod(word, &end);
  return end != word && *end == '\0' && isfinite(x);
}

/* Words that all are numbers become numbers. */
static enum em_status settle(struct em_grid_column *column, size_t rows, struct em_error *err) {
  for (size_t r = 0; r < rows; r++)
    if (!is_number(column->word[r])) return EM_OK;
  column->number = calloc(rows > 0 ? rows : 1, sizeof *column->number);
  if (!column->number) return em_error_set(err, EM_MEMORY, NULL, 0, "no memory for a table");
  for (size_t r = 0; r < rows; r++) {
    column->number[r] = strtod(column->word[r], NULL);
    free(column->word[r]);
  }
  free(column->word);
  column->word = NULL;
  return EM_OK;
}

/* To the begin, behind UTF-8's mark, as some editors put it. */
static void to_begin(FILE *in) {
  char mark[3];
  rewind(in);
  if (fread(mark, 1, 3, in) != 3 || memcmp(mark, "\xEF\xBB\xBF", 3) != 0) rewind(in);
}

static size_t count_rows(FILE *in) {
  char *line = NULL;
  size_t size = 0, rows = 0;
  to_begin(in);
  while (getline(&line, &size, in) >= 0)
    rows += is_row(line);
  free(line);
  to_begin(in);
  return rows > 0 ? rows - 1 : 0;
}

enum em_status em_grid_read(struct em_grid *grid, const char *path, struct em_error *err) {
  *grid = (struct em_grid){0};
  FILE *in = fopen(path, "r");
  if (!in) return em_error_set(err, EM_INPUT, path, 0, "cannot be read: %s", strerror(errno));
  grid->rows = count_rows(in);
  char *line = NULL;
  size_t size = 0, row = 0;
  enum em_status status = EM_OK;
  for (int k = 1; status == EM_OK && getline(&line, &size, in) >= 0; k++) {
    if (!is_row(line)) continue;
    if (grid->columns == 0)
      status = read_keys(grid, line, path, err);
    else
      status = read_row(grid, row++, line, path, k, err);
  }
  if (status == EM_OK && ferror(in))
    status = em_error_set(err, EM_INPUT, path, 0, "cannot be read: %s", strerror(errno));
  free(line);
  fclose(in);
  if (status == EM_OK && grid->columns == 0)
    status = em_error_set(err, EM_INPUT, path, 0, "is empty, expected a line of keys");
  for (size_t c = 0; c < grid->columns && status == EM_OK; c++)
    status = settle(&grid->column[c], grid->rows, err);
  return status;
}

/* ---------------------------------------------------------------- writing */

/* Are all numbers of a column whole, so that each stands for itself to the last digit? */
static bool is_whole(const struct em_grid_column *column, size_t rows) {
  for (size_t r = 0; r < rows; r++) {
    const double x = column->number[r];
    if (!(x >= 0.0 && x <= 0x1p53 && x == floor(x))) return false;
  }
  return true;
}

void em_grid_report(const struct em_grid *grid, struct em_report *report, const char *name) {
  em_report_begin(report, name, NULL);
  for (size_t c = 0; c < grid->columns; c++)
    em_report_column(report, grid->column[c].key, grid->column[c].key, grid->column[c].unit);
  for (size_t r = 0; r < grid->rows; r++) {
    for (size_t c = 0; c < grid->columns; c++) {
      const struct em_grid_column *column = &grid->column[c];
      if (column->word)
        em_report_text(report, "%s", column->word[r]);
      else if (is_whole(column, grid->rows))
        em_report_count(report, (uint64_t)column->number[r]);
      else
        em_report_number(report, column->number[r]);
    }
  }
}

static bool write_words(const struct em_grid_column *column, size_t rows, hid_t file,
                        const char *path) {
  size_t width = 1;
  for (size_t r = 0; r < rows; r++) {
    const size_t length = strlen(column->word[r]);
    if (length > width) width = length;
  }
  char *all = calloc(rows, width);
  if (!all) return false;
  for (size_t r = 0; r < rows; r++)
    memcpy(all + r * width, column->word[r], strlen(column->word[r]));
  const struct em_h5_shape shape = {1, {rows}};
  const hid_t type = H5Tcopy(H5T_C_S1);
  bool good = H5Tset_size(type, width) >= 0 && H5Tset_strpad(type, H5T_STR_NULLPAD) >= 0 &&
              H5Tset_cset(type, H5T_CSET_UTF8) >= 0;
  good = good && em_h5_create(file, path, type, shape, 0, 0, NULL) &&
         em_h5_write(file, path, type, all);
  H5Tclose(type);
  free(all);
  return good;
}

bool em_grid_write(const struct em_grid *grid, hid_t file, const char *group) {
  if (!em_h5_group(file, group)) return false;
  if (grid->rows == 0) return true;
  const struct em_h5_shape shape = {1, {grid->rows}};
  for (size_t c = 0; c < grid->columns; c++) {
    const struct em_grid_column *column = &grid->column[c];
    char path[160];
    snprintf(path, sizeof path, "%s/%s", group, column->key);
    if (column->word) {
      if (!write_words(column, grid->rows, file, path)) return false;
      continue;
    }
    if (!em_h5_create(file, path, H5T_IEEE_F64LE, shape, 0, 0,
                      column->unit[0] ? column->unit : NULL) ||
        !em_h5_write(file, path, H5T_NATIVE_DOUBLE, column->number))
      return false;
  }
  return true;
}
