/* Scenes: read, print, free, and what can be asked of them. */
#include "eventmill/scene.h"

#include <libconfig.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "num/locale.h"
#include "scene/scene_check.h"
#include "scene/scene_fill.h"
#include "scene/scene_override.h"
#include "scene/scene_print.h"
#include "scene/scene_report.h"
#include "scene/scene_source.h"

#define SPELLING(code, text) text,
static const char *const shapes[] = {EM_SHAPE_LIST(SPELLING)};
static const char *const starts[] = {EM_START_LIST(SPELLING)};
static const char *const lists[] = {EM_LISTS_LIST(SPELLING)};
static const char *const partitions[] = {EM_PARTITION_LIST(SPELLING)};
static const char *const accuracies[] = {EM_ACCURACY_LIST(SPELLING)};
static const char *const effects[] = {EM_EFFECT_LIST(SPELLING)};
#undef SPELLING

/* ---- reading */

static bool any_moves(const struct em_scene *scene) {
  for (size_t r = 0; r < scene->rotor_count; ++r)
    for (size_t b = 0; b < scene->rotor[r].blade_count; ++b)
      if (scene->rotor[r].blade[b].omega != 0.0) return true;
  return false;
}

/* Does the contact change tangential velocities? */
static bool is_rough(const struct em_contact_law *contact) {
  return contact->rule != EM_RULE_SMOOTH && contact->tangential != 1.0 &&
         !(contact->rule == EM_RULE_FRICTION && contact->friction == 0.0);
}

static bool any_rough(const struct em_scene *scene) {
  for (int k = 0; k < EM_CLASS_COUNT; ++k)
    if (is_rough(&scene->contact[k])) return true;
  return false;
}

/* The smallest diameter (m) of any ball; where there is none, the chamber's extent. */
static double smallest_diameter(const struct em_scene *scene) {
  double d = INFINITY;
  for (size_t k = 0; k < scene->species_count; ++k)
    if (scene->species[k].count > 0) d = fmin(d, scene->species[k].diameter);
  struct em_vec low, high;
  em_scene_bounds(scene, &low, &high);
  return isfinite(d) ? d : em_vec_norm(em_vec_sub(high, low));
}

void em_scene_jam(const struct em_scene *scene, int *after, double *within) {
  *after = any_moves(scene) && any_rough(scene) ? 5 : 0;
  *within = fmin(1e-8, 1e-5 * smallest_diameter(scene) / em_scene_typical_speed(scene));
}

/* What the scene does not say of its remedies follows from the rest of it. */
static void complete_remedy(struct em_scene *scene) {
  struct em_remedy *r = &scene->remedy;
  int after;
  double within;
  em_scene_jam(scene, &after, &within);
  if (r->jam_after < 0) r->jam_after = after;
  if (r->jam_within < 0.0) r->jam_within = within;
}

/* Fills and checks a scene from its tree. */
static void build(struct em_scene_report *report, struct em_scene *scene) {
  em_scene_fill_all(report, scene);
  if (report->errors > 0) return;
  complete_remedy(scene);
  em_scene_check_all(report, scene);
}

/* Reads the joined text into the tree, puts the overrides in, builds. */
static void read_tree(struct em_scene_report *report, config_t *tree, struct em_scene *scene,
                      size_t override_count, const char *const *overrides) {
  if (!em_scene_source_read(tree, report->source->text)) {
    int line;
    const char *file = em_scene_source_place(report->source, config_error_line(tree), &line);
    em_scene_report_line(report, file, line, "%s, expected NAME = VALUE;", config_error_text(tree));
    return;
  }
  for (size_t k = 0; k < override_count; ++k)
    em_scene_override_apply(report, tree, overrides[k]);
  build(report, scene);
}

enum em_status em_scene_parse(struct em_scene **scene, const char *text, const char *name,
                              size_t override_count, const char *const *overrides,
                              struct em_error *err) {
  EM_LOCALE_PLAIN;
  *scene = NULL;
  struct em_error unread = {0};
  err = err ? err : &unread;
  err->code = EM_OK;
  err->text[0] = '\0';
  struct em_scene_source source;
  enum em_status status = em_scene_source_join(&source, text, name, err);
  if (status != EM_OK) return status;
  struct em_scene *made = calloc(1, sizeof *made);
  config_t tree;
  config_init(&tree);
  struct em_scene_report report = {.source = &source, .tree = &tree, .err = err};
  if (!made)
    em_scene_report_memory(&report);
  else if (strlen(name) >= sizeof made->file)
    em_scene_report_line(&report, name, 0, "the path is too long, expected at most %zu bytes",
                         sizeof made->file - 1);
  else {
    strcpy(made->file, name);
    read_tree(&report, &tree, made, override_count, overrides);
  }
  config_destroy(&tree);
  em_scene_source_free(&source);
  if (report.errors == 0) {
    *scene = made;
    return EM_OK;
  }
  em_scene_free(made);
  return em_scene_report_end(&report);
}

