/* Paths of the balls between the frames of a run. */
#include "eventmill/motion.h"

#include <stdlib.h>
#include <string.h>

/* A place through which a ball's centre went: at a contact. In a periodic box, places of one ball
 * are those of one unbroken path, which leaves the box. */
struct knot {
  double time;
  struct em_vec place;
  uint8_t cls;
};

struct mark {
  double time;
  struct em_vec place;
  uint8_t cls;
};

enum {
  MOST_ROWS = 20000000, /* between two frames; beyond that the table is left alone */
  MOST_BACK = 4000000   /* rows in which last contacts are looked for */
};

/* Of a periodic box: a way that is longer tells the velocity, although places are stored in single
 * precision. */
static const double SEEN = 1e-3;

struct em_motion {
  const struct em_run_file *file;
  const struct em_scene *scene;
  double memory, time;
  size_t frames, interval;    /* the interval begins with this frame; frames: none yet */
  double begin, end;          /* s, of the interval */
  struct em_balls *from, *to; /* its two frames */
  struct em_balls *balls;     /* at `time` */
  double *blade;              /* rad */
  uint8_t *before, *cls;      /* last contacts at the interval's begin; at `time` */
  struct em_rows *rows;       /* NULL: no table */
  double hint_time;           /* s: the rows before hint_row are earlier */
  uint64_t hint_row;
  size_t knot_count, knot_room;
  size_t *first; /* balls + 1: the knots of ball k are first[k] … first[k + 1] - 1 */
  struct knot *knot;
  size_t mark_count, mark_room;
  struct mark *mark;
};

static enum em_status no_memory(struct em_error *err) {
  return em_error_set(err, EM_MEMORY, NULL, 0, "no memory for the balls' paths");
}

enum em_status em_motion_new(struct em_motion **motion, const struct em_run_file *file,
                             double memory, struct em_error *err) {
  *motion = NULL;
  if (em_run_file_ball_count(file) == 0)
    return em_error_set(err, EM_INPUT, em_run_file_path(file), 0,
                        "the run has no balls to look at");
  if (em_run_file_frame_count(file) == 0)
    return em_error_set(err, EM_INPUT, em_run_file_path(file), 0,
                        "the run has no frames to look at; record.frames must be above 0");
  struct em_motion *m = calloc(1, sizeof *m);
  if (m == NULL) return no_memory(err);
  m->file = file;
  m->scene = em_run_file_scene(file);
  m->memory = memory;
  m->frames = em_run_file_frame_count(file);
  m->interval = m->frames;
  const size_t count = em_run_file_ball_count(file);
  enum em_status status = em_run_file_balls(file, &m->from, err);
  if (status == EM_OK) status = em_run_file_balls(file, &m->to, err);
  if (status == EM_OK) status = em_run_file_balls(file, &m->balls, err);
  m->blade = calloc(em_scene_blade_count(m->scene) + 1, sizeof *m->blade);
  m->before = malloc(count);
  m->cls = malloc(count);
  m->first = calloc(count + 2, sizeof *m->first);
  if (em_run_file_has_rows(file))
    m->rows = em_run_file_rows_new(EM_COLUMN_TIME | EM_COLUMN_CLASS | EM_COLUMN_BALL |
                                   EM_COLUMN_PARTNER | EM_COLUMN_PLACE | EM_COLUMN_NORMAL);
  if (status == EM_OK && (m->blade == NULL || m->before == NULL || m->cls == NULL ||
                          m->first == NULL || (em_run_file_has_rows(file) && m->rows == NULL)))
    status = no_memory(err);
  if (status == EM_OK) {
    memset(m->before, EM_CLASS_COUNT, count);
    status = em_motion_seek(m, em_motion_first(m), err);
  }
  if (status != EM_OK) {
    em_motion_free(m);
    return status;
  }
  *motion = m;
  return EM_OK;
}

void em_motion_free(struct em_motion *motion) {
  if (motion == NULL) return;
  em_start_free(motion->from);
  em_start_free(motion->to);
  em_start_free(motion->balls);
  free(motion->blade);
  free(motion->before);
  free(motion->cls);
  if (motion->rows != NULL) em_run_file_rows_free(motion->rows);
  free(motion->first);
  free(motion->knot);
  free(motion->mark);
  free(motion);
}

