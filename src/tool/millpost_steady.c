/* millpost steady: from when on a run is stationary, by several observables. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "eventmill/plot.h"
#include "eventmill/steady.h"
#include "tool/millpost.h"
#include "tool/trace.h"
#include "tool/window.h"

static const char *const option_names[] = {"to", "level", "output", ""};

static const struct em_millpost_help help = {
    .name = "steady",
    .arguments = "RUN",
    .summary = "Tells from when on a run is stationary.",
    .details =
        "The start is where MSER cuts: the rest then has the least standard error. Cuts in the "
        "first\n"
        "half of a series are tried; if the last of them is the best, no steady state was found. "
        "A\n"
        "rest of fewer than ten independent values is too short to tell. Geweke's test compares "
        "the first\n"
        "tenth of the rest with its second half; a small p says that it still drifts. The median\n"
        "speed decides (it is the default --from of the other commands).",
    .examples = "  millpost steady simoloyer-2l.h5\n"
                "  millpost steady simoloyer-2l.h5 -o steady.png",
    .options = option_names,
    .least = 1,
    .most = 1,
};

/* An observable to look at; totals are turned into rates. */
struct indicator {
  const char *name, *label, *unit;
  bool total;
};

static const struct indicator indicators[] = {
    {"median_speed", "median speed", "m/s", false},
    {"mean_speed", "mean speed", "m/s", false},
    {"kinetic_energy", "kinetic energy", "J", false},
    {"collisions", "collisions per second", "1/s", true},
    {"blade_work", "power of the blades", "W", true},
};

enum { INDICATORS = sizeof indicators / sizeof *indicators };

/* Does it vary by no more than rounding? */
static bool is_constant(const double *x, size_t n) {
  static const double ROUNDING = 1e-12;
  double low = INFINITY, high = -INFINITY;
  for (size_t k = 0; k < n; k++) {
    low = fmin(low, x[k]);
    high = fmax(high, x[k]);
  }
  return high - low <= ROUNDING * fabs(high);
}

/* The indicator as one number per sample, in place; returns how many there are. */
static size_t flatten(struct em_trace *trace, const struct indicator *indicator) {
  if (!indicator->total) return trace->width == 1 ? trace->count : 0;
  if (trace->count < 2) return 0;
  const size_t n = trace->count - 1;
  for (size_t k = 0; k < n; k++) {
    const double growth =
        em_trace_sum(trace, k + 1, 0, trace->width) - em_trace_sum(trace, k, 0, trace->width);
    trace->value[k] = growth / (trace->time[k + 1] - trace->time[k]);
  }
  return n;
}

static void columns(struct em_report *report) {
  em_report_begin(report, "indicators", NULL);
  em_report_column(report, "indicator", "indicator", "");
  em_report_column(report, "unit", "unit", "");
  em_report_column(report, "start", "steady from", "s");
  em_report_column(report, "found", "steady", "");
  em_report_column(report, "geweke_z", "Geweke z", "");
  em_report_column(report, "geweke_p", "p", "");
  em_report_column(report, "mean", "mean from there on", "");
  em_report_column(report, "memory", "correlated over", "s");
}

static void row(struct em_report *report, const struct indicator *indicator,
                const struct em_trace *trace, size_t n, double level) {
  static const char *const word[] = {
      [EM_STEADY_NONE] = "no", [EM_STEADY_BRIEF] = "too short", [EM_STEADY_YES] = "yes"};
  const bool constant = is_constant(trace->value, n);
  const struct em_steady steady =
      constant ? (struct em_steady){.start = 0, .found = EM_STEADY_YES, .geweke = NAN, .p = NAN}
               : em_steady_find(trace->value, n);
  const size_t start = steady.start < n ? steady.start : 0;
  const struct em_interval mean =
      constant ? (struct em_interval){.value = trace->value[0], .inefficiency = NAN}
               : em_interval_series(trace->value + start, n - start, level);
  em_report_text(report, "%s", indicator->label);
  em_report_text(report, "%s", indicator->unit);
  em_report_number(report, trace->time[start]);
  em_report_text(report, "%s", word[steady.found]);
  em_report_number(report, steady.geweke);
  em_report_number(report, steady.p);
  em_report_interval(report, &mean);
  em_report_number(report, mean.inefficiency * (trace->time[1] - trace->time[0]));
}

static enum em_status table(struct em_report *report, const struct em_run_file *run,
                            const struct em_window *all, double level, struct em_error *err) {
  columns(report);
  int rows = 0;
  for (int k = 0; k < INDICATORS; k++) {
    struct em_trace trace;
    const enum em_status status = em_trace_read(&trace, run, indicators[k].name, all, err);
    if (status != EM_OK) return status;
    const size_t n = flatten(&trace, &indicators[k]);
    if (n >= 4) row(report, &indicators[k], &trace, n, level);
    rows += n >= 4;
    em_trace_free(&trace);
  }
  if (rows > 0) return EM_OK;
  return em_error_set(err, EM_INPUT, em_run_file_path(run), 0,
                      "too few observables to tell; run longer or with record.observables higher");
}

static enum em_status draw(const struct em_run_file *run, const struct em_window *all,
                           const struct em_window *window, const char *path, struct em_error *err) {
  struct em_trace trace;
  enum em_status status = em_trace_read(&trace, run, "median_speed", all, err);
  if (status != EM_OK) return status;
  char subtitle[256], name[64];
  em_plot_subtitle(em_run_file_scene(run), subtitle, sizeof subtitle);
  snprintf(name, sizeof name, "steady from %.3g s", window->from);
  const struct em_plot_series series = {
      .style = EM_PLOT_LINE, .count = trace.count, .x = trace.time, .y = trace.value};
  const struct em_plot_mark mark = {window->from, false, name};
  const struct em_plot plot = {.title = "Median speed of the balls",
                               .subtitle = subtitle,
                               .x_label = "time  [s]",
                               .y_label = "median speed  [m/s]",
                               .series_count = 1,
                               .series = &series,
                               .mark_count = window->steady ? 1 : 0,
                               .mark = &mark};
  status = em_plot_draw(&plot, path, err);
  em_trace_free(&trace);
  return status;
}

int em_millpost_steady(int argc, char **argv) {
  struct em_millpost_options options;
  const int code = em_millpost_options(&options, &help, argc, argv);
  if (code >= 0) return code;
  struct em_error err = {.code = EM_OK};
  struct em_run_file *run;
  if (em_millpost_open(&run, options.run[0], &err) != EM_OK) return em_millpost_fail(&err);
  struct em_window window = {.from = 0.0}, all;
  struct em_report *report = em_report_new("steady");
  enum em_status status = em_window_find(&window, run, NAN, options.to, &err);
  if (status == EM_OK) {
    all = window;
    all.from = 0.0;
    em_report_fact_text(report, "run", "run", "%s", options.run[0]);
    em_report_fact_text(report, "steady", "steady", "%s", window.steady ? "yes" : "no");
    em_window_report(report, &window);
    status = table(report, run, &all, options.level, &err);
  }
  if (status == EM_OK && options.out) status = draw(run, &all, &window, options.out, &err);
  em_run_file_close(run);
  if (status == EM_OK) return em_millpost_print(report, &options, EM_MILLPOST_DONE);
  em_report_free(report);
  return em_millpost_fail(&err);
}
