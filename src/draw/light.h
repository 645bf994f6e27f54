/* How surfaces are lit: GLSL that the programs for balls and for solids share. Colours are worked
 * on in linear light with a gamma of 2, so that coding is a square root. Directions are the eye's.
 */
#ifndef EM_DRAW_LIGHT_H
#define EM_DRAW_LIGHT_H

#define EM_LIGHT_GLSL                                                      \
  "#version 330 core\n"                                                    \
  "const vec3 KEY = vec3(-0.3810, 0.6873, 0.6184);\n"                      \
  "const vec3 FILL = vec3(0.8682, -0.0790, 0.4899);\n"                     \
  "/* n normal, v towards the eye, open: how much of the sky is seen */\n" \
  "vec3 lit(vec3 base, vec3 n, vec3 v, float open, float shine) {\n"       \
  "  float key = max(dot(n, KEY), 0.0);\n"                                 \
  "  float fill = max(dot(n, FILL), 0.0);\n"                               \
  "  float sky = 0.70 + 0.30 * n.y;\n"                                     \
  "  float face = max(dot(n, v), 0.0);\n"                                  \
  "  vec3 half_way = normalize(KEY + v);\n"                                \
  "  float s = max(dot(n, half_way), 0.0);\n"                              \
  "  s *= s; s *= s; s *= s; s *= s; s *= s;\n"                            \
  "  float edge = 1.0 - face;\n"                                           \
  "  float light = open * (0.50 * sky + 0.20 * fill)\n"                    \
  "              + (0.35 + 0.65 * open) * 0.72 * key;\n"                   \
  "  vec3 c = base * (light * (1.0 - 0.45 * edge * edge));\n"              \
  "  return c + vec3(shine * open * s);\n"                                 \
  "}\n"

#endif
