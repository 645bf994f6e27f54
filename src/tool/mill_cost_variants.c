/* Which variants of a scene mill cost measures. */
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "tool/mill_cost.h"

/* words: KEY=VALUE, separated by blanks. */
static void add(struct em_cost *cost, enum em_cost_group group, enum em_cost_change change,
                const char *name, const char *format, ...) __attribute__((format(printf, 5, 6)));

static void add(struct em_cost *cost, enum em_cost_group group, enum em_cost_change change,
                const char *name, const char *format, ...) {
  if (cost->count == EM_COST_VARIANTS || (cost->only && !strstr(name, cost->only))) return;
  struct em_cost_result *r = &cost->result[cost->count++];
  *r = (struct em_cost_result){.variant = {.group = group, .change = change}};
  snprintf(r->variant.name, sizeof r->variant.name, "%s", name);
  char text[256], *rest = NULL;
  va_list args;
  va_start(args, format);
  vsnprintf(text, sizeof text, format, args);
  va_end(args);
  for (char *word = strtok_r(text, " ", &rest); word && r->variant.words < EM_COST_WORDS;
       word = strtok_r(NULL, " ", &rest))
    snprintf(r->variant.word[r->variant.words++], sizeof r->variant.word[0], "%s", word);
}

static void accuracy(struct em_cost *cost, const char *name, const char *words) {
  add(cost, EM_COST_ACCURACY, EM_COST_AS_IS, name, "%s", words);
}

static void effect(struct em_cost *cost, const char *name, const char *words) {
  add(cost, EM_COST_EFFECT, EM_COST_AS_IS, name, "%s", words);
}

static void add_accuracy(struct em_cost *cost, unsigned effects) {
  const struct em_chamber *c = &cost->scene->chamber;
  const bool drum = c->shape == EM_SHAPE_DRUM, rotor = effects & EM_EFFECT_ROTOR;
  const struct em_vec g = cost->scene->gravity;
  const bool quartic = drum && c->facets == 0 && (g.x != 0.0 || g.z != 0.0);
  accuracy(cost, "level fast", "engine.accuracy=fast");
  accuracy(cost, "level standard", "engine.accuracy=standard");
  accuracy(cost, "level reference", "engine.accuracy=reference");
  if (quartic) {
    accuracy(cost, "quartic: bracket", "engine.quartic=bracket");
    accuracy(cost, "quartic: Ferrari + Newton", "engine.quartic=ferrari+newton");
    accuracy(cost, "quartic: Ferrari", "engine.quartic=ferrari");
    accuracy(cost, "quartic: GSL", "engine.quartic=gsl");
    accuracy(cost, "no gravity near the wall", "engine.shortcut=1.0");
  }
  if (rotor) {
    accuracy(cost, "blade: steps of 0.1 d", "engine.blade=steps engine.blade_step=0.1");
    accuracy(cost, "blade: steps of 0.5 d", "engine.blade=steps engine.blade_step=0.5");
    accuracy(cost, "blade: steps of 2 d", "engine.blade=steps engine.blade_step=2.0");
  }
  if (quartic || rotor) {
    accuracy(cost, "tolerance 1e-9 d", "engine.tolerance=1e-9");
    accuracy(cost, "tolerance 1e-3 d", "engine.tolerance=1e-3");
  }
  accuracy(cost, "polish: 64 bits", "engine.polish=extended");
  if (drum && c->facets == 0 && c->rpm == 0.0 && c->ramp_half == 0.0) {
    accuracy(cost, "drum of 16 facets", "chamber.facets=16");
    accuracy(cost, "drum of 64 facets", "chamber.facets=64");
    accuracy(cost, "drum of 256 facets", "chamber.facets=256");
  }
}

/* A constant coefficient as good as the law at the median v_n. */
static double typical_restitution(const struct em_cost *cost) {
  const double vn = cost->figure[EM_PRECISION_VN].value;
  return em_contact_restitution(&cost->scene->contact[EM_CLASS_BALL].normal, vn > 0.0 ? vn : 1.0);
}

static void add_effects(struct em_cost *cost, unsigned effects) {
  const struct em_scene *s = cost->scene;
  if (effects & EM_EFFECT_GRAVITY)
    effect(cost, "without gravity", "gravity=none");
  else
    effect(cost, "with gravity", "gravity=[0.0,0.0,-9.81]");
  if (effects & EM_EFFECT_SPIN) {
    effect(cost, "without spin (smooth)", "contact.rule=smooth");
    if (s->contact[EM_CLASS_BALL].rule == EM_RULE_FRICTION)
      effect(cost, "without sliding (rough)", "contact.rule=rough");
    else
      effect(cost, "with sliding (friction)", "contact.rule=friction");
  } else {
    effect(cost, "with spin (rough)", "contact.rule=rough contact.tangential=0.9");
  }
  if (effects & EM_EFFECT_RESTITUTION)
    add(cost, EM_COST_EFFECT, EM_COST_AS_IS, "constant restitution, TC",
        "contact.normal=%.6f remedy.tc=1e-6", typical_restitution(cost));
  else
    effect(cost, "restitution falls with speed", "contact.normal=spahn");
  if (effects & EM_EFFECT_ROTOR) {
    effect(cost, "blades without tips", "rotor.tip=none");
    effect(cost, "blades with round tips", "rotor.tip=hemisphere");
    add(cost, EM_COST_EFFECT, EM_COST_NO_ROTOR, "without rotor", "remedy.tc=1e-6");
    effect(cost, s->remedy.jam_after > 0 ? "without jam remedy" : "with jam remedy",
           s->remedy.jam_after > 0 ? "remedy.jam_after=0" : "remedy.jam_after=5");
  }
  if (effects & EM_EFFECT_MIXED)
    add(cost, EM_COST_EFFECT, EM_COST_UNMIXED, "balls of one kind", "%s", "");
  else
    add(cost, EM_COST_EFFECT, EM_COST_MIXED, "balls of mixed kinds", "%s", "");
  effect(cost, effects & EM_EFFECT_TC ? "without TC" : "with TC (1 µs)",
         effects & EM_EFFECT_TC ? "remedy.tc=0.0" : "remedy.tc=1e-6");
}

static void recording(struct em_cost *cost, const char *name, const char *words) {
  add(cost, EM_COST_RECORDING, EM_COST_AS_IS, name, "%s", words);
}

enum { CHECKPOINTS = 4 };

static void add_recording(struct em_cost *cost) {
  recording(cost, "collision table", "record.collisions=true");
  recording(cost, "frames, 50/s", "record.frames=50.0");
  recording(cost, "observables, 100/s", "record.observables=100.0");
  recording(cost, "histograms, 20/s", "record.histograms=20.0");
  /* s between two on the wall, of which a run of this length has some */
  const double between = fmax(cost->time * cost->cpu_per_time / CHECKPOINTS, 1e-3);
  char name[64], words[64];
  snprintf(name, sizeof name, "checkpoints, every %.2g s", between);
  snprintf(words, sizeof words, "record.checkpoint=%.9e", between);
  recording(cost, name, words);
}

void em_mill_cost_variants(struct em_cost *cost) {
  const unsigned effects = em_scene_effects(cost->scene);
  cost->count = 0;
  add_accuracy(cost, effects);
  add_effects(cost, effects);
  add_recording(cost);
}
