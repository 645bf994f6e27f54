/* Command lines of millpost: one list of options, of which each command takes its own. */
#include <errno.h>
#include <getopt.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "eventmill/contact.h"
#include "tool/millpost.h"

enum target { TEXT, NUMBER, WHOLE, FLAG, CLASSES, FORMAT };

struct option_entry {
  const char *name, *argument, *help;
  enum target target;
  size_t offset;
  int value; /* FORMAT: which */
};

#define AT(field) offsetof(struct em_millpost_options, field)

static const struct option_entry entries[] = {
    {"of", "WHAT", "which quantity", TEXT, AT(of), 0},
    {"class", "CLASS,...", "only these: ball-ball ball-drum ball-end ball-blade", CLASSES,
     AT(classes), 0},
    {"from", "T", "begin at T seconds; default: when the run is steady", NUMBER, AT(from), 0},
    {"to", "T", "end at T seconds; default: the end of the run", NUMBER, AT(to), 0},
    {"bins", "N", "number of bins; default: the square root of the number of values", WHOLE,
     AT(bins), 0},
    {"above", "V", "threshold of shares and rates; default: 3 (m/s)", NUMBER, AT(above), 0},
    {"level", "P", "level of the confidence intervals; default: 0.95", NUMBER, AT(level), 0},
    {"alpha", "P",
     "a law is refuted when its p-value, times the number of tests, is below P; "
     "default: 0.001",
     NUMBER, AT(alpha), 0},
    {"cumulative", NULL, "draw the shares below a value instead of the density", FLAG,
     AT(cumulative), 0},
    {"curve", NULL, "print the histogram itself, bin by bin", FLAG, AT(curve), 0},
    {"log", NULL, "logarithmic axis", FLAG, AT(log), 0},
    {"cells", "KIND", "sectors (seen along the axis) or rings (seen from the side)", TEXT,
     AT(cells), 0},
    {"slices", "N", "cut the drum into N slices along its axis; default: 1", WHOLE, AT(slices), 0},
    {"tubes", "N", "number of tubes of the sectors; default: 25", WHOLE, AT(tubes), 0},
    {"sectors", "N", "number of sectors of a slice; default: 2500", WHOLE, AT(sectors), 0},
    {"rings", "N", "least number of rings; default: 2000", WHOLE, AT(rings), 0},
    {"minus", "RUN", "subtract the map of another run", TEXT, AT(minus), 0},
    {"spread", NULL, "map the relative standard deviation instead of the mean", FLAG, AT(spread),
     0},
    {"relative", NULL, "map the confidence interval of the mean, relative to the mean", FLAG,
     AT(relative), 0},
    {"match", "FIGURE", "what to hold fixed: median-vn or rate-above", TEXT, AT(match), 0},
    {"target", "X", "the value to reach; default: that of the first run", NUMBER, AT(target), 0},
    {"to-format", "FORMAT", "xdmf xdmf3 vtk lammps csv pov or stl", TEXT, AT(to_format), 0},
    {"until", "T", "end at T seconds; default: the end of the run", NUMBER, AT(to), 0},
    {"at", "T", "only the frame at T seconds", NUMBER, AT(at), 0},
    {"every", "N", "every Nth frame only; default: 1", WHOLE, AT(every), 0},
    {"anyway", NULL, "test laws also where the scene does not promise them", FLAG, AT(anyway), 0},
    {"scene", NULL, "print the scene that the run was made from", FLAG, AT(scene), 0},
    {"output", "FILE", "-o FILE: write a picture (.png .svg .pdf, or .gp for gnuplot)", TEXT,
     AT(out), 0},
    {"csv", NULL, "print comma-separated values", FORMAT, AT(format), EM_REPORT_CSV},
    {"json", NULL, "print one JSON object", FORMAT, AT(format), EM_REPORT_JSON},
};

enum { ENTRIES = sizeof entries / sizeof *entries };

static bool takes(const struct em_millpost_help *help, const struct option_entry *entry) {
  if (entry->target == FORMAT) return true;
  for (const char *const *name = help->options; **name; name++)
    if (strcmp(*name, entry->name) == 0) return true;
  return false;
}

static void print_help(const struct em_millpost_help *help) {
  printf("Usage: millpost %s %s\n\n%s\n", help->name, help->arguments, help->summary);
  if (help->details) printf("\n%s\n", help->details);
  printf("\nOptions:\n");
  for (int k = 0; k < ENTRIES; k++) {
    if (!takes(help, &entries[k])) continue;
    char left[64];
    const bool to = strcmp(entries[k].name, "to-format") == 0;
    snprintf(left, sizeof left, "--%s%s%s", to ? "to" : entries[k].name,
             entries[k].argument ? " " : "", entries[k].argument ? entries[k].argument : "");
    printf("  %-18s %s\n", left, entries[k].help);
  }
  printf("  %-18s %s\n", "--help", "print this");
  if (help->examples) printf("\nExamples:\n%s\n", help->examples);
}

int em_millpost_usage(const char *command, const char *format, ...) {
  va_list args;
  va_start(args, format);
  fprintf(stderr, "millpost %s: error: ", command);
  vfprintf(stderr, format, args);
  fprintf(stderr, "\nTry 'millpost %s --help'.\n", command);
  va_end(args);
  return EM_MILLPOST_USAGE;
}

