/* The event loop, a template: loop_variants.h includes it once per set of effects.
 * Before each inclusion LOOP is the suffix of its functions, LOOP_NAME what users read, and
 * LOOP_FLAGS the set of EM_LOOP_*; what a set does not name is not compiled into it. Here is how
 * events follow each other; when a ball meets others is in loop_pairs.h, when it meets surfaces in
 * loop_surfaces.h, what a contact does in loop_contacts.h, and what memory is asked ahead for in
 * loop_ahead.h.
 *
 *     run               takes the first event of all, again and again:
 *       tidy            a bin of the calendar begins
 *       cross           a ball leaves its place: predict_pairs with those who are new to it, settle
 *       renew           a prediction is stale: predict
 *       untie           several have their events at one time: which goes first
 *       hit_ball        collide_pair, predict_two
 *       hit_surface     collide_surface, predict
 *     predict           predict_pairs, settle
 *       settle          predict_surfaces, schedule */

#define FN_JOIN(name, suffix) name##_##suffix
#define FN_MAKE(name, suffix) FN_JOIN(name, suffix)
#define FN(name)              FN_MAKE(name, LOOP)
#define WITH(effect)          ((LOOP_FLAGS & EM_LOOP_##effect) != 0)

/* --- moving on -------------------------------------------------------------------------------- */

static inline void FN(fly)(const struct em_world *w, struct em_body *b, double t) {
  const double dt = t - b->t;
  b->x = b->x + b->vx * dt, b->y = b->y + b->vy * dt, b->z = b->z + b->vz * dt;
  if (WITH(GRAVITY)) {
    const double h = 0.5 * dt * dt;
    b->x = b->x + w->gravity.x * h, b->y = b->y + w->gravity.y * h, b->z = b->z + w->gravity.z * h;
    b->vx = b->vx + w->gravity.x * dt;
    b->vy = b->vy + w->gravity.y * dt;
    b->vz = b->vz + w->gravity.z * dt;
  }
  b->t = t;
}

#include "event/loop_pairs.h"
#include "event/loop_surfaces.h"

/* --- prediction of all that a ball meets ------------------------------------------------------ */

static void FN(schedule)(struct em_world *w, uint32_t i) {
  queue_set(w, i, local_least(w, i));
}

/* After its contacts with balls: predicts those of ball i with surfaces, and files the earliest. */
static bool FN(settle)(struct em_world *w, uint32_t i, double now) {
  if (!FN(predict_surfaces)(w, i, now)) return false;
  FN(schedule)(w, i);
  return true;
}

/* Predicts all events of ball i anew. */
static bool FN(predict)(struct em_world *w, uint32_t i, double now) {
  const struct candidates c = candidates_of(w, i, 0);
  w->tally.predictions++;
  return FN(predict_pairs)(w, i, c.id, c.count, now, true) && FN(settle)(w, i, now);
}

/* Predicts all events of two balls that have just met. The processor works on the roots of one
 * while it waits for those of the other, if they are near enough to each other: a gain of 1.15. */
static __attribute__((noinline)) bool FN(predict_two)(struct em_world *w, uint32_t i, uint32_t j,
                                                      const struct candidates *of_i,
                                                      const struct candidates *of_j, double now) {
  w->tally.predictions += 2;
  w->tally.candidates += of_i->count + of_j->count;
  if (of_i->count <= FN(most) && of_j->count <= FN(most)) {
    struct FN(approaches) to_i, to_j;
    FN(approach)(w, i, of_i->id, of_i->count, now, true, &to_i);
    FN(approach)(w, j, of_j->id, of_j->count, now, true, &to_j);
    w->plan[i].first = FN(choose)(w, i, of_i->id, of_i->count, now, true, &to_i);
    w->plan[j].first = FN(choose)(w, j, of_j->id, of_j->count, now, true, &to_j);
  } else {
    w->plan[i].first = FN(best_of)(w, i, of_i->id, of_i->count, now);
    w->plan[j].first = FN(best_of)(w, j, of_j->id, of_j->count, now);
  }
  return FN(settle)(w, i, now) && FN(settle)(w, j, now);
}

