/* The tables of all entries of a scene, and the search for a name in them. */
#include "scene/scene_table.h"

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#define SPELLING(code, text) text,
static const char *const shapes[] = {EM_SHAPE_LIST(SPELLING) NULL};
static const char *const starts[] = {EM_START_LIST(SPELLING) NULL};
static const char *const lists[] = {EM_LISTS_LIST(SPELLING) NULL};
static const char *const partitions[] = {EM_PARTITION_LIST(SPELLING) NULL};
static const char *const accuracies[] = {EM_ACCURACY_LIST(SPELLING) NULL};
static const char *const quartics[] = {EM_QUARTIC_LIST(SPELLING) NULL};
static const char *const searches[] = {EM_SEARCH_LIST(SPELLING) NULL};
static const char *const polishes[] = {EM_POLISH_LIST(SPELLING) NULL};
static const char *const tips[] = {EM_TIP_LIST(SPELLING) NULL};
static const char *const lanes[] = {"0", "4", "8", NULL};
static const char *const rules[] = {EM_RULE_LIST(SPELLING) NULL};
const char *const em_scene_table_classes[] = {EM_CLASS_LIST(SPELLING) NULL};
const char *const em_scene_table_laws[] = {EM_LAW_LIST(SPELLING) NULL};

/* An enum is stored through an int of its own size. */
_Static_assert(sizeof(enum em_shape) == sizeof(int), "an enum is as wide as an int");

#define AT(type, member) offsetof(struct type, member), sizeof(((struct type *)0)->member)
#define NOWHERE          0, 0
#define ANY              -INFINITY, INFINITY, false, NULL
#define FROM(low)        low, INFINITY, false, NULL
#define ABOVE(low)       low, INFINITY, true, NULL
#define RANGE(low, high) low, high, false, NULL
#define ONE_OF(names)    0, 0, false, names
#define TABLE(name, place, entries)                                    \
  const struct em_scene_table em_scene_table_##name = {place, entries, \
                                                       sizeof(entries) / sizeof((entries)[0])}

static const struct em_scene_entry top[] = {
    {"title", EM_KIND_TEXT, AT(em_scene, title), "", ANY, "", "what the scene shows"},
    {"duration", EM_KIND_REAL, AT(em_scene, duration), "1", FROM(0), "s", "simulated time"},
    {"seed", EM_KIND_U64, AT(em_scene, seed), "1", RANGE(1, 4294967295.0), "",
     "of the random start (mt19937)"},
    {"gravity", EM_KIND_SPECIAL, NOWHERE, "[0.0, 0.0, -9.81]", ANY, "m/s²",
     "any vector, or \"none\""},
    {"chamber", EM_KIND_SPECIAL, NOWHERE, NULL, ANY, "", "group: the vessel"},
    {"rotor", EM_KIND_SPECIAL, NOWHERE, NULL, ANY, "", "group or list of groups"},
    {"balls", EM_KIND_SPECIAL, NOWHERE, NULL, ANY, "", "group or list of groups (species)"},
    {"contact", EM_KIND_SPECIAL, NOWHERE, NULL, ANY, "", "group: how things collide"},
    {"engine", EM_KIND_SPECIAL, NOWHERE, NULL, ANY, "", "group: how events are found"},
    {"remedy", EM_KIND_SPECIAL, NOWHERE, NULL, ANY, "", "group: against collapse and jams"},
    {"record", EM_KIND_SPECIAL, NOWHERE, NULL, ANY, "", "group: what is written"},
};
TABLE(top, "", top);

static const struct em_scene_entry chamber[] = {
    {"shape", EM_KIND_NAME, AT(em_chamber, shape), "drum", ONE_OF(shapes), "",
     "drum: its axis along y; box: from 0 to `size`"},
    {"diameter", EM_KIND_REAL, AT(em_chamber, diameter), NULL, ABOVE(0), "m", "of the drum"},
    {"length", EM_KIND_REAL, AT(em_chamber, length), NULL, ABOVE(0), "m", "of the drum"},
    {"size", EM_KIND_VECTOR, AT(em_chamber, size), NULL, ABOVE(0), "m", "of the box"},
    {"periodic", EM_KIND_SPECIAL, NOWHERE, "false", ANY, "",
     "of the box: true, false, or one of these for each of x, y, z"},
    {"rpm", EM_KIND_REAL, AT(em_chamber, rpm), "0", ANY, "1/min",
     "of the drum and its end walls about +y"},
    {"facets", EM_KIND_INTEGER, AT(em_chamber, facets), "0", RANGE(0, 100000), "",
     "flat sides that touch the drum from outside, instead of its round wall; at least 3; 0: "
     "round"},
    {"ramps", EM_KIND_SPECIAL, NOWHERE, NULL, ANY, "",
     "group: two sectors of the drum with a turned normal (the reference's ramps)"},
};
TABLE(chamber, "chamber", chamber);

