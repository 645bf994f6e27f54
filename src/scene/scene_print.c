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

/* The same as a comment where the value is what the entry has when the scene does not give it, as
 * it lies at `left_out` (NULL: nothing that follows from other entries): if these change, so shall
 * it. */
static void put_given(FILE *out, int depth, const struct em_scene_entry *entry, const void *base,
                      const void *left_out) {
  const void *at = (const char *)base + entry->offset;
  const bool follows = left_out && memcmp(at, left_out, entry->size) == 0;
  if (follows) {
    indent(out, depth);
    fputs("# ", out);
  }
  put_line(out, follows ? 0 : depth, entry, base);
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

/* What all blades of a rotor have in common is said of the rotor; NAN or -1 where they differ. */
static struct em_scene_rotor_form common_form(const struct em_rotor *rotor) {
  struct em_scene_rotor_form form = {.rpm = rotor->rpm,
                                     .radius = NAN,
                                     .reach = NAN,
                                     .tip = -1,
                                     .axis = rotor->axis,
                                     .point = rotor->point};
  const struct em_blade *blade = rotor->blade, *end = blade + rotor->blade_count;
  if (blade == end) return form;
  form.radius = blade->radius;
  form.reach = blade->reach;
  form.tip = (int)blade->tip;
  while (++blade < end) {
    if (blade->radius != form.radius) form.radius = NAN;
    if (blade->reach != form.reach) form.reach = NAN;
    if ((int)blade->tip != form.tip) form.tip = -1;
  }
  return form;
}

static void put_blade(FILE *out, int depth, const struct em_rotor *rotor,
                      const struct em_scene_rotor_form *form, size_t k) {
  const struct em_blade *blade = &rotor->blade[k];
  indent(out, depth);
  fputs("{ y = ", out);
  put_real(out, rotor->blade_y[k]);
  fputs("; angle_deg = ", out);
  put_degrees(out, blade->angle);
  if (isnan(form->radius)) {
    fputs("; radius = ", out);
    put_real(out, blade->radius);
  }
  if (isnan(form->reach)) {
    fputs("; reach = ", out);
    put_real(out, blade->reach);
  }
  if (form->tip < 0) fprintf(out, "; tip = \"%s\"", em_surface_tip_name(blade->tip));
  if (blade->omega != em_scene_fill_omega(rotor->rpm)) {
    fputs("; rpm = ", out);
    put_read(out, blade->omega, 60.0 / (2.0 * M_PI), em_scene_fill_omega);
  }
  fputs(k + 1 < rotor->blade_count ? "; },\n" : "; }\n", out);
}

static void put_rotor(FILE *out, int depth, const struct em_rotor *rotor) {
  const struct em_scene_rotor_form form = common_form(rotor);
  const char *of_each[4] = {NULL};
  int count = 0;
  if (isnan(form.radius)) of_each[count++] = "radius";
  if (isnan(form.reach)) of_each[count++] = "reach";
  if (form.tip < 0) of_each[count++] = "tip";
  put_table(out, depth, &em_scene_table_rotor, &form, of_each);
  indent(out, depth);
  fputs("blades = (\n", out);
  for (size_t k = 0; k < rotor->blade_count; ++k)
    put_blade(out, depth + 1, rotor, &form, k);
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

static bool same_law(const struct em_restitution *a, const struct em_restitution *b) {
  bool equal = a->law == b->law;
  for (int k = 0; equal && k < em_contact_law_size(a->law); ++k)
    equal = a->p[k] == b->p[k];
  return equal;
}

static bool same_contact(const struct em_contact_law *a, const struct em_contact_law *b) {
  return a->rule == b->rule && a->tangential == b->tangential && a->friction == b->friction &&
         same_law(&a->normal, &b->normal);
}

/* A class's group goes without what it takes from `all`, the group that holds it (NULL: it is that
 * group itself). */
static void put_contact(FILE *out, int depth, const struct em_contact_law *contact,
                        const struct em_contact_law *all) {
  for (size_t k = 0; k < em_scene_table_class.count; ++k) {
    const struct em_scene_entry *entry = &em_scene_table_class.entry[k];
    if (entry->kind == EM_KIND_SPECIAL) continue;
    put_given(out, depth, entry, contact, all ? (const char *)all + entry->offset : NULL);
  }
  indent(out, depth);
  if (all && same_law(&contact->normal, &all->normal)) fputs("# ", out);
  fprintf(out, "normal = { law = \"%s\";", em_contact_law_name(contact->normal.law));
  for (int k = 0; k < em_contact_law_size(contact->normal.law); ++k) {
    fprintf(out, " %s = ", em_contact_law_parameter(contact->normal.law, k));
    put_real(out, contact->normal.p[k]);
    fputc(';', out);
  }
  fputs(" };\n", out);
}

/* The first class stands for all; classes that differ from it follow as groups. */
static void put_contacts(FILE *out, const struct em_scene *scene) {
  const struct em_contact_law *all = &scene->contact[0];
  fputs("contact = {\n", out);
  put_contact(out, 1, all, NULL);
  for (int k = 1; k < EM_CLASS_COUNT; ++k) {
    if (same_contact(&scene->contact[k], all)) continue;
    fprintf(out, "  %s = {\n", em_scene_table_classes[k]);
    put_contact(out, 2, &scene->contact[k], all);
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

static void put_engine(FILE *out, const struct em_engine *engine) {
  fputs("engine = {\n", out);
  for (size_t k = 0; k < em_scene_table_engine.count; ++k) {
    const struct em_scene_entry *entry = &em_scene_table_engine.entry[k];
    put_given(out, 1, entry, engine, em_scene_fill_level(engine->accuracy, entry));
  }
  fputs("};\n", out);
}

static void put_remedy(FILE *out, const struct em_scene *scene) {
  struct em_remedy left_out = {.tc = NAN, .elastic_below = NAN}; /* nothing that a scene has */
  em_scene_jam(scene, &left_out.jam_after, &left_out.jam_within);
  fputs("remedy = {\n", out);
  for (size_t k = 0; k < em_scene_table_remedy.count; ++k) {
    const struct em_scene_entry *entry = &em_scene_table_remedy.entry[k];
    put_given(out, 1, entry, &scene->remedy, (const char *)&left_out + entry->offset);
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
  put_remedy(out, scene);
  put_group(out, &em_scene_table_record, &scene->record);
}
