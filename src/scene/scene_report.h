/* Errors of a scene: where they stand in the file or on the command line, all of them collected. */
#ifndef EVENTMILL_SCENE_SCENE_REPORT_H
#define EVENTMILL_SCENE_SCENE_REPORT_H

#include <libconfig.h>
#include <stddef.h>

#include "eventmill/error.h"
#include "scene/scene_source.h"

struct em_scene_report {
  const struct em_scene_source *source;
  const config_t *tree;
  struct em_error *err; /* borrowed; may be NULL */
  enum em_status status;
  size_t errors;  /* found so far */
  size_t omitted; /* of these, for want of room in err */
};

/* An error at a setting; the text begins with the setting's path. A setting that an override made
 * (its hook is set) is reported as of the command line. */
void em_scene_report_at(struct em_scene_report *report, const config_setting_t *setting,
                        const char *format, ...) __attribute__((format(printf, 3, 4)));

/* The same for a dotted path ("rotor.1.blades.0"), which need not exist: the nearest setting above
 * it gives the line. An index 0 may stand for the only group where no list is. */
void em_scene_report_path(struct em_scene_report *report, const char *path, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* An error at a line of a file (NULL, 0: on the command line). */
void em_scene_report_line(struct em_scene_report *report, const char *file, int line,
                          const char *format, ...) __attribute__((format(printf, 4, 5)));

/* Out of memory: reported once. */
void em_scene_report_memory(struct em_scene_report *report);

/* Says how many errors had no room, and returns the status of the whole. */
enum em_status em_scene_report_end(struct em_scene_report *report);

/* Writes the dotted path of a setting. */
void em_scene_report_name(const config_setting_t *setting, size_t size, char *text);

/* Writes the value of a setting as a message shows it. */
void em_scene_report_value(const config_setting_t *setting, size_t size, char *text);

#endif
