/* The laws that an ideal gas of balls obeys (Reichardt 2005, Tab. 14-2 and appendix A). */
#ifndef EVENTMILL_DISTRIBUTION_H
#define EVENTMILL_DISTRIBUTION_H

#ifdef __cplusplus
extern "C" {
#endif

/* code, name, parameter. The density on x ≥ 0 unless said otherwise:
 *   normal    exp(−x²/2a²)/(a√2π), all x          one component of a velocity, a = σ
 *   maxwell   √(2/π) x²/a³ exp(−x²/2a²)           speed, a = σ
 *   maxwell4  x³/(2a⁴) exp(−x²/2a²)               relative speed at collisions, a = √2 σ
 *   rayleigh  x/a² exp(−x²/2a²)                   v_n at collisions, a = √2 σ
 *   linear    2x/a² on [0, a]                     impact parameter, radius in a disc
 *   uniform   1/a on [0, a]                       positions, angles, cosines (shifted) */
#define EM_DISTRIBUTION_LIST(X) \
  X(NORMAL, "normal")           \
  X(MAXWELL, "maxwell")         \
  X(MAXWELL4, "maxwell4")       \
  X(RAYLEIGH, "rayleigh")       \
  X(LINEAR, "linear")           \
  X(UNIFORM, "uniform")
#define EM_DISTRIBUTION_ENUM(code, text) EM_DISTRIBUTION_##code,
enum em_distribution { EM_DISTRIBUTION_LIST(EM_DISTRIBUTION_ENUM) EM_DISTRIBUTION_COUNT };
#undef EM_DISTRIBUTION_ENUM

const char *em_distribution_name(enum em_distribution law);

/* Density and cumulative probability at x for the parameter a > 0. */
double em_distribution_pdf(enum em_distribution law, double a, double x);
double em_distribution_cdf(enum em_distribution law, double a, double x);

/* Degrees of freedom k of a law whose x²/a² is χ² with k of them (normal 1, rayleigh 2, maxwell 3,
 * maxwell4 4); 0 for the others. */
int em_distribution_freedom(enum em_distribution law);

#ifdef __cplusplus
}
#endif

#endif
