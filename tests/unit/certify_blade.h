/* Certificates for blades: the distance to 60 digits (MPFR), and a walk in 64 bits that shows that
 * no contact is earlier. */
#ifndef EVENTMILL_TESTS_CERTIFY_BLADE_H
#define EVENTMILL_TESTS_CERTIFY_BLADE_H

#include "certify.h"
#include "eventmill/surface.h"

struct certify_bar {
  struct em_blade blade;
  struct em_vec r, v, g;
  double radius, angle;
  bool touched;
  mpfr_t frame[3][3], p[3][3]; /* e1, axis × e1, axis; along these: place, velocity, g / 2 */
  mpfr_t c[6];
};

static inline void certify_bar_init(struct certify_bar *b) {
  for (int k = 0; k < 3; k++)
    for (int j = 0; j < 3; j++)
      mpfr_inits2(CERTIFY_BITS, b->frame[k][j], b->p[k][j], (mpfr_ptr)0);
  for (int k = 0; k < 6; k++)
    mpfr_init2(b->c[k], CERTIFY_BITS);
}

static inline void certify_bar_clear(struct certify_bar *b) {
  for (int k = 0; k < 3; k++)
    for (int j = 0; j < 3; j++)
      mpfr_clears(b->frame[k][j], b->p[k][j], (mpfr_ptr)0);
  for (int k = 0; k < 6; k++)
    mpfr_clear(b->c[k]);
}

/* out += frame · a */
static inline void certify_dot(struct certify_bar *b, mpfr_t out, mpfr_t frame[3],
                               struct em_vec a) {
  const double x[3] = {a.x, a.y, a.z};
  for (int k = 0; k < 3; k++) {
    mpfr_mul_d(b->c[0], frame[k], x[k], MPFR_RNDN);
    mpfr_add(out, out, b->c[0], MPFR_RNDN);
  }
}

/* Once per flight: its state along the axes in which the blade turns. */
static inline void certify_bar_begin(struct certify_bar *b) {
  const struct em_vec n = b->blade.axis, e = b->blade.e1;
  const double axis[3] = {n.x, n.y, n.z}, e1[3] = {e.x, e.y, e.z};
  for (int k = 0; k < 3; k++) {
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    mpfr_set_d(b->frame[0][k], e1[k], MPFR_RNDN);
    mpfr_set_d(b->frame[2][k], axis[k], MPFR_RNDN);
    mpfr_set_d(b->c[0], axis[i], MPFR_RNDN);
    mpfr_mul_d(b->c[0], b->c[0], e1[j], MPFR_RNDN);
    mpfr_set_d(b->c[1], axis[j], MPFR_RNDN);
    mpfr_mul_d(b->c[1], b->c[1], e1[i], MPFR_RNDN);
    mpfr_sub(b->frame[1][k], b->c[0], b->c[1], MPFR_RNDN);
  }
  for (int k = 0; k < 3; k++) {
    for (int j = 0; j < 3; j++)
      mpfr_set_zero(b->p[k][j], 1);
    certify_dot(b, b->p[k][0], b->frame[k], b->r);
    certify_dot(b, b->p[k][0], b->frame[k], em_vec_scale(-1.0, b->blade.centre));
    certify_dot(b, b->p[k][1], b->frame[k], b->v);
    certify_dot(b, b->p[k][2], b->frame[k], em_vec_scale(0.5, b->g));
  }
}

