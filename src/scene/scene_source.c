/* Reads the text of a scene and of the files it includes, and smooths what libconfig 1.5 stumbles
 * over: it ends the program on an unreadable include, cuts integers to 32 bits without a word, and
 * refuses arrays that mix integers and reals. */
#include "scene/scene_source.h"

#include <ctype.h>
#include <errno.h>
#include <limits.h>
#include <locale.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { NESTING = 64, INCLUDES = 16 };

static bool is_word(char c) {
  return isalnum((unsigned char)c) || c == '_' || c == '*' || c == '-';
}

/* Where the copying of one file stands. */
struct cursor {
  struct em_scene_source *source;
  struct em_error *err;
  const char *file, *at, *word; /* word: the last one before `at`, or "" */
  const char *folder;           /* put before names of files that are not absolute, or NULL */
  int line, depth;
  int *nesting;  /* open brackets, shared by all files */
  char *bracket; /* what closes each of them */
};

static enum em_status no_memory(struct em_error *err) {
  return em_error_set(err, EM_MEMORY, NULL, 0, "no memory for the scene's text");
}

static enum em_status put(struct cursor *c, const char *text, size_t length) {
  struct em_scene_source *s = c->source;
  if (s->length + length + 1 > s->room) {
    size_t room = 2 * (s->length + length) + 1024;
    char *grown = realloc(s->text, room);
    if (!grown) return no_memory(c->err);
    s->text = grown;
    s->room = room;
  }
  for (size_t k = 0; k < length; ++k)
    s->lines += text[k] == '\n';
  memcpy(s->text + s->length, text, length);
  s->length += length;
  s->text[s->length] = '\0';
  return EM_OK;
}

/* Copies `length` characters of the file. */
static enum em_status pass(struct cursor *c, size_t length) {
  for (size_t k = 0; k < length; ++k)
    c->line += c->at[k] == '\n';
  enum em_status status = put(c, c->at, length);
  c->at += length;
  return status;
}

static enum em_status add_piece(struct cursor *c) {
  struct em_scene_source *s = c->source;
  struct em_scene_piece *grown = realloc(s->piece, (s->piece_count + 1) * sizeof *grown);
  if (!grown) return no_memory(c->err);
  s->piece = grown;
  struct em_scene_piece *piece = &s->piece[s->piece_count];
  *piece = (struct em_scene_piece){s->lines, c->line, strdup(c->file)};
  if (!piece->file) return no_memory(c->err);
  s->piece_count++;
  return EM_OK;
}

static bool begins_comment(const char *at) {
  return at[0] == '#' || (at[0] == '/' && (at[1] == '/' || at[1] == '*'));
}

/* Copies a comment, one of a line without its end. */
static enum em_status pass_comment(struct cursor *c) {
  if (c->at[0] == '#' || c->at[1] == '/') return pass(c, strcspn(c->at, "\n"));
  const char *end = strstr(c->at + 2, "*/");
  if (!end)
    return em_error_set(c->err, EM_INPUT, c->file, c->line,
                        "the comment that begins here has no end, expected */");
  return pass(c, (size_t)(end - c->at) + 2);
}

/* Is the value that follows the name of a file? */
static bool names_file(const struct cursor *c) {
  static const char *const entries[] = {"table", "from"};
  for (size_t k = 0; k < sizeof entries / sizeof *entries; ++k) {
    size_t n = strlen(entries[k]);
    if (strncmp(c->word, entries[k], n) == 0 && !is_word(c->word[n])) return true;
  }
  return false;
}

/* Copies the quote that opens the name of a file, and the folder from which it is seen. */
static enum em_status pass_folder(struct cursor *c) {
  enum em_status status = pass(c, 1);
  const char *at = *c->at == '/' ? "" : c->folder;
  for (; status == EM_OK && *at; ++at) {
    if (*at == '"' || *at == '\\') status = put(c, "\\", 1);
    if (status == EM_OK) status = put(c, at, 1);
  }
  return status;
}

/* Copies a string with its quotes. */
static enum em_status pass_string(struct cursor *c) {
  size_t k = 1;
  while (c->at[k] && c->at[k] != '"')
    k += c->at[k] == '\\' && c->at[k + 1] ? 2 : 1;
  if (!c->at[k])
    return em_error_set(c->err, EM_INPUT, c->file, c->line,
                        "the string that begins here has no end, expected \"");
  enum em_status status = EM_OK;
  if (c->folder && names_file(c)) {
    status = pass_folder(c);
    --k;
  }
  c->word = "";
  return status == EM_OK ? pass(c, k + 1) : status;
}

/* Copies a number; one that is a plain integer beyond 32 bits gets an L, beyond 64 bits it becomes
 * a real. */
