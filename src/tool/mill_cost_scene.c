/* Scenes of mill cost: the user's with a variant's changes, read from the text that was there at
 * the beginning. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "eventmill/run_file.h"
#include "tool/mill_cost.h"

/* Half of the first species gets a density that differs in the 12th digit. */
static enum em_status mix(struct em_scene *scene, struct em_error *err) {
  const size_t n = scene->species_count;
  if (n == 0 || scene->species[0].count < 2) return EM_OK;
  struct em_species *more = realloc(scene->species, (n + 1) * sizeof *more);
  if (!more) return em_mill_cost_no_memory(err);
  scene->species = more;
  memmove(more + 1, more, n * sizeof *more);
  scene->species_count++;
  more[0].count = more[1].count / 2;
  more[1].count -= more[0].count;
  more[0].density *= 1.0 + 1e-12;
  /* The balls come from the snapshot; rows of a table stay with the other half. */
  if (more[0].start == EM_START_TABLE) more[0].speed = 0.0;
  more[0].start = EM_START_UNIFORM;
  more[0].position = more[0].velocity = more[0].spin = NULL;
  return EM_OK;
}

/* All balls get the smallest diameter, at which none overlap, and the mean mass. */
static void unmix(struct em_scene *scene) {
  double diameter = INFINITY, mass = 0.0, count = 0.0;
  for (size_t k = 0; k < scene->species_count; k++) {
    const struct em_species *s = &scene->species[k];
    diameter = fmin(diameter, s->diameter);
    mass += (double)s->count * s->density * pow(s->diameter, 3.0);
    count += (double)s->count;
  }
  for (size_t k = 0; k < scene->species_count; k++) {
    scene->species[k].diameter = diameter;
    scene->species[k].density = mass / (count * pow(diameter, 3.0));
  }
}

enum em_status em_mill_cost_scene_with(const struct em_cost *cost, size_t count,
                                       const char *const *more, struct em_scene **scene,
                                       struct em_error *err) {
  const size_t own = cost->override_count;
  const char **list = calloc(own + count + 1, sizeof *list);
  *scene = NULL;
  if (!list) return em_mill_cost_no_memory(err);
  for (size_t k = 0; k < own; k++)
    list[k] = cost->overrides[k];
  for (size_t k = 0; k < count; k++)
    list[own + k] = more[k];
  enum em_status status = em_scene_parse(scene, cost->text, cost->path, own + count, list, err);
  free(list);
  if (!status) status = em_run_file_turn(*scene, err);
  return status;
}

enum em_status em_mill_cost_scene(const struct em_cost *cost, const struct em_cost_variant *variant,
                                  struct em_scene **scene, size_t *hidden, struct em_error *err) {
  const char *word[EM_COST_WORDS];
  for (size_t k = 0; k < variant->words; k++)
    word[k] = variant->word[k];
  *hidden = 0;
  enum em_status status = em_mill_cost_scene_with(cost, variant->words, word, scene, err);
  if (status) return status;
  if (variant->change == EM_COST_NO_ROTOR) {
    *hidden = (*scene)->rotor_count;
    (*scene)->rotor_count = 0;
  }
  if (variant->change == EM_COST_UNMIXED) unmix(*scene);
  if (variant->change == EM_COST_MIXED) status = mix(*scene, err);
  return status;
}

void em_mill_cost_scene_free(struct em_scene *scene, size_t hidden) {
  if (scene && hidden) scene->rotor_count = hidden;
  em_scene_free(scene);
}
