// Page of a sweep: Pareto front, response or map, parallel coordinates and points, drawn by Observable Plot.

const WORDS = { raise: "larger is better", lower: "smaller is better", none: "no direction" };
const SIGNS = { pass: "✓", warning: "!", fail: "✕" };
const OTHER = -1;   // number of no input
const MOST = 60;   // points of a map with written values
const GLYPH = 6.6;   // width of a letter [px]
const outputs = data.outputs;   // name, direction, values and uncertainties of each
const inputs = data.inputs;     // name, values as positions and texts of each; named: positions have no meaning
const designs = [...data.reports.keys()];
const shown = name => outputs[+byId(name).value];
const seen = { across: OTHER, up: OTHER, held: [] };   // inputs of the panels, and the values of the others

// the designs to which no other is at least as good in all outputs and better in one
function front(chosen) {
  const judged = chosen.filter(output => output.direction !== "none");
  const cost = (design, { direction, values }) => direction === "raise" ? -values[design] : values[design];
  const beats = (other, design) => judged.every(output => cost(other, output) <= cost(design, output))
    && judged.some(output => cost(other, output) < cost(design, output));
  return judged.length ? designs.filter(design => !designs.some(other => beats(other, design))) : [];
}

const titleOf = output => output.direction === "none" ? output.name : `${output.name}, ${WORDS[output.direction]}`;
// the report of a design, or its row in the table
const linkOf = design => data.reports[design] || `#point${design}`;
const levels = ({ values }, own = designs) => d3.sort(new Set(own.map(design => values[design])));
const textAt = (input, value) => input.texts[input.values.indexOf(value)];

// largest number of decimals; smaller values have an exponent
const FIXED = 5;

// leading digits of an uncertainty up to which it has two digits, as in the terminal
const TWO_DIGITS = 3.55;

// a value of an output with its uncertainty, which has one or two digits; 0 if no digit remains
function reading(output, design) {
  const value = output.values[design], error = output.uncertainties[design], text = digitsWithin(output.values)(value);
  if (!output.uncertainties.length) return text;
  if (typeof error !== "number") return `${text} (${error || "uncertainty unknown"})`;
  if (!error) return text;
  const power = Math.floor(Math.log10(error)), tails = own => Math.round(Math.abs(own) / 10 ** last);
  let last = power - (error / 10 ** power < TWO_DIGITS ? 1 : 0);
  if (error < Math.abs(value) && tails(error) === tails(value)) last -= 1;  // a clear value differs
  const unit = 10 ** last;
  const tailed = own => {
    const rounded = Math.round(own / unit);
    if (last >= 0 || !rounded) return String(rounded * unit);
    return last >= -FIXED ? own.toFixed(-last) : own.toExponential(String(Math.abs(rounded)).length - 1);
  };
  return `${tailed(value)} ± ${tailed(error)}`;
}

// all that is known of a design, for its tooltip
function inWords(design) {
  const given = inputs.map(input => `${input.name} ${input.texts[design]}`);
  const results = outputs.map(output => `${output.name} ${reading(output, design)}`);
  return [...given, ...results, `checks: ${data.checks[design].text || "not known"}`].join("\n");
}

// a chart in an element, below the legend of its colours
function draw(parent, options) {
  const width = Math.max(340, Math.min(1120, parent.clientWidth));
  const style = { background: "none", overflow: "visible" };
  const svg = Plot.plot({ width, marginLeft: 60, marginTop: 28, marginBottom: 48, style, ...options });
  parent.replaceChildren();
  if (options.color) {
    const color = { ...svg.scale("color"), label: options.color.label };
    element("div", parent, "", "ramp").append(colourBar(color));
  }
  parent.append(svg);
}

const HALO = { stroke: "var(--paper)", strokeWidth: 3, strokeOpacity: 0.8, paintOrder: "stroke" };
const links = { href: linkOf, title: inWords };
const valueText = output => ({ text: valueWithSign(output), ...HALO, pointerEvents: "none" });
const axisOf = ({ name, values }) => ({ label: name, tickFormat: digitsWithin(values) });

