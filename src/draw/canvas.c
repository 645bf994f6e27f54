/* The canvas over OSMesa: a software OpenGL that draws into our own memory. */
#include "draw/canvas.h"

#include "draw/gl.h" /* before osmesa.h, whose gl.h hides some of the types */

#include <GL/osmesa.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

struct em_canvas {
  OSMesaContext context;
  struct em_gl gl;
  int width, height;
  uint8_t *pixel;
};

static bool load(struct em_gl *gl) {
#define LOAD(type, name)                                       \
  {                                                            \
    const OSMESAproc found = OSMesaGetProcAddress("gl" #name); \
    if (found == NULL) return false;                           \
    memcpy(&gl->name, &found, sizeof found);                   \
  }
  EM_GL_LIST(LOAD)
#undef LOAD
  return true;
}

const struct em_gl *em_canvas_current(struct em_canvas *canvas, struct em_error *err) {
  if (OSMesaMakeCurrent(canvas->context, canvas->pixel, GL_UNSIGNED_BYTE, canvas->width,
                        canvas->height)) {
    OSMesaPixelStore(OSMESA_Y_UP, 0);
    return &canvas->gl;
  }
  em_error_set(err, EM_PICTURE, NULL, 0, "OSMesa cannot draw on %d x %d pixels", canvas->width,
               canvas->height);
  return NULL;
}

enum em_status em_canvas_new(struct em_canvas **canvas, int width, int height,
                             struct em_error *err) {
  static const int wanted[] = {OSMESA_FORMAT,
                               OSMESA_BGRA,
                               OSMESA_DEPTH_BITS,
                               24,
                               OSMESA_PROFILE,
                               OSMESA_CORE_PROFILE,
                               OSMESA_CONTEXT_MAJOR_VERSION,
                               3,
                               OSMESA_CONTEXT_MINOR_VERSION,
                               3,
                               0};
  *canvas = NULL;
  if (width < 1 || height < 1 || width > EM_CANVAS_LARGEST || height > EM_CANVAS_LARGEST)
    return em_error_set(err, EM_INPUT, NULL, 0, "a picture of %d x %d pixels; 1 to %d are possible",
                        width, height, EM_CANVAS_LARGEST);
  struct em_canvas *made = calloc(1, sizeof *made);
  if (made == NULL) return em_error_set(err, EM_MEMORY, NULL, 0, "no memory for a canvas");
  made->width = width;
  made->height = height;
  made->pixel = calloc((size_t)width * (size_t)height, 4);
  if (made->pixel == NULL) {
    em_canvas_free(made);
    return em_error_set(err, EM_MEMORY, NULL, 0, "no memory for %d x %d pixels", width, height);
  }
  made->context = OSMesaCreateContextAttribs(wanted, NULL);
  if (made->context == NULL) {
    em_canvas_free(made);
    return em_error_set(err, EM_PICTURE, NULL, 0, "OSMesa offers no OpenGL 3.3 core profile");
  }
  if (em_canvas_current(made, err) == NULL || !load(&made->gl)) {
    em_canvas_free(made);
    return em_error_set(err, EM_PICTURE, NULL, 0, "OSMesa lacks functions of OpenGL 3.3");
  }
  *canvas = made;
  return EM_OK;
}

uint8_t *em_canvas_read(struct em_canvas *canvas) {
  canvas->gl.Finish();
  return canvas->pixel;
}

struct em_canvas_size em_canvas_size(const struct em_canvas *canvas) {
  return (struct em_canvas_size){
      .width = canvas->width,
      .height = canvas->height,
      .renderer = (const char *)canvas->gl.GetString(GL_RENDERER),
      .version = (const char *)canvas->gl.GetString(GL_VERSION),
  };
}

void em_canvas_free(struct em_canvas *canvas) {
  if (canvas == NULL) return;
  if (canvas->context != NULL) OSMesaDestroyContext(canvas->context);
  free(canvas->pixel);
  free(canvas);
}
