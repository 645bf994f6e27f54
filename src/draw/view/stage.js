// The stage: camera, surfaces of the machine, ray-cast spheres.
const cross = (a, b) =>
  [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const unit = a => a.map(x => x / Math.hypot(...a));
const along = (a, s, b) => [a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]];

// ---------------------------------------------------------------- camera
// Looks at the chamber's middle from a direction, as near as all of the outline fits the window
// that the margins (shares of the picture) leave.
class Camera {
  constructor() {
    this.turn = 38;
    this.tilt = 18;
    this.zoom = 1;
    this.fov = 28;
    this.margin = {left: 0, right: 0, top: 0, bottom: 0};
  }

  aim(low, high, outline, width, height) {
    const a = this.turn * Math.PI / 180, e = this.tilt * Math.PI / 180;
    const ca = Math.cos(a), sa = Math.sin(a), ce = Math.cos(e), se = Math.sin(e);
    const right = [ca, sa, 0], up = [-se * sa, se * ca, ce], back = [ce * sa, -ce * ca, se];
    const half = Math.tan(this.fov * Math.PI / 360), aspect = width / height, m = this.margin;
    const wx = half * aspect * Math.max(1 - m.left - m.right, 0.05);
    const wy = half * Math.max(1 - m.top - m.bottom, 0.05);
    const middle = low.map((l, k) => (l + high[k]) / 2);
    // From every side the whole outline fits, so that turning does not change the size.
    let distance = 0;
    for (const point of outline) {
      const p = along(point, -1, middle);
      const flat = Math.hypot(p[0], p[1]);
      distance = Math.max(distance, flat * 0.82 / wx, Math.abs(dot(p, right)) / wx + dot(p, back),
                          Math.abs(dot(p, up)) / wy + dot(p, back));
    }
    const radius = 0.75 * Math.hypot(...along(high, -1, low));
    const near = Math.max(0.02 * distance, distance - 2 * radius), far = distance + 2 * radius;
    const eye = along(middle, distance, back), lens = this.zoom / half;
    this.eye = eye;
    this.view = new Float32Array([
      right[0], up[0], back[0], 0, right[1], up[1], back[1], 0, right[2], up[2], back[2], 0,
      -dot(right, eye), -dot(up, eye), -dot(back, eye), 1]);
    this.projection = new Float32Array([
      lens / aspect, 0, 0, 0, 0, lens, 0, 0, m.right - m.left, m.top - m.bottom,
      -(far + near) / (far - near), -1, 0, 0, -2 * far * near / (far - near), 0]);
    this.axes = {right, up, back, lens, aspect};
  }

  // The direction in the scene of the ray through a place of the picture, each in -1 ... 1.
  ray(x, y) {
    const {right, up, back, lens, aspect} = this.axes, m = this.margin;
    const dx = (x + m.right - m.left) * aspect / lens, dy = (y + m.top - m.bottom) / lens;
    return unit(along(along(right.map(c => c * dx), dy, up), -1, back));
  }
}

// ---------------------------------------------------------------- surfaces
// Triangles of profiles that turn about an axis: [distance, place along, normal out, normal along].
// With facets, prisms of flat sides that touch the round surface from outside, the first towards z.
class Mesh {
  constructor() {
    this.data = [];
  }

  triangle(a, b, c) {
    const turn = cross(along(b[0], -1, a[0]), along(c[0], -1, a[0]));
    if (dot(turn, turn) <= 0) return;
    const flip = dot(turn, along(along(a[1], 1, b[1]), 1, c[1])) < 0;
    for (const [place, normal] of flip ? [a, c, b] : [a, b, c]) this.data.push(...place, ...normal);
  }

