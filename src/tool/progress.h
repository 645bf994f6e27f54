/* Progress on stderr: a bar on a terminal, a line every ten seconds elsewhere. */
#ifndef EVENTMILL_PROGRESS_H
#define EVENTMILL_PROGRESS_H

#include <stdbool.h>

struct em_progress;

struct em_progress_state {
  double fraction; /* of the work of this session that is done, 0 … 1: for the time that is left */
  double whole;    /* of the whole, 0 … 1: for the bar */
  double wall;     /* s since the work began */
};

/* s of the clock on the wall, from any beginning. */
double em_progress_clock(void);

/* quiet: shows nothing. NULL: no memory; all functions take NULL for quiet. */
struct em_progress *em_progress_new(bool quiet);
/* Shows where the work stands, when it is time to. text: a few words, no line break. */
void em_progress_show(struct em_progress *progress, const struct em_progress_state *state,
                      const char *text);
/* Clears the bar and frees. */
void em_progress_end(struct em_progress *progress);

#endif