static const struct em_scene_entry ramps[] = {
    {"half_deg", EM_KIND_DEGREES, AT(em_scene_ramps, half), "0", RANGE(0, 90), "°",
     "half width of the sectors at top and bottom; 0: no ramps"},
    {"tilt_deg", EM_KIND_DEGREES, AT(em_scene_ramps, tilt), "30", RANGE(-89, 89), "°",
     "turn of the normal against the ball's motion along x"},
};
TABLE(ramps, "chamber.ramps", ramps);

static const struct em_scene_entry rotor[] = {
    {"rpm", EM_KIND_REAL, AT(em_scene_rotor_form, rpm), "0", ANY, "1/min",
     "right-handed about the axis"},
    {"axis", EM_KIND_VECTOR, AT(em_scene_rotor_form, axis), "[0.0, 1.0, 0.0]", ANY, "",
     "direction, of any length but 0"},
    {"point", EM_KIND_VECTOR, AT(em_scene_rotor_form, point), "[0.0, 0.0, 0.0]", ANY, "m",
     "a point on the axis, from which the blades' y counts"},
    {"radius", EM_KIND_REAL, AT(em_scene_rotor_form, radius), NULL, ABOVE(0), "m",
     "of blades that give none"},
    {"reach", EM_KIND_REAL, AT(em_scene_rotor_form, reach), NULL, ABOVE(0), "m",
     "of blades that give none"},
    {"tip", EM_KIND_NAME, AT(em_scene_rotor_form, tip), "flat", ONE_OF(tips), "",
     "of blades that give none"},
    {"blades", EM_KIND_SPECIAL, NOWHERE, NULL, ANY, "", "list of groups"},
};
TABLE(rotor, "rotor", rotor);

static const struct em_scene_entry blade[] = {
    {"y", EM_KIND_REAL, AT(em_scene_blade_form, y), NULL, ANY, "m",
     "place along the rotor's axis, from its point"},
    {"angle_deg", EM_KIND_DEGREES, AT(em_scene_blade_form, angle), "0", ANY, "°",
     "at the start; 0 points up (+z), growing towards +x"},
    {"radius", EM_KIND_REAL, AT(em_scene_blade_form, radius), NULL, ABOVE(0), "m",
     "of the bar; default: the rotor's"},
    {"reach", EM_KIND_REAL, AT(em_scene_blade_form, reach), NULL, ABOVE(0), "m",
     "from the axis to either end of the bar; default: the rotor's"},
    {"tip", EM_KIND_NAME, AT(em_scene_blade_form, tip), NULL, ONE_OF(tips), "",
     "form of the ends; default: the rotor's"},
    {"rpm", EM_KIND_REAL, AT(em_scene_blade_form, rpm), NULL, ANY, "1/min",
     "speed of its own; default: the rotor's"},
};
TABLE(blade, "rotor.blades", blade);

static const struct em_scene_entry balls[] = {
    {"name", EM_KIND_TEXT, AT(em_species, name), "balls", ANY, "", "of the species"},
    {"count", EM_KIND_COUNT, AT(em_species, count), NULL, RANGE(0, 1e8), "",
     "number of balls; for start \"table\" its number of rows"},
    {"diameter", EM_KIND_REAL, AT(em_species, diameter), NULL, ABOVE(0), "m", ""},
    {"density", EM_KIND_REAL, AT(em_species, density), "7850", ABOVE(0), "kg/m³", ""},
    {"start", EM_KIND_NAME, AT(em_species, start), "uniform", ONE_OF(starts), "",
     "uniform: at random; half: at random in the lower half; lattice: a regular lattice; "
     "table: as given; run: from a run file's last frame"},
    {"speed", EM_KIND_REAL, AT(em_species, speed), "1", FROM(0), "m/s",
     "at the start, in directions at random; not for table and run"},
    {"region", EM_KIND_SPECIAL, NOWHERE, NULL, ANY, "",
     "group: box in which the centres start; default: the chamber"},
    {"table", EM_KIND_SPECIAL, NOWHERE, NULL, ANY, "m, m/s, rad/s",
     "rows (x, y, z, vx, vy, vz) or (x, y, z, vx, vy, vz, wx, wy, wz), or the name of a text "
     "file with such rows"},
    {"from", EM_KIND_TEXT, AT(em_species, from), "", ANY, "", "run file, for start \"run\""},
};
TABLE(balls, "balls", balls);