double em_motion_first(const struct em_motion *motion) {
  return em_run_file_frame_time(motion->file, 0);
}

double em_motion_last(const struct em_motion *motion) {
  return em_run_file_frame_time(motion->file, motion->frames - 1);
}

bool em_motion_is_exact(const struct em_motion *motion) {
  return motion->rows != NULL;
}

/* The first row at or after a time: near the one found last, or by bisection in blocks of rows. */
static enum em_status find_row(struct em_motion *m, double time, uint64_t *row,
                               struct em_error *err) {
  uint64_t low = time >= m->hint_time ? m->hint_row : 0, high = em_run_file_row_count(m->file);
  enum em_status status = em_run_file_rows(m->file, low, m->rows, err);
  if (status != EM_OK) return status;
  const size_t got = m->rows->count;
  const bool near = got == 0 || m->rows->time[got - 1] >= time;
  while (!near && high - low > EM_ROWS_BLOCK / 2) {
    const uint64_t middle = low + (high - low) / 2;
    status = em_run_file_rows(m->file, middle, m->rows, err);
    if (status != EM_OK) return status;
    if (m->rows->count == 0 || m->rows->time[0] >= time)
      high = middle;
    else
      low = middle + 1;
  }
  if (!near) status = em_run_file_rows(m->file, low, m->rows, err);
  if (status != EM_OK) return status;
  *row = low;
  for (size_t k = 0; k < m->rows->count && m->rows->time[k] < time; k++)
    ++*row;
  m->hint_row = *row;
  m->hint_time = time;
  return EM_OK;
}

/* d, brought to the nearest image where the box is periodic. */
static struct em_vec nearest(const struct em_scene *scene, struct em_vec d) {
  if (scene->chamber.shape != EM_SHAPE_BOX) return d;
  const struct em_vec size = scene->chamber.size;
  if (scene->chamber.periodic[0]) d.x -= size.x * round(d.x / size.x);
  if (scene->chamber.periodic[1]) d.y -= size.y * round(d.y / size.y);
  if (scene->chamber.periodic[2]) d.z -= size.z * round(d.z / size.z);
  return d;
}

/* One contact more, until the interval's knots are sorted by ball. */
struct pending {
  uint32_t ball;
  struct knot knot;
};

/* A ball on its path through the images of a periodic box, just after its last contact. */
struct walker {
  double time;
  struct em_vec place, velocity, spin;
};

struct gather {
  struct em_motion *motion;
  size_t count, room;
  struct pending *pending;
  struct walker *walker; /* one per ball; NULL: the box is not periodic */
};

static bool add_knot(struct gather *g, uint32_t ball, const struct knot *knot) {
  if (ball >= g->motion->balls->count) return true; /* a foreign row harms nobody */
  if (g->count == g->room) {
    const size_t room = g->room ? 2 * g->room : 4096;
    struct pending *more = realloc(g->pending, room * sizeof *more);
    if (more == NULL) return false;
    g->pending = more;
    g->room = room;
  }
  g->pending[g->count++] = (struct pending){ball, *knot};
  return true;
}

static bool add_mark(struct em_motion *m, const struct mark *mark) {
  if (m->mark_count == m->mark_room) {
    const size_t room = m->mark_room ? 2 * m->mark_room : 1024;
    struct mark *more = realloc(m->mark, room * sizeof *more);
    if (more == NULL) return false;
    m->mark = more;
    m->mark_room = room;
  }
  m->mark[m->mark_count++] = *mark;
  return true;
}

static bool start_walkers(struct gather *g) {
  const struct em_motion *m = g->motion;
  if (!(em_scene_effects(m->scene) & EM_EFFECT_PERIODIC)) return true;
  g->walker = calloc(m->balls->count, sizeof *g->walker);
  for (size_t k = 0; g->walker != NULL && k < m->balls->count; k++)
    g->walker[k] =
        (struct walker){m->begin, m->from->position[k], m->from->velocity[k], m->from->spin[k]};
  return g->walker != NULL;
}

