/* Fills rotors with their blades, species of balls, and contact laws. */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "scene/scene_fill.h"

/* A part that may be one group or a list of groups: how many, and each. */
static int part_count(struct em_scene_report *report, const config_setting_t *part) {
  if (!part) return 0;
  if (config_setting_is_group(part)) return 1;
  if (config_setting_is_list(part)) return config_setting_length(part);
  em_scene_fill_mismatch(report, part, "a group { } or a list of groups ( { }, ... )");
  return 0;
}

static const config_setting_t *part_at(const config_setting_t *part, int k) {
  return config_setting_is_group(part) ? part : config_setting_get_elem(part, (unsigned)k);
}

static const config_setting_t *member(const config_setting_t *group, const char *name) {
  return group && config_setting_is_group(group) ? config_setting_get_member(group, name) : NULL;
}

/* calloc for at least one. */
static void *room(struct em_scene_report *report, size_t count, size_t size) {
  void *made = calloc(count > 0 ? count : 1, size);
  if (!made) em_scene_report_memory(report);
  return made;
}

/* ---- rotors */

static void fill_blade(struct em_scene_report *report, const config_setting_t *group,
                       const struct em_scene_rotor_form *form, struct em_rotor *rotor, size_t k) {
  struct em_scene_blade_form b = {
      .y = NAN, .radius = form->radius, .reach = form->reach, .rpm = form->rpm, .tip = form->tip};
  size_t before = report->errors;
  em_scene_fill_group(report, &em_scene_table_blade, group, &b);
  if (report->errors == before) {
    if (isnan(b.y)) em_scene_fill_missing(report, group, &em_scene_table_blade, "y");
    if (isnan(b.radius)) em_scene_fill_missing(report, group, &em_scene_table_blade, "radius");
    if (isnan(b.reach)) em_scene_fill_missing(report, group, &em_scene_table_blade, "reach");
  }
  rotor->blade_y[k] = b.y;
  rotor->blade[k] = (struct em_blade){.centre = em_vec_axpy(rotor->point, b.y, rotor->axis),
                                      .axis = rotor->axis,
                                      .e1 = em_scene_fill_upright(rotor->axis),
                                      .angle = b.angle,
                                      .omega = em_scene_fill_omega(b.rpm),
                                      .radius = b.radius,
                                      .reach = b.reach,
                                      .tip = (enum em_tip)b.tip};
}

static void fill_blades(struct em_scene_report *report, const config_setting_t *group,
                        const struct em_scene_rotor_form *form, struct em_rotor *rotor) {
  const config_setting_t *blades = member(group, "blades");
  int count = part_count(report, blades);
  if (!blades)
    em_scene_report_at(report, group, "\"blades\" is missing, expected a list of groups");
  rotor->blade = room(report, (size_t)count, sizeof *rotor->blade);
  rotor->blade_y = room(report, (size_t)count, sizeof *rotor->blade_y);
  if (!rotor->blade || !rotor->blade_y) return;
  rotor->blade_count = (size_t)count;
  for (int k = 0; k < count; ++k)
    fill_blade(report, part_at(blades, k), form, rotor, (size_t)k);
}

static void fill_rotor(struct em_scene_report *report, const config_setting_t *group,
                       struct em_rotor *rotor) {
  struct em_scene_rotor_form form = {.radius = NAN, .reach = NAN};
  em_scene_fill_group(report, &em_scene_table_rotor, group, &form);
  if (!config_setting_is_group(group)) return;
  double n2 = em_vec_norm2(form.axis);
  if (!(n2 > 0.0 && isfinite(n2))) {
    em_scene_fill_mismatch(report, member(group, "axis"), "a direction other than (0, 0, 0)");
    form.axis = em_vec_make(0.0, 1.0, 0.0);
  }
  rotor->axis = em_scene_fill_unit(form.axis);
  rotor->point = form.point;
  rotor->rpm = form.rpm;
  fill_blades(report, group, &form, rotor);
}

void em_scene_fill_rotors(struct em_scene_report *report, struct em_scene *scene) {
  const config_setting_t *part = config_lookup(report->tree, "rotor");
  int count = part_count(report, part);
  scene->rotor = room(report, (size_t)count, sizeof *scene->rotor);
  if (!scene->rotor) return;
  scene->rotor_count = (size_t)count;
  for (int k = 0; k < count; ++k)
    fill_rotor(report, part_at(part, k), &scene->rotor[k]);
}

/* ---- species */

