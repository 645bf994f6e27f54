/* Begins scripts in the house style and has gnuplot draw them; the picture comes to us through
 * gnuplot's standard output, so that no file name is ever part of a script that is run. */
#include "draw/gnuplot.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#include "draw/child.h"
#include "draw/letters.h"
#include "record/output.h"

static bool is_script(const char *path) {
  return strcmp(em_output_ending(path), ".gp") == 0;
}

static bool write_terminal(FILE *out, const char *path, int width, int height) {
  const char *end = em_output_ending(path);
  if (strcmp(end, ".svg") == 0)
    fprintf(out, "set terminal svg size %d,%d enhanced font 'DejaVu Sans,13' background 'white'\n",
            width, height);
  else if (strcmp(end, ".pdf") == 0)
    fprintf(out, "set terminal pdfcairo size %gin,%gin enhanced font 'DejaVu Sans,10'\n",
            width / 120.0, height / 120.0);
  else if (strcmp(end, ".png") == 0 || is_script(path))
    fprintf(out, "set terminal pngcairo size %d,%d enhanced font 'DejaVu Sans,13'\n", width,
            height);
  else
    return false;
  return true;
}

static void write_style(FILE *out) {
  fputs("set encoding utf8\n"
        "set border 3 lw 1 lc rgb '#5b606b'\n"
        "set tics nomirror out scale 0.6 textcolor rgb '#2b2f36'\n"
        "set format x '%h'\n" /* no room for a sign: numbers amid their tics */
        "set grid back lt 1 lw 0.8 lc rgb '#e4e7eb'\n"
        "set key top right samplen 2 spacing 1.25 font ',12' textcolor rgb '#2b2f36' noenhanced\n",
        out);
}

enum em_status em_gnuplot_begin(struct em_gnuplot *script, const char *path, int width, int height,
                                struct em_error *err) {
  script->out = open_memstream(&script->text, &script->size);
  if (script->out == NULL) return em_error_set(err, EM_MEMORY, path, 0, "no memory for a diagram");
  if (!write_terminal(script->out, path, width, height)) {
    fclose(script->out);
    free(script->text);
    return em_error_set(err, EM_INPUT, path, 0,
                        "the name of a diagram must end in .png, .svg, .pdf or .gp");
  }
  if (is_script(path)) {
    const char *slash = strrchr(path, '/'), *name = slash != NULL ? slash + 1 : path;
    char picture[512];
    snprintf(picture, sizeof picture, "%.*s.png", (int)(strlen(name) - 3), name);
    fputs("set output ", script->out);
    em_gnuplot_string(script, picture);
    fputc('\n', script->out);
  }
  write_style(script->out);
  return EM_OK;
}

void em_gnuplot_string(struct em_gnuplot *script, const char *text) {
  fputc('\'', script->out);
  for (const char *c = text != NULL ? text : ""; *c != '\0';) {
    const size_t length = em_letters_length(c);
    if (*c == '\'') fputc('\'', script->out);
    if (length == 0 || (unsigned char)*c < ' ')
      fputc(length == 0 ? '?' : ' ', script->out);
    else
      fwrite(c, 1, length, script->out);
    c += length > 0 ? length : 1;
  }
  fputc('\'', script->out);
}

/* A tic's label is a format: each % has to be two. */
static const char *without_format(const char *label, char *text, size_t size) {
  size_t n = 0;
  for (const char *c = label; *c != '\0' && n + 2 < size; c++) {
    if (*c == '%') text[n++] = '%';
    text[n++] = *c;
  }
  text[n] = '\0';
  return text;
}

void em_gnuplot_names(struct em_gnuplot *script, const char *axis, const char *const *name,
                      size_t count) {
  fprintf(script->out, "set %stics (", axis);
  for (size_t k = 0; k < count; k++) {
    char text[256];
    if (k > 0) fputs(", ", script->out);
    em_gnuplot_string(script, without_format(name[k], text, sizeof text));
    fprintf(script->out, " %zu", k);
  }
  fputs(") scale 0 noenhanced\n", script->out);
}

void em_gnuplot_title(struct em_gnuplot *script, const char *title, const char *subtitle) {
  const char *text[2] = {title, subtitle};
  static const char *const look[2] = {
      "at screen 0.035,0.955 left font ',17' textcolor rgb '#1c1f24' noenhanced front\n",
      "at screen 0.035,0.908 left font ',12' textcolor rgb '#6a707b' noenhanced front\n"};
  for (int k = 0; k < 2; k++) {
    if (text[k] == NULL) continue;
    fprintf(script->out, "set label %d ", 1000 + k);
    em_gnuplot_string(script, text[k]);
    fprintf(script->out, " %s", look[k]);
  }
}

/* Has gnuplot draw into the open file `picture`. */
static enum em_status run(const struct em_gnuplot *script, int picture, struct em_error *err) {
  static const char *const command[] = {"gnuplot", "-", NULL};
  struct em_child child;
  enum em_status status = em_child_start(&child, command, picture, err);
  if (status != EM_OK) return status;
  status = em_child_send(&child, script->text, script->size, err);
  if (status == EM_OK) status = em_child_finish(&child, err);
  if (status != EM_OK) em_child_abandon(&child);
  return status;
}

/* Copies a picture; errors of the output are seen when it ends. */
static bool copy(int picture, FILE *out) {
  char block[1 << 16];
  off_t at = 0;
  for (ssize_t got; (got = pread(picture, block, sizeof block, at)) > 0; at += got)
    fwrite(block, 1, (size_t)got, out);
  return at > 0;
}

/* Writes a picture, or where there is none the script itself. */
static enum em_status write_file(const struct em_gnuplot *script, int picture, const char *path,
                                 struct em_error *err) {
  struct em_output output;
  enum em_status status = em_output_begin(&output, path, EM_OUTPUT_STREAM, err);
  if (status != EM_OK) return status;
  if (picture < 0)
    fwrite(script->text, 1, script->size, output.out);
  else if (!copy(picture, output.out))
    status = em_error_set(err, EM_PICTURE, path, 0, "gnuplot drew nothing");
  return em_output_end(&output, status, err);
}

/* gnuplot does not tell whether it could write: it draws into memory, and we write. */
static enum em_status draw(const struct em_gnuplot *script, const char *path,
                           struct em_error *err) {
  const int picture = memfd_create("picture", MFD_CLOEXEC);
  if (picture < 0) return em_error_set(err, EM_MEMORY, path, 0, "no memory for a diagram");
  enum em_status status = run(script, picture, err);
  if (status == EM_OK) status = write_file(script, picture, path, err);
  close(picture);
  return status;
}

enum em_status em_gnuplot_end(struct em_gnuplot *script, const char *path, struct em_error *err) {
  enum em_status status = EM_OK;
  if (fclose(script->out) != 0)
    status = em_error_set(err, EM_MEMORY, path, 0, "no memory for a diagram");
  else
    status = is_script(path) ? write_file(script, -1, path, err) : draw(script, path, err);
  free(script->text);
  return status;
}
