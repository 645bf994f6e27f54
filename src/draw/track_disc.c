/* Threshold, contours, circles. */
#include "draw/track_disc.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { LEVELS = 512, RAYS = 360, FAINTEST = 40, SMALLEST_CHAIN = 16 };

struct field {
  const float *value;
  int width, height;
  float threshold;
  uint8_t *mark; /* 1: on a contour that was followed */
};

static bool is_in(const struct field *f, int x, int y) {
  return x >= 0 && y >= 0 && x < f->width && y < f->height &&
         f->value[(size_t)y * (size_t)f->width + (size_t)x] >= f->threshold;
}

/* Otsu 1979: the level that parts two classes with the largest variance between them; but never
 * within the noise, whose size is the median of |value|. */
static float threshold_of(const float *value, size_t count) {
  double histogram[LEVELS] = {0}, noise[LEVELS] = {0}, sum = 0.0;
  for (size_t p = 0; p < count; p++) {
    const double v = fmin(fmax((double)value[p], 0.0), 1.0);
    histogram[(int)(v * (LEVELS - 1))]++;
    noise[(int)(fmin(fabs((double)value[p]), 1.0) * (LEVELS - 1))]++;
    sum += (int)(v * (LEVELS - 1));
  }
  double below = 0.0, sum_below = 0.0, best = -1.0, at = 0.0, half = 0.0;
  int median = 0;
  while (median < LEVELS - 1 && (half += noise[median]) < 0.5 * (double)count)
    median++;
  for (int k = 0; k < LEVELS - 1; k++) {
    below += histogram[k];
    sum_below += k * histogram[k];
    const double above = (double)count - below;
    if (below <= 0.0 || above <= 0.0) continue;
    const double gap = sum_below / below - (sum - sum_below) / above;
    if (below * above * gap * gap > best) {
      best = below * above * gap * gap;
      at = k + 1;
    }
  }
  return (float)(fmax(at, fmax(9.0 * (median + 1), 0.1 * LEVELS)) / (LEVELS - 1));
}

/* ---------------------------------------------------------------- contours */

static const int step_x[8] = {1, 1, 0, -1, -1, -1, 0, 1};
static const int step_y[8] = {0, 1, 1, 1, 0, -1, -1, -1};

/* What is added up along a chain (Freeman 1961). */
struct chain {
  double area, x, y; /* twice the area, and moments for the centroid */
  int straight, diagonal, corners, length;
  bool border;
};

static void add_step(struct chain *c, int x, int y, int direction, int before) {
  const int u = x + step_x[direction], v = y + step_y[direction];
  const double twice = (double)x * v - (double)u * y;
  c->area += twice;
  c->x += (x + u) * twice;
  c->y += (y + v) * twice;
  c->straight += !(direction & 1);
  c->diagonal += direction & 1;
  c->corners += direction != before;
  c->length++;
}

/* Follows the outer contour from its first pixel in reading order, the region on the same hand. */
static struct chain follow(const struct field *f, int x0, int y0) {
  struct chain c = {0};
  int x = x0, y = y0, direction = 7, first = -1, before = -1;
  const int most = 4 * (f->width + f->height) * 8;
  while (c.length < most) {
    int k = 0, next = (direction + 6) % 8;
    while (k < 8 && !is_in(f, x + step_x[next], y + step_y[next])) {
      next = (next + 1) % 8;
      k++;
    }
    if (k == 8) break; /* a single pixel */
    if (x == x0 && y == y0 && next == first) break;
    if (first < 0) first = next;
    f->mark[(size_t)y * (size_t)f->width + (size_t)x] = 1;
    c.border |= x == 0 || y == 0 || x == f->width - 1 || y == f->height - 1;
    add_step(&c, x, y, next, before);
    before = direction = next;
    x += step_x[next];
    y += step_y[next];
  }
  return c;
}

/* Length of a chain without the bias of its steps (Vossepoel & Smeulders 1982). */
static double length_of(const struct chain *c) {
  return 0.980 * c->straight + 1.406 * c->diagonal - 0.091 * c->corners;
}

/* ---------------------------------------------------------------- circles */

