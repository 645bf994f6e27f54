/* Letters of texts in UTF-8. What draws texts draws nothing more, or anything, after a byte that
 * belongs to no letter, as titles and names of files in another coding have them. */
#ifndef EM_DRAW_LETTERS_H
#define EM_DRAW_LETTERS_H

#include <stddef.h>

/* Bytes of the letter with which a text begins; 0: it begins with none. */
size_t em_letters_length(const char *text);

/* Puts '?' for each byte that belongs to no letter. */
void em_letters_clean(char *text);

#endif
