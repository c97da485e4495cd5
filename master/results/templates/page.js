const data = JSON.parse(document.getElementById("data").textContent);
const byId = name => document.getElementById(name), style = name => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
const slider = byId("instant"), dark = window.matchMedia("(prefers-color-scheme: dark)");
let instant = 0, positions, numbers, playing = false;
let painters = [];           // called whenever the cursor moves; those of the film come anew with it
const always = [];           // the same of bodies and of details
const chosen = { film: 0, colour: "", run: -1 };

function element(kind, parent, text, name) {
  const made = document.createElement(kind);
  if (text) made.textContent = text;
  if (name) made.className = name;
  return parent.appendChild(made);
}

async function inflate(text) {
  const bytes = Uint8Array.from(atob(text), c => c.charCodeAt(0));
  return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"))).arrayBuffer();
}

// frames of a field: second differences from frame to frame, low bytes and high bytes (results/packing.py)
const unpackFrames = run => run.read ||= framesOf(run);
async function framesOf({ text, shape, low, high }) {
  const bytes = new Uint8Array(await inflate(text)), count = bytes.length / 2, size = shape[0] * shape[1], steps = new Uint16Array(count);
  for (let k = 0; k < count; k++) {
    const small = bytes[k] | bytes[count + k] << 8;
    steps[k] = (small >>> 1 ^ -(small & 1)) + (k < size ? 0 : 2 * steps[k - size]) - (k < 2 * size ? 0 : steps[k - 2 * size]);
  }
  const factor = (high - low) / 65535;
  return (frame, cell) => low + factor * steps[frame * size + cell];
}

const column = ([begin, count]) => numbers.subarray(begin, begin + count);
const digits = value => value === 0 ? "0" : Math.abs(value) >= 1e5 || Math.abs(value) < 1e-3 ? value.toExponential(2) : String(+value.toPrecision(3));
const withUnit = (value, unit) => digits(value) + (unit ? " " + unit : "");
const colourOf = run => run < 0 ? "var(--ink)" : `var(--run${run % data.palette.length})`;
const shows = run => chosen.run < 0 || chosen.run === run;
// index of the cells around at a position
const cellOf = ({ shape: [n], ends: [[low, high]] }, position) => Math.floor((((position - low) / (high - low)) % 1 + 1) % 1 * n);
const has = (run, cell) => !run.there || run.there[cell] === "1";
const span = values => [Math.min(...values), Math.max(...values)];

// colours of the layers of a film, as a table of pixels
const RAMPS = { pressure: ["#ffffff", "#fee090", "#fda048", "#de4933", "#890a42", "#35003c"], thickness: ["#3c095c", "#205ca4", "#56aac4", "#bee0d6", "#f8f8f2"], fraction: ["#f7f2e8", "#c9a86a", "#3b2a12"], contact: ["#ffffff", "#f4b6c2", "#c51b7d", "#40004b"] };
const FINE = 1023;
function rampOf(kind) {
  const of = RAMPS[kind] ? d3.piecewise(d3.interpolateRgb, RAMPS[kind]) : d3.interpolateViridis;
  return (rampOf[kind] ||= Uint32Array.from({ length: FINE + 1 }, (_, k) => { const { r, g, b } = d3.rgb(of(k / FINE)); return (255 << 24 | Math.round(b) << 16 | Math.round(g) << 8 | Math.round(r)) >>> 0; }));
}

