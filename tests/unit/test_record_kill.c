/* Run files when the program dies or the disk fails: at every single call that changes the disk.
 * The test takes the place of the system's pwrite, rename, link, unlink and ftruncate; at the n-th
 * call it kills the process in the midst of it, or reports a full disk. */
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>

#include <cmocka.h>

#include "run_digest.h"

/* ---------------------------------------------------------------- the faulty disk */

enum fault { NONE, KILL, FULL };
static enum fault fault;
static long calls, fuse; /* calls so far; the one at which the fault strikes */

static int strikes(void) {
  calls++;
  return fault == KILL ? calls == fuse : fault == FULL ? calls >= fuse : 0;
}

/* What a crash of the machine may undo: `replaced` is the file that lost its name to another one
 * since names were last forced to the disk (0: none is left to write to), and may have it again;
 * `overwritten` counts writes to it. */
static bool folder_fails;
static ino_t replaced;
static long overwritten, settled;

static void write_to(int fd) {
  struct stat info;
  if (fstat(fd, &info) == 0 && info.st_ino == replaced) overwritten++;
}

int fsync(int fd) {
  struct stat info;
  if (fstat(fd, &info) != 0 || !S_ISDIR(info.st_mode)) return (int)syscall(SYS_fsync, fd);
  errno = EIO;
  if (folder_fails) return -1;
  settled++;
  replaced = 0;
  return 0;
}

static void die(void) {
  syscall(SYS_kill, syscall(SYS_getpid), SIGKILL);
}

/* Half of the bytes arrive before the kill. */
ssize_t pwrite(int fd, const void *data, size_t size, off_t at) {
  write_to(fd);
  if (strikes()) {
    if (fault == FULL) {
      errno = ENOSPC;
      return -1;
    }
    syscall(SYS_pwrite64, fd, data, size / 2, at);
    die();
  }
  return syscall(SYS_pwrite64, fd, data, size, at);
}

int rename(const char *from, const char *to) {
  struct stat info;
  if (strikes() && fault == KILL) die();
  if (stat(to, &info) == 0 && info.st_nlink > 1) replaced = info.st_ino;
  return (int)syscall(SYS_rename, from, to);
}

int link(const char *from, const char *to) {
  if (strikes() && fault == KILL) die();
  return (int)syscall(SYS_link, from, to);
}

int unlink(const char *path) {
  struct stat info;
  if (stat(path, &info) == 0 && info.st_nlink == 1 && info.st_ino == replaced) replaced = 0;
  if (strikes() && fault == KILL) die();
  return (int)syscall(SYS_unlink, path);
}

int ftruncate(int fd, off_t size) {
  write_to(fd);
  if (strikes() && fault == KILL) die();
  return (int)syscall(SYS_ftruncate, fd, size);
}

/* ---------------------------------------------------------------- the runs */

static const char *path_of(const char *name) {
  static char path[256];
  snprintf(path, sizeof path, "%s/%s", digest_folder(), name);
  return path;
}

static enum em_status record(const char *path, struct em_error *err) {
  static const char *const overrides[] = {"duration=0.012", "balls.count=40"};
  struct em_scene *scene = digest_scene(SMALL_MILL, 2, overrides);
  const struct em_recorder_options options = {.path = path, .resume = true};
  const enum em_status status = em_recorder_run(scene, &options, NULL, NULL, err);
  em_scene_free(scene);
  return status;
}

/* In a process of its own; returns what waitpid tells. */
static int record_apart(const char *path, enum fault what, long when) {
  const pid_t child = fork();
  if (child == 0) {
    struct em_error err = {0};
    fault = what;
    fuse = when;
    calls = 0;
    const enum em_status status = record(path, &err);
    if (status && !(status == EM_FILE && strstr(err.text, "No space left"))) _exit(99);
    _exit(status ? 1 : 0);
  }
  int result = 0;
  waitpid(child, &result, 0);
  return result;
}

