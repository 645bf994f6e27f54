/* Contact times in more than double precision, a template: surface_roots.c includes it once per
 * type. REAL is the type, POLISH(name) makes the names. The arguments are taken as exact. */

/* Two Newton steps on the root of a double: a quarter of 113 bits, twice doubled. */
static REAL POLISH(root)(REAL x) {
  if (!(x > 0)) return 0;
  REAL s = (REAL)sqrt((double)x);
  if (!(s > 0)) return 0;
  s = (s + x / s) / 2;
  return (s + x / s) / 2;
}

/* Sine and cosine: the argument less multiples of π/2, and Taylor's series. */
static void POLISH(sincos)(REAL a, REAL *sine, REAL *cosine) {
  const REAL quarter =
      (REAL)1.5707963267948966 + (REAL)6.123233995736766e-17 - (REAL)1.4973849048591833e-33;
  const double n = nearbyint((double)a / 1.5707963267948966);
  const REAL x = a - (REAL)n * quarter, x2 = x * x;
  REAL s = x, c = 1, term_s = x, term_c = 1;
  for (int k = 1; k < 16; k++) {
    term_c = -term_c * x2 / ((2 * k - 1) * (2 * k));
    term_s = -term_s * x2 / ((2 * k) * (2 * k + 1));
    c += term_c;
    s += term_s;
  }
  const int turn = (int)fmod(n, 4.0) & 3;
  *sine = turn == 0 ? s : turn == 1 ? c : turn == 2 ? -s : -c;
  *cosine = turn == 0 ? c : turn == 1 ? -s : turn == 2 ? -c : s;
}

static REAL POLISH(size)(REAL x) {
  return x < 0 ? -x : x;
}

/* Newton from a root in double precision; where it does not settle nearby, that root stays. */
static double POLISH(newton)(double start, void *self,
                             void (*at)(void *self, REAL t, REAL *value, REAL *slope)) {
  REAL t = start;
  for (int step = 0; step < 40; step++) {
    REAL value, slope;
    at(self, t, &value, &slope);
    if (value == 0) return (double)t;
    if (slope == 0) return start;
    const REAL next = t - value / slope;
    const REAL moved = POLISH(size)(next - t);
    if (!(POLISH(size)(next - start) <= 1e-3 * (REAL)start)) return start;
    t = next;
    if (moved <= POLISH(size)(t) * (REAL)1e-19) return (double)t;
  }
  return start;
}

struct POLISH(poly) {
  REAL a[5];
  int degree;
};

static void POLISH(poly_at)(void *self, REAL t, REAL *value, REAL *slope) {
  const struct POLISH(poly) *q = self;
  *value = q->a[q->degree];
  *slope = 0;
  for (int k = q->degree - 1; k >= 0; k--) {
    *slope = *slope * t + *value;
    *value = *value * t + q->a[k];
  }
}

static double POLISH(plane)(double t, double gap, double rate, double fall, bool touched) {
  struct POLISH(poly) q = {{gap, rate, (REAL)fall / 2, 0, 0}, 2};
  if (touched) q = (struct POLISH(poly)){{rate, (REAL)fall / 2, 0, 0, 0}, 1};
  return POLISH(newton)(t, &q, POLISH(poly_at));
}

static double POLISH(drum)(double t, struct em_vec p, struct em_vec v, struct em_vec g, double rho,
                           bool touched) {
  const REAL px = p.x, pz = p.z, vx = v.x, vz = v.z, gx = g.x, gz = g.z, big = rho;
  struct POLISH(poly)
      q = {{px * px + pz * pz - big * big, 2 * (px * vx + pz * vz),
            vx * vx + vz * vz + px * gx + pz * gz, vx * gx + vz * gz, (gx * gx + gz * gz) / 4},
           4};
  if (touched) {
    for (int k = 0; k < 4; k++)
      q.a[k] = q.a[k + 1];
    q.degree = 3;
  }
  return POLISH(newton)(t, &q, POLISH(poly_at));
}

static REAL POLISH(dot)(const REAL *a, struct em_vec b) {
  return a[0] * b.x + a[1] * b.y + a[2] * b.z;
}

struct POLISH(bar) {
  REAL r[3], v[3], g[3]; /* along e1, axis × e1, the axis */
  REAL angle, omega, radius, a, reach;
  enum em_tip tip;
};

