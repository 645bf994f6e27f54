/* millpost export: frames, walls and collisions for ParaView, OVITO, POV-Ray and others. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "eventmill/xdmf.h"
#include "tool/export.h"
#include "tool/millpost.h"

static const char *const option_names[] = {"to-format", "what",  "first",  "until",
                                           "at",        "every", "result", ""};

static const struct em_millpost_help help = {
    .name = "export",
    .arguments = "RUN --to FORMAT",
    .summary = "Writes a run in the format of another program.",
    .details =
        "  xdmf    a small text file with which ParaView opens the run file itself (\"XDMF "
        "Reader\")\n"
        "  xdmf3   the same for ParaView's \"Xdmf3 Reader\"\n"
        "  vtk     VTK PolyData, one file per frame, and a .pvd with their times\n"
        "  lammps  a text dump of all frames, for OVITO\n"
        "  csv     a line per ball and frame; with --of collisions, a line per collision\n"
        "  pov     a POV-Ray scene per frame\n"
        "  stl     walls and blades at the first frame, in metres\n"
        "--from, --until, --every and --at choose frames (xdmf takes all); the default is all. "
        "Of\n"
        "collisions, --from and --until choose those of a stretch of time.\n"
        "Without -o, the output stands beside the run and has its name.",
    .examples = "  millpost export simoloyer-2l.h5 --to xdmf\n"
                "  millpost export simoloyer-2l.h5 --to lammps --every 5 -o mill.dump\n"
                "  millpost export simoloyer-2l.h5 --to pov --at 0.5 -o mill.pov && povray +W1280 "
                "+H720 mill.pov",
    .options = option_names,
    .least = 1,
    .most = 1,
};

static enum em_status write_xdmf(const struct em_export *job, struct em_error *err) {
  return em_xdmf_write(job->run, job->out, EM_XDMF_HYPERSLAB, err);
}

static enum em_status write_xdmf3(const struct em_export *job, struct em_error *err) {
  return em_xdmf_write(job->run, job->out, EM_XDMF_SELECTION, err);
}

#define NAME(code, name) name,
static const char *const names[] = {EM_EXPORT_LIST(NAME)};

static const struct format {
  enum em_export_format which;
  const char *ending;
  bool needs_frames;
  enum em_status (*write)(const struct em_export *job, struct em_error *err);
} formats[EM_EXPORT_FORMATS] = {
    [EM_EXPORT_XDMF] = {EM_EXPORT_XDMF, ".xdmf", true, write_xdmf},
    [EM_EXPORT_XDMF3] = {EM_EXPORT_XDMF3, ".xdmf", true, write_xdmf3},
    [EM_EXPORT_VTK] = {EM_EXPORT_VTK, ".pvd", true, em_export_vtk_write},
    [EM_EXPORT_LAMMPS] = {EM_EXPORT_LAMMPS, ".dump", true, em_export_text_lammps},
    [EM_EXPORT_CSV] = {EM_EXPORT_CSV, ".csv", true, em_export_text_frames},
    [EM_EXPORT_POV] = {EM_EXPORT_POV, ".pov", true, em_export_pov_write},
    [EM_EXPORT_STL] = {EM_EXPORT_STL, ".stl", false, em_export_stl_write},
};

static const struct format collisions = {EM_EXPORT_CSV, ".csv", false, em_export_text_collisions};

static const struct format *find_format(const struct em_millpost_options *o) {
  for (int k = 0; o->to_format && k < EM_EXPORT_FORMATS; k++) {
    if (strcmp(names[k], o->to_format) != 0) continue;
    return o->of && k == EM_EXPORT_CSV ? &collisions : &formats[k];
  }
  return NULL;
}

static size_t nearest(const struct em_run_file *run, double time) {
  const size_t k = em_run_file_frame_before(run, time), next = k + 1;
  if (next == em_run_file_frame_count(run)) return k;
  const double before = time - em_run_file_frame_time(run, k);
  return em_run_file_frame_time(run, next) - time < before ? next : k;
}

/* Times that are given as printed, in nine digits, may lie beside those of their frames. */
static const double PRINTED = 5e-9;

/* Indices of the chosen frames; returns how many there are. */
static size_t choose(size_t *chosen, const struct em_run_file *run,
                     const struct em_millpost_options *o) {
  const size_t frames = em_run_file_frame_count(run), every = o->every ? (size_t)o->every : 1;
  size_t seen = 0, count = 0;
  if (!isnan(o->at) && frames > 0) {
    chosen[0] = nearest(run, o->at);
    return 1;
  }
  for (size_t k = 0; k < frames; k++) {
    const double t = em_run_file_frame_time(run, k), slack = PRINTED * t;
    if (t + slack < o->from || t - slack > o->to) continue; /* NAN: no bound */
    if (seen++ % every == 0) chosen[count++] = k;
  }
  return count;
}

