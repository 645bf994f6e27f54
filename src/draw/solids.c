/* Builds and draws the machine around the balls. The model has no shaft that balls could touch; a
 * thin one is drawn because the machine has it. */
#include "draw/solids.h"

#include <assert.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "draw/light.h"
#include "draw/mesh.h"
#include "draw/program.h"

enum { ROUND = 192 }; /* more sides of a drum cannot be told from a round one */

enum material { BLADE, SHAFT, RING, GLASS };

struct em_part {
  enum material material;
  GLint first;
  GLsizei count;
  const struct em_blade *blade; /* turns with this blade; NULL: stands */
};

static const float colour_of[][3] = {
    [BLADE] = {0.80F, 0.80F, 0.82F},
    [SHAFT] = {0.66F, 0.67F, 0.70F},
    [RING] = {0.56F, 0.59F, 0.63F},
    [GLASS] = {0.45F, 0.55F, 0.64F},
};

static const char vertex[] = "layout(location = 0) in vec3 place;\n"
                             "layout(location = 1) in vec3 normal;\n"
                             "uniform mat4 model, view, projection;\n"
                             "out vec3 at, n;\n"
                             "void main() {\n"
                             "  mat4 all = view * model;\n"
                             "  vec4 p = all * vec4(place, 1.0);\n"
                             "  at = p.xyz;\n"
                             "  n = mat3(all) * normal;\n"
                             "  gl_Position = projection * p;\n"
                             "}\n";

static const char fragment[] = "in vec3 at, n;\n"
                               "uniform vec3 base;\n"
                               "uniform int glass, parallel;\n"
                               "out vec4 colour;\n"
                               "void main() {\n"
                               "  vec3 v = parallel != 0 ? vec3(0, 0, 1) : normalize(-at);\n"
                               "  vec3 m = normalize(n);\n"
                               "  if (dot(m, v) < 0.0) m = -m;\n"
                               "  if (glass == 0) {\n"
                               "    colour = vec4(sqrt(lit(base * base, m, v, 1.0, 0.35)), 1.0);\n"
                               "  } else {\n"
                               "    float edge = 1.0 - dot(m, v);\n"
                               "    float alpha = 0.035 + 0.42 * edge * edge * edge;\n"
                               "    float s = max(dot(m, normalize(KEY + v)), 0.0);\n"
                               "    s *= s; s *= s; s *= s; s *= s; s *= s; s *= s; s *= s;\n"
                               "    colour = vec4(base * alpha, alpha) + vec4(0.07 * s);\n"
                               "  }\n"
                               "}\n";

struct builder {
  struct em_solids *solids;
  struct em_mesh mesh;
  size_t room;
};

/* All vertices since the last part become a part. */
static void finish_part(struct builder *b, enum material material, const struct em_blade *blade) {
  struct em_solids *s = b->solids;
  if (s->part_count == b->room) {
    b->mesh.failed = true;
    return;
  }
  assert(s->part != NULL);
  const struct em_part *last = s->part_count ? &s->part[s->part_count - 1] : NULL;
  const GLint first = last ? last->first + last->count : 0;
  s->part[s->part_count++] =
      (struct em_part){material, first, (GLsizei)b->mesh.count - first, blade};
}

static void add_blade(struct builder *b, const struct em_blade *blade) {
  const struct em_mesh_axis axis = {{0, 0, 0}, {0, 0, 1}, 0};
  if (blade->tip == EM_TIP_HEMISPHERE && blade->reach > blade->radius)
    em_mesh_capsule(&b->mesh, &axis, blade->radius, -blade->reach, blade->reach);
  else
    em_mesh_bar(&b->mesh, &axis, blade->radius, -blade->reach, blade->reach);
  finish_part(b, BLADE, blade);
}

