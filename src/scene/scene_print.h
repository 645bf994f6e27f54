/* A scene as text. */
#ifndef EVENTMILL_SCENE_SCENE_PRINT_H
#define EVENTMILL_SCENE_SCENE_PRINT_H

#include <stdio.h>

#include "eventmill/scene.h"

void em_scene_print_all(const struct em_scene *scene, FILE *out);

#endif
