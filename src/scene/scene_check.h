/* Is a scene possible? */
#ifndef EVENTMILL_SCENE_SCENE_CHECK_H
#define EVENTMILL_SCENE_SCENE_CHECK_H

#include "eventmill/scene.h"
#include "scene/scene_report.h"

/* Reports magnitudes out of range, blades that touch walls or each other, rotors in periodic boxes,
 * balls that do not fit, periodic edges too short for them, regions outside the chamber, drums with
 * facets that turn or have ramps. The scene's entries are in their ranges. */
void em_scene_check_all(struct em_scene_report *report, const struct em_scene *scene);

/* Reports lengths, masses, speeds and times with which the engine could not reckon, by their
 * entries; false: there are some. */
bool em_scene_check_range(struct em_scene_report *report, const struct em_scene *scene);

/* Writes the path of an entry of species k: "balls.diameter", "balls.1.diameter". */
void em_scene_check_species_path(const struct em_scene *scene, size_t k, const char *entry,
                                 size_t size, char *path);

#endif
