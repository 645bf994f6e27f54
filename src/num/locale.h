/* Numbers with a decimal point, whatever the locale of the program that the library is part of. */
#ifndef EVENTMILL_LOCALE_H
#define EVENTMILL_LOCALE_H

#include <locale.h>

struct em_locale {
  locale_t own, before; /* own: 0 when there is no memory, and nothing was changed */
};

static inline struct em_locale em_locale_begin(void) {
  const locale_t own = newlocale(LC_ALL_MASK, "C", (locale_t)0);
  return (struct em_locale){own, uselocale(own)};
}

static inline void em_locale_end(const struct em_locale *locale) {
  if (!locale->own) return;
  uselocale(locale->before);
  freelocale(locale->own);
}

/* For whoever reads or writes numbers as text: this thread's locale is "C" to the end of the block.
 * No callback may be called in it. */
#define EM_LOCALE_PLAIN                                                            \
  const struct em_locale em_locale_plain __attribute__((cleanup(em_locale_end))) = \
      em_locale_begin();                                                           \
  (void)em_locale_plain

#endif
