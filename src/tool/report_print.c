/* Reports printed as aligned text, CSV or JSON. */
#include <assert.h>
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "draw/letters.h"
#include "tool/report.h"
#include "tool/report_parts.h"

/* ---------------------------------------------------------------- text */

/* Columns of a terminal that a UTF-8 text takes (all our characters are one wide). */
static int width_of(const char *text) {
  int width = 0;
  for (; *text; text++)
    width += ((unsigned char)*text & 0xC0) != 0x80;
  return width;
}

static void pad(FILE *out, int count) {
  for (int k = 0; k < count; k++)
    fputc(' ', out);
}

/* value ± half with two digits of half, both with the same number of decimals; "(3.7 ± 3.1)e-06"
 * for what is small or large. */
static void show_interval(char *text, size_t size, double value, double half) {
  const double most = fmax(fabs(value), half);
  if (!(half > 0.0) || half < 1e-9 * most) {
    snprintf(text, size, "%.4g ± %.2g", value, half);
    return;
  }
  const bool plain = most >= 1e-3 && most < 1e9;
  const int power = plain ? 0 : (int)floor(log10(most)),
            place = (int)floor(log10(half)) - 1 - power;
  const double scale = pow(10.0, -power), unit = pow(10.0, place);
  const int decimals = place < 0 ? -place : 0;
  value *= scale;
  half *= scale;
  if (place > 0) {
    value = round(value / unit) * unit;
    half = round(half / unit) * unit;
  }
  if (plain)
    snprintf(text, size, "%.*f ± %.*f", decimals, value, decimals, half);
  else
    snprintf(text, size, "(%.*f ± %.*f)e%+03d", decimals, value, decimals, half, power);
}

static void show(char *text, size_t size, const struct em_report_cell *cell) {
  const double scale = cell->kind == EM_REPORT_PERCENT ? 100.0 : 1.0;
  const char *end = cell->kind == EM_REPORT_PERCENT ? " %" : "";
  char number[96] = "-";
  switch (cell->kind) {
  case EM_REPORT_TEXT_CELL:
    snprintf(text, size, "%s", cell->text);
    return;
  case EM_REPORT_COUNT:
    snprintf(text, size, "%llu", (unsigned long long)cell->count);
    return;
  case EM_REPORT_BLANK:
    snprintf(text, size, "-");
    return;
  case EM_REPORT_NUMBER:
  case EM_REPORT_PERCENT:
    break;
  }
  if (isnan(cell->value)) {
    snprintf(text, size, "-");
    return;
  }
  if (cell->has_half && isfinite(cell->half))
    show_interval(number, sizeof number, scale * cell->value, scale * cell->half);
  else
    snprintf(number, sizeof number, cell->kind == EM_REPORT_PERCENT ? "%.4g" : "%.5g",
             scale * cell->value);
  snprintf(text, size, "%s%s", number, end);
}

static bool is_left(const struct em_report_part *part, size_t column) {
  for (size_t k = column; k < part->cells; k += part->columns)
    if (part->cell[k].kind == EM_REPORT_TEXT_CELL) return true;
  return false;
}

static void aligned(FILE *out, const char *text, int width, bool left, bool last) {
  if (!left) pad(out, width - width_of(text));
  fputs(text, out);
  if (left && !last) pad(out, width - width_of(text));
  fputs(last ? "\n" : "  ", out);
}

static void print_part_text(const struct em_report_part *part, FILE *out) {
  if (part->columns == 0) return;
  if (part->title) fprintf(out, "%s\n", part->title);
  int *width = em_report_checked(calloc(part->columns, sizeof *width));
  char text[512];
  for (size_t k = 0; k < part->columns; k++) {
    const int heading = width_of(part->column[k].heading), unit = width_of(part->column[k].unit);
    width[k] = heading > unit ? heading : unit;
  }
  for (size_t k = 0; k < part->cells; k++) {
    show(text, sizeof text, &part->cell[k]);
    const int w = width_of(text), c = (int)(k % part->columns);
    if (w > width[c]) width[c] = w;
  }
  bool units = false;
  for (size_t k = 0; k < part->columns; k++)
    units = units || *part->column[k].unit;
  for (int line = 0; line < (units ? 2 : 1); line++)
    for (size_t k = 0; k < part->columns; k++)
      aligned(out, line ? part->column[k].unit : part->column[k].heading, width[k],
              is_left(part, k), k + 1 == part->columns);
  for (size_t k = 0; k < part->cells; k++) {
    const size_t c = k % part->columns;
    show(text, sizeof text, &part->cell[k]);
    aligned(out, text, width[c], is_left(part, c), c + 1 == part->columns);
  }
  free(width);
}

