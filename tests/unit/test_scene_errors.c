/* Bad scenes: each fault gives one message with file, line, entry and what was expected; all faults
 * of a scene are reported at once. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "eventmill/scene.h"

#define DRUM  "chamber = { diameter = 0.146; length = 0.135; };\n"
#define BALLS "balls = { count = 10; diameter = 0.005; };\n"
#define BAR   "y = 0.06; radius = 0.006; reach = 0.058;"

struct fault {
  const char *text, *message; /* the whole report begins with the message */
};

static void check(const struct fault *fault) {
  struct em_scene *scene;
  struct em_error err = {0};
  enum em_status status = em_scene_parse(&scene, fault->text, "bad.cfg", 0, NULL, &err);
  if (status != EM_INPUT || strncmp(err.text, fault->message, strlen(fault->message)) != 0 ||
      strchr(err.text, '\n') != NULL)
    fail_msg("\nscene  %s\nreport %s\nwanted %s", fault->text, err.text, fault->message);
  assert_null(scene);
}

static void check_all(const struct fault *faults, size_t count) {
  for (size_t k = 0; k < count; ++k)
    check(&faults[k]);
}
#define CHECK_ALL(faults) check_all(faults, sizeof faults / sizeof faults[0])

static void syntax(void **state) {
  (void)state;
  static const struct fault faults[] = {
      {"duration = ;\n", "bad.cfg:1: error: syntax error, expected NAME = VALUE;"},
      {"\n\nduration 5;\n", "bad.cfg:3: error: syntax error"},
      {DRUM BALLS "duration = 1;\nduration = 2;\n", "bad.cfg:4: error: duplicate setting name"},
      {"chamber = { size = [1, 2); };", "bad.cfg:1: error: found \")\", expected \"]\""},
      {"\n}", "bad.cfg:2: error: \"}\" closes nothing"},
      {"[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[",
       "bad.cfg:1: error: nested too deeply, expected at most 64 brackets"},
      {"\ntitle = \"no end\n;\n",
       "bad.cfg:2: error: the string that begins here has no end, expected \""},
      {"a = @b;", "bad.cfg:1: error: \"@\", expected @include \"FILE\" at the beginning of a line"},
      {"\n/* ok */\n /* no end * /\nduration = 1;\n",
       "bad.cfg:3: error: the comment that begins here has no end, expected */"},
      {"@include \"x", "bad.cfg:1: error: \"@\", expected @include \"FILE\""},
  };
  CHECK_ALL(faults);
}

/* What makes numbers that are none, or lose their digits, is refused by its entry. */
#define OF(length, diameter, density, speed)                                                    \
  "gravity = \"none\"; chamber = { shape = \"box\"; size = [" length ", " length ", " length    \
  "]; };\nballs = { count = 10; diameter = " diameter "; density = " density "; speed = " speed \
  "; };\n"
