/* The command lines of mill. */
#include <getopt.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tool/mill.h"

static const struct option known[] = {
    {"output", required_argument, NULL, 'o'},
    {"resume", no_argument, NULL, EM_MILL_RESUME},
    {"force", no_argument, NULL, EM_MILL_FORCE},
    {"quiet", no_argument, NULL, 'q'},
    {"json", no_argument, NULL, 'j'},
    {"until-precision", required_argument, NULL, EM_MILL_PRECISION},
    {"joined", no_argument, NULL, EM_MILL_JOINED},
    {"help", no_argument, NULL, 'h'},
    {NULL, 0, NULL, 0},
};

int em_mill_usage(const struct em_mill_help *help, const char *what, const char *word) {
  fprintf(stderr, "mill %s: error: %s", help->name, what);
  if (word) fprintf(stderr, " '%s'", word);
  fprintf(stderr, "\nTry 'mill %s --help'.\n", help->name);
  return EM_MILL_USAGE;
}

static void set(struct em_mill_options *options, int letter) {
  switch (letter) {
  case 'o':
    options->out = optarg;
    break;
  case EM_MILL_PRECISION:
    options->precision = optarg;
    break;
  case EM_MILL_RESUME:
    options->resume = true;
    break;
  case EM_MILL_FORCE:
    options->force = true;
    break;
  case 'q':
    options->quiet = true;
    break;
  case EM_MILL_JOINED:
    options->joined = true;
    break;
  default:
    options->json = true;
  }
}

int em_mill_words(struct em_mill_options *options, const struct em_mill_help *help, int count,
                  char **words) {
  if (count == 0)
    return em_mill_usage(help, "no scene given, expected SCENE [KEY=VALUE ...]", NULL);
  options->overrides = calloc((size_t)count, sizeof *options->overrides);
  if (!options->overrides) return em_mill_usage(help, "out of memory", NULL);
  for (int i = 0; i < count; i++) {
    const char *equal = strchr(words[i], '=');
    if (equal && equal != words[i] && options->scene)
      options->overrides[options->override_count++] = words[i];
    else if (!options->scene)
      options->scene = words[i];
    else
      return em_mill_usage(help, "expected KEY=VALUE, found", words[i]);
  }
  return -1;
}

int em_mill_unknown(const struct em_mill_help *help, const char *letters, int letter,
                    const char *name, const char *word) {
  char text[64];
  const int single = letter == '?' ? optopt : letter;
  if (letter == '?' && single && (single > UCHAR_MAX || strchr(letters, single)))
    return em_mill_usage(help, "no value belongs to", word);
  if (!name && !single) return em_mill_usage(help, "unknown option", word);
  if (name)
    snprintf(text, sizeof text, "--%s", name);
  else
    snprintf(text, sizeof text, "-%c", single);
  return em_mill_usage(help, "unknown option", text);
}

static bool takes(const struct em_mill_help *help, int option) {
  for (const int *own = help->takes; *own; own++)
    if (*own == option) return true;
  return false;
}

int em_mill_options(struct em_mill_options *options, const struct em_mill_help *help, int argc,
                    char **argv) {
  static const char letters[] = ":o:qjh";
  memset(options, 0, sizeof *options);
  opterr = 0;
  optind = 1;
  for (;;) {
    int index = -1;
    const int letter = getopt_long(argc, argv, letters, known, &index);
    if (letter == -1) break;
    if (letter == 'h') {
      fputs(help->text, stdout);
      return EM_MILL_DONE;
    }
    if (letter == ':') return em_mill_usage(help, "a value is missing after", argv[optind - 1]);
    if (letter == '?' || !takes(help, letter))
      return em_mill_unknown(help, letters, letter, index >= 0 ? known[index].name : NULL,
                             argv[optind - 1]);
    set(options, letter);
  }
  return em_mill_words(options, help, argc - optind, argv + optind);
}

void em_mill_complain(const struct em_error *err) {
  fprintf(stderr, "%s\n", err->text);
}

static int refuse(const struct em_error *err) {
  em_mill_complain(err);
  return err->code == EM_MEMORY ? EM_MILL_FAILED : EM_MILL_USAGE;
}

int em_mill_read(struct em_scene **scene, const struct em_mill_options *options) {
  struct em_error err = {0};
  const enum em_status status =
      em_scene_read(scene, options->scene, options->override_count, options->overrides, &err);
  return status ? refuse(&err) : -1;
}

int em_mill_scene(struct em_scene **scene, const struct em_mill_options *options) {
  struct em_error err = {0};
  const int code = em_mill_read(scene, options);
  if (code >= 0) return code;
  return em_run_file_turn(*scene, &err) ? refuse(&err) : -1;
}
