/* What the user asked for: a plain, validated description of a run. SI units throughout; the frame
 * has the drum's axis along y, its end walls at y = 0 and y = length, its axis at x = z = 0; a box
 * spans [0, size] in each direction.
 *
 * A scene is to be looked at: its fields follow from one another (a blade's omega from its rotor's
 * rpm) and are checked together when it is read. Another one is read from the same text with other
 * overrides. */
#ifndef EVENTMILL_SCENE_H
#define EVENTMILL_SCENE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "eventmill/contact.h"
#include "eventmill/error.h"
#include "eventmill/surface_roots.h"
#include "eventmill/vec.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { EM_SCENE_NAME = 64, EM_SCENE_PATH = 1024 };

#define EM_SHAPE_LIST(X) \
  X(DRUM, "drum")        \
  X(BOX, "box")
#define EM_SHAPE_ENUM(code, text) EM_SHAPE_##code,
enum em_shape { EM_SHAPE_LIST(EM_SHAPE_ENUM) EM_SHAPE_COUNT };
#undef EM_SHAPE_ENUM

struct em_chamber {
  enum em_shape shape;
  double diameter;    /* m, drum */
  double length;      /* m, drum, along y */
  struct em_vec size; /* m, box */
  bool periodic[3];   /* box: x, y, z. Default: false */
  double rpm;         /* drum and its end walls turn about +y. Default: 0 */
  int facets;         /* drum: flat sides around it instead of a round wall; 0: round. Default: 0 */
  double ramp_half; /* rad, half width of the faked ramps' two sectors (top, bottom). Default: 0 */
  double ramp_tilt; /* rad, by which their normal is turned against the ball's x motion */
};

/* One rotor; its blades carry their own position, angle, speed. */
struct em_rotor {
  struct em_vec point; /* m, a point on its axis. Default: 0 */
  struct em_vec axis;  /* unit vector. Default: +y */
  double rpm;          /* signed. Default for its blades */
  size_t blade_count;
  struct em_blade *blade; /* owned */
  double *blade_y;        /* m along the axis from `point`, owned (as the scene gave it) */
};

#define EM_START_LIST(X)                                                       \
  X(UNIFORM, "uniform") /* at random, without overlap */                       \
  X(HALF, "half")       /* at random in the lower half (z < axis or middle) */ \
  X(LATTICE, "lattice") /* a regular lattice that fills the region evenly */   \
  X(TABLE, "table")     /* positions and velocities are given one by one */    \
  X(RUN, "run")         /* the last frame of a run file */
#define EM_START_ENUM(code, text) EM_START_##code,
enum em_start { EM_START_LIST(EM_START_ENUM) EM_START_COUNT };
#undef EM_START_ENUM

/* Balls of one kind. */
struct em_species {
  char name[EM_SCENE_NAME]; /* Default: "balls" */
  size_t count;
  double diameter; /* m */
  double density;  /* kg/m³ */
  double speed;    /* m/s, isotropic. Default: 1 */
  enum em_start start;
  bool has_region;
  struct em_vec low, high;  /* m, box in which the centres start; whole chamber by default */
  struct em_vec *position;  /* count, m, for `table`, owned; else NULL */
  struct em_vec *velocity;  /* count, m/s, for `table`, owned; else NULL */
  struct em_vec *spin;      /* count, rad/s, for `table`, owned; may be NULL (0) */
  char from[EM_SCENE_PATH]; /* run file, for `run` */
};

#define EM_LISTS_LIST(X)                                                          \
  X(CALENDAR, "calendar") /* earliest event per ball, bounded-increasing queue */ \
  X(TREE, "tree")         /* all predictions, local and global red-black trees */ \
  X(ALL, "all")           /* all predictions in local trees, bounded-increasing queue */
#define EM_LISTS_ENUM(code, text) EM_LISTS_##code,
enum em_lists { EM_LISTS_LIST(EM_LISTS_ENUM) EM_LISTS_COUNT };
#undef EM_LISTS_ENUM

#define EM_PARTITION_LIST(X)                                                  \
  X(AUTO, "auto")             /* cells, or lists where these are faster */    \
  X(NEIGHBOURS, "neighbours") /* near-neighbour lists with a skin */          \
  X(CELLS, "cells")           /* cubes */                                     \
  X(SLICES, "slices")         /* discs along y with check-in and check-out */ \
  X(NONE, "none")             /* every ball is tested against every other */
#define EM_PARTITION_ENUM(code, text) EM_PARTITION_##code,
enum em_partition { EM_PARTITION_LIST(EM_PARTITION_ENUM) EM_PARTITION_COUNT };
#undef EM_PARTITION_ENUM

#define EM_ACCURACY_LIST(X) \
  X(STANDARD, "standard")   \
  X(FAST, "fast")           \
  X(REFERENCE, "reference")
#define EM_ACCURACY_ENUM(code, text) EM_ACCURACY_##code,
enum em_accuracy { EM_ACCURACY_LIST(EM_ACCURACY_ENUM) EM_ACCURACY_COUNT };
#undef EM_ACCURACY_ENUM

struct em_engine {
  enum em_lists lists;
  enum em_partition partition;
  enum em_accuracy accuracy;
  int slices;            /* for `slices`; 0: as many as fit, at most 26. Default: 0 */
  double skin;           /* for `neighbours`, in ball diameters; 0: chosen. Default: 0 */
  bool simd;             /* work by vectors; same bits. Default: true */
  int lanes;             /* doubles of a vector: 4 or 8; 0: what the processor has. Default: 0 */
  struct em_roots roots; /* Defaults: those of the accuracy level */
};

