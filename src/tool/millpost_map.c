/* millpost map: where balls are, how fast they are there, and where and how hard they hit. */
#include <gsl/gsl_sort.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "eventmill/plot.h"
#include "eventmill/sample.h"
#include "record/output.h"
#include "tool/field.h"
#include "tool/millpost.h"
#include "tool/window.h"

static const char *const option_names[] = {"cells",  "of",       "class",   "from",   "to",
                                           "slices", "tubes",    "sectors", "rings",  "minus",
                                           "spread", "relative", "level",   "output", ""};

static const struct em_millpost_help help = {
    .name = "map",
    .arguments = "RUN --cells sectors|rings --of WHAT",
    .summary = "Maps the drum: where balls are, how fast, and where and how hard they hit.",
    .details =
        "--of count: balls per volume;  speed: their mean speed (both from the frames)\n"
        "--of hits: collisions per volume and time;  vn: their mean normal speed;\n"
        "     energy: Σ ½ m_eff v_n² per volume and time;  lost: what they dissipate there\n"
        "     (these four from the collision table; --class picks classes)\n"
        "The default is count, with --class hits.\n"
        "Sectors all have one volume; rings have one cross-section and are mirrored at the axis.\n"
        "The text table sums up the tubes; --csv and --json give every cell. Cells without data "
        "stay\n"
        "blank. With --minus, both maps and their difference are made; red is where RUN is "
        "larger.\n"
        "Both runs must be of drums of one size, and each has its own window.\n"
        "With --slices, one picture is written per slice: FILE-1.png, FILE-2.png, ...",
    .examples =
        "  millpost map simoloyer-2l.h5 --cells sectors --of count -o where.png\n"
        "  millpost map simoloyer-2l.h5 --cells rings --of vn --class ball-ball -o vn.png\n"
        "  millpost map ramps.h5 --minus plain.h5 --cells sectors --of vn -o difference.png",
    .options = option_names,
    .least = 1,
    .most = 1,
};

/* What is shown of a cell. */
struct shown {
  double value, half, spread, values;
};

static struct shown look(const struct em_field *field, const struct em_field *minus, size_t k,
                         double level) {
  const struct em_interval a = em_field_value(field, k, level);
  struct shown out = {a.value, a.half, NAN, em_field_values(field, k)};
  if (!minus) {
    out.spread = em_field_spread(field, k);
    if (out.values == 0.0) out.value = out.half = NAN;
    return out;
  }
  const struct em_interval b = em_field_value(minus, k, level);
  if (out.values == 0.0 && em_field_values(minus, k) == 0.0) out.value = NAN;
  out.value -= b.value;
  out.half = hypot(a.half, b.half);
  return out;
}

/* ---------------------------------------------------------------- tables */

static void tube_table(struct em_report *report, const struct em_field *field,
                       const struct em_field *minus, double level) {
  const struct em_cells *cells = field->cells;
  const char *unit = em_field_unit(field->of);
  em_report_begin(report, "tubes", em_field_symbol(field->of));
  em_report_column(report, "from", "radius from", "mm");
  em_report_column(report, "to", "to", "mm");
  em_report_column(report, "values", "values", "");
  em_report_column(report, "share", "share", "");
  em_report_column(report, "value", "value", unit);
  if (minus) em_report_column(report, "other", "other run", unit);
  for (size_t t = 0; t < cells->tubes; t++) {
    /* A tube is the same stretch of cells in every slice. */
    double n = 0.0;
    const size_t first = cells->first[t], end = first + cells->in_tube[t];
    for (size_t s = 0; s < cells->slices; s++)
      for (size_t k = first; k < end; k++)
        n += em_field_values(field, s * cells->per_slice + k);
    const struct em_interval value = em_field_tube_value(field, t, level);
    em_report_number(report, 1e3 * cells->edge[t]);
    em_report_number(report, 1e3 * cells->edge[t + 1]);
    em_report_count(report, (uint64_t)n);
    em_report_percent(report, field->total > 0.0 ? n / field->total : NAN);
    em_report_interval(report, &value);
    if (minus) {
      const struct em_interval other = em_field_tube_value(minus, t, level);
      em_report_interval(report, &other);
    }
  }
}

