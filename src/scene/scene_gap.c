/* Distances between blades and from blades to walls, by support functions: the distance of two
 * convex bodies is the largest gap between parallel planes that part them,
 *
 *   gap = max over unit vectors n of  n·(c_B − c_A) − h_A(n) − h_B(−n),
 *
 * where h(n) is a body's extent along n (all bodies here are symmetric: h(−n) = h(n)). A turning
 * bar with flat ends sweeps the part |y| ≤ radius of a ball of radius √(reach² + radius²); one with
 * round ends a disc of radius reach − radius, thickened by the bar's radius. */
#include "scene/scene_gap.h"

#include <math.h>

struct em_scene_body em_scene_gap_body_at(const struct em_blade *blade, double angle) {
  struct em_vec e2 = em_vec_cross(blade->axis, blade->e1);
  return (struct em_scene_body){
      .centre = blade->centre,
      .axis = blade->axis,
      .bar = em_vec_axpy(em_vec_scale(cos(angle), blade->e1), sin(angle), e2),
      .radius = blade->radius,
      .reach = blade->reach,
      .round = blade->tip == EM_TIP_HEMISPHERE};
}

struct em_scene_body em_scene_gap_body(const struct em_blade *blade) {
  struct em_scene_body body = em_scene_gap_body_at(blade, blade->angle);
  body.swept = blade->omega != 0.0;
  return body;
}

double em_scene_gap_extent(const struct em_scene_body *body, struct em_vec n) {
  double a = body->radius, length = fmax(body->reach - a, 0.0);
  if (body->swept) {
    double na = fabs(em_vec_dot(n, body->axis)), np = sqrt(fmax(0.0, 1.0 - na * na));
    if (body->round) return length * np + a;
    double ball = sqrt(body->reach * body->reach + a * a);
    return ball * na <= a ? ball : na * a + np * body->reach;
  }
  double nb = fabs(em_vec_dot(n, body->bar));
  if (body->round) return length * nb + a;
  return body->reach * nb + a * sqrt(fmax(0.0, 1.0 - nb * nb));
}

/* The gap between the planes across n. */
static double parted(const struct em_scene_body *a, const struct em_scene_body *b,
                     struct em_vec n) {
  return em_vec_dot(n, em_vec_sub(b->centre, a->centre)) - em_scene_gap_extent(a, n) -
         em_scene_gap_extent(b, n);
}

static struct em_vec turned(struct em_vec n, struct em_vec t, double angle) {
  struct em_vec m = em_vec_axpy(em_vec_scale(cos(angle), n), sin(angle), t);
  return em_vec_scale(1.0 / em_vec_norm(m), m);
}

/* Climbs from n to the largest gap. Where the bodies are apart the gap has no other maxima, as it
 * is concave; the steps shrink until they are below what matters. */
static double climb(const struct em_scene_body *a, const struct em_scene_body *b, struct em_vec n,
                    double step) {
  enum { WAYS = 8, STEPS = 400 };
  const double gain = 1e-11 * (a->reach + b->reach); /* m */
  double best = parted(a, b, n);
  for (int k = 0; k < STEPS && step > 1e-7; ++k) {
    struct em_vec up = fabs(n.z) < 0.9 ? em_vec_make(0, 0, 1) : em_vec_make(1, 0, 0);
    struct em_vec t1 = em_vec_cross(n, up);
    t1 = em_vec_scale(1.0 / em_vec_norm(t1), t1);
    struct em_vec t2 = em_vec_cross(n, t1), next = n;
    for (int way = 0; way < WAYS; ++way) {
      double phi = 2.0 * M_PI * way / WAYS;
      struct em_vec t = em_vec_axpy(em_vec_scale(cos(phi), t1), sin(phi), t2);
      struct em_vec m = turned(n, t, step);
      double gap = parted(a, b, m);
      if (gap > best + gain) {
        best = gap;
        next = m;
      }
    }
    if (next.x == n.x && next.y == n.y && next.z == n.z) step *= 0.5;
    n = next;
  }
  return best;
}

/* Largest extent from the centre in any direction. */
static double span(const struct em_scene_body *body) {
  return body->round ? fmax(body->reach, body->radius) : hypot(body->reach, body->radius);
}

