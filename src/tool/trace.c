/* Observables within a window of time. */
#include "tool/trace.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum em_status em_trace_read(struct em_trace *trace, const struct em_run_file *run,
                             const char *name, const struct em_window *window,
                             struct em_error *err) {
  memset(trace, 0, sizeof *trace);
  if (!em_run_file_has(run, name)) return EM_OK;
  struct em_series *series;
  const enum em_status status = em_run_file_series(run, name, &series, err);
  if (status != EM_OK) return status;
  const double slack = 1e-9 * (window->to - window->from);
  size_t first = 0, end = series->count;
  while (first < end && series->time[first] < window->from - slack)
    first++;
  while (end > first && series->time[end - 1] > window->to + slack)
    end--;
  const size_t cells = (end - first) * series->width;
  trace->time = malloc((end - first + 1) * sizeof *trace->time);
  trace->value = malloc((cells + 1) * sizeof *trace->value);
  if (trace->time && trace->value && end > first) {
    trace->count = end - first;
    trace->width = series->width;
    memcpy(trace->time, series->time + first, trace->count * sizeof *trace->time);
    memcpy(trace->value, series->value + first * series->width, cells * sizeof *trace->value);
  }
  const bool good = trace->time && trace->value;
  em_run_file_series_free(series);
  if (good) return EM_OK;
  em_trace_free(trace);
  return em_error_set(err, EM_MEMORY, NULL, 0, "out of memory");
}

void em_trace_free(struct em_trace *trace) {
  free(trace->time);
  free(trace->value);
  memset(trace, 0, sizeof *trace);
}

double em_trace_sum(const struct em_trace *trace, size_t k, size_t first, size_t end) {
  double sum = 0.0;
  for (size_t j = first; j < end && j < trace->width; j++)
    sum += trace->value[k * trace->width + j];
  return sum;
}

double em_trace_rate(const struct em_trace *trace, size_t first, size_t end) {
  if (trace->count < 2) return NAN;
  const size_t last = trace->count - 1;
  return (em_trace_sum(trace, last, first, end) - em_trace_sum(trace, 0, first, end)) /
         (trace->time[last] - trace->time[0]);
}

static struct em_interval of_series(double *x, size_t n, double level) {
  struct em_interval out = {NAN, NAN, NAN, 0.0, 1.0};
  if (x && n > 0) out = em_interval_series(x, n, level);
  free(x);
  return out;
}

struct em_interval em_trace_rate_interval(const struct em_trace *trace, size_t first, size_t end,
                                          double level) {
  if (trace->count < 2) return of_series(NULL, 0, level);
  const size_t n = trace->count - 1;
  double *rate = malloc(n * sizeof *rate);
  for (size_t k = 0; rate && k < n; k++)
    rate[k] = (em_trace_sum(trace, k + 1, first, end) - em_trace_sum(trace, k, first, end)) /
              (trace->time[k + 1] - trace->time[k]);
  struct em_interval out = of_series(rate, n, level);
  out.value = em_trace_rate(trace, first, end);
  if (out.value == 0.0) out.half = out.error = NAN; /* nothing was seen */
  return out;
}

struct em_interval em_trace_mean(const struct em_trace *trace, size_t j, double level) {
  double *x = trace->count > 0 ? malloc(trace->count * sizeof *x) : NULL;
  for (size_t k = 0; x && k < trace->count; k++)
    x[k] = trace->value[k * trace->width + j];
  return of_series(x, trace->count, level);
}
