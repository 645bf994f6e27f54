/* When does a ball's centre, in free flight r + v t + ½ g t², first touch a surface?
 *
 * All functions return the time (s, ≥ 0) after t = 0 of the first contact, or INFINITY when there
 * is none up to `horizon`. A result is a function of the state alone: a smaller horizon never
 * changes the bits of a time that is returned. The sign rule holds for every surface: a ball that
 * overlaps by rounding and approaches has its contact now (0); one that overlaps and parts has none
 * there. `touched`: the ball's last contact was with this very surface, at t = 0: that root is no
 * event. */
#ifndef EVENTMILL_SURFACE_H
#define EVENTMILL_SURFACE_H

#include <stdbool.h>

#include "eventmill/vec.h"

#ifdef __cplusplus
extern "C" {
#endif

#define EM_TIP_LIST(X)        \
  X(FLAT, "flat")             \
  X(HEMISPHERE, "hemisphere") \
  X(NONE, "none")
#define EM_TIP_ENUM(code, text) EM_TIP_##code,
enum em_tip { EM_TIP_LIST(EM_TIP_ENUM) EM_TIP_COUNT };
#undef EM_TIP_ENUM

/* How the drum's quartic is solved. Those before `ferrari` never miss a contact; the others are
 * what the field uses, and the reference. */
#define EM_QUARTIC_LIST(X)                                                             \
  X(SAFE, "safe")                     /* guaranteed Newton from below on a parabola */ \
  X(BRACKET, "bracket")               /* roots of the derivatives as brackets */       \
  X(FERRARI_NEWTON, "ferrari+newton") /* closed form, one Newton step, checked */      \
  X(FERRARI, "ferrari")               /* closed form alone */                          \
  X(GSL, "gsl")                       /* GSL's eigenvalues of the companion matrix */
#define EM_QUARTIC_ENUM(code, text) EM_QUARTIC_##code,
enum em_quartic { EM_QUARTIC_LIST(EM_QUARTIC_ENUM) EM_QUARTIC_COUNT };
#undef EM_QUARTIC_ENUM
enum { EM_QUARTIC_SURE = EM_QUARTIC_FERRARI };

/* A blade: a bar through the rotor's axis that strikes on both sides.
 * At angle α its axis is e1 cos α + (axis × e1) sin α; for the axis +y, e1 = +z: angle 0 points up
 * and a positive speed turns +z towards +x. */
struct em_blade {
  struct em_vec centre; /* m, where the bar crosses the rotor's axis */
  struct em_vec axis;   /* unit vector of the rotor's axis */
  struct em_vec e1;     /* unit vector, perpendicular to the axis: the bar at angle 0 */
  double angle;         /* rad, at the time origin */
  double omega;         /* rad/s, right-handed about the axis */
  double radius;        /* m, of the bar */
  double reach;         /* m, from the rotor's axis to the end of the bar */
  enum em_tip tip;
};

const char *em_surface_tip_name(enum em_tip tip);
const char *em_surface_quartic_name(enum em_quartic solver);

/* Two balls on a straight relative path: r, v relative position (m) and velocity (m/s), sigma the
 * sum of the radii. The root without cancellation, c/(−b+√(b²−v²c)). */
static inline double em_surface_pair(struct em_vec r, struct em_vec v, double sigma) {
  const double b = em_vec_dot(r, v);
  if (!(b < 0.0)) return INFINITY;
  const double c = em_vec_norm2(r) - sigma * sigma;
  if (c <= 0.0) return 0.0;
  const double disc = b * b - em_vec_norm2(v) * c;
  if (disc < 0.0) return INFINITY;
  return c / (sqrt(disc) - b);
}

/* A plane: gap = distance of the ball's surface (m) along the normal that points into the room,
 * rate its time derivative (m/s), fall the normal component of gravity (m/s²). */
double em_surface_plane(double gap, double rate, double fall, bool touched);

/* Inside of a drum: p, v, g are the components perpendicular to its axis (x and z), rho the radius
 * that centres can reach. */
double em_surface_drum(double px, double pz, double vx, double vz, double gx, double gz, double rho,
                       bool touched, enum em_quartic solver, double horizon);

/* The same; the solver `safe` is content with a gap of `tolerance` (m). */
double em_surface_drum_within(double px, double pz, double vx, double vz, double gx, double gz,
                              double rho, bool touched, enum em_quartic solver, double tolerance,
                              double horizon);

/* A ball of radius R against a blade that stands at angle `angle` at t = 0. r is the ball's centre
 * in the frame of the scene. steps (may be NULL) is increased by the evaluations of the distance.
 */
double em_surface_blade(const struct em_blade *blade, struct em_vec r, struct em_vec v,
                        struct em_vec g, double radius, double angle, bool touched, double horizon,
                        unsigned *steps);

/* The same search, content with a gap or an overlap of `tolerance` (m; at least rounding). */
double em_surface_blade_within(const struct em_blade *blade, struct em_vec r, struct em_vec v,
                               struct em_vec g, double radius, double angle, bool touched,
                               double horizon, double tolerance, unsigned *steps);

/* The heuristic search of Reichardt 2005, 8.4, which may miss contacts: steps along the distance
 * from a bar without ends (8-13) within (8-14), longer ones where it grows; where it changes its
 * sign downwards, three Newton steps; a contact beyond the bar's end is dropped. `step`: the way of
 * the ball against the end of the bar in one step, in ball diameters. */
double em_surface_blade_steps(const struct em_blade *blade, struct em_vec r, struct em_vec v,
                              struct em_vec g, double radius, double angle, double horizon,
                              double step, unsigned *steps);

/* Distance (m) between the blade's surface and the ball's, negative when they overlap; for the tip
 * `none` the bar has no end. */
double em_surface_blade_gap(const struct em_blade *blade, struct em_vec r, double radius,
                            double angle);

/* Unit normal from the blade to the ball's centre r, at a contact. */
struct em_vec em_surface_blade_normal(const struct em_blade *blade, struct em_vec r, double angle);

/* Velocity (m/s) of the blade's material at the point x. */
struct em_vec em_surface_blade_velocity(const struct em_blade *blade, struct em_vec x);

#ifdef __cplusplus
}
#endif

#endif
