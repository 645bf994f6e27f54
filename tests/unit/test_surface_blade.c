/* First contacts with turning blades against brute force with a certified bound: no contact missed,
 * none invented. */
#include <float.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

#include "eventmill/surface.h"

/* test_long_surface_blade.c has more of them. */
#ifndef CASES
#define CASES 12000
#endif

/* Brute force walks on by at least what the gap can change by so much (m). */
#define GRAIN 1e-12L

/* The walk of brute force ends after so many steps, and the case is not counted. */
enum { PATIENCE = 200000 };

typedef long double real;

struct flight {
  struct em_blade blade;
  struct em_vec r, v, g;
  double radius, angle, horizon;
  bool touched;
};

static double uniform(double low, double high) {
  return low + (high - low) * drand48();
}

static double spread(double low, double high) {
  return low * pow(high / low, drand48());
}

static double sign(void) {
  return drand48() < 0.5 ? -1.0 : 1.0;
}

static struct em_vec direction(void) {
  for (;;) {
    const struct em_vec a = {uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)};
    const double n = em_vec_norm(a);
    if (n > 0.1 && n < 1.0) return em_vec_scale(1.0 / n, a);
  }
}

static struct em_vec across(struct em_vec axis) {
  const struct em_vec a = em_vec_cross(axis, direction());
  const double n = em_vec_norm(a);
  return n > 0.1 ? em_vec_scale(1.0 / n, a) : across(axis);
}

/* ---------------------------------------------------------------- brute force */
struct look {
  real gap, along; /* m: surface to surface; the ball's centre along the bar */
  real rate;       /* m/s, of the gap */
  real r, speed;   /* m from the blade's centre; m/s */
  real sure;       /* s, within which the ball stays away from all that the blade sweeps */
};

/* For how long h − closing t − ½ fall t² stays positive. */
static real stays(real h, real closing, real fall) {
  if (!(h > 0)) return 0;
  const real root = sqrtl(closing * closing + 2 * fall * h);
  if (closing > 0) return 2 * h / (root + closing);
  return fall > 0 ? (root - closing) / fall : INFINITY;
}

/* At any angle the blade is within a slice across its axis, and within a sphere; where an open bar
 * counts, so is the ball's centre. Its distance from a plane, and from a sphere, is at least what
 * the tangent at its place says: d̂·(d + s) with d̂·s ≥ −closing t − ½ fall t². */
static real aloof(const struct flight *f, const real d[3], const real v[3]) {
  const struct em_blade *b = &f->blade;
  const real n[3] = {b->axis.x, b->axis.y, b->axis.z}, fall = em_vec_norm(f->g);
  const bool open = b->tip == EM_TIP_NONE;
  const real wide = (real)b->radius + f->radius, a = open ? wide : (real)b->radius;
  const real rim = hypotl(b->reach, a) + (open ? 0 : (real)f->radius);
  real y = 0, vy = 0, r2 = 0, dv = 0;
  for (int k = 0; k < 3; k++) {
    y += d[k] * n[k];
    vy += v[k] * n[k];
    r2 += d[k] * d[k];
    dv += d[k] * v[k];
  }
  const real r = sqrtl(r2);
  const real beside = stays(fabsl(y) - wide - 1e-15L, y < 0 ? vy : -vy, fall);
  return fmaxl(beside, stays(r - rim - 1e-15L, r > 0 ? -dv / r : 0, fall));
}

