/* The well-formed sequences of bytes (Unicode, table 3-7). */
#include "draw/letters.h"

size_t em_letters_length(const char *text) {
  const unsigned char *c = (const unsigned char *)text;
  if (c[0] == '\0') return 0;
  if (c[0] < 0x80) return 1;
  const size_t length = c[0] < 0xE0 ? 2 : c[0] < 0xF0 ? 3 : 4;
  const unsigned least = c[0] == 0xE0 ? 0xA0 : c[0] == 0xF0 ? 0x90 : 0x80;
  const unsigned most = c[0] == 0xED ? 0x9F : c[0] == 0xF4 ? 0x8F : 0xBF;
  if (c[0] < 0xC2 || c[0] > 0xF4 || c[1] < least || c[1] > most) return 0;
  for (size_t k = 2; k < length; k++)
    if (c[k] < 0x80 || c[k] > 0xBF) return 0;
  return length;
}

void em_letters_clean(char *text) {
  while (*text != '\0') {
    const size_t length = em_letters_length(text);
    if (length == 0) *text = '?';
    text += length > 0 ? length : 1;
  }
}
