/* When a ball in free flight first touches a turning blade: a search that provably jumps over no
 * contact. The derivation is in docs/physics.md. */
#include <float.h>
#include <stddef.h>

#include "eventmill/surface.h"

/* Distance to something and its time derivative. */
struct gap {
  double value, rate;
};

/* The search for one ball and one blade, in coordinates about the blade's centre: u along e1, w
 * along axis × e1, y along the axis. */
struct search {
  double pu, pw, py, vu, vw, vy, gu, gw, gy;
  double fall;         /* m/s², |g| */
  double angle, omega; /* of the blade */
  double radius;       /* m, of the ball */
  double a, reach;     /* m, of the blade */
  enum em_tip tip;
  double rim;       /* m from the blade's centre to the farthest point of a flat end */
  double bound;     /* m from the rotor's axis: no contact is farther out */
  double tolerance; /* m, rounding of a distance */
};

/* Where the ball is at one time. */
struct place {
  double u, w, y, du, dw, dy;
  double r, speed; /* m from the rotor's axis; m/s across it */
};

static struct place place_at(const struct search *s, double t) {
  struct place p;
  p.u = s->pu + t * (s->vu + 0.5 * t * s->gu);
  p.w = s->pw + t * (s->vw + 0.5 * t * s->gw);
  p.y = s->py + t * (s->vy + 0.5 * t * s->gy);
  p.du = s->vu + t * s->gu;
  p.dw = s->vw + t * s->gw;
  p.dy = s->vy + t * s->gy;
  p.r = sqrt(p.u * p.u + p.w * p.w);
  p.speed = sqrt(p.du * p.du + p.dw * p.dw);
  return p;
}

/* Distance from the point (x, y) of a half plane to the profile of the slab |y| ≤ a inside the
 * sphere of radius rim = √(reach² + a²), which is what a bar with flat ends sweeps. */
static struct gap swept_flat(const struct place *p, double reach, double a, double rim,
                             double radius) {
  const double sign = p->y < 0.0 ? -1.0 : 1.0, y = sign * p->y, dy = sign * p->dy;
  const double up = y - a, out = p->r - reach;
  const double turn = p->u * p->du + p->w * p->dw; /* r r' */
  if (up <= 0.0 || up * reach < out * a) {
    const double far = sqrt(p->r * p->r + y * y);
    return (struct gap){far - rim - radius, far > 0.0 ? (turn + y * dy) / far : 0.0};
  }
  if (out <= 0.0) return (struct gap){up - radius, dy};
  const double d = sqrt(up * up + out * out);
  return (struct gap){d - radius, (up * dy + out * turn / p->r) / d};
}

/* The same for a bar with hemispherical ends: a disc of radius reach − a, thickened by a. */
static struct gap swept_round(const struct place *p, double reach, double a, double radius) {
  const double out = p->r - (reach > a ? reach - a : 0.0);
  const double sign = p->y < 0.0 ? -1.0 : 1.0;
  if (out <= 0.0) return (struct gap){sign * p->y - a - radius, sign * p->dy};
  const double d = sqrt(out * out + p->y * p->y);
  const double dr = p->r > 0.0 ? (p->u * p->du + p->w * p->dw) / p->r : p->speed;
  return (struct gap){d - a - radius, (out * dr + p->y * p->dy) / d};
}

/* Distance of the ball from the body that the blade sweeps in a turn: a lower bound of its distance
 * from the blade at any angle. (Tip `none`: of its centre from the places where contacts are.) */
static struct gap swept(const struct search *s, const struct place *p) {
  switch (s->tip) {
  case EM_TIP_HEMISPHERE:
    return swept_round(p, s->reach, s->a, s->radius);
  case EM_TIP_NONE:
    return swept_flat(p, s->reach, s->a + s->radius, s->rim, 0.0);
  case EM_TIP_FLAT:
  case EM_TIP_COUNT:
    break;
  }
  return swept_flat(p, s->reach, s->a, s->rim, s->radius);
}

/* In the frame that turns with the blade: x along the bar, ρ from its axis, and their rates. */
struct turned {
  double x, rho, dx, drho;
};

