/* Walls, blades and a grid of cells: what a ball must not overlap when it is placed. */
#include "scene/start_field.h"

#include <math.h>
#include <stdlib.h>

static void collect_blades(struct em_start_field *f) {
  for (size_t r = 0; r < f->scene->rotor_count; ++r)
    for (size_t b = 0; b < f->scene->rotor[r].blade_count; ++b) {
      struct em_blade *blade = &f->blade[f->blade_count++];
      *blade = f->scene->rotor[r].blade[b];
      if (blade->tip == EM_TIP_NONE) blade->tip = EM_TIP_FLAT;
    }
}

static double largest_radius(const struct em_balls *balls) {
  double r = 0.0;
  for (size_t k = 0; k < balls->count; ++k)
    r = fmax(r, balls->radius[k]);
  return r;
}

/* Cells at least as wide as the largest ball, and not many more than balls. */
static void choose_cells(struct em_start_field *f) {
  double most = 2.0 * (double)f->balls->count + 64.0;
  double side = 2.0 * largest_radius(f->balls) * (1.0 + 1e-6);
  side = fmax(side, cbrt(f->size.x * f->size.y * f->size.z / most));
  const double size[3] = {f->size.x, f->size.y, f->size.z};
  for (int k = 0; k < 3; ++k) {
    double n = floor(size[k] / side);
    f->cells[k] = n < 1.0 ? 1 : n > 1e6 ? 1000000 : (int32_t)n;
  }
  f->per_length = em_vec_make(f->cells[0] / size[0], f->cells[1] / size[1], f->cells[2] / size[2]);
}

static size_t cell_count(const struct em_start_field *f) {
  return (size_t)f->cells[0] * (size_t)f->cells[1] * (size_t)f->cells[2];
}

enum em_status em_start_field_make(struct em_start_field *field, const struct em_scene *scene,
                                   struct em_balls *balls, struct em_error *err) {
  *field = (struct em_start_field){.scene = scene, .balls = balls};
  em_scene_bounds(scene, &field->low, &field->high);
  field->size = em_vec_sub(field->high, field->low);
  field->drum = scene->chamber.shape == EM_SHAPE_DRUM;
  for (int k = 0; k < 3; ++k)
    field->periodic[k] = !field->drum && scene->chamber.periodic[k];
  choose_cells(field);
  field->blade = calloc(em_scene_blade_count(scene) + 1, sizeof *field->blade);
  field->head = malloc(cell_count(field) * sizeof *field->head);
  field->next = malloc((balls->count + 1) * sizeof *field->next);
  if (!field->blade || !field->head || !field->next) {
    em_start_field_free(field);
    return em_error_set(err, EM_MEMORY, NULL, 0, "no memory to place %zu balls", balls->count);
  }
  collect_blades(field);
  em_start_field_clear(field);
  return EM_OK;
}

void em_start_field_free(struct em_start_field *field) {
  free(field->blade);
  free(field->head);
  free(field->next);
  *field = (struct em_start_field){0};
}

bool em_start_field_stops(const struct em_start_field *field) {
  return field->stop && *field->stop;
}

enum em_status em_start_field_stopped(struct em_error *err) {
  return em_error_set(err, EM_STOPPED, NULL, 0, "stopped while the balls were being placed");
}

void em_start_field_clear(struct em_start_field *field) {
  size_t cells = cell_count(field);
  for (size_t c = 0; c < cells; ++c)
    field->head[c] = -1;
}

/* The cell along one direction; positions beyond the walls belong to the outermost. */
static int32_t cell_along(double x, double low, double per_length, int32_t cells) {
  double c = floor((x - low) * per_length);
  return c < 0.0 ? 0 : c >= cells ? cells - 1 : (int32_t)c;
}

static void cell_of(const struct em_start_field *f, struct em_vec r, int32_t c[3]) {
  c[0] = cell_along(r.x, f->low.x, f->per_length.x, f->cells[0]);
  c[1] = cell_along(r.y, f->low.y, f->per_length.y, f->cells[1]);
  c[2] = cell_along(r.z, f->low.z, f->per_length.z, f->cells[2]);
}

static size_t cell_index(const struct em_start_field *f, int32_t x, int32_t y, int32_t z) {
  return ((size_t)z * (size_t)f->cells[1] + (size_t)y) * (size_t)f->cells[0] + (size_t)x;
}

size_t em_start_field_cell(const struct em_start_field *field, struct em_vec r) {
  int32_t c[3];
  cell_of(field, r, c);
  return cell_index(field, c[0], c[1], c[2]);
}

void em_start_field_put(struct em_start_field *field, size_t k) {
  size_t cell = em_start_field_cell(field, field->balls->position[k]);
  field->next[k] = field->head[cell];
  field->head[cell] = (int32_t)k;
}

