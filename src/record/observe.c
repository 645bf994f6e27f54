/* The observables of a run: which ones a scene has, and their values now. */
#include "record/observe.h"

#include <math.h>
#include <string.h>

#include "eventmill/sample.h"

/* ---------------------------------------------------------------- which scene has which */

static size_t always(const struct em_scene *scene) {
  (void)scene;
  return 1;
}

static size_t has(const struct em_scene *scene, unsigned effects) {
  return (em_scene_effects(scene) & effects) != 0;
}

static size_t with_gravity(const struct em_scene *scene) {
  return has(scene, EM_EFFECT_GRAVITY);
}

static size_t with_spin(const struct em_scene *scene) {
  return has(scene, EM_EFFECT_SPIN);
}

static size_t with_turning(const struct em_scene *scene) {
  return has(scene, EM_EFFECT_TURNING);
}

static size_t with_tc(const struct em_scene *scene) {
  return has(scene, EM_EFFECT_TC);
}

static size_t with_elastic(const struct em_scene *scene) {
  return has(scene, EM_EFFECT_ELASTIC);
}

static size_t with_jam(const struct em_scene *scene) {
  return has(scene, EM_EFFECT_JAM);
}

static size_t per_class(const struct em_scene *scene) {
  (void)scene;
  return EM_CLASS_COUNT;
}

static size_t per_blade(const struct em_scene *scene) {
  return em_scene_blade_count(scene);
}

/* ---------------------------------------------------------------- what they are */

static const struct em_tally *tally(const struct em_observe_state *state) {
  return em_world_tally(state->world);
}

static void kinetic_energy(const struct em_observe_state *state, void *cells) {
  *(double *)cells = state->energy.kinetic;
}

static void spin_energy(const struct em_observe_state *state, void *cells) {
  *(double *)cells = state->energy.spin;
}

static void potential_energy(const struct em_observe_state *state, void *cells) {
  *(double *)cells = state->energy.potential;
}

static void median_speed(const struct em_observe_state *state, void *cells) {
  *(double *)cells = state->median_speed;
}

static void mean_speed(const struct em_observe_state *state, void *cells) {
  *(double *)cells = state->mean_speed;
}

static void resting_share(const struct em_observe_state *state, void *cells) {
  *(double *)cells = state->resting;
}

static void collisions(const struct em_observe_state *state, void *cells) {
  memcpy(cells, tally(state)->collisions, sizeof tally(state)->collisions);
}

static void dissipated_energy(const struct em_observe_state *state, void *cells) {
  memcpy(cells, tally(state)->lost, sizeof tally(state)->lost);
}

static void collision_energy(const struct em_observe_state *state, void *cells) {
  memcpy(cells, tally(state)->collision_energy, sizeof tally(state)->collision_energy);
}

static void blade_work(const struct em_observe_state *state, void *cells) {
  for (size_t k = 0; k < em_world_blade_count(state->world); k++)
    ((double *)cells)[k] = em_world_blade_tally(state->world, k)->work;
}

static void blade_angular_impulse(const struct em_observe_state *state, void *cells) {
  for (size_t k = 0; k < em_world_blade_count(state->world); k++)
    ((double *)cells)[k] = em_world_blade_tally(state->world, k)->angular_impulse;
}

/* The mean over the interval: difference of the angular impulse by time. */
static void blade_torque(const struct em_observe_state *state, void *cells) {
  for (size_t k = 0; k < em_world_blade_count(state->world); k++) {
    const double now = em_world_blade_tally(state->world, k)->angular_impulse;
    const double before = state->impulse_before[k];
    ((double *)cells)[k] = state->interval > 0.0 ? (now - before) / state->interval : 0.0;
  }
}

static void blade_contacts(const struct em_observe_state *state, void *cells) {
  for (size_t k = 0; k < em_world_blade_count(state->world); k++)
    ((uint64_t *)cells)[k] = em_world_blade_tally(state->world, k)->contacts;
}

static void drum_work(const struct em_observe_state *state, void *cells) {
  *(double *)cells = tally(state)->drum_work;
}

static void tc_contacts(const struct em_observe_state *state, void *cells) {
  *(uint64_t *)cells = tally(state)->tc;
}

static void elastic_contacts(const struct em_observe_state *state, void *cells) {
  *(uint64_t *)cells = tally(state)->elastic;
}

static void jam_contacts(const struct em_observe_state *state, void *cells) {
  *(uint64_t *)cells = tally(state)->jam;
}

const struct em_observable em_observe_list[] = {
    {"kinetic_energy", "J", false, false, always, kinetic_energy},
    {"spin_energy", "J", false, false, with_spin, spin_energy},
    {"potential_energy", "J", false, false, with_gravity, potential_energy},
    {"median_speed", "m s-1", false, false, always, median_speed},
    {"mean_speed", "m s-1", false, false, always, mean_speed},
    {"resting_share", NULL, false, false, with_gravity, resting_share},
    {"collisions", NULL, true, true, per_class, collisions},
    {"dissipated_energy", "J", false, true, per_class, dissipated_energy},
    {"collision_energy", "J", false, true, per_class, collision_energy},
    {"blade_work", "J", false, true, per_blade, blade_work},
    {"blade_angular_impulse", "N m s", false, true, per_blade, blade_angular_impulse},
    {"blade_torque", "N m", false, true, per_blade, blade_torque},
    {"blade_contacts", NULL, true, true, per_blade, blade_contacts},
    {"drum_work", "J", false, false, with_turning, drum_work},
    {"tc_contacts", NULL, true, false, with_tc, tc_contacts},
    {"elastic_contacts", NULL, true, false, with_elastic, elastic_contacts},
    {"jam_contacts", NULL, true, false, with_jam, jam_contacts},
};
const size_t em_observe_count = sizeof em_observe_list / sizeof em_observe_list[0];

/* ---------------------------------------------------------------- their ingredients */

/* The chamber turns about the axis y through the origin. */
static double resting(const struct em_scene *scene, const struct em_balls *balls) {
  const double fall = em_vec_norm(scene->gravity), omega = scene->chamber.rpm * M_PI / 30.0;
  size_t count = 0;
  for (size_t i = 0; i < balls->count; i++) {
    const struct em_vec v = balls->velocity[i], x = balls->position[i];
    const struct em_vec turning = {v.x - omega * x.z, v.y, v.z + omega * x.x};
    const double least = fmin(em_vec_norm2(v), em_vec_norm2(turning));
    count += least < 2.0 * fall * 2.0 * balls->radius[i];
  }
  return balls->count ? (double)count / (double)balls->count : 0.0;
}

void em_observe_balls(struct em_observe_state *state, const struct em_scene *scene,
                      const struct em_balls *balls, double *speeds) {
  double sum = 0.0;
  for (size_t i = 0; i < balls->count; i++) {
    speeds[i] = em_vec_norm(balls->velocity[i]);
    sum += speeds[i];
  }
  state->mean_speed = balls->count ? sum / (double)balls->count : NAN;
  state->median_speed = em_sample_median(speeds, balls->count);
  state->resting = resting(scene, balls);
  state->energy = em_world_energy(state->world, balls);
}

double em_observe_work(const struct em_world *world) {
  double work = em_world_tally(world)->drum_work;
  for (size_t k = 0; k < em_world_blade_count(world); k++)
    work += em_world_blade_tally(world, k)->work;
  return work;
}

double em_observe_lost(const struct em_world *world) {
  double lost = 0.0;
  for (int c = 0; c < EM_CLASS_COUNT; c++)
    lost += em_world_tally(world)->lost[c];
  return lost;
}