static struct turned turn(const struct search *s, const struct place *p, double t) {
  double sine, cosine;
  sincos(s->angle + s->omega * t, &sine, &cosine);
  const double x = p->u * cosine + p->w * sine, z = p->w * cosine - p->u * sine;
  const double dx = p->du * cosine + p->dw * sine + s->omega * z;
  const double dz = p->dw * cosine - p->du * sine - s->omega * x;
  const double rho = sqrt(p->y * p->y + z * z);
  const double drho = rho > 0.0 ? (p->y * p->dy + z * dz) / rho : sqrt(p->dy * p->dy + dz * dz);
  return x < 0.0 ? (struct turned){-x, rho, -dx, drho} : (struct turned){x, rho, dx, drho};
}

/* Distance between the surfaces of ball and blade; convex in the ball's place, of slope 1. */
static struct gap distance(const struct search *s, const struct turned *q) {
  if (s->tip == EM_TIP_NONE) return (struct gap){q->rho - (s->a + s->radius), q->drho};
  const bool round = s->tip == EM_TIP_HEMISPHERE;
  const double end = round ? (s->reach > s->a ? s->reach - s->a : 0.0) : s->reach;
  const double ax = q->x - end, ar = round ? q->rho : q->rho - s->a;
  const double off = round ? s->a + s->radius : s->radius;
  if (ax <= 0.0 && (round || ar > ax)) return (struct gap){ar - off, q->drho};
  if (ar <= 0.0) return (struct gap){ax - off, q->dx};
  const double d = sqrt(ax * ax + ar * ar);
  return (struct gap){d - off, (ax * q->dx + ar * q->drho) / d};
}

/* The time for which f + f' s − ½ bend s² stays positive; from f = 0, where it has become positive,
 * or where f' turns negative if it never does. */
static double safe_step(double f, double rate, double bend) {
  const double disc = rate * rate + 2.0 * bend * f;
  const double root = disc > 0.0 ? sqrt(disc) : 0.0;
  if (rate < 0.0) return 2.0 * f / (root - rate);
  return bend > 0.0 ? (rate + root) / bend : INFINITY;
}

/* Does f + f' s − ½ bend s² stay above the tolerance for so long? It is concave: the ends decide.
 */
static bool is_clear(struct gap f, double bend, double time, double tolerance) {
  return f.value > tolerance && f.value + (f.rate - 0.5 * bend * time) * time > tolerance;
}

/* A bound of the acceleration in the frame that turns, valid for the next 1/|ω|:
 * |g| + 2 |ω| V + ω² r with the growth of V and r under gravity. */
static double acceleration(const struct search *s, const struct place *p) {
  if (s->omega == 0.0) return s->fall;
  const double omega = fabs(s->omega), r = p->r > s->bound ? p->r : s->bound;
  return 3.125 * s->fall + omega * (2.0 * p->speed + omega * r);
}

/* From a gap that rounding nearly hides to the contact; 0 where that is so flat that the way there
 * bends by more than the gap. */
static double last_step(const struct search *s, const struct place *p, struct gap f, double bend) {
  if (f.value <= 0.0) return 0.0;
  const double time = safe_step(f.value, f.rate, bend);
  const double speed = p->speed + fabs(p->dy) + fabs(s->omega) * p->r;
  return (bend + speed * speed / s->radius) * time * time < s->tolerance ? time : 0.0;
}

/* Inside the endless bar of the tip `none`: F = ρ² − w² has F'' ≤ 2 U² + 2 w A; the first root of
 * the upper parabola is not later than the exit. U holds for the time in which a ball falls half
 * the width, and the step is no longer. */
static double inside_step(const struct search *s, const struct place *p, const struct turned *q,
                          double bend) {
  const double width = s->a + s->radius, omega = fabs(s->omega);
  const double r = p->r > s->bound ? p->r : s->bound;
  const double drift = sqrt(width * s->fall);
  const double u = p->speed + drift + omega * (r + width), w = fabs(p->dy) + drift;
  const double value = em_lesser((q->rho - width) * (q->rho + width), 0.0);
  const double rate = 2.0 * q->rho * q->drho, curve = 2.0 * (u * u + w * w + width * bend);
  const double root = sqrt(rate * rate - 2.0 * curve * value);
  const double step = rate > 0.0    ? -2.0 * value / (rate + root)
                      : curve > 0.0 ? (root - rate) / curve
                                    : INFINITY;
  return s->fall > 0.0 ? em_lesser(step, sqrt(width / s->fall)) : step;
}

