/* Builds triangles by turning profiles about an axis. */
#include "draw/mesh.h"

#include <stdlib.h>
#include <string.h>

enum { ROUND = 96, DOME = 10 };

static void push(struct em_mesh *mesh, struct em_vec place, struct em_vec normal) {
  if (mesh->count == mesh->room) {
    const size_t room = mesh->room ? 2 * mesh->room : 4096;
    struct em_mesh_vertex *more = realloc(mesh->vertex, room * sizeof *more);
    if (more == NULL) {
      mesh->failed = true;
      return;
    }
    mesh->vertex = more;
    mesh->room = room;
  }
  mesh->vertex[mesh->count++] = (struct em_mesh_vertex){
      {(float)place.x, (float)place.y, (float)place.z},
      {(float)normal.x, (float)normal.y, (float)normal.z},
  };
}

struct corner {
  struct em_vec place, normal;
};

static void triangle(struct em_mesh *mesh, const struct corner *a, const struct corner *b,
                     const struct corner *c) {
  const struct em_vec turn =
      em_vec_cross(em_vec_sub(b->place, a->place), em_vec_sub(c->place, a->place));
  if (em_vec_norm2(turn) <= 0.0) return;
  const struct em_vec out = em_vec_add(em_vec_add(a->normal, b->normal), c->normal);
  const bool swap = em_vec_dot(turn, out) < 0.0;
  push(mesh, a->place, a->normal);
  push(mesh, swap ? c->place : b->place, swap ? c->normal : b->normal);
  push(mesh, swap ? b->place : c->place, swap ? b->normal : c->normal);
}

/* Two unit vectors that stand upright on a third. */
static void across(struct em_vec along, struct em_vec *e1, struct em_vec *e2) {
  const struct em_vec other =
      fabs(along.z) < 0.9 ? em_vec_make(0.0, 0.0, 1.0) : em_vec_make(0.0, 1.0, 0.0);
  const struct em_vec raw = em_vec_axpy(other, -em_vec_dot(other, along), along);
  *e1 = em_vec_scale(1.0 / em_vec_norm(raw), raw);
  *e2 = em_vec_cross(along, *e1);
}

/* A point of the profile in the direction `out`, of which only a corner's is longer than 1. */
static struct corner turned(const struct em_mesh_axis *axis, struct em_vec out,
                            struct em_vec facing, struct em_mesh_profile p) {
  const double length = hypot(p.normal_r, p.normal_h);
  return (struct corner){
      em_vec_axpy(em_vec_axpy(axis->origin, p.r, out), p.h, axis->along),
      em_vec_axpy(em_vec_scale(p.normal_r / length, facing), p.normal_h / length, axis->along),
  };
}

void em_mesh_revolve(struct em_mesh *mesh, const struct em_mesh_axis *axis,
                     struct em_mesh_profile p, struct em_mesh_profile q, int segments) {
  const bool flat = axis->facets > 0;
  const int sides = flat ? axis->facets : segments;
  const double step = 2.0 * M_PI / sides, corner = flat ? 1.0 / cos(0.5 * step) : 1.0;
  struct em_vec e1, e2;
  across(axis->along, &e1, &e2);
  for (int k = 0; k < sides; k++) {
    const double middle = step * k, from = flat ? middle - 0.5 * step : middle;
    const double angle[3] = {from, from + step, middle};
    struct em_vec out[3];
    for (int j = 0; j < 3; j++)
      out[j] = em_vec_axpy(em_vec_scale(cos(angle[j]), e1), sin(angle[j]), e2);
    struct corner c[4];
    for (int j = 0; j < 4; j++)
      c[j] = turned(axis, em_vec_scale(corner, out[j % 2]), out[flat ? 2 : j % 2], j < 2 ? p : q);
    triangle(mesh, &c[0], &c[1], &c[2]);
    triangle(mesh, &c[2], &c[1], &c[3]);
  }
}

void em_mesh_bar(struct em_mesh *mesh, const struct em_mesh_axis *axis, double r, double h0,
                 double h1) {
  const double edge = fmin(0.08 * r, 0.25 * (h1 - h0));
  const struct em_mesh_profile p[] = {
      {0.0, h0, 0, -1},     {r - edge, h0, 0, -1}, {r - edge, h0, 1, -1}, {r, h0 + edge, 1, -1},
      {r, h0 + edge, 1, 0}, {r, h1 - edge, 1, 0},  {r, h1 - edge, 1, 1},  {r - edge, h1, 1, 1},
      {r - edge, h1, 0, 1}, {0.0, h1, 0, 1},
  };
  for (size_t k = 0; k < sizeof p / sizeof *p; k += 2)
    em_mesh_revolve(mesh, axis, p[k], p[k + 1], ROUND / 2);
}

void em_mesh_capsule(struct em_mesh *mesh, const struct em_mesh_axis *axis, double r, double h0,
                     double h1) {
  for (int end = 0; end < 2; end++) {
    const double sign = end ? 1.0 : -1.0, middle = end ? h1 - r : h0 + r;
    for (int k = 0; k < DOME; k++) {
      const double a = 0.5 * M_PI * k / DOME, b = 0.5 * M_PI * (k + 1) / DOME;
      em_mesh_revolve(
          mesh, axis,
          (struct em_mesh_profile){r * cos(a), middle + sign * r * sin(a), cos(a), sign * sin(a)},
          (struct em_mesh_profile){r * cos(b), middle + sign * r * sin(b), cos(b), sign * sin(b)},
          ROUND / 2);
    }
  }
  em_mesh_revolve(mesh, axis, (struct em_mesh_profile){r, h0 + r, 1, 0},
                  (struct em_mesh_profile){r, h1 - r, 1, 0}, ROUND / 2);
}

void em_mesh_ring(struct em_mesh *mesh, const struct em_mesh_axis *axis, double inner, double outer,
                  double h0, double h1) {
  const double edge = 0.15 * fmin(outer - inner, h1 - h0);
  const struct em_mesh_profile p[] = {
      {inner, h0, -1, 0},        {inner, h1, -1, 0},        {inner, h0, 0, -1},
      {outer - edge, h0, 0, -1}, {outer - edge, h0, 1, -1}, {outer, h0 + edge, 1, -1},
      {outer, h0 + edge, 1, 0},  {outer, h1 - edge, 1, 0},  {outer, h1 - edge, 1, 1},
      {outer - edge, h1, 1, 1},  {outer - edge, h1, 0, 1},  {inner, h1, 0, 1},
  };
  for (size_t k = 0; k < sizeof p / sizeof *p; k += 2)
    em_mesh_revolve(mesh, axis, p[k], p[k + 1], ROUND);
}

void em_mesh_quad(struct em_mesh *mesh, struct em_vec p, struct em_vec a, struct em_vec b) {
  const struct em_vec raw = em_vec_cross(a, b);
  const struct em_vec normal = em_vec_scale(1.0 / em_vec_norm(raw), raw);
  const struct corner c[4] = {{p, normal},
                              {em_vec_add(p, a), normal},
                              {em_vec_add(em_vec_add(p, a), b), normal},
                              {em_vec_add(p, b), normal}};
  triangle(mesh, &c[0], &c[1], &c[2]);
  triangle(mesh, &c[0], &c[2], &c[3]);
}

void em_mesh_clear(struct em_mesh *mesh) {
  free(mesh->vertex);
  memset(mesh, 0, sizeof *mesh);
}
