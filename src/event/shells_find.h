/* The search for near shells, a template: FIND is the function's name, eight shells at a time. */

/* Appends the names of those of eight shells whose bits are set; writes up to eight places. */
static inline uint32_t *append(uint32_t *id, const float *name, unsigned near) {
#ifdef __AVX2__
  _mm256_storeu_si256((__m256i *)id, pack(_mm256_load_si256((const __m256i *)name), near));
  return id + __builtin_popcount(near);
#else
  for (; near; near &= near - 1)
    memcpy(id++, name + __builtin_ctz(near), sizeof *id);
  return id;
#endif
}

/* The cells along one axis that a sphere can touch, each with the centre as seen from it. */
struct row {
  int cell[3], count;
  float centre[3];
};

static inline void row_of(const struct em_shells *s, int axis, float centre, float reach,
                          struct row *row) {
  const int n = s->n[axis];
  const float low = s->lowest[axis], per = s->cells_per[axis], period = s->period[axis];
  /* Shifted by one cell, so that cutting off is rounding down. */
  int a = (int)((centre - reach - low) * per + 1.0f) - 1;
  int b = (int)((centre + reach - low) * per + 1.0f) - 1;
  if (period == 0.0f) {
    a = a < 0 ? 0 : a >= n ? n - 1 : a;
    b = b < 0 ? 0 : b >= n ? n - 1 : b;
  }
  row->count = b - a < 2 ? b - a + 1 : 3; /* a fourth one is out of reach but for rounding */
  for (int h = 0; h < 3; h++) {
    const int k = a + h;
    row->cell[h] = k < 0 ? k + n : k >= n ? k - n : k;
    row->centre[h] = k < 0 ? centre + period : k >= n ? centre - period : centre;
  }
}

/* Not more than a cell's edge; one slack is for the rounding of the row. */
static inline float reach_of(const struct em_shells *s, float hull) {
  return hull + (float)s->hull_most + 2.0f * s->slack;
}

/* Empty places are infinitely far, so that whole vectors can be looked at. */
uint32_t FIND(const struct em_shells *s, const float centre[3], float hull, uint32_t *id,
              uint32_t most) {
  struct row rx, ry, rz;
  const float reach = reach_of(s, hull);
  const v8f wide = v8f_all(hull + s->slack);
  const size_t room = s->room, size = EM_SHELLS_FIELDS * room;
  const float *const block = s->block;
  const uint32_t *const held = s->held;
  const int nx = s->n[0], ny = s->n[1];
  uint32_t *end = id;
  row_of(s, 0, centre[0], reach, &rx);
  row_of(s, 1, centre[1], reach, &ry);
  row_of(s, 2, centre[2], reach, &rz);
  if (27 * room > most) return most;
  for (int c = 0; c < rz.count; c++) {
    const v8f z = v8f_all(rz.centre[c]);
    for (int b = 0; b < ry.count; b++) {
      const v8f y = v8f_all(ry.centre[b]);
      const int line = nx * (ny * rz.cell[c] + ry.cell[b]);
      for (int a = 0; a < rx.count; a++) {
        const int cell = line + rx.cell[a];
        const float *e = block + (size_t)cell * size;
        const v8f x = v8f_all(rx.centre[a]);
        size_t k = 0;
        do {
          const v8f dx = *(const v8f *)(e + k) - x;
          const v8f dy = *(const v8f *)(e + room + k) - y;
          const v8f dz = *(const v8f *)(e + 2 * room + k) - z;
          const v8f r = *(const v8f *)(e + 3 * room + k) + wide;
          end = append(end, e + 4 * room + k, v8i_bits(dx * dx + dy * dy + dz * dz <= r * r));
        } while ((k += EM_SHELLS_STEP) < held[cell]);
      }
    }
  }
  return (uint32_t)(end - id);
}
