/* Near-neighbour lists: each ball lives in a sphere of its own (its shell) until it leaves it, and
 * its list holds all balls whose shells come so near that the balls could touch. Shells are placed
 * ahead of the moving ball, and their size adapts to how crowded the place is. Cells serve only to
 * find the shells around a new one.
 *
 * In a drum whose rotor carries the balls round, all shells turn with the balls' mean rotation:
 * their distances stay as they are, and a ball leaves its shell by what it does beyond the common
 * turning only. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "event/fetch.h"
#include "event/neighbours.h"
#include "event/partition.h"
#include "event/shells.h"
#include "event/span.h"
#include "event/vectors.h"

#define AHEAD  0.7  /* of the skin: how far before the ball a shell is placed */
#define KEEP   0.72 /* of the skin: nearer to its centre a shell is kept when its time is up */
#define NARROW 0.2  /* of the widest skin: the narrowest */

enum {
  LIST_LEAST = 16,  /* a list's room is at least this, doubled when full, halved when it can be */
  LIST_CLASSES = 28 /* rooms up to LIST_LEAST << 27 */
};

struct em_places {
  struct em_neighbours lists; /* what the loop asks for */
  uint32_t count;
  uint32_t *mark; /* stamps of the last search */
  uint32_t stamp;
  bool surfaces; /* that there are any */

  size_t pool_used, pool_room;
  uint32_t *spare[LIST_CLASSES]; /* freed pieces by size: positions in the pool */
  size_t spare_count[LIST_CLASSES], spare_room[LIST_CLASSES];

  struct em_shells shells;
  uint32_t *found; /* result of a search */
  uint32_t *gone;  /* scratch: as many as the longest list has room for */
  size_t found_room, gone_room;

  double phase;                 /* rad, their angle at the epoch's start */
  double at, cos, sin;          /* of their angle at the time `at` */
  double now, cos_now, sin_now; /* and at the time last asked for */
  bool may_turn;

  double skin_least, skin_most;
  uint32_t few, many; /* neighbours; beyond them the skin adapts */
};

static bool grow(void **array, size_t size, size_t *room, size_t wanted) {
  size_t more = *room ? *room : 64;
  while (more < wanted)
    more += more / 4;
  void *p = realloc(*array, more * size);
  if (!p) return false;
  memset((char *)p + *room * size, 0, (more - *room) * size);
  *array = p;
  *room = more;
  return true;
}

/* --- lists ------------------------------------------------------------------------------------ */

static unsigned class_of(uint32_t room) {
  unsigned k = 0;
  while (((uint32_t)LIST_LEAST << k) < room)
    k++;
  return k;
}

/* On a cache line's boundary, so that a list of the least room is one line. */
static bool pool_grow(struct em_places *p, size_t wanted) {
  size_t room = p->pool_room;
  while (room < wanted)
    room += room / 4 + LIST_LEAST;
  uint32_t *pool = em_body_array(room, sizeof *pool);
  if (!pool) return false;
  if (p->lists.pool) memcpy(pool, p->lists.pool, p->pool_used * sizeof *pool);
  free(p->lists.pool);
  p->lists.pool = pool;
  p->pool_room = room;
  return true;
}

static bool list_take(struct em_places *p, uint32_t room, uint32_t *at) {
  const unsigned k = class_of(room);
  if (p->spare_count[k]) {
    *at = p->spare[k][--p->spare_count[k]];
    return true;
  }
  if (p->pool_used + room > p->pool_room && !pool_grow(p, p->pool_used + room)) return false;
  *at = (uint32_t)p->pool_used;
  p->pool_used += room;
  return true;
}

/* Moves a list to another room, at least its count. False: no memory, and a list that was to become
 * smaller is as it was. */
static bool list_move(struct em_places *p, struct em_list *l, uint32_t room) {
  const unsigned k = class_of(l->room);
  uint32_t at;
  if (p->spare_count[k] == p->spare_room[k] &&
      !grow((void **)&p->spare[k], sizeof **p->spare, &p->spare_room[k], p->spare_count[k] + 1))
    return false;
  if (!list_take(p, room, &at)) return false;
  memcpy(p->lists.pool + at, p->lists.pool + l->at, l->count * sizeof *p->lists.pool);
  p->spare[k][p->spare_count[k]++] = l->at;
  l->at = at;
  l->room = room;
  return room <= p->gone_room || grow((void **)&p->gone, sizeof *p->gone, &p->gone_room, room);
}

