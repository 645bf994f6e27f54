/* millpost table: the key figures of all runs of a sweep in one table. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "eventmill/interval.h"
#include "eventmill/provenance.h"
#include "record/output.h"
#include "tool/figures.h"
#include "tool/grid.h"
#include "tool/millpost.h"

/* Columns between those of the points and the figures. */
enum { FACTS = 6 };

static const char *const option_names[] = {"of", "from", "to", "above", "level", "tables", ""};

static const struct em_millpost_help help = {
    .name = "table",
    .arguments = "POINTS.csv",
    .summary = "Puts the key figures of all runs of a sweep into one table.",
    .details =
        "POINTS.csv has a line of keys and a line per run; its column 'run' names the run files,\n"
        "from its own folder. All its columns come first in the table, then each key figure and\n"
        "the half width of its confidence interval. Runs that are missing, not finished or over "
        "before\n"
        "--from are left out.\n"
        "counted_from and counted_to: of what is counted in collisions, in whole blocks of "
        "histograms\n"
        "where there is no collision table.\n"
        "--of runs: a row per run (default)\n"
        "--of points: a row per value of the column 'point'; repeated runs are averaged\n"
        "--of provenance: version, machine and computing time of each run",
    .examples = "  millpost table sweeps/map/points.csv --csv > map.csv\n"
                "  millpost table sweeps/map/points.csv --of points --from 0.2 -o map.h5",
    .options = option_names,
    .least = 1,
    .most = 1,
};

/* What is known of the finished runs, row by row alike. */
struct tables {
  struct em_grid runs, points, provenance;
  size_t missing, brief;
  char folder[1024];
};

static enum em_status no_memory(struct em_error *err) {
  return em_error_set(err, EM_MEMORY, NULL, 0, "no memory for a table");
}

/* Columns that follow those of the points. */
static bool add_columns(struct em_grid *runs, double level) {
  bool good = em_grid_add(runs, "simulated_time", "s", false) &&
              em_grid_add(runs, "from", "s", false) && em_grid_add(runs, "to", "s", false) &&
              em_grid_add(runs, "counted_from", "s", false) &&
              em_grid_add(runs, "counted_to", "s", false) &&
              em_grid_add(runs, "total_collisions", "", false);
  for (int k = 0; k < EM_FIGURES_COUNT && good; k++) {
    char key[96];
    const char *unit = em_figures_unit((enum em_figures_kind)k);
    em_report_half_key(key, sizeof key, em_figures_key((enum em_figures_kind)k), level);
    good = em_grid_add(runs, em_figures_key((enum em_figures_kind)k), unit, false) &&
           em_grid_add(runs, key, unit, false);
  }
  return good;
}

static bool add_provenance(struct em_grid *grid, size_t rows) {
  grid->rows = rows;
  return em_grid_add(grid, "run", "", true) && em_grid_add(grid, "version", "", true) &&
         em_grid_add(grid, "compiler", "", true) && em_grid_add(grid, "libraries", "", true) &&
         em_grid_add(grid, "host", "", true) && em_grid_add(grid, "started", "", true) &&
         em_grid_add(grid, "ended", "", true) && em_grid_add(grid, "sessions", "", false) &&
         em_grid_add(grid, "wall_time", "s", false) && em_grid_add(grid, "cpu_time", "s", false);
}

/* Commas would part a field of CSV. */
static bool put_plain(struct em_grid_column *column, size_t row, char *text) {
  for (char *c = text; *c; c++)
    if (*c == ',') *c = ';';
  return em_grid_put(column, row, text);
}

static enum em_status fill_provenance(struct em_grid *grid, size_t row, const char *name,
                                      const struct em_run_file *run, struct em_error *err) {
  struct em_grid_column *c = grid->column;
  const size_t sessions = em_run_file_session_count(run);
  double wall = 0.0, cpu = 0.0;
  bool good = em_grid_put(&c[0], row, name);
  for (size_t k = 0; k < sessions && good; k++) {
    struct em_run_session session;
    const enum em_status status = em_run_file_session(run, k, &session, err);
    if (status != EM_OK) return status;
    wall += session.wall_time;
    cpu += session.cpu_time;
    if (k == 0) good = put_plain(&c[5], row, session.started);
    good = good && put_plain(&c[1], row, session.version) &&
           put_plain(&c[2], row, session.compiler) && put_plain(&c[3], row, session.libraries) &&
           put_plain(&c[4], row, session.host) && put_plain(&c[6], row, session.ended);
  }
  c[7].number[row] = (double)sessions;
  c[8].number[row] = wall;
  c[9].number[row] = cpu;
  return good ? EM_OK : no_memory(err);
}

