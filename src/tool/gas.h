/* What an ideal gas promises, sampled from a run so that the values are independent of one another.
 *
 * Velocities come from frames that lie so many ball-ball collisions apart that the gas has
 * forgotten the one before; collisions from short windows of time, in which few balls collide
 * twice, equally far apart. Both begin when the start is forgotten. */
#ifndef EVENTMILL_GAS_H
#define EVENTMILL_GAS_H

#include <stdbool.h>
#include <stddef.h>

#include "eventmill/distribution.h"
#include "eventmill/run_file.h"
#include "tool/millpost.h"

/* How a law's parameter is known: free of the data; tied to the data by conservation of energy; or
 * fitted to the data by the second moment. */
enum em_gas_tie { EM_GAS_FREE, EM_GAS_ENERGY, EM_GAS_FITTED };

/* code, key, words, law, tie */
#define EM_GAS_LIST(X)                                                                     \
  X(SPEED, "speed", "speed of the balls", MAXWELL, EM_GAS_ENERGY)                          \
  X(VX, "vx", "velocity, x", NORMAL, EM_GAS_FITTED)                                        \
  X(VY, "vy", "velocity, y", NORMAL, EM_GAS_FITTED)                                        \
  X(VZ, "vz", "velocity, z", NORMAL, EM_GAS_FITTED)                                        \
  X(RELATIVE, "relative", "relative speed at ball-ball collisions", MAXWELL4, EM_GAS_FREE) \
  X(VN, "vn", "v_n at ball-ball collisions", RAYLEIGH, EM_GAS_FREE)                        \
  X(IMPACT, "impact", "impact parameter", LINEAR, EM_GAS_FREE)                             \
  X(NORMAL_X, "normal_x", "impact points on the balls, x", UNIFORM, EM_GAS_FREE)           \
  X(NORMAL_Y, "normal_y", "impact points on the balls, y", UNIFORM, EM_GAS_FREE)           \
  X(NORMAL_Z, "normal_z", "impact points on the balls, z", UNIFORM, EM_GAS_FREE)           \
  X(VN_DRUM, "vn_drum", "v_n at ball-drum collisions", RAYLEIGH, EM_GAS_FREE)              \
  X(VN_END, "vn_end", "v_n at ball-end collisions", RAYLEIGH, EM_GAS_FREE)                 \
  X(DRUM_ANGLE, "drum_angle", "impact points on the drum, angle", UNIFORM, EM_GAS_FREE)    \
  X(DRUM_AXIAL, "drum_axial", "impact points on the drum, along the axis", UNIFORM, EM_GAS_FREE)
#define EM_GAS_ENUM(code, key, words, law, tie) EM_GAS_##code,
enum em_gas_quantity { EM_GAS_LIST(EM_GAS_ENUM) EM_GAS_COUNT };
#undef EM_GAS_ENUM

enum { EM_GAS_MODES = 4 };

/* Density waves along one coordinate: in each frame that is far from the one before, the mean over
 * all balls of up to EM_GAS_MODES waves, which is 0 when all places are alike. Its variance is that
 * of free points times S(0) = (1−φ)⁴/((1+2φ)² + φ³(φ−4)), because balls exclude one another
 * (Carnahan & Starling 1969). Waves that end at walls are odd: the layers of balls at both walls
 * cancel. */
struct em_gas_waves {
  const char *key, *words; /* NULL: the chamber has no such coordinate */
  double chi2;             /* Σ (amplitude/σ)² */
  size_t freedom;          /* number of its terms */
};

struct em_gas {
  double kt;           /* J, from the energy at the start (with gravity: of the frames), less what
                          spins have of it, and the centre of mass where no walls hold it */
  double kt_frames;    /* J, from the balls' velocities */
  double mass, sigma;  /* kg, and m/s: √(kT/m); NAN for balls of several masses */
  double energy_drift; /* largest |E(t) − E(0)| of the observables, relative to the largest energy;
                          NAN: none, or gravity pulls balls across a periodic boundary */
  double square[3];    /* Σ m v_x²/kT, the same of y and z, over the sampled frames */
  double collisions;   /* per ball, between balls, from the start to the end of the window */
  double wave_spacing; /* collisions per ball between two frames for the waves */
  bool alike;          /* all balls: only then are there waves */
  size_t most;         /* values of a law at most: as many as the balls tell */
  size_t frames, wave_frames, windows;
  size_t n[EM_GAS_COUNT];
  double *x[EM_GAS_COUNT]; /* in units of the law's parameter; [0, 1] for uniform ones; owned */
  struct em_gas_waves waves[3];
};

const char *em_gas_key(enum em_gas_quantity q);
const char *em_gas_words(enum em_gas_quantity q);
enum em_distribution em_gas_law(enum em_gas_quantity q);
enum em_gas_tie em_gas_tie(enum em_gas_quantity q);

/* Why the laws of velocities, those of relative speeds and impact parameters, of impact points on
 * balls, and of places, need not hold in a scene; "" when they must. */
const char *em_gas_no_velocities(const struct em_scene *scene);
const char *em_gas_no_relative(const struct em_scene *scene);
const char *em_gas_no_points(const struct em_scene *scene);
const char *em_gas_no_places(const struct em_scene *scene);

/* Does the chamber have the walls that a quantity is of? */
bool em_gas_has(const struct em_scene *scene, enum em_gas_quantity q);

/* Samples a run. from: NAN: when the start is forgotten. Errors: EM_INPUT (no frames, or too few
 * collisions), EM_MEMORY and those of reading. */
enum em_status em_gas_new(struct em_gas **gas, const struct em_run_file *run, double from,
                          double to, struct em_error *err);
void em_gas_free(struct em_gas *gas);

#endif
