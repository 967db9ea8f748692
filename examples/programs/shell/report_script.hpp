#pragma once
#include "run_folder.hpp"

/// \file
/// Styles and scripts that page_html() puts into a page beside its text. Nothing is loaded from elsewhere.

namespace tapestry::shell {
/// Style of a list of views; in print without the controls.
inline constexpr const char* list_style =
    R"(#views th { cursor: pointer } #views th[aria-sort=ascending]::after { content: " \2191" }
#views th[aria-sort=descending]::after { content: " \2193" }
#views tr.chosen { background: var(--shade) } .missed { color: #b35900 }
.list { max-height: 30em; overflow: auto } .list table { font-size: 13px; margin: 0 }
.list td, .list th { padding-right: .6em } .list td:first-child, .list th:first-child { min-width: 3em }
.list th { position: sticky; top: 0; background: var(--paper); z-index: 1 }
.list button { font: inherit; color: var(--mark); background: none; border: 0; padding: 0; text-align: left;
  text-decoration: underline; cursor: pointer } .list th:first-child { z-index: 2 } .list tr.chosen td:first-child { background: var(--shade) }
@media (prefers-color-scheme: dark) { .missed { color: #ffa657 } }
@media print { .hands { display: none } .list { max-height: none } body { max-width: none } }
)";

/// Style of a run's page, after page_style and list_style.
inline constexpr const char* report_style =
    R"(
.verdict { font-size: 19px } .pictures { display: grid; grid-template-columns: repeat(4, minmax(0, max-content)); gap: .6em 1em;
  margin-right: min(0px, (100% - 100vw) / 2 + 1.5em) }
.pictures figure { margin: 0; display: grid; align-content: start } .pictures figcaption { width: 0; min-width: 100% }
.hands button { font: inherit; padding: .2em 1.2em }
.boxes span { margin-right: 1em } .boxes i { display: inline-block; width: .8em; height: .8em }
@media (max-width: 60em) { .pictures { grid-template-columns: repeat(2, minmax(0, max-content)) } }
.atlases { display: flex; flex-wrap: wrap; gap: 1em } .atlases figure { margin: 0; width: 15em }
.atlases img { image-rendering: pixelated; width: 100% }
.curves { display: flex; flex-wrap: wrap; gap: 1em } .curves svg { max-width: 100%; height: auto }
svg text { font: 11px sans-serif; fill: var(--ink) } svg .end { text-anchor: end } svg .curve { fill: none; stroke: var(--mark) }
svg .frame { fill: none; stroke: var(--line) }
#car { width: 100%; max-width: 48em; aspect-ratio: 16 / 9; touch-action: none; background: var(--shade);
  cursor: grab; display: block }
)";

/// Reads the page's data, a JSON text with the id `data`: a list of views that sorts and filters, the
/// pictures of one view beside each other, and the car, whose GLB file is drawn by WebGL and turned by hand.
inline constexpr const char* report_script = R"('use strict';
const data = JSON.parse(document.getElementById('data').textContent);
const make = (name, words) => { const e = document.createElement(name); e.textContent = words ?? ''; return e; };

// The list of views: name, place, then for each texture [best confidence, share of its pictures found].
function listViews() {
  const table = document.getElementById('views'), head = table.createTHead().insertRow();
  const body = table.createTBody(), search = document.getElementById('search'), only = document.getElementById('only');
  const places = ['azimuth', 'elevation', 'distance', 'hidden'], digits = [1, 1, 2, 0], unit = ['\u00b0', '\u00b0', '', ' %'];
  const titles = ['view', ...places, ...data.textures], first = 1 + places.length;
  let column = data.textures.indexOf(data.sorted) + first, sign = -1;
  for (const texture of data.textures) only.append(new Option('not found in ' + texture, texture));
  titles.forEach((title, i) => {
    const th = make('th', title);
    th.scope = 'col'; th.tabIndex = 0;
    const sort = () => { sign = column === i ? -sign : i < first ? 1 : -1; column = i; fill(); };
    th.onclick = sort; th.onkeydown = e => { if (e.key === 'Enter') sort(); };
    head.append(th);
  });
  const key = view => column === 0 ? view.name : column < first ? view.place[column - 1] : view.scores[column - first][0];
  function fill() {
    [...head.cells].forEach((th, i) => i === column
      ? th.setAttribute('aria-sort', sign > 0 ? 'ascending' : 'descending') : th.removeAttribute('aria-sort'));
    const shown = data.views.filter(view => view.name.includes(search.value) &&
      (only.value === '' || view.scores[data.textures.indexOf(only.value)][1] < 1));
    shown.sort((a, b) => sign * (key(a) < key(b) ? -1 : key(a) > key(b) ? 1 : 0) || a.index - b.index);
    body.replaceChildren(...shown.map(view => {
      const row = make('tr'), button = make('button', view.name);
      button.onclick = () => { choose(view); for (const r of body.rows) r.classList.toggle('chosen', r === row);
        document.getElementById('chosen').scrollIntoView({block: 'nearest'}); };
      row.insertCell().append(view.picture < 0 ? view.name : button);
      view.place.forEach((value, i) => row.append(make('td', value.toFixed(digits[i]) + unit[i])));
      view.scores.forEach(([best, found]) => {
        const cell = make('td', best.toFixed(3) + (found === 1 ? '' : found === 0 ? ' not found' : ' ' + found.toFixed(2)));
        if (found < 1) cell.className = 'missed';
        row.append(cell);
      });
      return row;
    }));
    document.getElementById('count').textContent = shown.length + ' of ' + data.views.length + ' views';
  }
  search.oninput = only.onchange = fill; fill();
  if (pictured.length) choose(pictured[0]);
}

