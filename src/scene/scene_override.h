/* KEY=VALUE from the command line, put into a scene's tree before it is read. */
#ifndef EVENTMILL_SCENE_SCENE_OVERRIDE_H
#define EVENTMILL_SCENE_SCENE_OVERRIDE_H

#include "scene/scene_report.h"

/* Sets an entry by its dotted path. A part of the path that is a list takes an index, or none and
 * then means all its elements. rotor.rpm keeps the sense of counter-turning rotors and the ratios
 * of blades with a speed of their own; balls.count keeps the species' proportions; contact.rule and
 * its like, and rotor.radius, .reach, .tip, also replace what parts had for themselves. */
void em_scene_override_apply(struct em_scene_report *report, config_t *tree, const char *text);

#endif
