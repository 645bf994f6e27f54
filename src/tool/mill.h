/* The commands of mill, and what they share: exit codes, command lines, messages. */
#ifndef EVENTMILL_MILL_H
#define EVENTMILL_MILL_H

#include <signal.h>
#include <stdbool.h>
#include <stddef.h>

#include "eventmill/error.h"
#include "eventmill/provenance.h"
#include "eventmill/recorder.h"
#include "eventmill/scene.h"

/* Exit codes. */
enum { EM_MILL_DONE = 0, EM_MILL_FAILED = 1, EM_MILL_USAGE = 2 };

/* Each takes its own name as argv[0] and returns an exit code. */
int em_mill_run(int argc, char **argv);
int em_mill_check(int argc, char **argv);
int em_mill_cost(int argc, char **argv);

/* What a command line says. */
struct em_mill_options {
  const char *scene;
  size_t override_count;
  const char **overrides; /* owned; "KEY=VALUE" */
  const char *out;        /* -o, or NULL */
  const char *precision;  /* --until-precision, or NULL */
  bool resume, force, quiet, json, joined;
};

/* Options without a letter. */
enum { EM_MILL_RESUME = 256, EM_MILL_FORCE, EM_MILL_PRECISION, EM_MILL_JOINED };

/* Which options a command takes, and what its --help says. */
struct em_mill_help {
  const char *name;
  const int *takes; /* beside -h: letters and options without one; 0 ends the list */
  const char *text;
};

/* Reads a command line "SCENE [KEY=VALUE ...] [options]". Returns -1 to go on, or the exit code
 * (help was printed, or a message). The caller frees options->overrides. */
int em_mill_options(struct em_mill_options *options, const struct em_mill_help *help, int argc,
                    char **argv);

/* What is left of the command line: SCENE [KEY=VALUE ...]. Returns -1, or the exit code. */
int em_mill_words(struct em_mill_options *options, const struct em_mill_help *help, int count,
                  char **words);

/* Prints "what 'word'" (word may be NULL) and where to find help. Returns the exit code. */
int em_mill_usage(const struct em_mill_help *help, const char *what, const char *word);

/* Says that getopt's `letter` is no option here: '?', or one of `letters` that this command does
 * not take. `name`: its long form if that was used, else NULL; `word`: the last one that getopt
 * took. Returns the exit code. */
int em_mill_unknown(const struct em_mill_help *help, const char *letters, int letter,
                    const char *name, const char *word);

/* Reads the scene; also turns its blades, when its balls start from a run, to where they stood
 * then. Print errors. Return -1, or the exit code. */
int em_mill_read(struct em_scene **scene, const struct em_mill_options *options);
int em_mill_scene(struct em_scene **scene, const struct em_mill_options *options);

/* From now on SIGTERM and SIGHUP (a closed terminal; not under nohup), however often, and the first
 * SIGINT ask for an end by what this points to. A second SIGINT ends the program at once: it comes
 * from people, the others from programs, which repeat them and have SIGKILL. */
const volatile sig_atomic_t *em_mill_signals(void);

/* Prints the error's text to stderr. */
void em_mill_complain(const struct em_error *err);

/* What --until-precision asks for, and what the run found. */
struct em_mill_precision {
  size_t count;
  struct em_precision_target target[EM_PRECISION_TARGETS];
  struct em_precision_found found[EM_PRECISION_TARGETS];
};

/* The summary of a run, for people and as one JSON object (NAN: null). */
void em_mill_report_text(const struct em_summary *summary, const struct em_scene *scene);
void em_mill_report_json(const struct em_summary *summary, const struct em_scene *scene,
                         const struct em_mill_precision *precision);

#endif