/* In the frame of the scene, by vectors, in long double. */
static struct look look(const struct flight *f, real t) {
  const struct em_blade *b = &f->blade;
  const real r[3] = {f->r.x, f->r.y, f->r.z}, v[3] = {f->v.x, f->v.y, f->v.z};
  const real g[3] = {f->g.x, f->g.y, f->g.z}, c[3] = {b->centre.x, b->centre.y, b->centre.z};
  const real n[3] = {b->axis.x, b->axis.y, b->axis.z}, e[3] = {b->e1.x, b->e1.y, b->e1.z};
  const real alpha = (real)f->angle + (real)b->omega * t, co = cosl(alpha), si = sinl(alpha);
  const real e2[3] = {n[1] * e[2] - n[2] * e[1], n[2] * e[0] - n[0] * e[2],
                      n[0] * e[1] - n[1] * e[0]};
  real d[3], vt[3], bar[3], along = 0, r2 = 0, v2 = 0, rho2 = 0;
  for (int k = 0; k < 3; k++) {
    d[k] = r[k] - c[k] + t * (v[k] + 0.5L * t * g[k]);
    vt[k] = v[k] + t * g[k];
    bar[k] = co * e[k] + si * e2[k];
    along += d[k] * bar[k];
    r2 += d[k] * d[k];
    v2 += vt[k] * vt[k];
  }
  for (int k = 0; k < 3; k++)
    rho2 += (d[k] - along * bar[k]) * (d[k] - along * bar[k]);
  const real rho = sqrtl(rho2), x = fabsl(along);
  const bool round = b->tip == EM_TIP_HEMISPHERE;
  const real end = b->tip == EM_TIP_NONE ? INFINITY
                   : round               ? fmax(b->reach - b->radius, 0.0)
                                         : b->reach;
  const real thick = round ? 0 : b->radius, dx = fmaxl(x - end, 0), dr = fmaxl(rho - thick, 0);
  real gap = hypotl(dx, dr), nx = dx / gap, nr = dr / gap;
  if (!(gap > 0)) { /* the centre is inside the bar */
    nr = rho - thick > x - end;
    nx = 1 - nr;
    gap = fmaxl(x - end, rho - thick);
  }
  real rate = 0;
  for (int k = 0; k < 3; k++) {
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    const real turn = b->omega * (n[i] * d[j] - n[j] * d[i]);
    const real normal =
        nx * (along < 0 ? -bar[k] : bar[k]) + (rho > 0 ? nr * (d[k] - along * bar[k]) / rho : 0);
    rate += normal * (vt[k] - turn);
  }
  if (round) gap -= b->radius;
  return (struct look){gap - f->radius, along, rate, sqrtl(r2), sqrtl(v2), aloof(f, d, vt)};
}

/* A time within which a gap of this size cannot close: it changes by no more than the ball's speed
 * plus |ω| times the ball's distance from the blade's centre. And, the blade being convex, the
 * second derivative of the gap is no less than −(|g| + 2 |ω| V + ω² r), here taken fourfold. */
static real certain(const struct flight *f, const struct look *at, real gap) {
  const real omega = fabsl((real)f->blade.omega), fall = em_vec_norm(f->g);
  const real first = gap / (at->speed + omega * at->r + 1e-30L);
  const real speed = at->speed + fall * first;
  const real step = gap / (speed + omega * (at->r + speed * first) + 1e-30L);
  if (at->gap < 0) return step;
  const real bend = 4 * (fall + 2 * omega * at->speed + omega * omega * at->r);
  const real root = sqrtl(at->rate * at->rate + 2 * bend * gap);
  const real second = at->rate < 0 ? 2 * gap / (root - at->rate) : (root + at->rate) / bend;
  const bool small = fall * second < at->speed + omega * at->r && omega * second < 0.1L;
  return small ? fmaxl(step, second) : step;
}

/* The first crossing from + to − after `from`; INFINITY when there is none before the horizon, NAN
 * when patience ends or the end of the bar leaves it open whether a crossing counts. */
static real brute(const struct flight *f, real from) {
  real t = from;
  struct look at = look(f, t);
  bool inside = at.gap < 0;
  for (int step = 0; step < PATIENCE; step++) {
    if (t > f->horizon) return INFINITY;
    if (!inside && at.gap < 0) { /* by less than the grain */
      if (f->blade.tip != EM_TIP_NONE) return t;
      const real over = fabsl(at.along) - f->blade.reach;
      if (fabsl(over) < 1e-9L) return NAN;
      if (over < 0) return t;
    }
    inside = at.gap < 0;
    t += fmaxl(at.sure, certain(f, &at, fmaxl(fabsl(at.gap), GRAIN)));
    at = look(f, t);
  }
  return NAN;
}

