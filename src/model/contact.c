/* Laws of normal restitution and collision rules: what happens when two surfaces touch. */
#include "eventmill/contact.h"

#include <stddef.h>
#include <string.h>

/* 2/5 of a solid sphere: I = q m R²; q/(1+q) is the share of the tangential impulse. */
static const double STICK = 2.0 / 7.0;

struct law {
  const char *name;
  int size;
  const char *parameter[EM_LAW_PARAMETERS];
  double fallback[EM_LAW_PARAMETERS];
};

/* Defaults: Spahn (7-2) is the measured one; the others are its least-squares approximations over
 * 0 … 50 m/s (docs/physics.md). */
static const struct law LAW[EM_LAW_COUNT] = {
    [EM_LAW_CONSTANT] = {"constant", 1, {"epsilon"}, {0.9}},
    [EM_LAW_SALO] = {"salo", 1, {"c"}, {13.94}},
    [EM_LAW_ANDREWS] = {"andrews", 1, {"c"}, {1.572}},
    [EM_LAW_SPAHN] = {"spahn", 3, {"A", "B", "C"}, {0.985, 0.9494, 0.291}},
    [EM_LAW_POWER2] = {"power2", 2, {"A", "B"}, {0.2947, 0.5261}},
    [EM_LAW_POWER4] = {"power4", 4, {"A", "B", "C", "D"}, {1.0533, 1.0, 0.291, 0.0}},
    [EM_LAW_EXPONENTIAL] = {"exponential", 3, {"A", "B", "C"}, {0.3401, 0.5612, 0.2875}},
    [EM_LAW_VISCOELASTIC] = {"viscoelastic", 1, {"beta"}, {0.5123}},
};

#define NAME(code, text) text,
static const char *const CLASS_NAME[] = {EM_CLASS_LIST(NAME)};
static const char *const RULE_NAME[] = {EM_RULE_LIST(NAME)};
#undef NAME

static int find(const char *const *names, int count, const char *name) {
  for (int i = 0; i < count; i++)
    if (strcmp(names[i], name) == 0) return i;
  return -1;
}

const char *em_contact_class_name(enum em_class cls) {
  return CLASS_NAME[cls];
}

const char *em_contact_law_name(enum em_law law) {
  return LAW[law].name;
}

const char *em_contact_rule_name(enum em_rule rule) {
  return RULE_NAME[rule];
}

int em_contact_class_find(const char *name) {
  return find(CLASS_NAME, EM_CLASS_COUNT, name);
}

int em_contact_law_find(const char *name) {
  for (int i = 0; i < EM_LAW_COUNT; i++)
    if (strcmp(LAW[i].name, name) == 0) return i;
  return -1;
}

int em_contact_law_size(enum em_law law) {
  return LAW[law].size;
}

const char *em_contact_law_parameter(enum em_law law, int k) {
  return k >= 0 && k < LAW[law].size ? LAW[law].parameter[k] : NULL;
}

struct em_restitution em_contact_law_default(enum em_law law) {
  struct em_restitution result = {.law = law};
  memcpy(result.p, LAW[law].fallback, sizeof(result.p));
  return result;
}

static double clamp(double x) {
  if (!(x > 0.0)) return 0.0;
  return x < 1.0 ? x : 1.0;
}

/* (6-6); the inner root is real for x ≤ 1, and the value is 1 at x = 1. */
static double andrews(double c, double v) {
  if (v <= c) return 1.0;
  const double x2 = (c / v) * (c / v);
  return sqrt(-(2.0 / 3.0) * x2 + sqrt((10.0 / 3.0) * x2 - (5.0 / 9.0) * x2 * x2));
}

/* Falls from 1 to the floor as `share` falls from 1 to 0. */
static double above(double floor, double share) {
  return floor + (1.0 - floor) * share;
}

/* Padé approximant of the viscoelastic sphere (Müller & Pöschel 2011); x² = β v^(1/5). */
static double viscoelastic(double beta, double v) {
  const double x = sqrt(beta) * pow(v, 0.1);
  const double below = 1.0 + x * (0.501086 + x * (1.15345 + x * (0.577977 + x * 0.532178)));
  return (1.0 + 0.501086 * x) / below;
}

double em_contact_restitution(const struct em_restitution *law, double vn) {
  const double *p = law->p;
  switch (law->law) {
  case EM_LAW_CONSTANT:
    return clamp(p[0]);
  case EM_LAW_SALO:
    return clamp(1.0 / (1.0 + vn / p[0]));
  case EM_LAW_ANDREWS:
    return clamp(andrews(p[0], vn));
  case EM_LAW_SPAHN:
    return clamp(p[0] * pow(vn + p[1], -p[2]));
  case EM_LAW_POWER2:
    return clamp(1.0 / (1.0 + p[0] * pow(vn, p[1])));
  case EM_LAW_POWER4:
    return clamp(above(p[3], pow(1.0 + p[0] * pow(vn, p[1]), -p[2])));
  case EM_LAW_EXPONENTIAL:
    return clamp(above(p[2], exp(-p[0] * pow(vn, p[1]))));
  case EM_LAW_VISCOELASTIC:
    return clamp(viscoelastic(p[0], vn));
  case EM_LAW_COUNT:
    break;
  }
  return 1.0;
}

/* P_t = −share · g_t, by rule; pn is the size of the normal impulse. */
static double tangential_share(const struct em_contact_law *law, double m_eff, double pn,
                               double vt) {
  const double full = (1.0 - law->tangential) * m_eff;
  switch (law->rule) {
  case EM_RULE_ROUGH:
    return STICK * full;
  case EM_RULE_REICHARDT2005:
    return full;
  case EM_RULE_FRICTION: {
    const double stick = STICK * full, limit = law->friction * pn;
    return stick * vt > limit ? limit / vt : stick;
  }
  case EM_RULE_SMOOTH:
  case EM_RULE_COUNT:
    break;
  }
  return 0.0;
}

struct em_impulse em_contact_impulse(const struct em_contact_law *law, double m_eff,
                                     struct em_vec e, struct em_vec g, bool frictionless,
                                     bool elastic) {
  const double gn = em_vec_dot(g, e);
  const struct em_vec gt = em_vec_axpy(g, -gn, e);
  struct em_impulse impulse = {.vn = gn < 0.0 ? -gn : 0.0, .vt = em_vec_norm(gt)};
  const double pn = em_contact_push(&law->normal, m_eff, e, impulse.vn, elastic);
  impulse.normal = em_vec_scale(pn, e);
  if (!frictionless)
    impulse.tangential = em_vec_scale(-tangential_share(law, m_eff, pn, impulse.vt), gt);
  return impulse;
}

double em_contact_spin_factor(enum em_rule rule, double m, double radius) {
  switch (rule) {
  case EM_RULE_ROUGH:
  case EM_RULE_FRICTION:
    return -2.5 / (m * radius);
  case EM_RULE_REICHARDT2005:
    return -radius / m;
  case EM_RULE_SMOOTH:
  case EM_RULE_COUNT:
    break;
  }
  return 0.0;
}
