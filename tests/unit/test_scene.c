/* Scenes: every default, every form of every entry, effects, sizes, and that what is printed reads
 * back to the same bits. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "eventmill/scene.h"
#include "scene/scene_table.h"

#define DRUM  "chamber = { diameter = 0.146; length = 0.135; };"
#define BALLS "balls = { count = 10; diameter = 0.005; };"
#define BAR   "y = 0.06; radius = 0.006; reach = 0.058;"

static struct em_scene *parse(const char *text) {
  struct em_scene *scene;
  struct em_error err = {0};
  enum em_status status = em_scene_parse(&scene, text, "t.cfg", 0, NULL, &err);
  if (status != EM_OK) print_error("%s\n", err.text);
  assert_int_equal(status, EM_OK);
  return scene;
}

static void defaults_of_all_entries(void **state) {
  (void)state;
  struct em_scene *s = parse(DRUM BALLS);
  assert_string_equal(s->title, "");
  assert_string_equal(s->file, "t.cfg");
  assert_true(s->duration == 1.0);
  assert_int_equal(s->seed, 1);
  assert_true(s->gravity.x == 0.0 && s->gravity.y == 0.0 && s->gravity.z == -9.81);
  assert_int_equal(s->chamber.shape, EM_SHAPE_DRUM);
  assert_true(s->chamber.diameter == 0.146 && s->chamber.length == 0.135);
  assert_true(s->chamber.rpm == 0.0 && s->chamber.ramp_half == 0.0);
  assert_true(s->chamber.ramp_tilt == 30.0 * (M_PI / 180.0));
  for (int k = 0; k < 3; ++k)
    assert_false(s->chamber.periodic[k]);
  assert_int_equal(s->rotor_count, 0);
  assert_int_equal(s->species_count, 1);
  const struct em_species *b = &s->species[0];
  assert_string_equal(b->name, "balls");
  assert_true(b->count == 10 && b->diameter == 0.005 && b->density == 7850.0 && b->speed == 1.0);
  assert_int_equal(b->start, EM_START_UNIFORM);
  assert_false(b->has_region);
  assert_null(b->position);
  for (int k = 0; k < EM_CLASS_COUNT; ++k) {
    assert_int_equal(s->contact[k].rule, EM_RULE_ROUGH);
    assert_int_equal(s->contact[k].normal.law, EM_LAW_SPAHN);
    assert_true(s->contact[k].normal.p[0] == 0.985);
    assert_true(s->contact[k].tangential == 0.9 && s->contact[k].friction == 0.1);
  }
  assert_int_equal(s->engine.lists, EM_LISTS_CALENDAR);
  assert_int_equal(s->engine.partition, EM_PARTITION_AUTO);
  assert_int_equal(s->engine.accuracy, EM_ACCURACY_STANDARD);
  assert_int_equal(s->engine.roots.quartic, EM_QUARTIC_SAFE);
  assert_true(s->engine.slices == 0 && s->engine.skin == 0.0 && s->engine.simd);
  assert_true(s->remedy.tc == 0.0 && s->remedy.elastic_below == 0.0);
  assert_int_equal(s->remedy.jam_after, 0);
  assert_true(s->remedy.jam_within == 1e-8);
  assert_int_equal(s->remedy.collapse_after, 100000);
  assert_true(s->record.frames == 50.0 && s->record.observables == 100.0);
  assert_true(s->record.histograms == 20.0 && !s->record.collisions);
  assert_true(s->record.checkpoint == 30.0);
  assert_int_equal(s->record.compression, 1);
  em_scene_free(s);
}

static void blades_take_after_their_rotor(void **state) {
  (void)state;
  struct em_scene *s =
      parse(DRUM BALLS "rotor = { rpm = 1200; radius = 0.004; reach = 0.05; tip = \"hemisphere\";"
                       "blades = ( { y = 0.03; angle_deg = 90; },"
                       " { y = 0.06; radius = 0.006; reach = 0.058; tip = \"none\"; rpm = -600; }"
                       "); };");
  assert_int_equal(s->rotor_count, 1);
  assert_int_equal(em_scene_blade_count(s), 2);
  const struct em_blade *a = &s->rotor[0].blade[0], *b = &s->rotor[0].blade[1];
  assert_true(a->radius == 0.004 && a->reach == 0.05 && a->tip == EM_TIP_HEMISPHERE);
  assert_true(fabs(a->omega - 40.0 * M_PI) < 1e-12 && fabs(a->angle - 0.5 * M_PI) < 1e-15);
  assert_true(a->centre.x == 0.0 && a->centre.y == 0.03 && a->centre.z == 0.0);
  assert_true(a->axis.x == 0.0 && a->axis.y == 1.0 && a->axis.z == 0.0);
  assert_true(a->e1.x == 0.0 && a->e1.y == 0.0 && a->e1.z == 1.0);
  assert_true(b->radius == 0.006 && b->reach == 0.058 && b->tip == EM_TIP_NONE);
  assert_true(fabs(b->omega + 20.0 * M_PI) < 1e-12);
  assert_int_equal(s->remedy.jam_after, 5);
  em_scene_free(s);
}

static void an_axis_is_made_a_unit_vector(void **state) {
  (void)state;
  struct em_scene *s = parse("chamber = { shape = \"box\"; size = [1, 1, 1]; };" BALLS
                             "rotor = { axis = [3, 0, 4]; point = [0.5, 0.5, 0.5];"
                             "blades = { y = 0.1; radius = 0.006; reach = 0.058; }; };");
  const struct em_blade *b = &s->rotor[0].blade[0];
  assert_true(fabs(b->axis.x - 0.6) < 1e-15 && fabs(b->axis.z - 0.8) < 1e-15);
  assert_true(fabs(em_vec_dot(b->axis, b->e1)) < 1e-15);
  assert_true(fabs(em_vec_norm(b->e1) - 1.0) < 1e-15);
  assert_true(fabs(b->centre.x - 0.56) < 1e-15 && fabs(b->centre.z - 0.58) < 1e-15);
  assert_int_equal(s->remedy.jam_after, 0); /* it stands still */
  em_scene_free(s);
}

