/* Fills groups of a scene by their tables, and the parts of the scene that are plain groups. */
#include "scene/scene_fill.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { EXPECTED = 400 };

double em_scene_fill_omega(double rpm) {
  return rpm * (2.0 * M_PI / 60.0);
}

double em_scene_fill_radians(double degrees) {
  return degrees * (M_PI / 180.0);
}

struct em_vec em_scene_fill_unit(struct em_vec direction) {
  double n2 = em_vec_norm2(direction);
  /* A vector of this kind that is read back keeps its bits. */
  if (fabs(n2 - 1.0) <= 1e-15) return direction;
  double n = hypot(hypot(direction.x, direction.y), direction.z);
  return em_vec_make(direction.x / n, direction.y / n, direction.z / n);
}

struct em_vec em_scene_fill_upright(struct em_vec axis) {
  struct em_vec up = fabs(axis.z) < 0.9 ? em_vec_make(0, 0, 1) : em_vec_make(1, 0, 0);
  return em_scene_fill_unit(em_vec_axpy(up, -em_vec_dot(up, axis), axis));
}

void em_scene_fill_mismatch(struct em_scene_report *report, const config_setting_t *setting,
                            const char *expected) {
  char found[128];
  em_scene_report_value(setting, sizeof found, found);
  em_scene_report_at(report, setting, "found %s, expected %s", found, expected);
}

void em_scene_fill_missing(struct em_scene_report *report, const config_setting_t *group,
                           const struct em_scene_table *table, const char *name) {
  char expected[EXPECTED];
  em_scene_table_expects(em_scene_table_find(table, name), sizeof expected, expected);
  em_scene_report_at(report, group, "\"%s\" is missing, expected %s", name, expected);
}

static bool is_integer(const config_setting_t *setting) {
  int type = config_setting_type(setting);
  return type == CONFIG_TYPE_INT || type == CONFIG_TYPE_INT64;
}

bool em_scene_fill_number(struct em_scene_report *report, const config_setting_t *setting,
                          const char *expected, double *value) {
  double x = NAN;
  if (is_integer(setting))
    x = (double)config_setting_get_int64(setting);
  else if (config_setting_type(setting) == CONFIG_TYPE_FLOAT)
    x = config_setting_get_float(setting);
  if (!isfinite(x)) {
    em_scene_fill_mismatch(report, setting, expected);
    return false;
  }
  *value = x;
  return true;
}

bool em_scene_fill_vector(struct em_scene_report *report, const config_setting_t *setting,
                          const char *expected, struct em_vec *value) {
  int type = config_setting_type(setting);
  if ((type != CONFIG_TYPE_LIST && type != CONFIG_TYPE_ARRAY) ||
      config_setting_length(setting) != 3) {
    em_scene_fill_mismatch(report, setting, expected);
    return false;
  }
  double x[3];
  for (unsigned k = 0; k < 3; ++k)
    if (!em_scene_fill_number(report, config_setting_get_elem(setting, k), expected, &x[k]))
      return false;
  *value = em_vec_make(x[0], x[1], x[2]);
  return true;
}

static int spelt(const struct em_scene_entry *entry, const char *name) {
  for (int k = 0; entry->names[k]; ++k)
    if (strcmp(entry->names[k], name) == 0) return k;
  return -1;
}

static bool in_range(const struct em_scene_entry *entry, double x) {
  if (entry->names) {
    char text[32];
    snprintf(text, sizeof text, "%.0f", x);
    return spelt(entry, text) >= 0;
  }
  return x >= entry->low && x <= entry->high && !(entry->above && x == entry->low);
}

/* Stores a number in the type that the entry has. */
static void store(const struct em_scene_entry *entry, double x, void *out) {
  switch (entry->kind) {
  case EM_KIND_DEGREES:
    x = em_scene_fill_radians(x);
    memcpy(out, &x, sizeof x);
    break;
  case EM_KIND_REAL:
    memcpy(out, &x, sizeof x);
    break;
  case EM_KIND_INTEGER:
    memcpy(out, &(int){(int)x}, sizeof(int));
    break;
  case EM_KIND_COUNT:
    memcpy(out, &(size_t){(size_t)x}, sizeof(size_t));
    break;
  case EM_KIND_U32:
    memcpy(out, &(uint32_t){(uint32_t)x}, sizeof(uint32_t));
    break;
  case EM_KIND_U64:
    memcpy(out, &(uint64_t){(uint64_t)x}, sizeof(uint64_t));
    break;
  default:
    break;
  }
}

