/* The event loop, a template: loop_variants.h includes it once per set of effects.
 * Before each inclusion LOOP is the suffix of its functions and LOOP_FLAGS the set of EM_LOOP_*;
 * what a set does not name is not compiled into it. */

#define FN_JOIN(name, suffix) name##_##suffix
#define FN_MAKE(name, suffix) FN_JOIN(name, suffix)
#define FN(name)              FN_MAKE(name, LOOP)
#define WITH(effect)          ((LOOP_FLAGS & EM_LOOP_##effect) != 0)

/* --- prediction of pairs ---------------------------------------------------------------------- */

/* When balls i and j touch, from their states at the later of their last real events. `now` only
 * chooses the periodic image. The pair that has just collided is left out. */
static double FN(pair)(const struct em_world *w, uint32_t i, uint32_t j, double now) {
  const struct em_body *a = &w->body[i], *b = &w->body[j];
  const double tr = b->t > a->t ? b->t : a->t;
  const double da = tr - a->t, db = tr - b->t;
  double xa = a->x + a->vx * da, ya = a->y + a->vy * da, za = a->z + a->vz * da;
  double xb = b->x + b->vx * db, yb = b->y + b->vy * db, zb = b->z + b->vz * db;
  double ua = a->vx, va = a->vy, wa = a->vz, ub = b->vx, vb = b->vy, wb = b->vz;
  if (WITH(GRAVITY)) {
    const struct em_vec g = w->gravity;
    const double ha = 0.5 * da * da, hb = 0.5 * db * db;
    xa = xa + g.x * ha, ya = ya + g.y * ha, za = za + g.z * ha;
    xb = xb + g.x * hb, yb = yb + g.y * hb, zb = zb + g.z * hb;
    ua = ua + g.x * da, va = va + g.y * da, wa = wa + g.z * da;
    ub = ub + g.x * db, vb = vb + g.y * db, wb = wb + g.z * db;
  }
  double dx = xb - xa, dy = yb - ya, dz = zb - za;
  const double du = ub - ua, dv = vb - va, dw = wb - wa;
  if (WITH(PERIODIC)) {
    const double ahead = now - tr;
    dx = dx - em_body_shift(dx + du * ahead, w->period.x, w->per_period.x);
    dy = dy - em_body_shift(dy + dv * ahead, w->period.y, w->per_period.y);
    dz = dz - em_body_shift(dz + dw * ahead, w->period.z, w->per_period.z);
  }
  (void)now;
  const double p = (dx * du + dy * dv) + dz * dw;
  if (!(p < 0.0)) return INFINITY;
  const double sigma = b->radius + a->radius;
  const double c = ((dx * dx + dy * dy) + dz * dz) - sigma * sigma;
  if (w->plan[i].last == j && w->plan[j].last == i && a->t == b->t && c < 1e-3 * sigma * sigma)
    return INFINITY;
  if (c <= 0.0) return tr;
  if (WITH(EXTRA) && w->exact_pairs)
    return em_body_exact_pair(w, i, j, em_vec_make(dx - (xb - xa), dy - (yb - ya), dz - (zb - za)));
  const double disc = p * p - ((du * du + dv * dv) + dw * dw) * c;
  if (disc < 0.0) return INFINITY;
  return tr + c / (sqrt(disc) - p);
}

/* The earliest of n candidates of ball i, one after the other. */
static struct em_prediction FN(first_of)(const struct em_world *w, uint32_t i, const uint32_t *id,
                                         uint32_t n, double now) {
  double first = INFINITY;
  uint32_t partner = EM_NOBODY;
  for (uint32_t k = 0; k < n; k++) {
    const double t = FN(pair)(w, i, id[k], now);
    if (t < first || (t == first && id[k] < partner)) first = t, partner = id[k];
  }
  return (struct em_prediction){first, partner, w->contacts};
}

/* LANES pairs of balls, as far as a root is needed. */
struct FN(pairs) {
  vd tr;     /* s: when both move along their last paths */
  vd p, c;   /* m²/s, m²: half the rate of the squared distance, and its excess */
  vd disc;   /* m⁴/s² */
  vm inside; /* they overlap */
  vm hit;    /* they meet */
};

/* The same LANES at a time, to the same bits: balls a and b, as struct em_body. `fresh`: the last
 * event of all was that of the balls a, so that the others alone have to be moved on. */