static void contacts_by_class(void **state) {
  (void)state;
  struct em_scene *s =
      parse(DRUM BALLS "contact = { rule = \"friction\"; normal = 0.8; friction = 0.3;"
                       "ball-drum = { normal = \"salo\"; };"
                       "ball-end = { normal = { law = \"spahn\"; C = 0.3; }; rule = \"smooth\"; };"
                       "ball-blade = { normal = { epsilon = 0.7; }; tangential = -0.5; }; };");
  const struct em_contact_law *c = s->contact;
  assert_int_equal(c[EM_CLASS_BALL].normal.law, EM_LAW_CONSTANT);
  assert_true(c[EM_CLASS_BALL].normal.p[0] == 0.8 && c[EM_CLASS_BALL].friction == 0.3);
  assert_int_equal(c[EM_CLASS_DRUM].normal.law, EM_LAW_SALO);
  assert_int_equal(c[EM_CLASS_DRUM].rule, EM_RULE_FRICTION);
  assert_int_equal(c[EM_CLASS_END].rule, EM_RULE_SMOOTH);
  assert_true(c[EM_CLASS_END].normal.p[0] == 0.985 && c[EM_CLASS_END].normal.p[2] == 0.3);
  assert_int_equal(c[EM_CLASS_BLADE].normal.law, EM_LAW_CONSTANT);
  assert_true(c[EM_CLASS_BLADE].normal.p[0] == 0.7 && c[EM_CLASS_BLADE].tangential == -0.5);
  assert_true(c[EM_CLASS_BALL].tangential == 0.9);
  em_scene_free(s);
}

static void forms_that_values_may_take(void **state) {
  (void)state;
  struct em_scene *s = parse("gravity = [0, 0, -9.81];" /* integers and reals in one array */
                             "seed = 4294967295; duration = 3;"
                             "chamber = { shape = \"box\"; size = (1, 2.5, 3);"
                             "periodic = [true, false, true]; };"
                             "balls = ( { count = 3; diameter = 0.1; name = \"large\"; },"
                             "{ diameter = 0.05; start = \"table\"; table = ("
                             "(0.5, 0.5, 0.5, 1, 2, 3), (0.7, 0.5, 0.5, 0, 0, 0, 7, 8, 9)); } );");
  assert_true(s->gravity.z == -9.81 && s->duration == 3.0);
  assert_true(s->seed == 4294967295u);
  assert_true(s->chamber.size.y == 2.5);
  assert_true(s->chamber.periodic[0] && !s->chamber.periodic[1] && s->chamber.periodic[2]);
  assert_int_equal(em_scene_ball_count(s), 5);
  assert_string_equal(s->species[0].name, "large");
  assert_int_equal(s->species[1].count, 2);
  assert_true(s->species[1].velocity[0].z == 3.0 && s->species[1].position[1].x == 0.7);
  assert_true(s->species[1].spin[0].x == 0.0 && s->species[1].spin[1].z == 9.0);
  em_scene_free(s);
  s = parse("gravity = \"none\"; balls = ();"
            "chamber = { shape = \"box\"; size = [1, 1, 1]; periodic = true; };");
  assert_true(em_vec_norm2(s->gravity) == 0.0 && s->chamber.periodic[1]);
  assert_int_equal(em_scene_ball_count(s), 0);
  em_scene_free(s);
}

