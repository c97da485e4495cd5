// Bodies in 3-D by WebGL, one canvas for each run and cylinder. Dragging or arrow keys turn all of them.

const HEIGHT = 420;   // of a canvas [px]
const NO_VALUE = -1e6;   // share of a point without a value: no triangle with such a corner has colours
const GREY = { moving: [0.68, 0.72, 0.76], resting: [0.55, 0.57, 0.6], schematic: [0.62, 0.6, 0.55] };
const VERTEX = `#version 300 es
in vec3 place; in float share;           // far below zero: no value
uniform mat3 view; uniform vec4 frame;   // centre of the view, and half of its height
uniform float aspect;
out float colour;
void main() {
  vec3 eye = view * (place - frame.xyz);
  colour = share;
  gl_Position = vec4(eye.x / frame.w / aspect, eye.y / frame.w, -eye.z / frame.w / 8.0, 1.0);
}`;
const FRAGMENT = `#version 300 es
precision highp float;
in float colour;
uniform sampler2D table; uniform vec3 plain; uniform float tall;   // pixels of the height, an eighth of the depth
out vec4 seen;
void main() {
  vec3 normal = vec3(8.0 * tall * vec2(dFdx(gl_FragCoord.z), dFdy(gl_FragCoord.z)), 1.0);
  float light = 0.45 + 0.55 * abs(dot(normal, normalize(vec3(0.3, 0.5, 0.9)))) * inversesqrt(dot(normal, normal));
  vec3 own = colour < 0.0 ? plain : texture(table, vec2((colour * 255.0 + 0.5) / 256.0, 0.5)).rgb;
  seen = vec4(own * light, 1.0);
}`;

function shaderProgram(gl) {
  const program = gl.createProgram();
  for (const [kind, source] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, FRAGMENT]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program));
  return program;
}

class Scene {
  constructor(parent, label, run, solids, meshes, controls) {
    Object.assign(this, { label, run, solids, controls, meshes: solids.map(solid => meshes[solid.mesh]) });
    const figure = element("figure", parent, "", "scene");
    this.canvas = element("canvas", figure);
    this.canvas.style.cssText = `touch-action: none; cursor: grab; height: ${HEIGHT}px`;
    this.canvas.tabIndex = 0;
    this.canvas.scene = this;
    this.thrust = element("span", figure, "thrust", "mark");
    this.anti = element("span", figure, "anti-thrust", "mark");
    this.caption = element("figcaption", figure);
    this.gl = this.canvas.getContext("webgl2", { antialias: false });
    if (!this.gl) {
      this.caption.textContent = `${label}: this browser has no WebGL 2`;
      return;
    }
    this.prepare();
    this.connect();
  }