static inline bool list_add(struct em_places *p, uint32_t i, uint32_t j) {
  struct em_list *l = &p->lists.of[i].list;
  if (l->count == l->room && !list_move(p, l, 2 * l->room)) return false;
  p->lists.pool[l->at + l->count++] = j;
  return true;
}

/* Four entries at a time: where one stands cannot be foretold, and a wrong guess costs more. */
static inline void list_drop(struct em_places *p, uint32_t i, uint32_t j) {
  struct em_list *l = &p->lists.of[i].list;
  uint32_t *e = p->lists.pool + l->at;
  uint32_t k = 0;
  unsigned here;
  while (!(here = v4i_bits(*(const v4i *)(e + k) == (int)j)))
    k += 4;
  e[k + (uint32_t)__builtin_ctz(here)] = e[--l->count];
}

/* --- shells ----------------------------------------------------------------------------------- */

/* Sets the cosine and sine of the shells' angle at time t, to 1e-12: from those of a time nearby,
 * which are renewed every few thousandths of a turn. */
static void shells_turn(struct em_places *p, double t) {
  double d = p->lists.omega * (t - p->at);
  if (!(fabs(d) < 0.02)) {
    const double angle = p->phase + p->lists.omega * t;
    p->at = t;
    p->cos = cos(angle);
    p->sin = sin(angle);
    d = 0.0;
  }
  const double d2 = d * d;
  const double cd = 1.0 - d2 * (0.5 - d2 * (1.0 / 24.0));
  const double sd = d * (1.0 - d2 * (1.0 / 6.0 - d2 * (1.0 / 120.0)));
  p->now = t;
  p->cos_now = p->cos * cd - p->sin * sd;
  p->sin_now = p->sin * cd + p->cos * sd;
}

/* Turns the position and velocity of a ball at time t to what is seen from the shells. */
static void turn_to_shells(struct em_places *p, double t, struct em_vec *x, struct em_vec *v) {
  if (t != p->now) shells_turn(p, t);
  const double c = p->cos_now, s = p->sin_now;
  const double u = v->x - p->lists.omega * x->z, m = v->z + p->lists.omega * x->x;
  *x = em_vec_make(c * x->x - s * x->z, x->y, s * x->x + c * x->z);
  *v = em_vec_make(c * u - s * m, v->y, s * u + c * m);
}

static struct em_two twice(struct em_vec v) {
  return (struct em_two){{v.x, v.x}, {v.y, v.y}, {v.z, v.z}};
}

static bool is_periodic(const struct em_world *w) {
  return w->per_period.x + w->per_period.y + w->per_period.z != 0.0;
}

/* Until when a ball that is seen at x with velocity v at the time `from` surely stays in shell s.
 * `fast2`: its squared speed in the frame of the scene. Its path is bent by gravity, and, seen from
 * turning shells, by 2 Ω |v| + Ω² ρ, ρ up to the corners of a drum with facets, together less than
 * `bend`. */
static double stay(const struct em_world *w, const struct em_shell *s, double from, struct em_vec x,
                   struct em_vec v, double fast2) {
  const double bend = w->lists->bend + w->lists->bend_per_speed2 * fast2;
  return from + em_neighbours_stay(w, s, s, twice(x), twice(v), (v2d){bend, bend}, bend > 0.0,
                                   is_periodic(w))[0];
}

/* What bends a path at most: a speed u is less than (u²/a + a)/2 for any a, and gravity adds to it
 * less than √(2 · rest of the skin · g) before the ball is out. */
static void set_bend(const struct em_world *w, struct em_places *p, double usual_speed) {
  const double turn = fabs(p->lists.omega), reach = em_scene_reach(w->scene);
  const double a = fmax(usual_speed, 1e-3 * turn * reach);
  const double fallen = sqrt(2.0 * (1.0 - EM_NEIGHBOURS_STRAIGHT) * p->skin_most * w->fall);
  p->lists.bend = w->fall;
  p->lists.bend_per_speed2 = 0.0;
  if (turn == 0.0) return;
  p->lists.bend += turn * turn * reach + 2.0 * turn * (fallen + 0.5 * a);
  p->lists.bend_per_speed2 = turn / a;
}

