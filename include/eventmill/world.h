/* The event engine: balls, surfaces, event lists, and the loop that works them off.
 *
 * A world is made from a scene and its start, run to a time, and asked for its state. It knows
 * neither files nor pictures: whoever wants to see what happens registers an observer. */
#ifndef EVENTMILL_WORLD_H
#define EVENTMILL_WORLD_H

#include <signal.h>
#include <stdint.h>

#include "eventmill/error.h"
#include "eventmill/scene.h"
#include "eventmill/start.h"

#ifdef __cplusplus
extern "C" {
#endif

struct em_world;

/* With whom a ball has a contact, as one code: another ball (its index) or a surface, EM_SURFACE +
 * the number of a wall (0, 1: x; 2, 3: y; 4, 5: z, the lower one first; or EM_WALL_DRUM) or a blade
 * (EM_SURFACE_BLADE, numbered rotor after rotor). */
enum { EM_WALL_DRUM = 6, EM_WALLS = 7 };
#define EM_SURFACE          0xFFF00000u
#define EM_NOBODY           0xFFFFFFFFu
#define EM_SURFACE_BLADE(k) (EM_SURFACE + EM_WALLS + (uint32_t)(k))

/* One contact, as observers see it. */
struct em_contact {
  double time; /* s since the start of the run */
  enum em_class cls;
  uint32_t ball;        /* index of the ball (the smaller one of a pair) */
  uint32_t partner;     /* the other ball; for EM_CLASS_BLADE the number of the blade, for DRUM
                           and END that of the wall, without EM_SURFACE */
  struct em_vec place;  /* m, point of contact */
  struct em_vec normal; /* unit vector from the partner to the ball */
  double vn, vt;        /* m/s, ≥ 0 */
  double lost;          /* J, kinetic energy (spin included) dissipated in the contact: what the
                           balls lost plus the work that a moving surface did on them */
  double work;          /* J, done by a moving surface on the ball; 0 for pairs */
};

/* Observers neither change the world nor ask about it: they are told in the midst of an event. Any
 * callback may be NULL. */
struct em_observer {
  void *self;
  void (*contact)(void *self, const struct em_contact *contact);
};

/* Histogram of v_n: EM_TALLY_PER_OCTAVE bins per factor of two, the edges of the bins of
 * an octave equally spaced; bin k begins at em_world_bin_edge(k). The first holds what lies below
 * as well, the last what lies above. */
enum {
  EM_TALLY_PER_OCTAVE = 64,
  EM_TALLY_OCTAVES = 40,
  EM_TALLY_LOWEST = -30,
  EM_TALLY_BINS = EM_TALLY_PER_OCTAVE * EM_TALLY_OCTAVES
};

/* What the engine counts while it runs; all since the start of the run. */
struct em_tally {
  uint64_t collisions[EM_CLASS_COUNT];
  double lost[EM_CLASS_COUNT];             /* J, dissipated */
  double collision_energy[EM_CLASS_COUNT]; /* J, Σ ½ m v_n² (20-2), m = m_eff */
  uint64_t vn[EM_CLASS_COUNT][EM_TALLY_BINS];
  double drum_work;                 /* J, done by a turning drum and its end walls */
  uint64_t tc, elastic, jam;        /* contacts on which a remedy acted */
  uint64_t stale, transfers;        /* invalid events; virtual events of the partition */
  uint64_t predictions, candidates; /* searches of one ball's next event; pairs tested */
  uint64_t blade_searches, blade_steps, epochs;
};

/* Per blade. */
struct em_blade_tally {
  double work;            /* J, done on the balls */
  double angular_impulse; /* N m s about the rotor's axis, given to the balls */
  uint64_t contacts;
};

/* All that is needed to continue bit for bit. Arrays of `count`, in the frame of the engine's own
 * epoch; spin may be NULL. A plain copy: owned by whoever made it. */
struct em_snapshot {
  uint32_t count, blade_count;
  double origin;                /* s since the start of the run: when the first epoch began */
  uint64_t epoch;               /* epochs gone */
  double clock;                 /* s within the epoch */
  struct em_vec *position;      /* m, at each ball's own time */
  struct em_vec *velocity;      /* m/s */
  struct em_vec *spin;          /* rad/s or NULL */
  double *time;                 /* s within the epoch: when the ball's last real event was */
  uint32_t *last;               /* code of the last partner, or EM_NOBODY */
  uint32_t *streak;             /* contacts in a row */
  double *blade_angle;          /* blade_count, rad at the epoch's start */
  struct em_blade_tally *blade; /* blade_count */
  struct em_tally tally;
};

/* Makes a world. Keeps a reference to scene, which must outlive it; copies what it needs of balls.
 * Errors: EM_MEMORY, EM_INPUT (balls outside or overlapping at the start; not as many as the scene
 * has, or one whose radius and mass, em_start_mass, are not those of its species). */
enum em_status em_world_new(struct em_world **world, const struct em_scene *scene,
                            const struct em_balls *balls, struct em_error *err);
void em_world_free(struct em_world *world);

/* Registers an observer; its pointer is copied. Errors: EM_MEMORY. */
enum em_status em_world_observe(struct em_world *world, const struct em_observer *observer);

/* Works off all events before `until` (s since the start; INFINITY: until all lie still). *stop,
 * when it turns non-zero, ends the run between two events (EM_STOPPED); stop may be NULL. Errors:
 * EM_COLLAPSE, EM_JAM: the state is that before the event in question; EM_INPUT: `until` is NAN;
 * EM_MEMORY: the world can only be freed. */
enum em_status em_world_run(struct em_world *world, double until, const volatile sig_atomic_t *stop,
                            struct em_error *err);

/* As em_world_run, but ends after `count` collisions as well. */
enum em_status em_world_run_collisions(struct em_world *world, double until, uint64_t count,
                                       const volatile sig_atomic_t *stop, struct em_error *err);

double em_world_time(const struct em_world *world); /* s since the start */
size_t em_world_count(const struct em_world *world);
size_t em_world_blade_count(const struct em_world *world);
uint64_t em_world_collisions(const struct em_world *world);
const struct em_tally *em_world_tally(const struct em_world *world);
const struct em_blade_tally *em_world_blade_tally(const struct em_world *world, size_t blade);

/* The state of all balls at `time` ≥ the world's time, as long as no event is due before: fills
 * balls (made by em_start_new with the world's count). Periodic positions are inside the box. */
void em_world_state(const struct em_world *world, double time, struct em_balls *balls);

/* Energies (J) of a state that em_world_state filled: kinetic (translation), spin, potential. */
struct em_energy {
  double kinetic, spin, potential;
};
struct em_energy em_world_energy(const struct em_world *world, const struct em_balls *balls);

/* Bin edges of em_tally.vn: lower edge of bin k (m/s), 0 ≤ k ≤ EM_TALLY_BINS. */
double em_world_bin_edge(size_t k);

/* A copy of all that a restart needs; em_world_snapshot_free. Errors: EM_MEMORY. */
enum em_status em_world_snapshot(const struct em_world *world, struct em_snapshot **snapshot,
                                 struct em_error *err);
/* A copy from which a world of another scene can go on: time, balls and blades are where they are
 * now, and the balls have met nobody yet. Between its contacts a ball's path depends on the scene,
 * and so does the length of an epoch. Errors: EM_MEMORY. */
enum em_status em_world_snapshot_now(const struct em_world *world, struct em_snapshot **snapshot,
                                     struct em_error *err);
/* A world that continues from a copy; one of em_world_snapshot belongs to its own scene. Radii and
 * masses are those of the scene, which must outlive the world. Errors: EM_MEMORY, EM_INPUT (a copy
 * that does not fit the scene, or from which no world can go on: times to come, balls outside,
 * numbers not finite). Balls are not checked for overlap. */
enum em_status em_world_resume(struct em_world **world, const struct em_scene *scene,
                               const struct em_snapshot *snapshot, struct em_error *err);
/* Room for a copy, all zero; NULL when memory is short. */
struct em_snapshot *em_world_snapshot_new(uint32_t count, uint32_t blade_count, bool spin);
void em_world_snapshot_free(struct em_snapshot *snapshot);

/* For `mill check`: the name of the loop's variant ("gravity+spin+rotor+remedies"), and the bytes
 * that a ball takes. */
const char *em_world_variant(const struct em_world *world);
double em_world_bytes_per_ball(const struct em_world *world);
/* Of these, the bytes for the events that a ball waits for. */
double em_world_bytes_of_events(const struct em_world *world);

/* Consistency of all lists, and no overlap beyond `tolerance` (m); for tests. Fills err with the
 * first fault. */
bool em_world_is_valid(const struct em_world *world, double tolerance, struct em_error *err);

#ifdef __cplusplus
}
#endif

#endif
