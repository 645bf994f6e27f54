/* Tables and pictures of mill cost. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "eventmill/plot.h"
#include "tool/mill_cost.h"
#include "tool/report.h"

/* ---------------------------------------------------------------- tables */

static const char *const figure_key[] = {"median_speed", "median_vn", "rate_above_3", "power"};

/* By how much a figure is shifted, relative to the scene as it is over the same time. */
static struct em_interval shift(const struct em_cost_result *r, int k) {
  const struct em_interval *a = &r->plain[k], *b = &r->figure[k];
  struct em_interval s = {NAN, NAN, NAN, 0.0, 1.0};
  if (r->failed || !(fabs(a->value) > 0.0)) return s;
  s.value = (b->value - a->value) / fabs(a->value);
  s.half = hypot(a->half, b->half) / fabs(a->value);
  return s;
}

static void shift_columns(struct em_report *report) {
  for (int k = 0; k < EM_PRECISION_COUNT; k++)
    em_report_column(report, figure_key[k], em_precision_words((enum em_precision_kind)k), "");
}

static void shift_cells(struct em_report *report, const struct em_cost_result *r) {
  for (int k = 0; k < EM_PRECISION_COUNT; k++) {
    const struct em_interval s = shift(r, k);
    em_report_percent_interval(report, &s);
  }
}

static void time_columns(struct em_report *report) {
  em_report_column(report, "variant", "variant", "");
  em_report_column(report, "time", "time", "");
  em_report_column(report, "time_low", "from", "");
  em_report_column(report, "time_high", "to", "");
  em_report_column(report, "time_per_collision", "per collision", "");
}

static void time_cells(struct em_report *report, const struct em_cost_result *r) {
  em_report_text(report, "%s", r->variant.name);
  em_report_number(report, r->failed ? NAN : r->time);
  em_report_number(report, r->failed ? NAN : r->time_low);
  em_report_number(report, r->failed ? NAN : r->time_high);
  em_report_number(report, r->failed ? NAN : r->collision);
}

/* Per 10⁹ flights. */
static double share(uint64_t n, uint64_t flights) {
  return flights ? 1e9 * (double)n / (double)flights : NAN;
}

static void accuracy_table(struct em_report *report, const struct em_cost *cost) {
  em_report_begin(report, "accuracy",
                  "accuracy against time: the scene as it is = 1; figures: shift against it");
  time_columns(report);
  em_report_column(report, "error_rms", "contact time, rms", "s");
  em_report_column(report, "error_most", "largest", "s");
  em_report_column(report, "missed", "missed", "/1e9 flights");
  em_report_column(report, "invented", "invented", "/1e9 flights");
  em_report_column(report, "energy", "energy error", "");
  shift_columns(report);
  for (size_t k = 0; k < cost->count; k++) {
    const struct em_cost_result *r = &cost->result[k];
    if (r->variant.group != EM_COST_ACCURACY) continue;
    const struct em_cost_flights *f = &r->flights;
    time_cells(report, r);
    em_report_number(report, f->contacts ? f->rms : NAN);
    em_report_number(report, f->contacts ? f->most : NAN);
    em_report_number(report, share(f->missed, f->flights));
    em_report_number(report, share(f->invented, f->flights));
    em_report_number(report, r->failed ? NAN : r->energy);
    shift_cells(report, r);
  }
}

static void effects_table(struct em_report *report, const struct em_cost *cost) {
  em_report_begin(report, "effects", "effects against time: the scene as it is = 1");
  time_columns(report);
  shift_columns(report);
  for (size_t k = 0; k < cost->count; k++) {
    const struct em_cost_result *r = &cost->result[k];
    if (r->variant.group != EM_COST_EFFECT) continue;
    time_cells(report, r);
    shift_cells(report, r);
  }
  em_report_begin(report, "recording",
                  "recording against time: a run that writes nothing but its end = 1");
  em_report_column(report, "variant", "variant", "");
  em_report_column(report, "time", "time", "");
  em_report_column(report, "time_low", "from", "");
  em_report_column(report, "time_high", "to", "");
  for (size_t k = 0; k < cost->count; k++) {
    const struct em_cost_result *r = &cost->result[k];
    if (r->variant.group != EM_COST_RECORDING) continue;
    em_report_text(report, "%s", r->variant.name);
    em_report_number(report, r->time);
    em_report_number(report, r->time_low);
    em_report_number(report, r->time_high);
  }
}

static struct em_interval relative(const struct em_interval *a) {
  struct em_interval r = *a;
  r.half = a->half / fabs(a->value);
  return r;
}

/* Simulated time (s) for a relative half width: it falls with the root of time. */
static double time_for(const struct em_cost *cost, int k, double wanted) {
  const double r = relative(&cost->figure[k]).half / wanted;
  return em_precision_time(cost->precision, em_precision_blocks(cost->precision)) * r * r;
}

