/* Ray-cast spheres. Seen from the eye, a sphere (centre c, radius r) is bounded by its tangent
 * cone, which touches it in a circle: centre c (1 − r²/c²), radius r √(1 − r²/c²). The square
 * around that circle, wider by a pixel, covers the silhouette, and nothing else needs rays. No
 * sphere is drawn smaller than a pixel: it would be lost between the pixels' middles. Rays start at
 * the square, so that the quadratic works with lengths of the size of r and loses no digits. A
 * pixel that the silhouette cuts is covered in part and lets through what is behind: spheres have
 * to come farthest first. Discs are spheres without light and shade. */
#include "draw/spheres.h"

#include <stddef.h>
#include <stdint.h>

#include "draw/light.h"
#include "draw/program.h"

static const char vertex[] =
    "layout(location = 0) in vec4 sphere;\n"
    "layout(location = 1) in vec4 occlusion;\n"
    "layout(location = 2) in vec4 colour;\n"
    "uniform mat4 view, projection;\n"
    "uniform int parallel;\n"
    "uniform float pixel;\n" /* its size, at the distance 1 where there is perspective */
    "flat out vec3 centre;\n"
    "flat out float radius;\n"
    "flat out vec4 shade;\n"
    "flat out vec3 base;\n"
    "out vec3 start;\n" /* from the centre to the square */
    "out vec2 place;\n" /* on the square; 1: the silhouette */
    "flat out int disc;\n"
    "void main() {\n"
    "  centre = (view * vec4(sphere.xyz, 1.0)).xyz;\n"
    "  float width = pixel * (parallel != 0 ? 1.0 : length(centre));\n"
    "  radius = max(sphere.w, 0.5 * width);\n"
    "  shade = vec4(mat3(view) * occlusion.xyz, occlusion.w);\n"
    "  base = colour.rgb * colour.rgb;\n"
    "  disc = colour.a < 0.5 ? 1 : 0;\n"
    "  vec3 back = parallel != 0 ? vec3(0, 0, 1) : -normalize(centre);\n"
    "  float q = parallel != 0 ? 0.0 : radius * radius / dot(centre, centre);\n"
    "  vec3 right = normalize(vec3(back.z, 0, -back.x));\n"
    "  vec3 up = cross(back, right);\n"
    "  float size = radius * sqrt(1.0 - min(q, 0.999));\n"
    "  place = (vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0 - 1.0) * (1.0 + width / size);\n"
    "  start = -q * centre + size * (place.x * right + place.y * up);\n"
    "  gl_Position = projection * vec4(centre + start, 1.0);\n"
    "}\n";

static const char fragment[] =
    "const float RIM = 0.7;\n"
    "flat in vec3 centre;\n"
    "flat in float radius;\n"
    "flat in vec4 shade;\n"
    "flat in vec3 base;\n"
    "in vec3 start;\n"
    "in vec2 place;\n"
    "flat in int disc;\n"
    "uniform mat4 projection;\n"
    "uniform int parallel;\n"
    "out vec4 colour;\n"
    "void main() {\n"
    "  float away = length(place);\n"
    "  vec2 way = place / max(away, 1e-6);\n"
    "  vec2 step = vec2(dot(way, dFdx(place)), dot(way, dFdy(place)));\n"
    "  float cover = clamp(0.5 + (1.0 - away) / length(step), 0.0, 1.0);\n"
    "  if (cover <= 0.0) discard;\n"
    "  vec3 u = parallel != 0 ? vec3(0, 0, -1) : normalize(centre + start);\n"
    "  float b = dot(start, u);\n"
    "  float root = sqrt(max(b * b - dot(start, start) + radius * radius, 0.0));\n"
    "  vec3 hit = start - (b + root) * u;\n"
    "  vec3 n = normalize(hit);\n"
    "  float open = 1.0 / (1.0 + 1.7 * max(shade.w + dot(shade.xyz, n), 0.0));\n"
    "  vec3 c = lit(base, n, -u, open, 0.16);\n"
    "  if (disc != 0) c = away < RIM ? base : vec3(1);\n"
    "  colour = vec4(min(sqrt(c), 1.0), 1.0) * cover;\n"
    "  float z = centre.z + hit.z;\n"
    "  float w = parallel != 0 ? 1.0 : -z;\n"
    "  gl_FragDepth = 0.5 + 0.5 * (projection[2][2] * z + projection[3][2]) / w;\n"
    "}\n";

static void describe(const struct em_gl *gl, GLuint index, GLint size, GLenum type, size_t offset) {
  gl->EnableVertexAttribArray(index);
  gl->VertexAttribPointer(index, size, type, type == GL_UNSIGNED_BYTE, sizeof(struct em_sphere),
                          (const void *)(uintptr_t)offset);
  gl->VertexAttribDivisor(index, 1);
}

enum em_status em_spheres_make(struct em_spheres *spheres, const struct em_gl *gl,
                               struct em_error *err) {
  spheres->program = em_program_make(gl, EM_LIGHT_GLSL, vertex, fragment, err);
  if (spheres->program == 0) return EM_PICTURE;
  spheres->view = gl->GetUniformLocation(spheres->program, "view");
  spheres->projection = gl->GetUniformLocation(spheres->program, "projection");
  spheres->parallel = gl->GetUniformLocation(spheres->program, "parallel");
  spheres->pixel = gl->GetUniformLocation(spheres->program, "pixel");
  gl->GenVertexArrays(1, &spheres->array);
  gl->GenBuffers(1, &spheres->buffer);
  gl->BindVertexArray(spheres->array);
  gl->BindBuffer(GL_ARRAY_BUFFER, spheres->buffer);
  describe(gl, 0, 4, GL_FLOAT, offsetof(struct em_sphere, place));
  describe(gl, 1, 4, GL_FLOAT, offsetof(struct em_sphere, occlusion));
  describe(gl, 2, 4, GL_UNSIGNED_BYTE, offsetof(struct em_sphere, rgba));
  return EM_OK;
}

void em_spheres_draw(const struct em_spheres *spheres, const struct em_gl *gl,
                     const struct em_camera_aim *aim, const struct em_sphere *sphere,
                     size_t count) {
  if (count == 0) return;
  gl->UseProgram(spheres->program);
  gl->UniformMatrix4fv(spheres->view, 1, GL_FALSE, aim->view);
  gl->UniformMatrix4fv(spheres->projection, 1, GL_FALSE, aim->projection);
  gl->Uniform1i(spheres->parallel, aim->parallel);
  gl->Uniform1f(spheres->pixel, 2.0F / (aim->projection[5] * (float)aim->height));
  gl->BindVertexArray(spheres->array);
  gl->BindBuffer(GL_ARRAY_BUFFER, spheres->buffer);
  gl->BufferData(GL_ARRAY_BUFFER, (GLsizeiptr)(count * sizeof *sphere), sphere, GL_STREAM_DRAW);
  gl->Enable(GL_BLEND);
  gl->BlendFunc(GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  gl->DrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, (GLsizei)count);
  gl->Disable(GL_BLEND);
}

void em_spheres_clear(struct em_spheres *spheres, const struct em_gl *gl) {
  if (spheres->array != 0) gl->DeleteVertexArrays(1, &spheres->array);
  if (spheres->buffer != 0) gl->DeleteBuffers(1, &spheres->buffer);
  if (spheres->program != 0) gl->DeleteProgram(spheres->program);
}
