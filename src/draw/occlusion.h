/* How much of the sky each ball sees past its neighbours. */
#ifndef EM_DRAW_OCCLUSION_H
#define EM_DRAW_OCCLUSION_H

#include <stddef.h>

/* A sphere as the drawing knows it. On input occlusion is free; see em_occlusion_fill. */
struct em_sphere {
  float place[3], radius; /* m */
  float occlusion[4];     /* vector and constant of the linear law: a point with normal n loses
                             max(0, o[3] + n·(o[0], o[1], o[2])) */
  unsigned char rgba[4];
};

/* Working space that is kept from call to call. All zero at first. */
struct em_occlusion {
  size_t cells, spheres;
  unsigned *first; /* cells + 1 */
  unsigned *order; /* spheres */
};

/* Fills in the occlusion of all spheres by their neighbours within two diameters of the largest. A
 * neighbour of radius R at distance d in the direction u takes (R/d)² max(0, n·u) of the light
 * (cosine-weighted solid angle); max(0, cos) is replaced by its first two Legendre terms,
 * 1/4 + cos/2. 0: memory is short. */
int em_occlusion_fill(struct em_occlusion *space, struct em_sphere *sphere, size_t count);

void em_occlusion_clear(struct em_occlusion *space);

#endif
