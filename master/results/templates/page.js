// The report: data of runs, what is chosen, the cursor, the view of a film and the details.

const slider = byId("instant");
const chosen = { film: 0, colour: "", run: -1 };   // run -1: all
let instant = 0;      // index of the cursor in `positions`
let positions;        // abscissae of the cursor
let numbers;          // all columns one after the other
let playing = false;
let hasBegun = false;
let painters = [];    // called when the cursor moves: those of the shown film ...
const always = [];    // ... and those of bodies and details

// Data
const column = ([begin, count]) => numbers.subarray(begin, begin + count);
const nearest = (rising, value) => d3.bisectCenter(rising, value);
const has = (run, cell) => !run.cells || run.cells[cell] === "1";
const shows = run => chosen.run < 0 || chosen.run === run;
const colourOf = run => run < 0 ? "var(--ink)" : `var(--run${run % data.palette.length})`;
const withUnit = (value, unit) => digits(value) + (unit ? " " + unit : "");
const withBrackets = (name, unit) => name + (unit ? ` [${unit}]` : "");

// index of the cells around at a position
function cellAround({ shape: [n], ends: [[low, high]] }, position) {
  const share = (position - low) / (high - low);
  return Math.floor((share - Math.floor(share)) * n);
}

// give a run's field `at(frame, cell)`, the inverse of `packed_frames` of results/packing.py
function readFrames(run) {
  return run.reading ||= inflate(run.text).then(buffer => {
    const size = run.shape[0] * run.shape[1], shares = fromDifferences(new Uint8Array(buffer), size);
    const factor = (run.high - run.low) / 65535;
    run.at = (frame, cell) => run.low + factor * shares[frame * size + cell];
  });
}

// frames from their second differences: low bytes, then high bytes, the sign in the last bit
function fromDifferences(bytes, size) {
  const count = bytes.length / 2, values = new Uint16Array(count);
  for (let k = 0; k < count; k++) {
    const folded = bytes[k] | bytes[count + k] << 8, difference = folded >>> 1 ^ -(folded & 1);
    const before = k < size ? 0 : values[k - size], earlier = k < 2 * size ? 0 : values[k - 2 * size];
    values[k] = difference + 2 * before - earlier;
  }
  return values;
}

// Cursor
function show() {
  byId("place").textContent = `${+positions[instant].toFixed(2)} ${data.cursor.unit}`;
  slider.value = instant;
  for (const paint of [...painters, ...always]) paint();
  if (!playing) remember();
}

function go(index) {
  instant = (index + positions.length) % positions.length;
  show();
}

function togglePlay() {
  playing = !playing;
  byId("play").textContent = playing ? "❚❚" : "▶";
  if (!playing) return show();
  Object.assign(play, { shown: 0, count: 0 });
  requestAnimationFrame(play);
}

// at most 30 instants a second
function play(time) {
  if (!playing) return;
  if (time - play.shown > 32) {
    play.shown = time;
    play.count += 1;
    go(instant + 1);
  }
  requestAnimationFrame(play);
}

// The address of the page holds the cursor and what is chosen.
function remember() {
  if (!hasBegun) return;
  const named = new URLSearchParams({ at: +positions[instant].toFixed(3) }), film = data.films[chosen.film];
  if (data.films.length > 1) named.set("film", film.title);
  if (chosen.run >= 0) named.set("run", data.labels[chosen.run]);
  if (chosen.colour && chosen.colour !== Object.keys(film.layers)[0]) named.set("colour", chosen.colour);
  history.replaceState(null, "", "#" + named);
}

function recall() {
  const named = new URLSearchParams(location.hash.slice(1));
  if (named.has("at")) instant = nearest(positions, +named.get("at"));
  if (named.has("film")) chosen.film = Math.max(0, filmIndex(named.get("film")));
  if (named.has("run")) chosen.run = data.labels.indexOf(named.get("run"));
  if (named.has("colour")) chosen.colour = named.get("colour");
}

const filmIndex = title => data.films.findIndex(film => film.title === title);

// View of a film: maps, section and curves; without a film the first curves of the case
async function showFilm() {
  const film = data.films[chosen.film];
  painters = [];
  if (film) await Promise.all(Object.values(film.layers).flatMap(({ runs }) => runs.filter(Boolean).map(readFrames)));
  byId("maps").replaceChildren();
  byId("curves").replaceChildren();
  if (film) drawFilm(film);
  const ofCase = data.sections.flatMap(section => section.drawn).filter(drawn => drawn.cursor).slice(0, 4);
  for (const drawn of film?.curves || ofCase) chart(byId("curves"), drawn, painters);
  show();
}