/* Integers without a point, where a real is meant. */
static void whole_numbers_of_any_length(void **state) {
  (void)state;
  struct em_scene *s;
  struct em_error err = {0};
  static const struct {
    const char *text;
    double value;
  } numbers[] = {{"2147483648", 0x1p31},
                 {"9223372036854775807", 0x1p63},
                 {"9223372036854775808", 0x1p63},
                 {"18446744073709551616", 0x1p64},
                 {"100000000000000000000", 1e20}};
  for (size_t k = 0; k < sizeof numbers / sizeof numbers[0]; ++k) {
    char text[200];
    snprintf(text, sizeof text, "duration = %s; " DRUM BALLS, numbers[k].text);
    if (em_scene_parse(&s, text, "t.cfg", 0, NULL, &err) != EM_OK) fail_msg("%s", err.text);
    assert_true(s->duration == numbers[k].value);
    em_scene_free(s);
  }
}

/* Two bars that cross close by are parted by planes that no simple direction gives. */
static void blades_are_apart_at_any_scale(void **state) {
  (void)state;
  for (double m = 1e-30; m < 1e31; m *= 1e15) {
    char text[800];
    snprintf(text, sizeof text,
             "gravity = \"none\"; chamber = { diameter = %.17g; length = %.17g; };"
             "rotor = ({ radius = %.17g; reach = %.17g; blades = ({ y = %.17g; angle_deg = 351; });"
             "}, { axis = [1, 0.3, 0.2]; point = [%.17g, %.17g, %.17g]; radius = %.17g;"
             "reach = %.17g; blades = ({ y = 0; angle_deg = 8; }); });"
             "balls = { count = 1; diameter = %.17g; };",
             0.4 * m, 0.4 * m, 0.006 * m, 0.058 * m, 0.2 * m, 0.02 * m, 0.199 * m, -0.044 * m,
             0.006 * m, 0.058 * m, 0.001 * m);
    struct em_scene *s;
    struct em_error err = {0};
    if (em_scene_parse(&s, text, "t.cfg", 0, NULL, &err) != EM_OK) fail_msg("%g: %s", m, err.text);
    em_scene_free(s);
  }
}

/* ---- files */

static void write_file(const char *path, const char *text) {
  FILE *file = fopen(path, "w");
  assert_non_null(file);
  fputs(text, file);
  fclose(file);
}

