/* millpost hist: how often and how hard, as tables with confidence intervals and as a diagram. */
#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "eventmill/plot.h"
#include "tool/gather.h"
#include "tool/millpost.h"
#include "tool/window.h"

enum { MOST_RUNS = 16, LEAST_BINS = 100, MOST_BINS = 2000, ONLINE_BINS = 160 };

static const char *const option_names[] = {"of",    "class",      "from",  "to",  "bins",   "above",
                                           "level", "cumulative", "curve", "log", "output", ""};

static const struct em_millpost_help help = {
    .name = "hist",
    .arguments = "RUN [RUN ...]",
    .summary =
        "Tells how often and how hard balls hit: counts, rates, quartiles, and what lies above "
        "a threshold.",
    .details =
        "Quantities (--of): vn vt relative energy lost impact, at collisions;\n"
        "speed vx vy vz, of balls in the frames. All but vn, speed and its components need the\n"
        "collision table (record.collisions=true). The ± are confidence intervals that respect\n"
        "correlation in time. Several runs are laid over one another.",
    .examples =
        "  millpost hist simoloyer-2l.h5 -o vn.png\n"
        "  millpost hist simoloyer-2l.h5 --of speed --from 0.2 --csv\n"
        "  millpost hist slow.h5 fast.h5 --class ball-ball --above 2 --cumulative -o both.png",
    .options = option_names,
    .least = 1,
    .most = MOST_RUNS,
};

struct input {
  struct em_run_file *file;
  struct em_gather *gather;
  struct em_window window;
  char label[96];
};

static bool shown(const struct input *in, unsigned classes, int row) {
  if (row == EM_GATHER_ALL) return true;
  if (in->gather->of_balls) return false;
  if (classes) return (classes & 1U << row) != 0;
  return em_histogram_weight(in->gather->total[row]) > 0.0;
}

static const char *row_name(const struct em_gather *gather, int row) {
  if (row < EM_CLASS_COUNT) return em_contact_class_name((enum em_class)row);
  return gather->of_balls ? "balls" : "all";
}

/* ---------------------------------------------------------------- tables */

static void begin_row(struct em_report *report, const struct input *in, int runs, int row) {
  if (runs > 1) em_report_text(report, "%s", in->label);
  em_report_text(report, "%s", row_name(in->gather, row));
}

static void begin_table(struct em_report *report, const char *key, const char *title, int runs) {
  em_report_begin(report, key, title);
  if (runs > 1) em_report_column(report, "run", "run", "");
  em_report_column(report, "class", "class", "");
}

static void interval(struct em_report *report, const struct em_gather *gather, int row,
                     enum em_gather_figure figure, double parameter, double level) {
  const struct em_interval i = em_gather_interval(gather, row, figure, parameter, level);
  if (figure == EM_GATHER_SHARE_ABOVE)
    em_report_percent_interval(report, &i);
  else
    em_report_interval(report, &i);
}

static void how_often(struct em_report *report, const struct input *in, int runs,
                      const struct em_millpost_options *o, double above) {
  const bool balls = in[0].gather->of_balls, threshold = isfinite(above);
  const char *unit = em_gather_unit(in[0].gather->of);
  begin_table(report, "how_often", "How often", runs);
  em_report_column(report, "count", balls ? "values" : "collisions", "");
  if (!balls) {
    em_report_column(report, "share", "share", "");
    em_report_column(report, "rate", "rate", "1/s");
  }
  if (threshold) {
    char heading[64];
    snprintf(heading, sizeof heading, "above %g %s", above, unit);
    em_report_column(report, "share_above", heading, "");
    if (!balls) em_report_column(report, "rate_above", heading, "1/s");
  }
  for (int r = 0; r < runs; r++)
    for (int row = 0; row < EM_GATHER_ROWS; row++) {
      const struct em_gather *gather = in[r].gather;
      if (!shown(&in[r], o->classes, row)) continue;
      begin_row(report, &in[r], runs, row);
      em_report_count(report, (uint64_t)em_histogram_weight(gather->total[row]));
      if (!balls) {
        const struct em_interval share = em_gather_share(gather, row, o->level);
        if (row == EM_GATHER_ALL)
          em_report_percent(report, 1.0);
        else
          em_report_percent_interval(report, &share);
        interval(report, gather, row, EM_GATHER_RATE, 0.0, o->level);
      }
      if (!threshold) continue;
      interval(report, gather, row, EM_GATHER_SHARE_ABOVE, above, o->level);
      if (!balls) interval(report, gather, row, EM_GATHER_RATE_ABOVE, above, o->level);
    }
}

