/* Sums over the cells of a drum. */
#include "tool/field.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tool/gather.h"

#define NAME(code, name, symbol, unit)   name,
#define SYMBOL(code, name, symbol, unit) symbol,
#define UNIT(code, name, symbol, unit)   unit,
static const char *const names[] = {EM_FIELD_LIST(NAME)};
static const char *const symbols[] = {EM_FIELD_LIST(SYMBOL)};
static const char *const units[] = {EM_FIELD_LIST(UNIT)};

int em_field_find(const char *name) {
  for (int k = 0; k < EM_FIELD_COUNT_OF; k++)
    if (strcmp(name, names[k]) == 0) return k;
  return -1;
}

const char *em_field_name(enum em_field_of of) {
  return names[of];
}

const char *em_field_symbol(enum em_field_of of) {
  return symbols[of];
}

const char *em_field_unit(enum em_field_of of) {
  return units[of];
}

bool em_field_is_mean(enum em_field_of of) {
  return of == EM_FIELD_SPEED || of == EM_FIELD_VN;
}

void em_field_free(struct em_field *field) {
  if (!field) return;
  em_cells_free(field->cells);
  free(field->n);
  free(field->sum);
  free(field->square);
  free(field);
}

static void add(struct em_field *field, size_t group, struct em_vec place, double x) {
  const size_t k = em_cells_find(field->cells, place.x, place.y, place.z);
  if (k >= field->cells->count) {
    field->outside += 1.0;
    return;
  }
  field->n[group * field->cells->count + k] += 1.0;
  field->sum[group * field->cells->count + k] += x;
  field->square[k] += x * x;
  field->total += 1.0;
}

/* ---------------------------------------------------------------- frames */

static enum em_status from_frames(struct em_field *field, const struct em_run_file *run,
                                  const struct em_window *window, struct em_error *err) {
  size_t first = 0, end = em_run_file_frame_count(run);
  while (first < end && em_run_file_frame_time(run, first) < window->from)
    first++;
  while (end > first && em_run_file_frame_time(run, end - 1) > window->to)
    end--;
  if (first == end)
    return em_error_set(err, EM_INPUT, em_run_file_path(run), 0, "no frame between %g s and %g s",
                        window->from, window->to);
  const size_t frames = end - first;
  field->groups = frames < EM_FIELD_GROUPS ? frames : EM_FIELD_GROUPS;
  struct em_balls *balls = NULL;
  enum em_status status = em_run_file_balls(run, &balls, err);
  double rim = 0.0, all = 0.0;
  for (size_t f = 0; status == EM_OK && f < frames; f++) {
    const size_t group = f * field->groups / frames;
    status = em_run_file_frame(run, first + f, balls, err);
    field->weight[group] += 1.0;
    for (size_t i = 0; status == EM_OK && i < balls->count; i++) {
      const struct em_vec r = balls->position[i];
      const double reach = field->cells->radius - balls->radius[i];
      add(field, group, r, field->of == EM_FIELD_SPEED ? em_vec_norm(balls->velocity[i]) : 1.0);
      rim += hypot(r.x, r.z) > reach * 0.96;
      all += 1.0;
    }
  }
  field->rim = rim / all;
  em_start_free(balls);
  return status;
}

/* ---------------------------------------------------------------- collision table */

static double of_row(enum em_field_of of, const struct em_rows *rows, size_t k,
                     const struct em_balls *balls) {
  if (of == EM_FIELD_HITS) return 1.0;
  if (of == EM_FIELD_VN) return (double)rows->vn[k];
  return of == EM_FIELD_LOST ? em_gather_row_lost(rows, k, balls)
                             : em_gather_row_energy(rows, k, balls);
}

static void add_rows(struct em_field *field, const struct em_rows *rows, unsigned classes,
                     const struct em_balls *balls, const struct em_window *window) {
  for (size_t k = 0; k < rows->count; k++) {
    const double t = rows->time[k];
    if (!em_window_has(window, t) || !(classes & 1U << rows->cls[k])) continue;
    size_t group = (size_t)((t - window->from) / field->group_time);
    if (group >= field->groups) group = field->groups - 1;
    const double x = of_row(field->of, rows, k, balls);
    const struct em_vec place = {(double)rows->place[k][0], (double)rows->place[k][1],
                                 (double)rows->place[k][2]};
    if (isfinite(x)) add(field, group, place, x);
  }
}

static enum em_status from_rows(struct em_field *field, const struct em_run_file *run,
                                unsigned classes, const struct em_window *window,
                                struct em_error *err) {
  if (!em_run_file_has_rows(run))
    return em_error_set(err, EM_INPUT, em_run_file_path(run), 0,
                        "a map of %s needs the collision table: run with record.collisions=true",
                        em_field_name(field->of));
  unsigned columns = EM_COLUMN_TIME | EM_COLUMN_CLASS | EM_COLUMN_PLACE;
  if (field->of != EM_FIELD_HITS) columns |= EM_COLUMN_VN;
  if (field->of == EM_FIELD_ENERGY || field->of == EM_FIELD_LOST)
    columns |= EM_COLUMN_BALL | EM_COLUMN_PARTNER;
  if (field->of == EM_FIELD_LOST) columns |= EM_COLUMN_LOST;
  field->groups = EM_FIELD_GROUPS;
  field->group_time = (window->to - window->from) / EM_FIELD_GROUPS;
  for (size_t g = 0; g < field->groups; g++)
    field->weight[g] = field->group_time;
  struct em_rows *rows = em_run_file_rows_new(columns);
  struct em_balls *balls = NULL;
  enum em_status status = rows ? em_run_file_balls(run, &balls, err)
                               : em_error_set(err, EM_MEMORY, NULL, 0, "out of memory");
  for (uint64_t first = 0; status == EM_OK; first += rows->count) {
    status = em_run_file_rows(run, first, rows, err);
    if (status != EM_OK || rows->count == 0) break;
    add_rows(field, rows, classes, balls, window);
    if (rows->time[rows->count - 1] > window->to) break;
  }
  em_run_file_rows_free(rows);
  em_start_free(balls);
  return status;
}

