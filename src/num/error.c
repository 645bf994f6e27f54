/* Fills error reports: code, place and text, cut to their room. */
#include "eventmill/error.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "num/locale.h"

#undef em_error_set
#undef em_error_add

static const char *const status_text[EM_STATUS_COUNT] = {
#define TEXT(code, text) [EM_##code] = text,
    EM_STATUS_LIST(TEXT)
#undef TEXT
};

/* Appends to err->text what fits. */
static void append(struct em_error *err, const char *format, va_list args)
    __attribute__((format(printf, 2, 0)));

static void append(struct em_error *err, const char *format, va_list args) {
  EM_LOCALE_PLAIN;
  size_t used = strlen(err->text);
  vsnprintf(err->text + used, sizeof err->text - used, format, args);
}

static void appendf(struct em_error *err, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

static void appendf(struct em_error *err, const char *format, ...) {
  va_list args;
  va_start(args, format);
  append(err, format, args);
  va_end(args);
}

/* "FILE:LINE: error: TEXT"; without line or file these parts are left out. */
static void append_line(struct em_error *err, const char *file, int line, const char *format,
                        va_list args) {
  if (file && line > 0)
    appendf(err, "%s:%d: ", file, line);
  else if (file)
    appendf(err, "%s: ", file);
  appendf(err, "error: ");
  append(err, format, args);
}

static void place(struct em_error *err, enum em_status code, const char *file, int line) {
  err->code = code;
  err->line = line;
  snprintf(err->file, sizeof err->file, "%s", file ? file : "");
}

enum em_status em_error_set(struct em_error *err, enum em_status code, const char *file, int line,
                            const char *format, ...) {
  if (!err) return code;
  va_list args;
  va_start(args, format);
  err->text[0] = '\0';
  place(err, code, file, line);
  append_line(err, file, line, format, args);
  va_end(args);
  return code;
}

enum em_status em_error_add(struct em_error *err, enum em_status code, const char *file, int line,
                            const char *format, ...) {
  if (!err) return code;
  if (err->code == EM_OK) {
    err->text[0] = '\0';
    place(err, code, file, line);
  } else {
    appendf(err, "\n");
  }
  va_list args;
  va_start(args, format);
  append_line(err, file, line, format, args);
  va_end(args);
  return code;
}

const char *em_error_text(enum em_status code) {
  if ((unsigned)code >= EM_STATUS_COUNT) return "unknown status";
  return status_text[code];
}
