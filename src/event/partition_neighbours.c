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
#ifdef __SSE2__
#include <emmintrin.h>
#endif

#include "event/partition.h"

enum {
  CELL_STEP = 8,    /* a cell's room grows in steps of this many shells */
  LIST_LEAST = 16,  /* a list's room is at least this, doubled when full */
  LIST_CLASSES = 28 /* rooms up to LIST_LEAST << 27 */
};

/* The sphere in which a ball stays until world.leave. Single precision: the centre is what it says,
 * exactly; `slack` covers the rounding of distances. */
struct shell {
  float x, y, z;
  float skin; /* m: room for the ball's centre */
};

struct list {
  uint32_t at; /* first entry in the pool */
  uint32_t count, room;
};

struct em_places {
  uint32_t count;
  struct shell *shell;
  struct list *list;
  uint32_t *cell; /* of each ball */
  uint32_t *mark; /* stamps of the last search */
  uint32_t stamp;
  uint32_t *blades; /* NULL without blades */

  uint32_t *pool; /* of all lists */
  size_t pool_used, pool_room;
  uint32_t *spare[LIST_CLASSES]; /* freed pieces by size: positions in the pool */
  size_t spare_count[LIST_CLASSES], spare_room[LIST_CLASSES];

  uint32_t *fresh; /* result of a crossing */
  size_t fresh_room;

  int n[3];        /* cells */
  double edge[3];  /* m */
  struct em_vec low;
  uint32_t room;   /* shells per cell, a multiple of CELL_STEP */
  uint32_t *held;  /* shells in each cell */
  float *entry;    /* per cell: x[room], y[room], z[room], hull[room] */
  uint32_t *id;    /* per cell: id[room] */

  double omega;    /* rad/s of the shells about the drum's axis */
  double phase;    /* rad, their angle at the epoch's start */
  double at, cos, sin; /* of their angle at the time `at` */
  bool may_turn;

  float period[3];
  float slack;
  double skin_least, skin_most, ahead;
  uint32_t few, many; /* neighbours; beyond them the skin adapts */
};

static size_t cells(const struct em_places *p) {
  return (size_t)p->n[0] * (size_t)p->n[1] * (size_t)p->n[2];
}

static bool grow(void **array, size_t size, size_t *room, size_t wanted) {
  size_t more = *room ? *room : 64;
  while (more < wanted) more *= 2;
  void *p = realloc(*array, more * size);
  if (!p) return false;
  *array = p;
  *room = more;
  return true;
}

/* --- lists ------------------------------------------------------------------------------------ */

static unsigned class_of(uint32_t room) {
  unsigned k = 0;
  while (((uint32_t)LIST_LEAST << k) < room) k++;
  return k;
}

static bool list_take(struct em_places *p, uint32_t room, uint32_t *at) {
  const unsigned k = class_of(room);
  if (p->spare_count[k]) {
    *at = p->spare[k][--p->spare_count[k]];
    return true;
  }
  if (p->pool_used + room > p->pool_room &&
      !grow((void **)&p->pool, sizeof *p->pool, &p->pool_room, p->pool_used + room))
    return false;
  *at = (uint32_t)p->pool_used;
  p->pool_used += room;
  return true;
}

static bool list_widen(struct em_places *p, struct list *l) {
  const unsigned k = class_of(l->room);
  uint32_t at;
  if (!list_take(p, 2 * l->room, &at)) return false;
  memcpy(p->pool + at, p->pool + l->at, l->count * sizeof *p->pool);
  if (p->spare_count[k] == p->spare_room[k] &&
      !grow((void **)&p->spare[k], sizeof **p->spare, &p->spare_room[k], p->spare_count[k] + 1))
    return false;
  p->spare[k][p->spare_count[k]++] = l->at;
  l->at = at;
  l->room *= 2;
  return true;
}

static inline bool list_add(struct em_places *p, uint32_t i, uint32_t j) {
  struct list *l = &p->list[i];
  if (l->count == l->room && !list_widen(p, l)) return false;
  p->pool[l->at + l->count++] = j;
  return true;
}

static inline void list_drop(struct em_places *p, uint32_t i, uint32_t j) {
  struct list *l = &p->list[i];
  uint32_t *e = p->pool + l->at;
  uint32_t k = 0;
  while (e[k] != j) k++;
  e[k] = e[--l->count];
}

