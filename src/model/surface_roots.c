/* Contact times as the knobs of accuracy ask for them. */
#include "eventmill/surface_roots.h"

#include <math.h>

#define REAL         long double
#define POLISH(name) name##_extended
#include "model/surface_polish.h"
#undef REAL
#undef POLISH

#ifdef __SIZEOF_FLOAT128__
__extension__ typedef __float128 quad;
#else
typedef long double quad; /* 113 bits where __float128 is missing, as on ARM */
#endif
#define REAL         quad
#define POLISH(name) name##_quad
#include "model/surface_polish.h"
#undef REAL
#undef POLISH

bool em_surface_roots_special(const struct em_roots *how) {
  return how->blade != EM_SEARCH_SAFE || how->tolerance > 0.0 || how->shortcut > 0.0 ||
         how->polish != EM_POLISH_NONE;
}

/* Polishing moves a root: which lies before the horizon is known afterwards. */
static double beyond(const struct em_roots *how, double horizon) {
  return how->polish == EM_POLISH_NONE ? horizon : 1.01 * horizon;
}

/* Is the ball so near to the drum, and so fast towards it, that gravity may be left out? */
static bool is_short(const struct em_roots *how, struct em_vec r, struct em_vec v, struct em_vec g,
                     double rho, double radius) {
  const double near = how->shortcut * 2.0 * radius, out = sqrt(r.x * r.x + r.z * r.z);
  if (!(near > 0.0) || rho - out > near || out == 0.0) return false;
  const double speed = (r.x * v.x + r.z * v.z) / out;
  return speed > 0.0 && speed * speed > 20.0 * sqrt(g.x * g.x + g.z * g.z) * near;
}

double em_surface_roots_drum(const struct em_roots *how, struct em_vec r, struct em_vec v,
                             struct em_vec g, double rho, double radius, bool touched,
                             double horizon) {
  if (is_short(how, r, v, g, rho, radius)) g = em_vec_make(0.0, 0.0, 0.0);
  const double t = em_surface_drum_within(r.x, r.z, v.x, v.z, g.x, g.z, rho, touched, how->quartic,
                                          how->tolerance * 2.0 * radius, beyond(how, horizon));
  if (!(t > 0.0 && t < INFINITY) || how->polish == EM_POLISH_NONE) return t;
  const double root = how->polish == EM_POLISH_QUAD ? drum_quad(t, r, v, g, rho, touched)
                                                    : drum_extended(t, r, v, g, rho, touched);
  return root <= horizon ? root : INFINITY;
}

double em_surface_roots_plane(const struct em_roots *how, double gap, double rate, double fall,
                              bool touched) {
  const double t = em_surface_plane(gap, rate, fall, touched);
  if (!(t > 0.0 && t < INFINITY) || how->polish == EM_POLISH_NONE) return t;
  return how->polish == EM_POLISH_QUAD ? plane_quad(t, gap, rate, fall, touched)
                                       : plane_extended(t, gap, rate, fall, touched);
}

double em_surface_roots_blade(const struct em_roots *how, const struct em_blade *blade,
                              struct em_vec r, struct em_vec v, struct em_vec g, double radius,
                              double angle, bool touched, double horizon, unsigned *steps) {
  if (how->blade == EM_SEARCH_STEPS)
    return em_surface_blade_steps(blade, r, v, g, radius, angle, horizon, how->blade_step, steps);
  const double t =
      em_surface_blade_within(blade, r, v, g, radius, angle, touched, beyond(how, horizon),
                              how->tolerance * 2.0 * radius, steps);
  if (!(t > 0.0 && t < INFINITY) || how->polish == EM_POLISH_NONE) return t;
  const double root = how->polish == EM_POLISH_QUAD
                          ? blade_quad(t, blade, r, v, g, radius, angle)
                          : blade_extended(t, blade, r, v, g, radius, angle);
  return root <= horizon ? root : INFINITY;
}

double em_surface_roots_pair(const struct em_roots *how, const struct em_surface_path *a,
                             const struct em_surface_path *b, struct em_vec g, struct em_vec shift,
                             double sigma) {
  return how->polish == EM_POLISH_QUAD ? pair_quad(a, b, g, shift, sigma)
                                       : pair_extended(a, b, g, shift, sigma);
}
