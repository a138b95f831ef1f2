// SPDX-License-Identifier: Apache-2.0
'use strict';
(async () => {
const box = document.getElementById('viewer'), canvas = box.querySelector('canvas');
const text = (id) => document.getElementById(id).textContent;
const fail = (why) => { const p = document.createElement('p'); p.style.padding = '16px';
  p.textContent = 'The viewer cannot start: ' + why; box.replaceChildren(p); };
const gl = canvas.getContext('webgl2', {antialias: true});
if (!gl) return fail('this browser has no WebGL 2. The pictures below show the same bake.');
if (!window.DecompressionStream) return fail('this browser is too old to unpack the data.');
const head = JSON.parse(text('viewer-head')), frames = head.frames.length;

// Triangles, weights, then by frame and axis the folded differences: low bytes, high bytes.
const coded = atob(text('viewer-data'));
const raw = Uint8Array.from(coded, (c) => c.charCodeAt(0));
const stream = new Blob([raw]).stream().pipeThrough(new DecompressionStream('deflate'));
const bytes = new Uint8Array(await new Response(stream).arrayBuffer());
let at = 0;
for (const mesh of head.meshes) {
  const n = mesh.vertices;
  mesh.index = new Uint32Array(bytes.slice(at, at += 12 * mesh.triangles).buffer);
  mesh.weight = mesh.weighted ? bytes.slice(at, at += n) : new Uint8Array(n);
  const rows = 3 * (frames + mesh.rest);  // the rest pose first
  mesh.steps = new Uint16Array(n * rows);
  for (let row = 0; row < rows; ++row, at += 2 * n) {
    for (let v = 0; v < n; ++v) {
      const folded = bytes[at + v] | bytes[at + n + v] << 8;
      const before = row < 3 ? 0 : mesh.steps[(row - 3) * n + v];
      mesh.steps[row * n + v] = before + ((folded >> 1) ^ -(folded & 1));
    }
  }
  if (mesh.rest) {
    mesh.bind = mesh.steps.slice(0, 3 * n);
    mesh.steps = mesh.steps.slice(3 * n);
  }
}

const vertex = `#version 300 es
layout(location = 0) in vec3 place;
layout(location = 1) in vec3 across;
layout(location = 2) in float weight;
uniform mat4 view, lens; out vec3 normal, spot; out float share;
void main() { vec4 p = view * vec4(place, 1); spot = p.xyz; gl_Position = lens * p;
  normal = mat3(view) * across; share = weight; }`;
const fragment = `#version 300 es
precision highp float;
in vec3 normal, spot; in float share; uniform vec4 base; uniform float level; out vec4 colour;
vec3 ramp(float t) { t = 3.0 * clamp(t, 0.0, 1.0);
  vec3 c = mix(vec3(.93, .92, .87), vec3(.95, .72, .36), clamp(t, 0.0, 1.0));
  c = mix(c, vec3(.80, .27, .22), clamp(t - 1.0, 0.0, 1.0));
  return mix(c, vec3(.33, .07, .24), clamp(t - 2.0, 0.0, 1.0)); }
vec3 stretched(float t) { vec3 even = vec3(.97, .96, .94);
  return t < .5 ? mix(vec3(.13, .40, .67), even, 2.0 * t)
                : mix(even, vec3(.70, .09, .17), 2.0 * t - 1.0); }
void main() { vec3 n = normalize(normal); vec3 eye = normalize(-spot);
  if (dot(n, eye) < 0.0) n = -n;
  vec3 c = level == -1.0 ? base.rgb : level == -2.0 ? ramp(share) :
      level == -3.0 ? stretched(share) : ramp(level);
  float key = max(dot(n, normalize(vec3(.45, .7, .6))), 0.0), sky = .5 + .5 * n.y;
  vec3 lit = c * (.34 + .28 * sky + .52 * key);
  lit += .10 * pow(max(dot(reflect(-normalize(vec3(.45, .7, .6)), n), eye), 0.0), 24.0);
  float rim = 1.0 - abs(dot(n, eye));
  colour = vec4(lit, base.a < 1.0 ? mix(base.a, 0.75, rim * rim) : 1.0); }`;
const program = gl.createProgram();
for (const [kind, source] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
  const shader = gl.createShader(kind);
  gl.shaderSource(shader, source);
  gl.compileShader(shader);
  if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) return fail(gl.getShaderInfoLog(shader));
  gl.attachShader(program, shader);
}
gl.linkProgram(program);
if (!gl.getProgramParameter(program, gl.LINK_STATUS)) return fail(gl.getProgramInfoLog(program));
gl.useProgram(program);
const where = Object.fromEntries(['view', 'lens', 'base', 'level'].map(
    (name) => [name, gl.getUniformLocation(program, name)]));

for (const mesh of head.meshes) {
  mesh.array = gl.createVertexArray();
  gl.bindVertexArray(mesh.array);
  mesh.place = new Float32Array(3 * mesh.vertices);
  mesh.across = new Float32Array(3 * mesh.vertices);
  mesh.buffers = [mesh.place, mesh.across].map((values, i) => {
    const buffer = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ARRAY_BUFFER, values.byteLength, gl.DYNAMIC_DRAW);
    gl.vertexAttribPointer(i, 3, gl.FLOAT, false, 0, 0);
    gl.enableVertexAttribArray(i);
    return buffer;
  });
  gl.bindBuffer(gl.ARRAY_BUFFER, mesh.shares = gl.createBuffer());
  gl.bufferData(gl.ARRAY_BUFFER, mesh.weight, mesh.bind ? gl.DYNAMIC_DRAW : gl.STATIC_DRAW);
  gl.vertexAttribPointer(2, 1, gl.UNSIGNED_BYTE, true, 0, 0);
  gl.enableVertexAttribArray(2);
  gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
  gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, mesh.index, gl.STATIC_DRAW);
  mesh.shown = -1;
}

