/* Reports of facts, tables and notes: how they are built. */
#include "tool/report.h"

#include <assert.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "tool/report_parts.h"

static char *copy(const char *text) {
  return em_report_checked(strdup(text));
}

/* Room for one more element; grows by doubling. */
static void *more(void *array, size_t count, size_t size) {
  if (count & (count - 1)) return array;
  return em_report_checked(realloc(array, (count ? 2 * count : 1) * size));
}

static char *formatted(const char *format, va_list args) __attribute__((format(printf, 1, 0)));

static char *formatted(const char *format, va_list args) {
  char *text = NULL;
  if (vasprintf(&text, format, args) < 0) text = NULL;
  return em_report_checked(text);
}

struct em_report *em_report_new(const char *command) {
  struct em_report *report = em_report_checked(calloc(1, sizeof *report));
  report->command = copy(command);
  report->level = 0.95;
  return report;
}

void em_report_level(struct em_report *report, double level) {
  report->level = level;
}

void em_report_half_key(char *text, size_t size, const char *key, double level) {
  snprintf(text, size, "%s_ci%g", key, 100.0 * level);
}

static void free_part(struct em_report_part *part) {
  for (size_t k = 0; k < part->columns; k++) {
    free(part->column[k].key);
    free(part->column[k].heading);
    free(part->column[k].unit);
  }
  for (size_t k = 0; k < part->cells; k++)
    free(part->cell[k].text);
  free(part->column);
  free(part->cell);
  free(part->key);
  free(part->title);
}

void em_report_free(struct em_report *report) {
  if (!report) return;
  for (size_t k = 0; k < report->facts; k++) {
    free(report->fact[k].key);
    free(report->fact[k].label);
    free(report->fact[k].unit);
    free(report->fact[k].cell.text);
  }
  for (size_t k = 0; k < report->parts; k++)
    free_part(&report->part[k]);
  for (size_t k = 0; k < report->notes; k++)
    free(report->note[k]);
  free(report->fact);
  free(report->part);
  free(report->note);
  free(report->command);
  free(report);
}

/* ---------------------------------------------------------------- building */

static void add_fact(struct em_report *report, const char *key, const char *label, const char *unit,
                     struct em_report_cell cell) {
  report->fact = more(report->fact, report->facts, sizeof *report->fact);
  report->fact[report->facts++] = (struct em_report_fact){copy(key), copy(label), copy(unit), cell};
}

void em_report_fact(struct em_report *report, const char *key, const char *label, double value,
                    const char *unit) {
  add_fact(report, key, label, unit,
           (struct em_report_cell){.kind = EM_REPORT_NUMBER, .value = value});
}

void em_report_fact_count(struct em_report *report, const char *key, const char *label,
                          uint64_t value) {
  add_fact(report, key, label, "",
           (struct em_report_cell){.kind = EM_REPORT_COUNT, .count = value});
}

void em_report_fact_interval(struct em_report *report, const char *key, const char *label,
                             const struct em_interval *value, const char *unit) {
  add_fact(
      report, key, label, unit,
      (struct em_report_cell){
          .kind = EM_REPORT_NUMBER, .value = value->value, .half = value->half, .has_half = true});
}

void em_report_fact_text(struct em_report *report, const char *key, const char *label,
                         const char *format, ...) {
  va_list args;
  va_start(args, format);
  add_fact(report, key, label, "",
           (struct em_report_cell){.kind = EM_REPORT_TEXT_CELL, .text = formatted(format, args)});
  va_end(args);
}

void em_report_begin(struct em_report *report, const char *key, const char *title) {
  report->part = more(report->part, report->parts, sizeof *report->part);
  struct em_report_part *part = &report->part[report->parts++];
  *part = (struct em_report_part){.key = copy(key), .title = title ? copy(title) : NULL};
}

static struct em_report_part *current(struct em_report *report) {
  if (report->parts == 0) em_report_begin(report, "table", NULL);
  return &report->part[report->parts - 1];
}

void em_report_column(struct em_report *report, const char *key, const char *heading,
                      const char *unit) {
  struct em_report_part *part = current(report);
  part->column = more(part->column, part->columns, sizeof *part->column);
  part->column[part->columns++] =
      (struct em_report_column){copy(key), copy(heading), copy(unit), false};
}

static void add_cell(struct em_report *report, struct em_report_cell cell) {
  struct em_report_part *part = current(report);
  assert(part->columns > 0);
  if (cell.has_half) part->column[part->cells % part->columns].has_half = true;
  part->cell = more(part->cell, part->cells, sizeof *part->cell);
  part->cell[part->cells++] = cell;
}

void em_report_text(struct em_report *report, const char *format, ...) {
  va_list args;
  va_start(args, format);
  add_cell(report,
           (struct em_report_cell){.kind = EM_REPORT_TEXT_CELL, .text = formatted(format, args)});
  va_end(args);
}

void em_report_number(struct em_report *report, double value) {
  add_cell(report, (struct em_report_cell){.kind = EM_REPORT_NUMBER, .value = value});
}

void em_report_percent(struct em_report *report, double share) {
  add_cell(report, (struct em_report_cell){.kind = EM_REPORT_PERCENT, .value = share});
}

void em_report_count(struct em_report *report, uint64_t value) {
  add_cell(report, (struct em_report_cell){.kind = EM_REPORT_COUNT, .count = value});
}

void em_report_interval(struct em_report *report, const struct em_interval *value) {
  add_cell(report, (struct em_report_cell){.kind = EM_REPORT_NUMBER,
                                           .value = value->value,
                                           .half = value->half,
                                           .has_half = true});
}

void em_report_percent_interval(struct em_report *report, const struct em_interval *share) {
  add_cell(report, (struct em_report_cell){.kind = EM_REPORT_PERCENT,
                                           .value = share->value,
                                           .half = share->half,
                                           .has_half = true});
}

void em_report_blank(struct em_report *report) {
  add_cell(report, (struct em_report_cell){.kind = EM_REPORT_BLANK});
}

void em_report_note(struct em_report *report, const char *format, ...) {
  va_list args;
  va_start(args, format);
  report->note = more(report->note, report->notes, sizeof *report->note);
  report->note[report->notes++] = formatted(format, args);
  va_end(args);
}
