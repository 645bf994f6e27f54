/* Levels, outlines, circles.
 *
 * The outline alone says whether a region is a disc and about where. The circle comes from the
 * difference before any smoothing: along each ray, the edge is where the ball would have to end to
 * hold as much contrast as is seen. Within the ball, contrast follows Lambert's law, a + b μ with
 * μ = √(1 − (r/R)²), the normal's part along the line of sight, whatever the light's direction; at
 * the edge it falls steeply, and without b radii come out wrong by up to 3 %. */
#include "draw/track_disc.h"

#include <gsl/gsl_cdf.h>
#include <math.h>
#include <string.h>

enum { LEVELS = 2048, RAYS = 180, SECTOR = 6, DIRECTIONS = 32, SMALLEST_CHAIN = 16, PASSES = 7 };

static const double FAINTEST = 3.0;        /* grey values that can be told from none */
static const double SMALLEST = 3.0;        /* pixels, radius */
static const double STEP = 0.125;          /* pixels, along a ray */
static const double WORST_SCATTER = 0.1;   /* of the edge, in radii; pixels if that is more */
static const double FEWEST_RAYS = 2.0 / 3; /* of all that have to show the edge */

/* ---------------------------------------------------------------- outlines */

static bool is_in(const struct em_disc_field *f, double level, int x, int y) {
  return x >= 0 && y >= 0 && x < f->width && y < f->height &&
         (double)f->contrast[(size_t)y * (size_t)f->width + (size_t)x] >= level;
}

/* How far a region reaches in each direction, from the picture's origin. */
struct outline {
  double reach[DIRECTIONS];
  int length; /* steps around it */
};

static double direction_of(int k) {
  return 2.0 * M_PI * k / DIRECTIONS;
}

static void add_pixel(struct outline *o, int x, int y) {
  for (int k = 0; k < DIRECTIONS; k++) {
    const double reach = 0.5 + x * cos(direction_of(k)) + y * sin(direction_of(k));
    o->reach[k] = o->length > 0 ? fmax(o->reach[k], reach) : reach;
  }
  o->length++;
}

/* Follows the outer contour from its first pixel in reading order, the region on the same hand
 * (Freeman 1961). */
static struct outline follow(const struct em_disc_field *f, double level, int x0, int y0) {
  static const int step_x[8] = {1, 1, 0, -1, -1, -1, 0, 1};
  static const int step_y[8] = {0, 1, 1, 1, 0, -1, -1, -1};
  struct outline o = {.length = 0};
  int x = x0, y = y0, direction = 7, first = -1;
  const int most = 32 * (f->width + f->height);
  while (o.length < most) {
    int k = 0, next = (direction + 6) % 8;
    while (k < 8 && !is_in(f, level, x + step_x[next], y + step_y[next])) {
      next = (next + 1) % 8;
      k++;
    }
    if (k == 8) break; /* a single pixel */
    if (x == x0 && y == y0 && next == first) break;
    if (first < 0) first = next;
    f->mark[(size_t)y * (size_t)f->width + (size_t)x] = 1;
    add_pixel(&o, x, y);
    direction = next;
    x += step_x[next];
    y += step_y[next];
  }
  return o;
}

/* The disc as large as the hull: perimeter, area and centre of the polygon whose sides touch the
 * region in all directions; bays, as highlights tear them, do not count. */
static struct em_disc disc_of(const struct outline *o) {
  const double turn = direction_of(1);
  double perimeter = 0.0, area = 0.0;
  struct em_disc d = {0};
  for (int k = 0; k < DIRECTIONS; k++) {
    const double next = o->reach[(k + 1) % DIRECTIONS],
                 last = o->reach[(k + DIRECTIONS - 1) % DIRECTIONS];
    const double side = (next + last - 2.0 * o->reach[k] * cos(turn)) / sin(turn);
    perimeter += side;
    area += 0.5 * o->reach[k] * side;
    d.radius += o->reach[k] / DIRECTIONS;
    d.x += 2.0 * o->reach[k] * cos(direction_of(k)) / DIRECTIONS;
    d.y += 2.0 * o->reach[k] * sin(direction_of(k)) / DIRECTIONS;
  }
  /* A circle's polygon has U²/A = 4 n tan(π/n). */
  d.roundness = perimeter * perimeter / (4.0 * DIRECTIONS * tan(0.5 * turn) * area);
  return d;
}

/* ---------------------------------------------------------------- circles */

