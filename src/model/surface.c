/* When a ball in free flight first touches a plane or the inside of a drum. */
#include "eventmill/surface.h"

#include <float.h>
#include <gsl/gsl_poly.h>
#include <stddef.h>

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

/* Is q < −floor all the way to the horizon, beyond rounding? q'' is convex on t ≥ 0, so q lies
 * below the parabola with the larger of its ends; that is convex, so its own ends decide. (Of a
 * cubic, t q starts at 0: it is not far.) */
static bool is_far(const double *q, int degree, double floor, double horizon) {
  const double h = horizon, q3 = q[3], q4 = degree == 4 ? q[4] : 0.0;
  const double end = 2.0 * q[2] + h * (6.0 * q3 + h * 12.0 * q4);
  const double bend = em_greater(em_greater(2.0 * q[2], end), 0.0);
  const double size = h * (fabs(q[1]) + h * (fabs(q[2]) + h * (fabs(q3) + h * fabs(q4)))) - q[0];
  if (degree == 3 && floor > 0.0) return false;
  return q[0] < -floor && q[0] + h * (q[1] + 0.5 * bend * h) < -1e-14 * size - floor;
}

enum { STEPS = 40 };

/* q, q', q'' of a quartic. */
struct jet {
  double value, slope, bend;
};

static struct jet jet_at(const double *a, double t) {
  return (struct jet){a[0] + t * (a[1] + t * (a[2] + t * (a[3] + t * a[4]))),
                      a[1] + t * (2.0 * a[2] + t * (3.0 * a[3] + t * 4.0 * a[4])),
                      2.0 * a[2] + t * (6.0 * a[3] + t * 12.0 * a[4])};
}

/* How long after t the quartic rises through 0, by brackets. */
static double rise_after(const double *a, double t) {
  const struct jet here = jet_at(a, t);
  const double shifted[5] = {here.value, here.slope, 0.5 * here.bend, a[3] + 4.0 * t * a[4], a[4]};
  return em_poly_first_rise(shifted, 4);
}

/* The first rise of a polynomial q with q(0) ≤ 0 and a positive leading coefficient.
 *
 * Let q(T) > 0. On [t, T] the convex q'' lies below its chord, so for t with q(t) < 0 and t+s ≤ T
 *     q(t+s) ≤ q + q' s + ½ B s²,   B = q''(t) + ⅓ max(q''(T) − q''(t), 0).
 * The first root of that parabola is no later than that of q: stepping there never jumps over it.
 * T starts as a power-of-two multiple of a guess that is derived from the state and follows the
 * steps; the error then falls with its third power. The search ends where q reaches −floor (of a
 * cubic: where t q does). Where steps stay short (double roots), or
 * rounding contradicts the bounds, brackets finish from t. */
static inline __attribute__((always_inline)) double safe(const double *q, int degree, double guess,
                                                         double floor, double horizon) {
  const double a[5] = {q[0], q[1], q[2], q[3], degree == 4 ? q[4] : 0.0};
  double top = guess, t = 0.0;
  struct jet end = jet_at(a, top);
  while (!(end.value > 0.0) && top < 2.0 * top) /* neither 0 nor infinite */
    end = jet_at(a, top *= 2.0);
  for (int step = 0;; step++) {
    if (t > horizon) return INFINITY;
    const struct jet here = jet_at(a, t);
    if (here.value >= (floor > 0.0 ? -floor / (degree == 4 ? 1.0 : t) : 0.0) && step > 0) return t;
    const double rest = end.bend - here.bend;
    const double bend = em_greater(here.bend + em_greater(rest, 0.0) / 3.0, 0.0);
    const double root = sqrt(here.slope * here.slope - 2.0 * bend * here.value);
    const double s =
        here.slope > 0.0 ? -2.0 * here.value / (here.slope + root) : (root - here.slope) / bend;
    const double next = t + s;
    if (!(next < top) || step == STEPS) return t + rise_after(a, t);
    if (!(next > t) || (fabs(rest) + bend - here.bend) * s * s < 1e-16 * root * next) return next;
    t = next;
    if (t + s < top) {
      const struct jet beyond = jet_at(a, t + s);
      if (beyond.value > 0.0) {
        top = t + s;
        end = beyond;
      }
    }
  }
}

