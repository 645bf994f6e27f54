/* Command lines of millpost: a table of options, of which each command takes some or all; help and
 * messages are made from it. --help, -h, --quiet and -q are always there; -o and -j are short for
 * --output and --json. */
#ifndef EVENTMILL_MILLPOST_LINE_H
#define EVENTMILL_MILLPOST_LINE_H

#include <stdbool.h>
#include <stddef.h>

/* What an option's text becomes in the command's struct. */
enum em_millpost_target {
  EM_MILLPOST_TEXT,     /* const char * */
  EM_MILLPOST_FLAG,     /* bool: true */
  EM_MILLPOST_CHOICE,   /* int: the entry's value; without argument; all commands take it */
  EM_MILLPOST_NUMBER,   /* double */
  EM_MILLPOST_POSITIVE, /* double above 0 */
  EM_MILLPOST_WHOLE,    /* long, 1 to 1e9 */
  EM_MILLPOST_OTHER     /* what `read` makes of it */
};

struct em_millpost_option {
  const char *key;      /* by which commands name it */
  const char *argument; /* NULL: none */
  const char *help;     /* NULL: the option is not listed */
  enum em_millpost_target target;
  size_t offset;    /* in the command's struct */
  const char *name; /* on command lines, where that is not its key; NULL */
  int value;
  /* -1, or an exit code after a message. name: of the option. */
  int (*read)(void *place, const char *command, const char *name, const char *text);
};

/* An entry without exceptions. */
#define EM_MILLPOST_OPTION(type, key, argument, help, target, field) \
  { key, argument, help, EM_MILLPOST_##target, offsetof(type, field), NULL, 0, NULL }

/* The names of a list of kinds, as a part of a text: "one of:" EM_CAMERA_LIST(EM_MILLPOST_WORD). */
#define EM_MILLPOST_WORD(code, name) " " name

struct em_millpost_help {
  const char *name, *arguments, *summary, *details, *examples;
  const char *const *options; /* keys of the options it takes, "" ends the list; NULL: all */
  int least, most;            /* number of arguments; most < 0: any */
};

struct em_millpost_line {
  const struct em_millpost_option *option;
  size_t count;
  size_t quiet; /* offset of a bool in the command's struct */
};

/* Reads a command line into `wish`; arguments that are no options become word[0 … words-1]. Returns
 * -1 to go on, or the exit code (help was printed, or a message). */
int em_millpost_line_read(void *wish, const struct em_millpost_line *line,
                          const struct em_millpost_help *help, int argc, char **argv, int *words,
                          char ***word);

/* Reads a number that ends at `end`; rest (or NULL): where. */
bool em_millpost_line_number(const char *text, char end, double *value, const char **rest);

/* Reads LOW:HIGH into two doubles, as `read` of an option. */
int em_millpost_line_range(void *place, const char *command, const char *option, const char *text);

#endif
