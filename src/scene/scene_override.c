/* Applies KEY=VALUE to a scene's tree: finds the settings that a dotted path means, and sets them.
 * What an override sets carries a hook, by which errors are reported as of the command line. */
#include "scene/scene_override.h"

#include <ctype.h>
#include <errno.h>
#include <limits.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "eventmill/contact.h"

enum { PATH = 256, SPECIES = 256 };

struct override {
  struct em_scene_report *report;
  const char *text; /* as given */
  char path[PATH];  /* before the "=" */
  const config_setting_t *value;
};

static void complain(const struct override *o, const char *what) {
  em_scene_report_line(o->report, NULL, 0, "%s: %s", o->path, what);
}

/* ---- setting one entry */

static bool copy_value(config_setting_t *to, const config_setting_t *from);

static bool copy_child(config_setting_t *to, const config_setting_t *from) {
  config_setting_t *made =
      config_setting_add(to, config_setting_name(from), config_setting_type(from));
  return made && copy_value(made, from);
}

/* Copies the content of a setting into another of the same type. */
static bool copy_value(config_setting_t *to, const config_setting_t *from) {
  switch (config_setting_type(from)) {
  case CONFIG_TYPE_INT:
    return config_setting_set_int(to, config_setting_get_int(from));
  case CONFIG_TYPE_INT64:
    return config_setting_set_int64(to, config_setting_get_int64(from));
  case CONFIG_TYPE_FLOAT:
    return config_setting_set_float(to, config_setting_get_float(from));
  case CONFIG_TYPE_BOOL:
    return config_setting_set_bool(to, config_setting_get_bool(from));
  case CONFIG_TYPE_STRING:
    return config_setting_set_string(to, config_setting_get_string(from));
  default:
    break;
  }
  for (int k = 0; k < config_setting_length(from); ++k)
    if (!copy_child(to, config_setting_get_elem(from, (unsigned)k))) return false;
  return true;
}

/* Makes (or makes anew) the entry `name` of a group. */
static config_setting_t *renew(const struct override *o, config_setting_t *group, const char *name,
                               int type) {
  if (config_setting_get_member(group, name)) config_setting_remove(group, name);
  config_setting_t *made = config_setting_add(group, name, type);
  if (made)
    config_setting_set_hook(made, (void *)(uintptr_t)o->text);
  else
    complain(o, "cannot be set, expected a name made of letters, digits, - and _");
  return made;
}

static void set_entry(const struct override *o, config_setting_t *group, const char *name) {
  config_setting_t *made = renew(o, group, name, config_setting_type(o->value));
  if (made && !copy_value(made, o->value)) em_scene_report_memory(o->report);
}

static void set_real(const struct override *o, config_setting_t *group, const char *name,
                     double x) {
  config_setting_t *made = renew(o, group, name, CONFIG_TYPE_FLOAT);
  if (made) config_setting_set_float(made, x);
}

/* ---- finding what a path means */

static bool all_digits(const char *text) {
  return text[0] && text[strspn(text, "0123456789")] == '\0' && strlen(text) < 10;
}

/* A law given by its name becomes a group, so that a parameter can be set in it. */
static config_setting_t *law_as_group(const struct override *o, config_setting_t *parent,
                                      config_setting_t *law) {
  const char *name = config_setting_get_string(law);
  char *kept = name ? strdup(name) : NULL;
  config_setting_t *group = kept ? renew(o, parent, "normal", CONFIG_TYPE_GROUP) : NULL;
  config_setting_t *inner = group ? config_setting_add(group, "law", CONFIG_TYPE_STRING) : NULL;
  if (inner)
    config_setting_set_string(inner, kept);
  else
    complain(o, "the law is a number, expected one with parameters");
  free(kept);
  return inner ? group : NULL;
}

static void descend(const struct override *o, config_setting_t *at, const char *path);