static void how_hard(struct em_report *report, const struct input *in, int runs,
                     const struct em_millpost_options *o) {
  const char *unit = em_gather_unit(in[0].gather->of);
  char title[128];
  bool online = false;
  for (int r = 0; r < runs; r++)
    online = online || in[r].gather->online;
  snprintf(title, sizeof title, "How %s: %s",
           in[0].gather->of_balls                 ? "fast"
           : in[0].gather->of == EM_GATHER_IMPACT ? "central"
                                                  : "hard",
           em_gather_symbol(in[0].gather->of));
  begin_table(report, "how_hard", title, runs);
  em_report_column(report, "mode", "mode", unit);
  em_report_column(report, "q25", "1st quartile", unit);
  em_report_column(report, "median", "median", unit);
  em_report_column(report, "q75", "3rd quartile", unit);
  em_report_column(report, "mean", "mean", unit);
  em_report_column(report, "q90", "90 % below", unit);
  em_report_column(report, "highest", online ? "all below" : "highest", unit);
  for (int r = 0; r < runs; r++)
    for (int row = 0; row < EM_GATHER_ROWS; row++) {
      const struct em_gather *gather = in[r].gather;
      if (!shown(&in[r], o->classes, row)) continue;
      begin_row(report, &in[r], runs, row);
      interval(report, gather, row, EM_GATHER_MODE, 0.0, o->level);
      interval(report, gather, row, EM_GATHER_QUANTILE, 0.25, o->level);
      interval(report, gather, row, EM_GATHER_QUANTILE, 0.50, o->level);
      interval(report, gather, row, EM_GATHER_QUANTILE, 0.75, o->level);
      interval(report, gather, row, EM_GATHER_MEAN, 0.0, o->level);
      interval(report, gather, row, EM_GATHER_QUANTILE, 0.90, o->level);
      em_report_number(report, em_gather_highest(gather, row));
    }
}

/* ---------------------------------------------------------------- curves */

struct curve {
  struct em_histogram *h; /* equal bins */
  double *y;              /* bins + 1: heights, or shares at the edges */
  char name[160];
};

/* Is this a curve of the diagram? In a comparison of runs, all classes together unless asked for.
 */
static bool drawn(const struct input *in, int runs, unsigned classes, int row) {
  if (!shown(in, classes, row) || !(in->gather->total[row]->total > 0.0)) return false;
  if (runs > 1 && !classes && row != EM_GATHER_ALL) return false;
  const bool one = classes && !(classes & (classes - 1));
  return !(row == EM_GATHER_ALL && one); /* the same as its one class */
}

/* Ends of the bins in use; *low stays at 0 where no value is negative. */
static void range_of(const struct em_histogram *h, double *low, double *high) {
  size_t first = 0, end = h->bins;
  while (end > 0 && !(h->count[end - 1] > 0.0))
    end--;
  while (first < end && !(h->count[first] > 0.0))
    first++;
  *low = fmin(0.0, h->edge[first]);
  *high = h->edge[end];
}

/* The range that all curves share holds all values, so that the areas are 1. */
static void common_range(const struct input *in, int runs, unsigned classes, double *low,
                         double *high) {
  *low = INFINITY;
  *high = -INFINITY;
  for (int r = 0; r < runs; r++)
    for (int row = 0; row < EM_GATHER_ROWS; row++) {
      if (!drawn(&in[r], runs, classes, row)) continue;
      double own_low, own_high;
      range_of(in[r].gather->total[row], &own_low, &own_high);
      *low = fmin(*low, own_low);
      *high = fmax(*high, own_high);
    }
}