static inline __attribute__((always_inline)) struct FN(pairs)
    FN(pairs_of)(const struct em_world *w, const vd a[8], const vd b[8], double now, bool fresh) {
  const vd zero = vd_all(0.0);
  const vd tr = fresh ? a[6] : vd_choose(vd_below(a[6], b[6]), b[6], a[6]);
  const vd da = tr - a[6], db = tr - b[6];
  vd xa = a[0], ya = a[1], za = a[2], ua = a[3], va = a[4], wa = a[5];
  if (!fresh) xa = xa + ua * da, ya = ya + va * da, za = za + wa * da;
  vd xb = b[0] + b[3] * db, yb = b[1] + b[4] * db, zb = b[2] + b[5] * db;
  vd ub = b[3], vb = b[4], wb = b[5];
  if (WITH(GRAVITY)) {
    const struct em_vec g = w->gravity;
    const vd ha = 0.5 * da * da, hb = 0.5 * db * db;
    if (!fresh) {
      xa = xa + g.x * ha, ya = ya + g.y * ha, za = za + g.z * ha;
      ua = ua + g.x * da, va = va + g.y * da, wa = wa + g.z * da;
    }
    xb = xb + g.x * hb, yb = yb + g.y * hb, zb = zb + g.z * hb;
    ub = ub + g.x * db, vb = vb + g.y * db, wb = wb + g.z * db;
  }
  vd dx = xb - xa, dy = yb - ya, dz = zb - za;
  const vd du = ub - ua, dv = vb - va, dw = wb - wa;
  if (WITH(PERIODIC)) {
    const vd ahead = now - tr;
    dx = dx - image_shift(dx + du * ahead, w->period.x, w->per_period.x);
    dy = dy - image_shift(dy + dv * ahead, w->period.y, w->per_period.y);
    dz = dz - image_shift(dz + dw * ahead, w->period.z, w->per_period.z);
  }
  const vd p = (dx * du + dy * dv) + dz * dw;
  const vd sigma = b[7] + a[7];
  const vd c = ((dx * dx + dy * dy) + dz * dz) - sigma * sigma;
  const vd disc = p * p - ((du * du + dv * dv) + dw * dw) * c;
  const vm inside = vd_at_most(c, zero);
  return (struct FN(pairs)){tr,   p,      c,
                            disc, inside, vd_below(p, zero) & (inside | vd_at_most(zero, disc))};
}

/* When those that are hit touch. */
static inline vd FN(times_of)(const struct FN(pairs) * q) {
  const vd zero = vd_all(0.0);
  const vd root = q->c / (vd_sqrt(vd_choose(vd_below(zero, q->disc), q->disc, zero)) - q->p);
  return q->tr + vd_choose(q->inside, zero, root);
}

/* The earliest of a ball's candidates in each lane. */
struct FN(earliest) {
  vd time;
  vl partner;
};

/* Without branches: what is hit cannot be foretold, and a wrong guess costs more than a root. */
static inline __attribute__((always_inline)) struct FN(earliest)
    FN(earliest_of)(const struct em_world *w, uint32_t i, const uint32_t *id, uint32_t n,
                    double now, bool fresh) {
  const struct em_body *own = &w->body[i];
  const vd a[8] = {vd_all(own->x),  vd_all(own->y),  vd_all(own->z), vd_all(own->vx),
                   vd_all(own->vy), vd_all(own->vz), vd_all(own->t), vd_all(own->radius)};
  struct FN(earliest) best = {vd_all(INFINITY), vl_all(EM_NOBODY)};
  for (uint32_t k = 0; k < n; k += LANES) {
    vd b[8];
    vd_records(&w->body->x, id + k, b);
    const struct FN(pairs) q = FN(pairs_of)(w, a, b, now, fresh);
    const vd time = vd_choose(q.hit & vm_below(n - k), FN(times_of)(&q), vd_all(INFINITY));
    const vl other = vl_of(id + k);
    const vm sooner =
        vd_below(time, best.time) | (vd_equal(time, best.time) & vl_below(other, best.partner));
    best.time = vd_choose(sooner, time, best.time);
    best.partner = vl_choose(sooner, other, best.partner);
  }
  return best;
}

/* The earliest of all. */
static inline struct em_prediction FN(choose)(const struct em_world *w, uint32_t i,
                                              const uint32_t *id, uint32_t n, double now,
                                              const struct FN(earliest) * best) {
  const double first = vd_least_of(best->time);
  const uint32_t partner =
      (uint32_t)vl_least_of(vd_equal(best->time, vd_all(first)), best->partner);
  if (partner == w->plan[i].last && first < INFINITY) return FN(first_of)(w, i, id, n, now);
  return (struct em_prediction){first, partner, w->contacts};
}

/* Predicts the contacts of n pairs of balls, beside what has been predicted of the first of each;
 * few of them meet. */
static __attribute__((noinline)) void FN(predict_mixed)(struct em_world *w, const uint32_t *ball,
                                                        const uint32_t *other, uint32_t n,
                                                        double now) {
  w->tally.candidates += n;
  for (uint32_t k = 0; k < n; k += LANES) {
    vd a[8], b[8];
    vd_records(&w->body->x, ball + k, a);
    vd_records(&w->body->x, other + k, b);
    const struct FN(pairs) q = FN(pairs_of)(w, a, b, now, false);
    unsigned hit = vm_bits(q.hit & vm_below(n - k));
    if (!hit) continue;
    const vd time = FN(times_of)(&q);
    for (; hit; hit &= hit - 1) {
      const unsigned h = (unsigned)__builtin_ctz(hit);
      const uint32_t i = ball[k + h], j = other[k + h];
      const bool met = w->plan[i].last == j;
      const double t = met ? FN(pair)(w, i, j, now) : time[h];
      const struct em_prediction p = {t, j, w->contacts};
      em_local_first_add(w->local, i, &p);
    }
  }
}

