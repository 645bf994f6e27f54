/* Diagrams: they are drawn, whatever their texts say, and bad ones are refused. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "draw_mill.h"
#include "eventmill/plot.h"

static const double edge[] = {0, 1, 2, 3, 4}, height[] = {1, 4, 2, 0.5}, error[] = {1, 1, 1, 1};
static const double gap[] = {1, NAN, 2, 3};

/* Width and height of a PNG file; 0 × 0 when it is none. */
static void png_size(const char *path, unsigned *width, unsigned *height_of) {
  unsigned char head[24] = {0};
  FILE *file = fopen(path, "rb");
  *width = *height_of = 0;
  if (file == NULL) return;
  const size_t got = fread(head, 1, sizeof head, file);
  fclose(file);
  if (got != sizeof head || memcmp(head, "\x89PNG\r\n\x1a\n", 8) != 0) return;
  *width = (unsigned)head[16] << 24 | (unsigned)head[17] << 16 | (unsigned)head[18] << 8 | head[19];
  *height_of =
      (unsigned)head[20] << 24 | (unsigned)head[21] << 16 | (unsigned)head[22] << 8 | head[23];
}

static void all_styles_are_drawn(void **state) {
  const struct em_plot_series all[] = {
      {.name = "line", .style = EM_PLOT_LINE, .count = 4, .x = edge, .y = gap},
      {.name = "dashed", .style = EM_PLOT_DASHED, .count = 4, .x = edge, .y = height},
      {.name = "points", .style = EM_PLOT_POINTS, .count = 4, .x = edge, .y = height},
      {.style = EM_PLOT_POINTS, .count = 4, .x = edge, .y = height, .error = error},
      {.name = "band", .style = EM_PLOT_BAND, .count = 4, .x = edge, .y = gap, .error = error},
      {.name = "steps", .style = EM_PLOT_STEPS, .count = 4, .x = edge, .y = gap},
      {.style = EM_PLOT_LINE, .count = 4, .x = edge, .y = height, .second_axis = true},
  };
  const struct em_plot_mark mark[] = {{.at = 2.0, .name = "here"}, {.at = 1.0, .horizontal = true}};
  struct em_plot plot = {.title = "all", .series = all, .mark = mark, .mark_count = 2};
  struct em_error err = {0};
  unsigned w, h;
  (void)state;
  for (size_t k = 1; k <= sizeof all / sizeof *all; k++)
    for (int log = 0; log < 2; log++) {
      const char *path = draw_path("all.png");
      plot.series_count = k;
      plot.log_y = log;
      assert_int_equal(em_plot_draw(&plot, path, &err), EM_OK);
      png_size(path, &w, &h);
      assert_int_equal(w, 1200);
      assert_int_equal(h, 750);
      unlink(path);
    }
}

static bool is_written(const struct em_plot *plot, const char *text);

/* A text that would break out of its string would make gnuplot write this file. */
static void texts_are_taken_literally(void **state) {
  char evil[512];
  const struct em_plot_series s = {.name = "it's \"a\" {/*9 trap} \\n",
                                   .style = EM_PLOT_LINE,
                                   .count = 4,
                                   .x = edge,
                                   .y = height};
  struct em_error err = {0};
  unsigned w, h;
  (void)state;
  const char *trap = draw_path("trap");
  snprintf(evil, sizeof evil,
           "x'; system('touch %s'); set title 'y\nsystem('touch %s')\n`touch %s`", trap, trap,
           trap);
  const struct em_plot plot = {.title = evil,
                               .subtitle = evil,
                               .x_label = evil,
                               .y_label = evil,
                               .series_count = 1,
                               .series = &s,
                               .width = 400,
                               .height = 300};
  const char *path = draw_path("it's a file.png");
  assert_int_equal(em_plot_draw(&plot, path, &err), EM_OK);
  png_size(path, &w, &h);
  assert_int_equal(w, 400);
  assert_int_equal(h, 300);
  assert_int_not_equal(access(trap, F_OK), 0);
}

