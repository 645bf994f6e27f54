/* The multisampled frame buffer. */
#include "draw/target.h"

#include <stddef.h>

enum { SAMPLES = 4 };

enum em_status em_target_make(struct em_target *target, const struct em_gl *gl, int width,
                              int height, struct em_error *err) {
  GLint most = 0;
  gl->GetIntegerv(GL_MAX_SAMPLES, &most);
  *target = (struct em_target){.width = width, .height = height};
  target->samples = most < SAMPLES ? 0 : SAMPLES;
  gl->GenFramebuffers(1, &target->frame);
  gl->GenRenderbuffers(1, &target->colour);
  gl->GenRenderbuffers(1, &target->depth);
  gl->BindRenderbuffer(GL_RENDERBUFFER, target->colour);
  gl->RenderbufferStorageMultisample(GL_RENDERBUFFER, target->samples, GL_RGBA8, width, height);
  gl->BindRenderbuffer(GL_RENDERBUFFER, target->depth);
  gl->RenderbufferStorageMultisample(GL_RENDERBUFFER, target->samples, GL_DEPTH_COMPONENT24, width,
                                     height);
  gl->BindFramebuffer(GL_FRAMEBUFFER, target->frame);
  gl->FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER,
                              target->colour);
  gl->FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, target->depth);
  const GLenum state = gl->CheckFramebufferStatus(GL_FRAMEBUFFER);
  if (state == GL_FRAMEBUFFER_COMPLETE && gl->GetError() == GL_NO_ERROR) return EM_OK;
  em_target_clear(target, gl);
  return em_error_set(err, EM_PICTURE, NULL, 0, "no frame buffer of %d x %d pixels", width, height);
}

void em_target_begin(const struct em_target *target, const struct em_gl *gl) {
  gl->BindFramebuffer(GL_FRAMEBUFFER, target->frame);
  gl->Viewport(0, 0, target->width, target->height);
  gl->Enable(GL_DEPTH_TEST);
  gl->DepthMask(GL_TRUE);
  gl->Disable(GL_BLEND);
  gl->ClearColor(0.0F, 0.0F, 0.0F, 0.0F);
  gl->Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
}

void em_target_end(const struct em_target *target, const struct em_gl *gl) {
  gl->BindFramebuffer(GL_READ_FRAMEBUFFER, target->frame);
  gl->BindFramebuffer(GL_DRAW_FRAMEBUFFER, 0);
  gl->BlitFramebuffer(0, 0, target->width, target->height, 0, 0, target->width, target->height,
                      GL_COLOR_BUFFER_BIT, GL_NEAREST);
}

void em_target_clear(struct em_target *target, const struct em_gl *gl) {
  if (target->frame != 0) gl->DeleteFramebuffers(1, &target->frame);
  if (target->colour != 0) gl->DeleteRenderbuffers(1, &target->colour);
  if (target->depth != 0) gl->DeleteRenderbuffers(1, &target->depth);
  *target = (struct em_target){0};
}