static int read_classes(unsigned *classes, const char *command, const char *text) {
  char list[256];
  if (strlen(text) >= sizeof list) return em_millpost_usage(command, "'%s' is too long", text);
  strcpy(list, text);
  *classes = 0;
  char *rest = list;
  for (char *name; (name = strsep(&rest, ",")) != NULL;) {
    const int k = em_contact_class_find(name);
    if (k < 0)
      return em_millpost_usage(command,
                               "unknown class '%s', expected ball-ball, ball-drum, "
                               "ball-end or ball-blade",
                               name);
    *classes |= 1U << k;
  }
  return -1;
}

static int store(struct em_millpost_options *options, const struct option_entry *entry,
                 const char *command, char *text) {
  char *place = (char *)options + entry->offset, *end;
  switch (entry->target) {
  case TEXT:
    *(const char **)(void *)place = text;
    return -1;
  case FLAG:
    *(bool *)(void *)place = true;
    return -1;
  case FORMAT:
    options->format = (enum em_report_format)entry->value;
    return -1;
  case CLASSES:
    return read_classes(&options->classes, command, text);
  case NUMBER: {
    const double value = strtod(text, &end);
    if (end == text || *end || !isfinite(value))
      return em_millpost_usage(command, "--%s: '%s' is not a number", entry->name, text);
    *(double *)(void *)place = value;
    return -1;
  }
  case WHOLE: {
    errno = 0;
    const long value = strtol(text, &end, 10);
    if (end == text || *end || errno || value < 1 || value > 10000000)
      return em_millpost_usage(command, "--%s: '%s' is not a number from 1 to 10000000",
                               entry->name, text);
    *(long *)(void *)place = value;
    return -1;
  }
  }
  return -1;
}

static struct em_millpost_options defaults(void) {
  return (struct em_millpost_options){.from = NAN,
                                      .to = NAN,
                                      .above = NAN,
                                      .below = NAN,
                                      .at = NAN,
                                      .target = NAN,
                                      .level = 0.95,
                                      .alpha = 0.001};
}

/* The options of this command, as getopt_long wants them; `val` is the index in `entries`. */
static void list_options(struct option *list, const struct em_millpost_help *help) {
  int count = 0;
  for (int k = 0; k < ENTRIES; k++) {
    if (!takes(help, &entries[k])) continue;
    const char *name = strcmp(entries[k].name, "to-format") == 0 ? "to" : entries[k].name;
    list[count++] = (struct option){name, entries[k].argument ? required_argument : no_argument,
                                    NULL, 1000 + k};
  }
  list[count++] = (struct option){"help", no_argument, NULL, 'h'};
  list[count] = (struct option){NULL, 0, NULL, 0};
}

static int check(const struct em_millpost_options *options, const struct em_millpost_help *help) {
  if (options->run_count < help->least)
    return em_millpost_usage(help->name, "expected %s%s", help->least > 1 ? "at least: " : "",
                             help->arguments);
  if (help->most >= 0 && options->run_count > help->most)
    return em_millpost_usage(help->name, "unexpected argument '%s'", options->run[help->most]);
  if (!(options->level > 0.0 && options->level < 1.0))
    return em_millpost_usage(help->name, "--level must lie between 0 and 1");
  if (!(options->alpha > 0.0 && options->alpha < 1.0))
    return em_millpost_usage(help->name, "--alpha must lie between 0 and 1");
  return -1;
}

int em_millpost_options(struct em_millpost_options *options, const struct em_millpost_help *help,
                        int argc, char **argv) {
  struct option list[ENTRIES + 2];
  list_options(list, help);
  *options = defaults();
  opterr = 0;
  optind = 0; /* glibc: start afresh, even after another command line */
  const char *asked;
  for (int c; asked = NULL, (c = getopt_long(argc, argv, ":ho:", list, NULL)) != -1;) {
    asked = optind > 0 ? argv[optind - 1] : "";
    if (c == 'h') {
      print_help(help);
      return EM_MILLPOST_DONE;
    }
    if (c == ':') return em_millpost_usage(help->name, "'%s' needs a value", asked);
    if (c == '?') return em_millpost_usage(help->name, "unknown option '%s'", asked);
    const struct option_entry *entry = NULL;
    for (int k = 0; k < ENTRIES; k++)
      if (c == 1000 + k || (c == 'o' && strcmp(entries[k].name, "output") == 0))
        entry = &entries[k];
    if (!entry || !takes(help, entry))
      return em_millpost_usage(help->name, "unknown option '%s'", asked);
    const int code = store(options, entry, help->name, optarg);
    if (code >= 0) return code;
  }
  options->run_count = argc - optind;
  options->run = argv + optind;
  return check(options, help);
}

int em_millpost_fail(const struct em_error *err) {
  const char *text = err->text[0] ? err->text : em_error_text(err->code);
  if (strncmp(text, "error: ", 7) == 0)
    fprintf(stderr, "millpost: %s\n", text);
  else
    fprintf(stderr, "%s\n", text);
  return err->code == EM_INPUT ? EM_MILLPOST_USAGE : EM_MILLPOST_FAILED;
}

int em_millpost_print(struct em_report *report, const struct em_millpost_options *options,
                      int code) {
  struct em_error err = {.code = EM_OK};
  if (em_report_print(report, options->format, stdout, &err) != EM_OK)
    code = em_millpost_fail(&err);
  em_report_free(report);
  return code;
}

void em_millpost_label(const char *path, char *label, size_t size) {
  const char *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path;
  snprintf(label, size, "%s", name);
  char *dot = strrchr(label, '.');
  if (dot && dot != label && strcmp(dot, ".h5") == 0) *dot = '\0';
}
