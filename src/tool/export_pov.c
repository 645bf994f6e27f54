/* POV-Ray scenes: balls coloured by speed, a glass drum, steel blades. */
#include <math.h>

#include "eventmill/colour.h"
#include "eventmill/picture.h"
#include "record/output.h"
#include "tool/export.h"

static const char *const finish =
    "#declare Ball = finish { ambient 0.12 diffuse 0.7 specular 0.5 roughness 0.02 }\n"
    "#declare Steel = texture { pigment { rgb <0.55, 0.57, 0.6> }\n"
    "  finish { ambient 0.1 diffuse 0.6 specular 0.8 roughness 0.01 reflection 0.12 } }\n"
    "#declare Glass = texture { pigment { rgbt <0.92, 0.96, 1, 0.93> }\n"
    "  finish { ambient 0 diffuse 0.1 specular 0.6 roughness 0.002 } }\n";

/* POV-Ray's axes are left-handed: ours, with z up, are its <x, z, y>. */
static void put_vec(FILE *out, struct em_vec v) {
  fprintf(out, "<%.7g, %.7g, %.7g>", v.x, v.z, v.y);
}

static void camera(FILE *out, const struct em_scene *scene) {
  struct em_vec low, high;
  em_scene_extent(scene, &low, &high);
  const struct em_vec middle = em_vec_scale(0.5, em_vec_add(low, high));
  const double size = em_vec_norm(em_vec_sub(high, low));
  const struct em_vec eye = em_vec_add(middle, em_vec_scale(size, em_vec_make(0.95, -1.35, 0.55)));
  const struct em_vec lamp = em_vec_add(middle, em_vec_scale(size, em_vec_make(2.0, -2.0, 3.0)));
  const struct em_vec fill = em_vec_add(middle, em_vec_scale(size, em_vec_make(-3.0, -1.5, 1.0)));
  fprintf(out, "camera { perspective location ");
  put_vec(out, eye);
  /* The angle is that of the width; the shorter side of the picture holds all of the chamber. */
  fprintf(out, " right x*image_width/image_height up y "
               "angle 2*degrees(atan(0.28*max(1, image_width/image_height))) sky y look_at ");
  put_vec(out, middle);
  fprintf(out, " }\nlight_source { ");
  put_vec(out, lamp);
  fprintf(out, " rgb 1 }\nlight_source { ");
  put_vec(out, fill);
  fprintf(out, " rgb 0.45 shadowless }\nbackground { rgb 1 }\n");
}

static void cylinder(FILE *out, struct em_vec a, struct em_vec b, double radius, const char *rest) {
  fprintf(out, "cylinder { ");
  put_vec(out, a);
  fprintf(out, ", ");
  put_vec(out, b);
  fprintf(out, ", %.7g %s }\n", radius, rest);
}

/* A drum from y = a to b: a cylinder, or a prism whose facets touch it from outside. POV-Ray's
 * prisms rise along its y, so that its y and z are exchanged. */
static void barrel(FILE *out, const struct em_chamber *c, double radius, double a, double b) {
  if (c->facets == 0) {
    cylinder(out, em_vec_make(0, a, 0), em_vec_make(0, b, 0), radius, "");
    return;
  }
  const double step = 2.0 * M_PI / c->facets, corner = radius / cos(0.5 * step);
  fprintf(out, "prism { linear_sweep linear_spline %.7g, %.7g, %d", a, b, c->facets + 1);
  for (int k = 0; k <= c->facets; k++) {
    const double angle = (k % c->facets + 0.5) * step; /* from z to x */
    fprintf(out, ",\n  <%.7g, %.7g>", corner * sin(angle), corner * cos(angle));
  }
  fprintf(out, "\n  matrix <1, 0, 0, 0, 0, 1, 0, 1, 0, 0, 0, 0> }\n");
}

/* A steel ring around an end of the drum, from y = a to b. */
static void ring(FILE *out, const struct em_chamber *c, double a, double b) {
  const double slack = b - a, radius = 0.5 * c->diameter;
  fprintf(out, "difference {\n");
  barrel(out, c, 1.045 * radius, a, b);
  barrel(out, c, radius, a - slack, b + slack);
  fprintf(out, "texture { Steel } }\n");
}

static void walls(FILE *out, const struct em_scene *scene) {
  const struct em_chamber *c = &scene->chamber;
  if (c->shape == EM_SHAPE_DRUM) {
    const double wall = 0.015 * c->diameter, r = 0.5 * c->diameter;
    fprintf(out, "difference {\n");
    barrel(out, c, r + wall, -wall, c->length + wall);
    barrel(out, c, r, -2.0 * wall, c->length + 2.0 * wall);
    fprintf(out, "texture { Glass } no_shadow }\n");
    ring(out, c, -2.0 * wall, 0.0);
    ring(out, c, c->length, c->length + 2.0 * wall);
    return;
  }
  fprintf(out, "box { <0, 0, 0>, ");
  put_vec(out, c->size);
  fprintf(out, " texture { Glass } no_shadow }\n");
}

