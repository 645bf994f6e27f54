/* A program of several commands: its help, its version, and which command is meant. */
#ifndef EVENTMILL_COMMAND_H
#define EVENTMILL_COMMAND_H

#include <stddef.h>

struct em_command {
  const char *name, *summary;
  int (*run)(int argc, char **argv); /* its own name is argv[0]; an exit code */
};

struct em_command_program {
  const char *name;
  const char *usage; /* what stands behind its name */
  const char *about, *details;
  size_t count;
  const struct em_command *command;
};

/* Does what the command line asks for. Returns the exit code: 0 done, 1 failed, or what was printed
 * has not arrived, 2 wrong usage, or the command's own. */
int em_command_main(const struct em_command_program *program, int argc, char **argv);

#endif
