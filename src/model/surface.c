/* When a ball in free flight first touches a plane or the inside of a drum. */
#include "eventmill/surface.h"

#include <float.h>
#include <stddef.h>
#include <string.h>

#include "num/poly.h"

#define NAME(code, text) text,
static const char *const TIP_NAME[] = {EM_TIP_LIST(NAME)};
static const char *const QUARTIC_NAME[] = {EM_QUARTIC_LIST(NAME)};
#undef NAME

const char *em_surface_tip_name(enum em_tip tip) {
  return TIP_NAME[tip];
}

const char *em_surface_quartic_name(enum em_quartic solver) {
  return QUARTIC_NAME[solver];
}

static int find(const char *const *names, int count, const char *name) {
  for (int i = 0; i < count; i++)
    if (strcmp(names[i], name) == 0) return i;
  return -1;
}

int em_surface_tip_find(const char *name) {
  return find(TIP_NAME, EM_TIP_COUNT, name);
}

int em_surface_quartic_find(const char *name) {
  return find(QUARTIC_NAME, EM_QUARTIC_COUNT, name);
}

/* x² − y z, without cancellation where the two terms nearly agree. */
static double difference(double x, double y, double z) {
  const double square = x * x, product = y * z, d = square - product;
  if (fabs(d) > 0.01 * square) return d;
  return d + (fma(x, x, -square) - fma(y, z, -product));
}

/* The contact with a falling ball (fall < 0) that is below the plane by rounding and rises: when it
 * comes back to the plane, or when it turns, if it does not get up to it. */
static double fall_back(double gap, double rate, double fall) {
  const double disc = difference(rate, 2.0 * gap, fall);
  return (rate + (disc > 0.0 ? sqrt(disc) : 0.0)) / -fall;
}

double em_surface_plane(double gap, double rate, double fall, bool touched) {
  if (touched) {
    if (rate < 0.0) return 0.0;
    return fall < 0.0 ? -2.0 * (rate / fall) : INFINITY;
  }
  if (gap <= 0.0) {
    if (rate < 0.0) return 0.0;
    return fall < 0.0 ? fall_back(gap, rate, fall) : INFINITY;
  }
  if (fall < 0.0 && rate > 0.0) return fall_back(gap, rate, fall);
  if (!(rate < 0.0 || fall < 0.0)) return INFINITY;
  const double disc = difference(rate, 2.0 * gap, fall);
  if (disc < 0.0) return INFINITY;
  return 2.0 * gap / (sqrt(disc) - rate);
}

/* |p + v t|² − ρ² = q₀ + 2 b t + a t²: its later root. */
static double drum_straight(double q0, double b, double a, bool touched) {
  if (touched || q0 >= 0.0) {
    if (b > 0.0 || a == 0.0) return a == 0.0 ? INFINITY : 0.0;
    if (touched) return -2.0 * b / a;
    const double disc = difference(b, a, q0);
    return (sqrt(disc > 0.0 ? disc : 0.0) - b) / a;
  }
  if (a == 0.0) return INFINITY;
  const double root = sqrt(b * b - a * q0);
  return b > 0.0 ? -q0 / (b + root) : (root - b) / a;
}

/* The first rise of a polynomial q with q(0) ≤ 0 and a positive leading coefficient.
 *
 * From t with q(t) < 0, q(t+s) ≤ q + q' s + ½ B s² as long as t+s ≤ T, where B is the maximum of q''
 * on [t, T] (q'' is convex: the larger of its ends) and q(T) > 0. The first root of that parabola
 * is no later than that of q: stepping there never jumps over it, and converges quadratically.
 * T is the first power-of-two multiple of a guess that is derived from the state. */
static double safe(const double *q, int degree, double guess, double horizon) {
  double a[5] = {0};
  memcpy(a, q, (size_t)(degree + 1) * sizeof(*q));
  double top = guess;
  while (!(em_poly_value(a, 4, top) > 0.0)) top *= 2.0;
  const double end = 2.0 * a[2] + top * (6.0 * a[3] + top * 12.0 * a[4]);
  double t = 0.0;
  for (int step = 0; step < 40; step++) {
    if (t > horizon) return INFINITY;
    const double value = em_poly_value(a, 4, t);
    if (value >= 0.0 && step > 0) return t;
    const double slope = a[1] + t * (2.0 * a[2] + t * (3.0 * a[3] + t * 4.0 * a[4]));
    const double here = 2.0 * a[2] + t * (6.0 * a[3] + t * 12.0 * a[4]);
    const double bound = fmax(fmax(here, end), 0.0);
    const double root = sqrt(slope * slope - 2.0 * bound * value);
    const double s = slope > 0.0 ? -2.0 * value / (slope + root) : (root - slope) / bound;
    const double next = t + s;
    if (!(next < top)) break;
    if (!(next > t) || s < 4e-16 * t) return next;
    t = next;
  }
  return em_poly_first_rise(q, degree);
}