/* The distance of the surfaces at time t; of the tip `none`, from the bar without ends. */
static inline double certify_bar_gap(struct certify_bar *b, double t) {
  mpfr_t *const c = b->c;
  for (int k = 0; k < 3; k++) { /* c[k] = place along the axes */
    mpfr_mul_d(c[k], b->p[k][2], t, MPFR_RNDN);
    mpfr_add(c[k], c[k], b->p[k][1], MPFR_RNDN);
    mpfr_mul_d(c[k], c[k], t, MPFR_RNDN);
    mpfr_add(c[k], c[k], b->p[k][0], MPFR_RNDN);
  }
  mpfr_set_d(c[3], t, MPFR_RNDN);
  mpfr_mul_d(c[3], c[3], b->blade.omega, MPFR_RNDN);
  mpfr_add_d(c[3], c[3], b->angle, MPFR_RNDN);
  mpfr_sin_cos(c[3], c[4], c[3], MPFR_RNDN);
  mpfr_fmma(c[5], c[0], c[4], c[1], c[3], MPFR_RNDN); /* x */
  mpfr_fmms(c[4], c[1], c[4], c[0], c[3], MPFR_RNDN); /* z */
  mpfr_hypot(c[4], c[4], c[2], MPFR_RNDN);            /* ρ */
  mpfr_abs(c[5], c[5], MPFR_RNDN);
  const bool round = b->blade.tip == EM_TIP_HEMISPHERE;
  mpfr_sub_d(c[5], c[5], b->blade.reach, MPFR_RNDN); /* beyond the end */
  mpfr_add_d(c[5], c[5], round ? b->blade.radius : 0.0, MPFR_RNDN);
  mpfr_sub_d(c[4], c[4], round ? 0.0 : b->blade.radius, MPFR_RNDN);
  const bool beside = mpfr_sgn(c[5]) <= 0 && (round || mpfr_cmp(c[4], c[5]) > 0);
  if (b->blade.tip != EM_TIP_NONE && !beside) {
    if (mpfr_sgn(c[4]) <= 0)
      mpfr_set(c[4], c[5], MPFR_RNDN);
    else
      mpfr_hypot(c[4], c[5], c[4], MPFR_RNDN);
  }
  mpfr_sub_d(c[4], c[4], b->radius, MPFR_RNDN);
  mpfr_sub_d(c[4], c[4], round ? b->blade.radius : 0.0, MPFR_RNDN);
  return mpfr_get_d(c[4], MPFR_RNDN);
}

/* ---------------------------------------------------------------- the walk */

/* In the frame that turns with the blade, in long double. */
struct certify_look {
  long double gap, rate;  /* m, m/s: to the body with which contacts are */
  long double rho, drho;  /* m, m/s: to the bar's axis */
  long double r, v, fall; /* m to the blade's centre; m/s; m/s² */
};

/* Of the tip `none`, contacts are where the centre enters a cylinder with ends, through its side.
 */
static inline struct certify_look certify_look(const struct certify_bar *b, long double t) {
  typedef long double real;
  const struct em_blade *s = &b->blade;
  const real n[3] = {s->axis.x, s->axis.y, s->axis.z}, e[3] = {s->e1.x, s->e1.y, s->e1.z};
  const real d0[3] = {(real)b->r.x - s->centre.x, (real)b->r.y - s->centre.y,
                      (real)b->r.z - s->centre.z};
  const real v0[3] = {b->v.x, b->v.y, b->v.z}, g[3] = {b->g.x, b->g.y, b->g.z};
  const real alpha = b->angle + (real)s->omega * t;
  const real co = cosl(alpha), si = sinl(alpha);
  real d[3], v[3], w[3], bar[3], x = 0, dx = 0;
  for (int k = 0; k < 3; k++) {
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    d[k] = d0[k] + t * (v0[k] + t * g[k] / 2);
    v[k] = v0[k] + t * g[k];
    bar[k] = co * e[k] + si * (n[i] * e[j] - n[j] * e[i]);
  }
  struct certify_look look = {.fall = sqrtl(g[0] * g[0] + g[1] * g[1] + g[2] * g[2])};
  for (int k = 0; k < 3; k++) { /* w: velocity against the blade */
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    w[k] = v[k] - s->omega * (n[i] * d[j] - n[j] * d[i]);
    x += d[k] * bar[k];
    dx += w[k] * bar[k];
    look.r += d[k] * d[k];
    look.v += v[k] * v[k];
  }
  for (int k = 0; k < 3; k++) {
    const real across = d[k] - x * bar[k];
    look.rho += across * across;
    look.drho += across * w[k];
  }
  look.r = sqrtl(look.r);
  look.v = sqrtl(look.v);
  look.rho = sqrtl(look.rho);
  if (look.rho > 0) look.drho /= look.rho;
  if (x < 0) x = -x, dx = -dx;
  const bool round = s->tip == EM_TIP_HEMISPHERE, none = s->tip == EM_TIP_NONE;
  const real thick = (none ? (real)b->radius : 0) + (round ? 0 : s->radius);
  const real out = x - s->reach + (round ? s->radius : 0), up = look.rho - thick;
  if (out <= 0 && (round || up > out)) {
    look.gap = up, look.rate = look.drho;
  } else if (up <= 0) {
    look.gap = out, look.rate = dx;
  } else {
    look.gap = sqrtl(out * out + up * up);
    look.rate = (out * dx + up * look.drho) / look.gap;
  }
  if (!none) look.gap -= (round ? (real)s->radius : 0) + b->radius;
  return look;
}

