/* Scene and operating point in one line. */
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

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

/* The parts of an operating point, each without what stands between parts. */
static void add_title(struct line *line, const struct em_scene *scene) {
  const int length = title_length(scene->title);
  add(line, "%.*s%s", length, scene->title, scene->title[length] != '\0' ? "…" : "");
}

static void add_speeds(struct line *line, const struct em_scene *scene) {
  bool alike = true;
  for (size_t k = 1; k < scene->rotor_count; k++)
    alike = alike && scene->rotor[k].rpm == scene->rotor[0].rpm;
  const size_t count = alike && scene->rotor_count > 1 ? 1 : scene->rotor_count;
  if (count == 0) return;
  for (size_t k = 0; k < count; k++)
    add(line, "%s%g", k > 0 ? " and " : "", scene->rotor[k].rpm);
  add(line, " rpm");
}

static void add_balls(struct line *line, const struct em_scene *scene) {
  enum { MOST = 4 };
  for (size_t k = 0; k < scene->species_count && k < MOST; k++)
    add(line, "%s%zu ball%s of %g mm", k > 0 ? " · " : "", scene->species[k].count,
        scene->species[k].count == 1 ? "" : "s", 1e3 * scene->species[k].diameter);
  if (scene->species_count > MOST) add(line, " · …");
}

/* A part of all scenes: once what they have in common, else side by side. */
static void add_part(struct line *line, void (*part)(struct line *, const struct em_scene *),
                     const struct em_scene *const *scene, size_t count) {
  enum { MOST = 4, SIZE = 400 };
  char known[MOST][SIZE];
  size_t kinds = 0;
  for (size_t k = 0; k < count && kinds < MOST; k++) {
    struct line one = {known[kinds], SIZE, 0};
    bool is_new = true;
    known[kinds][0] = '\0';
    part(&one, scene[k]);
    for (size_t j = 0; j < kinds; j++)
      is_new = is_new && strcmp(known[j], known[kinds]) != 0;
    kinds += is_new && one.used > 0;
  }
  for (size_t j = 0; j < kinds && j < MOST - 1; j++) {
    if (j > 0)
      add(line, " / ");
    else if (line->used > 0)
      add(line, " · ");
    add(line, "%s", known[j]);
  }
  if (kinds == MOST) add(line, " / …");
}

static struct line begin(char *text, size_t size) {
  if (size > 0) text[0] = '\0';
  return (struct line){text, size, 0};
}

void em_plot_operating_point(const struct em_scene *scene, char *text, size_t size) {
  EM_LOCALE_PLAIN;
  struct line line = begin(text, size);
  add_part(&line, add_speeds, &scene, 1);
  add_part(&line, add_balls, &scene, 1);
}

void em_plot_subtitles(const struct em_scene *const *scene, size_t count, char *text, size_t size) {
  EM_LOCALE_PLAIN;
  struct line line = begin(text, size);
  add_part(&line, add_title, scene, count);
  add_part(&line, add_speeds, scene, count);
  add_part(&line, add_balls, scene, count);
}

void em_plot_subtitle(const struct em_scene *scene, char *text, size_t size) {
  em_plot_subtitles(&scene, 1, text, size);
}
