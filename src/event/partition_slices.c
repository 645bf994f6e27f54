/* Slices along y with check-in and check-out (Reichardt 11; Tab. 11-1).
 *
 * Slice k has the planes k w and (k + 1) w, and reaches beyond both by δ, a little more than the
 * largest radius. Balls that touch have the middle between them in some slice, and both are less
 * than δ from that middle: each ball's candidates are all balls of its slices. A ball is in one
 * slice, or, within δ of a plane, in two. The planes k w ± δ thus cut the axis into intervals, even
 * ones (inside slice c / 2) and odd ones (shared by two slices); a ball is in one interval until it
 * crosses a border. Going from an even one to an odd one is a check-in, the way back a check-out.
 *
 * All balls stand in one array, interval after interval, so that the candidates are one piece
 * of it, and going over to the next interval is one exchange at their common end. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "event/partition.h"
#include "event/span.h"

enum { MOST_SLICES = 26 /* unless the scene asks for more: the best of the reference */ };

struct em_places {
  uint32_t count;
  int slices, intervals;
  double low, width;   /* m: where slice 0 begins, distance of the planes */
  double delta, slack; /* m */
  double period;       /* m, along y; 0: closed */
  double room;         /* m: see em_span_room */
  struct em_vec *centre;
  int *interval;      /* of each ball */
  uint32_t *order;    /* all balls, by interval */
  uint32_t *position; /* of each ball in `order` */
  uint32_t *start;    /* of each interval in `order`, and the end */
  uint32_t *mask;     /* blades in each interval */
  uint32_t *found;    /* scratch: candidates */
};

static double low_of(const struct em_places *p, int c) {
  if (p->period <= 0.0 && c == 0) return -INFINITY;
  if (p->intervals == 1) return -INFINITY;
  return p->low + (c % 2 ? (c / 2 + 1) * p->width - p->delta : c / 2 * p->width + p->delta);
}

static double high_of(const struct em_places *p, int c) {
  if (p->period <= 0.0 && c == p->intervals - 1) return INFINITY;
  if (p->intervals == 1) return INFINITY;
  return p->low + (c / 2 + 1) * p->width + (c % 2 ? p->delta : -p->delta);
}

static int interval_of(const struct em_places *p, double y) {
  if (p->intervals == 1) return 0;
  double d = y - p->low;
  if (p->period > 0.0) d -= p->period * floor(d / p->period);
  int k = (int)floor(d / p->width);
  k = k < 0 ? 0 : k >= p->slices ? p->slices - 1 : k;
  const double inside = d - k * p->width;
  int c = 2 * k;
  if (inside < p->delta)
    c--;
  else if (inside > p->width - p->delta)
    c++;
  if (p->period > 0.0) return (c + p->intervals) % p->intervals;
  return c < 0 ? 0 : c >= p->intervals ? p->intervals - 1 : c;
}

/* y as it is seen from interval c. */
static double seen(const struct em_places *p, int c, double y) {
  const double k = c % 2 ? c / 2 + 1.0 : c / 2 + 0.5;
  return em_span_image(y, p->low + k * p->width, p->period);
}

static void set_leave(struct em_world *w, uint32_t i, double from) {
  const struct em_places *p = w->places;
  const int c = p->interval[i];
  const double y = seen(p, c, em_body_at(w, i, from).y), v = em_body_velocity(w, i, from).y;
  w->plan[i].near = EM_NEAR_WALL | p->mask[c];
  double leave = from + em_span_leave(y, v, w->gravity.y, low_of(p, c), high_of(p, c));
  if (p->centre) leave = fmin(leave, em_partition_stay(w, i, from, p->centre[i], p->room));
  w->plan[i].leave = fmin(leave, em_span_limit(w, from));
}

static void moved(struct em_world *w, uint32_t i) {
  set_leave(w, i, w->body[i].t);
}

static void exchange(struct em_places *p, uint32_t i, uint32_t place) {
  const uint32_t other = p->order[place], hole = p->position[i];
  p->order[hole] = other;
  p->position[other] = hole;
  p->order[place] = i;
  p->position[i] = place;
}