/* Where the line point + s·axis is inside [low, high]. */
static bool clip(struct em_vec point, struct em_vec axis, struct em_vec low, struct em_vec high,
                 double *from, double *to) {
  const double p[] = {point.x, point.y, point.z}, d[] = {axis.x, axis.y, axis.z};
  const double l[] = {low.x, low.y, low.z}, h[] = {high.x, high.y, high.z};
  *from = -INFINITY;
  *to = INFINITY;
  for (int k = 0; k < 3; k++) {
    if (fabs(d[k]) < 1e-12) {
      if (p[k] < l[k] || p[k] > h[k]) return false;
      continue;
    }
    const double s = (l[k] - p[k]) / d[k], t = (h[k] - p[k]) / d[k];
    *from = fmax(*from, fmin(s, t));
    *to = fmin(*to, fmax(s, t));
  }
  return *from < *to && isfinite(*from) && isfinite(*to);
}

/* How far the end rings stand out along the axis. */
static double ring_thickness(const struct em_scene *scene) {
  return 0.022 * scene->chamber.diameter;
}

static void add_rotor(struct builder *b, const struct em_scene *scene,
                      const struct em_rotor *rotor) {
  struct em_vec low, high;
  double from, to, radius = 0.0;
  for (size_t k = 0; k < rotor->blade_count; k++) {
    add_blade(b, &rotor->blade[k]);
    radius = fmax(radius, 0.6 * rotor->blade[k].radius);
  }
  em_scene_extent(scene, &low, &high);
  if (radius <= 0.0 || !clip(rotor->point, rotor->axis, low, high, &from, &to)) return;
  const double out = scene->chamber.shape == EM_SHAPE_DRUM ? 2.0 * ring_thickness(scene) : 0.0;
  const struct em_mesh_axis axis = {rotor->point, rotor->axis, 0};
  em_mesh_bar(&b->mesh, &axis, radius, from - out, to + out);
  finish_part(b, SHAFT, NULL);
}

static void add_drum(struct builder *b, const struct em_scene *scene) {
  const double r = 0.5 * scene->chamber.diameter, l = scene->chamber.length;
  const double thick = ring_thickness(scene);
  const int facets = scene->chamber.facets <= ROUND ? scene->chamber.facets : 0;
  const struct em_mesh_axis axis = {{0, 0, 0}, {0, 1, 0}, facets};
  em_mesh_ring(&b->mesh, &axis, r, 1.045 * r, -thick, 0.0);
  em_mesh_ring(&b->mesh, &axis, r, 1.045 * r, l, l + thick);
  finish_part(b, RING, NULL);
  em_mesh_revolve(&b->mesh, &axis, (struct em_mesh_profile){r, 0.0, 1, 0},
                  (struct em_mesh_profile){r, l, 1, 0}, ROUND);
  finish_part(b, GLASS, NULL);
}

static double *component(struct em_vec *v, int k) {
  return k == 0 ? &v->x : k == 1 ? &v->y : &v->z;
}

static void add_box(struct builder *b, const struct em_scene *scene) {
  struct em_vec low, high;
  em_scene_extent(scene, &low, &high);
  const struct em_vec size = em_vec_sub(high, low);
  const double r = 0.004 * fmax(size.x, fmax(size.y, size.z));
  for (int k = 0; k < 3; k++) {
    for (int corner = 0; corner < 4; corner++) {
      struct em_mesh_axis axis = {low, {0, 0, 0}, 0};
      struct em_vec extent = size;
      *component(&axis.along, k) = 1.0;
      if (corner & 1) *component(&axis.origin, (k + 1) % 3) += *component(&extent, (k + 1) % 3);
      if (corner & 2) *component(&axis.origin, (k + 2) % 3) += *component(&extent, (k + 2) % 3);
      em_mesh_capsule(&b->mesh, &axis, r, -r, *component(&extent, k) + r);
    }
  }
  finish_part(b, RING, NULL);
  const struct em_vec x = {size.x, 0, 0}, y = {0, size.y, 0}, z = {0, 0, size.z};
  em_mesh_quad(&b->mesh, low, y, x);
  em_mesh_quad(&b->mesh, low, z, y);
  em_mesh_quad(&b->mesh, low, x, z);
  em_mesh_quad(&b->mesh, em_vec_add(low, z), x, y);
  em_mesh_quad(&b->mesh, em_vec_add(low, x), y, z);
  em_mesh_quad(&b->mesh, em_vec_add(low, y), z, x);
  finish_part(b, GLASS, NULL);
}

