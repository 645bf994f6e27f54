/* Where numbers stand along an axis; gnuplot's own on logarithmic ones are powers of ten only. */
#include "draw/plot_ticks.h"

#include <math.h>

static const double DECADES = 1000.0, NARROW = 4.0;

double em_plot_ticks_step(double range, double steps) {
  const double raw = range / steps, power = pow(10.0, floor(log10(raw))), lead = raw / power;
  return power * (lead < 1.5 ? 1.0 : lead < 3.5 ? 2.0 : lead < 7.5 ? 5.0 : 10.0);
}

static void write_even(FILE *out, double low, double high) {
  enum { MOST = 16 };
  const double step = em_plot_ticks_step(high - low, 5.0), first = ceil(low / step - 1e-9);
  const int digits = 1 + (int)ceil(log10(high / step));
  const char *between = "";
  for (int k = 0; k < MOST && (first + k) * step <= high + 1e-9 * step; k++) {
    const double at = (first + k) * step;
    fprintf(out, "%s'%.*g' %.17g", between, digits, at, at);
    between = ", ";
  }
}

static void write_decades(FILE *out, double low, double high) {
  static const double steps[] = {1.0, 2.0, 5.0};
  const char *between = "";
  for (double ten = pow(10.0, floor(log10(low))); ten < high; ten *= 10.0)
    for (int k = 0; k < 3; k++) {
      const double at = steps[k] * ten;
      if (at < low * (1.0 - 1e-9) || at > high * (1.0 + 1e-9)) continue;
      fprintf(out, "%s'%g' %.9g", between, at, at);
      between = ", ";
    }
}

void em_plot_ticks_log(struct em_gnuplot *script, const char *axis, double low, double high) {
  fprintf(script->out, "set logscale %s\n", axis);
  if (high >= DECADES * low) {
    fprintf(script->out, "set format %s '10^{%%T}'\n", axis);
    return;
  }
  fprintf(script->out, "set %stics (", axis);
  if (high < NARROW * low)
    write_even(script->out, low, high);
  else
    write_decades(script->out, low, high);
  fputs(")\n", script->out);
}