  prepare() {
    const { gl } = this, program = this.program = shaderProgram(gl);
    this.inputs = Object.fromEntries(["place", "share"].map(name => [name, gl.getAttribLocation(program, name)]));
    for (const input of Object.values(this.inputs)) gl.enableVertexAttribArray(input);
    const names = ["view", "frame", "aspect", "tall", "plain"];
    this.uniforms = Object.fromEntries(names.map(name => [name, gl.getUniformLocation(program, name)]));
    this.parts = this.solids.map((solid, k) => this.part(solid, this.meshes[k]));
    gl.bindTexture(gl.TEXTURE_2D, gl.createTexture());
    const colours = new Uint8Array(data.colours.flat().map(Math.round));
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGB, 256, 1, 0, gl.RGB, gl.UNSIGNED_BYTE, colours);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
    gl.enable(gl.DEPTH_TEST);
  }

  // buffers of a body; one that rests is cut open
  part(solid, mesh) {
    const { gl } = this, { between, triangles } = solid.motion ? { between: [], ...mesh } : cutOpen(mesh);
    const sides = solid.motion ? enclosing(mesh) : { closed: false };
    const index = gl.createBuffer();
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, index);
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, triangles, gl.STATIC_DRAW);
    return { ...sides, between, count: triangles.length, index, place: gl.createBuffer(), share: gl.createBuffer() };
  }

  connect() {
    const { canvas, controls } = this;
    const turns = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, -0.1], ArrowDown: [0, 0.1] };
    const zooms = { "+": 1 / 1.1, "=": 1 / 1.1, "-": 1.1 };
    canvas.onpointerdown = event => canvas.setPointerCapture(event.pointerId);
    canvas.onpointermove = event => event.buttons && controls.turn(event.movementX * 0.01, event.movementY * 0.01);
    canvas.onkeydown = event => {
      if (!turns[event.key] && !zooms[event.key]) return;
      event.preventDefault();
      if (turns[event.key]) controls.turn(...turns[event.key]);
      else controls.zoom(zooms[event.key]);
    };
    canvas.onwheel = event => {
      if (!event.ctrlKey) return;
      event.preventDefault();
      controls.zoom(event.deltaY > 0 ? 1.1 : 1 / 1.1);
    };
  }

  get frame() {
    return data.cursor.frames[this.run][instant];
  }

  // displacement, its size and values of a colouring at the cursor, for each body
  appearance(colouring) {
    return this.solids.map((solid, k) => {
      const displacement = displaced(solid, this.meshes[k], this.frame), sizes = sizesOf(displacement);
      return { displacement, sizes, values: colouring.values(this, k, this.frame, sizes) };
    });
  }

  // `density`: pixels of the canvas for one of the screen
  paint(appearance, scale, view, density) {
    const { gl, canvas } = this;
    if (!gl) return;
    const ratio = (devicePixelRatio || 1) * density;
    const width = Math.round(canvas.clientWidth * ratio), height = Math.round(HEIGHT * ratio);
    if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
    const piston = this.solids.find(solid => solid.motion);
    const pistonHeight = piston ? column(piston.motion)[3 * this.frame + 1] : 0;
    const centre = view.follow ? pistonHeight : view.centre;
    gl.viewport(0, 0, width, height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.useProgram(this.program);
    gl.uniformMatrix3fv(this.uniforms.view, false, view.matrix);
    gl.uniform4f(this.uniforms.frame, 0, centre, 0, view.half);
    gl.uniform1f(this.uniforms.aspect, width / height);
    gl.uniform1f(this.uniforms.tall, height);
    this.solids.forEach((solid, k) => {
      if (solid.motion || this.controls.block.checked) this.paintBody(solid, k, appearance[k], scale, view.times);
    });
    gl.flush();   // drawn while the page goes on
    this.placeMarks(view, pistonHeight - centre);
    this.describe(appearance, view.times);
  }

  paintBody(solid, k, { displacement, values }, { low, high }, times) {
    const { gl } = this, mesh = this.meshes[k], part = this.parts[k];
    const shares = new Float32Array(mesh.points.length / 3).fill(NO_VALUE);
    if (values) for (let p = 0; p < shares.length; p++) {
      const share = (values[p] - low) / (high - low || 1);
      if (!Number.isNaN(share)) shares[p] = Math.min(1, Math.max(0, share));
    }
    const places = placed(solid, mesh, displacement, this.frame, times);
    this.fill("place", part.place, withCut(places, part.between, 3), 3);
    this.fill("share", part.share, withCut(shares, part.between, 1), 1);
    gl.uniform3f(this.uniforms.plain, ...GREY[solid.schematic ? "schematic" : solid.motion ? "moving" : "resting"]);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, part.index);
    if (part.closed) {
      gl.enable(gl.CULL_FACE);
      gl.cullFace(part.outward ? gl.BACK : gl.FRONT);
    } else gl.disable(gl.CULL_FACE);
    gl.drawElements(gl.TRIANGLES, part.count, gl.UNSIGNED_INT, 0);
  }

  fill(input, buffer, values, size) {
    const { gl } = this;
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ARRAY_BUFFER, values, gl.DYNAMIC_DRAW);
    gl.vertexAttribPointer(this.inputs[input], size, gl.FLOAT, false, 0, 0);
  }

  // the words "thrust" and "anti-thrust" before the outermost points of the two sides
  placeMarks({ matrix, half, reach }, height) {
    const { clientWidth } = this.canvas;
    for (const [mark, x] of [[this.thrust, 1.35 * reach], [this.anti, -1.35 * reach]]) {
      const right = (matrix[0] * x + matrix[3] * height) / half, up = (matrix[1] * x + matrix[4] * height) / half;
      const left = Math.min(clientWidth - 38, Math.max(38, 0.5 * (clientWidth + right * HEIGHT)));
      const top = (0.5 - 0.5 * up) * HEIGHT;
      mark.style.transform = `translate(-50%, -50%) translate(${left.toFixed(1)}px, ${top.toFixed(1)}px)`;
    }
  }

  describe(appearance, times) {
    const words = this.solids.flatMap((solid, k) => {
      if (solid.schematic) return [];
      if (solid.count) return [`${solid.name} deflects up to ${withUnit(d3.max(appearance[k].sizes), "µm")}`];
      return [`${solid.name} ${solid.held ? "rigid" : "without deflection, as modal coordinates were not recorded"}`];
    });
    const schematic = this.solids.filter(solid => solid.schematic).map(solid => solid.name);
    if (schematic.length) words.push(`${schematic.join(", ")} schematic, at true scale`);
    const drawn = `deflection, sideways motion and tilt drawn ${digits(times)} times`;
    this.caption.textContent = `${this.label}: ${words.join("; ")}; ${drawn}`;
    this.canvas.setAttribute("aria-label", this.caption.textContent);
  }
}

// Controls above the scenes
function labelled(row, words, kind, given = {}) {
  const label = element("label", row, words + " ");
  return Object.assign(element(kind, label), given);
}

