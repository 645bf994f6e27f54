// The run: frames as they are stored in the page, and where everything is between them.
function bytesOf(id) {
  const text = atob(document.getElementById(id).textContent.trim());
  const bytes = new Uint8Array(text.length);
  for (let k = 0; k < text.length; k++) bytes[k] = text.charCodeAt(k);
  return bytes;
}

class Run {
  constructor() {
    Object.assign(this, JSON.parse(document.getElementById("head").textContent));
    const raw = bytesOf("frames").buffer, n = this.count;
    this.species = new Uint16Array(bytesOf("species").buffer);
    this.spins = new Uint16Array(bytesOf("spins").buffer);
    this.classes = bytesOf("classes");
    this.places = [];
    this.velocities = [];
    for (let k = 0; k < this.times.length; k++) {
      this.places.push(new Uint16Array(raw, 12 * n * k, 3 * n));
      this.velocities.push(new Int16Array(raw, 12 * n * k + 6 * n, 3 * n));
    }
    this.first = this.times[0];
    this.last = this.times[this.times.length - 1];
    this.place = new Float32Array(3 * n);
    this.speed = new Float32Array(n);
    this.spin = new Float32Array(n);
    this.hit = new Uint8Array(n);
    this.step = this.high.map((h, a) => (h - this.low[a]) / 65535);
    this.size = this.high.map((h, a) => h - this.low[a]);
  }

  radius(ball) {
    return this.radii[this.species[ball]];
  }

  // The last frame at or before a time.
  frameBefore(time) {
    let low = 0, high = this.times.length - 1;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (this.times[middle] <= time) low = middle;
      else high = middle - 1;
    }
    return low;
  }

  // Between which frames a time is, and how far.
  moment(time) {
    const from = Math.min(this.frameBefore(time), Math.max(this.times.length - 2, 0));
    const to = Math.min(from + 1, this.times.length - 1);
    const span = this.times[to] - this.times[from];
    const u = span > 0 ? Math.min(Math.max((time - this.times[from]) / span, 0), 1) : 0;
    return {from, to, span, u};
  }

  // How far from the axis of the drum a place is, across the wall that is nearest.
  outwards(x, z) {
    if (!this.facets) return Math.hypot(x, z);
    const step = 2 * Math.PI / this.facets, angle = step * Math.round(Math.atan2(x, z) / step);
    return x * Math.sin(angle) + z * Math.cos(angle);
  }

  // A centre stays inside the chamber; in periodic directions its image is shown.
  keepInside(place, at, radius) {
    if (this.shape === "drum") {
      const most = this.diameter / 2 - radius, r = this.outwards(place[at], place[at + 2]);
      if (r > most) {
        place[at] *= most / r;
        place[at + 2] *= most / r;
      }
      place[at + 1] = Math.min(Math.max(place[at + 1], radius), this.length - radius);
      return;
    }
    for (let a = 0; a < 3; a++) {
      if (this.periodic[a])
        place[at + a] -= this.size[a] * Math.floor(place[at + a] / this.size[a]);
      else
        place[at + a] = Math.min(Math.max(place[at + a], radius), this.size[a] - radius);
    }
  }

  // One ball: a cubic through both places with both velocities, which are shortened so that the
  // path does not overshoot. Writes the place to out[at ...] and returns the speed.
  ball(moment, i, out, at) {
    const {from, to, span, u} = moment, w = 1 - u;
    const p = this.places[from], q = this.places[to];
    const v = this.velocities[from], z = this.velocities[to];
    const sv = this.scales[from], sz = this.scales[to];
    let way = 0, before = 0, after = 0;
    for (let a = 0; a < 3; a++) {
      const j = 3 * i + a;
      let d = (q[j] - p[j]) * this.step[a];
      if (this.periodic[a]) { // the image that is nearest to where both velocities lead
        const even = 0.5 * span * (sv * v[j] + sz * z[j]);
        d -= this.size[a] * Math.round((d - even) / this.size[a]);
      }
      way += d * d;
      before += v[j] * v[j];
      after += z[j] * z[j];
      out[at + a] = this.low[a] + p[j] * this.step[a] + u * u * (3 - 2 * u) * d;
    }
    before = Math.sqrt(before) * sv;
    after = Math.sqrt(after) * sz;
    if (span > 0) {
      const most = 1.5 * Math.sqrt(way) / span;
      const start = sv * span * u * w * w * (before > most ? most / before : 1);
      const end = sz * span * u * u * w * (after > most ? most / after : 1);
      for (let a = 0; a < 3; a++) out[at + a] += start * v[3 * i + a] - end * z[3 * i + a];
    }
    this.keepInside(out, at, this.radius(i));
    return w * before + u * after;
  }

  // All balls.
  seek(time) {
    const moment = this.moment(time), {from, to, u} = moment, n = this.count;
    for (let i = 0; i < n; i++) this.speed[i] = this.ball(moment, i, this.place, 3 * i);
    if (this.spins.length > 0) {
      const a = (1 - u) * this.spinScales[from], b = u * this.spinScales[to];
      for (let i = 0; i < n; i++)
        this.spin[i] = a * this.spins[from * n + i] + b * this.spins[to * n + i];
    }
    if (this.classes.length > 0) this.hit.set(this.classes.subarray(from * n, (from + 1) * n));
  }
}