static enum em_status pass_number(struct cursor *c) {
  const char *at = c->at;
  bool hex = at[0] == '0' && (at[1] == 'x' || at[1] == 'X');
  size_t n = hex ? 2 + strspn(at + 2, "0123456789abcdefABCDEF") : strspn(at, "0123456789");
  bool whole = at[n] != '.' && !isalpha((unsigned char)at[n]);
  errno = 0;
  unsigned long long value = strtoull(at, NULL, hex ? 16 : 10);
  bool wide = value > INT_MAX, wider = !hex && (value > LLONG_MAX || errno == ERANGE);
  if (!whole) {
    n += strspn(at + n, "0123456789.");
    if (at[n] == 'e' || at[n] == 'E') n += 1u + (size_t)(at[n + 1] == '+' || at[n + 1] == '-');
    while (isalnum((unsigned char)at[n]) || at[n] == '.')
      ++n;
  }
  enum em_status status = pass(c, n);
  if (status != EM_OK || !whole || !wide) return status;
  return wider ? put(c, ".0", 2) : put(c, "L", 1);
}

/* Copies a bracket; square ones become round where they match. */
static enum em_status pass_bracket(struct cursor *c) {
  char b = *c->at;
  if (strchr("[({", b)) {
    if (*c->nesting == NESTING)
      return em_error_set(c->err, EM_INPUT, c->file, c->line,
                          "nested too deeply, expected at most %d brackets", NESTING);
    c->bracket[(*c->nesting)++] = (char)(b == '[' ? ']' : b == '(' ? ')' : '}');
  } else {
    if (*c->nesting == 0)
      return em_error_set(c->err, EM_INPUT, c->file, c->line, "\"%c\" closes nothing", b);
    if (c->bracket[*c->nesting - 1] != b)
      return em_error_set(c->err, EM_INPUT, c->file, c->line, "found \"%c\", expected \"%c\"", b,
                          c->bracket[*c->nesting - 1]);
    --*c->nesting;
  }
  c->at++;
  const char *round = b == '[' ? "(" : b == ']' ? ")" : &b;
  return put(c, round, 1);
}

static enum em_status copy_file(struct cursor *c);

static bool begins_line(const struct cursor *c, const char *start) {
  const char *at = c->at;
  while (at > start && (at[-1] == ' ' || at[-1] == '\t'))
    --at;
  return at == start || at[-1] == '\n';
}

/* Copies the included file in place of its directive. */
static enum em_status include(struct cursor *c, const char *start) {
  size_t word_length = strlen("@include");
  bool good = strncmp(c->at, "@include", word_length) == 0 && begins_line(c, start);
  const char *name = good ? c->at + word_length + strspn(c->at + word_length, " \t") : "";
  size_t n = *name == '"' ? strcspn(name + 1, "\"\n") : 0;
  if (n == 0 || name[n + 1] != '"')
    return em_error_set(c->err, EM_INPUT, c->file, c->line,
                        "\"@\", expected @include \"FILE\" at the beginning of a line");
  if (c->depth == INCLUDES)
    return em_error_set(c->err, EM_INPUT, c->file, c->line,
                        "@include: nested too deeply, expected at most %d files", INCLUDES);
  char *word = strndup(name + 1, n);
  char *path = word ? em_scene_source_beside(c->file, word) : NULL;
  char *text = NULL;
  free(word);
  struct em_error inner = {0};
  enum em_status status = path ? em_scene_source_load(&text, path, &inner) : no_memory(c->err);
  if (path && status != EM_OK)
    em_error_set(c->err, status, c->file, c->line, "@include \"%.200s\": %.200s", path,
                 inner.text + strspn(inner.text, " "));
  if (status == EM_OK) {
    struct cursor inside = *c;
    inside.file = path;
    inside.at = text;
    inside.word = "";
    inside.line = 1;
    inside.depth++;
    status = copy_file(&inside);
  }
  free(path);
  free(text);
  if (status != EM_OK) return status;
  c->at = name + n + 2;
  return add_piece(c);
}

static enum em_status copy_file(struct cursor *c) {
  const char *start = c->at;
  enum em_status status = add_piece(c);
  while (status == EM_OK && *c->at) {
    if (begins_comment(c->at))
      status = pass_comment(c);
    else if (*c->at == '"')
      status = pass_string(c);
    else if (strchr("[](){}", *c->at))
      status = pass_bracket(c);
    else if (*c->at == '@')
      status = include(c, start);
    else if (isdigit((unsigned char)*c->at))
      status = pass_number(c);
    else if (isalpha((unsigned char)*c->at) || *c->at == '*' || *c->at == '.') {
      size_t n = 1;
      while (is_word(c->at[n]) || (*c->at == '.' && isdigit((unsigned char)c->at[n])))
        ++n;
      c->word = c->at;
      status = pass(c, n);
    } else
      status = pass(c, 1);
  }
  return status;
}