/* A ball that is slower than rounding over half a turn: the time until it has moved by that. */
static double idle_step(const struct search *s, const struct place *p) {
  const double speed = sqrt(p->speed * p->speed + p->dy * p->dy);
  const double half = s->omega != 0.0 ? M_PI / fabs(s->omega) : INFINITY;
  if ((speed + 0.5 * s->fall * half) * half > s->tolerance) return 0.0;
  return 2.0 * s->tolerance / (speed + sqrt(speed * speed + 2.0 * s->fall * s->tolerance));
}

/* After this time the ball is beyond the blade for ever. */
static double gone(const struct search *s, const struct place *p) {
  if (s->fall == 0.0) return INFINITY;
  const double speed = sqrt(p->speed * p->speed + p->dy * p->dy);
  const double way = 2.0 * s->bound + p->r + fabs(p->y);
  return (speed + sqrt(speed * speed + 2.0 * s->fall * way)) / s->fall;
}

/* On the way along a path. */
struct walk {
  double t;     /* s */
  double since; /* s: from when on its steps near the blade add up to half a turn at most */
  bool inside;  /* within the endless bar of a blade without tip, beyond its end */
  bool meets;   /* the step that was chosen is the last one, to the contact */
};

/* The step from a place that the blade can reach: to where the ball can touch it at the earliest.
 * `f`: the gap there. */
static double next_step(const struct search *s, struct walk *walk, const struct place *p,
                        const struct turned *q, struct gap f, double bend) {
  const bool ends = s->tip != EM_TIP_NONE;
  if (!ends && f.value < -1e-9 * (s->radius + s->a)) walk->inside = true;
  if (f.value > s->tolerance) walk->inside = false; /* it left beyond the reach */
  if (walk->inside && (f.value < -s->tolerance || f.rate <= 0.0)) return inside_step(s, p, q, bend);
  walk->inside = false;
  if (!(f.value <= s->tolerance && f.rate < 0.0)) return safe_step(f.value, f.rate, bend);
  walk->meets = ends || q->x <= s->reach;
  if (walk->meets) return last_step(s, p, f, bend);
  walk->inside = true;
  return inside_step(s, p, q, bend);
}

/* Not longer than A is a bound, and as long as `least`, which rounding hides, or as what is out of
 * reach allows. A ball that has not moved by more than rounding for half a turn waits. */
static double bounded(const struct search *s, struct walk *walk, const struct place *p,
                      struct gap outer, double step, double least) {
  const double cap = s->omega != 0.0 ? 1.0 / fabs(s->omega) : INFINITY;
  if (step < least) step = least;
  if (step > cap) step = cap;
  if (outer.value > 0.0) step = em_greater(step, safe_step(outer.value, outer.rate, s->fall));
  if (walk->t + step - walk->since > M_PI * cap) {
    step = em_greater(step, idle_step(s, p));
    walk->since = walk->t;
  }
  return step;
}

/* The time of the first contact: from place to place by steps that jump over none. */
static double first_contact(const struct search *s, bool touched, double horizon, unsigned *steps) {
  const double near = 1e-3 * (s->radius + s->a);
  const double cap = s->omega != 0.0 ? 1.0 / fabs(s->omega) : INFINITY;
  struct walk walk = {.t = 0.0};
  struct place p = place_at(s, 0.0);
  const double limit = em_lesser(horizon < INFINITY ? horizon : gone(s, &p), DBL_MAX);
  /* Rounding of the angle comes on top of that of the place. */
  const double angle = fabs(s->angle) + fabs(s->omega) * limit;
  const double doubt = s->tolerance + 4.0 * DBL_EPSILON * angle * s->bound;
  for (; walk.t <= limit; p = place_at(s, walk.t)) {
    const bool begins = touched && walk.t == 0.0;
    const struct gap outer = swept(s, &p);
    const double rest = limit - walk.t;
    if (is_clear(outer, s->fall, rest, doubt)) break;
    if (outer.value > near && !begins) {
      walk.since = walk.t += safe_step(outer.value, outer.rate, s->fall);
      continue;
    }
    ++*steps;
    const struct turned q = turn(s, &p, walk.t);
    struct gap f = distance(s, &q);
    if (begins) f.value = 0.0;
    const double bend = acceleration(s, &p);
    if (rest < cap && is_clear(f, bend, rest, doubt)) break;
    const double step = next_step(s, &walk, &p, &q, f, bend);
    if (walk.meets) return walk.t + step <= horizon ? walk.t + step : INFINITY;
    const double least = f.rate >= 0.0 || walk.inside ? sqrt(2.0 * s->tolerance / bend) : 0.0;
    const double next = walk.t + bounded(s, &walk, &p, outer, step, least);
    walk.t = next > walk.t ? next : nextafter(walk.t, INFINITY);
  }
  return INFINITY;
}

