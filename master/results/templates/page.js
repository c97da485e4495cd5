const data = JSON.parse(document.getElementById("data").textContent);
const byId = name => document.getElementById(name), style = name => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
const slider = byId("instant"), tip = byId("tip");
let instant = 0;          // where the cursor stands, of all positions
const painters = [];      // called with the cursor's position whenever it moves
const repainters = [];    // called when colours of the page, its width or what is chosen changes

function element(kind, parent, text, name) {
  const made = document.createElement(kind);
  if (text) made.textContent = text;
  if (name) made.className = name;
  return parent.appendChild(made);
}

async function inflate(text) {
  const bytes = Uint8Array.fromBase64 ? Uint8Array.fromBase64(text) : Uint8Array.from(atob(text), c => c.charCodeAt(0));
  return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"))).arrayBuffer();
}

// half-precision numbers by their bits
const halves = new Float32Array(65536);
for (let bits = 0; bits < 65536; bits++) {
  const sign = bits & 32768 ? -1 : 1, power = (bits >> 10) & 31, part = bits & 1023;
  halves[bits] = sign * (power === 31 ? (part ? NaN : Infinity) : power ? 2 ** (power - 15) * (1 + part / 1024) : 2 ** -14 * part / 1024);
}

// frames are unpacked once, whoever draws them
const unpackFrames = run => run.read ||= framesOf(run);
async function framesOf(run) {
  const bits = new Uint16Array(await inflate(run.text)), size = run.shape[0] * run.shape[1];
  for (let k = size; k < bits.length; k++) bits[k] += bits[k - size];   // frames are steps from the one before
  return (frame, cell) => halves[bits[frame * size + cell]] * run.scale;
}

const dark = window.matchMedia("(prefers-color-scheme: dark)");
const colourOf = run => { if (run < 0) return style("--ink"); const own = dark.matches && !printing ? data.palette_dark : data.palette; return own[run % own.length]; };
let printing = false;   // on paper colours are those of the day
const onPaper = 350;    // width of a chart or a map there, two beside one another

const digits = value => value === 0 ? "0" : Math.abs(value) >= 1e5 || Math.abs(value) < 1e-3 ? value.toExponential(2) : String(+value.toPrecision(4));
const withUnit = (value, unit) => digits(value) + (unit ? " " + unit : "");

// round numbers between two ends: of a linear or of a logarithmic scale
function ticks(low, high, logarithmic, wanted = 6) {
  const found = [];
  if (logarithmic) {
    const decades = Math.log10(high / low), factors = decades > 3 ? [1] : decades > 1.5 ? [1, 3] : [1, 2, 3, 5];
    for (let power = Math.floor(Math.log10(low)); power <= Math.ceil(Math.log10(high)); power++)
      for (const factor of factors) { const value = factor * 10 ** power; if (value >= low * .999 && value <= high * 1.001) found.push(value); }
    if (found.length > 1) return found;
  }
  if (!(high > low)) return [low];
  const raw = (high - low) / wanted, unit = 10 ** Math.floor(Math.log10(raw)), step = unit * [1, 2, 2.5, 5, 10].find(f => f * unit >= raw * .999);
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + step * 1e-9; k++) found.push(+(k * step).toPrecision(12));
  return logarithmic ? found.filter(value => value > 0) : found;
}

// red, green, blue at a share of a colour table, between its entries
function colourAt(share, colours = data.colours) {
  const place = Math.min(1, Math.max(0, share)) * 255, k = Math.min(254, Math.floor(place)), rest = place - k;
  return [0, 1, 2].map(c => Math.round(colours[k][c] * (1 - rest) + colours[k + 1][c] * rest));
}

// the same by a table, as the bytes of a pixel; finer than a colour's 8 bits
const fine = 4095, tableOfPixels = colours => Uint32Array.from({ length: fine + 1 }, (_, k) => { const [r, g, b] = colourAt(k / fine, colours); return (255 << 24 | b << 16 | g << 8 | r) >>> 0; });
const pixels = tableOfPixels(data.colours), pixelsOfDifferences = tableOfPixels(data.diverging);
const pixelAt = (share, scale) => (scale.differences ? pixelsOfDifferences : pixels)[Math.round(Math.min(1, Math.max(0, share)) * fine)];

const shareOf = (value, scale) => scale.logarithmic
  ? value <= scale.low ? 0 : Math.log(value / scale.low) / Math.log(scale.high / scale.low)
  : (value - scale.low) / ((scale.high - scale.low) || 1);
const lowestDecades = 1e-4;   // a logarithmic scale reaches down to this share of its upper end

function scaleOver(low, high, positive, logarithmic) {
  if (!logarithmic || !(high > 0)) return { low, high, logarithmic: false };
  const floor = Math.max(low > 0 ? low : 0, high * lowestDecades, low > 0 ? 0 : positive || 0);
  return { low: floor < high ? floor : high / 2, high, logarithmic: true };
}

let age = 0;   // goes up whenever widths or colours of the page may have changed

// a canvas as sharp as the screen; what is drawn is in CSS pixels
function sharp(canvas, height) {
  if (canvas.age !== age) {
    canvas.age = age;
    canvas.style.height = height + "px";
    canvas.wide = printing && canvas.map ? onPaper - 10 : Math.max(160, canvas.clientWidth || canvas.parentElement.clientWidth);
    canvas.ratio = window.devicePixelRatio || 1;
    canvas.width = Math.round(canvas.wide * canvas.ratio); canvas.height = Math.round(height * canvas.ratio);
  }
  const pen = canvas.getContext("2d"), width = canvas.wide, ratio = canvas.ratio;
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  pen.clearRect(0, 0, width, height);
  pen.font = "11px system-ui, sans-serif";
  return { pen, width, height };
}

