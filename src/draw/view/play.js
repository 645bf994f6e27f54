// The player: time, choice of balls, trails, and what people do with mouse, fingers and keys.
const RATES = [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10000];
const TRAIL = {most: 20, beads: 320, colours: [[217, 95, 14], [184, 50, 112], [31, 95, 168],
                                              [27, 138, 90], [106, 76, 165], [140, 109, 31]]};
const $ = id => document.getElementById(id);

class Player {
  constructor() {
    this.run = new Run();
    this.legend = new Legend($("legend"), this.run, () => this.change());
    this.stage = new Stage($("stage"), this.run);
    this.occlusion = new Occlusion();
    this.hidden = {rotor: false, drum: false, balls: false};
    this.trails = [];
    this.time = this.run.first;
    this.playing = true;
    this.slow = this.goodRate();
    this.decimals = this.goodDecimals();
    this.trailTime = Math.min(0.05, (this.run.last - this.run.first) / 4);
    this.makeRoom(this.run.count + TRAIL.most * TRAIL.beads);
    this.texts();
    document.body.classList.toggle("dark", this.run.dark);
    this.controls();
    this.gestures();
    this.obey(location.hash);
    addEventListener("hashchange", () => this.obey(location.hash));
    new ResizeObserver(() => this.resize()).observe($("stage"));
    this.resize();
    this.before = performance.now();
    requestAnimationFrame(now => this.tick(now));
  }

  // The rate at which the run lasts about twenty seconds, and frames do not rush by.
  goodRate() {
    const {times, first, last} = this.run;
    const frames = Math.max(times.length - 1, 1), span = Math.max(last - first, 1e-9);
    const wanted = Math.min(20, Math.max(frames / 10, 4)) / span;
    return RATES.reduce((a, b) => Math.abs(Math.log(b / wanted)) < Math.abs(Math.log(a / wanted))
                                    ? b : a);
  }

  // Of the time: a thousandth of the run can be told.
  goodDecimals() {
    const span = this.run.last - this.run.first;
    return span > 0 ? Math.min(Math.max(3 - Math.floor(Math.log10(span)), 4), 12) : 4;
  }

  makeRoom(count) {
    this.sphere = new Float32Array(4 * count);
    this.law = new Float32Array(4 * count);
    this.rgba = new Uint8Array(4 * count);
    this.sorted = {sphere: this.sphere.slice(), law: this.law.slice(), rgba: this.rgba.slice()};
    this.depth = new Float32Array(count);
  }

  texts() {
    document.title = this.run.title || "Eventmill";
    $("title").textContent = this.run.title;
    $("point").textContent = this.run.point;
    for (const r of RATES)
      $("rate").add(new Option(r === 1 ? "real time" : `${r} × slower`, r));
    const words = {speed: "by speed", spin: "by spin", class: "by last contact",
                   species: "by species"};
    for (const by of Object.keys(this.legend.kinds)) $("colour").add(new Option(words[by], by));
    $("colour").hidden = $("colour").length < 2;
    $("scrub").min = this.run.first;
    $("scrub").max = this.run.last;
  }

  change() {
    this.dirty = true;
  }

  resize() {
    const ratio = Math.min(devicePixelRatio || 1, 2), canvas = $("stage");
    const width = canvas.clientWidth, height = canvas.clientHeight;
    canvas.width = Math.max(1, Math.round(width * ratio));
    canvas.height = Math.max(1, Math.round(height * ratio));
    const wide = width > 760;
    $("legend").hidden = !wide;
    this.stage.camera.margin = {left: (wide ? 40 : 12) / width, right: (wide ? 200 : 12) / width,
                                top: 84 / height, bottom: (wide ? 88 : 130) / height};
    this.legend.resize(width, height, ratio);
    this.draw(); // now, since a canvas of new size is empty
  }

  // ---------------------------------------------------------------- drawing
  tick(now) {
    const gone = Math.min((now - this.before) / 1000, 0.1);
    this.before = now;
    if (this.playing) {
      this.time += gone / this.slow;
      if (this.time > this.run.last) this.time = this.run.first;
      this.change();
    }
    if (this.dirty) this.draw();
    requestAnimationFrame(t => this.tick(t));
  }