// a map: the canvas holds interpolated colours, the drawing over it lines, marks and axes
const BOX = { width: 430, height: 320, left: 40, top: 8, w: 380, h: 256 };
class FieldMap {
  constructor(parent, film, run, label, kind, frame) {
    Object.assign(this, { film, kind, frame, layer: film.layers[kind], index: run });
    this.run = this.layer.runs[run];
    const figure = element("figure", parent, "", "map"), plane = (this.caption = element("figcaption", figure), element("div", figure, "", "plane"));
    this.label = element("span", this.caption, label); this.label.style.color = colourOf(run);
    this.now = element("span", this.caption, "", "dim");
    this.canvas = element("canvas", plane); this.canvas.map = this;
    this.svg = d3.select(plane).append("svg").attr("viewBox", `0 0 ${BOX.width} ${BOX.height}`).attr("role", "img");
    const [n, m] = this.run.shape, [first, second] = this.run.ends, [around, along] = this.layer.axes, id = `clip${FieldMap.count = (FieldMap.count || 0) + 1}`;
    const X = this.X = c => BOX.left + c / n * BOX.w, Y = this.Y = c => BOX.top + BOX.h - c / m * BOX.h;
    this.svg.append("clipPath").attr("id", id).append("rect").attr("x", BOX.left).attr("y", BOX.top).attr("width", BOX.w).attr("height", BOX.h);
    this.lines = this.svg.append("g").attr("clip-path", `url(#${id})`);
    const cut = this.svg.append("g").attr("class", "cut").attr("clip-path", `url(#${id})`);
    for (let i = 0; i < n; i++) for (let j = 0; j < m; j++)
      if (!has(this.run, i * m + j)) cut.append("rect").attr("x", X(i) - .3).attr("y", Y(j + 1) - .3).attr("width", BOX.w / n + .6).attr("height", BOX.h / m + .6);
    this.marks = this.svg.append("g");
    this.svg.append("rect").attr("class", "frame").attr("x", BOX.left).attr("y", BOX.top).attr("width", BOX.w).attr("height", BOX.h);
    const text = (x, y, name, words) => this.svg.append("text").attr("class", name).attr("x", x).attr("y", y).text(words);
    const across = value => X((value - first[0]) / (first[1] - first[0]) * n), floor = BOX.top + BOX.h;
    const turn = around.unit === "deg" && first[1] - first[0] > 350;
    for (const value of turn ? d3.range(90 * Math.ceil(first[0] / 90), first[1] + 5, 90) : d3.ticks(...first, 5)) text(Math.min(across(value), BOX.left + BOX.w - 4), floor + 15, "tick", value + (turn ? "°" : ""));
    for (const [word, value] of Object.entries(around.marks)) text(Math.max(BOX.left + 4 * word.length, across(value)), floor + 30, "word", word);
    text(BOX.left + BOX.w / 2, floor + 45, "tick", around.label + (around.unit ? ` [${around.unit}]` : ""));
    for (const value of d3.ticks(...second, 4)) text(BOX.left - 5, Y((value - second[0]) / (second[1] - second[0]) * m) + 4, "", value).attr("text-anchor", "end");
    text(0, 0, "tick", along.label + (along.unit ? ` [${along.unit}]` : "")).attr("transform", `translate(11 ${BOX.top + BOX.h / 2}) rotate(-90)`);
    // every cell is an odd number of pixels wide: the middle one has the value of the cell
    const odd = (pixels, cells) => 2 * Math.ceil(pixels / cells / 2) + 1, kx = odd(300, n), ky = odd(200, m), closed = this.closed = around.closed;
    Object.assign(this.canvas, { width: n * kx, height: m * ky, cell: [kx, ky] });
    const near = (count, k, wraps) => Int32Array.from({ length: count * k }, (_, p) => { const c = Math.floor((p + .5) / k - .5); return wraps ? (c + count) % count : Math.max(0, Math.min(count - 1, c)); });
    const next = (cells, count, wraps, k) => cells.map((c, p) => (p + .5) / k < .5 ? (wraps ? 0 : 0) : wraps ? (c + 1) % count : Math.min(count - 1, c + 1));
    const rest = (count, k) => Float64Array.from({ length: count * k }, (_, p) => { const c = (p + .5) / k - .5; return c - Math.floor(c); });
    this.grid = { a: near(n, kx, closed), b: near(m, ky, false), u: rest(n, kx), v: rest(m, ky) };
    this.grid.a1 = next(this.grid.a, n, closed, kx); this.grid.b1 = next(this.grid.b, m, false, ky);
    this.svg.on("pointermove", event => { const [x, y] = d3.pointer(event), i = Math.floor((x - BOX.left) / BOX.w * n), j = Math.floor((BOX.top + BOX.h - y) / BOX.h * m); this.pointed = i >= 0 && j >= 0 && i < n && j < m ? [i, j] : null; this.tell(); }).on("pointerleave", () => { this.pointed = null; this.tell(); });
    this.image = new ImageData(n * kx, m * ky); this.pixels = new Uint32Array(this.image.data.buffer);
  }
  values(kind) {
    const run = this.film.layers[kind]?.runs[this.index], frame = this.frame ?? data.cursor.frames[this.index][instant];
    return run && Float64Array.from({ length: run.shape[0] * run.shape[1] }, (_, cell) => run.at(frame, cell));
  }
  paint() {
    const values = this.values(this.kind), ramp = rampOf(this.kind), [, m] = this.run.shape, { low, high } = this.layer, { a, b, a1, b1, u, v } = this.grid, { pixels } = this, wide = a.length, tall = b.length, factor = FINE / (high - low || 1);
    for (let y = 0; y < tall; y++) for (let x = 0, row = (tall - 1 - y) * wide; x < wide; x++) {
      const p = a[x] * m, q = a1[x] * m, lower = values[p + b[y]] + u[x] * (values[q + b[y]] - values[p + b[y]]), upper = values[p + b1[y]] + u[x] * (values[q + b1[y]] - values[p + b1[y]]);
      pixels[row + x] = ramp[Math.max(0, Math.min(FINE, Math.round((lower + v[y] * (upper - lower) - low) * factor)))];
    }
    this.canvas.getContext("2d").putImageData(this.image, 0, 0);
    this.lines.selectAll("*").remove(); this.marks.selectAll("*").remove();
    const thickness = this.values("thickness"), fraction = this.values("fraction"), pressure = this.values("pressure"), said = [];
    if (thickness) this.contours(thickness, levelsOf(this.film.layers.thickness), "thickness", true);
    if (fraction) this.contours(fraction, [.99], "rupture", false);
    const extreme = (field, sign) => { let best = -1; for (let k = 0; k < field.length; k++) if (has(this.run, k) && (best < 0 || sign * field[k] > sign * field[best])) best = k; return best; };
    const mark = (cell, path) => { for (const name of ["halo", "marker"]) this.marks.append("path").attr("class", name).attr("d", path).attr("transform", `translate(${this.X(Math.floor(cell / m) + .5)} ${this.Y(cell % m + .5)})`); };
    if (thickness) { const k = extreme(thickness, -1); mark(k, "M4.5 0A4.5 4.5 0 1 0 -4.5 0A4.5 4.5 0 1 0 4.5 0"); said.push(`film ≥ ${withUnit(thickness[k], this.film.layers.thickness.unit)}`); }
    if (pressure) { const k = extreme(pressure, 1); mark(k, "M-5 0H5M0 -5V5"); said.push(`pressure ≤ ${withUnit(pressure[k], this.film.layers.pressure.unit)}`); }
    if (!said.length) said.push(`${digits(values[extreme(values, -1)])} to ${withUnit(values[extreme(values, 1)], this.layer.unit)}`);
    this.said = ` · ${said.join(", ")}${this.frame === undefined ? " now" : ""}`;
    this.svg.attr("aria-label", this.label.textContent + this.said);
    this.tell();
  }
  // the caption: extremes, or the cell under the pointer
  tell() {
    if (!this.pointed) { this.now.textContent = this.said; return; }
    const [i, j] = this.pointed, [n, m] = this.run.shape, { ends } = this.run, at = (axis, k, count) => `${digits(ends[axis][0] + (k + .5) / count * (ends[axis][1] - ends[axis][0]))} ${this.layer.axes[axis].unit}`;
    const values = Object.keys(this.film.layers).filter(kind => this.film.layers[kind].runs[this.index]).map(kind => `${this.film.layers[kind].variable || this.film.layers[kind].name} ${withUnit(this.values(kind)[i * m + j], this.film.layers[kind].unit)}`);
    this.now.textContent = ` · ${at(0, i, n)}, ${at(1, j, m)}: ${has(this.run, i * m + j) ? values.join(", ") : "no film"}`;
  }
  contours(values, levels, name, labelled) {
    const [n, m] = this.run.shape, taken = [], inside = (c, count) => Math.max(0, Math.min(count - 1, c));
    const padded = Float64Array.from({ length: (n + 2) * (m + 2) }, (_, k) => { const i = k % (n + 2) - 1, j = Math.floor(k / (n + 2)) - 1; return values[(this.closed ? (i + n) % n : inside(i, n)) * m + inside(j, m)]; });
    for (const level of d3.contours().size([n + 2, m + 2]).thresholds(levels)(padded)) {
      const rings = level.coordinates.flat().map(ring => ring.map(([x, y]) => [this.X(x - 1), this.Y(y - 1)]));
      if (!rings.length) continue;
      this.lines.append("path").attr("class", name).attr("data-level", level.value).attr("d", rings.map(ring => "M" + ring.map(p => `${p[0].toFixed(1)} ${p[1].toFixed(1)}`).join("L")).join(""));
      if (!labelled) continue;
      const anchor = BOX.left + BOX.w * (.15 + .11 * (taken.length % 3)), free = rings.flat().filter(([x, y]) => x > BOX.left + 14 && x < BOX.left + BOX.w - 14 && y > BOX.top + 8 && y < BOX.top + BOX.h - 8 && taken.every(([a, b]) => Math.abs(a - x) > 26 || Math.abs(b - y) > 13));
      const spot = d3.least(free, ([x]) => Math.abs(x - anchor));
      if (!spot) continue;
      taken.push(spot);
      this.lines.append("text").attr("class", "level").attr("x", spot[0]).attr("y", spot[1] + 4).text(digits(level.value));
    }
  }
}
// round values over the range of a film thickness, closer where it is thin
function levelsOf({ low, high }) {
  const over = factors => factors.flatMap(f => d3.range(-3, 5).map(power => +(f * 10 ** power).toPrecision(2))).filter(value => value > low && value < high).sort(d3.ascending);
  return [[1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 7], [1, 1.5, 2, 3, 5, 7], [1, 2, 5]].map(over).find(levels => levels.length < 10) || over([1, 3]);
}