double em_scene_gap_bodies(const struct em_scene_body *a, const struct em_scene_body *b) {
  enum { DIRECTIONS = 400 };
  struct em_vec apart = em_vec_sub(b->centre, a->centre);
  double distance = em_vec_norm(apart), best = -INFINITY;
  if (distance == 0.0) return -fmin(a->radius, b->radius);
  struct em_vec n0 = em_vec_scale(1.0 / distance, apart), from = n0;
  best = parted(a, b, n0);
  /* Points spread evenly over the sphere (golden spiral), and the line of centres. */
  for (int k = 0; k < DIRECTIONS; ++k) {
    double z = 1.0 - (2.0 * k + 1.0) / DIRECTIONS, s = sqrt(1.0 - z * z);
    double phi = M_PI * (3.0 - sqrt(5.0)) * k;
    struct em_vec n = em_vec_make(s * cos(phi), s * sin(phi), z);
    double gap = parted(a, b, n);
    if (gap > best) {
      best = gap;
      from = n;
    }
  }
  /* The axes are where thin discs part. */
  for (int side = -1; side <= 1; side += 2)
    for (int k = 0; k < 2; ++k) {
      struct em_vec n = em_vec_scale(side, k == 0 ? a->axis : b->axis);
      double gap = parted(a, b, n);
      if (gap > best) {
        best = gap;
        from = n;
      }
    }
  return climb(a, b, from, 0.1);
}

/* Blades that sweep a common room and have speeds of the same size meet at fixed phases: the gap is
 * smallest over one turn. Otherwise every pair of angles comes. */
double em_scene_gap_blades(const struct em_blade *a, const struct em_blade *b) {
  enum { PHASES = 720 };
  struct em_scene_body sa = em_scene_gap_body(a), sb = em_scene_gap_body(b);
  double far = em_vec_norm(em_vec_sub(a->centre, b->centre)) - span(&sa) - span(&sb);
  if (far > 0.0) return far;
  double gap = em_scene_gap_bodies(&sa, &sb);
  if (gap > 0.0 || a->omega == 0.0 || fabs(a->omega) != fabs(b->omega)) return gap;
  gap = INFINITY;
  double slip = (a->reach + b->reach) * 2.0 * M_PI / PHASES;
  for (int k = 0; k < PHASES; ++k) {
    double turn = 2.0 * M_PI * k / PHASES;
    sa = em_scene_gap_body_at(a, a->angle + turn);
    sb = em_scene_gap_body_at(b, b->angle + (a->omega == b->omega ? turn : -turn));
    gap = fmin(gap, em_scene_gap_bodies(&sa, &sb));
  }
  /* Between two phases the gap may be smaller by half of what the ends move. */
  return gap - 0.5 * slip;
}

double em_scene_gap_plane(const struct em_scene_body *body, const struct em_scene *scene, int k,
                          int side) {
  struct em_vec low, high, n = em_vec_make(k == 0, k == 1, k == 2);
  em_scene_bounds(scene, &low, &high);
  double at = em_vec_component(body->centre, k);
  double room = side ? em_vec_component(high, k) - at : at - em_vec_component(low, k);
  return room - em_scene_gap_extent(body, n);
}

double em_scene_gap_drum(const struct em_scene_body *body, const struct em_scene *scene) {
  enum { DIRECTIONS = 3600 };
  double farthest = 0.0, at = 0.0, step = 2.0 * M_PI / DIRECTIONS;
  struct em_vec c = body->centre;
  for (int k = 0; k < DIRECTIONS; ++k) {
    struct em_vec n = em_vec_make(sin(k * step), 0.0, cos(k * step));
    double far = em_vec_dot(n, c) + em_scene_gap_extent(body, n);
    if (far > farthest) {
      farthest = far;
      at = k * step;
    }
  }
  for (; step > 1e-9; step *= 0.5)
    for (int side = -1; side <= 1; side += 2) {
      double phi = at + side * step;
      struct em_vec n = em_vec_make(sin(phi), 0.0, cos(phi));
      double far = em_vec_dot(n, c) + em_scene_gap_extent(body, n);
      if (far > farthest) {
        farthest = far;
        at = phi;
      }
    }
  return 0.5 * scene->chamber.diameter - farthest;
}
