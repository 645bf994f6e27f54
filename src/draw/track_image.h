/* Frames of a film, red, green and blue byte by byte, and what is new in one of them. */
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

/* Reads frame k; rgb: 3 × width × height. Errors: EM_FILE, EM_INPUT (another size). */
enum em_status em_track_image_read(const struct em_film_strip *strip, size_t k, uint8_t *rgb,
                                   struct em_error *err);

/* The median of the frames at each pixel (at most 41 of them): the picture without the ball. */
enum em_status em_track_image_ground(const struct em_film_strip *strip, uint8_t *ground,
                                     struct em_error *err);

/* frame − gain · ground, in grey values of each colour; gain: the median ratio of both, so that
 * flicker and uneven light cancel. */
void em_track_image_difference(const uint8_t *rgb, const uint8_t *ground, size_t pixels,
                               float *difference);

/* Root mean square over the colours of the difference, smoothed before by a Gaussian, in the first
 * width × height of `contrast`; it and `work` are as large as the difference. */
void em_track_image_contrast(const float *difference, int width, int height, double smoothing,
                             float *contrast, float *work);

#endif