/* One Newton step for q from x; INFINITY where q falls. */
static double newton(const double *q, int degree, double x) {
  double slope = 0.0, value = q[degree];
  for (int k = degree - 1; k >= 0; k--) {
    slope = slope * x + value;
    value = value * x + q[k];
  }
  return slope > 0.0 ? em_greater(x - value / slope, 0.0) : INFINITY;
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

/* All real roots by closed form; the polynomial is turned round where that is better scaled.
 * small: are both ends so small that closed forms lose their digits? */
static int closed_form(const double *q, int degree, double guess, double root[4], bool *small) {
  double high = fabs(q[degree]), middle = 0.0, scale = 1.0;
  for (int k = 1; k < degree; k++) {
    scale *= guess;
    middle = em_greater(middle, fabs(q[k]) * scale);
  }
  high *= scale * guess;
  *small = em_greater(fabs(q[0]), high) < 1e-3 * middle;
  double a[5];
  const bool turn = fabs(q[0]) > high;
  for (int k = 0; k <= degree; k++)
    a[k] = turn ? q[degree - k] : q[k];
  const int count = degree == 4 ? em_poly_quartic(a, root) : em_poly_cubic(a, root);
  for (int k = 0; turn && k < count; k++)
    root[k] = 1.0 / root[k];
  return count;
}

/* The first rise of q by closed form and one Newton step. Where both ends of the polynomial are
 * small, or roots close together, closed forms lose half of the digits or more: brackets then. */
static double ferrari_newton(const double *q, int degree, double guess) {
  double root[4], best = INFINITY;
  bool small;
  const int count = closed_form(q, degree, guess, root, &small);
  if (small) return em_poly_first_rise(q, degree);
  for (int k = 0; k < count; k++)
    if (root[k] > 0.0 && root[k] < best) best = em_lesser(best, newton(q, degree, root[k]));
  const bool sound = best < INFINITY && is_root(q, degree, best);
  if (!sound) return em_poly_first_rise(q, degree);
  /* Close to the wall, moving out: the closed form has no digits left of a root so small. */
  const double start = newton(q, degree, 0.0);
  const double near = start < best ? newton(q, degree, start) : INFINITY;
  return near < best && is_root(q, degree, near) ? near : best;
}

/* The smallest of the positive roots at which q rises. */
static double first_of(const double *q, int degree, const double *root, int count) {
  double best = INFINITY;
  for (int k = 0; k < count; k++)
    if (root[k] > 0.0 && root[k] < best && newton(q, degree, root[k]) < INFINITY) best = root[k];
  return best;
}

static double ferrari(const double *q, int degree, double guess) {
  double root[4];
  bool small;
  const int count = closed_form(q, degree, guess, root, &small);
  return first_of(q, degree, root, count);
}

/* The eigenvalues of the companion matrix, which has its place on the stack. Those that are real up
 * to the rounding of a double root count. */
static double companion(const double *q, int degree) {
  double matrix[16], z[8], root[4];
  gsl_poly_complex_workspace space = {(size_t)degree, matrix};
  if (gsl_poly_complex_solve(q, (size_t)degree + 1, &space, z) != 0)
    return em_poly_first_rise(q, degree);
  int count = 0;
  for (int k = 0; k < degree; k++)
    if (fabs(z[2 * k + 1]) <= 1e-8 * fabs(z[2 * k])) root[count++] = z[2 * k];
  return first_of(q, degree, root, count);
}

static inline __attribute__((always_inline)) double solve(const double *q, int degree, double guess,
                                                          enum em_quartic solver, double floor,
                                                          double horizon) {
  if (is_far(q, degree, floor, horizon)) return INFINITY;
  switch (solver) {
  case EM_QUARTIC_SAFE:
    return floor > 0.0 ? safe(q, degree, guess, floor, horizon)
                       : safe(q, degree, guess, 0.0, horizon);
  case EM_QUARTIC_FERRARI_NEWTON:
    return ferrari_newton(q, degree, guess);
  case EM_QUARTIC_FERRARI:
    return ferrari(q, degree, guess);
  case EM_QUARTIC_GSL:
    return companion(q, degree);
  case EM_QUARTIC_BRACKET:
  case EM_QUARTIC_COUNT:
    break;
  }
  return em_poly_first_rise(q, degree);
}

static inline __attribute__((always_inline)) double drum(double px, double pz, double vx, double vz,
                                                         double gx, double gz, double rho,
                                                         bool touched, enum em_quartic solver,
                                                         double tolerance, double horizon) {
  const double g2 = gx * gx + gz * gz, v2 = vx * vx + vz * vz;
  const double b = px * vx + pz * vz, q0 = (px * px + pz * pz) - rho * rho;
  if (g2 == 0.0) {
    const double t = drum_straight(q0, b, v2, touched);
    return t <= horizon ? t : INFINITY;
  }
  const double q[5] = {q0, 2.0 * b, v2 + (px * gx + pz * gz), vx * gx + vz * gz, 0.25 * g2};
  if ((touched || q0 >= 0.0) && b > 0.0) return 0.0;
  /* Without gravity the ball would be out by then; with it alone, by the other. */
  const double guess = 1.2 * em_lesser(2.0 * rho / sqrt(v2), 2.0 * sqrt(rho / sqrt(g2)));
  const double floor = 2.0 * rho * tolerance;
  double t;
  if (touched)
    t = b == 0.0 && q[2] >= 0.0 ? 0.0 : solve(q + 1, 3, guess, solver, floor, horizon);
  else if (q0 >= 0.0)
    t = em_poly_first_rise(q, 4);
  else
    t = solve(q, 4, guess, solver, floor, horizon);
  return t <= horizon ? t : INFINITY;
}

double em_surface_drum(double px, double pz, double vx, double vz, double gx, double gz, double rho,
                       bool touched, enum em_quartic solver, double horizon) {
  return drum(px, pz, vx, vz, gx, gz, rho, touched, solver, 0.0, horizon);
}

double em_surface_drum_within(double px, double pz, double vx, double vz, double gx, double gz,
                              double rho, bool touched, enum em_quartic solver, double tolerance,
                              double horizon) {
  return drum(px, pz, vx, vz, gx, gz, rho, touched, solver, tolerance, horizon);
}