static void print_text(const struct em_report *report, FILE *out) {
  int width = 0;
  char text[4096];
  for (size_t k = 0; k < report->facts; k++) {
    const int w = width_of(report->fact[k].label);
    if (w > width) width = w;
  }
  for (size_t k = 0; k < report->facts; k++) {
    const struct em_report_fact *fact = &report->fact[k];
    show(text, sizeof text, &fact->cell);
    fputs(fact->label, out);
    pad(out, width - width_of(fact->label));
    fprintf(out, "  %s%s%s\n", text, *fact->unit ? " " : "", fact->unit);
  }
  for (size_t k = 0; k < report->parts; k++) {
    if (k > 0 || report->facts > 0) fputc('\n', out);
    print_part_text(&report->part[k], out);
  }
  if (report->notes > 0 && (report->parts > 0 || report->facts > 0)) fputc('\n', out);
  for (size_t k = 0; k < report->notes; k++)
    fprintf(out, "%s\n", report->note[k]);
}

/* ---------------------------------------------------------------- CSV */

static void csv_text(const char *text, FILE *out) {
  if (!strpbrk(text, ",\"\n\r")) {
    fputs(text, out);
    return;
  }
  fputc('"', out);
  for (; *text; text++) {
    if (*text == '"') fputc('"', out);
    fputc(*text, out);
  }
  fputc('"', out);
}

/* Whole numbers, seeds among them, to all digits. */
static void csv_number(double value, FILE *out) {
  const bool whole = fabs(value) < 0x1p53 && value == rint(value);
  if (isfinite(value)) fprintf(out, whole ? "%.0f" : "%.9g", value);
}

static void csv_cell(const struct em_report_cell *cell, bool has_half, FILE *out) {
  if (cell->kind == EM_REPORT_TEXT_CELL) csv_text(cell->text, out);
  if (cell->kind == EM_REPORT_COUNT) fprintf(out, "%llu", (unsigned long long)cell->count);
  if (cell->kind == EM_REPORT_NUMBER || cell->kind == EM_REPORT_PERCENT)
    csv_number(cell->value, out);
  if (!has_half) return;
  fputc(',', out);
  if (cell->has_half) csv_number(cell->half, out);
}

static void print_part_csv(const struct em_report_part *part, double level, FILE *out) {
  for (size_t k = 0; k < part->columns; k++) {
    const struct em_report_column *column = &part->column[k];
    char key[128], text[256];
    const char *open = *column->unit ? " [" : "", *close = *column->unit ? "]" : "";
    snprintf(text, sizeof text, "%s%s%s%s", column->key, open, column->unit, close);
    if (k > 0) fputc(',', out);
    csv_text(text, out);
    if (!column->has_half) continue;
    em_report_half_key(key, sizeof key, column->key, level);
    snprintf(text, sizeof text, "%s%s%s%s", key, open, column->unit, close);
    fputc(',', out);
    csv_text(text, out);
  }
  if (part->columns > 0) fputc('\n', out);
  assert(part->columns > 0 || part->cells == 0);
  for (size_t k = 0; k < part->cells; k++) {
    const size_t c = k % part->columns;
    if (c > 0) fputc(',', out);
    csv_cell(&part->cell[k], part->column[c].has_half, out);
    if (c + 1 == part->columns) fputc('\n', out);
  }
}

static void print_csv(const struct em_report *report, FILE *out) {
  for (size_t k = 0; k < report->facts; k++) {
    const struct em_report_fact *fact = &report->fact[k];
    fprintf(out, "# %s = ", fact->key);
    if (fact->cell.kind == EM_REPORT_TEXT_CELL)
      fputs(fact->cell.text, out);
    else
      csv_cell(&fact->cell, false, out);
    fprintf(out, "%s%s\n", *fact->unit ? " " : "", fact->unit);
    if (!fact->cell.has_half) continue;
    char key[128];
    em_report_half_key(key, sizeof key, fact->key, report->level);
    fprintf(out, "# %s = ", key);
    csv_number(fact->cell.half, out);
    fprintf(out, "%s%s\n", *fact->unit ? " " : "", fact->unit);
  }
  for (size_t k = 0; k < report->parts; k++) {
    if (k > 0) fputc('\n', out);
    if (report->parts > 1) fprintf(out, "# %s\n", report->part[k].key);
    print_part_csv(&report->part[k], report->level, out);
  }
  for (size_t k = 0; k < report->notes; k++)
    fprintf(out, "# %s\n", report->note[k]);
}