/* The difference at a place, between the pixels in straight lines. */
static void sample(const struct em_disc_field *f, double x, double y, double value[3]) {
  const double u = fmin(fmax(x, 0.0), f->width - 1.001), v = fmin(fmax(y, 0.0), f->height - 1.001);
  const int i = (int)u, j = (int)v;
  const float *p = f->difference + 3 * ((size_t)j * (size_t)f->width + (size_t)i);
  const float *q = p + 3 * (size_t)f->width;
  const double a = u - i, b = v - j;
  for (int c = 0; c < 3; c++)
    value[c] = (1.0 - b) * ((1.0 - a) * (double)p[c] + a * (double)p[c + 3]) +
               b * ((1.0 - a) * (double)q[c] + a * (double)q[c + 3]);
}

static double dot(const double u[3], const double v[3]) {
  return u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
}

/* μ at a distance from the middle. */
static double facing(const struct em_disc *d, double r) {
  return sqrt(fmax(1.0 - r * r / (d->radius * d->radius), 0.0));
}

/* Moments of the difference within the ball along a ray, for a line over μ. */
struct shade {
  double n, m, mm; /* Σ 1, Σ μ, Σ μ² */
  double sum[3], moment[3];
};

/* Along all rays, from r0 to r1. */
static void gather(const struct em_disc_field *f, const struct em_disc *d, double r0, double r1,
                   struct shade ray[RAYS]) {
  for (int k = 0; k < RAYS; k++) {
    const double cx = cos(2.0 * M_PI * k / RAYS), cy = sin(2.0 * M_PI * k / RAYS);
    ray[k] = (struct shade){.n = 0.0};
    for (double r = r0; r < r1; r += STEP) {
      const double mu = facing(d, r);
      double value[3];
      sample(f, d->x + r * cx, d->y + r * cy, value);
      ray[k].n += 1.0, ray[k].m += mu, ray[k].mm += mu * mu;
      for (int c = 0; c < 3; c++) {
        ray[k].sum[c] += value[c];
        ray[k].moment[c] += mu * value[c];
      }
    }
  }
}

/* Contrast a + b μ about a ray, by least squares over it and SECTOR neighbours on either side. */
static void solve(const struct shade ray[RAYS], int middle, double a[3], double b[3]) {
  struct shade all = {.n = 0.0};
  for (int k = middle - SECTOR; k <= middle + SECTOR; k++) {
    const struct shade *one = ray + (k + RAYS) % RAYS;
    all.n += one->n, all.m += one->m, all.mm += one->mm;
    for (int c = 0; c < 3; c++) {
      all.sum[c] += one->sum[c];
      all.moment[c] += one->moment[c];
    }
  }
  for (int c = 0; c < 3; c++) {
    b[c] =
        (all.n * all.moment[c] - all.m * all.sum[c]) / fmax(all.n * all.mm - all.m * all.m, 1e-12);
    a[c] = (all.sum[c] - b[c] * all.m) / all.n;
  }
}

/* Distance from the middle at which the ball ends along a ray, looked for within `reach` of its
 * radius; NAN: contrast there is below `least`. */
static double edge_along(const struct em_disc_field *f, const struct em_disc *d, double cx,
                         double cy, const double a[3], const double b[3], double reach,
                         double least) {
  const double size = sqrt(dot(a, a)), start = d->radius - reach, end = d->radius + reach;
  double value[3], content = 0.0, held = 0.0;
  if (size < sqrt(3.0) * least) return NAN;
  for (double r = start + 0.5 * STEP; r < end; r += STEP) {
    sample(f, d->x + r * cx, d->y + r * cy, value);
    content += STEP * dot(value, a) / size;
  }
  for (double r = start; r < end; r += STEP) {
    const double density = size + facing(d, r + 0.5 * STEP) * dot(b, a) / size;
    if (density <= 0.0) return NAN;
    if (held + STEP * density >= content) return r + (content - held) / density;
    held += STEP * density;
  }
  return NAN;
}

