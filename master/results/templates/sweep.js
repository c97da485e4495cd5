// Page of a sweep: Pareto front, response, parallel coordinates and points, drawn by Observable Plot.

const WORDS = { raise: "larger is better", lower: "smaller is better", none: "no direction" };
const outputs = data.outputs;   // name, direction and values of each
const inputs = data.inputs;     // name, values as positions and texts of each
const designs = [...data.reports.keys()];
const shown = name => outputs[+byId(name).value];

// the designs to which no other is at least as good in all outputs and better in one
function front(chosen) {
  const judged = chosen.filter(output => output.direction !== "none");
  const cost = (design, { direction, values }) => direction === "raise" ? -values[design] : values[design];
  const beats = (other, design) => judged.every(output => cost(other, output) <= cost(design, output))
    && judged.some(output => cost(other, output) < cost(design, output));
  return judged.length ? designs.filter(design => !designs.some(other => beats(other, design))) : [];
}

const titleOf = output => output.direction === "none" ? output.name : `${output.name}, ${WORDS[output.direction]}`;
const reportOf = design => data.reports[design] || null;

// all that is known of a design, for its tooltip
function inWords(design) {
  const given = inputs.map(input => `${input.name} ${input.texts[design]}`);
  return [...given, ...outputs.map(output => `${output.name} ${digits(output.values[design])}`)].join("\n");
}

// a chart in an element of the page, below the legend of its colours
function draw(name, options) {
  const parent = byId(name), width = Math.max(340, Math.min(1120, parent.clientWidth));
  const style = { background: "none", overflow: "visible" };
  const svg = Plot.plot({ width, marginLeft: 60, marginTop: 28, marginBottom: 42, style, ...options });
  parent.replaceChildren();
  if (options.color) {
    const color = { ...svg.scale("color"), label: options.color.label };
    element("div", parent, "", "ramp").append(colourBar(color));
  }
  parent.append(svg);
}

const HALO = { stroke: "var(--paper)", strokeWidth: 3, strokeOpacity: 0.8, paintOrder: "stroke" };
const links = { href: reportOf, title: inWords };

function drawFront() {
  const [x, y, colour] = ["x", "y", "z"].map(shown), best = front([x, y, colour]), inPlane = front([x, y]);
  const at = { x: design => x.values[design], y: design => y.values[design] };
  const step = d3.sort(inPlane, at.x);
  draw("pareto", {
    height: 380, grid: true, inset: 14,
    x: { label: titleOf(x), tickFormat: digits }, y: { label: titleOf(y), tickFormat: digits },
    color: { label: titleOf(colour), scheme: "viridis" },
    marks: [
      Plot.line(step, { ...at, stroke: "var(--dim)", strokeDasharray: "5 3", curve: "linear" }),
      Plot.dot(best, { ...at, r: 11, stroke: "var(--red)", strokeWidth: 2 }),
      Plot.dot(designs, { ...at, ...links, r: 7, fill: design => colour.values[design], stroke: "var(--ink)" }),
    ],
  });
  const judged = [...new Set([x, y, colour])].filter(output => output.direction !== "none");
  byId("front").textContent = judged.length
    ? `Ringed: ${best.length} of ${designs.length} points, which no other point beats in ${listed(judged)}.`
    : "No point is ringed, because none of these outputs has a direction.";
}

const listed = some => some.map(output => output.name.replace(/ \[.*\]$/, "")).join(", ");

