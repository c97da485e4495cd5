// Charts by Observable Plot. The cursor is a line of its own, which moves without drawing the chart again.

const DASHES = { dash: "6 3", dot: "2 3", dashdot: "7 3 2 3" };
const MARGIN = { left: 48, right: 22, top: 16 };
const FEW = 60;   // points that are drawn large

// `list`: of the functions that move cursors
function chart(parent, drawn, list, height = 130) {
  const figure = element("figure", parent, "", "chart");
  const isCarpet = drawn.kind === "carpet", hasCursor = isCarpet || drawn.cursor;
  const curves = (drawn.curves || []).filter(curve => curve.run < 0 || shows(curve.run));
  const half = matchMedia("(max-width: 760px)").matches ? 1 : 2;
  const width = Math.max(360, Math.min(560, parent.clientWidth / half));
  const domain = hasCursor ? d3.extent(positions) : d3.extent(curves.flatMap(curve => d3.extent(column(curve.x))));
  const values = chartHead(figure, drawn);
  const phases = hasCursor ? phasesWithin(drawn.phases || data.phases, domain) : [];
  const svg = Plot.plot({
    width, height: isCarpet ? 200 : height,
    marginLeft: MARGIN.left, marginRight: MARGIN.right, marginTop: MARGIN.top, marginBottom: hasCursor ? 22 : 38,
    style: { background: "none", overflow: "visible" },
    x: { label: hasCursor ? null : drawn.x, domain, ...(hasCursor ? cursorTicks(domain) : {}) },
    y: { label: null, ticks: 4, tickFormat: digits, nice: true, ...(isCarpet ? {} : ordinate(drawn, curves)) },
    color: isCarpet ? carpetColours(drawn) : undefined,
    marks: [
      ...(isCarpet ? [carpetMark(drawn, domain)] : shadeMarks(drawn, phases)),
      ...(isCarpet ? [] : [...curves.map(curveMark).reverse(), ...extremeMarks(drawn)]),
      phaseLabels(phases, domain, width),
    ],
  });
  if (isCarpet) element("div", figure, "", "ramp").append(colourBar({ ...svg.scale("color"), label: drawn.unit }));
  figure.append(svg);
  figure.chart = { drawn, svg };
  if (hasCursor) list.push(chartCursor(svg, curves, values));
  else if (curves.length > 1)
    for (const curve of curves) element("span", values, curve.name).style.color = colourOf(curve.run);
}

// title with unit and a download; returns the element for values
function chartHead(figure, drawn) {
  const unit = drawn.kind === "carpet" ? `[${drawn.unit}]` : drawn.y.match(/\[.*\]$/)?.[0] || "";
  const head = element("figcaption", figure, `${drawn.title || drawn.x} ${unit}`);
  const download = element("button", head, "CSV", "get");
  download.title = "Download this chart as CSV";
  download.onclick = () => save((drawn.title || "chart").replace(/[^\w-]+/g, "_") + ".csv", tableOf(drawn));
  const values = element("span", head, "", "values");
  for (const band of drawn.bands || [])
    element("span", values, `${band.low === band.high ? "dashed" : "green"}: ${band.text}`, "dim");
  if (drawn.corridor) element("span", values, `grey: ${drawn.corridor.text}`, "dim");
  return values;
}

// degrees every 90 or 180; of a short run and of a time those of the library
function cursorTicks([begin, end]) {
  if (data.cursor.unit !== "deg") return {};
  const tickFormat = value => value + "°", step = end - begin > 1000 ? 180 : 90;
  if (end - begin < 180) return { tickFormat };
  return { tickFormat, ticks: d3.range(90 * Math.ceil(begin / 90), end + 1, step) };
}

function ordinate(drawn, curves) {
  if (drawn.around) return { grid: true, ticks: [0, 90, 180, 270, 360], domain: [-9, 369] };
  if (drawn.logarithmic) return { grid: true, type: "log" };
  return { grid: true, zero: curves.every(curve => d3.min(column(curve.y)) >= 0) };
}

