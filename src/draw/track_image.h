/* Frames of a film as grey pictures, and what is new in one of them. */
#ifndef EM_DRAW_TRACK_IMAGE_H
#define EM_DRAW_TRACK_IMAGE_H

#include <stddef.h>
#include <stdint.h>

#include "eventmill/error.h"

/* The PNG files of a folder, by name. */
struct em_film_strip {
  size_t count;
  char **path;
  int width, height; /* pixels, of all frames */
};

enum em_status em_track_image_list(struct em_film_strip *strip, const char *folder,
                                   struct em_error *err);
void em_track_image_clear(struct em_film_strip *strip);

/* Reads frame k; grey: width × height. Errors: EM_FILE, EM_INPUT (another size). */
enum em_status em_track_image_read(const struct em_film_strip *strip, size_t k, uint8_t *grey,
                                   struct em_error *err);

/* The median of the frames at each pixel (at most 101 of them): the picture without the ball. */
enum em_status em_track_image_ground(const struct em_film_strip *strip, uint8_t *ground,
                                     struct em_error *err);

/* |1 − frame/(gain · ground)| of the side, dark or bright, that stands out, smoothed by a Gaussian;
 * gain: the median ratio of both, so that flicker and uneven light cancel. work: as large as out.
 */
void em_track_image_contrast(const uint8_t *grey, const uint8_t *ground, int width, int height,
                             double smoothing, float *out, float *work);

#endif
