/* The engine against a simulation as plain as can be: small steps and bisection, one contact after
 * the other, with laws and geometry of its own. Balls of two kinds that spin, a drum that turns one
 * way and blades that turn the other, oblique gravity, another rule for each class. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "support/trial.h"

static const char scene[] =
    "gravity=[0.7,-0.3,-9.81];"
    "chamber={shape=\"drum\";diameter=0.1;length=0.06;rpm=-300.0;};"
    "rotor={rpm=1500.0;radius=0.005;reach=0.03;blades=("
    "{y=0.015;angle_deg=20.0;tip=\"flat\";},"
    "{y=0.04;angle_deg=100.0;tip=\"hemisphere\";radius=0.006;});};"
    "balls=({count=40;diameter=0.005;density=7850.0;speed=2.0;},"
    "{count=15;diameter=0.008;density=3000.0;speed=3.0;});"
    "contact={rule=\"rough\";normal=\"spahn\";tangential=0.5;"
    "ball-drum={rule=\"friction\";normal={law=\"salo\";c=10.0;};tangential=-0.4;friction=0.2;};"
    "ball-end={rule=\"reichardt2005\";normal=0.7;tangential=0.7;};"
    "ball-blade={rule=\"rough\";normal=0.8;tangential=-0.6;};};"
    "remedy={jam_after=0;};seed=7;";

enum { BALLS = 55, CONTACTS = 1000 };
static const double PI = 3.14159265358979323846;
static const double DRUM = 0.05, LENGTH = 0.06;     /* m: radius, length */
static const double DRUM_TURNS = -300.0 / 60.0;     /* 1/s, about +y */
static const double ROTOR_TURNS = 1500.0 / 60.0;    /* 1/s, about +y */
static const double BAR_Y[2] = {0.015, 0.04};       /* m */
static const double BAR_ANGLE[2] = {20.0, 100.0};   /* degrees, from +z towards +x */
static const double BAR_RADIUS[2] = {0.005, 0.006}; /* m */
static const double REACH = 0.03;                   /* m, with the tip */
static const double STEP = 2e-6, FASTEST = 20.0;    /* s; m/s, that two surfaces approach */

/* Whom a ball can meet. */
enum kind { BALL, WALL, FIRST_END, SECOND_END, FLAT_BAR, ROUND_BAR, KINDS };

struct naive {
  struct em_vec x[BALLS], v[BALLS], w[BALLS], gravity;
  double radius[BALLS], mass[BALLS];
  double time;
  enum kind kind; /* the contact that has just been made */
  size_t i, j;
};

static struct em_vec unit(struct em_vec a) {
  return em_vec_scale(1.0 / em_vec_norm(a), a);
}

static struct em_vec after(const struct naive *n, size_t i, double s) {
  return em_vec_axpy(em_vec_axpy(n->x[i], s, n->v[i]), 0.5 * s * s, n->gravity);
}

static double clamp(double x, double most) {
  return x > most ? most : x < -most ? -most : x;
}

/* The point of a bar that is nearest to x, outside of it. */
static struct em_vec on_bar(int bar, struct em_vec x, double time) {
  const double angle = BAR_ANGLE[bar] * PI / 180.0 + 2.0 * PI * ROTOR_TURNS * time;
  const struct em_vec along = {sin(angle), 0.0, cos(angle)};
  const struct em_vec d = em_vec_sub(x, em_vec_make(0.0, BAR_Y[bar], 0.0));
  const double s = em_vec_dot(d, along), r = BAR_RADIUS[bar];
  struct em_vec inside; /* of the bar's axis, or of its cylinder: nearest there */
  if (bar == 1) {
    inside = em_vec_scale(clamp(s, REACH - r), along);
    inside = em_vec_axpy(inside, r, unit(em_vec_sub(d, inside)));
  } else {
    const struct em_vec across = em_vec_axpy(d, -s, along);
    const double share = fmin(1.0, r / em_vec_norm(across));
    inside = em_vec_axpy(em_vec_scale(clamp(s, REACH), along), share, across);
  }
  return em_vec_add(inside, em_vec_make(0.0, BAR_Y[bar], 0.0));
}

/* Distance of the surfaces `s` from now. */
static double gap(const struct naive *n, enum kind kind, size_t i, size_t j, double s) {
  const struct em_vec x = after(n, i, s);
  const double r = n->radius[i];
  switch (kind) {
  case BALL:
    return em_vec_norm(em_vec_sub(x, after(n, j, s))) - r - n->radius[j];
  case WALL:
    return DRUM - hypot(x.x, x.z) - r;
  case FIRST_END:
    return x.y - r;
  case SECOND_END:
    return LENGTH - x.y - r;
  case FLAT_BAR:
  case ROUND_BAR:
  case KINDS:
    break;
  }
  return em_vec_norm(em_vec_sub(x, on_bar(kind == ROUND_BAR, x, n->time + s))) - r;
}