/* --- cells ------------------------------------------------------------------------------------ */

static int cell_along(const struct em_places *p, int axis, double x) {
  const int n = p->n[axis], k = (int)floor(x / p->edge[axis]);
  return k < 0 ? 0 : k >= n ? n - 1 : k;
}

static uint32_t cell_of(const struct em_places *p, const struct shell *s) {
  const int a = cell_along(p, 0, (double)s->x - p->low.x);
  const int b = cell_along(p, 1, (double)s->y - p->low.y);
  const int c = cell_along(p, 2, (double)s->z - p->low.z);
  return (uint32_t)(a + p->n[0] * (b + p->n[1] * c));
}

/* Doubles the room of every cell. */
static bool cells_widen(struct em_places *p) {
  const uint32_t old = p->room, room = old ? 2 * old : CELL_STEP;
  const size_t n = cells(p);
  float *entry = em_body_array(n * 4 * room, sizeof *entry);
  uint32_t *id = em_body_array(n * room, sizeof *id);
  if (!entry || !id) {
    free(entry);
    free(id);
    return false;
  }
  for (size_t c = 0; old && c < n; c++) {
    for (size_t k = 0; k < 4; k++)
      memcpy(entry + (c * 4 + k) * room, p->entry + (c * 4 + k) * old, old * sizeof *entry);
    memcpy(id + c * room, p->id + c * old, old * sizeof *id);
  }
  free(p->entry);
  free(p->id);
  p->entry = entry;
  p->id = id;
  p->room = room;
  return true;
}

static float hull_of(const struct em_world *w, const struct em_places *p, uint32_t i) {
  return p->shell[i].skin + (float)w->body[i].radius;
}

static bool cell_enter(struct em_world *w, struct em_places *p, uint32_t i) {
  const uint32_t c = cell_of(p, &p->shell[i]);
  if (p->held[c] == p->room && !cells_widen(p)) return false;
  const uint32_t k = p->held[c]++, room = p->room;
  float *e = p->entry + (size_t)c * 4 * room;
  e[k] = p->shell[i].x;
  e[room + k] = p->shell[i].y;
  e[2 * room + k] = p->shell[i].z;
  e[3 * room + k] = hull_of(w, p, i);
  p->id[(size_t)c * room + k] = i;
  p->cell[i] = c;
  return true;
}

static void cell_quit(struct em_places *p, uint32_t i) {
  const uint32_t c = p->cell[i], room = p->room, last = --p->held[c];
  float *e = p->entry + (size_t)c * 4 * room;
  uint32_t *id = p->id + (size_t)c * room, k = 0;
  while (id[k] != i) k++;
  for (uint32_t f = 0; f < 4; f++) e[f * room + k] = e[f * room + last];
  id[k] = id[last];
}

/* --- shells ----------------------------------------------------------------------------------- */

static double wrapped(double x, double low, double period) {
  return period > 0.0 ? x - period * floor((x - low) / period) : x;
}

/* Position and velocity of ball i at time t, as seen from the shells. */
static void seen(const struct em_world *w, struct em_places *p, uint32_t i, double t,
                 struct em_vec *x, struct em_vec *v) {
  *x = em_body_at(w, i, t);
  *v = em_body_velocity(w, i, t);
  if (p->omega == 0.0) return;
  if (t != p->at) {
    const double angle = p->phase + p->omega * t;
    p->at = t;
    p->cos = cos(angle);
    p->sin = sin(angle);
  }
  const double c = p->cos, s = p->sin;
  const double u = v->x - p->omega * x->z, m = v->z + p->omega * x->x;
  *x = em_vec_make(c * x->x - s * x->z, x->y, s * x->x + c * x->z);
  *v = em_vec_make(c * u - s * m, v->y, s * u + c * m);
}

static double nearest(double d, double period) {
  return period > 0.0 ? d - period * nearbyint(d / period) : d;
}

/* Until when a ball that is seen at x with velocity v at the time `from` surely stays in shell s.
 * Its straight path may use a part of the skin, what bends the path the rest: gravity, and, seen
 * from turning shells, |2 Ω × v| + Ω² ρ, all less than `bend`. */
