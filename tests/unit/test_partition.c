/* Partitions: no pair that can touch, and no blade that can be met, is ever left out; and the
 * collisions are the same with all of them and with all lists. */
#include <malloc.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "event/blocks.h"
#include "event/body.h"
#include "event/neighbours.h"
#include "event/partition.h"
#include "support/trial.h"

#define GAS "contact = { rule = \"smooth\"; normal = 1.0; }; record = { frames = 0.0; };"
#define MILL                                                                                 \
  "rotor = ( { rpm = 1300.0; point = [0.0, 0.0, 0.0]; radius = 0.006; reach = 0.030;"        \
  "  blades = ( { y = 0.0225; angle_deg = 0.0; }, { y = 0.0675; angle_deg = 60.0; } ); } );" \
  "contact = { rule = \"rough\"; normal = 0.9; tangential = 0.9; };"

static const struct {
  const char *name, *text;
} scenes[] = {
    {"drum", "chamber = { shape = \"drum\"; diameter = 0.08; length = 0.1; };"
             "gravity = [0.0, 0.0, -9.81]; balls = { count = 150; diameter = 0.006; };" GAS},
    {"mill", "chamber = { shape = \"drum\"; diameter = 0.08; length = 0.09; };"
             "gravity = [0.0, 0.0, -9.81]; balls = { count = 150; diameter = 0.005; };" MILL},
    {"box", "chamber = { shape = \"box\"; size = [0.05, 0.08, 0.04]; };"
            "gravity = \"none\"; balls = { count = 120; diameter = 0.006; };" GAS},
    {"tilted", "chamber = { shape = \"box\"; size = [0.05, 0.08, 0.04]; };"
               "gravity = [3.0, -8.0, 2.0]; balls = { count = 120; diameter = 0.006; };" GAS},
    {"mixed", "chamber = { shape = \"box\"; size = [0.06, 0.08, 0.05]; }; gravity = \"none\";"
              "balls = ( { name = \"large\"; count = 12; diameter = 0.012; },"
              "          { name = \"small\"; count = 150; diameter = 0.003; } );" GAS},
    {"periodic", "chamber = { shape = \"box\"; size = [0.06, 0.07, 0.05];"
                 "  periodic = [true, true, true]; };"
                 "gravity = \"none\"; balls = { count = 150; diameter = 0.006; };" GAS},
    {"tight", "chamber = { shape = \"box\"; size = [0.026, 0.06, 0.026];"
              "  periodic = [true, false, true]; };"
              "gravity = \"none\"; balls = { count = 30; diameter = 0.006; };" GAS},
    {"turning", "chamber = { shape = \"box\"; size = [0.05, 0.026, 0.05];"
                "  periodic = [false, true, false]; };"
                "gravity = [0.0, 0.0, -9.81]; balls = { count = 50; diameter = 0.006; };" GAS},
    {"crowded", "chamber = { shape = \"box\"; size = [0.0361, 0.0481, 0.0361]; };"
                "gravity = \"none\"; balls = { count = 130; diameter = 0.006; };" GAS},
    {"exact", "chamber = { shape = \"box\"; size = [0.03004, 0.03004, 0.03004];"
              "  periodic = [true, true, true]; };"
              "gravity = \"none\"; balls = { count = 60; diameter = 0.006; };" GAS},
    {"lonely", "chamber = { shape = \"box\"; size = [0.05, 0.05, 0.05]; };"
               "gravity = \"none\"; balls = { count = 1; diameter = 0.006; };" GAS},
};
enum { SCENES = sizeof scenes / sizeof scenes[0] };

/* xorshift64*: the same numbers on every machine. */
static double draw(uint64_t *state) {
  *state ^= *state >> 12;
  *state ^= *state << 25;
  *state ^= *state >> 27;
  return (double)((*state * UINT64_C(2685821657736338717)) >> 11) * 0x1p-53;
}

static struct em_world *open_world(size_t which, enum em_partition partition, enum em_lists lists,
                                   int slices, struct em_scene **scene) {
  static struct em_error err; /* large */
  char how[3][64];
  snprintf(how[0], sizeof how[0], "engine.partition=%s", em_scene_partition_name(partition));
  snprintf(how[1], sizeof how[1], "engine.lists=%s", em_scene_lists_name(lists));
  snprintf(how[2], sizeof how[2], "engine.slices=%d", slices);
  const char *overrides[] = {how[0], how[1], how[2]};
  struct em_balls *balls = NULL;
  struct em_world *world = NULL;
  if (em_scene_parse(scene, scenes[which].text, scenes[which].name, 3, overrides, &err) ||
      em_start_make(&balls, *scene, NULL, NULL, &err) || em_world_new(&world, *scene, balls, &err))
    fail_msg("%s", err.text);
  em_start_free(balls);
  return world;
}

static void close_world(struct em_world *world, struct em_scene *scene) {
  em_world_free(world);
  em_scene_free(scene);
}

/* --- against brute force ---------------------------------------------------------------------- */