static void fill_name(struct em_scene_report *report, const struct em_scene_entry *entry,
                      const config_setting_t *setting, const char *expected, void *out) {
  const char *name = config_setting_get_string(setting);
  int k = name ? spelt(entry, name) : -1;
  if (k >= 0) {
    memcpy(out, &k, sizeof k);
    return;
  }
  size_t count = 0;
  while (entry->names[count])
    ++count;
  const char *near = name ? em_scene_table_nearest(name, count, entry->names) : NULL;
  if (near)
    em_scene_report_at(report, setting, "unknown \"%.60s\", expected %s; did you mean \"%s\"?",
                       name, expected, near);
  else
    em_scene_fill_mismatch(report, setting, expected);
}

static void fill_text(struct em_scene_report *report, const struct em_scene_entry *entry,
                      const config_setting_t *setting, const char *expected, void *out) {
  const char *text = config_setting_get_string(setting);
  if (text && strlen(text) < entry->size)
    strcpy(out, text);
  else
    em_scene_fill_mismatch(report, setting, expected);
}

static void fill_number(struct em_scene_report *report, const struct em_scene_entry *entry,
                        const config_setting_t *setting, const char *expected, void *out) {
  bool real = entry->kind == EM_KIND_REAL || entry->kind == EM_KIND_DEGREES;
  double x;
  if (!real && !is_integer(setting))
    em_scene_fill_mismatch(report, setting, expected);
  else if (em_scene_fill_number(report, setting, expected, &x)) {
    if (in_range(entry, x))
      store(entry, x, out);
    else
      em_scene_fill_mismatch(report, setting, expected);
  }
}

static void fill_vector(struct em_scene_report *report, const struct em_scene_entry *entry,
                        const config_setting_t *setting, const char *expected, void *out) {
  struct em_vec v;
  if (!em_scene_fill_vector(report, setting, expected, &v)) return;
  if (in_range(entry, v.x) && in_range(entry, v.y) && in_range(entry, v.z))
    memcpy(out, &v, sizeof v);
  else
    em_scene_report_at(report, setting, "found (%.10g, %.10g, %.10g), expected %s", v.x, v.y, v.z,
                       expected);
}

static void fill_entry(struct em_scene_report *report, const struct em_scene_entry *entry,
                       const config_setting_t *setting, void *out) {
  char expected[EXPECTED];
  em_scene_table_expects(entry, sizeof expected, expected);
  switch (entry->kind) {
  case EM_KIND_SPECIAL:
    break;
  case EM_KIND_BOOLEAN:
    if (config_setting_type(setting) == CONFIG_TYPE_BOOL)
      *(bool *)out = config_setting_get_bool(setting) != 0;
    else
      em_scene_fill_mismatch(report, setting, expected);
    break;
  case EM_KIND_NAME:
    fill_name(report, entry, setting, expected, out);
    break;
  case EM_KIND_TEXT:
    fill_text(report, entry, setting, expected, out);
    break;
  case EM_KIND_VECTOR:
    fill_vector(report, entry, setting, expected, out);
    break;
  default:
    fill_number(report, entry, setting, expected, out);
    break;
  }
}

/* The default of an entry that has one. */
static void fill_default(const struct em_scene_entry *entry, void *out) {
  if (!entry->fallback) return;
  struct em_vec v;
  int k;
  switch (entry->kind) {
  case EM_KIND_SPECIAL:
    break;
  case EM_KIND_BOOLEAN:
    *(bool *)out = strcmp(entry->fallback, "true") == 0;
    break;
  case EM_KIND_NAME:
    k = spelt(entry, entry->fallback);
    memcpy(out, &k, sizeof k);
    break;
  case EM_KIND_TEXT:
    strcpy(out, entry->fallback);
    break;
  case EM_KIND_VECTOR:
    sscanf(entry->fallback, "[%lf, %lf, %lf]", &v.x, &v.y, &v.z);
    memcpy(out, &v, sizeof v);
    break;
  default:
    store(entry, strtod(entry->fallback, NULL), out);
    break;
  }
}

