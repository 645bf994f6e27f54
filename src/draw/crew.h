/* Processes that draw pictures side by side. Each is given states through shared memory and leaves
 * its pictures there. */
#ifndef EM_DRAW_CREW_H
#define EM_DRAW_CREW_H

#include "eventmill/film.h"

struct em_crew;

/* Starts the workers. first: a state of the film, whose number of balls all others share. */
enum em_status em_crew_start(struct em_crew **crew, int workers, const struct em_scene *scene,
                             const struct em_film_options *options,
                             const struct em_picture_state *first, struct em_error *err);

/* How many pictures can be under way at once. */
size_t em_crew_depth(const struct em_crew *crew);

/* Has picture k (from 0, rising) drawn from a copy of the state. At most em_crew_depth may be under
 * way. */
enum em_status em_crew_give(struct em_crew *crew, size_t k, const struct em_picture_state *state,
                            struct em_error *err);

/* Waits for picture k, in the order in which they were given; it holds until k + depth is given. */
enum em_status em_crew_take(struct em_crew *crew, size_t k, const uint8_t **rgba,
                            struct em_error *err);

/* Ends all workers. */
void em_crew_end(struct em_crew *crew);

#endif