/* Where only the earliest is kept: the earliest of n candidates of ball i. */
static inline struct em_prediction FN(best_of)(const struct em_world *w, uint32_t i,
                                               const uint32_t *id, uint32_t n, double now) {
  if (w->vectors) {
    const struct FN(earliest) best = FN(earliest_of)(w, i, id, n, now, false);
    return FN(choose)(w, i, id, n, now, &best);
  }
  return FN(first_of)(w, i, id, n, now);
}

/* Predicts the contacts of ball i with n candidates: beside what has been predicted, or `anew`. */
static inline bool FN(predict_pairs)(struct em_world *w, uint32_t i, const uint32_t *id, uint32_t n,
                                     double now, bool anew) {
  w->tally.candidates += n;
  if (!w->keeps_all) {
    const struct em_prediction p = FN(best_of)(w, i, id, n, now);
    if (!anew) return p.time == INFINITY || local_add(w, i, &p);
    w->plan[i].first = p;
    return true;
  }
  if (anew) w->local_kind->clear(w->local, i);
  for (uint32_t k = 0; k < n; k++) {
    const struct em_prediction p = {FN(pair)(w, i, id[k], now), id[k], w->contacts};
    if (p.time < INFINITY && !local_add(w, i, &p)) return false;
  }
  return true;
}

/* --- moving on -------------------------------------------------------------------------------- */

static inline void FN(fly)(const struct em_world *w, struct em_body *b, double t) {
  const double dt = t - b->t;
  b->x = b->x + b->vx * dt, b->y = b->y + b->vy * dt, b->z = b->z + b->vz * dt;
  if (WITH(GRAVITY)) {
    const double h = 0.5 * dt * dt;
    b->x = b->x + w->gravity.x * h, b->y = b->y + w->gravity.y * h, b->z = b->z + w->gravity.z * h;
    b->vx = b->vx + w->gravity.x * dt;
    b->vy = b->vy + w->gravity.y * dt;
    b->vz = b->vz + w->gravity.z * dt;
  }
  b->t = t;
}

/* --- prediction of surfaces -------------------------------------------------------------------
 *
 * What a ball meets is found from its last contact on, so that it does not depend on when that is
 * asked. That it meets nothing can be seen, mostly, from where it is now, which spares half the
 * searches for blades: a gain of 1.03 to 1.07. `rest` is how long from now on contacts with
 * surfaces matter, h how long from its last contact on. */

static bool FN(enter_surface)(struct em_world *w, uint32_t i, uint32_t code, double dt) {
  const struct em_prediction p = {w->body[i].t + dt, code, w->contacts};
  return dt == INFINITY || local_add(w, i, &p);
}

/* Without gravity a path is a chord, so that both its ends inside mean all inside; gravity bends it
 * by less than ½ g h². */
static inline bool FN(stays_in_drum)(const struct em_world *w, const struct em_body *at,
                                     double rest) {
  const double rho = w->rho - at->radius;
  const double sure = WITH(GRAVITY) ? rho - 0.5 * w->fall * rest * rest : rho, s2 = sure * sure;
  const double qx = at->x + at->vx * rest, qz = at->z + at->vz * rest;
  return (sure > 0.0) & (at->x * at->x + at->z * at->z < s2) & (qx * qx + qz * qz < s2);
}

static __attribute__((noinline)) bool FN(predict_drum)(struct em_world *w, uint32_t i, double h) {
  const struct em_body *b = &w->body[i];
  const double gx = WITH(GRAVITY) ? w->gravity.x : 0.0, gz = WITH(GRAVITY) ? w->gravity.z : 0.0;
  const uint32_t code = EM_SURFACE + EM_WALL_DRUM;
  const bool touched = w->plan[i].last == code;
  if (WITH(EXTRA) && w->special_drum)
    return FN(enter_surface)(w, i, code, em_body_special_drum(w, i, touched, h));
  const double dt = em_surface_drum(b->x, b->z, b->vx, b->vz, gx, gz, w->rho - b->radius, touched,
                                    w->scene->engine.roots.quartic, h);
  return FN(enter_surface)(w, i, code, dt);
}

static bool FN(predict_plane)(struct em_world *w, uint32_t i, uint32_t wall, double gap,
                              double rate, double fall, double h) {
  if (gap > 0.0 && gap + rate * h - (WITH(GRAVITY) ? 0.5 * fabs(fall) * h * h : 0.0) > 0.0)
    return true;
  const uint32_t code = EM_SURFACE + wall;
  const bool touched = w->plan[i].last == code;
  if (!WITH(GRAVITY)) fall = 0.0;
  const double dt = WITH(EXTRA) && w->exact_pairs
                        ? em_surface_roots_plane(&w->scene->engine.roots, gap, rate, fall, touched)
                        : em_surface_plane(gap, rate, fall, touched);
  return dt > h || FN(enter_surface)(w, i, code, dt);
}