/* ---------------------------------------------------------------- JSON */

/* Names of files need not be UTF-8; JSON has to be. */
static void json_text(const char *text, FILE *out) {
  fputc('"', out);
  for (size_t size; *text; text += size > 0 ? size : 1) {
    const unsigned char c = (unsigned char)*text;
    size = em_letters_length(text);
    if (size == 0)
      fputs("\\ufffd", out);
    else if (c == '"' || c == '\\')
      fprintf(out, "\\%c", c);
    else if (c == '\n')
      fputs("\\n", out);
    else if (c < 0x20)
      fprintf(out, "\\u%04x", c);
    else
      fwrite(text, 1, size, out);
  }
  fputc('"', out);
}

static void json_number(double value, FILE *out) {
  if (isfinite(value))
    fprintf(out, "%.17g", value);
  else
    fputs("null", out);
}

static void json_entry(const char *key, const struct em_report_cell *cell, double level,
                       FILE *out) {
  json_text(key, out);
  fputs(": ", out);
  switch (cell->kind) {
  case EM_REPORT_TEXT_CELL:
    json_text(cell->text, out);
    break;
  case EM_REPORT_COUNT:
    fprintf(out, "%llu", (unsigned long long)cell->count);
    break;
  case EM_REPORT_BLANK:
    fputs("null", out);
    break;
  case EM_REPORT_NUMBER:
  case EM_REPORT_PERCENT:
    json_number(cell->value, out);
    break;
  }
  if (!cell->has_half) return;
  fputs(", ", out);
  char text[256];
  em_report_half_key(text, sizeof text, key, level);
  json_text(text, out);
  fputs(": ", out);
  json_number(cell->half, out);
}

static void print_part_json(const struct em_report_part *part, double level, FILE *out) {
  fputs(",\n  ", out);
  json_text(part->key, out);
  fputs(": [", out);
  for (size_t k = 0; k < part->cells; k++) {
    const size_t c = k % part->columns;
    if (c == 0) fputs(k > 0 ? ",\n    {" : "\n    {", out);
    if (c > 0) fputs(", ", out);
    json_entry(part->column[c].key, &part->cell[k], level, out);
    if (c + 1 == part->columns) fputc('}', out);
  }
  fputs("\n  ]", out);
}

static void print_json(const struct em_report *report, FILE *out) {
  fputs("{\n  \"command\": ", out);
  json_text(report->command, out);
  for (size_t k = 0; k < report->facts; k++) {
    fputs(",\n  ", out);
    json_entry(report->fact[k].key, &report->fact[k].cell, report->level, out);
  }
  for (size_t k = 0; k < report->parts; k++)
    print_part_json(&report->part[k], report->level, out);
  fputs(",\n  \"units\": {", out);
  const char *between = "";
  for (size_t k = 0; k < report->facts; k++) {
    if (!*report->fact[k].unit) continue;
    fputs(between, out);
    json_text(report->fact[k].key, out);
    fputs(": ", out);
    json_text(report->fact[k].unit, out);
    between = ", ";
  }
  for (size_t p = 0; p < report->parts; p++)
    for (size_t k = 0; k < report->part[p].columns; k++) {
      const struct em_report_column *column = &report->part[p].column[k];
      if (!*column->unit) continue;
      char text[256];
      snprintf(text, sizeof text, "%s.%s", report->part[p].key, column->key);
      fputs(between, out);
      json_text(text, out);
      fputs(": ", out);
      json_text(column->unit, out);
      between = ", ";
    }
  fputs("},\n  \"notes\": [", out);
  for (size_t k = 0; k < report->notes; k++) {
    if (k > 0) fputs(", ", out);
    json_text(report->note[k], out);
  }
  fputs("]\n}\n", out);
}

enum em_status em_report_print(const struct em_report *report, enum em_report_format format,
                               FILE *out, struct em_error *err) {
  if (format == EM_REPORT_TEXT) print_text(report, out);
  if (format == EM_REPORT_CSV) print_csv(report, out);
  if (format == EM_REPORT_JSON) print_json(report, out);
  if (fflush(out) == 0 && !ferror(out)) return EM_OK;
  return em_error_set(err, EM_FILE, NULL, 0, "cannot write the output: %s", strerror(errno));
}
