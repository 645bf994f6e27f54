/* What happens when two surfaces touch: laws of normal restitution and collision rules.
 * Sources: Reichardt 2005 (6-5 … 6-7, 9-6 … 9-17); Schwager & Pöschel 1998, 2008;
 * Walton & Braun 1986; Luding 1998. */
#ifndef EVENTMILL_CONTACT_H
#define EVENTMILL_CONTACT_H

#include <stdbool.h>

#include "eventmill/vec.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Who touches whom. In a box the walls across y are "end" walls, all others "drum" walls. */
#define EM_CLASS_LIST(X) \
  X(BALL, "ball-ball")   \
  X(DRUM, "ball-drum")   \
  X(END, "ball-end")     \
  X(BLADE, "ball-blade")
#define EM_CLASS_ENUM(code, text) EM_CLASS_##code,
enum em_class { EM_CLASS_LIST(EM_CLASS_ENUM) EM_CLASS_COUNT };
#undef EM_CLASS_ENUM

/* code, name, number of parameters, names and defaults of the parameters are in contact.c. */
#define EM_LAW_LIST(X)          \
  X(CONSTANT, "constant")       \
  X(SALO, "salo")               \
  X(ANDREWS, "andrews")         \
  X(SPAHN, "spahn")             \
  X(POWER2, "power2")           \
  X(POWER4, "power4")           \
  X(EXPONENTIAL, "exponential") \
  X(VISCOELASTIC, "viscoelastic")
#define EM_LAW_ENUM(code, text) EM_LAW_##code,
enum em_law { EM_LAW_LIST(EM_LAW_ENUM) EM_LAW_COUNT };
#undef EM_LAW_ENUM

enum { EM_LAW_PARAMETERS = 4 };

#define EM_RULE_LIST(X)             \
  X(ROUGH, "rough")                 \
  X(FRICTION, "friction")           \
  X(REICHARDT2005, "reichardt2005") \
  X(SMOOTH, "smooth")
#define EM_RULE_ENUM(code, text) EM_RULE_##code,
enum em_rule { EM_RULE_LIST(EM_RULE_ENUM) EM_RULE_COUNT };
#undef EM_RULE_ENUM

/* A law of normal restitution with its parameters. */
struct em_restitution {
  enum em_law law;
  double p[EM_LAW_PARAMETERS];
};

/* How one class of contacts collides. */
struct em_contact_law {
  enum em_rule rule;            /* Default: rough */
  struct em_restitution normal; /* Default: spahn */
  double tangential;            /* ε_t in [-1, 1]. 1: smooth, -1: perfectly rough. Default: 0.9 */
  double friction;              /* μ ≥ 0, for `friction` alone. Default: 0.1 */
};

/* The impulse (kg m/s) that a contact gives to ball i; its partner gets the opposite. */
struct em_impulse {
  struct em_vec normal, tangential;
  double vn; /* m/s, ≥ 0: normal speed of approach of the surfaces */
  double vt; /* m/s, ≥ 0: tangential speed of the surfaces */
};

const char *em_contact_class_name(enum em_class cls);
const char *em_contact_law_name(enum em_law law);
const char *em_contact_rule_name(enum em_rule rule);

/* Index of a name in its list, or -1. */
int em_contact_class_find(const char *name);
int em_contact_law_find(const char *name);

/* The law's number of parameters (≤ EM_LAW_PARAMETERS), the name of parameter k (NULL beyond),
 * and the law with its default parameters. */
int em_contact_law_size(enum em_law law);
const char *em_contact_law_parameter(enum em_law law, int k);
struct em_restitution em_contact_law_default(enum em_law law);

/* ε_n at the approach speed vn ≥ 0 (m/s); in [0, 1]. */
double em_contact_restitution(const struct em_restitution *law, double vn);

/* |e|² − 1, which rounding leaves in a unit vector, to well below 1e-16: squares of the leading
 * halves are exact. Left uncorrected it is a bias at contacts of one and the same distance, and the
 * energy of an elastic gas grows by 3e-16 of a ball's with each contact. */
static inline double em_contact_length_excess(struct em_vec e) {
  const double x = (double)(float)e.x, y = (double)(float)e.y, z = (double)(float)e.z;
  const double lead = ((x * x - 1.0) + y * y) + z * z;
  return lead + ((e.x - x) * (e.x + x) + (e.y - y) * (e.y + y) + (e.z - z) * (e.z + z));
}

/* Size of the normal impulse at the speed of approach vn (m/s); the rest as below. */
static inline double em_contact_push(const struct em_restitution *law, double m_eff,
                                     struct em_vec e, double vn, bool elastic) {
  const double epsilon = elastic ? 1.0 : em_contact_restitution(law, vn);
  const double raw = (1.0 + epsilon) * m_eff * vn;
  return raw - raw * em_contact_length_excess(e);
}

/* Impulse on ball i. e: unit normal from the partner to the ball; g: velocity of the ball's surface
 * relative to the partner's at the point of contact (9-6); m_eff: m_i m_j/(m_i+m_j), or m_i for a
 * wall. frictionless: leave the tangential part out (jam remedy); elastic: take ε_n = 1 (TC model).
 */
struct em_impulse em_contact_impulse(const struct em_contact_law *law, double m_eff,
                                     struct em_vec e, struct em_vec g, bool frictionless,
                                     bool elastic);

/* k such that a ball of mass m (kg) and radius R (m) changes its spin by Δω = k e × P_t, where e
 * points to the ball i that gets P_t. The partner j, with its own m and R, has its k with the
 * *same* e and P_t. −5/(2 m R); `reichardt2005`: −R/m (9-9, 9-17; docs/physics.md on the sign);
 * `smooth`: 0. */
double em_contact_spin_factor(enum em_rule rule, double m, double radius);

#ifdef __cplusplus
}
#endif

#endif