static void statistics_table(struct em_report *report, const struct em_cost *cost) {
  em_report_begin(report, "statistics",
                  "statistics against time: half width of the confidence interval (95 %)");
  em_report_column(report, "time", "simulated", "s");
  em_report_column(report, "cpu", "computing", "s");
  shift_columns(report);
  const size_t all = em_precision_blocks(cost->precision);
  for (size_t n = all / 8; n > 0 && n <= all; n *= 2) {
    const double time = em_precision_time(cost->precision, n);
    em_report_number(report, time);
    em_report_number(report, time * cost->cpu_per_time);
    for (int k = 0; k < EM_PRECISION_COUNT; k++) {
      const struct em_interval f =
          em_precision_figure(cost->precision, n, (enum em_precision_kind)k, 3.0, 0.95);
      em_report_percent(report, relative(&f).half);
    }
  }
  em_report_begin(report, "one_percent", "one per cent takes");
  em_report_column(report, "figure", "figure", "");
  em_report_column(report, "value", "value", "");
  em_report_column(report, "unit", "", "");
  em_report_column(report, "inefficiency", "blocks that count as one", "");
  em_report_column(report, "time", "simulated", "s");
  em_report_column(report, "cpu", "computing", "s");
  for (int k = 0; k < EM_PRECISION_COUNT; k++) {
    const double time = time_for(cost, k, 0.01);
    if (!isfinite(time)) continue;
    em_report_text(report, "%s", em_precision_words((enum em_precision_kind)k));
    em_report_interval(report, &cost->figure[k]);
    em_report_text(report, "%s", em_precision_unit((enum em_precision_kind)k));
    em_report_number(report, cost->figure[k].inefficiency);
    em_report_number(report, time);
    em_report_number(report, time * cost->cpu_per_time);
  }
}

static void notes(struct em_report *report, const struct em_cost *cost) {
  const uint64_t flights = cost->result[0].flights.flights;
  if (flights)
    em_report_note(report,
                   "contact times: against 113 bits, over %llu flights of this scene; 0 seen means "
                   "less than %.3g in 1e9 (95 %%).",
                   (unsigned long long)flights, 3e9 / (double)flights);
  em_report_note(report, "d: diameter of a ball. time: median of %d turns, and their quartiles.",
                 cost->rounds);
  for (size_t k = 0; k < cost->count; k++)
    if (cost->result[k].failed)
      em_report_note(report, "%s: %s", cost->result[k].variant.name, cost->result[k].why);
}

static void facts(struct em_report *report, const struct em_cost *cost) {
  em_report_fact_text(report, "scene", "scene", "%s", cost->path);
  em_report_fact(report, "steady", "steady from", cost->steady, "s");
  em_report_fact(report, "time", "each run", cost->time, "s");
  em_report_fact(report, "cpu_per_time", "computing time", cost->cpu_per_time, "s per simulated s");
  em_report_fact(report, "collisions_per_time", "collisions", cost->collisions_per_time, "/s");
  em_report_fact(report, "energy", "energy error", cost->energy, "relative");
}

/* ---------------------------------------------------------------- pictures */

static enum em_status draw(const struct em_cost *cost, struct em_plot *plot, const char *prefix,
                           const char *what, struct em_error *err) {
  char path[EM_SCENE_PATH + 32], subtitle[256];
  snprintf(path, sizeof path, "%s-%s.png", prefix, what);
  em_plot_subtitle(cost->scene, subtitle, sizeof subtitle);
  plot->subtitle = subtitle;
  return em_plot_draw(plot, path, err);
}

/* Variants whose names begin with the same word are a family: one colour. */
static bool is_family(const char *a, const char *b) {
  const size_t n = strcspn(a, " ");
  return n == strcspn(b, " ") && strncmp(a, b, n) == 0;
}

/* A point per variant; errors of 0 lie at the lower edge. */
static enum em_status draw_accuracy(const struct em_cost *cost, const char *prefix,
                                    struct em_error *err) {
  struct em_plot_series series[EM_COST_VARIANTS];
  double x[EM_COST_VARIANTS], y[EM_COST_VARIANTS];
  char names[EM_COST_VARIANTS][16];
  const char *before = "";
  size_t n = 0, families = 0;
  for (size_t k = 0; k < cost->count; k++) {
    const struct em_cost_result *r = &cost->result[k];
    if (r->variant.group != EM_COST_ACCURACY || r->failed || !r->flights.contacts) continue;
    if (!isfinite(r->flights.rms)) continue;
    x[n] = r->time;
    y[n] = fmax(r->flights.rms, 1e-22);
    if (!is_family(before, r->variant.name)) {
      const char *name = r->variant.name;
      snprintf(names[families], sizeof names[0], "%.*s", (int)strcspn(name, " :"), name);
      if (strcmp(names[families], "no") == 0)
        snprintf(names[families], sizeof names[0], "shortcut");
      series[families] = (struct em_plot_series){
          .name = names[families], .style = EM_PLOT_POINTS, .x = &x[n], .y = &y[n]};
      families++;
      before = name;
    }
    series[families - 1].count++;
    n++;
  }
  if (n == 0) return EM_OK;
  struct em_plot plot = {.title = "Accuracy against time",
                         .x_label = "computing time, the scene as it is = 1",
                         .y_label = "error of contact times, rms  [s]",
                         .log_x = true,
                         .log_y = true,
                         .series_count = families,
                         .series = series};
  return draw(cost, &plot, prefix, "accuracy", err);
}

