/* A crew of drawing processes. Mesa keeps one software rasteriser per process, which serves one
 * context at a time; separate processes do not wait for each other. */
#include "draw/crew.h"

#include <assert.h>
#include <errno.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

enum { SLOTS_PER_WORKER = 2, MOST_WORKERS = 64 };

/* One picture's place in the shared memory; the arrays follow it. */
struct slot {
  size_t index; /* of the picture */
  double time;
  size_t bead_count, unmarked;
  bool has_classes;
  enum em_status status;
  struct em_error error;
};

struct worker {
  pid_t pid;
  int line; /* to and from the worker: one byte per picture */
};

struct em_crew {
  int workers;
  size_t count, blades, bead_room; /* sizes of a state */
  size_t pixels;                   /* bytes of a picture */
  size_t slot_size, map_size;
  char *map;
  struct worker worker[MOST_WORKERS];
  const struct em_scene *scene;
  const struct em_film_options *options;
  struct em_balls constant; /* radius, mass, species: as they were at the start */
};

/* The arrays of a slot. */
struct view {
  struct slot *slot;
  struct em_vec *position, *velocity, *spin;
  double *blade;
  struct em_picture_bead *bead;
  uint8_t *last, *rgba;
};

static size_t aligned(size_t size) {
  return (size + 63U) & ~(size_t)63U;
}

/* Lays out slot k; with a map of NULL, *size tells how much memory a slot takes. */
static struct view view_of(const struct em_crew *crew, size_t k, size_t *size) {
  char *const base = crew->map != NULL ? crew->map + k * crew->slot_size : NULL;
  size_t at = 0;
  struct view v = {0};
#define TAKE(field, bytes)                             \
  v.field = base != NULL ? (void *)(base + at) : NULL; \
  at += aligned(bytes)
  TAKE(slot, sizeof *v.slot);
  TAKE(position, crew->count * sizeof *v.position);
  TAKE(velocity, crew->count * sizeof *v.velocity);
  TAKE(spin, crew->count * sizeof *v.spin);
  TAKE(blade, (crew->blades + 1) * sizeof *v.blade);
  TAKE(bead, (crew->bead_room + 1) * sizeof *v.bead);
  TAKE(last, crew->count);
  TAKE(rgba, crew->pixels);
#undef TAKE
  assert(size != NULL || v.slot != NULL);
  if (size != NULL) *size = at;
  return v;
}

static size_t slot_of(const struct em_crew *crew, size_t k) {
  return k % em_crew_depth(crew);
}

static struct worker *worker_of(struct em_crew *crew, size_t k) {
  return &crew->worker[k % (size_t)crew->workers];
}

/* Draws what is in a slot. */
static void draw(struct em_picture *picture, const struct em_crew *crew, const struct view *v) {
  struct em_balls balls = crew->constant;
  balls.position = v->position;
  balls.velocity = v->velocity;
  balls.spin = v->spin;
  const struct em_picture_state state = {
      .balls = &balls,
      .time = v->slot->time,
      .blade_angle = v->blade,
      .last = v->slot->has_classes ? v->last : NULL,
      .bead_count = v->slot->bead_count,
      .bead = v->bead,
      .unmarked = v->slot->unmarked,
  };
  const struct em_film_options *o = crew->options;
  if (o->orbit != 0.0)
    em_picture_turn(picture, o->picture.camera.azimuth + o->orbit * (double)v->slot->index);
  v->slot->status = em_picture_draw(picture, &state, v->rgba, &v->slot->error);
}

/* The life of a worker: a byte comes with the number of a slot, and goes back when it is drawn. */
static void work(struct em_crew *crew, int line) {
  struct em_error error = {0};
  struct em_picture *picture = NULL;
  /* One thread per process: the processes fill the cores. */
  setenv("LP_NUM_THREADS", "0", 1);
  const enum em_status status =
      em_picture_new(&picture, crew->scene, &crew->options->picture, &error);
  unsigned char slot;
  while (read(line, &slot, 1) == 1) {
    const struct view v = view_of(crew, slot, NULL);
    if (status == EM_OK) {
      draw(picture, crew, &v);
    } else {
      v.slot->status = status;
      v.slot->error = error;
    }
    if (send(line, &slot, 1, MSG_NOSIGNAL) != 1) break;
  }
  _Exit(0);
}