/* Walls and blades that a ball can touch while its shell stays where it is, or turns about the
 * drum's axis; `reach`: how far from the shell's centre its surface can be. */
static uint32_t surfaces_near(const struct em_world *w, const struct em_shell *s, double reach) {
  const double x = (double)s->centre[0], y = (double)s->centre[1], z = (double)s->centre[2];
  const double r = reach * (1.0 + 1e-6) + w->content, in = w->rho - r;
  uint32_t near = em_partition_blades(w, em_vec_make(x, y, z), r, em_vec_make(0.0, 0.0, 0.0));
  if (w->drum && !(in > 0.0 && x * x + z * z < in * in)) near |= EM_NEAR_WALL;
  if (w->wall[0] && !(x - r > w->low.x && x + r < w->high.x)) near |= EM_NEAR_WALL;
  if (w->wall[2] && !(y - r > w->low.y && y + r < w->high.y)) near |= EM_NEAR_WALL;
  if (w->wall[4] && !(z - r > w->low.z && z + r < w->high.z)) near |= EM_NEAR_WALL;
  return near;
}

/* Leave times are lower bounds, and often a ball is still well inside its shell: then it stays
 * there, and the time is set anew. */
static bool shell_keeps(struct em_world *w, struct em_places *p, uint32_t i, double now) {
  struct em_vec x = em_body_at(w, i, now), v = em_body_velocity(w, i, now);
  const double fast2 = em_vec_norm2(v);
  if (p->lists.omega != 0.0) turn_to_shells(p, now, &x, &v);
  const struct em_shell *s = &p->lists.of[i].shell;
  const struct em_two o = em_neighbours_offset(w, s, s, twice(x), is_periodic(w));
  const double inside = KEEP * (double)s->skin;
  if (em_two_dot(o, o)[0] > inside * inside) return false;
  w->plan[i].leave = stay(w, s, now, x, v, fast2);
  return true;
}

/* Places the shell of ball i at time `now`, ahead of it in its direction. */
static void shell_place(struct em_world *w, struct em_places *p, uint32_t i, double now) {
  struct em_vec x = em_body_at(w, i, now), v = em_body_velocity(w, i, now);
  const double fast2 = em_vec_norm2(v);
  if (p->lists.omega != 0.0) turn_to_shells(p, now, &x, &v);
  const double speed2 = em_vec_norm2(v);
  struct em_shell *s = &p->lists.of[i].shell;
  const double ahead = speed2 > 0.0 ? AHEAD * (double)s->skin / sqrt(speed2) : 0.0;
  const struct em_vec c = em_body_wrap(w, em_vec_axpy(x, ahead, v));
  s->centre[0] = (float)c.x;
  s->centre[1] = (float)c.y;
  s->centre[2] = (float)c.z;
  w->plan[i].leave = stay(w, s, now, x, v, fast2);
  if (p->surfaces) w->plan[i].near = surfaces_near(w, s, w->body[i].radius + (double)s->skin);
}

static float hull_of(const struct em_world *w, uint32_t i) {
  return w->places->lists.of[i].shell.skin + (float)w->body[i].radius;
}

/* All shells near that of ball i go to p->found, with room behind them up to a multiple of eight;
 * false: no memory. */
static bool search(const struct em_world *w, struct em_places *p, uint32_t i, uint32_t *count) {
  for (;;) {
    const uint32_t most = (uint32_t)p->found_room / 8 * 8;
    *count = em_shells_find(&p->shells, p->lists.of[i].shell.centre, hull_of(w, i), p->found, most);
    if (*count < most) return true;
    if (!grow((void **)&p->found, sizeof *p->found, &p->found_room, 2 * p->found_room + 64))
      return false;
  }
}

static uint32_t next_stamp(struct em_places *p) {
  if (p->stamp > UINT32_MAX - 4) {
    memset(p->mark, 0, p->count * sizeof *p->mark);
    p->stamp = 0;
  }
  return p->stamp += 2;
}