/* ---------------------------------------------------------------- the comparison */
struct tally {
  long cases, hits, grazes, open, steps, most;
  double worst; /* m, gap at a contact */
};

static double search(const struct flight *f, double horizon, unsigned *steps) {
  return em_surface_blade(&f->blade, f->r, f->v, f->g, f->radius, f->angle, f->touched, horizon,
                          steps);
}

static void same_bits(const struct flight *f, double t) {
  for (int k = 0; k < 3; k++) {
    double horizon = f->horizon * drand48();
    if (t < INFINITY) horizon = k == 0 ? t : k == 1 ? nextafter(t, -1.0) : t * uniform(0.0, 2.0);
    const double cut = search(f, horizon, NULL);
    assert_true(cut == (horizon >= t ? t : INFINITY));
  }
}

static void compare(const struct flight *f, real from, struct tally *tally) {
  unsigned steps = 0;
  const double t = search(f, f->horizon, &steps);
  assert_true(t >= 0.0 && (t <= f->horizon || t == INFINITY));
  tally->cases++;
  tally->steps += steps;
  tally->most = steps > tally->most ? (long)steps : tally->most;
  same_bits(f, t);
  const real truth = brute(f, from);
  if (truth != truth) {
    tally->open++;
    return;
  }
  if (t < INFINITY) {
    const struct look at = look(f, t);
    const double size = (double)at.r + f->blade.reach + f->radius + em_vec_norm(f->r);
    const double turned = fabs(f->angle) + fabs(f->blade.omega) * t;
    /* Not invented: the surfaces touch, up to the rounding of place and angle. */
    const double slack = DBL_EPSILON * (64.0 * size + 4.0 * turned * (double)at.r);
    assert_true(fabsl(at.gap) <= slack);
    assert_true(at.rate <= 1e-6L * (at.speed + 1));
    if (f->blade.tip == EM_TIP_NONE) assert_true(fabsl(at.along) < f->blade.reach + 1e-9L);
    tally->worst = fmax(tally->worst, fabs((double)at.gap));
    tally->hits++;
  }
  /* Not missed: nothing is deeper than brute force can see before the contact. */
  if (truth < t) {
    const real end = t < INFINITY ? t : truth;
    for (int k = 0; k <= 32; k++)
      assert_true(look(f, truth + (end - truth) * k / 32).gap >= -(t < INFINITY ? 3e-12L : 1e-14L));
    tally->grazes += t == INFINITY;
  } else if (t < INFINITY && truth == INFINITY) {
    tally->grazes++;
  }
}

static void report(const char *what, const struct tally *t) {
  printf("  %-30s %7ld cases, %6ld hits, %4ld grazing, %4ld open, %.1f (%ld) steps, gap %.1e m\n",
         what, t->cases, t->hits, t->grazes, t->open, (double)t->steps / (double)t->cases, t->most,
         t->worst);
}

/* ---------------------------------------------------------------- flights */
static struct flight machine(int n, double omega) {
  struct flight f = {.blade = {.omega = omega, .tip = (enum em_tip)(n % EM_TIP_COUNT)},
                     .angle = uniform(-10, 10),
                     .radius = 0.0025,
                     .horizon = 0.03};
  f.blade.radius = n % 2 ? 0.006 : spread(0.001, 0.02);
  f.blade.reach = f.blade.radius * spread(1.0, 20.0);
  f.blade.axis = n % 3 ? em_vec_make(0, 1, 0) : direction();
  f.blade.e1 = n % 3 ? em_vec_make(0, 0, 1) : across(f.blade.axis);
  f.blade.centre = em_vec_make(uniform(-0.1, 0.1), uniform(0, 0.2), uniform(-0.1, 0.1));
  f.g = n % 5 ? em_vec_scale(9.81, direction()) : em_vec_make(0, 0, 0);
  return f;
}

/* The ball at `out` from the axis and `up` along it. */
static void put(struct flight *f, double out, double up) {
  const struct em_vec side = across(f->blade.axis);
  f->r = em_vec_axpy(em_vec_axpy(f->blade.centre, up, f->blade.axis), out, side);
}

