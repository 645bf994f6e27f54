/* Progress on stderr: a bar on a terminal, a line every ten seconds elsewhere. */
#include "tool/progress.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <time.h>
#include <unistd.h>

enum { BAR = 12 };
static const double BAR_EVERY = 0.2, LINE_EVERY = 10.0; /* s */

struct em_progress {
  bool terminal, drawn;
  double next; /* s, wall clock */
};

double em_progress_clock(void) {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

struct em_progress *em_progress_new(bool quiet) {
  struct em_progress *progress = quiet ? NULL : calloc(1, sizeof *progress);
  if (!progress) return NULL;
  progress->terminal = isatty(STDERR_FILENO);
  progress->next = em_progress_clock() + (progress->terminal ? BAR_EVERY : LINE_EVERY);
  return progress;
}

/* Seconds as 12:34 or 1:02:03; "--:--" when unknown. */
static void duration(double seconds, char *text, size_t size) {
  if (!(seconds >= 0.0) || seconds > 3.6e7)
    snprintf(text, size, "--:--");
  else if (seconds < 3600.0)
    snprintf(text, size, "%02d:%02d", (int)seconds / 60, (int)seconds % 60);
  else
    snprintf(text, size, "%d:%02d:%02d", (int)seconds / 3600, (int)seconds / 60 % 60,
             (int)seconds % 60);
}

static int columns(void) {
  struct winsize size;
  return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 20 ? size.ws_col : 80;
}

static void draw_bar(double whole, const char *left, const char *text) {
  char bar[BAR + 1], line[512];
  const int filled = (int)(fmin(fmax(whole, 0.0), 1.0) * BAR);
  memset(bar, '.', BAR);
  memset(bar, '#', (size_t)filled);
  bar[BAR] = '\0';
  snprintf(line, sizeof line, "[%s] %3.0f %%  ETA %s  %s", bar, 100.0 * whole, left, text);
  fprintf(stderr, "\r\033[K%.*s", columns() - 1, line);
  fflush(stderr);
}

void em_progress_show(struct em_progress *progress, const struct em_progress_state *state,
                      const char *text) {
  const double now = progress ? em_progress_clock() : 0.0;
  if (!progress || now < progress->next) return;
  progress->next = now + (progress->terminal ? BAR_EVERY : LINE_EVERY);
  char left[32];
  const double f = state->fraction;
  duration(f > 0.0 ? state->wall * (1.0 - f) / f : -1.0, left, sizeof left);
  if (progress->terminal)
    draw_bar(state->whole, left, text);
  else
    fprintf(stderr, "%3.0f %%  ETA %s  %s\n", 100.0 * state->whole, left, text);
  progress->drawn = progress->terminal;
}

void em_progress_end(struct em_progress *progress) {
  if (progress && progress->drawn) fprintf(stderr, "\r\033[K");
  free(progress);
}