enum em_status em_scene_read(struct em_scene **scene, const char *path, size_t override_count,
                             const char *const *overrides, struct em_error *err) {
  *scene = NULL;
  char *text = NULL;
  enum em_status status = em_scene_source_load(&text, path, err);
  if (status != EM_OK) return status;
  status = em_scene_parse(scene, text, path, override_count, overrides, err);
  free(text);
  return status;
}

void em_scene_free(struct em_scene *scene) {
  if (!scene) return;
  for (size_t k = 0; scene->rotor && k < scene->rotor_count; ++k) {
    free(scene->rotor[k].blade);
    free(scene->rotor[k].blade_y);
  }
  for (size_t k = 0; scene->species && k < scene->species_count; ++k) {
    free(scene->species[k].position);
    free(scene->species[k].velocity);
    free(scene->species[k].spin);
  }
  free(scene->rotor);
  free(scene->species);
  free(scene);
}

/* ---- printing */

enum em_status em_scene_print(const struct em_scene *scene, FILE *out) {
  EM_LOCALE_PLAIN;
  em_scene_print_all(scene, out);
  return ferror(out) ? EM_FILE : EM_OK;
}

char *em_scene_text(const struct em_scene *scene) {
  char *text = NULL;
  size_t size = 0;
  FILE *out = open_memstream(&text, &size);
  if (!out) return NULL;
  bool good = em_scene_print(scene, out) == EM_OK;
  good = fclose(out) == 0 && good;
  if (good) return text;
  free(text);
  return NULL;
}

/* ---- what a scene calls for */

size_t em_scene_ball_count(const struct em_scene *scene) {
  size_t count = 0;
  for (size_t k = 0; k < scene->species_count; ++k)
    count += scene->species[k].count;
  return count;
}

size_t em_scene_blade_count(const struct em_scene *scene) {
  size_t count = 0;
  for (size_t k = 0; k < scene->rotor_count; ++k)
    count += scene->rotor[k].blade_count;
  return count;
}

/* Can contacts of this class happen? */
static bool is_used(const struct em_scene *scene, enum em_class cls) {
  const struct em_chamber *c = &scene->chamber;
  bool drum = c->shape == EM_SHAPE_DRUM;
  switch (cls) {
  case EM_CLASS_BALL:
    return em_scene_ball_count(scene) > 1;
  case EM_CLASS_DRUM:
    return drum || !c->periodic[0] || !c->periodic[2];
  case EM_CLASS_END:
    return drum || !c->periodic[1];
  case EM_CLASS_BLADE:
    return em_scene_blade_count(scene) > 0;
  case EM_CLASS_COUNT:
    break;
  }
  return false;
}

/* Do spins change, or does a table set some? */
static bool has_spin(const struct em_scene *scene) {
  for (int k = 0; k < EM_CLASS_COUNT; ++k)
    if (is_used(scene, (enum em_class)k) && is_rough(&scene->contact[k])) return true;
  for (size_t k = 0; k < scene->species_count; ++k)
    if (scene->species[k].spin) return true;
  return false;
}

static bool is_mixed(const struct em_scene *scene) {
  const struct em_species *first = NULL;
  for (size_t k = 0; k < scene->species_count; ++k) {
    const struct em_species *s = &scene->species[k];
    if (s->count == 0) continue;
    if (first && (s->diameter != first->diameter || s->density != first->density)) return true;
    first = s;
  }
  return false;
}

static bool has_speed_law(const struct em_scene *scene) {
  for (int k = 0; k < EM_CLASS_COUNT; ++k)
    if (is_used(scene, (enum em_class)k) && scene->contact[k].normal.law != EM_LAW_CONSTANT)
      return true;
  return false;
}