  draw() {
    this.dirty = false;
    this.run.seek(this.time);
    this.legend.count();
    const shown = this.collect(), all = shown + this.addTrails(shown);
    this.stage.begin();
    this.stage.metal(this.time, this.hidden);
    this.occlusion.fill(this.sphere, shown, this.law);
    this.law.fill(0, 4 * shown, 4 * all);
    this.sort(all);
    this.stage.balls(this.sorted.sphere, this.sorted.law, this.sorted.rgba, all);
    if (!this.hidden.drum) this.stage.glass();
    this.legend.draw();
    this.tell(shown);
  }

  // The balls that are to be seen, with their colours.
  collect() {
    const {run, legend, sphere, rgba} = this;
    let n = 0;
    for (let i = 0; i < run.count && !this.hidden.balls; i++) {
      if (!legend.shows(i)) continue;
      for (let a = 0; a < 3; a++) sphere[4 * n + a] = run.place[3 * i + a];
      legend.paint(i, rgba, 4 * n);
      sphere[4 * n + 3] = run.radius(i);
      rgba[4 * n + 3] = 255;
      n++;
    }
    return n;
  }

  // Trails are strings of beads; a chosen ball is seen even when all others are hidden.
  addTrails(first) {
    const {run, sphere, rgba} = this;
    let n = first;
    this.trails.forEach((ball, k) => {
      const colour = TRAIL.colours[k % TRAIL.colours.length];
      for (let j = 0; j < TRAIL.beads; j++) {
        const age = j / (TRAIL.beads - 1), time = this.time - age * this.trailTime;
        if (time < run.first) break;
        run.ball(run.moment(time), ball, sphere, 4 * n);
        sphere[4 * n + 3] = run.radius(ball) * (j === 0 ? 1.04 : 0.34 - 0.22 * age);
        for (let a = 0; a < 3; a++) rgba[4 * n + a] = colour[a];
        rgba[4 * n++ + 3] = 255;
      }
    });
    return n - first;
  }

  // Farthest first, by counting in narrow slices of depth.
  sort(count) {
    const {depth, sphere, sorted} = this, m = this.stage.camera.view, SLICES = 16384;
    let low = Infinity, high = -Infinity;
    for (let k = 0; k < count; k++) {
      depth[k] = m[2] * sphere[4 * k] + m[6] * sphere[4 * k + 1] + m[10] * sphere[4 * k + 2];
      low = Math.min(low, depth[k]);
      high = Math.max(high, depth[k]);
    }
    const scale = high > low ? (SLICES - 1) / (high - low) : 0;
    const slice = k => Math.floor((depth[k] - low) * scale);
    const first = new Uint32Array(SLICES + 1);
    for (let k = 0; k < count; k++) first[slice(k)]++;
    for (let c = 1; c <= SLICES; c++) first[c] += first[c - 1];
    for (let k = count - 1; k >= 0; k--) {
      const to = 4 * --first[slice(k)];
      for (let a = 0; a < 4; a++) {
        sorted.sphere[to + a] = sphere[4 * k + a];
        sorted.law[to + a] = this.law[4 * k + a];
        sorted.rgba[to + a] = this.rgba[4 * k + a];
      }
    }
  }

  tell(shown) {
    const {run, legend} = this;
    const ranges = legend.axes.filter(a => a.bounds[0] > 0 || a.bounds[1] < Infinity).map(a => {
      const [low, high] = a.bounds.map(v => v.toPrecision(3));
      return `${a.title.toLowerCase()} ` + (a.bounds[1] === Infinity
        ? `above ${low} ${a.unit}` : `between ${low} and ${high} ${a.unit}`);
    });
    $("time").textContent = `t = ${this.time.toFixed(this.decimals)} s`;
    $("scrub").value = this.time;
    $("rate").value = this.slow;
    $("play").textContent = this.playing ? "❚❚" : "▶";
    $("colour").value = legend.by;
    $("shown").textContent = ranges.length > 0
      ? `${shown} of ${run.count} balls: ${ranges.join(", ")}` : run.limited
        ? `${run.count} of ${run.total} balls are shown` : "";
    for (const what of ["rotor", "drum", "balls"])
      $(what).setAttribute("aria-pressed", !this.hidden[what]);
    Object.assign(document.body.dataset, {time: this.time.toFixed(6), shown, ready: "yes"});
  }

