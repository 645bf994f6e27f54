/* Collects the errors of a scene with the place of each. */
#include "scene/scene_report.h"

#include <ctype.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MESSAGE = 700, PATH = 256 };

/* Room that is kept for the last line, which counts what was left out. */
enum { RESERVE = 64 };

static void add(struct em_scene_report *report, const char *file, int line, const char *text) {
  report->errors++;
  if (report->status == EM_OK) report->status = EM_INPUT;
  if (!report->err) return;
  size_t used = report->err->code == EM_OK ? 0 : strlen(report->err->text);
  size_t need = strlen(text) + strlen(file) + RESERVE;
  if (report->omitted > 0 || used + need >= EM_ERROR_TEXT - RESERVE)
    report->omitted++;
  else
    em_error_add(report->err, EM_INPUT, file, line, "%s", text);
}

void em_scene_report_line(struct em_scene_report *report, const char *file, int line,
                          const char *format, ...) {
  char text[MESSAGE];
  va_list args;
  va_start(args, format);
  vsnprintf(text, sizeof text, format, args);
  va_end(args);
  add(report, file ? file : "command line", line, text);
}

void em_scene_report_memory(struct em_scene_report *report) {
  if (report->status != EM_MEMORY)
    em_error_set(report->err, EM_MEMORY, NULL, 0, "no memory for the scene");
  report->status = EM_MEMORY;
  report->errors++;
}

enum em_status em_scene_report_end(struct em_scene_report *report) {
  if (report->omitted > 0 && report->status != EM_MEMORY)
    em_error_add(report->err, EM_INPUT, NULL, 0, "and %zu more", report->omitted);
  return report->status;
}

void em_scene_report_name(const config_setting_t *setting, size_t size, char *text) {
  text[0] = '\0';
  if (!setting || config_setting_is_root(setting)) return;
  const config_setting_t *parent = config_setting_parent(setting);
  em_scene_report_name(parent, size, text);
  size_t used = strlen(text);
  const char *dot = used > 0 ? "." : "", *name = config_setting_name(setting);
  if (name)
    snprintf(text + used, size - used, "%s%s", dot, name);
  else
    snprintf(text + used, size - used, "%s%d", dot, config_setting_index(setting));
}

void em_scene_report_value(const config_setting_t *setting, size_t size, char *text) {
  switch (config_setting_type(setting)) {
  case CONFIG_TYPE_INT:
  case CONFIG_TYPE_INT64:
    snprintf(text, size, "%lld", config_setting_get_int64(setting));
    break;
  case CONFIG_TYPE_FLOAT:
    snprintf(text, size, "%.10g", config_setting_get_float(setting));
    /* A real without a point would look like the integer that may be expected. */
    if (!strpbrk(text, ".en")) snprintf(text + strlen(text), size - strlen(text), ".0");
    break;
  case CONFIG_TYPE_STRING:
    snprintf(text, size, "\"%.60s\"", config_setting_get_string(setting));
    break;
  case CONFIG_TYPE_BOOL:
    snprintf(text, size, "%s", config_setting_get_bool(setting) ? "true" : "false");
    break;
  case CONFIG_TYPE_GROUP:
    snprintf(text, size, "a group { }");
    break;
  default:
    snprintf(text, size, "a list of %d", config_setting_length(setting));
    break;
  }
}

/* Was the setting, or something that it is part of, made by an override? */
static bool is_override(const config_setting_t *setting) {
  for (; setting; setting = config_setting_parent(setting))
    if (config_setting_get_hook(setting)) return true;
  return false;
}

static void add_at(struct em_scene_report *report, const config_setting_t *setting,
                   const char *text) {
  if (is_override(setting)) {
    add(report, "command line", 0, text);
    return;
  }
  int line = 1;
  const char *file = report->source->name;
  if (!config_setting_is_root(setting))
    file = em_scene_source_place(report->source, (int)config_setting_source_line(setting), &line);
  add(report, file, line, text);
}

void em_scene_report_at(struct em_scene_report *report, const config_setting_t *setting,
                        const char *format, ...) {
  char path[PATH], body[MESSAGE - PATH], text[MESSAGE + 8];
  em_scene_report_name(setting, sizeof path, path);
  va_list args;
  va_start(args, format);
  vsnprintf(body, sizeof body, format, args);
  va_end(args);
  snprintf(text, sizeof text, "%s%s%s", path, path[0] ? ": " : "", body);
  add_at(report, setting, text);
}

/* The child of a setting that a path's next part names, or NULL. */
static const config_setting_t *child(const config_setting_t *setting, const char *part,
                                     size_t length) {
  char name[PATH];
  if (length >= sizeof name) return NULL;
  memcpy(name, part, length);
  name[length] = '\0';
  bool index = isdigit((unsigned char)name[0]) != 0;
  if (config_setting_type(setting) == CONFIG_TYPE_GROUP)
    return index ? (atoi(name) == 0 ? setting : NULL) : config_setting_get_member(setting, name);
  if (!config_setting_is_aggregate(setting) || !index) return NULL;
  return config_setting_get_elem(setting, (unsigned)atoi(name));
}

void em_scene_report_path(struct em_scene_report *report, const char *path, const char *format,
                          ...) {
  const config_setting_t *setting = config_root_setting(report->tree);
  for (const char *part = path; setting && *part;) {
    size_t length = strcspn(part, ".");
    const config_setting_t *next = child(setting, part, length);
    if (!next) break;
    setting = next;
    part += length + (part[length] == '.');
  }
  char body[MESSAGE - PATH], text[MESSAGE + 8];
  va_list args;
  va_start(args, format);
  vsnprintf(body, sizeof body, format, args);
  va_end(args);
  snprintf(text, sizeof text, "%.200s%s%s", path, path[0] ? ": " : "", body);
  add_at(report, setting, text);
}