/* Moves ball i to the interval c, over all between. */
static void put(struct em_places *p, uint32_t i, int c) {
  int *at = &p->interval[i];
  for (; *at < c; ++*at)
    exchange(p, i, --p->start[*at + 1]);
  for (; *at > c; --*at)
    exchange(p, i, p->start[*at]++);
}

/* Copies the balls of the intervals first … last, except i. */
static uint32_t collect(struct em_places *p, uint32_t i, int first, int last) {
  uint32_t n = 0;
  for (int c = first; c <= last; c++) {
    int k = c;
    if (p->period > 0.0)
      k = (c + 2 * p->intervals) % p->intervals;
    else if (c < 0 || c >= p->intervals)
      continue;
    const uint32_t begin = p->start[k], held = p->start[k + 1] - begin;
    if (held) memcpy(p->found + n, p->order + begin, held * sizeof *p->found);
    if (k == p->interval[i]) p->found[n + p->position[i] - begin] = p->found[n + held - 1];
    n += k == p->interval[i] ? held - 1 : held;
  }
  return n;
}

static const uint32_t *candidates(struct em_world *w, uint32_t i, uint32_t *count) {
  struct em_places *p = w->places;
  const int c = p->interval[i], reach = p->intervals == 1 ? 0 : c % 2 ? 2 : 1;
  *count = collect(p, i, c - reach, c + reach);
  return p->found;
}

static const uint32_t *cross(struct em_world *w, uint32_t i, double now, uint32_t *count) {
  struct em_places *p = w->places;
  const int c = p->interval[i];
  const double y = seen(p, c, em_body_at(w, i, now).y), v = em_body_velocity(w, i, now).y;
  const int side = em_span_side(y, v, w->gravity.y, low_of(p, c), high_of(p, c), p->slack);
  const int next = (c + side + p->intervals) % p->intervals;
  put(p, i, next);
  if (p->centre) p->centre[i] = em_body_at(w, i, now);
  set_leave(w, i, now);
  if (p->centre) return candidates(w, i, count);
  const bool check_in = side && next % 2;
  *count = check_in
               ? side > 0 ? collect(p, i, next + 1, next + 2) : collect(p, i, next - 2, next - 1)
               : 0;
  return p->found;
}

/* Blades that reach, as they turn, a ball whose centre is in interval c. */
static uint32_t blades_in(const struct em_world *w, const struct em_places *p, int c) {
  uint32_t mask = 0;
  for (uint32_t k = 0; k < w->blade_count; k++) {
    const struct em_blade *b = &w->blade[k].blade;
    const double along = fabs(b->axis.y), across = sqrt(fmax(0.0, 1.0 - along * along));
    const double reach =
        w->blade[k].hull * across + b->radius * along + w->largest + 2.0 * p->slack + w->content;
    if (b->centre.y + reach < low_of(p, c) || b->centre.y - reach > high_of(p, c)) continue;
    mask |= EM_NEAR_BLADE(k);
  }
  return mask;
}

static void free_places(struct em_places *p) {
  if (!p) return;
  free(p->centre);
  free(p->interval);
  free(p->order);
  free(p->position);
  free(p->start);
  free(p->mask);
  free(p->found);
  free(p);
}

static enum em_status set_slices(struct em_world *w, struct em_places *p, struct em_error *err) {
  const double extent = w->high.y - w->low.y;
  const int wanted = w->scene->engine.slices;
  p->slack = 1e-6 * w->largest;
  p->delta = w->largest + 2.0 * p->slack;
  const double fit = extent / (2.0 * p->delta + 4.0 * p->slack);
  const int most = fit < 1.0 ? 1 : fit > 1e6 ? 1000000 : (int)fit;
  if (wanted > most)
    return em_error_set(err, EM_INPUT, w->scene->file, 0,
                        "engine.slices: %d slices are thinner than a ball of %g m; at most %d",
                        wanted, 2.0 * w->largest, most);
  p->slices = wanted > 0 ? wanted : most < MOST_SLICES ? most : MOST_SLICES;
  p->period = w->period.y;
  if (p->period > 0.0 && p->slices < 3) p->slices = 1;
  p->intervals = p->slices == 1 ? 1 : p->period > 0.0 ? 2 * p->slices : 2 * p->slices - 1;
  p->low = w->low.y;
  p->width = extent / p->slices;
  p->room = em_span_room(w);
  return EM_OK;
}