/* Goes on to a contact, and chooses its image: the one that is nearest to where the ball flies. */
static void walk(struct walker *w, const struct em_scene *scene, struct knot *knot) {
  const double span = knot->time - w->time, size = em_vec_norm(scene->chamber.size);
  const struct em_vec fall = em_vec_scale(span, scene->gravity);
  const struct em_vec way = em_vec_scale(span, em_vec_axpy(w->velocity, 0.5, fall));
  const struct em_vec place = em_vec_add(w->place, way);
  knot->place = em_vec_add(place, nearest(scene, em_vec_sub(knot->place, place)));
  const struct em_vec gone = em_vec_sub(knot->place, w->place);
  if (em_vec_norm(gone) > SEEN * size)
    w->velocity = em_vec_axpy(em_vec_scale(1.0 / span, gone), -0.5, fall);
  w->velocity = em_vec_add(w->velocity, fall);
  w->place = knot->place;
  w->time = knot->time;
}

/* Velocities and spins after a contact, by its rule; j: the partner, NULL: a wall, or a blade,
 * which stands still in a periodic box. e: from the partner to ball i. */
static void collide(const struct em_motion *m, struct walker *w, uint32_t i, const uint32_t *j,
                    enum em_class cls, struct em_vec e) {
  const struct em_contact_law *law = &m->scene->contact[cls];
  const double *mass = m->balls->mass, *radius = m->balls->radius;
  struct em_vec g = em_vec_axpy(w[i].velocity, -radius[i], em_vec_cross(w[i].spin, e));
  if (j != NULL) {
    g = em_vec_sub(g, w[*j].velocity);
    g = em_vec_axpy(g, -radius[*j], em_vec_cross(w[*j].spin, e));
  }
  if (!(em_vec_dot(g, e) < 0.0)) return; /* a touch, for all that single precision knows */
  const double m_eff = j != NULL ? mass[i] * mass[*j] / (mass[i] + mass[*j]) : mass[i];
  const struct em_impulse p = em_contact_impulse(law, m_eff, e, g, false, false);
  const struct em_vec all = em_vec_add(p.normal, p.tangential);
  const struct em_vec turn = em_vec_cross(e, p.tangential);
  w[i].velocity = em_vec_axpy(w[i].velocity, 1.0 / mass[i], all);
  w[i].spin = em_vec_axpy(w[i].spin, em_contact_spin_factor(law->rule, mass[i], radius[i]), turn);
  if (j == NULL) return;
  w[*j].velocity = em_vec_axpy(w[*j].velocity, -1.0 / mass[*j], all);
  w[*j].spin =
      em_vec_axpy(w[*j].spin, em_contact_spin_factor(law->rule, mass[*j], radius[*j]), turn);
}

static bool take_row(struct gather *g, size_t k) {
  struct em_motion *m = g->motion;
  const struct em_rows *r = m->rows;
  const struct em_vec place = {(double)r->place[k][0], (double)r->place[k][1],
                               (double)r->place[k][2]};
  const struct em_vec normal = {(double)r->normal[k][0], (double)r->normal[k][1],
                                (double)r->normal[k][2]};
  const uint32_t i = r->ball[k], j = r->partner[k];
  if (m->memory > 0.0 && !add_mark(m, &(struct mark){r->time[k], place, r->cls[k]})) return false;
  if (r->time[k] < m->begin || i >= m->balls->count) return true;
  const double *radius = m->balls->radius;
  const bool pair = r->cls[k] == EM_CLASS_BALL && j < m->balls->count;
  struct knot one = {r->time[k], em_vec_axpy(place, radius[i], normal), r->cls[k]}, other = one;
  if (pair) other.place = em_vec_axpy(place, -radius[j], normal);
  if (g->walker != NULL) {
    walk(&g->walker[i], m->scene, &one);
    if (pair) walk(&g->walker[j], m->scene, &other);
    if (r->cls[k] < EM_CLASS_COUNT)
      collide(m, g->walker, i, pair ? &j : NULL, (enum em_class)r->cls[k], normal);
  }
  return add_knot(g, i, &one) && (!pair || add_knot(g, j, &other));
}

