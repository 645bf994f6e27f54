/* The text of a scene with its includes in place, made safe for libconfig. */
#ifndef EVENTMILL_SCENE_SCENE_SOURCE_H
#define EVENTMILL_SCENE_SCENE_SOURCE_H

#include <libconfig.h>
#include <stdbool.h>
#include <stddef.h>

#include "eventmill/error.h"

/* From line `first` of the joined text on, lines come from `file`, beginning with its line `line`.
 */
struct em_scene_piece {
  int first, line;
  char *file; /* owned */
};

struct em_scene_source {
  const char *name; /* of the scene, borrowed */
  char *text;       /* owned, zero-terminated */
  size_t length, room;
  int lines; /* of the text so far, the unfinished one included */
  struct em_scene_piece *piece;
  size_t piece_count;
};

/* Joins `text` (of the file `name`) with what it includes: `@include "FILE"` at the beginning of a
 * line, relative to the file in which it stands. On the way square brackets become round ones (so
 * that [0, 0, -9.81] may mix integers and reals), and integers beyond 32 bits get the L that
 * libconfig needs to read them. Errors: EM_INPUT, EM_FILE, EM_MEMORY. */
enum em_status em_scene_source_join(struct em_scene_source *source, const char *text,
                                    const char *name, struct em_error *err);

/* The same, but the names of files in the text (`balls.table`, `balls.from`) become absolute, as
 * seen from the directory of `name`: the text means the same wherever it stands. */
enum em_status em_scene_source_join_whole(struct em_scene_source *source, const char *text,
                                          const char *name, struct em_error *err);

/* The content of a regular file without UTF-8's byte order mark, to be freed by the caller. Errors:
 * EM_FILE, EM_MEMORY, EM_INPUT (it holds a zero byte). */
enum em_status em_scene_source_load(char **text, const char *path, struct em_error *err);

/* `path` as seen from the directory of the file `base`, to be freed by the caller; NULL when memory
 * is short. */
char *em_scene_source_beside(const char *base, const char *path);
/* The same, but absolute: it means the same from any folder. */
char *em_scene_source_whole(const char *base, const char *path);

/* Reads joined text into a tree, as config_read_string does, but keeps this thread's locale, which
 * that function changes to the program's. */
bool em_scene_source_read(config_t *tree, const char *text);

/* The file and its line that a line of the joined text came from. */
const char *em_scene_source_place(const struct em_scene_source *source, int joined, int *line);

void em_scene_source_free(struct em_scene_source *source);

#endif