/* One step of Gauss and Newton of a circle to the edge; leaves out what is far from it. */
static bool refine(const struct em_disc_field *f, struct em_disc *d, double reach, double trust,
                   double least) {
  double sc = 0.0, ss = 0.0, scc = 0.0, sss = 0.0, scs = 0.0, sr = 0.0, src = 0.0, srs = 0.0;
  double square = 0.0, shade_a[3], shade_b[3];
  struct shade ray[RAYS];
  int n = 0;
  gather(f, d, fmax(d->radius - reach - 1.5, 0.0), d->radius - 0.4 * reach, ray);
  for (int k = 0; k < RAYS; k++) {
    solve(ray, k, shade_a, shade_b);
    const double c = cos(2.0 * M_PI * k / RAYS), s = sin(2.0 * M_PI * k / RAYS);
    const double r = edge_along(f, d, c, s, shade_a, shade_b, reach, least) - d->radius;
    if (!(fabs(r) <= trust)) continue;
    sc += c, ss += s, scc += c * c, sss += s * s, scs += c * s;
    sr += r, src += r * c, srs += r * s, square += r * r;
    n++;
  }
  if (n < FEWEST_RAYS * RAYS) return false;
  /* r = dR + dx c + dy s, by the normal equations with the means taken off. */
  const double a = scc - sc * sc / n, b = scs - sc * ss / n, e = sss - ss * ss / n;
  const double p = src - sc * sr / n, q = srs - ss * sr / n, det = a * e - b * b;
  if (!(det > 0.0)) return false;
  const double dx = (p * e - q * b) / det, dy = (a * q - b * p) / det;
  d->x += dx;
  d->y += dy;
  d->radius += (sr - dx * sc - dy * ss) / n;
  d->scatter = sqrt(square / n);
  return d->radius > SMALLEST;
}

/* Mean contrast half way to the edge. */
static double body_of(const struct em_disc_field *f, const struct em_disc *d) {
  double sum = 0.0;
  for (int k = 0; k < RAYS; k++) {
    const int x = (int)lround(d->x + 0.5 * d->radius * cos(2.0 * M_PI * k / RAYS)),
              y = (int)lround(d->y + 0.5 * d->radius * sin(2.0 * M_PI * k / RAYS));
    if (is_in(f, 0.0, x, y))
      sum += (double)f->contrast[(size_t)y * (size_t)f->width + (size_t)x] / RAYS;
  }
  return sum;
}

static bool measure(const struct em_disc_field *f, double level, struct em_disc *d) {
  /* Smoothing has moved the edge from half of the contrast out to the level. */
  const double share = fmin(fmax(level / fmax(body_of(f, d), 1e-9), 1e-3), 0.5);
  d->radius = fmax(d->radius - f->smoothing * gsl_cdf_ugaussian_Qinv(share), 0.5 * d->radius);
  for (int k = 0; k < PASSES; k++) {
    const double reach = fmin(k < 3 ? 4.0 : 2.5, 0.5 * d->radius);
    if (!refine(f, d, reach, k < 3 ? reach : fmax(3.0 * d->scatter, 0.5), level)) return false;
  }
  return d->scatter <= fmax(WORST_SCATTER * d->radius, 1.0) && d->x - d->radius > -1.0 &&
         d->y - d->radius > -1.0 && d->x + d->radius < f->width && d->y + d->radius < f->height;
}

/* ---------------------------------------------------------------- levels */

/* Eight times the median contrast, which is noise: nearly all of the picture is empty. */
static double noise_of(const struct em_disc_field *f) {
  const size_t pixels = (size_t)f->width * (size_t)f->height;
  size_t histogram[LEVELS] = {0};
  for (size_t p = 0; p < pixels; p++)
    histogram[(int)fmin((double)f->contrast[p] * (LEVELS / 256), LEVELS - 1)]++;
  size_t sum = histogram[0];
  int median = 0;
  while (2 * sum < pixels)
    sum += histogram[++median];
  return 8.0 * (median + 0.5) * (256.0 / LEVELS);
}

static bool largest_at(const struct em_disc_field *f, double level, double tolerance,
                       struct em_disc *disc) {
  disc->radius = SMALLEST;
  bool found = false;
  memset(f->mark, 0, (size_t)f->width * (size_t)f->height);
  for (int y = 0; y < f->height; y++)
    for (int x = 0; x < f->width; x++) {
      if (!is_in(f, level, x, y) || is_in(f, level, x - 1, y) ||
          f->mark[(size_t)y * (size_t)f->width + (size_t)x])
        continue;
      const struct outline o = follow(f, level, x, y);
      if (o.length < SMALLEST_CHAIN) continue;
      const struct em_disc d = disc_of(&o);
      if (fabs(d.roundness - 1.0) > tolerance || d.radius <= disc->radius) continue;
      *disc = d;
      found = true;
    }
  return found;
}

bool em_track_disc_find(const struct em_disc_field *field, double tolerance, struct em_disc *disc) {
  for (double level = fmax(noise_of(field), FAINTEST); level < 256.0; level *= 2.0)
    if (largest_at(field, level, tolerance, disc) && measure(field, level, disc)) return true;
  return false;
}