/* Time after now of the first contact of balls i and j, in any image. */
static double first_touch(const struct em_world *w, uint32_t i, uint32_t j, double now) {
  const struct em_vec r = em_vec_sub(em_body_at(w, j, now), em_body_at(w, i, now));
  const struct em_vec v = em_vec_sub(em_body_velocity(w, j, now), em_body_velocity(w, i, now));
  const double sigma = w->body[i].radius + w->body[j].radius;
  const int nx = w->period.x > 0.0 ? 2 : 0, ny = w->period.y > 0.0 ? 2 : 0;
  const int nz = w->period.z > 0.0 ? 2 : 0;
  const double cx = nx ? nearbyint(r.x / w->period.x) : 0.0;
  const double cy = ny ? nearbyint(r.y / w->period.y) : 0.0;
  const double cz = nz ? nearbyint(r.z / w->period.z) : 0.0;
  double first = INFINITY;
  for (int a = -nx; a <= nx; a++)
    for (int b = -ny; b <= ny; b++)
      for (int c = -nz; c <= nz; c++) {
        const struct em_vec d = {r.x - (cx + a) * w->period.x, r.y - (cy + b) * w->period.y,
                                 r.z - (cz + c) * w->period.z};
        first = fmin(first, em_surface_pair(d, v, sigma));
      }
  return first;
}

static bool holds(const uint32_t *list, uint32_t count, uint32_t j) {
  for (uint32_t k = 0; k < count; k++)
    if (list[k] == j) return true;
  return false;
}

/* All candidates of ball i in a copy; each once, and never i itself. */
static uint32_t copy_candidates(struct em_world *w, uint32_t i, uint32_t *copy) {
  uint32_t n;
  const uint32_t *id = w->partition_kind->candidates(w, i, &n);
  assert_true(n < w->count);
  if (n) memcpy(copy, id, n * sizeof *copy);
  assert_false(holds(copy, n, i));
  for (uint32_t k = 0; k < n; k++)
    assert_false(holds(copy, k, copy[k]));
  return n;
}

static void check_pairs(struct em_world *w, uint32_t i, double now, uint64_t *found) {
  uint32_t list[512];
  const uint32_t n = copy_candidates(w, i, list);
  for (uint32_t j = 0; j < w->count; j++) {
    if (j == i) continue;
    const double t = now + first_touch(w, i, j, now);
    if (t > w->plan[i].leave || t > w->plan[j].leave) continue;
    if (t < INFINITY) ++*found;
    if (t < INFINITY && !holds(list, n, j))
      fail_msg("%s: balls %u and %u touch at %g, before %g and %g", w->partition_kind->name, i, j,
               t, w->plan[i].leave, w->plan[j].leave);
  }
}

static void check_blades(const struct em_world *w, uint32_t i, double now, uint64_t *found) {
  const uint32_t mask = w->plan[i].near;
  const double horizon = w->plan[i].leave - now;
  for (uint32_t k = 0; k < w->blade_count && horizon > 0.0; k++) {
    const struct em_blade *b = &w->blade[k].blade;
    const double dt =
        em_surface_blade(b, em_body_at(w, i, now), em_body_velocity(w, i, now), w->gravity,
                         w->body[i].radius, b->angle + b->omega * now, false, horizon, NULL);
    if (dt > horizon) continue;
    ++*found;
    assert_true(mask & EM_NEAR_BLADE(k));
  }
}

static double inside(double x, double low, double period) {
  return period > 0.0 ? x - period * floor((x - low) / period) : x;
}

/* Gives ball i a new path at `now`: back towards the middle when it is near a wall. */
static void turn_ball(struct em_world *w, uint32_t i, double now, uint64_t *state) {
  struct em_body *b = &w->body[i];
  const struct em_vec x = em_body_at(w, i, now);
  const struct em_vec middle = em_vec_scale(0.5, em_vec_add(w->low, w->high));
  const struct em_vec half = em_vec_scale(0.4, em_vec_sub(w->high, w->low));
  const double speed = 2.0 * draw(state);
  struct em_vec v = {draw(state) - 0.5, draw(state) - 0.5, draw(state) - 0.5};
  if (w->period.x <= 0.0 && fabs(x.x - middle.x) > half.x) v.x = x.x > middle.x ? -0.5 : 0.5;
  if (w->period.y <= 0.0 && fabs(x.y - middle.y) > half.y) v.y = x.y > middle.y ? -0.5 : 0.5;
  if (w->period.z <= 0.0 && fabs(x.z - middle.z) > half.z) v.z = x.z > middle.z ? -0.5 : 0.5;
  b->x = inside(x.x, w->low.x, w->period.x);
  b->y = inside(x.y, w->low.y, w->period.y);
  b->z = inside(x.z, w->low.z, w->period.z);
  b->vx = speed * v.x;
  b->vy = draw(state) < 0.05 ? 0.0 : speed * v.y;
  b->vz = speed * v.z;
  b->t = now;
  w->partition_kind->moved(w, i);
}