static void includes_and_tables_beside_the_scene(void **state) {
  const char *dir = *state;
  char scene[256], part[256], rows[256];
  snprintf(scene, sizeof scene, "%s/scene.cfg", dir);
  snprintf(part, sizeof part, "%s/part.cfg", dir);
  snprintf(rows, sizeof rows, "%s/rows.csv", dir);
  write_file(scene, "@include \"part.cfg\"\nballs = { diameter = 0.005; start = \"table\";\n"
                    "table = \"rows.csv\"; };\n");
  write_file(part, "# a vessel\n" DRUM "\n");
  write_file(rows, "x,y,z,vx,vy,vz\n0,0.05,0,1,0,0\n# no more\n 0.02 0.05 0 0 1e0 -2.5\n");
  struct em_scene *s;
  struct em_error err = {0};
  assert_int_equal(em_scene_read(&s, scene, 0, NULL, &err), EM_OK);
  assert_true(s->chamber.diameter == 0.146);
  assert_int_equal(s->species[0].count, 2);
  assert_true(s->species[0].velocity[1].z == -2.5);
  em_scene_free(s);

  /* Editors may mark a text as UTF-8. */
  write_file(part, "\xEF\xBB\xBF# a vessel\n" DRUM "\n");
  write_file(rows, "\xEF\xBB\xBF"
                   "0,0.05,0,1,0,0\n");
  assert_int_equal(em_scene_read(&s, scene, 0, NULL, &err), EM_OK);
  assert_int_equal(s->species[0].count, 1);
  em_scene_free(s);

  /* What is read as a number is no name of a column. */
  write_file(rows, "nan 0.05 0.05 0 0 0\n0 0.05 0 1 0 0\n");
  assert_int_equal(em_scene_read(&s, scene, 0, NULL, &err), EM_INPUT);
  assert_non_null(strstr(err.text, "rows.csv:1: error: table: expected 6 or 9 numbers"));

  /* With decimal commas, numbers would be others. */
  write_file(rows, "0,5;0,5;0,5;1;0;0\n");
  assert_int_equal(em_scene_read(&s, scene, 0, NULL, &err), EM_INPUT);
  assert_non_null(strstr(err.text, "rows.csv:1: error: table: expected 6 or 9 numbers"));
  assert_non_null(strstr(err.text, "with commas or blanks between them"));

  /* Any text begins with a line of words. */
  write_file(rows, "just some words\n# no table\n");
  assert_int_equal(em_scene_read(&s, scene, 0, NULL, &err), EM_INPUT);
  assert_non_null(strstr(err.text, "rows.csv:1: error: table: no rows, expected 6 or 9 numbers"));

  /* Faults are placed in the file in which they stand. */
  write_file(part, "# a vessel\n\nchamber = { diameter = 0.146; length = -1; };\n");
  write_file(rows, "0,0.05,0,1,0,0\n0,0.05,0\n");
  assert_int_equal(em_scene_read(&s, scene, 0, NULL, &err), EM_INPUT);
  assert_non_null(strstr(err.text, "part.cfg:3: error: chamber.length: found -1, expected a number"
                                   " above 0 (m)"));
  assert_non_null(strstr(err.text, "rows.csv:2: error: table: expected 6 or 9 numbers"));
  assert_null(s);

  write_file(part, "@include \"part.cfg\"\n");
  assert_int_equal(em_scene_read(&s, scene, 0, NULL, &err), EM_INPUT);
  assert_non_null(strstr(err.text, "part.cfg:1: error: @include: nested too deeply"));
  write_file(part, "@include \"/\"\n");
  assert_int_equal(em_scene_read(&s, scene, 0, NULL, &err), EM_FILE);
  assert_non_null(strstr(err.text, "part.cfg:1: error: @include \"/\": "));
  remove(part);
  assert_int_equal(em_scene_read(&s, scene, 0, NULL, &err), EM_FILE);
  assert_non_null(strstr(err.text, "scene.cfg:1: error: @include"));
  remove(scene);
  assert_int_equal(em_scene_read(&s, scene, 0, NULL, &err), EM_FILE);
  assert_int_equal(em_scene_read(&s, dir, 0, NULL, &err), EM_FILE);
  assert_non_null(strstr(err.text, "is a directory, expected a file"));
  remove(rows);
}

static int make_directory(void **state) {
  static char dir[] = "/tmp/test_scene_XXXXXX";
  *state = mkdtemp(dir);
  return *state ? 0 : -1;
}

static int remove_directory(void **state) {
  return remove(*state);
}

/* ---- printing */

