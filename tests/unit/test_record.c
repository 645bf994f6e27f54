/* Run files: what is written is what happened; what is resumed is what would have been; what is
 * damaged is refused. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <sys/stat.h>

#include <cmocka.h>

#include "eventmill/xdmf.h"
#include "run_digest.h"

enum { FLIPS = 500, CUTS = 60 };

static char *path_of(const char *name) {
  static char paths[8][256];
  static int next;
  char *path = paths[next++ % 8];
  snprintf(path, 256, "%s/%s", digest_folder(), name);
  return path;
}

static enum em_status record(const struct em_scene *scene, const char *path, bool resume,
                             struct em_summary *summary, struct em_error *err) {
  const struct em_recorder_options options = {.path = path, .resume = resume, .command = "test"};
  return em_recorder_run(scene, &options, summary, NULL, err);
}

/* Records SMALL_MILL with at most one override; the digest of its file. */
static uint64_t record_digest(const char *path, const char *override, bool resume) {
  struct em_scene *scene = digest_scene(SMALL_MILL, override ? 1 : 0, &override);
  struct em_error err = {0};
  uint64_t digest = 0;
  if (record(scene, path, resume, NULL, &err)) fail_msg("%s", err.text);
  em_scene_free(scene);
  if (digest_run(path, &digest, &err)) fail_msg("%s", err.text);
  return digest;
}

/* ---------------------------------------------------------------- what is written */

struct diary {
  size_t count, room;
  struct em_contact *contact;
};

static void note(void *self, const struct em_contact *contact) {
  struct diary *diary = self;
  if (diary->count == diary->room) {
    diary->room = diary->room ? 2 * diary->room : 1024;
    diary->contact = realloc(diary->contact, diary->room * sizeof *contact);
  }
  diary->contact[diary->count++] = *contact;
}

/* The same scene run without the recorder: frames and contacts must be the same bits. */
static void frames_and_contacts_are_those_of_the_world(void **state) {
  (void)state;
  const char *path = path_of("world.h5");
  record_digest(path, NULL, false);
  struct em_run_file *file = NULL;
  struct em_error err = {0};
  assert_int_equal(em_run_file_open(&file, path, &err), EM_OK);

  struct em_scene *scene = digest_scene(SMALL_MILL, 0, NULL);
  struct em_balls *start = NULL, *b = em_start_new(150), *f = NULL;
  struct em_world *world = NULL;
  struct diary diary = {0};
  const struct em_observer observer = {&diary, note};
  assert_int_equal(em_start_make(&start, scene, NULL, NULL, &err), EM_OK);
  assert_int_equal(em_world_new(&world, scene, start, &err), EM_OK);
  assert_int_equal(em_world_observe(world, &observer), EM_OK);
  assert_int_equal(em_run_file_balls(file, &f, &err), EM_OK);
  assert_int_equal(em_run_file_frame_count(file), 13);
  for (size_t k = 0; k < 13; k++) {
    const double time = (double)k / 200.0;
    assert_true(em_run_file_frame_time(file, k) == time);
    assert_int_equal(em_world_run(world, time, NULL, &err), EM_OK);
    em_world_state(world, time, b);
    assert_int_equal(em_run_file_frame(file, k, f, &err), EM_OK);
    assert_memory_equal(b->position, f->position, 150 * sizeof *b->position);
    assert_memory_equal(b->velocity, f->velocity, 150 * sizeof *b->velocity);
    assert_memory_equal(b->spin, f->spin, 150 * sizeof *b->spin);
    assert_memory_equal(b->mass, f->mass, 150 * sizeof *b->mass);
    assert_memory_equal(b->radius, f->radius, 150 * sizeof *b->radius);
  }
  assert_true(diary.count > 1000);
  assert_int_equal(em_run_file_row_count(file), diary.count);
  struct em_rows *rows = em_run_file_rows_new(EM_COLUMN_ALL);
  assert_int_equal(em_run_file_rows(file, 0, rows, &err), EM_OK);
  for (size_t i = 0; i < rows->count; i++) {
    const struct em_contact *c = &diary.contact[i];
    assert_true(rows->time[i] == c->time && rows->cls[i] == c->cls && rows->ball[i] == c->ball &&
                rows->partner[i] == c->partner && rows->vn[i] == (float)c->vn &&
                rows->vt[i] == (float)c->vt && rows->lost[i] == (float)c->lost &&
                rows->place[i][1] == (float)c->place.y && rows->normal[i][2] == (float)c->normal.z);
  }
  em_run_file_rows_free(rows);
  free(diary.contact);
  em_world_free(world);
  em_start_free(start);
  em_start_free(b);
  em_start_free(f);
  em_scene_free(scene);
  em_run_file_close(file);
}

