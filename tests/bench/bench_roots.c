/* Time per call of the laws, the rules and the first contacts, on states as a mill has them. */
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "eventmill/contact.h"
#include "eventmill/surface.h"

enum { STATES = 4096, ROUNDS = 300 };

struct state {
  struct em_vec r, v;
  double horizon, angle;
  bool touched;
};

static struct state states[STATES];
static volatile double sink;

static double uniform(double low, double high) {
  return low + (high - low) * drand48();
}

static struct em_vec inside(double rho, double length) {
  const double phi = uniform(0.0, 2.0 * M_PI), r = rho * sqrt(drand48());
  return em_vec_make(r * cos(phi), uniform(0.0, length), r * sin(phi));
}

static double now(void) {
  struct timespec t;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void report(const char *what, double start, const char *note) {
  printf("%-44s %8.1f ns %s\n", what, (now() - start) * 1e9 / ((double)STATES * ROUNDS), note);
}

static void fill(double horizon) {
  srand48(1);
  for (int i = 0; i < STATES; i++) {
    states[i].r = inside(0.0705, 0.135);
    states[i].v = em_vec_make(uniform(-3, 3), uniform(-3, 3), uniform(-3, 3));
    states[i].horizon = horizon < INFINITY ? -horizon * log(1.0 - drand48()) : INFINITY;
    states[i].angle = uniform(-3, 3);
  }
}

static void on_the_wall(void) {
  for (int i = 0; i < STATES; i++) {
    struct state *s = &states[i];
    const double r = sqrt(s->r.x * s->r.x + s->r.z * s->r.z), k = 0.0705 / r;
    s->r.x *= k;
    s->r.z *= k;
    if (s->r.x * s->v.x + s->r.z * s->v.z > 0.0) s->v = em_vec_scale(-1.0, s->v);
  }
}

static void laws(void) {
  for (int law = 0; law < EM_LAW_COUNT; law++) {
    const struct em_restitution e = em_contact_law_default((enum em_law)law);
    double sum = 0.0;
    const double start = now();
    for (int round = 0; round < ROUNDS; round++)
      for (int i = 0; i < STATES; i++)
        sum += em_contact_restitution(&e, fabs(states[i].v.x));
    sink = sum;
    char what[64];
    snprintf(what, sizeof(what), "law %s", em_contact_law_name((enum em_law)law));
    report(what, start, "");
  }
}

static void rules(void) {
  for (int rule = 0; rule < EM_RULE_COUNT; rule++) {
    const struct em_contact_law law = {(enum em_rule)rule, em_contact_law_default(EM_LAW_CONSTANT),
                                       0.9, 0.1};
    double sum = 0.0;
    const double start = now();
    for (int round = 0; round < ROUNDS; round++)
      for (int i = 0; i < STATES; i++)
        sum += em_contact_impulse(&law, 1.0, em_vec_make(0.0, 0.6, -0.8), states[i].v, false, false)
                   .tangential.x;
    sink = sum;
    char what[64];
    snprintf(what, sizeof(what), "rule %s, constant law", em_contact_rule_name((enum em_rule)rule));
    report(what, start, "");
  }
}

/* The source's pair test: both roots, of which the lesser that lies ahead is the contact. */
static double two_roots(double b, double a, double c) {
  const double disc = b * b - a * c;
  if (disc < 0.0) return INFINITY;
  const double first = (-b - sqrt(disc)) / a, second = (-b + sqrt(disc)) / a;
  const double t = first < second ? first : second;
  return t > 0.0 ? t : INFINITY;
}

/* Balls that part are left out before the root; the first contact has one form. */
static double one_root(double b, double a, double c) {
  if (b >= 0.0) return INFINITY;
  const double disc = b * b - a * c;
  return disc < 0.0 ? INFINITY : c / (sqrt(disc) - b);
}

static inline __attribute__((always_inline)) void pairs(const char *what,
                                                        double (*root)(double, double, double)) {
  double sum = 0.0;
  const double start = now();
  for (int round = 0; round < ROUNDS; round++)
    for (int i = 0; i < STATES; i++) {
      const struct state *p = &states[i], *q = &states[(i + round + 1) % STATES];
      const struct em_vec d = em_vec_scale(0.1, em_vec_sub(q->r, p->r)), u = em_vec_sub(q->v, p->v);
      sum += fmin(1.0, root(em_vec_dot(d, u), em_vec_norm2(u), em_vec_norm2(d) - 2.5e-5));
    }
  sink = sum;
  report(what, start, "");
}

static void plane(void) {
  double sum = 0.0;
  const double start = now();
  for (int round = 0; round < ROUNDS; round++)
    for (int i = 0; i < STATES; i++)
      sum += fmin(1.0, em_surface_plane(states[i].r.y, states[i].v.y, -9.81, false));
  sink = sum;
  report("plane, with gravity", start, "");
}

static void drum(const char *what, double gravity, bool touched, enum em_quartic solver) {
  double sum = 0.0;
  const double start = now();
  for (int round = 0; round < ROUNDS; round++)
    for (int i = 0; i < STATES; i++) {
      const struct state *s = &states[i];
      sum += fmin(1.0, em_surface_drum(s->r.x, s->r.z, s->v.x, s->v.z, 0.0, -gravity, 0.0705,
                                       touched, solver, s->horizon));
    }
  sink = sum;
  char text[64];
  snprintf(text, sizeof(text), "drum %s", what);
  report(text, start, "");
}

static void drums(void) {
  drum("without gravity", 0.0, false, EM_QUARTIC_SAFE);
  for (int solver = 0; solver < EM_QUARTIC_COUNT; solver++)
    drum(em_surface_quartic_name((enum em_quartic)solver), 9.81, false, (enum em_quartic)solver);
  fill(3e-4);
  drum("safe, horizon 0.3 ms", 9.81, false, EM_QUARTIC_SAFE);
  fill(INFINITY);
  on_the_wall();
  for (int solver = 0; solver < EM_QUARTIC_COUNT; solver++) {
    char text[64];
    snprintf(text, sizeof(text), "%s, ball on the wall",
             em_surface_quartic_name((enum em_quartic)solver));
    drum(text, 9.81, true, (enum em_quartic)solver);
  }
}

static void blade(const char *what, enum em_tip tip, double near) {
  const struct em_blade b = {.centre = {0.0, 0.0675, 0.0},
                             .axis = {0.0, 1.0, 0.0},
                             .e1 = {0.0, 0.0, 1.0},
                             .omega = 178.0,
                             .radius = 0.006,
                             .reach = 0.058,
                             .tip = tip};
  double sum = 0.0;
  unsigned steps = 0;
  const double start = now();
  for (int round = 0; round < ROUNDS; round++)
    for (int i = 0; i < STATES; i++) {
      const struct state *s = &states[i];
      const struct em_vec r = {s->r.x, 0.0675 + (s->r.y - 0.0675) * near, s->r.z};
      sum += fmin(1.0, em_surface_blade(&b, r, s->v, em_vec_make(0.0, 0.0, -9.81), 0.0025, s->angle,
                                        false, s->horizon, &steps));
    }
  sink = sum;
  char note[64], text[64];
  snprintf(note, sizeof(note), " %.2f evaluations", steps / ((double)STATES * ROUNDS));
  snprintf(text, sizeof(text), "blade %s, %s", em_surface_tip_name(tip), what);
  report(text, start, note);
}

static void blades(void) {
  for (int tip = 0; tip < EM_TIP_COUNT; tip++) {
    fill(3e-4);
    blade("anywhere, horizon 0.3 ms", (enum em_tip)tip, 1.0);
    blade("in its slice, horizon 0.3 ms", (enum em_tip)tip, 0.126);
    fill(0.03);
    blade("in its slice, horizon 30 ms", (enum em_tip)tip, 0.126);
  }
}

int main(void) {
  fill(INFINITY);
  laws();
  rules();
  pairs("pair, two roots", two_roots);
  pairs("pair, one root", one_root);
  plane();
  drums();
  blades();
  return 0;
}