/* One Newton step for q from x; INFINITY where q falls. */
static double newton(const double *q, int degree, double x) {
  double slope = 0.0, value = q[degree];
  for (int k = degree - 1; k >= 0; k--) {
    slope = slope * x + value;
    value = value * x + q[k];
  }
  return slope > 0.0 ? fmax(x - value / slope, 0.0) : INFINITY;
}

/* Is q(x) zero up to rounding? */
static bool is_root(const double *q, int degree, double x) {
  double value = q[degree], size = fabs(value);
  for (int k = degree - 1; k >= 0; k--) {
    value = value * x + q[k];
    size = size * x + fabs(q[k]);
  }
  return fabs(value) <= 4.0 * DBL_EPSILON * size;
}

/* The first rise of q by closed form and one Newton step. Where both ends of the polynomial are
 * small, or roots close together, closed forms lose half of the digits or more: brackets then. */
static double ferrari(const double *q, int degree, double guess) {
  double high = fabs(q[degree]), middle = 0.0, scale = 1.0;
  for (int k = 1; k < degree; k++) {
    scale *= guess;
    middle = fmax(middle, fabs(q[k]) * scale);
  }
  high *= scale * guess;
  if (fmax(fabs(q[0]), high) < 1e-3 * middle) return em_poly_first_rise(q, degree);
  double a[5], root[4];
  const bool turn = fabs(q[0]) > high;
  for (int k = 0; k <= degree; k++) a[k] = turn ? q[degree - k] : q[k];
  const int count = degree == 4 ? em_poly_quartic(a, root) : em_poly_cubic(a, root);
  double best = INFINITY;
  for (int k = 0; k < count; k++) {
    const double x = turn ? 1.0 / root[k] : root[k];
    if (x > 0.0 && x < best) best = fmin(best, newton(q, degree, x));
  }
  const bool sound = best < INFINITY && is_root(q, degree, best);
  return sound ? best : em_poly_first_rise(q, degree);
}

static double solve(const double *q, int degree, double guess, enum em_quartic solver,
                    double horizon) {
  switch (solver) {
  case EM_QUARTIC_SAFE: return safe(q, degree, guess, horizon);
  case EM_QUARTIC_FERRARI: return ferrari(q, degree, guess);
  case EM_QUARTIC_BRACKET:
  case EM_QUARTIC_COUNT: break;
  }
  return em_poly_first_rise(q, degree);
}

double em_surface_drum(double px, double pz, double vx, double vz, double gx, double gz, double rho,
                       bool touched, enum em_quartic solver, double horizon) {
  const double g2 = gx * gx + gz * gz, v2 = vx * vx + vz * vz;
  const double b = px * vx + pz * vz, q0 = (px * px + pz * pz) - rho * rho;
  if (g2 == 0.0) {
    const double t = drum_straight(q0, b, v2, touched);
    return t <= horizon ? t : INFINITY;
  }
  const double q[5] = {q0, 2.0 * b, v2 + (px * gx + pz * gz), vx * gx + vz * gz, 0.25 * g2};
  if ((touched || q0 >= 0.0) && b > 0.0) return 0.0;
  /* Without gravity the ball would be out by then; with it alone, by the other. */
  const double guess = 1.2 * fmin(2.0 * rho / sqrt(v2), 2.0 * sqrt(rho / sqrt(g2)));
  double t;
  if (touched)
    t = b == 0.0 && q[2] >= 0.0 ? 0.0 : solve(q + 1, 3, guess, solver, horizon);
  else if (q0 >= 0.0)
    t = em_poly_first_rise(q, 4);
  else
    t = solve(q, 4, guess, solver, horizon);
  return t <= horizon ? t : INFINITY;
}
