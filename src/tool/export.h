/* Frames, walls and collisions of a run in the formats of other programs. */
#ifndef EVENTMILL_EXPORT_H
#define EVENTMILL_EXPORT_H

#include <stddef.h>
#include <stdio.h>

#include "eventmill/error.h"
#include "eventmill/run_file.h"

/* What is asked for. */
struct em_export {
  const struct em_run_file *run;
  const char *out;     /* path; for a file per frame, "-0000" comes before its ending */
  size_t frames;       /* chosen frames */
  const size_t *frame; /* their indices, rising */
  double from, to;     /* s, of rows of the collision table */
};

/* A file that appears complete or not at all: it is written under another name first. */
struct em_export_file {
  FILE *out;
  char path[EM_SCENE_PATH], temporary[EM_SCENE_PATH + 16];
};

/* Errors: EM_FILE. close: `status` is that of the writing; on failure nothing is left behind. */
enum em_status em_export_file_open(struct em_export_file *file, const char *path,
                                   struct em_error *err);
enum em_status em_export_file_close(struct em_export_file *file, enum em_status status,
                                    struct em_error *err);

/* Puts "-0000" before the ending of a path; ending (with its dot; NULL: as it is) replaces it. */
void em_export_file_number(char *text, size_t size, const char *path, size_t number,
                           const char *ending);

/* Writes a little-endian float. */
void em_export_file_float(FILE *out, double x);

/* LAMMPS text dump of all chosen frames, for OVITO: id type x y z vx vy vz radius mass and, with
 * spins, omegax omegay omegaz. */
enum em_status em_export_text_lammps(const struct em_export *job, struct em_error *err);
/* One line per ball and frame; one line per collision. */
enum em_status em_export_text_frames(const struct em_export *job, struct em_error *err);
enum em_status em_export_text_collisions(const struct em_export *job, struct em_error *err);

/* A VTK PolyData file (.vtp) per frame, and a collection (.pvd) that gives their times. */
enum em_status em_export_vtk_write(const struct em_export *job, struct em_error *err);

/* A POV-Ray scene per frame: balls coloured by speed, glass drum, blades. */
enum em_status em_export_pov_write(const struct em_export *job, struct em_error *err);

/* The walls and the blades at the first chosen frame, as a binary STL surface in metres. */
enum em_status em_export_stl_write(const struct em_export *job, struct em_error *err);

#endif