static void magnitudes(void **state) {
  (void)state;
  static const struct fault faults[] = {
      {OF("1e110", "1e100", "1e-300", "1.0"), "bad.cfg:1: error: chamber.size: found 1e+110 m"},
      {OF("1.0", "1e-110", "1e270", "1.0"), "bad.cfg:2: error: balls.diameter: found 1e-110 m"},
      {OF("1.5e54", "2e53", "1000.0", "1.0"),
       "bad.cfg:2: error: balls.density: found 1000 kg/m³, balls of 4.19e+162 kg, expected"},
      {OF("1e-60", "1e-61", "1000.0", "1.0"), "bad.cfg:2: error: balls.density: found 1000 kg/m³"},
      {OF("1e90", "1e89", "1e-130", "1.0"),
       "bad.cfg:2: error: balls.density: found 1e-130 kg/m³, m d² = "},
      {OF("0.1", "0.01", "1000.0", "1e155"),
       "bad.cfg:2: error: balls.speed: makes speeds of 1e+155 m/s, expected at most"},
      {OF("0.1", "0.01", "1e158", "1000.0"),
       "bad.cfg:2: error: balls.speed: makes speeds of 1000 m/s"},
      {OF("0.1", "0.01", "1e-147", "0.1"), "bad.cfg:2: error: balls: found speeds of 0.1 m/s"},
      {OF("0.1", "0.01", "1000.0", "1e-150"), "bad.cfg:2: error: balls: found speeds of 1e-150"},
      {DRUM BALLS "gravity = [1e220, 0.0, 0.0];", "bad.cfg:3: error: gravity: found 1e+220 m/s²"},
      {DRUM "balls = { count = 1; diameter = 0.005; speed = 0.0; };\ngravity = [0.0, 0.0, 1e-200];",
       "bad.cfg:3: error: gravity: found 1e-200 m/s², expected 0, or"},
      {DRUM BALLS "rotor = { rpm = 1e200; blades = { " BAR " }; };",
       "bad.cfg:3: error: rotor.rpm: found 1.047e+199 rad/s"},
      {DRUM BALLS "rotor = { rpm = 1e150; blades = { " BAR " }; };",
       "bad.cfg:3: error: rotor.rpm: makes speeds of"},
      {"chamber = { diameter = 0.146; length = 0.135; rpm = -1e200; };\n" BALLS,
       "bad.cfg:1: error: chamber.rpm: found 1.047e+199 rad/s"},
      {DRUM BALLS "duration = 1e200;", "bad.cfg:3: error: duration: found 1e+200 s"},
      {DRUM "balls = { diameter = 0.005; start = \"table\"; table = ((0.0, 0.05, 0.0, 1e200, 0.0, "
            "0.0)); };",
       "bad.cfg:2: error: balls.table: makes speeds of"},
  };
  CHECK_ALL(faults);
}

static void names(void **state) {
  (void)state;
  static const struct fault faults[] = {
      {DRUM BALLS "durration = 1;",
       "bad.cfg:3: error: durration: unknown entry, expected \"durati"},
      {DRUM BALLS "zzzzzzzz = 1;",
       "bad.cfg:3: error: zzzzzzzz: unknown entry, expected one of: ti"},
      {DRUM "balls = { count = 1;\n diamter = 0.005; diameter = 0.005; };",
       "bad.cfg:3: error: balls.diamter: unknown entry, expected \"diameter\"?"},
      {DRUM BALLS "engine = { list = \"tree\"; };",
       "bad.cfg:3: error: engine.list: unknown entry, expected \"lists\"?"},
      {DRUM BALLS "contact = { ball-rotor = { }; };",
       "bad.cfg:3: error: contact.ball-rotor: unknown entry, expected \"ball-ball\"?"},
      {DRUM BALLS "contact = { ball-end = { rul = 1; }; };",
       "bad.cfg:3: error: contact.ball-end.rul: unknown entry, expected \"rule\"?"},
      {DRUM BALLS "rotor = { blades = ({" BAR "},\n{ y = 0.03; radius = 0.006; reach = 0.058;"
                  "agle_deg = 3; }); };",
       "bad.cfg:4: error: rotor.blades.1.agle_deg: unknown entry, expected \"angle_deg\"?"},
      {DRUM BALLS "contact = { normal = { law = \"spahn\"; epsilon = 1; }; };",
       "bad.cfg:3: error: contact.normal.epsilon: unknown parameter of the law \"spahn\", expected"
       " one of: A, B, C"},
  };
  CHECK_ALL(faults);
}