/* The next part of the path names an entry of this group. */
static void descend_group(const struct override *o, config_setting_t *group, const char *part,
                          const char *rest) {
  if (all_digits(part)) {
    /* Index 0 of what might be a list and is a group. */
    if (atoi(part) == 0 && rest && config_setting_name(group))
      descend(o, group, rest);
    else
      complain(o, "there is no such element");
    return;
  }
  if (!rest) {
    set_entry(o, group, part);
    return;
  }
  config_setting_t *next = config_setting_get_member(group, part);
  if (!next && strcmp(part, "rotor") == 0) {
    complain(o, "the scene has no rotor");
    return;
  }
  if (!next)
    next = renew(o, group, part, CONFIG_TYPE_GROUP);
  else if (!config_setting_is_aggregate(next) && strcmp(part, "normal") == 0)
    next = law_as_group(o, group, next);
  if (next) descend(o, next, rest);
}

/* The next part is an index, or the path means all elements of this list. */
static void descend_list(const struct override *o, config_setting_t *list, const char *path,
                         const char *part, const char *rest) {
  int count = config_setting_length(list);
  if (!all_digits(part)) {
    for (int k = 0; k < count; ++k)
      descend(o, config_setting_get_elem(list, (unsigned)k), path);
    if (count == 0) complain(o, "the scene has none of these");
    return;
  }
  if (atoi(part) >= count) {
    char name[PATH], text[2 * PATH];
    em_scene_report_name(list, sizeof name, name);
    snprintf(text, sizeof text, "%s has %d elements, expected an index below that", name, count);
    complain(o, text);
  } else if (!rest)
    complain(o, "is an element, expected the name of one of its entries after it");
  else
    descend(o, config_setting_get_elem(list, (unsigned)atoi(part)), rest);
}

static void descend(const struct override *o, config_setting_t *at, const char *path) {
  char part[PATH];
  size_t n = strcspn(path, ".");
  memcpy(part, path, n);
  part[n] = '\0';
  const char *rest = path[n] ? path + n + 1 : NULL;
  if (config_setting_is_group(at))
    descend_group(o, at, part, rest);
  else if (config_setting_is_list(at))
    descend_list(o, at, path, part, rest);
  else
    complain(o, "goes into something that is not a group");
}

/* ---- paths with a meaning of their own */

static int length_of(const config_setting_t *part) {
  return !part ? 0 : config_setting_is_group(part) ? 1 : config_setting_length(part);
}

static config_setting_t *group_of(config_setting_t *part, int k) {
  config_setting_t *group =
      config_setting_is_group(part) ? part : config_setting_get_elem(part, (unsigned)k);
  return group && config_setting_is_group(group) ? group : NULL;
}

/* The number that a setting holds, or `otherwise`. */
static double number_of(const config_setting_t *setting, double otherwise) {
  if (!setting) return otherwise;
  int type = config_setting_type(setting);
  if (type == CONFIG_TYPE_FLOAT) return config_setting_get_float(setting);
  if (type == CONFIG_TYPE_INT || type == CONFIG_TYPE_INT64)
    return (double)config_setting_get_int64(setting);
  return otherwise;
}

static double entry_number(const config_setting_t *group, const char *name, double otherwise) {
  return number_of(config_setting_get_member(group, name), otherwise);
}

/* A rotor's own speed, or the largest of its blades' if it has none. */
static double rotor_speed(config_setting_t *rotor) {
  double speed = entry_number(rotor, "rpm", 0.0);
  if (speed != 0.0) return speed;
  config_setting_t *blades = config_setting_get_member(rotor, "blades");
  for (int k = 0; k < length_of(blades); ++k) {
    const config_setting_t *blade = group_of(blades, k);
    if (blade) speed = fmax(speed, fabs(entry_number(blade, "rpm", 0.0)));
  }
  return speed;
}

/* Sets a rotor's speed; blades with a speed of their own keep their ratio to it. */
static void set_rpm(const struct override *o, config_setting_t *rotor, double rpm) {
  double before = rotor_speed(rotor);
  config_setting_t *blades = config_setting_get_member(rotor, "blades");
  for (int k = 0; k < length_of(blades); ++k) {
    config_setting_t *blade = group_of(blades, k);
    double own = blade ? entry_number(blade, "rpm", NAN) : NAN;
    if (isnan(own)) continue;
    double ratio = own == before ? 1.0 : own == -before ? -1.0 : own / before;
    set_real(o, blade, "rpm", before == 0.0 ? rpm : ratio * rpm);
  }
  set_real(o, rotor, "rpm", rpm);
}