// parts of the abscissa that are in sight, cut to it; a mark belongs to the beginning
function phasesWithin(phases, [begin, end]) {
  return phases.filter(phase => phase.end > begin && phase.begin < end).map(phase => ({
    name: phase.name, mark: phase.begin < begin - 1e-6 ? "" : phase.mark,
    begin: Math.max(begin, phase.begin), end: Math.min(end, phase.end),
  }));
}

// marks such as TDC, and the names of the phases in which they fit
function phaseLabels(phases, [begin, end], width) {
  const labels = phases.map(phase => {
    const room = (phase.end - phase.begin) / (end - begin) * (width - MARGIN.left - MARGIN.right);
    const both = [phase.mark, phase.name].filter(Boolean).join(", ");
    const choices = [both, phase.mark, phase.name].filter(words => words.length * 8 < room);
    return { x: phase.begin, text: choices.find(Boolean) || phase.mark };
  });
  const style = { frameAnchor: "top", dy: -11, textAnchor: "start", fontSize: 10, clip: false };
  return Plot.text(labels.filter(label => label.text), { x: "x", text: "text", ...style });
}

// every second phase, expected ranges and measured bands
function shadeMarks(drawn, phases) {
  const shaded = phases.filter((_, k) => k % 2);
  const marks = [Plot.rectX(shaded, { x1: "begin", x2: "end", fill: "var(--shade)" })];
  for (const band of drawn.bands) {
    const isLine = band.low === band.high;
    marks.push(isLine
      ? Plot.ruleY([band.low], { strokeDasharray: "3" })
      : Plot.rectY([band], { y1: "low", y2: "high", fill: "var(--green)", fillOpacity: 0.15 }));
  }
  if (drawn.corridor) {
    const [x, y1, y2] = ["x", "low", "high"].map(name => column(drawn.corridor[name]));
    marks.push(Plot.areaY({ length: x.length }, { x, y1, y2, fill: "var(--dim)", fillOpacity: 0.3 }));
  }
  return marks;
}

function curveMark(curve) {
  const x = column(curve.x), given = { x, y: column(curve.y), clip: true }, colour = colourOf(curve.run);
  if (curve.points) return Plot.dot({ length: x.length }, { ...given, r: x.length < FEW ? 3 : 1.3, fill: colour });
  const dash = { strokeWidth: 1.6, strokeDasharray: DASHES[curve.dash] };
  return Plot.line({ length: x.length }, { ...given, stroke: colour, ...dash });
}

// lowest and highest points with their values
function extremeMarks(drawn) {
  const own = (drawn.extremes || []).filter(extreme => shows(extreme.run)), at = { x: "x", y: "y" };
  const halo = { stroke: "var(--paper)", strokeWidth: 3, paintOrder: "stroke", fontSize: 10, clip: false };
  return own.flatMap(extreme => {
    const isRing = extreme.sign === "ring", dot = { ...at, symbol: isRing ? "circle" : "plus", r: 4, strokeWidth: 1.6 };
    const text = { ...at, text: "text", textAnchor: extreme.anchor, dy: isRing ? 11 : -11, ...halo };
    return [Plot.dot([extreme], { ...dot, stroke: colourOf(extreme.run) }), Plot.text([extreme], text)];
  });
}

// line and dots at the cursor, the values there in the caption; returns what moves them
function chartCursor(svg, curves, values) {
  const x = svg.scale("x"), y = svg.scale("y"), drawing = d3.select(svg);
  const line = drawing.append("line").attr("class", "now");
  line.attr("y1", MARGIN.top).attr("y2", svg.getAttribute("height") - 22);
  const followed = curves.filter(curve => !curve.points).slice(0, 4).map(curve => {
    const text = element("span", values);
    text.style.color = colourOf(curve.run);
    return { curve, text, dot: drawing.append("circle").attr("r", 3).style("fill", colourOf(curve.run)) };
  });
  svg.onpointerdown = svg.onpointermove = event => {
    const isDragged = event.type === "pointerdown" || event.buttons;
    if (isDragged) go(nearest(positions, x.invert(d3.pointer(event, svg)[0])));
  };
  const move = () => {
    const at = x.apply(positions[instant]);
    line.attr("x1", at).attr("x2", at);
    for (const { curve, text, dot } of followed) {
      const abscissae = column(curve.x), k = nearest(abscissae, positions[instant]), value = column(curve.y)[k];
      dot.attr("cx", x.apply(abscissae[k])).attr("cy", y.apply(value));
      text.textContent = `${curve.name} ${digits(value)}`;
    }
  };
  move();
  return move;
}