static struct search prepare(const struct em_blade *blade, struct em_vec r, double radius,
                             double angle) {
  const struct em_vec e2 = em_vec_cross(blade->axis, blade->e1);
  const struct em_vec d = em_vec_sub(r, blade->centre);
  struct search s = {.angle = angle,
                     .omega = blade->omega,
                     .radius = radius,
                     .a = blade->radius,
                     .reach = blade->reach,
                     .tip = blade->tip};
  s.pu = em_vec_dot(d, blade->e1);
  s.pw = em_vec_dot(d, e2);
  s.py = em_vec_dot(d, blade->axis);
  const double a = blade->tip == EM_TIP_NONE ? blade->radius + radius : blade->radius;
  s.rim = sqrt(blade->reach * blade->reach + a * a);
  s.bound = s.rim + radius;
  s.tolerance = 8.0 * DBL_EPSILON * (s.bound + fabs(s.pu) + fabs(s.pw) + fabs(s.py));
  return s;
}

/* Does the ball stay beside the blade, along the rotor's axis, by more than the tolerance up to the
 * horizon? A lower bound of its distance from the blade's slice is concave in time, so its ends
 * decide. */
static bool is_aside(const struct em_blade *blade, struct em_vec r, struct em_vec v,
                     struct em_vec g, double radius, double tolerance, double horizon) {
  const double y = em_vec_dot(em_vec_sub(r, blade->centre), blade->axis);
  const double vy = em_vec_dot(v, blade->axis), gy = em_vec_dot(g, blade->axis);
  const double off = fabs(y) - (blade->radius + radius);
  const double way = ((y < 0.0 ? -vy : vy) - 0.5 * fabs(gy) * horizon) * horizon;
  const double clear = 1e-9 * radius + tolerance;
  return off > clear && off + way > clear;
}

static void set_motion(struct search *s, const struct em_blade *blade, struct em_vec v,
                       struct em_vec g) {
  const struct em_vec e2 = em_vec_cross(blade->axis, blade->e1);
  s->vu = em_vec_dot(v, blade->e1);
  s->vw = em_vec_dot(v, e2);
  s->vy = em_vec_dot(v, blade->axis);
  s->gu = em_vec_dot(g, blade->e1);
  s->gw = em_vec_dot(g, e2);
  s->gy = em_vec_dot(g, blade->axis);
  s->fall = em_vec_norm(g);
}

double em_surface_blade_within(const struct em_blade *blade, struct em_vec r, struct em_vec v,
                               struct em_vec g, double radius, double angle, bool touched,
                               double horizon, double tolerance, unsigned *steps) {
  if (is_aside(blade, r, v, g, radius, tolerance, horizon)) return INFINITY;
  struct search s = prepare(blade, r, radius, angle);
  s.tolerance = em_greater(s.tolerance, tolerance);
  set_motion(&s, blade, v, g);
  unsigned count = 0;
  const double t = first_contact(&s, touched, horizon, &count);
  if (steps != NULL) *steps += count;
  return t;
}

double em_surface_blade(const struct em_blade *blade, struct em_vec r, struct em_vec v,
                        struct em_vec g, double radius, double angle, bool touched, double horizon,
                        unsigned *steps) {
  return em_surface_blade_within(blade, r, v, g, radius, angle, touched, horizon, 0.0, steps);
}

/* (8-13): distance of the ball from the bar without ends. */
static struct gap endless(const struct search *s, double t, double *x) {
  const struct place p = place_at(s, t);
  const struct turned q = turn(s, &p, t);
  *x = q.x;
  return (struct gap){q.rho - (s->a + s->radius), q.drho};
}

