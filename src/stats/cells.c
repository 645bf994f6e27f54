/* Cells of a drum: sectors of equal volume and rings of equal cross-section. */
#include "eventmill/cells.h"

#include <math.h>
#include <stdlib.h>

static struct em_cells *allocate(double radius, double length, size_t tubes) {
  if (!(radius > 0.0) || !(length > 0.0) || tubes < 1) return NULL;
  struct em_cells *cells = calloc(1, sizeof *cells);
  if (!cells) return NULL;
  cells->radius = radius;
  cells->length = length;
  cells->tubes = tubes;
  cells->edge = calloc(tubes + 1, sizeof *cells->edge);
  cells->in_tube = calloc(tubes, sizeof *cells->in_tube);
  cells->first = calloc(tubes, sizeof *cells->first);
  if (cells->edge && cells->in_tube && cells->first) return cells;
  em_cells_free(cells);
  return NULL;
}

void em_cells_free(struct em_cells *cells) {
  if (!cells) return;
  free(cells->edge);
  free(cells->in_tube);
  free(cells->first);
  free(cells);
}

/* With N sectors left for the t innermost tubes out to radius r: r² is proportional to N, and equal
 * widths would leave (1 − 1/t)² N to the tubes further in. */
static void divide(struct em_cells *cells, size_t sectors) {
  size_t left = sectors;
  cells->edge[cells->tubes] = cells->radius;
  for (size_t t = cells->tubes; t-- > 0;) {
    const double inner = 1.0 - 1.0 / ((double)t + 1.0);
    size_t rest = (size_t)lround(inner * inner * (double)left);
    if (rest < t) rest = t; /* one at least for each */
    if (rest > left - 1) rest = left - 1;
    if (t == 0) rest = 0;
    cells->in_tube[t] = left - rest;
    cells->first[t] = rest;
    cells->edge[t] = cells->radius * sqrt((double)rest / (double)sectors);
    left = rest;
  }
}

struct em_cells *em_cells_sectors(double radius, double length, size_t tubes, size_t sectors,
                                  size_t slices) {
  if (sectors < tubes || slices < 1) return NULL;
  struct em_cells *cells = allocate(radius, length, tubes);
  if (!cells) return NULL;
  cells->kind = EM_CELLS_SECTORS;
  cells->slices = slices;
  cells->per_slice = sectors;
  cells->count = sectors * slices;
  divide(cells, sectors);
  return cells;
}

struct em_cells *em_cells_rings(double radius, double length, size_t least) {
  if (least < 1 || !(radius > 0.0) || !(length > 0.0)) return NULL;
  const double side = sqrt(radius * length / (double)least);
  const size_t tubes = (size_t)fmax(1.0, ceil(radius / side - 1e-9));
  const size_t columns = (size_t)fmax(1.0, ceil(length / side - 1e-9));
  struct em_cells *cells = allocate(radius, length, tubes);
  if (!cells) return NULL;
  cells->kind = EM_CELLS_RINGS;
  cells->slices = 1;
  cells->columns = columns;
  cells->count = cells->per_slice = tubes * columns;
  for (size_t t = 0; t <= tubes; t++)
    cells->edge[t] = radius * (double)t / (double)tubes;
  for (size_t t = 0; t < tubes; t++) {
    cells->in_tube[t] = columns;
    cells->first[t] = t * columns;
  }
  return cells;
}

/* The tubes are nearly of equal width: from where it would be then, a step or two. */
static size_t tube_of(const struct em_cells *cells, double r) {
  const size_t last = cells->tubes - 1, guess = (size_t)(r / cells->radius * (double)cells->tubes);
  size_t t = guess < last ? guess : last;
  while (t > 0 && r < cells->edge[t])
    t--;
  while (t < last && r >= cells->edge[t + 1])
    t++;
  return t;
}

/* Part `x` of n equal parts, for x in [0, 1]; the end belongs to the last. */
static size_t part(double x, size_t n) {
  const size_t k = (size_t)(x * (double)n);
  return k < n ? k : n - 1;
}

size_t em_cells_find(const struct em_cells *cells, double x, double y, double z) {
  const double r = sqrt(x * x + z * z), slack = 1e-6;
  double u = y / cells->length;
  if (!(r <= cells->radius * (1.0 + slack)) || !(fabs(u - 0.5) <= 0.5 + slack)) return cells->count;
  u = u < 0.0 ? 0.0 : u > 1.0 ? 1.0 : u;
  const size_t t = tube_of(cells, r);
  if (cells->kind == EM_CELLS_RINGS) return cells->first[t] + part(u, cells->columns);
  double angle = atan2(z, x) / (2.0 * M_PI);
  if (angle < 0.0) angle += 1.0;
  return part(u, cells->slices) * cells->per_slice + cells->first[t] +
         part(angle, cells->in_tube[t]);
}

void em_cells_bounds(const struct em_cells *cells, size_t k, double low[3], double high[3]) {
  const size_t slice = k / cells->per_slice, within = k % cells->per_slice;
  size_t t = 0;
  while (!(within >= cells->first[t] && within < cells->first[t] + cells->in_tube[t]))
    t++;
  const double place = (double)(within - cells->first[t]), n = (double)cells->in_tube[t];
  low[0] = cells->edge[t];
  high[0] = cells->edge[t + 1];
  if (cells->kind == EM_CELLS_RINGS) {
    low[1] = 0.0;
    high[1] = 2.0 * M_PI;
    low[2] = cells->length * place / n;
    high[2] = cells->length * (place + 1.0) / n;
    return;
  }
  low[1] = 2.0 * M_PI * place / n;
  high[1] = 2.0 * M_PI * (place + 1.0) / n;
  low[2] = cells->length * (double)slice / (double)cells->slices;
  high[2] = cells->length * (double)(slice + 1) / (double)cells->slices;
}

double em_cells_volume(const struct em_cells *cells, size_t k) {
  double low[3], high[3];
  em_cells_bounds(cells, k, low, high);
  return 0.5 * (high[1] - low[1]) * (high[0] * high[0] - low[0] * low[0]) * (high[2] - low[2]);
}
