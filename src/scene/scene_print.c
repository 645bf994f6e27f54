/* Prints a complete scene such that it reads back to the same bits: each number with as many digits
 * as it needs, angles and speeds in the units of the scene. */
#include "scene/scene_print.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "scene/scene_fill.h"
#include "scene/scene_table.h"

static double same(double x) {
  return x;
}

/* Puts the shortest of 15 to 17 digits that `read` brings back to x; false if none does. */
static bool spell(double value, double x, double (*read)(double), size_t size, char *text) {
  for (int digits = 15; digits <= 17; ++digits) {
    snprintf(text, size, "%.*g", digits, value);
    if (read(strtod(text, NULL)) == x) break;
    if (digits == 17) return false;
  }
  if (strpbrk(text, ".") == NULL) {
    /* libconfig knows a real by its point. */
    char *e = strchr(text, 'e'), rest[16];
    snprintf(rest, sizeof rest, "%s", e ? e : "");
    text[e ? (size_t)(e - text) : strlen(text)] = '\0';
    strcat(text, ".0");
    strcat(text, rest);
  }
  return true;
}

/* A number whose meaning is x = read(number); `scale` is about number/x. Conversions round, so the
 * neighbours of the first guess are tried as well. */
static void put_read(FILE *out, double x, double scale, double (*read)(double)) {
  char text[48];
  double guess = x * scale, lower = guess, upper = guess;
  bool good = spell(guess, x, read, sizeof text, text);
  for (int k = 0; !good && k < 4; ++k) {
    lower = nextafter(lower, -INFINITY);
    upper = nextafter(upper, INFINITY);
    good = spell(lower, x, read, sizeof text, text) || spell(upper, x, read, sizeof text, text);
  }
  fputs(text, out);
}

static void put_real(FILE *out, double x) {
  put_read(out, x, 1.0, same);
}

static void put_degrees(FILE *out, double x) {
  put_read(out, x, 180.0 / M_PI, em_scene_fill_radians);
}

static void put_vector(FILE *out, struct em_vec v) {
  fputc('[', out);
  put_real(out, v.x);
  fputs(", ", out);
  put_real(out, v.y);
  fputs(", ", out);
  put_real(out, v.z);
  fputc(']', out);
}

static void put_text(FILE *out, const char *text) {
  fputc('"', out);
  for (; *text; ++text) {
    unsigned char c = (unsigned char)*text;
    if (c == '"' || c == '\\')
      fprintf(out, "\\%c", c);
    else if (c < 32 || c == 127)
      fprintf(out, "\\x%02x", c);
    else
      fputc(c, out);
  }
  fputc('"', out);
}

static void indent(FILE *out, int depth) {
  fprintf(out, "%*s", 2 * depth, "");
}

/* The value of an entry that lies in memory as its table says. */
static void put_entry(FILE *out, const struct em_scene_entry *entry, const void *base) {
  const void *at = (const char *)base + entry->offset;
  switch (entry->kind) {
  case EM_KIND_REAL:
    put_real(out, *(const double *)at);
    break;
  case EM_KIND_DEGREES:
    put_degrees(out, *(const double *)at);
    break;
  case EM_KIND_INTEGER:
    fprintf(out, "%d", *(const int *)at);
    break;
  case EM_KIND_COUNT:
    fprintf(out, "%zu", *(const size_t *)at);
    break;
  case EM_KIND_U32:
    fprintf(out, "%lu", (unsigned long)*(const uint32_t *)at);
    break;
  case EM_KIND_U64:
    fprintf(out, "%llu", (unsigned long long)*(const uint64_t *)at);
    break;
  case EM_KIND_BOOLEAN:
    fputs(*(const bool *)at ? "true" : "false", out);
    break;
  case EM_KIND_TEXT:
    put_text(out, at);
    break;
  case EM_KIND_NAME:
    fprintf(out, "\"%s\"", entry->names[*(const int *)at]);
    break;
  case EM_KIND_VECTOR:
    put_vector(out, *(const struct em_vec *)at);
    break;
  case EM_KIND_SPECIAL:
    break;
  }
}

/* "  name = value;  # unit" */
static void put_line(FILE *out, int depth, const struct em_scene_entry *entry, const void *base) {
  indent(out, depth);
  fprintf(out, "%s = ", entry->name);
  put_entry(out, entry, base);
  fprintf(out, entry->unit[0] ? ";  # %s\n" : ";\n", entry->unit);
}