// bars of uncertainty along x or y
function bars(output, own, rule, at, ends, stroke = "var(--dim)") {
  const known = own.filter(design => typeof output.uncertainties[design] === "number");
  const end = sign => design => output.values[design] + sign * output.uncertainties[design];
  return rule(known, { ...at, [`${ends}1`]: end(-1), [`${ends}2`]: end(1), stroke });
}

// signs of the checks that are not passed, beside their points
const signs = (own, at) => ["warning", "fail"].map(outcome => Plot.text(
  own.filter(design => data.checks[design].outcome === outcome),
  { ...at, text: () => SIGNS[outcome], dx: 12, dy: -9, fontWeight: 700, fontSize: 14, className: outcome, ...HALO },
));
const valueWithSign = output => design => {
  const { outcome } = data.checks[design], sign = ["warning", "fail"].includes(outcome) ? ` ${SIGNS[outcome]}` : "";
  return digitsWithin(output.values)(output.values[design]) + sign;
};

function drawFront() {
  const [x, y, colour] = ["x", "y", "z"].map(shown), best = front([x, y, colour]), inPlane = front([x, y]);
  const at = { x: design => x.values[design], y: design => y.values[design] };
  const step = d3.sort(inPlane, at.x);
  draw(byId("pareto"), {
    height: 380, grid: true, inset: 14,
    x: { ...axisOf(x), label: titleOf(x) }, y: { ...axisOf(y), label: titleOf(y) },
    color: { label: titleOf(colour), scheme: "viridis" },
    marks: [
      Plot.line(step, { ...at, stroke: "var(--dim)", strokeDasharray: "5 3", curve: "linear" }),
      bars(x, designs, Plot.ruleY, { y: at.y }, "x"),
      bars(y, designs, Plot.ruleX, { x: at.x }, "y"),
      Plot.dot(best, { ...at, r: 11, stroke: "var(--red)", strokeWidth: 2 }),
      Plot.dot(designs, { ...at, ...links, r: 7, fill: design => colour.values[design], stroke: "var(--ink)" }),
      ...signs(designs, at),
    ],
  });
  const judged = [...new Set([x, y, colour])].filter(output => output.direction !== "none");
  byId("front").textContent = judged.length
    ? `Ringed: ${best.length} of ${designs.length} points, which no other point beats in ${listed(judged)}.`
    : "No point is ringed, because none of these outputs has a direction.";
}

const listed = some => some.map(output => output.name.replace(/ \[.*\]$/, "")).join(", ");

// ---- panels: a map over two numbers, curves over a number, points of names, or cells of two names

// the designs of the panels: those with the held values of the other inputs
function heldDesigns() {
  const others = [...inputs.keys()].filter(k => k !== seen.across && k !== seen.up);
  return designs.filter(design => others.every(k => inputs[k].values[design] === seen.held[k]));
}

function drawPanels() {
  const [across, up] = [inputs[seen.across], inputs[seen.up]], own = heldDesigns();
  const isGrid = input => input && !input.named && levels(input, own).length > 1;
  byId("linear").hidden = !(isGrid(across) && isGrid(up));
  for (const k of data.panels.keys()) {
    const output = outputs[+byId(`panel${k}`).value], parent = byId(`drawn${k}`);
    if (isGrid(across) && isGrid(up)) drawMap(parent, output, own, across, up);
    else if (across.named && up) drawCells(parent, output, own, across, up);
    else if (across.named) drawNames(parent, output, own, across);
    else drawCurves(parent, output, own, across, up);
  }
}