  revolve(origin, axis, p, q, segments, facets = 0) {
    const sides = facets || segments, step = 2 * Math.PI / sides;
    const other = Math.abs(axis[2]) < 0.9 ? [0, 0, 1] : [0, 1, 0];
    const e1 = unit(along(other, -dot(other, axis), axis)), e2 = cross(axis, e1);
    const direction = k => along(e1.map(c => c * Math.cos(step * k)), Math.sin(step * k), e2);
    const corner = facets ? 1 / Math.cos(step / 2) : 1, back = facets ? 0.5 : 0;
    const at = ([r, h, nr, nh], side, next) => {
      const out = direction((side + next) % sides - back), facing = facets ? direction(side) : out;
      return [along(along(origin, r * corner, out), h, axis),
              unit(along(facing.map(c => c * nr), nh, axis))];
    };
    for (let k = 0; k < sides; k++) {
      const a = at(p, k, 0), b = at(q, k, 0), c = at(p, k, 1), d = at(q, k, 1);
      this.triangle(a, c, b);
      this.triangle(b, c, d);
    }
  }

  turned(origin, axis, profile, segments, facets) {
    for (let k = 0; k + 1 < profile.length; k += 2)
      this.revolve(origin, axis, profile[k], profile[k + 1], segments, facets);
  }

  bar(origin, axis, r, h0, h1) {
    const e = Math.min(0.08 * r, 0.25 * (h1 - h0));
    this.turned(origin, axis, [
      [0, h0, 0, -1], [r - e, h0, 0, -1], [r - e, h0, 1, -1], [r, h0 + e, 1, -1],
      [r, h0 + e, 1, 0], [r, h1 - e, 1, 0], [r, h1 - e, 1, 1], [r - e, h1, 1, 1],
      [r - e, h1, 0, 1], [0, h1, 0, 1]], 48);
  }

  capsule(origin, axis, r, h0, h1) {
    const profile = [[r, h0 + r, 1, 0], [r, h1 - r, 1, 0]], steps = 10;
    for (let k = 0; k < steps; k++)
      for (const s of [-1, 1])
        for (const a of [k, k + 1].map(j => Math.PI / 2 * j / steps))
          profile.push([r * Math.cos(a), (s < 0 ? h0 + r : h1 - r) + s * r * Math.sin(a),
                        Math.cos(a), s * Math.sin(a)]);
    this.turned(origin, axis, profile, 48);
  }

  ring(origin, axis, inner, outer, h0, h1, facets) {
    const e = 0.15 * Math.min(outer - inner, h1 - h0);
    this.turned(origin, axis, [
      [inner, h0, -1, 0], [inner, h1, -1, 0], [inner, h0, 0, -1], [outer - e, h0, 0, -1],
      [outer - e, h0, 1, -1], [outer, h0 + e, 1, -1], [outer, h0 + e, 1, 0], [outer, h1 - e, 1, 0],
      [outer, h1 - e, 1, 1], [outer - e, h1, 1, 1], [outer - e, h1, 0, 1], [inner, h1, 0, 1]], 96, facets);
  }

  quad(p, a, b) {
    const n = unit(cross(a, b)), q = along(along(p, 1, a), 1, b);
    this.triangle([p, n], [along(p, 1, a), n], [q, n]);
    this.triangle([p, n], [q, n], [along(p, 1, b), n]);
  }
}

const METAL = {blade: [0.80, 0.80, 0.82], shaft: [0.66, 0.67, 0.70], ring: [0.56, 0.59, 0.63],
               glass: [0.45, 0.55, 0.64]};

// The machine's parts: first vertex, count, colour, and the blade with which a part turns.
class Machine {
  constructor(run) {
    this.mesh = new Mesh();
    this.parts = [];
    for (const blade of run.blades) {
      const shape = blade.tip === "hemisphere" && blade.reach > blade.radius ? "capsule" : "bar";
      this.mesh[shape]([0, 0, 0], [0, 0, 1], blade.radius, -blade.reach, blade.reach);
      this.finish("blade", blade);
    }
    for (const s of run.shafts) {
      this.mesh.bar(s.point, s.axis, s.radius, s.from, s.to);
      this.finish("shaft");
    }
    this.outline = run.shape === "drum" ? this.drum(run) : this.box(run);
  }

