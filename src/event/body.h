/* The inside of a world: what the loop, the partitions and the predictions share. */
#ifndef EVENTMILL_BODY_H
#define EVENTMILL_BODY_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "event/local.h"
#include "event/plan.h"
#include "event/queue.h"
#include "event/ties.h"
#include "event/vectors.h"
#include "eventmill/world.h"

/* The hot record of a ball, one cache line: its state at its own last real event. */
struct em_body {
  double x, y, z;    /* m */
  double vx, vy, vz; /* m/s */
  double t;          /* s within the epoch */
  double radius;     /* m */
} __attribute__((aligned(64)));

/* Numbers of balls that do not fit into the nearest caches any more, into the next ones neither. */
enum { EM_FETCH_CLOSE_FROM = 6000, EM_FETCH_FROM = 24576 };

/* Of a chamber's size, or of a radius: far more than rounding. Surfaces that a look ahead finds
 * nearer are searched for. */
#define EM_CLEARLY 1e-9

/* A ball's index leaves two bits to slots.h. */
#define EM_BALLS_MOST 0x3FFFFFFF

/* A blade with what the loop asks of it. */
struct em_turning {
  struct em_blade blade; /* angle: at the epoch's start */
  double swing;          /* m/s, speed of its tip */
  double hull;           /* m, half diagonal: no point of it is further from its centre */
  struct em_vec e3;      /* axis × e1 */
  double cos, sin, at;   /* of its angle at the time `at`, for bounds only */
};

struct em_partition_kind;
struct em_places;     /* opaque */
struct em_neighbours; /* see neighbours.h */

struct em_world {
  const struct em_scene *scene;
  uint32_t count;
  struct em_body *body;
  struct em_plan *plan;
  struct em_vec *spin;             /* rad/s; NULL when no rule knows spins */
  double *mass;                    /* kg; NULL when all are equal */
  double mass0, largest, smallest; /* kg; m, m: radii */

  struct em_vec gravity;
  double fall;                      /* |gravity| */
  double rho;                       /* m, drum: its radius */
  struct em_vec low, high;          /* m, of the chamber */
  struct em_vec period, per_period; /* m, 1/m; 0 where not periodic */
  bool drum;
  bool wall[EM_WALLS], walls;       /* which there are; any plane at all */
  uint32_t blade_count, few_blades; /* and the bits of the first 30: see EM_NEAR_BLADE */
  struct em_turning *blade;
  struct em_blade_tally *blade_tally;
  double drum_omega;    /* rad/s */
  uint32_t facets;      /* flat sides of the drum; 0: round */
  struct em_vec *facet; /* their inward normals; NULL: none */
  bool vectors;         /* pairs eight or four at a time, if the loop has as many lanes */
  /* Knobs beyond the choice of a quartic's solver; the drum's may be facets. */
  bool special_roots, special_drum, exact_pairs;
  double content; /* m: so far from drum or blade, searches may find a contact; 0: none of them */

  double origin;       /* s since the start: when the first epoch began */
  double epoch_length; /* s, a power of two */
  uint64_t epoch;
  double clock;  /* s within the epoch */
  double within; /* s: contacts in a row */
  /* s: what lies further in the past than rounding explains is no contact to come: when times are
   * moved back, their rounding can turn a pair that has just missed into one that has just touched.
   */
  double late;
  /* Contacts since everything was predicted anew. A prediction is stale when its partner has had
   * one since it was made; so whoever predicts need not ask anything of the partner. */
  uint32_t contacts;

  const struct em_queue_kind *queue_kind;
  struct em_queue *queue;
  bool calendar, keeps_all; /* which lists these are */
  const struct em_local_kind *local_kind;
  struct em_local *local;
  const struct em_partition_kind *partition_kind;
  struct em_places *places;    /* what the partition keeps */
  struct em_neighbours *lists; /* near-neighbour lists; NULL: there are none */
  bool cells;                  /* that these are cells */
  bool joins;                  /* the contacts of two balls that have met are predicted together */
  bool fetches_close;          /* memory is asked for their candidates before they meet */
  double early;                /* m before the end of its place that a ball may be moved on */
  bool crosses_all;            /* when a ball leaves its place, all its candidates are found anew */
  const struct em_loop_kind *loop;

  struct em_observer *observer;
  size_t observers;
  struct em_tally tally;
  struct em_ties ties;
  const volatile sig_atomic_t *stop; /* of the run that goes on; may be NULL */
};

/* The loop, compiled once per set of effects. */
enum em_loop_flag {
  EM_LOOP_GRAVITY = 1,
  EM_LOOP_SPIN = 2,
  EM_LOOP_ROTOR = 4,
  EM_LOOP_PERIODIC = 8,
  EM_LOOP_EXTRA = 16, /* remedies, ramps, facets, a turning drum, special roots */
};
struct em_loop_kind {
  const char *name;
  unsigned flags;
  unsigned lanes; /* doubles at a time: 8 with AVX-512, 4 with AVX2, else 1 */
  /* Predicts the next event of every ball anew; false: no memory. */
  bool (*predict_all)(struct em_world *world);
  /* Works off events before `limit` (s within the epoch), at most *left collisions. */
  enum em_status (*run)(struct em_world *world, double limit, uint64_t *left,
                        const volatile sig_atomic_t *stop, struct em_error *err);
};
const struct em_loop_kind *em_loop_find(unsigned flags, unsigned lanes);
const struct em_loop_kind *em_loop_avx2_find(unsigned flags);
const struct em_loop_kind *em_loop_avx512_find(unsigned flags);

