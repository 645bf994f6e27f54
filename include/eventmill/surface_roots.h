/* How contact times are found: the knobs that trade accuracy for time, and the searches that they
 * choose. */
#ifndef EVENTMILL_SURFACE_ROOTS_H
#define EVENTMILL_SURFACE_ROOTS_H

#include <stdbool.h>

#include "eventmill/surface.h"
#include "eventmill/vec.h"

#ifdef __cplusplus
extern "C" {
#endif

#define EM_SEARCH_LIST(X)                       \
  X(SAFE, "safe")   /* jumps over no contact */ \
  X(STEPS, "steps") /* the heuristic of Reichardt 2005, 8.4 */
#define EM_SEARCH_ENUM(code, text) EM_SEARCH_##code,
enum em_search { EM_SEARCH_LIST(EM_SEARCH_ENUM) EM_SEARCH_COUNT };
#undef EM_SEARCH_ENUM

#define EM_POLISH_LIST(X)                     \
  X(NONE, "none")                             \
  X(EXTENDED, "extended") /* 64 bits (x87) */ \
  X(QUAD, "quad")         /* 113 bits: right to 1 ulp */
#define EM_POLISH_ENUM(code, text) EM_POLISH_##code,
enum em_polish { EM_POLISH_LIST(EM_POLISH_ENUM) EM_POLISH_COUNT };
#undef EM_POLISH_ENUM

struct em_roots {
  enum em_quartic quartic; /* drum with gravity */
  enum em_search blade;
  double blade_step; /* ball diameters, for the heuristic search */
  double tolerance;  /* ball diameters: gap with which searches are content; 0: rounding */
  double shortcut;   /* ball diameters: so near to the drum, balls that fly towards it with
                        v² > 20 g × that distance are taken to fly straight (Reichardt 2005, 8.3.3,
                        which gives no limits). 0: off */
  enum em_polish polish;
};

/* First contact with the inside of a drum; as em_surface_drum. radius: the ball's, m. */
double em_surface_roots_drum(const struct em_roots *how, struct em_vec r, struct em_vec v,
                             struct em_vec g, double rho, double radius, bool touched,
                             double horizon);

/* First contact with a plane, as em_surface_plane. */
double em_surface_roots_plane(const struct em_roots *how, double gap, double rate, double fall,
                              bool touched);

/* First contact with a blade, as em_surface_blade. */
double em_surface_roots_blade(const struct em_roots *how, const struct em_blade *blade,
                              struct em_vec r, struct em_vec v, struct em_vec g, double radius,
                              double angle, bool touched, double horizon, unsigned *steps);

/* A ball's place and velocity at its own time. */
struct em_surface_path {
  struct em_vec r, v;
  double t;
};

/* When (not after how long) two balls in the same gravity touch after the later of their times;
 * shift: added to b − a, for periodic images; sigma: sum of the radii. */
double em_surface_roots_pair(const struct em_roots *how, const struct em_surface_path *a,
                             const struct em_surface_path *b, struct em_vec g, struct em_vec shift,
                             double sigma);

/* Is anything asked for beyond a choice of the quartic's solver? */
bool em_surface_roots_special(const struct em_roots *how);

#ifdef __cplusplus
}
#endif

#endif
