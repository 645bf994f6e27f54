/* Every entry that a scene may have: name, kind, default, range, unit, meaning. Reading, checking,
 * suggestions for misspelt names and the reference in docs/scenes.md all follow these tables. */
#ifndef EVENTMILL_SCENE_SCENE_TABLE_H
#define EVENTMILL_SCENE_SCENE_TABLE_H

#include <stdbool.h>
#include <stddef.h>

#include "eventmill/scene.h"

enum em_scene_kind {
  EM_KIND_REAL,    /* double */
  EM_KIND_DEGREES, /* degrees in the scene, rad (double) in memory */
  EM_KIND_INTEGER, /* int */
  EM_KIND_COUNT,   /* size_t */
  EM_KIND_U32,     /* uint32_t */
  EM_KIND_U64,     /* uint64_t */
  EM_KIND_BOOLEAN, /* bool */
  EM_KIND_TEXT,    /* char[size] */
  EM_KIND_NAME,    /* an enum, spelt as in `names` */
  EM_KIND_VECTOR,  /* struct em_vec */
  EM_KIND_SPECIAL  /* read by a function of its own; not stored at `offset` */
};

struct em_scene_entry {
  const char *name;
  enum em_scene_kind kind;
  size_t offset, size;      /* bytes, in the struct that the table fills */
  const char *fallback;     /* default as text; NULL: none, or filled in by other means */
  double low, high;         /* range, both ends included ... */
  bool above;               /* ... but for `low` where this is set */
  const char *const *names; /* NULL-terminated: all values that a name, or an integer, may have */
  const char *unit, *help;
};

struct em_scene_table {
  const char *path; /* where it stands in a scene, for documentation */
  const struct em_scene_entry *entry;
  size_t count;
};

/* What the `ramps` group holds. */
struct em_scene_ramps {
  double half, tilt; /* rad */
};

/* What a rotor's own entries hold, its blades apart. */
struct em_scene_rotor_form {
  double rpm, radius, reach; /* 1/min; m; m: radius and reach NAN where the scene is silent */
  int tip;
  struct em_vec axis, point;
};

/* What a blade's entries hold. */
struct em_scene_blade_form {
  double y, angle, radius, reach, rpm; /* m, rad, m, m, 1/min; NAN where the scene is silent */
  int tip;
};

/* The box in which a species starts. */
struct em_scene_region {
  struct em_vec low, high; /* m */
};

extern const struct em_scene_table em_scene_table_top, em_scene_table_chamber, em_scene_table_ramps,
    em_scene_table_rotor, em_scene_table_blade, em_scene_table_balls, em_scene_table_region,
    em_scene_table_contact, em_scene_table_class, em_scene_table_engine, em_scene_table_remedy,
    em_scene_table_record;

/* All of the above, NULL-terminated. */
extern const struct em_scene_table *const em_scene_table_all[];

extern const char *const em_scene_table_classes[], *const em_scene_table_laws[];

/* The entry of that name, or NULL. */
const struct em_scene_entry *em_scene_table_find(const struct em_scene_table *table,
                                                 const char *name);

/* The one of `count` names that is nearest to `name`, or NULL when none is near. */
const char *em_scene_table_nearest(const char *name, size_t count, const char *const *names);

/* Writes into `text` (of `size` bytes) what an entry expects: "a number above 0 (m)". */
void em_scene_table_expects(const struct em_scene_entry *entry, size_t size, char *text);

#endif