/* All entries of a table that are not special; `skip` (may be NULL) names some to leave out. */
static void put_table(FILE *out, int depth, const struct em_scene_table *table, const void *base,
                      const char *const *skip) {
  for (size_t k = 0; k < table->count; ++k) {
    bool out_of_it = table->entry[k].kind == EM_KIND_SPECIAL;
    for (const char *const *name = skip; name && *name; ++name)
      out_of_it = out_of_it || strcmp(*name, table->entry[k].name) == 0;
    if (!out_of_it) put_line(out, depth, &table->entry[k], base);
  }
}

static void put_chamber(FILE *out, const struct em_chamber *c) {
  static const char *const not_drum[] = {"size", NULL};
  static const char *const not_box[] = {"diameter", "length", "rpm", "facets", NULL};
  fputs("chamber = {\n", out);
  put_table(out, 1, &em_scene_table_chamber, c, c->shape == EM_SHAPE_DRUM ? not_drum : not_box);
  if (c->shape == EM_SHAPE_DRUM) {
    struct em_scene_ramps ramps = {c->ramp_half, c->ramp_tilt};
    fputs("  ramps = {\n", out);
    put_table(out, 2, &em_scene_table_ramps, &ramps, NULL);
    fputs("  };\n", out);
  } else {
    fprintf(out, "  periodic = [%s, %s, %s];\n", c->periodic[0] ? "true" : "false",
            c->periodic[1] ? "true" : "false", c->periodic[2] ? "true" : "false");
  }
  fputs("};\n", out);
}

static void put_blade(FILE *out, int depth, const struct em_rotor *rotor, size_t k) {
  const struct em_blade *blade = &rotor->blade[k];
  indent(out, depth);
  fputs("{ y = ", out);
  put_real(out, rotor->blade_y[k]);
  fputs("; angle_deg = ", out);
  put_degrees(out, blade->angle);
  fputs("; radius = ", out);
  put_real(out, blade->radius);
  fputs("; reach = ", out);
  put_real(out, blade->reach);
  fprintf(out, "; tip = \"%s\";", em_surface_tip_name(blade->tip));
  if (blade->omega != em_scene_fill_omega(rotor->rpm)) {
    fputs(" rpm = ", out);
    put_read(out, blade->omega, 60.0 / (2.0 * M_PI), em_scene_fill_omega);
    fputc(';', out);
  }
  fputs(k + 1 < rotor->blade_count ? " },\n" : " }\n", out);
}

static void put_rotor(FILE *out, int depth, const struct em_rotor *rotor) {
  static const char *const each_blade[] = {"radius", "reach", "tip", NULL};
  struct em_scene_rotor_form form = {.rpm = rotor->rpm, .axis = rotor->axis, .point = rotor->point};
  put_table(out, depth, &em_scene_table_rotor, &form, each_blade);
  indent(out, depth);
  fputs("blades = (\n", out);
  for (size_t k = 0; k < rotor->blade_count; ++k)
    put_blade(out, depth + 1, rotor, k);
  indent(out, depth);
  fputs(");\n", out);
}

static void put_row(FILE *out, const struct em_species *s, size_t k) {
  struct em_vec v[3] = {s->position[k], s->velocity[k], em_vec_make(0, 0, 0)};
  if (s->spin) v[2] = s->spin[k];
  fputc('(', out);
  for (int i = 0; i < (s->spin ? 3 : 2); ++i) {
    fputs(i > 0 ? ", " : "", out);
    put_real(out, v[i].x);
    fputs(", ", out);
    put_real(out, v[i].y);
    fputs(", ", out);
    put_real(out, v[i].z);
  }
  fputs(k + 1 < s->count ? "),\n" : ")\n", out);
}

static void put_species(FILE *out, int depth, const struct em_species *s) {
  static const char *const not_from[] = {"from", NULL};
  put_table(out, depth, &em_scene_table_balls, s, s->start == EM_START_RUN ? NULL : not_from);
  if (s->has_region) {
    struct em_scene_region region = {s->low, s->high};
    indent(out, depth);
    fputs("region = {\n", out);
    put_table(out, depth + 1, &em_scene_table_region, &region, NULL);
    indent(out, depth);
    fputs("};\n", out);
  }
  if (s->start != EM_START_TABLE) return;
  indent(out, depth);
  fputs("table = (\n", out);
  for (size_t k = 0; k < s->count; ++k) {
    indent(out, depth + 1);
    put_row(out, s, k);
  }
  indent(out, depth);
  fputs(");\n", out);
}

