/* An XDMF sidecar: a text file with which ParaView opens the frames of a run file, without a copy.
 */
#ifndef EVENTMILL_XDMF_H
#define EVENTMILL_XDMF_H

#include "eventmill/error.h"
#include "eventmill/run_file.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ParaView 5.11 has two families of readers, and no form suits both. */
enum em_xdmf_form {
  EM_XDMF_HYPERSLAB, /* for "XDMF Reader"; names the run file relative to the sidecar's folder
                        when it lies in the same one */
  EM_XDMF_SELECTION  /* for "Xdmf3 Reader"; names the run file by its absolute path */
};

/* Writes positions, velocities, spins (where the scene has them), radii, masses and species of all
 * frames. The file appears complete or not at all. Errors: EM_INPUT (no frames), EM_FILE. */
enum em_status em_xdmf_write(const struct em_run_file *file, const char *path,
                             enum em_xdmf_form form, struct em_error *err);

#ifdef __cplusplus
}
#endif

#endif
