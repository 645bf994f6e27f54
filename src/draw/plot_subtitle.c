/* Scene and operating point in one line. */
#include <stdarg.h>
#include <stdio.h>

#include "eventmill/plot.h"

#include "num/locale.h"

struct line {
  char *text;
  size_t size, used;
};

static void add(struct line *line, const char *format, ...) __attribute__((format(printf, 2, 3)));

static void add(struct line *line, const char *format, ...) {
  if (line->used >= line->size) return;
  va_list list;
  va_start(list, format);
  const int more = vsnprintf(line->text + line->used, line->size - line->used, format, list);
  va_end(list);
  if (more > 0) line->used += (size_t)more;
}

static void begin_part(struct line *line) {
  if (line->used > 0) add(line, " · ");
}

static void add_speeds(struct line *line, const struct em_scene *scene) {
  bool alike = true;
  for (size_t k = 1; k < scene->rotor_count; k++)
    alike = alike && scene->rotor[k].rpm == scene->rotor[0].rpm;
  const size_t count = alike && scene->rotor_count > 1 ? 1 : scene->rotor_count;
  if (count == 0) return;
  begin_part(line);
  for (size_t k = 0; k < count; k++)
    add(line, "%s%g", k > 0 ? " and " : "", scene->rotor[k].rpm);
  add(line, " rpm");
}

/* As many bytes of a title as leave room for the operating point beside it, in whole letters. */
static int title_length(const char *title) {
  enum { MOST = 64 };
  int letters = 0, length = 0;
  for (; title[length] != '\0'; length++) {
    letters += ((unsigned char)title[length] & 0xC0) != 0x80; /* UTF-8 */
    if (letters > MOST) break;
  }
  return length;
}

static void add_operating_point(struct line *line, const struct em_scene *scene) {
  add_speeds(line, scene);
  for (size_t k = 0; k < scene->species_count && k < 4; k++) {
    begin_part(line);
    add(line, "%zu ball%s of %g mm", scene->species[k].count,
        scene->species[k].count == 1 ? "" : "s", 1e3 * scene->species[k].diameter);
  }
}

void em_plot_operating_point(const struct em_scene *scene, char *text, size_t size) {
  EM_LOCALE_PLAIN;
  struct line line = {text, size, 0};
  if (size > 0) text[0] = '\0';
  add_operating_point(&line, scene);
}

void em_plot_subtitle(const struct em_scene *scene, char *text, size_t size) {
  EM_LOCALE_PLAIN;
  struct line line = {text, size, 0};
  const int length = title_length(scene->title);
  if (size > 0) text[0] = '\0';
  add(&line, "%.*s%s", length, scene->title, scene->title[length] != '\0' ? "…" : "");
  add_operating_point(&line, scene);
}