static enum em_status fill_figures(struct em_grid *runs, size_t row, size_t first,
                                   const struct em_run_file *run,
                                   const struct em_millpost_options *o, struct em_error *err) {
  struct em_figures figures;
  const double above = isnan(o->above) ? 3.0 : o->above;
  const enum em_status status =
      em_figures_read(&figures, run, o->from, o->to, above, o->level, err);
  if (status != EM_OK) return status;
  struct em_grid_column *c = runs->column + first;
  c[0].number[row] = em_run_file_state(run)->time;
  c[1].number[row] = figures.window.from;
  c[2].number[row] = figures.window.to;
  c[3].number[row] = figures.counted.from;
  c[4].number[row] = figures.counted.to;
  c[5].number[row] = (double)em_run_file_state(run)->collisions;
  for (int k = 0; k < EM_FIGURES_COUNT; k++) {
    c[FACTS + 2 * k].number[row] = figures.value[k].value;
    c[FACTS + 2 * k + 1].number[row] = figures.value[k].half;
  }
  return EM_OK;
}

/* One run; *kept tells whether it has a row. A file that is not there yet is no error, nor is one
 * that ends before the window. */
static enum em_status read_run(struct tables *t, size_t row, size_t first, const char *name,
                               const struct em_millpost_options *o, bool *kept,
                               struct em_error *err) {
  char path[2048];
  *kept = false;
  snprintf(path, sizeof path, "%s%s", name[0] == '/' ? "" : t->folder, name);
  struct em_run_file *run = NULL;
  enum em_status status = EM_OK;
  if (access(path, R_OK) == 0) status = em_millpost_open(&run, path, err);
  if (status != EM_OK) return status;
  const bool done = run && em_run_file_state(run)->end == EM_END_DONE;
  *kept = done && !(em_run_file_state(run)->time <= o->from);
  t->missing += !done;
  t->brief += done && !*kept;
  if (*kept) {
    status = fill_figures(&t->runs, row, first, run, o, err);
    if (status == EM_OK) status = fill_provenance(&t->provenance, row, name, run, err);
  }
  em_run_file_close(run);
  return status;
}

/* Leaves only the rows that are kept, in their order. */
static void keep_rows(struct em_grid *grid, const bool *keep) {
  size_t kept = 0;
  for (size_t r = 0; r < grid->rows; r++) {
    for (size_t c = 0; c < grid->columns; c++) {
      struct em_grid_column *column = &grid->column[c];
      if (column->number) {
        column->number[kept] = column->number[r];
        continue;
      }
      char *word = column->word[r];
      column->word[r] = NULL;
      if (keep[r])
        column->word[kept] = word;
      else
        free(word);
    }
    kept += keep[r];
  }
  grid->rows = kept;
}

/* Does each column have a name of its own, under which HDF5 can keep it? */
static enum em_status check_keys(const struct em_grid *runs, const struct em_millpost_options *o,
                                 struct em_error *err) {
  for (size_t c = 0; c < runs->columns; c++) {
    const char *key = runs->column[c].key;
    if (em_grid_find(runs, key) != (int)c)
      return em_error_set(err, EM_INPUT, o->run[0], 0,
                          "a column '%s', expected a key that no other column nor figure has", key);
    if (o->out && (strchr(key, '/') || !*key))
      return em_error_set(err, EM_INPUT, o->run[0], 0,
                          "a column '%s', expected keys without / for -o", key);
  }
  return EM_OK;
}

