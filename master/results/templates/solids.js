// bodies on their meshes: WebGL, one canvas a run; turned by dragging or the arrow keys
const layers = data.films.flatMap(film => Object.values(film.layers));
const shareOf = (value, { low, high }) => (value - low) / ((high - low) || 1);
const VERTEX = `#version 300 es
in vec3 place; in float share;           // far below zero: no value there
uniform mat3 view; uniform vec4 frame;   // centre of the view in x, y, z and what is one half of its height
uniform float aspect;
out float colour;
void main() {
  vec3 eye = view * (place - frame.xyz);
  colour = share;
  gl_Position = vec4(eye.x / frame.w / aspect, eye.y / frame.w, -eye.z / frame.w / 8.0, 1.0);
}`;
const FRAGMENT = `#version 300 es
precision highp float;
in float colour;   // a triangle has colours where all its corners have
uniform sampler2D table; uniform vec3 plain; uniform float tall;   // dots of the view's height, which is an eighth of its depth
out vec4 seen;
void main() {
  vec3 normal = vec3(8.0 * tall * vec2(dFdx(gl_FragCoord.z), dFdy(gl_FragCoord.z)), 1.0);
  float light = 0.45 + 0.55 * abs(dot(normal, normalize(vec3(0.3, 0.5, 0.9)))) * inversesqrt(dot(normal, normal));
  vec3 own = colour < 0.0 ? plain : texture(table, vec2((colour * 255.0 + 0.5) / 256.0, 0.5)).rgb;
  seen = vec4(own * light, 1.0);
}`;
const nothing = -1e6;   // so far below zero that no triangle with such a corner has colours

async function unpackMesh(mesh) {
  const [points, triangles, modes] = await Promise.all([inflate(mesh.points), inflate(mesh.triangles), inflate(mesh.modes)]);
  return { points: new Float32Array(points), triangles: new Uint32Array(triangles), modes: Float32Array.from(new Int16Array(modes), value => value / 32767) };
}

// the half of a mesh behind z = 0: its triangles, and points on the cut, each between two others
function cutOpen(mesh) {
  const count = mesh.points.length / 3, between = [], known = new Map(), triangles = [], z = p => mesh.points[3 * p + 2];
  const onCut = (a, b) => {
    if (a > b) [a, b] = [b, a];
    const key = a * count + b;
    if (!known.has(key)) { known.set(key, count + between.length); between.push([a, b, z(a) / (z(a) - z(b))]); }
    return known.get(key);
  };
  for (let t = 0; t < mesh.triangles.length; t += 3) {
    const kept = [];
    for (let k = 0; k < 3; k++) {
      const a = mesh.triangles[t + k], b = mesh.triangles[t + (k + 1) % 3];
      if (z(a) <= 0) kept.push(a);
      if (z(a) <= 0 !== z(b) <= 0) kept.push(onCut(a, b));
    }
    for (let k = 2; k < kept.length; k++) triangles.push(kept[0], kept[k - 1], kept[k]);
  }
  return { between, triangles: Uint32Array.from(triangles) };
}

// values of the points, then of those on the cut
function withCut(values, between, size) {
  if (!between.length) return values;
  const count = values.length / size, out = new Float32Array(values.length + size * between.length);
  out.set(values);
  between.forEach(([a, b, share], k) => { for (let c = 0; c < size; c++) out[size * (count + k) + c] = (1 - share) * values[size * a + c] + share * values[size * b + c]; });
  return out;
}

// displacement of every point at a recorded instant: modes times coordinates
function displaced(solid, mesh, frame) {
  const size = mesh.points.length, found = new Float64Array(size), all = column(solid.coordinates);
  const { modes } = mesh;
  for (let k = 0; k < solid.count; k++) {
    const q = all[frame * solid.count + k], from = k * size;
    for (let p = 0; p < size; p++) found[p] += q * modes[from + p];
  }
  return found;
}