// The larger principal stretch of a triangle: the root of the larger eigenvalue of C = F^T F. a, b:
// its edges at rest, u, v now.
function stretch_of(a, b, u, v) {
  const dot = (p, q) => p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
  const l = Math.sqrt(dot(a, a)), c = dot(a, b) / l, h = Math.sqrt(Math.max(dot(b, b) - c * c, 0));
  if (!(l * h > 0)) return [0, 1];
  const x = u.map((w) => w / l), y = v.map((w, i) => (w - c * x[i]) / h);
  const xx = dot(x, x), yy = dot(y, y), xy = dot(x, y);
  return [l * h, Math.sqrt((xx + yy) / 2 + Math.hypot((xx - yy) / 2, xy))];
}

// By node, mean by the area at rest of the triangles around it: 1/2 to 2 as 0 to 255, by octaves.
function load_stretch(mesh, frame) {
  if (mesh.stretched === frame) return;
  mesh.stretched = frame;
  const {index, steps, bind, vertices: n, place: p} = mesh;
  const area = new Float64Array(n), sum = new Float64Array(n);
  const rest = (i, j) => [0, 1, 2].map((a) => head.step * (bind[a * n + j] - bind[a * n + i]));
  const now = (i, j) => [0, 1, 2].map((a) => p[3 * j + a] - p[3 * i + a]);
  for (let t = 0; t < index.length; t += 3) {
    const [i, j, k] = index.subarray(t, t + 3);
    const [size, stretch] = stretch_of(rest(i, j), rest(i, k), now(i, j), now(i, k));
    for (const c of [i, j, k]) { area[c] += size; sum[c] += size * stretch; }
  }
  mesh.stretch = sum.map((s, v) => area[v] > 0 ? s / area[v] : 1);
  const bytes = Uint8Array.from(mesh.stretch,
      (s) => Math.round(255 * Math.max(0, Math.min(1, (Math.log2(s) + 1) / 2))));
  gl.bindBuffer(gl.ARRAY_BUFFER, mesh.shares);
  gl.bufferSubData(gl.ARRAY_BUFFER, 0, bytes);
}

