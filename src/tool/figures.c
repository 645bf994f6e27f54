/* The key figures of a run. */
#include "tool/figures.h"

#include <math.h>

#include "tool/gather.h"
#include "tool/trace.h"

#define KEY(code, key, words, unit)   key,
#define WORDS(code, key, words, unit) words,
#define UNIT(code, key, words, unit)  unit,
static const char *const keys[] = {EM_FIGURES_LIST(KEY)};
static const char *const all_words[] = {EM_FIGURES_LIST(WORDS)};
static const char *const units[] = {EM_FIGURES_LIST(UNIT)};

const char *em_figures_key(enum em_figures_kind kind) {
  return keys[kind];
}

const char *em_figures_words(enum em_figures_kind kind) {
  return all_words[kind];
}

const char *em_figures_unit(enum em_figures_kind kind) {
  return units[kind];
}

const struct em_window *em_figures_window(const struct em_figures *figures,
                                          enum em_figures_kind kind) {
  const bool counted = kind >= EM_FIGURES_RATE && kind <= EM_FIGURES_RATE_ABOVE;
  return counted ? &figures->counted : &figures->window;
}

/* Figures that are means over time, or rates of totals, of one observable. */
static enum em_status from_observables(struct em_figures *f, const struct em_run_file *run,
                                       double level, struct em_error *err) {
  const struct {
    enum em_figures_kind kind;
    const char *name;
    bool total;
  } list[] = {{EM_FIGURES_MEDIAN_SPEED, "median_speed", false},
              {EM_FIGURES_MEAN_SPEED, "mean_speed", false},
              {EM_FIGURES_POWER, "blade_work", true},
              {EM_FIGURES_DISSIPATED, "dissipated_energy", true},
              {EM_FIGURES_IMPACT, "collision_energy", true}};
  for (size_t k = 0; k < sizeof list / sizeof *list; k++) {
    struct em_trace trace;
    const enum em_status status = em_trace_read(&trace, run, list[k].name, &f->window, err);
    if (status != EM_OK) return status;
    if (trace.count > 0)
      f->value[list[k].kind] = list[k].total ? em_trace_rate_interval(&trace, 0, trace.width, level)
                                             : em_trace_mean(&trace, 0, level);
    em_trace_free(&trace);
  }
  return EM_OK;
}

static enum em_status from_collisions(struct em_figures *f, const struct em_run_file *run,
                                      double threshold, double level, struct em_error *err) {
  if (!em_run_file_has_rows(run) && em_run_file_block_count(run) == 0) return EM_OK;
  const struct {
    enum em_figures_kind kind;
    int row;
    enum em_gather_figure figure;
    double parameter;
  } list[] = {{EM_FIGURES_RATE, EM_GATHER_ALL, EM_GATHER_RATE, 0.0},
              {EM_FIGURES_RATE_BALL, EM_CLASS_BALL, EM_GATHER_RATE, 0.0},
              {EM_FIGURES_RATE_DRUM, EM_CLASS_DRUM, EM_GATHER_RATE, 0.0},
              {EM_FIGURES_RATE_END, EM_CLASS_END, EM_GATHER_RATE, 0.0},
              {EM_FIGURES_RATE_BLADE, EM_CLASS_BLADE, EM_GATHER_RATE, 0.0},
              {EM_FIGURES_MODE_VN, EM_GATHER_ALL, EM_GATHER_MODE, 0.0},
              {EM_FIGURES_MEDIAN_VN, EM_GATHER_ALL, EM_GATHER_QUANTILE, 0.5},
              {EM_FIGURES_MEDIAN_VN_BALL, EM_CLASS_BALL, EM_GATHER_QUANTILE, 0.5},
              {EM_FIGURES_Q75_VN, EM_GATHER_ALL, EM_GATHER_QUANTILE, 0.75},
              {EM_FIGURES_SHARE_ABOVE, EM_GATHER_ALL, EM_GATHER_SHARE_ABOVE, threshold},
              {EM_FIGURES_RATE_ABOVE, EM_GATHER_ALL, EM_GATHER_RATE_ABOVE, threshold}};
  struct em_gather *gather;
  const enum em_status status = em_gather_new(&gather, run, EM_GATHER_VN, 0, &f->window, err);
  if (status != EM_OK) return status;
  f->counted = em_gather_window(gather, &f->window);
  for (size_t k = 0; k < sizeof list / sizeof *list; k++)
    f->value[list[k].kind] =
        em_gather_interval(gather, list[k].row, list[k].figure, list[k].parameter, level);
  em_gather_free(gather);
  return EM_OK;
}

enum em_status em_figures_read(struct em_figures *figures, const struct em_run_file *run,
                               double from, double to, double threshold, double level,
                               struct em_error *err) {
  for (int k = 0; k < EM_FIGURES_COUNT; k++)
    figures->value[k] = (struct em_interval){NAN, NAN, NAN, 0.0, 1.0};
  enum em_status status = em_window_find(&figures->window, run, from, to, err);
  figures->counted = figures->window;
  if (status == EM_OK) status = from_observables(figures, run, level, err);
  if (status == EM_OK) status = from_collisions(figures, run, threshold, level, err);
  return status;
}
