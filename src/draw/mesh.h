/* Triangles of surfaces of revolution: all that a mill's machine is made of. */
#ifndef EM_DRAW_MESH_H
#define EM_DRAW_MESH_H

#include <stdbool.h>
#include <stddef.h>

#include "eventmill/vec.h"

struct em_mesh_vertex {
  float place[3], normal[3];
};

struct em_mesh {
  size_t count, room;
  struct em_mesh_vertex *vertex; /* owned; three for each triangle, counterclockwise from outside */
  bool failed;                   /* memory was short */
};

/* Where a surface of revolution stands: the origin, and the unit vector of its axis; or a prism, of
 * flat sides that touch the round surface from outside, the first of them towards z (towards y when
 * that is the axis). */
struct em_mesh_axis {
  struct em_vec origin, along;
  int facets; /* 0: round */
};

/* A point of a profile: distance from the axis, place along it, and the direction of the normal. */
struct em_mesh_profile {
  double r, h, normal_r, normal_h;
};

/* Turns the line from p to q about the axis; round ones have so many segments. */
void em_mesh_revolve(struct em_mesh *mesh, const struct em_mesh_axis *axis,
                     struct em_mesh_profile p, struct em_mesh_profile q, int segments);

/* A closed bar of the radius r from h0 to h1 with flat ends and slightly broken edges. */
void em_mesh_bar(struct em_mesh *mesh, const struct em_mesh_axis *axis, double r, double h0,
                 double h1);

/* The same with hemispheres at both ends, which are within h0 … h1. */
void em_mesh_capsule(struct em_mesh *mesh, const struct em_mesh_axis *axis, double r, double h0,
                     double h1);

/* A ring of rectangular section. */
void em_mesh_ring(struct em_mesh *mesh, const struct em_mesh_axis *axis, double inner, double outer,
                  double h0, double h1);

/* A parallelogram with the corner p and the sides a, b; its normal is a × b. */
void em_mesh_quad(struct em_mesh *mesh, struct em_vec p, struct em_vec a, struct em_vec b);

void em_mesh_clear(struct em_mesh *mesh);

#endif
