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
class Mesh {
  constructor() {
    this.data = [];
  }

  triangle(a, b, c) {
    const turn = cross(along(b[0], -1, a[0]), along(c[0], -1, a[0]));
    if (dot(turn, turn) <= 1e-30) return;
    const flip = dot(turn, along(along(a[1], 1, b[1]), 1, c[1])) < 0;
    for (const [place, normal] of flip ? [a, c, b] : [a, b, c]) this.data.push(...place, ...normal);
  }

  revolve(origin, axis, p, q, segments) {
    const e1 = unit(cross(Math.abs(axis[2]) < 0.9 ? [0, 0, 1] : [1, 0, 0], axis));
    const e2 = cross(axis, e1);
    const at = ([r, h, nr, nh], k) => {
      const angle = 2 * Math.PI * (k % segments) / segments;
      const out = along(e1.map(c => c * Math.cos(angle)), Math.sin(angle), e2);
      return [along(along(origin, r, out), h, axis),
              unit(along(out.map(c => c * nr), nh, axis))];
    };
    for (let k = 0; k < segments; k++) {
      const a = at(p, k), b = at(q, k), c = at(p, k + 1), d = at(q, k + 1);
      this.triangle(a, c, b);
      this.triangle(b, c, d);
    }
  }

  turned(origin, axis, profile, segments) {
    for (let k = 0; k + 1 < profile.length; k += 2)
      this.revolve(origin, axis, profile[k], profile[k + 1], segments);
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

  ring(origin, axis, inner, outer, h0, h1) {
    const e = 0.15 * Math.min(outer - inner, h1 - h0);
    this.turned(origin, axis, [
      [inner, h0, -1, 0], [inner, h1, -1, 0], [inner, h0, 0, -1], [outer - e, h0, 0, -1],
      [outer - e, h0, 1, -1], [outer, h0 + e, 1, -1], [outer, h0 + e, 1, 0], [outer, h1 - e, 1, 0],
      [outer, h1 - e, 1, 1], [outer - e, h1, 1, 1], [outer - e, h1, 0, 1], [inner, h1, 0, 1]], 96);
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

  drum({diameter, length}) {
    const r = diameter / 2, thick = 0.022 * diameter, y = [0, 1, 0], o = [0, 0, 0], points = [];
    this.mesh.ring(o, y, r, 1.045 * r, -thick, 0);
    this.mesh.ring(o, y, r, 1.045 * r, length, length + thick);
    this.finish("ring");
    this.mesh.revolve(o, y, [r, 0, 1, 0], [r, length, 1, 0], 192);
    this.finish("glass");
    for (let k = 0; k < 96; k++) {
      const a = 2 * Math.PI * (k >> 1) / 48;
      points.push([1.045 * r * Math.cos(a), k & 1 ? length + thick : -thick,
                   1.045 * r * Math.sin(a)]);
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
const sphereVertex = `
layout(location = 0) in vec4 sphere;
layout(location = 1) in vec4 occlusion;
layout(location = 2) in vec4 colour;
uniform mat4 view, projection;
flat out vec3 centre;
flat out float radius;
flat out vec4 shade;
flat out vec3 base;
out vec3 start;
out vec2 place;
void main() {
  centre = (view * vec4(sphere.xyz, 1.0)).xyz;
  radius = sphere.w;
  shade = vec4(mat3(view) * occlusion.xyz, occlusion.w);
  base = colour.rgb * colour.rgb;
  place = (vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0 - 1.0) * 1.06;
  // The circle in which the tangent cone from the eye touches.
  vec3 back = -normalize(centre);
  float q = radius * radius / dot(centre, centre);
  vec3 right = normalize(vec3(back.z, 0, -back.x));
  float size = radius * sqrt(1.0 - min(q, 0.999));
  start = -q * centre + size * (place.x * right + place.y * cross(back, right));
  gl_Position = projection * vec4(centre + start, 1.0);
}`;

const sphereFragment = `
flat in vec3 centre;
flat in float radius;
flat in vec4 shade;
flat in vec3 base;
in vec3 start;
in vec2 place;
uniform mat4 projection;
out vec4 colour;
void main() {
  float away = length(place);
  float cover = clamp(0.5 + (1.0 - away) / max(fwidth(away), 1e-6), 0.0, 1.0);
  if (cover <= 0.0) discard;
  vec3 u = normalize(centre + start);
  float b = dot(start, u);
  float disc = max(b * b - dot(start, start) + radius * radius, 0.0);
  vec3 hit = start - (b + sqrt(disc)) * u;
  vec3 n = normalize(hit);
  float open = 1.0 / (1.0 + 1.7 * max(shade.w + dot(shade.xyz, n), 0.0));
  colour = vec4(min(sqrt(lit(base, n, -u, open, 0.16)), vec3(1.0)), 1.0) * cover;
  float z = centre.z + hit.z;
  gl_FragDepth = 0.5 - 0.5 * (projection[2][2] * z + projection[3][2]) / z;
}`;

const solidVertex = `
layout(location = 0) in vec3 place;
layout(location = 1) in vec3 normal;
uniform mat4 model, view, projection;
out vec3 at, n;
void main() {
  mat4 all = view * model;
  vec4 p = all * vec4(place, 1.0);
  at = p.xyz;
  n = mat3(all) * normal;
  gl_Position = projection * p;
}`;

const solidFragment = `
in vec3 at, n;
uniform vec3 base;
uniform int glass;
out vec4 colour;
void main() {
  vec3 v = normalize(-at), m = normalize(n);
  if (dot(m, v) < 0.0) m = -m;
  if (glass == 0) {
    colour = vec4(min(sqrt(lit(base * base, m, v, 1.0, 0.35)), vec3(1.0)), 1.0);
    return;
  }
  float edge = 1.0 - dot(m, v), alpha = 0.035 + 0.42 * edge * edge * edge;
  float s = pow(max(dot(m, normalize(KEY + v)), 0.0), 128.0);
  colour = vec4(base * alpha, alpha) + vec4(0.07 * s);
}`;

class Program {
  constructor(gl, light, vertex, fragment) {
    this.gl = gl;
    this.program = gl.createProgram();
    const head = "#version 300 es\nprecision highp float;\nprecision highp int;\n";
    for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, light + fragment]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, head + text);
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS))
        throw new Error(gl.getShaderInfoLog(shader));
      gl.attachShader(this.program, shader);
    }
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

// ---------------------------------------------------------------- stage
class Stage {
  constructor(canvas, run) {
    const gl = canvas.getContext("webgl2", {antialias: true, preserveDrawingBuffer: true});
    if (!gl) throw new Error("This browser offers no WebGL 2, which the picture needs.");
    this.canvas = canvas;
    this.gl = gl;
    this.camera = new Camera();
    this.machine = new Machine(run);
    this.run = run;
    this.room = 0;
    this.prepare();
  }

  // Everything that lives on the graphics card; again when its context was lost.
  prepare() {
    const gl = this.gl;
    this.spheres = new Program(gl, this.run.light, sphereVertex, sphereFragment);
    this.solids = new Program(gl, this.run.light, solidVertex, solidFragment);
    this.solidArray = this.array(new Float32Array(this.machine.mesh.data), [3, 3]);
    this.sphereArray = gl.createVertexArray();
    this.sphereBuffers = [gl.createBuffer(), gl.createBuffer(), gl.createBuffer()];
    gl.bindVertexArray(this.sphereArray);
    this.sphereBuffers.forEach((buffer, k) => {
      gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
      gl.enableVertexAttribArray(k);
      if (k < 2) gl.vertexAttribPointer(k, 4, gl.FLOAT, false, 16, 0);
      else gl.vertexAttribPointer(k, 4, gl.UNSIGNED_BYTE, true, 4, 0);
      gl.vertexAttribDivisor(k, 1);
    });
    gl.enable(gl.DEPTH_TEST);
    gl.clearColor(0, 0, 0, 0);
  }

  array(data, sizes) {
    const gl = this.gl, array = gl.createVertexArray(), stride = 4 * sizes.reduce((a, b) => a + b);
    gl.bindVertexArray(array);
    gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ARRAY_BUFFER, data, gl.STATIC_DRAW);
    sizes.reduce((offset, size, k) => {
      gl.enableVertexAttribArray(k);
      gl.vertexAttribPointer(k, size, gl.FLOAT, false, stride, offset);
      return offset + 4 * size;
    }, 0);
    return array;
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
    const {gl, solids} = this;
    solids.use(this.camera);
    gl.bindVertexArray(this.solidArray);
    gl.uniform1i(solids.place.glass, 0);
    this.parts(time, kind => kind === "ring" ? !hidden.drum : kind !== "glass" && !hidden.rotor);
  }

  // Spheres [x, y, z, r], laws of occlusion, colours; farthest first.
  balls(sphere, law, rgba, count) {
    const {gl} = this;
    if (count === 0) return;
    this.spheres.use(this.camera);
    gl.bindVertexArray(this.sphereArray);
    [sphere.subarray(0, 4 * count), law.subarray(0, 4 * count), rgba.subarray(0, 4 * count)]
      .forEach((data, k) => {
        gl.bindBuffer(gl.ARRAY_BUFFER, this.sphereBuffers[k]);
        gl.bufferData(gl.ARRAY_BUFFER, data, gl.STREAM_DRAW);
      });
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, count);
    gl.disable(gl.BLEND);
  }

  glass() {
    const {gl, solids} = this;
    solids.use(this.camera);
    gl.bindVertexArray(this.solidArray);
    gl.uniform1i(solids.place.glass, 1);
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