static double sample(const struct field *f, double x, double y) {
  const double u = fmin(fmax(x, 0.0), f->width - 1.001), v = fmin(fmax(y, 0.0), f->height - 1.001);
  const int i = (int)u, j = (int)v;
  const float *p = f->value + (size_t)j * (size_t)f->width + (size_t)i;
  const double a = u - i, b = v - j;
  return (1.0 - b) * ((1.0 - a) * (double)p[0] + a * (double)p[1]) +
         b * ((1.0 - a) * (double)p[f->width] + a * (double)p[f->width + 1]);
}

/* Distance from (x, y) in a direction at which the contrast, coming from outside, first reaches
 * half of what it is within; NAN: nowhere. */
static double edge_along(const struct field *f, const struct em_disc *d, double cx, double cy) {
  const double reach = fmin(6.0, 0.5 * d->radius), step = 0.125;
  double inside = 0.0, outer = 0.0;
  int n = 0;
  for (double r = d->radius - reach; r < d->radius - 0.5 * reach; r += step, n++)
    inside += sample(f, d->x + r * cx, d->y + r * cy);
  const double level = 0.5 * inside / n;
  if (n == 0 || level < 0.5 * (double)f->threshold) return NAN;
  for (double r = d->radius + reach; r > d->radius - reach; r -= step) {
    const double v = sample(f, d->x + r * cx, d->y + r * cy);
    if (v >= level) return r + step * (v - level) / fmax(v - outer, 1e-12);
    outer = v;
  }
  return NAN;
}

/* One step of Gauss and Newton of a circle to the edge; leaves out what is far from it. */
static bool refine(const struct field *f, struct em_disc *d, double trust) {
  double sc = 0.0, ss = 0.0, scc = 0.0, sss = 0.0, scs = 0.0, sr = 0.0, src = 0.0, srs = 0.0;
  double square = 0.0;
  int n = 0;
  for (int k = 0; k < RAYS; k++) {
    const double c = cos(2.0 * M_PI * k / RAYS), s = sin(2.0 * M_PI * k / RAYS);
    const double r = edge_along(f, d, c, s) - d->radius;
    if (!(fabs(r) <= trust)) continue;
    sc += c, ss += s, scc += c * c, sss += s * s, scs += c * s;
    sr += r, src += r * c, srs += r * s, square += r * r;
    n++;
  }
  if (n < RAYS / 2) return false;
  /* r = dR + dx c + dy s, by the normal equations with the means taken off. */
  const double a = scc - sc * sc / n, b = scs - sc * ss / n, e = sss - ss * ss / n;
  const double p = src - sc * sr / n, q = srs - ss * sr / n, det = a * e - b * b;
  if (!(det > 0.0)) return false;
  const double dx = (p * e - q * b) / det, dy = (a * q - b * p) / det;
  d->x += dx;
  d->y += dy;
  d->radius += (sr - dx * sc - dy * ss) / n;
  d->scatter = sqrt(square / n);
  return d->radius > 1.0;
}

static bool measure(const struct field *f, const struct chain *c, struct em_disc *d) {
  d->x = c->x / (3.0 * c->area);
  d->y = c->y / (3.0 * c->area);
  d->radius = sqrt(0.5 * fabs(c->area) / M_PI) + 0.5;
  for (int k = 0; k < 6; k++)
    if (!refine(f, d, k < 2 ? 6.0 : fmax(4.0 * d->scatter, 0.5))) return false;
  return true;
}

bool em_track_disc_find(const float *contrast, int width, int height, double tolerance,
                        uint8_t *mark, struct em_disc *disc) {
  const size_t pixels = (size_t)width * (size_t)height;
  const struct field f = {contrast, width, height, threshold_of(contrast, pixels), mark};
  struct chain best = {0};
  memset(mark, 0, pixels);
  for (int y = 0; y < height; y++)
    for (int x = 0; x < width; x++) {
      if (!is_in(&f, x, y) || is_in(&f, x - 1, y) || mark[(size_t)y * (size_t)width + (size_t)x])
        continue;
      const struct chain c = follow(&f, x, y);
      if (c.border || c.length < SMALLEST_CHAIN || fabs(c.area) < FAINTEST) continue;
      const double u = length_of(&c), round = u * u / (2.0 * M_PI * fabs(c.area));
      if (fabs(round - 1.0) > tolerance || fabs(c.area) <= fabs(best.area)) continue;
      best = c;
      disc->roundness = round;
    }
  return best.length > 0 && measure(&f, &best, disc);
}
