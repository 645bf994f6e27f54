/* Where a picture is drawn before it is smoothed: four samples per pixel, premultiplied alpha. */
#ifndef EM_DRAW_TARGET_H
#define EM_DRAW_TARGET_H

#include "draw/gl.h"
#include "eventmill/error.h"

struct em_target {
  GLuint frame, colour, depth;
  int width, height, samples;
};

enum em_status em_target_make(struct em_target *target, const struct em_gl *gl, int width,
                              int height, struct em_error *err);

/* Begins an empty, transparent picture. */
void em_target_begin(const struct em_target *target, const struct em_gl *gl);

/* Averages the samples into the canvas. */
void em_target_end(const struct em_target *target, const struct em_gl *gl);

void em_target_clear(struct em_target *target, const struct em_gl *gl);

#endif