/* When they touch within `most`, or `most`. Those that have just touched part first. */
static double touches(const struct naive *n, enum kind kind, size_t i, size_t j, double most) {
  const bool parts = kind == n->kind && i == n->i && (kind != BALL || j == n->j);
  double low = parts ? 1e-3 * STEP : 0.0, high = most;
  if (high <= low || gap(n, kind, i, j, low) > FASTEST * STEP || gap(n, kind, i, j, high) >= 0.0)
    return most;
  while (high - low > 1e-17) {
    const double middle = 0.5 * (low + high);
    if (middle <= low || middle >= high) break;
    *(gap(n, kind, i, j, middle) < 0.0 ? &high : &low) = middle;
  }
  return high;
}

/* Moves all on to the next contact, at most to `until`; false: there is none. */
static bool move(struct naive *n, double until) {
  for (;;) {
    double first = fmin(STEP, until - n->time);
    enum kind kind = KINDS;
    size_t one = 0, other = 0;
    for (size_t i = 0; i < BALLS; i++)
      for (int k = BALL; k < KINDS; k++)
        for (size_t j = k == BALL ? i + 1 : 0; j < (k == BALL ? (size_t)BALLS : 1); j++) {
          const double s = touches(n, (enum kind)k, i, j, first);
          if (s < first) first = s, kind = (enum kind)k, one = i, other = j;
        }
    for (size_t i = 0; i < BALLS; i++) {
      n->x[i] = after(n, i, first);
      n->v[i] = em_vec_axpy(n->v[i], first, n->gravity);
    }
    n->time += first;
    n->kind = kind, n->i = one, n->j = other;
    if (kind != KINDS) return true;
    if (n->time >= until) return false;
  }
}

/* Restitution, and the tangential impulse per sliding speed (kg), of the scene's classes. */
static void laws(enum kind kind, double m, double vn, double vt, double *epsilon, double *share) {
  const double stick = 2.0 / 7.0; /* of a solid sphere */
  switch (kind) {
  case BALL:
    *epsilon = 0.985 * pow(vn + 0.9494, -0.291), *share = stick * (1.0 - 0.5) * m;
    return;
  case WALL:
    *epsilon = 1.0 / (1.0 + vn / 10.0);
    *share = fmin(stick * (1.0 + 0.4) * m, 0.2 * (1.0 + *epsilon) * m * vn / vt);
    return;
  case FIRST_END:
  case SECOND_END:
    *epsilon = 0.7, *share = (1.0 - 0.7) * m;
    return;
  case FLAT_BAR:
  case ROUND_BAR:
  case KINDS:
    break;
  }
  *epsilon = 0.8, *share = stick * (1.0 + 0.6) * m;
}

static struct em_vec normal_of(const struct naive *n) {
  const struct em_vec x = n->x[n->i];
  switch (n->kind) {
  case BALL:
    return unit(em_vec_sub(x, n->x[n->j]));
  case WALL:
    return unit(em_vec_make(-x.x, 0.0, -x.z));
  case FIRST_END:
    return em_vec_make(0.0, 1.0, 0.0);
  case SECOND_END:
    return em_vec_make(0.0, -1.0, 0.0);
  case FLAT_BAR:
  case ROUND_BAR:
  case KINDS:
    break;
  }
  return unit(em_vec_sub(x, on_bar(n->kind == ROUND_BAR, x, n->time)));
}

/* Velocity of ball i's material at a place on its surface. */
static struct em_vec surface_of(const struct naive *n, size_t i, struct em_vec place) {
  return em_vec_add(n->v[i], em_vec_cross(n->w[i], em_vec_sub(place, n->x[i])));
}

/* Pushes ball i at a place. The rule reichardt2005 turns it by torque over mass, in SI units. */
static void push(struct naive *n, size_t i, struct em_vec place, struct em_vec impulse) {
  const bool source = n->kind == FIRST_END || n->kind == SECOND_END;
  const double inertia = n->mass[i] * (source ? 1.0 : 0.4 * n->radius[i] * n->radius[i]);
  const struct em_vec torque = em_vec_cross(em_vec_sub(place, n->x[i]), impulse);
  n->v[i] = em_vec_axpy(n->v[i], 1.0 / n->mass[i], impulse);
  n->w[i] = em_vec_axpy(n->w[i], 1.0 / inertia, torque);
}

static double energy(const struct naive *n, size_t i) {
  return 0.5 * n->mass[i] *
         (em_vec_norm2(n->v[i]) + 0.4 * n->radius[i] * n->radius[i] * em_vec_norm2(n->w[i]));
}