/* The same, and how many calls it took. */
static uint64_t record_whole(const char *path, long *count) {
  struct em_error err = {0};
  uint64_t digest = 0;
  calls = 0;
  if (record(path, &err)) fail_msg("%s", err.text);
  *count = calls;
  assert_int_equal(digest_run(path, &digest, &err), EM_OK);
  return digest;
}

static void remove_run(const char *path) {
  char other[300];
  unlink(path);
  snprintf(other, sizeof other, "%s.next", path);
  unlink(other);
  snprintf(other, sizeof other, "%s.prev", path);
  unlink(other);
  snprintf(other, sizeof other, "%s.lock", path);
  unlink(other);
}

/* What is there can be read to its end, and goes on to the end of the uninterrupted run. */
static void check_and_finish(const char *path, uint64_t whole, long when) {
  struct em_error err = {0};
  uint64_t digest = 0;
  if (access(path, F_OK) == 0 && digest_run(path, &digest, &err))
    fail_msg("call %ld: %s", when, err.text);
  if (record(path, &err)) fail_msg("call %ld: %s", when, err.text);
  if (digest_run(path, &digest, &err)) fail_msg("call %ld: %s", when, err.text);
  if (digest != whole) fail_msg("call %ld: resumed run differs", when);
}

/* The long form tries every single call. */
#ifdef EVERY_CALL
enum { KILLS = INT_MAX, FULLS = INT_MAX };
#else
enum { KILLS = 50, FULLS = 15 };
#endif

/* The step that makes about `tries` tries. */
static long step_of(long count, long tries) {
  return count < tries ? 1 : count / tries;
}

static void killed_at_any_call_the_file_is_valid_and_resumes(void **state) {
  (void)state;
  long count;
  const uint64_t whole = record_whole(path_of("whole.h5"), &count);
  assert_true(count > 200);
  print_message("# %ld calls change the disk\n", count);
  for (long when = 1; when <= count; when += step_of(count, KILLS)) {
    const char *path = path_of("killed.h5");
    remove_run(path);
    const int result = record_apart(path, KILL, when);
    assert_true(WIFSIGNALED(result) && WTERMSIG(result) == SIGKILL);
    check_and_finish(path, whole, when);
  }
}

/* Killed again and again at the same few calls of every try, it must come to its end still when the
 * fuse is long enough for one flush. */
static void killed_when_resuming_it_goes_on(void **state) {
  (void)state;
  long count;
  const uint64_t whole = record_whole(path_of("whole2.h5"), &count);
  const char *path = path_of("often.h5");
  remove_run(path);
  int tries = 0, result;
  do {
    result = record_apart(path, KILL, count / 3 + 17 * (tries % 7));
    struct em_error err = {0};
    uint64_t digest;
    if (access(path, F_OK) == 0 && digest_run(path, &digest, &err)) fail_msg("%s", err.text);
  } while (WIFSIGNALED(result) && ++tries < 200);
  assert_true(WIFEXITED(result) && WEXITSTATUS(result) == 0);
  assert_true(tries > 2);
  struct em_error err = {0};
  uint64_t digest = 0;
  assert_int_equal(digest_run(path, &digest, &err), EM_OK);
  assert_true(digest == whole);
}

static void a_full_disk_is_an_error_and_the_file_stays_valid(void **state) {
  (void)state;
  long count;
  const uint64_t whole = record_whole(path_of("whole3.h5"), &count);
  for (long when = 1; when <= count; when += step_of(count, FULLS)) {
    const char *path = path_of("full.h5");
    remove_run(path);
    const int result = record_apart(path, FULL, when);
    assert_true(WIFEXITED(result));
    /* The last calls are no writes: nothing fails there. */
    if (WEXITSTATUS(result) > 1) fail_msg("call %ld: unexpected error", when);
    check_and_finish(path, whole, when);
  }
}

/* The former file is written to only when its name is the new one's for good, or never. */
static void a_crash_of_the_machine_finds_a_whole_file(void **state) {
  (void)state;
  uint64_t whole[2];
  for (int fails = 0; fails < 2; fails++) {
    const char *path = path_of("crash.h5");
    long count;
    remove_run(path);
    folder_fails = fails;
    settled = overwritten = 0;
    whole[fails] = record_whole(path, &count);
    assert_int_equal(overwritten, 0);
    assert_true(fails ? settled == 0 : settled > 5);
  }
  folder_fails = false;
  assert_true(whole[0] == whole[1]);
}