static bool make_curve(struct curve *curve, const struct em_histogram *h, size_t bins, double low,
                       double high, bool cumulative) {
  curve->h = em_histogram_rebin(h, bins, low, high);
  curve->y = calloc(bins + 1, sizeof *curve->y);
  if (!curve->h || !curve->y) return false;
  double sum = curve->h->below;
  const double all = sum + curve->h->total + curve->h->above;
  for (size_t k = 0; k < bins; k++) {
    curve->y[k] = cumulative ? (all > 0.0 ? sum / all : NAN) : em_histogram_density(curve->h, k);
    sum += curve->h->count[k];
  }
  curve->y[bins] = cumulative ? (all > 0.0 ? sum / all : NAN) : 0.0;
  return true;
}

/* All curves share their bins: the square root of the number of values of the curve that has the
 * fewest, but enough to tell the shape of those that have more. */
static size_t bins_of(const struct input *in, int runs, const struct em_millpost_options *o) {
  if (o->bins > 0) return (size_t)o->bins;
  size_t fewest = MOST_BINS, most = 1;
  for (int r = 0; r < runs; r++)
    for (int row = 0; row < EM_GATHER_ROWS; row++) {
      if (!drawn(&in[r], runs, o->classes, row)) continue;
      const size_t limit = in[r].gather->online ? ONLINE_BINS : MOST_BINS;
      const size_t bins = em_histogram_default_bins(in[r].gather->total[row]->total, limit);
      if (bins < fewest) fewest = bins;
      if (bins > most) most = bins;
    }
  const size_t least = most < LEAST_BINS ? most : LEAST_BINS;
  return fewest > least ? fewest : least;
}

static int make_curves(struct curve *curve, const struct input *in, int runs,
                       const struct em_millpost_options *o) {
  double low, high;
  common_range(in, runs, o->classes, &low, &high);
  if (!(low < high)) return 0;
  const size_t bins = bins_of(in, runs, o);
  int count = 0;
  for (int r = 0; r < runs; r++)
    for (int row = EM_GATHER_ALL; row >= 0; row--) {
      const struct em_histogram *h = in[r].gather->total[row];
      if (!drawn(&in[r], runs, o->classes, row)) continue;
      struct curve *c = &curve[count++];
      snprintf(c->name, sizeof c->name, "%s%s%s", runs > 1 ? in[r].label : "", runs > 1 ? ", " : "",
               row_name(in[r].gather, row));
      if (!make_curve(c, h, bins, low, high, o->cumulative)) return -1;
    }
  return count;
}

static const char *density_unit(enum em_gather_of of) {
  const char *unit = em_gather_unit(of);
  return strcmp(unit, "m/s") == 0 ? "s/m" : strcmp(unit, "J") == 0 ? "1/J" : "1";
}

static void curve_table(struct em_report *report, const struct curve *curve, int count,
                        const struct em_gather *gather, bool cumulative) {
  const char *unit = cumulative ? "" : density_unit(gather->of);
  em_report_begin(report, "curve", cumulative ? "Share below" : "Density (area 1)");
  em_report_column(report, "low", "from", em_gather_unit(gather->of));
  em_report_column(report, "high", "to", em_gather_unit(gather->of));
  for (int k = 0; k < count; k++)
    em_report_column(report, curve[k].name, curve[k].name, unit);
  for (size_t b = 0; b < curve[0].h->bins; b++) {
    em_report_number(report, curve[0].h->edge[b]);
    em_report_number(report, curve[0].h->edge[b + 1]);
    for (int k = 0; k < count; k++)
      em_report_number(report, cumulative ? curve[k].y[b + 1] : curve[k].y[b]);
  }
}