/* Bars with numbers, whose names stand in the legend. */
static enum em_status draw_effects(const struct em_cost *cost, const char *prefix,
                                   struct em_error *err) {
  struct em_plot_series series[EM_COST_VARIANTS];
  double x[EM_COST_VARIANTS], y[EM_COST_VARIANTS];
  char label[EM_COST_VARIANTS][96], number[EM_COST_VARIANTS][8];
  const char *names[EM_COST_VARIANTS + 8];
  double low = 0.0, high = 0.0;
  size_t n = 0;
  for (size_t k = 0; k < cost->count; k++) {
    const struct em_cost_result *r = &cost->result[k];
    if (r->variant.group == EM_COST_ACCURACY || r->failed || !isfinite(r->time)) continue;
    x[n] = (double)n;
    y[n] = 100.0 * (r->time - 1.0);
    low = fmin(low, y[n]);
    high = fmax(high, y[n]);
    snprintf(number[n], sizeof number[n], "%zu", n + 1);
    snprintf(label[n], sizeof label[n], "%zu  %s", n + 1, r->variant.name);
    series[n] = (struct em_plot_series){
        .name = label[n], .style = EM_PLOT_BARS, .count = 1, .x = &x[n], .y = &y[n]};
    names[n] = number[n];
    n++;
  }
  struct em_plot plot = {.title = "Effects against time",
                         .y_label = "computing time against the scene as it is  [%]",
                         .y_low = 1.1 * low - 1.0, /* room for the legend above the bars */
                         .y_high = high + 1.2 * (high - low) + 5.0,
                         .series_count = n,
                         .series = series,
                         .category = names,
                         .category_count = n,
                         .width = 1400};
  return n ? draw(cost, &plot, prefix, "effects", err) : EM_OK;
}

static enum em_status draw_statistics(const struct em_cost *cost, const char *prefix,
                                      struct em_error *err) {
  enum { POINTS = 24 };
  struct em_plot_series series[EM_PRECISION_COUNT];
  double x[POINTS], y[EM_PRECISION_COUNT][POINTS];
  const size_t all = em_precision_blocks(cost->precision);
  size_t n = 0, used = 0, before = 0;
  for (int k = 0; k < POINTS; k++) {
    const size_t blocks =
        (size_t)llround((double)all * pow(16.0, ((double)k - (POINTS - 1)) / (POINTS - 1)));
    if (blocks < 4 || blocks == before) continue;
    before = blocks;
    x[n] = em_precision_time(cost->precision, blocks);
    for (int j = 0; j < EM_PRECISION_COUNT; j++) {
      const struct em_interval f =
          em_precision_figure(cost->precision, blocks, (enum em_precision_kind)j, 3.0, 0.95);
      y[j][n] = 100.0 * relative(&f).half;
      if (!(y[j][n] > 0.0) || !isfinite(y[j][n])) y[j][n] = NAN;
    }
    n++;
  }
  for (int j = 0; j < EM_PRECISION_COUNT; j++) {
    if (!(cost->figure[j].half > 0.0) || cost->figure[j].value == 0.0) continue;
    series[used++] = (struct em_plot_series){.name = em_precision_words((enum em_precision_kind)j),
                                             .style = EM_PLOT_LINE,
                                             .count = n,
                                             .x = x,
                                             .y = y[j]};
  }
  struct em_plot plot = {.title = "Statistics against time",
                         .x_label = "simulated time  [s]",
                         .y_label = "half width of the confidence interval  [%]",
                         .log_x = true,
                         .log_y = true,
                         .series_count = used,
                         .series = series};
  return used && n > 1 ? draw(cost, &plot, prefix, "statistics", err) : EM_OK;
}

/* ---------------------------------------------------------------- all of it */

static enum em_status write_csv(const struct em_report *report, const char *path,
                                struct em_error *err) {
  FILE *out = fopen(path, "w");
  if (!out) return em_error_set(err, EM_FILE, path, 0, "cannot be written");
  enum em_status status = em_report_print(report, EM_REPORT_CSV, out, err);
  if (fclose(out) && !status) status = em_error_set(err, EM_FILE, path, 0, "cannot be written");
  return status;
}

enum em_status em_mill_cost_report(const struct em_cost *cost, bool json, const char *csv,
                                   const char *prefix, struct em_error *err) {
  struct em_report *report = em_report_new("cost");
  facts(report, cost);
  accuracy_table(report, cost);
  effects_table(report, cost);
  statistics_table(report, cost);
  notes(report, cost);
  enum em_status status =
      em_report_print(report, json ? EM_REPORT_JSON : EM_REPORT_TEXT, stdout, err);
  if (!status && csv) status = write_csv(report, csv, err);
  if (!status && prefix) status = draw_accuracy(cost, prefix, err);
  if (!status && prefix) status = draw_effects(cost, prefix, err);
  if (!status && prefix) status = draw_statistics(cost, prefix, err);
  em_report_free(report);
  return status;
}