function drawLegend(canvas, scale, unit) {
  const shown = [age, scale.low, scale.high, scale.logarithmic, scale.differences, unit].join(" ");
  if (canvas.shown === shown) return;
  canvas.shown = shown;
  const { pen, width } = sharp(canvas, 32), left = 24, right = width - 40;
  for (let x = 0; x < right - left; x++) {
    pen.fillStyle = `rgb(${colourAt((x + .5) / (right - left), scale.differences ? data.diverging : data.colours)})`;
    pen.fillRect(left + x, 0, 1, 13);
  }
  pen.fillStyle = style("--ink"); pen.textAlign = "center";
  let after = -Infinity;
  for (const value of ticks(scale.low, scale.high, scale.logarithmic)) {
    const x = left + shareOf(value, scale) * (right - left), below = scale.logarithmic && value <= scale.low * 1.001;
    const text = (below ? "\u2264 " : "") + digits(value), half = pen.measureText(text).width / 2;
    pen.fillRect(x, 13, 1, 4);
    if (x - half < after) continue;
    pen.fillText(text, x, 28);
    after = x + half + 6;
  }
  pen.textAlign = "right"; pen.fillText(unit || "", width, 11);
  canvas.scale = { ...scale, left, right };
}

// lines of one value through the centres of cells, by marching squares; [x, y] pairs in cells
function contour(at, n, m, closed, level) {
  const lines = [];
  for (let i = 0; i < (closed ? n : n - 1); i++) for (let j = 0; j < m - 1; j++) {
    const corners = [[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]], values = corners.map(([a, b]) => at(a % n, b));
    if (values.some(v => Number.isNaN(v))) continue;
    const cuts = [];
    for (let k = 0; k < 4; k++) {
      const a = values[k], b = values[(k + 1) % 4];
      if ((a < level) === (b < level)) continue;
      const share = (level - a) / (b - a), p = corners[k], q = corners[(k + 1) % 4];
      cuts.push([p[0] + share * (q[0] - p[0]), p[1] + share * (q[1] - p[1])]);
    }
    for (let k = 0; k + 1 < cuts.length; k += 2) lines.push([cuts[k], cuts[k + 1]]);
  }
  return lines;
}

