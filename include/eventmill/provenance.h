/* What this build is, and what it runs with. */
#ifndef EVENTMILL_PROVENANCE_H
#define EVENTMILL_PROVENANCE_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

const char *em_provenance_version(void); /* with the repository's state: "0.1.0 (1a2b3c4)" */
const char *em_provenance_compiler(void);

/* Names and versions of the libraries (HDF5, GSL: those that are loaded), cut to `size` bytes. */
void em_provenance_libraries(char *text, size_t size);

#ifdef __cplusplus
}
#endif

#endif
