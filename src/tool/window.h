/* Windows of time in which a run is looked at. */
#ifndef EVENTMILL_WINDOW_H
#define EVENTMILL_WINDOW_H

#include <stdbool.h>

#include "eventmill/error.h"
#include "eventmill/run_file.h"
#include "tool/report.h"

/* A stretch of time, and in words where its begin comes from. */
struct em_window {
  double from, to; /* s */
  bool closed;     /* `to` is the end of the run: contacts at that time are in the window */
  bool automatic;  /* `from` was found, not given */
  bool steady;     /* the run was found to be stationary from there on */
  double geweke_p; /* NAN: not tested */
  char how[160];
};

/* From `from` (NAN: steady start) to `to` (NAN: end of the run). Errors: EM_INPUT for an empty
 * window, and those of reading. */
enum em_status em_window_find(struct em_window *window, const struct em_run_file *run, double from,
                              double to, struct em_error *err);

/* Is a contact at this time in the window? At `to` it belongs to what follows, if anything does. */
bool em_window_has(const struct em_window *window, double time);

/* Adds the window's facts to a report. */
void em_window_report(struct em_report *report, const struct em_window *window);

#endif