// one map: first index to the right, second upwards
class FieldMap {
  constructor(parent, field, run, label, at, frames, controls) {
    Object.assign(this, { field, run, label, at, frames, controls });
    const figure = element("figure", parent);
    this.caption = element("figcaption", figure);
    this.canvas = element("canvas", figure);
    this.canvas.tabIndex = 0;
    this.canvas.setAttribute("role", "img");
    this.canvas.map = this;
    const [n, m] = run.shape;
    this.cell = { i: n >> 2, j: m >> 1 };
    this.canvas.onmousemove = event => this.point(event);
    this.canvas.onmouseleave = this.canvas.onblur = () => { tip.style.display = "none"; this.held = false; };
    this.canvas.onkeydown = event => this.step(event);
  }
  frame() { return this.frames ? this.frames[instant] : 0; }
  // of every cell at the cursor, NaN where nothing is
  values() {
    const frame = this.frame(), { there } = this.run, found = new Float64Array(this.run.shape[0] * this.run.shape[1]);
    for (let cell = 0; cell < found.length; cell++) found[cell] = there && !there[cell] ? NaN : this.at(frame, cell);
    return found;
  }
  range(values = this.values()) {
    let low = Infinity, high = -Infinity, positive = Infinity;
    for (const v of values) {
      if (v < low) low = v;
      if (v > high) high = v;
      if (v > 0 && v < positive) positive = v;
    }
    return { low, high, positive };
  }
  paint(scale) {
    const { pen, width, height } = sharp(this.canvas, 218), [n, m] = this.run.shape, [first, second] = this.run.ends, axes = this.field.axes;
    const titled = axis => axis.label + (axis.unit ? ` [${axis.unit}]` : ""), upright = inLines(titled(axes[1]), 34);
    const left = 44 + 12 * (upright.length - 1), box = this.box = { left, top: 6, width: width - left - 10, height: height - 62 };
    if (!this.small) Object.assign(this.small = document.createElement("canvas"), { width: n, height: m });
    const values = this.values(), image = new ImageData(n, m), dots = new Uint32Array(image.data.buffer);
    for (let i = 0; i < n; i++) for (let j = 0; j < m; j++) {
      const v = values[i * m + j];
      if (!Number.isNaN(v)) dots[(m - 1 - j) * n + i] = pixelAt(shareOf(v, scale), scale);
    }
    const small = this.small;
    small.getContext("2d").putImageData(image, 0, 0);
    pen.imageSmoothingEnabled = false;
    pen.drawImage(small, box.left, box.top, box.width, box.height);
    if (this.controls.contours.checked && !playing) this.drawContours(pen, scale, values);
    pen.strokeStyle = pen.fillStyle = style("--ink"); pen.lineWidth = 1;
    pen.strokeRect(box.left, box.top, box.width, box.height);
    const quarters = axes[0].unit === "deg" && first[1] - first[0] > 350;
    const marks = quarters ? [0, 90, 180, 270, 360] : ticks(first[0], first[1]);
    pen.textAlign = "center";
    for (const value of marks) {
      const share = (value - first[0]) / (first[1] - first[0]), x = box.left + Math.min(1, Math.max(0, share)) * box.width;
      if (share < -.02 || share > 1.02) continue;
      pen.fillRect(x, box.top + box.height, 1, 4);
      pen.fillText(digits(value), x, box.top + box.height + 15);
    }
    for (const [word, value] of Object.entries(axes[0].marks))
      pen.fillText(word, box.left + (value - first[0]) / (first[1] - first[0]) * box.width, box.top + box.height + 28);
    pen.fillText(titled(axes[0]), box.left + box.width / 2, box.top + box.height + 42);
    pen.textAlign = "right";
    for (const value of ticks(second[0], second[1], false, 4)) {
      const y = box.top + box.height * (1 - (value - second[0]) / (second[1] - second[0]));
      pen.fillRect(box.left - 4, y, 4, 1);
      pen.fillText(digits(value), box.left - 6, y + 4);
    }
    pen.save();
    pen.translate(11, box.top + box.height / 2 + (upright.length > 1 ? 20 : 0)); pen.rotate(-Math.PI / 2); pen.textAlign = "center";
    upright.forEach((text, k) => pen.fillText(text, 0, 12 * k));
    pen.restore();
    const { low, high } = this.range(values);
    if (!(high >= low)) { this.caption.textContent = `${this.label}: no instant that both runs have recorded`; return; }
    const away = this.run.there ? "; blank: no film there" : "";
    this.caption.textContent = `${this.label}: ${digits(low)} to ${withUnit(high, this.field.unit)}${away}`;
    this.canvas.setAttribute("aria-label", `${this.field.name}, ${this.caption.textContent}`);
    if (this.held) this.tell();
  }
  drawContours(pen, scale, values) {
    const [n, m] = this.run.shape, box = this.box, at = (i, j) => values[i * m + j];
    pen.save();
    pen.beginPath(); pen.rect(box.left, box.top, box.width, box.height); pen.clip();
    const said = [];   // where labels stand: another of a steep place would cover them
    for (const level of ticks(scale.low, scale.high, scale.logarithmic)) {
      if (shareOf(level, scale) < .001 || shareOf(level, scale) > .999) continue;
      const lines = contour(at, n, m, this.field.axes[0].closed, level);
      if (!lines.length) continue;
      const bright = scale.differences ? Math.abs(shareOf(level, scale) - .5) < .35 : shareOf(level, scale) > .55, X = p => box.left + (p[0] + .5) / n * box.width, Y = p => box.top + box.height * (1 - (p[1] + .5) / m);
      pen.strokeStyle = bright ? "rgba(0,0,0,.55)" : "rgba(255,255,255,.7)"; pen.lineWidth = .8;
      pen.beginPath();
      for (const [p, q] of lines) { pen.moveTo(X(p), Y(p)); pen.lineTo(X(q), Y(q)); }
      pen.stroke();
      const within = p => [Math.min(box.left + box.width - 14, Math.max(box.left + 14, X(p))), Math.min(box.top + box.height - 3, Math.max(box.top + 10, Y(p) + 3))];
      const spot = [1, 2, 0].map(k => within(lines[Math.floor((k + .01) * lines.length / 3)][0])).find(([x, y]) => said.every(([a, b]) => Math.abs(a - x) > 34 || Math.abs(b - y) > 11));
      if (!spot) continue;
      said.push(spot);
      pen.fillStyle = bright ? "#000" : "#fff"; pen.textAlign = "center"; pen.font = "10px system-ui, sans-serif";
      pen.fillText(digits(level), ...spot);
    }
    pen.restore();
    pen.font = "11px system-ui, sans-serif";
  }
  point(event) {
    const [n, m] = this.run.shape, box = this.box, i = Math.floor((event.offsetX - box.left) / box.width * n), j = m - 1 - Math.floor((event.offsetY - box.top) / box.height * m);
    if (i < 0 || j < 0 || i >= n || j >= m) { tip.style.display = "none"; this.held = false; return; }
    this.cell = { i, j };
    this.tell();
  }
  step(event) {
    const move = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key], [n, m] = this.run.shape;
    if (!move) return;
    event.preventDefault();
    this.cell = { i: (this.cell.i + move[0] + n) % n, j: Math.min(m - 1, Math.max(0, this.cell.j + move[1])) };
    this.tell();
  }
  tell() {
    const { i, j } = this.cell, said = this.difference ? `${this.field.name}, ${this.label}` : this.field.name, [n, m] = this.run.shape, axes = this.field.axes, value = this.values()[i * m + j];
    const along = (axis, ends, k, cells) => `${axis.label} ${withUnit(ends[0] + (k + .5) / cells * (ends[1] - ends[0]), axis.unit)}`;
    const place = [along(axes[0], this.run.ends[0], i, n), along(axes[1], this.run.ends[1], j, m)];
    if (this.frames) place.push(`${data.cursor.label} ${withUnit(positions[instant], data.cursor.unit)}`);
    tip.textContent = `${said} ${Number.isNaN(value) ? "\u2013 (nothing there)" : withUnit(value, this.field.unit)}: ${place.join(", ")}`;
    const rect = this.canvas.getBoundingClientRect(), box = this.box;
    tip.style.display = "block"; this.held = true;
    tip.style.left = Math.min(window.innerWidth - tip.offsetWidth - 8, rect.left + box.left + (i + .5) / n * box.width + 14) + "px";
    tip.style.top = rect.top + box.top + (1 - (j + .5) / m) * box.height + 14 + "px";
  }
}

