/* Command lines by a table: getopt's list, help, numbers, messages. */
#include "tool/millpost_line.h"

#include <getopt.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tool/millpost.h"

enum { FIRST = 1000 }; /* what getopt returns for the first option */

static const char *name_of(const struct em_millpost_option *option) {
  return option->name ? option->name : option->key;
}

static bool takes(const struct em_millpost_help *help, const struct em_millpost_option *option) {
  if (!help->options || option->target == EM_MILLPOST_CHOICE) return true;
  for (const char *const *key = help->options; **key; key++)
    if (strcmp(*key, option->key) == 0) return true;
  return false;
}

static void print_help(const struct em_millpost_line *line, const struct em_millpost_help *help) {
  printf("Usage: millpost %s %s\n\n%s\n", help->name, help->arguments, help->summary);
  if (help->details) printf("\n%s\n", help->details);
  printf("\nOptions:\n");
  for (size_t k = 0; k < line->count; k++) {
    const struct em_millpost_option *option = &line->option[k];
    if (!takes(help, option) || !option->help) continue;
    char left[64];
    snprintf(left, sizeof left, "--%s%s%s", name_of(option), option->argument ? " " : "",
             option->argument ? option->argument : "");
    printf("  %-18s %s\n", left, option->help);
  }
  printf("  %-18s %s\n", "--quiet", "-q: no progress, no report on the standard error");
  printf("  %-18s %s\n", "--help", "-h: print this");
  if (help->examples) printf("\nExamples:\n%s\n", help->examples);
}

bool em_millpost_line_number(const char *text, char end, double *value, const char **rest) {
  char *stop;
  *value = strtod(text, &stop);
  if (rest) *rest = stop;
  return stop != text && *stop == end && isfinite(*value);
}

int em_millpost_line_range(void *place, const char *command, const char *option, const char *text) {
  double *low = place;
  const char *rest;
  if (em_millpost_line_number(text, ':', &low[0], &rest) &&
      em_millpost_line_number(rest + 1, '\0', &low[1], NULL) && low[0] < low[1])
    return -1;
  return em_millpost_usage(command, "--%s: '%s' is not LOW:HIGH with LOW < HIGH", option, text);
}

static int store_number(void *place, const struct em_millpost_option *option, const char *command,
                        const char *text) {
  const char *name = name_of(option);
  double value;
  if (!em_millpost_line_number(text, '\0', &value, NULL))
    return em_millpost_usage(command, "--%s: '%s' is not a number", name, text);
  if (option->target == EM_MILLPOST_POSITIVE && !(value > 0.0))
    return em_millpost_usage(command, "--%s: %s is not above 0", name, text);
  if (option->target != EM_MILLPOST_WHOLE) {
    *(double *)place = value;
    return -1;
  }
  if (!(value >= 1.0 && value <= 1e9 && value == floor(value)))
    return em_millpost_usage(command, "--%s: '%s' is not a whole number from 1 to 1000000000", name,
                             text);
  *(long *)place = (long)value;
  return -1;
}

static int store(void *wish, const struct em_millpost_option *option, const char *command,
                 const char *text) {
  void *place = (char *)wish + option->offset;
  switch (option->target) {
  case EM_MILLPOST_TEXT:
    *(const char **)place = text;
    return -1;
  case EM_MILLPOST_FLAG:
    *(bool *)place = true;
    return -1;
  case EM_MILLPOST_CHOICE:
    *(int *)place = option->value;
    return -1;
  case EM_MILLPOST_OTHER:
    return option->read(place, command, name_of(option), text);
  default:
    return store_number(place, option, command, text);
  }
}

/* The options of this command, as getopt_long wants them. */
static void list_options(struct option *list, const struct em_millpost_line *line,
                         const struct em_millpost_help *help) {
  for (size_t k = 0; k < line->count; k++)
    if (takes(help, &line->option[k]))
      *list++ = (struct option){name_of(&line->option[k]),
                                line->option[k].argument ? required_argument : no_argument, NULL,
                                FIRST + (int)k};
  *list++ = (struct option){"quiet", no_argument, NULL, 'q'};
  *list = (struct option){"help", no_argument, NULL, 'h'};
}

static const char *long_name(int letter) {
  return letter == 'o' ? "output" : letter == 'j' ? "json" : "";
}

/* The option that getopt found; a letter is short for the first one of its long name. */
static const struct em_millpost_option *found(const struct em_millpost_line *line,
                                              const struct em_millpost_help *help, int letter) {
  for (size_t k = 0; k < line->count; k++)
    if (letter == FIRST + (int)k || (takes(help, &line->option[k]) &&
                                     strcmp(name_of(&line->option[k]), long_name(letter)) == 0))
      return &line->option[k];
  return NULL;
}

static int read_options(void *wish, const struct em_millpost_line *line,
                        const struct em_millpost_help *help, const struct option *list, int argc,
                        char **argv) {
  opterr = 0;
  optind = 0; /* glibc: start afresh, even after another command line */
  for (int c; (c = getopt_long(argc, argv, ":hqo:j", list, NULL)) != -1;) {
    /* A single letter may stand among others, or have a value after it. */
    const int letter = c == '?' ? optopt : c;
    const char single[] = {'-', (char)letter, '\0'};
    const bool is_single = c == 'o' || c == 'j' ||
                           (c == '?' && letter && letter < FIRST && letter != 'h' && letter != 'q');
    const char *asked = is_single ? single : optind > 0 ? argv[optind - 1] : "";
    if (c == 'h') {
      print_help(line, help);
      return EM_MILLPOST_DONE;
    }
    if (c == 'q') {
      *(bool *)((char *)wish + line->quiet) = true;
      continue;
    }
    if (c == ':') return em_millpost_usage(help->name, "'%s' needs a value", asked);
    const struct em_millpost_option *option = found(line, help, c);
    if (!option) return em_millpost_usage(help->name, "unknown option '%s'", asked);
    const int code = store(wish, option, help->name, optarg);
    if (code >= 0) return code;
  }
  return -1;
}

int em_millpost_line_read(void *wish, const struct em_millpost_line *line,
                          const struct em_millpost_help *help, int argc, char **argv, int *words,
                          char ***word) {
  struct option *list = calloc(line->count + 3, sizeof *list);
  if (!list) return em_millpost_usage(help->name, "out of memory");
  list_options(list, line, help);
  const int code = read_options(wish, line, help, list, argc, argv);
  free(list);
  if (code >= 0) return code;
  *words = argc - optind;
  *word = argv + optind;
  if (*words < help->least)
    return em_millpost_usage(help->name, "expected %s%s", help->least > 1 ? "at least: " : "",
                             help->arguments);
  if (help->most >= 0 && *words > help->most)
    return em_millpost_usage(help->name, "unexpected argument '%s'", (*word)[help->most]);
  return -1;
}