/* Ball i crosses: what becomes a candidate must be among what is returned. */
static void cross_ball(struct em_world *w, uint32_t i, double now) {
  uint32_t before[512], after[512], fresh[512], n;
  const uint32_t n_before = copy_candidates(w, i, before);
  const uint32_t *id = w->partition_kind->cross(w, i, now, &n);
  assert_true(id || n == 0);
  assert_true(n < w->count);
  if (n) memcpy(fresh, id, n * sizeof *fresh);
  const uint32_t n_after = copy_candidates(w, i, after);
  for (uint32_t k = 0; k < n_after; k++)
    assert_true(holds(before, n_before, after[k]) || holds(fresh, n, after[k]));
  assert_true(w->plan[i].leave >= now);
  assert_false(holds(fresh, n, i));
}

/* Moves a ball on before its leave time, as far as that is allowed. */
static bool cross_early(struct em_world *w, uint32_t i, double now) {
  const struct em_vec v = em_body_velocity(w, i, w->plan[i].leave);
  const double left = w->plan[i].leave - now, speed = em_vec_norm(v) + w->fall * left;
  if (!(left > 0.0 && speed * left <= w->early)) return false;
  cross_ball(w, i, w->plan[i].leave);
  return true;
}

static void drive(struct em_world *w, uint64_t seed) {
  uint64_t state = seed, pairs = 0, hits = 0, crossings = 0, early = 0;
  double now = 0.0;
  w->clock = 0.0;
  int in_place = 0;
  for (int step = 0; step < 6000; step++) {
    uint32_t next = 0;
    for (uint32_t i = 1; i < w->count; i++)
      if (w->plan[i].leave < w->plan[next].leave) next = i;
    const double turn = now + 4e-5 * draw(&state);
    for (uint32_t i = 0; i < w->count; i++) {
      if (!cross_early(w, i, now)) continue;
      early++;
      check_pairs(w, i, now, &pairs);
      check_blades(w, i, now, &hits);
    }
    if (w->plan[next].leave <= turn) {
      in_place = w->plan[next].leave > now ? 0 : in_place + 1;
      assert_true(in_place < 20 * (int)w->count);
      now = fmax(now, w->plan[next].leave);
      cross_ball(w, next, now);
      crossings++;
      check_blades(w, next, now, &hits);
    } else {
      now = turn;
      next = (uint32_t)(draw(&state) * w->count);
      turn_ball(w, next, now, &state);
    }
    check_pairs(w, next, now, &pairs);
    if (step % 500 == 0) {
      assert_true(w->partition_kind->is_valid(w));
      for (uint32_t i = 0; i < w->count; i++) {
        check_pairs(w, i, now, &pairs);
        check_blades(w, i, now, &hits);
      }
    }
  }
  assert_true(w->count < 2 || pairs > 500); /* the test has tested something */
  assert_true(w->blade_count == 0 || hits > 10);
  assert_true(crossings + early > 10 || w->count < 2 || w->partition_kind == &em_partition_none);
  assert_true(early > 0 || w->early == 0.0 || w->count < 2);
}

static void test_nothing_is_left_out(void **unused) {
  (void)unused;
  for (size_t which = 0; which < SCENES; which++)
    for (int k = 0; k < EM_PARTITION_COUNT; k++) {
      struct em_scene *scene;
      struct em_world *w = open_world(which, (enum em_partition)k, EM_LISTS_CALENDAR, 0, &scene);
      drive(w, which + 1);
      close_world(w, scene);
    }
}

/* --- places ------------------------------------------------------------------------------------
 */

/* A ball somewhere in a sphere, slow enough for gravity to bend its path within it. */
static struct em_vec throw_ball(struct em_world *w, uint32_t i, double room, uint64_t *state) {
  struct em_body *b = &w->body[i];
  struct em_vec o;
  do
    o = em_vec_make(2.0 * draw(state) - 1.0, 2.0 * draw(state) - 1.0, 2.0 * draw(state) - 1.0);
  while (em_vec_norm2(o) > 1.0);
  const double speed = 0.6 * draw(state) * draw(state);
  b->vx = speed * (draw(state) - 0.5);
  b->vy = speed * (draw(state) - 0.5);
  b->vz = draw(state) < 0.05 ? 0.0 : speed * (draw(state) - 0.5);
  return em_vec_axpy(em_body_at(w, i, b->t), room, o);
}

/* How far from a point ball i gets until the time `end`, in `room`; counts those that go far. */
static double farthest(const struct em_world *w, uint32_t i, struct em_vec c, double end,
                       double room, uint64_t *far) {
  enum { STEPS = 200 };
  const double from = w->body[i].t, span = end < INFINITY ? end - from : 1.0;
  double most = 0.0;
  for (int k = 1; k <= STEPS; k++) {
    const struct em_vec x = em_body_at(w, i, from + span * k / STEPS);
    most = fmax(most, em_vec_norm(em_vec_sub(x, c)));
  }
  *far += most > 0.85 * room;
  return most;
}

