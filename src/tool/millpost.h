/* The commands of millpost, and what they share: command lines, windows of time, messages. */
#ifndef EVENTMILL_MILLPOST_H
#define EVENTMILL_MILLPOST_H

#include <stdbool.h>
#include <stddef.h>

#include "eventmill/error.h"
#include "eventmill/run_file.h"
#include "tool/millpost_line.h"
#include "tool/report.h"

/* Exit codes. */
enum {
  EM_MILLPOST_DONE = 0,
  EM_MILLPOST_FAILED = 1,
  EM_MILLPOST_USAGE = 2,
  EM_MILLPOST_NOT_PASSED = 3
};

/* Each takes its own name as argv[0] and returns an exit code. */
int em_millpost_info(int argc, char **argv);
int em_millpost_hist(int argc, char **argv);
int em_millpost_verify(int argc, char **argv);
int em_millpost_map(int argc, char **argv);
int em_millpost_power(int argc, char **argv);
int em_millpost_steady(int argc, char **argv);
int em_millpost_compare(int argc, char **argv);
int em_millpost_scale(int argc, char **argv);
int em_millpost_table(int argc, char **argv);
int em_millpost_fit(int argc, char **argv);
int em_millpost_track(int argc, char **argv);
int em_millpost_frame(int argc, char **argv);
int em_millpost_film(int argc, char **argv);
int em_millpost_view(int argc, char **argv);
int em_millpost_export(int argc, char **argv);

/* What a command line says; options that were not given keep the values noted here. */
struct em_millpost_options {
  int run_count;
  char **run;                                      /* arguments that are no options */
  int format;                                      /* enum em_report_format: TEXT */
  const char *out;                                 /* NULL */
  const char *of;                                  /* NULL */
  const char *cells;                               /* NULL */
  const char *to_format;                           /* NULL: --to of export */
  const char *minus;                               /* NULL */
  const char *match;                               /* NULL */
  unsigned classes;                                /* bits 1 << enum em_class; 0: not given */
  double from, to;                                 /* s; NAN */
  double above;                                    /* NAN */
  double at;                                       /* s; NAN */
  double level;                                    /* 0.95 */
  double alpha;                                    /* 0.001 */
  double target;                                   /* NAN */
  long bins, slices, tubes, sectors, rings, every; /* 0 */
  bool cumulative, curve, log, relative, spread;   /* false */
  bool scene, anyway, quiet;                       /* false */
};

/* Reads a command line. Returns -1 to go on, or the exit code (help was printed, or a message). */
int em_millpost_options(struct em_millpost_options *options, const struct em_millpost_help *help,
                        int argc, char **argv);

/* Opens a run that the command line names: one that cannot be read is EM_INPUT. */
enum em_status em_millpost_open(struct em_run_file **run, const char *path, struct em_error *err);

/* Prints an error ("millpost: error: ..." or as the error says) and returns the exit code that
 * belongs to it. */
int em_millpost_fail(const struct em_error *err);
/* The same for a wrong command line. */
int em_millpost_usage(const char *command, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/* Prints the report in the format asked for, frees it, and returns the exit code. */
int em_millpost_print(struct em_report *report, const struct em_millpost_options *options,
                      int code);

/* The names of classes (bits 1 << enum em_class), with commas between; "" for none. */
enum { EM_MILLPOST_CLASSES = 64 }; /* room for all of them */
void em_millpost_classes(unsigned classes, char *text, size_t size);

/* The file's name without folder and ending, cut to size. */
void em_millpost_label(const char *path, char *label, size_t size);

#endif