/* All contacts of the interval, and those before it that are still remembered. */
static enum em_status read_rows(struct gather *g, struct em_error *err) {
  struct em_motion *m = g->motion;
  uint64_t row = 0, taken = 0;
  m->mark_count = 0;
  enum em_status status = find_row(m, m->begin - m->memory, &row, err);
  for (bool more = status == EM_OK; more;) {
    status = em_run_file_rows(m->file, row, m->rows, err);
    if (status != EM_OK) return status;
    more = m->rows->count > 0;
    for (size_t k = 0; k < m->rows->count && more; k++) {
      more = m->rows->time[k] <= m->end && ++taken <= MOST_ROWS;
      if (more && !take_row(g, k)) return no_memory(err);
    }
    row += m->rows->count;
  }
  return status;
}

/* Sorts the knots by ball; the order in time stays. */
static bool sort_knots(struct em_motion *m, const struct gather *g) {
  const size_t count = m->balls->count;
  if (g->count > m->knot_room) {
    struct knot *more = realloc(m->knot, g->count * sizeof *more);
    if (more == NULL) return false;
    m->knot = more;
    m->knot_room = g->count;
  }
  memset(m->first, 0, (count + 2) * sizeof *m->first);
  for (size_t k = 0; k < g->count; k++)
    m->first[g->pending[k].ball + 2]++;
  for (size_t b = 2; b < count + 2; b++)
    m->first[b] += m->first[b - 1];
  for (size_t k = 0; k < g->count; k++)
    m->knot[m->first[g->pending[k].ball + 1]++] = g->pending[k].knot;
  m->knot_count = g->count;
  return true;
}

/* What the balls last touched before the interval, carried on from the one that precedes it. */
static void carry_classes(struct em_motion *m) {
  for (size_t b = 0; b < m->balls->count; b++)
    if (m->first[b + 1] > m->first[b]) m->before[b] = m->knot[m->first[b + 1] - 1].cls;
}

static size_t touch(struct em_motion *m, uint32_t ball, uint8_t cls) {
  if (ball >= m->balls->count || m->before[ball] != EM_CLASS_COUNT) return 0;
  m->before[ball] = cls;
  return 1;
}

/* After a jump: what the balls last touched before the interval, by going back through the table
 * until all are known. */
static enum em_status look_back(struct em_motion *m, struct em_error *err) {
  size_t unknown = m->balls->count;
  uint64_t end = 0;
  enum em_status status = find_row(m, m->begin, &end, err);
  const uint64_t stop = end > MOST_BACK ? end - MOST_BACK : 0;
  memset(m->before, EM_CLASS_COUNT, m->balls->count);
  while (status == EM_OK && end > stop && unknown > 0) {
    const uint64_t first = end > EM_ROWS_BLOCK ? end - EM_ROWS_BLOCK : 0;
    status = em_run_file_rows(m->file, first, m->rows, err);
    if (status != EM_OK) break;
    for (size_t k = (size_t)(end - first); k-- > 0;) {
      if (k >= m->rows->count) continue; /* a table that was cut short */
      unknown -= touch(m, m->rows->ball[k], m->rows->cls[k]);
      if (m->rows->cls[k] == EM_CLASS_BALL) unknown -= touch(m, m->rows->partner[k], EM_CLASS_BALL);
    }
    end = first;
  }
  return status;
}

static enum em_status load(struct em_motion *m, size_t interval, struct em_error *err) {
  const size_t next = interval + 1 < m->frames ? interval + 1 : interval;
  const bool follows = m->interval + 1 == interval && m->interval < m->frames;
  enum em_status status = EM_OK;
  if (follows) {
    carry_classes(m);
    struct em_balls *swap = m->from;
    m->from = m->to;
    m->to = swap;
  } else {
    status = em_run_file_frame(m->file, interval, m->from, err);
  }
  m->interval = m->frames; /* until all is there */
  if (status == EM_OK) status = em_run_file_frame(m->file, next, m->to, err);
  if (status != EM_OK) return status;
  m->begin = em_run_file_frame_time(m->file, interval);
  m->end = em_run_file_frame_time(m->file, next);
  if (m->rows != NULL && !follows) status = look_back(m, err);
  if (m->rows != NULL && status == EM_OK) {
    struct gather g = {.motion = m};
    status = start_walkers(&g) ? read_rows(&g, err) : no_memory(err);
    if (status == EM_OK && !sort_knots(m, &g)) status = no_memory(err);
    free(g.pending);
    free(g.walker);
  }
  if (status == EM_OK) m->interval = interval;
  return status;
}

