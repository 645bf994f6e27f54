/* Asks memory for a line that will be read some events from now.
 *
 * It is to come into the second cache, not the first, which is too small for the balls of two bins
 * of the calendar, and has too few lines under way at a time: a gain of 1.2 at 10⁵ balls, of 1.5 at
 * 10⁶. */
#ifndef EVENTMILL_EVENT_FETCH_H
#define EVENTMILL_EVENT_FETCH_H

static inline void em_fetch(const void *place) {
  __builtin_prefetch(place, 0, 2);
}

/* The same for a line that will be read within this event: into the first cache. */
static inline void em_fetch_close(const void *place) {
  __builtin_prefetch(place, 0, 3);
}

#endif
