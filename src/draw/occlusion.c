/* Ambient occlusion among spheres: neighbours by a grid of cubes, summed into a linear law. */
#include "draw/occlusion.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

struct grid {
  float low[3], cell, reach;
  int size[3];
};

enum { MOST_PER_SIDE = 96 };

static struct grid grid_of(const struct em_sphere *sphere, size_t count) {
  struct grid g = {{INFINITY, INFINITY, INFINITY}, 0.0F, 0.0F, {1, 1, 1}};
  float high[3] = {-INFINITY, -INFINITY, -INFINITY};
  for (size_t k = 0; k < count; k++) {
    g.reach = fmaxf(g.reach, 4.0F * sphere[k].radius);
    for (int a = 0; a < 3; a++) {
      g.low[a] = fminf(g.low[a], sphere[k].place[a]);
      high[a] = fmaxf(high[a], sphere[k].place[a]);
    }
  }
  g.cell = g.reach;
  for (int a = 0; a < 3; a++)
    g.cell = fmaxf(g.cell, (high[a] - g.low[a]) / MOST_PER_SIDE);
  for (int a = 0; a < 3 && g.cell > 0.0F; a++)
    g.size[a] = 1 + (int)((high[a] - g.low[a]) / g.cell);
  return g;
}

static int cell_along(const struct grid *g, const float *place, int axis) {
  const int k = g->cell > 0.0F ? (int)((place[axis] - g->low[axis]) / g->cell) : 0;
  return k < 0 ? 0 : k >= g->size[axis] ? g->size[axis] - 1 : k;
}

static size_t cell_of(const struct grid *g, const float *place) {
  const size_t x = (size_t)cell_along(g, place, 0), y = (size_t)cell_along(g, place, 1);
  return (x * (size_t)g->size[1] + y) * (size_t)g->size[2] + (size_t)cell_along(g, place, 2);
}

static int make_room(struct em_occlusion *space, size_t cells, size_t spheres) {
  if (cells > space->cells) {
    unsigned *more = realloc(space->first, (cells + 1) * sizeof *more);
    if (more == NULL) return 0;
    space->first = more;
    space->cells = cells;
  }
  if (spheres > space->spheres) {
    unsigned *more = realloc(space->order, spheres * sizeof *more);
    if (more == NULL) return 0;
    space->order = more;
    space->spheres = spheres;
  }
  return 1;
}

/* Sorts the spheres by cells: those of cell c are order[first[c]] … order[first[c + 1] - 1]. */
static void sort(struct em_occlusion *space, const struct grid *g, size_t cells,
                 const struct em_sphere *sphere, size_t count) {
  memset(space->first, 0, (cells + 1) * sizeof *space->first);
  for (size_t k = 0; k < count; k++)
    space->first[cell_of(g, sphere[k].place)]++;
  unsigned sum = 0;
  for (size_t c = 0; c <= cells; c++) {
    sum += space->first[c];
    space->first[c] = sum;
  }
  for (size_t k = count; k-- > 0;)
    space->order[--space->first[cell_of(g, sphere[k].place)]] = (unsigned)k;
}

static void add(struct em_sphere *to, const struct em_sphere *from, float reach2) {
  float d[3], d2 = 0.0F;
  for (int a = 0; a < 3; a++) {
    d[a] = from->place[a] - to->place[a];
    d2 += d[a] * d[a];
  }
  if (d2 >= reach2 || d2 <= 0.0F) return;
  const float share = from->radius * from->radius / d2;
  const float directed = 0.5F * share / sqrtf(d2);
  for (int a = 0; a < 3; a++)
    to->occlusion[a] += directed * d[a];
  to->occlusion[3] += 0.25F * share;
}

static void add_neighbours(struct em_sphere *to, const struct em_sphere *sphere,
                           const struct em_occlusion *space, const struct grid *g) {
  int low[3], high[3];
  for (int a = 0; a < 3; a++) {
    const int c = cell_along(g, to->place, a);
    low[a] = c > 0 ? c - 1 : 0;
    high[a] = c + 1 < g->size[a] ? c + 1 : c;
  }
  memset(to->occlusion, 0, sizeof to->occlusion);
  for (int x = low[0]; x <= high[0]; x++)
    for (int y = low[1]; y <= high[1]; y++) {
      const size_t row = ((size_t)x * (size_t)g->size[1] + (size_t)y) * (size_t)g->size[2];
      const unsigned begin = space->first[row + (size_t)low[2]];
      const unsigned end = space->first[row + (size_t)high[2] + 1];
      for (unsigned n = begin; n < end; n++)
        add(to, &sphere[space->order[n]], g->reach * g->reach);
    }
}

int em_occlusion_fill(struct em_occlusion *space, struct em_sphere *sphere, size_t count) {
  if (count == 0) return 1;
  const struct grid g = grid_of(sphere, count);
  const size_t cells = (size_t)g.size[0] * (size_t)g.size[1] * (size_t)g.size[2];
  if (!make_room(space, cells, count)) return 0;
  sort(space, &g, cells, sphere, count);
  for (size_t k = 0; k < count; k++)
    add_neighbours(&sphere[k], sphere, space, &g);
  return 1;
}

void em_occlusion_clear(struct em_occlusion *space) {
  free(space->first);
  free(space->order);
  memset(space, 0, sizeof *space);
}
