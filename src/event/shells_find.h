/* The search for near shells, a template: FIND is the function's name, eight shells at a time. */

typedef float v8f __attribute__((vector_size(32)));
typedef int32_t v8i __attribute__((vector_size(32)));

static inline unsigned bits_of(v8i mask) {
#if defined(__AVX2__)
  return (unsigned)_mm256_movemask_ps((__m256)mask);
#elif defined(__SSE2__)
  union {
    v8i all;
    __m128 half[2];
  } m = {mask};
  return (unsigned)(_mm_movemask_ps(m.half[0]) | _mm_movemask_ps(m.half[1]) << 4);
#else
  unsigned bits = 0;
  for (int k = 0; k < 8; k++)
    bits |= (mask[k] & 1u) << k;
  return bits;
#endif
}

/* Appends the names of those of eight shells whose bits are set; writes up to eight places. */
static inline uint32_t *append(uint32_t *id, const float *name, unsigned near) {
#ifdef __AVX2__
  const __m256i order = _mm256_cvtepu8_epi32(_mm_loadl_epi64((const __m128i *)&PACK[near]));
  const __m256i all = _mm256_load_si256((const __m256i *)name);
  _mm256_storeu_si256((__m256i *)id, _mm256_permutevar8x32_epi32(all, order));
  return id + __builtin_popcount(near);
#else
  for (; near; near &= near - 1)
    memcpy(id++, name + __builtin_ctz(near), sizeof *id);
  return id;
#endif
}

/* The cells along one axis that a sphere can touch, each with the centre as seen from it and the
 * square of the least distance between the two. */
struct row {
  int cell[3], count;
  float centre[3], apart2[3];
};

static inline void row_of(const struct em_shells *s, int axis, float centre, double reach,
                          struct row *row) {
  const int n = s->n[axis];
  const double e = s->edge[axis], low = axis == 0 ? s->low.x : axis == 1 ? s->low.y : s->low.z;
  const double x = (double)centre - low;
  const float period = s->period[axis];
  int a = (int)floor((x - reach) * s->per_edge[axis]);
  int b = (int)floor((x + reach) * s->per_edge[axis]);
  if (period == 0.0f) {
    a = a < 0 ? 0 : a >= n ? n - 1 : a;
    b = b < 0 ? 0 : b >= n ? n - 1 : b;
  }
  row->count = 0;
  for (int k = a; k <= b && row->count < 3; k++) {
    const bool beyond = period == 0.0f && (k == 0 || k == n - 1); /* holds all outside as well */
    const double under = k * e - x, over = x - (k + 1) * e, far = under > over ? under : over;
    const int h = row->count++;
    row->cell[h] = k < 0 ? k + n : k >= n ? k - n : k;
    row->centre[h] = k < 0 ? centre + period : k >= n ? centre - period : centre;
    row->apart2[h] = beyond || far < 0.0 ? 0.0f : (float)(far * far);
  }
}

uint32_t FIND(const struct em_shells *s, const float centre[3], float hull, uint32_t *id,
              uint32_t most) {
  struct row rx, ry, rz;
  const double reach = (double)hull + s->hull_most + 2.0 * (double)s->slack;
  const float reach2 = (float)(1.00001 * reach * reach), wide = hull + s->slack;
  const uint32_t room = s->room;
  uint32_t *end = id;
  row_of(s, 0, centre[0], reach, &rx);
  row_of(s, 1, centre[1], reach, &ry);
  row_of(s, 2, centre[2], reach, &rz);
  for (int c = 0; c < rz.count; c++) {
    for (int b = 0; b < ry.count; b++) {
      const float left = reach2 - rz.apart2[c] - ry.apart2[b];
      if (left < 0.0f) continue;
      const int line = s->n[0] * (s->n[1] * rz.cell[c] + ry.cell[b]);
      for (int a = 0; a < rx.count; a++) {
        if (rx.apart2[a] > left) continue;
        const uint32_t held = s->held[line + rx.cell[a]];
        const float *e = s->block + (size_t)(line + rx.cell[a]) * EM_SHELLS_FIELDS * room;
        if (end + held + EM_SHELLS_STEP > id + most) return most;
        for (uint32_t k = 0; k < held; k += EM_SHELLS_STEP) {
          const v8f dx = *(const v8f *)(e + k) - rx.centre[a];
          const v8f dy = *(const v8f *)(e + room + k) - ry.centre[b];
          const v8f dz = *(const v8f *)(e + 2 * room + k) - rz.centre[c];
          const v8f r = *(const v8f *)(e + 3 * room + k) + wide;
          end = append(end, e + 4 * room + k, bits_of(dx * dx + dy * dy + dz * dz <= r * r));
        }
      }
    }
  }
  return (uint32_t)(end - id);
}
