// Map of a field on the developed surface: a canvas with interpolated colours, and a drawing over it with contours,
// marks and axes.

const BOX = { width: 442, height: 320, left: 46, top: 8, w: 380, h: 256 };   // of the drawing, and of the field in it
const FLOOR = BOX.top + BOX.h;
const FINEST = 1023;   // last colour of a table
const { ramps: RAMPS, rupture: RUPTURE } = data.style;   // film fraction at which the film ruptures

const colourScale = kind => RAMPS[kind] ? d3.piecewise(d3.interpolateRgb, RAMPS[kind]) : d3.interpolateViridis;

// colours of a layer as pixels, least value first
function rampOf(kind) {
  return rampOf[kind] ||= Uint32Array.from({ length: FINEST + 1 }, (_, k) => {
    const { r, g, b } = d3.rgb(colourScale(kind)(k / FINEST));
    return (255 << 24 | Math.round(b) << 16 | Math.round(g) << 8 | Math.round(r)) >>> 0;
  });
}

// the cells on both sides of every pixel, and the weight of the upper one
function interpolation(cells, pixelsPerCell, closed) {
  const count = cells * pixelsPerCell;
  const lower = new Int32Array(count), upper = new Int32Array(count), weight = new Float64Array(count);
  for (let pixel = 0; pixel < count; pixel++) {
    const position = (pixel + 0.5) / pixelsPerCell - 0.5, cell = Math.floor(position);
    lower[pixel] = insideAxis(cell, cells, closed);
    upper[pixel] = insideAxis(cell + 1, cells, closed);
    weight[pixel] = position - cell;
  }
  return { count, lower, upper, weight };
}

// index of a cell beside the axis: a closed one goes round
function insideAxis(cell, cells, closed) {
  return closed ? (cell + cells) % cells : Math.max(0, Math.min(cells - 1, cell));
}

class FieldMap {
  // `frame`: of a field without time; by default that of the cursor
  constructor(parent, film, run, kind, frame) {
    Object.assign(this, { film, kind, frame, index: run, layer: film.layers[kind], run: film.layers[kind].runs[run] });
    const figure = element("figure", parent, "", "map"), caption = element("figcaption", figure);
    this.label = element("span", caption, data.labels[run]);
    this.label.style.color = colourOf(run);
    this.reading = element("span", caption, "", "dim");
    const plane = element("div", figure, "", "plane");
    this.canvas = element("canvas", plane);
    this.canvas.map = this;
    this.svg = d3.select(plane).append("svg").attr("viewBox", `0 0 ${BOX.width} ${BOX.height}`).attr("role", "img");
    const [n, m] = this.run.shape;
    this.x = d3.scaleLinear([0, n], [BOX.left, BOX.left + BOX.w]);   // of cells
    this.y = d3.scaleLinear([0, m], [FLOOR, BOX.top]);
    this.drawLayers();
    this.drawAxisAround();
    this.drawAxisAlong();
    this.prepareCanvas();
    this.followPointer();
  }

  drawLayers() {
    const clip = `clip${FieldMap.count = (FieldMap.count || 0) + 1}`;
    this.box(this.svg.append("clipPath").attr("id", clip).append("rect"));
    this.lines = this.svg.append("g").attr("clip-path", `url(#${clip})`);
    this.drawCutOuts(this.svg.append("g").attr("class", "cut").attr("clip-path", `url(#${clip})`));
    this.marks = this.svg.append("g");
    this.box(this.svg.append("rect").attr("class", "frame"));
  }

  box(rectangle) {
    rectangle.attr("x", BOX.left).attr("y", BOX.top).attr("width", BOX.w).attr("height", BOX.h);
  }

  drawCutOuts(group) {
    const [n, m] = this.run.shape, margin = 0.3;
    for (let i = 0; i < n; i++) for (let j = 0; j < m; j++) {
      if (has(this.run, i * m + j)) continue;
      group.append("rect").attr("x", this.x(i) - margin).attr("y", this.y(j + 1) - margin)
        .attr("width", BOX.w / n + 2 * margin).attr("height", BOX.h / m + 2 * margin);
    }
  }

  text(x, y, className, words) {
    return this.svg.append("text").attr("class", className).attr("x", x).attr("y", y).text(words);
  }

  drawAxisAround() {
    const axis = this.layer.axes[0], [low, high] = this.run.ends[0], right = BOX.left + BOX.w;
    const x = d3.scaleLinear([low, high], [BOX.left, right]), isTurn = axis.unit === "deg" && high - low > 350;
    const ticks = isTurn ? d3.range(90 * Math.ceil(low / 90), high + 5, 90) : d3.ticks(low, high, 5);
    for (const value of ticks)
      this.text(Math.min(x(value), right - 4), FLOOR + 16, "tick", value + (isTurn ? "°" : ""));
    for (const [word, value] of Object.entries(axis.marks))
      this.text(Math.max(BOX.left + 4 * word.length, x(value)), FLOOR + 32, "word", word);
    this.text(BOX.left + BOX.w / 2, FLOOR + 48, "tick", withBrackets(axis.label, axis.unit));
  }

