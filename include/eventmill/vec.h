/* Three-dimensional vectors, by value, and the lesser and greater of two numbers. The order of
 * every sum is fixed: results are reproducible. */
#ifndef EVENTMILL_VEC_H
#define EVENTMILL_VEC_H

#include <math.h>

#ifdef __cplusplus
extern "C" {
#endif

/* fmin and fmax of numbers, none of them NaN: one instruction, no call; a gain of 1.01 to 1.02. */
static inline double em_lesser(double a, double b) {
  return b < a ? b : a;
}

static inline double em_greater(double a, double b) {
  return b > a ? b : a;
}

struct em_vec {
  double x, y, z;
};

static inline struct em_vec em_vec_make(double x, double y, double z) {
  return (struct em_vec){x, y, z};
}

/* Along x, y or z: k = 0, 1, 2. */
static inline double em_vec_component(struct em_vec a, int k) {
  return k == 0 ? a.x : k == 1 ? a.y : a.z;
}

static inline struct em_vec em_vec_add(struct em_vec a, struct em_vec b) {
  return (struct em_vec){a.x + b.x, a.y + b.y, a.z + b.z};
}

static inline struct em_vec em_vec_sub(struct em_vec a, struct em_vec b) {
  return (struct em_vec){a.x - b.x, a.y - b.y, a.z - b.z};
}

static inline struct em_vec em_vec_scale(double s, struct em_vec a) {
  return (struct em_vec){s * a.x, s * a.y, s * a.z};
}

/* a + s b */
static inline struct em_vec em_vec_axpy(struct em_vec a, double s, struct em_vec b) {
  return (struct em_vec){a.x + s * b.x, a.y + s * b.y, a.z + s * b.z};
}

static inline double em_vec_dot(struct em_vec a, struct em_vec b) {
  return (a.x * b.x + a.y * b.y) + a.z * b.z;
}

static inline struct em_vec em_vec_cross(struct em_vec a, struct em_vec b) {
  return (struct em_vec){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

static inline double em_vec_norm2(struct em_vec a) {
  return em_vec_dot(a, a);
}

static inline double em_vec_norm(struct em_vec a) {
  return sqrt(em_vec_norm2(a));
}

#ifdef __cplusplus
}
#endif

#endif
