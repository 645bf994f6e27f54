/* Partitions: which balls, and which blades, can a ball meet before it leaves its place?
 *
 * A partition keeps world.plan[i].leave for every ball: a time, never later than the moment from
 * which the candidates of i could be incomplete. Until both leave times, any two balls that can
 * touch are candidates of each other, and this holds, too, if each is moved on when it is still
 * world.early (m) of its way before its leave time. What is chosen never changes the sequence of
 * collisions. */
#ifndef EVENTMILL_PARTITION_H
#define EVENTMILL_PARTITION_H

#include "event/body.h"

struct em_partition_kind {
  const char *name;
  /* Makes world.places for the world's balls at its clock and sets all leave times. Reads the
   * world's scene, bodies, bounds, period and blades. Errors: EM_MEMORY, EM_INPUT; then
   * world.places stays NULL. */
  enum em_status (*make)(struct em_world *world, struct em_error *err);
  void (*free)(struct em_places *places);
  /* All candidates of ball i (i itself is not among them); valid until the next call. Behind them,
   * up to a multiple of eight, stand any balls; the same holds for cross. */
  const uint32_t *(*candidates)(struct em_world *world, uint32_t i, uint32_t *count);
  bool lasting; /* those of two balls can be asked for together: see candidates in loop_parts.h */
  /* Ball i moves along a new path since body[i].t: sets world.plan[i].leave. */
  void (*moved)(struct em_world *world, uint32_t i);
  /* Ball i reaches its leave time `now`, or will: re-places it, sets world.plan[i].leave > now
   * where it can, and returns candidates that may be new (a superset of the new ones is allowed;
   * where `make` has set world.crosses_all, all candidates).
   * Valid until the next call. NULL with *count > 0: no memory. */
  const uint32_t *(*cross)(struct em_world *world, uint32_t i, double now, uint32_t *count);
  /* A new epoch has begun: all times of the world, leave times too, have been moved back by its
   * length. NULL: nothing to do. Returns false when memory is short. */
  bool (*renew)(struct em_world *world);
  /* Asks memory for what `candidates` and `moved` will read of ball i: first what stands at its
   * number, later (`beyond`) what that points to, and what `cross` will read when it `leaves`.
   * NULL: nothing to ask for. */
  void (*fetch)(const struct em_world *world, uint32_t i, bool beyond, bool leaves);
  size_t (*bytes)(const struct em_places *places);
  bool (*is_valid)(const struct em_world *world);
};

/* What plan.near is made of, which `make` and `cross` set: the drum or any plane wall, and blade k:
 * the last bit stands for all further blades. */
#define EM_NEAR_WALL     0x80000000u
#define EM_NEAR_MANY     30
#define EM_NEAR_BLADE(k) (1u << ((k) < EM_NEAR_MANY ? (k) : EM_NEAR_MANY))

extern const struct em_partition_kind em_partition_neighbours;
extern const struct em_partition_kind em_partition_cells;
extern const struct em_partition_kind em_partition_slices;
extern const struct em_partition_kind em_partition_none;

/* Is single precision enough for the neighbours' shells in the chamber? */
bool em_partition_neighbours_fit(const struct em_world *world);

/* The one that the scene names, or the fastest for the world's balls. */
const struct em_partition_kind *em_partition_find(const struct em_world *world);

/* Packing fraction of the balls in the chamber. */
double em_partition_fraction(const struct em_world *world);

/* Latest safe time (s within the epoch) until which ball i, where it is at the time `from` (≥ its
 * own), stays within `room` (m) of the point c: a lower bound of the true time under gravity, never
 * before `from`. In a periodic box c is taken at its nearest image. */
double em_partition_stay(const struct em_world *world, uint32_t i, double from, struct em_vec c,
                         double room);

/* The blades, as bits EM_NEAR_BLADE, that a ball whose centre stays in the box c ± half can touch.
 */
uint32_t em_partition_blades(const struct em_world *world, struct em_vec c, double radius,
                             struct em_vec half);

#endif
