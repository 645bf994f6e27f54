/* What a command found: facts, tables with units, and notes; printed as aligned text, CSV or JSON.
 *
 * A report is built from top to bottom. Cells fill the columns of the current table from left to
 * right, row after row. Values that are NaN are printed as "-" (text), nothing (CSV), null (JSON).
 * Running out of memory ends the program. */
#ifndef EVENTMILL_REPORT_H
#define EVENTMILL_REPORT_H

#include <stdint.h>
#include <stdio.h>

#include "eventmill/error.h"
#include "eventmill/interval.h"

enum em_report_format { EM_REPORT_TEXT, EM_REPORT_CSV, EM_REPORT_JSON };

struct em_report;

struct em_report *em_report_new(const char *command);
void em_report_free(struct em_report *report);

/* The level of all intervals, which names their half widths; 0.95 when it is not set. */
void em_report_level(struct em_report *report, double level);
/* The key of the half width of `key`: "power_ci95". */
void em_report_half_key(char *text, size_t size, const char *key, double level);

/* A fact: key for JSON ("from_time"), label for people, unit "" for none. */
void em_report_fact(struct em_report *report, const char *key, const char *label, double value,
                    const char *unit);
void em_report_fact_count(struct em_report *report, const char *key, const char *label,
                          uint64_t value);
void em_report_fact_text(struct em_report *report, const char *key, const char *label,
                         const char *format, ...) __attribute__((format(printf, 4, 5)));
void em_report_fact_interval(struct em_report *report, const char *key, const char *label,
                             const struct em_interval *value, const char *unit);

/* Begins a table; title NULL: none is printed. */
void em_report_begin(struct em_report *report, const char *key, const char *title);
/* A column of the current table, before its first cell. */
void em_report_column(struct em_report *report, const char *key, const char *heading,
                      const char *unit);

void em_report_text(struct em_report *report, const char *format, ...)
    __attribute__((format(printf, 2, 3)));
void em_report_number(struct em_report *report, double value); /* 5 significant digits */
void em_report_percent(struct em_report *report,
                       double share); /* shown as 12.3 %; CSV, JSON: share */
void em_report_count(struct em_report *report, uint64_t value);
/* value ± half, shown to two digits of half. */
void em_report_interval(struct em_report *report, const struct em_interval *value);
void em_report_percent_interval(struct em_report *report, const struct em_interval *share);
void em_report_blank(struct em_report *report);

/* A line beneath all tables. */
void em_report_note(struct em_report *report, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/* Errors: EM_FILE. */
enum em_status em_report_print(const struct em_report *report, enum em_report_format format,
                               FILE *out, struct em_error *err);

#endif
