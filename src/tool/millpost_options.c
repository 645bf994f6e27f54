/* Command lines of millpost: one list of options, of which each command takes its own. */
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

#include "eventmill/contact.h"
#include "tool/export.h"
#include "tool/millpost.h"

#define AT(field) offsetof(struct em_millpost_options, field)
#define OPTION(key, argument, help, target, field) \
  EM_MILLPOST_OPTION(struct em_millpost_options, key, argument, help, target, field)

static int read_classes(void *place, const char *command, const char *option, const char *text);

static const struct em_millpost_option options[] = {
    OPTION("of", "WHAT", "which quantity", TEXT, of),
    {"class", "CLASS,...", "only these:" EM_CLASS_LIST(EM_MILLPOST_WORD), EM_MILLPOST_OTHER,
     AT(classes), NULL, 0, read_classes},
    OPTION("from", "T", "begin at T seconds; default: when the run is steady", NUMBER, from),
    OPTION("to", "T", "end at T seconds; default: the end of the run", NUMBER, to),
    OPTION("bins", "N",
           "number of bins; default: the square root of the number of values of the smallest class",
           WHOLE, bins),
    OPTION("above", "V", "threshold of shares and rates; default: 3 (m/s)", NUMBER, above),
    OPTION("level", "P", "level of the confidence intervals; default: 0.95", NUMBER, level),
    OPTION("alpha", "P",
           "a law is refuted when its p-value, times the number of tests, is below P; "
           "default: 0.001",
           NUMBER, alpha),
    OPTION("cumulative", NULL, "draw the shares below a value instead of the density", FLAG,
           cumulative),
    OPTION("curve", NULL, "print the curves themselves, as a table", FLAG, curve),
    OPTION("log", NULL, "logarithmic axis", FLAG, log),
    OPTION("cells", "KIND", "sectors (seen along the axis) or rings (seen from the side)", TEXT,
           cells),
    OPTION("slices", "N", "cut the drum into N slices along its axis; default: 1", WHOLE, slices),
    OPTION("tubes", "N", "number of tubes of the sectors; default: 25", WHOLE, tubes),
    OPTION("sectors", "N", "number of sectors of a slice; default: 2500", WHOLE, sectors),
    OPTION("rings", "N", "least number of rings; default: 2000", WHOLE, rings),
    OPTION("minus", "RUN", "subtract the map of another run", TEXT, minus),
    OPTION("spread", NULL,
           "map the relative standard deviation of speeds or v_n instead of the mean", FLAG,
           spread),
    OPTION("relative", NULL, "map the confidence interval of the mean, relative to the mean", FLAG,
           relative),
    OPTION("match", "FIGURE", "what to hold fixed: median-vn or rate-above", TEXT, match),
    OPTION("target", "X", "the value to reach; default: that of the first run", NUMBER, target),
    {"what", "collisions", "with --to csv: a line per collision instead of per ball and frame",
     EM_MILLPOST_TEXT, AT(of), "of", 0, NULL},
    {"to-format", "FORMAT", "one of:" EM_EXPORT_LIST(EM_MILLPOST_WORD), EM_MILLPOST_TEXT,
     AT(to_format), "to", 0, NULL},
    {"first", "T", "begin at T seconds; default: the begin of the run", EM_MILLPOST_NUMBER,
     AT(from), "from", 0, NULL},
    OPTION("until", "T", "end at T seconds; default: the end of the run", NUMBER, to),
    OPTION("at", "T", "only the frame nearest to T seconds", NUMBER, at),
    OPTION("every", "N", "every Nth frame only; default: 1", WHOLE, every),
    OPTION("anyway", NULL, "test laws also where the scene does not promise them", FLAG, anyway),
    OPTION("scene", NULL, "print the scene that the run was made from", FLAG, scene),
    OPTION("output", "FILE", "-o FILE: write a picture (.png .svg .pdf, or .gp for gnuplot)", TEXT,
           out),
    {"tables", "FILE.h5", "-o FILE.h5: write all three tables (HDF5)", EM_MILLPOST_TEXT, AT(out),
     "output", 0, NULL},
    {"result", "FILE", "-o FILE: what to write; default: beside the run, with its name",
     EM_MILLPOST_TEXT, AT(out), "output", 0, NULL},
    {"csv", NULL, "print comma-separated values", EM_MILLPOST_CHOICE, AT(format), NULL,
     EM_REPORT_CSV, NULL},
    {"json", NULL, "-j: print one JSON object", EM_MILLPOST_CHOICE, AT(format), NULL,
     EM_REPORT_JSON, NULL},
};