/* (8-14): when the ball is within the bar's slice, on a straight path along the axis. */
static void slice_times(const struct search *s, double horizon, double *from, double *to) {
  const double wide = s->a + s->radius;
  *from = 0.0;
  *to = horizon;
  if (s->gy != 0.0) return;
  if (s->vy == 0.0) {
    if (fabs(s->py) > wide) *to = -1.0;
    return;
  }
  const double t1 = (-wide - s->py) / s->vy, t2 = (wide - s->py) / s->vy;
  *from = em_greater(*from, em_lesser(t1, t2));
  *to = em_lesser(*to, em_greater(t1, t2));
}

double em_surface_blade_steps(const struct em_blade *blade, struct em_vec r, struct em_vec v,
                              struct em_vec g, double radius, double angle, double horizon,
                              double step, unsigned *steps) {
  struct search s = prepare(blade, r, radius, angle);
  set_motion(&s, blade, v, g);
  const struct place start = place_at(&s, 0.0);
  double from, to, x;
  slice_times(&s, gone(&s, &start), &from, &to);
  const double least = step * 2.0 * radius / (em_vec_norm(v) + fabs(s.omega) * s.reach);
  if (!(from <= to) || !(least > 0.0) || !(em_lesser(to, horizon) < INFINITY)) return INFINITY;
  struct gap f = endless(&s, from, &x);
  double t = from, dt = least;
  unsigned count = 1;
  while (t < to && t <= horizon) {
    const double next = em_lesser(t + dt, to);
    const struct gap g1 = endless(&s, next, &x);
    count++;
    /* Out of the bar: it was inside by a fault of its place, and is let go. */
    if (f.value < 0.0 && g1.value >= 0.0) break;
    if (f.value >= 0.0 && g1.value < 0.0) {
      double root = 0.5 * (t + next);
      for (int k = 0; k < 3; k++) {
        const struct gap h = endless(&s, root, &x);
        count++;
        if (h.rate != 0.0) root -= h.value / h.rate;
      }
      (void)endless(&s, root, &x);
      if (steps != NULL) *steps += count;
      return root > 0.0 && root <= horizon && x <= s.reach ? root : INFINITY;
    }
    dt = g1.value > f.value ? em_lesser(2.0 * dt, 8.0 * least) : em_greater(0.5 * dt, least);
    t = next;
    f = g1;
    if (next >= to) break;
  }
  if (steps != NULL) *steps += count;
  return INFINITY;
}

double em_surface_blade_gap(const struct em_blade *blade, struct em_vec r, double radius,
                            double angle) {
  const struct search s = prepare(blade, r, radius, angle);
  const struct place p = place_at(&s, 0.0);
  const struct turned q = turn(&s, &p, 0.0);
  return distance(&s, &q).value;
}

struct em_vec em_surface_blade_normal(const struct em_blade *blade, struct em_vec r, double angle) {
  const struct em_vec e2 = em_vec_cross(blade->axis, blade->e1);
  const struct em_vec d = em_vec_sub(r, blade->centre);
  double sine, cosine;
  sincos(angle, &sine, &cosine);
  const struct em_vec bar = em_vec_axpy(em_vec_scale(cosine, blade->e1), sine, e2);
  const double x = em_vec_dot(d, bar);
  const struct em_vec across = em_vec_axpy(d, -x, bar);
  const double rho = em_vec_norm(across), sign = x < 0.0 ? -1.0 : 1.0;
  const bool round = blade->tip == EM_TIP_HEMISPHERE;
  double end = INFINITY;
  if (round) end = blade->reach > blade->radius ? blade->reach - blade->radius : 0.0;
  if (blade->tip == EM_TIP_FLAT) end = blade->reach;
  const double ax = fabs(x) - end, ar = round ? rho : rho - blade->radius;
  struct em_vec n;
  if (ax <= 0.0 && (round || ar > ax))
    n = across;
  else if (ar <= 0.0)
    n = em_vec_scale(sign, bar);
  else
    n = em_vec_axpy(round ? across : em_vec_scale(ar / rho, across), sign * ax, bar);
  const double length = em_vec_norm(n);
  return length > 0.0 ? em_vec_scale(1.0 / length, n) : blade->axis;
}

struct em_vec em_surface_blade_velocity(const struct em_blade *blade, struct em_vec x) {
  return em_vec_scale(blade->omega, em_vec_cross(blade->axis, em_vec_sub(x, blade->centre)));
}
