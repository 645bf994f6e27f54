/* Finds a ball in a frame's difference to the picture without it. */
#ifndef EM_DRAW_TRACK_DISC_H
#define EM_DRAW_TRACK_DISC_H

#include <stdbool.h>
#include <stdint.h>

/* A frame, width × height. */
struct em_disc_field {
  int width, height;
  const float *difference; /* grey values in red, green and blue, 3 × width × height */
  const float *contrast;   /* size of the smoothed difference, width × height */
  double smoothing;        /* pixels, standard deviation of the Gaussian that smoothed it */
  uint8_t *mark;           /* working space, width × height */
};

struct em_disc {
  double x, y, radius; /* pixels from the middle of the top left one */
  double scatter;      /* pixels, of the edge about the circle */
  double roundness;    /* U²/(4πA) of the outline's convex hull */
};

/* The largest region that is round to within `tolerance` at the lowest level of contrast above the
 * noise at which there is one and its edge is a circle that lies within the picture; false when
 * there is none. */
bool em_track_disc_find(const struct em_disc_field *field, double tolerance, struct em_disc *disc);

#endif