/* Prints, reads, prints again: the texts and what they hold must be the same. */
static void round_trip(const struct em_scene *s) {
  char *first = em_scene_text(s);
  assert_non_null(first);
  struct em_scene *again = parse(first);
  char *second = em_scene_text(again);
  assert_string_equal(first, second);
  assert_true(s->duration == again->duration && s->seed == again->seed);
  assert_memory_equal(&s->gravity, &again->gravity, sizeof s->gravity);
  assert_true(s->chamber.diameter == again->chamber.diameter);
  assert_true(s->chamber.ramp_half == again->chamber.ramp_half);
  assert_true(s->chamber.ramp_tilt == again->chamber.ramp_tilt);
  assert_memory_equal(&s->chamber.size, &again->chamber.size, sizeof s->chamber.size);
  assert_int_equal(s->rotor_count, again->rotor_count);
  for (size_t r = 0; r < s->rotor_count; ++r) {
    assert_int_equal(s->rotor[r].blade_count, again->rotor[r].blade_count);
    assert_true(s->rotor[r].rpm == again->rotor[r].rpm);
    for (size_t k = 0; k < s->rotor[r].blade_count; ++k) {
      const struct em_blade *a = &s->rotor[r].blade[k], *b = &again->rotor[r].blade[k];
      assert_memory_equal(&a->centre, &b->centre, sizeof a->centre);
      assert_memory_equal(&a->axis, &b->axis, sizeof a->axis);
      assert_memory_equal(&a->e1, &b->e1, sizeof a->e1);
      assert_true(a->angle == b->angle && a->omega == b->omega);
      assert_true(a->radius == b->radius && a->reach == b->reach && a->tip == b->tip);
    }
  }
  assert_int_equal(s->species_count, again->species_count);
  for (size_t k = 0; k < s->species_count; ++k) {
    const struct em_species *a = &s->species[k], *b = &again->species[k];
    assert_string_equal(a->name, b->name);
    assert_true(a->count == b->count && a->diameter == b->diameter && a->density == b->density);
    assert_true(a->speed == b->speed && a->start == b->start && a->has_region == b->has_region);
    assert_memory_equal(&a->low, &b->low, sizeof a->low);
    assert_memory_equal(&a->high, &b->high, sizeof a->high);
    if (a->position) assert_memory_equal(a->position, b->position, a->count * sizeof *a->position);
    if (a->velocity) assert_memory_equal(a->velocity, b->velocity, a->count * sizeof *a->velocity);
    assert_int_equal(a->spin != NULL, b->spin != NULL);
  }
  for (int k = 0; k < EM_CLASS_COUNT; ++k) {
    const struct em_contact_law *a = &s->contact[k], *b = &again->contact[k];
    assert_true(a->rule == b->rule && a->tangential == b->tangential);
    assert_true(a->friction == b->friction && a->normal.law == b->normal.law);
    assert_memory_equal(a->normal.p, b->normal.p, sizeof a->normal.p);
  }
  assert_true(s->engine.skin == again->engine.skin && s->engine.slices == again->engine.slices);
  assert_memory_equal(&s->engine.roots, &again->engine.roots, sizeof s->engine.roots);
  assert_true(s->chamber.facets == again->chamber.facets);
  assert_true(s->engine.lists == again->engine.lists && s->engine.simd == again->engine.simd);
  assert_true(s->remedy.tc == again->remedy.tc && s->remedy.jam_after == again->remedy.jam_after);
  assert_int_equal(s->remedy.collapse_after, again->remedy.collapse_after);
  assert_true(s->record.frames == again->record.frames);
  assert_true(s->record.checkpoint == again->record.checkpoint);
  assert_int_equal(em_scene_effects(s), em_scene_effects(again));
  em_scene_free(again);
  free(first);
  free(second);
}

/* Reads what `text` with `saved` prints, with `changed`; it must be what `text` with both is. */
static void changes_as_it_would(const char *text, const char *saved, const char *changed) {
  const char *both[2] = {saved, changed};
  struct em_scene *s, *printed, *whole;
  struct em_error err = {0};
  assert_int_equal(em_scene_parse(&s, text, "t.cfg", 1, both, &err), EM_OK);
  char *print = em_scene_text(s);
  assert_int_equal(em_scene_parse(&printed, print, "t.cfg", 1, both + 1, &err), EM_OK);
  assert_int_equal(em_scene_parse(&whole, text, "t.cfg", 2, both, &err), EM_OK);
  char *one = em_scene_text(printed), *other = em_scene_text(whole);
  assert_string_equal(one, other);
  free(one);
  free(other);
  free(print);
  em_scene_free(whole);
  em_scene_free(printed);
  em_scene_free(s);
}

