// Section of a film in the thrust plane, with gaps inwards and pressures outwards; of a bearing the orbit.

const SIDE = { width: 220, left: 60, right: 160, room: 46 };   // walls of the section, and room beside each
const ORBIT = { x: 110, y: 120, radius: 92 };

function sideFigure(parent, title) {
  const figure = element("figure", parent, "", "side");
  element("figcaption", figure, title);
  return d3.select(figure).append("svg").attr("viewBox", `0 0 ${SIDE.width} ${BOX.height}`).attr("role", "img");
}

function drawSide(parent, film) {
  const { pressure, thickness } = film.layers, marks = (pressure || thickness)?.axes[0].marks || {};
  if (film.orbit) drawOrbit(parent, film.orbit);
  else if (pressure && thickness && "thrust" in marks && "anti-thrust" in marks) drawSection(parent, film, marks);
}

function drawSection(parent, { layers: { pressure, thickness } }, marks) {
  const svg = sideFigure(parent, "Section in the thrust plane"), live = svg.append("g");
  const walls = [
    { mark: "thrust", x: SIDE.right, outwards: 1 },
    { mark: "anti-thrust", x: SIDE.left, outwards: -1 },
  ];
  const perGap = SIDE.room / largestOnWalls(thickness, walls, marks);
  const perLoad = SIDE.room / largestOnWalls(pressure, walls, marks);
  for (const { mark, x, outwards } of walls) {
    svg.append("path").attr("class", "wall").attr("d", `M${x} ${BOX.top}V${FLOOR}`);
    svg.append("text").attr("class", "tick").attr("x", x + 6 * outwards).attr("y", FLOOR + 15).text(mark);
  }
  drawScaleBar(svg, perGap, thickness.unit);
  painters.push(() => {
    live.selectAll("*").remove();
    for (const run of [...data.labels.keys()].reverse().filter(shows)) for (const { mark, x, outwards } of walls) {
      const load = profile(pressure, run, marks[mark], x, outwards * perLoad);
      const gap = profile(thickness, run, marks[mark], x, -outwards * perGap);
      const line = (name, gain, path) => live.append("path").attr("class", name).attr("d", path).attr("data-run", run)
        .attr("data-side", mark).attr("data-gain", gain).attr("data-wall", x).style("stroke", colourOf(run));
      if (load) {
        const area = line("load", outwards * perLoad, `M${x} ${FLOOR}L${load}L${x} ${BOX.top}Z`);
        area.style("fill", colourOf(run));
      }
      if (gap) line("gap", -outwards * perGap, "M" + gap);
    }
  });
}

function drawScaleBar(svg, perGap, unit) {
  const lengths = [1, 2, 5, 10, 20, 50, 100, 200, 500];
  const length = d3.least(lengths, value => Math.abs(value * perGap - 18));
  svg.append("path").attr("class", "wall").attr("d", `M44 ${FLOOR + 27}h${length * perGap}`);
  svg.append("text").attr("x", 50 + length * perGap).attr("y", FLOOR + 31).text(`gap of ${length} ${unit}`);
  svg.append("text").attr("class", "tick").attr("x", SIDE.width / 2).attr("y", FLOOR + 47)
    .text("shaded: pressure on the wall");
}

// cells of a run along a line around the axis, from bottom to top
function cellsAlong(run, position) {
  const m = run.shape[1], i = cellAround(run, position);
  return d3.range(m).map(j => i * m + j).filter(cell => has(run, cell));
}

// values along a line as points of the drawing, undefined without the run
function profile(layer, index, position, wall, gain) {
  const run = layer.runs[index], frame = data.cursor.frames[index][instant];
  return run && cellsAlong(run, position).map(cell => {
    const y = FLOOR - (cell % run.shape[1] + 0.5) / run.shape[1] * BOX.h;
    return `${(wall + gain * run.at(frame, cell)).toFixed(2)} ${y.toFixed(2)}`;
  }).join("L");
}

// largest value of a layer on both walls, of all runs and instants
function largestOnWalls(layer, walls, marks) {
  const known = layer.runs.flatMap((run, r) => run ? [[run, data.cursor.frames[r]]] : []);
  return d3.max(known, ([run, frames]) =>
    d3.max(walls, ({ mark }) =>
      d3.max(cellsAlong(run, marks[mark]), cell => d3.max(frames, frame => run.at(frame, cell))))) || 1;
}

function drawOrbit(parent, { clearance, runs }) {
  const svg = sideFigure(parent, "Orbit in the clearance circle");
  const radius = run => d3.max(column(run.x), (x, k) => Math.hypot(x, column(run.y)[k]));
  const gain = ORBIT.radius / Math.max(clearance, d3.max(runs, radius));
  const at = (run, k) =>
    `${(ORBIT.x + gain * column(run.x)[k]).toFixed(2)} ${(ORBIT.y - gain * column(run.y)[k]).toFixed(2)}`;
  svg.append("circle").attr("class", "rim").attr("cx", ORBIT.x).attr("cy", ORBIT.y).attr("r", gain * clearance);
  svg.append("path").attr("class", "frame").attr("d", `M${ORBIT.x - 6} ${ORBIT.y}h12m-6 -6v12`);
  const words = [`dashed: clearance of ${digits(clearance)} µm`, "right: +x, thrust side", "up: +y, towards the head"];
  words.forEach((text, k) =>
    svg.append("text").attr("class", "tick").attr("x", ORBIT.x).attr("y", 240 + 18 * k).text(text));
  runs.forEach((run, r) => {
    if (!shows(r)) return;
    const path = "M" + d3.range(run.at[1]).map(k => at(run, k)).join("L");
    svg.append("path").attr("class", "gap").attr("data-run", r).attr("data-gain", gain).attr("d", path)
      .style("stroke", colourOf(r));
    const dot = svg.append("circle").attr("r", 5).style("fill", colourOf(r));
    painters.push(() => dot.attr("transform", `translate(${at(run, nearest(column(run.at), positions[instant]))})`));
  });
}
