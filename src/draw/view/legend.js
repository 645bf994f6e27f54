// The legend: colour bar with ticks, the histogram of speeds that lives on it, two marks that
// bound the speeds shown.
const BINS = 48;

class Legend {
  constructor(canvas, run, changed) {
    this.canvas = canvas;
    this.run = run;
    this.bins = new Uint32Array(BINS);
    this.bounds = [0, Infinity];
    this.colours = Uint8Array.from(atob(run.colours), c => c.charCodeAt(0));
    this.held = -1;
    canvas.addEventListener("pointerdown", e => {
      const y = e.offsetY, [low, high] = this.bounds.map(v => this.yOf(v));
      this.held = Math.abs(y - low) < Math.abs(y - high) ? 0 : 1;
      canvas.setPointerCapture(e.pointerId);
      this.pull(y, changed);
    });
    canvas.addEventListener("pointermove", e => this.held >= 0 && this.pull(e.offsetY, changed));
    for (const end of ["pointerup", "pointercancel"])
      canvas.addEventListener(end, () => this.held = -1);
    canvas.addEventListener("dblclick", () => {
      this.bounds = [0, Infinity];
      changed();
    });
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
    const h = Math.min(430, this.height - 110);
    this.bar = {x: this.width - 82, y: (this.height - h) / 2 + 30, w: 14, h};
  }

  yOf(value) {
    const {y, h} = this.bar, {scaleLow, scaleHigh} = this.run;
    return y + h * (1 - Math.min(Math.max((value - scaleLow) / (scaleHigh - scaleLow), 0), 1));
  }

  pull(y, changed) {
    const {bar, run} = this, u = Math.min(Math.max(1 - (y - bar.y) / bar.h, 0), 1);
    const value = run.scaleLow + u * (run.scaleHigh - run.scaleLow);
    if (this.held === 0) this.bounds[0] = Math.min(value, this.bounds[1]);
    else this.bounds[1] = u >= 1 ? Infinity : Math.max(value, this.bounds[0]);
    changed();
  }

  // Number of the colour for a speed.
  step(speed) {
    const {scaleLow, scaleHigh} = this.run;
    const u = (speed - scaleLow) / (scaleHigh - scaleLow);
    return u > 0 ? Math.min(Math.floor(u * 256), 255) : 0;
  }

  count(speeds) {
    this.bins.fill(0);
    for (const v of speeds) this.bins[this.step(v) * BINS >> 8]++;
  }

  css(k) {
    return `rgb(${this.colours.slice(3 * k, 3 * k + 3).join(" ")})`;
  }

  draw() {
    const c = this.canvas.getContext("2d"), {x, y, w, h} = this.bar;
    const ink = getComputedStyle(document.body).getPropertyValue("--ink");
    const shade = s => `rgb(${ink} / ${s})`;
    c.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    c.clearRect(0, 0, this.width, this.height);
    const most = Math.max(1, ...this.bins), step = h / BINS;
    const [low, high] = this.bounds;
    for (let k = 0; k < BINS; k++) {
      const v = this.run.scaleLow + (k + 0.5) / BINS * (this.run.scaleHigh - this.run.scaleLow);
      c.globalAlpha = v >= low && v <= high ? 1 : 0.25;
      c.fillStyle = this.css(Math.round((k + 0.5) * 256 / BINS));
      const long = 84 * this.bins[k] / most;
      c.fillRect(x - 5 - long, y + h - (k + 1) * step + 0.6, long, step - 1.2);
    }
    c.globalAlpha = 1;
    const ramp = c.createLinearGradient(0, y + h, 0, y);
    for (let k = 0; k < 256; k += 5) ramp.addColorStop(k / 255, this.css(k));
    c.fillStyle = ramp;
    c.fillRect(x, y, w, h);
    this.ticks(c, shade);
    this.marks(c, shade);
  }

  ticks(c, shade) {
    const {x, y, w} = this.bar, {scaleLow, scaleHigh} = this.run;
    const raw = (scaleHigh - scaleLow) / 6, power = 10 ** Math.floor(Math.log10(raw));
    const lead = raw / power, step = power * (lead < 1.5 ? 1 : lead < 3.5 ? 2 : lead < 7.5 ? 5 : 10);
    const digits = step < 1 ? Math.ceil(-Math.log10(step) - 1e-9) : 0;
    c.font = '14px "DejaVu Sans", "Segoe UI", system-ui, sans-serif';
    c.textAlign = "left";
    for (let k = Math.ceil(scaleLow / step - 1e-9); k * step <= scaleHigh + 1e-9 * step; k++) {
      const at = this.yOf(k * step);
      c.fillStyle = shade(0.55);
      c.fillRect(x + w + 2, at - 0.5, 5, 1);
      c.fillStyle = shade(0.8);
      c.fillText((k * step).toFixed(digits), x + w + 18, at + 5);
    }
    c.fillStyle = shade(0.7);
    c.fillText("m/s", x - 1, y - 15);
    c.fillStyle = shade(0.92);
    c.font = `bold ${c.font}`.replace("14px", "15px");
    c.fillText("Speed", x - 1, y - 34);
  }

  marks(c, shade) {
    const {x, w} = this.bar;
    c.fillStyle = shade(0.75);
    for (const value of this.bounds) {
      const at = this.yOf(value);
      c.beginPath();
      c.moveTo(x + w + 1, at);
      c.lineTo(x + w + 10, at - 6);
      c.lineTo(x + w + 10, at + 6);
      c.fill();
    }
  }
}