static void printed_scenes_keep_what_follows_free(void **state) {
  (void)state;
  const char *mill =
      DRUM BALLS "rotor = { rpm = 1300; radius = 0.005; reach = 0.05; blades = ( { y = 0.03; },"
                 "{ y = 0.06; } ); };"
                 "contact = { ball-drum = { tangential = 0.5; normal = 0.8; }; ball-end = { rule = "
                 "\"smooth\"; }; };";
  changes_as_it_would(mill, "contact.rule=smooth", "contact.rule=rough");
  changes_as_it_would(mill, "contact.rule=rough", "contact.rule=smooth");
  changes_as_it_would(mill, "contact.tangential=0.8", "contact.normal=0.9");
  changes_as_it_would(mill, "rotor.rpm=0", "rotor.rpm=1300");
  changes_as_it_would(mill, "rotor.rpm=1300", "rotor.rpm=2500"); /* jam_within below 1e-8 s */
  changes_as_it_would(mill, "rotor.rpm=2500", "balls.diameter=0.001");
  changes_as_it_would(mill, "rotor.radius=0.004", "rotor.reach=0.045");
  changes_as_it_would(mill, "rotor.tip=none", "rotor.tip=hemisphere");
  changes_as_it_would(mill, "remedy.jam_after=7", "contact.rule=smooth");
  changes_as_it_would(mill, "remedy.jam_within=1e-7", "rotor.rpm=2500");
}

static void printed_scenes_read_back_to_the_same_bits(void **state) {
  (void)state;
  static const char *const files[] = {
      "geometries/simoloyer-2l.cfg",      "geometries/ideal-gas.cfg",
      "geometries/ideal-gas-gravity.cfg", "geometries/bouncing-ball.cfg",
      "geometries/newtons-cradle.cfg",    "geometries/two-rotors.cfg"};
  for (size_t k = 0; k < sizeof files / sizeof files[0]; ++k) {
    struct em_scene *s;
    struct em_error err = {0};
    assert_int_equal(em_scene_read(&s, files[k], 0, NULL, &err), EM_OK);
    round_trip(s);
    em_scene_free(s);
  }
  struct em_scene *s = parse(
      "title = \"quo\\\"te, back\\\\slash, line\\nbreak, \xc3\xa9\"; duration = 0.1;"
      "seed = 3000000000; gravity = [1e-300, 0.3333333333333333, -1e22];"
      "chamber = { shape = \"box\"; size = [1, 1, 1]; };"
      "rotor = { axis = [1, 1, 1]; point = [0.5, 0.5, 0.5]; rpm = 0.1;"
      "blades = ( { y = 0.01; angle_deg = 33.3; radius = 0.006; reach = 0.058; rpm = -7.7; } ); };"
      "balls = ( { count = 5; diameter = 0.0123; region = { low = [0, 0, 0.7]; high = [1, 1, 0.9];"
      "}; start = \"half\"; }, { diameter = 0.01; start = \"table\";"
      "table = ((0.1, 0.1, 0.1, 1e-3, 0.7, -0.1, 3, 2, 0.1)); },"
      "{ count = 2; start = \"run\"; from = \"old.h5\"; diameter = 0.02; } );"
      "contact = { normal = 0.1; ball-end = { normal = \"power4\"; tangential = 0.3; }; };"
      "remedy = { collapse_after = 4000000000; tc = 1e-7; };");
  round_trip(s);
  em_scene_free(s);
  s = parse("balls = (); " DRUM);
  round_trip(s);
  em_scene_free(s);
}

/* Angles and speeds are converted on the way in; the way back must find numbers that lead there. */
static void odd_angles_read_back_to_the_same_bits(void **state) {
  (void)state;
  uint64_t x = 88172645463325252u;
  for (int k = 0; k < 300; ++k) {
    char text[512];
    double value[2];
    for (int i = 0; i < 2; ++i) {
      x ^= x << 13;
      x ^= x >> 7;
      x ^= x << 17;
      value[i] = (double)(x >> 11) * 0x1p-53 * (k % 3 == 0 ? 360.0 : k % 3 == 1 ? 1.0 : 1e5);
    }
    snprintf(text, sizeof text,
             DRUM BALLS "rotor = { blades = ( { " BAR "angle_deg = %.17g; rpm = %.17g; } ); };",
             value[0], value[1]);
    struct em_scene *s = parse(text);
    round_trip(s);
    em_scene_free(s);
  }
}

/* ---- what can be asked */

static unsigned effects_of(const char *text) {
  struct em_scene *s = parse(text);
  unsigned bits = em_scene_effects(s);
  em_scene_free(s);
  return bits;
}