/* Until its leave time a ball is in its place, wherever it was hit, by gravity or without. */
static void test_balls_stay_in_their_places(void **unused) {
  (void)unused;
  const double room = 0.002;
  for (size_t which = 0; which < SCENES; which++) {
    struct em_scene *scene;
    struct em_world *w = open_world(which, EM_PARTITION_NEIGHBOURS, EM_LISTS_CALENDAR, 0, &scene);
    uint64_t state = 7, far = 0, far_shell = 0;
    for (int n = 0; n < 20000; n++) {
      const struct em_vec c = throw_ball(w, 0, room, &state);
      const double most =
          farthest(w, 0, c, em_partition_stay(w, 0, w->body[0].t, c, room), room, &far);
      if (most > room * (1.0 + 1e-9)) fail_msg("%s: %g in %g m", scenes[which].name, most, room);
      if (w->lists->omega != 0.0) continue;
      struct em_shell *s = &w->lists->of[0].shell;
      *s = (struct em_shell){{(float)c.x, (float)c.y, (float)c.z}, (float)room};
      const struct em_vec d = {(double)s->centre[0], (double)s->centre[1], (double)s->centre[2]};
      w->partition_kind->moved(w, 0);
      const double out = farthest(w, 0, d, w->plan[0].leave, room, &far_shell);
      const double in = em_vec_norm(em_vec_sub(em_body_at(w, 0, w->body[0].t), d));
      if (out > fmax(in, room) * (1.0 + 1e-6))
        fail_msg("%s: %g in a shell of %g m", scenes[which].name, out, room);
    }
    assert_true(far > 1000 && (far_shell > 1000 || w->lists->omega != 0.0));
    close_world(w, scene);
  }
}

/* Where x (m), at the time t, is seen from shells that have turned since 0. */
static struct em_vec seen_from_shells(const struct em_world *w, struct em_vec x, double t) {
  const double c = cos(w->lists->omega * t), s = sin(w->lists->omega * t);
  return em_vec_make(c * x.x - s * x.z, x.y, s * x.x + c * x.z);
}

/* Is the centre of ball 0 beyond one of the drum's facets? */
static bool is_outside(const struct em_world *w, struct em_vec x) {
  return em_vec_dot(em_body_facet(w, x), x) + w->rho - w->body[0].radius < 0.0;
}

/* Anywhere between the facets, often in a corner, with a velocity that is often along the circle.
 */
static void throw_in_drum(struct em_world *w, uint64_t *state) {
  struct em_body *b = &w->body[0];
  const double reach = em_scene_reach(w->scene), turn = w->lists->omega;
  double r, angle;
  do {
    angle = 2.0 * M_PI * draw(state);
    r = reach * (0.6 + 0.3 * draw(state));
    b->x = r * cos(angle), b->y = 15.0, b->z = r * sin(angle);
  } while (is_outside(w, em_vec_make(b->x, b->y, b->z)));
  const double speed = turn * r * (4.0 * draw(state) - 2.0);
  const double along = angle + 0.5 * M_PI + (draw(state) - 0.5);
  b->vx = speed * cos(along), b->vy = 0.0, b->vz = speed * sin(along);
  b->t = 0.5 * w->epoch_length * draw(state);
}

/* In shells that turn, too, up to the corners of a drum with facets, which are further out than its
 * radius. */
static void test_balls_stay_in_turning_shells(void **unused) {
  (void)unused;
  static const char text[] =
      "chamber = { shape = \"drum\"; diameter = 10.0; length = 30.0; facets = 3; };"
      "rotor = ( { rpm = 60.0; point = [0.0, 0.0, 0.0]; radius = 0.3; reach = 2.0;"
      "  blades = ( { y = 10.0; angle_deg = 0.0; } ); } ); gravity = \"none\";"
      "balls = { count = 1; diameter = 1.0; start = \"table\";"
      "  table = ( [0.0, 15.0, 4.0, 8.0, 0.0, 0.0] ); }; engine = { skin = 1.0; };" GAS;
  enum { STEPS = 20 };
  struct trial t;
  trial_open(&t, text, "engine.partition=neighbours");
  struct em_world *w = t.world;
  struct em_shell *s = &w->lists->of[0].shell;
  uint64_t state = 7, far = 0;
  assert_true(w->lists->omega == 2.0);
  for (int n = 0; n < 200000; n++) {
    throw_in_drum(w, &state);
    const double from = w->body[0].t;
    const double angle = 2.0 * M_PI * draw(&state), off = draw(&state);
    const struct em_vec o = {off * cos(angle), 0.0, off * sin(angle)};
    const struct em_vec c = em_vec_add(o, seen_from_shells(w, em_body_at(w, 0, from), from));
    *s = (struct em_shell){{(float)c.x, (float)c.y, (float)c.z}, 1.0f};
    w->partition_kind->moved(w, 0);
    const double span = w->plan[0].leave - from;
    for (int k = 1; k <= STEPS; k++) {
      const double at = from + span * k / STEPS;
      const struct em_vec x = em_body_at(w, 0, at);
      if (is_outside(w, x)) break;
      const double out = em_vec_norm(em_vec_sub(seen_from_shells(w, x, at), c));
      far += out > 0.95;
      if (out > 1.0 + 1e-6) fail_msg("%g in a shell of 1 m", out);
    }
  }
  assert_true(far > 1000);
  trial_free(&t);
}

/* --- the same collisions ---------------------------------------------------------------------- */

struct print {
  uint64_t value, count;
};

