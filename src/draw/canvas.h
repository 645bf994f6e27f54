/* A place in memory to draw on with OpenGL, without a window. All that is known of OSMesa is behind
 * these five functions. */
#ifndef EM_DRAW_CANVAS_H
#define EM_DRAW_CANVAS_H

#include <stdint.h>

#include "eventmill/error.h"

struct em_canvas;
struct em_gl; /* the OpenGL functions; see gl.h */

/* What draws: GL_RENDERER, GL_VERSION. */
struct em_canvas_size {
  int width, height; /* pixels */
  const char *renderer, *version;
};

enum { EM_CANVAS_LARGEST = 16384 };

/* Makes a canvas of 1 … EM_CANVAS_LARGEST pixels each way, with 24 bits of depth and an OpenGL core
 * profile ≥ 3.3. Errors: EM_INPUT (size), EM_MEMORY, EM_PICTURE (no such OpenGL here). */
enum em_status em_canvas_new(struct em_canvas **canvas, int width, int height,
                             struct em_error *err);

/* Makes the canvas current in this thread; all drawing goes to it from now on. Returns the OpenGL
 * functions, or NULL (err: EM_PICTURE). */
const struct em_gl *em_canvas_current(struct em_canvas *canvas, struct em_error *err);

/* Finishes all drawing and returns the pixels: bytes B, G, R, A (cairo's RGB24 on a little-endian
 * machine), the top row first. They belong to the canvas and hold until it is drawn on again. */
uint8_t *em_canvas_read(struct em_canvas *canvas);

struct em_canvas_size em_canvas_size(const struct em_canvas *canvas);

void em_canvas_free(struct em_canvas *canvas);

#endif