static bool overlaps(const struct flight *f) {
  return em_surface_blade_gap(&f->blade, f->r, f->radius, f->angle) < 1e-9;
}

static void run(const char *what, int cases, struct flight (*make)(int n)) {
  struct tally tally = {0};
  for (int n = 0; n < cases; n++) {
    const struct flight f = make(n);
    if (f.blade.tip != EM_TIP_NONE && overlaps(&f)) continue;
    compare(&f, 0, &tally);
  }
  report(what, &tally);
  assert_true(tally.hits > 0 && tally.open * 100 <= tally.cases);
}

static struct flight in_a_mill(int n) {
  struct flight f = machine(n, sign() * spread(1.0, 1000.0));
  put(&f, f.blade.reach * 1.3 * sqrt(drand48()), uniform(-3, 3) * f.blade.radius);
  f.v = em_vec_scale(spread(0.01, 10.0), direction());
  return f;
}

static struct flight very_fast(int n) {
  struct flight f = machine(n, sign() * spread(1e3, 1e6));
  put(&f, f.blade.reach * uniform(0.9, 1.5), uniform(-3, 3) * f.blade.radius);
  f.v = em_vec_scale(spread(0.1, 10.0), direction());
  f.horizon = fmin(0.01, 300.0 / fabs(f.blade.omega));
  return f;
}

static struct flight at_rest(int n) {
  struct flight f = machine(n, n % 2 ? 0.0 : sign() * spread(1e-12, 1e-2));
  put(&f, f.blade.reach * uniform(0.0, 1.5), uniform(-3, 3) * f.blade.radius);
  f.v = em_vec_scale(spread(0.01, 10.0), direction());
  return f;
}

/* Slow balls that see many turns go by, most of them outside what the blade sweeps. */
static struct flight many_turns(int n) {
  struct flight f = machine(n, sign() * spread(100.0, 3000.0));
  put(&f, f.blade.reach * uniform(0.8, 1.3),
      sign() * uniform(0.8, 1.3) * (f.blade.radius + f.radius));
  f.v = em_vec_scale(spread(1e-9, 1e-2), direction());
  if (n % 2) f.g = em_vec_make(0, 0, 0);
  f.horizon = 60.0 / fabs(f.blade.omega);
  return f;
}

/* Just ahead of the blade, at almost its speed. */
static struct flight overtaken(int n) {
  struct flight f = machine(n, sign() * spread(1.0, 1000.0));
  const double out = f.blade.reach * drand48(), ahead = spread(1e-6, 1e-3);
  const struct em_vec e2 = em_vec_cross(f.blade.axis, f.blade.e1);
  f.angle = 0.0;
  const double way = f.blade.radius + f.radius + ahead;
  f.r = em_vec_axpy(em_vec_axpy(f.blade.centre, out, f.blade.e1), f.blade.omega > 0.0 ? way : -way,
                    e2);
  f.v = em_vec_scale(1.0 + sign() * spread(1e-9, 1e-1), em_surface_blade_velocity(&f.blade, f.r));
  return f;
}

/* Along the bar, close to it. */
static struct flight along(int n) {
  struct flight f = machine(n, sign() * spread(0.01, 300.0));
  const struct em_vec e2 = em_vec_cross(f.blade.axis, f.blade.e1);
  const double phi = uniform(0, 6.3), way = f.blade.radius + f.radius + spread(1e-6, 1e-3);
  f.angle = 0.0;
  f.r = em_vec_axpy(f.blade.centre, uniform(-1, 1) * f.blade.reach, f.blade.e1);
  f.r = em_vec_axpy(f.r, way * cos(phi), f.blade.axis);
  f.r = em_vec_axpy(f.r, way * sin(phi), e2);
  f.v = em_vec_scale(sign() * spread(0.1, 10.0), f.blade.e1);
  return f;
}

