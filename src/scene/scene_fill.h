/* From libconfig's tree to struct em_scene: types, ranges, defaults, unknown entries. */
#ifndef EVENTMILL_SCENE_SCENE_FILL_H
#define EVENTMILL_SCENE_SCENE_FILL_H

#include "eventmill/scene.h"
#include "scene/scene_report.h"
#include "scene/scene_table.h"

/* Fills a zeroed scene from the report's tree. What is wrong goes into the report. */
void em_scene_fill_all(struct em_scene_report *report, struct em_scene *scene);

/* Fills what `table` describes from a group (NULL: defaults alone) and reports unknown entries. */
void em_scene_fill_group(struct em_scene_report *report, const struct em_scene_table *table,
                         const config_setting_t *group, void *out);

/* Reads one number; false (and a report with `expected`) when it is none or not finite. */
bool em_scene_fill_number(struct em_scene_report *report, const config_setting_t *setting,
                          const char *expected, double *value);

/* Reads three numbers from a list; false and a report when they are not. */
bool em_scene_fill_vector(struct em_scene_report *report, const config_setting_t *setting,
                          const char *expected, struct em_vec *value);

/* Reports that a setting holds something else than what was expected. */
void em_scene_fill_mismatch(struct em_scene_report *report, const config_setting_t *setting,
                            const char *expected);

/* Reports that a group lacks an entry. */
void em_scene_fill_missing(struct em_scene_report *report, const config_setting_t *group,
                           const struct em_scene_table *table, const char *name);

/* Where a level of accuracy keeps its value of an entry of `engine`; NULL: no level sets this
 * entry. */
const void *em_scene_fill_level(enum em_accuracy accuracy, const struct em_scene_entry *entry);

/* The parts of a scene that need more than their table. */
void em_scene_fill_contacts(struct em_scene_report *report, struct em_scene *scene);
void em_scene_fill_rotors(struct em_scene_report *report, struct em_scene *scene);
void em_scene_fill_species(struct em_scene_report *report, struct em_scene *scene);

/* A species' `table`: rows in the scene or in a file. */
void em_scene_fill_rows(struct em_scene_report *report, const config_setting_t *setting,
                        struct em_species *species);

/* A rotor's and a blade's speed, and an angle, as the scene gives and as the engine uses them. */
double em_scene_fill_omega(double rpm);
double em_scene_fill_radians(double degrees);

/* The scene's unit vector for a direction, and the bar's direction at angle 0 on such an axis. */
struct em_vec em_scene_fill_unit(struct em_vec direction);
struct em_vec em_scene_fill_upright(struct em_vec axis);

#endif