// points moved with the body, displacement and motion across exaggerated
function placed(solid, mesh, displacement, frame, times) {
  const out = new Float32Array(mesh.points.length);
  const [across, along, turn] = solid.motion ? column(solid.motion).subarray(3 * frame, 3 * frame + 3) : [0, 0, 0];
  const c = Math.cos(times * turn), s = Math.sin(times * turn);
  for (let p = 0; p < out.length; p += 3) {
    const x = mesh.points[p] + times * displacement[p], y = mesh.points[p + 1] + times * displacement[p + 1];
    out[p] = c * x - s * y + times * across;
    out[p + 1] = s * x + c * y + along;
    out[p + 2] = mesh.points[p + 2] + times * displacement[p + 2];
  }
  return out;
}

// for every point its cell of fields around the body, -1 where it is not on that face
function cellsOf(mesh, run, [low, high]) {
  const [n, m] = run.shape, [first] = run.ends, found = new Int32Array(mesh.points.length / 3).fill(-1);
  let radius = 0;
  for (let p = 0; p < mesh.points.length; p += 3) radius = Math.max(radius, Math.hypot(mesh.points[p], mesh.points[p + 2]));
  for (let p = 0; p < mesh.points.length; p += 3) {
    const [x, y, z] = mesh.points.subarray(p, p + 3), share = (y - low) / (high - low);
    if (Math.hypot(x, z) < 0.985 * radius || share < -1e-6 || share > 1 + 1e-6) continue;
    const angle = Math.atan2(x, z) * 180 / Math.PI;   // from +z towards +x
    const i = ((Math.floor((angle - first[0]) / 360 * n) % n) + n) % n, j = Math.min(m - 1, Math.max(0, Math.floor(share * m)));
    if (has(run, i * m + j)) found[p / 3] = i * m + j;
  }
  return found;
}

function program(gl) {
  const made = gl.createProgram();
  for (const [kind, text] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, FRAGMENT]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, text); gl.compileShader(shader); gl.attachShader(made, shader);
  }
  gl.linkProgram(made);
  if (!gl.getProgramParameter(made, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(made));
  return made;
}

// whether a surface encloses a body: every edge is gone along once each way; and whether it is seen from outside counterclockwise
function enclosing({ points, triangles }) {
  const gone = new Set(), count = points.length / 3;
  let volume = 0;
  for (let t = 0; t < triangles.length; t += 3) {
    const corners = triangles.subarray(t, t + 3), [a, b, c] = [...corners].map(p => points.subarray(3 * p, 3 * p + 3));
    for (let k = 0; k < 3; k++) gone.add(corners[k] * count + corners[(k + 1) % 3]);
    volume += a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0]);
  }
  const closed = gone.size === triangles.length && [...gone].every(edge => gone.has(edge % count * count + Math.floor(edge / count)));
  return { closed, outward: volume > 0 };
}