  finish(kind, blade) {
    const last = this.parts[this.parts.length - 1];
    const first = last ? last.first + last.count : 0;
    this.parts.push({kind, blade, first, count: this.mesh.data.length / 6 - first});
  }

  drum({diameter, length, facets}) {
    const r = diameter / 2, thick = 0.022 * diameter, y = [0, 1, 0], o = [0, 0, 0], points = [];
    const flat = facets <= 192 ? facets : 0; // more sides cannot be told from a round drum
    this.mesh.ring(o, y, r, 1.045 * r, -thick, 0, flat);
    this.mesh.ring(o, y, r, 1.045 * r, length, length + thick, flat);
    this.finish("ring");
    this.mesh.revolve(o, y, [r, 0, 1, 0], [r, length, 1, 0], 192, flat);
    this.finish("glass");
    const corners = flat || 48, reach = 1.045 * r / (flat ? Math.cos(Math.PI / flat) : 1);
    for (let k = 0; k < 2 * corners; k++) {
      const a = 2 * Math.PI * ((k >> 1) + (flat ? 0.5 : 0)) / corners;
      points.push([reach * Math.sin(a), k & 1 ? length + thick : -thick, reach * Math.cos(a)]);
    }
    return points;
  }

  box({low, high, size}) {
    const r = 0.004 * Math.max(...size), axes = [[1, 0, 0], [0, 1, 0], [0, 0, 1]], points = [];
    for (let k = 0; k < 3; k++)
      for (let corner = 0; corner < 4; corner++) {
        const at = [...low], b = (k + 1) % 3, c = (k + 2) % 3;
        if (corner & 1) at[b] = high[b];
        if (corner & 2) at[c] = high[c];
        this.mesh.capsule(at, axes[k], r, -r, size[k] + r);
      }
    this.finish("ring");
    const [x, y, z] = axes.map((a, k) => a.map(c => c * size[k]));
    for (const [p, a, b] of [[low, y, x], [low, z, y], [low, x, z], [along(low, 1, z), x, y],
                             [along(low, 1, x), y, z], [along(low, 1, y), z, x]])
      this.mesh.quad(p, a, b);
    this.finish("glass");
    for (let k = 0; k < 8; k++) points.push([0, 1, 2].map(a => k >> a & 1 ? high[a] : low[a]));
    return points;
  }
}

const STILL = new Float32Array([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]);

// A blade's own frame: its z along the bar, its y along the rotor's axis.
function bladeModel(blade, time) {
  const angle = blade.angle + blade.omega * time, e2 = cross(blade.axis, blade.e1);
  const z = along(blade.e1.map(c => c * Math.cos(angle)), Math.sin(angle), e2);
  return new Float32Array([...cross(blade.axis, z), 0, ...blade.axis, 0, ...z, 0,
                           ...blade.centre, 1]);
}

// ---------------------------------------------------------------- programs
// Written so that both WebGL 2 and WebGL 1 understand them, by the words that HEADS define. Without
// DEPTH a ball is a disc in depth; balls are painted farthest first, so that only where one touches
// metal can this be seen.
const HEADS = {
  2: {vertex: `#version 300 es
precision highp float;
#define attribute in
#define varying out
#define FLAT flat
`, fragment: `#version 300 es
precision highp float;
#define varying in
#define FLAT flat
#define DEPTH gl_FragDepth
#define gl_FragColor paint
out vec4 paint;
`},
  1: {vertex: `precision highp float;
#define FLAT
`, fragment: `#extension GL_EXT_frag_depth : enable
#ifdef GL_EXT_frag_depth
#define DEPTH gl_FragDepthEXT
#endif
#ifdef GL_FRAGMENT_PRECISION_HIGH
precision highp float;
#else
precision mediump float;
#endif
#define FLAT
`}};