/* Both walls across one axis. */
static inline bool FN(stays_between)(double x, double v, double g, double radius, double low,
                                     double high, double rest) {
  const double near = fabs(x - 0.5 * (low + high)) + radius;
  const double far = fabs(v) * rest + (WITH(GRAVITY) ? 0.5 * fabs(g) * rest * rest : 0.0);
  return (near + far) * (1.0 + 1e-12) < 0.5 * (high - low);
}

static __attribute__((noinline)) bool FN(predict_walls)(struct em_world *w, uint32_t i,
                                                        uint32_t axis, double x, double v, double g,
                                                        double low, double high, double h) {
  const double r = w->body[i].radius;
  return (!w->wall[2 * axis] || FN(predict_plane)(w, i, 2 * axis, x - low - r, v, g, h)) &&
         (!w->wall[2 * axis + 1] || FN(predict_plane)(w, i, 2 * axis + 1, high - x - r, -v, -g, h));
}

/* Can ball and blade not close their gap in time? */
static inline bool FN(stays_off_blade)(struct em_turning *turning, const struct em_body *at,
                                       double fall, double rest) {
  const double speed = em_vec_norm((struct em_vec){at->vx, at->vy, at->vz}) + fall * rest;
  const double gap = turning_gap(turning, centre(at), at->radius, at->t);
  return gap > speed * rest + turning->swing * (fabs(at->t - turning->at) + rest);
}

static __attribute__((noinline)) bool FN(predict_blade)(struct em_world *w, uint32_t i, uint32_t k,
                                                        double h) {
  const struct em_body *b = &w->body[i];
  const struct em_blade *blade = &w->blade[k].blade;
  const uint32_t code = EM_SURFACE_BLADE(k);
  const struct em_vec r = centre(b), v = {b->vx, b->vy, b->vz};
  const struct em_vec g = WITH(GRAVITY) ? w->gravity : (struct em_vec){0, 0, 0};
  const double angle = blade->angle + blade->omega * b->t;
  const bool touched = w->plan[i].last == code;
  unsigned steps = 0;
  const double dt = w->special_roots
                        ? em_surface_roots_blade(&w->scene->engine.roots, blade, r, v, g, b->radius,
                                                 angle, touched, h, &steps)
                        : em_surface_blade(blade, r, v, g, b->radius, angle, touched, h, &steps);
  w->tally.blade_searches++;
  w->tally.blade_steps += steps;
  return FN(enter_surface)(w, i, code, dt);
}

/* The chamber's walls. */
static inline bool FN(predict_room)(struct em_world *w, uint32_t i, const struct em_body *at,
                                    double until) {
  const struct em_body *b = &w->body[i];
  const struct em_vec g = w->gravity, low = w->low, high = w->high;
  const double rest = until - at->t, h = until - b->t, r = at->radius;
  if (w->drum) {
    if (!FN(stays_in_drum)(w, at, rest) && !FN(predict_drum)(w, i, h)) return false;
  } else if (w->walls) {
    if (!FN(stays_between)(at->x, at->vx, g.x, r, low.x, high.x, rest) &&
        !FN(predict_walls)(w, i, 0, b->x, b->vx, g.x, low.x, high.x, h))
      return false;
    if (!FN(stays_between)(at->z, at->vz, g.z, r, low.z, high.z, rest) &&
        !FN(predict_walls)(w, i, 2, b->z, b->vz, g.z, low.z, high.z, h))
      return false;
  }
  return !w->walls || FN(stays_between)(at->y, at->vy, g.y, r, low.y, high.y, rest) ||
         FN(predict_walls)(w, i, 1, b->y, b->vy, g.y, low.y, high.y, h);
}

/* How far ahead contacts with surfaces matter. */
static double FN(until)(const struct em_world *w, uint32_t i) {
  return w->keeps_all ? w->plan[i].leave : local_least(w, i);
}

static inline bool FN(meet_blade)(struct em_world *w, uint32_t i, const struct em_body *at,
                                  uint32_t k) {
  const double until = FN(until)(w, i);
  return FN(stays_off_blade)(&w->blade[k], at, WITH(GRAVITY) ? w->fall : 0.0, until - at->t) ||
         FN(predict_blade)(w, i, k, until - w->body[i].t);
}

/* Predicts the contacts of ball i with surfaces, as far as they can matter before it leaves its
 * place or meets another ball; it has met none before `now`. */
static bool FN(predict_surfaces)(struct em_world *w, uint32_t i, double now) {
  const uint32_t near = w->plan[i].near;
  if (!near) return true;
  struct em_body at = w->body[i];
  FN(fly)(w, &at, now);
  if (near & EM_NEAR_WALL && !FN(predict_room)(w, i, &at, FN(until)(w, i))) return false;
  if (!WITH(ROTOR)) return true;
  for (uint32_t left = near & w->few_blades; left; left &= left - 1)
    if (!FN(meet_blade)(w, i, &at, (uint32_t)__builtin_ctz(left))) return false;
  for (uint32_t k = EM_NEAR_MANY; near & EM_NEAR_BLADE(k) && k < w->blade_count; k++)
    if (!FN(meet_blade)(w, i, &at, k)) return false;
  return true;
}