static void blade(FILE *out, const struct em_blade *b, double time) {
  const double angle = b->angle + b->omega * time;
  const struct em_vec bar = em_vec_add(em_vec_scale(cos(angle), b->e1),
                                       em_vec_scale(sin(angle), em_vec_cross(b->axis, b->e1)));
  const bool round = b->tip == EM_TIP_HEMISPHERE;
  const double half = round ? b->reach - b->radius : b->reach;
  const struct em_vec end[2] = {em_vec_axpy(b->centre, half, bar),
                                em_vec_axpy(b->centre, -half, bar)};
  cylinder(out, end[0], end[1], b->radius, "texture { Steel }");
  for (int k = 0; round && k < 2; k++) {
    fprintf(out, "sphere { ");
    put_vec(out, end[k]);
    fprintf(out, ", %.7g texture { Steel } }\n", b->radius);
  }
}

/* What carries the blades; balls do not meet it. */
static void shaft(FILE *out, const struct em_scene *scene, const struct em_rotor *rotor) {
  const double beyond = 0.044 * scene->chamber.diameter;
  if (scene->chamber.shape != EM_SHAPE_DRUM || rotor->axis.y < 0.999999) return;
  double radius = 0.0;
  for (size_t k = 0; k < rotor->blade_count; k++)
    radius = fmax(radius, 0.6 * rotor->blade[k].radius);
  if (radius > 0.0)
    cylinder(out, em_vec_make(rotor->point.x, -beyond, rotor->point.z),
             em_vec_make(rotor->point.x, scene->chamber.length + beyond, rotor->point.z), radius,
             "texture { Steel }");
}

/* sRGB to the linear light that POV-Ray 3.7 computes with. */
static double linear(uint8_t value) {
  const double s = value / 255.0;
  return s <= 0.04045 ? s / 12.92 : pow((s + 0.055) / 1.055, 2.4);
}

static void ball(FILE *out, const struct em_balls *b, size_t i, const struct em_colour_map *map,
                 double high) {
  const uint8_t *rgb = em_colour_at(map, em_vec_norm(b->velocity[i]), 0.0, high);
  fprintf(out, "sphere { ");
  put_vec(out, b->position[i]);
  fprintf(out, ", %.6g pigment { rgb <%.3f, %.3f, %.3f> } finish { Ball } }\n", b->radius[i],
          linear(rgb[0]), linear(rgb[1]), linear(rgb[2]));
}

static void write_scene(FILE *out, const struct em_scene *scene, const struct em_balls *balls,
                        double time, double top) {
  struct em_colour_map map;
  em_colour_make(EM_COLOUR_LAGOON, &map);
  fprintf(out, "// t = %.9g s; colours end at %.4g m/s. Render with: povray +W1280 +H720 +A FILE\n",
          time, top);
  fprintf(out, "#version 3.7;\nglobal_settings { assumed_gamma 1 max_trace_level 12 }\n%s", finish);
  camera(out, scene);
  walls(out, scene);
  for (size_t r = 0; r < scene->rotor_count; r++) {
    shaft(out, scene, &scene->rotor[r]);
    for (size_t k = 0; k < scene->rotor[r].blade_count; k++)
      blade(out, &scene->rotor[r].blade[k], time);
  }
  for (size_t i = 0; i < balls->count; i++)
    ball(out, balls, i, &map, top);
}

enum em_status em_export_pov_write(const struct em_export *job, struct em_error *err) {
  const struct em_scene *scene = em_run_file_scene(job->run);
  struct em_balls *balls = NULL;
  double top = 0.0;
  enum em_status status = em_run_file_balls(job->run, &balls, err);
  size_t written = 0;
  while (written < job->frames && status == EM_OK) {
    const size_t k = job->frame[written];
    struct em_output file;
    char path[EM_SCENE_PATH];
    em_export_file_name(path, sizeof path, job, written, NULL);
    status = em_run_file_frame(job->run, k, balls, err);
    if (status == EM_OK)
      status = em_output_begin(&file, job->frames > 1 ? path : job->out, EM_OUTPUT_STREAM, err);
    if (status != EM_OK) break;
    if (written == 0) top = em_picture_scale(scene, balls);
    write_scene(file.out, scene, balls, em_run_file_frame_time(job->run, k), top);
    status = em_output_end(&file, EM_OK, err);
    written += status == EM_OK;
  }
  em_start_free(balls);
  if (status != EM_OK) em_export_file_remove(job, written, NULL);
  return status;
}
