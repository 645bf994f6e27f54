/* The local lists: what is predicted for each ball. A prediction is stale when its partner has
 * had a contact since it was made; nothing is deleted recursively. */
#ifndef EVENTMILL_LOCAL_H
#define EVENTMILL_LOCAL_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "event/plan.h"
#include "eventmill/scene.h"

struct em_local; /* opaque; each kind has its own */

/* An exchangeable kind of local list. */
struct em_local_kind {
  const char *name;
  bool keeps_all; /* false: only the earliest is kept; when that turns out stale, predict anew */
  /* plan: of each ball, outlives the lists. NULL: no memory. */
  struct em_local *(*make)(uint32_t count, struct em_plan *plan);
  void (*free)(struct em_local *local);
  void (*clear)(struct em_local *local, uint32_t ball);
  /* Enters a prediction; false: no memory. Equal times are allowed. */
  bool (*add)(struct em_local *local, uint32_t ball, const struct em_prediction *prediction);
  /* The earliest, or NULL; valid until the list changes. */
  const struct em_prediction *(*first)(const struct em_local *local, uint32_t ball);
  /* Takes the earliest out. */
  void (*pop)(struct em_local *local, uint32_t ball);
  size_t (*bytes)(const struct em_local *local);
  bool (*is_valid)(const struct em_local *local, uint32_t ball);
};

extern const struct em_local_kind em_local_tree;  /* threaded red-black tree of all predictions */
extern const struct em_local_kind em_local_first; /* the earliest only */

const struct em_local_kind *em_local_find(enum em_lists lists);

#endif
