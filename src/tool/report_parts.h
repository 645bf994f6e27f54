/* What a report consists of: between those who build it and those who print it. */
#ifndef EVENTMILL_REPORT_PARTS_H
#define EVENTMILL_REPORT_PARTS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

enum em_report_kind {
  EM_REPORT_TEXT_CELL,
  EM_REPORT_NUMBER,
  EM_REPORT_PERCENT,
  EM_REPORT_COUNT,
  EM_REPORT_BLANK
};

struct em_report_cell {
  enum em_report_kind kind;
  bool has_half;
  double value, half;
  uint64_t count;
  char *text;
};

struct em_report_column {
  char *key, *heading, *unit;
  bool has_half;
};

struct em_report_part {
  char *key, *title;
  size_t columns, cells;
  struct em_report_column *column;
  struct em_report_cell *cell;
};

struct em_report_fact {
  char *key, *label, *unit;
  struct em_report_cell cell;
};

struct em_report {
  char *command;
  double level; /* of all intervals */
  size_t facts, parts, notes;
  struct em_report_fact *fact;
  struct em_report_part *part;
  char **note;
};

static inline void *em_report_checked(void *p) {
  if (p) return p;
  fputs("error: out of memory\n", stderr);
  exit(1);
}

#endif