static enum em_status join(struct em_scene_source *source, const char *text, const char *name,
                           const char *folder, struct em_error *err) {
  *source = (struct em_scene_source){.name = name, .lines = 1};
  int nesting = 0;
  char bracket[NESTING];
  struct cursor c = {source, err, name, text, "", folder, 1, 0, &nesting, bracket};
  enum em_status status = put(&c, "", 0);
  if (status == EM_OK) status = copy_file(&c);
  if (status != EM_OK) em_scene_source_free(source);
  return status;
}

enum em_status em_scene_source_join(struct em_scene_source *source, const char *text,
                                    const char *name, struct em_error *err) {
  return join(source, text, name, NULL, err);
}

enum em_status em_scene_source_join_whole(struct em_scene_source *source, const char *text,
                                          const char *name, struct em_error *err) {
  char *folder = em_scene_source_whole(name, "");
  if (!folder) return no_memory(err);
  enum em_status status = join(source, text, name, folder, err);
  free(folder);
  return status;
}

/* Reads an open file to its end. */
static enum em_status slurp(char **text, FILE *file, const char *path, struct em_error *err) {
  size_t length = 0, room = 0;
  char *all = NULL;
  for (;;) {
    if (room - length < 4096) {
      char *grown = realloc(all, room = 2 * room + 8192);
      if (!grown) {
        free(all);
        return no_memory(err);
      }
      all = grown;
    }
    size_t n = fread(all + length, 1, room - length - 1, file);
    length += n;
    if (n == 0) break;
  }
  all[length] = '\0';
  enum em_status status = EM_OK;
  if (ferror(file))
    status = em_error_set(err, EM_FILE, path, 0, "cannot be read: %s", strerror(errno));
  else if (strlen(all) != length)
    status = em_error_set(err, EM_INPUT, path, 0, "holds a zero byte, expected text");
  static const char mark[] = "\xEF\xBB\xBF"; /* of UTF-8, as some editors put it */
  if (status == EM_OK && strncmp(all, mark, strlen(mark)) == 0)
    memmove(all, all + strlen(mark), length - strlen(mark) + 1);
  if (status == EM_OK)
    *text = all;
  else
    free(all);
  return status;
}

enum em_status em_scene_source_load(char **text, const char *path, struct em_error *err) {
  struct stat st;
  if (stat(path, &st) != 0)
    return em_error_set(err, EM_FILE, path, 0, "cannot be opened: %s", strerror(errno));
  if (!S_ISREG(st.st_mode) && !S_ISFIFO(st.st_mode))
    return em_error_set(err, EM_FILE, path, 0, "is a %s, expected a file",
                        S_ISDIR(st.st_mode) ? "directory" : "device");
  FILE *file = fopen(path, "rb");
  if (!file) return em_error_set(err, EM_FILE, path, 0, "cannot be opened: %s", strerror(errno));
  enum em_status status = slurp(text, file, path, err);
  fclose(file);
  return status;
}

char *em_scene_source_beside(const char *base, const char *path) {
  const char *slash = strrchr(base, '/');
  if (path[0] == '/' || !slash) return strdup(path);
  size_t n = (size_t)(slash - base) + 1;
  char *joined = malloc(n + strlen(path) + 1);
  if (joined) {
    memcpy(joined, base, n);
    strcpy(joined + n, path);
  }
  return joined;
}

char *em_scene_source_whole(const char *base, const char *path) {
  char *beside = em_scene_source_beside(base, path), *whole = NULL;
  if (!beside || beside[0] == '/') return beside;
  char *here = getcwd(NULL, 0);
  if (here && asprintf(&whole, "%s/%s", here, beside) < 0) whole = NULL;
  free(here);
  free(beside);
  return whole;
}

const char *em_scene_source_place(const struct em_scene_source *source, int joined, int *line) {
  const char *file = source->name;
  *line = joined;
  for (size_t k = 0; k < source->piece_count && source->piece[k].first <= joined; ++k) {
    file = source->piece[k].file;
    *line = source->piece[k].line + (joined - source->piece[k].first);
  }
  return file;
}

bool em_scene_source_read(config_t *tree, const char *text) {
  const locale_t before = uselocale((locale_t)0);
  const bool good = config_read_string(tree, text) == CONFIG_TRUE;
  uselocale(before);
  return good;
}

void em_scene_source_free(struct em_scene_source *source) {
  free(source->text);
  for (size_t k = 0; k < source->piece_count; ++k)
    free(source->piece[k].file);
  free(source->piece);
  *source = (struct em_scene_source){0};
}