class Scene {
  constructor(parent, label, run, solids, meshes, controls) {
    Object.assign(this, { label, run, solids, controls });
    const figure = element("figure", parent);
    this.canvas = element("canvas", figure);
    figure.className = "scene";
    this.thrust = element("span", figure, "thrust", "mark"); this.anti = element("span", figure, "anti-thrust", "mark");
    this.caption = element("figcaption", figure);
    this.canvas.style.cssText = "touch-action: none; cursor: grab; height: 420px";
    this.canvas.tabIndex = 0;
    this.canvas.scene = this;
    this.meshes = solids.map(solid => meshes[solid.mesh]);
    const gl = this.gl = this.canvas.getContext("webgl2", { antialias: false });
    if (!gl) { this.caption.textContent = `${label}: this browser has no WebGL 2`; return; }
    this.program = program(gl);
    this.slots = {};
    for (const name of ["place", "share"]) gl.enableVertexAttribArray(this.slots[name] = gl.getAttribLocation(this.program, name));
    this.parts = solids.map((solid, k) => {
      const { between, triangles } = solid.motion ? { between: [], triangles: this.meshes[k].triangles } : cutOpen(this.meshes[k]);
      const { closed, outward } = solid.motion ? enclosing(this.meshes[k]) : { closed: false };
      return { closed, outward, between, count: triangles.length, place: gl.createBuffer(), share: gl.createBuffer(), index: this.buffer(triangles, gl.ELEMENT_ARRAY_BUFFER) };
    });
    const table = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, table);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGB, 256, 1, 0, gl.RGB, gl.UNSIGNED_BYTE, new Uint8Array(data.colours.flat().map(Math.round)));
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
    gl.enable(gl.DEPTH_TEST);
    this.canvas.onpointerdown = event => { this.canvas.setPointerCapture(event.pointerId); };
    this.canvas.onpointermove = event => { if (event.buttons) controls.turn(event.movementX * .01, event.movementY * .01); };
    this.canvas.onkeydown = event => {
      const move = { ArrowLeft: [-.1, 0], ArrowRight: [.1, 0], ArrowUp: [0, -.1], ArrowDown: [0, .1] }[event.key], factor = { "+": 1 / 1.1, "=": 1 / 1.1, "-": 1.1 }[event.key];
      if (factor) { event.preventDefault(); controls.zoom(factor); }
      if (move) { event.preventDefault(); controls.turn(...move); }
    };
    this.canvas.onwheel = event => { if (event.ctrlKey) { event.preventDefault(); controls.zoom(event.deltaY > 0 ? 1.1 : 1 / 1.1); } };
  }
  buffer(values, kind = this.gl.ARRAY_BUFFER) {
    const made = this.gl.createBuffer();
    this.gl.bindBuffer(kind, made); this.gl.bufferData(kind, values, this.gl.STATIC_DRAW);
    return made;
  }
  frame() { return data.cursor.frames[this.run][instant]; }
  sizeOf(displacement) {
    const out = new Float32Array(displacement.length / 3);
    for (let p = 0; p < out.length; p++) out[p] = 1e6 * Math.hypot(displacement[3 * p], displacement[3 * p + 1], displacement[3 * p + 2]);
    return out;
  }
  // of every body what it looks like at the cursor: displacement, its size, values of a colouring
  look(colouring) {
    const frame = this.frame();
    return this.solids.map((solid, k) => {
      const displacement = displaced(solid, this.meshes[k], frame), sizes = this.sizeOf(displacement);
      return { displacement, sizes, values: colouring.values(this, k, frame, sizes) };
    });
  }
  paint(look, scale, view, dots) {
    const gl = this.gl;
    if (!gl) return;
    const wide = this.wide = this.canvas.clientWidth, tall = this.tall = 420, ratio = (window.devicePixelRatio || 1) * dots, width = Math.round(wide * ratio), height = Math.round(tall * ratio);
    if (this.canvas.width !== width || this.canvas.height !== height) { this.canvas.width = width; this.canvas.height = height; }
    gl.viewport(0, 0, width, height);
    gl.clearColor(0, 0, 0, 0); gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.useProgram(this.program);
    const at = name => this.slots[name] ??= gl.getUniformLocation(this.program, name);
    gl.uniformMatrix3fv(at("view"), false, view.matrix);
    const frame = this.frame(), moving = this.solids.find(solid => solid.motion), height0 = moving ? column(moving.motion)[3 * frame + 1] : 0;
    const middle = view.follow ? height0 : view.middle;
    gl.uniform4f(at("frame"), 0, middle, 0, view.half);
    gl.uniform1f(at("aspect"), width / height); gl.uniform1f(at("tall"), height);
    const said = [];
    this.solids.forEach((solid, k) => {
      const mesh = this.meshes[k], part = this.parts[k], { displacement, sizes, values } = look[k];
      if (!solid.motion && !this.controls.block.checked) return;
      const shares = new Float32Array(sizes.length).fill(nothing);
      if (values) for (let p = 0; p < shares.length; p++) if (!Number.isNaN(values[p])) shares[p] = Math.min(1, Math.max(0, shareOf(values[p], scale)));
      const largest = sizes.reduce((a, b) => Math.max(a, b), 0);
      said.push(`${solid.name} ${solid.count ? `deflects up to ${withUnit(largest, "µm")}` : solid.held ? "rigid" : "without deflection, as modal coordinates were not recorded"}`);
      gl.bindBuffer(gl.ARRAY_BUFFER, part.place);
      gl.bufferData(gl.ARRAY_BUFFER, withCut(placed(solid, mesh, displacement, frame, view.times), part.between, 3), gl.DYNAMIC_DRAW);
      gl.bindBuffer(gl.ARRAY_BUFFER, part.share);
      gl.bufferData(gl.ARRAY_BUFFER, withCut(shares, part.between, 1), gl.DYNAMIC_DRAW);
      for (const [name, buffer, count] of [["place", part.place, 3], ["share", part.share, 1]]) {
        gl.bindBuffer(gl.ARRAY_BUFFER, buffer); gl.vertexAttribPointer(this.slots[name], count, gl.FLOAT, false, 0, 0);
      }
      gl.uniform3f(at("plain"), ...(solid.motion ? [.68, .72, .76] : [.55, .57, .6]));
      gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, part.index);
      if (part.closed) { gl.enable(gl.CULL_FACE); gl.cullFace(part.outward ? gl.BACK : gl.FRONT); } else gl.disable(gl.CULL_FACE);
      gl.drawElements(gl.TRIANGLES, part.count, gl.UNSIGNED_INT, 0);
    });
    gl.flush();   // drawn while the page goes on
    // the words stand before the outermost points of the two sides
    const height1 = height0 - middle, matrix = view.matrix;
    for (const [mark, x] of [[this.thrust, 1.35 * view.reach], [this.anti, -1.35 * view.reach]]) {
      const right = (matrix[0] * x + matrix[3] * height1) / view.half, up = (matrix[1] * x + matrix[4] * height1) / view.half;
      const across = Math.min(this.wide - 38, Math.max(38, .5 * this.wide + .5 * right * this.tall));
      mark.style.transform = `translate(-50%, -50%) translate(${across.toFixed(1)}px, ${(.5 - .5 * up) * this.tall}px)`;
    }
    const text = `${this.label}: ${said.join("; ")}; deflection, sideways motion and tilt drawn ${digits(view.times)} times`;
    if (this.caption.textContent !== text) { this.caption.textContent = text; this.canvas.setAttribute("aria-label", text); }
  }
}

