/* millpost compare: runs side by side, and which differences are more than chance. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "eventmill/plot.h"
#include "tool/figures.h"
#include "tool/millpost.h"

enum { MOST_RUNS = 16, LABEL = 96 };

static const char *const option_names[] = {"from", "to", "above", "level", "output", ""};

static const struct em_millpost_help help = {
    .name = "compare",
    .arguments = "RUN RUN [RUN ...]",
    .summary =
        "Puts the key figures of runs side by side and tells which differences are significant.",
    .details =
        "Each run is held against the first one. A difference counts as significant when its\n"
        "p-value (Welch), times the number of figures, is below 1 - level; intervals respect "
        "correlation\n"
        "in time. Runs go by the names of their files, or by their paths where these are alike. "
        "-o\n"
        "draws the main ones relative to the first run.",
    .examples = "  millpost compare plain.h5 ramps.h5\n"
                "  millpost compare 1000rpm.h5 1300rpm.h5 1700rpm.h5 --above 2 -o compare.png",
    .options = option_names,
    .least = 2,
    .most = MOST_RUNS,
};

/* Is the name of run r that of another run, or a word of the report? */
static bool is_taken(char name[][LABEL], int r, int runs) {
  static const char *const words[] = {"command", "threshold", "level", "figures", "notes",
                                      "units",   "figure",    "key",   "unit"};
  for (size_t k = 0; k < sizeof words / sizeof *words; k++)
    if (strcmp(name[r], words[k]) == 0) return true;
  for (int s = 0; s < runs; s++)
    if (s != r && strcmp(name[s], name[r]) == 0) return true;
  return false;
}

/* Names for keys and headings: that of the file; where it is taken, the end of its path; where that
 * is taken, too, the number of the run behind it. */
static void name_runs(char label[][LABEL], char *const *path, int runs) {
  char name[MOST_RUNS][LABEL];
  for (int r = 0; r < runs; r++)
    em_millpost_label(path[r], name[r], LABEL);
  for (int r = 0; r < runs; r++) {
    const size_t length = strlen(path[r]), most = LABEL - 16;
    const char *end = length > most ? path[r] + length - most : path[r];
    const bool h5 = length > 3 && strcmp(path[r] + length - 3, ".h5") == 0;
    if (is_taken(name, r, runs))
      snprintf(label[r], LABEL, "%.*s", (int)(strlen(end) - (h5 ? 3 : 0)), end);
    else
      strcpy(label[r], name[r]);
  }
  memcpy(name, label, sizeof name);
  for (int r = 0; r < runs; r++)
    if (is_taken(name, r, runs)) snprintf(label[r], LABEL, "%.*s (%d)", LABEL - 16, name[r], r + 1);
}

/* Does any run know this figure, and is it anything but 0? */
static bool is_known(const struct em_figures *f, int runs, int kind) {
  for (int r = 0; r < runs; r++)
    if (isfinite(f[r].value[kind].value) && f[r].value[kind].value != 0.0) return true;
  return false;
}

static int count_known(const struct em_figures *f, int runs) {
  int count = 0;
  for (int k = 0; k < EM_FIGURES_COUNT; k++)
    count += is_known(f, runs, k);
  return count;
}

static void window_fact(struct em_report *report, const char *label, const struct em_figures *f) {
  const struct em_window *w = &f->window, *counted = &f->counted;
  char collisions[128] = "";
  if (counted->from != w->from || counted->to != w->to)
    snprintf(collisions, sizeof collisions,
             "; collisions %g … %g s, in whole blocks of the histograms", counted->from,
             counted->to);
  em_report_fact_text(report, label, label, "%g … %g s (%s)%s", w->from, w->to, w->how, collisions);
}

static void columns(struct em_report *report, char label[][LABEL], int runs) {
  em_report_begin(report, "figures", NULL);
  em_report_column(report, "figure", "figure", "");
  em_report_column(report, "key", "key", "");
  em_report_column(report, "unit", "unit", "");
  em_report_column(report, label[0], label[0], "");
  for (int r = 1; r < runs; r++) {
    char key[LABEL + 32];
    em_report_column(report, label[r], label[r], "");
    snprintf(key, sizeof key, "%s_change", label[r]);
    em_report_column(report, key, "change", "");
    snprintf(key, sizeof key, "%s_p", label[r]);
    em_report_column(report, key, "p", "");
    snprintf(key, sizeof key, "%s_significant", label[r]);
    em_report_column(report, key, "significant", "");
  }
}

static void row(struct em_report *report, const struct em_figures *f, int runs, int kind,
                double limit) {
  const struct em_interval *base = &f[0].value[kind];
  const bool share = kind == EM_FIGURES_SHARE_ABOVE;
  em_report_text(report, "%s", em_figures_words((enum em_figures_kind)kind));
  em_report_text(report, "%s", em_figures_key((enum em_figures_kind)kind));
  em_report_text(report, "%s", em_figures_unit((enum em_figures_kind)kind));
  for (int r = 0; r < runs; r++) {
    const struct em_interval *value = &f[r].value[kind];
    if (share)
      em_report_percent_interval(report, value);
    else
      em_report_interval(report, value);
    if (r == 0) continue;
    const double p = em_interval_difference(base, value);
    em_report_percent(report, base->value != 0.0 ? value->value / base->value - 1.0 : NAN);
    em_report_number(report, p);
    em_report_text(report, "%s", isnan(p) ? "unknown" : p < limit ? "yes" : "no");
  }
}

