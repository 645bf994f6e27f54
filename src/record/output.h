/* Files that appear complete or not at all: they are written under another name, FILE.PID.part, and
 * put in their place at the end. What is there and no regular file (a pipe, a terminal, a device)
 * is written to directly, and never replaced. */
#ifndef EM_RECORD_OUTPUT_H
#define EM_RECORD_OUTPUT_H

#include <stddef.h>
#include <stdio.h>

#include "eventmill/error.h"

enum em_output_kind {
  EM_OUTPUT_STREAM, /* is written from its begin to its end */
  EM_OUTPUT_FILE    /* otherwise: needs a regular file */
};

struct em_output {
  FILE *out;       /* write here, or to the file called `temporary` */
  char *path;      /* where the file belongs: what a link leads to; owned */
  char *temporary; /* owned; NULL: `out` is the place itself */
};

/* Opens an empty file. Nothing is left to be ended after an error. Errors: EM_INPUT (not a regular
 * file, but one is needed), EM_FILE, EM_MEMORY. */
enum em_status em_output_begin(struct em_output *output, const char *path, enum em_output_kind kind,
                               struct em_error *err);

/* Closes it and puts it in its place, or takes it away when `status`, that of the writing, is an
 * error. Returns the first error: `status` or EM_FILE. */
enum em_status em_output_end(struct em_output *output, enum em_status status, struct em_error *err);

/* The ending of a path with its dot, "" without one. */
const char *em_output_ending(const char *path);

/* "FOLDER/NAME.png" with the tag "2" becomes "FOLDER/NAME-2.png"; ending (NULL: that of the path)
 * replaces ".png". The text is cut to its size. */
void em_output_name(char *text, size_t size, const char *path, const char *tag, const char *ending);

/* The text with what XML reserves written as entities; freed by the caller. NULL: no memory. */
char *em_output_xml(const char *text);

#endif