static void send(struct em_solids *solids, const struct em_gl *gl, const struct em_mesh *mesh) {
  gl->GenVertexArrays(1, &solids->array);
  gl->GenBuffers(1, &solids->buffer);
  gl->BindVertexArray(solids->array);
  gl->BindBuffer(GL_ARRAY_BUFFER, solids->buffer);
  gl->BufferData(GL_ARRAY_BUFFER, (GLsizeiptr)(mesh->count * sizeof *mesh->vertex), mesh->vertex,
                 GL_STATIC_DRAW);
  gl->EnableVertexAttribArray(0);
  gl->VertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, sizeof *mesh->vertex, NULL);
  gl->EnableVertexAttribArray(1);
  gl->VertexAttribPointer(1, 3, GL_FLOAT, GL_FALSE, sizeof *mesh->vertex,
                          (const void *)(uintptr_t)offsetof(struct em_mesh_vertex, normal));
}

enum em_status em_solids_make(struct em_solids *solids, const struct em_gl *gl,
                              const struct em_scene *scene, bool rotor, bool chamber,
                              struct em_error *err) {
  struct builder b = {.solids = solids};
  memset(solids, 0, sizeof *solids);
  b.room = 2 + em_scene_blade_count(scene) + scene->rotor_count;
  solids->part = calloc(b.room, sizeof *solids->part);
  b.mesh.failed = solids->part == NULL;
  for (size_t k = 0; rotor && !b.mesh.failed && k < scene->rotor_count; k++)
    add_rotor(&b, scene, &scene->rotor[k]);
  if (chamber && !b.mesh.failed) {
    if (scene->chamber.shape == EM_SHAPE_DRUM)
      add_drum(&b, scene);
    else
      add_box(&b, scene);
  }
  if (b.mesh.failed) {
    em_mesh_clear(&b.mesh);
    em_solids_clear(solids, gl);
    return em_error_set(err, EM_MEMORY, NULL, 0, "no memory for the machine's surfaces");
  }
  send(solids, gl, &b.mesh);
  em_mesh_clear(&b.mesh);
  solids->program = em_program_make(gl, EM_LIGHT_GLSL, vertex, fragment, err);
  if (solids->program == 0) {
    em_solids_clear(solids, gl);
    return EM_PICTURE;
  }
  solids->model = gl->GetUniformLocation(solids->program, "model");
  solids->view = gl->GetUniformLocation(solids->program, "view");
  solids->projection = gl->GetUniformLocation(solids->program, "projection");
  solids->parallel = gl->GetUniformLocation(solids->program, "parallel");
  solids->colour = gl->GetUniformLocation(solids->program, "base");
  solids->glass = gl->GetUniformLocation(solids->program, "glass");
  return EM_OK;
}

/* The blade's own frame in the scene: its z along the bar, its y along the rotor's axis. */
static void place_blade(const struct em_blade *blade, double angle, float m[16]) {
  const struct em_vec e2 = em_vec_cross(blade->axis, blade->e1);
  const struct em_vec z = em_vec_axpy(em_vec_scale(cos(angle), blade->e1), sin(angle), e2);
  const struct em_vec column[4] = {em_vec_cross(blade->axis, z), blade->axis, z, blade->centre};
  for (int k = 0; k < 4; k++) {
    m[4 * k] = (float)column[k].x;
    m[4 * k + 1] = (float)column[k].y;
    m[4 * k + 2] = (float)column[k].z;
    m[4 * k + 3] = k == 3 ? 1.0F : 0.0F;
  }
}

static void draw_part(const struct em_solids *solids, const struct em_gl *gl,
                      const struct em_part *part, const float model[16]) {
  const float *c = colour_of[part->material];
  gl->UniformMatrix4fv(solids->model, 1, GL_FALSE, model);
  gl->Uniform3f(solids->colour, c[0], c[1], c[2]);
  gl->DrawArrays(GL_TRIANGLES, part->first, part->count);
}

