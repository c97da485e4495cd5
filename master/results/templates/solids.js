// bodies on their meshes: WebGL, one canvas a run; turned by dragging or the arrow keys
const VERTEX = `#version 300 es
in vec3 rest; in vec3 place; in float share;
uniform mat3 view; uniform vec4 frame;   // centre of the view in x, y, z and what is one half of its height
uniform float aspect;
out vec3 eye; out float colour; out float cut;
void main() {
  eye = view * (place - frame.xyz);
  colour = share; cut = rest.z;
  gl_Position = vec4(eye.x / frame.w / aspect, eye.y / frame.w, -eye.z / frame.w / 8.0, 1.0);
}`;
const FRAGMENT = `#version 300 es
precision highp float;
in vec3 eye; in float colour; in float cut;
uniform sampler2D table; uniform float open; uniform vec3 plain;
out vec4 seen;
void main() {
  if (cut > open) discard;
  vec3 normal = normalize(cross(dFdx(eye), dFdy(eye)));
  float light = 0.45 + 0.55 * abs(dot(normal, normalize(vec3(0.3, 0.5, 0.9))));
  vec3 own = colour < 0.0 ? plain : texture(table, vec2((colour * 255.0 + 0.5) / 256.0, 0.5)).rgb;
  seen = vec4(own * light, 1.0);
}`;

async function unpackMesh(mesh) {
  const [points, triangles, modes] = await Promise.all([inflate(mesh.points), inflate(mesh.triangles), inflate(mesh.modes)]);
  return { points: new Float32Array(points), triangles: new Uint32Array(triangles), modes: new Float32Array(modes) };
}