static void FN(schedule)(struct em_world *w, uint32_t i) {
  queue_set(w, i, local_least(w, i));
}

/* After its contacts with balls: predicts those of ball i with surfaces, and files the earliest. */
static bool FN(settle)(struct em_world *w, uint32_t i, double now) {
  if (!FN(predict_surfaces)(w, i, now)) return false;
  FN(schedule)(w, i);
  return true;
}

/* Predicts all events of ball i anew. */
static bool FN(predict)(struct em_world *w, uint32_t i, double now) {
  uint32_t n;
  const uint32_t *id = candidates(w, i, 0, &n);
  w->tally.predictions++;
  return FN(predict_pairs)(w, i, id, n, now, true) && FN(settle)(w, i, now);
}

/* Predicts all events of two balls that have just met. The processor works on the roots of one
 * while it waits for those of the other, if they are near enough to each other: a gain of 1.15. */
static __attribute__((noinline)) bool FN(predict_two)(struct em_world *w, uint32_t i, uint32_t j,
                                                      double now) {
  if (!w->joins) return FN(predict)(w, i, now) && FN(predict)(w, j, now);
  uint32_t n, m;
  const uint32_t *id_i = candidates(w, i, 0, &n), *id_j = candidates(w, j, n + 8, &m);
  w->tally.predictions += 2;
  w->tally.candidates += n + m;
  const struct FN(earliest) a = FN(earliest_of)(w, i, id_i, n, now, true);
  const struct FN(earliest) b = FN(earliest_of)(w, j, id_j, m, now, true);
  w->plan[i].first = FN(choose)(w, i, id_i, n, now, &a);
  w->plan[j].first = FN(choose)(w, j, id_j, m, now, &b);
  return FN(settle)(w, i, now) && FN(settle)(w, j, now);
}

static bool FN(predict_all)(struct em_world *w) {
  w->queue_kind->clear(w->queue, w->clock);
  w->contacts = 0;
  for (uint32_t i = 0; i < w->count; i++)
    w->plan[i].contact = 0;
  for (uint32_t i = 0; i < w->count; i++)
    if (!FN(predict)(w, i, w->clock)) return false;
  return true;
}

/* --- contacts --------------------------------------------------------------------------------- */

/* Counts contacts in a row. */
static uint32_t FN(streak)(const struct em_world *w, uint32_t i, double t) {
  return t - w->body[i].t <= w->within ? w->plan[i].streak + 1 : 0;
}

static void FN(advance)(struct em_world *w, uint32_t i, double t) {
  struct em_body *b = &w->body[i];
  FN(fly)(w, b, t);
  if (WITH(PERIODIC)) {
    b->x = wrap(b->x, w->low.x, w->period.x);
    b->y = wrap(b->y, w->low.y, w->period.y);
    b->z = wrap(b->z, w->low.z, w->period.z);
  }
}

/* By division: m (1/m) is not 1, and that error, the same at each contact, would add up. */
static void FN(push)(struct em_world *w, uint32_t i, double mass, struct em_vec impulse) {
  struct em_body *b = &w->body[i];
  b->vx = b->vx + impulse.x / mass;
  b->vy = b->vy + impulse.y / mass;
  b->vz = b->vz + impulse.z / mass;
}

/* Turns ball i by k e × P_t; returns the spin energy (J) that it gained. */
static double FN(spin_up)(struct em_world *w, uint32_t i, double m,
                          const struct em_contact_law *law, struct em_vec twist) {
  const double r = w->body[i].radius;
  const struct em_vec d = em_vec_scale(em_contact_spin_factor(law->rule, m, r), twist);
  const struct em_vec old = w->spin[i];
  w->spin[i] = em_vec_add(old, d);
  return 0.5 * (0.4 * m * r * r) * em_vec_dot(d, em_vec_add(old, w->spin[i]));
}

/* Which remedies act on a contact with approach speed vn, when the balls' last was `since` ago. An
 * elastic contact loses nothing, along the surface neither: else rough heaps still collapse. */
static struct remedy FN(remedy)(struct em_world *w, uint32_t streak, double since, double vn) {
  struct remedy act = {false, false};
  if (!WITH(EXTRA)) return act;
  const struct em_remedy *r = &w->scene->remedy;
  if (r->jam_after > 0 && streak >= (uint32_t)r->jam_after) {
    act.frictionless = true;
    w->tally.jam++;
  }
  if (since < r->tc) {
    act.elastic = act.frictionless = true;
    w->tally.tc++;
  }
  if (vn < r->elastic_below) {
    act.elastic = act.frictionless = true;
    w->tally.elastic++;
  }
  return act;
}

/* The impulse on a ball. Where no surface is rough it is along the normal, and how fast the
 * surfaces slide is asked by observers only: a gain of 1.05. */
static inline struct em_impulse FN(impulse)(const struct em_world *w,
                                            const struct em_contact_law *law, double m_eff,
                                            struct em_vec e, struct em_vec g, struct remedy act) {
  if (WITH(SPIN)) return em_contact_impulse(law, m_eff, e, g, act.frictionless, act.elastic);
  const double gn = em_vec_dot(g, e), vn = gn < 0.0 ? -gn : 0.0;
  return (struct em_impulse){
      .normal = em_vec_scale(em_contact_push(&law->normal, m_eff, e, vn, act.elastic), e),
      .vn = vn,
      .vt = w->observers ? em_vec_norm(em_vec_axpy(g, -gn, e)) : 0.0};
}

