/* Colour maps with even steps: computed in OKLab (Ottosson 2020), where equal distances look equal.
 * Along each map of one direction the lightness rises steadily, so that it survives grey printing
 * and colour blindness. Balance is even on each side of its white middle. */
#ifndef EVENTMILL_COLOUR_H
#define EVENTMILL_COLOUR_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define EM_COLOUR_LIST(X)                                              \
  X(LAGOON, "lagoon")   /* violet, blue, green, yellow: the default */ \
  X(EMBER, "ember")     /* indigo, magenta, orange, yellow */          \
  X(GREY, "grey")       /* without hue */                              \
  X(BALANCE, "balance") /* blue, white, red: for differences */
#define EM_COLOUR_ENUM(code, text) EM_COLOUR_##code,
enum em_colour { EM_COLOUR_LIST(EM_COLOUR_ENUM) EM_COLOUR_COUNT };
#undef EM_COLOUR_ENUM

enum { EM_COLOUR_STEPS = 256 };

/* sRGB, 8 bits per channel; entry 0 is the low end. */
struct em_colour_map {
  uint8_t rgb[EM_COLOUR_STEPS][3];
};

const char *em_colour_name(enum em_colour which);
int em_colour_find(const char *name); /* -1: no such map */

/* Computes a map. */
void em_colour_make(enum em_colour which, struct em_colour_map *map);

/* The entry for a value in [low, high]; clamped outside, the low end for NaN. */
const uint8_t *em_colour_at(const struct em_colour_map *map, double value, double low, double high);

/* Colour number k of the cycle for species, classes and curves (sRGB), dark enough on white. */
const uint8_t *em_colour_cycle(unsigned k);

#ifdef __cplusplus
}
#endif

#endif