static double stay(const struct em_world *w, const struct em_places *p, const struct shell *s,
                   double from, struct em_vec x, struct em_vec v) {
  const double share = 0.8, skin = (double)s->skin, vv = em_vec_norm2(v);
  const double turn = fabs(p->omega);
  double bend = w->fall;
  if (turn > 0.0)
    bend += 2.0 * turn * (sqrt(vv) + sqrt(2.0 * (1.0 - share) * skin * w->fall)) +
            3.0 * turn * turn * w->rho;
  const double room = bend > 0.0 ? share * skin : 0.999999 * skin;
  const struct em_vec o = {nearest(x.x - (double)s->x, w->period.x),
                           nearest(x.y - (double)s->y, w->period.y),
                           nearest(x.z - (double)s->z, w->period.z)};
  const double b = em_vec_dot(o, v), c = room * room - em_vec_norm2(o);
  double time;
  if (c <= 0.0) {
    const double disc = b * b + vv * c;
    time = b < 0.0 && disc > 0.0 ? (sqrt(disc) - b) / vv : 0.0;
  } else {
    const double root = sqrt(b * b + vv * c);
    time = b > 0.0 ? c / (b + root) : vv > 0.0 ? (root - b) / vv : INFINITY;
  }
  if (bend > 0.0) time = fmin(time, sqrt(2.0 * (1.0 - share) * skin / bend));
  return from + time;
}

/* Places the shell of ball i at time `now`, ahead of it in its direction. */
static void shell_place(struct em_world *w, struct em_places *p, uint32_t i, double now) {
  struct em_vec x, v;
  seen(w, p, i, now, &x, &v);
  const double speed2 = em_vec_norm2(v);
  struct shell *s = &p->shell[i];
  const double ahead = speed2 > 0.0 ? p->ahead * (double)s->skin / sqrt(speed2) : 0.0;
  const struct em_vec c = em_vec_axpy(x, ahead, v);
  s->x = (float)wrapped(c.x, w->low.x, w->period.x);
  s->y = (float)wrapped(c.y, w->low.y, w->period.y);
  s->z = (float)wrapped(c.z, w->low.z, w->period.z);
  w->leave[i] = stay(w, p, s, now, x, v);
  if (!p->blades) return;
  const struct em_vec centre = {(double)s->x, (double)s->y, (double)s->z};
  p->blades[i] = em_partition_blades(w, centre, w->body[i].radius, (double)s->skin);
}

/* The cells along one axis that a sphere can touch, each with the shift that brings its periodic
 * image to the sphere, and the least distance between the two. */
struct row {
  int cell[3];
  float shift[3], apart2[3];
  int count;
  bool whole; /* a short periodic edge: the nearest image has to be chosen shell by shell */
};

static struct row row_of(const struct em_places *p, int axis, double x, double reach) {
  const int n = p->n[axis];
  const double e = p->edge[axis], period = (double)p->period[axis];
  int a = (int)floor((x - reach) / e), b = (int)floor((x + reach) / e);
  struct row row = {.whole = period > 0.0 && n < 3};
  if (row.whole) {
    a = 0;
    b = n - 1;
  } else if (period == 0.0) {
    a = a < 0 ? 0 : a >= n ? n - 1 : a;
    b = b < 0 ? 0 : b >= n ? n - 1 : b;
  }
  for (int k = a; k <= b && row.count < 3; k++) {
    const bool edge = period == 0.0 && (k == 0 || k == n - 1); /* holds all beyond it as well */
    const double apart = row.whole || edge ? 0.0 : fmax(0.0, fmax(k * e - x, x - (k + 1) * e));
    row.cell[row.count] = k < 0 ? k + n : k >= n ? k - n : k;
    row.shift[row.count] = (float)(k < 0 ? -period : k >= n ? period : 0.0);
    row.apart2[row.count++] = (float)(apart * apart);
  }
  return row;
}

typedef float v4f __attribute__((vector_size(16)));
typedef int32_t v4i __attribute__((vector_size(16)));

static inline unsigned bits_of(v4i mask) {
#ifdef __SSE2__
  return (unsigned)_mm_movemask_ps((__m128)mask);
#else
  return (mask[0] & 1u) | (mask[1] & 2u) | (mask[2] & 4u) | (mask[3] & 8u);
#endif
}

