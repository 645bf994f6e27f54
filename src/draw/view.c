/* Writes the page that plays a run: what is the same for all runs is in src/draw/view/ and becomes
 * part of the library when it is built; here the run's own data are put in. */
#include "eventmill/view.h"

#include <stdio.h>
#include <string.h>

#include "draw/light.h"
#include "draw/view_frames.h"
#include "eventmill/colour.h"
#include "eventmill/picture.h"
#include "eventmill/plot.h"
#include "num/locale.h"
#include "record/output.h"
#include "view_page.h"

/* All that a page is made of. */
struct page {
  const struct em_scene *scene;
  const struct em_balls *balls;
  const struct em_view_frames *frames;
  double low, high; /* m/s, of the colours */
  bool dark;
};

static void put_base64(FILE *out, const uint8_t *bytes, size_t count) {
  static const char digit[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  for (size_t k = 0; k < count; k += 3) {
    const unsigned a = bytes[k], b = k + 1 < count ? bytes[k + 1] : 0;
    const unsigned c = k + 2 < count ? bytes[k + 2] : 0, all = a << 16 | b << 8 | c;
    const char four[4] = {digit[all >> 18], digit[all >> 12 & 63],
                          k + 1 < count ? digit[all >> 6 & 63] : '=',
                          k + 2 < count ? digit[all & 63] : '='};
    fwrite(four, 1, sizeof four, out);
  }
}

/* A string of JSON that can stand within a script element. */
static void put_text(FILE *out, const char *text) {
  putc('"', out);
  for (const unsigned char *c = (const unsigned char *)text; *c; c++) {
    if (*c == '"' || *c == '\\')
      fprintf(out, "\\%c", *c);
    else if (*c < ' ' || *c == '<' || *c == '>' || *c == '&')
      fprintf(out, "\\u%04x", *c);
    else
      putc(*c, out);
  }
  putc('"', out);
}

static void put_vec(FILE *out, const char *key, struct em_vec v) {
  fprintf(out, "\"%s\":[%.9g,%.9g,%.9g]", key, v.x, v.y, v.z);
}

static void put_numbers(FILE *out, const char *key, const double *value, size_t count) {
  fprintf(out, "\"%s\":[", key);
  for (size_t k = 0; k < count; k++)
    fprintf(out, "%s%.12g", k ? "," : "", value[k]);
  fprintf(out, "],\n");
}

static void put_blades(FILE *out, const struct em_scene *scene) {
  const char *comma = "";
  fprintf(out, "\"blades\":[");
  for (size_t r = 0; r < scene->rotor_count; r++)
    for (size_t k = 0; k < scene->rotor[r].blade_count; k++) {
      const struct em_blade *b = &scene->rotor[r].blade[k];
      fprintf(out, "%s{", comma);
      put_vec(out, "centre", b->centre);
      putc(',', out);
      put_vec(out, "axis", b->axis);
      putc(',', out);
      put_vec(out, "e1", b->e1);
      fprintf(out,
              ",\"angle\":%.17g,\"omega\":%.17g,\"radius\":%.9g,\"reach\":%.9g,\"tip\":\"%s\"}",
              b->angle, b->omega, b->radius, b->reach, em_surface_tip_name(b->tip));
      comma = ",\n";
    }
  fprintf(out, "],\n");
}

/* From where to where (m, along the axis) a shaft is to be seen: through a drum and its end rings;
 * an axis that is not the drum's, as far as its blades stand apart. */
static void put_shafts(FILE *out, const struct em_scene *scene) {
  const char *comma = "";
  fprintf(out, "\"shafts\":[");
  for (size_t r = 0; r < scene->rotor_count; r++) {
    const struct em_rotor *rotor = &scene->rotor[r];
    double radius = 0.0, from = INFINITY, to = -INFINITY;
    for (size_t k = 0; k < rotor->blade_count; k++) {
      const struct em_blade *b = &rotor->blade[k];
      const double h = em_vec_dot(em_vec_sub(b->centre, rotor->point), rotor->axis);
      radius = fmax(radius, 0.6 * b->radius);
      from = fmin(from, h - b->radius);
      to = fmax(to, h + b->radius);
    }
    if (!(radius > 0.0)) continue;
    if (scene->chamber.shape == EM_SHAPE_DRUM && rotor->axis.y > 0.999999) {
      const double out_of = 0.044 * scene->chamber.diameter;
      from = -out_of - rotor->point.y;
      to = scene->chamber.length + out_of - rotor->point.y;
    }
    fprintf(out, "%s{", comma);
    put_vec(out, "point", rotor->point);
    putc(',', out);
    put_vec(out, "axis", rotor->axis);
    fprintf(out, ",\"radius\":%.9g,\"from\":%.9g,\"to\":%.9g}", radius, from, to);
    comma = ",";
  }
  fprintf(out, "],\n");
}

static void put_chamber(FILE *out, const struct em_scene *scene) {
  const struct em_chamber *c = &scene->chamber;
  struct em_vec low, high;
  em_scene_extent(scene, &low, &high);
  fprintf(
      out,
      "\"shape\":\"%s\",\"diameter\":%.9g,\"length\":%.9g,\"facets\":%d,\"periodic\":[%d,%d,%d],",
      em_scene_shape_name(c->shape), c->diameter, c->length, c->facets, c->periodic[0],
      c->periodic[1], c->periodic[2]);
  put_vec(out, "low", low);
  putc(',', out);
  put_vec(out, "high", high);
  fprintf(out, ",\n");
}

static void put_titles(FILE *out, const struct em_scene *scene) {
  char point[512];
  em_plot_operating_point(scene, point, sizeof point);
  fprintf(out, "\"title\":");
  put_text(out, scene->title);
  fprintf(out, ",\"point\":");
  put_text(out, point);
  fprintf(out, ",\n");
}

static void put_names(FILE *out, const struct em_scene *scene) {
  fprintf(out, "\"classNames\":[");
  for (int k = 0; k < EM_CLASS_COUNT; k++) {
    if (k > 0) putc(',', out);
    put_text(out, em_contact_class_name((enum em_class)k));
  }
  fprintf(out, "],\"speciesNames\":[");
  for (size_t k = 0; k < scene->species_count; k++) {
    if (k > 0) putc(',', out);
    put_text(out, scene->species[k].name);
  }
  fprintf(out, "],\n");
}

static void put_radii(FILE *out, const struct em_scene *scene) {
  fprintf(out, "\"radii\":[");
  for (size_t k = 0; k < scene->species_count; k++)
    fprintf(out, "%s%.12g", k ? "," : "", 0.5 * scene->species[k].diameter);
  fprintf(out, "],\n");
}

static void put_colours(FILE *out) {
  enum { CYCLE = 16 };
  struct em_colour_map map;
  uint8_t cycle[CYCLE][3];
  em_colour_make(EM_COLOUR_LAGOON, &map);
  for (unsigned k = 0; k < CYCLE; k++)
    memcpy(cycle[k], em_colour_cycle(k), sizeof cycle[k]);
  fprintf(out, "\"cycle\":\"");
  put_base64(out, &cycle[0][0], sizeof cycle);
  fprintf(out, "\",\n");
  fprintf(out, "\"colours\":\"");
  put_base64(out, &map.rgb[0][0], sizeof map.rgb);
  /* The same light as in pictures; a browser's GLSL has another first line. */
  fprintf(out, "\",\n\"light\":");
  put_text(out, strchr(EM_LIGHT_GLSL, '\n') + 1);
}

static void put_head(FILE *out, const struct page *page) {
  const struct em_view_frames *f = page->frames;
  fprintf(out, "{\"count\":%zu,\"total\":%zu,\"limited\":%s,\"dark\":%s,\n", f->balls, f->total,
          f->balls < f->total ? "true" : "false", page->dark ? "true" : "false");
  put_titles(out, page->scene);
  put_chamber(out, page->scene);
  put_blades(out, page->scene);
  put_shafts(out, page->scene);
  put_radii(out, page->scene);
  fprintf(out, "\"scaleLow\":%.9g,\"scaleHigh\":%.9g,\"spinHigh\":%.9g,\n", page->low, page->high,
          em_picture_spin_scale(page->balls));
  put_names(out, page->scene);
  put_numbers(out, "times", f->time, f->count);
  put_numbers(out, "scales", f->scale, f->count);
  put_numbers(out, "spinScales", f->spin_scale, f->spins ? f->count : 0);
  put_colours(out);
  putc('}', out);
}

/* 16 bits for each ball, the low byte first. */
static void put_species(FILE *out, const struct page *page) {
  enum { ROOM = 3 * 1024 }; /* only the last piece of base64 may end within three bytes */
  const struct em_view_frames *f = page->frames;
  uint8_t species[2 * ROOM];
  for (size_t first = 0; first < f->balls; first += ROOM) {
    const size_t count = f->balls - first < ROOM ? f->balls - first : ROOM;
    for (size_t k = 0; k < count; k++) {
      const unsigned kind = page->balls->species[f->chosen[first + k]];
      species[2 * k] = (uint8_t)(kind & 0xff);
      species[2 * k + 1] = (uint8_t)(kind >> 8);
    }
    put_base64(out, species, 2 * count);
  }
}

/* Copies the page; a place holder is a name between two @. */
static void put_page(FILE *out, const struct page *page) {
  const struct em_view_frames *f = page->frames;
  const char *rest = (const char *)view_page;
  for (const char *hole; (hole = strchr(rest, '@')) != NULL;) {
    fwrite(rest, 1, (size_t)(hole - rest), out);
    rest = hole + 1;
    const size_t length = strspn(rest, "ABCDEFGHIJKLMNOPQRSTUVWXYZ");
    if (length == 0 || rest[length] != '@') {
      putc('@', out);
      continue;
    }
    if (strncmp(rest, "HEAD", length) == 0) put_head(out, page);
    if (strncmp(rest, "SPECIES", length) == 0) put_species(out, page);
    if (strncmp(rest, "FRAMES", length) == 0)
      put_base64(out, f->bytes, f->count * f->balls * EM_VIEW_BALL_BYTES);
    if (strncmp(rest, "SPINS", length) == 0)
      put_base64(out, f->spins, f->spins ? f->count * f->balls * EM_VIEW_SPIN_BYTES : 0);
    if (strncmp(rest, "CLASSES", length) == 0)
      put_base64(out, f->classes, f->classes ? f->count * f->balls : 0);
    if (strncmp(rest, "SCRIPT", length) == 0) fputs((const char *)view_script, out);
    rest += length + 1;
  }
  fputs(rest, out);
}

static enum em_status write_file(const struct page *page, const char *path, size_t *bytes,
                                 struct em_error *err) {
  struct em_output output;
  const enum em_status status = em_output_begin(&output, path, EM_OUTPUT_STREAM, err);
  if (status != EM_OK) return status;
  put_page(output.out, page);
  const long size = ftell(output.out); /* -1: a pipe */
  *bytes = size > 0 ? (size_t)size : 0;
  return em_output_end(&output, EM_OK, err);
}

enum em_status em_view_write(const struct em_run_file *run, const struct em_view_options *options,
                             const char *path, struct em_view_report *report,
                             struct em_error *err) {
  EM_LOCALE_PLAIN;
  struct em_view_frames frames = {0};
  struct em_motion *motion = NULL;
  size_t bytes = 0;
  enum em_status status = em_motion_new(&motion, run, 0.0, err);
  if (status == EM_OK && em_run_file_ball_count(run) == 0)
    status = em_error_set(err, EM_INPUT, em_run_file_path(run), 0, "the run has no balls");
  if (status == EM_OK) status = em_view_frames_fill(&frames, run, motion, options, err);
  if (status == EM_OK) {
    const struct em_balls *balls = em_motion_balls(motion);
    const struct em_scene *scene = em_run_file_scene(run);
    const struct page page = {
        .scene = scene,
        .balls = balls,
        .frames = &frames,
        .low = isnan(options->low) ? 0.0 : options->low,
        .high = isnan(options->high) ? em_picture_scale(scene, balls) : options->high,
        .dark = options->dark,
    };
    status = write_file(&page, path, &bytes, err);
  }
  if (status == EM_OK && report != NULL)
    *report = (struct em_view_report){
        .frames = frames.count,
        .balls = frames.balls,
        .bytes = bytes,
        .first = frames.time[0],
        .last = frames.time[frames.count - 1],
        .wanted = frames.wanted,
    };
  em_view_frames_clear(&frames);
  em_motion_free(motion);
  return status;
}