/* Takes ball i out of the lists of those that were near and are no longer, and leaves in p->found
 * those that have come near; returns how many. What each is cannot be foretold: no branches. */
static uint32_t exchange(struct em_places *p, uint32_t i, uint32_t found) {
  struct em_list *l = &p->lists.of[i].list;
  uint32_t *mark = p->mark, *old = p->lists.pool + l->at, *gone = p->gone;
  const uint32_t was = next_stamp(p), stays = was + 1;
  for (uint32_t k = 0; k < l->count; k++) {
    mark[old[k]] = was;
    __builtin_prefetch(&p->lists.of[old[k]].list);
  }
  uint32_t come = 0, left = 0, go = 0;
  for (uint32_t k = 0; k < found; k++) {
    const uint32_t j = p->found[k], near = mark[j] == was;
    mark[j] += near;
    p->found[come] = j;
    come += !near;
    __builtin_prefetch(&p->lists.of[j].list);
  }
  for (uint32_t k = 0; k < l->count; k++) {
    const uint32_t j = old[k], keep = mark[j] == stays;
    old[left] = gone[go] = j;
    left += keep;
    go += !keep;
  }
  l->count = left;
  for (uint32_t k = 0; k < go; k++)
    __builtin_prefetch(p->lists.pool + p->lists.of[gone[k]].list.at);
  for (uint32_t k = 0; k < come; k++)
    __builtin_prefetch(p->lists.pool + p->lists.of[p->found[k]].list.at);
  for (uint32_t k = 0; k < go; k++)
    list_drop(p, gone[k], i);
  return come;
}

static const uint32_t *cross(struct em_world *w, uint32_t i, double now, uint32_t *count) {
  struct em_places *p = w->places;
  struct em_list *l = &p->lists.of[i].list;
  struct em_shell *s = &p->lists.of[i].shell;
  *count = 0;
  if (shell_keeps(w, p, i, now)) return p->found;
  if (l->count > p->many)
    s->skin = fmaxf(0.9f * s->skin, (float)p->skin_least);
  else if (l->count < p->few)
    s->skin = fminf(1.1f * s->skin, (float)p->skin_most);
  em_shells_quit(&p->shells, i);
  shell_place(w, p, i, now);
  uint32_t found;
  if (!search(w, p, i, &found)) goto memory;
  *count = exchange(p, i, found);
  if (l->room > LIST_LEAST && l->count + *count <= l->room / 2)
    (void)list_move(p, l, l->room / 2); /* or it stays as it is, where memory is short */
  for (uint32_t k = 0; k < *count; k++)
    if (!list_add(p, i, p->found[k]) || !list_add(p, p->found[k], i)) goto memory;
  if (!em_shells_enter(&p->shells, i, s->centre, hull_of(w, i))) goto memory;
  return p->found;
memory:
  *count = 1;
  return NULL;
}

static const uint32_t *candidates(struct em_world *w, uint32_t i, uint32_t *count) {
  const struct em_list *l = &w->places->lists.of[i].list;
  *count = l->count;
  return w->places->lists.pool + l->at;
}

static void moved(struct em_world *w, uint32_t i) {
  struct em_places *p = w->places;
  const struct em_body *b = &w->body[i];
  struct em_vec x = {b->x, b->y, b->z}, v = {b->vx, b->vy, b->vz};
  const double fast2 = em_vec_norm2(v);
  if (p->lists.omega != 0.0) turn_to_shells(p, b->t, &x, &v);
  w->plan[i].leave = stay(w, &p->lists.of[i].shell, b->t, x, v, fast2);
}

static void fetch(const struct em_world *w, uint32_t i, bool beyond, bool leaves) {
  const struct em_places *p = w->places;
  em_neighbours_fetch(&p->lists, i, beyond);
  if (!beyond)
    em_fetch(&p->shells.cell[i]);
  else if (leaves)
    em_shells_fetch(&p->shells, p->lists.of[i].shell.centre, hull_of(w, i));
}

/* --- making ----------------------------------------------------------------------------------- */

/* Skin in diameters of the largest ball, from the packing fraction: where balls hardly meet, a wide
 * shell saves crossings; where they crowd, a narrow one saves candidates. A rotor throws the balls
 * outwards, so that they crowd more than the fraction says. Measured. */
