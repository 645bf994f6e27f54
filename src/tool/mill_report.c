/* The summary of a run, for people and for programs. */
#include <math.h>
#include <stdio.h>

#include "tool/mill.h"

/* ---------------------------------------------------------------- JSON */

static void number(const char *key, double value) {
  if (isfinite(value))
    printf(",\"%s\":%.17g", key, value);
  else
    printf(",\"%s\":null", key);
}

static void count(const char *key, uint64_t value) {
  printf(",\"%s\":%llu", key, (unsigned long long)value);
}

/* A list, when something was asked for. */
static void found(const struct em_mill_precision *precision) {
  if (precision->count == 0) return;
  printf(",\"precision\":[");
  for (size_t k = 0; k < precision->count; k++) {
    char name[64];
    em_precision_name(&precision->target[k], name, sizeof name);
    printf("%s{\"figure\":\"%s\"", k ? "," : "", name);
    number("value", precision->found[k].figure.value);
    number("ci95", precision->found[k].figure.half);
    number("wanted", precision->target[k].wanted);
    printf(",\"reached\":%s}", precision->found[k].reached ? "true" : "false");
  }
  printf("]");
}

void em_mill_report_json(const struct em_summary *s, const struct em_scene *scene,
                         const struct em_mill_precision *precision) {
  printf("{\"collisions\":%llu", (unsigned long long)s->collisions);
  number("collisions_per_second", s->collisions_per_second);
  number("simulated_time", s->simulated_time);
  number("wall_time", s->wall_time);
  number("realtime_factor", s->realtime_factor);
  number("median_speed", s->median_speed);
  number("median_vn", s->median_vn);
  number("rate_above_3", s->rate_above_3);
  number("share_above_3", s->share_above_3);
  number("power", s->power);
  number("energy_error", s->energy_error);
  printf(",\"collisions_by_class\":{");
  for (int c = 0; c < EM_CLASS_COUNT; c++)
    printf("%s\"%s\":%llu", c ? "," : "", em_contact_class_name((enum em_class)c),
           (unsigned long long)s->by_class[c]);
  printf("},\"effects\":[");
  const unsigned effects = em_scene_effects(scene);
  const char *comma = "";
  for (int k = 0; k < EM_EFFECT_COUNT; k++)
    if (effects >> k & 1) {
      printf("%s\"%s\"", comma, em_scene_effect_name((enum em_effect_bit)k));
      comma = ",";
    }
  printf("]");
  count("seed", scene->seed);
  count("tc_contacts", s->tc);
  count("elastic_contacts", s->elastic);
  count("jam_contacts", s->jam);
  found(precision);
  printf("}\n");
}

/* ---------------------------------------------------------------- text */

static void line(const char *label, double value, const char *unit) {
  if (isfinite(value))
    printf("  %-24s %12.5g %s\n", label, value, unit);
  else
    printf("  %-24s %12s\n", label, "-");
}

static void count_line(const char *label, uint64_t value) {
  printf("  %-24s %12llu\n", label, (unsigned long long)value);
}

static void remedies(const struct em_summary *s, unsigned effects) {
  if (effects & EM_EFFECT_TC) count_line("elastic by tc", s->tc);
  if (effects & EM_EFFECT_ELASTIC) count_line("elastic as too slow", s->elastic);
  if (effects & EM_EFFECT_JAM) count_line("jam remedy", s->jam);
}

void em_mill_report_text(const struct em_summary *s, const struct em_scene *scene) {
  const unsigned effects = em_scene_effects(scene);
  printf("%s (%s)\n", scene->title[0] ? scene->title : scene->file, em_run_file_end_name(s->end));
  line("simulated time", s->simulated_time, "s");
  line("wall time", s->wall_time, "s");
  line("real-time factor", s->realtime_factor, "");
  count_line("collisions", s->collisions);
  for (int c = 0; c < EM_CLASS_COUNT; c++) {
    char label[32];
    snprintf(label, sizeof label, "  %s", em_contact_class_name((enum em_class)c));
    if (s->by_class[c]) count_line(label, s->by_class[c]);
  }
  line("collisions per second", s->collisions_per_second, "/s of wall time");
  remedies(s, effects);
  line("energy error", s->energy_error, "relative");
  printf("from %.4g s on\n", s->steady);
  line("median speed of balls", s->median_speed, "m/s");
  line("median v_n", s->median_vn, "m/s");
  line("contacts above 3 m/s", s->rate_above_3, "/s");
  line("their share", 100.0 * s->share_above_3, "%");
  if (effects & (EM_EFFECT_ROTOR | EM_EFFECT_TURNING)) line("power", s->power, "W");
}
