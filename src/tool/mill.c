/* mill: checks and runs scenes. */
#include "tool/mill.h"

#include <gsl/gsl_errno.h>
#include <stdio.h>
#include <string.h>

struct command {
  const char *name, *summary;
  int (*run)(int argc, char **argv);
};

static const struct command commands[] = {
    {"run", "run a scene and write a run file", em_mill_run},
    {"check", "validate a scene; print it in full, with what it calls for", em_mill_check},
    {"cost", "measure what accuracy, effects and statistics cost on a scene", em_mill_cost},
};

enum { COMMANDS = sizeof commands / sizeof *commands };

static void print_help(FILE *out) {
  fprintf(out, "Usage: mill COMMAND SCENE [KEY=VALUE ...] [OPTION ...]\n\n"
               "Simulates ball mills as a sequence of collisions.\n\nCommands:\n");
  for (int k = 0; k < COMMANDS; k++)
    fprintf(out, "  %-8s %s\n", commands[k].name, commands[k].summary);
  fprintf(out,
          "\nKEY=VALUE overrides any entry of the scene: rotor.rpm=1700 balls.count=2000\n"
          "'mill COMMAND --help' tells more, with examples; 'mill --version' what this is.\n"
          "Exit codes: 0 done, 1 the run failed or was interrupted, 2 wrong usage or scene.\n");
}

static void print_version(void) {
  char libraries[256];
  em_provenance_libraries(libraries, sizeof libraries);
  printf("mill (Eventmill) %s\n%s\n%s\n", em_provenance_version(), em_provenance_compiler(),
         libraries);
}

static int dispatch(int argc, char **argv) {
  for (int k = 0; k < COMMANDS; k++)
    if (strcmp(argv[0], commands[k].name) == 0) return commands[k].run(argc, argv);
  fprintf(stderr, "mill: error: unknown command '%s', expected", argv[0]);
  for (int k = 0; k < COMMANDS; k++)
    fprintf(stderr, "%s %s", k ? " or" : "", commands[k].name);
  fprintf(stderr, "\n");
  return EM_MILL_USAGE;
}

/* What was printed must have arrived. */
static int finish(int code) {
  if (code != EM_MILL_DONE || (!fflush(stdout) && !ferror(stdout))) return code;
  fprintf(stderr, "mill: error: standard output cannot be written\n");
  return EM_MILL_FAILED;
}

int main(int argc, char **argv) {
  gsl_set_error_handler_off(); /* statuses are checked where they are returned */
  if (argc < 2) {
    print_help(stderr);
    return EM_MILL_USAGE;
  }
  if (strcmp(argv[1], "--help") == 0 || strcmp(argv[1], "-h") == 0) {
    print_help(stdout);
    return finish(EM_MILL_DONE);
  }
  if (strcmp(argv[1], "--version") == 0) {
    print_version();
    return finish(EM_MILL_DONE);
  }
  return finish(dispatch(argc - 1, argv + 1));
}