// linear between the points of a grid; without a value where a corner of the cell is missing
function surface(output, own, across, up) {
  const [xs, ys] = [levels(across, own), levels(up, own)];
  const values = new Map(own.map(design => [`${across.values[design]} ${up.values[design]}`, output.values[design]]));
  const cell = (list, value) => Math.max(0, Math.min(list.length - 2, d3.bisectRight(list, value) - 1));
  const at = (i, j) => values.get(`${xs[i]} ${ys[j]}`) ?? NaN;
  return (x, y) => {
    const i = cell(xs, x), j = cell(ys, y);
    const u = (x - xs[i]) / (xs[i + 1] - xs[i]), v = (y - ys[j]) / (ys[j + 1] - ys[j]);
    return (1 - v) * ((1 - u) * at(i, j) + u * at(i + 1, j)) + v * ((1 - u) * at(i, j + 1) + u * at(i + 1, j + 1));
  };
}

// the swept values as ticks, unless they are close together
function sweptTicks(input, own) {
  const swept = levels(input, own), range = swept.at(-1) - swept[0];
  const isApart = d3.pairs(swept).every(([a, b]) => b - a > 0.12 * range);
  return { ...axisOf(input), ...(isApart ? { ticks: swept } : { ticks: 6 }) };
}

function drawMap(parent, output, own, across, up) {
  const at = { x: design => across.values[design], y: design => up.values[design] };
  const [[x1, x2], [y1, y2]] = [d3.extent(own, at.x), d3.extent(own, at.y)];
  const drawn = { x1, x2, y1, y2, fill: surface(output, own, across, up) };
  const isConstant = new Set(own.map(design => output.values[design])).size < 2;
  const contours = isConstant ? [] : [Plot.contour({ ...drawn, fill: "none", value: drawn.fill, stroke: "white" })];
  draw(parent, {
    height: 330, inset: 26,
    x: sweptTicks(across, own), y: sweptTicks(up, own), color: { label: output.name, scheme: "viridis" },
    marks: [
      Plot.raster({ ...drawn, pixelSize: 2 }),
      ...contours,
      Plot.dot(own, { ...at, ...links, r: 4, fill: "var(--paper)", stroke: "var(--ink)" }),
      Plot.text(own.length > MOST ? [] : own, { ...at, dy: -13, ...valueText(output) }),
    ],
  });
}

// a curve over a number for each value of the other input, with a legend
function drawCurves(parent, output, own, across, up) {
  const at = { x: design => across.values[design], y: design => output.values[design] };
  const groups = up ? levels(up, own) : [], groupOf = design => up ? groups.indexOf(up.values[design]) : 0;
  const colour = k => `var(--run${k % data.palette.length})`, stroke = design => colour(groupOf(design));
  const ordered = d3.sort(own, at.x);
  draw(parent, {
    height: 330, grid: true, inset: 12,
    x: sweptTicks(across, own), y: axisOf({ name: output.name, values: own.map(at.y) }),
    marks: [
      bars(output, own, Plot.ruleX, { x: at.x }, "y", stroke),
      Plot.line(ordered, { ...at, z: groupOf, stroke }),
      Plot.dot(own, { ...at, ...links, r: 6, fill: stroke }),
      ...signs(own, at),
    ],
  });
  const legend = document.createElement("p");
  legend.className = "row";
  groups.forEach((value, k) => { element("b", legend, `● ${textAt(up, value)}`).style.color = colour(k); });
  parent.prepend(legend);
}

const marginOf = input => 24 + GLYPH * d3.max(input.texts, text => text.length);
const bandOf = input => ({ type: "band", label: null, tickFormat: value => textAt(input, value) });

function drawNames(parent, output, own, across) {
  const at = { x: design => output.values[design], y: design => across.values[design] };
  draw(parent, {
    height: 90 + 30 * levels(across, own).length, marginLeft: marginOf(across), grid: true, inset: 8,
    x: axisOf({ name: output.name, values: own.map(at.x) }), y: bandOf(across),
    marks: [
      bars(output, own, Plot.ruleY, { y: at.y }, "x"),
      Plot.dot(own, { ...at, ...links, r: 6, fill: "var(--run0)" }),
      ...signs(own, at),
    ],
  });
}

