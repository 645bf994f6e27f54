// The legend: what colours mean, the histogram that lives on its scale, and two marks that bound
// what is shown. Speed and spin have a bar of colours; classes and species have their names, and
// the histogram of speeds is made of their shares.
const BINS = 48;
const NO_CLASS = [190, 193, 198];

// What colours can tell: the values on the scale, and for groups which one a ball belongs to.
function kindsOf(run) {
  const speed = {title: "Speed", unit: "m/s", value: run.speed, bounds: [0, Infinity],
                 low: run.scaleLow, high: run.scaleHigh};
  const kinds = {speed: {axis: speed}};
  if (run.spins.length > 0) {
    const spin = {title: "Spin", unit: "rad/s", value: run.spin, bounds: [0, Infinity],
                  low: 0, high: run.spinHigh};
    kinds.spin = {axis: spin};
  }
  if (run.classes.length > 0)
    kinds.class = {title: "Last contact", axis: speed, group: run.hit, names: run.classNames};
  if (run.speciesNames.length > 1)
    kinds.species = {title: "Balls", axis: speed, group: run.species, names: run.speciesNames};
  return kinds;
}

class Legend {
  constructor(canvas, run, changed) {
    const colours = text => Uint8Array.from(atob(text), c => c.charCodeAt(0));
    this.canvas = canvas;
    this.run = run;
    this.kinds = kindsOf(run);
    this.axes = [...new Set(Object.values(this.kinds).map(k => k.axis))];
    this.colours = colours(run.colours);
    this.cycle = colours(run.cycle);
    this.bins = new Uint32Array(BINS);
    this.held = -1;
    this.paintBy("speed");
    canvas.addEventListener("pointerdown", e => {
      const y = e.offsetY, [low, high] = this.axis.bounds.map(v => this.yOf(v));
      this.held = Math.abs(y - low) < Math.abs(y - high) ? 0 : 1;
      canvas.setPointerCapture(e.pointerId);
      this.pull(y, changed);
    });
    canvas.addEventListener("pointermove", e => this.held >= 0 && this.pull(e.offsetY, changed));
    for (const end of ["pointerup", "pointercancel"])
      canvas.addEventListener(end, () => this.held = -1);
    canvas.addEventListener("dblclick", () => {
      this.showAll();
      changed();
    });
  }

  paintBy(by) {
    this.by = by;
    this.kind = this.kinds[by];
    this.axis = this.kind.axis;
    this.names = this.kind.names || [];
    this.shares = this.names.map(() => new Uint32Array(BINS));
    this.shares.push(new Uint32Array(BINS)); // of no group
    if (this.height > 0) this.place();
  }

  showAll() {
    for (const axis of this.axes) axis.bounds = [0, Infinity];
  }

  shows(ball) {
    return this.axes.every(a => a.value[ball] >= a.bounds[0] && a.value[ball] <= a.bounds[1]);
  }

  // Where to put it in a window.
  resize(width, height, ratio) {
    this.width = 190;
    this.height = Math.max(height - 96, 160);
    this.ratio = ratio;
    this.canvas.style.width = `${this.width}px`;
    this.canvas.style.height = `${this.height}px`;
    this.canvas.width = Math.round(this.width * ratio);
    this.canvas.height = Math.round(this.height * ratio);
    this.place();
  }

  place() {
    const all = Math.min(430, this.height - 110);
    this.rows = Math.min(this.names.length, Math.max(Math.floor((all - 100) / 24), 4));
    const names = this.rows > 0 ? 24 * this.rows + 40 : 0;
    const h = Math.max(all - names, 60);
    this.bar = {x: this.width - 82, y: (this.height - h + names) / 2 + 30, w: 14, h};
  }

  // How far up the axis a value is, and back.
  shareOf(value) {
    const {low, high} = this.axis;
    return (value - low) / (high - low);
  }

  valueOf(share) {
    const {low, high} = this.axis;
    return low + share * (high - low);
  }

  yOf(value) {
    const {y, h} = this.bar;
    return y + h * (1 - Math.min(Math.max(this.shareOf(value), 0), 1));
  }

  pull(y, changed) {
    const {bar, axis} = this, u = Math.min(Math.max(1 - (y - bar.y) / bar.h, 0), 1);
    const value = this.valueOf(u);
    if (this.held === 0) axis.bounds[0] = u <= 0 ? 0 : Math.min(value, axis.bounds[1]);
    else axis.bounds[1] = u >= 1 ? Infinity : Math.max(value, axis.bounds[0]);
    changed();
  }

  // Number of the colour for a value on the axis.
  step(value) {
    const u = this.shareOf(value);
    return u > 0 ? Math.min(Math.floor(u * 256), 255) : 0;
  }

  // A ball's colour into three places of an array.
  paint(ball, rgb, at) {
    const {group, names} = this.kind;
    const k = group ? group[ball] : this.step(this.axis.value[ball]);
    for (let a = 0; a < 3; a++)
      rgb[at + a] = !group ? this.colours[3 * k + a]
        : k < names.length ? this.cycle[3 * (k % 16) + a] : NO_CLASS[a];
  }