/* Moves all times back by one epoch and predicts everything anew: times stay small, and with them
 * their rounding. */
bool em_body_next_epoch(struct em_world *world);

/* Have all balls finite states, and do none overlap by more than `tolerance` (m)? Fills err with
 * the first fault. */
bool em_world_valid_balls(struct em_world *world, double tolerance, struct em_error *err);
/* Can the engine go on from the state that a snapshot gave? Fills err with the first fault. */
bool em_world_valid_restart(const struct em_world *world, struct em_error *err);
/* Are the event lists and the partition consistent? Builds with assertions ask at each epoch. */
bool em_world_valid_lists(const struct em_world *world);

/* The balls of a snapshot. Radii and masses come from the scene; everything else from the snapshot.
 * em_start_free. Errors: EM_INPUT (the scene has another number of balls or blades), EM_MEMORY. */
enum em_status em_world_snapshot_balls(const struct em_scene *scene,
                                       const struct em_snapshot *snapshot, struct em_balls **balls,
                                       struct em_error *err);
/* Gives a world, before it has lists, the times, tallies, last partners and blades' angles of the
 * snapshot that its balls are from. */
void em_world_snapshot_restore(struct em_world *world, const struct em_snapshot *snapshot);

/* When balls i and j touch, in the precision that engine.polish asks for; shift: of the periodic
 * image, added to j − i. INFINITY: they don't. */
double em_body_exact_pair(const struct em_world *world, uint32_t i, uint32_t j,
                          struct em_vec shift);

/* How long until ball i reaches the drum, where knobs or facets ask for more than
 * em_surface_drum. */
double em_body_special_drum(const struct em_world *world, uint32_t i, bool touched, double horizon);

/* How far (m) a ball of radius r at x is from the drum's wall; negative: it is in it. */
double em_body_drum_gap(const struct em_world *world, struct em_vec x, double r);

/* Inward normal of the facet that is nearest to x. */
struct em_vec em_body_facet(const struct em_world *world, struct em_vec x);
/* The same where a ball with velocity v touches it: in a corner, where two are as near but for
 * rounding, the one against which it flies. */
struct em_vec em_body_facet_met(const struct em_world *world, struct em_vec x, struct em_vec v);

/* Memory on cache-line boundaries, zeroed; freed by free(). NULL: no memory. */
void *em_body_array(size_t count, size_t size);

/* Whole periods in a distance: 0 where the box is closed, for then per_period is 0. */
static inline double em_body_shift(double d, double period, double per_period) {
  return period * ((d * per_period + EM_NEAREST) - EM_NEAREST);
}

/* The shortest of a distance's periodic images. */
static inline struct em_vec em_body_nearest(const struct em_world *w, struct em_vec d) {
  return (struct em_vec){d.x - em_body_shift(d.x, w->period.x, w->per_period.x),
                         d.y - em_body_shift(d.y, w->period.y, w->per_period.y),
                         d.z - em_body_shift(d.z, w->period.z, w->per_period.z)};
}

/* Back into the box; as it is along closed axes, for there the period is 0. */
static inline struct em_vec em_body_wrap(const struct em_world *w, struct em_vec x) {
  return (struct em_vec){x.x - w->period.x * floor((x.x - w->low.x) * w->per_period.x),
                         x.y - w->period.y * floor((x.y - w->low.y) * w->per_period.y),
                         x.z - w->period.z * floor((x.z - w->low.z) * w->per_period.z)};
}

/* The time t (s within the epoch) since the start (s). */
static inline double em_body_absolute(const struct em_world *w, double t) {
  return w->origin + ((double)w->epoch * w->epoch_length + t);
}

/* Position of ball i at time t (s within the epoch). */
static inline struct em_vec em_body_at(const struct em_world *w, uint32_t i, double t) {
  const struct em_body *b = &w->body[i];
  const double dt = t - b->t, h = 0.5 * dt * dt;
  return (struct em_vec){b->x + b->vx * dt + w->gravity.x * h, b->y + b->vy * dt + w->gravity.y * h,
                         b->z + b->vz * dt + w->gravity.z * h};
}

/* Velocity of ball i at time t. */
static inline struct em_vec em_body_velocity(const struct em_world *w, uint32_t i, double t) {
  const struct em_body *b = &w->body[i];
  const double dt = t - b->t;
  return (struct em_vec){b->vx + w->gravity.x * dt, b->vy + w->gravity.y * dt,
                         b->vz + w->gravity.z * dt};
}

#endif