// a run's field less that of another at the same place and position of the cursor
class DifferenceMap extends FieldMap {
  constructor(parent, field, run, label, controls, later, first) {
    super(parent, field, run, label, null, later.frames, controls);
    Object.assign(this, { later, first, difference: true });
    const both = [later, first].map(map => map.run.there).filter(there => there);
    if (both.length) this.run = { ...run, there: run.text && both.reduce((a, b) => a.map((one, k) => one && b[k])) };
  }
  // both runs recorded this instant
  common(k = instant) {
    if (!this.frames) return true;
    const [a, b] = [this.later, this.first].map(map => map.recorded[map.frames[k]]);
    return Math.abs(a - b) <= 1e-3 * Math.abs(positions[positions.length - 1] - positions[0]) / positions.length;
  }
  values() {
    const values = this.later.values(), less = this.first.values(), common = this.common();
    return values.map((value, cell) => common ? value - less[cell] : NaN);
  }
  // largest difference of all instants, or of this one
  largest(now) {
    if (now || !this.frames) { const { low, high } = this.range(); return high >= low ? Math.max(-low, high) : 0; }
    if (this.most !== undefined) return this.most;
    const [n, m] = this.run.shape;
    this.most = 0;
    for (let k = 0; k < positions.length; k++) if (this.common(k)) for (let cell = 0; cell < n * m; cell++) {
      if (this.run.there && !this.run.there[cell]) continue;
      const apart = Math.abs(this.later.at(this.later.frames[k], cell) - this.first.at(this.first.frames[k], cell));
      if (apart > this.most) this.most = apart;
    }
    return this.most;
  }
}

// whether two runs have recorded the same instant at all
const meet = (map, first) => [...positions.keys()].some(k => DifferenceMap.prototype.common.call({ frames: map.frames, later: map, first }, k));

// differences of every later run from the first that has the field, with a legend of their own; what repaints them
function showDifferences(parent, field, maps, contours, now) {
  const [first, ...later] = maps, alike = later.filter(map => String(map.run.shape) === String(first.run.shape));
  for (const map of later) if (!alike.includes(map)) element("p", parent, `No difference of ${map.label} and ${first.label}: their grids have ${map.run.shape.join(" x ")} and ${first.run.shape.join(" x ")} cells.`, "small");
  if (!alike.length) return () => {};
  const bounds = maps[0].frames ? alike.filter(map => meet(map, first)) : alike;
  for (const map of alike) if (!bounds.includes(map)) element("p", parent, `No difference of ${map.label} and ${first.label}: they have recorded no instant in common.`, "small");
  if (!bounds.length) return () => {};
  const row = element("div", parent, "", "scale"), label = element("label", row), box = element("input", label), legend = element("canvas", row);
  box.type = "checkbox"; box.checked = true; label.append(` differences from ${first.label}`);
  legend.style.cssText = "flex: 1 1 280px; max-width: 420px; min-width: 200px";
  legend.dataset.differences = field.name;
  const area = element("div", parent, "", "maps"), shown = bounds.map(map => new DifferenceMap(area, field, map.run, `${map.label} minus ${first.label}`, { contours }, map, first));
  const repaint = () => {
    area.hidden = legend.hidden = !box.checked;
    if (!box.checked) return;
    const most = Math.max(...shown.map(map => map.largest(now()))) || 1;
    const scale = { low: -most, high: most, logarithmic: false, differences: true };
    drawLegend(legend, scale, field.unit);
    shown.forEach(map => map.paint(scale));
  };
  box.onchange = repaint;
  if (maps[0].frames) painters.push(whenSeen(area, repaint));
  return repaint;
}

// a field of every run, with its legend and what is chosen for it
async function showField(parent, field, moving) {
  element("h3", parent, field.name);
  if (field.low === field.high) {
    element("p", parent, `${withUnit(field.low, field.unit)} ${moving ? "at every instant and " : ""}in every cell of all runs that have it.`);
    return;
  }
  const row = element("div", parent, "", "scale"), legend = element("canvas", row);
  legend.style.cssText = "flex: 1 1 280px; max-width: 420px; min-width: 200px";
  legend.dataset.legend = field.name;
  const choice = (text, options) => {
    const label = element("label", row, text + " "), made = element("select", label);
    options.forEach(([value, said]) => { element("option", made, said).value = value; });
    made.onchange = () => repaint();
    return made;
  };
  const over = choice("scale", moving ? [["all", "common: all instants and runs"], ["now", "own: this instant, all runs"]] : [["all", "common: all runs"]]);
  const kind = choice("colours", [["linear", "linear"], ["log", "logarithmic"]]);
  kind.value = field.logarithmic ? "log" : "linear";
  if (!(field.high > 0)) kind.disabled = true;
  const label = element("label", row), contours = element("input", label);
  label.append(" contours");
  contours.type = "checkbox"; contours.checked = true; contours.onchange = () => repaint();
  const area = element("div", parent, "", "maps"), maps = [];
  for (const [k, run] of field.runs.entries()) {
    if (!run) { element("figcaption", element("figure", area), `${data.labels[k]}: not recorded`); continue; }
    maps.push(new FieldMap(area, field, run, data.labels[k], await unpackFrames(run), moving ? data.cursor.frames[k] : null, { contours }));
    if (moving) maps[maps.length - 1].recorded = column(data.cursor.recorded[k]);
  }
  const repaintDifferences = maps.length > 1 ? showDifferences(parent, field, maps, contours, () => over.value === "now") : () => {};
  const paint = () => {
    let { low, high, positive } = field;
    if (over.value === "now") {
      const ranges = maps.map(map => map.range());
      low = Math.min(...ranges.map(r => r.low)); high = Math.max(...ranges.map(r => r.high)); positive = Math.min(...ranges.map(r => r.positive));
    }
    const scale = scaleOver(low, high, Number.isFinite(positive) ? positive : 0, kind.value === "log");
    drawLegend(legend, scale, field.unit);
    maps.forEach(map => map.paint(scale));
  };
  const repaint = () => { paint(); repaintDifferences(); };
  if (moving) painters.push(whenSeen(area, paint));
  repainters.push(repaint);
  repaint();
}