/* ---------------------------------------------------------------- others at the file */

struct visit {
  const char *path, *other;
  int looks, fd; /* of a reader that holds no lock; -1: none yet */
  uint64_t bytes;
};

static uint64_t digest_bytes(int fd) {
  char room[4096];
  uint64_t digest = 0;
  ssize_t n;
  for (off_t at = 0; (n = pread(fd, room, sizeof room, at)) > 0; at += n)
    digest = digest_add(digest, room, (size_t)n);
  return digest;
}

static void put_other_in_place(void *self, const struct em_recorder_progress *progress) {
  struct visit *visit = self;
  (void)progress;
  if (++visit->looks == 4) assert_int_equal(syscall(SYS_rename, visit->other, visit->path), 0);
}

static void overwrite(void *self, const struct em_recorder_progress *progress) {
  struct visit *visit = self;
  (void)progress;
  if (++visit->looks == 4) {
    FILE *out = fopen(visit->path, "wb");
    assert_non_null(out);
    fclose(out);
  }
}

static void begin_reading(void *self, const struct em_recorder_progress *progress) {
  struct visit *visit = self;
  (void)progress;
  if (++visit->looks != 4) return;
  visit->fd = open(visit->path, O_RDONLY);
  assert_true(visit->fd >= 0);
  visit->bytes = digest_bytes(visit->fd);
}

static uint64_t record_visited(struct visit *visit,
                               void (*progress)(void *, const struct em_recorder_progress *)) {
  static const char *const overrides[] = {"duration=0.05", "balls.count=40"};
  struct em_scene *scene = digest_scene(SMALL_MILL, 2, overrides);
  const struct em_recorder_options options = {
      .path = visit->path, .force = true, .progress = progress, .self = visit};
  struct em_error err = {0};
  uint64_t digest = 0;
  if (em_recorder_run(scene, &options, NULL, NULL, &err)) fail_msg("%s", err.text);
  assert_int_equal(digest_run(visit->path, &digest, &err), EM_OK);
  em_scene_free(scene);
  return digest;
}

static void a_file_replaced_by_others_does_not_harm_the_run(void **state) {
  (void)state;
  long count;
  record_whole(path_of("other.h5"), &count);
  char path[256], other[256];
  snprintf(other, sizeof other, "%s", path_of("other.h5"));
  snprintf(path, sizeof path, "%s", path_of("visited.h5"));
  struct visit visit = {.path = path, .other = other, .fd = -1};
  const uint64_t whole = record_visited(&visit, NULL);
  assert_true(record_visited(&visit, put_other_in_place) == whole);
  visit.looks = 0;
  assert_true(record_visited(&visit, overwrite) == whole);
}

static void what_somebody_reads_stays_as_it_was(void **state) {
  (void)state;
  struct visit visit = {.path = path_of("read.h5"), .fd = -1};
  record_visited(&visit, begin_reading);
  assert_true(visit.looks > 6);
  if (fcntl(visit.fd, F_SETLEASE, F_RDLCK) != 0) skip(); /* none on this file system */
  assert_true(digest_bytes(visit.fd) == visit.bytes);
  close(visit.fd);
}

static int remove_folder(void **state) {
  (void)state;
  digest_folder_remove();
  return 0;
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(killed_at_any_call_the_file_is_valid_and_resumes),
      cmocka_unit_test(killed_when_resuming_it_goes_on),
      cmocka_unit_test(a_full_disk_is_an_error_and_the_file_stays_valid),
      cmocka_unit_test(a_crash_of_the_machine_finds_a_whole_file),
      cmocka_unit_test(a_file_replaced_by_others_does_not_harm_the_run),
      cmocka_unit_test(what_somebody_reads_stays_as_it_was),
  };
  return cmocka_run_group_tests(tests, NULL, remove_folder);
}