// section in the thrust plane: gaps inwards, pressures outwards; or the orbit of a bearing
const SIDE = { width: 220, left: 60, right: 160, room: 46 };
function section(parent, film) {
  const { pressure, thickness } = film.layers, marks = (pressure || thickness)?.axes[0].marks || {};
  if (film.orbit) return orbit(parent, film.orbit);
  if (!pressure || !thickness || !("thrust" in marks) || !("anti-thrust" in marks)) return;
  const figure = element("figure", parent, "", "side"), svg = (element("figcaption", figure, "Section in the thrust plane"), d3.select(figure).append("svg").attr("viewBox", `0 0 ${SIDE.width} ${BOX.height}`).attr("role", "img"));
  const walls = [["thrust", SIDE.right, 1], ["anti-thrust", SIDE.left, -1]], live = svg.append("g"), floor = BOX.top + BOX.h;
  const largest = layer => d3.max(layer.runs.flatMap((run, r) => run ? walls.flatMap(([mark]) => { const [, m] = run.shape, i = cellOf(run, marks[mark]); return data.cursor.frames[r].flatMap(frame => d3.range(m).filter(j => has(run, i * m + j)).map(j => run.at(frame, i * m + j))); }) : [])) || 1;
  const gain = SIDE.room / largest(thickness), load = SIDE.room / largest(pressure), bar = d3.least([1, 2, 5, 10, 20, 50, 100, 200, 500], value => Math.abs(value * gain - 18));
  for (const [mark, x, out] of walls) { svg.append("path").attr("class", "wall").attr("d", `M${x} ${BOX.top}V${floor}`); svg.append("text").attr("class", "tick").attr("x", x + 6 * out).attr("y", floor + 15).text(mark); }
  svg.append("path").attr("class", "wall").attr("d", `M44 ${floor + 27}h${bar * gain}`);
  svg.append("text").attr("x", 50 + bar * gain).attr("y", floor + 31).text(`gap of ${bar} ${thickness.unit}`);
  svg.append("text").attr("class", "tick").attr("x", SIDE.width / 2).attr("y", floor + 47).text("shaded: pressure on the wall");
  painters.push(() => {
    live.selectAll("*").remove();
    [...data.labels.keys()].reverse().filter(shows).forEach(r => walls.forEach(([mark, wall, out]) => {
      const p = pressure.runs[r], h = thickness.runs[r], frame = data.cursor.frames[r][instant];
      const line = (run, from, factor) => { const [, m] = run.shape, i = cellOf(run, marks[mark]); return d3.range(m).filter(j => has(run, i * m + j)).map(j => `${(from + factor * run.at(frame, i * m + j)).toFixed(2)} ${(floor - (j + .5) / m * BOX.h).toFixed(2)}`).join("L"); };
      if (p) live.append("path").attr("class", "load").attr("data-run", r).attr("data-side", mark).attr("data-gain", out * load).attr("data-wall", wall).style("fill", colourOf(r)).style("stroke", colourOf(r)).attr("d", `M${wall} ${floor}L${line(p, wall, out * load)}L${wall} ${BOX.top}Z`);
      if (h) live.append("path").attr("class", "gap").attr("data-run", r).attr("data-side", mark).attr("data-gain", -out * gain).attr("data-wall", wall).style("stroke", colourOf(r)).attr("d", "M" + line(h, wall, -out * gain));
    }));
  });
}
function orbit(parent, { clearance, runs }) {
  const figure = element("figure", parent, "", "side"), svg = (element("figcaption", figure, "Orbit in the clearance circle"), d3.select(figure).append("svg").attr("viewBox", `0 0 220 ${BOX.height}`).attr("role", "img")), middle = [110, 120], radius = 92;
  const largest = d3.max(runs, run => d3.max(column(run.x), (x, k) => Math.hypot(x, column(run.y)[k]))), gain = radius / Math.max(clearance, largest);
  const at = (run, k) => `${(middle[0] + gain * column(run.x)[k]).toFixed(2)} ${(middle[1] - gain * column(run.y)[k]).toFixed(2)}`;
  svg.append("circle").attr("class", "rim").attr("cx", middle[0]).attr("cy", middle[1]).attr("r", gain * clearance);
  svg.append("path").attr("class", "frame").attr("d", `M${middle[0] - 6} ${middle[1]}h12m-6 -6v12`);
  svg.append("text").attr("class", "tick").attr("x", 110).attr("y", 240).text(`dashed: clearance of ${digits(clearance)} µm`);
  svg.append("text").attr("class", "tick").attr("x", 110).attr("y", 258).text("right: +x, thrust side");
  svg.append("text").attr("class", "tick").attr("x", 110).attr("y", 276).text("up: +y, towards the head");
  runs.forEach((run, r) => { if (shows(r)) svg.append("path").attr("class", "gap").attr("data-run", r).attr("data-gain", gain).style("stroke", colourOf(r)).attr("d", "M" + d3.range(run.at[1]).map(k => at(run, k)).join("L")); });
  const dots = runs.map((_, r) => svg.append("circle").attr("r", 5).style("fill", colourOf(r)).attr("display", shows(r) ? null : "none"));
  painters.push(() => runs.forEach((run, r) => dots[r].attr("transform", `translate(${at(run, nearest(column(run.at), positions[instant]))})`)));
}

