/* The engine's state in a run file: one dataset per array, attributes for single numbers. */
#include "record/checkpoint.h"

#include <stdio.h>

#include "record/layout.h"

/* An array of a snapshot. */
struct array {
  const char *name, *unit;
  hid_t file, memory; /* types of its numbers */
  size_t count, width;
  void *data;
};

enum { ARRAYS = 12 };

static struct array reals(const char *name, const char *unit, size_t count, size_t width,
                          void *data) {
  return (struct array){name, unit, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, count, width, data};
}

/* Lists the arrays that a snapshot has; returns how many. */
static size_t arrays_of(const struct em_snapshot *s, struct array *list) {
  const size_t n = s->count, b = s->blade_count;
  const hid_t u32 = H5T_STD_U32LE, uint32 = H5T_NATIVE_UINT32;
  size_t k = 0;
  list[k++] = reals("position", "m", n, 3, s->position);
  list[k++] = reals("velocity", "m s-1", n, 3, s->velocity);
  if (s->spin) list[k++] = reals("angular_velocity", "s-1", n, 3, s->spin);
  list[k++] = reals("time", "s", n, 1, s->time);
  list[k++] = (struct array){"last", NULL, u32, uint32, n, 1, s->last};
  list[k++] = (struct array){"streak", NULL, u32, uint32, n, 1, s->streak};
  if (b) list[k++] = reals("blade_angle", "rad", b, 1, s->blade_angle);
  list[k++] = (struct array){"vn",           NULL,          H5T_STD_U64LE,      H5T_NATIVE_UINT64,
                             EM_CLASS_COUNT, EM_TALLY_BINS, (void *)s->tally.vn};
  return k;
}

static void path_of(const struct array *array, char *path, size_t size) {
  snprintf(path, size, EM_LAYOUT_CHECKPOINT "/%s", array->name);
}

static bool same_shape(const struct array *array, const struct em_h5_shape *shape) {
  return shape->rank == (array->width > 1 ? 2 : 1) && shape->dims[0] == array->count &&
         (array->width == 1 || shape->dims[1] == array->width);
}

/* A single number of the tally; count: uint64_t, else double. `work`: a count of the engine's own
 * work, which may differ after a restart. */
struct number {
  const char *name;
  bool is_count, is_work;
  size_t width; /* 0: single */
  void *data;
};

enum { NUMBERS = 24 };

static size_t numbers_of(struct em_snapshot *s, struct number *list) {
  struct em_tally *t = &s->tally;
  size_t k = 0;
  list[k++] = (struct number){"epoch", true, false, 0, &s->epoch};
  list[k++] = (struct number){"clock", false, false, 0, &s->clock};
  list[k++] = (struct number){"collisions", true, false, EM_CLASS_COUNT, t->collisions};
  list[k++] = (struct number){"dissipated", false, false, EM_CLASS_COUNT, t->lost};
  list[k++] =
      (struct number){"collision_energy", false, false, EM_CLASS_COUNT, t->collision_energy};
  list[k++] = (struct number){"drum_work", false, false, 0, &t->drum_work};
  list[k++] = (struct number){"tc", true, false, 0, &t->tc};
  list[k++] = (struct number){"elastic", true, false, 0, &t->elastic};
  list[k++] = (struct number){"jam", true, false, 0, &t->jam};
  list[k++] = (struct number){"stale", true, true, 0, &t->stale};
  list[k++] = (struct number){"transfers", true, true, 0, &t->transfers};
  list[k++] = (struct number){"predictions", true, true, 0, &t->predictions};
  list[k++] = (struct number){"candidates", true, true, 0, &t->candidates};
  list[k++] = (struct number){"blade_searches", true, true, 0, &t->blade_searches};
  list[k++] = (struct number){"blade_steps", true, true, 0, &t->blade_steps};
  list[k++] = (struct number){"epochs", true, true, 0, &t->epochs};
  return k;
}

static const char *home_of(const struct number *number) {
  return number->is_work ? EM_LAYOUT_ENGINE : EM_LAYOUT_CHECKPOINT;
}

static bool put_number(hid_t file, const struct number *number) {
  return em_h5_put_numbers(
      file, home_of(number), number->name, number->is_count ? H5T_STD_U64LE : H5T_IEEE_F64LE,
      number->is_count ? H5T_NATIVE_UINT64 : H5T_NATIVE_DOUBLE, number->width, number->data);
}

static bool get_number(hid_t file, const struct number *number) {
  return em_h5_get_numbers(file, home_of(number), number->name,
                           number->is_count ? H5T_NATIVE_UINT64 : H5T_NATIVE_DOUBLE, number->width,
                           number->data);
}

/* Blades are rows of three numbers; their contacts are exact up to 2^53. */
#define BLADE_PATH EM_LAYOUT_CHECKPOINT "/blade"
enum { BLADE_WIDTH = 3 };