static void put_contact(FILE *out, int depth, const struct em_contact_law *contact) {
  put_table(out, depth, &em_scene_table_class, contact, NULL);
  indent(out, depth);
  fprintf(out, "normal = { law = \"%s\";", em_contact_law_name(contact->normal.law));
  for (int k = 0; k < em_contact_law_size(contact->normal.law); ++k) {
    fprintf(out, " %s = ", em_contact_law_parameter(contact->normal.law, k));
    put_real(out, contact->normal.p[k]);
    fputc(';', out);
  }
  fputs(" };\n", out);
}

static bool same_contact(const struct em_contact_law *a, const struct em_contact_law *b) {
  bool equal = a->rule == b->rule && a->tangential == b->tangential && a->friction == b->friction &&
               a->normal.law == b->normal.law;
  for (int k = 0; k < em_contact_law_size(a->normal.law); ++k)
    equal = equal && a->normal.p[k] == b->normal.p[k];
  return equal;
}

/* The first class stands for all; classes that differ from it follow as groups. */
static void put_contacts(FILE *out, const struct em_scene *scene) {
  fputs("contact = {\n", out);
  put_contact(out, 1, &scene->contact[0]);
  for (int k = 1; k < EM_CLASS_COUNT; ++k) {
    if (same_contact(&scene->contact[k], &scene->contact[0])) continue;
    fprintf(out, "  %s = {\n", em_scene_table_classes[k]);
    put_contact(out, 2, &scene->contact[k]);
    fputs("  };\n", out);
  }
  fputs("};\n", out);
}

/* One group, or a list where there are several or none. */
static void put_parts(FILE *out, const char *name, size_t count, const struct em_scene *scene,
                      void (*put)(FILE *, int, const struct em_scene *, size_t)) {
  fprintf(out, count == 1 ? "%s = {\n" : "%s = (\n", name);
  for (size_t k = 0; k < count; ++k) {
    if (count > 1) fputs("  {\n", out);
    put(out, count > 1 ? 2 : 1, scene, k);
    if (count > 1) fputs(k + 1 < count ? "  },\n" : "  }\n", out);
  }
  fputs(count == 1 ? "};\n" : ");\n", out);
}

static void put_rotor_part(FILE *out, int depth, const struct em_scene *scene, size_t k) {
  put_rotor(out, depth, &scene->rotor[k]);
}

static void put_species_part(FILE *out, int depth, const struct em_scene *scene, size_t k) {
  put_species(out, depth, &scene->species[k]);
}

static void put_group(FILE *out, const struct em_scene_table *table, const void *base) {
  fprintf(out, "%s = {\n", table->path);
  put_table(out, 1, table, base, NULL);
  fputs("};\n", out);
}

/* Entries that are what their level of accuracy says are comments: another level shall set them. */
static void put_engine(FILE *out, const struct em_engine *engine) {
  fputs("engine = {\n", out);
  for (size_t k = 0; k < em_scene_table_engine.count; ++k) {
    const struct em_scene_entry *entry = &em_scene_table_engine.entry[k];
    const void *level = em_scene_fill_level(engine->accuracy, entry);
    const bool follows =
        level && memcmp(level, (const char *)engine + entry->offset, entry->size) == 0;
    if (follows) fputs("  # ", out);
    put_line(out, follows ? 0 : 1, entry, engine);
  }
  fputs("};\n", out);
}

void em_scene_print_all(const struct em_scene *scene, FILE *out) {
  put_table(out, 0, &em_scene_table_top, scene, NULL);
  fputs("gravity = ", out);
  put_vector(out, scene->gravity);
  fputs(";  # m/s²\n", out);
  put_chamber(out, &scene->chamber);
  put_parts(out, "rotor", scene->rotor_count, scene, put_rotor_part);
  put_parts(out, "balls", scene->species_count, scene, put_species_part);
  put_contacts(out, scene);
  put_engine(out, &scene->engine);
  put_group(out, &em_scene_table_remedy, &scene->remedy);
  put_group(out, &em_scene_table_record, &scene->record);
}
