/* A program that reads what we send it: gnuplot, ffmpeg. */
#ifndef EM_DRAW_CHILD_H
#define EM_DRAW_CHILD_H

#include <stddef.h>
#include <sys/types.h>

#include "eventmill/error.h"

struct em_child {
  pid_t pid;
  int input;  /* what is sent here is the program's standard input */
  int report; /* what it says on standard error */
  const char *name;
};

/* Starts argv[0], found by PATH. Its standard output goes to `output` (a descriptor; -1: nowhere).
 * Errors: EM_PICTURE (cannot be started). */
enum em_status em_child_start(struct em_child *child, const char *const *argv, int output,
                              struct em_error *err);

/* Sends size bytes. No signal is raised when the program has gone: EM_PICTURE. */
enum em_status em_child_send(struct em_child *child, const void *data, size_t size,
                             struct em_error *err);

/* Ends the input, waits for the program, and tells what it said when it failed (EM_PICTURE). */
enum em_status em_child_finish(struct em_child *child, struct em_error *err);

/* The same for a program whose work is no longer wanted. */
void em_child_abandon(struct em_child *child);

#endif