  drawAxisAlong() {
    const axis = this.layer.axes[1], [low, high] = this.run.ends[1], y = d3.scaleLinear([low, high], [FLOOR, BOX.top]);
    for (const value of d3.ticks(low, high, 4))
      this.text(BOX.left - 5, y(value) + 4, "", value).attr("text-anchor", "end");
    this.text(0, 0, "tick", withBrackets(axis.label, axis.unit))
      .attr("transform", `translate(12.5 ${BOX.top + BOX.h / 2}) rotate(-90)`);
  }

  // every cell is an odd number of pixels wide, so that the middle one has the value of the cell
  prepareCanvas() {
    const [n, m] = this.run.shape, odd = (pixels, cells) => 2 * Math.ceil(pixels / cells / 2) + 1;
    const perCell = [odd(300, n), odd(200, m)];
    this.around = interpolation(n, perCell[0], this.layer.axes[0].closed);
    this.along = interpolation(m, perCell[1], false);
    Object.assign(this.canvas, { width: this.around.count, height: this.along.count, cell: perCell });
    this.image = new ImageData(this.around.count, this.along.count);
    this.pixels = new Uint32Array(this.image.data.buffer);
  }

  followPointer() {
    const [n, m] = this.run.shape;
    this.svg.on("pointermove", event => {
      const [x, y] = d3.pointer(event), i = Math.floor(this.x.invert(x)), j = Math.floor(this.y.invert(y));
      this.pointed = i >= 0 && j >= 0 && i < n && j < m ? [i, j] : null;
      this.showReading();
    });
    this.svg.on("pointerleave", () => {
      this.pointed = null;
      this.showReading();
    });
  }

  // a layer at the cursor, undefined if the run has none
  values(kind) {
    const run = this.film.layers[kind]?.runs[this.index];
    const frame = this.frame ?? data.cursor.frames[this.index][instant];
    return run && Float64Array.from({ length: run.shape[0] * run.shape[1] }, (_, cell) => run.at(frame, cell));
  }

  paint() {
    this.paintColours(this.values(this.kind));
    this.lines.selectAll("*").remove();
    this.marks.selectAll("*").remove();
    const { thickness, fraction } = this.film.layers;
    this.taken = [];   // positions of the marks
    this.extremes = ` · ${this.markExtremes().join(", ")}${this.frame === undefined ? " now" : ""}`;
    if (thickness?.runs[this.index]) this.drawContours(this.values("thickness"), thickness.levels, "thickness");
    if (fraction?.runs[this.index]) this.drawContours(this.values("fraction"), [RUPTURE], "rupture");
    this.svg.attr("aria-label", this.label.textContent + this.extremes);
    this.showReading();
  }

  paintColours(values) {
    const ramp = rampOf(this.kind), m = this.run.shape[1], { low, high } = this.layer, { around, along, pixels } = this;
    const factor = FINEST / (high - low || 1);
    for (let y = 0; y < along.count; y++) {
      const row = (along.count - 1 - y) * around.count, below = along.lower[y], above = along.upper[y];
      for (let x = 0; x < around.count; x++) {
        const left = around.lower[x] * m, right = around.upper[x] * m, u = around.weight[x];
        const lower = values[left + below] + u * (values[right + below] - values[left + below]);
        const upper = values[left + above] + u * (values[right + above] - values[left + above]);
        const share = Math.round((lower + along.weight[y] * (upper - lower) - low) * factor);
        pixels[row + x] = ramp[Math.max(0, Math.min(FINEST, share))];
      }
    }
    this.canvas.getContext("2d").putImageData(this.image, 0, 0);
  }

  // mark the thinnest film and the highest pressure, and return them in words; of another field its range
  markExtremes() {
    const { thickness, pressure } = this.film.layers, words = [];
    if (thickness?.runs[this.index]) {
      const values = this.values("thickness"), cell = this.extreme(values, -1);
      this.mark(cell, "M4.5 0A4.5 4.5 0 1 0 -4.5 0A4.5 4.5 0 1 0 4.5 0");
      words.push(`film ≥ ${withUnit(values[cell], thickness.unit)}`);
    }
    if (pressure?.runs[this.index]) {
      const values = this.values("pressure"), cell = this.extreme(values, 1);
      this.mark(cell, "M-5 0H5M0 -5V5");
      words.push(`pressure ≤ ${withUnit(values[cell], pressure.unit)}`);
    }
    if (words.length) return words;
    const values = this.values(this.kind), [low, high] = [-1, 1].map(sign => values[this.extreme(values, sign)]);
    return [`${digits(low)} to ${withUnit(high, this.layer.unit)}`];
  }

