/* How a run begins whose balls start from another run. */
#ifndef EVENTMILL_RECORDER_START_H
#define EVENTMILL_RECORDER_START_H

#include "eventmill/recorder.h"

/* A copy of the scene, with its blades where they stood at the end of the run that its balls start
 * from; NULL when they start otherwise. em_scene_free. Errors: those of em_run_file_turn. */
enum em_status em_recorder_start_scene(struct em_scene **copy, const struct em_scene *scene,
                                       struct em_error *err);

#endif
