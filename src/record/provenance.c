/* Who made a run: program, libraries, machine, times. */
#include "record/provenance.h"

#include <gsl/gsl_version.h>
#include <libconfig.h>
#include <stdio.h>
#include <string.h>
#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

#include "record/layout.h"
#include "version.h"

static void now(char *text, size_t size) {
  const time_t t = time(NULL);
  struct tm tm;
  gmtime_r(&t, &tm);
  strftime(text, size, "%Y-%m-%dT%H:%M:%SZ", &tm);
}

const char *em_provenance_version(void) {
  return EM_VERSION " (" EM_VERSION_GIT ")";
}

const char *em_provenance_compiler(void) {
  return EM_VERSION_COMPILER;
}

void em_provenance_libraries(char *text, size_t size) {
  unsigned major = 0, minor = 0, release = 0;
  H5get_libversion(&major, &minor, &release);
  snprintf(text, size, "HDF5 %u.%u.%u, GSL %s, libconfig %d.%d.%d", major, minor, release,
           gsl_version, LIBCONFIG_VER_MAJOR, LIBCONFIG_VER_MINOR, LIBCONFIG_VER_REVISION);
}

static double cpu_time(void) {
  struct rusage usage;
  if (getrusage(RUSAGE_SELF, &usage) != 0) return 0.0;
  return (double)(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
         1e-6 * (double)(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec);
}

void em_provenance_begin(struct em_run_session *session, const char *command, double from) {
  memset(session, 0, sizeof *session);
  snprintf(session->version, sizeof session->version, "%s", em_provenance_version());
  snprintf(session->compiler, sizeof session->compiler, "%s", em_provenance_compiler());
  snprintf(session->flags, sizeof session->flags, "%s", EM_VERSION_FLAGS);
  em_provenance_libraries(session->libraries, sizeof session->libraries);
  if (gethostname(session->host, sizeof session->host - 1) != 0)
    snprintf(session->host, sizeof session->host, "unknown");
  snprintf(session->command, sizeof session->command, "%s", command ? command : "");
  now(session->started, sizeof session->started);
  session->from = from;
}

void em_provenance_update(struct em_run_session *session, double wall, double to) {
  now(session->ended, sizeof session->ended);
  session->wall_time = wall;
  session->cpu_time = cpu_time();
  session->to = to;
}

static void path_of(size_t k, char *path, size_t size) {
  snprintf(path, size, EM_LAYOUT_SESSIONS "/%zu", k);
}

/* Name, member and room of each text. */
#define EACH_TEXT(X) \
  X(version) X(compiler) X(flags) X(libraries) X(host) X(command) X(started) X(ended)
#define EACH_NUMBER(X) X(wall_time) X(cpu_time) X(from) X(to)

bool em_provenance_write(hid_t file, size_t k, const struct em_run_session *session) {
  char path[128];
  path_of(k, path, sizeof path);
  bool good = em_h5_exists(file, path) || em_h5_group(file, path);
#define PUT(member) good = good && em_h5_put_text(file, path, #member, session->member);
  EACH_TEXT(PUT)
#undef PUT
#define PUT(member) good = good && em_h5_put_double(file, path, #member, session->member);
  EACH_NUMBER(PUT)
#undef PUT
  return good;
}

bool em_provenance_read(hid_t file, size_t k, struct em_run_session *session) {
  char path[128];
  path_of(k, path, sizeof path);
  bool good = true;
#define GET(member) \
  good = good && em_h5_get_text(file, path, #member, session->member, sizeof session->member);
  EACH_TEXT(GET)
#undef GET
#define GET(member) \
  good = good && em_h5_get_numbers(file, path, #member, H5T_NATIVE_DOUBLE, 0, &session->member);
  EACH_NUMBER(GET)
#undef GET
  return good;
}

size_t em_provenance_count(hid_t file) {
  char path[128];
  size_t k = 0;
  for (;; k++) {
    path_of(k, path, sizeof path);
    if (!em_h5_exists(file, path)) return k;
  }
}
