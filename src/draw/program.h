/* Shader programs. */
#ifndef EM_DRAW_PROGRAM_H
#define EM_DRAW_PROGRAM_H

#include "draw/gl.h"
#include "eventmill/error.h"

/* Compiles and links; 0 on failure (EM_PICTURE, with the compiler's words). Both parts begin after
 * `common`. */
GLuint em_program_make(const struct em_gl *gl, const char *common, const char *vertex,
                       const char *fragment, struct em_error *err);

#endif