// charts by Observable Plot; the cursor is a line of its own, moved without drawing the chart anew
const nearest = (sorted, value) => d3.bisectCenter(sorted, value);
function chart(parent, drawn, list, height = 130) {
  const carpet = drawn.kind === "carpet", over = carpet || drawn.cursor, figure = element("figure", parent, "", "chart"), head = element("figcaption", figure, (drawn.title || drawn.x) + (drawn.y ? " " + (drawn.y.match(/\[.*\]$/) || [""])[0] : carpet ? ` [${drawn.unit}]` : ""));
  const get = element("button", head, "CSV", "get"); get.title = "Download this chart as CSV"; get.onclick = () => save(figure.dataset.name + ".csv", tableOf(drawn));
  figure.dataset.name = (drawn.title || "chart").replace(/[^\w-]+/g, "_");
  const values = element("span", head, "", "values"), curves = (drawn.curves || []).filter(curve => curve.run < 0 || shows(curve.run));
  const wide = Math.max(360, Math.min(560, parent.clientWidth / (matchMedia("(max-width: 760px)").matches ? 1 : 2)));
  const inCycle = over && data.cursor.unit === "deg", [begin, end] = over ? [positions[0], positions[positions.length - 1]] : d3.extent(curves.flatMap(curve => d3.extent(column(curve.x)))), phases = over ? (drawn.phases || data.phases).filter(one => one.end > begin && one.begin < end) : [], stroke = { stroke: "var(--line)" };
  const marks = [], start = one => Math.max(begin, one.begin), fits = (one, words) => words.length * 8 < (Math.min(end, one.end) - start(one)) / (end - begin) * (wide - 58), named = phases.every(one => fits(one, one.name));
  const labels = phases.map(one => { const words = named ? [one.mark, one.name].filter(Boolean).join(", ") : ""; return { x: start(one), text: fits(one, words) && words ? words : one.mark || (named ? one.name : "") }; }).filter(one => one.text);
  if (carpet) marks.push(Plot.raster(drawn.values, { width: positions.length, height: drawn.run.shape[1], x1: begin, x2: end, y1: drawn.run.ends[1][0], y2: drawn.run.ends[1][1], imageRendering: "auto" }));
  else {
    phases.forEach((one, k) => { if (k % 2) marks.push(Plot.rectX([one], { x1: Math.max(begin, one.begin), x2: Math.min(end, one.end), fill: "var(--shade)" })); });
    (drawn.bands || []).forEach(band => marks.push(band.low === band.high ? Plot.ruleY([band.low], { strokeDasharray: "3" }) : Plot.rectY([band], { y1: "low", y2: "high", fill: "#3a7d44", fillOpacity: .15 })));
    if (drawn.corridor) marks.push(Plot.areaY({ length: drawn.corridor.x[1] }, { x: column(drawn.corridor.x), y1: column(drawn.corridor.low), y2: column(drawn.corridor.high), fill: "#808a94", fillOpacity: .3 }));
    for (const curve of [...curves].reverse()) {
      const given = { x: column(curve.x), y: column(curve.y), clip: true };
      marks.push(curve.points ? Plot.dot({ length: curve.x[1] }, { ...given, r: curve.x[1] < 60 ? 3 : 1.3, fill: colourOf(curve.run) }) : Plot.line({ length: curve.x[1] }, { ...given, stroke: colourOf(curve.run), strokeWidth: 1.6, strokeDasharray: { dash: "6 3", dot: "2 3", dashdot: "7 3 2 3" }[curve.dash] }));
    }
  }
  marks.push(Plot.text(labels, { x: "x", text: "text", frameAnchor: "top", dy: -11, textAnchor: "start", fontSize: 10, clip: false }));
  const svg = Plot.plot({
    width: wide, height: carpet ? 200 : height, marginLeft: 48, marginRight: 10, marginTop: 16, marginBottom: over ? 22 : 38, style: { background: "none", overflow: "visible" },
    x: { label: over ? null : drawn.x, domain: [begin, end], ...(inCycle ? { ticks: d3.range(90 * Math.ceil(begin / 90), end + 1, end - begin > 1000 ? 180 : 90), tickFormat: v => v + "°" } : {}) },
    y: { label: null, grid: !carpet, ticks: 4, tickFormat: digits, nice: true, ...(drawn.logarithmic && !carpet ? { type: "log" } : { zero: curves.every(curve => d3.min(column(curve.y)) >= 0) }), ...(drawn.around ? { ticks: [0, 90, 180, 270, 360], domain: [-9, 369] } : {}) },
    color: carpet ? { type: "linear", interpolate: d3.piecewise(d3.interpolateRgb, RAMPS[drawn.ramp]), domain: [drawn.layer.low, drawn.layer.high] } : undefined, marks,
  });
  if (carpet) element("div", figure, "", "ramp").append(Plot.legend({ color: svg.scale("color"), width: 260, height: 34, marginTop: 4, ticks: 4 }));
  figure.append(svg); figure.chart = { drawn, svg };
  if (!over) { for (const curve of curves.length > 1 ? curves : []) element("span", values, curve.name).style.color = colourOf(curve.run); return; }
  const x = svg.scale("x"), y = svg.scale("y"), now = d3.select(svg).append("line").attr("class", "now").attr("y1", 16).attr("y2", svg.getAttribute("height") - 22), followed = curves.filter(curve => !curve.points).slice(0, 4);
  const dots = followed.map(curve => d3.select(svg).append("circle").attr("r", 3).style("fill", colourOf(curve.run))), texts = followed.map(curve => { const made = element("span", values); made.style.color = colourOf(curve.run); return made; });
  const move = () => {
    now.attr("x1", x.apply(positions[instant])).attr("x2", x.apply(positions[instant]));
    followed.forEach((curve, c) => { const k = nearest(column(curve.x), positions[instant]), value = column(curve.y)[k]; dots[c].attr("cx", x.apply(column(curve.x)[k])).attr("cy", y.apply(value)); texts[c].textContent = `${curve.name} ${digits(value)}`; });
  };
  svg.onpointerdown = svg.onpointermove = event => { if (event.type === "pointerdown" || event.buttons) go(nearest(positions, x.invert(d3.pointer(event, svg)[0]))); };
  list.push(move); move();
}

