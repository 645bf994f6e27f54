/* Part of loop_template.h, a template: when balls meet walls, the drum and blades.
 *
 * What a ball meets is found from its last contact on, so that it does not depend on when that is
 * asked. That it meets nothing can be seen, mostly, from where it is now, which spares half the
 * searches for blades: a gain of 1.03 to 1.07; what is nearer than EM_CLEARLY, far more than
 * rounding, or than searches are content with, is searched for, so that nothing is decided here.
 * `rest` is how long from now on contacts with surfaces matter, h how long from its last contact
 * on. */

static bool FN(enter_surface)(struct em_world *w, uint32_t i, uint32_t code, double dt) {
  const struct em_prediction p = {w->body[i].t + dt, code, w->contacts};
  return dt == INFINITY || local_add(w, i, &p);
}

static inline double FN(content)(const struct em_world *w) {
  return WITH(EXTRA) ? w->content : 0.0;
}

/* Without gravity a path is a chord, so that both its ends inside mean all inside; gravity bends it
 * by less than ½ g h². */
static inline bool FN(stays_in_drum)(const struct em_world *w, const struct em_body *at,
                                     double rest) {
  const double rho = w->rho - at->radius;
  const double bent = WITH(GRAVITY) ? 0.5 * w->fall * rest * rest : 0.0;
  const double sure = rho * (1.0 - EM_CLEARLY) - bent - FN(content)(w), s2 = sure * sure;
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
  const double bent = WITH(GRAVITY) ? 0.5 * fabs(fall) * h * h : 0.0;
  if (gap > 0.0 && gap + rate * h - bent > EM_CLEARLY * w->body[i].radius) return true;
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
  return (near + far) * (1.0 + EM_CLEARLY) < 0.5 * (high - low);
}

static __attribute__((noinline)) bool FN(predict_walls)(struct em_world *w, uint32_t i,
                                                        uint32_t axis, double x, double v, double g,
                                                        double low, double high, double h) {
  const double r = w->body[i].radius;
  return (!w->wall[2 * axis] || FN(predict_plane)(w, i, 2 * axis, x - low - r, v, g, h)) &&
         (!w->wall[2 * axis + 1] || FN(predict_plane)(w, i, 2 * axis + 1, high - x - r, -v, -g, h));
}

/* Lower bound of the gap (m) between a ball and a blade as it stood at turning.at, not too far from
 * the time t; a contact needs the ball within the bar's length, whatever its tip. */
static inline double FN(turning_gap)(struct em_turning *b, struct em_vec r, double radius,
                                     double t) {
  if (b->swing * fabs(t - b->at) > 0.25 * radius) {
    b->at = t;
    b->cos = cos(b->blade.angle + b->blade.omega * t);
    b->sin = sin(b->blade.angle + b->blade.omega * t);
  }
  const struct em_vec q = em_vec_sub(r, b->blade.centre);
  const double q1 = em_vec_dot(q, b->blade.e1), q3 = em_vec_dot(q, b->e3);
  const double axial = em_vec_dot(q, b->blade.axis);
  const double along = q1 * b->cos + q3 * b->sin, off = q3 * b->cos - q1 * b->sin;
  const double side = sqrt(off * off + axial * axial) - b->blade.radius;
  return (em_greater(fabs(along) - b->blade.reach, side) - radius) - EM_CLEARLY * b->hull;
}

/* Can ball and blade not close their gap in time? */
static inline bool FN(stays_off_blade)(struct em_turning *turning, const struct em_body *at,
                                       double fall, double content, double rest) {
  const double speed = em_vec_norm(velocity(at)) + fall * rest;
  const double gap = FN(turning_gap)(turning, centre(at), at->radius, at->t);
  return gap > speed * rest + turning->swing * (fabs(at->t - turning->at) + rest) + content;
}

static __attribute__((noinline)) bool FN(predict_blade)(struct em_world *w, uint32_t i, uint32_t k,
                                                        double h) {
  const struct em_body *b = &w->body[i];
  const struct em_blade *blade = &w->blade[k].blade;
  const uint32_t code = EM_SURFACE_BLADE(k);
  const struct em_vec r = centre(b), v = velocity(b);
  const struct em_vec g = WITH(GRAVITY) ? w->gravity : (struct em_vec){0, 0, 0};
  const double angle = blade->angle + blade->omega * b->t;
  const bool touched = w->plan[i].last == code;
  unsigned steps = 0;
  const double dt = WITH(EXTRA) && w->special_roots
                        ? em_surface_roots_blade(&w->scene->engine.roots, blade, r, v, g, b->radius,
                                                 angle, touched, h, &steps)
                        : em_surface_blade(blade, r, v, g, b->radius, angle, touched, h, &steps);
  w->tally.blade_searches++;
  w->tally.blade_steps += steps;
  return FN(enter_surface)(w, i, code, dt);
}

/* Both walls across one axis, from where the ball is now. */
static inline bool FN(meet_walls)(struct em_world *w, uint32_t i, const struct em_body *at,
                                  uint32_t axis, double rest, double h) {
  const struct em_body *b = &w->body[i];
  const double low = em_vec_component(w->low, (int)axis),
               high = em_vec_component(w->high, (int)axis);
  const double g = em_vec_component(w->gravity, (int)axis);
  return FN(stays_between)(em_vec_component(centre(at), (int)axis),
                           em_vec_component(velocity(at), (int)axis), g, at->radius, low, high,
                           rest) ||
         FN(predict_walls)(w, i, axis, em_vec_component(centre(b), (int)axis),
                           em_vec_component(velocity(b), (int)axis), g, low, high, h);
}

/* The chamber's walls. */
static inline bool FN(predict_room)(struct em_world *w, uint32_t i, const struct em_body *at,
                                    double until) {
  const double rest = until - at->t, h = until - w->body[i].t;
  if (w->drum) {
    if (!FN(stays_in_drum)(w, at, rest) && !FN(predict_drum)(w, i, h)) return false;
  } else if (w->walls) {
    if (!FN(meet_walls)(w, i, at, 0, rest, h) || !FN(meet_walls)(w, i, at, 2, rest, h))
      return false;
  }
  return !w->walls || FN(meet_walls)(w, i, at, 1, rest, h);
}

/* How far ahead contacts with surfaces matter. */
static double FN(until)(const struct em_world *w, uint32_t i) {
  return w->keeps_all ? w->plan[i].leave : local_least(w, i);
}

static inline bool FN(meet_blade)(struct em_world *w, uint32_t i, const struct em_body *at,
                                  uint32_t k) {
  const double until = FN(until)(w, i);
  return FN(stays_off_blade)(&w->blade[k], at, WITH(GRAVITY) ? w->fall : 0.0, FN(content)(w),
                             until - at->t) ||
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