const sphereVertex = `
attribute vec2 corner;
attribute vec4 sphere, occlusion, colour;
uniform mat4 view, projection;
uniform float pixel;
FLAT varying vec3 centre, base;
FLAT varying float radius, edge;
FLAT varying vec4 shade;
varying vec3 start;
varying vec2 place;
void main() {
  centre = (view * vec4(sphere.xyz, 1.0)).xyz;
  radius = max(sphere.w, 0.5 * pixel * length(centre)); // else lost between middles of pixels
  shade = vec4((view * vec4(occlusion.xyz, 0.0)).xyz, occlusion.w);
  base = colour.rgb * colour.rgb;
  // The circle in which the tangent cone from the eye touches, and how wide a pixel is in it.
  vec3 back = -normalize(centre);
  float q = radius * radius / dot(centre, centre);
  vec3 right = normalize(vec3(back.z, 0.0, -back.x));
  float size = radius * sqrt(1.0 - min(q, 0.999));
  edge = max(pixel * length(centre) / size, 1e-6);
  place = corner * (1.0 + edge);
  start = -q * centre + size * (place.x * right + place.y * cross(back, right));
  gl_Position = projection * vec4(centre + start, 1.0);
}`;

const sphereFragment = `
FLAT varying vec3 centre, base;
FLAT varying float radius, edge;
FLAT varying vec4 shade;
varying vec3 start;
varying vec2 place;
uniform mat4 projection;
void main() {
  float cover = clamp(0.5 + (1.0 - length(place)) / edge, 0.0, 1.0);
  if (cover <= 0.0) discard;
  vec3 u = normalize(centre + start);
  float b = dot(start, u);
  float disc = max(b * b - dot(start, start) + radius * radius, 0.0);
  vec3 hit = start - (b + sqrt(disc)) * u;
  vec3 n = normalize(hit);
  float open = 1.0 / (1.0 + 1.7 * max(shade.w + dot(shade.xyz, n), 0.0));
  gl_FragColor = vec4(min(sqrt(lit(base, n, -u, open, 0.16)), vec3(1.0)), 1.0) * cover;
#ifdef DEPTH
  float z = centre.z + hit.z;
  DEPTH = 0.5 - 0.5 * (projection[2][2] * z + projection[3][2]) / z;
#endif
}`;

const solidVertex = `
attribute vec3 spot, normal;
uniform mat4 model, view, projection;
varying vec3 at, n;
void main() {
  mat4 all = view * model;
  vec4 p = all * vec4(spot, 1.0);
  at = p.xyz;
  n = (all * vec4(normal, 0.0)).xyz;
  gl_Position = projection * p;
}`;

const solidFragment = `
varying vec3 at, n;
uniform vec3 base;
uniform int glass;
void main() {
  vec3 v = normalize(-at), m = normalize(n);
  if (dot(m, v) < 0.0) m = -m;
  if (glass == 0) {
    gl_FragColor = vec4(min(sqrt(lit(base * base, m, v, 1.0, 0.35)), vec3(1.0)), 1.0);
    return;
  }
  float edge = 1.0 - dot(m, v), alpha = 0.035 + 0.42 * edge * edge * edge;
  float s = pow(max(dot(m, normalize(KEY + v)), 0.0), 128.0);
  gl_FragColor = vec4(base * alpha, alpha) + vec4(0.07 * s);
}`;

// Where attributes are: those of balls, and those of solids, so that neither meets the other's.
const SPOTS = {corner: 0, sphere: 1, occlusion: 2, colour: 3, spot: 0, normal: 4};