function tableOf(drawn) {
  const cell = value => Number.isFinite(value) ? String(+value.toPrecision(7)) : "";
  if (drawn.kind === "carpet") {
    const [low, high] = drawn.run.ends[1], [, m] = drawn.run.shape, count = positions.length;
    return [[NaN, ...positions], ...d3.range(m).map(j => [low + (j + .5) / m * (high - low), ...drawn.values.subarray(j * count, (j + 1) * count)])].map(row => row.map(cell).join(",")).join("\n") + "\n";
  }
  const columns = drawn.curves.flatMap(curve => [[`${curve.name}: ${drawn.x}`, column(curve.x)], [`${curve.name}: ${drawn.title || ""} ${drawn.y}`, column(curve.y)]]);
  return [columns.map(([name]) => `"${name}"`), ...d3.range(d3.max(columns, ([, own]) => own.length)).map(k => columns.map(([, own]) => k < own.length ? cell(own[k]) : ""))].map(row => row.join(",")).join("\n") + "\n";
}
function save(name, content) {
  const link = document.createElement("a");
  link.href = content instanceof Blob ? URL.createObjectURL(content) : URL.createObjectURL(new Blob([content], { type: "text/csv" }));
  link.download = name; link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}
// the view as one picture: canvases, drawings and captions where they are on the page
async function picture() {
  const view = byId("view"), from = view.getBoundingClientRect(), canvas = document.createElement("canvas"), pen = (canvas.width = 2 * from.width, canvas.height = 2 * from.height, canvas.getContext("2d"));
  const rules = [...document.styleSheets].flatMap(sheet => [...sheet.cssRules]).map(rule => rule.cssText).filter(text => !text.startsWith("@")).join("\n");
  pen.scale(2, 2); pen.fillStyle = style("--paper"); pen.fillRect(0, 0, from.width, from.height);
  const box = node => { const own = node.getBoundingClientRect(); return [own.left - from.left, own.top - from.top, own.width, own.height]; };
  for (const node of view.querySelectorAll("canvas, svg")) {
    if (node instanceof HTMLCanvasElement) { pen.drawImage(node, ...box(node)); continue; }
    const copy = node.cloneNode(true), [, , width, height] = box(node);
    copy.setAttribute("width", width); copy.setAttribute("height", height);
    copy.prepend(Object.assign(document.createElementNS(copy.namespaceURI, "style"), { textContent: `${rules}\nsvg{${data.palette.map((_, k) => `--run${k}:${style(`--run${k}`)}`).join(";")};${["--ink", "--dim", "--line", "--paper", "--shade"].map(name => `${name}:${style(name)}`).join(";")};color:${style("--ink")}}` }));
    const image = new Image();
    image.src = "data:image/svg+xml;charset=utf-8," + encodeURIComponent(new XMLSerializer().serializeToString(copy));
    await image.decode();
    pen.drawImage(image, ...box(node));
  }
  pen.textBaseline = "top";
  for (const node of view.querySelectorAll("figcaption, figcaption .values span, #place, #legend span")) {
    const own = node.matches("figcaption") ? [...node.childNodes].filter(part => !part.matches?.(".values, button")).map(part => part.textContent).join("") : node.textContent, [x, y] = box(node);
    pen.font = getComputedStyle(node).font; pen.fillStyle = getComputedStyle(node).color; pen.fillText(own, x, y);
  }
  return new Promise(done => canvas.toBlob(done));
}

