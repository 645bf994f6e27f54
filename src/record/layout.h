/* Where things are in a run file. docs/run-file.md describes them. */
#ifndef EVENTMILL_LAYOUT_H
#define EVENTMILL_LAYOUT_H

enum { EM_LAYOUT_VERSION = 1, EM_LAYOUT_TEXT_LIMIT = 1 << 28 };

#define EM_LAYOUT_H5MD        "/h5md"
#define EM_LAYOUT_BALLS       "/particles/balls"
#define EM_LAYOUT_BOX         EM_LAYOUT_BALLS "/box"
#define EM_LAYOUT_OBSERVABLES "/observables"
#define EM_LAYOUT_PARAMETERS  "/parameters"
#define EM_LAYOUT_HOME        "/eventmill"
#define EM_LAYOUT_SCENE       EM_LAYOUT_HOME "/scene"
#define EM_LAYOUT_SESSIONS    EM_LAYOUT_HOME "/sessions"
#define EM_LAYOUT_HISTOGRAM   EM_LAYOUT_HOME "/histogram"
#define EM_LAYOUT_TABLE       EM_LAYOUT_HOME "/collisions"
#define EM_LAYOUT_CHECKPOINT  EM_LAYOUT_HOME "/checkpoint"
#define EM_LAYOUT_ENGINE      EM_LAYOUT_CHECKPOINT "/engine"

#endif