class Program {
  constructor(gl, version, light, vertex, fragment) {
    this.gl = gl;
    this.program = gl.createProgram();
    const heads = HEADS[version];
    for (const [kind, text] of [[gl.VERTEX_SHADER, heads.vertex + vertex],
                                [gl.FRAGMENT_SHADER, heads.fragment + light + fragment]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS))
        throw new Error(gl.getShaderInfoLog(shader));
      gl.attachShader(this.program, shader);
    }
    for (const name of vertex.match(/attribute [^;]*/g).join(" ").match(/\w+/g))
      if (name in SPOTS) gl.bindAttribLocation(this.program, SPOTS[name], name);
    gl.linkProgram(this.program);
    if (!gl.getProgramParameter(this.program, gl.LINK_STATUS))
      throw new Error(gl.getProgramInfoLog(this.program));
    this.place = {};
    const count = gl.getProgramParameter(this.program, gl.ACTIVE_UNIFORMS);
    for (let k = 0; k < count; k++) {
      const {name} = gl.getActiveUniform(this.program, k);
      this.place[name] = gl.getUniformLocation(this.program, name);
    }
  }

  use(camera) {
    this.gl.useProgram(this.program);
    this.gl.uniformMatrix4fv(this.place.view, false, camera.view);
    this.gl.uniformMatrix4fv(this.place.projection, false, camera.projection);
  }
}

// ---------------------------------------------------------------- balls
const CORNERS = [-1, -1, 1, -1, -1, 1, 1, 1];

// One instance of four corners per ball.
class Instances {
  constructor(stage) {
    const {gl} = stage;
    this.stage = stage;
    this.corner = stage.buffer(new Float32Array(CORNERS));
    this.data = [gl.createBuffer(), gl.createBuffer(), gl.createBuffer()];
  }

  draw(sphere, law, rgba, count) {
    const {stage} = this, {gl} = stage;
    stage.attribute("corner", this.corner, 2);
    [["sphere", sphere], ["occlusion", law], ["colour", rgba]].forEach(([name, array], k) => {
      gl.bindBuffer(gl.ARRAY_BUFFER, this.data[k]);
      gl.bufferData(gl.ARRAY_BUFFER, array.subarray(0, 4 * count), gl.STREAM_DRAW);
      stage.attribute(name, this.data[k], 4, {bytes: k === 2});
      gl.vertexAttribDivisor(SPOTS[name], 1);
    });
    gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, count);
  }
}

// For WebGL 1: every ball's data four times, as many balls at once as 16-bit indices can tell.
class Copies {
  constructor(stage) {
    const {gl} = stage, most = Copies.MOST;
    const corner = new Float32Array(8 * most), index = new Uint16Array(6 * most);
    for (let k = 0; k < most; k++) {
      corner.set(CORNERS, 8 * k);
      index.set([0, 1, 2, 2, 1, 3].map(c => 4 * k + c), 6 * k);
    }
    this.stage = stage;
    this.corner = stage.buffer(corner);
    this.index = gl.createBuffer();
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, this.index);
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, index, gl.STATIC_DRAW);
    this.data = [gl.createBuffer(), gl.createBuffer(), gl.createBuffer()];
    this.room = [new Float32Array(16 * most), new Float32Array(16 * most),
                 new Uint8Array(16 * most)];
  }

  draw(sphere, law, rgba, count) {
    const {stage, room} = this, {gl} = stage;
    stage.attribute("corner", this.corner, 2);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, this.index);
    for (let first = 0; first < count; first += Copies.MOST) {
      const n = Math.min(count - first, Copies.MOST);
      [["sphere", sphere], ["occlusion", law], ["colour", rgba]].forEach(([name, array], k) => {
        for (let i = 0; i < 16 * n; i++) room[k][i] = array[4 * (first + (i >> 4)) + (i & 3)];
        gl.bindBuffer(gl.ARRAY_BUFFER, this.data[k]);
        gl.bufferData(gl.ARRAY_BUFFER, room[k].subarray(0, 16 * n), gl.STREAM_DRAW);
        stage.attribute(name, this.data[k], 4, {bytes: k === 2});
      });
      gl.drawElements(gl.TRIANGLES, 6 * n, gl.UNSIGNED_SHORT, 0);
    }
  }
}
Copies.MOST = 16384;