static void a_scene_has_only_the_effects_it_calls_for(void **state) {
  (void)state;
  const unsigned all = EM_EFFECT_GRAVITY | EM_EFFECT_SPIN | EM_EFFECT_RESTITUTION;
  assert_int_equal(effects_of(DRUM BALLS), all);
  assert_int_equal(effects_of(DRUM BALLS "gravity = \"none\";"),
                   all & ~(unsigned)EM_EFFECT_GRAVITY);
#define PLAIN DRUM "gravity = \"none\"; contact = { rule = \"smooth\"; normal = 0.9; };"
  assert_int_equal(effects_of(PLAIN BALLS), 0);
  assert_int_equal(effects_of(DRUM BALLS "gravity = \"none\"; contact = { rule = \"rough\";"
                                         "tangential = 1; normal = 1; };"),
                   0);
  assert_int_equal(effects_of(DRUM BALLS "gravity = \"none\"; contact = { rule = \"friction\";"
                                         "friction = 0; normal = 1; };"),
                   0);
  /* Laws of contacts that cannot happen do not count. */
  assert_int_equal(effects_of(DRUM BALLS "gravity = \"none\"; contact = { rule = \"smooth\";"
                                         "normal = 1; ball-blade = { rule = \"rough\";"
                                         "normal = \"spahn\"; }; };"),
                   0);
  assert_int_equal(effects_of(PLAIN BALLS "rotor = { rpm = 3; blades = ({" BAR "}); };"),
                   EM_EFFECT_ROTOR);
  assert_int_equal(effects_of(DRUM BALLS "rotor = { rpm = 3; blades = ({" BAR "}); };"),
                   all | EM_EFFECT_ROTOR | EM_EFFECT_JAM);
  assert_int_equal(effects_of(DRUM BALLS "rotor = { rpm = 3; blades = ({" BAR "}); };"
                                         "remedy = { jam_after = 0; };"),
                   all | EM_EFFECT_ROTOR);
  assert_int_equal(effects_of(PLAIN "balls = ({ count = 1; diameter = 0.005; },"
                                    "{ count = 1; diameter = 0.006; });"),
                   EM_EFFECT_MIXED);
  assert_int_equal(effects_of(PLAIN "balls = ({ count = 1; diameter = 0.005; },"
                                    "{ count = 1; diameter = 0.005; density = 1; });"),
                   EM_EFFECT_MIXED);
  assert_int_equal(effects_of(PLAIN "balls = ({ count = 1; diameter = 0.005; },"
                                    "{ count = 0; diameter = 0.006; });"),
                   0);
  assert_int_equal(effects_of(PLAIN BALLS "remedy = { tc = 1e-6; elastic_below = 1e-3; };"),
                   EM_EFFECT_TC | EM_EFFECT_ELASTIC);
  assert_int_equal(effects_of(PLAIN BALLS "record = { collisions = true; };"),
                   EM_EFFECT_COLLISIONS);
  assert_int_equal(effects_of(BALLS "gravity = \"none\"; contact = { rule = \"smooth\";"
                                    "normal = 0.9; };"
                                    "chamber = { diameter = 0.1; length = 0.1; rpm = 1;"
                                    "ramps = { half_deg = 10; }; };"),
                   EM_EFFECT_TURNING | EM_EFFECT_RAMPS);
  assert_int_equal(effects_of(BALLS "gravity = \"none\"; contact = { rule = \"smooth\";"
                                    "normal = 0.9; }; chamber = { shape = \"box\";"
                                    "size = [1, 1, 1]; periodic = [false, false, true]; };"),
                   EM_EFFECT_PERIODIC);
}

static void sizes_and_speeds(void **state) {
  (void)state;
  struct em_vec low, high;
  struct em_scene *s = parse(DRUM BALLS);
  em_scene_bounds(s, &low, &high);
  assert_true(low.x == -0.073 && low.y == 0.0 && high.y == 0.135 && high.z == 0.073);
  assert_true(fabs(em_scene_volume(s) - M_PI * 0.073 * 0.073 * 0.135) < 1e-18);
  assert_true(fabs(em_scene_typical_speed(s) - sqrt(2.0 * 9.81 * 0.146)) < 1e-12);
  em_scene_free(s);
  s = parse("gravity = \"none\"; balls = { count = 1; diameter = 0.1; speed = 0; };"
            "chamber = { shape = \"box\"; size = [1, 2, 3]; };");
  assert_true(em_scene_volume(s) == 6.0 && em_scene_typical_speed(s) > 0.0);
  em_scene_free(s);
}