unsigned em_scene_effects(const struct em_scene *scene) {
  const struct em_chamber *c = &scene->chamber;
  bool drum = c->shape == EM_SHAPE_DRUM;
  const bool on[EM_EFFECT_COUNT] = {
      [EM_EFFECT_BIT_GRAVITY] = em_vec_norm2(scene->gravity) > 0.0,
      [EM_EFFECT_BIT_SPIN] = has_spin(scene),
      [EM_EFFECT_BIT_ROTOR] = em_scene_blade_count(scene) > 0,
      [EM_EFFECT_BIT_PERIODIC] = !drum && (c->periodic[0] || c->periodic[1] || c->periodic[2]),
      [EM_EFFECT_BIT_MIXED] = is_mixed(scene),
      [EM_EFFECT_BIT_RESTITUTION] = has_speed_law(scene),
      [EM_EFFECT_BIT_TC] = scene->remedy.tc > 0.0,
      [EM_EFFECT_BIT_ELASTIC] = scene->remedy.elastic_below > 0.0,
      [EM_EFFECT_BIT_JAM] = scene->remedy.jam_after > 0,
      [EM_EFFECT_BIT_RAMPS] = drum && c->ramp_half > 0.0 && c->ramp_tilt != 0.0,
      [EM_EFFECT_BIT_FACETS] = drum && c->facets > 0,
      [EM_EFFECT_BIT_TURNING] = drum && c->rpm != 0.0,
      [EM_EFFECT_BIT_COLLISIONS] = scene->record.collisions,
  };
  unsigned bits = 0;
  for (unsigned k = 0; k < EM_EFFECT_COUNT; ++k)
    bits |= on[k] ? 1u << k : 0u;
  return bits;
}

/* ---- sizes and speeds */

double em_scene_volume(const struct em_scene *scene) {
  const struct em_chamber *c = &scene->chamber;
  if (c->shape == EM_SHAPE_DRUM) return 0.25 * M_PI * c->diameter * c->diameter * c->length;
  return c->size.x * c->size.y * c->size.z;
}

void em_scene_bounds(const struct em_scene *scene, struct em_vec *low, struct em_vec *high) {
  const struct em_chamber *c = &scene->chamber;
  bool drum = c->shape == EM_SHAPE_DRUM;
  double r = 0.5 * c->diameter;
  *low = drum ? em_vec_make(-r, 0.0, -r) : em_vec_make(0.0, 0.0, 0.0);
  *high = drum ? em_vec_make(r, c->length, r) : c->size;
}

double em_scene_reach(const struct em_scene *scene) {
  const struct em_chamber *c = &scene->chamber;
  return 0.5 * c->diameter / (c->facets > 0 ? cos(M_PI / c->facets) : 1.0);
}

void em_scene_extent(const struct em_scene *scene, struct em_vec *low, struct em_vec *high) {
  em_scene_bounds(scene, low, high);
  if (scene->chamber.shape != EM_SHAPE_DRUM) return;
  const double reach = em_scene_reach(scene);
  low->x = low->z = -reach;
  high->x = high->z = reach;
}

/* The largest speed at which a species starts. */
static double start_speed(const struct em_species *s) {
  if (s->start != EM_START_TABLE) return s->count > 0 ? s->speed : 0.0;
  double v2 = 0.0;
  for (size_t k = 0; k < s->count; ++k)
    v2 = fmax(v2, em_vec_norm2(s->velocity[k]));
  return sqrt(v2);
}

double em_scene_typical_speed(const struct em_scene *scene) {
  double speed = 0.0;
  for (size_t k = 0; k < scene->species_count; ++k)
    speed = fmax(speed, start_speed(&scene->species[k]));
  for (size_t r = 0; r < scene->rotor_count; ++r)
    for (size_t b = 0; b < scene->rotor[r].blade_count; ++b) {
      const struct em_blade *blade = &scene->rotor[r].blade[b];
      speed = fmax(speed, 0.5 * fabs(blade->omega) * blade->reach);
    }
  struct em_vec low, high, g = scene->gravity;
  em_scene_bounds(scene, &low, &high);
  struct em_vec size = em_vec_sub(high, low);
  double fall = fabs(g.x) * size.x + fabs(g.y) * size.y + fabs(g.z) * size.z;
  speed = fmax(speed, sqrt(2.0 * fall));
  return speed > 0.0 ? speed : 1.0;
}

/* ---- names */

const char *em_scene_effect_name(enum em_effect_bit bit) {
  return effects[bit];
}

const char *em_scene_shape_name(enum em_shape shape) {
  return shapes[shape];
}

const char *em_scene_start_name(enum em_start start) {
  return starts[start];
}

const char *em_scene_lists_name(enum em_lists choice) {
  return lists[choice];
}

const char *em_scene_partition_name(enum em_partition partition) {
  return partitions[partition];
}

const char *em_scene_accuracy_name(enum em_accuracy accuracy) {
  return accuracies[accuracy];
}