static void types_and_ranges(void **state) {
  (void)state;
  static const struct fault faults[] = {
      {DRUM BALLS "duration = \"1 s\";",
       "bad.cfg:3: error: duration: found \"1 s\", expected a number not below 0 (s)"},
      {DRUM BALLS "duration = -1;", "bad.cfg:3: error: duration: found -1, expected a number not"},
      {DRUM BALLS "duration = 1e999;", "bad.cfg:3: error: duration: found inf, expected a number"},
      {DRUM BALLS "seed = 0;",
       "bad.cfg:3: error: seed: found 0, expected an integer from 1 to 4294967295"},
      {DRUM BALLS "seed = 4294967297;", "bad.cfg:3: error: seed: found 4294967297, expected"},
      {DRUM BALLS "seed = 1.0;", "bad.cfg:3: error: seed: found 1.0, expected an integer"},
      {DRUM BALLS "title = 5;", "bad.cfg:3: error: title: found 5, expected a text of at most 255"},
      {DRUM BALLS "gravity = [0.0, 1.0];",
       "bad.cfg:3: error: gravity: found a list of 2, expected three numbers [x, y, z] (m/s²) or"},
      {DRUM BALLS "gravity = \"down\";",
       "bad.cfg:3: error: gravity: found \"down\", expected three"},
      {DRUM BALLS "engine = { simd = 1; };",
       "bad.cfg:3: error: engine.simd: found 1, expected true or false"},
      {DRUM BALLS "engine = { lists = \"heap\"; };",
       "bad.cfg:3: error: engine.lists: found \"heap\", expected \"calendar\", \"tree\" or "
       "\"all\""},
      {DRUM BALLS "engine = { partition = \"cell\"; };",
       "bad.cfg:3: error: engine.partition: unknown \"cell\", expected \"auto\", \"neighbours\", "
       "\"cells\", \"slices\" or \"none\"; did you mean \"cells\"?"},
      {DRUM BALLS "engine = { lanes = 5; };",
       "bad.cfg:3: error: engine.lanes: found 5, expected 0, 4 or 8"},
      {DRUM BALLS "engine = { lanes = 8.0; };",
       "bad.cfg:3: error: engine.lanes: found 8.0, expected 0, 4 or 8"},
      {DRUM BALLS "remedy = { jam_after = -1; };",
       "bad.cfg:3: error: remedy.jam_after: found -1, expected an integer from 0 to 1000000000 "
       "(contacts)"},
      {DRUM BALLS "engine = 5;", "bad.cfg:3: error: engine: found 5, expected a group { }"},
      {DRUM BALLS "remedy = { collapse_after = 0; };",
       "bad.cfg:3: error: remedy.collapse_after: found 0, expected an integer from 1 to"},
      {DRUM BALLS "record = { compression = 10; };",
       "bad.cfg:3: error: record.compression: found 10, expected an integer from 0 to 9"},
      {DRUM "balls = { count = -1; diameter = 1; };",
       "bad.cfg:2: error: balls.count: found -1, expected an integer from 0 to 100000000"},
      {DRUM "balls = 7;", "bad.cfg:2: error: balls: found 7, expected a group { } or a list"},
      {DRUM BALLS "contact = { tangential = 1.5; };",
       "bad.cfg:3: error: contact.tangential: found 1.5, expected a number from -1 to 1"},
      {DRUM BALLS "contact = { normal = 1.5; };",
       "bad.cfg:3: error: contact.normal: found 1.5, expected a number from 0 to 1"},
      {DRUM BALLS "contact = { normal = true; };",
       "bad.cfg:3: error: contact.normal: found true, expected a number from 0 to 1, the name of"},
      {DRUM BALLS "contact = { normal = \"span\"; };",
       "bad.cfg:3: error: contact.normal: unknown law \"span\", expected \"constant\""},
      {DRUM BALLS "contact = { normal = { law = \"salo\"; c = 0; }; };",
       "bad.cfg:3: error: contact.normal.c: found 0, expected a number above 0"},
      {BALLS "chamber = { shape = \"box\"; size = [1, 0, 1]; };",
       "bad.cfg:2: error: chamber.size: found (1, 0, 1), expected three numbers [x, y, z], each "
       "above 0 (m)"},
      {BALLS "chamber = { shape = \"box\"; size = [1, 1, 1]; periodic = [true, 1, true]; };",
       "bad.cfg:2: error: chamber.periodic: found a list of 3, expected true, false, or three"},
      {DRUM BALLS "rotor = { axis = [0, 0, 0]; blades = (); };",
       "bad.cfg:3: error: rotor.axis: found a list of 3, expected a direction other than (0, 0, "
       "0)"},
  };
  CHECK_ALL(faults);
}