static void cell_table(struct em_report *report, const struct em_field *field,
                       const struct em_field *minus, double level) {
  const char *unit = em_field_unit(field->of);
  em_report_begin(report, "cells", NULL);
  em_report_column(report, "r_from", "r from", "m");
  em_report_column(report, "r_to", "to", "m");
  em_report_column(report, "angle_from", "angle from", "rad");
  em_report_column(report, "angle_to", "to", "rad");
  em_report_column(report, "y_from", "y from", "m");
  em_report_column(report, "y_to", "to", "m");
  em_report_column(report, "values", "values", "");
  em_report_column(report, minus ? "difference" : "value", "value", unit);
  em_report_column(report, "half", "±", unit);
  em_report_column(report, "relative_sigma", "relative σ", "");
  for (size_t k = 0; k < field->cells->count; k++) {
    const struct shown cell = look(field, minus, k, level);
    double low[3], high[3];
    em_cells_bounds(field->cells, k, low, high);
    for (int d = 0; d < 3; d++) {
      em_report_number(report, low[d]);
      em_report_number(report, high[d]);
    }
    em_report_count(report, (uint64_t)cell.values);
    em_report_number(report, cell.value);
    em_report_number(report, cell.half);
    em_report_number(report, cell.spread);
  }
}

/* minus, other: of the run that is subtracted, and its window; minus NULL: none. */
static void facts(struct em_report *report, const struct em_field *field,
                  const struct em_field *minus, const struct em_millpost_options *o,
                  const struct em_window *window, const struct em_window *other) {
  const struct em_cells *cells = field->cells;
  em_report_fact_text(report, "run", "run", "%s", o->run[0]);
  em_report_fact_text(report, "of", "map of", "%s [%s]", em_field_symbol(field->of),
                      em_field_unit(field->of));
  char classes[EM_MILLPOST_CLASSES];
  em_millpost_classes(o->classes, classes, sizeof classes);
  if (o->classes) em_report_fact_text(report, "classes", "classes", "%s", classes);
  em_window_report(report, window);
  if (minus) {
    em_report_fact_text(report, "minus", "minus", "%s", o->minus);
    em_report_fact(report, "minus_from", "from", other->from, "s");
    em_report_fact(report, "minus_to", "to", other->to, "s");
    em_report_fact_text(report, "minus_from_how", "begin chosen", "%s", other->how);
  }
  if (cells->kind == EM_CELLS_SECTORS)
    em_report_fact_text(report, "cells_kind", "cells", "%zu sectors in %zu tubes, %zu slice%s",
                        cells->count, cells->tubes, cells->slices, cells->slices > 1 ? "s" : "");
  else
    em_report_fact_text(report, "cells_kind", "cells", "%zu rings, %zu radial × %zu axial",
                        cells->count, cells->tubes, cells->columns);
  em_report_fact_count(report, "values_in_cells", "values", (uint64_t)field->total);
  if (field->outside > 0.0)
    em_report_fact_count(report, "values_outside", "values outside the drum",
                         (uint64_t)field->outside);
  if (isfinite(field->rim))
    em_report_fact(report, "share_in_rim",
                   "share of balls in the outer 7.84 % that centres can reach", field->rim, "");
}

/* ---------------------------------------------------------------- pictures */

static double picked(const struct shown *cell, const struct em_millpost_options *o) {
  if (o->spread) return 100.0 * cell->spread;
  if (o->relative) return 100.0 * cell->half / fabs(cell->value);
  return cell->value;
}

/* The cells of one slice, and how many values stand behind each; rings twice, mirrored at the axis.
 */