static bool write_blades(hid_t file, const struct em_snapshot *s) {
  bool good = true;
  for (uint32_t k = 0; k < s->blade_count && good; k++) {
    const double row[BLADE_WIDTH] = {s->blade[k].work, s->blade[k].angular_impulse,
                                     (double)s->blade[k].contacts};
    good = em_h5_write_rows(file, BLADE_PATH, H5T_NATIVE_DOUBLE, k, 1, row);
  }
  return good;
}

static bool read_blades(hid_t file, struct em_snapshot *s) {
  struct em_h5_shape shape;
  if (s->blade_count == 0) return true;
  if (!em_h5_shape(file, BLADE_PATH, &shape) || shape.rank != 2 ||
      shape.dims[0] != s->blade_count || shape.dims[1] != BLADE_WIDTH)
    return false;
  bool good = true;
  for (uint32_t k = 0; k < s->blade_count && good; k++) {
    double row[BLADE_WIDTH];
    good = em_h5_read_rows(file, BLADE_PATH, H5T_NATIVE_DOUBLE, k, 1, row) && row[2] >= 0.0 &&
           row[2] < 0x1p53;
    if (good) s->blade[k] = (struct em_blade_tally){row[0], row[1], (uint64_t)row[2]};
  }
  return good;
}

bool em_checkpoint_create(hid_t file, const struct em_snapshot *snapshot) {
  struct array list[ARRAYS];
  const size_t count = arrays_of(snapshot, list);
  bool good = em_h5_group(file, EM_LAYOUT_ENGINE);
  for (size_t i = 0; i < count && good; i++) {
    const struct em_h5_shape shape = {list[i].width > 1 ? 2 : 1, {list[i].count, list[i].width}};
    char path[128];
    path_of(&list[i], path, sizeof path);
    good = em_h5_create(file, path, list[i].file, shape, 0, 0, list[i].unit);
  }
  if (good && snapshot->blade_count) {
    const struct em_h5_shape shape = {2, {0, BLADE_WIDTH}};
    good = em_h5_create(file, BLADE_PATH, H5T_IEEE_F64LE, shape, 64, 0, NULL);
  }
  return good;
}

bool em_checkpoint_write(hid_t file, const struct em_snapshot *snapshot) {
  struct array list[ARRAYS];
  const size_t count = arrays_of(snapshot, list);
  bool good = true;
  for (size_t i = 0; i < count && good; i++) {
    char path[128];
    path_of(&list[i], path, sizeof path);
    good = em_h5_write(file, path, list[i].memory, list[i].data);
  }
  struct em_snapshot copy = *snapshot;
  struct number numbers[NUMBERS];
  const size_t singles = numbers_of(&copy, numbers);
  for (size_t i = 0; i < singles && good; i++)
    good = put_number(file, &numbers[i]);
  return good && write_blades(file, snapshot);
}

static bool read_into(hid_t file, struct em_snapshot *snapshot) {
  struct array list[ARRAYS];
  const size_t count = arrays_of(snapshot, list);
  bool good = true;
  for (size_t i = 0; i < count && good; i++) {
    struct em_h5_shape shape;
    char path[128];
    path_of(&list[i], path, sizeof path);
    good = em_h5_shape(file, path, &shape) && same_shape(&list[i], &shape) &&
           em_h5_read(file, path, list[i].memory, list[i].data);
  }
  struct number numbers[NUMBERS];
  const size_t singles = numbers_of(snapshot, numbers);
  for (size_t i = 0; i < singles && good; i++)
    good = get_number(file, &numbers[i]);
  return good && read_blades(file, snapshot);
}

struct em_snapshot *em_checkpoint_read(hid_t file, const char *name, size_t balls, size_t blades,
                                       bool spin, struct em_error *err) {
  /* The scene may lie about its size: the file must have an array of it before memory is taken. */
  struct em_h5_shape shape;
  if (!em_h5_shape(file, EM_LAYOUT_CHECKPOINT "/time", &shape) || shape.rank != 1 ||
      shape.dims[0] != balls || balls > UINT32_MAX || blades > UINT32_MAX) {
    em_error_set(err, EM_FORMAT, name, 0, "its checkpoint does not fit its scene");
    return NULL;
  }
  struct em_snapshot *snapshot = em_world_snapshot_new((uint32_t)balls, (uint32_t)blades, spin);
  if (!snapshot) {
    em_error_set(err, EM_MEMORY, name, 0, "out of memory");
    return NULL;
  }
  if (read_into(file, snapshot)) return snapshot;
  em_error_set(err, EM_FORMAT, name, 0, "its checkpoint is damaged or missing");
  em_world_snapshot_free(snapshot);
  return NULL;
}