static void report_unknown(struct em_scene_report *report, const struct em_scene_table *table,
                           const config_setting_t *setting) {
  const char *names[32] = {NULL};
  size_t count = 0;
  for (; count < table->count && count < 32; ++count)
    names[count] = table->entry[count].name;
  const char *name = config_setting_name(setting);
  const char *near = em_scene_table_nearest(name, count, names);
  if (near) {
    em_scene_report_at(report, setting, "unknown entry, expected \"%s\"?", near);
    return;
  }
  char all[EXPECTED] = "";
  for (size_t k = 0; k < count; ++k)
    snprintf(all + strlen(all), sizeof all - strlen(all), "%s%s", k > 0 ? ", " : "", names[k]);
  em_scene_report_at(report, setting, "unknown entry, expected one of: %s", all);
}

void em_scene_fill_group(struct em_scene_report *report, const struct em_scene_table *table,
                         const config_setting_t *group, void *out) {
  for (size_t k = 0; k < table->count; ++k)
    fill_default(&table->entry[k], (char *)out + table->entry[k].offset);
  if (!group) return;
  if (config_setting_type(group) != CONFIG_TYPE_GROUP) {
    em_scene_fill_mismatch(report, group, "a group { }");
    return;
  }
  for (int k = 0; k < config_setting_length(group); ++k) {
    const config_setting_t *setting = config_setting_get_elem(group, (unsigned)k);
    const struct em_scene_entry *entry = em_scene_table_find(table, config_setting_name(setting));
    if (entry)
      fill_entry(report, entry, setting, (char *)out + entry->offset);
    else
      report_unknown(report, table, setting);
  }
}

/* A vector, or "none". */
static void fill_gravity(struct em_scene_report *report, struct em_scene *scene) {
  const config_setting_t *setting = config_lookup(report->tree, "gravity");
  scene->gravity = em_vec_make(0.0, 0.0, -9.81);
  if (!setting) return;
  const char *name = config_setting_get_string(setting);
  if (name && strcmp(name, "none") == 0)
    scene->gravity = em_vec_make(0.0, 0.0, 0.0);
  else
    em_scene_fill_vector(report, setting, "three numbers [x, y, z] (m/s²) or \"none\"",
                         &scene->gravity);
}

/* true, false, or three of these. */
static void fill_periodic(struct em_scene_report *report, const config_setting_t *setting,
                          bool periodic[3]) {
  const char *expected = "true, false, or three of these for x, y, z";
  if (config_setting_type(setting) == CONFIG_TYPE_BOOL) {
    for (int k = 0; k < 3; ++k)
      periodic[k] = config_setting_get_bool(setting) != 0;
    return;
  }
  int type = config_setting_type(setting);
  bool good = (type == CONFIG_TYPE_LIST || type == CONFIG_TYPE_ARRAY) &&
              config_setting_length(setting) == 3;
  for (unsigned k = 0; good && k < 3; ++k) {
    const config_setting_t *one = config_setting_get_elem(setting, k);
    good = config_setting_type(one) == CONFIG_TYPE_BOOL;
    periodic[k] = good && config_setting_get_bool(one) != 0;
  }
  if (!good) em_scene_fill_mismatch(report, setting, expected);
}

/* Entries that belong to the other shape of chamber are errors; those of its own are needed. */
static void match_shape(struct em_scene_report *report, const config_setting_t *group,
                        enum em_shape shape) {
  static const struct {
    const char *name;
    enum em_shape shape;
    bool needed;
  } belongs[] = {{"diameter", EM_SHAPE_DRUM, true}, {"length", EM_SHAPE_DRUM, true},
                 {"facets", EM_SHAPE_DRUM, false},  {"rpm", EM_SHAPE_DRUM, false},
                 {"ramps", EM_SHAPE_DRUM, false},   {"size", EM_SHAPE_BOX, true},
                 {"periodic", EM_SHAPE_BOX, false}};
  for (size_t k = 0; k < sizeof belongs / sizeof belongs[0]; ++k) {
    const config_setting_t *setting = config_setting_get_member(group, belongs[k].name);
    if (setting && belongs[k].shape != shape)
      em_scene_report_at(report, setting,
                         "does not belong to a chamber of shape \"%s\", expected "
                         "it only where shape = \"%s\"",
                         em_scene_shape_name(shape), em_scene_shape_name(belongs[k].shape));
    if (!setting && belongs[k].shape == shape && belongs[k].needed)
      em_scene_fill_missing(report, group, &em_scene_table_chamber, belongs[k].name);
  }
}