/* rotor.rpm: all rotors; where their senses differ, each keeps its own. */
static void set_all_rpm(const struct override *o, config_setting_t *rotors) {
  double rpm = number_of(o->value, NAN);
  int count = length_of(rotors);
  bool plus = false, minus = false;
  for (int k = 0; k < count; ++k) {
    config_setting_t *rotor = group_of(rotors, k);
    double before = rotor ? rotor_speed(rotor) : 0.0;
    plus = plus || before > 0.0;
    minus = minus || before < 0.0;
  }
  for (int k = 0; k < count; ++k) {
    config_setting_t *rotor = group_of(rotors, k);
    if (!rotor) continue;
    double before = rotor_speed(rotor), sense = before > 0.0 ? 1.0 : before < 0.0 ? -1.0 : 0.0;
    set_rpm(o, rotor, plus && minus ? sense * rpm : rpm);
  }
}

/* Shares `total` in the proportions of `weight` (all equal where these are 0): floors first, then
 * the largest remainders, the first of equals. */
static void share(long long total, size_t n, const double *weight, long long *part) {
  if (n == 0) return;
  double sum = 0.0;
  for (size_t k = 0; k < n; ++k)
    sum += weight[k];
  double left[SPECIES];
  long long rest = total;
  for (size_t k = 0; k < n; ++k) {
    double exact = sum > 0.0 ? (double)total * (weight[k] / sum) : (double)total / (double)n;
    part[k] = (long long)floor(exact);
    left[k] = exact - floor(exact);
    rest -= part[k];
  }
  for (; rest > 0; --rest) {
    size_t best = 0;
    for (size_t k = 1; k < n; ++k)
      if (left[k] > left[best]) best = k;
    part[best]++;
    left[best] = -1.0;
  }
}

/* balls.count: the total of all species. */
static void set_all_counts(const struct override *o, config_setting_t *balls) {
  double weight[SPECIES];
  long long part[SPECIES] = {0};
  size_t n = (size_t)length_of(balls);
  if (n > SPECIES) {
    complain(o, "too many species to share out, expected counts one by one");
    return;
  }
  for (size_t k = 0; k < n; ++k) {
    const config_setting_t *group = group_of(balls, (int)k);
    double count = group ? entry_number(group, "count", 0.0) : 0.0;
    weight[k] = count > 0.0 && isfinite(count) ? count : 0.0;
  }
  share((long long)number_of(o->value, 0.0), n, weight, part);
  for (size_t k = 0; k < n; ++k) {
    config_setting_t *group = group_of(balls, (int)k);
    config_setting_t *made = group ? renew(o, group, "count", CONFIG_TYPE_INT64) : NULL;
    if (made) config_setting_set_int64(made, part[k]);
  }
}

static void drop(config_setting_t *group, const char *name) {
  if (group && config_setting_is_group(group) && config_setting_get_member(group, name))
    config_setting_remove(group, name);
}

/* What was set for all contacts, or for a rotor, parts no longer have for themselves. */
static void drop_own(const struct override *o, const config_t *tree) {
  static const char *const classes[] = {
#define SPELLING(code, text) text,
      EM_CLASS_LIST(SPELLING)
#undef SPELLING
  };
  const char *dot = strrchr(o->path, '.');
  if (!dot) return;
  const char *last = dot + 1;
  if (strncmp(o->path, "contact.", 8) == 0 && strchr(o->path, '.') == dot)
    for (size_t k = 0; k < sizeof classes / sizeof classes[0]; ++k) {
      config_setting_t *contact = config_lookup(tree, "contact");
      drop(config_setting_get_member(contact, classes[k]), last);
    }
  bool shape = !strcmp(last, "radius") || !strcmp(last, "reach") || !strcmp(last, "tip");
  if (!shape || strncmp(o->path, "rotor.", 6) != 0 || strstr(o->path, ".blades")) return;
  config_setting_t *rotors = config_lookup(tree, "rotor");
  int only = isdigit((unsigned char)o->path[6]) ? atoi(o->path + 6) : -1;
  for (int k = 0; k < length_of(rotors); ++k) {
    config_setting_t *rotor = only < 0 || only == k ? group_of(rotors, k) : NULL;
    config_setting_t *blades = rotor ? config_setting_get_member(rotor, "blades") : NULL;
    for (int j = 0; j < length_of(blades); ++j)
      drop(group_of(blades, j), last);
  }
}

