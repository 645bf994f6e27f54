/* A grid of cells that holds shells. */
#include "event/shells.h"
#include "event/vectors.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "event/body.h"
#include "event/fetch.h"

/* Shells per cell, where these are not too small for it: eight are looked at in one go. */
#define PER_CELL 3.0

#define FIND     find_plain
static uint32_t find_plain(const struct em_shells *s, const float centre[3], float hull,
                           uint32_t *id, uint32_t most);
#include "event/shells_find.h"

static size_t cells(const struct em_shells *s) {
  return (size_t)s->n[0] * (size_t)s->n[1] * (size_t)s->n[2];
}

static float *block_of(const struct em_shells *s, uint32_t cell) {
  return s->block + (size_t)cell * EM_SHELLS_FIELDS * s->room;
}

static void vacate(float *block, uint32_t room) {
  for (uint32_t k = 0; k < room; k++)
    block[k] = INFINITY;
}

/* Doubles the room of every cell. */
static bool widen(struct em_shells *s) {
  const uint32_t old = s->room, room = old ? 2 * old : EM_SHELLS_STEP;
  const size_t n = cells(s), step = (size_t)EM_SHELLS_FIELDS * room;
  float *block = em_body_array(n * step, sizeof *block);
  if (!block) return false;
  for (size_t c = 0; c < n; c++) {
    vacate(block + c * step, room);
    for (size_t f = 0; old && f < EM_SHELLS_FIELDS; f++)
      memcpy(block + c * step + f * room, s->block + (c * EM_SHELLS_FIELDS + f) * old,
             old * sizeof *block);
  }
  free(s->block);
  s->block = block;
  s->room = room;
  return true;
}

bool em_shells_resolve(struct em_vec low, struct em_vec high, double rounding, double hull) {
  const double far = hypot(hypot(fmax(fabs(low.x), fabs(high.x)), fmax(fabs(low.y), fabs(high.y))),
                           fmax(fabs(low.z), fabs(high.z)));
  return 0.5 * (double)FLT_EPSILON * far <= rounding && 4.0 * far * far <= (double)FLT_MAX &&
         (double)FLT_EPSILON * hull * hull >= (double)FLT_MIN;
}

double em_shells_slack(struct em_vec low, struct em_vec high) {
  return 1e-6 * (em_vec_norm(low) + 2.0 * em_vec_norm(em_vec_sub(high, low)));
}

static void set_cells(struct em_shells *s, struct em_vec extent) {
  const double length[3] = {extent.x, extent.y, extent.z};
  const double share = PER_CELL * extent.x * extent.y * extent.z / fmax(1.0, s->count);
  const double edge = fmax(2.0 * (s->hull_most + (double)s->slack), cbrt(share));
  for (int k = 0; k < 3; k++) {
    s->n[k] = length[k] > edge ? (int)(length[k] / edge) : 1;
    s->edge[k] = length[k] / s->n[k];
    s->per_edge[k] = 1.0 / s->edge[k];
    s->cells_per[k] = (float)s->per_edge[k];
    s->whole = s->whole || (s->period[k] > 0.0f && s->n[k] < 3);
  }
}

bool em_shells_init(struct em_shells *s, uint32_t count, struct em_vec low, struct em_vec high,
                    struct em_vec period, double hull_most, bool avx2) {
  const struct em_vec extent = em_vec_sub(high, low);
  *s = (struct em_shells){.count = count, .low = low, .hull_most = hull_most, .avx2 = avx2};
  s->period[0] = (float)period.x;
  s->period[1] = (float)period.y;
  s->period[2] = (float)period.z;
  s->lowest[0] = (float)low.x;
  s->lowest[1] = (float)low.y;
  s->lowest[2] = (float)low.z;
  s->slack = (float)em_shells_slack(low, high);
  set_cells(s, extent);
  s->held = em_body_array(cells(s), sizeof *s->held);
  s->cell = em_body_array(count, sizeof *s->cell);
  return s->held && s->cell && widen(s);
}

void em_shells_release(struct em_shells *s) {
  free(s->block);
  free(s->held);
  free(s->cell);
}

static int along(const struct em_shells *s, int axis, double x) {
  const int n = s->n[axis];
  const double k = x * s->per_edge[axis];
  return k < 0.0 ? 0 : k >= n ? n - 1 : (int)k;
}