static void see(void *self, const struct em_contact *c) {
  struct print *print = self;
  const double part[] = {c->time, c->place.x, c->place.y, c->place.z, c->vn, c->lost};
  print->value ^= ((uint64_t)c->ball << 32) ^ c->partner ^ ((uint64_t)c->cls << 60);
  for (size_t k = 0; k < sizeof part / sizeof part[0]; k++) {
    uint64_t bits;
    memcpy(&bits, &part[k], sizeof bits);
    print->value = (print->value ^ bits) * UINT64_C(0x9e3779b97f4a7c15);
    print->value ^= print->value >> 31;
  }
  print->count++;
}

static struct print run(size_t which, enum em_partition partition, enum em_lists lists,
                        int slices) {
  static struct em_error err; /* large */
  struct em_scene *scene;
  struct em_world *w = open_world(which, partition, lists, slices, &scene);
  struct print print = {0, 0};
  const struct em_observer observer = {&print, see};
  assert_int_equal(em_world_observe(w, &observer), EM_OK);
  if (em_world_run_collisions(w, 1000.0, 4000, NULL, &err)) fail_msg("%s", err.text);
  if (!em_world_is_valid(w, 1e-9, &err)) fail_msg("%s", err.text);
  close_world(w, scene);
  return print;
}

static void test_same_collisions(void **unused) {
  (void)unused;
  for (size_t which = 0; which < SCENES; which++) {
    const struct print expected = run(which, EM_PARTITION_NONE, EM_LISTS_TREE, 0);
    assert_int_equal(expected.count, 4000);
    for (int k = 0; k < EM_PARTITION_COUNT; k++)
      for (int l = 0; l < EM_LISTS_COUNT; l++) {
        const struct print got = run(which, (enum em_partition)k, (enum em_lists)l, 0);
        if (got.value != expected.value)
          fail_msg("%s: %s and %s differ from none and tree", scenes[which].name,
                   em_scene_partition_name((enum em_partition)k),
                   em_scene_lists_name((enum em_lists)l));
      }
    for (int slices = 1; slices <= 4; slices++)
      assert_true(run(which, EM_PARTITION_SLICES, EM_LISTS_CALENDAR, slices).value ==
                  expected.value);
  }
}

/* --- cells that become roomy -------------------------------------------------------------------
 */

#define CLOUD                                                                                \
  "chamber = { shape = \"box\"; size = [0.1, 0.1, 0.1]; periodic = [true, false, false]; };" \
  "gravity = \"none\"; balls = ( { name = \"large\"; count = 1; diameter = 0.012; },"        \
  "                             { name = \"small\"; count = 150; diameter = 0.003; } );" GAS

/* Small balls side by side in a few cells that fit the large one; they fly apart. */
static struct em_world *open_cloud(const char *partition, struct em_scene **scene) {
  static struct em_error err; /* large */
  const char *overrides[] = {partition};
  struct em_balls *balls = NULL;
  struct em_world *world = NULL;
  uint64_t state = 1;
  if (em_scene_parse(scene, CLOUD, "cloud", 1, overrides, &err) ||
      em_start_make(&balls, *scene, NULL, NULL, &err))
    fail_msg("%s", err.text);
  balls->position[0] = em_vec_make(0.04, 0.09, 0.09);
  for (size_t i = 1; i < balls->count; i++) {
    const double x = (double)(i % 6), y = (double)(i / 6 % 5), z = (double)(i / 30);
    balls->position[i] = em_vec_make(-0.04 + 0.0031 * x, 0.01 + 0.0031 * y, 0.01 + 0.0031 * z);
    balls->velocity[i] = em_vec_make(draw(&state) - 0.3, draw(&state) - 0.3, draw(&state) - 0.3);
  }
  if (em_world_new(&world, *scene, balls, &err)) fail_msg("%s", err.text);
  em_start_free(balls);
  return world;
}

static void test_cells_get_roomy(void **unused) {
  (void)unused;
  static struct em_error err; /* large */
  struct em_scene *scene[2];
  struct em_world *none = open_cloud("engine.partition=none", &scene[0]);
  struct em_world *cells = open_cloud("engine.partition=cells", &scene[1]);
  struct print expected = {0, 0}, got = {0, 0};
  assert_int_equal(em_world_observe(none, &(struct em_observer){&expected, see}), EM_OK);
  assert_int_equal(em_world_observe(cells, &(struct em_observer){&got, see}), EM_OK);
  const double crowded = em_world_bytes_per_ball(cells);
  if (em_world_run(none, 2.0, NULL, &err)) fail_msg("%s", err.text);
  if (em_world_run(cells, 2.0, NULL, &err)) fail_msg("%s", err.text);
  assert_true(em_world_bytes_per_ball(cells) < 0.8 * crowded);
  assert_true(expected.count > 500);
  assert_int_equal(got.count, expected.count);
  assert_int_equal(got.value, expected.value);
  if (!em_world_is_valid(cells, 1e-9, &err)) fail_msg("%s", err.text);
  close_world(none, scene[0]);
  close_world(cells, scene[1]);
}

/* A ball that turns right at the border of a cell, rising more slowly than time can tell, goes on
 * falling. */