/* gnuplot takes what is no UTF-8 for something else, and draws nothing or too much. */
static void texts_in_another_coding_are_drawn(void **state) {
  static const struct {
    const char *given, *drawn;
  } text[] = {{"M\xfchle", "'M?hle'"},
              {"Mühle · ½ … €", "'Mühle · ½ … €'"},
              {"cut \xe2\x80", "'cut ?\?'"},
              {"\xc0\xaf\xed\xa0\x80\xf4\x90\x80\x80", "'?\?\?\?\?\?\?\?\?'"},
              {"\xf0\x9f\x98\x80\xff", "'\xf0\x9f\x98\x80?'"}};
  const struct em_plot_series s = {.style = EM_PLOT_LINE, .count = 4, .x = edge, .y = height};
  struct em_error err = {0};
  (void)state;
  for (size_t k = 0; k < sizeof text / sizeof *text; k++) {
    const struct em_plot plot = {.title = text[k].given, .series_count = 1, .series = &s};
    assert_true(is_written(&plot, text[k].drawn));
    assert_int_equal(em_plot_draw(&plot, draw_path("coding.png"), &err), EM_OK);
  }
}

static void scripts_can_be_run(void **state) {
  const struct em_plot_series s = {.style = EM_PLOT_STEPS, .count = 4, .x = edge, .y = height};
  const struct em_plot plot = {.series_count = 1, .series = &s, .width = 500, .height = 200};
  struct em_error err = {0};
  char command[512];
  unsigned w, h;
  (void)state;
  const char *path = draw_path("script.gp");
  assert_int_equal(em_plot_draw(&plot, path, &err), EM_OK);
  snprintf(command, sizeof command, "cd '%.*s' && gnuplot script.gp",
           (int)(strlen(path) - strlen("/script.gp")), path);
  assert_int_equal(system(command), 0);
  png_size(draw_path("script.png"), &w, &h);
  assert_int_equal(w, 500);
  assert_int_equal(h, 200);
  assert_int_equal(em_plot_draw(&plot, draw_path("s.svg"), &err), EM_OK);
  assert_int_equal(em_plot_draw(&plot, draw_path("s.pdf"), &err), EM_OK);
}

/* Finds the label in a script, "set label 'TEXT' at screen X, screen Y left", from *from on. */
static bool next_label(const char **from, const char *text, double *x, double *y, char *side) {
  char start[64];
  snprintf(start, sizeof start, "set label '%s' at screen ", text);
  *from = strstr(*from, start);
  if (*from == NULL) return false;
  *from += strlen(start);
  return sscanf(*from, "%lf, screen %lf %c", x, y, side) == 3;
}

static char *read_script(const char *path) {
  char *text = calloc(1, 1 << 16);
  FILE *file = fopen(path, "r");
  assert_non_null(file);
  assert_true(fread(text, 1, (1 << 16) - 1, file) > 0);
  fclose(file);
  return text;
}

/* Many points in one place: their words lie beside one another, none on a point, all inside. */
static void words_do_not_overlap(void **state) {
  enum { N = 14, LETTERS = 12 };
  double x[N], y[N], at[N][2], width = 6.2 * LETTERS / 1200.0, line = 15.0 / 750.0;
  const char *text[N];
  struct em_error err = {0};
  (void)state;
  for (int k = 0; k < N; k++) {
    x[k] = 1.0 + 0.01 * (k % 5);
    y[k] = pow(10.0, -5.0 - 0.05 * (k % 3));
    text[k] = "twelve chars";
  }
  const struct em_plot_series s = {
      .style = EM_PLOT_POINTS, .count = N, .x = x, .y = y, .text = text};
  const struct em_plot plot = {.log_x = true,
                               .log_y = true,
                               .x_low = 0.8,
                               .x_high = 100.0,
                               .y_low = 1e-20,
                               .y_high = 1.0,
                               .series_count = 1,
                               .series = &s};
  const char *path = draw_path("words.gp");
  assert_int_equal(em_plot_draw(&plot, path, &err), EM_OK);
  char *script = read_script(path), side;
  const char *from = script;
  for (int k = 0; k < N; k++) {
    assert_true(next_label(&from, text[0], &at[k][0], &at[k][1], &side));
    if (side == 'r') at[k][0] -= width;
    assert_true(at[k][0] > 0.08 && at[k][0] + width < 0.98 && at[k][1] > 0.1 && at[k][1] < 0.87);
    for (int j = 0; j < k; j++)
      assert_true(fabs(at[k][0] - at[j][0]) > width || fabs(at[k][1] - at[j][1]) > line);
  }
  free(script);
}