// How much of the sky each sphere sees past its neighbours: a linear law in its normal. One of
// radius R at distance d in the direction u takes (R/d)² max(0, n·u), and max(0, cos) is replaced by
// 1/4 + cos/2. Spheres are [x, y, z, r], laws [vector, constant].
class Occlusion {
  fill(sphere, count, law) {
    let reach = 0;
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    for (let k = 0; k < count; k++) {
      reach = Math.max(reach, 4 * sphere[4 * k + 3]);
      for (let a = 0; a < 3; a++) {
        low[a] = Math.min(low[a], sphere[4 * k + a]);
        high[a] = Math.max(high[a], sphere[4 * k + a]);
      }
    }
    law.fill(0, 0, 4 * count);
    if (!(reach > 0)) return;
    let cell = reach;
    for (let a = 0; a < 3; a++) cell = Math.max(cell, (high[a] - low[a]) / 96);
    const size = high.map((h, a) => 1 + Math.floor((h - low[a]) / cell));
    const along = (k, a) =>
      Math.min(Math.floor((sphere[4 * k + a] - low[a]) / cell), size[a] - 1);
    const index = k => (along(k, 0) * size[1] + along(k, 1)) * size[2] + along(k, 2);
    const first = new Uint32Array(size[0] * size[1] * size[2] + 1);
    const order = new Uint32Array(count);
    for (let k = 0; k < count; k++) first[index(k)]++;
    for (let c = 1; c < first.length; c++) first[c] += first[c - 1];
    for (let k = count - 1; k >= 0; k--) order[--first[index(k)]] = k;
    for (let k = 0; k < count; k++) {
      const z0 = Math.max(along(k, 2) - 1, 0), z1 = Math.min(along(k, 2) + 1, size[2] - 1);
      for (let x = Math.max(along(k, 0) - 1, 0); x <= Math.min(along(k, 0) + 1, size[0] - 1); x++)
        for (let y = Math.max(along(k, 1) - 1, 0); y <= Math.min(along(k, 1) + 1, size[1] - 1);
             y++) {
          const row = (x * size[1] + y) * size[2];
          for (let n = first[row + z0]; n < first[row + z1 + 1]; n++)
            this.add(sphere, law, k, order[n], reach * reach);
        }
    }
  }

  add(sphere, law, to, from, reach) {
    const i = 4 * to, j = 4 * from;
    const x = sphere[j] - sphere[i], y = sphere[j + 1] - sphere[i + 1];
    const z = sphere[j + 2] - sphere[i + 2], d2 = x * x + y * y + z * z;
    if (d2 >= reach || d2 <= 0) return;
    const share = sphere[j + 3] * sphere[j + 3] / d2, directed = 0.5 * share / Math.sqrt(d2);
    law[i] += directed * x;
    law[i + 1] += directed * y;
    law[i + 2] += directed * z;
    law[i + 3] += 0.25 * share;
  }
}
