/* How a picture or a film of a run is to look: the command line that frame and film share. */
#ifndef EVENTMILL_MILLPOST_LOOK_H
#define EVENTMILL_MILLPOST_LOOK_H

#include <stdbool.h>

#include "eventmill/film.h"
#include "eventmill/show.h"

/* What can be left out. */
#define EM_MILLPOST_HIDDEN_LIST(X) X(rotor) X(drum) X(balls) X(legend) X(histogram)
#define EM_MILLPOST_HIDDEN(name)   bool name;
struct em_millpost_hidden {
  EM_MILLPOST_HIDDEN_LIST(EM_MILLPOST_HIDDEN)
};
#undef EM_MILLPOST_HIDDEN

/* What a command line says; NAN or 0 where it says nothing. */
struct em_millpost_look {
  const char *run, *out;
  bool quiet;
  int width, height;
  int view;          /* enum em_camera_view, or -1 */
  double turn, tilt; /* degrees; NAN: as the view has it */
  double zoom;
  bool parallel, dark;
  int by, map;      /* -1: not said */
  double low, high; /* ends of the scale; NAN */
  double show_low, show_high;
  long balls, smooth; /* 0: not said */
  struct em_millpost_hidden hide;
  struct em_show_options show;
  double at, triple;                 /* frame; NAN */
  double from, to, fps, slow, orbit; /* film; NAN */
  long workers, quality;             /* film; 0: not said */
};

/* Which command's options are allowed. */
enum em_millpost_kind { EM_LOOK_FRAME, EM_LOOK_FILM };

/* Reads a command line. Returns -1 to go on, or the exit code (help was printed, or a message). */
int em_millpost_look_read(struct em_millpost_look *look, enum em_millpost_kind kind, int argc,
                          char **argv);

/* The picture's options for a run, of which `balls` is a state. */
struct em_picture_options em_millpost_look_picture(const struct em_millpost_look *look,
                                                   const struct em_scene *scene,
                                                   const struct em_balls *balls);

#endif