static enum em_status start_worker(struct em_crew *crew, int k, struct em_error *err) {
  static const int ending[] = {SIGINT, SIGTERM, SIGHUP}; /* that a whole group may get */
  int pair[2];
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, pair) != 0)
    return em_error_set(err, EM_PICTURE, NULL, 0, "cannot start to draw: %s", strerror(errno));
  const pid_t pid = fork();
  if (pid == 0) {
    /* The parent decides when to end. */
    for (size_t n = 0; n < sizeof ending / sizeof *ending; n++)
      signal(ending[n], SIG_IGN);
    close(pair[0]);
    for (int other = 0; other < k; other++)
      close(crew->worker[other].line);
    work(crew, pair[1]);
  }
  close(pair[1]);
  if (pid < 0) {
    close(pair[0]);
    return em_error_set(err, EM_PICTURE, NULL, 0, "cannot start to draw: %s", strerror(errno));
  }
  crew->worker[k] = (struct worker){pid, pair[0]};
  crew->workers = k + 1;
  return EM_OK;
}

enum em_status em_crew_start(struct em_crew **crew, int workers, const struct em_scene *scene,
                             const struct em_film_options *options,
                             const struct em_picture_state *first, struct em_error *err) {
  *crew = NULL;
  struct em_crew *made = calloc(1, sizeof *made);
  if (made == NULL) return em_error_set(err, EM_MEMORY, NULL, 0, "no memory for a film");
  if (workers > MOST_WORKERS) workers = MOST_WORKERS;
  made->count = first->balls->count;
  made->blades = em_scene_blade_count(scene);
  made->bead_room = options->bead_room;
  made->pixels = 4 * (size_t)options->picture.width * (size_t)options->picture.height;
  made->scene = scene;
  made->options = options;
  made->constant = *first->balls;
  view_of(made, 0, &made->slot_size);
  made->map_size = made->slot_size * (size_t)workers * SLOTS_PER_WORKER;
  made->map = mmap(NULL, made->map_size, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (made->map == MAP_FAILED) {
    free(made);
    return em_error_set(err, EM_MEMORY, NULL, 0, "no memory for %d pictures", workers);
  }
  enum em_status status = EM_OK;
  for (int k = 0; k < workers && status == EM_OK; k++)
    status = start_worker(made, k, err);
  if (status != EM_OK) {
    em_crew_end(made);
    return status;
  }
  *crew = made;
  return EM_OK;
}

size_t em_crew_depth(const struct em_crew *crew) {
  return (size_t)crew->workers * SLOTS_PER_WORKER;
}

static enum em_status lost(struct em_error *err) {
  return em_error_set(err, EM_PICTURE, NULL, 0, "a process that draws has ended too early");
}

enum em_status em_crew_give(struct em_crew *crew, size_t k, const struct em_picture_state *state,
                            struct em_error *err) {
  const struct view v = view_of(crew, slot_of(crew, k), NULL);
  const size_t vectors = crew->count * sizeof *v.position;
  if (state->balls->count != crew->count || state->bead_count > crew->bead_room)
    return em_error_set(err, EM_INTERNAL, NULL, 0, "a state of %zu balls in a film of %zu",
                        state->balls->count, crew->count);
  v.slot->index = k;
  v.slot->time = state->time;
  v.slot->bead_count = state->bead_count;
  v.slot->unmarked = state->unmarked;
  v.slot->has_classes = state->last != NULL;
  memcpy(v.position, state->balls->position, vectors);
  memcpy(v.velocity, state->balls->velocity, vectors);
  memcpy(v.spin, state->balls->spin, vectors);
  if (crew->blades > 0) memcpy(v.blade, state->blade_angle, crew->blades * sizeof *v.blade);
  if (state->bead_count > 0) memcpy(v.bead, state->bead, state->bead_count * sizeof *v.bead);
  if (state->last != NULL) memcpy(v.last, state->last, crew->count);
  const unsigned char slot = (unsigned char)slot_of(crew, k);
  return send(worker_of(crew, k)->line, &slot, 1, MSG_NOSIGNAL) == 1 ? EM_OK : lost(err);
}

enum em_status em_crew_take(struct em_crew *crew, size_t k, const uint8_t **rgba,
                            struct em_error *err) {
  unsigned char slot;
  ssize_t got;
  do
    got = read(worker_of(crew, k)->line, &slot, 1);
  while (got < 0 && errno == EINTR);
  if (got != 1) return lost(err);
  const struct view v = view_of(crew, slot, NULL);
  if (v.slot->status != EM_OK && err != NULL) *err = v.slot->error;
  *rgba = v.rgba;
  return v.slot->status;
}

void em_crew_end(struct em_crew *crew) {
  if (crew == NULL) return;
  for (int k = 0; k < crew->workers; k++)
    close(crew->worker[k].line);
  for (int k = 0; k < crew->workers; k++)
    while (waitpid(crew->worker[k].pid, NULL, 0) < 0 && errno == EINTR)
      continue;
  munmap(crew->map, crew->map_size);
  free(crew);
}