static uint32_t cell_of(const struct em_shells *s, const float centre[3]) {
  const int a = along(s, 0, (double)centre[0] - s->low.x);
  const int b = along(s, 1, (double)centre[1] - s->low.y);
  const int c = along(s, 2, (double)centre[2] - s->low.z);
  return (uint32_t)(a + s->n[0] * (b + s->n[1] * c));
}

bool em_shells_enter(struct em_shells *s, uint32_t i, const float centre[3], float hull) {
  const uint32_t c = cell_of(s, centre);
  if (s->held[c] == s->room && !widen(s)) return false;
  const uint32_t k = s->held[c]++;
  float *e = block_of(s, c) + k;
  e[0] = centre[0];
  e[s->room] = centre[1];
  e[2 * s->room] = centre[2];
  e[3 * s->room] = hull;
  memcpy(e + 4 * s->room, &i, sizeof i);
  s->cell[i] = c;
  return true;
}

void em_shells_quit(struct em_shells *s, uint32_t i) {
  const uint32_t c = s->cell[i], last = --s->held[c], room = s->room;
  float *e = block_of(s, c);
  uint32_t k = 0;
  while (memcmp(e + 4 * room + k, &i, sizeof i) != 0)
    k++;
  for (uint32_t f = 0; f < EM_SHELLS_FIELDS; f++)
    e[f * room + k] = e[f * room + last];
  e[last] = INFINITY;
}

void em_shells_clear(struct em_shells *s) {
  const size_t n = cells(s);
  for (size_t c = 0; c < n; c++)
    vacate(block_of(s, (uint32_t)c), s->held[c]);
  memset(s->held, 0, n * sizeof *s->held);
}

static float nearest(float d, float period) {
  return period > 0.0f ? d - period * rintf(d / period) : d;
}

/* Where a periodic edge is short, all cells are searched. */
static uint32_t find_whole(const struct em_shells *s, const float centre[3], float hull,
                           uint32_t *id, uint32_t most) {
  uint32_t count = 0;
  for (size_t c = 0; c < cells(s); c++) {
    const float *e = block_of(s, (uint32_t)c);
    for (uint32_t k = 0; k < s->held[c] && count < most; k++) {
      const float dx = nearest(e[k] - centre[0], s->period[0]);
      const float dy = nearest(e[s->room + k] - centre[1], s->period[1]);
      const float dz = nearest(e[2 * s->room + k] - centre[2], s->period[2]);
      const float r = e[3 * s->room + k] + hull + s->slack;
      if (dx * dx + dy * dy + dz * dz <= r * r)
        memcpy(&id[count++], e + 4 * s->room + k, sizeof *id);
    }
  }
  return count;
}

uint32_t em_shells_find(const struct em_shells *s, const float centre[3], float hull, uint32_t *id,
                        uint32_t most) {
  if (s->whole) return find_whole(s, centre, hull, id, most);
#ifdef EM_HAVE_AVX2
  if (s->avx2) return em_shells_avx2_find(s, centre, hull, id, most);
#endif
  return find_plain(s, centre, hull, id, most);
}

void em_shells_fetch(const struct em_shells *s, const float centre[3], float hull) {
  if (s->whole) return;
  struct row rx, ry, rz;
  const float reach = reach_of(s, hull);
  row_of(s, 0, centre[0], reach, &rx);
  row_of(s, 1, centre[1], reach, &ry);
  row_of(s, 2, centre[2], reach, &rz);
  const size_t size = (size_t)EM_SHELLS_FIELDS * s->room;
  for (int c = 0; c < rz.count; c++)
    for (int b = 0; b < ry.count; b++) {
      const int line = s->n[0] * (s->n[1] * rz.cell[c] + ry.cell[b]);
      for (int a = 0; a < rx.count; a++) {
        const float *e = s->block + (size_t)(line + rx.cell[a]) * size;
        for (size_t k = 0; k < size; k += 16)
          em_fetch(e + k);
        em_fetch(&s->held[line + rx.cell[a]]);
      }
    }
}

size_t em_shells_bytes(const struct em_shells *s) {
  return s->count * sizeof *s->cell +
         cells(s) * (sizeof *s->held + EM_SHELLS_FIELDS * s->room * sizeof *s->block);
}

bool em_shells_holds(const struct em_shells *s, uint32_t i, const float centre[3]) {
  const uint32_t c = s->cell[i];
  if (c != cell_of(s, centre)) return false;
  for (uint32_t k = 0; k < s->held[c]; k++)
    if (memcmp(block_of(s, c) + 4 * s->room + k, &i, sizeof i) == 0) return true;
  return false;
}
