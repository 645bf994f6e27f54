/* How close blades come to walls and to each other. */
#ifndef EVENTMILL_SCENE_SCENE_GAP_H
#define EVENTMILL_SCENE_SCENE_GAP_H

#include <stdbool.h>

#include "eventmill/scene.h"

/* A convex body: a bar that stands still, or all that a turning bar sweeps. */
struct em_scene_body {
  struct em_vec centre, axis; /* m; unit vector of the rotor's axis */
  struct em_vec bar;          /* unit vector along the bar, where it stands still */
  double radius, reach;       /* m */
  bool round;                 /* hemispherical ends */
  bool swept;
};

/* The blade as it turns (or stands, if it does not turn), and as it stands at an angle (rad). */
struct em_scene_body em_scene_gap_body(const struct em_blade *blade);
struct em_scene_body em_scene_gap_body_at(const struct em_blade *blade, double angle);

/* The body's extent (m) from its centre in the direction of the unit vector n. */
double em_scene_gap_extent(const struct em_scene_body *body, struct em_vec n);

/* The distance (m) of two bodies; where they touch or overlap some value ≤ 0. Exact to about 1e-8
 * m. */
double em_scene_gap_bodies(const struct em_scene_body *a, const struct em_scene_body *b);

/* The smallest distance (m) that two blades ever have; ≤ 0: they touch. */
double em_scene_gap_blades(const struct em_blade *a, const struct em_blade *b);

/* The distance (m) between a body and the lower (side 0) or upper (side 1) wall across x, y or z
 * (k = 0, 1, 2), or between a body and the drum's wall; negative when it sticks out. */
double em_scene_gap_plane(const struct em_scene_body *body, const struct em_scene *scene, int k,
                          int side);
double em_scene_gap_drum(const struct em_scene_body *body, const struct em_scene *scene);

#endif