static bool take_arrays(struct em_places *p) {
  p->interval = em_body_array(p->count, sizeof *p->interval);
  p->order = em_body_array(p->count, sizeof *p->order);
  p->position = em_body_array(p->count, sizeof *p->position);
  p->found = em_body_array(p->count, sizeof *p->found);
  p->start = em_body_array((size_t)p->intervals + 1, sizeof *p->start);
  p->mask = em_body_array((size_t)p->intervals, sizeof *p->mask);
  if (p->room < INFINITY) p->centre = em_body_array(p->count, sizeof *p->centre);
  return p->interval && p->order && p->position && p->found && p->start && p->mask &&
         (p->centre || p->room == INFINITY);
}

/* Sorts the balls by interval. */
static void fill(struct em_world *w, struct em_places *p) {
  for (uint32_t i = 0; i < p->count; i++) {
    const struct em_vec x = em_body_at(w, i, w->clock);
    p->interval[i] = interval_of(p, x.y);
    p->start[p->interval[i] + 1]++;
    if (p->centre) p->centre[i] = x;
  }
  for (int c = 0; c < p->intervals; c++) {
    p->start[c + 1] += p->start[c];
    p->mask[c] = blades_in(w, p, c);
  }
  for (uint32_t i = p->count; i-- > 0;) {
    const uint32_t place = --p->start[p->interval[i] + 1];
    p->order[place] = i;
    p->position[i] = place;
  }
  /* start[c + 1] went down to the beginning of interval c: put it back in its own place */
  memmove(p->start, p->start + 1, (size_t)p->intervals * sizeof *p->start);
  p->start[p->intervals] = p->count;
  for (uint32_t i = 0; i < p->count; i++)
    set_leave(w, i, w->clock);
}

static enum em_status make(struct em_world *w, struct em_error *err) {
  struct em_places *p = calloc(1, sizeof *p);
  if (!p) return em_error_set(err, EM_MEMORY, NULL, 0, "no memory for the slices");
  p->count = w->count;
  const enum em_status status = set_slices(w, p, err);
  if (status || !take_arrays(p)) {
    free_places(p);
    return status ? status : em_error_set(err, EM_MEMORY, NULL, 0, "no memory for the slices");
  }
  w->places = p;
  w->crosses_all = p->centre;
  fill(w, p);
  return EM_OK;
}

static size_t bytes(const struct em_places *p) {
  const size_t each = sizeof *p->interval + sizeof *p->order + sizeof *p->position +
                      sizeof *p->found + (p->centre ? sizeof *p->centre : 0);
  const size_t slice = sizeof *p->start + sizeof *p->mask;
  return sizeof *p + p->count * each + (size_t)p->intervals * slice;
}

static bool is_valid(const struct em_world *w) {
  const struct em_places *p = w->places;
  if (p->start[0] != 0 || p->start[p->intervals] != p->count) return false;
  for (int c = 0; c < p->intervals; c++)
    if (p->start[c] > p->start[c + 1]) return false;
  for (uint32_t i = 0; i < p->count; i++) {
    const int c = p->interval[i];
    const uint32_t place = p->position[i];
    if (c < 0 || c >= p->intervals || place < p->start[c] || place >= p->start[c + 1]) return false;
    if (p->order[place] != i) return false;
  }
  return true;
}

const struct em_partition_kind em_partition_slices = {
    .name = "slices",
    .make = make,
    .free = free_places,
    .candidates = candidates,
    .moved = moved,
    .cross = cross,
    .bytes = bytes,
    .is_valid = is_valid,
};