int em_millpost_usage(const char *command, const char *format, ...) {
  va_list args;
  va_start(args, format);
  fprintf(stderr, "millpost %s: error: ", command);
  vfprintf(stderr, format, args);
  fprintf(stderr, "\nTry 'millpost %s --help'.\n", command);
  va_end(args);
  return EM_MILLPOST_USAGE;
}

static int read_classes(void *place, const char *command, const char *option, const char *text) {
  unsigned *classes = place;
  char list[256];
  if (strlen(text) >= sizeof list)
    return em_millpost_usage(command, "--%s: '%s' is too long", option, text);
  strcpy(list, text);
  *classes = 0;
  char *rest = list;
  for (char *name; (name = strsep(&rest, ",")) != NULL;) {
    const int k = em_contact_class_find(name);
    if (k < 0)
      return em_millpost_usage(
          command, "unknown class '%s', expected one of:" EM_CLASS_LIST(EM_MILLPOST_WORD), name);
    *classes |= 1U << k;
  }
  return -1;
}

static struct em_millpost_options defaults(void) {
  return (struct em_millpost_options){.from = NAN,
                                      .to = NAN,
                                      .above = NAN,
                                      .at = NAN,
                                      .target = NAN,
                                      .level = 0.95,
                                      .alpha = 0.001};
}

/* An output never replaces what it is made from. */
static bool is_input(const struct em_millpost_options *o) {
  struct stat out, in;
  if (!o->out || stat(o->out, &out) != 0) return false;
  for (int k = 0; k < o->run_count; k++)
    if (stat(o->run[k], &in) == 0 && in.st_dev == out.st_dev && in.st_ino == out.st_ino)
      return true;
  return false;
}

static int check(const struct em_millpost_options *o, const struct em_millpost_help *help) {
  if (is_input(o))
    return em_millpost_usage(help->name, "-o %s would replace the run itself", o->out);
  if (!(o->level > 0.0 && o->level < 1.0))
    return em_millpost_usage(help->name, "--level must lie between 0 and 1");
  if (!(o->alpha > 0.0 && o->alpha < 1.0))
    return em_millpost_usage(help->name, "--alpha must lie between 0 and 1");
  return -1;
}

int em_millpost_options(struct em_millpost_options *o, const struct em_millpost_help *help,
                        int argc, char **argv) {
  const struct em_millpost_line line = {options, sizeof options / sizeof *options, AT(quiet)};
  *o = defaults();
  const int code = em_millpost_line_read(o, &line, help, argc, argv, &o->run_count, &o->run);
  return code >= 0 ? code : check(o, help);
}

enum em_status em_millpost_open(struct em_run_file **run, const char *path, struct em_error *err) {
  const enum em_status status = em_run_file_open(run, path, err);
  if (status != EM_FILE && status != EM_FORMAT) return status;
  err->code = EM_INPUT;
  return EM_INPUT;
}

int em_millpost_fail(const struct em_error *err) {
  const char *text = err->text[0] ? err->text : em_error_text(err->code);
  if (strncmp(text, "error: ", 7) == 0)
    fprintf(stderr, "millpost: %s\n", text);
  else
    fprintf(stderr, "%s\n", text);
  return err->code == EM_INPUT ? EM_MILLPOST_USAGE : EM_MILLPOST_FAILED;
}

int em_millpost_print(struct em_report *report, const struct em_millpost_options *o, int code) {
  struct em_error err = {.code = EM_OK};
  em_report_level(report, o->level);
  if (em_report_print(report, (enum em_report_format)o->format, stdout, &err) != EM_OK)
    code = em_millpost_fail(&err);
  em_report_free(report);
  return code;
}

void em_millpost_classes(unsigned classes, char *text, size_t size) {
  size_t used = 0;
  text[0] = '\0';
  for (int k = 0; k < EM_CLASS_COUNT && used < size; k++)
    if (classes & 1U << k)
      used += (size_t)snprintf(text + used, size - used, "%s%s", used > 0 ? ", " : "",
                               em_contact_class_name((enum em_class)k));
}

void em_millpost_label(const char *path, char *label, size_t size) {
  const char *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path;
  snprintf(label, size, "%s", name);
  char *dot = strrchr(label, '.');
  if (dot && dot != label && strcmp(dot, ".h5") == 0) *dot = '\0';
}
