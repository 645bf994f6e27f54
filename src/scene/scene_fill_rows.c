/* Reads a species' table of positions, velocities and spins, from the scene or from a text file. */
#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "scene/scene_fill.h"

static const char expected_row[] =
    "6 or 9 numbers (x, y, z, vx, vy, vz, and wx, wy, wz if it spins)";

/* Rows as they come, before their number is known. */
struct rows {
  double (*row)[9];
  size_t count, room;
};

static bool add_row(struct em_scene_report *report, struct rows *rows, const double *x) {
  if (rows->count == rows->room) {
    size_t room = 2 * rows->room + 64;
    double(*grown)[9] = realloc(rows->row, room * sizeof *grown);
    if (!grown) {
      em_scene_report_memory(report);
      return false;
    }
    rows->row = grown;
    rows->room = room;
  }
  memcpy(rows->row[rows->count++], x, sizeof *rows->row);
  return true;
}

static bool tree_row(struct em_scene_report *report, const config_setting_t *setting,
                     struct rows *rows) {
  double x[9] = {0};
  int n = config_setting_is_list(setting) ? config_setting_length(setting) : 0;
  if (n != 6 && n != 9) {
    em_scene_fill_mismatch(report, setting, expected_row);
    return true;
  }
  for (int k = 0; k < n; ++k)
    if (!em_scene_fill_number(report, config_setting_get_elem(setting, (unsigned)k), "a number",
                              &x[k]))
      return true;
  return add_row(report, rows, x);
}

static bool is_gap(char c) {
  return c == ',' || isspace((unsigned char)c);
}

/* Numbers of one line of a file; -1 when something else stands there. */
static int line_numbers(const char *line, double *x) {
  int n = 0;
  for (;;) {
    while (is_gap(*line))
      ++line;
    if (*line == '\0' || *line == '#') return n;
    char *end;
    double value = strtod(line, &end);
    if (end == line || n == 9 || !isfinite(value) || !(is_gap(*end) || !*end || *end == '#'))
      return -1;
    x[n++] = value;
    line = end;
  }
}

/* The names of columns: they begin with a letter, and no number (as nan) stands there. */
static bool is_heading(const char *line) {
  const char *first = line + strspn(line, "\" \t");
  char *end;
  strtod(first, &end);
  return isalpha((unsigned char)*first) && end == first;
}

static bool file_row(struct em_scene_report *report, const char *path, int number, const char *line,
                     struct rows *rows) {
  double x[9] = {0};
  int n = line_numbers(line, x);
  if (n == 0) return true;
  /* The first line of a CSV file may hold the names of its columns. */
  if (n == -1 && number == 1 && is_heading(line)) return true;
  if (n != 6 && n != 9) {
    em_scene_report_line(report, path, number,
                         "table: expected %s, with commas or blanks between them", expected_row);
    return true;
  }
  return add_row(report, rows, x);
}

static void read_file(struct em_scene_report *report, const config_setting_t *setting,
                      struct rows *rows) {
  char *path = em_scene_source_beside(report->source->name, config_setting_get_string(setting));
  char *text = NULL;
  struct em_error inner = {0};
  if (!path)
    em_scene_report_memory(report);
  else if (em_scene_source_load(&text, path, &inner) != EM_OK)
    em_scene_report_at(report, setting, "expected a readable file: %.300s", inner.text);
  const size_t before = report->errors;
  int number = 0;
  char *rest = text;
  for (char *line; rest && (line = strsep(&rest, "\n")) != NULL;)
    if (!file_row(report, path, ++number, line, rows)) break;
  if (text && rows->count == 0 && report->errors == before)
    em_scene_report_line(report, path, 1, "table: no rows, expected %s in each", expected_row);
  free(text);
  free(path);
}

static struct em_vec *column(const struct rows *rows, int first) {
  struct em_vec *v = calloc(rows->count > 0 ? rows->count : 1, sizeof *v);
  for (size_t k = 0; v && k < rows->count; ++k) {
    const double *x = rows->row[k] + first;
    v[k] = em_vec_make(x[0], x[1], x[2]);
  }
  return v;
}

static bool turns(const struct rows *rows) {
  for (size_t k = 0; k < rows->count; ++k)
    if (rows->row[k][6] != 0.0 || rows->row[k][7] != 0.0 || rows->row[k][8] != 0.0) return true;
  return false;
}

void em_scene_fill_rows(struct em_scene_report *report, const config_setting_t *setting,
                        struct em_species *species) {
  struct rows rows = {0};
  if (config_setting_type(setting) == CONFIG_TYPE_STRING)
    read_file(report, setting, &rows);
  else if (config_setting_is_list(setting)) {
    for (int k = 0; k < config_setting_length(setting); ++k)
      if (!tree_row(report, config_setting_get_elem(setting, (unsigned)k), &rows)) break;
  } else
    em_scene_fill_mismatch(report, setting, "a list of rows or the name of a file");
  species->count = rows.count;
  species->position = column(&rows, 0);
  species->velocity = column(&rows, 3);
  bool spin = turns(&rows);
  species->spin = spin ? column(&rows, 6) : NULL;
  if (!species->position || !species->velocity || (spin && !species->spin))
    em_scene_report_memory(report);
  free(rows.row);
}