/* The figures of the diagram, with names short enough to stand side by side. */
static const struct {
  enum em_figures_kind kind;
  const char *name;
} headlines[] = {{EM_FIGURES_MEDIAN_SPEED, "median speed"},
                 {EM_FIGURES_RATE, "collisions / s"},
                 {EM_FIGURES_MEDIAN_VN, "median v_n"},
                 {EM_FIGURES_Q75_VN, "v_n, 75 %"},
                 {EM_FIGURES_SHARE_ABOVE, "share above"},
                 {EM_FIGURES_RATE_ABOVE, "rate above"},
                 {EM_FIGURES_POWER, "power"},
                 {EM_FIGURES_DISSIPATED, "dissipated"}};

enum { HEADLINES = sizeof headlines / sizeof *headlines };

/* One group of points per run, at the place of each figure on the axis. */
static enum em_status draw(const struct em_figures *f, struct em_run_file *const *file,
                           char label[][LABEL], int runs, double threshold, const char *path,
                           struct em_error *err) {
  struct em_plot_series series[MOST_RUNS];
  double x[MOST_RUNS][HEADLINES], y[MOST_RUNS][HEADLINES], half[MOST_RUNS][HEADLINES];
  const char *name[HEADLINES];
  const struct em_scene *scene[MOST_RUNS];
  char subtitle[480], title[96];
  size_t count = 0;
  for (int h = 0; h < HEADLINES; h++) {
    const int k = (int)headlines[h].kind;
    const double base = f[0].value[k].value;
    if (!is_known(f, runs, k) || !(fabs(base) > 0.0)) continue;
    name[count] = headlines[h].name;
    for (int r = 0; r < runs; r++) {
      x[r][count] = (double)count + 0.5 * (r - 0.5 * (runs - 1)) / runs;
      y[r][count] = 100.0 * f[r].value[k].value / base;
      half[r][count] = 100.0 * f[r].value[k].half / fabs(base);
    }
    count++;
  }
  for (int r = 0; r < runs; r++)
    scene[r] = em_run_file_scene(file[r]);
  em_plot_subtitles(scene, (size_t)runs, subtitle, sizeof subtitle);
  snprintf(title, sizeof title, "Key figures relative to the first run; threshold %g m/s",
           threshold);
  for (int r = 0; r < runs; r++)
    series[r] = (struct em_plot_series){.name = label[r],
                                        .style = EM_PLOT_POINTS,
                                        .count = count,
                                        .x = x[r],
                                        .y = y[r],
                                        .error = half[r]};
  const struct em_plot_mark mark = {100.0, true, NULL};
  const struct em_plot plot = {.title = title,
                               .subtitle = subtitle,
                               .y_label = "figure / that of the first run  [%]",
                               .series_count = (size_t)runs,
                               .series = series,
                               .mark_count = 1,
                               .mark = &mark,
                               .category = name,
                               .category_count = count};
  return em_plot_draw(&plot, path, err);
}

int em_millpost_compare(int argc, char **argv) {
  struct em_millpost_options o;
  const int code = em_millpost_options(&o, &help, argc, argv);
  if (code >= 0) return code;
  const double threshold = isnan(o.above) ? 3.0 : o.above;
  struct em_figures figures[MOST_RUNS];
  struct em_run_file *run[MOST_RUNS] = {NULL};
  char label[MOST_RUNS][LABEL];
  struct em_error err = {.code = EM_OK};
  struct em_report *report = em_report_new("compare");
  em_report_fact(report, "threshold", "threshold", threshold, "m/s");
  em_report_fact(report, "level", "level of the intervals", o.level, "");
  enum em_status status = EM_OK;
  name_runs(label, o.run, o.run_count);
  for (int r = 0; r < o.run_count && status == EM_OK; r++) {
    status = em_millpost_open(&run[r], o.run[r], &err);
    if (status == EM_OK)
      status = em_figures_read(&figures[r], run[r], o.from, o.to, threshold, o.level, &err);
    if (status != EM_OK) break;
    window_fact(report, label[r], &figures[r]);
  }
  if (status == EM_OK) {
    const int tests = count_known(figures, o.run_count) * (o.run_count - 1);
    columns(report, label, o.run_count);
    for (int k = 0; k < EM_FIGURES_COUNT; k++)
      if (is_known(figures, o.run_count, k))
        row(report, figures, o.run_count, k, (1.0 - o.level) / (tests > 0 ? tests : 1));
    if (o.out) status = draw(figures, run, label, o.run_count, threshold, o.out, &err);
  }
  for (int r = 0; r < o.run_count; r++)
    em_run_file_close(run[r]);
  if (status == EM_OK) return em_millpost_print(report, &o, EM_MILLPOST_DONE);
  em_report_free(report);
  return em_millpost_fail(&err);
}