/* Is what the options ask for there? chosen: frames. */
static enum em_status check(const struct em_run_file *run, const struct format *format,
                            const struct em_millpost_options *o, size_t chosen,
                            struct em_error *err) {
  const size_t frames = em_run_file_frame_count(run);
  const double first = frames > 0 ? em_run_file_frame_time(run, 0) : NAN;
  const double last = frames > 0 ? em_run_file_frame_time(run, frames - 1) : NAN;
  const double slack = 1e-9 * (1.0 + fabs(last));
  if (o->at < first - slack || o->at > last + slack)
    return em_error_set(err, EM_INPUT, o->run[0], 0, "--at %g: the run has frames from %g to %g s",
                        o->at, first, last);
  const bool asked = !isnan(o->at) || !isnan(o->from) || !isnan(o->to);
  if (chosen == 0 && (format->needs_frames || (asked && format != &collisions)))
    return em_error_set(err, EM_INPUT, o->run[0], 0, "no frame is chosen; the run has %zu", frames);
  return EM_OK;
}

/* Bytes that names of frames may have more than the output's: a number and another ending. */
enum { MORE = 32 };

/* Beside the run, whose name is shorter than EM_SCENE_PATH, or it would not have been opened. */
static void default_path(char *path, size_t size, const char *run, const char *ending) {
  const size_t length = strlen(run);
  const bool h5 = length > 3 && strcmp(run + length - 3, ".h5") == 0;
  snprintf(path, size, "%.*s%s", (int)(h5 ? length - 3 : length), run, ending);
}

static int run_with(const struct em_run_file *run, const struct format *format,
                    const struct em_millpost_options *o) {
  struct em_error err = {.code = EM_OK};
  char path[EM_SCENE_PATH + MORE];
  struct em_export job = {.run = run, .out = o->out ? o->out : path};
  default_path(path, sizeof path, o->run[0], format->ending);
  if (strlen(job.out) >= EM_SCENE_PATH - MORE)
    return em_millpost_usage("export", "'%s': the path is too long, expected at most %d bytes",
                             job.out, EM_SCENE_PATH - MORE - 1);
  job.from = isnan(o->from) ? 0.0 : o->from;
  job.to = isnan(o->to) ? INFINITY : o->to;
  size_t *frame = malloc((em_run_file_frame_count(run) + 1) * sizeof *frame);
  enum em_status status = EM_OK;
  if (frame) {
    job.frame = frame;
    job.frames = choose(frame, run, o);
    status = check(run, format, o, job.frames, &err);
  } else {
    status = em_error_set(&err, EM_MEMORY, NULL, 0, "out of memory");
  }
  if (status == EM_OK) status = format->write(&job, &err);
  free(frame);
  if (status != EM_OK) return em_millpost_fail(&err);
  struct em_report *report = em_report_new("export");
  em_report_fact_text(report, "format", "format", "%s", names[format->which]);
  em_report_fact_text(report, "file", "written", "%s", job.out);
  const bool all = format->which == EM_EXPORT_XDMF || format->which == EM_EXPORT_XDMF3;
  if (format->needs_frames)
    em_report_fact_count(report, "frames", "frames",
                         all ? em_run_file_frame_count(run) : job.frames);
  return em_millpost_print(report, o, EM_MILLPOST_DONE);
}

int em_millpost_export(int argc, char **argv) {
  struct em_millpost_options options;
  int code = em_millpost_options(&options, &help, argc, argv);
  if (code >= 0) return code;
  const struct format *format = find_format(&options);
  if (!format)
    return em_millpost_usage("export", "--to must be one of:" EM_EXPORT_LIST(EM_MILLPOST_WORD));
  if (options.of && (format != &collisions || strcmp(options.of, "collisions") != 0))
    return em_millpost_usage("export", "--of takes only 'collisions', with --to csv");
  if (options.of && (!isnan(options.at) || options.every))
    return em_millpost_usage("export", "--at and --every choose frames, --of collisions has none");
  struct em_error err = {.code = EM_OK};
  struct em_run_file *run;
  if (em_millpost_open(&run, options.run[0], &err) != EM_OK) return em_millpost_fail(&err);
  code = run_with(run, format, &options);
  em_run_file_close(run);
  return code;
}
