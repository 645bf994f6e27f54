/* Part of loop_template.h, a template: what a contact does to a ball and its partner. */

/* Counts contacts in a row. */
static uint32_t FN(streak)(const struct em_world *w, uint32_t i, double t) {
  return t - w->body[i].t <= w->within && w->plan[i].last != EM_NOBODY ? w->plan[i].streak + 1 : 0;
}

static void FN(advance)(struct em_world *w, uint32_t i, double t) {
  struct em_body *b = &w->body[i];
  FN(fly)(w, b, t);
  if (WITH(PERIODIC)) {
    const struct em_vec x = em_body_wrap(w, centre(b));
    b->x = x.x, b->y = x.y, b->z = x.z;
  }
}

/* What an impulse adds to the velocity of a mass. By division: m (1/m) is not 1, and that error,
 * the same at each contact, would add up. */
static inline struct em_vec FN(kick)(struct em_vec impulse, double mass) {
  return (struct em_vec){impulse.x / mass, impulse.y / mass, impulse.z / mass};
}

static inline void FN(push)(struct em_body *b, double sign, struct em_vec kick) {
  b->vx = b->vx + sign * kick.x;
  b->vy = b->vy + sign * kick.y;
  b->vz = b->vz + sign * kick.z;
}

/* Turns ball i by k e × P_t; returns the spin energy (J) that it gained. */
static inline __attribute__((always_inline)) double FN(spin_up)(struct em_world *w, uint32_t i,
                                                                double m,
                                                                const struct em_contact_law *law,
                                                                struct em_vec twist) {
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
  if (r->elastic_below > 0.0 && vn < r->elastic_below) {
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

/* Two balls meet. Whom they may meet next is looked for, where that can be done in place, when the
 * contact has begun: the processor does it while it waits for roots and quotients. A gain of 1.02
 * in gases, of 1.01 in mills. */
static enum em_status FN(collide_pair)(struct em_world *w, uint32_t one, uint32_t other, double t,
                                       struct candidates *of_one, struct candidates *of_other,
                                       struct em_error *err) {
  const uint32_t i = one < other ? one : other, j = one ^ other ^ i;
  const uint32_t si = FN(streak)(w, i, t), sj = FN(streak)(w, j, t);
  if ((si > sj ? si : sj) >= w->scene->remedy.collapse_after)
    return em_collapse_report(w, si > sj ? i : j, si > sj ? j : i, t, err);
  double since = INFINITY;
  if (WITH(EXTRA)) since = em_lesser(FN(since)(w, i, t), FN(since)(w, j, t));
  FN(advance)(w, i, t);
  FN(advance)(w, j, t);
  const struct em_body *a = &w->body[i], *b = &w->body[j];
  struct em_vec d = {a->x - b->x, a->y - b->y, a->z - b->z};
  if (WITH(PERIODIC)) d = em_body_nearest(w, d);
  const double norm = em_vec_norm(d);
  const struct em_vec e = {d.x / norm, d.y / norm, d.z / norm};
  const struct em_vec u = {a->vx - b->vx, a->vy - b->vy, a->vz - b->vz};
  const struct em_vec g =
      WITH(SPIN) ? em_vec_add(u, em_vec_cross(e, em_vec_add(em_vec_scale(a->radius, w->spin[i]),
                                                            em_vec_scale(b->radius, w->spin[j]))))
                 : u;
  if (w->joins && w->cells) candidates_of_two(w, one, other, of_one, of_other);
  const double mi = w->mass ? w->mass[i] : w->mass0, mj = w->mass ? w->mass[j] : w->mass0;
  const double meff = mi * mj / (mi + mj);
  const struct remedy act = FN(remedy)(w, si > sj ? si : sj, since, -em_vec_dot(g, e));
  const struct em_contact_law *law = &w->scene->contact[EM_CLASS_BALL];
  const struct em_impulse p = FN(impulse)(w, law, meff, e, g, act);
  if (vn_bin(p.vn) == 0 && em_collapse_sticks(w, law, p.vn)) {
    w->clock = t; /* both have come so far */
    return em_collapse_stuck(w, i, j, t, p.vn, err);
  }
  const struct em_vec sum = WITH(SPIN) ? em_vec_add(p.normal, p.tangential) : p.normal;
  double gain = em_vec_dot(sum, u) + 0.5 * em_vec_norm2(sum) / meff;
  const struct em_vec kick = FN(kick)(sum, mi);
  FN(push)(&w->body[i], 1.0, kick);
  FN(push)(&w->body[j], -1.0, w->mass ? FN(kick)(sum, mj) : kick);
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

/* Velocity of a turning drum's wall where a ball of radius r at x touches it along e. */
static struct em_vec FN(drum_velocity)(const struct em_world *w, struct em_vec x, double r,
                                       struct em_vec e) {
  const struct em_vec at = em_vec_axpy(x, -r, e);
  return (struct em_vec){w->drum_omega * at.z, 0.0, -w->drum_omega * at.x};
}

/* Inward normal of the drum. That of the faked ramps (Reichardt 20.1.1): near the top and the
 * bottom it is turned against the ball's motion along x. */
static struct em_vec FN(drum_normal)(const struct em_world *w, const struct em_body *b) {
  const double rho = sqrt(b->x * b->x + b->z * b->z);
  struct em_vec e = {-b->x / rho, 0.0, -b->z / rho};
  if (WITH(EXTRA) && w->facets) return em_body_facet_met(w, centre(b), velocity(b));
  if (WITH(EXTRA) && w->scene->chamber.ramp_tilt != 0.0 &&
      fabs(e.z) > cos(w->scene->chamber.ramp_half)) {
    const double side = (b->vx > 0.0) == (e.z > 0.0) ? -1.0 : 1.0;
    const double s = side * sin(w->scene->chamber.ramp_tilt), c = cos(w->scene->chamber.ramp_tilt);
    const struct em_vec turned = {c * e.x + s * e.z, 0.0, c * e.z - s * e.x};
    const struct em_vec wall = FN(drum_velocity)(w, centre(b), b->radius, turned);
    if (em_vec_dot(turned, em_vec_sub(velocity(b), wall)) < 0.0)
      e = turned; /* else the ball would not come back */
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
  if (WITH(EXTRA) && w->drum_omega != 0.0)
    *surface = FN(drum_velocity)(w, centre(b), b->radius, *e);
  return wall / 2 == 1 ? EM_CLASS_END : EM_CLASS_DRUM;
}

static enum em_status FN(collide_surface)(struct em_world *w, uint32_t i, uint32_t code, double t,
                                          struct em_error *err) {
  const uint32_t si = FN(streak)(w, i, t);
  if (si >= w->scene->remedy.collapse_after) return em_collapse_report(w, i, code, t, err);
  const double since = WITH(EXTRA) ? FN(since)(w, i, t) : INFINITY;
  FN(advance)(w, i, t);
  const struct em_body *b = &w->body[i];
  struct em_vec e, surface;
  const enum em_class cls = FN(meet_surface)(w, i, code, t, &e, &surface);
  const struct em_vec v = velocity(b);
  struct em_vec g = em_vec_sub(v, surface);
  if (WITH(SPIN)) g = em_vec_add(g, em_vec_scale(b->radius, em_vec_cross(e, w->spin[i])));
  const double m = w->mass ? w->mass[i] : w->mass0;
  const struct remedy act = FN(remedy)(w, si, since, -em_vec_dot(g, e));
  const struct em_contact_law *law = &w->scene->contact[cls];
  const struct em_impulse p = FN(impulse)(w, law, m, e, g, act);
  const struct em_vec sum = WITH(SPIN) ? em_vec_add(p.normal, p.tangential) : p.normal;
  double gain = em_vec_dot(sum, v) + 0.5 * em_vec_norm2(sum) / m;
  const double work = em_vec_dot(sum, surface);
  FN(push)(&w->body[i], 1.0, FN(kick)(sum, m));
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