static void POLISH(bar_at)(void *self, REAL t, REAL *value, REAL *slope) {
  const struct POLISH(bar) *s = self;
  REAL p[3], dp[3], sine, cosine;
  for (int k = 0; k < 3; k++) {
    p[k] = s->r[k] + t * (s->v[k] + t * s->g[k] / 2);
    dp[k] = s->v[k] + t * s->g[k];
  }
  POLISH(sincos)(s->angle + s->omega * t, &sine, &cosine);
  REAL x = p[0] * cosine + p[1] * sine, z = p[1] * cosine - p[0] * sine;
  REAL dx = dp[0] * cosine + dp[1] * sine + s->omega * z;
  const REAL dz = dp[1] * cosine - dp[0] * sine - s->omega * x;
  if (x < 0) x = -x, dx = -dx;
  const REAL rho = POLISH(root)(p[2] * p[2] + z * z);
  const REAL drho = rho > 0 ? (p[2] * dp[2] + z * dz) / rho : 0;
  const bool round = s->tip == EM_TIP_HEMISPHERE, endless = s->tip == EM_TIP_NONE;
  const REAL end = round ? (s->reach > s->a ? s->reach - s->a : 0) : s->reach;
  const REAL ax = endless ? -1 : x - end, ar = round ? rho : rho - s->a;
  const REAL off = round ? s->a + s->radius : s->radius;
  if (ax <= 0 && (round || endless || ar > ax)) {
    *value = ar - off;
    *slope = drho;
  } else if (ar <= 0) {
    *value = ax - off;
    *slope = dx;
  } else {
    const REAL d = POLISH(root)(ax * ax + ar * ar);
    *value = d - off;
    *slope = (ax * dx + ar * drho) / d;
  }
}

static double POLISH(blade)(double t, const struct em_blade *blade, struct em_vec r,
                            struct em_vec v, struct em_vec g, double radius, double angle) {
  const struct em_vec a = blade->axis, e = blade->e1, c = blade->centre;
  const REAL frame[3][3] = {{e.x, e.y, e.z},
                            {(REAL)a.y * e.z - (REAL)a.z * e.y, (REAL)a.z * e.x - (REAL)a.x * e.z,
                             (REAL)a.x * e.y - (REAL)a.y * e.x},
                            {a.x, a.y, a.z}};
  struct POLISH(bar) s = {.angle = angle,
                          .omega = blade->omega,
                          .radius = radius,
                          .a = blade->radius,
                          .reach = blade->reach,
                          .tip = blade->tip};
  for (int k = 0; k < 3; k++) {
    s.r[k] = POLISH(dot)(frame[k], r) - POLISH(dot)(frame[k], c);
    s.v[k] = POLISH(dot)(frame[k], v);
    s.g[k] = POLISH(dot)(frame[k], g);
  }
  return POLISH(newton)(t, &s, POLISH(bar_at));
}

static double POLISH(pair)(const struct em_surface_path *a, const struct em_surface_path *b,
                           struct em_vec g, struct em_vec shift, double sigma) {
  const double tr = b->t > a->t ? b->t : a->t;
  const REAL da = (REAL)tr - a->t, db = (REAL)tr - b->t, fall = (db * db - da * da) / 2;
  const REAL turn = db - da;
  const REAL d[3] = {(b->r.x - (REAL)a->r.x) + b->v.x * db - a->v.x * da + g.x * fall + shift.x,
                     (b->r.y - (REAL)a->r.y) + b->v.y * db - a->v.y * da + g.y * fall + shift.y,
                     (b->r.z - (REAL)a->r.z) + b->v.z * db - a->v.z * da + g.z * fall + shift.z};
  const REAL u[3] = {(b->v.x - (REAL)a->v.x) + g.x * turn, (b->v.y - (REAL)a->v.y) + g.y * turn,
                     (b->v.z - (REAL)a->v.z) + g.z * turn};
  const REAL p = d[0] * u[0] + d[1] * u[1] + d[2] * u[2];
  if (!(p < 0)) return INFINITY;
  const REAL c = d[0] * d[0] + d[1] * d[1] + d[2] * d[2] - (REAL)sigma * sigma;
  if (c <= 0) return tr;
  const REAL disc = p * p - (u[0] * u[0] + u[1] * u[1] + u[2] * u[2]) * c;
  if (disc < 0) return INFINITY;
  return (double)(tr + c / (POLISH(root)(disc) - p));
}