/* Against collapse and jams; what a remedy does is counted. */
struct em_remedy {
  double tc;            /* s: a contact within tc of the ball's last one is elastic. Default: 0 */
  double elastic_below; /* m/s: contacts slower than this are elastic. Default: 0 */
  int jam_after;        /* contacts in a row after which the tangential part is left out; 0: off.
                           Default: 5 where a blade moves and contacts are not smooth, else 0 */
  double jam_within;    /* s, between contacts in a row. Default: 1e-8, or the time in which a ball
                           at the typical speed flies 1e-5 of the smallest diameter, if less */
  uint32_t collapse_after; /* contacts in a row at which the run stops as collapsed.
                              Default: 100000 */
};

struct em_recording {
  double frames;      /* 1/s; 0: none. Default: 50 */
  double observables; /* 1/s; 0: none. Default: 100 */
  double histograms;  /* 1/s, of v_n per class, in blocks of time; 0: one block. Default: 20 */
  bool collisions;    /* full collision table. Default: false */
  double checkpoint;  /* s of wall time between checkpoints. Default: 30 */
  int compression;    /* deflate level 0 … 9. Default: 1 */
};

struct em_scene {
  char title[256];
  char file[EM_SCENE_PATH]; /* where it was read from */
  double duration;          /* s */
  uint64_t seed;
  struct em_vec gravity; /* m/s² */
  struct em_chamber chamber;
  size_t rotor_count;
  struct em_rotor *rotor; /* owned */
  size_t species_count;
  struct em_species *species; /* owned */
  struct em_contact_law contact[EM_CLASS_COUNT];
  struct em_engine engine;
  struct em_remedy remedy;
  struct em_recording record;
};

/* Effects: what a scene calls for, and what its loop is compiled with. */
#define EM_EFFECT_LIST(X)                                                 \
  X(GRAVITY, "gravity")                                                   \
  X(SPIN, "spin")                                                         \
  X(ROTOR, "rotor")                                                       \
  X(PERIODIC, "periodic")                                                 \
  X(MIXED, "mixed")             /* balls of different diameter or mass */ \
  X(RESTITUTION, "restitution") /* ε_n depends on the speed */           \
  X(TC, "tc")                                                             \
  X(ELASTIC, "elastic-below")                                             \
  X(JAM, "jam")                                                           \
  X(RAMPS, "ramps")                                                       \
  X(FACETS, "facets")                                                     \
  X(TURNING, "turning-drum")                                              \
  X(COLLISIONS, "collision-table")
#define EM_EFFECT_ENUM(code, text) EM_EFFECT_BIT_##code,
enum em_effect_bit { EM_EFFECT_LIST(EM_EFFECT_ENUM) EM_EFFECT_COUNT };
#undef EM_EFFECT_ENUM
#define EM_EFFECT_ENUM(code, text) EM_EFFECT_##code = 1 << EM_EFFECT_BIT_##code,
enum em_effect { EM_EFFECT_LIST(EM_EFFECT_ENUM) };
#undef EM_EFFECT_ENUM

/* Reads a scene and applies `overrides` ("KEY=VALUE", count of them), fills in all defaults and
 * validates. All errors of a file are reported at once, a line each. On success *scene is the
 * caller's, to be freed. Errors: EM_FILE, EM_INPUT, EM_MEMORY. */
enum em_status em_scene_read(struct em_scene **scene, const char *path, size_t override_count,
                             const char *const *overrides, struct em_error *err);

/* The same from a text; `name` stands for the file in messages. */
enum em_status em_scene_parse(struct em_scene **scene, const char *text, const char *name,
                              size_t override_count, const char *const *overrides,
                              struct em_error *err);

/* The complete scene with its defaults filled in; what it prints is a valid scene that reads back
 * to the same bits. What follows from other entries is a comment, and so follows them still.
 * Errors: EM_FILE (`out` has an error). */
enum em_status em_scene_print(const struct em_scene *scene, FILE *out);

/* The same as a text, to be freed by the caller; NULL when memory is short. */
char *em_scene_text(const struct em_scene *scene);

void em_scene_free(struct em_scene *scene);

/* Bits EM_EFFECT_*. */
unsigned em_scene_effects(const struct em_scene *scene);
const char *em_scene_effect_name(enum em_effect_bit bit);

size_t em_scene_ball_count(const struct em_scene *scene);
size_t em_scene_blade_count(const struct em_scene *scene);

/* remedy.jam_after and jam_within (s) of a scene that does not give them. */
void em_scene_jam(const struct em_scene *scene, int *after, double *within);

/* A speed (m/s) that is typical of the scene: the largest of start speeds, half the tip speed and
 * the fall through the chamber. Never 0. */
double em_scene_typical_speed(const struct em_scene *scene);

/* The chamber's volume (m³), and the extent (m) of its bounding box; of a drum with facets, those
 * of the round drum that they touch from outside. */
double em_scene_volume(const struct em_scene *scene);
void em_scene_bounds(const struct em_scene *scene, struct em_vec *low, struct em_vec *high);

/* How far a drum reaches from its axis (m): to its wall, or to the corners between its facets; and
 * the box that holds all of a chamber, these corners as well. */
double em_scene_reach(const struct em_scene *scene);
void em_scene_extent(const struct em_scene *scene, struct em_vec *low, struct em_vec *high);

const char *em_scene_shape_name(enum em_shape shape);
const char *em_scene_start_name(enum em_start start);
const char *em_scene_lists_name(enum em_lists lists);
const char *em_scene_partition_name(enum em_partition partition);
const char *em_scene_accuracy_name(enum em_accuracy accuracy);

#ifdef __cplusplus
}
#endif

#endif