static void missing_and_misplaced(void **state) {
  (void)state;
  static const struct fault faults[] = {
      {BALLS, "bad.cfg:1: error: \"chamber\" is missing, expected a group"},
      {DRUM, "bad.cfg:1: error: \"balls\" is missing, expected a group"},
      {BALLS "chamber = { diameter = 1; };",
       "bad.cfg:2: error: chamber: \"length\" is missing, expected a number above 0 (m)"},
      {BALLS "chamber = { shape = \"box\"; };",
       "bad.cfg:2: error: chamber: \"size\" is missing, expected three numbers"},
      {BALLS "chamber = { shape = \"box\"; size = [1, 1, 1];\n rpm = 3; };",
       "bad.cfg:3: error: chamber.rpm: does not belong to a chamber of shape \"box\", expected it "
       "only where shape = \"drum\""},
      {DRUM "balls = { diameter = 0.005; };",
       "bad.cfg:2: error: balls: \"count\" is missing, expected an integer from 0"},
      {DRUM "balls = { count = 5; };",
       "bad.cfg:2: error: balls: \"diameter\" is missing, expected a number above 0 (m)"},
      {DRUM "balls = { count = 5; diameter = 0.005; region = { low = [0, 0, 0]; }; };",
       "bad.cfg:2: error: balls.region: \"high\" is missing, expected three numbers"},
      {DRUM "balls = { count = 5; diameter = 0.005; start = \"run\"; };",
       "bad.cfg:2: error: balls: \"from\" is missing, expected a text"},
      {DRUM "balls = { count = 5; diameter = 0.005; from = \"x.h5\"; };",
       "bad.cfg:2: error: balls.from: is not used, expected it only with start = \"run\""},
      {DRUM "balls = { diameter = 0.005; start = \"table\"; };",
       "bad.cfg:2: error: balls: \"table\" is missing, expected rows"},
      {DRUM "balls = { diameter = 0.005; count = 2; start = \"table\";\n"
            "table = ((0, 0.05, 0, 0, 0, 0)); };",
       "bad.cfg:2: error: balls.count: found 2, expected 1, the number of rows of the table"},
      {DRUM "balls = { diameter = 0.005; start = \"table\"; table = (\n(0, 0.05, 0)); };",
       "bad.cfg:3: error: balls.table.0: found a list of 3, expected 6 or 9 numbers"},
      {DRUM "balls = { diameter = 0.005; start = \"table\"; table = \"no.csv\"; };",
       "bad.cfg:2: error: balls.table: expected a readable file: no.csv: error: cannot be opened"},
      {DRUM BALLS "rotor = { rpm = 5; };",
       "bad.cfg:3: error: rotor: \"blades\" is missing, expected a list"},
      {DRUM BALLS "rotor = { blades = ({ radius = 0.006; reach = 0.058; }); };",
       "bad.cfg:3: error: rotor.blades.0: \"y\" is missing, expected a number (m)"},
      {DRUM BALLS "rotor = { blades = ({ y = 0.06; reach = 0.058; }); };",
       "bad.cfg:3: error: rotor.blades.0: \"radius\" is missing, expected a number above 0 (m)"},
  };
  CHECK_ALL(faults);
}