static enum em_status draw(const struct curve *curve, int count, const struct input *in, int runs,
                           const struct em_millpost_options *o, double above,
                           struct em_error *err) {
  struct em_plot_series series[MOST_RUNS * EM_GATHER_ROWS];
  const struct em_gather *gather = in[0].gather;
  char subtitle[320], title[160], x_label[96], y_label[96], mark_name[64];
  char classes[EM_MILLPOST_CLASSES];
  for (int k = 0; k < count; k++) {
    const size_t bins = curve[k].h->bins;
    series[k] = (struct em_plot_series){.name = count > 1 ? curve[k].name : NULL,
                                        .style = o->cumulative ? EM_PLOT_LINE : EM_PLOT_STEPS,
                                        .count = o->cumulative ? bins + 1 : bins,
                                        .x = curve[k].h->edge,
                                        .y = curve[k].y};
  }
  em_plot_subtitle(em_run_file_scene(in[0].file), subtitle, sizeof subtitle);
  const size_t used = strlen(subtitle);
  snprintf(subtitle + used, sizeof subtitle - used, " · %.3g … %.3g s", gather->from, gather->to);
  if (runs > 1) {
    const struct em_scene *scene[MOST_RUNS];
    for (int r = 0; r < runs; r++)
      scene[r] = em_run_file_scene(in[r].file);
    em_plot_subtitles(scene, (size_t)runs, subtitle, sizeof subtitle);
  }
  em_millpost_classes(o->classes, classes, sizeof classes);
  const size_t end_of_it = strlen(subtitle);
  if (o->classes) snprintf(subtitle + end_of_it, sizeof subtitle - end_of_it, " · %s", classes);
  snprintf(title, sizeof title, "%s of the %s", o->cumulative ? "Cumulative share" : "Distribution",
           em_gather_symbol(gather->of));
  snprintf(x_label, sizeof x_label, "%s  [%s]", em_gather_symbol(gather->of),
           em_gather_unit(gather->of));
  snprintf(y_label, sizeof y_label, o->cumulative ? "share below" : "density  [%s]",
           density_unit(gather->of));
  snprintf(mark_name, sizeof mark_name, "%g %s", above, em_gather_unit(gather->of));
  const struct em_plot_mark mark = {above, false, mark_name};
  const double end = curve[0].h->edge[curve[0].h->bins];
  const struct em_plot plot = {.title = title,
                               .subtitle = subtitle,
                               .x_label = x_label,
                               .y_label = y_label,
                               .log_y = o->log,
                               .series_count = (size_t)count,
                               .series = series,
                               .mark_count = isfinite(above) && above < end ? 1 : 0,
                               .mark = &mark,
                               .y_high = o->cumulative ? 1.0 : 0.0};
  return em_plot_draw(&plot, o->out, err);
}

/* ---------------------------------------------------------------- command */

static enum em_status read_inputs(struct input *in, const struct em_millpost_options *o,
                                  enum em_gather_of of, struct em_error *err) {
  for (int r = 0; r < o->run_count; r++) {
    em_millpost_label(o->run[r], in[r].label, sizeof in[r].label);
    enum em_status status = em_millpost_open(&in[r].file, o->run[r], err);
    if (status == EM_OK) status = em_window_find(&in[r].window, in[r].file, o->from, o->to, err);
    if (status == EM_OK)
      status = em_gather_new(&in[r].gather, in[r].file, of, o->classes, &in[r].window, err);
    if (status != EM_OK) return status;
  }
  return EM_OK;
}

static void facts(struct em_report *report, const struct input *in, int runs,
                  const struct em_millpost_options *o) {
  assert(in[0].gather != NULL);
  em_report_fact_text(report, "of", "quantity", "%s [%s]", em_gather_symbol(in[0].gather->of),
                      em_gather_unit(in[0].gather->of));
  em_report_fact(report, "level", "level of the intervals", o->level, "");
  for (int r = 0; r < runs; r++) {
    if (runs == 1) em_report_fact_text(report, "run", "run", "%s", o->run[0]);
    if (runs > 1)
      em_report_fact_text(report, in[r].label, in[r].label, "%g … %g s (%s)", in[r].gather->from,
                          in[r].gather->to, em_gather_window(in[r].gather, &in[r].window).how);
  }
  if (runs > 1) return;
  const struct em_window used = em_gather_window(in[0].gather, &in[0].window);
  em_window_report(report, &used);
  em_report_fact_text(report, "source", "read from", "%s",
                      in[0].gather->of_balls ? "frames"
                      : in[0].gather->online ? "online histograms (whole blocks of time)"
                                             : "collision table");
}