  // cell with the largest (sign 1) or smallest (sign -1) value
  extreme(values, sign) {
    return d3.maxIndex(values, (value, cell) => has(this.run, cell) ? sign * value : NaN);
  }

  mark(cell, path) {
    const m = this.run.shape[1], x = this.x(Math.floor(cell / m) + 0.5), y = this.y(cell % m + 0.5);
    this.taken.push([x, y]);
    for (const name of ["halo", "marker"])
      this.marks.append("path").attr("class", name).attr("d", path).attr("transform", `translate(${x} ${y})`);
  }

  // the caption: extremes, or the cell under the pointer
  showReading() {
    this.reading.textContent = this.pointed ? this.cellInWords(...this.pointed) : this.extremes;
  }

  cellInWords(i, j) {
    const [n, m] = this.run.shape, { ends } = this.run, { axes } = this.layer, cell = i * m + j;
    const middle = ([low, high], k, count) => digits(low + (k + 0.5) / count * (high - low));
    const place = `${middle(ends[0], i, n)} ${axes[0].unit}, ${middle(ends[1], j, m)} ${axes[1].unit}`;
    const known = Object.entries(this.film.layers).filter(([, layer]) => layer.runs[this.index]);
    const words = known.map(([kind, layer]) =>
      `${layer.variable || layer.name} ${withUnit(this.values(kind)[cell], layer.unit)}`);
    return ` · ${place}: ${has(this.run, cell) ? words.join(", ") : "no film"}`;
  }

  // contours of the film thickness have labels
  drawContours(values, levels, name) {
    const labels = [...this.taken];
    for (const contour of this.contours(values, levels)) {
      const rings = contour.coordinates.flat().map(ring => ring.map(([x, y]) => [this.x(x - 1), this.y(y - 1)]));
      if (!rings.length) continue;
      const pathOf = ring => "M" + ring.map(([x, y]) => `${x.toFixed(1)} ${y.toFixed(1)}`).join("L");
      const path = this.lines.append("path").attr("class", name);
      path.attr("data-level", contour.value).attr("d", rings.map(pathOf).join(""));
      const place = name === "thickness" && labelPlace(rings.flat(), labels);
      if (!place) continue;
      labels.push(place);
      const label = this.lines.append("text").attr("class", "level").attr("x", place[0]).attr("y", place[1] + 4);
      label.text(digits(contour.value));
    }
  }

  // contours of cells with a margin of one: on a closed axis the cells of the other end
  contours(values, levels) {
    const [n, m] = this.run.shape, { closed } = this.layer.axes[0];
    const padded = Float64Array.from({ length: (n + 2) * (m + 2) }, (_, k) => {
      const i = insideAxis(k % (n + 2) - 1, n, closed), j = insideAxis(Math.floor(k / (n + 2)) - 1, m, false);
      return values[i * m + j];
    });
    return d3.contours().size([n + 2, m + 2]).thresholds(levels)(padded);
  }
}

// a point of a contour that is clear of the frame and of other labels; labels are side by side
function labelPlace(points, labels) {
  const wanted = BOX.left + BOX.w * (0.15 + 0.11 * (labels.length % 3));
  const isInside = ([x, y]) =>
    x > BOX.left + 14 && x < BOX.left + BOX.w - 14 && y > BOX.top + 8 && y < FLOOR - 8;
  const isFree = ([x, y]) => labels.every(([a, b]) => Math.abs(a - x) > 26 || Math.abs(b - y) > 13);
  return d3.least(points.filter(point => isInside(point) && isFree(point)), ([x]) => Math.abs(x - wanted));
}

function drawLegend(film) {
  const parent = byId("legend"), layer = film.layers[chosen.colour], { thickness, pressure, fraction } = film.layers;
  parent.replaceChildren();
  const high = layer.high === layer.low ? layer.low + 1 : layer.high;
  const label = withBrackets(layer.name, layer.unit), interpolate = colourScale(chosen.colour);
  const color = { type: "linear", domain: [layer.low, high], interpolate, label };
  element("div", parent, "", "ramp").append(colourBar(color));
  const addLine = (className, text) => {
    const entry = element("span", parent);
    element("i", entry, "", className);
    entry.append(text);
  };
  if (thickness) {
    addLine("sample", withBrackets("film thickness", thickness.unit));
    element("span", parent, "○ thinnest");
  }
  if (pressure) element("span", parent, "+ highest pressure");
  if (fraction) addLine("sample dashed", `film ruptures (film fraction ${RUPTURE})`);
  if (layer.runs.some(run => run?.cells)) element("span", parent, "grey: no film");
}