// Positions and normals (sums of the triangles' cross products) of one frame.
function load(mesh, frame) {
  if (mesh.shown === frame) return;
  mesh.shown = frame;
  const {place: p, across: m, index, steps, vertices: n} = mesh;
  for (let v = 0; v < n; ++v) {
    for (let a = 0; a < 3; ++a) {
      p[3 * v + a] = head.low[a] + head.step * steps[(3 * frame + a) * n + v];
    }
  }
  m.fill(0);
  for (let t = 0; t < index.length; t += 3) {
    const i = 3 * index[t], j = 3 * index[t + 1], k = 3 * index[t + 2];
    const ax = p[j] - p[i], ay = p[j + 1] - p[i + 1], az = p[j + 2] - p[i + 2];
    const bx = p[k] - p[i], by = p[k + 1] - p[i + 1], bz = p[k + 2] - p[i + 2];
    const x = ay * bz - az * by, y = az * bx - ax * bz, z = ax * by - ay * bx;
    for (const c of [i, j, k]) { m[c] += x; m[c + 1] += y; m[c + 2] += z; }
  }
  // Areas are small numbers: to length 1, so that single precision keeps them apart from 0.
  for (let c = 0; c < m.length; c += 3) {
    const length = Math.hypot(m[c], m[c + 1], m[c + 2]) || 1;
    m[c] /= length; m[c + 1] /= length; m[c + 2] /= length;
  }
  [p, m].forEach((values, i) => {
    gl.bindBuffer(gl.ARRAY_BUFFER, mesh.buffers[i]);
    gl.bufferSubData(gl.ARRAY_BUFFER, 0, values);
  });
}

let low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
for (const mesh of head.meshes) {
  for (let row = 0; row < 3 * frames; ++row) {
    const a = row % 3;
    for (let v = 0; v < mesh.vertices; ++v) {
      const x = head.low[a] + head.step * mesh.steps[row * mesh.vertices + v];
      if (x < low[a]) low[a] = x;
      if (x > high[a]) high[a] = x;
    }
  }
}
const radius = 0.5 * Math.hypot(...high.map((h, a) => h - low[a]));
const home = () => ({yaw: 0.7, pitch: 0.15, far: 2.9 * radius,
                     target: low.map((l, a) => 0.5 * (l + high[a]))});
let eye = home(), frame = 0, playing = false, started = 0, asked = false;

const [play, range, told] =
    ['button', 'input[type=range]', 'output'].map((q) => box.querySelector(q));
const control = (name) => box.querySelector(`[name=${name}]`);
for (const mesh of head.meshes) {
  if (mesh.kind !== 'muscle') continue;
  control('alone').add(new Option(mesh.name.replaceAll('_', ' '), mesh.name));
}
const colours = {muscle: [0.66, 0.23, 0.19], bone: [0.88, 0.84, 0.74], skin: [0.86, 0.68, 0.58],
  prop: [0.44, 0.50, 0.56]};
const rgb = (hex) => [1, 3, 5].map((i) => parseInt(hex.slice(i, i + 2), 16) / 255);
const decade = (error) => error > 0 ? (Math.log10(error) + 17) / 15 : 0;  // 1e-17 to 1e-2
range.max = frames - 1;
for (const kind of ['muscle', 'bone', 'skin', 'prop']) {
  if (!head.meshes.some((mesh) => mesh.kind === kind)) control(kind).closest('label').hidden = true;
}

// The eye's axes in the world.
function axes() {
  const [cy, sy] = [Math.cos(eye.yaw), Math.sin(eye.yaw)];
  const [cp, sp] = [Math.cos(eye.pitch), Math.sin(eye.pitch)];
  return [[cy, 0, -sy], [-sy * sp, cp, -cy * sp], [sy * cp, sp, cy * cp]];
}