static double skin_for(const struct em_world *w) {
  if (w->scene->engine.skin > 0.0) return w->scene->engine.skin;
  const double phi = fmax(em_partition_fraction(w), 1e-3);
  return fmin(1.0, w->blade_count ? 0.18 / cbrt(phi) : 0.177 / sqrt(phi));
}

/* In a periodic box the image that is nearest at a prediction has to be the one that is met: until
 * a ball leaves its shell it moves by two skins at the most, a pair by four. And of two that are
 * candidates already, whose shells are near each other but for the slack, no new shell asks anew.
 */
static double skin_most(const struct em_world *w) {
  const double slack = em_shells_slack(w->low, w->high);
  return fmin(skin_for(w) * 2.0 * w->largest, fmax(0.0, em_span_room(w) - 0.25 * slack));
}

/* Rounding of a shell's centre may take half of what its ball has left of the straight part. */
static bool fits(const struct em_world *w, double most) {
  const double least = NARROW * most, rounding = 0.5 * (EM_NEIGHBOURS_STRAIGHT - AHEAD) * least;
  return w->count == 0 || em_shells_resolve(w->low, w->high, rounding, least + w->smallest);
}

bool em_partition_neighbours_fit(const struct em_world *w) {
  return fits(w, skin_most(w));
}

static void free_places(struct em_places *p) {
  if (!p) return;
  for (int k = 0; k < LIST_CLASSES; k++)
    free(p->spare[k]);
  free(p->lists.of);
  free(p->mark);
  free(p->lists.pool);
  free(p->found);
  free(p->gone);
  em_shells_release(&p->shells);
  free(p);
}

static bool take_arrays(const struct em_world *w, struct em_places *p) {
  p->lists.of = em_body_array(w->count, sizeof *p->lists.of);
  p->mark = em_body_array(w->count, sizeof *p->mark);
  p->surfaces = w->drum || w->walls || w->blade_count;
  return p->lists.of && p->mark &&
         grow((void **)&p->gone, sizeof *p->gone, &p->gone_room, LIST_LEAST) &&
         em_shells_init(&p->shells, w->count, w->low, w->high, w->period, p->skin_most + w->largest,
                        w->loop->lanes >= 4);
}

/* Enters the balls one by one; each finds those entered before. */
static bool fill(struct em_world *w, struct em_places *p) {
  for (uint32_t i = 0; i < w->count; i++) {
    shell_place(w, p, i, w->clock);
    uint32_t count;
    if (!search(w, p, i, &count)) return false;
    for (uint32_t k = 0; k < count; k++)
      if (!list_add(p, i, p->found[k]) || !list_add(p, p->found[k], i)) return false;
    if (!em_shells_enter(&p->shells, i, p->lists.of[i].shell.centre, hull_of(w, i))) return false;
  }
  return true;
}

static bool first_fill(struct em_world *w, struct em_places *p) {
  for (uint32_t i = 0; i < w->count; i++) {
    struct em_list *l = &p->lists.of[i].list;
    p->lists.of[i].shell.skin = (float)p->skin_most;
    l->room = LIST_LEAST;
    if (!list_take(p, l->room, &l->at)) return false;
  }
  return fill(w, p);
}

/* Shells can turn with the balls about the drum's axis, as long as that is every blade's axis. */
static bool may_turn(const struct em_world *w) {
  if (!w->drum || !w->blade_count) return false;
  for (uint32_t k = 0; k < w->blade_count; k++) {
    const struct em_blade *b = &w->blade[k].blade;
    if (fabs(b->axis.y) < 1.0 || b->centre.x != 0.0 || b->centre.z != 0.0) return false;
  }
  return true;
}

/* Angular velocity of the balls' mean rotation about the drum's axis, and what moves beyond it. */
static double mean_rotation(const struct em_world *w, double *rest) {
  double momentum = 0.0, inertia = 0.0, square = 0.0;
  for (uint32_t i = 0; i < w->count; i++) {
    const struct em_vec x = em_body_at(w, i, w->clock), v = em_body_velocity(w, i, w->clock);
    momentum += x.z * v.x - x.x * v.z;
    inertia += x.x * x.x + x.z * x.z;
    square += em_vec_norm2(v);
  }
  const double omega = inertia > 0.0 ? momentum / inertia : 0.0;
  *rest = w->count ? sqrt(fmax(0.0, square - omega * momentum) / w->count) : 0.0;
  return omega;
}