function drawFilm(film) {
  const layers = Object.entries(film.layers);
  if (!film.layers[chosen.colour]) chosen.colour = layers[0][0];
  offer("colour", layers.map(([kind, layer]) => [kind, `colour: ${layer.variable || layer.name}`]), chosen.colour);
  film.layers[chosen.colour].runs.forEach((run, r) => {
    if (!run || !shows(r)) return;
    const map = new FieldMap(byId("maps"), film, r, chosen.colour);
    painters.push(() => map.paint());
  });
  drawSide(byId("maps"), film);
  drawLegend(film);
}

// a select that hides if there is nothing to choose
function offer(name, entries, value) {
  fillSelect(byId(name), entries, value);
  byId(name).hidden = entries.length < 2;
}

// Details, drawn when they are opened
async function showDetails() {
  const parent = byId("sections");
  if (parent.childElementCount) return;
  const sections = [...data.films.map(carpetsOf), ...data.sections].filter(section => section.drawn.length);
  for (const section of sections) {
    element("h2", parent, section.title);
    if (section.text) element("p", parent, section.text);
    await drawSectionCharts(element("div", parent, "", "charts"), section);
  }
}

async function drawSectionCharts(parent, section) {
  for (const drawn of section.drawn) {
    if (drawn.kind === "map") {
      await drawStillMaps(parent, drawn);
      continue;
    }
    if (drawn.kind === "carpet") drawn.values = await carpetValues(drawn);
    drawn.phases = section.phases;
    chart(parent, drawn, always, 220);
  }
}

async function drawStillMaps(parent, layer) {
  const kinds = { thickness: /thickness/i, contact: /contact/i, pressure: /.*/ };
  const kind = Object.keys(kinds).find(name => kinds[name].test(layer.name));
  for (const [r, run] of layer.runs.entries()) {
    if (!run) continue;
    await readFrames(run);
    const figure = element("div", parent);
    element("b", figure, withBrackets(layer.name, layer.unit));
    new FieldMap(figure, { layers: { [kind]: layer } }, r, kind, 0).paint();
    const color = { type: "linear", domain: [layer.low, layer.high], interpolate: colourScale(kind) };
    element("div", figure, "", "ramp").append(colourBar(color));
  }
}

// Start
function connectControls() {
  slider.max = positions.length - 1;
  slider.oninput = () => go(+slider.value);
  byId("play").onclick = togglePlay;
  offer("film", data.films.map((film, k) => [k, film.title.replaceAll("_", " ")]), chosen.film);
  offer("run", [[-1, "all runs"], ...data.labels.map((label, k) => [k, label])], chosen.run);
  byId("run").hidden = data.labels.length < 2;
  byId("colour").hidden = true;
  const choose = (key, value) => {
    chosen[key] = value;
    return showFilm();
  };
  byId("film").onchange = event => choose("film", +event.target.value);
  byId("colour").onchange = event => choose("colour", event.target.value);
  byId("run").onchange = event => choose("run", +event.target.value);
  for (const link of document.querySelectorAll("[data-film]")) link.onclick = event => {
    event.preventDefault();
    byId("film").value = filmIndex(link.dataset.film);
    choose("film", filmIndex(link.dataset.film));
  };
  byId("csv").onclick = () => save("curves.csv", tableOf(shownCurves()));
  byId("png").onclick = async () => save("view.png", await picture());
  byId("details").addEventListener("toggle", () => byId("details").open && showDetails());
  byId("bodies")?.addEventListener("toggle", () => byId("bodies").open && showSolids());
  addEventListener("keydown", moveByKey);
  addEventListener("hashchange", () => {
    if (!location.hash.includes("at=")) return;
    recall();
    showFilm();
  });
}

function moveByKey(event) {
  const move = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
  if (!move || event.target.closest("input, select, canvas, button")) return;
  event.preventDefault();
  go(instant + move);
}

async function begin() {
  for (const query of [darkScheme, onPaper]) query.addEventListener("change", usePalette);
  usePalette();
  data.labels.forEach((_, run) => {
    for (const node of document.querySelectorAll(`.run${run}`)) node.style.color = colourOf(run);
  });
  const [columns] = await Promise.all([inflate(data.columns), loadLibraries()]);
  numbers = new Float32Array(columns);
  positions = column(data.cursor.positions);
  instant = data.cursor.start;
  const worst = document.querySelector("[data-film]");
  if (worst) chosen.film = filmIndex(worst.dataset.film);
  recall();
  connectControls();
  if (data.measured) for (const drawn of data.measured.drawn) chart(byId("measured-charts"), drawn, always, 220);
  await showFilm();
  hasBegun = true;
  performance.mark("first picture");
  document.body.dataset.page = "ready";
}
