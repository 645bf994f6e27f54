/* Fuzz target: any text is a scene or gives an error; a scene prints as a scene. The first line, if
 * it begins with "%", holds an override. */
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "eventmill/scene.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static void read_back(const struct em_scene *scene) {
  char *text = em_scene_text(scene);
  struct em_scene *again;
  if (!text || em_scene_parse(&again, text, "again.cfg", 0, NULL, NULL) != EM_OK) abort();
  char *second = em_scene_text(again);
  if (!second || strcmp(text, second) != 0) abort();
  em_scene_free(again);
  free(second);
  free(text);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  char *text = malloc(size + 1);
  if (!text) return 0;
  memcpy(text, data, size);
  text[size] = '\0';
  char *scene_text = text, *line = text[0] == '%' ? strchr(text, '\n') : NULL;
  const char *override = text + 1;
  if (line) {
    *line = '\0';
    scene_text = line + 1;
  }
  struct em_scene *scene;
  struct em_error err;
  enum em_status status =
      em_scene_parse(&scene, scene_text, "/nowhere/fuzz.cfg", line ? 1 : 0, &override, &err);
  if (status == EM_OK) {
    read_back(scene);
    em_scene_effects(scene);
    em_scene_free(scene);
  } else if (scene || err.code == EM_OK || err.text[0] == '\0') {
    abort();
  }
  free(text);
  return 0;
}