/* At the tip and its rim, from outside. */
static struct flight tip(int n) {
  struct flight f = machine(n, sign() * spread(1.0, 300.0));
  put(&f, f.blade.reach + f.radius + spread(1e-5, 1e-2), uniform(-1.5, 1.5) * f.blade.radius);
  const struct em_vec in = em_vec_sub(f.blade.centre, f.r);
  f.v = em_vec_axpy(em_vec_scale(spread(0.1, 10.0) / em_vec_norm(in), in), 0.3, direction());
  return f;
}

/* Near the axis, and through it. */
static struct flight near_axis(int n) {
  struct flight f = machine(n, sign() * spread(1.0, 1000.0));
  put(&f, spread(1e-12, 1e-2), sign() * (f.blade.radius + f.radius + spread(1e-6, 1e-2)));
  f.v = em_vec_axpy(em_vec_scale(spread(1e-3, 1.0), direction()), -20.0,
                    em_vec_sub(f.r, f.blade.centre));
  return f;
}

/* Into the bar without an end, at its reach or a hair beyond. */
static struct flight at_the_reach(int n) {
  struct flight f = machine(3 * n + EM_TIP_NONE, sign() * spread(1.0, 300.0));
  const struct em_vec e2 = em_vec_cross(f.blade.axis, f.blade.e1);
  const double phi = uniform(0, 6.3), way = f.blade.radius + f.radius, before = spread(1e-6, 1e-4);
  const struct em_vec e = em_vec_axpy(em_vec_scale(cos(phi), f.blade.axis), sin(phi), e2);
  f.r = em_vec_axpy(f.blade.centre, f.blade.reach + sign() * spread(1e-8, 1e-5), f.blade.e1);
  f.r = em_vec_axpy(f.r, way, e);
  f.v = em_vec_axpy(em_surface_blade_velocity(&f.blade, f.r), -spread(0.1, 10.0), e);
  f.v = em_vec_axpy(f.v, uniform(-1, 1), f.blade.e1);
  f.r = em_vec_axpy(em_vec_axpy(f.r, -before, f.v), 0.5 * before * before, f.g);
  f.v = em_vec_axpy(f.v, -before, f.g);
  f.angle = -f.blade.omega * before;
  return f;
}

static void mill(void **state) {
  (void)state;
  srand48(1);
  run("as in a mill", 4 * CASES, in_a_mill);
}

static void turns(void **state) {
  (void)state;
  srand48(2);
  run("up to 1e6 rad/s", CASES / 2, very_fast);
  run("many turns", CASES / 10, many_turns);
  run("not turning", CASES, at_rest);
}

static void special(void **state) {
  (void)state;
  srand48(3);
  run("overtaken", CASES / 4, overtaken);
  run("along the bar", CASES / 4, along);
  run("at the tip", CASES, tip);
  run("near the axis", CASES / 2, near_axis);
  run("at the reach, without tip", CASES / 4, at_the_reach);
}

/* ---------------------------------------------------------------- contacts as starts */
/* Acceleration relative to the blade is below this. */
static double bend(const struct flight *f) {
  const double omega = fabs(f->blade.omega), far = em_vec_norm(em_vec_sub(f->r, f->blade.centre));
  return 4.0 * (em_vec_norm(f->g) + 2.0 * omega * em_vec_norm(f->v) + omega * omega * far);
}

/* A ball at a random place of the blade's surface, `gap` from it; *normal points to it. */
static struct flight at_contact(int n, double gap, struct em_vec *normal) {
  for (;;) {
    struct flight f = machine(n, n % 7 ? sign() * spread(0.1, 1000.0) : 0.0);
    if (f.blade.tip == EM_TIP_NONE && n % 2) f.blade.tip = EM_TIP_FLAT;
    put(&f, f.blade.reach * 1.2 * drand48(), uniform(-1.2, 1.2) * f.blade.radius);
    for (int k = 0; k < 50; k++) {
      const double d = em_surface_blade_gap(&f.blade, f.r, f.radius, f.angle);
      *normal = em_surface_blade_normal(&f.blade, f.r, f.angle);
      f.r = em_vec_axpy(f.r, gap - d, *normal);
    }
    const double d = em_surface_blade_gap(&f.blade, f.r, f.radius, f.angle);
    if (fabs(d - gap) < 1e-16) return f;
  }
}

