/* Part of loop_template.h, a template: when balls meet, one pair at a time, to the same bits many
 * at a time, and the earliest of a ball's candidates. */

/* When balls i and j touch or have touched: see FN(pair). */
static double FN(touch)(const struct em_world *w, uint32_t i, uint32_t j, double now) {
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
  return tr + em_surface_pair(em_vec_make(dx, dy, dz), em_vec_make(du, dv, dw), sigma);
}

/* When balls i and j touch, from their states at the later of their last real events. `now` only
 * chooses the periodic image, and tells what is past. The contact that has just been made is left
 * out; other images of that partner are further away (PERIOD_LEAST in scene_check.c). */
static double FN(pair)(const struct em_world *w, uint32_t i, uint32_t j, double now) {
  const double t = FN(touch)(w, i, j, now);
  return t >= now - w->late ? t : INFINITY;
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
  vd tr;   /* s: when both move along their last paths */
  vd p, c; /* m²/s, m²: half the rate of the squared distance, and its excess, ≥ 0 */
  vd disc; /* m⁴/s²; they meet if it is not negative, as p is */
};

/* The same LANES at a time, to the same bits: balls a and b, as struct em_body. `fresh`: the last
 * event of all, which is `now`, was that of the balls a, so that the others alone have to be moved
 * on. That, and that a root is drawn of all, whether they meet or not, are gains of 1.02 to 1.05 in
 * gases. */
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
    vd nx = dx, ny = dy, nz = dz;
    if (!fresh) {
      const vd ahead = now - tr;
      nx = nx + du * ahead, ny = ny + dv * ahead, nz = nz + dw * ahead;
    }
    dx = dx - image_shift(nx, w->period.x, w->per_period.x);
    dy = dy - image_shift(ny, w->period.y, w->per_period.y);
    dz = dz - image_shift(nz, w->period.z, w->per_period.z);
  }
  const vd p = (dx * du + dy * dv) + dz * dw;
  const vd sigma = b[7] + a[7];
  const vd over = ((dx * dx + dy * dy) + dz * dz) - sigma * sigma;
  const vd c = vd_greater(over, zero);
  const vd disc = p * p - ((du * du + dv * dv) + dw * dw) * c;
  return (struct FN(pairs)){tr, p, c, disc};
}

/* When those that are hit touch: at once where they overlap (c = 0). */
static inline vd FN(times_of)(vd tr, vd p, vd c, vd disc) {
  return tr + c / (vd_sqrt(disc) - p);
}

enum { FN(most) = 64 }; /* candidates of a ball that are looked through at a time */

/* Up to as many pairs, before roots are drawn. */
struct FN(approaches) {
  struct FN(pairs) of[FN(most) / LANES];
};

/* Without branches: what is hit cannot be foretold, and a wrong guess costs more than a root; what
 * parts is told by the sign, and where disc < 0 the root will be no number: gains of 1.01. And
 * without roots, before all pairs have come so far: the processor sees no more than two vectors
 * ahead, so that it would have nothing else to do while it waits for each: a gain of 1.05 to 1.1 in
 * gases. */
static inline __attribute__((always_inline)) void FN(approach)(const struct em_world *w, uint32_t i,
                                                               const uint32_t *id, uint32_t n,
                                                               double now, bool fresh,
                                                               struct FN(approaches) * to) {
  const struct em_body *own = &w->body[i];
  const vd a[8] = {vd_all(own->x),  vd_all(own->y),  vd_all(own->z), vd_all(own->vx),
                   vd_all(own->vy), vd_all(own->vz), vd_all(own->t), vd_all(own->radius)};
  const vd none = vd_all(NAN);
  struct FN(pairs) *each = to->of;
  vl left = (int64_t)n - 1 - vl_lanes(); /* candidates behind that of each lane */
  for (const uint32_t *end = id + n; id < end; id += LANES, each++, left -= LANES) {
    vd b[8];
    vd_records(&w->body->x, id, b);
    const struct FN(pairs) q = FN(pairs_of)(w, a, b, now, fresh);
    if (!fresh) each->tr = q.tr;
    each->p = q.p;
    each->c = vd_choose_negative((vl)q.p & ~left, q.c, none);
    each->disc = q.disc;
  }
}