static void test_turning_at_a_border(void **unused) {
  (void)unused;
  struct em_scene *scene;
  struct em_world *w = open_world(3, EM_PARTITION_CELLS, EM_LISTS_CALENDAR, 0, &scene);
  const struct em_blocks_axis *y = &w->places->axis[1];
  uint32_t i = 0;
  while (w->plan[i].cell[1] < 3 || w->plan[i].cell[1] + 2 > y->n)
    i++;
  assert_true(w->gravity.y < 0.0);
  const double border = y->border[w->plan[i].cell[1]];
  struct em_body *b = &w->body[i];
  for (double rise = 1e-10; rise > 1e-22; rise *= 1e-2) {
    double now = 1.0;
    b->y = border, b->vx = b->vz = 0.0, b->vy = rise, b->t = now;
    w->partition_kind->moved(w, i);
    for (int crossings = 0; w->plan[i].leave < 1.01; crossings++) {
      uint32_t n;
      assert_true(crossings < 20);
      now = fmax(now, w->plan[i].leave);
      w->partition_kind->cross(w, i, now, &n);
    }
  }
  close_world(w, scene);
}

static void test_too_many_slices(void **unused) {
  (void)unused;
  static struct em_error err; /* large */
  const char *overrides[] = {"engine.partition=slices", "engine.slices=100"};
  struct em_scene *scene = NULL;
  struct em_balls *balls = NULL;
  struct em_world *world = NULL;
  assert_int_equal(em_scene_parse(&scene, scenes[0].text, "drum", 2, overrides, &err), EM_OK);
  assert_int_equal(em_start_make(&balls, scene, NULL, NULL, &err), EM_OK);
  assert_int_equal(em_world_new(&world, scene, balls, &err), EM_INPUT);
  assert_non_null(strstr(err.text, "engine.slices"));
  em_start_free(balls);
  em_scene_free(scene);
}

/* In a short period the image that is nearest now, not at the last contact, is the one that is met.
 * Ball 0 flies round towards ball 1, from beyond half the period; ball 2, which comes nearer beside
 * it and would meet it just before, is hit by ball 3, the only contact until then. So what ball 0
 * expects becomes stale, and it has to find ball 1 again. The others rest, and make the bins of the
 * calendar short. */
static void test_few_contacts_in_a_short_period(void **unused) {
  (void)unused;
  enum { BALLS = 104 };
  static const char text[] =
      "chamber = { shape = \"box\"; size = [4.3, 40.0, 12.0]; periodic = [true, false, false]; };"
      "gravity = \"none\"; balls = { count = 104; diameter = 1.0; speed = 1.0; };" GAS;
  static const struct em_vec place[] = {
      {0.6, 4.0, 7.0}, {2.9, 4.3, 7.0}, {0.6, 2.94, 7.0}, {0.6, 2.94, 8.3}};
  static const struct em_vec speed[] = {
      {1.0, 0.0, 0.0}, {0.0, 0.0, 0.0}, {1.0, 0.05, 0.0}, {1.0, 0.0, -3.0}};
  static const char *const partition[] = {"none", "cells", "neighbours", "slices"};
  static struct em_error err; /* large */
  for (size_t k = 0; k < sizeof partition / sizeof *partition; k++) {
    char how[64];
    snprintf(how, sizeof how, "engine.partition=%s", partition[k]);
    const char *overrides[] = {how};
    struct em_scene *scene = NULL;
    struct em_balls *balls = NULL;
    struct em_world *w = NULL;
    assert_int_equal(em_scene_parse(&scene, text, "period", 1, overrides, &err), EM_OK);
    assert_int_equal(em_start_make(&balls, scene, NULL, NULL, &err), EM_OK);
    for (size_t i = 0; i < BALLS; i++) {
      const double row = (double)(i / 3), column = (double)(i % 3);
      balls->velocity[i] = i < 4 ? speed[i] : em_vec_make(0.0, 0.0, 0.0);
      balls->position[i] = i < 4 ? place[i]
                                 : em_vec_make(0.6 + 1.4 * column, 10.0 + 1.3 * floor(row / 4.0),
                                               1.0 + 1.3 * fmod(row, 4.0));
    }
    if (em_world_new(&w, scene, balls, &err)) fail_msg("%s", err.text);
    em_start_free(balls);
    if (em_world_run_collisions(w, 2.0, 2, NULL, &err)) fail_msg("%s", err.text);
    assert_true(fabs(em_world_time(w) - (2.3 - sqrt(0.91))) < 1e-12);
    close_world(w, scene);
  }
}

/* Along the shortest edge there may be, 2.05 diameters, two balls meet by turns as each other's two
 * images, at every 0.05 diameters of flight. */