/* Blocks follow one another to the end and add up to the counts of the observables and the table.
 */
static void histograms_add_up(void **state) {
  (void)state;
  const char *path = path_of("sum.h5");
  record_digest(path, "record.histograms=70.0", false); /* the last block is a part of one */
  struct em_run_file *file = NULL;
  struct em_series *collisions = NULL;
  struct em_error err = {0};
  assert_int_equal(em_run_file_open(&file, path, &err), EM_OK);
  assert_int_equal(em_run_file_series(file, "collisions", &collisions, &err), EM_OK);
  const size_t bins = em_run_file_bins(file), blocks = em_run_file_block_count(file);
  uint64_t *counts = malloc(EM_CLASS_COUNT * bins * sizeof *counts), sum[EM_CLASS_COUNT] = {0};
  assert_int_equal(blocks, 5);
  double end = 0.0;
  for (size_t k = 0; k < blocks; k++) {
    assert_true(em_run_file_block_start(file, k) == end);
    end = em_run_file_block_end(file, k);
    assert_int_equal(em_run_file_block(file, k, counts, &err), EM_OK);
    for (size_t i = 0; i < EM_CLASS_COUNT * bins; i++)
      sum[i / bins] += counts[i];
  }
  assert_true(end == 0.06);
  uint64_t total = 0;
  for (int c = 0; c < EM_CLASS_COUNT; c++) {
    const double last = collisions->value[(collisions->count - 1) * collisions->width + (size_t)c];
    assert_true((double)sum[c] == last);
    total += sum[c];
  }
  assert_int_equal(collisions->count, 31);
  assert_int_equal(total, em_run_file_row_count(file));
  assert_int_equal(total, em_run_file_state(file)->collisions);
  free(counts);
  em_run_file_series_free(collisions);
  em_run_file_close(file);
}

/* A scene pays only for what it calls for. */
static void absent_effects_leave_no_trace(void **state) {
  (void)state;
  static const char text[] = "duration = 0.01; gravity = [0.0, 0.0, 0.0];\n"
                             "chamber = { shape = \"box\"; size = [0.1, 0.1, 0.1]; };\n"
                             "balls = { count = 20; diameter = 0.01; density = 1000.0; };\n"
                             "contact = { rule = \"smooth\"; normal = 1.0; };\n"
                             "record = { frames = 0.0; observables = 1000.0; };";
  const char *path = path_of("poor.h5");
  struct em_scene *scene = digest_scene(text, 0, NULL);
  struct em_error err = {0};
  struct em_summary summary;
  assert_int_equal(record(scene, path, false, &summary, &err), EM_OK);
  em_scene_free(scene);
  struct em_run_file *file = NULL;
  if (em_run_file_open(&file, path, &err)) fail_msg("%s", err.text);
  assert_int_equal(em_run_file_frame_count(file), 0);
  assert_false(em_run_file_has_rows(file));
  assert_true(em_run_file_has(file, "kinetic_energy"));
  assert_false(em_run_file_has(file, "spin_energy"));
  assert_false(em_run_file_has(file, "potential_energy"));
  assert_false(em_run_file_has(file, "blade_work"));
  assert_false(em_run_file_has(file, "jam_contacts"));
  em_run_file_close(file);
  assert_true(summary.energy_error < 1e-12);
  struct em_balls *balls = NULL;
  assert_int_equal(em_run_file_last(path, &balls, &err), EM_INPUT);
}