static void fill_region(struct em_scene_report *report, const config_setting_t *group,
                        struct em_species *s) {
  struct em_scene_region region = {{NAN, NAN, NAN}, {NAN, NAN, NAN}};
  size_t before = report->errors;
  em_scene_fill_group(report, &em_scene_table_region, group, &region);
  if (report->errors == before) {
    if (isnan(region.low.x)) em_scene_fill_missing(report, group, &em_scene_table_region, "low");
    if (isnan(region.high.x)) em_scene_fill_missing(report, group, &em_scene_table_region, "high");
  }
  s->has_region = true;
  s->low = region.low;
  s->high = region.high;
}

/* Entries that only one kind of start uses. */
static void match_start(struct em_scene_report *report, const config_setting_t *group,
                        const struct em_species *s) {
  static const struct {
    const char *name;
    enum em_start start;
  } belongs[] = {{"table", EM_START_TABLE}, {"from", EM_START_RUN}};
  for (size_t k = 0; k < sizeof belongs / sizeof belongs[0]; ++k) {
    const config_setting_t *setting = member(group, belongs[k].name);
    if (setting && s->start != belongs[k].start)
      em_scene_report_at(report, setting, "is not used, expected it only with start = \"%s\"",
                         em_scene_start_name(belongs[k].start));
    if (!setting && s->start == belongs[k].start)
      em_scene_fill_missing(report, group, &em_scene_table_balls, belongs[k].name);
  }
}

static void fill_from(struct em_scene_report *report, const config_setting_t *group,
                      struct em_species *s) {
  char *path = em_scene_source_whole(report->source->name, s->from);
  if (!path)
    em_scene_report_memory(report);
  else if (strlen(path) >= sizeof s->from)
    em_scene_report_at(report, member(group, "from"),
                       "the path is too long, expected at most %zu "
                       "bytes",
                       sizeof s->from - 1);
  else
    strcpy(s->from, path);
  free(path);
}

static void fill_one_species(struct em_scene_report *report, const config_setting_t *group,
                             struct em_species *s) {
  size_t before = report->errors;
  em_scene_fill_group(report, &em_scene_table_balls, group, s);
  const config_setting_t *region = member(group, "region"), *table = member(group, "table");
  if (region) fill_region(report, region, s);
  if (report->errors > before) return;
  match_start(report, group, s);
  if (!member(group, "diameter"))
    em_scene_fill_missing(report, group, &em_scene_table_balls, "diameter");
  if (!member(group, "count") && s->start != EM_START_TABLE)
    em_scene_fill_missing(report, group, &em_scene_table_balls, "count");
  size_t asked = s->count;
  if (table && s->start == EM_START_TABLE && report->errors == before) {
    em_scene_fill_rows(report, table, s);
    if (member(group, "count") && asked != s->count && report->errors == before)
      em_scene_report_at(report, member(group, "count"),
                         "found %zu, expected %zu, the number of rows of the table", asked,
                         s->count);
  }
  if (s->from[0] && s->start == EM_START_RUN) fill_from(report, group, s);
}

/* Species that the balls' numbers of their species, of 16 bits, can tell apart. */
enum { SPECIES_MOST = UINT16_MAX + 1 };

void em_scene_fill_species(struct em_scene_report *report, struct em_scene *scene) {
  const config_setting_t *part = config_lookup(report->tree, "balls");
  int count = part_count(report, part);
  if (count > SPECIES_MOST) {
    em_scene_report_at(report, part, "found a list of %d, expected at most %d species", count,
                       SPECIES_MOST);
    count = 0;
  }
  if (!part)
    em_scene_report_at(report, config_root_setting(report->tree),
                       "\"balls\" is missing, expected a group { count; diameter; ... }");
  scene->species = room(report, (size_t)count, sizeof *scene->species);
  if (!scene->species) return;
  scene->species_count = (size_t)count;
  for (int k = 0; k < count; ++k)
    fill_one_species(report, part_at(part, k), &scene->species[k]);
}

/* ---- contacts */

/* Index of the law's parameter of that name, or -1. */
static int parameter_find(enum em_law law, const char *name) {
  for (int k = 0; k < em_contact_law_size(law); ++k)
    if (strcmp(em_contact_law_parameter(law, k), name) == 0) return k;
  return -1;
}