// painting only what is on the screen; what comes into sight is painted then
function whenSeen(node, paint) {
  let seen = true;
  new IntersectionObserver(entries => { seen = entries[entries.length - 1].isIntersecting; if (seen) paint(); }).observe(node);
  return () => { if (seen) paint(); };
}

// scalar outputs under the cursor, a lane each; pointing sets the cursor. The cursor and the values are no part of the canvas
function strip() {
  const canvas = byId("strip"), lanes = data.strip.filter(lane => lane.runs.some(([, count]) => count));
  if (!lanes.length && !data.phases.length) { canvas.remove(); return; }
  const box = canvas.parentElement, now = element("div", box, "", "now"), tall = 34, X = (value, width) => (value - positions[0]) / ((positions[positions.length - 1] - positions[0]) || 1) * width;
  const said = lanes.map((lane, row) => { const made = element("span", box, "", "lane"); made.style.top = 16 + tall * row - 2 + "px"; return made; });
  const draw = () => {
    const { pen, width, height } = sharp(canvas, 16 + tall * lanes.length);
    drawPhases(pen, width, height, X);
    lanes.forEach((lane, row) => {
      const runs = lane.runs.map(column), all = runs.flatMap(own => [...own]), low = Math.min(...all), high = Math.max(...all);
      const Y = value => 16 + tall * row + (tall - 4) * (1 - (value - low) / ((high - low) || 1));
      pen.fillStyle = style("--ink"); pen.textAlign = "right"; pen.font = "10px system-ui, sans-serif";
      for (const [value, down] of high > low ? [[high, 9], [low, -1]] : [[low, -1]]) pen.fillText(digits(+value.toPrecision(3)), width - 3, Y(value) + down);
      if (low < 0 && high > 0) { pen.fillStyle = style("--line"); pen.fillRect(0, Y(0), width - 40, 1); }
      runs.forEach((own, k) => {
        pen.strokeStyle = colourOf(k); pen.lineWidth = 1.2; pen.beginPath();
        own.forEach((value, p) => pen.lineTo(X(positions[p], width), Y(value)));
        pen.stroke();
      });
    });
  };
  const paint = () => {
    const k = instant;
    lanes.forEach((lane, row) => {
      said[row].textContent = `${lane.name}: ${lane.runs.map(column).map(own => own.length ? withUnit(own[k], lane.unit) : "\u2013").join(" | ")}`;
    });
    now.style.transform = `translateX(${X(positions[k], 100).toFixed(3)}%)`;
  };
  const set = event => { if (event.buttons) go(nearest(positions[0] + event.offsetX / canvas.clientWidth * (positions[positions.length - 1] - positions[0]))); };
  canvas.onpointerdown = canvas.onpointermove = set;
  draw();
  painters.push(paint); repainters.push(() => { draw(); paint(); });
}

function drawPhases(pen, width, height, X) {
  data.phases.forEach((phase, k) => {
    const a = Math.max(0, X(phase.begin, width)), b = Math.min(width, X(phase.end, width));
    if (b <= a) return;
    if (k % 2) { pen.fillStyle = style("--shade"); pen.fillRect(a, 0, b - a, height); }
    pen.fillStyle = style("--ink"); pen.textAlign = "center";
    const said = [phase.name, phase.name.slice(0, 4) + ".", phase.name.slice(0, 2) + "."].find(text => pen.measureText(text).width + 3 < b - a);
    if (said) pen.fillText(said, (a + b) / 2, 11);
    if (!phase.mark || phase.begin < positions[0]) return;
    pen.setLineDash([2, 2]); pen.strokeStyle = style("--ink"); pen.lineWidth = 1; pen.beginPath(); pen.moveTo(a, 0); pen.lineTo(a, height); pen.stroke(); pen.setLineDash([]);
    pen.textAlign = "left"; pen.fillText(phase.mark, a + 3, height - 3);
  });
}

// charts ---------------------------------------------------------------------
let numbers, positions;
const column = ([begin, count]) => numbers.subarray(begin, begin + count);
const nearest = value => { let best = 0; positions.forEach((p, k) => { if (Math.abs(p - value) < Math.abs(positions[best] - value)) best = k; }); return best; };

function axisOfCursor(title) {
  const axis = { title: { text: title, standoff: 6 }, automargin: true, exponentformat: "power", separatethousands: true, gridcolor: style("--line"), zerolinecolor: style("--line"), linecolor: style("--line") };
  const first = positions[0], last = positions[positions.length - 1], span = last - first;
  if (data.cursor.unit === "deg") Object.assign(axis, { tick0: 0, separatethousands: false, dtick: span > 1200 ? 180 : span > 300 ? 90 : span > 120 ? 30 : 10 });
  if (span > 0) axis.range = [first - .01 * span, last + .01 * span];
  return axis;
}

// text in lines of so many letters
const inLines = (text, letters) => text.split(" ").reduce((lines, word) => { const last = lines[lines.length - 1]; return last && last.length + word.length < letters ? [...lines.slice(0, -1), last + " " + word] : [...lines, word]; }, []);

