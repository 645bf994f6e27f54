/* Who made a run: program, libraries, machine, times. */
#ifndef EVENTMILL_RECORD_PROVENANCE_H
#define EVENTMILL_RECORD_PROVENANCE_H

#include "eventmill/provenance.h"
#include "eventmill/run_file.h"
#include "record/h5.h"

/* A session that begins now. command may be NULL. */
void em_provenance_begin(struct em_run_session *session, const char *command, double from);
/* Brings its end, computing times and `to` up to date. wall: s since it began. */
void em_provenance_update(struct em_run_session *session, double wall, double to);

bool em_provenance_write(hid_t file, size_t k, const struct em_run_session *session);
bool em_provenance_read(hid_t file, size_t k, struct em_run_session *session);
size_t em_provenance_count(hid_t file);

#endif