function legend(film) {
  const parent = byId("legend"), layer = film.layers[chosen.colour], flat = layer.high === layer.low;
  parent.replaceChildren();
  const bar = element("div", parent, "", "ramp"), [low, high] = flat ? [layer.low, layer.low + 1] : [layer.low, layer.high];
  bar.append(Plot.legend({ color: { type: "linear", domain: [low, high], interpolate: RAMPS[chosen.colour] ? d3.piecewise(d3.interpolateRgb, RAMPS[chosen.colour]) : d3.interpolateViridis, label: `${layer.name}${layer.unit ? ` [${layer.unit}]` : ""}` }, width: 300, height: 46, ticks: 5 }));
  const entry = (name, text) => { const made = element("span", parent); element("i", made, "", name); made.append(text); };
  if (film.layers.thickness) { entry("sample", `film thickness [${film.layers.thickness.unit}]`); element("span", parent, "○ thinnest"); }
  if (film.layers.pressure) element("span", parent, "+ highest pressure");
  if (film.layers.fraction) entry("sample dashed", "film ruptures (film fraction 0.99)");
  if (layer.runs.some(run => run?.there)) element("span", parent, "grey: no film");
}

async function showFilm() {
  const film = data.films[chosen.film];
  for (const layer of Object.values(film?.layers || {})) for (const run of layer.runs) if (run) run.at = await unpackFrames(run);
  painters = [];
  byId("maps").replaceChildren(); byId("curves").replaceChildren();
  byId("colour").hidden = true;
  if (film) {
    if (!film.layers[chosen.colour]) chosen.colour = Object.keys(film.layers)[0];
    options(byId("colour"), Object.entries(film.layers).map(([kind, layer]) => [kind, `colour: ${layer.variable || layer.name}`]), chosen.colour);
    film.layers[chosen.colour].runs.forEach((run, r) => { if (run && shows(r)) { const map = new FieldMap(byId("maps"), film, r, data.labels[r], chosen.colour); painters.push(() => map.paint()); } });
    section(byId("maps"), film);
    legend(film);
  }
  for (const one of film?.curves || data.sections.flatMap(part => part.drawn).filter(one => one.cursor).slice(0, 4)) chart(byId("curves"), one, painters);
  show();
}
function options(select, entries, value) {
  select.replaceChildren(...entries.map(([key, text]) => Object.assign(document.createElement("option"), { value: key, textContent: text })));
  select.value = value; select.hidden = entries.length < 2;
}
// pressure and film thickness along the marked lines over the crank angle
const carpets = () => data.films.map(film => ({ title: `Over ${data.cursor.label} and height${data.films.length > 1 ? `: ${film.title.replaceAll("_", " ")}` : ""}`, drawn: ["pressure", "thickness"].flatMap(kind => {
  const layer = film.layers[kind];
  if (!layer) return [];
  return Object.keys(layer.axes[0].marks).flatMap(mark => layer.runs.flatMap((run, r) => run ? [{ kind: "carpet", ramp: kind, layer, run, frames: data.cursor.frames[r], mark, title: `${layer.variable} on the ${mark} line, ${data.labels[r]}`, unit: layer.unit }] : []));
}) }));
// values along a mark at all positions of the cursor, from bottom to top
async function alongMark({ run, frames, layer, mark }) {
  run.at = await unpackFrames(run);
  const [n, m] = run.shape, i = cellOf(run, layer.axes[0].marks[mark]);
  return Float64Array.from({ length: m * frames.length }, (_, k) => { const j = Math.floor(k / frames.length), cell = i * m + j; return has(run, cell) ? run.at(frames[k % frames.length], cell) : NaN; });
}
async function showDetails() {
  const parent = byId("sections");
  if (parent.childElementCount) return;
  for (const part of [...carpets(), ...data.sections].filter(one => one.drawn.length)) {
    element("h2", parent, part.title);
    if (part.said) element("p", parent, part.said);
    const charts = element("div", parent, "", "charts");
    for (const drawn of part.drawn) {
      drawn.phases = part.phases;
      if (drawn.kind === "carpet") drawn.values = await alongMark(drawn);
      if (drawn.kind !== "map") { chart(charts, drawn, always, 220); continue; }
      for (const [r, run] of drawn.runs.entries()) {
        if (!run) continue;
        run.at = await unpackFrames(run);
        const kind = /thickness|wear/i.test(drawn.name) ? "thickness" : /contact/i.test(drawn.name) ? "contact" : "pressure", own = element("div", charts);
        element("b", own, `${drawn.name} [${drawn.unit}]`);
        new FieldMap(own, { layers: { [kind]: drawn } }, r, data.labels[r], kind, 0).paint();
      }
    }
  }
}