static bool FN(predict_all)(struct em_world *w) {
  w->queue_kind->clear(w->queue, w->clock);
  em_ties_clear(&w->ties);
  w->contacts = 0;
  for (uint32_t i = 0; i < w->count; i++)
    w->plan[i].contact = 0;
  for (uint32_t i = 0; i < w->count; i++)
    if (!FN(predict)(w, i, w->clock)) return false;
  return true;
}

#include "event/loop_contacts.h"

/* --- the loop --------------------------------------------------------------------------------- */

static __attribute__((noinline)) void FN(moved)(struct em_world *w, uint32_t i) {
  if (w->cells)
    em_blocks_moved(w, i, WITH(GRAVITY), WITH(PERIODIC));
  else
    w->partition_kind->moved(w, i);
}

static __attribute__((noinline)) void FN(moved_in_shells)(struct em_world *w, uint32_t i,
                                                          uint32_t j) {
  em_neighbours_moved(w, i, j, WITH(GRAVITY), WITH(PERIODIC));
}

/* Balls i and j. */
static inline void FN(both_moved)(struct em_world *w, uint32_t i, uint32_t j) {
  if (w->lists && w->lists->omega == 0.0) {
    FN(moved_in_shells)(w, i, j);
    return;
  }
  FN(moved)(w, i);
  FN(moved)(w, j);
}

/* Ball i reaches the end of its place at the time `leave`. The images of others are those of `now`,
 * when these are in their places: until then a fast one may be elsewhere. Where all candidates are
 * found anew, what was predicted of them goes: it would be kept once more. */
static bool FN(cross)(struct em_world *w, uint32_t i, double leave, double now) {
  uint32_t n;
  const uint32_t *id = w->cells ? em_blocks_cross(w, i, leave, &n, WITH(GRAVITY), WITH(PERIODIC))
                                : w->partition_kind->cross(w, i, leave, &n);
  w->tally.transfers++;
  if (!id && n) return false;
  if (w->keeps_all && w->crosses_all) w->local_kind->clear(w->local, i);
  return FN(predict_pairs)(w, i, id, n, now, false) && FN(settle)(w, i, leave);
}

/* Takes a stale prediction of ball i out. */
static bool FN(renew)(struct em_world *w, uint32_t i, double now) {
  w->tally.stale++;
  if (!w->keeps_all) return FN(predict)(w, i, now);
  w->local_kind->pop(w->local, i);
  FN(schedule)(w, i);
  return true;
}

/* The event of ball i at t, which is no contact that holds. */
static inline bool FN(update)(struct em_world *w, uint32_t i, double t) {
  return w->plan[i].leave <= t ? FN(cross)(w, i, t, t) : FN(renew)(w, i, t);
}

/* Several balls move on at once from their cells; their candidates are tested together. */
static bool FN(cross_all)(struct em_world *w, const uint32_t *ball, uint32_t n, double now) {
  struct em_places *p = w->places;
  double leave[EM_BLOCKS_MANY];
  uint32_t all = 0;
  for (uint32_t k = 0; k < n; k++) {
    const uint32_t i = ball[k];
    const unsigned exit = p->plan[i].exit;
    leave[k] = p->plan[i].leave;
    if (!em_blocks_step(w, i, leave[k], WITH(GRAVITY), WITH(PERIODIC))) return false;
    const uint32_t end = (uint32_t)(em_blocks_new(p, i, exit, p->found + all) - p->found);
    for (; all < end; all += 8)
      *(v8iu *)(p->finder + all) = (v8iu){0} + (int32_t)i;
    all = end;
  }
  w->tally.transfers += n;
  FN(predict_mixed)(w, p->finder, p->found, all, now);
  for (uint32_t k = 0; k < n; k++)
    if (!FN(settle)(w, ball[k], leave[k])) return false;
  return true;
}

/* A bin of the calendar begins, with an event before `limit`, or there is nothing to do: of its
 * balls, those that leave their places in it are moved on at once, if they are near enough to the
 * border, and predictions that are stale are made anew. When that is done changes no contact, and
 * the processor, which cannot foretell what the next event is, goes through many of a kind without
 * wrong guesses: a gain of 1.1. */
