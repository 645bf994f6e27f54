/* Colour maps: a path through OKLCh, brought into the sRGB gamut, walked in equal steps. */
#include "eventmill/colour.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

/* A station of a path: lightness 0 … 1, chroma, hue in degrees. */
struct station {
  double light, chroma, hue;
};

static const struct station lagoon[] = {
    {0.34, 0.160, 305}, {0.45, 0.155, 280}, {0.56, 0.130, 240},
    {0.66, 0.125, 190}, {0.78, 0.170, 150}, {0.92, 0.190, 105},
};
static const struct station ember[] = {
    {0.25, 0.160, 275}, {0.40, 0.210, 310}, {0.54, 0.220, 355},
    {0.66, 0.190, 30},  {0.78, 0.160, 65},  {0.94, 0.150, 105},
};
static const struct station grey[] = {{0.25, 0, 0}, {0.95, 0, 0}};
static const struct station balance[] = {
    {0.40, 0.150, 255}, {0.70, 0.110, 245}, {0.96, 0, 245},
    {0.96, 0, 35},      {0.70, 0.140, 35},  {0.45, 0.180, 25},
};

struct lab {
  double l, a, b;
};

#define COUNT(array) (sizeof(array) / sizeof((array)[0]))

const char *em_colour_name(enum em_colour which) {
#define NAME(code, text) text,
  static const char *const name[] = {EM_COLOUR_LIST(NAME)};
#undef NAME
  return (unsigned)which < EM_COLOUR_COUNT ? name[which] : "?";
}

int em_colour_find(const char *name) {
  for (int k = 0; k < EM_COLOUR_COUNT; k++)
    if (strcmp(name, em_colour_name((enum em_colour)k)) == 0) return k;
  return -1;
}

/* OKLab to linear sRGB: the inverse of Ottosson's two matrices and cube roots. */
static void linear_from_lab(struct lab c, double rgb[3]) {
  const double l = pow(c.l + 0.3963377774 * c.a + 0.2158037573 * c.b, 3);
  const double m = pow(c.l - 0.1055613458 * c.a - 0.0638541728 * c.b, 3);
  const double s = pow(c.l - 0.0894841775 * c.a - 1.2914855480 * c.b, 3);
  rgb[0] = 4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s;
  rgb[1] = -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s;
  rgb[2] = -0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s;
}

static int is_in_gamut(struct lab c) {
  double rgb[3];
  linear_from_lab(c, rgb);
  for (int k = 0; k < 3; k++)
    if (rgb[k] < 0.0 || rgb[k] > 1.0) return 0;
  return 1;
}

static uint8_t encode(double linear) {
  const double u = linear <= 0.0031308 ? 12.92 * linear : 1.055 * pow(linear, 1 / 2.4) - 0.055;
  return (uint8_t)lround(255.0 * fmin(fmax(u, 0.0), 1.0));
}

static struct lab polar(double light, double chroma, double hue) {
  return (struct lab){light, chroma * cos(hue), chroma * sin(hue)};
}

/* The colour at s in [0, 1] along the stations; its chroma is lowered until sRGB can show it. */
static struct lab path_at(const struct station *station, size_t count, double s) {
  const double place = s * (double)(count - 1);
  const size_t k = place >= (double)(count - 1) ? count - 2 : (size_t)place;
  const double u = place - (double)k;
  const struct station p = station[k], q = station[k + 1];
  double turn = q.hue - p.hue;
  if (turn > 180.0) turn -= 360.0;
  if (turn < -180.0) turn += 360.0;
  const double hue = (p.hue + u * turn) * M_PI / 180.0;
  const double light = p.light + u * (q.light - p.light);
  double low = 0.0, high = p.chroma + u * (q.chroma - p.chroma);
  if (is_in_gamut(polar(light, high, hue))) return polar(light, high, hue);
  for (int step = 0; step < 30; step++) {
    const double middle = 0.5 * (low + high);
    if (is_in_gamut(polar(light, middle, hue)))
      low = middle;
    else
      high = middle;
  }
  return polar(light, low, hue);
}

static double distance(struct lab p, struct lab q) {
  return sqrt((p.l - q.l) * (p.l - q.l) + (p.a - q.a) * (p.a - q.a) + (p.b - q.b) * (p.b - q.b));
}

/* Walks the path in so many places with equal distances between them. */
static void walk(const struct station *station, size_t count, uint8_t (*rgb)[3], int steps) {
  enum { FINE = 4096 };
  double whole = 0.0;
  struct lab before = path_at(station, count, 0.0);
  for (int k = 1; k <= FINE; k++) {
    const struct lab here = path_at(station, count, k / (double)FINE);
    whole += distance(before, here);
    before = here;
  }
  double gone = 0.0;
  int fine = 0;
  before = path_at(station, count, 0.0);
  for (int n = 0; n < steps; n++) {
    const double goal = whole * n / (steps - 1);
    while (fine < FINE && gone < goal) {
      const struct lab here = path_at(station, count, ++fine / (double)FINE);
      gone += distance(before, here);
      before = here;
    }
    double light[3];
    linear_from_lab(before, light);
    for (int k = 0; k < 3; k++)
      rgb[n][k] = encode(light[k]);
  }
}

void em_colour_make(enum em_colour which, struct em_colour_map *map) {
  switch (which) {
  case EM_COLOUR_EMBER:
    walk(ember, COUNT(ember), map->rgb, EM_COLOUR_STEPS);
    break;
  case EM_COLOUR_GREY:
    walk(grey, COUNT(grey), map->rgb, EM_COLOUR_STEPS);
    break;
  case EM_COLOUR_BALANCE:
    /* Each side by itself, so that the middle is white. */
    walk(balance, 3, map->rgb, EM_COLOUR_STEPS / 2);
    walk(balance + 3, 3, map->rgb + EM_COLOUR_STEPS / 2, EM_COLOUR_STEPS / 2);
    break;
  case EM_COLOUR_LAGOON:
  case EM_COLOUR_COUNT:
  default:
    walk(lagoon, COUNT(lagoon), map->rgb, EM_COLOUR_STEPS);
  }
}

const uint8_t *em_colour_at(const struct em_colour_map *map, double value, double low,
                            double high) {
  const double u = high > low ? (value - low) / (high - low) : 0.0;
  if (!(u > 0.0)) return map->rgb[0];
  if (u >= 1.0) return map->rgb[EM_COLOUR_STEPS - 1];
  return map->rgb[(size_t)(u * EM_COLOUR_STEPS)];
}

const uint8_t *em_colour_cycle(unsigned k) {
  static const uint8_t cycle[][3] = {
      {0x1f, 0x5f, 0xa8}, {0xd9, 0x5f, 0x0e}, {0x1b, 0x8a, 0x5a}, {0xb8, 0x32, 0x70},
      {0x6a, 0x4c, 0xa5}, {0x8c, 0x6d, 0x1f}, {0x2a, 0x9d, 0xb5}, {0x5b, 0x60, 0x6b},
  };
  return cycle[k % COUNT(cycle)];
}