/* At a new epoch: the shells' angle goes on; when the balls turn at another speed by now, all
 * shells are placed anew. */
static bool renew(struct em_world *w) {
  struct em_places *p = w->places;
  if (!p->may_turn) return true;
  p->phase = fmod(p->phase + p->lists.omega * w->epoch_length, 2.0 * M_PI);
  p->at = p->now = NAN;
  double rest;
  const double omega = mean_rotation(w, &rest);
  if (fabs(omega - p->lists.omega) * w->rho < 0.25 * rest) return true;
  p->lists.omega = omega;
  p->phase = 0.0;
  set_bend(w, p, hypot(rest, omega * w->rho));
  em_shells_clear(&p->shells);
  for (uint32_t i = 0; i < w->count; i++)
    p->lists.of[i].list.count = 0;
  return fill(w, p);
}

static enum em_status make(struct em_world *w, struct em_error *err) {
  const double most = skin_most(w);
  if (!fits(w, most))
    return em_error_set(err, EM_INPUT, w->scene->file, 0,
                        "engine.partition: \"neighbours\" keeps places in single precision, too "
                        "coarse for skins of %.3g m in a chamber of %.3g m, expected \"auto\", "
                        "\"cells\", \"slices\" or \"none\"",
                        NARROW * most, em_vec_norm(em_vec_sub(w->high, w->low)));
  struct em_places *p = calloc(1, sizeof *p);
  if (!p) return em_error_set(err, EM_MEMORY, NULL, 0, "no memory for the neighbour lists");
  p->count = w->count;
  p->skin_most = most;
  p->skin_least = NARROW * most;
  p->few = 12;
  p->many = 28;
  w->places = p;
  w->lists = &p->lists;
  p->may_turn = may_turn(w);
  w->early = p->may_turn ? 0.0 : 0.1 * p->skin_least;
  p->at = p->now = NAN;
  double rest = 0.0;
  if (p->may_turn) p->lists.omega = mean_rotation(w, &rest);
  set_bend(w, p, hypot(rest, p->lists.omega * w->rho));
  if (!take_arrays(w, p) || !first_fill(w, p)) {
    w->places = NULL;
    w->lists = NULL;
    free_places(p);
    return em_error_set(err, EM_MEMORY, NULL, 0, "no memory for the neighbour lists");
  }
  return EM_OK;
}

static size_t bytes(const struct em_places *p) {
  size_t sum = p->count * (sizeof *p->lists.of + sizeof *p->mark) +
               p->pool_room * sizeof *p->lists.pool +
               (p->found_room + p->gone_room) * sizeof *p->found;
  for (int k = 0; k < LIST_CLASSES; k++)
    sum += p->spare_room[k] * sizeof **p->spare;
  return sum + em_shells_bytes(&p->shells);
}

/* Every entry has its mirror image, every shell is in its cell. */
static bool is_valid(const struct em_world *w) {
  const struct em_places *p = w->places;
  for (uint32_t i = 0; i < p->count; i++) {
    const struct em_list *l = &p->lists.of[i].list;
    if (!em_shells_holds(&p->shells, i, p->lists.of[i].shell.centre)) return false;
    for (uint32_t k = 0; k < l->count; k++) {
      const struct em_list *m = &p->lists.of[p->lists.pool[l->at + k]].list;
      uint32_t seen = 0;
      for (uint32_t h = 0; h < m->count; h++)
        seen += p->lists.pool[m->at + h] == i;
      if (seen != 1) return false;
    }
  }
  return true;
}

const struct em_partition_kind em_partition_neighbours = {
    .name = "neighbours",
    .make = make,
    .free = free_places,
    .candidates = candidates,
    .lasting = true,
    .moved = moved,
    .cross = cross,
    .renew = renew,
    .fetch = fetch,
    .bytes = bytes,
    .is_valid = is_valid,
};