static size_t fill(struct em_plot_cell *out, double *values, const struct em_field *field,
                   const struct em_field *minus, const struct em_millpost_options *o,
                   size_t slice) {
  const struct em_cells *cells = field->cells;
  size_t count = 0;
  for (size_t j = 0; j < cells->per_slice; j++) {
    const size_t k = slice * cells->per_slice + j;
    const struct shown cell = look(field, minus, k, o->level);
    const double value = picked(&cell, o);
    double low[3], high[3];
    em_cells_bounds(cells, k, low, high);
    values[count] = cell.values;
    if (cells->kind == EM_CELLS_SECTORS) {
      out[count++] = (struct em_plot_cell){{low[0], low[1]}, {high[0], high[1]}, value};
      continue;
    }
    out[count++] =
        (struct em_plot_cell){{1e3 * low[2], 1e3 * low[0]}, {1e3 * high[2], 1e3 * high[0]}, value};
    values[count] = cell.values;
    out[count++] = (struct em_plot_cell){
        {1e3 * low[2], -1e3 * high[0]}, {1e3 * high[2], -1e3 * low[0]}, value};
  }
  if (cells->kind == EM_CELLS_SECTORS)
    for (size_t j = 0; j < count; j++) {
      out[j].low[0] *= 1e3; /* mm */
      out[j].high[0] *= 1e3;
    }
  return count;
}

/* Colours from the 0.5 % to the 99.5 % quantile of the cells that hold at least so many values:
 * means of fewer scatter too much to set the scale. */
enum { LEAST_VALUES = 10 };

static void colour_range(struct em_plot_map *map, const double *values, bool means) {
  double *value = malloc((map->cell_count + 1) * sizeof *value);
  size_t n = 0;
  map->low = map->high = 0.0;
  if (!value) return;
  for (int least = means ? LEAST_VALUES : 0; n == 0 && least >= 0; least -= LEAST_VALUES)
    for (size_t k = 0; k < map->cell_count; k++)
      if (isfinite(map->cell[k].value) && values[k] >= least)
        value[n++] = map->diverging ? fabs(map->cell[k].value) : map->cell[k].value;
  if (n > 0) {
    gsl_sort(value, 1, n);
    map->high = em_sample_quantile(value, n, 0.995);
    map->low = map->diverging ? -map->high : em_sample_quantile(value, n, 0.005);
  }
  free(value);
}

static void titles(struct em_plot_map *map, const struct em_field *field,
                   const struct em_field *minus, const struct em_millpost_options *o, char *title,
                   char *value, size_t size) {
  const char *symbol = em_field_symbol(field->of), *unit = em_field_unit(field->of);
  if (o->spread) {
    snprintf(title, size, "Relative standard deviation, %s", symbol);
    snprintf(value, size, "relative standard deviation  [%%]");
  } else if (o->relative) {
    snprintf(title, size, "Confidence interval (±) of the %s", symbol);
    snprintf(value, size, "± relative to the value  [%%]");
  } else if (minus) {
    snprintf(title, size, "Difference of the %s", symbol);
    snprintf(value, size, "difference  [%s]", unit);
  } else {
    snprintf(title, size, "%c%s", symbol[0] >= 'a' && symbol[0] <= 'z' ? symbol[0] - 32 : symbol[0],
             symbol + 1);
    snprintf(value, size, "%s  [%s]", symbol, unit);
  }
  map->title = title;
  map->value_label = value;
  map->polar = field->cells->kind == EM_CELLS_SECTORS;
  map->equal = true;
  map->x_label = map->polar ? "x  [mm]" : "y, along the axis  [mm]";
  map->y_label = map->polar ? "z  [mm]" : "radius  [mm]";
  map->diverging = minus && !o->relative;
  map->log_value = !map->diverging && !o->spread && !em_field_is_mean(field->of);
}