static void notes(struct em_report *report, const struct input *in) {
  const struct em_histogram *h = in->gather->total[EM_GATHER_ALL];
  const char *unit = em_gather_unit(in->gather->of);
  if (!(em_histogram_weight(h) > 0.0))
    em_report_note(report, "%s: nothing was counted between %.9g s and %.9g s.", in->label,
                   in->gather->from, in->gather->to);
  static const char *const how_far = "- stands for figures that depend on how far";
  const double all = em_histogram_weight(h), begin = h->edge[0], end = h->edge[h->bins];
  if (h->below > 0.0)
    em_report_note(report, "%s: %.0f of %.0f values lie below %g %s, where the bins begin; %s.",
                   in->label, h->below, all, begin, unit, how_far);
  if (h->above > 0.0)
    em_report_note(report, "%s: %.0f of %.0f values lie beyond %g %s, where the bins end; %s.",
                   in->label, h->above, all, end, unit, how_far);
}

static int run_with(struct input *in, const struct em_millpost_options *o, enum em_gather_of of) {
  struct em_error err = {.code = EM_OK};
  const int runs = o->run_count;
  if (read_inputs(in, o, of, &err) != EM_OK) return em_millpost_fail(&err);
  double above = o->above;
  if (isnan(above) && strcmp(em_gather_unit(of), "m/s") == 0) above = 3.0;
  struct em_report *report = em_report_new("hist");
  facts(report, in, runs, o);
  for (int r = 0; r < runs; r++)
    notes(report, &in[r]);
  how_often(report, in, runs, o, above);
  how_hard(report, in, runs, o);
  struct curve curve[MOST_RUNS * EM_GATHER_ROWS] = {{NULL, NULL, ""}};
  const int count = make_curves(curve, in, runs, o);
  enum em_status status =
      count < 0 ? em_error_set(&err, EM_MEMORY, NULL, 0, "out of memory") : EM_OK;
  if (count == 0 && (o->curve || o->out))
    status = em_error_set(&err, EM_INPUT, o->run[0], 0, "nothing was counted in this window");
  if (status == EM_OK && o->curve) curve_table(report, curve, count, in[0].gather, o->cumulative);
  if (status == EM_OK && o->out) status = draw(curve, count, in, runs, o, above, &err);
  for (size_t k = 0; k < sizeof curve / sizeof *curve; k++) {
    em_histogram_free(curve[k].h);
    free(curve[k].y);
  }
  const int code = status == EM_OK ? EM_MILLPOST_DONE : em_millpost_fail(&err);
  return em_millpost_print(report, o, code);
}

#define WORD(code, name, symbol, unit) " " name

int em_millpost_hist(int argc, char **argv) {
  struct em_millpost_options options;
  const int code = em_millpost_options(&options, &help, argc, argv);
  if (code >= 0) return code;
  const int of = options.of ? em_gather_find(options.of) : EM_GATHER_VN;
  if (of < 0)
    return em_millpost_usage("hist", "unknown quantity '%s', expected one of:" EM_GATHER_LIST(WORD),
                             options.of);
  if (options.classes && em_gather_is_of_balls((enum em_gather_of)of))
    return em_millpost_usage("hist",
                             "--class: balls have none, expected it with vn vt relative "
                             "energy lost or impact, not with --of %s",
                             options.of);
  struct input in[MOST_RUNS] = {{NULL, NULL, {0}, ""}};
  const int result = run_with(in, &options, (enum em_gather_of)of);
  for (int r = 0; r < options.run_count; r++) {
    em_gather_free(in[r].gather);
    em_run_file_close(in[r].file);
  }
  return result;
}