  count() {
    const {axis, kind: {group}, names, shares, bins} = this, none = names.length;
    for (const share of [bins, ...shares]) share.fill(0);
    for (let i = 0; i < axis.value.length; i++) {
      const k = this.step(axis.value[i]) * BINS >> 8;
      bins[k]++;
      shares[group ? Math.min(group[i], none) : none][k]++;
    }
  }

  css(rgb) {
    return `rgb(${rgb.join(" ")})`;
  }

  colour(k) {
    return this.css(this.colours.slice(3 * k, 3 * k + 3));
  }

  groupColour(k) {
    return this.css(k < this.names.length ? this.cycle.slice(3 * (k % 16), 3 * (k % 16) + 3)
                                          : NO_CLASS);
  }

  draw() {
    const c = this.canvas.getContext("2d"), {x, y, w, h} = this.bar;
    const ink = getComputedStyle(document.body).getPropertyValue("--ink");
    const shade = s => `rgb(${ink} / ${s})`;
    c.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    c.clearRect(0, 0, this.width, this.height);
    this.histogram(c);
    if (this.names.length > 0) {
      c.fillStyle = shade(0.3);
      c.fillRect(x, y, 2, h);
      this.list(c, shade);
    } else {
      const ramp = c.createLinearGradient(0, y + h, 0, y);
      for (let k = 0; k < 256; k += 5) ramp.addColorStop(k / 255, this.colour(k));
      c.fillStyle = ramp;
      c.fillRect(x, y, w, h);
    }
    this.ticks(c, shade);
    this.marks(c, shade);
  }

  histogram(c) {
    const {x, y, h} = this.bar, [low, high] = this.axis.bounds;
    const most = Math.max(1, ...this.bins), step = h / BINS, grouped = this.names.length > 0;
    for (let k = 0; k < BINS; k++) {
      const v = this.valueOf((k + 0.5) / BINS);
      let right = x - 5;
      c.globalAlpha = v >= low && v <= high ? 1 : 0.25;
      this.shares.forEach((share, g) => {
        const long = 84 * share[k] / most;
        c.fillStyle = grouped ? this.groupColour(g) : this.colour(Math.round((k + 0.5) * 256 / BINS));
        c.fillRect(right - long, y + h - (k + 1) * step + 0.6, long, step - 1.2);
        right -= long;
      });
    }
    c.globalAlpha = 1;
  }

  // Names of groups, above the scale: as many as there is room for.
  list(c, shade) {
    const {names, rows} = this, left = 36, top = this.bar.y - 76 - 24 * rows;
    this.write(c, this.kind.title, left, top, shade(0.92), "bold 15px");
    names.slice(0, rows).forEach((name, k) => {
      const at = top + 26 + 24 * k;
      if (k === rows - 1 && names.length > rows) {
        this.write(c, `and ${names.length - k} more`, left + 24, at, shade(0.8));
        return;
      }
      c.fillStyle = this.groupColour(k);
      c.beginPath();
      c.arc(left + 7, at - 5, 7, 0, 2 * Math.PI);
      c.fill();
      this.write(c, name, left + 24, at, shade(0.8));
    });
  }

  write(c, text, x, y, style, font = "14px") {
    c.font = `${font} "DejaVu Sans", "Segoe UI", system-ui, sans-serif`;
    c.fillStyle = style;
    c.fillText(text, x, y, this.width - x);
  }

  ticks(c, shade) {
    const {x, y, w} = this.bar, {title, unit, low, high} = this.axis;
    const raw = (high - low) / 6, power = 10 ** Math.floor(Math.log10(raw));
    const lead = raw / power, step = power * (lead < 1.5 ? 1 : lead < 3.5 ? 2 : lead < 7.5 ? 5 : 10);
    const decimals = step < 1 ? Math.ceil(-Math.log10(step) - 1e-9) : 0;
    const most = Math.max(Math.abs(low), Math.abs(high)), plain = decimals <= 5 && most < 1e7;
    const digits = Math.min(1 + Math.ceil(Math.log10(most / step)), 17);
    const first = Math.ceil(low / step - 1e-9), MOST = 16;
    c.textAlign = "left";
    for (let j = 0; j < MOST && (first + j) * step <= high + 1e-9 * step; j++) {
      const value = (first + j) * step, at = this.yOf(value);
      c.fillStyle = shade(0.55);
      c.fillRect(x + w + 2, at - 0.5, 5, 1);
      this.write(c, plain ? value.toFixed(decimals) : `${+value.toPrecision(digits)}`, x + w + 18,
                 at + 5, shade(0.8));
    }
    this.write(c, unit, x - 1, y - 15, shade(0.7));
    this.write(c, title, x - 1, y - 34, shade(0.92), "bold 15px");
  }

  marks(c, shade) {
    const {x, w} = this.bar;
    c.fillStyle = shade(0.75);
    for (const value of this.axis.bounds) {
      const at = this.yOf(value);
      c.beginPath();
      c.moveTo(x + w + 1, at);
      c.lineTo(x + w + 10, at - 6);
      c.lineTo(x + w + 10, at + 6);
      c.fill();
    }
  }
}
