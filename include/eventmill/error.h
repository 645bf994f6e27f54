/* Status codes and the error report that every fallible function fills.
 *
 * GSL, on which the library stands, ends the program where it fails, unless the program turns that
 * off: gsl_set_error_handler_off(), once at its start, and there are statuses instead. */
#ifndef EVENTMILL_ERROR_H
#define EVENTMILL_ERROR_H

#ifdef __cplusplus
extern "C" {
#endif

/* code, text: the one list from which the enum and the messages are made. */
#define EM_STATUS_LIST(X)           \
  X(OK, "done")                     \
  X(INPUT, "bad input")             \
  X(MEMORY, "out of memory")        \
  X(FILE, "file error")             \
  X(FORMAT, "not a valid run file") \
  X(NUMERIC, "numerical failure")   \
  X(COLLAPSE, "inelastic collapse") \
  X(JAM, "jam without exit")        \
  X(STOPPED, "stopped on request")  \
  X(PICTURE, "drawing failed")      \
  X(INTERNAL, "internal inconsistency")

#define EM_STATUS_ENUM(code, text) EM_##code,
enum em_status { EM_STATUS_LIST(EM_STATUS_ENUM) EM_STATUS_COUNT };
#undef EM_STATUS_ENUM

enum { EM_ERROR_TEXT = 4096, EM_ERROR_FILE = 1024 };

/* What went wrong. Several errors of one file are lines of `text`, each complete
 * ("FILE:LINE: error: what, and what was expected"). */
struct em_error {
  enum em_status code;
  int line; /* 0: not tied to a line */
  char file[EM_ERROR_FILE];
  char text[EM_ERROR_TEXT];
};

/* Fills err (may be NULL) and returns code, so that callers write `return em_error_set(...)`.
 * file may be NULL. The text is cut when it does not fit. */
enum em_status em_error_set(struct em_error *err, enum em_status code, const char *file, int line,
                            const char *format, ...) __attribute__((format(printf, 5, 6)));

/* Appends one more line "FILE:LINE: error: TEXT" to err (may be NULL), keeping the first code. */
enum em_status em_error_add(struct em_error *err, enum em_status code, const char *file, int line,
                            const char *format, ...) __attribute__((format(printf, 5, 6)));

#ifdef __clang_analyzer__
/* Static analysis, one file at a time, cannot see that both return their code. */
#define em_error_set(err, code, ...) (em_error_set(err, code, __VA_ARGS__), code)
#define em_error_add(err, code, ...) (em_error_add(err, code, __VA_ARGS__), code)
#endif

/* The text of a status code; never NULL. */
const char *em_error_text(enum em_status code);

#ifdef __cplusplus
}
#endif

#endif