/* The earliest of them; those that are not hit have no number as c, nor as time. Several at the
 * same time are rare, and so is a second contact with the ball that was met last: they are looked
 * for one by one. */
static inline __attribute__((always_inline)) struct em_prediction
FN(choose)(const struct em_world *w, uint32_t i, const uint32_t *id, uint32_t n, double now,
           bool fresh, const struct FN(approaches) * to) {
  static const uint32_t nobody = EM_NOBODY;
  vd each = vd_all(INFINITY);
  vl from = vl_all(0), at = vl_all(0);
  vm twice = vm_of(0);
  for (uint32_t h = 0; h * LANES < n; h++, from += LANES) {
    const struct FN(pairs) *q = &to->of[h];
    const vd t = FN(times_of)(fresh ? vd_all(now) : q->tr, q->p, q->c, q->disc);
    vm sooner = vd_below(t, each);
    if (!fresh) sooner &= vd_at_most(vd_all(now - w->late), t);
    twice |= vd_equal(t, each);
    each = vd_choose(sooner, t, each);
    at = vl_choose(sooner, from, at);
  }
  const double first = vd_least_of(each);
  const bool any = first < INFINITY;
  const unsigned here = vm_bits(vd_equal(each, vd_all(first)));
  const unsigned lane = (unsigned)__builtin_ctz(here);
  const uint32_t partner = *(any ? id + at[lane] + lane : &nobody);
  const bool tied = (here & (here - 1)) | vm_bits(twice);
  if (any & (tied | (partner == w->plan[i].last))) return FN(first_of)(w, i, id, n, now);
  return (struct em_prediction){first, partner, w->contacts};
}

/* Predicts the contacts of n pairs of balls, up to the most, beside what has been predicted of the
 * first of each; few of them meet. */
static inline void FN(predict_some)(struct em_world *w, const uint32_t *ball, const uint32_t *other,
                                    uint32_t n, double now) {
  struct FN(approaches) to;
  const vd zero = vd_all(0.0);
  uint64_t hit = 0;
  for (uint32_t k = 0; k < n; k += LANES) {
    vd a[8], b[8];
    vd_records(&w->body->x, ball + k, a);
    vd_records(&w->body->x, other + k, b);
    const struct FN(pairs) q = FN(pairs_of)(w, a, b, now, false);
    to.of[k / LANES] = q;
    const vm hits = vd_below(q.p, zero) & vd_at_most(zero, q.disc);
    hit |= (uint64_t)vm_bits(hits & vm_below(n - k)) << k;
  }
  for (; hit; hit &= hit - 1) {
    const unsigned k = (unsigned)__builtin_ctzll(hit), v = k / LANES, h = k % LANES;
    const uint32_t i = ball[k], j = other[k];
    const struct FN(pairs) *q = &to.of[v];
    const double root = q->c[h] / (sqrt(q->disc[h]) - q->p[h]);
    const double t = w->plan[i].last == j ? FN(pair)(w, i, j, now) : q->tr[h] + root;
    const struct em_prediction p = {t, j, w->contacts};
    if (t >= now - w->late) em_local_first_add(w->local, i, &p);
  }
}

static __attribute__((noinline)) void FN(predict_mixed)(struct em_world *w, const uint32_t *ball,
                                                        const uint32_t *other, uint32_t n,
                                                        double now) {
  w->tally.candidates += n;
  for (uint32_t k = 0; k < n; k += FN(most))
    FN(predict_some)(w, ball + k, other + k, n - k < FN(most) ? n - k : FN(most), now);
}

/* Where only the earliest is kept: the earliest of n candidates of ball i. */
static inline struct em_prediction FN(best_of)(const struct em_world *w, uint32_t i,
                                               const uint32_t *id, uint32_t n, double now) {
  if (!w->vectors) return FN(first_of)(w, i, id, n, now);
  struct em_prediction best = {INFINITY, EM_NOBODY, w->contacts};
  for (uint32_t k = 0; k < n; k += FN(most)) {
    const uint32_t some = n - k < FN(most) ? n - k : FN(most);
    struct FN(approaches) to;
    FN(approach)(w, i, id + k, some, now, false, &to);
    const struct em_prediction p = FN(choose)(w, i, id + k, some, now, false, &to);
    if (em_local_sooner(&p, &best)) best = p;
  }
  return best;
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
