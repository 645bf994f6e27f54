/* Scripts for gnuplot: what diagrams and maps share. */
#ifndef EM_DRAW_GNUPLOT_H
#define EM_DRAW_GNUPLOT_H

#include <stddef.h>
#include <stdio.h>

#include "eventmill/error.h"

/* A script that is being written. */
struct em_gnuplot {
  FILE *out; /* write here */
  char *text;
  size_t size;
};

/* Checks the path's ending and begins a script with the house style. Errors: EM_INPUT (unknown
 * ending), EM_MEMORY. */
enum em_status em_gnuplot_begin(struct em_gnuplot *script, const char *path, int width, int height,
                                struct em_error *err);

/* Where a diagram below a title ends, in shares of the picture's height. */
#define EM_GNUPLOT_TOP 0.865

/* Writes a text as a gnuplot string: taken literally, on one line, '?' for what is no letter. NULL
 * is empty. */
void em_gnuplot_string(struct em_gnuplot *script, const char *text);

/* Names instead of numbers at 0, 1, … of an axis ("x", "y"). */
void em_gnuplot_names(struct em_gnuplot *script, const char *axis, const char *const *name,
                      size_t count);

/* Title and subtitle above the diagram. */
void em_gnuplot_title(struct em_gnuplot *script, const char *title, const char *subtitle);

/* Runs the script, or writes it down for a path that ends in .gp; frees it in any case. Errors:
 * EM_FILE, EM_MEMORY, EM_PICTURE. */
enum em_status em_gnuplot_end(struct em_gnuplot *script, const char *path, struct em_error *err);

#endif