// The pictures of one view, and the way to those before and behind.
const pictured = data.views.filter(view => view.picture >= 0);
let chosen = 0;
function choose(view) {
  chosen = pictured.indexOf(view);
  document.querySelectorAll('.pictures img').forEach((image, i) => {
    image.src = 'data:image/jpeg;base64,' + data.pictures[i][view.picture]; });
  document.getElementById('chosen').textContent = 'view ' + view.name + ', ' + (chosen + 1) + ' of ' + pictured.length;
}
const step = by => choose(pictured[(chosen + by + pictured.length) % pictured.length]);
for (const [id, by] of [['back', -1], ['on', 1]]) if (pictured.length) document.getElementById(id).onclick = () => step(by);

// The parts of a binary glTF 2.0 file that io::write_glb() writes.
function readGlb(letters) {
  const bytes = Uint8Array.from(atob(letters), c => c.charCodeAt(0)), words = new DataView(bytes.buffer);
  const length = words.getUint32(12, true), gltf = JSON.parse(new TextDecoder().decode(bytes.subarray(20, 20 + length)));
  const start = 28 + length;
  const range = i => { const v = gltf.bufferViews[i]; return [start + (v.byteOffset ?? 0), v.byteLength]; };
  const read = i => {
    const a = gltf.accessors[i], [from] = range(a.bufferView), size = {SCALAR: 1, VEC2: 2, VEC3: 3, VEC4: 4}[a.type];
    const kind = {5121: Uint8Array, 5123: Uint16Array, 5125: Uint32Array, 5126: Float32Array}[a.componentType];
    const begin = from + (a.byteOffset ?? 0);
    return new kind(bytes.buffer.slice(begin, begin + a.count * size * kind.BYTES_PER_ELEMENT));
  };
  return {gltf, read, picture: i => { const [from, size] = range(gltf.images[i].bufferView);
    return new Blob([bytes.subarray(from, from + size)], {type: gltf.images[i].mimeType}); }};
}

// Draws the ground below a car: its outline seen from above, blurred, as the shadow of an even sky. `turn` makes y the height.
function groundOf(gl, program, turn, meshes) {
  const n = 96, low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity], points = [];
  for (const mesh of meshes)
    for (const [a, b] of mesh)
      for (let t = 0; t < 1; t += 1 / 16) {
        const p = a.map((v, k) => v + t * (b[k] - v)), q = [0, 1, 2].map(r => turn[r] * p[0] + turn[3 + r] * p[1] + turn[6 + r] * p[2]);
        q.forEach((v, k) => { low[k] = Math.min(low[k], v); high[k] = Math.max(high[k], v); });
        points.push(q);
      }
  const middle = low.map((v, k) => (v + high[k]) / 2), reach = 0.75 * Math.max(high[0] - low[0], high[2] - low[2]);
  const cell = (q, k) => Math.floor(((q[k] - middle[k]) / reach + 1) * n / 2);
  const first = Array(n).fill(n), last = Array(n).fill(-1);
  for (const q of points)
    for (let row = cell(q, 2) - 2; row <= cell(q, 2) + 2; ++row) {
      first[row] = Math.min(first[row], cell(q, 0)); last[row] = Math.max(last[row], cell(q, 0));
    }
  let dark = Float32Array.from({length: n * n}, (_, i) => i % n >= first[i / n | 0] && i % n <= last[i / n | 0] ? 1 : 0);
  for (let pass = 0; pass < 6; ++pass) {  // three each along rows and columns
    const step = pass % 2 ? n : 1, from = dark;
    dark = from.map((_, i) => { let sum = 0; for (let k = -3; k <= 3; ++k) sum += from[i + k * step] ?? 0; return sum / 7; });
  }
  const texture = gl.createTexture(), array = gl.createVertexArray(); gl.bindTexture(gl.TEXTURE_2D, texture);
  gl.texImage2D(gl.TEXTURE_2D, 0, gl.R8, n, n, 0, gl.RED, gl.UNSIGNED_BYTE, Uint8Array.from(dark, v => 255 * v));
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR);
  return (view, projection) => {
    gl.useProgram(program); gl.bindVertexArray(array); gl.bindTexture(gl.TEXTURE_2D, texture);
    const place = name => gl.getUniformLocation(program, name);
    gl.uniformMatrix4fv(place('view'), false, view); gl.uniformMatrix4fv(place('projection'), false, projection);
    gl.uniformMatrix3fv(place('turn'), false, turn); gl.uniform1f(place('reach'), reach);
    gl.uniform3f(place('middle'), middle[0], low[1], middle[2]);
    gl.depthMask(false); gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4); gl.depthMask(true);
  };
}