/* Does a script of this diagram have this text in it? */
static bool is_written(const struct em_plot *plot, const char *text) {
  struct em_error err = {0};
  assert_int_equal(em_plot_draw(plot, draw_path("is.gp"), &err), EM_OK);
  char *script = read_script(draw_path("is.gp"));
  const bool found = strstr(script, text) != NULL;
  free(script);
  return found;
}

/* The legend goes to a free corner, else beside the diagram, or below it where it is wide. */
static void the_legend_lies_on_no_curve(void **state) {
  const double x[] = {0.0, 1.0, 2.0, 3.0}, rises[] = {0.0, 1.0, 2.0, 3.0};
  const double low[] = {0.0, 0.1, 0.0, 3.0}, all[] = {0.0, 3.0, 0.0, 3.0};
  struct em_plot_series s[2] = {
      {.name = "one", .style = EM_PLOT_LINE, .count = 4, .x = x, .y = low}};
  struct em_plot plot = {.series_count = 1, .series = s};
  struct em_error err = {0};
  (void)state;
  assert_true(is_written(&plot, "set key top left"));
  s[0].y = rises;
  assert_true(is_written(&plot, "set key top left"));
  s[1] = (struct em_plot_series){.style = EM_PLOT_POINTS, .count = 4, .x = x, .y = all};
  const double down[] = {3.0, 2.0, 1.0, 0.0};
  s[1].y = down;
  plot.series_count = 2;
  assert_true(is_written(&plot, "set key outside right top"));
  s[0].name = "a name that is as long as that of a mill with its balls, its drum and its speed";
  assert_true(is_written(&plot, "set key at screen"));
  /* However many, one below the other. */
  struct em_plot_series many[32];
  for (int k = 0; k < 32; k++)
    many[k] = (struct em_plot_series){
        .name = s[0].name, .style = EM_PLOT_LINE, .count = 4, .x = x, .y = k % 2 ? all : down};
  plot.series = many;
  for (plot.series_count = 2; plot.series_count <= 32; plot.series_count += 10) {
    double margin, top, font;
    assert_int_equal(em_plot_draw(&plot, draw_path("many.gp"), &err), EM_OK);
    char *script = read_script(draw_path("many.gp"));
    const char *below = strstr(script, "set bmargin at screen ");
    assert_non_null(below);
    assert_int_equal(sscanf(below,
                            "set bmargin at screen %lf\nset key at screen 0.07, screen %lf left "
                            "top Left reverse horizontal maxcols 1 font ',%lf'",
                            &margin, &top, &font),
                     3);
    assert_true(top < margin && margin <= 0.61);
    assert_true(font * (double)plot.series_count * 1.95 <= 750.0 * top);
    free(script);
  }
}

/* Nor on the bars of errors, of which one end is cut off at 0. */
static void the_legend_lies_on_no_error(void **state) {
  const double x[] = {0.0, 1.0, 2.0, 3.0}, y[] = {1, 1, 1, 1}, half[] = {0.2, 0.2, 0.2, 5.0};
  const struct em_plot_series s = {
      .name = "one", .style = EM_PLOT_POINTS, .count = 4, .x = x, .y = y, .error = half};
  const struct em_plot plot = {.series_count = 1, .series = &s};
  (void)state;
  assert_true(is_written(&plot, "set key top left"));
  assert_true(is_written(&plot, "set yrange [0<*:6<*]"));
}

/* The name of a line moves to its other end when a curve crosses it; error bars below 0 do not take
 * the axis there. */
static void names_of_lines_are_free(void **state) {
  const double x[] = {0.0, 1.0, 2.0, 10.0}, y[] = {0.5, 1.5, 3.0, 3.0}, half[] = {0.6, 0, 0, 0};
  const struct em_plot_series s = {
      .style = EM_PLOT_BAND, .count = 4, .x = x, .y = y, .error = half};
  struct em_plot_mark mark = {.at = 1.0, .horizontal = true, .name = "a limit"};
  const struct em_plot plot = {.series_count = 1, .series = &s, .mark_count = 1, .mark = &mark};
  (void)state;
  assert_true(is_written(&plot, "'a limit' at graph 0.98, first 1 right"));
  mark.at = 0.2;
  assert_true(is_written(&plot, "'a limit' at graph 0.02, first 0.2 left") ||
              is_written(&plot, "'a limit' at graph 0.98, first 0.2 right"));
  assert_true(is_written(&plot, "set yrange [0<*:3<*]"));
  const double wide[] = {0.6, 9.0, 0, 0}; /* an end that is cut off hides the other to gnuplot */
  struct em_plot_series points = s;
  points.error = wide;
  points.style = EM_PLOT_POINTS;
  const struct em_plot cut = {.series_count = 1, .series = &points};
  assert_true(is_written(&cut, "set yrange [0<*:10.5<*]"));
}