static void test_both_images(void **unused) {
  (void)unused;
  static const char text[] =
      "chamber = { shape = \"box\"; size = [2.05, 9.0, 9.0]; periodic = true; }; gravity = "
      "\"none\";"
      "balls = { count = 2; diameter = 1.0; start = \"table\";"
      "  table = ( [0.0, 1.0, 1.0, 1.0, 0.0, 0.0], [1.00005, 1.0, 1.0, 0.0, 0.0, 0.0] ); };" GAS;
  for (int k = 0; k < EM_PARTITION_COUNT; k++)
    for (int l = 0; l < EM_LISTS_COUNT; l++) {
      struct trial t;
      trial_open(&t, text, "engine.partition=%s engine.lists=%s",
                 em_scene_partition_name((enum em_partition)k),
                 em_scene_lists_name((enum em_lists)l));
      trial_run(&t, 1.0);
      assert_int_equal(em_world_collisions(t.world), 20);
      trial_free(&t);
    }
}

/* Balls at the far ends of their shells, which are near each other but for the slack of a search in
 * a wide box, are half a short period apart, and meet on their way through new shells. */
static void test_far_ends_of_shells(void **unused) {
  (void)unused;
  static const char text[] =
      "chamber = { shape = \"box\"; size = [2.05, 600.0, 600.0]; periodic = [true, false, false]; "
      "};"
      "gravity = \"none\"; balls = { count = 2; diameter = 1.0; start = \"table\";"
      "  table = ( [0.5, 3.0, 3.0, 1.0, 0.0, 0.0], [1.52, 3.0, 3.0, -1.0, 0.0, 0.0] ); };" GAS;
  struct trial t;
  trial_open(&t, text, "engine.partition=neighbours engine.skin=1");
  struct em_world *w = t.world;
  const struct em_shell *s[] = {&w->lists->of[0].shell, &w->lists->of[1].shell};
  assert_true(w->lists->of[0].list.count == 1);
  const double skin = (double)s[0]->skin, room = 0.24 * (0.5 * 2.05 - 1.0);
  assert_true(skin > 0.9 * room);
  const double apart = 1.0 + 2.0 * skin + 0.27 * room; /* the slack: 0.28 of the room */
  em_world_free(w);
  t.balls->position[0].x = 0.5 - 0.7 * skin;
  t.balls->position[1].x = 0.5 + apart + 0.7 * skin;
  trial_world(&t);
  w = t.world;
  assert_true(w->lists->of[0].list.count == 1);
  w->body[0].x = 0.5 - 0.97 * skin;
  w->body[1].x = 0.5 + apart + 0.97 * skin;
  for (uint32_t i = 0; i < 2; i++)
    w->partition_kind->moved(w, i);
  assert_true(w->loop->predict_all(w));
  trial_run(&t, 0.02);
  assert_int_equal(em_world_collisions(w), 1);
  trial_free(&t);
}

/* A large ball in a short period comes near `small` balls on a dome before it all at once. What
 * stands behind the candidates that are new to it, up to a multiple of eight, is read as well, and
 * has to name balls, however many they are. */
static void meet_dome(size_t small) {
  static const char text[] =
      "chamber = { shape = \"box\"; size = [4.0, 20.0, 20.0]; periodic = [true, false, false]; };"
      "gravity = \"none\"; engine = { partition = \"neighbours\"; skin = 0.2; };"
      "balls = ( { name = \"large\"; count = 1; diameter = 1.0; },"
      "          { name = \"small\"; count = 1; diameter = 0.01; } );" GAS;
  struct trial t;
  trial_scene(&t, text, "balls.1.count=%zu", small);
  trial_balls(&t);
  t.balls->position[0] = em_vec_make(2.0, 10.0, 10.0);
  t.balls->velocity[0] = em_vec_make(0.0, 1.0, 0.0);
  for (size_t i = 1; i <= small; i++) {
    const double h = 0.2 + 0.8 * ((double)i - 0.5) / (double)small, angle = 2.4 * (double)i;
    const double side = 0.895 * sqrt(1.0 - h * h);
    t.balls->position[i] =
        em_vec_make(2.0 + side * cos(angle), 10.48 + 0.895 * h, 10.0 + side * sin(angle));
    t.balls->velocity[i] = em_vec_make(0.0, 0.0, 0.0);
  }
  trial_world(&t);
  assert_true(t.world->lists->of[0].list.count == 0);
  trial_run(&t, 0.35);
  assert_true(t.world->lists->of[0].list.count == small);
  trial_free(&t);
}

static void test_behind_new_candidates(void **unused) {
  (void)unused;
  mallopt(M_PERTURB, 85); /* memory that was not set names no balls */
  for (size_t small = 189; small < 200; small++)
    meet_dome(small);
  mallopt(M_PERTURB, 0);
}

/* Places are small where an edge is short, and balls leave thousands of them between two contacts;
 * lists that keep all predictions grow no longer by that. */
static void test_short_lists(void **unused) {
  (void)unused;
  static const char text[] =
      "chamber = { shape = \"box\"; size = [2.1, 20.0, 20.0]; periodic = true; };"
      "gravity = \"none\"; engine = { lists = \"all\"; };"
      "balls = { count = 20; diameter = 1.0; speed = 1.0; };" GAS;
  for (int k = 0; k < EM_PARTITION_COUNT; k++) {
    struct trial t;
    trial_open(&t, text, "engine.partition=%s", em_scene_partition_name((enum em_partition)k));
    const double bytes = em_world_bytes_of_events(t.world);
    trial_run(&t, 0.99 * t.world->epoch_length);
    assert_true(em_world_tally(t.world)->transfers > 20000);
    assert_true(em_world_bytes_of_events(t.world) <= 2.0 * bytes);
    trial_free(&t);
  }
}

