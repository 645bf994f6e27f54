/* A run as one HTML file that plays it in a browser: turn, zoom, scrub, filter, follow balls. The
 * file needs nothing else, no network and no server.
 *
 * Positions are stored with 16 bits per coordinate of the chamber's box, velocities with 16 bits of
 * each frame's largest component; the page moves balls between frames on the same curves as
 * em_motion does for runs without a collision table. Blades turn by their exact angles. */
#ifndef EVENTMILL_VIEW_H
#define EVENTMILL_VIEW_H

#include <stdbool.h>
#include <stddef.h>

#include "eventmill/error.h"
#include "eventmill/run_file.h"

#ifdef __cplusplus
extern "C" {
#endif

struct em_view_options {
  double from, to;  /* s; NAN: the first, the last frame */
  double step;      /* s between frames; NAN: the stored frames or, with a collision table, from
                       which positions at all times are exact, 1 ms */
  size_t balls;     /* no more than so many, evenly chosen; 0: all */
  size_t largest;   /* bytes that the frames may take in the file; 0: 48 MiB */
  double low, high; /* m/s, ends of the colour scale; NAN: 0, em_picture_scale */
  bool dark;
};

/* What was written. */
struct em_view_report {
  size_t frames, balls, bytes; /* bytes: 0 when a pipe was written to */
  double first, last;          /* s */
  size_t wanted;               /* frames there would have been without the limit of size */
};

/* Writes the file, complete or not at all. report may be NULL. Errors: EM_INPUT (no frames, an
 * empty window), EM_MEMORY, EM_FILE, those of the run file. */
enum em_status em_view_write(const struct em_run_file *run, const struct em_view_options *options,
                             const char *path, struct em_view_report *report, struct em_error *err);

#ifdef __cplusplus
}
#endif

#endif