/* More curves than colours have dashes; more than can be told apart are refused. */
static void many_curves_can_be_told_apart(void **state) {
  struct em_plot_series s[33];
  struct em_error err = {0};
  (void)state;
  for (int k = 0; k < 33; k++)
    s[k] = (struct em_plot_series){.style = EM_PLOT_LINE, .count = 4, .x = edge, .y = height};
  struct em_plot plot = {.series_count = 8, .series = s};
  assert_false(is_written(&plot, " dt ("));
  plot.series_count = 9;
  assert_true(is_written(&plot, " dt ("));
  plot.series_count = 32;
  assert_int_equal(em_plot_draw(&plot, draw_path("32.gp"), &err), EM_OK);
  plot.series_count = 33;
  assert_int_equal(em_plot_draw(&plot, draw_path("33.gp"), &err), EM_INPUT);
}

/* A logarithmic colour bar has three numbers or more, however narrow it is, and is pointed where
 * values go beyond it. */
static void colour_bars_can_be_read(void **state) {
  static const double width[] = {1.0, 1.3, 3.0, 9.0, 70.0, 900.0, 1e5};
  struct em_error err = {0};
  (void)state;
  for (int k = 0; k < 7; k++) {
    const struct em_plot_cell cell[] = {{{0, 0}, {1, 1}, 0.37}, {{1, 0}, {2, 1}, 0.37 * width[k]}};
    struct em_plot_map map = {.cell_count = 2, .cell = cell, .log_value = true};
    assert_int_equal(em_plot_map(&map, draw_path("bar.gp"), &err), EM_OK);
    char *script = read_script(draw_path("bar.gp"));
    const char *tics = strstr(script, "set cbtics (");
    int numbers = 0;
    for (const char *c = tics; c != NULL && *c != ')'; c++)
      numbers += *c == ',';
    assert_true(width[k] > 1000.0 ? tics == NULL : numbers >= 2);
    assert_null(strstr(script, "polygon"));
    free(script);
    if (k != 3) continue;
    map.low = 0.5;
    map.high = 1.0;
    assert_int_equal(em_plot_map(&map, draw_path("bar.gp"), &err), EM_OK);
    script = read_script(draw_path("bar.gp"));
    assert_non_null(strstr(script, "set object 1 polygon"));
    assert_non_null(strstr(script, "set object 2 polygon"));
    free(script);
    assert_int_equal(em_plot_map(&map, draw_path("bar.png"), &err), EM_OK);
  }
}

/* Values that differ by rounding are alike: ticks at steps that a double cannot make have no end,
 * and gnuplot draws no such range. */
static void rounding_is_no_range(void **state) {
  static const double size[] = {1e-300, 1.0, 1e300};
  struct em_error err = {0};
  (void)state;
  for (int k = 0; k < 6; k++) {
    const double low = size[k / 2];
    const struct em_plot_cell cell[] = {{{0, 0}, {1, 1}, low},
                                        {{1, 0}, {2, 1}, nextafter(low, INFINITY)}};
    const struct em_plot_map map = {.cell_count = 2, .cell = cell, .log_value = k % 2};
    assert_int_equal(em_plot_map(&map, draw_path("alike.png"), &err), EM_OK);
  }
  const double x[] = {1.0, 2.0}, y[] = {1.0, 1.0};
  const struct em_plot_series s = {.style = EM_PLOT_LINE, .count = 2, .x = x, .y = y};
  const struct em_plot plot = {
      .log_y = true, .y_low = 1.0, .y_high = nextafter(1.0, 2.0), .series_count = 1, .series = &s};
  assert_true(is_written(&plot, "set ytics ("));
}