  // ---------------------------------------------------------------- what people do
  go(time) {
    this.time = Math.min(Math.max(time, this.run.first), this.run.last);
    this.change();
  }

  pause(still = true) {
    this.playing = !still;
    this.change();
  }

  toggle(what) {
    this.hidden[what] = !this.hidden[what];
    this.change();
  }

  rate(steps) {
    const k = RATES.indexOf(this.slow) + steps;
    this.slow = RATES[Math.min(Math.max(k, 0), RATES.length - 1)];
    this.change();
  }

  frame(steps) {
    const {run} = this, k = run.frameBefore(this.time + 1e-9) + steps;
    this.pause();
    this.go(run.times[Math.min(Math.max(k, 0), run.times.length - 1)]);
  }

  look(turn, tilt, zoom) {
    Object.assign(this.stage.camera, {
      turn, tilt: Math.min(Math.max(tilt, -90), 90), zoom: Math.min(Math.max(zoom, 0.3), 40)});
    this.change();
  }

  paintBy(by) {
    if (by in this.legend.kinds) this.legend.paintBy(by);
    this.change();
  }

  // The address's #t=0.3&paused&turn=20&tilt=10&zoom=2&hide=drum,rotor&speeds=1:5&spins=0:900
  // &trail=3,8&rate=50&colour=spin&dark
  obey(hash) {
    const given = new URLSearchParams(hash.slice(1)), camera = this.stage.camera;
    const number = (name, old) => Number.isFinite(parseFloat(given.get(name)))
      ? parseFloat(given.get(name)) : old;
    if (given.has("paused")) this.pause();
    if (given.has("dark")) document.body.classList.add("dark");
    for (const what of (given.get("hide") || "").split(","))
      if (what in this.hidden) this.hidden[what] = true;
    for (const axis of this.legend.axes) {
      const range = given.get(`${axis.title.toLowerCase()}s`);
      if (range === null) continue;
      const [low, high] = range.split(":").map(parseFloat);
      axis.bounds = [low || 0, high > 0 ? high : Infinity];
    }
    if (given.has("colour")) this.paintBy(given.get("colour"));
    if (given.has("trail"))
      this.trails = given.get("trail").split(",").map(Number)
        .filter(b => Number.isInteger(b) && b >= 0 && b < this.run.count).slice(0, TRAIL.most);
    this.look(number("turn", camera.turn), number("tilt", camera.tilt), number("zoom", camera.zoom));
    if (RATES.includes(number("rate", 0))) this.slow = number("rate", 0);
    this.go(number("t", this.time));
  }

  controls() {
    $("play").onclick = () => this.pause(this.playing);
    $("scrub").oninput = () => {
      this.pause();
      this.go(Number($("scrub").value));
    };
    $("rate").onchange = () => this.slow = Number($("rate").value);
    $("colour").onchange = () => this.paintBy($("colour").value);
    for (const what of ["rotor", "drum", "balls"]) $(what).onclick = () => this.toggle(what);
    $("night").onclick = () => this.night();
    $("about").onclick = () => $("help").showModal();
    $("help").onclick = () => $("help").close();
    const keys = {
      " ": () => this.pause(this.playing), ArrowLeft: () => this.frame(-1),
      ArrowRight: () => this.frame(1), Home: () => this.go(this.run.first),
      End: () => this.go(this.run.last), "+": () => this.rate(-1), "=": () => this.rate(-1),
      "-": () => this.rate(1), 1: () => this.look(38, 18, 1), 2: () => this.look(0, 0, 1),
      3: () => this.look(90, 0, 1), r: () => this.toggle("rotor"), d: () => this.toggle("drum"),
      b: () => this.toggle("balls"), n: () => this.night(), "?": () => $("help").showModal(),
      t: () => {
        this.trails = [];
        this.change();
      },
      s: () => {
        this.legend.showAll();
        this.change();
      },
      c: () => {
        const kinds = Object.keys(this.legend.kinds);
        this.paintBy(kinds[(kinds.indexOf(this.legend.by) + 1) % kinds.length]);
      },
    };
    addEventListener("keydown", e => {
      if (!(e.key in keys) || e.ctrlKey || e.metaKey || e.altKey || $("help").open) return;
      if (e.target.tagName === "SELECT") return;
      e.preventDefault();
      keys[e.key]();
    });
  }