function draw() {
  asked = false;
  const ratio = window.devicePixelRatio || 1;
  const [width, height] =
      [canvas.clientWidth, canvas.clientHeight].map((size) => Math.round(size * ratio));
  if (canvas.width !== width || canvas.height !== height) {
    canvas.width = width;
    canvas.height = height;
  }
  gl.viewport(0, 0, width, height);
  gl.clearColor(0, 0, 0, 0);
  gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
  gl.enable(gl.DEPTH_TEST);
  gl.depthFunc(gl.LEQUAL);
  const [right, up, back] = axes();
  const dot = (a) => -(a[0] * eye.target[0] + a[1] * eye.target[1] + a[2] * eye.target[2]);
  gl.uniformMatrix4fv(where.view, false, [right[0], up[0], back[0], 0, right[1], up[1], back[1], 0,
      right[2], up[2], back[2], 0, dot(right), dot(up), dot(back) - eye.far, 1]);
  const f = 1 / Math.tan(0.3);
  const near = Math.max(eye.far - 2.2 * radius, 0.01 * radius), far = eye.far + 2.2 * radius;
  gl.uniformMatrix4fv(where.lens, false, [f * Math.min(1, height / width), 0, 0, 0,
      0, f * Math.min(1, width / height), 0, 0, 0, 0, (far + near) / (near - far), -1,
      0, 0, 2 * far * near / (near - far), 0]);
  const by = control('colour').value, shown = Number(control('skin').value);
  const skin = by === 'stretch' && shown > 0 ? 2 : shown;  // colours want a solid surface
  const alone = control('alone').value;
  for (const mesh of head.meshes) {
    if (mesh.kind === 'skin' ? skin === 0 : !control(mesh.kind).checked) continue;
    if (alone && mesh.kind === 'muscle' && mesh.name !== alone) continue;
    load(mesh, frame);
    gl.bindVertexArray(mesh.array);
    let base = [...colours[mesh.kind], 1], level = -1;
    if (mesh.kind === 'muscle' && by === 'muscle') base = [...rgb(mesh.colour), 1];
    if (mesh.kind === 'bone' && (by === 'weight' || by === 'error')) base = [0.62, 0.66, 0.70, 1];
    if (mesh.kind === 'muscle' && by === 'weight') level = -2;
    if (mesh.kind === 'muscle' && by === 'error' && mesh.errors.length) {
      level = decade(mesh.errors[frame]);
    }
    if (mesh.bind && by === 'stretch') {
      load_stretch(mesh, frame);
      level = -3;
    }
    mesh.level = level;
    mesh.paint = () => {
      gl.uniform4fv(where.base, base);
      gl.uniform1f(where.level, level);
      gl.drawElements(gl.TRIANGLES, mesh.index.length, gl.UNSIGNED_INT, 0);
    };
    if (mesh.kind !== 'skin' || skin === 2) mesh.paint();
  }
  // Of see-through skin only the nearest layer: its depth first, then its colour.
  for (const mesh of skin === 1 ? head.meshes.filter((mesh) => mesh.kind === 'skin') : []) {
    gl.bindVertexArray(mesh.array);
    gl.uniform4f(where.base, ...colours.skin, 0.28);
    gl.uniform1f(where.level, mesh.level);
    gl.colorMask(false, false, false, false);
    gl.drawElements(gl.TRIANGLES, mesh.index.length, gl.UNSIGNED_INT, 0);
    gl.colorMask(true, true, true, true);
    gl.enable(gl.BLEND);
    gl.blendFuncSeparate(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA, gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    gl.drawElements(gl.TRIANGLES, mesh.index.length, gl.UNSIGNED_INT, 0);
    gl.disable(gl.BLEND);
  }
  range.value = frame;
  told.textContent = 'frame ' + head.frames[frame];
  const scale = box.querySelector('.scale');
  scale.style.display = by === 'weight' || by === 'error' || by === 'stretch' ? 'flex' : 'none';
  scale.classList.toggle('stretch', by === 'stretch');
  let worst = {name: '', error: -1};
  for (const {name, errors} of head.meshes) {
    if (errors.length && errors[frame] > worst.error) worst = {name, error: errors[frame]};
  }
  scale.firstChild.textContent = by === 'weight' ? '0' : '1e-17';
  scale.lastChild.textContent = by === 'weight' ? 'heaviest'
      : `1e-2 \u2003 largest in this frame: ${worst.error.toExponential(1)}, ` +
        worst.name.replaceAll('_', ' ');
  if (by === 'stretch') {
    const all = head.meshes.flatMap((mesh) => mesh.stretch ? [mesh.stretch] : []);
    const most = all.reduce((m, one) => one.reduce((a, s) => Math.max(a, s), m), 0);
    scale.firstChild.textContent = '\u00bd';
    scale.lastChild.textContent = '2 \u2003 larger principal stretch; ' + (all.length
        ? `in this frame up to ${most.toFixed(2)}` : 'there is no skin');
  }
  mark_charts();
}

// Charts tell where their frames are: a line at this one, and a click goes to another.
function plot_of(chart) {
  const [first, last] = chart.dataset.frames.split(' ').map(Number);
  const [left, right, top, bottom] = chart.dataset.plot.split(' ').map(Number);
  return {first, last: Math.max(last, first + 1), left, right, top, bottom};
}
function mark_charts() {
  for (const chart of document.querySelectorAll('svg[data-frames]')) {
    const {first, last, left, right, top, bottom} = plot_of(chart);
    let line = chart.querySelector('.now');
    if (!line) {
      line = document.createElementNS('http://www.w3.org/2000/svg', 'line');
      line.setAttribute('class', 'now');
      chart.append(line);
    }
    const x = left + (right - left) * (head.frames[frame] - first) / (last - first);
    const ends = {x1: x, x2: x, y1: top, y2: bottom};
    for (const [name, value] of Object.entries(ends)) line.setAttribute(name, value);
  }
}
// The shown frame that is nearest to a frame's number, with the viewer in sight.
function show(number) {
  const away = (f) => Math.abs(head.frames[f] - number);
  go(head.frames.reduce((best, _, f) => away(f) < away(best) ? f : best, 0));
  box.scrollIntoView({block: 'nearest'});
}
document.addEventListener('click', (event) => {
  const button = event.target.closest('[data-frame]');
  const chart = event.target.closest('svg[data-frames]');
  if (button) return show(Number(button.dataset.frame));
  if (!chart) return;
  const {first, last, left, right} = plot_of(chart), size = chart.getBoundingClientRect();
  const x = (event.clientX - size.left) * chart.viewBox.baseVal.width / size.width;
  if (x >= left - 8 && x <= right + 8) show(first + (last - first) * (x - left) / (right - left));
});
function ask() { if (!asked) { asked = true; requestAnimationFrame(draw); } }
function tick(now) {
  if (!playing) return;
  frame = (started.frame + Math.floor((now - started.now) * head.fps / 1000)) % frames;
  draw();
  requestAnimationFrame(tick);
}
function toggle() {
  playing = !playing;
  play.textContent = playing ? 'Pause' : 'Play';
  started = {frame, now: performance.now()};
  if (playing) requestAnimationFrame(tick);
}
function go(to) { if (playing) toggle(); frame = (to + frames) % frames; ask(); }
play.addEventListener('click', toggle);
range.addEventListener('input', () => go(Number(range.value)));
for (const name of ['muscle', 'bone', 'skin', 'prop', 'colour', 'alone']) {
  control(name).addEventListener('change', ask);
}
canvas.addEventListener('keydown', (event) => {
  if (event.key === ' ') toggle();
  else if (event.key === 'ArrowRight') go(frame + 1);
  else if (event.key === 'ArrowLeft') go(frame - 1);
  else return;
  event.preventDefault();
});
const fingers = new Map();
const apart = () => { const [a, b] = [...fingers.values()];
  return Math.hypot(a.clientX - b.clientX, a.clientY - b.clientY); };
canvas.addEventListener('pointerdown', (event) => {
  canvas.setPointerCapture(event.pointerId);
  fingers.set(event.pointerId, event);
});
for (const end of ['pointerup', 'pointercancel']) {
  canvas.addEventListener(end, (event) => fingers.delete(event.pointerId));
}
const nearer = (by) => { eye.far = Math.max(0.1 * radius, Math.min(12 * radius, eye.far * by)); };
canvas.addEventListener('pointermove', (event) => {
  if (!event.buttons) return;
  if (fingers.size === 2 && fingers.has(event.pointerId)) {
    const before = apart();
    fingers.set(event.pointerId, event);
    nearer(before / Math.max(apart(), 1));
    return ask();
  }
  if (event.shiftKey || event.buttons & 6) {
    const step = 0.62 * eye.far / canvas.clientHeight, [right, up] = axes();
    eye.target = eye.target.map(
        (x, a) => x + step * (event.movementY * up[a] - event.movementX * right[a]));
  } else {
    eye.yaw -= 0.008 * event.movementX;
    eye.pitch = Math.max(-1.5, Math.min(1.5, eye.pitch + 0.008 * event.movementY));
  }
  ask();
});
canvas.addEventListener('contextmenu', (event) => event.preventDefault());
canvas.addEventListener('wheel', (event) => {
  nearer(Math.exp(0.0012 * event.deltaY));
  event.preventDefault();
  ask();
}, {passive: false});
canvas.addEventListener('dblclick', () => { eye = home(); ask(); });
new ResizeObserver(ask).observe(canvas);
draw();
})();