// decades that the values above zero of a chart reach over
function decades(drawn) {
  let low = Infinity, high = 0;
  for (const curve of drawn.curves) for (const value of column(curve.y)) if (value > 0) { low = Math.min(low, value); high = Math.max(high, value); }
  return high > 0 ? Math.log10(high / low) : 0;
}

// of a chart so many pixels wide: narrow ones have their title below the buttons, in lines
function layoutOf(drawn, width) {
  const narrow = width < 520, title = inLines(drawn.title || drawn.name || "", Math.floor((narrow ? width : width - 250) / 7.5)), top = narrow ? (printing ? 26 : 58) + 17 * title.length : 52 + 17 * (title.length - 1);
  const axis = title => ({ title: { text: inLines(String(title), 30).join("<br>"), standoff: 6 }, automargin: true, exponentformat: "power", separatethousands: true, gridcolor: style("--line"), zerolinecolor: style("--line"), linecolor: style("--line") });
  const layout = {
    title: { text: title.join("<br>"), font: { size: 14 }, x: 0.02, xanchor: "left", ...(narrow || title.length > 1 ? { y: 1 - (printing ? 12 : narrow ? 42 : 14) / 330, yref: "container", yanchor: "top" } : {}) }, height: 330, ...(printing ? { width } : {}), margin: { l: 60, r: 16, t: top, b: 46 },
    paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)", font: { color: style("--ink"), size: 11 }, hovermode: drawn.kind === "chart" && drawn.cursor ? "x unified" : "closest",
    hoverlabel: { bgcolor: style("--soft"), font: { color: style("--ink") } }, showlegend: drawn.kind === "chart" && drawn.curves.length > 1,
    modebar: { bgcolor: "rgba(0,0,0,0)", color: style("--line"), activecolor: style("--accent") }, legend: { orientation: "h", y: -0.24, yanchor: "top", itemsizing: drawn.kind === "chart" && drawn.curves.some(curve => curve.points) ? "constant" : "trace" }, xaxis: axis(drawn.x), yaxis: axis(drawn.y), shapes: [], annotations: [],
  };
  if (drawn.kind === "carpet") { layout.xaxis = axisOfCursor(drawn.titles.x); layout.yaxis = axis(drawn.titles.y); }
  if (drawn.kind === "chart" && drawn.cursor) layout.xaxis = axisOfCursor(drawn.x);
  if (drawn.logarithmic && drawn.kind === "chart") Object.assign(layout.yaxis, { type: "log", dtick: decades(drawn) > 2 ? 1 : "D2" });
  if (drawn.equal) Object.assign(layout.yaxis, { scaleanchor: "x", constrain: "domain" });
  if (drawn.around) Object.assign(layout.yaxis, { range: [-9, 369], tick0: 0, dtick: 90 });
  for (const band of drawn.bands || []) {
    layout.shapes.push({ type: band.low === band.high ? "line" : "rect", xref: "paper", x0: 0, x1: 1, y0: band.low, y1: band.high, layer: "below",
      fillcolor: "rgba(58,125,68,.14)", line: { width: band.low === band.high ? 1 : 0, color: style("--ink"), dash: "dot" } });
    layout.annotations.push({ text: band.said, xref: "paper", x: 1, xanchor: "right", y: drawn.logarithmic ? Math.log10(band.high) : band.high, yanchor: "bottom", showarrow: false, font: { size: 10 } });
  }
  if (drawn.kind === "carpet" || drawn.cursor) drawn.phases.forEach((phase, k) => {
    if (phase.end <= positions[0] || phase.begin >= positions[positions.length - 1]) return;
    const a = Math.max(phase.begin, positions[0]), b = Math.min(phase.end, positions[positions.length - 1]);
    if (k % 2 && drawn.kind === "chart") layout.shapes.push({ type: "rect", yref: "paper", x0: a, x1: b, y0: 0, y1: 1, layer: "below", line: { width: 0 }, fillcolor: style("--shade") });
    if (phase.mark && phase.begin >= positions[0]) {
      layout.shapes.push({ type: "line", yref: "paper", x0: a, x1: a, y0: 0, y1: 1, line: { width: 1, color: style("--ink"), dash: "dot" } });
      layout.annotations.push({ text: phase.mark, x: a, xanchor: "left", yref: "paper", y: 0, yanchor: "bottom", showarrow: false, font: { size: 10 } });
    }
    const room = (b - a) / (positions[positions.length - 1] - positions[0]) * (width - 76);
    if (room > 5 * phase.name.length) layout.annotations.push({ text: phase.name, x: (a + b) / 2, yref: "paper", y: 1, yanchor: "bottom", showarrow: false, font: { size: 10 } });
  });
  return layout;
}

// a shaded range along the abscissa: its lower edge, and its upper one filled down to it
function corridorOf({ corridor }) {
  if (!corridor) return [];
  const edge = { type: "scatter", mode: "lines", x: column(corridor.x), line: { width: 0 }, hoverinfo: "skip", showlegend: false };
  return [{ ...edge, y: column(corridor.low) }, { ...edge, y: column(corridor.high), fill: "tonexty", fillcolor: "rgba(120,130,140,.3)", name: corridor.said, showlegend: true }];
}

