/* What a ball has before it and behind it, apart from its state: one cache line, for in a large
 * system each line that an event reads is waited for. */
#ifndef EVENTMILL_EVENT_PLAN_H
#define EVENTMILL_EVENT_PLAN_H

#include <stdint.h>

/* One predicted contact of a ball. */
struct em_prediction {
  double time;      /* s within the epoch */
  uint32_t partner; /* ball, or code of a surface */
  uint32_t made;    /* how many contacts there had been: see world.contacts */
};

struct em_plan {
  struct em_prediction first; /* its earliest contact: see local_first.h */
  double leave;               /* s: until when its candidates are complete: see partition.h */
  double due;                 /* s, of its next event, and */
  uint32_t place, later;      /* where it stands among the events: see calendar.h */
  uint32_t last;              /* partner of the last real event: ball, surface or EM_NOBODY */
  uint32_t streak;            /* contacts in a row, each within world.within of the one before */
  uint16_t cell[3], exit;     /* where it is: see blocks.h */
  uint32_t contact;           /* the number of its last contact: see world.contacts */
  uint32_t near;              /* surfaces that it can meet before it leaves: see partition.h */
} __attribute__((aligned(64)));

#endif