struct em_vec em_start_field_between(const struct em_start_field *field, struct em_vec a,
                                     struct em_vec b) {
  struct em_vec d = em_vec_sub(a, b);
  if (field->periodic[0]) d.x -= field->size.x * rint(d.x / field->size.x);
  if (field->periodic[1]) d.y -= field->size.y * rint(d.y / field->size.y);
  if (field->periodic[2]) d.z -= field->size.z * rint(d.z / field->size.z);
  return d;
}

/* x in [0, length), also where rounding would make it length. */
static double wrap_along(double x, double length) {
  x -= length * floor(x / length);
  return x < length ? x : 0.0;
}

struct em_vec em_start_field_wrap(const struct em_start_field *field, struct em_vec r) {
  if (field->periodic[0]) r.x = wrap_along(r.x, field->size.x);
  if (field->periodic[1]) r.y = wrap_along(r.y, field->size.y);
  if (field->periodic[2]) r.z = wrap_along(r.z, field->size.z);
  return r;
}

double em_start_field_wall_gap(const struct em_start_field *field, struct em_vec r, double radius) {
  const double at[3] = {r.x, r.y, r.z};
  const double low[3] = {field->low.x, field->low.y, field->low.z};
  const double high[3] = {field->high.x, field->high.y, field->high.z};
  double gap = INFINITY;
  for (int k = 0; k < 3; ++k)
    if (!field->periodic[k]) gap = fmin(gap, fmin(at[k] - low[k], high[k] - at[k]) - radius);
  if (field->drum)
    gap = fmin(gap, 0.5 * field->scene->chamber.diameter - sqrt(r.x * r.x + r.z * r.z) - radius);
  return gap;
}

double em_start_field_blade_gap(const struct em_start_field *field, struct em_vec r, double radius,
                                const struct em_blade **nearest) {
  double least = INFINITY;
  for (size_t k = 0; k < field->blade_count; ++k) {
    const struct em_blade *blade = &field->blade[k];
    /* Farther along the rotor's axis than the blade is thick: no contact. */
    double along = fabs(em_vec_dot(em_vec_sub(r, blade->centre), blade->axis));
    if (along > 2.0 * radius + blade->radius) continue;
    double gap = em_surface_blade_gap(blade, r, radius, blade->angle);
    if (gap >= least) continue;
    least = gap;
    if (nearest) *nearest = blade;
  }
  return least;
}

/* The cells c-1, c, c+1, across a periodic boundary or up to the wall; each once. */
static int around(int32_t c, int32_t cells, bool periodic, int32_t list[3]) {
  int n = 0;
  for (int32_t d = -1; d <= 1; ++d) {
    int32_t k = c + d;
    if (periodic)
      k = (k + cells) % cells;
    else if (k < 0 || k >= cells)
      continue;
    bool seen = false;
    for (int i = 0; i < n; ++i)
      seen = seen || list[i] == k;
    if (!seen) list[n++] = k;
  }
  return n;
}

bool em_start_field_each(const struct em_start_field *field, struct em_vec r,
                         bool (*visit)(void *self, size_t k), void *self) {
  int32_t c[3], list[3][3];
  int n[3];
  cell_of(field, r, c);
  for (int k = 0; k < 3; ++k)
    n[k] = around(c[k], field->cells[k], field->periodic[k], list[k]);
  for (int z = 0; z < n[2]; ++z)
    for (int y = 0; y < n[1]; ++y)
      for (int x = 0; x < n[0]; ++x) {
        size_t cell = cell_index(field, list[0][x], list[1][y], list[2][z]);
        for (int32_t k = field->head[cell]; k >= 0; k = field->next[k])
          if (!visit(self, (size_t)k)) return false;
      }
  return true;
}

struct candidate {
  const struct em_start_field *field;
  struct em_vec r;
  double radius, clearance;
  size_t self;
};

static bool keeps_away(void *self, size_t k) {
  const struct candidate *c = self;
  if (k == c->self) return true;
  struct em_vec d = em_start_field_between(c->field, c->r, c->field->balls->position[k]);
  double sigma = (c->radius + c->field->balls->radius[k]) * (1.0 + c->clearance);
  return em_vec_norm2(d) >= sigma * sigma;
}

bool em_start_field_fits(const struct em_start_field *field, size_t k, struct em_vec r,
                         double clearance) {
  double radius = field->balls->radius[k], room = clearance * radius;
  struct candidate c = {field, r, radius, clearance, k};
  return em_start_field_wall_gap(field, r, radius) >= room &&
         em_start_field_each(field, r, keeps_away, &c) &&
         em_start_field_blade_gap(field, r, radius, NULL) >= room;
}
