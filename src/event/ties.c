/* Contacts at one and the same time: the heap. */
#include "event/ties.h"

#include <stdlib.h>

#include "event/body.h"

bool em_ties_make(struct em_ties *ties, uint32_t count) {
  ties->ball = em_body_array(count, sizeof *ties->ball);
  ties->tie = em_body_array(count, sizeof *ties->tie);
  if (!ties->ball || !ties->tie) {
    em_ties_free(ties);
    return false;
  }
  for (uint32_t i = 0; i < count; i++)
    ties->tie[i].place = ties->tie[i].met = EM_NOBODY;
  return true;
}

void em_ties_free(struct em_ties *ties) {
  free(ties->ball);
  free(ties->tie);
  *ties = (struct em_ties){0};
}

void em_ties_clear(struct em_ties *ties) {
  for (uint32_t k = 0; k < ties->count; k++) {
    struct em_tie *own = &ties->tie[ties->ball[k]];
    own->place = EM_NOBODY;
    if (own->with < EM_SURFACE) ties->tie[own->with].met = EM_NOBODY;
  }
  ties->count = 0;
}

static bool goes_before(const struct em_ties *ties, uint32_t a, uint32_t b) {
  const uint32_t with_a = ties->tie[a].with, with_b = ties->tie[b].with;
  const bool sa = with_a >= EM_SURFACE, sb = with_b >= EM_SURFACE;
  if (sa != sb) return sb;
  if (sa) return with_a != with_b ? with_a < with_b : a < b;
  const uint32_t la = a < with_a ? a : with_a, ha = a < with_a ? with_a : a;
  const uint32_t lb = b < with_b ? b : with_b, hb = b < with_b ? with_b : b;
  return la != lb ? la < lb : ha != hb ? ha < hb : a < b;
}

static void put(struct em_ties *ties, uint32_t place, uint32_t ball) {
  ties->ball[place] = ball;
  ties->tie[ball].place = place;
}

/* A ball takes `place`, or one nearer to the top, or below, where the order asks for it. */
static void settle(struct em_ties *ties, uint32_t place, uint32_t ball) {
  for (uint32_t up; place > 0; place = up) {
    up = (place - 1) / 2;
    if (!goes_before(ties, ball, ties->ball[up])) break;
    put(ties, place, ties->ball[up]);
  }
  for (uint32_t down; (down = 2 * place + 1) < ties->count; place = down) {
    if (down + 1 < ties->count && goes_before(ties, ties->ball[down + 1], ties->ball[down])) down++;
    if (!goes_before(ties, ties->ball[down], ball)) break;
    put(ties, place, ties->ball[down]);
  }
  put(ties, place, ball);
}

void em_ties_add(struct em_ties *ties, uint32_t ball, uint32_t with) {
  struct em_tie *own = &ties->tie[ball];
  own->with = with;
  if (with < EM_SURFACE) {
    own->next = ties->tie[with].met;
    ties->tie[with].met = ball;
  }
  settle(ties, ties->count++, ball);
}

void em_ties_remove(struct em_ties *ties, uint32_t ball) {
  struct em_tie *own = &ties->tie[ball];
  const uint32_t place = own->place;
  if (place == EM_NOBODY) return;
  if (own->with < EM_SURFACE) {
    uint32_t *link = &ties->tie[own->with].met;
    while (*link != ball)
      link = &ties->tie[*link].next;
    *link = own->next;
  }
  own->place = EM_NOBODY;
  if (place < --ties->count) settle(ties, place, ties->ball[ties->count]);
}

uint32_t em_ties_first(const struct em_ties *ties) {
  return ties->count ? ties->ball[0] : EM_NOBODY;
}