static void impossible_machines(void **state) {
  (void)state;
  static const struct fault faults[] = {
      {DRUM BALLS "rotor = { blades = ({ y = 0.06; radius = 0.006;\n reach = 0.08; }); };",
       "bad.cfg:3: error: rotor.blades.0: touches the drum wall (reaches 0.00722"},
      /* √(0.0675² + 0.006²) = 0.067766: 5.234 mm are enough for balls of 5 mm, ... */
      {DRUM "balls = { count = 1; diameter = 0.0053; };"
            "rotor = { blades = ({ y = 0.06; radius = 0.006; reach = 0.0675; }); };",
       "bad.cfg:2: error: rotor.blades.0: leaves a gap of 0.005234 m to the drum wall, expected at "
       "least one ball diameter (0.0053 m)"},
      {DRUM BALLS "rotor = { blades = ({ y = 0.0109; radius = 0.006; reach = 0.058; }); };",
       "bad.cfg:3: error: rotor.blades.0: leaves a gap of 0.0049 m to the end wall at the lower end"
       " of y"},
      {DRUM BALLS "rotor = { blades = ({ y = 0.1341; radius = 0.006; reach = 0.058; }); };",
       "bad.cfg:3: error: rotor.blades.0: touches the end wall at the upper end of y"},
      {DRUM BALLS "rotor = { blades = ({" BAR "},\n{ y = 0.0719; radius = 0.006;"
                  "reach = 0.058; angle_deg = 90; }); };",
       "bad.cfg:4: error: rotor.blades.1: touches rotor.blades.0, expected blades that never "
       "touch"},
      /* The same, but at other phases: across each other when both stand at 45°. */
      {BALLS "chamber = { shape = \"box\"; size = [0.3, 0.135, 0.146]; };\n"
             "rotor = ({ rpm = 100; point = [0.073, 0, 0.073]; blades = ({" BAR "}); },\n"
             "{ rpm = 100; point = [0.178, 0, 0.073]; blades = ({" BAR "}); });",
       "bad.cfg:4: error: rotor.1.blades.0: touches rotor.0.blades.0"},
      /* Side by side on parallel axes, in one plane. */
      {BALLS "chamber = { shape = \"box\"; size = [0.3, 0.135, 0.146]; };\n"
             "rotor = ({ rpm = 10; point = [0.073, 0, 0.073]; blades = ({" BAR "}); },\n"
             "{ rpm = -11; point = [0.173, 0, 0.073]; blades = ({" BAR "}); });",
       "bad.cfg:4: error: rotor.1.blades.0: touches rotor.0.blades.0"},
      {BALLS "chamber = { shape = \"box\"; size = [0.3, 0.135, 0.146];\n"
             "periodic = [true, false, false]; };\n"
             "rotor = { point = [0.05, 0, 0.073]; rpm = 1; blades = ({" BAR "}); };",
       "bad.cfg:3: error: chamber.periodic: a rotor does not turn in a periodic box, expected "
       "false"},
      {DRUM "balls = { count = 1; diameter = 0.14; };",
       "bad.cfg:2: error: balls.diameter: 0.14 m does not fit into the chamber's extent of 0.135 m"
       " along y, expected less"},
      {"chamber = { shape = \"box\"; size = [1, 1, 1]; periodic = true; };\n"
       "balls = ({ count = 1; diameter = 0.1; },\n{ count = 1; diameter = 0.6; });",
       "bad.cfg:1: error: chamber.size: the periodic edge of 1 m along x is too short for balls of "
       "0.6 m, expected at least 2.05 diameters (1.23 m)"},
      {"balls = { count = 2; diameter = 0.5; };\n"
       "chamber = { shape = \"box\"; size = [0.51, 1, 1.0249];\n"
       "periodic = [false, false, true]; };",
       "bad.cfg:2: error: chamber.size: the periodic edge of 1.025 m along z is too short for "
       "balls "
       "of 0.5 m, expected at least 2.05 diameters (1.025 m)"},
      {DRUM "balls = { count = 26000; diameter = 0.005; };",
       "bad.cfg:2: error: balls: 26000 balls would fill 0.753 of the chamber, expected at most"},
      {DRUM "balls = { count = 1000; diameter = 0.005;\n"
            "region = { low = [0, 0, 0]; high = [0.03, 0.03, 0.03]; }; };",
       "bad.cfg:3: error: balls.region: 1000 balls would fill 1.64 of it, expected at most 0.74"},
      {DRUM "balls = { count = 1; diameter = 0.005;\n"
            "region = { low = [0, 0.14, 0]; high = [0.03, 0.2, 0.03]; }; };",
       "bad.cfg:3: error: balls.region: lies outside the chamber"},
      {DRUM "balls = { count = 1; diameter = 0.005;\n"
            "region = { low = [0.06, 0, 0.06]; high = [0.07, 0.1, 0.07]; }; };",
       "bad.cfg:3: error: balls.region: lies outside the chamber"},
      {DRUM "balls = { count = 1; diameter = 0.005;\n"
            "region = { low = [0.06, 0, 0]; high = [0, 0.1, 0.07]; }; };",
       "bad.cfg:3: error: balls.region: low is above high along x"},
  };
  CHECK_ALL(faults);
}

static void accept(const char *text) {
  struct em_scene *scene;
  struct em_error err = {0};
  if (em_scene_parse(&scene, text, "good.cfg", 0, NULL, &err) != EM_OK)
    fail_msg("%s\n%s", text, err.text);
  em_scene_free(scene);
}

