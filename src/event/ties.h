/* Contacts at one and the same time, in the order in which they go: by class, then by index.
 *
 * They stand in a heap, so that n of them cost n log n. When one is worked off, whoever was to meet
 * either of its balls expects that in vain; they are found without looking through the rest. */
#ifndef EVENTMILL_EVENT_TIES_H
#define EVENTMILL_EVENT_TIES_H

#include <stdbool.h>
#include <stdint.h>

/* What a ball has to do with it. */
struct em_tie {
  uint32_t place; /* in the heap; EM_NOBODY: it has not been entered */
  uint32_t with;  /* whom it is to meet: ball, or code of a surface */
  uint32_t met;   /* a ball that is to meet it, EM_NOBODY: none; */
  uint32_t next;  /* and another one that is to meet the same as this */
};

struct em_ties {
  uint32_t count;
  uint32_t *ball;     /* the heap, with room for all balls */
  struct em_tie *tie; /* of each ball; NULL: no contacts have been at one time yet */
  double time;        /* s within the epoch: they share it */
  uint32_t last;      /* the ball whose contact went last, */
  uint32_t contacts;  /* and world.contacts before it */
};

/* Takes memory for contacts of `count` balls; false: there is none. */
bool em_ties_make(struct em_ties *ties, uint32_t count);
void em_ties_free(struct em_ties *ties);
void em_ties_clear(struct em_ties *ties);

/* Enters the contact of a ball that has not been entered, with a ball or a surface. Two balls that
 * meet may both be entered. O(log count). */
void em_ties_add(struct em_ties *ties, uint32_t ball, uint32_t with);
/* Takes it out; nothing happens where it has not been entered. O(log count), and as many steps as
 * balls are to meet the same one. */
void em_ties_remove(struct em_ties *ties, uint32_t ball);

/* The ball whose contact goes first, or EM_NOBODY. */
uint32_t em_ties_first(const struct em_ties *ties);

#endif
