/* Restitution from film: a ball that is shot at a plate, frame by frame (Reichardt 2005, 7.2).
 *
 * From each frame the picture without the ball is taken off (the median of all frames, scaled to
 * the frame's own brightness), so the camera has to stand still and every place has to be free of
 * the ball in more than half of the frames. The difference is smoothed and cut at a level above its
 * noise; the largest region that is a disc, U²/A ≈ 4π (7-1), is the ball. Its centre and radius are
 * those of the circle through its edge, found on the unsmoothed difference, whatever side the ball
 * is lit from. A parabola before and one after the impact, of the same curvature, give both speeds
 * at the moment where they meet. */
#ifndef EVENTMILL_TRACK_H
#define EVENTMILL_TRACK_H

#include <stdbool.h>
#include <stddef.h>

#include "eventmill/error.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Where the plate is in the picture. */
#define EM_TRACK_PLATE_LIST(X)                                                                   \
  X(AUTO, "auto") /* across the axis of the picture that is nearest to the change of velocity */ \
  X(LEFT, "left")                                                                                \
  X(RIGHT, "right")                                                                              \
  X(TOP, "top")                                                                                  \
  X(BOTTOM, "bottom")
#define EM_TRACK_ENUM(code, text) EM_TRACK_##code,
enum em_track_plate { EM_TRACK_PLATE_LIST(EM_TRACK_ENUM) EM_TRACK_PLATES };
#undef EM_TRACK_ENUM

/* Pixels, of the filter's Gaussian. */
#define EM_TRACK_SHARPEST  0.5
#define EM_TRACK_SMOOTHEST 3.0

struct em_track_options {
  double fps;       /* frames per second */
  double scale;     /* m per pixel; 0: from the diameter */
  double diameter;  /* m, of the ball; used when scale is 0 */
  double roundness; /* how far U²/(4πA) may be from 1. 0: 0.15 */
  double smoothing; /* pixels, standard deviation of the filter, within the above. 0: 1.0 */
  enum em_track_plate plate;
};

/* The ball in one frame. */
struct em_track_spot {
  size_t frame;           /* number within the folder, from 0 */
  double x, y;            /* pixels from the middle of the top left one; y downwards */
  double radius, scatter; /* pixels; scatter: of the edge about the circle */
  double roundness;       /* U²/(4πA): 1 for a disc */
};

/* A value and its standard error; that of a speed includes the scale's. */
struct em_track_value {
  double value, error;
};

struct em_track {
  size_t frames, width, height;
  size_t count; /* frames in which a ball was found */
  size_t lost;  /* frames between the first and the last of these in which it was not */
  struct em_track_spot *spot;
  struct em_track_value scale;                         /* m per pixel; error 0: as given */
  struct em_track_value radius;                        /* pixels, median */
  enum em_track_plate plate;                           /* as found */
  size_t before, after;                                /* spots on either side of the impact */
  struct em_track_value approach, departure;           /* m/s, along the normal, both ≥ 0 */
  struct em_track_value tangent_before, tangent_after; /* m/s, along the plate */
  struct em_track_value restitution;
  double gravity; /* m/s², along the normal, towards the plate positive */
  double sigma;   /* pixels, scatter of the centres about the curves */
  double impact;  /* s after the first frame */
};

const char *em_track_plate_name(enum em_track_plate plate);
int em_track_plate_find(const char *name); /* -1: no such side */

/* Analyses the PNG files of a folder, in the order of their names. *track is the caller's. Errors:
 * EM_FILE, EM_INPUT (options; frames of different sizes; fewer than three frames with a ball before
 * or after the impact; more frames lost about the impact than seen on a side of it; centres that
 * are on no two parabolas; no impact, or a restitution above 1.5), EM_MEMORY, EM_NUMERIC. */
enum em_status em_track_folder(struct em_track **track, const char *folder,
                               const struct em_track_options *options, struct em_error *err);
void em_track_free(struct em_track *track);

#ifdef __cplusplus
}
#endif

#endif