// the cursor and what is chosen, which the address of the page holds
function show() {
  byId("place").textContent = `${+positions[instant].toFixed(2)} ${data.cursor.unit}`;
  slider.value = instant;
  painters.forEach(paint => paint()); always.forEach(paint => paint());
  if (!playing) remember();
}
function go(k) { instant = (k + positions.length) % positions.length; show(); }
function remember() {
  const named = new URLSearchParams({ at: +positions[instant].toFixed(3) });
  if (data.films.length > 1) named.set("film", data.films[chosen.film].title);
  if (chosen.run >= 0) named.set("run", data.labels[chosen.run]);
  if (chosen.colour && chosen.colour !== Object.keys(data.films[chosen.film].layers)[0]) named.set("colour", chosen.colour);
  if (begun) history.replaceState(null, "", "#" + named);
}
let begun = false;
function recall() {
  const named = new URLSearchParams(location.hash.slice(1)), film = data.films.findIndex(one => one.title === named.get("film"));
  if (named.has("at")) instant = nearest(positions, +named.get("at"));
  if (film >= 0) chosen.film = film;
  if (named.has("run")) chosen.run = data.labels.indexOf(named.get("run"));
  if (named.has("colour")) chosen.colour = named.get("colour");
}
function play(time) {
  if (!playing) return;
  if (time - play.shown > 32) { play.shown = time; play.count += 1; go(instant + 1); }
  requestAnimationFrame(play);
}