static enum em_status draw_slice(const struct em_run_file *run, const struct em_run_file *other,
                                 const struct em_field *field, const struct em_field *minus,
                                 const struct em_millpost_options *o, size_t slice,
                                 const char *path, struct em_error *err) {
  char title[160], value[160], subtitle[640], classes[EM_MILLPOST_CLASSES];
  struct em_plot_map map = {.width = 0};
  struct em_plot_cell *cell = malloc(2 * field->cells->per_slice * sizeof *cell);
  double *values = malloc(2 * field->cells->per_slice * sizeof *values);
  if (!cell || !values) {
    free(cell);
    free(values);
    return em_error_set(err, EM_MEMORY, NULL, 0, "out of memory");
  }
  titles(&map, field, minus, o, title, value, sizeof title);
  em_plot_subtitle(em_run_file_scene(run), subtitle, sizeof subtitle);
  if (minus) {
    char a[96], b[96];
    em_millpost_label(o->run[0], a, sizeof a);
    em_millpost_label(o->minus, b, sizeof b);
    const struct em_scene *const both[] = {em_run_file_scene(run), em_run_file_scene(other)};
    const int length = snprintf(subtitle, sizeof subtitle, "%s minus %s · ", a, b);
    em_plot_subtitles(both, 2, subtitle + length, sizeof subtitle - (size_t)length);
  }
  em_millpost_classes(o->classes, classes, sizeof classes);
  size_t used = strlen(subtitle);
  if (o->classes) snprintf(subtitle + used, sizeof subtitle - used, " · %s", classes);
  used = strlen(subtitle);
  if (field->cells->slices > 1)
    snprintf(subtitle + used, sizeof subtitle - used, " · slice %zu of %zu", slice + 1,
             field->cells->slices);
  map.subtitle = subtitle;
  map.cell = cell;
  map.cell_count = fill(cell, values, field, minus, o, slice);
  colour_range(&map, values, em_field_is_mean(field->of));
  if (map.log_value && !(map.low > 0.0)) map.low = map.high = 0.0;
  const enum em_status status = em_plot_map(&map, path, err);
  free(cell);
  free(values);
  return status;
}

static enum em_status draw(const struct em_run_file *run, const struct em_run_file *other,
                           const struct em_field *field, const struct em_field *minus,
                           const struct em_millpost_options *o, struct em_error *err) {
  enum em_status status = EM_OK;
  for (size_t s = 0; s < field->cells->slices && status == EM_OK; s++) {
    char path[EM_SCENE_PATH], tag[32];
    snprintf(tag, sizeof tag, "%zu", s + 1);
    em_output_name(path, sizeof path, o->out, tag, NULL);
    status =
        draw_slice(run, other, field, minus, o, s, field->cells->slices > 1 ? path : o->out, err);
  }
  return status;
}

/* ---------------------------------------------------------------- command */

struct input {
  struct em_run_file *run;
  struct em_field *field;
  struct em_window window;
};

static struct em_cells *make_cells(const struct em_chamber *chamber,
                                   const struct em_millpost_options *o) {
  const double radius = 0.5 * chamber->diameter;
  if (strcmp(o->cells, "rings") == 0)
    return em_cells_rings(radius, chamber->length, o->rings ? (size_t)o->rings : 2000);
  return em_cells_sectors(radius, chamber->length, o->tubes ? (size_t)o->tubes : 25,
                          o->sectors ? (size_t)o->sectors : 2500,
                          o->slices ? (size_t)o->slices : 1);
}

/* chamber: what the run's must be alike, or NULL. */
static enum em_status read_input(struct input *in, const char *path,
                                 const struct em_millpost_options *o, enum em_field_of of,
                                 const struct em_chamber *chamber, struct em_error *err) {
  enum em_status status = em_millpost_open(&in->run, path, err);
  if (status != EM_OK) return status;
  const struct em_scene *scene = em_run_file_scene(in->run);
  if (scene->chamber.shape != EM_SHAPE_DRUM)
    return em_error_set(err, EM_INPUT, path, 0, "maps are of drums, this chamber is a box");
  if (scene->chamber.facets > 0)
    return em_error_set(err, EM_INPUT, path, 0,
                        "maps are of round drums, this one has %d facets (chamber.facets)",
                        scene->chamber.facets);
  const struct em_chamber *own = &scene->chamber;
  if (chamber && (own->diameter != chamber->diameter || own->length != chamber->length))
    return em_error_set(err, EM_INPUT, path, 0,
                        "a drum of %g × %g m (diameter × length), expected that of %s, %g × %g m",
                        own->diameter, own->length, o->run[0], chamber->diameter, chamber->length);
  status = em_window_find(&in->window, in->run, o->from, o->to, err);
  if (status != EM_OK) return status;
  struct em_cells *cells = make_cells(own, o);
  return em_field_new(&in->field, in->run, of, o->classes, cells, &in->window, err);
}

