/* The machine: chamber, end rings, shafts, blades. */
#ifndef EM_DRAW_SOLIDS_H
#define EM_DRAW_SOLIDS_H

#include "draw/gl.h"
#include "eventmill/camera.h"
#include "eventmill/error.h"
#include "eventmill/scene.h"

struct em_part; /* a stretch of vertices of one material */

struct em_solids {
  GLuint program, array, buffer;
  GLint model, view, projection, parallel, colour, glass;
  size_t part_count;
  struct em_part *part;
};

enum em_status em_solids_make(struct em_solids *solids, const struct em_gl *gl,
                              const struct em_scene *scene, bool rotor, bool chamber,
                              struct em_error *err);

/* What hides: metal. blade_angle: rad, one per blade. */
void em_solids_draw_metal(const struct em_solids *solids, const struct em_gl *gl,
                          const struct em_camera_aim *aim, const double *blade_angle);

/* What veils: the glass of the chamber; to be drawn last. */
void em_solids_draw_glass(const struct em_solids *solids, const struct em_gl *gl,
                          const struct em_camera_aim *aim);

/* Points that a picture of the scene must show: at most EM_SOLIDS_OUTLINE of them. */
enum { EM_SOLIDS_OUTLINE = 96 };
size_t em_solids_outline(const struct em_scene *scene, struct em_vec point[EM_SOLIDS_OUTLINE]);

void em_solids_clear(struct em_solids *solids, const struct em_gl *gl);

#endif