/* Makes the contact that move() has come to. */
static struct em_contact meet(struct naive *n, double *m) {
  static const enum em_class classes[] = {EM_CLASS_BALL, EM_CLASS_DRUM,  EM_CLASS_END,
                                          EM_CLASS_END,  EM_CLASS_BLADE, EM_CLASS_BLADE};
  static const uint32_t partners[] = {0, 6, 2, 3, 0, 1};
  const size_t i = n->i, j = n->j;
  const bool pair = n->kind == BALL, bar = n->kind == FLAT_BAR || n->kind == ROUND_BAR;
  const struct em_vec e = normal_of(n), place = em_vec_axpy(n->x[i], -n->radius[i], e);
  const double turns = bar ? ROTOR_TURNS : DRUM_TURNS;
  const struct em_vec wall = em_vec_cross(em_vec_make(0.0, 2.0 * PI * turns, 0.0), place);
  const struct em_vec g =
      em_vec_sub(surface_of(n, i, place), pair ? surface_of(n, j, place) : wall);
  const double vn = -em_vec_dot(g, e);
  const struct em_vec slide = em_vec_axpy(g, vn, e);
  const double before = energy(n, i) + (pair ? energy(n, j) : 0.0);
  double epsilon, share;
  *m = pair ? n->mass[i] * n->mass[j] / (n->mass[i] + n->mass[j]) : n->mass[i];
  laws(n->kind, *m, vn, em_vec_norm(slide), &epsilon, &share);
  const struct em_vec impulse =
      em_vec_axpy(em_vec_scale((1.0 + epsilon) * *m * vn, e), -share, slide);
  push(n, i, place, impulse);
  if (pair) push(n, j, place, em_vec_scale(-1.0, impulse));
  const double work = pair ? 0.0 : em_vec_dot(impulse, wall);
  return (struct em_contact){
      .time = n->time,
      .cls = classes[n->kind],
      .ball = (uint32_t)i,
      .partner = pair ? (uint32_t)j : partners[n->kind],
      .place = place,
      .normal = e,
      .vn = vn,
      .vt = em_vec_norm(slide),
      .lost = before + work - energy(n, i) - (pair ? energy(n, j) : 0.0),
      .work = work,
  };
}

struct seen {
  struct em_contact contact[CONTACTS];
  size_t count;
};

static void see(void *self, const struct em_contact *contact) {
  struct seen *seen = self;
  assert_true(seen->count < CONTACTS);
  seen->contact[seen->count++] = *contact;
}

static void near_to(double a, double b, double tolerance, const char *what, size_t k) {
  if (!(fabs(a - b) <= tolerance)) fail_msg("contact %zu: %s: %.17g, not %.17g", k, what, a, b);
}

static void near_vec(struct em_vec a, struct em_vec b, double tolerance, const char *what,
                     size_t k) {
  near_to(em_vec_norm(em_vec_sub(a, b)), 0.0, tolerance, what, k);
}

/* What the plain simulation is uncertain of grows from contact to contact. */
static void same(const struct em_contact *a, const struct em_contact *b, size_t k) {
  assert_int_equal(a->cls, b->cls);
  assert_int_equal(a->ball, b->ball);
  assert_int_equal(a->partner, b->partner);
  near_to(a->time, b->time, 1e-8, "time", k);
  near_vec(a->place, b->place, 1e-7, "place", k);
  near_vec(a->normal, b->normal, 1e-5, "normal", k);
  near_to(a->vn, b->vn, 1e-5, "vn", k);
  near_to(a->vt, b->vt, 1e-5, "vt", k);
  near_to(a->lost, b->lost, 1e-8, "lost", k);
  near_to(a->work, b->work, 1e-8, "work", k);
}

static void test_contact_by_contact(void **state) {
  (void)state;
  static const double until = 0.06; /* s */
  static struct seen seen;
  static struct naive n;
  const struct em_observer observer = {&seen, see};
  struct trial t;
  trial_open(&t, scene, "%s", "");
  assert_int_equal(t.balls->count, BALLS);
  n = (struct naive){.gravity = {0.7, -0.3, -9.81}, .kind = KINDS};
  for (size_t i = 0; i < BALLS; i++) {
    n.x[i] = t.balls->position[i], n.v[i] = t.balls->velocity[i], n.w[i] = t.balls->spin[i];
    n.radius[i] = i < 40 ? 0.0025 : 0.004;
    n.mass[i] = (i < 40 ? 7850.0 : 3000.0) * 4.0 / 3.0 * PI * pow(n.radius[i], 3.0);
  }
  assert_int_equal(em_world_observe(t.world, &observer), EM_OK);
  trial_run(&t, until);
  double energy_of[EM_CLASS_COUNT] = {0.0}, m;
  uint64_t by_kind[KINDS] = {0};
  for (size_t k = 0; move(&n, until); k++) {
    by_kind[n.kind]++;
    const struct em_contact expected = meet(&n, &m);
    if (k >= seen.count) fail_msg("only %zu contacts", seen.count);
    same(&seen.contact[k], &expected, k);
    energy_of[expected.cls] += 0.5 * m * expected.vn * expected.vn;
  }
  const struct em_tally *tally = em_world_tally(t.world);
  for (int c = 0; c < EM_CLASS_COUNT; c++)
    near_to(tally->collision_energy[c], energy_of[c], 1e-6 * energy_of[c], "energy", (size_t)c);
  for (int k = 0; k < KINDS; k++)
    assert_true(by_kind[k] >= 5);
  trial_free(&t);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_contact_by_contact)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
