/* From where a scene is seen: direction, lens, and the matrices that follow from them. */
#ifndef EVENTMILL_CAMERA_H
#define EVENTMILL_CAMERA_H

#include <stdbool.h>
#include <stddef.h>

#include "eventmill/vec.h"

#ifdef __cplusplus
extern "C" {
#endif

#define EM_CAMERA_LIST(X)                                                 \
  X(AXIAL, "axial")                 /* along the axis, +y away from us */ \
  X(SIDE, "side")                   /* from +x; +y to the right */        \
  X(THREE_QUARTER, "three-quarter") /* between the two, from above */
#define EM_CAMERA_ENUM(code, text) EM_CAMERA_##code,
enum em_camera_view { EM_CAMERA_LIST(EM_CAMERA_ENUM) EM_CAMERA_VIEWS };
#undef EM_CAMERA_ENUM

struct em_camera {
  double azimuth;                  /* rad about +z; 0: axial, π/2: side */
  double elevation;                /* rad above the horizon, within ±π/2 */
  double fov;                      /* rad, height of the field of view; 0: parallel projection */
  double zoom;                     /* 1: the scene just fits */
  double left, right, top, bottom; /* shares of the picture to keep free at its sides */
  bool orbits;                     /* keep the distance that fits from every azimuth */
};

/* Where points go. Matrices are column by column, as OpenGL wants them. */
struct em_camera_aim {
  float view[16];       /* scene (m) to eye (m): x right, y up, z towards us */
  float projection[16]; /* eye to clip space */
  int width, height;    /* pixels */
  bool parallel;
};

const char *em_camera_name(enum em_camera_view view);
int em_camera_find(const char *name); /* -1: no such view */

/* A camera of field of view 28°, with nothing kept free. */
struct em_camera em_camera_make(enum em_camera_view view);

/* Aims at the box [low, high] so that the given points of it (count ≥ 1, m) fit the picture. */
void em_camera_aim(const struct em_camera *camera, struct em_vec low, struct em_vec high,
                   const struct em_vec *point, size_t count, int width, int height,
                   struct em_camera_aim *aim);

#ifdef __cplusplus
}
#endif

#endif