static int run_with(struct input *a, struct input *b, const struct em_millpost_options *o,
                    enum em_field_of of) {
  struct em_error err = {.code = EM_OK};
  enum em_status status = read_input(a, o->run[0], o, of, NULL, &err);
  if (status == EM_OK && o->minus)
    status = read_input(b, o->minus, o, of, &em_run_file_scene(a->run)->chamber, &err);
  if (status == EM_OK && !(a->field->total > 0.0))
    status = em_error_set(&err, EM_INPUT, o->run[0], 0, "nothing falls into the cells");
  if (status == EM_OK && o->out) status = draw(a->run, b->run, a->field, b->field, o, &err);
  if (status != EM_OK) return em_millpost_fail(&err);
  struct em_report *report = em_report_new("map");
  facts(report, a->field, b->field, o, &a->window, &b->window);
  tube_table(report, a->field, b->field, o->level);
  if (o->format != EM_REPORT_TEXT) cell_table(report, a->field, b->field, o->level);
  return em_millpost_print(report, o, EM_MILLPOST_DONE);
}

/* What does not go together; -1: everything does. */
static int check(const struct em_millpost_options *o, enum em_field_of of) {
  const char *name = em_field_name(of);
  const bool rings = strcmp(o->cells, "rings") == 0;
  if (o->classes && (of == EM_FIELD_COUNT || of == EM_FIELD_SPEED))
    return em_millpost_usage("map",
                             "--class: balls have none, expected it with hits vn energy or "
                             "lost, not with --of %s",
                             name);
  if (o->spread && !em_field_is_mean(of))
    return em_millpost_usage("map", "--spread: expected a mean, --of speed or vn, not %s", name);
  if (o->spread && (o->minus || o->relative))
    return em_millpost_usage("map", "--spread goes with neither --minus nor --relative");
  if (rings && (o->slices || o->tubes || o->sectors))
    return em_millpost_usage("map", "--slices, --tubes and --sectors are of --cells sectors");
  if (!rings && o->rings) return em_millpost_usage("map", "--rings is of --cells rings");
  if ((o->sectors ? o->sectors : 2500) < (o->tubes ? o->tubes : 25))
    return em_millpost_usage("map", "fewer sectors than tubes");
  return -1;
}

#define WORD(code, name, symbol, unit) " " name

int em_millpost_map(int argc, char **argv) {
  struct em_millpost_options o;
  int code = em_millpost_options(&o, &help, argc, argv);
  if (code >= 0) return code;
  if (!o.cells || (strcmp(o.cells, "sectors") != 0 && strcmp(o.cells, "rings") != 0))
    return em_millpost_usage("map", "--cells must be sectors or rings");
  const int of = o.of ? em_field_find(o.of) : o.classes ? EM_FIELD_HITS : EM_FIELD_COUNT;
  if (of < 0)
    return em_millpost_usage("map", "unknown quantity '%s', expected one of:" EM_FIELD_LIST(WORD),
                             o.of);
  code = check(&o, (enum em_field_of)of);
  if (code >= 0) return code;
  struct input a = {NULL, NULL, {0}}, b = {NULL, NULL, {0}};
  const int result = run_with(&a, &b, &o, (enum em_field_of)of);
  em_field_free(a.field);
  em_field_free(b.field);
  em_run_file_close(a.run);
  em_run_file_close(b.run);
  return result;
}