enum em_status em_field_new(struct em_field **out, const struct em_run_file *run,
                            enum em_field_of of, unsigned classes, struct em_cells *cells,
                            const struct em_window *window, struct em_error *err) {
  *out = NULL;
  struct em_field *field = calloc(1, sizeof *field);
  if (!field) {
    em_cells_free(cells);
    return em_error_set(err, EM_MEMORY, NULL, 0, "out of memory");
  }
  field->of = of;
  field->cells = cells;
  field->rim = NAN;
  if (cells) {
    field->n = calloc(EM_FIELD_GROUPS * cells->count, sizeof *field->n);
    field->sum = calloc(EM_FIELD_GROUPS * cells->count, sizeof *field->sum);
    field->square = calloc(cells->count, sizeof *field->square);
  }
  if (classes == 0) classes = (1U << EM_CLASS_COUNT) - 1U;
  enum em_status status;
  if (!field->n || !field->sum || !field->square)
    status = em_error_set(err, EM_MEMORY, NULL, 0, "out of memory");
  else if (of == EM_FIELD_COUNT || of == EM_FIELD_SPEED)
    status = from_frames(field, run, window, err);
  else
    status = from_rows(field, run, classes, window, err);
  if (status == EM_OK)
    *out = field;
  else
    em_field_free(field);
  return status;
}

/* ---------------------------------------------------------------- values */

double em_field_values(const struct em_field *field, size_t cell) {
  double sum = 0.0;
  for (size_t g = 0; g < field->groups; g++)
    sum += field->n[g * field->cells->count + cell];
  return sum;
}

/* Scatter below this share of a value is rounding. */
static const double ROUNDING = 1e-14;

/* A ratio Σ a_g / Σ b_g over groups of time, with the error of a ratio of sums; groups without
 * values tell nothing, and what was never seen is known to no precision. */
static struct em_interval ratio(const double *a, const double *b, size_t groups, double level) {
  double sa = 0.0, sb = 0.0, scatter = 0.0, filled = 0.0;
  for (size_t g = 0; g < groups; g++) {
    sa += a[g];
    sb += b[g];
    filled += b[g] > 0.0;
  }
  struct em_interval out = {NAN, NAN, NAN, filled - 1.0, 1.0};
  if (!(sb > 0.0)) return out;
  out.value = sa / sb;
  if (filled < 2.0 || sa == 0.0) return out;
  for (size_t g = 0; g < groups; g++) {
    const double d = a[g] - out.value * b[g];
    if (fabs(d) > ROUNDING * a[g]) scatter += d * d;
  }
  out.error = sqrt(scatter * filled / (filled - 1.0)) / sb;
  out.half = em_interval_student(level, out.freedom) * out.error;
  return out;
}

/* The mapped value of `count` cells from `first` on, in the first `slices` slices together. */
static struct em_interval value_of(const struct em_field *field, size_t first, size_t count,
                                   size_t slices, double level) {
  const struct em_cells *cells = field->cells;
  const bool mean = em_field_is_mean(field->of);
  double a[EM_FIELD_GROUPS] = {0.0}, b[EM_FIELD_GROUPS] = {0.0};
  for (size_t s = 0; s < slices; s++)
    for (size_t j = 0; j < count; j++) {
      const size_t k = s * cells->per_slice + first + j;
      const double volume = 1e6 * em_cells_volume(cells, k); /* cm³ */
      for (size_t g = 0; g < field->groups; g++) {
        a[g] += field->sum[g * cells->count + k];
        b[g] += mean ? field->n[g * cells->count + k] : field->weight[g] * volume;
      }
    }
  return ratio(a, b, field->groups, level);
}

struct em_interval em_field_value(const struct em_field *field, size_t cell, double level) {
  return value_of(field, cell, 1, 1, level);
}

struct em_interval em_field_tube_value(const struct em_field *field, size_t tube, double level) {
  const struct em_cells *cells = field->cells;
  return value_of(field, cells->first[tube], cells->in_tube[tube], cells->slices, level);
}

double em_field_spread(const struct em_field *field, size_t cell) {
  if (!em_field_is_mean(field->of)) return NAN;
  const double n = em_field_values(field, cell);
  double sum = 0.0;
  for (size_t g = 0; g < field->groups; g++)
    sum += field->sum[g * field->cells->count + cell];
  if (n < 2.0 || !(sum > 0.0)) return NAN;
  const double mean = sum / n;
  return sqrt(fmax(0.0, field->square[cell] - n * mean * mean) / (n - 1.0)) / mean;
}
