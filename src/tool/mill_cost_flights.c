/* Errors of contact times: free flights of the scene, as they really were, asked of every variant
 * and of the search in 113 bits. */
#include <math.h>
#include <stdlib.h>

#include "eventmill/surface_roots.h"
#include "eventmill/world.h"
#include "tool/mill_cost.h"

/* One ball's flight: its state after its last event, and how long it flew. */
struct flight {
  struct em_vec r, v;
  double radius, since, time; /* m; s within the epoch; s */
  uint32_t last;
};

struct sample {
  const struct em_scene *scene;
  size_t count, room;
  struct flight *flight;
  size_t blades;
  struct em_blade *blade;
  double *angle; /* of each blade at the beginning of each flight's epoch */
  double *truth; /* s: of drum, then of each blade, per flight */
  double *end;   /* s: when the balls of the round had their next event */
};

static void landed(void *self, const struct em_contact *c) {
  struct sample *s = self;
  if (s->end[c->ball] == INFINITY) s->end[c->ball] = c->time;
  if (c->cls == EM_CLASS_BALL && s->end[c->partner] == INFINITY) s->end[c->partner] = c->time;
}

/* The flights that are under way now, each to its end, or to `until`. */
static enum em_status take(struct sample *s, struct em_world *world, double until,
                           const volatile sig_atomic_t *stop, struct em_error *err) {
  struct em_snapshot *now = NULL;
  enum em_status status = em_world_snapshot(world, &now, err);
  if (status) return status;
  const double origin = em_world_time(world) - now->clock;
  for (uint32_t i = 0; i < now->count; i++)
    s->end[i] = INFINITY;
  status = em_world_run_collisions(world, until, 3 * (uint64_t)now->count + 1, stop, err);
  size_t i = 0;
  for (size_t k = 0; k < s->scene->species_count && !status; k++)
    for (size_t n = 0; n < s->scene->species[k].count && s->count < s->room; n++, i++) {
      const double end = fmin(s->end[i], em_world_time(world));
      const struct flight f = {.r = now->position[i],
                               .v = now->velocity[i],
                               .radius = 0.5 * s->scene->species[k].diameter,
                               .since = now->time[i],
                               .time = end - (origin + now->time[i]),
                               .last = now->last[i]};
      if (!(f.time > 0.0)) continue;
      for (size_t b = 0; b < s->blades; b++)
        s->angle[s->count * s->blades + b] = now->blade_angle[b];
      s->flight[s->count++] = f;
    }
  em_world_snapshot_free(now);
  return status;
}

/* s in which this many flights end, ten times as long as they take on an average. */
static double long_enough(const struct em_cost *cost, size_t flights) {
  const double n = (double)em_scene_ball_count(cost->scene);
  return 10.0 * (3.0 * n + 1.0) * ceil((double)flights / n) / cost->collisions_per_time;
}

/* Where nothing comes to contact any more, there are fewer flights, or none. */
static enum em_status gather(struct sample *s, const struct em_cost *cost, struct em_error *err) {
  struct em_world *world = NULL;
  if (!(cost->collisions_per_time > 0.0)) return EM_OK;
  enum em_status status = em_world_resume(&world, cost->scene, cost->settled, err);
  const struct em_observer observer = {s, landed};
  if (!status && em_world_observe(world, &observer)) status = em_mill_cost_no_memory(err);
  const double until = status ? 0.0 : em_world_time(world) + long_enough(cost, s->room);
  while (!status && s->count < s->room && em_world_time(world) < (1.0 - 1e-9) * until) {
    status = take(s, world, until, cost->stop, err);
    em_mill_cost_tell(cost, "flights are sampled");
  }
  em_world_free(world);
  return status == EM_COLLAPSE || status == EM_JAM ? EM_OK : status;
}

/* ---------------------------------------------------------------- asking */

/* First of the planes of a drum with facets, all of which lie beyond the round wall. */
static double facets(const struct em_scene *scene, const struct em_roots *how,
                     const struct flight *f, double rho, bool touched, double horizon) {
  const int n = scene->chamber.facets;
  const int last = (int)lround(atan2(f->r.x, f->r.z) * n / (2.0 * M_PI));
  double first = INFINITY;
  for (int k = 0; k < n; k++) {
    const double a = 2.0 * M_PI * k / n, x = sin(a), z = cos(a);
    const bool same = touched && k == (last + n) % n;
    first = fmin(first, em_surface_roots_plane(
                            how, rho - (f->r.x * x + f->r.z * z), -(f->v.x * x + f->v.z * z),
                            -(scene->gravity.x * x + scene->gravity.z * z), same));
  }
  return first <= horizon ? first : INFINITY;
}

/* The drum of `scene`; a ball of the sample may have left that of another scene. */
static double drum(const struct sample *s, const struct em_scene *scene, const struct em_roots *how,
                   const struct flight *f, double horizon) {
  const bool same = scene->chamber.facets == s->scene->chamber.facets;
  const bool touched = same && f->last == EM_SURFACE + EM_WALL_DRUM;
  const double rho = 0.5 * scene->chamber.diameter - f->radius;
  if (scene->chamber.facets > 0) return facets(scene, how, f, rho, touched, horizon);
  return em_surface_roots_drum(how, f->r, f->v, scene->gravity, rho, f->radius, touched, horizon);
}