function drawCells(parent, output, own, across, up) {
  const at = { x: design => up.values[design], y: design => across.values[design] };
  draw(parent, {
    height: 120 + 46 * levels(across, own).length, marginLeft: marginOf(across), marginBottom: 30 + 0.6 * marginOf(up),
    x: { ...bandOf(up), tickRotate: up.named ? -30 : 0 }, y: bandOf(across),
    color: { label: output.name, scheme: "viridis" },
    marks: [
      Plot.cell(own, { ...at, ...links, fill: design => output.values[design], inset: 1 }),
      Plot.text(own, { ...at, ...valueText(output) }),
    ],
  });
}

// choices of the panels: two inputs, the values of the others, and an output for each
function choosePanels() {
  const parent = byId("swept");
  const numbers = [...inputs.keys()].filter(k => !inputs[k].named && levels(inputs[k]).length > 1);
  const [first, second] = [...new Set([...numbers, ...inputs.keys()])];
  Object.assign(seen, { across: first, up: second ?? OTHER, held: inputs.map(input => input.values[0]) });
  const select = (words, entries, value, set) => {
    const made = element("select", element("label", parent, words + " "));
    fillSelect(made, entries, value);
    made.onchange = () => {
      set(+made.value);
      choose();
    };
  };
  const named = inputs.map((input, k) => [k, input.name]);
  const choose = () => {
    parent.replaceChildren();
    if (seen.up === seen.across) seen.up = OTHER;
    select("across", named, seen.across, value => { seen.across = value; });
    const others = named.filter(([k]) => k !== seen.across);
    if (others.length) select("up", [...others, [OTHER, "none"]], seen.up, value => { seen.up = value; });
    for (const [k, name] of others.filter(([k]) => k !== seen.up && levels(inputs[k]).length > 1))
      select(`${name} at`, levels(inputs[k]).map(value => [value, textAt(inputs[k], value)]), seen.held[k],
        value => { seen.held[k] = value; });
    drawPanels();
  };
  for (const [k, number] of data.panels.entries()) {
    const panel = element("section", byId("response")), row = element("p", panel, "", "row");
    const made = element("select", element("label", row, "output "));
    made.id = `panel${k}`;
    element("div", panel, "", "wide").id = `drawn${k}`;
    fillSelect(made, outputs.map((output, n) => [n, output.name]), number);
    made.onchange = drawPanels;
  }
  choose();
}

// ---- parallel coordinates

// labels of an axis with their shares of it: all values of an input, the ends of an output
function axisLabels(axis, room) {
  const [low, high] = d3.extent(axis.values), words = digitsWithin(axis.values);
  const share = value => high > low ? (value - low) / (high - low) : 0.5;
  const swept = axis.texts ? levels(axis).map(value => ({ share: share(value), text: textAt(axis, value) })) : [];
  const isFree = d3.pairs(swept).every(([a, b]) =>
    (b.share - a.share) * room > GLYPH / 2 * (a.text.length + b.text.length) + 8);
  if (axis.named || (swept.length && isFree)) return swept;
  return [...new Set([low, high])].map(value => ({ share: share(value), text: words(value) }));
}

// lines on which labels of names have room one above the other
function rowsOf(labels, room) {
  const width = d3.max(labels, ({ text }) => text.length) * GLYPH + 12;
  return labels.length < 2 ? 1 : Math.ceil(width * (labels.length - 1) / room);
}