/* What a scene does not say of its remedies goes by its balls; what it says is kept. */
static void defaults_of_remedies(void **state) {
  (void)state;
  static const struct {
    const char *text;
    double within;
  } cases[] = {
      {"balls = { count = 9; diameter = 1e-3; speed = 4; };", 1e-5 * 1e-3 / 4.0},
      {"balls = ({ count = 9; diameter = 1e-3; speed = 4; }, { count = 9; diameter = 1e-4; },"
       "{ count = 0; diameter = 1e-5; });",
       1e-5 * 1e-4 / 4.0},
      {"balls = { count = 9; diameter = 0.005; };", 1e-8},
      {"balls = { count = 9; diameter = 1e-4; }; remedy = { jam_within = 1e-3; };", 1e-3},
      {"balls = { count = 9; diameter = 1e-4; }; remedy = { jam_within = 0; };", 0.0},
  };
  for (size_t k = 0; k < sizeof cases / sizeof cases[0]; ++k) {
    char text[400];
    snprintf(text, sizeof text, "gravity = \"none\"; %s %s", DRUM, cases[k].text);
    struct em_scene *s = parse(text);
    assert_true(s->remedy.jam_within == cases[k].within);
    em_scene_free(s);
  }
}

/* "| `path.name` | default | expects | meaning |" */
static void reference_row(const struct em_scene_table *table, const struct em_scene_entry *e,
                          size_t size, char *row) {
  char expects[400];
  em_scene_table_expects(e, sizeof expects, expects);
  snprintf(row, size, "\n| `%s%s%s` | %s | %s | %s |\n", table->path, table->path[0] ? "." : "",
           e->name, e->fallback ? e->fallback : "", expects,
           e->kind == EM_KIND_SPECIAL ? "" : e->help);
}

/* The reference in docs/scenes.md must have the row of each entry, and each law's parameters. */
static void the_reference_names_every_entry(void **state) {
  (void)state;
  FILE *file = fopen("docs/scenes.md", "r");
  assert_non_null(file);
  char *text = calloc(1, 1 << 20);
  assert_non_null(text);
  assert_true(fread(text, 1, (1 << 20) - 1, file) > 0);
  fclose(file);
  for (const struct em_scene_table *const *t = em_scene_table_all; *t; ++t)
    for (size_t k = 0; k < (*t)->count; ++k) {
      char row[1200];
      reference_row(*t, &(*t)->entry[k], sizeof row, row);
      if (!strstr(text, row)) fail_msg("docs/scenes.md lacks %s", row);
    }
  for (char *p = text; *p; ++p)
    if (*p == '\n') *p = ' ';
  for (int law = 0; law < EM_LAW_COUNT; ++law) {
    char words[200];
    snprintf(words, sizeof words, "`%s` (", em_contact_law_name((enum em_law)law));
    for (int k = 0; k < em_contact_law_size((enum em_law)law); ++k)
      snprintf(words + strlen(words), sizeof words - strlen(words), "%s%s", k > 0 ? ", " : "",
               em_contact_law_parameter((enum em_law)law, k));
    strcat(words, ")");
    if (!strstr(text, words)) fail_msg("docs/scenes.md lacks %s", words);
  }
  free(text);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(defaults_of_all_entries),
      cmocka_unit_test(blades_take_after_their_rotor),
      cmocka_unit_test(an_axis_is_made_a_unit_vector),
      cmocka_unit_test(contacts_by_class),
      cmocka_unit_test(forms_that_values_may_take),
      cmocka_unit_test(whole_numbers_of_any_length),
      cmocka_unit_test(blades_are_apart_at_any_scale),
      cmocka_unit_test_setup_teardown(includes_and_tables_beside_the_scene, make_directory,
                                      remove_directory),
      cmocka_unit_test(printed_scenes_read_back_to_the_same_bits),
      cmocka_unit_test(printed_scenes_keep_what_follows_free),
      cmocka_unit_test(odd_angles_read_back_to_the_same_bits),
      cmocka_unit_test(a_scene_has_only_the_effects_it_calls_for),
      cmocka_unit_test(sizes_and_speeds),
      cmocka_unit_test(defaults_of_remedies),
      cmocka_unit_test(the_reference_names_every_entry),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
