/* Vectors of as many doubles as the processor of this translation unit works on at a time: eight
 * with AVX-512, else four. Each lane has the bits of the scalar operation. */
#ifndef EVENTMILL_EVENT_LANES_H
#define EVENTMILL_EVENT_LANES_H

#include "event/vectors.h"

#ifdef __AVX512F__

enum { LANES = 8 };
typedef double vd __attribute__((vector_size(64), may_alias));
typedef int64_t vl __attribute__((vector_size(64), may_alias));
typedef __mmask8 vm; /* a set of lanes */

static inline vd vd_all(double a) {
  return _mm512_set1_pd(a);
}

static inline vl vl_all(int64_t a) {
  return (vl)_mm512_set1_epi64(a);
}

static inline vm vd_below(vd a, vd b) {
  return _mm512_cmp_pd_mask(a, b, _CMP_LT_OQ);
}

static inline vm vd_at_most(vd a, vd b) {
  return _mm512_cmp_pd_mask(a, b, _CMP_LE_OQ);
}

static inline vm vd_equal(vd a, vd b) {
  return _mm512_cmp_pd_mask(a, b, _CMP_EQ_OQ);
}

static inline vm vm_below(uint32_t n) {
  return (vm)((1u << (n < 8 ? n : 8)) - 1u);
}

/* 0, 1, 2 … */
static inline vl vl_lanes(void) {
  return (vl){0, 1, 2, 3, 4, 5, 6, 7};
}

/* Or b where one is no number. */
static inline vd vd_greater(vd a, vd b) {
  return _mm512_max_pd(a, b);
}

static inline unsigned vm_bits(vm in) {
  return in;
}

/* The lanes whose bits are set. */
static inline vm vm_of(unsigned bits) {
  return (vm)bits;
}

static inline vd vd_choose(vm in, vd yes, vd no) {
  return _mm512_mask_blend_pd(in, no, yes);
}

/* By the sign bits. */
static inline vd vd_choose_negative(vl sign, vd yes, vd no) {
  return vd_choose(_mm512_movepi64_mask((__m512i)sign), yes, no);
}

static inline vl vl_choose(vm in, vl yes, vl no) {
  return (vl)_mm512_mask_blend_epi64(in, (__m512i)no, (__m512i)yes);
}

static inline vd vd_sqrt(vd a) {
  return _mm512_sqrt_pd(a);
}

static inline vd vd_nearest(vd a) {
  return _mm512_roundscale_pd(a, _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC);
}

static inline double vd_least_of(vd a) {
  return _mm512_reduce_min_pd(a);
}

/* The eight doubles of each of eight records, as eight vectors: first of all, second of all … */
static inline __attribute__((always_inline)) void
vd_records(const double *base, const uint32_t id[LANES], vd field[8]) {
  vd r[8], s[8], t[8];
  for (int k = 0; k < 8; k++)
    r[k] = *(const vd *)(base + 8 * (size_t)id[k]);
  for (int k = 0; k < 8; k += 2) {
    s[k] = _mm512_unpacklo_pd(r[k], r[k + 1]);
    s[k + 1] = _mm512_unpackhi_pd(r[k], r[k + 1]);
  }
  for (int k = 0; k < 2; k++) {
    t[k] = _mm512_shuffle_f64x2(s[k], s[k + 2], 0x88);
    t[k + 2] = _mm512_shuffle_f64x2(s[k], s[k + 2], 0xDD);
    t[k + 4] = _mm512_shuffle_f64x2(s[k + 4], s[k + 6], 0x88);
    t[k + 6] = _mm512_shuffle_f64x2(s[k + 4], s[k + 6], 0xDD);
  }
  for (int k = 0; k < 2; k++) {
    field[k] = _mm512_shuffle_f64x2(t[k], t[k + 4], 0x88);
    field[k + 4] = _mm512_shuffle_f64x2(t[k], t[k + 4], 0xDD);
    field[k + 2] = _mm512_shuffle_f64x2(t[k + 2], t[k + 6], 0x88);
    field[k + 6] = _mm512_shuffle_f64x2(t[k + 2], t[k + 6], 0xDD);
  }
}

#else

enum { LANES = 4 };
typedef v4d vd;
typedef v4l vl;
typedef v4l vm;

static inline vd vd_all(double a) {
  return v4d_all(a);
}

static inline vl vl_all(int64_t a) {
  return v4l_all(a);
}

static inline vm vd_below(vd a, vd b) {
  return a < b;
}

static inline vm vd_at_most(vd a, vd b) {
  return a <= b;
}

static inline vm vd_equal(vd a, vd b) {
  return a == b;
}

static inline vm vm_below(uint32_t n) {
  return (vl){0, 1, 2, 3} < (int64_t)n;
}

static inline vl vl_lanes(void) {
  return (vl){0, 1, 2, 3};
}

static inline vd vd_choose_negative(vl sign, vd yes, vd no) {
#ifdef __AVX2__
  return _mm256_blendv_pd(no, yes, (vd)sign);
#else
  return v4d_choose(sign < 0, yes, no);
#endif
}

static inline vd vd_greater(vd a, vd b) {
#ifdef __AVX2__
  return _mm256_max_pd(a, b);
#else
  return v4d_choose(a > b, a, b);
#endif
}

static inline unsigned vm_bits(vm in) {
  return v4l_bits(in);
}

static inline vm vm_of(unsigned bits) {
  const v4l bit = {1, 2, 4, 8};
  return (v4l_all(bits) & bit) == bit;
}

static inline vd vd_choose(vm in, vd yes, vd no) {
  return v4d_choose(in, yes, no);
}

static inline vl vl_choose(vm in, vl yes, vl no) {
  return v4l_choose(in, yes, no);
}

static inline vd vd_sqrt(vd a) {
  return v4d_sqrt(a);
}

static inline vd vd_nearest(vd a) {
  return v4d_nearest(a);
}

static inline double vd_least_of(vd a) {
  return v4d_least_of(a)[0];
}

static inline __attribute__((always_inline)) void
vd_records(const double *base, const uint32_t id[LANES], vd field[8]) {
  const double *p0 = base + 8 * (size_t)id[0], *p1 = base + 8 * (size_t)id[1];
  const double *p2 = base + 8 * (size_t)id[2], *p3 = base + 8 * (size_t)id[3];
  four_halves(p0, p1, p2, p3, &field[0], &field[1], &field[2], &field[3]);
  four_halves(p0 + 4, p1 + 4, p2 + 4, p3 + 4, &field[4], &field[5], &field[6], &field[7]);
}

#endif

#endif
