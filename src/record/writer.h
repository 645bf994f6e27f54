/* Writes a run file: frames, observables, histograms, contacts, and, all at once, what it has. */
#ifndef EVENTMILL_WRITER_H
#define EVENTMILL_WRITER_H

#include "eventmill/run_file.h"
#include "eventmill/world.h"
#include "record/observe.h"

struct em_writer;

/* What a flush stores beside the datasets. */
struct em_writer_flush {
  struct em_run_state state;
  struct em_run_session session;
  const struct em_snapshot *snapshot;
  bool last; /* nothing will be written any more */
};

/* Claims `path`: what is there stays as it is, for whoever wants to read it, until this writer
 * flushes. Errors: EM_FILE (cannot be written; another process writes it), EM_MEMORY. */
enum em_status em_writer_new(struct em_writer **writer, const char *path, struct em_error *err);
/* Begins a new run file; `balls` are those at the start. It is not to be seen before the first
 * flush. Errors: EM_FILE, EM_MEMORY. */
enum em_status em_writer_begin(struct em_writer *writer, const struct em_scene *scene,
                               const struct em_balls *balls, const struct em_snapshot *snapshot,
                               struct em_error *err);
/* Goes on with the file that is there, whose checkpoint tells the engine's state. The scene may
 * differ from the stored one in its duration alone. Errors: EM_FILE, EM_FORMAT, EM_MEMORY. */
enum em_status em_writer_resume(struct em_writer *writer, const struct em_scene *scene,
                                struct em_error *err);
/* Leaves the file as it was at the last flush. */
void em_writer_free(struct em_writer *writer);

/* Frames, observables and complete blocks that there are; each is the index of the next one. */
uint64_t em_writer_frames(const struct em_writer *writer);
uint64_t em_writer_samples(const struct em_writer *writer);
uint64_t em_writer_blocks(const struct em_writer *writer);

/* Adds one. Errors: EM_FILE. `counts` of em_writer_block: [EM_CLASS_COUNT * EM_TALLY_BINS]; an open
 * block is replaced by the next one that is added. */
enum em_status em_writer_frame(struct em_writer *writer, double time, const struct em_balls *balls,
                               struct em_error *err);
enum em_status em_writer_sample(struct em_writer *writer, const struct em_observe_state *state,
                                struct em_error *err);
enum em_status em_writer_block(struct em_writer *writer, double start, double end, bool open,
                               const uint64_t *counts, struct em_error *err);
/* Adds a contact to the table; failures show at the next flush. */
void em_writer_contact(struct em_writer *writer, const struct em_contact *contact);
/* Has anything failed that is not reported yet? */
bool em_writer_has_failed(struct em_writer *writer);

/* Makes everything so far durable. Errors: EM_FILE: the file is as at the flush before. */
enum em_status em_writer_flush(struct em_writer *writer, const struct em_writer_flush *flush,
                               struct em_error *err);

/* Is there a run file at the path? */
bool em_writer_is_published(const struct em_writer *writer);

#endif