static const struct em_scene_entry region[] = {
    {"low", EM_KIND_VECTOR, AT(em_scene_region, low), NULL, ANY, "m", "lowest x, y, z"},
    {"high", EM_KIND_VECTOR, AT(em_scene_region, high), NULL, ANY, "m", "highest x, y, z"},
};
TABLE(region, "balls.region", region);

#define CONTACT_ENTRIES(rule_default, tangential_default, friction_default)                       \
  {"rule",        EM_KIND_NAME, AT(em_contact_law, rule), rule_default,                           \
   ONE_OF(rules), "",           "collision rule"},                                                \
      {"normal",                                                                                  \
       EM_KIND_SPECIAL,                                                                           \
       NOWHERE,                                                                                   \
       NULL,                                                                                      \
       ANY,                                                                                       \
       "",                                                                                        \
       "law of normal restitution: a number (constant), a name, or a group { law; parameters }; " \
       "default: \"spahn\""},                                                                     \
      {"tangential",                                                                              \
       EM_KIND_REAL,                                                                              \
       AT(em_contact_law, tangential),                                                            \
       tangential_default,                                                                        \
       RANGE(-1, 1),                                                                              \
       "",                                                                                        \
       "tangential restitution; 1: smooth, -1: perfectly rough"},                                 \
  {                                                                                               \
    "friction", EM_KIND_REAL, AT(em_contact_law, friction), friction_default, FROM(0), "",        \
        "coefficient of the rule \"friction\""                                                    \
  }

static const struct em_scene_entry contact[] = {
    CONTACT_ENTRIES("rough", "0.9", "0.1"),
    {"ball-ball", EM_KIND_SPECIAL, NOWHERE, NULL, ANY, "", "group: other values for this class"},
    {"ball-drum", EM_KIND_SPECIAL, NOWHERE, NULL, ANY, "", "group: other values for this class"},
    {"ball-end", EM_KIND_SPECIAL, NOWHERE, NULL, ANY, "", "group: other values for this class"},
    {"ball-blade", EM_KIND_SPECIAL, NOWHERE, NULL, ANY, "", "group: other values for this class"},
};
TABLE(contact, "contact", contact);

/* A class starts from the values of `contact` itself, so it has no defaults of its own. */
static const struct em_scene_entry class[] = {CONTACT_ENTRIES(NULL, NULL, NULL)};
TABLE(class, "contact.CLASS", class);