static void summary_closes_the_energy_budget(void **state) {
  (void)state;
  struct em_scene *scene = digest_scene(SMALL_MILL, 0, NULL);
  struct em_summary s;
  struct em_error err = {0};
  assert_int_equal(record(scene, NULL, false, &s, &err), EM_OK);
  em_scene_free(scene);
  assert_true(s.energy_error < 1e-12);
  assert_true(s.simulated_time == 0.06);
  assert_true(s.power > 0.0 && s.median_speed > 0.0 && s.median_vn > 0.0);
  assert_int_equal(s.by_class[0] + s.by_class[1] + s.by_class[2] + s.by_class[3], s.collisions);
}

/* ---------------------------------------------------------------- resuming */

static volatile sig_atomic_t stop;

static void stop_at_third(void *self, const struct em_recorder_progress *progress) {
  (void)progress;
  if (++*(int *)self % 5 == 0) stop = 1;
}

static void interrupted_runs_end_as_uninterrupted_ones(void **state) {
  (void)state;
  const uint64_t whole = record_digest(path_of("whole.h5"), NULL, false);
  const char *path = path_of("pieces.h5");
  struct em_scene *scene = digest_scene(SMALL_MILL, 0, NULL);
  int calls = 0, pieces = 0;
  enum em_status status = EM_STOPPED;
  while (status == EM_STOPPED && pieces++ < 100) {
    const struct em_recorder_options options = {
        .path = path, .resume = true, .stop = &stop, .progress = stop_at_third, .self = &calls};
    struct em_error err = {0};
    stop = 0;
    status = em_recorder_run(scene, &options, NULL, NULL, &err);
  }
  em_scene_free(scene);
  assert_int_equal(status, EM_OK);
  assert_true(pieces > 3);
  struct em_error err = {0};
  uint64_t digest = 0;
  assert_int_equal(digest_run(path, &digest, &err), EM_OK);
  assert_true(digest == whole);
  struct em_run_file *file = NULL;
  struct em_run_session session;
  assert_int_equal(em_run_file_open(&file, path, &err), EM_OK);
  assert_int_equal(em_run_file_session_count(file), pieces);
  assert_int_equal(em_run_file_session(file, 1, &session, &err), EM_OK);
  assert_true(session.from > 0.0 && session.to > session.from && session.version[0]);
  em_run_file_close(file);
}

/* Epochs without a contact are many, and none of them may pass it over. */
static void a_world_in_which_nothing_happens_is_stopped(void **state) {
  (void)state;
  static const volatile sig_atomic_t at_once = 1;
  static const char *const empty[] = {"balls.count=0"};
  struct em_scene *scene = digest_scene(SMALL_MILL, 1, empty);
  struct em_balls *start = NULL;
  struct em_world *world = NULL;
  struct em_error err = {0};
  assert_int_equal(em_start_make(&start, scene, NULL, NULL, &err), EM_OK);
  assert_int_equal(em_world_new(&world, scene, start, &err), EM_OK);
  assert_int_equal(em_world_run(world, 100.0, &at_once, &err), EM_STOPPED);
  assert_true(em_world_time(world) == 0.0);
  em_world_free(world);
  em_start_free(start);
  em_scene_free(scene);
}

/* 0.045 s lies between samples of all kinds. */
static void finished_runs_can_be_extended(void **state) {
  (void)state;
  const uint64_t whole = record_digest(path_of("direct.h5"), NULL, false);
  const char *path = path_of("extended.h5");
  const uint64_t part = record_digest(path, "duration=0.0451", false);
  assert_true(part != whole);
  assert_true(record_digest(path, NULL, true) == whole);
  assert_true(record_digest(path, NULL, true) == whole); /* nothing to do */
}