static inline v4f nearest_image(v4f d, float period) {
  for (int k = 0; period > 0.0f && k < 4; k++) d[k] -= period * rintf(d[k] / period);
  return d;
}

/* Shells k … k+3 of a cell that come within reach of the centre x, y, z, as bits. */
static inline unsigned within(const struct em_places *p, const float *e, uint32_t k, float x,
                              float y, float z, float hull, bool whole) {
  const uint32_t room = p->room;
  v4f dx = *(const v4f *)(e + k) - x, dy = *(const v4f *)(e + room + k) - y;
  v4f dz = *(const v4f *)(e + 2 * room + k) - z;
  const v4f r = *(const v4f *)(e + 3 * room + k) + hull;
  if (whole) {
    dx = nearest_image(dx, p->period[0]);
    dy = nearest_image(dy, p->period[1]);
    dz = nearest_image(dz, p->period[2]);
  }
  return bits_of(dx * dx + dy * dy + dz * dz <= r * r);
}

/* Finds every shell within reach of ball i's: those stamped kept - 1 are stamped kept, the others
 * go to `fresh`. Returns false when memory is short. */
static bool search(const struct em_world *w, struct em_places *p, uint32_t i, uint32_t kept,
                   uint32_t *count) {
  const struct shell s = p->shell[i];
  const float hull = hull_of(w, p, i) + p->slack;
  const double reach = (double)hull + p->skin_most + w->largest + (double)p->slack;
  const float reach2 = (float)(1.00001 * reach * reach);
  const struct row rx = row_of(p, 0, (double)s.x - p->low.x, reach);
  const struct row ry = row_of(p, 1, (double)s.y - p->low.y, reach);
  const struct row rz = row_of(p, 2, (double)s.z - p->low.z, reach);
  const bool whole = rx.whole || ry.whole || rz.whole;
  for (int c = 0; c < rz.count; c++) {
    for (int b = 0; b < ry.count; b++) {
      const int line = p->n[0] * (p->n[1] * rz.cell[c] + ry.cell[b]);
      const float apart2 = rz.apart2[c] + ry.apart2[b];
      for (int a = 0; a < rx.count; a++) {
        if (apart2 + rx.apart2[a] > reach2) continue;
        const size_t cell = (size_t)(line + rx.cell[a]);
        const uint32_t held = p->held[cell];
        const float *e = p->entry + cell * 4 * p->room;
        const uint32_t *id = p->id + cell * p->room;
        if (*count + held > p->fresh_room &&
            !grow((void **)&p->fresh, sizeof *p->fresh, &p->fresh_room, *count + held))
          return false;
        for (uint32_t k = 0; k < held; k += 4) {
          unsigned near = within(p, e, k, s.x - rx.shift[a], s.y - ry.shift[b],
                                 s.z - rz.shift[c], hull, whole);
          if (held - k < 4) near &= (1u << (held - k)) - 1u;
          for (; near; near &= near - 1) {
            const uint32_t j = id[k + (uint32_t)__builtin_ctz(near)];
            if (p->mark[j] == kept - 1)
              p->mark[j] = kept;
            else
              p->fresh[(*count)++] = j;
          }
        }
      }
    }
  }
  return true;
}

static uint32_t next_stamp(struct em_places *p) {
  if (p->stamp > UINT32_MAX - 4) {
    memset(p->mark, 0, p->count * sizeof *p->mark);
    p->stamp = 0;
  }
  return p->stamp += 2;
}

static const uint32_t *cross(struct em_world *w, uint32_t i, double now, uint32_t *count) {
  struct em_places *p = w->places;
  struct list *l = &p->list[i];
  struct shell *s = &p->shell[i];
  if (l->count > p->many)
    s->skin = fmaxf(0.9f * s->skin, (float)p->skin_least);
  else if (l->count < p->few)
    s->skin = fminf(1.1f * s->skin, (float)p->skin_most);
  cell_quit(p, i);
  shell_place(w, p, i, now);
  const uint32_t kept = next_stamp(p);
  for (uint32_t k = 0; k < l->count; k++) p->mark[p->pool[l->at + k]] = kept - 1;
  *count = 0;
  if (!search(w, p, i, kept, count)) goto memory;
  for (uint32_t k = 0; k < l->count;) {
    const uint32_t j = p->pool[l->at + k];
    if (p->mark[j] == kept) {
      k++;
    } else {
      list_drop(p, j, i);
      p->pool[l->at + k] = p->pool[l->at + --l->count];
    }
  }
  for (uint32_t k = 0; k < *count; k++)
    if (!list_add(p, i, p->fresh[k]) || !list_add(p, p->fresh[k], i)) goto memory;
  if (!cell_enter(w, p, i)) goto memory;
  return p->fresh;
memory:
  *count = 1;
  return NULL;
}