/* The ball has just hit the blade and parts. */
static void touched(void **state) {
  (void)state;
  srand48(4);
  struct tally tally = {0};
  for (int n = 0; n < CASES / 2; n++) {
    struct em_vec e;
    struct flight f = at_contact(n, 0.0, &e);
    const double parting = spread(1e-4, 10.0);
    const struct em_vec slide = em_vec_scale(spread(1e-3, 5.0), em_vec_cross(e, direction()));
    f.touched = true;
    f.v = em_vec_axpy(em_vec_add(em_surface_blade_velocity(&f.blade, f.r), slide), parting, e);
    compare(&f, parting / bend(&f), &tally);
    f.v = em_vec_axpy(f.v, -1.1 * parting, e); /* approaching: at once */
    const double t = search(&f, INFINITY, NULL);
    const bool dropped = f.blade.tip == EM_TIP_NONE;
    assert_true(t == 0.0 || dropped);
  }
  report("touched", &tally);
}

/* Overlapping by rounding: approaching is now, parting is no contact. */
static void overlapping(void **state) {
  (void)state;
  srand48(5);
  struct tally tally = {0};
  for (int n = 0; n < CASES / 2; n++) {
    struct em_vec e;
    struct flight f = at_contact(n, sign() * spread(1e-18, 1e-13), &e);
    const double way = em_surface_blade_gap(&f.blade, f.r, f.radius, f.angle);
    const double parting = spread(1e-3, 10.0);
    const struct em_vec slide = em_vec_scale(spread(1e-3, 5.0), em_vec_cross(e, direction()));
    f.v = em_vec_axpy(em_vec_add(em_surface_blade_velocity(&f.blade, f.r), slide), parting, e);
    compare(&f, parting / bend(&f), &tally);
    f.v = em_vec_axpy(f.v, -2.0 * parting, e);
    const double t = search(&f, INFINITY, NULL);
    if (f.blade.tip != EM_TIP_NONE)
      assert_true(way <= 0.0 ? t == 0.0 : t < (1.1 * way + 1e-16) / parting);
  }
  report("overlapping by rounding", &tally);
}

/* A path that touches the surface up to 1e-16 … 1e-12 of the radius. */
static struct flight grazes(int n) {
  struct em_vec e;
  struct flight f = at_contact(n, 0.0, &e);
  const double before = spread(1e-4, 1e-2), miss = sign() * spread(1e-16, 1e-12) * f.radius;
  const struct em_vec slide = em_vec_scale(spread(1e-2, 5.0), em_vec_cross(e, direction()));
  f.v = em_vec_add(em_surface_blade_velocity(&f.blade, f.r), slide);
  f.r = em_vec_axpy(f.r, miss, e);
  f.r = em_vec_axpy(em_vec_axpy(f.r, -before, f.v), 0.5 * before * before, f.g);
  f.v = em_vec_axpy(f.v, -before, f.g);
  f.angle -= f.blade.omega * before;
  return f;
}

static void grazing(void **state) {
  (void)state;
  srand48(6);
  struct tally tally = {0};
  for (int n = 0; n < CASES / 4; n++) {
    const struct flight f = grazes(n);
    if (f.blade.tip != EM_TIP_NONE && !overlaps(&f)) compare(&f, 0, &tally);
  }
  report("grazing", &tally);
}