/* gnuplot does not tell that a disk is full. */
static void a_full_disk_is_told(void **state) {
  const struct em_plot_series s = {.style = EM_PLOT_LINE, .count = 4, .x = edge, .y = height};
  const struct em_plot plot = {.series_count = 1, .series = &s};
  struct em_error err = {0};
  (void)state;
  const char *path = draw_path("full.png");
  assert_int_equal(symlink("/dev/full", path), 0);
  assert_int_equal(em_plot_draw(&plot, path, &err), EM_FILE);
  unlink(path);
}

/* One bar ten times as long as the others leaves them readable: by an axis of logarithms, and by
 * their values. */
static void bars_are_readable(void **state) {
  static const char *const names[] = {"short", "it's 100 % long", "none", "less"};
  double value[] = {1.05, 7.2, NAN, 0.9}, low[] = {1.0, 7.0, 1.0, 0.9},
         high[] = {1.1, 7.5, 1.0, 0.95};
  struct em_plot_bars bars = {.title = "bars",
                              .x_label = "time",
                              .base = 1.0,
                              .count = 4,
                              .name = names,
                              .value = value,
                              .low = low,
                              .high = high,
                              .range_name = "range"};
  struct em_error err = {0};
  unsigned w, h;
  (void)state;
  assert_int_equal(em_plot_bars(&bars, draw_path("bars.png"), &err), EM_OK);
  png_size(draw_path("bars.png"), &w, &h);
  assert_int_equal(w, 1200);
  for (int even = 0; even < 2; even++) {
    if (even) value[1] = low[1] = high[1] = 1.1;
    assert_int_equal(em_plot_bars(&bars, draw_path("bars.gp"), &err), EM_OK);
    char *script = read_script(draw_path("bars.gp"));
    assert_true((strstr(script, "set logscale x") == NULL) == (even == 1));
    assert_non_null(strstr(script, "set label '1.05' at first 1.1"));
    assert_non_null(strstr(script, even ? "set label '1.10'" : "set label '7.20'"));
    assert_null(strstr(script, "nan"));
    assert_non_null(strstr(script, "'it''s 100 %% long' 1"));
    free(script);
  }
  value[0] = low[0] = high[0] = 0.00123;
  assert_int_equal(em_plot_bars(&bars, draw_path("bars.gp"), &err), EM_OK);
  char *small = read_script(draw_path("bars.gp"));
  assert_non_null(strstr(small, "set label '0.00123'"));
  free(small);
  bars.count = 0;
  assert_int_equal(em_plot_bars(&bars, draw_path("none.png"), &err), EM_INPUT);
}

static void maps_are_drawn(void **state) {
  struct em_plot_cell cell[12];
  struct em_error err = {0};
  unsigned w, h;
  (void)state;
  for (int k = 0; k < 12; k++)
    cell[k] = (struct em_plot_cell){{0.01 * (k / 6), M_PI / 3 * (k % 6)},
                                    {0.01 * (k / 6 + 1), M_PI / 3 * (k % 6 + 1)},
                                    k == 3 ? NAN : k - 2.0};
  for (int kind = 0; kind < 8; kind++) {
    const struct em_plot_map map = {.title = "map",
                                    .value_label = "v  [m/s]",
                                    .cell_count = 12,
                                    .cell = cell,
                                    .polar = kind & 1,
                                    .log_value = kind & 2,
                                    .diverging = kind & 4 && !(kind & 2)};
    const char *path = draw_path("map.png");
    assert_int_equal(em_plot_map(&map, path, &err), EM_OK);
    png_size(path, &w, &h);
    assert_int_equal(w, 1000);
    assert_int_equal(h, 900);
    unlink(path);
  }
}