static const struct em_scene_entry engine[] = {
    {"lists", EM_KIND_NAME, AT(em_engine, lists), "calendar", ONE_OF(lists), "",
     "structure of the event lists"},
    {"partition", EM_KIND_NAME, AT(em_engine, partition), "auto", ONE_OF(partitions), "",
     "how a ball's possible partners are found; auto: cells, but neighbours where balls crowd or "
     "their sizes differ"},
    {"accuracy", EM_KIND_NAME, AT(em_engine, accuracy), "standard", ONE_OF(accuracies), "",
     "a set of the entries from quartic to polish, as far as the scene does not give them"},
    {"quartic", EM_KIND_NAME, AT(em_engine, roots.quartic), "safe", ONE_OF(quartics), "",
     "solver for the drum with gravity; the first three never miss a contact"},
    {"blade", EM_KIND_NAME, AT(em_engine, roots.blade), "safe", ONE_OF(searches), "",
     "search for contacts with blades; steps: the reference's heuristic, which may miss some and "
     "knows no tips"},
    {"blade_step", EM_KIND_REAL, AT(em_engine, roots.blade_step), "0.1", ABOVE(0), "ball diameters",
     "for blade \"steps\": way against the bar's end in one step"},
    {"tolerance", EM_KIND_REAL, AT(em_engine, roots.tolerance), "0", RANGE(0, 0.1),
     "ball diameters",
     "gap with which searches for contacts with drum (quartic \"safe\") and blades are content; 0: "
     "rounding; 1e-6 for accuracy \"fast\""},
    {"shortcut", EM_KIND_REAL, AT(em_engine, roots.shortcut), "0", RANGE(0, 100), "ball diameters",
     "so near to the drum, fast balls are taken to fly straight (the reference's shortcut); 0: "
     "off"},
    {"polish", EM_KIND_NAME, AT(em_engine, roots.polish), "none", ONE_OF(polishes), "",
     "precision in which contact times are finished: double, 64 or 113 bits; \"quad\" for accuracy "
     "\"reference\""},
    {"slices", EM_KIND_INTEGER, AT(em_engine, slices), "0", RANGE(0, 1e6), "",
     "for partition \"slices\"; 0: as many as fit, at most 26"},
    {"skin", EM_KIND_REAL, AT(em_engine, skin), "0", RANGE(0, 100), "ball diameters",
     "for partition \"neighbours\"; 0: chosen"},
    {"simd", EM_KIND_BOOLEAN, AT(em_engine, simd), "true", ANY, "",
     "pairs and partners by vectors; the same results without"},
    {"lanes", EM_KIND_INTEGER, AT(em_engine, lanes), "0", ONE_OF(lanes), "",
     "numbers of a vector; 0: as many as the processor has"},
};
TABLE(engine, "engine", engine);

static const struct em_scene_entry remedy[] = {
    {"tc", EM_KIND_REAL, AT(em_remedy, tc), "0", FROM(0), "s",
     "a contact within this time of the ball's last one is elastic; 0: off"},
    {"elastic_below", EM_KIND_REAL, AT(em_remedy, elastic_below), "0", FROM(0), "m/s",
     "slower contacts are elastic; 0: off"},
    {"jam_after", EM_KIND_INTEGER, AT(em_remedy, jam_after), NULL, RANGE(0, 1e9), "contacts",
     "in a row after which the tangential part is left out; 0: off; default: 5 where a blade moves "
     "and contacts are not smooth, else 0"},
    {"jam_within", EM_KIND_REAL, AT(em_remedy, jam_within), NULL, FROM(0), "s",
     "between contacts in a row; default: 1e-8, or the time in which a ball at the scene's typical "
     "speed flies 1e-5 of the smallest diameter, if that is less"},
    {"collapse_after", EM_KIND_U32, AT(em_remedy, collapse_after), "100000", RANGE(1, 4294967295.0),
     "contacts", "in a row at which the run stops as collapsed"},
};
TABLE(remedy, "remedy", remedy);

static const struct em_scene_entry record[] = {
    {"frames", EM_KIND_REAL, AT(em_recording, frames), "50", FROM(0), "1/s", "0: none"},
    {"observables", EM_KIND_REAL, AT(em_recording, observables), "100", FROM(0), "1/s", "0: none"},
    {"histograms", EM_KIND_REAL, AT(em_recording, histograms), "20", FROM(0), "1/s",
     "blocks of time for the histograms of v_n per class; 0: one block"},
    {"collisions", EM_KIND_BOOLEAN, AT(em_recording, collisions), "false", ANY, "",
     "table of all collisions"},
    {"checkpoint", EM_KIND_REAL, AT(em_recording, checkpoint), "30", ABOVE(0), "s",
     "of wall time between checkpoints"},
    {"compression", EM_KIND_INTEGER, AT(em_recording, compression), "1", RANGE(0, 9), "",
     "deflate level; below 4 frames and the table's speeds, places and normals are stored as they "
     "are"},
};
TABLE(record, "record", record);

const struct em_scene_table *const em_scene_table_all[] = {&em_scene_table_top,
                                                           &em_scene_table_chamber,
                                                           &em_scene_table_ramps,
                                                           &em_scene_table_rotor,
                                                           &em_scene_table_blade,
                                                           &em_scene_table_balls,
                                                           &em_scene_table_region,
                                                           &em_scene_table_contact,
                                                           &em_scene_table_class,
                                                           &em_scene_table_engine,
                                                           &em_scene_table_remedy,
                                                           &em_scene_table_record,
                                                           NULL};