static int law_find(struct em_scene_report *report, const config_setting_t *setting) {
  const char *name = config_setting_get_string(setting);
  int law = name ? em_contact_law_find(name) : -1;
  if (law >= 0) return law;
  char all[200] = "";
  for (int k = 0; k < EM_LAW_COUNT; ++k)
    snprintf(all + strlen(all), sizeof all - strlen(all), "%s\"%s\"",
             k == 0                 ? ""
             : k + 1 < EM_LAW_COUNT ? ", "
                                    : " or ",
             em_scene_table_laws[k]);
  const char *near = name ? em_scene_table_nearest(name, EM_LAW_COUNT, em_scene_table_laws) : NULL;
  if (near)
    em_scene_report_at(report, setting, "unknown law \"%.60s\", expected %s; did you mean \"%s\"?",
                       name, all, near);
  else
    em_scene_fill_mismatch(report, setting, all);
  return -1;
}

/* Stores a parameter that makes sense: speeds (c) and what stands in a power's base above 0, the
 * rest not below 0, but for the second term of power4, which may be of either sign. */
static void set_parameter(struct em_scene_report *report, const config_setting_t *setting,
                          struct em_restitution *law, int k, double value) {
  bool above =
      !strcmp(em_contact_law_parameter(law->law, k), "c") || (law->law == EM_LAW_SPAHN && k == 1);
  bool any = law->law == EM_LAW_POWER4 && k == 2;
  if (law->law == EM_LAW_CONSTANT && (value < 0.0 || value > 1.0))
    em_scene_fill_mismatch(report, setting, "a number from 0 to 1");
  else if (!any && (value < 0.0 || (above && value == 0.0)))
    em_scene_fill_mismatch(report, setting, above ? "a number above 0" : "a number not below 0");
  else
    law->p[k] = value;
}

static void fill_parameter(struct em_scene_report *report, const config_setting_t *setting,
                           struct em_restitution *law) {
  const char *name = config_setting_name(setting);
  int k = parameter_find(law->law, name);
  double value;
  if (k >= 0) {
    if (em_scene_fill_number(report, setting, "a number", &value))
      set_parameter(report, setting, law, k, value);
    return;
  }
  char all[120] = "";
  for (k = 0; k < em_contact_law_size(law->law); ++k)
    snprintf(all + strlen(all), sizeof all - strlen(all), "%s%s", k > 0 ? ", " : "",
             em_contact_law_parameter(law->law, k));
  em_scene_report_at(report, setting, "unknown parameter of the law \"%s\", expected one of: %s",
                     em_contact_law_name(law->law), all);
}

/* { law; parameters }: without a law, the parameters of the law that holds so far. */
static void fill_law_group(struct em_scene_report *report, const config_setting_t *group,
                           struct em_restitution *law) {
  const config_setting_t *name = config_setting_get_member(group, "law");
  if (name) {
    int k = law_find(report, name);
    if (k < 0) return;
    *law = em_contact_law_default((enum em_law)k);
  }
  for (int k = 0; k < config_setting_length(group); ++k) {
    const config_setting_t *setting = config_setting_get_elem(group, (unsigned)k);
    if (setting != name) fill_parameter(report, setting, law);
  }
}

static void fill_law(struct em_scene_report *report, const config_setting_t *setting,
                     struct em_restitution *law) {
  int type = config_setting_type(setting);
  if (type == CONFIG_TYPE_STRING) {
    int k = law_find(report, setting);
    if (k >= 0) *law = em_contact_law_default((enum em_law)k);
  } else if (type == CONFIG_TYPE_GROUP) {
    fill_law_group(report, setting, law);
  } else {
    double e = 0.0;
    *law = em_contact_law_default(EM_LAW_CONSTANT);
    if (em_scene_fill_number(report, setting,
                             "a number from 0 to 1, the name of a law, or a group "
                             "{ law; parameters }",
                             &e))
      set_parameter(report, setting, law, 0, e);
  }
}

static void fill_class(struct em_scene_report *report, const struct em_scene_table *table,
                       const config_setting_t *group, struct em_contact_law *contact) {
  em_scene_fill_group(report, table, group, contact);
  const config_setting_t *normal = member(group, "normal");
  if (normal) fill_law(report, normal, &contact->normal);
}

void em_scene_fill_contacts(struct em_scene_report *report, struct em_scene *scene) {
  const config_setting_t *group = config_lookup(report->tree, "contact");
  struct em_contact_law all = {.normal = em_contact_law_default(EM_LAW_SPAHN)};
  fill_class(report, &em_scene_table_contact, group, &all);
  for (int k = 0; k < EM_CLASS_COUNT; ++k) {
    scene->contact[k] = all;
    const config_setting_t *own = member(group, em_scene_table_classes[k]);
    if (own) fill_class(report, &em_scene_table_class, own, &scene->contact[k]);
  }
}