static const uint32_t *candidates(struct em_world *w, uint32_t i, uint32_t *count) {
  const struct list *l = &w->places->list[i];
  *count = l->count;
  return w->places->pool + l->at;
}

static void moved(struct em_world *w, uint32_t i) {
  struct em_vec x, v;
  const double t = w->body[i].t;
  seen(w, w->places, i, t, &x, &v);
  w->leave[i] = stay(w, w->places, &w->places->shell[i], t, x, v);
}

static uint32_t blades(const struct em_world *w, uint32_t i) {
  return w->places->blades ? w->places->blades[i] : 0;
}

/* --- making ----------------------------------------------------------------------------------- */

/* Skin in diameters of the largest ball, from the packing fraction: where balls hardly meet, a wide
 * shell saves crossings; where they crowd, a narrow one saves candidates. */
static double skin_for(const struct em_world *w) {
  if (w->scene->engine.skin > 0.0) return w->scene->engine.skin;
  double balls = 0.0;
  for (uint32_t i = 0; i < w->count; i++) balls += pow(w->body[i].radius, 3.0);
  const double phi = fmax(balls * 4.0 / 3.0 * M_PI / em_scene_volume(w->scene), 1e-3);
  return fmin(1.0, 0.18 / cbrt(phi));
}

static void set_cells(struct em_world *w, struct em_places *p) {
  const double reach = 2.0 * (p->skin_most + w->largest + (double)p->slack);
  const double extent[3] = {w->high.x - w->low.x, w->high.y - w->low.y, w->high.z - w->low.z};
  const double most = 4.0 * w->count + 64.0;
  double edge = reach;
  while (fmax(1.0, extent[0] / edge) * fmax(1.0, extent[1] / edge) * fmax(1.0, extent[2] / edge) >
         most)
    edge *= 1.26;
  for (int k = 0; k < 3; k++) {
    p->n[k] = extent[k] > edge ? (int)(extent[k] / edge) : 1;
    p->edge[k] = extent[k] / p->n[k];
  }
}

/* In a periodic box no pair may see two images of each other. */
static enum em_status fit_period(struct em_world *w, struct em_places *p, struct em_error *err) {
  const double period[3] = {w->period.x, w->period.y, w->period.z};
  for (int k = 0; k < 3; k++) {
    p->period[k] = (float)period[k];
    if (period[k] <= 0.0) continue;
    const double most = 0.49 * (0.5 * period[k] - 2.0 * w->largest);
    if (most < 0.01 * w->largest)
      return em_error_set(err, EM_INPUT, w->scene->file, 0,
                          "chamber.size: a periodic edge of %g m is too short for balls of %g m "
                          "diameter; more than two diameters are needed",
                          period[k], 2.0 * w->largest);
    p->skin_most = fmin(p->skin_most, most);
  }
  return EM_OK;
}

static void free_places(struct em_places *p) {
  if (!p) return;
  for (int k = 0; k < LIST_CLASSES; k++) free(p->spare[k]);
  free(p->shell);
  free(p->list);
  free(p->cell);
  free(p->mark);
  free(p->blades);
  free(p->pool);
  free(p->fresh);
  free(p->held);
  free(p->entry);
  free(p->id);
  free(p);
}

static bool take_arrays(const struct em_world *w, struct em_places *p) {
  p->shell = em_body_array(w->count, sizeof *p->shell);
  p->list = em_body_array(w->count, sizeof *p->list);
  p->cell = em_body_array(w->count, sizeof *p->cell);
  p->mark = em_body_array(w->count, sizeof *p->mark);
  p->held = em_body_array(cells(p), sizeof *p->held);
  if (w->blade_count) p->blades = em_body_array(w->count, sizeof *p->blades);
  return p->shell && p->list && p->cell && p->mark && p->held && cells_widen(p) &&
         (p->blades || !w->blade_count);
}