enum em_status em_motion_seek(struct em_motion *motion, double time, struct em_error *err) {
  const double t = fmin(fmax(time, em_motion_first(motion)), em_motion_last(motion));
  size_t interval = em_run_file_frame_before(motion->file, t);
  if (interval + 1 == motion->frames && interval > 0) interval--;
  if (interval != motion->interval) {
    const enum em_status status = load(motion, interval, err);
    if (status != EM_OK) return status;
  }
  motion->time = t;
  size_t n = 0;
  for (size_t r = 0; r < motion->scene->rotor_count; r++)
    for (size_t k = 0; k < motion->scene->rotor[r].blade_count; k++, n++) {
      const struct em_blade *blade = &motion->scene->rotor[r].blade[k];
      motion->blade[n] = fmod(blade->angle + blade->omega * t, 2.0 * M_PI);
    }
  return EM_OK;
}

static double within(double x, double low, double high) {
  return fmin(fmax(x, low), high);
}

static double wrapped(double x, double size) {
  return x - size * floor(x / size);
}

/* How far from the axis of the drum, across the wall that is nearest. */
static double outwards(const struct em_chamber *c, struct em_vec p) {
  if (c->facets == 0) return hypot(p.x, p.z);
  const double step = 2.0 * M_PI / c->facets, angle = step * round(atan2(p.x, p.z) / step);
  return p.x * sin(angle) + p.z * cos(angle);
}

/* A centre that is inside the chamber; in periodic directions, its image there. */
static struct em_vec inside(const struct em_scene *scene, struct em_vec p, double radius) {
  const struct em_chamber *c = &scene->chamber;
  if (c->shape == EM_SHAPE_DRUM) {
    const double most = 0.5 * c->diameter - radius, r = outwards(c, p);
    const double scale = r > most && r > 0.0 ? most / r : 1.0;
    return em_vec_make(scale * p.x, within(p.y, radius, c->length - radius), scale * p.z);
  }
  p.x = c->periodic[0] ? wrapped(p.x, c->size.x) : within(p.x, radius, c->size.x - radius);
  p.y = c->periodic[1] ? wrapped(p.y, c->size.y) : within(p.y, radius, c->size.y - radius);
  p.z = c->periodic[2] ? wrapped(p.z, c->size.z) : within(p.z, radius, c->size.z - radius);
  return p;
}

/* A velocity as tangent of the cubic: no longer than 1.5 times the way per time. */
static struct em_vec shortened(struct em_vec v, double way, double span) {
  const double length = em_vec_norm(v) * span;
  return length > 1.5 * way ? em_vec_scale(1.5 * way / length, v) : v;
}

static void cubic(const struct em_motion *m, size_t ball, struct em_vec *position,
                  struct em_vec *velocity) {
  const double span = m->end - m->begin;
  const struct em_vec p = m->from->position[ball], v = m->from->velocity[ball];
  const struct em_vec w = m->to->velocity[ball];
  *position = p;
  *velocity = v;
  if (span <= 0.0) return;
  const double u = (m->time - m->begin) / span;
  /* The image that is nearest to where both velocities lead. */
  const struct em_vec even = em_vec_scale(0.5 * span, em_vec_add(v, w));
  const struct em_vec rest = em_vec_sub(em_vec_sub(m->to->position[ball], p), even);
  const struct em_vec d = em_vec_add(even, nearest(m->scene, rest));
  const double way = em_vec_norm(d);
  const struct em_vec a = shortened(v, way, span), b = shortened(w, way, span);
  struct em_vec q = em_vec_axpy(p, u * u * (3.0 - 2.0 * u), d);
  q = em_vec_axpy(q, span * u * (1.0 - u) * (1.0 - u), a);
  q = em_vec_axpy(q, -span * u * u * (1.0 - u), b);
  *position = inside(m->scene, q, m->from->radius[ball]);
  /* The direction turns, the speed goes evenly from one to the other. */
  const struct em_vec blend = em_vec_axpy(em_vec_scale(1.0 - u, v), u, w);
  const double speed = (1.0 - u) * em_vec_norm(v) + u * em_vec_norm(w);
  const double length = em_vec_norm(blend);
  *velocity = length > 0.0 ? em_vec_scale(speed / length, blend) : v;
}

