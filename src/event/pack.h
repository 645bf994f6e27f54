/* Packing the chosen of eight 32-bit lanes, for AVX2. */
#ifndef EVENTMILL_EVENT_PACK_H
#define EVENTMILL_EVENT_PACK_H

#ifdef __AVX2__
#include <immintrin.h>
#include <stdint.h>

/* PACK[bits]: the places of the set bits, one byte each, lowest first. */
#define COUNT(bits)   __builtin_popcount(bits)
#define PART(bits, k) ((uint64_t)((bits) >> (k)&1) * (k) << 8 * COUNT((bits) & ((1u << (k)) - 1u)))
#define ONE(b) \
  (PART(b, 1) | PART(b, 2) | PART(b, 3) | PART(b, 4) | PART(b, 5) | PART(b, 6) | PART(b, 7))
#define FOUR(b)       ONE(b), ONE((b) + 1u), ONE((b) + 2u), ONE((b) + 3u)
#define SIXTEEN(b)    FOUR(b), FOUR((b) + 4u), FOUR((b) + 8u), FOUR((b) + 12u)
#define SIXTY_FOUR(b) SIXTEEN(b), SIXTEEN((b) + 16u), SIXTEEN((b) + 32u), SIXTEEN((b) + 48u)
static const uint64_t PACK[256] = {SIXTY_FOUR(0u), SIXTY_FOUR(64u), SIXTY_FOUR(128u),
                                   SIXTY_FOUR(192u)};
#undef COUNT
#undef PART
#undef ONE
#undef FOUR
#undef SIXTEEN
#undef SIXTY_FOUR

/* The lanes whose bits are set, side by side from the first on. */
static inline __m256i pack(__m256i all, unsigned bits) {
  const __m256i order = _mm256_cvtepu8_epi32(_mm_loadl_epi64((const __m128i *)&PACK[bits]));
  return _mm256_permutevar8x32_epi32(all, order);
}

#endif
#endif