static double FN(since)(const struct em_world *w, uint32_t i, double t) {
  return w->plan[i].last == EM_NOBODY ? INFINITY : t - w->body[i].t;
}

static enum em_status FN(collide_pair)(struct em_world *w, uint32_t i, uint32_t j, double t,
                                       struct em_error *err) {
  const uint32_t low = i < j ? i : j, high = i ^ j ^ low;
  i = low, j = high;
  const uint32_t si = FN(streak)(w, i, t), sj = FN(streak)(w, j, t);
  if ((si > sj ? si : sj) >= w->scene->remedy.collapse_after)
    return collapsed(w, si > sj ? i : j, si > sj ? j : i, t, err);
  double since = INFINITY;
  if (WITH(EXTRA)) since = em_lesser(FN(since)(w, i, t), FN(since)(w, j, t));
  FN(advance)(w, i, t);
  FN(advance)(w, j, t);
  const struct em_body *a = &w->body[i], *b = &w->body[j];
  struct em_vec d = {a->x - b->x, a->y - b->y, a->z - b->z};
  if (WITH(PERIODIC)) {
    d.x = d.x - em_body_shift(d.x, w->period.x, w->per_period.x);
    d.y = d.y - em_body_shift(d.y, w->period.y, w->per_period.y);
    d.z = d.z - em_body_shift(d.z, w->period.z, w->per_period.z);
  }
  const double norm = em_vec_norm(d);
  const struct em_vec e = {d.x / norm, d.y / norm, d.z / norm};
  const struct em_vec u = {a->vx - b->vx, a->vy - b->vy, a->vz - b->vz};
  const struct em_vec g =
      WITH(SPIN) ? em_vec_add(u, em_vec_cross(e, em_vec_add(em_vec_scale(a->radius, w->spin[i]),
                                                            em_vec_scale(b->radius, w->spin[j]))))
                 : u;
  const double mi = w->mass ? w->mass[i] : w->mass0, mj = w->mass ? w->mass[j] : w->mass0;
  const double meff = mi * mj / (mi + mj);
  const struct remedy act = FN(remedy)(w, si > sj ? si : sj, since, -em_vec_dot(g, e));
  const struct em_contact_law *law = &w->scene->contact[EM_CLASS_BALL];
  const struct em_impulse p = FN(impulse)(w, law, meff, e, g, act);
  if (vn_bin(p.vn) == 0 && em_collapse_sticks(w, law, p.vn))
    return em_collapse_stuck(w, i, j, t, p.vn, err);
  const struct em_vec sum = WITH(SPIN) ? em_vec_add(p.normal, p.tangential) : p.normal;
  double gain = em_vec_dot(sum, u) + 0.5 * em_vec_norm2(sum) / meff;
  FN(push)(w, i, mi, sum);
  FN(push)(w, j, -mj, sum);
  if (WITH(SPIN)) {
    const struct em_vec twist = em_vec_cross(e, p.tangential);
    gain += FN(spin_up)(w, i, mi, law, twist);
    gain += FN(spin_up)(w, j, mj, law, twist);
  }
  w->contacts++;
  mark(w, i, j, si);
  mark(w, j, i, sj);
  note(w, EM_CLASS_BALL, meff, p.vn, -gain);
  if (w->observers) {
    const struct em_contact c = {.time = absolute(w, t),
                                 .cls = EM_CLASS_BALL,
                                 .ball = i,
                                 .partner = j,
                                 .place = em_vec_axpy(centre(a), -a->radius, e),
                                 .normal = e,
                                 .vn = p.vn,
                                 .vt = p.vt,
                                 .lost = -gain,
                                 .work = 0.0};
    tell(w, &c);
  }
  return EM_OK;
}

/* Outward normal of the faked ramps (Reichardt 20.1.1): near the top and the bottom the drum's
 * normal is turned against the ball's motion along x. */
static struct em_vec FN(drum_normal)(const struct em_world *w, const struct em_body *b) {
  const double rho = sqrt(b->x * b->x + b->z * b->z);
  struct em_vec e = {-b->x / rho, 0.0, -b->z / rho};
  if (WITH(EXTRA) && w->facets) return em_body_facet(w, em_vec_make(b->x, b->y, b->z));
  if (WITH(EXTRA) && w->scene->chamber.ramp_tilt != 0.0 &&
      fabs(e.z) > cos(w->scene->chamber.ramp_half)) {
    const double side = (b->vx > 0.0) == (e.z > 0.0) ? -1.0 : 1.0;
    const double s = side * sin(w->scene->chamber.ramp_tilt), c = cos(w->scene->chamber.ramp_tilt);
    e = (struct em_vec){c * e.x + s * e.z, 0.0, c * e.z - s * e.x};
  }
  return e;
}