static double blade(const struct sample *s, const struct em_roots *how, size_t i, size_t k,
                    double horizon) {
  const struct flight *f = &s->flight[i];
  const double angle = s->angle[i * s->blades + k] + s->blade[k].omega * f->since;
  return em_surface_roots_blade(how, &s->blade[k], f->r, f->v, s->scene->gravity, f->radius, angle,
                                f->last == EM_SURFACE_BLADE(k), horizon, NULL);
}

static const double MARGIN = 1e-9; /* relative: the flight's own end is in it */

static void find_truth(struct sample *s, const volatile sig_atomic_t *stop) {
  static const struct em_roots best = {.polish = EM_POLISH_QUAD};
  const size_t each = s->blades + 1;
  for (size_t i = 0; i < s->count && !*stop; i++) {
    const double h = s->flight[i].time * (1.0 + MARGIN);
    s->truth[i * each] = s->scene->chamber.shape == EM_SHAPE_DRUM
                             ? drum(s, s->scene, &best, &s->flight[i], h)
                             : INFINITY;
    for (size_t k = 0; k < s->blades; k++)
      s->truth[i * each + 1 + k] = blade(s, &best, i, k, h);
  }
}

/* t against the truth; near: differences below this are errors of the same contact. */
static void judge(struct em_cost_flights *f, double t, double truth, double flown, double near,
                  double *squares) {
  if (truth < INFINITY) f->contacts++;
  if (truth == INFINITY && t > flown) return;
  const double off = fabs(t - truth);
  if (off <= near && off < INFINITY) {
    f->most = fmax(f->most, off);
    *squares += off * off;
    return;
  }
  if (t > truth)
    f->missed++;
  else if (t <= flown)
    f->invented++;
}

static void ask(const struct sample *s, const struct em_scene *scene, struct em_cost_flights *f) {
  const size_t each = s->blades + 1;
  const struct em_roots *how = &scene->engine.roots;
  double squares = 0.0;
  f->flights = s->count;
  for (size_t i = 0; i < s->count; i++) {
    const struct flight *flight = &s->flight[i];
    const double h = flight->time * (1.0 + MARGIN);
    double speed = em_vec_norm(flight->v);
    for (size_t k = 0; k < s->blades; k++)
      speed = fmax(speed, em_vec_norm(flight->v) + fabs(s->blade[k].omega) * s->blade[k].reach);
    const double near = speed > 0.0 ? 0.1 * flight->radius / speed : 0.0;
    /* Facets are another drum: all contacts that come later are errors of time. */
    const bool other = scene->chamber.facets != s->scene->chamber.facets;
    if (scene->chamber.shape == EM_SHAPE_DRUM)
      judge(f, drum(s, scene, how, flight, other ? INFINITY : h + near), s->truth[i * each], h,
            other ? INFINITY : near, &squares);
    for (size_t k = 0; k < s->blades; k++)
      judge(f, blade(s, how, i, k, h + near), s->truth[i * each + 1 + k], h, near, &squares);
  }
  const uint64_t found = f->contacts > f->missed ? f->contacts - f->missed : 0;
  f->rms = found ? sqrt(squares / (double)found) : NAN;
}

static enum em_status ask_all(struct em_cost *cost, const struct sample *s, struct em_error *err) {
  enum em_status status = EM_OK;
  for (size_t k = 0; k < cost->count && !status; k++) {
    struct em_cost_result *r = &cost->result[k];
    struct em_scene *scene = NULL;
    size_t hidden;
    if (r->variant.group != EM_COST_ACCURACY) continue;
    status = em_mill_cost_scene(cost, &r->variant, &scene, &hidden, err);
    if (!status) ask(s, scene, &r->flights);
    em_mill_cost_scene_free(scene, hidden);
    em_mill_cost_tell(cost, r->variant.name);
    if (*cost->stop) status = em_error_set(err, EM_STOPPED, NULL, 0, "stopped");
  }
  return status;
}

static enum em_status make_room(struct sample *s, const struct em_cost *cost,
                                struct em_error *err) {
  const size_t blades = em_scene_blade_count(cost->scene), room = cost->flights;
  s->room = room;
  s->flight = calloc(room + 1, sizeof *s->flight);
  s->angle = calloc(room * blades + 1, sizeof *s->angle);
  s->truth = calloc(room * (blades + 1) + 1, sizeof *s->truth);
  s->end = calloc(em_scene_ball_count(cost->scene) + 1, sizeof *s->end);
  s->blade = calloc(blades + 1, sizeof *s->blade);
  if (!s->flight || !s->angle || !s->truth || !s->end || !s->blade)
    return em_mill_cost_no_memory(err);
  for (size_t r = 0; r < cost->scene->rotor_count; r++)
    for (size_t k = 0; k < cost->scene->rotor[r].blade_count; k++)
      s->blade[s->blades++] = cost->scene->rotor[r].blade[k];
  return EM_OK;
}

enum em_status em_mill_cost_flights(struct em_cost *cost, struct em_error *err) {
  struct sample s = {.scene = cost->scene};
  const bool drum_or_blade =
      cost->scene->chamber.shape == EM_SHAPE_DRUM || em_scene_blade_count(cost->scene) > 0;
  if (!drum_or_blade || cost->flights == 0) return EM_OK;
  enum em_status status = make_room(&s, cost, err);
  if (!status) status = gather(&s, cost, err);
  cost->sampled = s.count;
  if (!status) {
    find_truth(&s, cost->stop);
    status = ask_all(cost, &s, err);
  }
  free(s.flight);
  free(s.angle);
  free(s.truth);
  free(s.end);
  free(s.blade);
  return status;
}