function turnMatrix(round, up) {
  const [ca, sa, cb, sb] = [Math.cos(round), Math.sin(round), Math.cos(up), Math.sin(up)];
  return [ca, sb * sa, -cb * sa, 0, cb, sb, sa, -sb * ca, cb * ca];   // column after column
}

async function showSolids() {
  const parent = byId("solids");
  if (parent.childElementCount) return;
  const row = element("div", parent, "", "row"), meshes = await Promise.all(data.solids.meshes.map(unpackMesh));
  const coloured = labelled(row, "colour", "select"), over = labelled(row, "scale", "select");
  const exponents = { type: "range", min: 0, max: 3, step: 0.02, value: 1.7 };
  const exponent = labelled(row, "deformation drawn", "input", exponents);
  const timesShown = element("output", exponent.parentElement);
  const block = labelled(row, "block, cut open", "input", { type: "checkbox", checked: true });
  const follow = labelled(row, "follow the piston", "input", { type: "checkbox", checked: true });
  const bar = element("div", row), area = element("div", parent, "", "scenes");
  const help = "Drag or press the arrow keys to turn the bodies. Use Ctrl and the wheel, + or - to zoom. "
    + "Shading darkens the colours of the scale.";
  element("p", parent, help, "dim");

  const view = { round: -0.45, up: 0.3, zoom: 1 };
  const controls = {
    block, view,
    turn: (round, up) => {
      view.round += round;
      view.up = Math.min(1.5, Math.max(-1.5, view.up + up));
      paint();
    },
    zoom: factor => {
      view.zoom *= factor;
      paint();
    },
  };
  const scenes = data.solids.runs.flatMap((solids, run) =>
    [...d3.group(solids, solid => solid.owner)].map(([owner, own]) =>
      new Scene(area, [data.labels[run], owner].filter(Boolean).join(", "), run, own, meshes, controls)));
  const extent = extentOf(scenes), paints = colourings(scenes);
  fillSelect(coloured, paints.map((one, k) => [k, one.name]), 0);
  fillSelect(over, [["all", "of all instants and runs"], ["now", "of this instant"]], "all");

  let resting, shownScale;
  // once at the pixels of the screen while it moves, then at four times as many
  function paint() {
    clearTimeout(resting);
    if (!byId("bodies").open) return;
    draw(1);
    if (!playing) resting = setTimeout(draw, 250, 2);
  }
  function draw(density) {
    const colouring = paints[+coloured.value], appearances = scenes.map(scene => scene.appearance(colouring));
    const times = +(10 ** exponent.value).toPrecision(2), half = follow.checked ? 1.5 * extent.reach : extent.half;
    timesShown.textContent = ` ${times} times`;
    Object.assign(view, { ...extent, times, follow: follow.checked, half: half * view.zoom });
    view.matrix = turnMatrix(view.round, view.up);
    const scale = area.scale = scaleOf(colouring, over.value, appearances);
    const label = withBrackets(colouring.name, colouring.unit), text = [scale.low, scale.high, label].join();
    if (text !== shownScale) {
      shownScale = text;
      const domain = [scale.low, scale.high === scale.low ? scale.low + 1 : scale.high];
      bar.replaceChildren(colourBar({ type: "linear", scheme: "viridis", domain, label }));
    }
    scenes.forEach((scene, k) => scene.paint(appearances[k], scale, view, density));
  }
  async function change() {
    await Promise.all(paints[+coloured.value].fields.map(readFrames));
    paint();
  }
  for (const control of [coloured, over]) control.onchange = change;
  for (const control of [block, follow]) control.onchange = paint;
  exponent.oninput = paint;
  byId("bodies").addEventListener("toggle", paint);
  addEventListener("resize", paint);
  await change();
  always.push(paint);
}

// largest coordinate of the pistons, and centre and half the height of all bodies over all instants [m]
function extentOf(scenes) {
  const bodies = scenes.flatMap(scene => scene.solids.map((solid, k) => ({ solid, points: scene.meshes[k].points })));
  const pistons = bodies.filter(({ solid }) => solid.motion && !solid.schematic);
  const reach = d3.max(pistons, ({ points }) => d3.max(points, Math.abs));
  const heights = bodies.flatMap(({ solid, points }) => {
    const moves = solid.motion ? d3.extent(column(solid.motion).filter((_, k) => k % 3 === 1)) : [0, 0];
    const own = d3.extent(points.filter((_, k) => k % 3 === 1));
    return [own[0] + moves[0], own[1] + moves[1]];
  });
  const [low, high] = d3.extent(heights);
  return { reach, centre: (low + high) / 2, half: 0.55 * (high - low) };
}

function scaleOf({ low, high }, choice, appearances) {
  if (choice === "all") return { low, high };
  const now = d3.extent(appearances.flat().flatMap(({ values }) => values ? [...values] : []));
  return { low: now[0] ?? low, high: now[1] ?? high };
}