/* Class, normal and velocity of the surface `code` where ball i touches it. */
static enum em_class FN(meet_surface)(const struct em_world *w, uint32_t i, uint32_t code, double t,
                                      struct em_vec *e, struct em_vec *surface) {
  const struct em_body *b = &w->body[i];
  const uint32_t wall = code - EM_SURFACE;
  *surface = (struct em_vec){0.0, 0.0, 0.0};
  if (WITH(ROTOR) && wall >= EM_WALLS) {
    const struct em_blade *blade = &w->blade[wall - EM_WALLS].blade;
    *e = em_surface_blade_normal(blade, centre(b), blade->angle + blade->omega * t);
    *surface = em_surface_blade_velocity(blade, em_vec_axpy(centre(b), -b->radius, *e));
    return EM_CLASS_BLADE;
  }
  if (wall == EM_WALL_DRUM) {
    *e = FN(drum_normal)(w, b);
  } else {
    const double sign = wall & 1 ? -1.0 : 1.0;
    *e = (struct em_vec){wall / 2 == 0 ? sign : 0.0, wall / 2 == 1 ? sign : 0.0,
                         wall / 2 == 2 ? sign : 0.0};
  }
  if (WITH(EXTRA) && w->drum_omega != 0.0) {
    const struct em_vec x = em_vec_axpy(centre(b), -b->radius, *e);
    *surface = (struct em_vec){w->drum_omega * x.z, 0.0, -w->drum_omega * x.x};
  }
  return wall / 2 == 1 ? EM_CLASS_END : EM_CLASS_DRUM;
}

static enum em_status FN(collide_surface)(struct em_world *w, uint32_t i, uint32_t code, double t,
                                          struct em_error *err) {
  const uint32_t si = FN(streak)(w, i, t);
  if (si >= w->scene->remedy.collapse_after) return collapsed(w, i, code, t, err);
  const double since = WITH(EXTRA) ? FN(since)(w, i, t) : INFINITY;
  FN(advance)(w, i, t);
  const struct em_body *b = &w->body[i];
  struct em_vec e, surface;
  const enum em_class cls = FN(meet_surface)(w, i, code, t, &e, &surface);
  const struct em_vec v = {b->vx, b->vy, b->vz};
  struct em_vec g = em_vec_sub(v, surface);
  if (WITH(SPIN)) g = em_vec_add(g, em_vec_scale(b->radius, em_vec_cross(e, w->spin[i])));
  const double m = w->mass ? w->mass[i] : w->mass0;
  const struct remedy act = FN(remedy)(w, si, since, -em_vec_dot(g, e));
  const struct em_contact_law *law = &w->scene->contact[cls];
  const struct em_impulse p = FN(impulse)(w, law, m, e, g, act);
  const struct em_vec sum = WITH(SPIN) ? em_vec_add(p.normal, p.tangential) : p.normal;
  double gain = em_vec_dot(sum, v) + 0.5 * em_vec_norm2(sum) / m;
  const double work = em_vec_dot(sum, surface);
  FN(push)(w, i, m, sum);
  if (WITH(SPIN)) gain += FN(spin_up)(w, i, m, law, em_vec_cross(e, p.tangential));
  w->contacts++;
  mark(w, i, code, si);
  note(w, cls, m, p.vn, work - gain);
  const struct em_vec place = em_vec_axpy(centre(b), -b->radius, e);
  if (WITH(ROTOR) && cls == EM_CLASS_BLADE) note_blade(w, code, place, sum, work);
  if (WITH(EXTRA) && cls != EM_CLASS_BLADE) w->tally.drum_work += work;
  if (w->observers) {
    const uint32_t wall = code - EM_SURFACE;
    const struct em_contact c = {.time = absolute(w, t),
                                 .cls = cls,
                                 .ball = i,
                                 .partner = cls == EM_CLASS_BLADE ? wall - EM_WALLS : wall,
                                 .place = place,
                                 .normal = e,
                                 .vn = p.vn,
                                 .vt = p.vt,
                                 .lost = work - gain,
                                 .work = work};
    tell(w, &c);
  }
  return EM_OK;
}

/* --- the loop --------------------------------------------------------------------------------- */

static void FN(moved)(struct em_world *w, uint32_t i) {
  if (w->cells)
    em_blocks_moved(w, i, WITH(GRAVITY), WITH(PERIODIC));
  else
    w->partition_kind->moved(w, i);
}

/* Ball i has reached the end of its place. */
static bool FN(cross)(struct em_world *w, uint32_t i, double now) {
  uint32_t n;
  const uint32_t *id = w->cells ? em_blocks_cross(w, i, now, &n, WITH(GRAVITY), WITH(PERIODIC))
                                : w->partition_kind->cross(w, i, now, &n);
  w->tally.transfers++;
  if (!id && n) return false;
  return FN(predict_pairs)(w, i, id, n, now, false) && FN(settle)(w, i, now);
}

/* Takes a stale prediction of ball i out. */
static bool FN(renew)(struct em_world *w, uint32_t i, double now) {
  w->tally.stale++;
  if (!w->keeps_all) return FN(predict)(w, i, now);
  w->local_kind->pop(w->local, i);
  FN(schedule)(w, i);
  return true;
}