// one input: a curve; two: a cell of each pair of values; further inputs: the mean over theirs
function drawResponse() {
  const output = shown("r"), [first, second] = inputs;
  if (!second) {
    const at = { x: design => first.values[design], y: design => output.values[design] };
    return draw("response", {
      height: 320, grid: true, inset: 10,
      x: { label: first.name, tickFormat: digits }, y: { label: output.name, tickFormat: digits },
      marks: [
        Plot.line(d3.sort(designs, at.x), { ...at, stroke: "var(--run0)" }),
        Plot.dot(designs, { ...at, ...links, r: 6, fill: "var(--run0)" }),
      ],
    });
  }
  const pairs = d3.groups(designs, design => `${first.values[design]} ${second.values[design]}`);
  const cells = pairs.map(([, own]) => ({ own, mean: d3.mean(own, design => output.values[design]) }));
  const at = { x: ({ own }) => first.values[own[0]], y: ({ own }) => second.values[own[0]] };
  const words = ({ own, mean }) => digits(mean) + (own.length > 1 ? ` (mean of ${own.length})` : "");
  draw("response", {
    height: 120 + 46 * new Set(second.values).size,
    x: { type: "band", label: first.name, tickFormat: digits },
    y: { type: "band", label: second.name, tickFormat: digits, reverse: true },
    color: { label: output.name, scheme: "viridis" },
    marks: [
      Plot.cell(cells, { ...at, fill: "mean", inset: 1, href: ({ own }) => reportOf(own[0]), title: words }),
      Plot.text(cells, { ...at, text: words, ...HALO, pointerEvents: "none" }),
    ],
  });
}

function drawParallel() {
  const axes = [...inputs, ...outputs], colour = shown("c");
  const share = ({ values }, design) => {
    const [low, high] = d3.extent(values);
    return high > low ? (values[design] - low) / (high - low) : 0.5;
  };
  const points = designs.flatMap(design => axes.map((axis, k) => ({ design, k, share: share(axis, design) })));
  const ends = axes.flatMap((axis, k) => d3.extent(axis.values).map((value, end) => ({ k, share: end, value })));
  const at = { x: "share", y: "k" };
  draw("parallel", {
    height: 60 + 38 * axes.length, marginLeft: 270, marginRight: 40, marginTop: 20, marginBottom: 20,
    x: { axis: null }, y: { axis: null, reverse: true },
    color: { label: colour.name, scheme: "viridis" },
    marks: [
      Plot.ruleY(axes, { y: (_, k) => k, x1: 0, x2: 1, stroke: "var(--line)" }),
      Plot.text(axes, { y: (_, k) => k, x: 0, text: "name", textAnchor: "end", dx: -40 }),
      Plot.text(ends, { ...at, text: ({ value }) => digits(value), dy: -9, ...HALO }),
      Plot.line(points, {
        ...at, z: "design", stroke: ({ design }) => colour.values[design], strokeWidth: 2, strokeOpacity: 0.8,
        href: ({ design }) => reportOf(design), title: ({ design }) => inWords(design),
      }),
    ],
  });
}

// the points, those that no other beats in all outputs with a direction first
function drawTable() {
  const best = new Set(front(outputs)), table = byId("points");
  table.replaceChildren();
  const head = element("tr", table);
  for (const name of [...inputs, ...outputs].map(axis => axis.name)) element("th", head, name, "n");
  element("th", head, "report");
  for (const design of d3.sort(designs, one => !best.has(one))) {
    const row = element("tr", table, "", best.has(design) ? "best" : "");
    for (const input of inputs) element("td", row, input.texts[design], "n");
    for (const output of outputs) element("td", row, digits(output.values[design]), "n");
    const cell = element("td", row, reportOf(design) ? "" : "not written");
    if (reportOf(design)) element("a", cell, "report").href = reportOf(design);
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
  drawResponse();
  drawParallel();
}

async function begin() {
  await loadLibraries();
  for (const query of [darkScheme, onPaper]) query.addEventListener("change", usePalette);
  usePalette();
  if (outputs.length && designs.length) {
    const paints = { x: drawFront, y: drawFront, z: drawFront, c: drawParallel, r: drawResponse };
    Object.entries(paints).forEach(([name, paint], k) => {
      fillSelect(byId(name), outputs.map((output, n) => [n, output.name]), data.chosen[k < 3 ? k : 0]);
      byId(name).onchange = paint;
    });
    drawDirections();
    drawAll();
    addEventListener("resize", drawAll);
  }
  drawTable();
  document.body.dataset.page = "ready";
}
