/* Observables within a window of time, as values or as rates of running totals. */
#ifndef EVENTMILL_TRACE_H
#define EVENTMILL_TRACE_H

#include <stddef.h>

#include "eventmill/interval.h"
#include "eventmill/run_file.h"
#include "tool/window.h"

/* count samples of width numbers; value[k * width + j]. */
struct em_trace {
  size_t count, width;
  double *time; /* s */
  double *value;
};

/* The samples of an observable in the window. A run without it gives count = 0. Errors: EM_MEMORY
 * and those of reading. */
enum em_status em_trace_read(struct em_trace *trace, const struct em_run_file *run,
                             const char *name, const struct em_window *window,
                             struct em_error *err);
void em_trace_free(struct em_trace *trace);

/* Sum over columns [first, end) of sample k. */
double em_trace_sum(const struct em_trace *trace, size_t k, size_t first, size_t end);

/* Growth of that sum from the first sample to the last, per time; NAN for fewer than 2 samples. */
double em_trace_rate(const struct em_trace *trace, size_t first, size_t end);

/* The same with a confidence interval, from the growth between successive samples; there is none
 * where nothing grew. */
struct em_interval em_trace_rate_interval(const struct em_trace *trace, size_t first, size_t end,
                                          double level);

/* The mean of column j over time. */
struct em_interval em_trace_mean(const struct em_trace *trace, size_t j, double level);

#endif