/* The last knot of a ball at or before now; first[ball] - 1 + … as a count of knots gone. */
static size_t knots_gone(const struct em_motion *m, size_t ball) {
  size_t low = m->first[ball], high = m->first[ball + 1];
  while (low < high) {
    const size_t middle = low + (high - low) / 2;
    if (m->knot[middle].time <= m->time)
      low = middle + 1;
    else
      high = middle;
  }
  return low - m->first[ball];
}

/* Free flight between the knots, or frames, before and after now. */
static void flight(const struct em_motion *m, size_t ball, struct em_vec *position,
                   struct em_vec *velocity) {
  const size_t gone = knots_gone(m, ball), first = m->first[ball], past = m->first[ball + 1];
  const struct knot *before = gone > 0 ? &m->knot[first + gone - 1] : NULL;
  const struct knot *after = first + gone < past ? &m->knot[first + gone] : NULL;
  const struct em_vec g = m->scene->gravity;
  struct em_vec p = m->from->position[ball], v = m->from->velocity[ball];
  double since = m->time - m->begin;
  if (before != NULL && after == NULL) { /* back from the frame that follows */
    p = m->to->position[ball];
    v = m->to->velocity[ball];
    since = m->time - m->end;
  } else if (before != NULL) {
    const double span = after->time - before->time;
    p = before->place;
    since = m->time - before->time;
    v = m->from->velocity[ball];
    if (span > 0.0) {
      const struct em_vec d = em_vec_sub(after->place, p);
      v = em_vec_axpy(em_vec_scale(1.0 / span, d), -0.5 * span, g);
    }
  }
  *position = em_vec_axpy(em_vec_axpy(p, since, v), 0.5 * since * since, g);
  *position = inside(m->scene, *position, m->from->radius[ball]);
  *velocity = em_vec_axpy(v, since, g);
}

void em_motion_ball(const struct em_motion *motion, size_t ball, struct em_vec *position,
                    struct em_vec *velocity) {
  if (motion->rows != NULL)
    flight(motion, ball, position, velocity);
  else
    cubic(motion, ball, position, velocity);
}

const struct em_balls *em_motion_balls(struct em_motion *motion) {
  const double span = motion->end - motion->begin;
  const double u = span > 0.0 ? (motion->time - motion->begin) / span : 0.0;
  for (size_t k = 0; k < motion->balls->count; k++) {
    em_motion_ball(motion, k, &motion->balls->position[k], &motion->balls->velocity[k]);
    motion->balls->spin[k] =
        em_vec_axpy(em_vec_scale(1.0 - u, motion->from->spin[k]), u, motion->to->spin[k]);
  }
  return motion->balls;
}

const double *em_motion_blades(const struct em_motion *motion) {
  return motion->blade;
}

const uint8_t *em_motion_classes(struct em_motion *motion) {
  if (motion->rows == NULL) return NULL;
  for (size_t b = 0; b < motion->balls->count; b++) {
    const size_t gone = knots_gone(motion, b);
    motion->cls[b] = gone > 0 ? motion->knot[motion->first[b] + gone - 1].cls : motion->before[b];
  }
  return motion->cls;
}

size_t em_motion_marks(const struct em_motion *motion, struct em_picture_bead *bead, size_t room,
                       double radius) {
  size_t count = 0;
  for (size_t k = motion->mark_count; k-- > 0;) {
    const struct mark *mark = &motion->mark[k];
    const double age = motion->time - mark->time;
    if (age < 0.0) continue;
    if (age > motion->memory) break;
    if (count++ >= room) continue;
    const uint8_t *c = em_colour_cycle(mark->cls);
    bead[count - 1] = (struct em_picture_bead){
        mark->place, radius * (1.0 - 0.8 * age / motion->memory), {c[0], c[1], c[2]}, true};
  }
  return count;
}