/* Several balls move on at once from their cells; their candidates are tested together. */
static bool FN(cross_all)(struct em_world *w, const uint32_t *ball, uint32_t n, double now) {
  struct em_places *p = w->places;
  double leave[EM_BLOCKS_MANY];
  uint32_t all = 0;
  for (uint32_t k = 0; k < n; k++) {
    const uint32_t i = ball[k];
    const unsigned exit = p->plan[i].exit;
    leave[k] = p->plan[i].leave;
    if (!em_blocks_step(w, i, leave[k], WITH(GRAVITY), WITH(PERIODIC))) return false;
    const uint32_t end = (uint32_t)(em_blocks_new(p, i, exit, p->found + all) - p->found);
    for (; all < end; all += 8)
      *(v8iu *)(p->finder + all) = (v8iu){0} + (int32_t)i;
    all = end;
  }
  w->tally.transfers += n;
  FN(predict_mixed)(w, p->finder, p->found, all, now);
  for (uint32_t k = 0; k < n; k++)
    if (!FN(settle)(w, ball[k], leave[k])) return false;
  return true;
}

/* A bin of the calendar begins, after the last contact at `now`: of its balls, those that leave
 * their places in it are moved on at once, if they are near enough to the border, and predictions
 * that are stale are made anew. When that is done changes no contact, and the processor, which
 * cannot foretell what the next event is, goes through many of a kind without wrong guesses: a gain
 * of 1.1. */
static bool FN(tidy)(struct em_world *w, double now) {
  uint32_t ball[FORESEEN], stale[FORESEEN], leaving = 0, staying = 0, near = 0, rest = 0;
  const uint32_t n = em_calendar_peek(w->queue, 0, ball, FORESEEN);
  for (uint32_t k = 0; k < n; k++) {
    const uint32_t i = ball[k];
    const bool leaves = leaves_first(w, i);
    ball[leaving] = stale[staying] = i;
    leaving += leaves;
    staying += !leaves;
  }
  for (uint32_t k = 0; k < staying; k++) {
    const uint32_t i = stale[k];
    stale[rest] = i;
    rest += !holds(w, i, &w->plan[i].first);
  }
  for (uint32_t k = 0; k < leaving; k++) {
    const struct em_body *b = &w->body[ball[k]];
    const double leave = w->plan[ball[k]].leave, fallen = w->fall * (leave - b->t);
    const double speed = sqrt(b->vx * b->vx + b->vy * b->vy + b->vz * b->vz) + fallen;
    ball[near] = ball[k];
    near += speed * (leave - now) <= w->early;
  }
  if (w->joins && w->cells && !w->places->centre) {
    if (!FN(cross_all)(w, ball, near, now)) return false;
  } else {
    for (uint32_t k = 0; k < near; k++)
      if (!FN(cross)(w, ball[k], w->plan[ball[k]].leave)) return false;
  }
  for (uint32_t k = 0; k < rest; k++)
    if (!FN(renew)(w, stale[k], now)) return false;
  return true;
}

static enum em_status FN(run)(struct em_world *w, double limit, uint64_t *left,
                              const volatile sig_atomic_t *stop, struct em_error *err) {
  uint64_t turns = 0;
  const bool bins = w->calendar && !w->keeps_all;
  const bool foresight = bins && w->count >= EM_FETCH_FROM && w->partition_kind->fetch;
  while (*left > 0) {
    if (bins && em_calendar_is_over(w->queue)) {
      if (!em_calendar_advance(w->queue)) return EM_OK;
      if (foresight) foresee(w);
      if (!FN(tidy)(w, w->clock)) return no_memory(err);
      continue;
    }
    double t;
    uint32_t rival, i = queue_first(w, &t, &rival);
    if (i == EM_QUEUE_NOBODY || t >= limit) return EM_OK;
    if (stop && (++turns & 255) == 0 && *stop)
      return em_error_set(err, EM_STOPPED, NULL, 0, "stopped on request");
    if (rival != i && !meets(w, i, rival)) i = untie(w, t);
    if (!is_real(w, i, t)) {
      if (w->plan[i].leave <= t ? !FN(cross)(w, i, t) : !FN(renew)(w, i, t)) return no_memory(err);
      continue;
    }
    const uint32_t partner = local_first(w, i)->partner;
    const bool pair = partner < EM_SURFACE;
    const double at = t > w->clock ? t : w->clock;
    const enum em_status status = pair ? FN(collide_pair)(w, i, partner, at, err)
                                       : FN(collide_surface)(w, i, partner, at, err);
    if (status) return status;
    w->clock = at;
    --*left;
    FN(moved)(w, i);
    if (pair) FN(moved)(w, partner);
    if (pair ? !FN(predict_two)(w, i, partner, at) : !FN(predict)(w, i, at)) return no_memory(err);
  }
  return EM_OK;
}

#undef FN_JOIN
#undef FN_MAKE
#undef FN
#undef WITH
#undef LOOP
#undef LOOP_FLAGS