// what bodies can be coloured by: its range, and the value at every point of a body, NaN without one
function colourings(scenes) {
  const solids = scenes.flatMap(scene => scene.solids), known = [];
  const add = (name, unit, ranges, values, reads = []) => known.push({ name, unit, low: Math.min(...ranges.map(r => r.low)), high: Math.max(...ranges.map(r => r.high)), values, ready: () => Promise.all(reads.map(async run => { run.at = await unpackFrames(run); })) });
  // fields of the same kind on several films have one colouring
  const drawn = [...layers.keys()].filter(f => scenes.some(scene => layers[f].runs[scene.run] && scene.solids.some(one => one.over[f])));
  for (const [name, own] of d3.group(drawn, f => layers[f].variable)) {
    const fields = own.map(f => layers[f]);
    if (fields.every(one => one.low === one.high)) continue;
    add(name, fields[0].unit, fields, (scene, k, frame, sizes) => {
      const solid = scene.solids[k], values = sizes.map(() => NaN);
      for (const f of own.filter(one => solid.over[one] && layers[one].runs[scene.run])) {
        const run = layers[f].runs[scene.run], cells = (solid.cells ||= {})[f] ||= cellsOf(scene.meshes[k], run, solid.over[f]);
        cells.forEach((cell, p) => { if (cell >= 0) values[p] = run.at(frame, cell); });
      }
      return values;
    }, fields.flatMap(one => one.runs.filter(run => run)));
  }
  const stressed = solids.filter(one => one.stress).map(one => one.stress);
  if (stressed.length) add("von Mises stress", "MPa", stressed, (scene, k, frame, sizes) => { const own = scene.solids[k].stress; return own && sizes.map((_, p) => own.at(frame, p)); }, stressed);
  for (const name of new Set(solids.filter(one => one.count).map(one => one.name)))
    add(`displacement of the ${name}`, "µm", [{ low: 0, high: 1e6 * Math.max(...solids.map(one => one.name === name ? one.largest : 0)) }], (scene, k, frame, sizes) => scene.solids[k].name === name && scene.solids[k].count ? sizes : null);
  if (!known.length) add("nothing", "", [{ low: 0, high: 1 }], () => null);
  return known;
}

