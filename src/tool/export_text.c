/* Frames and collisions as text: LAMMPS dump (OVITO) and CSV. */
#include "record/output.h"
#include "tool/export.h"

static bool has_spin(const struct em_export *job) {
  return (em_scene_effects(em_run_file_scene(job->run)) & EM_EFFECT_SPIN) != 0;
}

static void lammps_header(FILE *out, const struct em_export *job, size_t frame, size_t count) {
  const struct em_scene *scene = em_run_file_scene(job->run);
  const bool box = scene->chamber.shape == EM_SHAPE_BOX;
  struct em_vec low, high;
  em_scene_extent(scene, &low, &high);
  fprintf(out,
          "ITEM: UNITS\nsi\nITEM: TIME\n%.17g\nITEM: TIMESTEP\n%zu\nITEM: NUMBER OF ATOMS\n%zu\n",
          em_run_file_frame_time(job->run, frame), frame, count);
  fprintf(out, "ITEM: BOX BOUNDS");
  for (int d = 0; d < 3; d++)
    fprintf(out, " %s", box && scene->chamber.periodic[d] ? "pp" : "ff");
  fprintf(out, "\n%.17g %.17g\n%.17g %.17g\n%.17g %.17g\n", low.x, high.x, low.y, high.y, low.z,
          high.z);
  fprintf(out, "ITEM: ATOMS id type x y z vx vy vz radius mass%s\n",
          has_spin(job) ? " omegax omegay omegaz" : "");
}

static void lammps_ball(FILE *out, const struct em_balls *b, size_t i, bool spin) {
  const struct em_vec r = b->position[i], v = b->velocity[i], w = b->spin[i];
  fprintf(out, "%zu %d %.9g %.9g %.9g %.9g %.9g %.9g %.9g %.9g", i + 1, b->species[i] + 1, r.x, r.y,
          r.z, v.x, v.y, v.z, b->radius[i], b->mass[i]);
  if (spin) fprintf(out, " %.9g %.9g %.9g", w.x, w.y, w.z);
  fputc('\n', out);
}

static void csv_ball(FILE *out, const struct em_balls *b, size_t i, bool spin, double time) {
  const struct em_vec r = b->position[i], v = b->velocity[i], w = b->spin[i];
  fprintf(out, "%.9g,%zu,%d,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g", time, i, b->species[i], r.x,
          r.y, r.z, v.x, v.y, v.z, b->radius[i], b->mass[i]);
  if (spin) fprintf(out, ",%.9g,%.9g,%.9g", w.x, w.y, w.z);
  fputc('\n', out);
}

/* All chosen frames into one file, in one of the two forms. */
static enum em_status write_frames(FILE *out, const struct em_export *job, bool lammps,
                                   struct em_error *err) {
  const bool spin = has_spin(job);
  struct em_balls *balls = NULL;
  enum em_status status = em_run_file_balls(job->run, &balls, err);
  if (!lammps)
    fprintf(out,
            "time [s],ball,species,x [m],y [m],z [m],vx [m/s],vy [m/s],vz [m/s],radius [m],"
            "mass [kg]%s\n",
            spin ? ",spin_x [rad/s],spin_y [rad/s],spin_z [rad/s]" : "");
  for (size_t k = 0; k < job->frames && status == EM_OK; k++) {
    status = em_run_file_frame(job->run, job->frame[k], balls, err);
    if (status != EM_OK) break;
    if (lammps) lammps_header(out, job, job->frame[k], balls->count);
    const double time = em_run_file_frame_time(job->run, job->frame[k]);
    for (size_t i = 0; i < balls->count; i++) {
      if (lammps)
        lammps_ball(out, balls, i, spin);
      else
        csv_ball(out, balls, i, spin, time);
    }
  }
  em_start_free(balls);
  return status;
}

static enum em_status export_frames(const struct em_export *job, bool lammps,
                                    struct em_error *err) {
  struct em_output file;
  enum em_status status = em_output_begin(&file, job->out, EM_OUTPUT_STREAM, err);
  if (status != EM_OK) return status;
  status = write_frames(file.out, job, lammps, err);
  return em_output_end(&file, status, err);
}

enum em_status em_export_text_lammps(const struct em_export *job, struct em_error *err) {
  return export_frames(job, true, err);
}

enum em_status em_export_text_frames(const struct em_export *job, struct em_error *err) {
  return export_frames(job, false, err);
}

static void csv_row(FILE *out, const struct em_rows *r, size_t k) {
  const int cls = r->cls[k];
  fprintf(out, "%.17g,%s,%u,%u,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g\n", r->time[k],
          cls < EM_CLASS_COUNT ? em_contact_class_name((enum em_class)cls) : "?", r->ball[k],
          r->partner[k], (double)r->place[k][0], (double)r->place[k][1], (double)r->place[k][2],
          (double)r->normal[k][0], (double)r->normal[k][1], (double)r->normal[k][2],
          (double)r->vn[k], (double)r->vt[k], (double)r->lost[k]);
}

static enum em_status write_rows(FILE *out, const struct em_export *job, struct em_error *err) {
  struct em_rows *rows = em_run_file_rows_new(EM_COLUMN_ALL);
  if (!rows) return em_error_set(err, EM_MEMORY, NULL, 0, "out of memory");
  fprintf(out, "time [s],class,ball,partner,x [m],y [m],z [m],normal_x,normal_y,normal_z,vn [m/s],"
               "vt [m/s],lost [J]\n");
  enum em_status status = EM_OK;
  bool any = false;
  for (uint64_t first = 0; status == EM_OK; first += rows->count) {
    status = em_run_file_rows(job->run, first, rows, err);
    if (status != EM_OK || rows->count == 0 || rows->time[0] > job->to) break;
    for (size_t k = 0; k < rows->count; k++) {
      if (rows->time[k] < job->from || rows->time[k] > job->to) continue;
      csv_row(out, rows, k);
      any = true;
    }
  }
  em_run_file_rows_free(rows);
  if (status == EM_OK && !any)
    status = em_error_set(err, EM_INPUT, em_run_file_path(job->run), 0,
                          "no collision is chosen; the run has %llu, until %g s",
                          (unsigned long long)em_run_file_row_count(job->run),
                          em_run_file_state(job->run)->time);
  return status;
}

enum em_status em_export_text_collisions(const struct em_export *job, struct em_error *err) {
  if (!em_run_file_has_rows(job->run))
    return em_error_set(err, EM_INPUT, em_run_file_path(job->run), 0,
                        "there is no collision table: run with record.collisions=true");
  struct em_output file;
  enum em_status status = em_output_begin(&file, job->out, EM_OUTPUT_STREAM, err);
  if (status != EM_OK) return status;
  status = write_rows(file.out, job, err);
  return em_output_end(&file, status, err);
}