  night() {
    document.body.classList.toggle("dark");
    this.change();
  }

  gestures() {
    const canvas = $("stage"), camera = this.stage.camera, fingers = new Map();
    let moved = 0;
    const spread = () => {
      const [a, b] = [...fingers.values()];
      return Math.hypot(a.x - b.x, a.y - b.y);
    };
    canvas.addEventListener("pointerdown", e => {
      canvas.setPointerCapture(e.pointerId);
      fingers.set(e.pointerId, {x: e.offsetX, y: e.offsetY});
      moved = fingers.size > 1 ? 100 : 0;
    });
    canvas.addEventListener("pointermove", e => {
      const old = fingers.get(e.pointerId);
      if (!old) return;
      const dx = e.offsetX - old.x, dy = e.offsetY - old.y;
      const gap = fingers.size === 2 ? spread() : 0;
      fingers.set(e.pointerId, {x: e.offsetX, y: e.offsetY});
      moved += Math.abs(dx) + Math.abs(dy);
      if (gap > 0) this.look(camera.turn, camera.tilt, camera.zoom * spread() / gap);
      else if (moved > 4) this.look(camera.turn - 0.4 * dx, camera.tilt + 0.4 * dy, camera.zoom);
    });
    canvas.addEventListener("pointerup", e => {
      if (fingers.delete(e.pointerId) && moved <= 4) this.pick(e.offsetX, e.offsetY);
    });
    canvas.addEventListener("pointercancel", e => fingers.delete(e.pointerId));
    canvas.addEventListener("wheel", e => {
      e.preventDefault();
      this.look(camera.turn, camera.tilt, camera.zoom * Math.exp(-0.001 * e.deltaY));
    }, {passive: false});
    canvas.addEventListener("webglcontextlost", e => e.preventDefault());
    canvas.addEventListener("webglcontextrestored", () => {
      this.stage.prepare();
      this.change();
    });
  }

  // The nearest visible ball under a place of the window gets a trail, or loses it.
  pick(x, y) {
    const canvas = $("stage"), {camera} = this.stage, {run} = this;
    const ray = camera.ray(2 * x / canvas.clientWidth - 1, 1 - 2 * y / canvas.clientHeight);
    let best = -1, nearest = Infinity;
    for (let i = 0; i < run.count; i++) {
      if (!this.legend.shows(i)) continue;
      const p = along([...run.place.subarray(3 * i, 3 * i + 3)], -1, camera.eye);
      const way = dot(p, ray), off = dot(p, p) - way * way, r = run.radius(i);
      if (off < r * r && way < nearest) {
        nearest = way;
        best = i;
      }
    }
    if (best < 0) return;
    const k = this.trails.indexOf(best);
    if (k >= 0) this.trails.splice(k, 1);
    else if (this.trails.length < TRAIL.most) this.trails.push(best);
    this.change();
  }

  // Draws, and counts what the picture shows: pixels that are not empty, a sum of all of them.
  probe() {
    this.draw();
    const {gl} = this.stage, {width, height} = this.stage.canvas;
    const pixel = new Uint8Array(4 * width * height);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
    let drawn = 0, sum = 0;
    const colours = new Set();
    for (let k = 0; k < pixel.length; k += 4) {
      if (pixel[k + 3] > 0) drawn++;
      sum = (sum * 31 + pixel[k] + 7 * pixel[k + 1] + 13 * pixel[k + 2]) % 4294967291;
      if (pixel[k + 3] === 255) colours.add(pixel[k] >> 4 << 8 | pixel[k + 1] >> 4 << 4 |
                                            pixel[k + 2] >> 4);
    }
    return {drawn: drawn / (width * height), sum, colours: colours.size, error: gl.getError(),
            time: this.time, shown: Number(document.body.dataset.shown)};
  }
}

let player;
try {
  player = new Player();
} catch (trouble) {
  $("trouble").hidden = false;
  $("trouble").textContent = trouble.message;
  document.querySelector(".bar").style.display = "none";
  document.body.dataset.ready = "no";
  throw trouble;
}