const struct em_scene_entry *em_scene_table_find(const struct em_scene_table *table,
                                                 const char *name) {
  for (size_t k = 0; k < table->count; ++k)
    if (strcmp(table->entry[k].name, name) == 0) return &table->entry[k];
  return NULL;
}

/* Edit distance with exchanges of neighbours: insert, delete, replace, exchange cost 1 each. Names
 * longer than the rows count as infinitely far. */
static size_t distance(const char *a, const char *b) {
  enum { ROOM = 64 };
  size_t n = strlen(a), m = strlen(b);
  if (n >= ROOM || m >= ROOM) return SIZE_MAX;
  size_t d[ROOM][ROOM];
  for (size_t i = 0; i <= n; ++i)
    d[i][0] = i;
  for (size_t j = 0; j <= m; ++j)
    d[0][j] = j;
  for (size_t i = 1; i <= n; ++i)
    for (size_t j = 1; j <= m; ++j) {
      size_t best = d[i - 1][j - 1] + (a[i - 1] != b[j - 1]);
      best = d[i - 1][j] + 1 < best ? d[i - 1][j] + 1 : best;
      best = d[i][j - 1] + 1 < best ? d[i][j - 1] + 1 : best;
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        best = d[i - 2][j - 2] + 1 < best ? d[i - 2][j - 2] + 1 : best;
      d[i][j] = best;
    }
  return d[n][m];
}

const char *em_scene_table_nearest(const char *name, size_t count, const char *const *names) {
  const char *nearest = NULL;
  size_t least = strlen(name) / 2 + 2;
  for (size_t k = 0; k < count; ++k) {
    size_t d = distance(name, names[k]);
    if (d < least) {
      least = d;
      nearest = names[k];
    }
  }
  return nearest;
}

/* " from LOW to HIGH", " above LOW", "": the range of an entry in words. */
static void expects_range(const struct em_scene_entry *entry, size_t size, char *text) {
  text[0] = '\0';
  if (isfinite(entry->low) && isfinite(entry->high))
    snprintf(text, size, " from %.10g to %.10g", entry->low, entry->high);
  else if (isfinite(entry->low))
    snprintf(text, size, entry->above ? " above %.10g" : " not below %.10g", entry->low);
}

/* The names of an entry, each between `quote`s: "a", "b" or "c". */
static void expects_name(const struct em_scene_entry *entry, const char *quote, size_t size,
                         char *text) {
  size_t used = 0;
  for (const char *const *name = entry->names; *name && used < size; ++name) {
    const char *joint = name == entry->names ? "" : name[1] ? ", " : " or ";
    used += (size_t)snprintf(text + used, size - used, "%s%s%s%s", joint, quote, *name, quote);
  }
}

void em_scene_table_expects(const struct em_scene_entry *entry, size_t size, char *text) {
  char range[64], unit[32] = "";
  expects_range(entry, sizeof range, range);
  if (entry->unit[0]) snprintf(unit, sizeof unit, " (%s)", entry->unit);
  switch (entry->kind) {
  case EM_KIND_REAL:
  case EM_KIND_DEGREES:
    snprintf(text, size, "a number%s%s", range, unit);
    break;
  case EM_KIND_INTEGER:
  case EM_KIND_COUNT:
  case EM_KIND_U32:
  case EM_KIND_U64:
    if (entry->names)
      expects_name(entry, "", size, text);
    else
      snprintf(text, size, "an integer%s%s", range, unit);
    break;
  case EM_KIND_BOOLEAN:
    snprintf(text, size, "true or false");
    break;
  case EM_KIND_TEXT:
    snprintf(text, size, "a text of at most %zu bytes", entry->size - 1);
    break;
  case EM_KIND_NAME:
    expects_name(entry, "\"", size, text);
    break;
  case EM_KIND_VECTOR:
    snprintf(text, size, "three numbers [x, y, z]%s%s", range[0] ? ", each" : "", range);
    if (unit[0]) strncat(text, unit, size - strlen(text) - 1);
    break;
  case EM_KIND_SPECIAL:
    snprintf(text, size, "%s", entry->help);
    break;
  }
}