static void begin(const struct em_solids *solids, const struct em_gl *gl,
                  const struct em_camera_aim *aim, int glass) {
  gl->UseProgram(solids->program);
  gl->BindVertexArray(solids->array);
  gl->UniformMatrix4fv(solids->view, 1, GL_FALSE, aim->view);
  gl->UniformMatrix4fv(solids->projection, 1, GL_FALSE, aim->projection);
  gl->Uniform1i(solids->parallel, aim->parallel);
  gl->Uniform1i(solids->glass, glass);
}

static const float stand[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};

void em_solids_draw_metal(const struct em_solids *solids, const struct em_gl *gl,
                          const struct em_camera_aim *aim, const double *blade_angle) {
  size_t blade = 0;
  begin(solids, gl, aim, 0);
  gl->Enable(GL_CULL_FACE);
  gl->CullFace(GL_BACK);
  for (size_t k = 0; k < solids->part_count; k++) {
    const struct em_part *part = &solids->part[k];
    if (part->material == GLASS) continue;
    float model[16];
    if (part->blade != NULL)
      place_blade(part->blade, blade_angle != NULL ? blade_angle[blade++] : part->blade->angle,
                  model);
    draw_part(solids, gl, part, part->blade != NULL ? model : stand);
  }
  gl->Disable(GL_CULL_FACE);
}

void em_solids_draw_glass(const struct em_solids *solids, const struct em_gl *gl,
                          const struct em_camera_aim *aim) {
  begin(solids, gl, aim, 1);
  gl->Enable(GL_BLEND);
  gl->BlendFunc(GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  gl->DepthMask(GL_FALSE);
  gl->Enable(GL_CULL_FACE);
  for (int pass = 0; pass < 2; pass++) {
    gl->CullFace(pass == 0 ? GL_FRONT : GL_BACK);
    for (size_t k = 0; k < solids->part_count; k++)
      if (solids->part[k].material == GLASS) draw_part(solids, gl, &solids->part[k], stand);
  }
  gl->Disable(GL_CULL_FACE);
  gl->DepthMask(GL_TRUE);
  gl->Disable(GL_BLEND);
}

size_t em_solids_outline(const struct em_scene *scene, struct em_vec point[EM_SOLIDS_OUTLINE]) {
  struct em_vec low, high;
  em_scene_extent(scene, &low, &high);
  if (scene->chamber.shape != EM_SHAPE_DRUM) {
    for (int k = 0; k < 8; k++)
      point[k] =
          em_vec_make(k & 1 ? high.x : low.x, k & 2 ? high.y : low.y, k & 4 ? high.z : low.z);
    return 8;
  }
  const double r = 1.045 * em_scene_reach(scene), thick = ring_thickness(scene);
  const int facets = scene->chamber.facets;
  const bool corners = facets > 0 && facets <= EM_SOLIDS_OUTLINE / 2;
  const int count = corners ? facets : EM_SOLIDS_OUTLINE / 2;
  for (int k = 0; k < 2 * count; k++) {
    /* From x; the corners stand half a facet beside z. */
    const double angle = 2.0 * M_PI * (k / 2) / count + (corners ? 0.5 * M_PI + M_PI / count : 0.0);
    const double y = k & 1 ? scene->chamber.length + thick : -thick;
    point[k] = em_vec_make(r * cos(angle), y, r * sin(angle));
  }
  return 2 * (size_t)count;
}

void em_solids_clear(struct em_solids *solids, const struct em_gl *gl) {
  if (solids->array != 0) gl->DeleteVertexArrays(1, &solids->array);
  if (solids->buffer != 0) gl->DeleteBuffers(1, &solids->buffer);
  if (solids->program != 0) gl->DeleteProgram(solids->program);
  free(solids->part);
  memset(solids, 0, sizeof *solids);
}
