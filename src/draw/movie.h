/* A film file that is being written by ffmpeg. */
#ifndef EM_DRAW_MOVIE_H
#define EM_DRAW_MOVIE_H

#include <stdbool.h>
#include <stdint.h>

#include "draw/child.h"
#include "eventmill/error.h"
#include "record/output.h"

struct em_movie {
  struct em_child child;
  struct em_output output;
  size_t frame_size;
};

/* Begins a film of width × height (even) pixels. quality: x264's constant rate factor. */
enum em_status em_movie_begin(struct em_movie *movie, const char *path, int width, int height,
                              double fps, int quality, struct em_error *err);

/* Adds a frame: R, G, B, A, the top row first. */
enum em_status em_movie_add(struct em_movie *movie, const uint8_t *rgba, struct em_error *err);

/* Ends the film; without `keep`, or on failure, nothing is left of it. */
enum em_status em_movie_end(struct em_movie *movie, bool keep, struct em_error *err);

#endif