/* ---------------------------------------------------------------- geometry */
/* Angle 0 points along e1; a positive speed about +y turns +z towards +x. */
static void convention(void **state) {
  (void)state;
  const struct em_blade b = {.axis = {0, 1, 0},
                             .e1 = {0, 0, 1},
                             .omega = 100.0,
                             .radius = 0.006,
                             .reach = 0.058,
                             .tip = EM_TIP_FLAT};
  const double up = em_surface_blade_gap(&b, em_vec_make(0, 0, 0.07), 0.0025, 0.0);
  assert_true(fabs(up - 0.0095) < 1e-15);
  const double right = em_surface_blade_gap(&b, em_vec_make(0.07, 0, 0), 0.0025, M_PI_2);
  assert_true(fabs(right - 0.0095) < 1e-15);
  const struct em_vec v = em_surface_blade_velocity(&b, em_vec_make(0, 0, 0.05));
  assert_true(fabs(v.x - 5.0) < 1e-14 && v.y == 0.0 && fabs(v.z) < 1e-14);
  /* A ball at rest right of the upright bar is hit by it after the angle asin(w/r). */
  const struct em_vec r = {0.05, 0, 0}, still = {0, 0, 0};
  const double t = em_surface_blade(&b, r, still, still, 0.0025, 0.0, false, INFINITY, NULL);
  assert_true(fabs(t - (M_PI_2 - asin(0.0085 / 0.05)) / 100.0) < 1e-15);
  const struct em_vec e = em_surface_blade_normal(&b, r, 100.0 * t);
  assert_true(e.x > 0.0 && e.z < -0.9 && fabs(em_vec_norm(e) - 1.0) < 1e-15);
}

/* The normal is the gradient of the gap. */
static void normals(void **state) {
  (void)state;
  srand48(7);
  for (int n = 0; n < CASES; n++) {
    struct em_vec e;
    const struct flight f = at_contact(n, 0.0, &e);
    const struct em_vec side = direction();
    const double h = 1e-7;
    const double up = em_surface_blade_gap(&f.blade, em_vec_axpy(f.r, h, side), f.radius, f.angle);
    const double down =
        em_surface_blade_gap(&f.blade, em_vec_axpy(f.r, -h, side), f.radius, f.angle);
    assert_true(fabs((up - down) / (2.0 * h) - em_vec_dot(e, side)) < 1e-4);
  }
}

/* Balls that no blade will ever meet, without a horizon: the search ends. */
static void ends(void **state) {
  (void)state;
  const struct em_vec none = {0, 0, 0};
  struct em_blade b = {.axis = {0, 1, 0},
                       .e1 = {0, 0, 1},
                       .omega = 100.0,
                       .radius = 0.006,
                       .reach = 0.058,
                       .tip = EM_TIP_FLAT};
  for (int k = 0; k < EM_TIP_COUNT; k++) {
    b.tip = (enum em_tip)k;
    const double rim = k == EM_TIP_FLAT   ? hypot(0.058, 0.006) + 0.0025
                       : k == EM_TIP_NONE ? hypot(0.058, 0.0085)
                                          : 0.0605;
    for (int ulp = -3; ulp <= 3; ulp++) {
      struct em_vec r = {rim * (1.0 + ulp * DBL_EPSILON), 0, 0};
      const double t = em_surface_blade(&b, r, none, none, 0.0025, 0.3, false, INFINITY, NULL);
      assert_true(t == INFINITY || t < M_PI / 100.0);
      r.y = 0.0085;
      em_surface_blade(&b, r, none, none, 0.0025, 0.3, false, INFINITY, NULL);
      em_surface_blade(&b, r, em_vec_make(0, 1e-18, 0), none, 0.0025, 0.3, false, INFINITY, NULL);
    }
    const struct em_vec far = {0.2, 0.05, 0.1}, fall = {0, 0, -9.81}, v = {1, 2, 3};
    assert_true(em_surface_blade(&b, far, none, none, 0.0025, 0, false, INFINITY, NULL) ==
                INFINITY);
    assert_true(em_surface_blade(&b, far, v, fall, 0.0025, 0, false, INFINITY, NULL) == INFINITY);
    /* In the middle of the bar without an end: never out, never in. */
    if (k == EM_TIP_NONE)
      assert_true(em_surface_blade(&b, none, none, none, 0.0025, 0, false, INFINITY, NULL) ==
                  INFINITY);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(convention), cmocka_unit_test(normals),     cmocka_unit_test(ends),
      cmocka_unit_test(mill),       cmocka_unit_test(turns),       cmocka_unit_test(special),
      cmocka_unit_test(touched),    cmocka_unit_test(overlapping), cmocka_unit_test(grazing),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