static bool FN(tidy)(struct em_world *w, double limit) {
  uint32_t ball[FORESEEN], stays[FORESEEN], stale[FORESEEN];
  uint32_t leaving = 0, staying = 0, near = 0, rest = 0;
  const uint32_t n = em_calendar_peek(w->queue, 0, ball, FORESEEN);
  double next = INFINITY; /* event: of a crossing, perhaps, long after the last contact */
  fetch_bin(w, ball, n);
  for (uint32_t k = 0; k < n; k++) {
    const uint32_t i = ball[k];
    const bool leaves = leaves_first(w, i);
    next = em_lesser(w->plan[i].due, next);
    ball[leaving] = stays[staying] = i;
    leaving += leaves;
    staying += !leaves;
  }
  if (next >= limit) return true;
  const double now = em_greater(next, w->clock); /* all before it is worked off */
  for (uint32_t k = 0; k < staying; k++) {
    stale[rest] = stays[k];
    rest += !holds(w, stays[k], &w->plan[stays[k]].first);
  }
  fetch_lists(w, stays, staying, false);
  for (uint32_t k = 0; k < leaving; k++) {
    const struct em_body *b = &w->body[ball[k]];
    const double leave = w->plan[ball[k]].leave, fallen = w->fall * (leave - b->t);
    const double speed = sqrt(b->vx * b->vx + b->vy * b->vy + b->vz * b->vz) + fallen;
    ball[near] = ball[k];
    near += speed * (leave - now) <= w->early;
  }
  if (w->joins && w->cells && !w->places->centre) {
    if (!FN(cross_all)(w, ball, near, now)) return false;
  } else {
    for (uint32_t k = 0; k < near; k++)
      if (!FN(cross)(w, ball[k], w->plan[ball[k]].leave, now)) return false;
  }
  for (uint32_t k = 0; k < rest; k++)
    if (!FN(renew)(w, stale[k], now)) return false;
  fetch_lists(w, stays, staying, true);
  return true;
}

/* Balls i and j meet. Whom they may meet next the contact does not change: so it is asked before,
 * or meanwhile, and processor and memory work on both at a time: gains of 1.01 to 1.03, of 1.1 in a
 * dense gas of 10⁴ balls. */
static enum em_status FN(hit_ball)(struct em_world *w, uint32_t i, uint32_t j, double t,
                                   struct em_error *err) {
  struct candidates of_i = {NULL, 0}, of_j = {NULL, 0};
  if (w->joins && !w->cells) candidates_of_two(w, i, j, &of_i, &of_j);
  const enum em_status status = FN(collide_pair)(w, i, j, t, &of_i, &of_j, err);
  if (status) return status;
  w->clock = t;
  FN(both_moved)(w, i, j);
  const bool done = w->joins ? FN(predict_two)(w, i, j, &of_i, &of_j, t)
                             : FN(predict)(w, i, t) && FN(predict)(w, j, t);
  return done ? EM_OK : no_memory(err);
}

static enum em_status FN(hit_surface)(struct em_world *w, uint32_t i, uint32_t code, double t,
                                      struct em_error *err) {
  const enum em_status status = FN(collide_surface)(w, i, code, t, err);
  if (status) return status;
  w->clock = t;
  FN(moved)(w, i);
  return FN(predict)(w, i, t) ? EM_OK : no_memory(err);
}

/* Ball i, whose event may be one of those at t: what only updates lists is worked off, and if that
 * leaves a contact, it is entered, in place of another; not when the run is to stop. */
static __attribute__((cold)) bool FN(enter)(struct em_world *w, uint32_t i, double t) {
  em_ties_remove(&w->ties, i);
  while (local_least(w, i) <= t && !is_stopped(w)) {
    if (is_real(w, i, t)) {
      em_ties_add(&w->ties, i, local_first(w, i)->partner);
      return true;
    }
    if (!FN(update)(w, i, t)) return false;
  }
  return true;
}

/* All that were to meet ball i, which has met another. */
static __attribute__((cold)) bool FN(enter_others)(struct em_world *w, uint32_t i, double t) {
  for (uint32_t k = w->ties.tie[i].met, next; k != EM_NOBODY; k = next) {
    next = w->ties.tie[k].next;
    if (!FN(enter)(w, k, t)) return false;
  }
  return true;
}