function drawParallel() {
  const parent = byId("parallel"), colour = shown("c"), axes = [...inputs, ...outputs];
  const names = 30 + GLYPH * d3.max(axes, ({ name }) => name.length);
  const ends = 24 + GLYPH / 2 * d3.max(inputs, ({ texts }) => d3.max(texts, text => text.length));
  const room = Math.max(340, Math.min(1120, parent.clientWidth)) - names - 2 * ends;
  let height = 0;
  const placed = axes.map(axis => {
    const labels = axisLabels(axis, room), rows = axis.named ? rowsOf(labels, room) : 1;
    height += 26 + 13 * rows;
    return { axis, y: height, labels: labels.map((label, k) => ({ ...label, y: height - 9 - 13 * (k % rows) })) };
  });
  const share = ({ values }, design) => {
    const [low, high] = d3.extent(values);
    return high > low ? (values[design] - low) / (high - low) : 0.5;
  };
  const points = designs.flatMap(design => placed.map(({ axis, y }) => ({ design, y, share: share(axis, design) })));
  const at = { x: "share", y: "y" };
  draw(parent, {
    height: height + 30, marginLeft: names + ends, marginRight: ends, marginTop: 10, marginBottom: 20,
    x: { axis: null, domain: [0, 1] }, y: { axis: null, domain: [height, 0] },
    color: { label: colour.name, scheme: "viridis" },
    marks: [
      Plot.ruleY(placed, { y: "y", x1: 0, x2: 1, stroke: "var(--line)" }),
      Plot.text(placed, { y: "y", x: 0, text: ({ axis }) => axis.name, textAnchor: "end", dx: -ends }),
      Plot.line(points, {
        ...at, z: "design", stroke: ({ design }) => colour.values[design], strokeWidth: 2, strokeOpacity: 0.8,
        href: ({ design }) => linkOf(design), title: ({ design }) => inWords(design),
      }),
      Plot.text(placed.flatMap(({ labels }) => labels), { ...at, text: "text", ...HALO, className: "ends" }),
    ],
  });
}

// the points, those that no other beats in all outputs with a direction first
function drawTable() {
  const best = new Set(front(outputs)), table = byId("points"), isLinked = data.reports.some(Boolean);
  table.replaceChildren();
  const head = element("tr", table);
  for (const { name } of inputs) element("th", head, name, "n");
  element("th", head, "worst check");
  if (isLinked) element("th", head, "report");
  for (const { name } of outputs) element("th", head, name, "n");
  for (const design of d3.sort(designs, one => !best.has(one))) {
    const row = element("tr", table, "", best.has(design) ? "best" : ""), { outcome, text } = data.checks[design];
    row.id = `point${design}`;
    for (const input of inputs) element("td", row, input.texts[design], "n");
    element("td", row, outcome ? `${SIGNS[outcome]} ${text}` : "not known", outcome);
    if (isLinked && !data.reports[design]) element("td", row, "not written");
    if (data.reports[design]) element("a", element("td", row), "report").href = data.reports[design];
    for (const output of outputs) {
      const [number, remark] = reading(output, design).split("(");
      const cell = element("td", row, number, "n");
      if (remark) element("small", cell, `(${remark}`);
    }
  }
}

// directions come from declarations, and can be changed here
function drawDirections() {
  for (const output of outputs) {
    const label = element("label", byId("directions"), output.name + " "), select = element("select", label);
    fillSelect(select, Object.entries(WORDS), output.direction);
    select.onchange = () => {
      output.direction = select.value;
      drawFront();
      drawTable();
    };
  }
}

function drawAll() {
  drawFront();
  drawPanels();
  drawParallel();
}

async function begin() {
  await loadLibraries();
  for (const query of [darkScheme, onPaper]) query.addEventListener("change", usePalette);
  usePalette();
  if (outputs.length && designs.length) {
    const paints = { x: drawFront, y: drawFront, z: drawFront, c: drawParallel };
    Object.entries(paints).forEach(([name, paint], k) => {
      fillSelect(byId(name), outputs.map((output, n) => [n, output.name]), data.chosen[k < 3 ? k : 0]);
      byId(name).onchange = paint;
    });
    drawDirections();
    choosePanels();
    drawAll();
    addEventListener("resize", drawAll);
  }
  drawTable();
  document.body.dataset.page = "ready";
}