static void fill_chamber(struct em_scene_report *report, struct em_chamber *chamber) {
  const config_setting_t *group = config_lookup(report->tree, "chamber");
  size_t before = report->errors;
  em_scene_fill_group(report, &em_scene_table_chamber, group, chamber);
  struct em_scene_ramps ramps = {0};
  const config_setting_t *inner = NULL, *periodic = NULL;
  bool is_group = group && config_setting_is_group(group);
  if (is_group) {
    inner = config_setting_get_member(group, "ramps");
    periodic = config_setting_get_member(group, "periodic");
  }
  em_scene_fill_group(report, &em_scene_table_ramps, inner, &ramps);
  chamber->ramp_half = ramps.half;
  chamber->ramp_tilt = ramps.tilt;
  if (periodic) fill_periodic(report, periodic, chamber->periodic);
  if (!group)
    em_scene_report_at(report, config_root_setting(report->tree),
                       "\"chamber\" is missing, expected a group { shape; ... }");
  else if (is_group && report->errors == before)
    match_shape(report, group, chamber->shape);
}

static void fill_plain(struct em_scene_report *report, const struct em_scene_table *table,
                       void *out) {
  em_scene_fill_group(report, table, config_lookup(report->tree, table->path), out);
}

/* The levels of accuracy: docs/accuracy.md has what each costs. */
static const struct em_roots levels[EM_ACCURACY_COUNT] = {
    [EM_ACCURACY_STANDARD] = {.blade_step = 0.1},
    [EM_ACCURACY_FAST] = {.blade_step = 0.1, .tolerance = 1e-6},
    [EM_ACCURACY_REFERENCE] = {.blade_step = 0.1, .polish = EM_POLISH_QUAD},
};

const void *em_scene_fill_level(enum em_accuracy accuracy, const struct em_scene_entry *entry) {
  const size_t first = offsetof(struct em_engine, roots);
  const bool is_knob = entry->offset >= first && entry->offset < first + sizeof levels[0];
  return is_knob ? (const char *)&levels[accuracy] + (entry->offset - first) : NULL;
}

/* Entries that the scene does not give follow from its level of accuracy. */
static void fill_accuracy(const struct em_scene_report *report, struct em_engine *engine) {
  const config_setting_t *group = config_lookup(report->tree, "engine");
  const bool is_group = group && config_setting_is_group(group);
  for (size_t k = 0; k < em_scene_table_engine.count; ++k) {
    const struct em_scene_entry *entry = &em_scene_table_engine.entry[k];
    const void *value = em_scene_fill_level(engine->accuracy, entry);
    if (!value || (is_group && config_setting_get_member(group, entry->name))) continue;
    memcpy((char *)engine + entry->offset, value, entry->size);
  }
}

void em_scene_fill_all(struct em_scene_report *report, struct em_scene *scene) {
  em_scene_fill_group(report, &em_scene_table_top, config_root_setting(report->tree), scene);
  fill_gravity(report, scene);
  fill_chamber(report, &scene->chamber);
  em_scene_fill_rotors(report, scene);
  em_scene_fill_species(report, scene);
  em_scene_fill_contacts(report, scene);
  fill_plain(report, &em_scene_table_engine, &scene->engine);
  fill_accuracy(report, &scene->engine);
  scene->remedy.jam_after = -1; /* both decided when the scene is complete */
  scene->remedy.jam_within = -1.0;
  fill_plain(report, &em_scene_table_remedy, &scene->remedy);
  fill_plain(report, &em_scene_table_record, &scene->record);
}