/* The index in "rotor.INDEX.rpm"; -1: "rotor.rpm"; -2: another path. */
static int rpm_index(const char *path) {
  if (strcmp(path, "rotor.rpm") == 0) return -1;
  int k = -2, end = 0;
  if (sscanf(path, "rotor.%9d.rpm%n", &k, &end) == 1 && end == (int)strlen(path) && k >= 0)
    return k;
  return -2;
}

static void apply(const struct override *o, config_t *tree) {
  config_setting_t *root = config_root_setting(tree);
  config_setting_t *rotors = config_lookup(tree, "rotor"), *balls = config_lookup(tree, "balls");
  int type = config_setting_type(o->value);
  bool integer = type == CONFIG_TYPE_INT || type == CONFIG_TYPE_INT64;
  int k = rpm_index(o->path);
  if (k >= -1 && (k < 0 ? 0 : k) < length_of(rotors) && isfinite(number_of(o->value, NAN))) {
    if (k < 0)
      set_all_rpm(o, rotors);
    else if (group_of(rotors, k))
      set_rpm(o, group_of(rotors, k), number_of(o->value, NAN));
  } else if (strcmp(o->path, "balls.count") == 0 && length_of(balls) > 1) {
    if (integer && number_of(o->value, -1.0) >= 0.0)
      set_all_counts(o, balls);
    else
      complain(o, "expected an integer not below 0");
  } else {
    descend(o, root, o->path);
    drop_own(o, tree);
  }
}

/* ---- the value */

/* Reads the value as libconfig would; a bare word is a string. */
static bool read_value(const struct override *o, config_t *tree, const char *text) {
  struct em_error inner = {0};
  struct em_scene_source source = {0};
  size_t room = strlen(text) + 8;
  char *line = malloc(room);
  if (!line) {
    em_scene_report_memory(o->report);
    return false;
  }
  snprintf(line, room, "v = %s\n;", text);
  enum em_status status = em_scene_source_join(&source, line, "command line", &inner);
  free(line);
  if (status == EM_MEMORY) em_scene_report_memory(o->report);
  bool good = status == EM_OK && em_scene_source_read(tree, source.text) &&
              config_setting_length(config_root_setting(tree)) == 1;
  em_scene_source_free(&source);
  if (good || status == EM_MEMORY) return good;
  if (!text[0] || strpbrk(text, "[](){}\"=;@")) {
    complain(o, "the value cannot be read, expected a number, a word, [x, y, z] or { ... }");
    return false;
  }
  config_destroy(tree);
  config_init(tree);
  config_setting_t *v = config_setting_add(config_root_setting(tree), "v", CONFIG_TYPE_STRING);
  return v && config_setting_set_string(v, text);
}

void em_scene_override_apply(struct em_scene_report *report, config_t *tree, const char *text) {
  struct override o = {.report = report, .text = text};
  const char *equals = strchr(text, '=');
  size_t n = equals ? (size_t)(equals - text) : 0;
  if (n == 0 || n >= sizeof o.path) {
    em_scene_report_line(report, NULL, 0, "\"%.80s\": expected KEY=VALUE", text);
    return;
  }
  memcpy(o.path, text, n);
  config_t value;
  config_init(&value);
  if (read_value(&o, &value, equals + 1)) {
    o.value = config_lookup(&value, "v");
    if (o.value) apply(&o, tree);
  }
  config_destroy(&value);
}