static enum em_status read_runs(struct tables *t, const struct em_millpost_options *o,
                                struct em_error *err) {
  enum em_status status = em_grid_read(&t->runs, o->run[0], err);
  if (status != EM_OK) return status;
  const int name = em_grid_find(&t->runs, "run");
  if (name < 0 || !t->runs.column[name].word)
    return em_error_set(err, EM_INPUT, o->run[0], 0, "no column 'run' with the names of run files");
  const size_t first = t->runs.columns;
  bool *keep = calloc(t->runs.rows + 1, sizeof *keep);
  if (!keep || !add_columns(&t->runs, o->level) || !add_provenance(&t->provenance, t->runs.rows))
    status = no_memory(err);
  if (status == EM_OK) status = check_keys(&t->runs, o, err);
  for (size_t r = 0; r < t->runs.rows && status == EM_OK; r++)
    status = read_run(t, r, first, t->runs.column[name].word[r], o, &keep[r], err);
  if (status == EM_OK) {
    keep_rows(&t->runs, keep);
    keep_rows(&t->provenance, keep);
  }
  free(keep);
  return status;
}

/* ---------------------------------------------------------------- points */

/* How a column of the runs goes into that of the points. */
enum pooling { FIRST, MEAN, HALF, SUM, LEFT_OUT };

static enum pooling pooling_of(const struct em_grid *runs, size_t c, size_t axes) {
  static const char *const out[] = {"repeat", "seed",         "run",       "from",
                                    "to",     "counted_from", "counted_to"};
  for (size_t k = 0; k < sizeof out / sizeof *out; k++)
    if (strcmp(runs->column[c].key, out[k]) == 0) return LEFT_OUT;
  if (c < axes) return FIRST;
  if (c < axes + FACTS) return SUM;
  return (c - axes) % 2 == 0 ? MEAN : HALF;
}

/* The mean of independent runs; half widths add like errors. */
static void pool(const double *value, const size_t *member, size_t n, enum pooling how,
                 double *out) {
  double sum = 0.0;
  for (size_t k = 0; k < n; k++) {
    const double x = value[member[k]];
    sum += how == HALF ? x * x : x;
  }
  *out = how == HALF ? sqrt(sum) / (double)n : how == MEAN ? sum / (double)n : sum;
}

static bool pool_column(struct em_grid *points, const struct em_grid *runs, size_t c,
                        const size_t *start, const size_t *member, enum pooling how) {
  const struct em_grid_column *from = &runs->column[c];
  struct em_grid_column *to = em_grid_add(points, from->key, from->unit, from->word != NULL);
  if (!to) return false;
  for (size_t p = 0; p < points->rows; p++) {
    const size_t *mine = member + start[p], n = start[p + 1] - start[p];
    if (from->word) {
      if (!em_grid_put(to, p, from->word[mine[0]])) return false;
    } else if (how == FIRST) {
      to->number[p] = from->number[mine[0]];
    } else {
      pool(from->number, mine, n, how, &to->number[p]);
    }
  }
  return true;
}

/* Sorts the runs by point: member[start[p]] … are the rows of the p-th one. */
static size_t sort_members(const double *point, size_t rows, size_t *start, size_t *member) {
  size_t points = 0, filled = 0;
  start[0] = 0;
  for (size_t r = 0; r < rows; r++) {
    bool seen = false;
    for (size_t k = 0; k < r && !seen; k++)
      seen = point[k] == point[r];
    if (seen) continue;
    for (size_t k = r; k < rows; k++)
      if (point[k] == point[r]) member[filled++] = k;
    start[++points] = filled;
  }
  return points;
}

static enum em_status pool_runs(struct tables *t, size_t axes, const struct em_millpost_options *o,
                                struct em_error *err) {
  const int at = em_grid_find(&t->runs, "point");
  if (at < 0 || !t->runs.column[at].number) {
    if (!o->of || strcmp(o->of, "points") != 0) return EM_OK;
    return em_error_set(err, EM_INPUT, o->run[0], 0, "no column 'point' of numbers");
  }
  size_t *start = calloc(t->runs.rows + 2, sizeof *start);
  size_t *member = calloc(t->runs.rows + 1, sizeof *member);
  bool good = start && member;
  if (good) {
    t->points.rows = sort_members(t->runs.column[at].number, t->runs.rows, start, member);
    for (size_t c = 0; c < t->runs.columns && good; c++) {
      const enum pooling how = pooling_of(&t->runs, c, axes);
      if (how != LEFT_OUT) good = pool_column(&t->points, &t->runs, c, start, member, how);
    }
  }
  struct em_grid_column *count = good ? em_grid_add(&t->points, "runs", "", false) : NULL;
  for (size_t p = 0; count && p < t->points.rows; p++)
    count->number[p] = (double)(start[p + 1] - start[p]);
  free(start);
  free(member);
  return count ? EM_OK : no_memory(err);
}