// displacement of every point at a recorded instant: modes times coordinates
function displaced(solid, mesh, frame) {
  const size = mesh.points.length, found = new Float64Array(size), all = column(solid.coordinates);
  for (let k = 0; k < solid.count; k++) {
    const q = all[frame * solid.count + k], from = k * size;
    for (let p = 0; p < size; p++) found[p] += q * mesh.modes[from + p];
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
function cellsOf(solid, mesh, run) {
  const [n, m] = run.shape, [first] = run.ends, [low, high] = solid.film, found = new Int32Array(mesh.points.length / 3).fill(-1);
  let radius = 0;
  for (let p = 0; p < mesh.points.length; p += 3) radius = Math.max(radius, Math.hypot(mesh.points[p], mesh.points[p + 2]));
  for (let p = 0; p < mesh.points.length; p += 3) {
    const [x, y, z] = mesh.points.subarray(p, p + 3), share = (y - low) / (high - low);
    if (Math.hypot(x, z) < 0.985 * radius || share < -1e-6 || share > 1 + 1e-6) continue;
    const angle = Math.atan2(x, z) * 180 / Math.PI;   // from +z towards +x
    const i = ((Math.floor((angle - first[0]) / 360 * n) % n) + n) % n, j = Math.min(m - 1, Math.max(0, Math.floor(share * m)));
    if (!run.there || run.there[i * m + j]) found[p / 3] = i * m + j;
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

class Scene {
  constructor(parent, label, run, solids, meshes, controls) {
    Object.assign(this, { label, run, solids, controls });
    const figure = element("figure", parent);
    this.canvas = element("canvas", figure);
    this.caption = element("figcaption", figure);
    this.canvas.style.cssText = "height: 420px; touch-action: none; cursor: grab";
    this.canvas.tabIndex = 0;
    this.canvas.scene = this;
    this.meshes = solids.map(solid => meshes[solid.mesh]);
    const gl = this.gl = this.canvas.getContext("webgl2", { antialias: true, preserveDrawingBuffer: true });
    if (!gl) { this.caption.textContent = `${label}: this browser has no WebGL 2`; return; }
    this.program = program(gl);
    this.parts = this.meshes.map(mesh => ({ rest: this.buffer(mesh.points), place: gl.createBuffer(), share: gl.createBuffer(), index: this.buffer(mesh.triangles, gl.ELEMENT_ARRAY_BUFFER) }));
    const table = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, table);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGB, 256, 1, 0, gl.RGB, gl.UNSIGNED_BYTE, new Uint8Array(data.colours.flat().map(Math.round)));
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
    gl.enable(gl.DEPTH_TEST);
    this.canvas.onpointerdown = event => { this.canvas.setPointerCapture(event.pointerId); };
    this.canvas.onpointermove = event => { if (event.buttons) controls.turn(event.movementX * .01, event.movementY * .01); };
    this.canvas.onkeydown = event => {
      const move = { ArrowLeft: [-.1, 0], ArrowRight: [.1, 0], ArrowUp: [0, -.1], ArrowDown: [0, .1] }[event.key];
      if (move) { event.preventDefault(); controls.turn(...move); }
    };
    this.canvas.onwheel = event => { if (event.ctrlKey) { event.preventDefault(); controls.zoom(event.deltaY > 0 ? 1.1 : 1 / 1.1); } };
  }
  buffer(values, kind = this.gl.ARRAY_BUFFER) {
    const made = this.gl.createBuffer();
    this.gl.bindBuffer(kind, made); this.gl.bufferData(kind, values, this.gl.STATIC_DRAW);
    return made;
  }
  frame() { return data.cursor.frames[this.run][+slider.value]; }
  sizes() { return this.solids.map((solid, k) => this.sizeOf(displaced(solid, this.meshes[k], this.frame()))); }
  sizeOf(displacement) {
    const out = new Float32Array(displacement.length / 3);
    for (let p = 0; p < out.length; p++) out[p] = 1e6 * Math.hypot(displacement[3 * p], displacement[3 * p + 1], displacement[3 * p + 2]);
    return out;
  }
  paint(scale, field, view) {
    const gl = this.gl;
    if (!gl) return;
    const ratio = window.devicePixelRatio || 1, width = Math.round(this.canvas.clientWidth * ratio), height = Math.round(this.canvas.clientHeight * ratio);
    if (this.canvas.width !== width || this.canvas.height !== height) { this.canvas.width = width; this.canvas.height = height; }
    gl.viewport(0, 0, width, height);
    gl.clearColor(0, 0, 0, 0); gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.useProgram(this.program);
    const at = name => gl.getUniformLocation(this.program, name);
    gl.uniformMatrix3fv(at("view"), false, view.matrix);
    const frame = this.frame(), moving = this.solids.find(solid => solid.motion), height0 = moving ? column(moving.motion)[3 * frame + 1] : 0;
    gl.uniform4f(at("frame"), 0, view.follow ? height0 + view.middle[1] : view.middle[1], 0, view.half);
    gl.uniform1f(at("aspect"), width / height);
    const said = [];
    this.solids.forEach((solid, k) => {
      const mesh = this.meshes[k], part = this.parts[k], displacement = displaced(solid, mesh, frame), sizes = this.sizeOf(displacement);
      if (!solid.motion && !this.controls.block.checked) return;
      const shares = new Float32Array(sizes.length).fill(-1);
      if (!field) sizes.forEach((value, p) => { shares[p] = solid.count ? Math.max(0, shareOf(value, scale)) : -1; });
      else if (field.cells[this.run] && solid.motion) field.cells[this.run].forEach((cell, p) => {
        if (cell >= 0) shares[p] = Math.max(0, shareOf(field.read[this.run](frame, cell), scale));
      });
      const largest = sizes.reduce((a, b) => Math.max(a, b), 0);
      said.push(`${solid.name} ${solid.count ? `deflects up to ${withUnit(largest, "µm")}` : "rigid, or its deflection was not recorded"}`);
      gl.bindBuffer(gl.ARRAY_BUFFER, part.place);
      gl.bufferData(gl.ARRAY_BUFFER, placed(solid, mesh, displacement, frame, view.times), gl.DYNAMIC_DRAW);
      gl.bindBuffer(gl.ARRAY_BUFFER, part.share);
      gl.bufferData(gl.ARRAY_BUFFER, shares, gl.DYNAMIC_DRAW);
      for (const [name, buffer, count] of [["rest", part.rest, 3], ["place", part.place, 3], ["share", part.share, 1]]) {
        const slot = gl.getAttribLocation(this.program, name);
        gl.bindBuffer(gl.ARRAY_BUFFER, buffer); gl.enableVertexAttribArray(slot); gl.vertexAttribPointer(slot, count, gl.FLOAT, false, 0, 0);
      }
      gl.uniform1f(at("open"), solid.motion ? 1e9 : 0);   // what rests is cut open
      gl.uniform3f(at("plain"), ...(solid.motion ? [.68, .72, .76] : [.55, .57, .6]));
      gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, part.index);
      gl.drawElements(gl.TRIANGLES, mesh.triangles.length, gl.UNSIGNED_INT, 0);
    });
    this.caption.textContent = `${this.label}: ${said.join("; ")}; deflection, sideways motion and tilt drawn ${digits(view.times)} times`;
    this.canvas.setAttribute("aria-label", this.caption.textContent);
  }
}

async function showSolids() {
  if (!data.solids.runs.some(run => run.length)) return;
  const parent = element("div", byId("solids"));
  element("h3", parent, "bodies on their meshes");
  const meshes = await Promise.all(data.solids.meshes.map(unpackMesh)), scenes = [], fields = [];
  for (const field of data.fields) {
    const read = await Promise.all(field.runs.map(run => run && unpackFrames(run)));
    const cells = field.runs.map((run, k) => {
      const solid = run && data.solids.runs[k].find(one => one.film);
      return solid ? cellsOf(solid, meshes[solid.mesh], run) : null;
    });
    if (field.low !== field.high && cells.some(own => own)) fields.push({ ...field, read, cells });
  }
  const row = element("div", parent, "", "scale"), legend = element("canvas", row);
  legend.style.cssText = "flex: 1 1 280px; max-width: 420px; min-width: 200px";
  const colours = element("select", element("label", row, "colour "));
  element("option", colours, "displacement").value = "";
  fields.forEach((field, k) => { element("option", colours, field.name).value = String(k); });
  const stretched = element("label", row, "drawn "), times = element("input", stretched), told = element("output", stretched);
  Object.assign(times, { type: "range", min: 0, max: 3, step: .02, value: 1.7 });
  const tick = (text, checked) => { const label = element("label", row), box = element("input", label); box.type = "checkbox"; box.checked = checked; label.append(" " + text); box.onchange = () => paint(); return box; };
  const block = tick("block, cut open", true), follow = tick("follow the piston", true);
  const view = { round: -.45, up: .3, half: 1, middle: [0, 0, 0] };
  const controls = { block, turn: (a, b) => { view.round += a; view.up = Math.min(1.5, Math.max(-1.5, view.up + b)); paint(); }, zoom: factor => { view.half *= factor; paint(); } };
  const area = element("div", parent, "", "maps");
  data.solids.runs.forEach((solids, run) => { if (solids.length) scenes.push(new Scene(area, data.labels[run], run, solids, meshes, controls)); });
  element("p", parent, "x, to the right at first, points to the thrust side; drag or press the arrow keys to turn, Ctrl and wheel to zoom. The piston's place along the bore is not exaggerated.", "small");
  const largest = scenes.map(scene => scene.solids.map((solid, k) => {
    const all = column(solid.coordinates); let most = 0;
    for (let frame = 0; solid.count && frame < all.length / solid.count; frame += 4) most = Math.max(most, scene.sizeOf(displaced(solid, scene.meshes[k], frame)).reduce((a, b) => Math.max(a, b), 0));
    return most;
  })).flat().reduce((a, b) => Math.max(a, b), 0) || 1;
  const points = scenes.flatMap(scene => scene.meshes.map((mesh, k) => ({ mesh, solid: scene.solids[k] })));
  const reach = Math.max(...points.filter(one => one.solid.motion).map(one => one.mesh.points.reduce((a, b) => Math.max(a, Math.abs(b)), 0)));
  view.half = 1.5 * reach;
  const paint = () => {
    const a = view.round, b = view.up;
    view.matrix = [Math.cos(a), Math.sin(b) * Math.sin(a), -Math.cos(b) * Math.sin(a), 0, Math.cos(b), Math.sin(b), Math.sin(a), -Math.sin(b) * Math.cos(a), Math.cos(b) * Math.cos(a)];
    view.times = +(10 ** times.value).toPrecision(2); view.follow = follow.checked;
    const rest = points.find(one => !one.solid.motion);
    view.middle = view.follow || !rest ? [0, 0, 0] : [0, (Math.max(...rest.mesh.points.filter((_, p) => p % 3 === 1)) + Math.min(...rest.mesh.points.filter((_, p) => p % 3 === 1))) / 2, 0];
    told.textContent = ` ${view.times} times`;
    const field = colours.value === "" ? null : fields[+colours.value];
    const scale = field ? scaleOver(field.low, field.high, field.positive, field.logarithmic) : { low: 0, high: largest, logarithmic: false };
    drawLegend(legend, scale, field ? field.unit : "µm");
    scenes.forEach(scene => scene.paint(scale, field, view));
  };
  colours.onchange = times.oninput = paint;
  painters.push(whenSeen(parent, paint)); repainters.push(paint);
  paint();
}