// ---------------------------------------------------------------- stage
class Stage {
  constructor(canvas, run) {
    const wish = {antialias: true, preserveDrawingBuffer: true};
    let gl = canvas.getContext("webgl2", wish);
    this.version = gl ? 2 : 1;
    if (!gl) gl = canvas.getContext("webgl", wish);
    if (!gl)
      throw new Error("This browser offers no WebGL, which the picture needs. It may be switched " +
                      "off in its settings, or want another graphics driver.");
    this.canvas = canvas;
    this.gl = gl;
    this.camera = new Camera();
    this.machine = new Machine(run);
    this.run = run;
    this.prepare();
  }

  // Everything that lives on the graphics card; again when its context was lost.
  prepare() {
    const {gl, version} = this, {light} = this.run;
    if (version === 1) gl.getExtension("EXT_frag_depth");
    this.spheres = new Program(gl, version, light, sphereVertex, sphereFragment);
    this.solids = new Program(gl, version, light, solidVertex, solidFragment);
    this.mesh = this.buffer(new Float32Array(this.machine.mesh.data));
    this.painter = version === 2 ? new Instances(this) : new Copies(this);
    gl.enable(gl.DEPTH_TEST);
    gl.clearColor(0, 0, 0, 0);
  }

  buffer(data) {
    const {gl} = this, buffer = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ARRAY_BUFFER, data, gl.STATIC_DRAW);
    return buffer;
  }

  // Numbers as they are; bytes as shares of 255.
  attribute(name, buffer, size, {stride = 0, offset = 0, bytes = false} = {}) {
    const {gl} = this;
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.enableVertexAttribArray(SPOTS[name]);
    gl.vertexAttribPointer(SPOTS[name], size, bytes ? gl.UNSIGNED_BYTE : gl.FLOAT, bytes, stride,
                           offset);
  }

  useSolids() {
    this.solids.use(this.camera);
    this.attribute("spot", this.mesh, 3, {stride: 24});
    this.attribute("normal", this.mesh, 3, {stride: 24, offset: 12});
  }

  begin() {
    const {gl, canvas} = this;
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    this.camera.aim(this.run.low, this.run.high, this.machine.outline, canvas.width,
                    canvas.height);
  }

  parts(time, wanted) {
    const {gl, solids} = this;
    for (const part of this.machine.parts) {
      if (!wanted(part.kind)) continue;
      gl.uniformMatrix4fv(solids.place.model, false,
                          part.blade ? bladeModel(part.blade, time) : STILL);
      gl.uniform3fv(solids.place.base, METAL[part.kind]);
      gl.drawArrays(gl.TRIANGLES, part.first, part.count);
    }
  }

  metal(time, hidden) {
    this.useSolids();
    this.gl.uniform1i(this.solids.place.glass, 0);
    this.parts(time, kind => kind === "ring" ? !hidden.drum : kind !== "glass" && !hidden.rotor);
  }

  // Spheres [x, y, z, r], laws of occlusion, colours; farthest first.
  balls(sphere, law, rgba, count) {
    const {gl} = this;
    if (count === 0) return;
    this.spheres.use(this.camera);
    gl.uniform1f(this.spheres.place.pixel, 2 / (this.camera.axes.lens * this.canvas.height));
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    this.painter.draw(sphere, law, rgba, count);
    gl.disable(gl.BLEND);
  }

  glass() {
    const {gl} = this;
    this.useSolids();
    gl.uniform1i(this.solids.place.glass, 1);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    gl.depthMask(false);
    gl.enable(gl.CULL_FACE);
    for (const side of [gl.FRONT, gl.BACK]) {
      gl.cullFace(side);
      this.parts(0, kind => kind === "glass");
    }
    gl.disable(gl.CULL_FACE);
    gl.depthMask(true);
    gl.disable(gl.BLEND);
  }
}