static void who_may_read_a_file_stays_so(void **state) {
  (void)state;
  char *path = path_of("private.h5");
  struct stat info;
  record_digest(path, "duration=0.01", false);
  assert_int_equal(chmod(path, 0640), 0);
  record_digest(path, "duration=0.02", true);
  assert_int_equal(stat(path, &info), 0);
  assert_int_equal(info.st_mode & 0777, 0640);
}

static void other_scenes_and_existing_files_are_refused(void **state) {
  (void)state;
  const char *path = path_of("mine.h5"), *override = "balls.count=149", *shorter = "duration=0.01";
  const uint64_t before = record_digest(path, NULL, false);
  struct em_error err = {0};
  struct em_scene *other = digest_scene(SMALL_MILL, 1, &override);
  assert_int_equal(record(other, path, true, NULL, &err), EM_INPUT);
  assert_non_null(strstr(err.text, "\"count = 150;\" there, \"count = 149;\" now"));
  assert_int_equal(record(other, path, false, NULL, &err), EM_INPUT);
  em_scene_free(other);
  other = digest_scene(SMALL_MILL, 1, &shorter);
  assert_int_equal(record(other, path, true, NULL, &err), EM_INPUT);
  em_scene_free(other);
  uint64_t after = 0;
  assert_int_equal(digest_run(path, &after, &err), EM_OK);
  assert_true(before == after);
  static const char *const ending[] = {"next", "prev", "lock"};
  for (int k = 0; k < 3; k++) {
    char other_name[300];
    snprintf(other_name, sizeof other_name, "%s.%s", path, ending[k]);
    assert_int_not_equal(access(other_name, F_OK), 0);
  }
}

/* ---------------------------------------------------------------- damage */

static unsigned char *read_file(const char *path, size_t *size) {
  FILE *in = fopen(path, "rb");
  assert_non_null(in);
  fseek(in, 0, SEEK_END);
  *size = (size_t)ftell(in);
  rewind(in);
  unsigned char *data = malloc(*size);
  assert_int_equal(fread(data, 1, *size, in), *size);
  fclose(in);
  return data;
}

static void write_file(const char *path, const void *data, size_t size) {
  FILE *out = fopen(path, "wb");
  assert_non_null(out);
  assert_int_equal(fwrite(data, 1, size, out), size);
  fclose(out);
}

/* A file that is cut short is refused, wherever the cut is. */
static void truncated_files_are_refused(void **state) {
  (void)state;
  const char *path = path_of("cut.h5");
  size_t size;
  record_digest(path, "duration=0.01", false);
  unsigned char *data = read_file(path, &size);
  for (size_t k = 0; k < CUTS; k++) {
    struct em_error err = {0};
    uint64_t digest;
    write_file(path, data, k < 8 ? k : size * k / CUTS);
    const enum em_status status = digest_run(path, &digest, &err);
    assert_true(status == EM_FORMAT || status == EM_FILE);
    assert_true(strstr(err.text, "error:"));
  }
  free(data);
}

/* A flipped bit is reported, or it has no consequence: never a wrong number. */
static void flipped_bits_do_no_harm(void **state) {
  (void)state;
  const char *path = path_of("flip.h5");
  size_t size, caught = 0;
  const uint64_t good = record_digest(path, "duration=0.01", false);
  unsigned char *data = read_file(path, &size);
  srand(7);
  for (int k = 0; k < FLIPS; k++) {
    /* A third of them among the first bytes, where the superblock and the first headers are. */
    const size_t at = (size_t)rand() % (k % 3 ? size : 4096), bit = (size_t)rand() % 8;
    struct em_error err = {0};
    uint64_t digest = 0;
    FILE *out = fopen(path, "r+b");
    fseek(out, (long)at, SEEK_SET);
    fputc(data[at] ^ (1 << bit), out);
    fclose(out);
    const enum em_status status = digest_run(path, &digest, &err);
    if (!status && digest != good) fail_msg("bit %zu of byte %zu: wrong numbers", bit, at);
    caught += status != EM_OK;
    out = fopen(path, "r+b");
    fseek(out, (long)at, SEEK_SET);
    fputc(data[at], out);
    fclose(out);
  }
  assert_true(caught > FLIPS / 10);
  free(data);
}

