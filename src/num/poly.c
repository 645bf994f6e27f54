/* Real polynomials of low degree: values, closed forms, bracketed roots. */
#include "num/poly.h"

#include <math.h>
#include <stdbool.h>

double em_poly_value(const double *a, int degree, double x) {
  double value = a[degree];
  for (int k = degree - 1; k >= 0; k--)
    value = value * x + a[k];
  return value;
}

int em_poly_quadratic(double a, double b, double c, double root[2]) {
  if (c == 0.0) {
    if (b == 0.0) return 0;
    root[0] = -a / b;
    return 1;
  }
  const double h = -0.5 * b, disc = h * h - a * c;
  if (disc < 0.0) return 0;
  const double far = h >= 0.0 ? h + sqrt(disc) : h - sqrt(disc);
  if (far == 0.0) {
    root[0] = 0.0;
    return 1;
  }
  const double x = far / c, y = a / far;
  if (x == y) {
    root[0] = x;
    return 1;
  }
  root[0] = x < y ? x : y;
  root[1] = x < y ? y : x;
  return 2;
}

/* One root of y³ + p y + q with one real root, by Cardano. */
static double cardano(double p, double q, double disc) {
  const double w = sqrt(disc), half = 0.5 * q;
  const double u = half > 0.0 ? -cbrt(half + w) : cbrt(w - half);
  return u == 0.0 ? 0.0 : u - p / (3.0 * u);
}

int em_poly_cubic(const double a[4], double root[3]) {
  const double b = a[2] / a[3], c = a[1] / a[3], d = a[0] / a[3];
  const double shift = b / 3.0;
  const double p = c - b * shift;
  const double q = d + shift * (2.0 * shift * shift - c);
  const double disc = 0.25 * q * q + p * p * p / 27.0;
  if (disc >= 0.0) {
    root[0] = cardano(p, q, disc) - shift;
    return 1;
  }
  const double m = 2.0 * sqrt(-p / 3.0);
  const double x = 3.0 * q / (p * m);
  const double angle = acos(x > 1.0 ? 1.0 : x < -1.0 ? -1.0 : x) / 3.0;
  for (int k = 0; k < 3; k++)
    root[k] = m * cos(angle - k * (2.0 * M_PI / 3.0)) - shift;
  return 3;
}

/* A positive root of the resolvent z³ + 2p z² + (p² − 4r) z − q², q ≠ 0: the largest one. */
static double resolvent(double p, double q, double r) {
  const double a[4] = {-q * q, p * p - 4.0 * r, 2.0 * p, 1.0};
  double root[3];
  const int count = em_poly_cubic(a, root);
  double z = root[0];
  for (int k = 1; k < count; k++)
    z = fmax(z, root[k]);
  const double slope = a[1] + z * (2.0 * a[2] + 3.0 * z);
  return slope != 0.0 ? z - em_poly_value(a, 3, z) / slope : z;
}

int em_poly_quartic(const double a[5], double root[4]) {
  const double b = a[3] / a[4], c = a[2] / a[4], d = a[1] / a[4], e = a[0] / a[4];
  const double s = 0.25 * b, s2 = s * s;
  const double p = c - 6.0 * s2;
  const double q = d - 2.0 * c * s + 8.0 * s2 * s;
  const double r = e - d * s + c * s2 - 3.0 * s2 * s2;
  int count = 0;
  const double z = q != 0.0 ? resolvent(p, q, r) : 0.0;
  if (z > 0.0) {
    const double w = sqrt(z), half = 0.5 * (p + z), skew = 0.5 * q / w;
    count = em_poly_quadratic(half - skew, w, 1.0, root);
    count += em_poly_quadratic(half + skew, -w, 1.0, root + count);
  } else {
    double square[2];
    const int squares = em_poly_quadratic(r, p, 1.0, square);
    for (int k = 0; k < squares; k++) {
      if (square[k] < 0.0) continue;
      root[count++] = sqrt(square[k]);
      root[count++] = -sqrt(square[k]);
    }
  }
  for (int k = 0; k < count; k++)
    root[k] -= s;
  return count;
}

double em_poly_root_bound(const double *a, int degree) {
  double bound = 0.0;
  for (int k = 0; k < degree; k++)
    bound = fmax(bound, pow(fabs(a[k] / a[degree]), 1.0 / (degree - k)));
  return 2.0 * bound;
}

/* The root in [low, high] of a polynomial that is monotone there and changes its sign: Newton
 * inside a bracket, bisection where Newton leaves it or halves too slowly. */
static double bracketed(const double *a, int degree, double low, double high) {
  const bool rising = em_poly_value(a, degree, high) > 0.0;
  double x = 0.5 * (low + high), before = high - low;
  for (int step = 0; step < 2200; step++) {
    double value = a[degree], slope = 0.0;
    for (int k = degree - 1; k >= 0; k--) {
      slope = slope * x + value;
      value = value * x + a[k];
    }
    if (value == 0.0) return x;
    if ((value > 0.0) == rising)
      high = x;
    else
      low = x;
    double next = x - value / slope;
    const bool bad = !(next > low && next < high) || fabs(next - x) > 0.5 * before;
    before = fabs(next - x);
    if (bad) {
      if (next == x || !(high - low > 0.0)) return x;
      next = 0.5 * (low + high);
      before = high - low;
      if (next <= low || next >= high) return x;
    } else if (next == x) {
      return x;
    }
    x = next;
  }
  return x;
}

static int trim(const double *a, int degree) {
  while (degree > 0 && a[degree] == 0.0)
    degree--;
  return degree;
}

static void derive(const double *a, int degree, double *slope) {
  for (int k = 1; k <= degree; k++)
    slope[k - 1] = k * a[k];
}

int em_poly_changes(const double *a, int degree, double low, double high,
                    double root[EM_POLY_DEGREE]) {
  degree = trim(a, degree);
  if (degree == 0) return 0;
  double slope[EM_POLY_DEGREE] = {0}, turn[EM_POLY_DEGREE + 1];
  derive(a, degree, slope);
  int turns = em_poly_changes(slope, degree - 1, low, high, turn);
  turn[turns++] = high;
  int count = 0;
  double from = low, value = em_poly_value(a, degree, low);
  for (int k = 0; k < turns; k++) {
    const double next = em_poly_value(a, degree, turn[k]);
    if ((value < 0.0 && next > 0.0) || (value > 0.0 && next < 0.0))
      root[count++] = bracketed(a, degree, from, turn[k]);
    from = turn[k];
    if (next != 0.0) value = next;
  }
  return count;
}

double em_poly_first_rise(const double *a, int degree) {
  degree = trim(a, degree);
  if (degree == 0) return INFINITY;
  double slope[EM_POLY_DEGREE] = {0}, turn[EM_POLY_DEGREE + 1];
  derive(a, degree, slope);
  const int top = trim(slope, degree - 1);
  int turns = em_poly_changes(slope, top, 0.0, 1.01 * em_poly_root_bound(slope, top), turn);
  turn[turns++] = INFINITY;
  double from = 0.0;
  for (int k = 0; k < turns; k++) {
    double to = turn[k];
    if (to == INFINITY) to = 1.01 * fmax(em_poly_root_bound(a, degree), 2.0 * from) + 1e-300;
    const double start = em_poly_value(a, degree, from), end = em_poly_value(a, degree, to);
    if (end > start && start >= 0.0) return from;
    if (start < 0.0 && end > 0.0) return bracketed(a, degree, from, to);
    from = turn[k];
  }
  return INFINITY;
}