function tracesOf(drawn) {
  if (drawn.kind === "chart") return corridorOf(drawn).concat(drawn.curves.map(curve => ({
    type: "scatter", mode: curve.points ? "markers" : "lines", name: curve.name, x: column(curve.x), y: column(curve.y), connectgaps: false,
    line: { color: colourOf(curve.run), dash: curve.dash, width: 1.5 }, marker: { size: curve.x[1] < 60 ? 7 : 3, color: colourOf(curve.run) },
    hovertemplate: "%{y:.5g}" + (drawn.cursor ? "" : " at %{x:.5g}") + "<extra>" + curve.name + "</extra>",
  })));
  const x = column(drawn.x), y = column(drawn.y), values = column(drawn.values), rows = [...y.keys()].map(j => values.subarray(j * x.length, (j + 1) * x.length));
  const { low, high, positive } = drawn.limits, scale = scaleOver(low, high, positive, drawn.logarithmic), log = scale.logarithmic;
  const shown = log ? rows.map(row => Array.from(row, v => Number.isNaN(v) ? null : Math.log10(Math.max(v, scale.low)))) : rows.map(row => Array.from(row, v => Number.isNaN(v) ? null : v));
  const marks = ticks(scale.low, scale.high, log);
  return [{
    type: "heatmap", x, y, z: shown, customdata: rows.map(row => Array.from(row)), colorscale: data.colours.filter((_, k) => k % 15 === 0).map((c, k) => [k / 17, `rgb(${c.map(Math.round)})`]),
    zmin: log ? Math.log10(scale.low) : scale.low, zmax: log ? Math.log10(scale.high) : scale.high || 1,
    colorbar: { title: { text: drawn.titles.unit, side: "top" }, thickness: 12, tickvals: log ? marks.map(Math.log10) : marks, ticktext: marks.map((v, k) => (log && k === 0 && v <= scale.low * 1.001 ? "\u2264 " : "") + digits(v)) },
    hovertemplate: `%{customdata:.4g} ${drawn.titles.unit}<br>${drawn.titles.x}: %{x:.4g}<br>${drawn.titles.y}: %{y:.4g}<extra></extra>`,
  }];
}

function tableOf(drawn) {
  if (drawn.kind === "carpet") {
    const x = column(drawn.x), y = column(drawn.y), values = column(drawn.values), lines = [`"${drawn.titles.y} \\ ${drawn.titles.x}",${x.join(",")}`];
    y.forEach((height, j) => lines.push([height, ...values.subarray(j * x.length, (j + 1) * x.length)].join(",")));
    return lines.join("\n") + "\n";
  }
  const columns = drawn.curves.flatMap(curve => [[`${curve.name}: ${drawn.x}`, column(curve.x)], [`${curve.name}: ${drawn.y || drawn.title}`, column(curve.y)]]);
  const rows = Math.max(...columns.map(([, values]) => values.length)), lines = [columns.map(([name]) => `"${name}"`).join(",")];
  for (let k = 0; k < rows; k++) lines.push(columns.map(([, values]) => k < values.length ? values[k] : "").join(","));
  return lines.join("\n") + "\n";
}

function save(name, text) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([text], { type: "text/csv" }));
  link.download = name; link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

// the value that every curve of a chart has everywhere; undefined where they vary
function constant(drawn) {
  if (drawn.kind !== "chart" || drawn.corridor || !drawn.curves.every(curve => curve.y[1])) return undefined;
  const value = column(drawn.curves[0].y)[0];
  return drawn.curves.every(curve => column(curve.y).every(own => own === value)) ? value : undefined;
}

// of a chart's buttons one is reached by Tab, the others from it by arrow keys
function toolbar(bar) {
  const buttons = [...bar.querySelectorAll("button")], reach = k => buttons.forEach((button, n) => { button.tabIndex = n === k ? 0 : -1; });
  reach(0);
  bar.onkeydown = event => {
    const move = { ArrowLeft: -1, ArrowRight: 1 }[event.key], from = buttons.indexOf(document.activeElement);
    if (!move || from < 0) return;
    event.preventDefault(); event.stopPropagation();
    const to = (from + move + buttons.length) % buttons.length;
    reach(to); buttons[to].focus();
  };
}

// letters as a button's picture
const letters = text => ({ svg: `<svg viewBox="0 0 30 24"><text x="15" y="18" text-anchor="middle" font-family="system-ui, sans-serif" font-size="12" font-weight="600">${text}</text></svg>` });
function chart(parent, drawn, aside) {
  const same = constant(drawn);
  if (same !== undefined) {
    const unit = (drawn.y.match(/\[([^\]]+)\]$/) || [])[1] || "";
    element("p", aside, `${drawn.title}: ${withUnit(same, unit === "-" ? "" : unit)} at every step of all runs.`, "constant");
    return;
  }
  const node = element("div", parent, "", "chart"), now = element("div", node, "", "now"), name = (drawn.title || "chart").replace(/[^\w-]+/g, "_");
  let made = false;
  const cursor = () => {
    const axes = made && (drawn.cursor || drawn.kind === "carpet") && node._fullLayout;
    if (!axes) return;
    const { xaxis, _size } = axes, x = xaxis.d2p(positions[instant]);
    now.style.cssText = `left:${_size.l + x}px;top:${_size.t}px;height:${_size.h}px;display:${x >= 0 && x <= _size.w ? "block" : "none"}`;
  };
  const draw = () => {
    if (!made) node.dataset.drawn = "yes";
    const first = !made;
    made = true;
    Plotly.react(node, tracesOf(drawn), layoutOf(drawn, printing ? onPaper : node.clientWidth), {
      responsive: true, displaylogo: false, showSendToCloud: false, plotlyServerURL: "", modeBarButtonsToRemove: ["select2d", "lasso2d", "autoScale2d", "sendChartToCloud", "sendDataToCloud"], toImageButtonOptions: { filename: name, scale: 2 },
      modeBarButtonsToAdd: [
        { name: "svg", title: "Download as SVG", icon: letters("svg"), click: gd => Plotly.downloadImage(gd, { format: "svg", filename: name }) },
        { name: "csv", title: "Download as CSV", icon: letters("csv"), click: () => save(name + ".csv", tableOf(drawn)) },
      ],
    });
    const bar = node.querySelector(".modebar");
    if (bar) toolbar(bar);
    if (first) {
      node.tabIndex = 0;
      node.setAttribute("role", "group");
      node.setAttribute("aria-label", `${drawn.title || "chart"}: arrow keys go from one recorded instant to the next`);
      node.onkeydown = event => {
        const move = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
        if (!move || event.target !== node || !(drawn.cursor || drawn.kind === "carpet")) return;
        event.preventDefault();
        go(instant + move);
        if (drawn.cursor) Plotly.Fx.hover(node, { xval: positions[instant] });
      };
      node.onblur = () => Plotly.Fx.unhover(node);
      node.appendChild(now);
      node.on("plotly_relayout", cursor); node.on("plotly_afterplot", cursor);
      if (drawn.cursor || drawn.kind === "carpet") node.on("plotly_click", event => go(nearest(event.points[0].x)));
    }
    cursor();
  };
  painters.push(whenSeen(node, cursor));
  waiting.push([node, () => { if (!made) draw(); }]);
  repainters.push(() => { if (made) draw(); });
}