/* What is just possible is no error. */
static void possible_machines(void **state) {
  (void)state;
  accept(DRUM BALLS "rotor = { blades = ({ y = 0.011; radius = 0.006; reach = 0.0675; },"
                    "{ y = 0.02301; radius = 0.006; reach = 0.058; angle_deg = 90; }); };");
  /* Round ends reach no farther than the reach. */
  accept(DRUM "balls = { count = 1; diameter = 0.005; };"
              "rotor = { tip = \"hemisphere\";"
              "blades = ({ y = 0.06; radius = 0.006; reach = 0.068; }); };");
  /* A standing bar need not have room to turn. */
  accept(BALLS "chamber = { shape = \"box\"; size = [0.146, 0.135, 0.03]; };"
               "rotor = { point = [0.073, 0, 0.015]; blades = ({ y = 0.06; radius = 0.005;"
               "reach = 0.06; angle_deg = 90; }); };");
  /* Gear wheels: bars in one plane at the same speed, always across each other. */
  accept(BALLS "chamber = { shape = \"box\"; size = [0.3, 0.135, 0.146]; };"
               "rotor = ({ rpm = 100; point = [0.073, 0, 0.073]; blades = ({" BAR "}); },"
               "{ rpm = 100; point = [0.178, 0, 0.073];"
               "blades = ({" BAR "angle_deg = 90; }); });");
  /* Between each other, on parallel axes. */
  accept(BALLS "chamber = { shape = \"box\"; size = [0.3, 0.135, 0.146]; };"
               "rotor = ({ rpm = 10; point = [0.073, 0, 0.073]; blades = ({" BAR "}); },"
               "{ rpm = -11; point = [0.173, 0, 0.073]; blades = ({ y = 0.073; radius = 0.006;"
               "reach = 0.058; }); });");
  accept(DRUM "balls = { count = 0; diameter = 0.005; };");
}

static void all_faults_at_once(void **state) {
  (void)state;
  struct em_scene *scene;
  struct em_error err = {0};
  const char *const overrides[] = {"record.frames=-1", "title"};
  enum em_status status =
      em_scene_parse(&scene, "duration = -1;\nsead = 5;\n" DRUM "balls = { count = 1; };\n",
                     "bad.cfg", 2, overrides, &err);
  assert_int_equal(status, EM_INPUT);
  assert_string_equal(
      err.text,
      "command line: error: \"title\": expected KEY=VALUE\n"
      "bad.cfg:1: error: duration: found -1, expected a number not below 0 (s)\n"
      "bad.cfg:2: error: sead: unknown entry, expected \"seed\"?\n"
      "bad.cfg:4: error: balls: \"diameter\" is missing, expected a number above 0 (m)\n"
      "command line: error: record.frames: found -1, expected a number not below 0 (1/s)");
}

/* More faults than the report has room for: the rest is counted. */
static void too_many_faults(void **state) {
  (void)state;
  char text[8192] = "";
  for (int k = 0; k < 200; ++k)
    snprintf(text + strlen(text), sizeof text - strlen(text), "unknown%d = 1;\n", k);
  struct em_scene *scene;
  struct em_error err = {0};
  assert_int_equal(em_scene_parse(&scene, text, "bad.cfg", 0, NULL, &err), EM_INPUT);
  int lines = 1, more = 0;
  for (const char *p = err.text; *p; ++p)
    lines += *p == '\n';
  const char *last = strrchr(err.text, '\n');
  assert_int_equal(sscanf(last, "\nerror: and %d more", &more), 1);
  assert_int_equal(lines - 1 + more, 202);
}

/* A ball's number of its species has 16 bits. */
static void species_beyond_all_numbers(void **state) {
  (void)state;
  enum { ONE_TOO_MANY = 65537 };
  static const char one[] = "{ count = 0; diameter = 0.005; },";
  char *text = malloc(sizeof DRUM + 32 + ONE_TOO_MANY * sizeof one), *at = text;
  assert_non_null(text);
  at = stpcpy(at, DRUM "balls = (");
  for (int k = 0; k < ONE_TOO_MANY; ++k)
    at = stpcpy(at, one);
  strcpy(at - 1, ");");
  check(&(struct fault){
      text, "bad.cfg:2: error: balls: found a list of 65537, expected at most 65536 species"});
  free(text);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(syntax),
      cmocka_unit_test(magnitudes),
      cmocka_unit_test(names),
      cmocka_unit_test(types_and_ranges),
      cmocka_unit_test(missing_and_misplaced),
      cmocka_unit_test(impossible_machines),
      cmocka_unit_test(possible_machines),
      cmocka_unit_test(all_faults_at_once),
      cmocka_unit_test(too_many_faults),
      cmocka_unit_test(species_beyond_all_numbers),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
