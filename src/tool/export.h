/* Frames, walls and collisions of a run in the formats of other programs. */
#ifndef EVENTMILL_EXPORT_H
#define EVENTMILL_EXPORT_H

#include <stddef.h>
#include <stdio.h>

#include "eventmill/error.h"
#include "eventmill/run_file.h"

#define EM_EXPORT_LIST(X) \
  X(XDMF, "xdmf")         \
  X(XDMF3, "xdmf3")       \
  X(VTK, "vtk")           \
  X(LAMMPS, "lammps")     \
  X(CSV, "csv")           \
  X(POV, "pov")           \
  X(STL, "stl")
#define EM_EXPORT_ENUM(code, name) EM_EXPORT_##code,
enum em_export_format { EM_EXPORT_LIST(EM_EXPORT_ENUM) EM_EXPORT_FORMATS };
#undef EM_EXPORT_ENUM

/* What is asked for. */
struct em_export {
  const struct em_run_file *run;
  const char *out;     /* path; for a file per frame, "-0000" comes before its ending */
  size_t frames;       /* chosen frames */
  const size_t *frame; /* their indices, rising */
  double from, to;     /* s, of rows of the collision table */
};

/* The name of the file of chosen frame k, with another ending unless that is NULL. */
void em_export_file_name(char *text, size_t size, const struct em_export *job, size_t k,
                         const char *ending);

/* Removes the files of the first `count` chosen frames, when a later one cannot be written. */
void em_export_file_remove(const struct em_export *job, size_t count, const char *ending);

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
