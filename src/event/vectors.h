/* Vectors of eight floats, of four and of two doubles, for every processor. */
#ifndef EVENTMILL_EVENT_VECTORS_H
#define EVENTMILL_EVENT_VECTORS_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>
#ifdef __AVX2__
#include <immintrin.h>
#elif defined(__SSE2__)
#include <emmintrin.h>
#endif

/* Adding this and taking it away rounds to the nearest integer, for |x| < 2^51: to the same one as
 * the instructions do. */
#define EM_NEAREST 6755399441055744.0

typedef float v8f __attribute__((vector_size(32), may_alias));
typedef int32_t v8i __attribute__((vector_size(32), may_alias));
typedef int32_t v4i __attribute__((vector_size(16), may_alias, aligned(4)));
typedef int32_t v8iu __attribute__((vector_size(32), aligned(4), may_alias)); /* anywhere */

static inline v8f v8f_all(float a) {
  return (v8f){a, a, a, a, a, a, a, a};
}

/* Bit k: lane k of the mask is set. */
static inline unsigned v8i_bits(v8i mask) {
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

/* Bit k: lane k of the mask is set. */
static inline unsigned v4i_bits(v4i mask) {
#ifdef __SSE2__
  return (unsigned)_mm_movemask_ps((__m128)mask);
#else
  unsigned bits = 0;
  for (int k = 0; k < 4; k++)
    bits |= (mask[k] & 1u) << k;
  return bits;
#endif
}

/* --- two doubles ------------------------------------------------------------------------------ */

typedef double v2d __attribute__((vector_size(16), may_alias));
typedef int64_t v2l __attribute__((vector_size(16), may_alias));

static inline v2d v2d_choose(v2l mask, v2d yes, v2d no) {
#ifdef __AVX2__
  return _mm_blendv_pd(no, yes, (v2d)mask);
#else
  return (v2d)((mask & (v2l)yes) | (~mask & (v2l)no));
#endif
}

static inline v2d v2d_sqrt(v2d a) {
#ifdef __SSE2__
  return _mm_sqrt_pd(a);
#else
  return (v2d){sqrt(a[0]), sqrt(a[1])};
#endif
}

static inline v2d v2d_nearest(v2d a) {
#ifdef __AVX2__
  return _mm_round_pd(a, _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC);
#else
  return (a + EM_NEAREST) - EM_NEAREST;
#endif
}

static inline bool v2l_any(v2l mask) {
#ifdef __SSE2__
  return _mm_movemask_pd((v2d)mask) != 0;
#else
  return (mask[0] | mask[1]) != 0;
#endif
}

/* --- four doubles ----------------------------------------------------------------------------- */

typedef double v4d __attribute__((vector_size(32), may_alias));
typedef int64_t v4l __attribute__((vector_size(32), may_alias));

static inline v4d v4d_all(double a) {
  return (v4d){a, a, a, a};
}

/* Of the four doubles at a place the first three, and 0. */
static inline v4d v4d_three(const double *p) {
#ifdef __AVX2__
  return _mm256_blend_pd(_mm256_setzero_pd(), _mm256_loadu_pd(p), 7);
#else
  return (v4d){p[0], p[1], p[2], 0.0};
#endif
}

static inline v4l v4l_all(int64_t a) {
  return (v4l){a, a, a, a};
}

static inline v4l v4l_choose(v4l mask, v4l yes, v4l no) {
  return (mask & yes) | (~mask & no);
}

static inline v4d v4d_choose(v4l mask, v4d yes, v4d no) {
#ifdef __AVX2__
  return _mm256_blendv_pd(no, yes, (v4d)mask);
#else
  return (v4d)v4l_choose(mask, (v4l)yes, (v4l)no);
#endif
}

static inline v4d v4d_sqrt(v4d a) {
#ifdef __AVX2__
  return _mm256_sqrt_pd(a);
#else
  return (v4d){sqrt(a[0]), sqrt(a[1]), sqrt(a[2]), sqrt(a[3])};
#endif
}

static inline v4d v4d_nearest(v4d a) {
#ifdef __AVX2__
  return _mm256_round_pd(a, _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC);
#else
  return (a + EM_NEAREST) - EM_NEAREST;
#endif
}

static inline v4d v4d_least(v4d a, v4d b) {
  return v4d_choose(a < b, a, b);
}

/* The least of all, in every lane. */
static inline v4d v4d_least_of(v4d a) {
  const v4d half = v4d_least(a, __builtin_shufflevector(a, a, 2, 3, 0, 1));
  return v4d_least(half, __builtin_shufflevector(half, half, 1, 0, 3, 2));
}

/* Bit k: lane k of the mask is set. */
static inline unsigned v4l_bits(v4l mask) {
#if defined(__AVX2__)
  return (unsigned)_mm256_movemask_pd((v4d)mask);
#elif defined(__SSE2__)
  union {
    v4l all;
    __m128d half[2];
  } m = {mask};
  return (unsigned)(_mm_movemask_pd(m.half[0]) | _mm_movemask_pd(m.half[1]) << 2);
#else
  return (unsigned)((mask[0] & 1) | (mask[1] & 2) | (mask[2] & 4) | (mask[3] & 8));
#endif
}

/* The four doubles at each of four places, as four vectors: first of all, second of all … */
static inline void four_halves(const double *p0, const double *p1, const double *p2,
                               const double *p3, v4d *a, v4d *b, v4d *c, v4d *d) {
  const v4d r0 = *(const v4d *)p0, r1 = *(const v4d *)p1;
  const v4d r2 = *(const v4d *)p2, r3 = *(const v4d *)p3;
  const v4d even01 = __builtin_shufflevector(r0, r1, 0, 4, 2, 6);
  const v4d odd01 = __builtin_shufflevector(r0, r1, 1, 5, 3, 7);
  const v4d even23 = __builtin_shufflevector(r2, r3, 0, 4, 2, 6);
  const v4d odd23 = __builtin_shufflevector(r2, r3, 1, 5, 3, 7);
  *a = __builtin_shufflevector(even01, even23, 0, 1, 4, 5);
  *b = __builtin_shufflevector(odd01, odd23, 0, 1, 4, 5);
  *c = __builtin_shufflevector(even01, even23, 2, 3, 6, 7);
  *d = __builtin_shufflevector(odd01, odd23, 2, 3, 6, 7);
}

#endif
