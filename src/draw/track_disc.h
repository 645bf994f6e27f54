/* Finds a disc in a picture of contrasts. */
#ifndef EM_DRAW_TRACK_DISC_H
#define EM_DRAW_TRACK_DISC_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct em_disc {
  double x, y, radius; /* pixels from the middle of the top left one */
  double scatter;      /* pixels, of the edge about the circle */
  double roundness;    /* U²/(4πA) of the contour */
};

/* The largest bright region that is round to within `tolerance` and does not touch the border;
 * false when there is none. mark: width × height bytes of working space. */
bool em_track_disc_find(const float *contrast, int width, int height, double tolerance,
                        uint8_t *mark, struct em_disc *disc);

#endif