async function showSolids() {
  const parent = byId("solids");
  if (parent.childElementCount) return;
  const meshes = await Promise.all(data.solids.meshes.map(unpackMesh)), scenes = [], row = element("div", parent, "", "row");
  const choose = (said, entries) => { const made = element("select", element("label", row, said + " ")); options(made, entries, entries[0]?.[0]); made.hidden = false; made.onchange = () => change(); return made; };
  const colours = choose("colour", []), over = choose("scale", [["all", "of all instants and runs"], ["now", "of this instant"]]);
  const stretched = element("label", row, "deformation drawn "), times = element("input", stretched), told = element("output", stretched);
  Object.assign(times, { type: "range", min: 0, max: 3, step: .02, value: 1.7 });
  const tick = text => { const label = element("label", row), box = element("input", label); box.type = "checkbox"; box.checked = true; label.append(" " + text); box.onchange = () => paint(); return box; };
  const block = tick("block, cut open"), follow = tick("follow the piston"), bar = element("div", row), view = { round: -.45, up: .3, half: 1, middle: 0 };
  const controls = { block, view, turn: (a, b) => { view.round += a; view.up = Math.min(1.5, Math.max(-1.5, view.up + b)); paint(); }, zoom: factor => { view.half *= factor; paint(); } };
  const area = element("div", parent, "", "scenes");
  data.solids.runs.forEach((solids, run) => {
    for (const owner of new Set(solids.map(solid => solid.owner)))
      scenes.push(new Scene(area, data.labels[run] + (owner ? `, ${owner}` : ""), run, solids.filter(solid => solid.owner === owner), meshes, controls));
  });
  element("p", parent, "Drag or press the arrow keys to turn the bodies. Use Ctrl and the wheel, + or - to zoom. Shading darkens the colours of the scale.", "dim");
  const paints = colourings(scenes), points = scenes.flatMap(scene => scene.meshes.map((mesh, k) => ({ mesh, solid: scene.solids[k] }))), rest = points.find(one => !one.solid.motion);
  options(colours, paints.map((one, k) => [k, one.name]), 0); colours.hidden = false;
  view.reach = Math.max(...points.filter(one => one.solid.motion).map(one => d3.max(one.mesh.points, Math.abs)));
  view.half = 1.5 * view.reach;
  const middle = rest ? d3.mean(d3.extent(rest.mesh.points.filter((_, p) => p % 3 === 1))) : 0;
  // at the dots of the screen while it moves, at four times as many when it rests
  let resting, scaled = "";
  const paint = () => { clearTimeout(resting); if (!byId("bodies").open) return; draw(1); if (!playing) resting = setTimeout(draw, 250, 2); };
  const draw = dots => {
    const { round: a, up: b } = view, one = paints[+colours.value], looks = scenes.map(scene => scene.look(one));
    view.matrix = [Math.cos(a), Math.sin(b) * Math.sin(a), -Math.cos(b) * Math.sin(a), 0, Math.cos(b), Math.sin(b), Math.sin(a), -Math.sin(b) * Math.cos(a), Math.cos(b) * Math.cos(a)];
    Object.assign(view, { times: +(10 ** times.value).toPrecision(2), follow: follow.checked, middle: follow.checked ? 0 : middle });
    told.textContent = ` ${view.times} times`;
    let { low, high } = one;
    if (over.value === "now") [low = one.low, high = one.high] = d3.extent(looks.flatMap(look => look.flatMap(own => own.values ? [...own.values] : [])));
    const scale = area.scale = { low, high }, said = [low, high, one.name].join();
    if (said !== scaled) { scaled = said; bar.replaceChildren(Plot.legend({ color: { type: "linear", scheme: "viridis", domain: [low, high === low ? low + 1 : high], label: one.name + (one.unit ? ` [${one.unit}]` : "") }, width: 240, height: 42, ticks: 4 })); }
    scenes.forEach((scene, k) => scene.paint(looks[k], scale, view, dots));
  };
  const change = async () => { await paints[+colours.value].ready(); paint(); };
  times.oninput = paint;
  byId("bodies").addEventListener("toggle", paint);
  addEventListener("resize", paint);
  await change();
  always.push(paint);
}
