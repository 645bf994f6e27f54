/* Walls and blades as a binary STL surface. */
#include <endian.h>
#include <math.h>
#include <string.h>

#include "record/output.h"
#include "tool/export.h"

enum { AROUND = 96 };

struct mesh {
  FILE *out; /* NULL: only count */
  uint32_t triangles;
};

static void put_vec(FILE *out, struct em_vec v) {
  em_export_file_float(out, v.x);
  em_export_file_float(out, v.y);
  em_export_file_float(out, v.z);
}

/* The normal is that of the right hand a → b → c. Triangles without area are left out. */
static void triangle(struct mesh *mesh, struct em_vec a, struct em_vec b, struct em_vec c) {
  const struct em_vec n = em_vec_cross(em_vec_sub(b, a), em_vec_sub(c, a));
  const double size = em_vec_norm(n);
  if (!(size > 0.0)) return;
  mesh->triangles++;
  if (!mesh->out) return;
  put_vec(mesh->out, em_vec_scale(1.0 / size, n));
  put_vec(mesh->out, a);
  put_vec(mesh->out, b);
  put_vec(mesh->out, c);
  fwrite("\0\0", 2, 1, mesh->out);
}

static void quad(struct mesh *mesh, struct em_vec a, struct em_vec b, struct em_vec c,
                 struct em_vec d) {
  triangle(mesh, a, b, c);
  triangle(mesh, a, c, d);
}

/* Where a body of revolution stands: u and v are unit vectors with u × v = axis. Its rings have
 * `around` points, the first at the angle `begin` (rad) from u. */
struct stand {
  struct em_vec origin, axis, u, v;
  int around;
  double begin;
};

/* Ring k lies at distance along[k] with radius out[k]. Normals point away from the axis for rising
 * `along`, towards it for falling. */
static void revolve(struct mesh *mesh, const struct stand *s, const double *along,
                    const double *out, int rings) {
  for (int k = 0; k + 1 < rings; k++)
    for (int j = 0; j < s->around; j++) {
      struct em_vec p[4];
      for (int corner = 0; corner < 4; corner++) {
        const int ring = k + (corner == 2 || corner == 3), step = j + (corner == 1 || corner == 2);
        const double phi = s->begin + 2.0 * M_PI * (step % s->around) / s->around;
        p[corner] = em_vec_axpy(s->origin, along[ring], s->axis);
        p[corner] = em_vec_axpy(p[corner], out[ring] * cos(phi), s->u);
        p[corner] = em_vec_axpy(p[corner], out[ring] * sin(phi), s->v);
      }
      quad(mesh, p[0], p[1], p[2], p[3]);
    }
}

/* Inside of the drum with its end walls: normals point into the room. */
static void drum(struct mesh *mesh, const struct em_scene *scene) {
  const double l = scene->chamber.length, r = em_scene_reach(scene);
  const int facets = scene->chamber.facets;
  const struct stand stand = {.axis = {0, 1, 0},
                              .u = {0, 0, 1},
                              .v = {1, 0, 0},
                              .around = facets > 0 ? facets : AROUND,
                              .begin = facets > 0 ? M_PI / facets : 0.0}; /* a corner */
  const double along[] = {l, l, 0.0, 0.0}, out[] = {0.0, r, r, 0.0};
  revolve(mesh, &stand, along, out, 4);
}

static void box(struct mesh *mesh, const struct em_chamber *c) {
  const struct em_vec s = c->size;
  struct em_vec p[8];
  for (int k = 0; k < 8; k++)
    p[k] = em_vec_make(k & 1 ? s.x : 0.0, k & 2 ? s.y : 0.0, k & 4 ? s.z : 0.0);
  static const int face[6][4] = {{0, 2, 6, 4}, {1, 5, 7, 3}, {0, 4, 5, 1},
                                 {2, 3, 7, 6}, {0, 1, 3, 2}, {4, 6, 7, 5}};
  for (int f = 0; f < 6; f++)
    if (!c->periodic[f / 2]) quad(mesh, p[face[f][0]], p[face[f][1]], p[face[f][2]], p[face[f][3]]);
}

/* The bar from end to end, its tips flat or rounded; normals point into the room. */
static void blade(struct mesh *mesh, const struct em_blade *b, double time) {
  enum { CAP = 12 };
  const double angle = b->angle + b->omega * time, r = b->radius;
  const struct em_vec bar = em_vec_add(em_vec_scale(cos(angle), b->e1),
                                       em_vec_scale(sin(angle), em_vec_cross(b->axis, b->e1)));
  const struct stand stand = {b->centre, bar, b->axis, em_vec_cross(bar, b->axis), AROUND, 0.0};
  double along[2 * CAP + 2], out[2 * CAP + 2];
  const double straight = b->tip == EM_TIP_HEMISPHERE ? b->reach - r : b->reach;
  int rings = 0;
  for (int end = -1; end <= 1; end += 2)
    for (int k = 0; k <= CAP; k++) {
      const double a = 0.5 * M_PI * (end < 0 ? CAP - k : k) / CAP; /* from the rim to the pole */
      const bool round = b->tip == EM_TIP_HEMISPHERE;
      if (!round && k > 0 && k < CAP) continue;
      along[rings] = end * (straight + (round ? r * sin(a) : 0.0));
      out[rings++] = (end < 0 ? k : CAP - k) == 0 ? 0.0 : round ? r * cos(a) : r;
    }
  revolve(mesh, &stand, along, out, rings);
}

static void everything(struct mesh *mesh, const struct em_scene *scene, double time) {
  if (scene->chamber.shape == EM_SHAPE_DRUM)
    drum(mesh, scene);
  else
    box(mesh, &scene->chamber);
  for (size_t r = 0; r < scene->rotor_count; r++)
    for (size_t k = 0; k < scene->rotor[r].blade_count; k++)
      blade(mesh, &scene->rotor[r].blade[k], time);
}

enum em_status em_export_stl_write(const struct em_export *job, struct em_error *err) {
  const struct em_scene *scene = em_run_file_scene(job->run);
  const double time = job->frames > 0 ? em_run_file_frame_time(job->run, job->frame[0]) : 0.0;
  struct em_output file;
  const enum em_status status = em_output_begin(&file, job->out, EM_OUTPUT_STREAM, err);
  if (status != EM_OK) return status;
  struct mesh mesh = {NULL, 0};
  everything(&mesh, scene, time);
  char header[80];
  memset(header, 0, sizeof header);
  snprintf(header, sizeof header, "Eventmill, metres, t = %.9g s", time);
  fwrite(header, sizeof header, 1, file.out);
  const uint32_t count = htole32(mesh.triangles);
  fwrite(&count, sizeof count, 1, file.out);
  mesh = (struct mesh){file.out, 0};
  everything(&mesh, scene, time);
  return em_output_end(&file, EM_OK, err);
}