/* --- neighbours in single precision ----------------------------------------------------------- */

#define CORNER "region = { low = [2, 2, 2]; high = [8, 8, 8]; };"

/* Balls of two sizes in the far corner of a cube that is `width` of the larger diameters wide. */
static enum em_status open_corner(const char *partition, double width, double diameter,
                                  struct em_scene **scene, struct em_world **w,
                                  struct em_error *err) {
  static const char text[] =
      "chamber = { shape = \"box\"; size = [9, 9, 9]; };"
      "gravity = \"none\"; engine = { skin = 0.2; };"
      "balls = ( { name = \"large\"; count = 30; diameter = 1.0; " CORNER " },"
      "          { name = \"small\"; count = 60; diameter = 0.5; " CORNER " } );" GAS;
  static const char *const entry[] = {"chamber.size", "balls.region.low", "balls.region.high"};
  const double at[] = {width * diameter, (width - 7.0) * diameter, (width - 1.0) * diameter};
  char how[6][128];
  const char *overrides[] = {partition, how[0], how[1], how[2], how[3], how[4], how[5]};
  struct em_balls *balls = NULL;
  for (size_t k = 0; k < 3; k++)
    snprintf(how[k], sizeof how[k], "%s=[%.17g,%.17g,%.17g]", entry[k], at[k], at[k], at[k]);
  snprintf(how[3], sizeof how[3], "balls.0.diameter=%.17g", diameter);
  snprintf(how[4], sizeof how[4], "balls.1.diameter=%.17g", 0.5 * diameter);
  snprintf(how[5], sizeof how[5], "balls.speed=%.17g", diameter);
  if (em_scene_parse(scene, text, "corner", 7, overrides, err) ||
      em_start_make(&balls, *scene, NULL, NULL, err))
    fail_msg("%s", err->text);
  const enum em_status status = em_world_new(w, *scene, balls, err);
  em_start_free(balls);
  return status;
}

static struct print run_corner(const char *partition, double width, double diameter) {
  static struct em_error err; /* large */
  struct em_scene *scene = NULL;
  struct em_world *w = NULL;
  struct print print = {0, 0};
  if (open_corner(partition, width, diameter, &scene, &w, &err)) fail_msg("%s", err.text);
  assert_int_equal(em_world_observe(w, &(struct em_observer){&print, see}), EM_OK);
  if (em_world_run(w, 10.0, NULL, &err)) fail_msg("%s", err.text);
  if (!em_world_is_valid(w, 1e-6 * w->smallest, &err)) fail_msg("%s", err.text);
  close_world(w, scene);
  return print;
}

/* With skins of 0.04 … 0.2 diameters they are resolved up to 19373 diameters, from 1.08e-15 m on.
 * Beyond, they are refused, and auto takes cells. */
static void test_single_precision(void **unused) {
  (void)unused;
  static const struct {
    double width, diameter;
    bool fits;
  } cases[] = {{20.0, 1.0, true},    {19300.0, 1.0, true},  {19400.0, 1.0, false},
               {1e8, 1.0, false},    {20.0, 1.1e-15, true}, {20.0, 1.05e-15, false},
               {20.0, 1e-22, false}, {10.0, 5e17, true},    {10.0, 6e17, false}};
  static struct em_error err; /* large */
  for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
    const double width = cases[k].width, d = cases[k].diameter;
    struct em_scene *scene = NULL;
    struct em_world *w = NULL;
    if (open_corner("engine.partition=auto", width, d, &scene, &w, &err)) fail_msg("%s", err.text);
    assert_ptr_equal(w->partition_kind,
                     cases[k].fits ? &em_partition_neighbours : &em_partition_cells);
    close_world(w, scene);
    const struct print expected = run_corner("engine.partition=none", width, d);
    assert_true(expected.count > 50);
    assert_int_equal(run_corner("engine.partition=auto", width, d).value, expected.value);
    if (cases[k].fits) continue;
    assert_int_equal(open_corner("engine.partition=neighbours", width, d, &scene, &w, &err),
                     EM_INPUT);
    assert_non_null(strstr(err.text, "engine.partition"));
    em_scene_free(scene);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_nothing_is_left_out),
      cmocka_unit_test(test_balls_stay_in_their_places),
      cmocka_unit_test(test_balls_stay_in_turning_shells),
      cmocka_unit_test(test_same_collisions),
      cmocka_unit_test(test_cells_get_roomy),
      cmocka_unit_test(test_turning_at_a_border),
      cmocka_unit_test(test_too_many_slices),
      cmocka_unit_test(test_few_contacts_in_a_short_period),
      cmocka_unit_test(test_both_images),
      cmocka_unit_test(test_far_ends_of_shells),
      cmocka_unit_test(test_behind_new_candidates),
      cmocka_unit_test(test_short_lists),
      cmocka_unit_test(test_single_precision),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
