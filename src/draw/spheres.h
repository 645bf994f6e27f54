/* Spheres without polygons: each fragment of a bounding square casts its own ray. */
#ifndef EM_DRAW_SPHERES_H
#define EM_DRAW_SPHERES_H

#include "draw/gl.h"
#include "draw/occlusion.h"
#include "eventmill/camera.h"
#include "eventmill/error.h"

struct em_spheres {
  GLuint program, array, buffer;
  GLint view, projection, parallel, pixel;
};

enum em_status em_spheres_make(struct em_spheres *spheres, const struct em_gl *gl,
                               struct em_error *err);

/* Draws spheres, which must come farthest first; those with an alpha of 0 as discs
 * with a white rim. */
void em_spheres_draw(const struct em_spheres *spheres, const struct em_gl *gl,
                     const struct em_camera_aim *aim, const struct em_sphere *sphere, size_t count);
void em_spheres_clear(struct em_spheres *spheres, const struct em_gl *gl);

#endif
