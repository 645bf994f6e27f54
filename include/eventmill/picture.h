/* Pictures of a state: the chamber, its rotors and its balls, with a legend. */
#ifndef EVENTMILL_PICTURE_H
#define EVENTMILL_PICTURE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "eventmill/camera.h"
#include "eventmill/colour.h"
#include "eventmill/error.h"
#include "eventmill/scene.h"
#include "eventmill/start.h"

#ifdef __cplusplus
extern "C" {
#endif

/* What the balls' colours tell. */
#define EM_PICTURE_LIST(X)                                               \
  X(SPEED, "speed")                                                      \
  X(SPIN, "spin")                                                        \
  X(CLASS, "class") /* of the last contact; needs the collision table */ \
  X(SPECIES, "species")                                                  \
  X(PLAIN, "plain") /* all alike */
#define EM_PICTURE_ENUM(code, text) EM_PICTURE_##code,
enum em_picture_by { EM_PICTURE_LIST(EM_PICTURE_ENUM) EM_PICTURE_KINDS };
#undef EM_PICTURE_ENUM

/* A small thing beside the balls: a sphere, of which trails are made, or a disc with a white rim
 * that marks a collision. */
struct em_picture_bead {
  struct em_vec place; /* m */
  double radius;       /* m */
  uint8_t rgb[3];      /* sRGB */
  bool disc;
};

/* What is to be seen. Nothing is kept or changed. */
struct em_picture_state {
  const struct em_balls *balls;
  double time;               /* s */
  const double *blade_angle; /* rad, one per blade of the scene, rotor after rotor */
  const uint8_t *last;       /* per ball: enum em_class of its last contact, EM_CLASS_COUNT: none
                                yet; NULL: not known */
  size_t bead_count;
  const struct em_picture_bead *bead;
  size_t unmarked; /* collisions that have no mark, because they are too many */
};

struct em_picture_options {
  int width, height; /* pixels */
  int smooth;        /* samples per pixel each way, 1 … 4: 2 for pictures, 1 for film */
  struct em_camera camera;
  enum em_picture_by by;
  enum em_colour map;
  double low, high;           /* ends of the scale, m/s or rad/s */
  double show_low, show_high; /* m/s: only balls as fast as this; show_high 0: no limit */
  size_t limit;               /* no more than so many balls, evenly chosen; 0: all */
  bool hide_rotor, hide_drum, hide_balls;
  bool hide_legend; /* small pictures have none: below about 200 × 140 pixels */
  bool histogram;   /* of the balls' speeds, beside the colour bar */
  bool dark;        /* on a dark ground */
  double marked;    /* s: collisions as old as this have marks; 0: none */
  char note[128];   /* written at the lower right: "40 times slower" */
};

struct em_picture;

const char *em_picture_name(enum em_picture_by by);
int em_picture_find(const char *name); /* -1: no such kind */

/* 1280 × 720, smooth 2, from three quarters, by speed; the scale ends at em_picture_scale (balls
 * may be NULL). */
struct em_picture_options em_picture_default(const struct em_scene *scene,
                                             const struct em_balls *balls);

/* Where the scale of speeds should end (m/s): 110 % of the fastest blade's tip speed (Reichardt
 * 2005, 12.2); without a moving rotor, the 99th percentile of the balls' speeds or, when there are
 * none, the scene's typical speed. Never 0. */
double em_picture_scale(const struct em_scene *scene, const struct em_balls *balls);

/* The same for spins (rad/s): the 99th percentile. */
double em_picture_spin_scale(const struct em_balls *balls);

/* Makes what is needed to draw pictures of a scene, which must outlive it. Errors: EM_INPUT (size,
 * scale), EM_MEMORY, EM_PICTURE. */
enum em_status em_picture_new(struct em_picture **picture, const struct em_scene *scene,
                              const struct em_picture_options *options, struct em_error *err);

/* Turns the camera to another azimuth (rad); for orbits. */
void em_picture_turn(struct em_picture *picture, double azimuth);

/* Draws a state. rgba: width × height × 4 bytes, the top row first, opaque. Errors: EM_INPUT
 * (positions that are no numbers), EM_MEMORY, EM_PICTURE. */
enum em_status em_picture_draw(struct em_picture *picture, const struct em_picture_state *state,
                               uint8_t *rgba, struct em_error *err);

/* Three states as the red, green and blue channel of one picture (Reichardt 2005, 7.1.1): what
 * rests is grey, what moves a coloured triplet. Errors: those of em_picture_draw. */
enum em_status em_picture_triple(struct em_picture *picture, const struct em_picture_state state[3],
                                 uint8_t *rgba, struct em_error *err);

/* GL_RENDERER: what draws. */
const char *em_picture_renderer(const struct em_picture *picture);

void em_picture_free(struct em_picture *picture);

/* Writes a PNG file, complete or not at all. Errors: EM_INPUT (another ending than .png), EM_FILE,
 * EM_MEMORY. */
enum em_status em_picture_save(const char *path, const uint8_t *rgba, int width, int height,
                               struct em_error *err);

#ifdef __cplusplus
}
#endif

#endif