static void bad_diagrams_are_refused(void **state) {
  const double none[] = {NAN, NAN, NAN, NAN};
  const struct em_plot_series s = {.style = EM_PLOT_LINE, .count = 4, .x = edge, .y = height};
  const struct em_plot_series empty = {.style = EM_PLOT_LINE, .count = 4, .x = edge, .y = none};
  const struct em_plot good = {.series_count = 1, .series = &s};
  const struct em_plot bad = {.series_count = 1, .series = &empty};
  const struct em_plot_map blank = {.cell_count = 0};
  struct em_error err = {0};
  char *old = strdup(getenv("PATH"));
  (void)state;
  assert_int_equal(em_plot_draw(&bad, draw_path("x.png"), &err), EM_INPUT);
  assert_int_equal(em_plot_map(&blank, draw_path("x.png"), &err), EM_INPUT);
  assert_int_equal(em_plot_draw(&good, draw_path("x.jpg"), &err), EM_INPUT);
  assert_int_equal(em_plot_draw(&good, draw_path("x"), &err), EM_INPUT);
  assert_int_equal(em_plot_draw(&good, "/nowhere/x.png", &err), EM_FILE);
  setenv("PATH", "/nowhere", 1);
  assert_int_equal(em_plot_draw(&good, draw_path("x.png"), &err), EM_PICTURE);
  setenv("PATH", old, 1);
  assert_int_not_equal(access(draw_path("x.png"), F_OK), 0);
  assert_int_not_equal(access(draw_path("x.png.part"), F_OK), 0);
  free(old);
}

static void the_subtitle_tells_the_operating_point(void **state) {
  char text[256], cut[8];
  (void)state;
  struct em_scene *scene = draw_scene(DRAW_MILL, 0, NULL);
  em_plot_subtitle(scene, text, sizeof text);
  assert_string_equal(text, "small mill · 2000 rpm · 150 balls of 4 mm");
  em_plot_subtitle(scene, cut, sizeof cut);
  assert_string_equal(cut, "small m");
  em_plot_operating_point(scene, text, sizeof text);
  assert_string_equal(text, "2000 rpm · 150 balls of 4 mm");
  em_scene_free(scene);
  /* Of several scenes: what they share once, the rest side by side. */
  static const char *const fast[] = {"rotor.rpm=3000"};
  struct em_scene *const two[] = {draw_scene(DRAW_MILL, 0, NULL), draw_scene(DRAW_MILL, 1, fast)};
  const struct em_scene *const both[] = {two[0], two[1], two[0]};
  em_plot_subtitles(both, 3, text, sizeof text);
  assert_string_equal(text, "small mill · 2000 rpm / 3000 rpm · 150 balls of 4 mm");
  em_scene_free(two[0]);
  em_scene_free(two[1]);
  /* That there are more kinds of balls is told. */
  char kinds[512] = "chamber = { shape = \"box\"; size = [1.0, 1.0, 1.0]; }; balls = (";
  for (int k = 0; k < 5; k++)
    snprintf(kinds + strlen(kinds), sizeof kinds - strlen(kinds),
             "%s{ name = \"%d\"; count = 1; diameter = 0.01; density = 1.0; }", k ? ", " : "", k);
  strcat(kinds, ");");
  scene = draw_scene(kinds, 0, NULL);
  em_plot_operating_point(scene, text, sizeof text);
  assert_non_null(strstr(text, "1 ball of 10 mm · …"));
  em_scene_free(scene);
  /* A long title leaves room for the rest, and is cut between letters. */
  char title[400] = "title=", whole[256];
  for (int k = 0; k < 100; k++)
    strcat(title, "é");
  const char *const override[] = {title};
  scene = draw_scene(DRAW_MILL, 1, override);
  em_plot_subtitle(scene, whole, sizeof whole);
  assert_non_null(strstr(whole, "éé… · 2000 rpm · 150 balls of 4 mm"));
  em_scene_free(scene);
}

static int clean(void **state) {
  (void)state;
  draw_clean();
  return 0;
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(all_styles_are_drawn),
      cmocka_unit_test(texts_are_taken_literally),
      cmocka_unit_test(texts_in_another_coding_are_drawn),
      cmocka_unit_test(scripts_can_be_run),
      cmocka_unit_test(the_legend_lies_on_no_curve),
      cmocka_unit_test(the_legend_lies_on_no_error),
      cmocka_unit_test(names_of_lines_are_free),
      cmocka_unit_test(many_curves_can_be_told_apart),
      cmocka_unit_test(colour_bars_can_be_read),
      cmocka_unit_test(rounding_is_no_range),
      cmocka_unit_test(a_full_disk_is_told),
      cmocka_unit_test(words_do_not_overlap),
      cmocka_unit_test(bars_are_readable),
      cmocka_unit_test(maps_are_drawn),
      cmocka_unit_test(bad_diagrams_are_refused),
      cmocka_unit_test(the_subtitle_tells_the_operating_point),
  };
  return cmocka_run_group_tests(tests, NULL, clean);
}
