/* Compiles and links shaders, and hands on what the compiler has to say. */
#include "draw/program.h"

#include <stddef.h>

static GLuint compile(const struct em_gl *gl, GLenum kind, const char *common, const char *text,
                      struct em_error *err) {
  const char *part[] = {common, text};
  const GLuint shader = gl->CreateShader(kind);
  gl->ShaderSource(shader, 2, part, NULL);
  gl->CompileShader(shader);
  GLint done = 0;
  gl->GetShaderiv(shader, GL_COMPILE_STATUS, &done);
  if (done) return shader;
  char log[1024] = "";
  gl->GetShaderInfoLog(shader, sizeof log, NULL, log);
  em_error_set(err, EM_PICTURE, NULL, 0, "a shader does not compile: %s", log);
  gl->DeleteShader(shader);
  return 0;
}

GLuint em_program_make(const struct em_gl *gl, const char *common, const char *vertex,
                       const char *fragment, struct em_error *err) {
  const GLuint v = compile(gl, GL_VERTEX_SHADER, common, vertex, err);
  if (v == 0) return 0;
  const GLuint f = compile(gl, GL_FRAGMENT_SHADER, common, fragment, err);
  if (f == 0) {
    gl->DeleteShader(v);
    return 0;
  }
  const GLuint program = gl->CreateProgram();
  gl->AttachShader(program, v);
  gl->AttachShader(program, f);
  gl->LinkProgram(program);
  gl->DeleteShader(v);
  gl->DeleteShader(f);
  GLint done = 0;
  gl->GetProgramiv(program, GL_LINK_STATUS, &done);
  if (done) return program;
  char log[1024] = "";
  gl->GetProgramInfoLog(program, sizeof log, NULL, log);
  em_error_set(err, EM_PICTURE, NULL, 0, "a shader program does not link: %s", log);
  gl->DeleteProgram(program);
  return 0;
}