async function begin() {
  const root = document.documentElement.style, paper = matchMedia("print"), colours = () => data.palette.forEach((colour, k) => root.setProperty(`--run${k}`, dark.matches && !paper.matches ? data.palette_dark[k] : colour));
  colours(); dark.addEventListener("change", colours); paper.addEventListener("change", colours);
  data.labels.forEach((_, run) => { for (const node of document.querySelectorAll(`.run${run}`)) node.style.color = colourOf(run); });
  const library = element("script", document.head);
  const [given, code] = await Promise.all([inflate(data.columns), inflate(byId("libraries").textContent)]);
  numbers = new Float32Array(given); positions = column(data.cursor.positions); instant = data.cursor.start;
  const run = document.createElement("script"); run.textContent = new TextDecoder().decode(code); library.replaceWith(run);
  const worst = document.querySelector("[data-film]");
  if (worst) chosen.film = data.films.findIndex(one => one.title === worst.dataset.film);
  recall();
  slider.max = positions.length - 1;
  options(byId("film"), data.films.map((one, k) => [k, one.title.replaceAll("_", " ")]), chosen.film);
  options(byId("run"), [[-1, "all runs"], ...data.labels.map((label, k) => [k, label])], chosen.run);
  byId("run").hidden = data.labels.length < 2;
  byId("film").onchange = event => { chosen.film = +event.target.value; showFilm(); };
  byId("colour").onchange = event => { chosen.colour = event.target.value; showFilm(); };
  byId("run").onchange = event => { chosen.run = +event.target.value; showFilm(); };
  for (const link of document.querySelectorAll("[data-film]")) link.onclick = event => { event.preventDefault(); byId("film").value = chosen.film = data.films.findIndex(one => one.title === link.dataset.film); showFilm(); };
  slider.oninput = () => go(+slider.value);
  byId("play").onclick = event => { playing = !playing; event.target.textContent = playing ? "❚❚" : "▶"; if (playing) { play.shown = play.count = 0; requestAnimationFrame(play); } else show(); };
  byId("csv").onclick = () => save("curves.csv", tableOf({ title: "", x: data.cursor.label, y: "", curves: [...document.querySelectorAll("#curves .chart")].flatMap(({ chart: { drawn } }) => drawn.curves.map(curve => ({ ...curve, name: `${curve.name}, ${drawn.title} ${drawn.y}` }))) }));
  byId("png").onclick = async () => save("view.png", await picture());
  addEventListener("keydown", event => { const move = { ArrowLeft: -1, ArrowRight: 1 }[event.key]; if (move && !event.target.closest("input, select, canvas, button")) { event.preventDefault(); go(instant + move); } });
  addEventListener("hashchange", () => { if (location.hash.includes("at=")) { recall(); showFilm(); } });
  byId("details").addEventListener("toggle", () => { if (byId("details").open) showDetails(); });
  byId("bodies")?.addEventListener("toggle", () => { if (byId("bodies").open) showSolids(); });
  await showFilm();
  begun = true;
  performance.mark("first picture");
  document.body.dataset.page = "ready";
}
