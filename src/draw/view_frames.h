/* The frames of a run as a browser's player wants them. */
#ifndef EM_DRAW_VIEW_FRAMES_H
#define EM_DRAW_VIEW_FRAMES_H

#include <stdint.h>

#include "eventmill/motion.h"
#include "eventmill/view.h"

/* For each frame and chosen ball: 3 × 16 bits of position, and after all of them 3 × 16 bits of
 * velocity; little-endian. */
enum { EM_VIEW_BALL_BYTES = 12, EM_VIEW_SPIN_BYTES = 2 };

struct em_view_frames {
  size_t count, wanted, balls, total; /* frames; chosen balls, balls of the run */
  double *time;                       /* s */
  double *scale, *spin_scale;         /* m/s and rad/s per unit */
  size_t *chosen;                     /* indices of balls */
  uint8_t *bytes;                     /* count × balls × EM_VIEW_BALL_BYTES */
  uint8_t *spins;                     /* count × balls × 16 bits; NULL: balls do not spin */
  uint8_t *classes;                   /* count × balls: enum em_class of the last contact or
                                         EM_CLASS_COUNT; NULL: not known */
};

/* Fills all zero `frames`; to be cleared in every case. */
enum em_status em_view_frames_fill(struct em_view_frames *frames, const struct em_run_file *run,
                                   struct em_motion *motion, const struct em_view_options *options,
                                   struct em_error *err);
void em_view_frames_clear(struct em_view_frames *frames);

#endif
