/* The slots of cells, eight at a time: taking the balls out of them. A slot holds the number of a
 * ball or of a crowd, or nothing. */
#ifndef EVENTMILL_EVENT_SLOTS_H
#define EVENTMILL_EVENT_SLOTS_H

#include <stdint.h>
#include <string.h>

#include "event/pack.h"

/* As signed numbers balls and crowds are not negative, an empty slot is. */
#define EM_SLOTS_EMPTY 0x80000000u
#define EM_SLOTS_CROWD 0x40000000u /* and the number of the crowd: see blocks.h */

#ifdef __AVX2__

typedef __m256i em_slots;

static inline em_slots em_slots_all(uint32_t number) {
  return _mm256_set1_epi32((int)number);
}

static inline em_slots em_slots_eight(const uint32_t *s) {
  return _mm256_loadu_si256((const __m256i *)s);
}

static inline em_slots em_slots_four(const uint32_t *s) {
  return _mm256_zextsi128_si256(_mm_loadu_si128((const __m128i *)s));
}

static inline long long em_slots_both(const uint32_t *s) {
  long long both;
  memcpy(&both, s, sizeof both);
  return both;
}

static inline em_slots em_slots_two(const uint32_t *s) {
  return _mm256_zextsi128_si256(_mm_loadl_epi64((const __m128i *)s));
}

static inline em_slots em_slots_twos(const uint32_t *a, const uint32_t *b, const uint32_t *c,
                                     const uint32_t *d) {
  return _mm256_set_epi64x(em_slots_both(d), em_slots_both(c), em_slots_both(b), em_slots_both(a));
}

static inline em_slots em_slots_join(em_slots a, em_slots b) {
  return _mm256_or_si256(a, b);
}

/* All but ball `self`. */
static inline em_slots em_slots_but(em_slots all, uint32_t self) {
  const __m256i here = _mm256_cmpeq_epi32(all, em_slots_all(self));
  return _mm256_or_si256(all, here);
}

/* Is there a crowd in slots that were joined? */
static inline int em_slots_crowded(em_slots joined) {
  return !_mm256_testz_si256(joined, em_slots_all(EM_SLOTS_CROWD));
}

/* Appends the balls and crowds of the slots whose bits are set; writes eight places. */
static inline uint32_t *em_slots_append(em_slots all, unsigned bits, uint32_t *end) {
#ifdef __AVX512F__
  const __mmask8 in = _mm256_mask_cmpge_epi32_mask((__mmask8)bits, all, _mm256_setzero_si256());
  _mm256_storeu_si256((__m256i *)end, _mm256_maskz_compress_epi32(in, all));
#else
  const unsigned in = ~(unsigned)_mm256_movemask_ps((__m256)all) & bits;
  _mm256_storeu_si256((__m256i *)end, pack(all, in));
#endif
  return end + __builtin_popcount(in);
}

#else

typedef struct {
  uint32_t slot[8];
} em_slots;

static inline em_slots em_slots_all(uint32_t number) {
  return (em_slots){{number, number, number, number, number, number, number, number}};
}

static inline em_slots em_slots_eight(const uint32_t *s) {
  em_slots all;
  memcpy(all.slot, s, sizeof all.slot);
  return all;
}

static inline em_slots em_slots_four(const uint32_t *s) {
  em_slots all = {{0}};
  memcpy(all.slot, s, 4 * sizeof *s);
  return all;
}

static inline em_slots em_slots_two(const uint32_t *s) {
  em_slots all = {{0}};
  memcpy(all.slot, s, 2 * sizeof *s);
  return all;
}

static inline em_slots em_slots_twos(const uint32_t *a, const uint32_t *b, const uint32_t *c,
                                     const uint32_t *d) {
  em_slots all;
  memcpy(all.slot, a, 2 * sizeof *a);
  memcpy(all.slot + 2, b, 2 * sizeof *b);
  memcpy(all.slot + 4, c, 2 * sizeof *c);
  memcpy(all.slot + 6, d, 2 * sizeof *d);
  return all;
}

static inline em_slots em_slots_join(em_slots a, em_slots b) {
  for (int k = 0; k < 8; k++)
    a.slot[k] |= b.slot[k];
  return a;
}

static inline em_slots em_slots_but(em_slots all, uint32_t self) {
  for (int k = 0; k < 8; k++)
    all.slot[k] = all.slot[k] == self ? EM_SLOTS_EMPTY : all.slot[k];
  return all;
}

static inline int em_slots_crowded(em_slots joined) {
  uint32_t any = 0;
  for (int k = 0; k < 8; k++)
    any |= joined.slot[k];
  return (any & EM_SLOTS_CROWD) != 0;
}

static inline uint32_t *em_slots_append(em_slots all, unsigned bits, uint32_t *end) {
  for (int k = 0; k < 8; k++) {
    *end = all.slot[k];
    end += (bits >> k & 1) & !(all.slot[k] >> 31);
  }
  return end;
}

#endif
#endif