/* ---------------------------------------------------------------- output */

static enum em_status write_file(const struct tables *t, const struct em_millpost_options *o,
                                 struct em_error *err) {
  struct em_output output;
  enum em_status status = em_output_begin(&output, o->out, EM_OUTPUT_FILE, err);
  if (status != EM_OK) return status;
  em_h5_quiet();
  const hid_t file = H5Fcreate(output.temporary, H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
  bool good = file >= 0 && em_h5_put_text(file, "/", "creator", "millpost table") &&
              em_h5_put_text(file, "/", "creator_version", em_provenance_version()) &&
              em_h5_put_text(file, "/", "points", o->run[0]) &&
              em_h5_put_double(file, "/", "level", o->level) &&
              em_h5_put_double(file, "/", "threshold", isnan(o->above) ? 3.0 : o->above) &&
              em_grid_write(&t->runs, file, "/runs") &&
              em_grid_write(&t->points, file, "/points") &&
              em_grid_write(&t->provenance, file, "/provenance");
  if (file >= 0 && H5Fclose(file) < 0) good = false;
  if (!good) status = em_error_set(err, EM_FILE, o->out, 0, "cannot be written");
  return em_output_end(&output, status, err);
}

static int print(const struct tables *t, const struct em_grid *grid, const char *name,
                 const struct em_millpost_options *o) {
  struct em_report *report = em_report_new("table");
  if (grid != &t->provenance) {
    em_report_fact(report, "threshold", "threshold", isnan(o->above) ? 3.0 : o->above, "m/s");
    em_report_fact(report, "level", "level of the intervals", o->level, "");
  }
  em_grid_report(grid, report, name);
  if (t->missing > 0) em_report_note(report, "%zu runs are missing or not finished", t->missing);
  if (t->brief > 0) em_report_note(report, "%zu runs are over before %g s", t->brief, o->from);
  return em_millpost_print(report, o, EM_MILLPOST_DONE);
}

int em_millpost_table(int argc, char **argv) {
  struct em_millpost_options o;
  const int code = em_millpost_options(&o, &help, argc, argv);
  if (code >= 0) return code;
  const char *of = o.of ? o.of : "runs";
  struct tables t = {.missing = 0};
  const struct em_grid *const grids[] = {&t.runs, &t.points, &t.provenance};
  static const char *const names[] = {"runs", "points", "provenance"};
  int which = 0;
  while (which < 3 && strcmp(of, names[which]) != 0)
    which++;
  if (which == 3)
    return em_millpost_usage("table", "--of %s: expected runs, points or provenance", of);
  const size_t length = o.out ? strlen(o.out) : 0;
  if (o.out && (length <= 3 || strcmp(o.out + length - 3, ".h5") != 0))
    return em_millpost_usage("table", "-o %s: expected a name that ends in .h5", o.out);
  const char *slash = strrchr(o.run[0], '/');
  if (slash) snprintf(t.folder, sizeof t.folder, "%.*s/", (int)(slash - o.run[0]), o.run[0]);
  struct em_error err = {.code = EM_OK};
  enum em_status status = read_runs(&t, &o, &err);
  if (status == EM_OK)
    status = pool_runs(&t, t.runs.columns - (FACTS + 2 * EM_FIGURES_COUNT), &o, &err);
  if (status == EM_OK && o.out) status = write_file(&t, &o, &err);
  const int result =
      status == EM_OK ? print(&t, grids[which], names[which], &o) : em_millpost_fail(&err);
  em_grid_free(&t.runs);
  em_grid_free(&t.points);
  em_grid_free(&t.provenance);
  return result;
}