/* Over the next `time`: how fast the ball is at most against the blade, and how much its path bends
 * in the blade's frame: |g| + 2 |ω| v + ω² r. */
struct certify_bound {
  long double speed, bend;
};

static const long double CERTIFY_STEP = 1e-3L; /* s: bounds hold for that long */

static inline struct certify_bound certify_bound(const struct certify_bar *b,
                                                 const struct certify_look *at, long double time) {
  const long double omega = fabsl((long double)b->blade.omega);
  const long double v = at->v + at->fall * time, r = at->r + v * time;
  return (struct certify_bound){v + omega * r, at->fall + omega * (2 * v + omega * r)};
}

/* How long f + f' s − ½ bend s² stays positive. */
static inline long double certify_parabola(long double f, long double rate, long double bend) {
  const long double root = sqrtl(rate * rate + 2 * bend * f);
  return rate < 0 ? 2 * f / (root - rate) : (rate + root) / bend;
}

/* Is there no contact in (0, t)? t: a contact or the horizon. `doubt` is above the rounding of 64
 * bits. Distances are convex, of slope 1, so that f'' ≥ −bend; from the contact backwards too. */
static inline bool certify_walk(const struct certify_bar *b, double t, bool contact) {
  const long double doubt = 1e-17L, width = (long double)b->blade.radius + b->radius;
  const struct certify_look end = certify_look(b, t);
  long double at = 0;
  bool inside = false;
  for (int step = 0; step < 100000; step++) {
    const struct certify_look here = certify_look(b, at);
    const struct certify_bound most = certify_bound(b, &here, CERTIFY_STEP);
    const long double rest = t - at;
    if (contact && !inside && rest < CERTIFY_STEP && end.rate < 0 &&
        rest * most.bend < -1.9L * end.rate)
      return true;
    if (!contact && rest <= 0) return true;
    if (contact && rest <= 0) return false;
    long double way;
    if (inside) { /* of w² − ρ², whose second derivative is ≥ −2 (speed² + w bend) */
      const long double left = (width - here.rho) * (width + here.rho);
      way = left > doubt * width
                ? certify_parabola(left, -2 * here.rho * here.drho,
                                   2 * (most.speed * most.speed + width * most.bend))
                : 0;
      if (way < 1e-12L / most.speed) way = 1e-12L / most.speed; /* through the side, outwards */
      inside = here.rho <= width;
    } else if (b->touched && at == 0) {
      if (!(here.rate > 1e-3L)) return false;
      way = here.rate / most.bend;
    } else if (here.gap > 2 * doubt) {
      way = certify_parabola(here.gap - doubt, here.rate, most.bend);
    } else {
      if (b->blade.tip != EM_TIP_NONE || here.rho > width - 1e-12L) return false;
      inside = true; /* through an end */
      way = 0;
    }
    at += fminl(way, CERTIFY_STEP);
  }
  return false;
}

#endif
