/* A program of several commands. */
#include "tool/command.h"

#include <fcntl.h>
#include <gsl/gsl_errno.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "eventmill/provenance.h"

enum { DONE = 0, FAILED = 1, USAGE = 2 };

static void print_help(const struct em_command_program *program, FILE *out) {
  fprintf(out, "Usage: %s %s\n\n%s\n\nCommands:\n", program->name, program->usage, program->about);
  for (size_t k = 0; k < program->count; k++)
    fprintf(out, "  %-8s %s\n", program->command[k].name, program->command[k].summary);
  fprintf(out, "\n%s\n", program->details);
}

static void print_version(const struct em_command_program *program) {
  char libraries[256];
  em_provenance_libraries(libraries, sizeof libraries);
  printf("%s (Eventmill) %s\n%s\n%s\n", program->name, em_provenance_version(),
         em_provenance_compiler(), libraries);
}

static int dispatch(const struct em_command_program *program, int argc, char **argv) {
  for (size_t k = 0; k < program->count; k++)
    if (strcmp(argv[0], program->command[k].name) == 0) return program->command[k].run(argc, argv);
  fprintf(stderr, "%s: error: unknown command '%s', expected one of:", program->name, argv[0]);
  for (size_t k = 0; k < program->count; k++)
    fprintf(stderr, " %s", program->command[k].name);
  fprintf(stderr, "\nTry '%s --help'.\n", program->name);
  return USAGE;
}

/* What was printed must have arrived. */
static int finish(const struct em_command_program *program, int code) {
  if (code != DONE || (!fflush(stdout) && !ferror(stdout))) return code;
  fprintf(stderr, "%s: error: standard output cannot be written\n", program->name);
  return FAILED;
}

/* A standard stream that the parent closed: its number must not go to a file, which would then take
 * what is printed. Writing to it stays an error. */
static void hold_streams(void) {
  int number;
  do
    number = open("/dev/null", O_RDONLY);
  while (number >= 0 && number <= STDERR_FILENO);
  if (number > STDERR_FILENO) close(number);
}

int em_command_main(const struct em_command_program *program, int argc, char **argv) {
  hold_streams();
  gsl_set_error_handler_off(); /* statuses are checked where they are returned */
  signal(SIGXFSZ, SIG_IGN);    /* so that a limit is an error of writing, and tidied up after */
  signal(SIGCHLD, SIG_DFL);    /* ignored, as some parents leave it, it hides how programs end */
  if (argc < 2) {
    print_help(program, stderr);
    return USAGE;
  }
  int code = DONE;
  if (strcmp(argv[1], "--help") == 0 || strcmp(argv[1], "-h") == 0)
    print_help(program, stdout);
  else if (strcmp(argv[1], "--version") == 0)
    print_version(program);
  else
    code = dispatch(program, argc - 1, argv + 1);
  return finish(program, code);
}