/* Enters the balls one by one; each finds those entered before. */
static bool fill(struct em_world *w, struct em_places *p) {
  for (uint32_t i = 0; i < w->count; i++) {
    shell_place(w, p, i, w->clock);
    uint32_t count = 0;
    if (!search(w, p, i, next_stamp(p), &count)) return false;
    for (uint32_t k = 0; k < count; k++)
      if (!list_add(p, i, p->fresh[k]) || !list_add(p, p->fresh[k], i)) return false;
    if (!cell_enter(w, p, i)) return false;
  }
  return true;
}

static bool first_fill(struct em_world *w, struct em_places *p) {
  for (uint32_t i = 0; i < w->count; i++) {
    struct list *l = &p->list[i];
    p->shell[i].skin = (float)p->skin_most;
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
  p->phase = fmod(p->phase + p->omega * w->epoch_length, 2.0 * M_PI);
  p->at = NAN;
  double rest;
  const double omega = mean_rotation(w, &rest);
  if (fabs(omega - p->omega) * w->rho < 0.25 * rest) return true;
  p->omega = omega;
  p->phase = 0.0;
  memset(p->held, 0, cells(p) * sizeof *p->held);
  for (uint32_t i = 0; i < w->count; i++) p->list[i].count = 0;
  return fill(w, p);
}

static enum em_status make(struct em_world *w, struct em_places **places, struct em_error *err) {
  struct em_places *p = calloc(1, sizeof *p);
  if (!p) return em_error_set(err, EM_MEMORY, NULL, 0, "no memory for the neighbour lists");
  const struct em_vec extent = em_vec_sub(w->high, w->low);
  const double far = fmax(em_vec_norm(extent), em_vec_norm(w->low) + em_vec_norm(extent));
  p->count = w->count;
  p->low = w->low;
  p->slack = (float)(1e-6 * far);
  p->skin_most = skin_for(w) * 2.0 * w->largest;
  const enum em_status status = fit_period(w, p, err);
  if (status) {
    free_places(p);
    return status;
  }
  p->skin_least = 0.2 * p->skin_most;
  p->ahead = 0.7;
  p->few = 10;
  p->many = 24;
  set_cells(w, p);
  w->places = p;
  p->may_turn = may_turn(w);
  p->at = NAN;
  if (p->may_turn) {
    double rest;
    p->omega = mean_rotation(w, &rest);
  }
  if (!take_arrays(w, p) || !first_fill(w, p)) {
    w->places = NULL;
    free_places(p);
    return em_error_set(err, EM_MEMORY, NULL, 0, "no memory for the neighbour lists");
  }
  *places = p;
  return EM_OK;
}

static size_t bytes(const struct em_places *p) {
  size_t sum = p->count * (sizeof *p->shell + sizeof *p->list + sizeof *p->cell + sizeof *p->mark) +
               p->pool_room * sizeof *p->pool + p->fresh_room * sizeof *p->fresh +
               cells(p) * (sizeof *p->held + p->room * (4 * sizeof *p->entry + sizeof *p->id));
  for (int k = 0; k < LIST_CLASSES; k++) sum += p->spare_room[k] * sizeof **p->spare;
  return sum + (p->blades ? p->count * sizeof *p->blades : 0);
}

/* Every entry has its mirror image, every shell is in its cell. */
static bool is_valid(const struct em_world *w) {
  const struct em_places *p = w->places;
  for (uint32_t i = 0; i < p->count; i++) {
    const struct list *l = &p->list[i];
    const uint32_t *id = p->id + (size_t)p->cell[i] * p->room;
    bool found = false;
    for (uint32_t k = 0; k < p->held[p->cell[i]]; k++) found = found || id[k] == i;
    if (!found || p->cell[i] != cell_of(p, &p->shell[i])) return false;
    for (uint32_t k = 0; k < l->count; k++) {
      const struct list *m = &p->list[p->pool[l->at + k]];
      uint32_t seen = 0;
      for (uint32_t h = 0; h < m->count; h++) seen += p->pool[m->at + h] == i;
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
    .moved = moved,
    .cross = cross,
    .renew = renew,
    .blades = blades,
    .bytes = bytes,
    .is_valid = is_valid,
};