/* After a contact at t among others: of those entered it moved its balls, and whoever was to meet
 * them. */
static __attribute__((cold)) bool FN(follow)(struct em_world *w, double t) {
  const uint32_t i = w->ties.last, with = w->ties.tie[i].with;
  const uint32_t j = with < EM_SURFACE ? with : i;
  em_ties_remove(&w->ties, i);
  em_ties_remove(&w->ties, j);
  return FN(enter_others)(w, i, t) && FN(enter_others)(w, j, t) && FN(enter)(w, i, t) &&
         FN(enter)(w, j, t);
}

/* All whose events are at t: they stand where the heap grows, which is never longer than what has
 * been entered of them. */
static __attribute__((cold)) bool FN(gather)(struct em_world *w, double t) {
  struct em_ties *ties = &w->ties;
  if (!ties->tie && !em_ties_make(ties, w->count)) return false;
  em_ties_clear(ties);
  const size_t n = w->queue_kind->tied(w->queue, ties->ball);
  for (size_t k = 0; k < n; k++)
    if (!FN(enter)(w, ties->ball[k], t)) return false;
  return true;
}

/* Several balls have their events at t: which goes first, when what only updates lists is worked
 * off; EM_NOBODY: no contact is left, or the run is to stop. False: no memory. */
static __attribute__((noinline, cold)) bool FN(untie)(struct em_world *w, double t,
                                                      uint32_t *first) {
  struct em_ties *ties = &w->ties;
  const bool known = ties->count > 0 && ties->last != EM_NOBODY && ties->time == t &&
                     w->contacts == ties->contacts + 1;
  if (known ? !FN(follow)(w, t) : !FN(gather)(w, t)) return false;
  *first = is_stopped(w) ? EM_NOBODY : em_ties_first(ties);
  ties->time = t, ties->last = *first, ties->contacts = w->contacts;
  return true;
}

static enum em_status FN(run)(struct em_world *w, double limit, uint64_t *left,
                              const volatile sig_atomic_t *stop, struct em_error *err) {
  uint64_t turns = 0;
  const bool bins = w->calendar && !w->keeps_all;
  const bool foresight = bins && w->count >= EM_FETCH_FROM && w->partition_kind->fetch;
  w->stop = stop;
  while (*left > 0) {
    if (bins && em_calendar_is_over(w->queue)) {
      if (!em_calendar_advance(w->queue)) return EM_OK;
      if (foresight) foresee(w);
      if (!FN(tidy)(w, limit)) return no_memory(err);
      continue;
    }
    double t;
    uint32_t rival, i = queue_first(w, &t, &rival);
    if (i == EM_QUEUE_NOBODY || t >= limit) return EM_OK;
    if (stop && (++turns & 255) == 0 && *stop)
      return em_error_set(err, EM_STOPPED, NULL, 0, "stopped on request");
    if (rival != i && !meet(w, i, rival)) {
      uint32_t next;
      if (!FN(untie)(w, t, &next)) return no_memory(err);
      if (next == EM_NOBODY) continue;
      i = next;
    }
    if (!is_real(w, i, t)) {
      if (!FN(update)(w, i, t)) return no_memory(err);
      continue;
    }
    const double at = t > w->clock ? t : w->clock;
    const uint32_t partner = local_first(w, i)->partner;
    const enum em_status status = partner < EM_SURFACE ? FN(hit_ball)(w, i, partner, at, err)
                                                       : FN(hit_surface)(w, i, partner, at, err);
    if (status) return status;
    --*left;
  }
  return EM_OK;
}

static const struct em_loop_kind FN(kind) = {
    .name = LOOP_NAME,
    .flags = LOOP_FLAGS,
    .lanes = LOOP_LANES,
    .predict_all = FN(predict_all),
    .run = FN(run),
};

#undef FN_JOIN
#undef FN_MAKE
#undef FN
#undef WITH
#undef LOOP
#undef LOOP_NAME
#undef LOOP_FLAGS
