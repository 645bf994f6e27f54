/* Windows of time: from where a run is steady, or from where the user says. */
#include <math.h>
#include <stdio.h>

#include "eventmill/steady.h"
#include "tool/window.h"

/* Shortest series from which a steady start is told. */
enum { LEAST_VALUES = 20 };

/* The source's 0.2 s (13.2), or half the run when that is shorter. */
static void rule_of_thumb(struct em_window *window, const char *why) {
  window->from = fmin(0.2, 0.5 * window->to);
  snprintf(window->how, sizeof window->how, "%s: 0.2 s, or half of a shorter run", why);
}

static enum em_status find_steady(struct em_window *window, const struct em_run_file *run,
                                  struct em_error *err) {
  if (!em_run_file_has(run, "median_speed")) {
    rule_of_thumb(window, "no observables");
    return EM_OK;
  }
  struct em_series *series;
  const enum em_status status = em_run_file_series(run, "median_speed", &series, err);
  if (status != EM_OK) return status;
  size_t count = series->count;
  while (count > 0 && series->time[count - 1] > window->to)
    count--;
  if (count < LEAST_VALUES) {
    rule_of_thumb(window, "too few observables");
  } else {
    const struct em_steady steady = em_steady_find(series->value, count);
    window->geweke_p = steady.p;
    window->steady = steady.found == EM_STEADY_YES;
    if (window->steady) {
      window->from = series->time[steady.start];
      snprintf(window->how, sizeof window->how, "steady start by MSER on the median speed");
    } else {
      rule_of_thumb(window, steady.found == EM_STEADY_BRIEF
                                ? "too short to tell whether it is steady"
                                : "no steady state found");
    }
  }
  em_run_file_series_free(series);
  return EM_OK;
}

enum em_status em_window_find(struct em_window *window, const struct em_run_file *run, double from,
                              double to, struct em_error *err) {
  const double end = em_run_file_state(run)->time;
  *window = (struct em_window){.geweke_p = NAN, .how = "as given"};
  window->to = isnan(to) || to > end ? end : to;
  window->closed = window->to == end;
  window->automatic = isnan(from);
  if (window->automatic) {
    const enum em_status status = find_steady(window, run, err);
    if (status != EM_OK) return status;
  } else {
    window->from = from;
  }
  if (window->from >= 0.0 && window->from < window->to) return EM_OK;
  return em_error_set(err, EM_INPUT, em_run_file_path(run), 0,
                      "nothing between %g s and %g s, the run has 0 to %g s", window->from,
                      window->to, end);
}

bool em_window_has(const struct em_window *window, double time) {
  return time >= window->from && (time < window->to || (window->closed && time == window->to));
}

void em_window_report(struct em_report *report, const struct em_window *window) {
  em_report_fact(report, "from", "from", window->from, "s");
  em_report_fact(report, "to", "to", window->to, "s");
  em_report_fact_text(report, "from_how", "begin chosen", "%s", window->how);
  if (isfinite(window->geweke_p))
    em_report_fact(report, "geweke_p", "Geweke's test of it, p", window->geweke_p, "");
}