async function showCar() {
  const canvas = document.getElementById('car');
  const gl = canvas.getContext('webgl2', {preserveDrawingBuffer: true});
  if (!gl) { canvas.replaceWith(make('p', 'This browser draws no WebGL: open painted.glb in a viewer.')); return; }
  const {gltf, read, picture} = readGlb(data.glb);
  const shader = (type, text) => {
    const s = gl.createShader(type); gl.shaderSource(s, text); gl.compileShader(s);
    if (!gl.getShaderParameter(s, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(s));
    return s;
  };
  const linked = (vertex, fragment) => {
    const program = gl.createProgram();
    gl.attachShader(program, shader(gl.VERTEX_SHADER, vertex)); gl.attachShader(program, shader(gl.FRAGMENT_SHADER, fragment));
    gl.linkProgram(program); return program;
  };
  const program = linked(`#version 300 es
    in vec3 position; in vec3 normal; in vec2 uv; uniform mat4 view, projection; out vec3 n, p; out vec2 at;
    void main() { vec4 e = view * vec4(position, 1.0); p = e.xyz; n = mat3(view) * normal; at = uv;
      gl_Position = projection * e; }`, `#version 300 es
    precision highp float; in vec3 n, p; in vec2 at; uniform sampler2D paint; uniform vec4 colour; uniform bool painted;
    out vec4 result;
    void main() { vec3 base = painted ? texture(paint, at).rgb : pow(colour.rgb, vec3(1.0 / 2.2));
      float facing = length(n) > 0.0 ? abs(dot(normalize(n), normalize(p))) : 1.0;
      result = vec4(base * (0.45 + 0.55 * facing), 1.0); }`);
  const below = linked(`#version 300 es
    uniform mat4 view, projection; uniform mat3 turn; uniform vec3 middle; uniform float reach; out vec2 at;
    void main() { at = vec2(gl_VertexID & 1, gl_VertexID >> 1); vec2 by = reach * (2.0 * at - 1.0);
      gl_Position = projection * view * vec4(transpose(turn) * (middle + vec3(by.x, 0.0, by.y)), 1.0); }`, `#version 300 es
    precision highp float; in vec2 at; uniform sampler2D dark; out vec4 result;
    void main() { result = vec4(0.0, 0.0, 0.0, 0.6 * texture(dark, at).r); }`);
  const place = name => gl.getUniformLocation(program, name);
  let low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
  const parts = gltf.meshes[0].primitives.map(part => {
    const array = gl.createVertexArray(); gl.bindVertexArray(array);
    const put = (name, accessor, size) => {
      const at = gl.getAttribLocation(program, name);
      if (at < 0 || accessor === undefined) return;
      const values = read(accessor);
      if (name === 'position') values.forEach((v, i) => {
        low[i % 3] = Math.min(low[i % 3], v); high[i % 3] = Math.max(high[i % 3], v); });
      gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer()); gl.bufferData(gl.ARRAY_BUFFER, values, gl.STATIC_DRAW);
      gl.enableVertexAttribArray(at); gl.vertexAttribPointer(at, size, gl.FLOAT, false, 0, 0);
    };
    put('position', part.attributes.POSITION, 3); put('normal', part.attributes.NORMAL, 3);
    put('uv', part.attributes.TEXCOORD_0, 2); const indices = read(part.indices);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, indices, gl.STATIC_DRAW);
    const surface = gltf.materials[part.material].pbrMetallicRoughness;
    return {array, count: indices.length, painted: surface.baseColorTexture !== undefined,
            type: indices instanceof Uint32Array ? gl.UNSIGNED_INT : gl.UNSIGNED_SHORT,
            colour: surface.baseColorFactor ?? [1, 1, 1, 1]};
  });
  const paint = gl.createTexture();
  if (gltf.images) {
    const bitmap = await createImageBitmap(picture(0)); gl.bindTexture(gl.TEXTURE_2D, paint);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, gl.RGBA, gl.UNSIGNED_BYTE, bitmap); gl.generateMipmap(gl.TEXTURE_2D);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR_MIPMAP_LINEAR);
  }
  const [qx, qy, qz, qw] = gltf.nodes[0].rotation ?? [0, 0, 0, 1];  // to y up
  const turn = [1 - 2 * (qy * qy + qz * qz), 2 * (qx * qy + qz * qw), 2 * (qx * qz - qy * qw),
                2 * (qx * qy - qz * qw), 1 - 2 * (qx * qx + qz * qz), 2 * (qy * qz + qx * qw),
                2 * (qx * qz + qy * qw), 2 * (qy * qz - qx * qw), 1 - 2 * (qx * qx + qy * qy)];
  const ground = groundOf(gl, below, turn, gltf.meshes[0].primitives.map(part => {
    const positions = read(part.attributes.POSITION), indices = read(part.indices), edges = [];
    const at = i => positions.subarray(3 * indices[i], 3 * indices[i] + 3);
    indices.forEach((_, i) => edges.push([[...at(i)], at(i % 3 === 2 ? i - 2 : i + 1)]));
    return edges;
  }));
  const middle = low.map((v, i) => (v + high[i]) / 2), radius = Math.hypot(...low.map((v, i) => high[i] - v)) / 2;
  let azimuth = 0.7, elevation = 0.35, distance = 2.1;
  function draw() {
    const ratio = window.devicePixelRatio || 1;
    canvas.width = canvas.clientWidth * ratio; canvas.height = canvas.clientHeight * ratio;
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.enable(gl.DEPTH_TEST); gl.clearColor(0, 0, 0, 0); gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    const ca = Math.cos(azimuth), sa = Math.sin(azimuth), ce = Math.cos(elevation), se = Math.sin(elevation);
    const look = [ca, sa * se, -sa * ce, 0, ce, se, sa, -ca * se, ca * ce];  // about y, then about x; by columns
    const m = new Float32Array(16);
    for (let c = 0; c < 3; ++c) for (let r = 0; r < 3; ++r)
      for (let k = 0; k < 3; ++k) m[4 * c + r] += look[3 * k + r] * turn[3 * c + k] / radius;
    for (let r = 0; r < 3; ++r) m[12 + r] = -(m[r] * middle[0] + m[4 + r] * middle[1] + m[8 + r] * middle[2]);
    m[14] -= distance; m[15] = 1;
    const f = 1.8, near = 0.05, far = 20, wide = canvas.height / canvas.width;
    const projection = [f * wide, 0, 0, 0, 0, f, 0, 0, 0, 0, (far + near) / (near - far), -1, 0, 0,
      2 * far * near / (near - far), 0];
    ground(m, projection);
    gl.useProgram(program); gl.bindTexture(gl.TEXTURE_2D, paint);
    gl.uniformMatrix4fv(place('view'), false, m); gl.uniformMatrix4fv(place('projection'), false, projection);
    for (const part of parts) {
      gl.bindVertexArray(part.array);
      gl.uniform1i(place('painted'), part.painted ? 1 : 0); gl.uniform4fv(place('colour'), part.colour);
      gl.drawElements(gl.TRIANGLES, part.count, part.type, 0);
    }
  }
  const turnBy = (x, y) => { azimuth += x; elevation = Math.min(1.5, Math.max(-0.2, elevation + y)); draw(); };
  canvas.onpointerdown = e => canvas.setPointerCapture(e.pointerId);
  canvas.onpointermove = e => { if (e.buttons) turnBy(e.movementX * 0.01, e.movementY * 0.01); };
  canvas.onwheel = e => { e.preventDefault(); distance = Math.min(6, Math.max(1.2, distance * Math.exp(e.deltaY * 1e-3))); draw(); };
  canvas.onkeydown = e => { const by = {ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, -0.1], ArrowDown: [0, 0.1]}[e.key];
    if (by) { e.preventDefault(); turnBy(...by); } };
  window.addEventListener('resize', draw); draw();
  const pixels = new Uint8Array(4 * canvas.width * canvas.height);
  gl.readPixels(0, 0, canvas.width, canvas.height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
  let drawn = 0;
  for (let i = 3; i < pixels.length; i += 4) drawn += pixels[i] === 255;
  canvas.dataset.drawn = drawn;  // pixels of the car, for tests of the page
}

if (data.views.length) listViews();
if (data.glb) showCar();
)";

/// The end of a page: the data for its script, and the script.
inline std::string page_end(const Json& data) {
  std::string text = "<script type=\"application/json\" id=\"data\">";
  for (const char c : data.dump()) text += c == '<' ? "\\u003c" : std::string(1, c);  // "<" may end it
  return text + "</script>\n<script>\n" + report_script + "</script>\n</body></html>\n";
}
}  // namespace tapestry::shell