const waiting = [];   // charts not drawn yet: each when it comes near the screen
function drawWhenNear() {
  const watcher = new IntersectionObserver(entries => entries.forEach(entry => {
    if (entry.isIntersecting) { watcher.unobserve(entry.target); waiting.find(([node]) => node === entry.target)[1](); }
  }), { rootMargin: "400px" });
  waiting.forEach(([node]) => watcher.observe(node));
}

async function showSection(section) {
  if (!section.drawn.length) return;
  const parent = byId("sections");
  element("h2", parent, section.title);
  if (section.said) element("p", parent, section.said);
  const charts = element("div", parent, "", "charts"), aside = element("div", parent);
  for (const drawn of section.drawn) {
    drawn.phases = section.phases || data.phases;
    if (drawn.kind === "map") await showField(element("div", parent), drawn, false);
    else chart(charts, drawn, aside);
  }
}

// the cursor -----------------------------------------------------------------
function show() {
  const k = instant;
  byId("place").textContent = `${data.cursor.label} ${withUnit(+positions[k].toFixed(4), data.cursor.unit)}  (${k + 1} of ${positions.length})`;
  byId("words").textContent = data.words.map((own, run) => `${data.labels[run]}:  ${own[k]}`).join("   |   ");
  painters.forEach(paint => paint());
}
function go(k) { instant = (k + positions.length) % positions.length; slider.value = instant; show(); }
let playing = false, due = 0, shown = 0, fineness = 1;   // pictures shown while playing; dots of the bodies by dots of the screen, along a side
const between = 1000 / 30;   // from picture to picture while playing [ms]
const steps = 8, drawnFineness = () => playing ? Math.round(fineness * steps) / steps : 1;   // in steps: another size costs a frame
function turn(time) {
  if (!playing) return;
  if (time >= due - 1) {   // a screen's beat is a little early or late
    const late = time - due;
    fineness = Math.min(1, Math.max(3 / steps, fineness * (late > .75 * between ? .94 : 1.01)));
    due = Math.max(due + between, time - 4 * between);   // a few late pictures are caught up, a long pause is not
    shown += 1;
    go(instant + 1);
  }
  requestAnimationFrame(turn);
}

// what was painted so far is on the screen; a page that is not looked at does not wait
const seen = () => new Promise(done => { requestAnimationFrame(() => setTimeout(done)); setTimeout(done, 100); });

async function begin() {
  document.body.classList.toggle("single", data.labels.length === 1);
  numbers = new Float64Array(await inflate(data.columns));
  positions = column(data.cursor.positions);
  slider.max = positions.length - 1;
  slider.value = instant = data.cursor.start;
  slider.oninput = () => go(+slider.value);
  byId("back").onclick = () => go(instant - 1);
  byId("on").onclick = () => go(instant + 1);
  byId("play").onclick = event => { playing = !playing; event.target.textContent = playing ? "stop" : "play"; playing ? requestAnimationFrame(turn) : show(); };
  strip();
  await showSolids();
  show();
  await seen();
  performance.mark("first picture", { detail: { maps: document.querySelectorAll("#fields canvas").length, charts: "Plotly" in window, bodies: document.querySelectorAll(".scene").length } });
  for (const field of data.fields) { await showField(element("div", byId("fields")), field, true); await seen(); }
  show();
  const plotter = document.createElement("script");
  plotter.textContent = new TextDecoder().decode(await inflate(byId("plotter").textContent));
  document.head.appendChild(plotter);
  for (const section of data.sections) await showSection(section);
  drawWhenNear();
  show();
  const again = () => { age += 1; repainters.forEach(paint => paint()); };
  let width = window.innerWidth;
  window.addEventListener("resize", () => { if (window.innerWidth !== width) { width = window.innerWidth; again(); } });
  dark.addEventListener("change", again);
  window.addEventListener("beforeprint", () => { printing = true; waiting.forEach(([, draw]) => draw()); again(); });
  window.addEventListener("afterprint", () => { printing = false; again(); });
  document.body.dataset.page = "ready";
}
begin();