// Carpet: a layer along a marked line, over the cursor's abscissa and the height.
const carpetColours = ({ ramp, layer }) =>
  ({ type: "linear", interpolate: colourScale(ramp), domain: [layer.low, layer.high] });

function carpetMark({ values, run }, [x1, x2]) {
  const [y1, y2] = run.ends[1], size = { width: positions.length, height: run.shape[1] };
  return Plot.raster(values, { ...size, x1, x2, y1, y2, imageRendering: "auto" });
}

function carpetsOf(film) {
  const of = data.films.length > 1 ? `: ${film.title.replaceAll("_", " ")}` : "";
  const carpet = (kind, layer, mark, run, r) => ({
    kind: "carpet", ramp: kind, layer, run, mark, frames: data.cursor.frames[r], unit: layer.unit,
    title: `${layer.variable} on the ${mark} line, ${data.labels[r]}`,
  });
  const drawn = ["pressure", "thickness"].filter(kind => film.layers[kind]).flatMap(kind => {
    const layer = film.layers[kind], marks = Object.keys(layer.axes[0].marks);
    return marks.flatMap(mark =>
      layer.runs.flatMap((run, r) => run ? [carpet(kind, layer, mark, run, r)] : []));
  });
  return { title: `Over ${data.cursor.label} and height${of}`, drawn };
}

// values of a carpet, one row of all positions for each height, from bottom to top
async function carpetValues({ run, frames, layer, mark }) {
  await readFrames(run);
  const [, m] = run.shape, i = cellAround(run, layer.axes[0].marks[mark]), count = frames.length;
  return Float64Array.from({ length: m * count }, (_, k) => {
    const cell = i * m + Math.floor(k / count);
    return has(run, cell) ? run.at(frames[k % count], cell) : NaN;
  });
}

// a chart as CSV
function tableOf(drawn) {
  const cell = value => Number.isFinite(value) ? String(+value.toPrecision(7)) : "";
  const text = rows => rows.map(row => row.join(",")).join("\n") + "\n";
  if (drawn.kind === "carpet") {
    const [low, high] = drawn.run.ends[1], m = drawn.run.shape[1], count = positions.length;
    const row = j => [low + (j + 0.5) / m * (high - low), ...drawn.values.subarray(j * count, (j + 1) * count)];
    return text([[NaN, ...positions], ...d3.range(m).map(row)].map(values => values.map(cell)));
  }
  const columns = drawn.curves.flatMap(curve => [
    { head: `${curve.name}: ${drawn.x}`, values: column(curve.x) },
    { head: `${curve.name}: ${drawn.title || ""} ${drawn.y}`, values: column(curve.y) },
  ]);
  const rows = d3.range(d3.max(columns, ({ values }) => values.length));
  return text([columns.map(({ head }) => `"${head}"`), ...rows.map(k => columns.map(({ values }) => cell(values[k])))]);
}

// the curves below the maps as one table
function shownCurves() {
  const charts = [...document.querySelectorAll("#curves .chart")].map(figure => figure.chart.drawn);
  const curves = charts.flatMap(({ title, y, curves: own }) =>
    own.map(curve => ({ ...curve, name: `${curve.name}, ${title} ${y}` })));
  return { title: "", x: data.cursor.label, y: "", curves };
}

function save(name, content) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(content instanceof Blob ? content : new Blob([content], { type: "text/csv" }));
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}