static void foreign_files_are_refused(void **state) {
  (void)state;
  const char *path = path_of("foreign");
  struct em_run_file *file = NULL;
  struct em_error err = {0};
  assert_int_equal(em_run_file_open(&file, path, &err), EM_FILE);
  assert_int_equal(em_run_file_open(&file, digest_folder(), &err), EM_FILE);
  write_file(path, "", 0);
  assert_int_equal(em_run_file_open(&file, path, &err), EM_FORMAT);
  write_file(path, "duration = 1.0;\n", 16);
  assert_int_equal(em_run_file_open(&file, path, &err), EM_FORMAT);
  assert_true(strstr(err.text, "foreign: error: is not an HDF5 file"));
}

/* ---------------------------------------------------------------- sidecar */

static size_t count_of(const char *text, const char *word) {
  size_t count = 0;
  for (const char *at = strstr(text, word); at; at = strstr(at + 1, word))
    count++;
  return count;
}

static char *sidecar(const struct em_run_file *file, enum em_xdmf_form form) {
  struct em_error err = {0};
  const char *path = path_of("run.xmf");
  size_t size;
  assert_int_equal(em_xdmf_write(file, path, form, &err), EM_OK);
  char *text = (char *)read_file(path, &size);
  text = realloc(text, size + 1);
  text[size] = '\0';
  return text;
}

/* Every frame names its own rows of the datasets. */
static void sidecars_name_every_frame(void **state) {
  (void)state;
  const char *path = path_of("side.h5");
  char whole[512];
  record_digest(path, NULL, false);
  struct em_run_file *file = NULL;
  struct em_error err = {0};
  assert_int_equal(em_run_file_open(&file, path, &err), EM_OK);
  char *text = sidecar(file, EM_XDMF_HYPERSLAB);
  assert_int_equal(count_of(text, "<Grid Name=\"frame "), 13);
  assert_int_equal(count_of(text, "</Grid>"), 14);
  assert_int_equal(count_of(text, ">12 0 0 1 1 1 1 150 3<"), 3); /* place, velocity, spin */
  assert_int_equal(count_of(text, ">side.h5:/particles/balls/position/value<"), 13);
  free(text);
  text = sidecar(file, EM_XDMF_SELECTION);
  snprintf(whole, sizeof whole, ">%s:/particles/balls/velocity/value|7 0 0:1 1 1:1 150 3:13 150 3<",
           path);
  assert_int_equal(count_of(text, whole), 1);
  free(text);
  em_run_file_close(file);
}

static int remove_folder(void **state) {
  (void)state;
  digest_folder_remove();
  return 0;
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(frames_and_contacts_are_those_of_the_world),
      cmocka_unit_test(histograms_add_up),
      cmocka_unit_test(absent_effects_leave_no_trace),
      cmocka_unit_test(summary_closes_the_energy_budget),
      cmocka_unit_test(interrupted_runs_end_as_uninterrupted_ones),
      cmocka_unit_test(a_world_in_which_nothing_happens_is_stopped),
      cmocka_unit_test(finished_runs_can_be_extended),
      cmocka_unit_test(who_may_read_a_file_stays_so),
      cmocka_unit_test(other_scenes_and_existing_files_are_refused),
      cmocka_unit_test(truncated_files_are_refused),
      cmocka_unit_test(flipped_bits_do_no_harm),
      cmocka_unit_test(foreign_files_are_refused),
      cmocka_unit_test(sidecars_name_every_frame),
  };
  return cmocka_run_group_tests(tests, NULL, remove_folder);
}
