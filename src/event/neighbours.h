/* Near-neighbour lists: what the loop asks of them stands here, to be worked on in place; how they
 * are made and renewed is in partition_neighbours.c. */
#ifndef EVENTMILL_EVENT_NEIGHBOURS_H
#define EVENTMILL_EVENT_NEIGHBOURS_H

#include <math.h>

#include "event/body.h"
#include "event/fetch.h"
#include "event/vectors.h"

#define EM_NEIGHBOURS_STRAIGHT 0.8 /* share of the skin for the straight part of a path */

/* The sphere in which a ball stays until plan.leave. */
struct em_shell {
  float centre[3]; /* m */
  float skin;      /* m: room for the ball's centre */
};

struct em_list {
  uint32_t at; /* first entry in the pool */
  uint32_t count, room;
};

/* What an event of a ball reads: half a cache line. */
struct em_place {
  struct em_shell shell;
  struct em_list list;
} __attribute__((aligned(32)));

struct em_neighbours {
  struct em_place *of;          /* of each ball */
  uint32_t *pool;               /* of all lists */
  double omega;                 /* rad/s of the shells about the drum's axis */
  double bend, bend_per_speed2; /* m/s², 1/m: see set_bend in partition_neighbours.c */
};

/* Vectors of two balls. */
struct em_two {
  v2d x, y, z;
};

static inline v2d em_two_dot(struct em_two a, struct em_two b) {
  return (a.x * b.x + a.y * b.y) + a.z * b.z;
}

/* From the centres of shells r and s to two places, or to their nearest images. */
static inline __attribute__((always_inline)) struct em_two
em_neighbours_offset(const struct em_world *w, const struct em_shell *r, const struct em_shell *s,
                     struct em_two at, bool periodic) {
  const float *a = r->centre, *b = s->centre;
  struct em_two o = {at.x - (v2d){(double)a[0], (double)b[0]},
                     at.y - (v2d){(double)a[1], (double)b[1]},
                     at.z - (v2d){(double)a[2], (double)b[2]}};
  if (!periodic) return o;
  o.x -= w->period.x * v2d_nearest(o.x * w->per_period.x);
  o.y -= w->period.y * v2d_nearest(o.y * w->per_period.y);
  o.z -= w->period.z * v2d_nearest(o.z * w->per_period.z);
  return o;
}

/* How long (s) two balls, seen at these places (m) with these velocities (m/s), surely stay in
 * shells r and s. The straight path may use a part of the skin, or, where the ball is beyond that
 * already, half of what is left; what bends it by less than `bend` (m/s²) has the rest. Inwards or
 * outwards is anybody's guess: no branches. */
static inline __attribute__((always_inline)) v2d
em_neighbours_stay(const struct em_world *w, const struct em_shell *r, const struct em_shell *s,
                   struct em_two at, struct em_two speed, v2d bend, bool bends, bool periodic) {
  const v2d zero = {0.0, 0.0}, ever = {INFINITY, INFINITY};
  const v2d skin = {(double)r->skin, (double)s->skin};
  const struct em_two o = em_neighbours_offset(w, r, s, at, periodic);
  const v2d oo = em_two_dot(o, o), b = em_two_dot(o, speed), vv = em_two_dot(speed, speed);
  v2d room = (bends ? EM_NEIGHBOURS_STRAIGHT : 0.999999) * skin;
  if (bends && __builtin_expect(v2l_any(oo >= room * room), 0))
    room = v2d_choose(oo >= room * room, 0.5 * (v2d_sqrt(oo) + skin), room);
  const v2d c = room * room - oo, root = v2d_sqrt(b * b + vv * c);
  const v2l out = b > zero;
  v2d stay = v2d_choose(out, c, root - b) / v2d_choose(out, b + root, vv);
  stay = v2d_choose((vv == zero) & (c > zero), ever, stay);
  if (bends) {
    const v2d most = v2d_sqrt(2.0 * (skin - room) / bend);
    stay = v2d_choose(stay < most, stay, most);
  }
  return v2d_choose(stay > zero, stay, zero);
}

/* Balls i and j move along new paths: sets their leave times, where shells do not turn. Both at a
 * time, and in place: a gain of 1.05 in dense gases. */
static inline __attribute__((always_inline)) void
em_neighbours_moved(struct em_world *w, uint32_t i, uint32_t j, bool falls, bool periodic) {
  const struct em_neighbours *n = w->lists;
  const struct em_body *a = &w->body[i], *b = &w->body[j];
  const struct em_two at = {{a->x, b->x}, {a->y, b->y}, {a->z, b->z}};
  const struct em_two speed = {{a->vx, b->vx}, {a->vy, b->vy}, {a->vz, b->vz}};
  const v2d leave =
      (v2d){a->t, b->t} + em_neighbours_stay(w, &n->of[i].shell, &n->of[j].shell, at, speed,
                                             (v2d){n->bend, n->bend}, falls, periodic);
  w->plan[i].leave = leave[0];
  w->plan[j].leave = leave[1];
}

/* Asks memory for what a prediction of ball i reads: where its list is, later (`beyond`) the list.
 */
static inline void em_neighbours_fetch(const struct em_neighbours *n, uint32_t i, bool beyond) {
  if (beyond)
    em_fetch(n->pool + n->of[i].list.at);
  else
    em_fetch(&n->of[i]);
}

#endif
