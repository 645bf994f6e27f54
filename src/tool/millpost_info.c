/* millpost info: where a run comes from, what it simulated, and what its file holds. */
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "eventmill/scene.h"
#include "eventmill/world.h"
#include "tool/millpost.h"

static const char *const option_names[] = {"scene", ""};

static const struct em_millpost_help help = {
    .name = "info",
    .arguments = "RUN",
    .summary = "Tells where a run comes from, what it simulated, and what its file holds.",
    .examples = "  millpost info simoloyer-2l.h5\n"
                "  millpost info simoloyer-2l.h5 --json\n"
                "  millpost info simoloyer-2l.h5 --scene > again.cfg",
    .options = option_names,
    .least = 1,
    .most = 1,
};

static void chamber_facts(struct em_report *report, const struct em_scene *scene) {
  const struct em_chamber *c = &scene->chamber;
  if (c->shape == EM_SHAPE_DRUM)
    em_report_fact_text(report, "chamber", "chamber", "drum, diameter %g m, length %g m",
                        c->diameter, c->length);
  else
    em_report_fact_text(report, "chamber", "chamber", "box, %g × %g × %g m%s", c->size.x, c->size.y,
                        c->size.z,
                        c->periodic[0] || c->periodic[1] || c->periodic[2] ? ", periodic" : "");
  for (size_t r = 0; r < scene->rotor_count; r++)
    em_report_fact_text(report, "rotor", "rotor", "%g rpm, %zu blades", scene->rotor[r].rpm,
                        scene->rotor[r].blade_count);
  for (size_t s = 0; s < scene->species_count; s++) {
    const struct em_species *k = &scene->species[s];
    em_report_fact_text(report, "balls", "balls", "%zu of %g m, %g kg/m³ (%s)", k->count,
                        k->diameter, k->density, k->name);
  }
  em_report_fact(report, "gravity", "gravity", em_vec_norm(scene->gravity), "m/s²");
}

static void effect_facts(struct em_report *report, const struct em_scene *scene) {
  char text[512] = "";
  const unsigned effects = em_scene_effects(scene);
  for (int k = 0; k < EM_EFFECT_COUNT; k++) {
    if (!(effects & 1U << k)) continue;
    const size_t used = strlen(text);
    snprintf(text + used, sizeof text - used, "%s%s", used ? " " : "",
             em_scene_effect_name((enum em_effect_bit)k));
  }
  em_report_fact_text(report, "effects", "effects", "%s", text[0] ? text : "none");
}

static void state_facts(struct em_report *report, const struct em_run_file *run) {
  const struct em_run_state *state = em_run_file_state(run);
  em_report_fact_text(report, "end", "end", "%s%s%s", em_run_file_end_name(state->end),
                      state->message[0] ? ": " : "", state->message);
  em_report_fact(report, "simulated_time", "simulated", state->time, "s");
  em_report_fact(report, "duration", "of", em_run_file_scene(run)->duration, "s");
  em_report_fact_count(report, "collisions", "collisions", state->collisions);
  em_report_fact_count(report, "frames", "frames", em_run_file_frame_count(run));
  em_report_fact_count(report, "histogram_blocks", "blocks of histograms",
                       em_run_file_block_count(run));
  if (em_run_file_has_rows(run))
    em_report_fact_count(report, "rows", "rows of the collision table", em_run_file_row_count(run));
  else
    em_report_fact_text(report, "rows", "collision table", "none");
}

/* Collisions per class up to the last flush, like their sum. */
static enum em_status class_table(struct em_report *report, const struct em_run_file *run,
                                  struct em_error *err) {
  struct em_snapshot *snapshot;
  const enum em_status status = em_run_file_checkpoint(run, &snapshot, err);
  if (status != EM_OK) return status;
  const uint64_t *count = snapshot->tally.collisions;
  uint64_t all = 0;
  for (int cls = 0; cls < EM_CLASS_COUNT; cls++)
    all += count[cls];
  em_report_begin(report, "collisions_by_class", NULL);
  em_report_column(report, "class", "class", "");
  em_report_column(report, "count", "collisions", "");
  em_report_column(report, "share", "share", "");
  for (int cls = 0; cls < EM_CLASS_COUNT; cls++) {
    em_report_text(report, "%s", em_contact_class_name((enum em_class)cls));
    em_report_count(report, count[cls]);
    em_report_percent(report, all > 0 ? (double)count[cls] / (double)all : NAN);
  }
  em_world_snapshot_free(snapshot);
  return EM_OK;
}

static enum em_status session_table(struct em_report *report, const struct em_run_file *run,
                                    struct em_error *err) {
  em_report_begin(report, "sessions", NULL);
  em_report_column(report, "started", "started (UTC)", "");
  em_report_column(report, "host", "host", "");
  em_report_column(report, "from", "from", "s");
  em_report_column(report, "to", "to", "s");
  em_report_column(report, "wall_time", "wall time", "s");
  em_report_column(report, "cpu_time", "CPU time", "s");
  em_report_column(report, "version", "version", "");
  for (size_t k = 0; k < em_run_file_session_count(run); k++) {
    struct em_run_session session;
    const enum em_status status = em_run_file_session(run, k, &session, err);
    if (status != EM_OK) return status;
    em_report_text(report, "%s", session.started);
    em_report_text(report, "%s", session.host);
    em_report_number(report, session.from);
    em_report_number(report, session.to);
    em_report_number(report, session.wall_time);
    em_report_number(report, session.cpu_time);
    em_report_text(report, "%s", session.version);
  }
  return EM_OK;
}

int em_millpost_info(int argc, char **argv) {
  struct em_millpost_options options;
  const int code = em_millpost_options(&options, &help, argc, argv);
  if (code >= 0) return code;
  struct em_error err = {.code = EM_OK};
  struct em_run_file *run;
  if (em_millpost_open(&run, options.run[0], &err) != EM_OK) return em_millpost_fail(&err);
  if (options.scene) {
    if (fputs(em_run_file_scene_text(run), stdout) < 0 || fflush(stdout) != 0)
      em_error_set(&err, EM_FILE, NULL, 0, "cannot write the output: %s", strerror(errno));
    em_run_file_close(run);
    return err.code == EM_OK ? EM_MILLPOST_DONE : em_millpost_fail(&err);
  }
  struct em_report *report = em_report_new("info");
  const struct em_scene *scene = em_run_file_scene(run);
  em_report_fact_text(report, "run", "run", "%s", options.run[0]);
  em_report_fact_text(report, "title", "title", "%s", scene->title);
  chamber_facts(report, scene);
  effect_facts(report, scene);
  em_report_fact_count(report, "seed", "seed", scene->seed);
  em_report_fact_text(report, "engine", "engine", "lists %s, partition %s, accuracy %s",
                      em_scene_lists_name(scene->engine.lists),
                      em_scene_partition_name(scene->engine.partition),
                      em_scene_accuracy_name(scene->engine.accuracy));
  state_facts(report, run);
  enum em_status status = class_table(report, run, &err);
  if (status == EM_OK) status = session_table(report, run, &err);
  em_run_file_close(run);
  if (status == EM_OK) return em_millpost_print(report, &options, EM_MILLPOST_DONE);
  em_report_free(report);
  return em_millpost_fail(&err);
}
