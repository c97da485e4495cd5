// Shared by the report and the page of a sweep.
const data = JSON.parse(document.getElementById("data").textContent);
const byId = name => document.getElementById(name);
const darkScheme = matchMedia("(prefers-color-scheme: dark)");
const onPaper = matchMedia("print");

function element(kind, parent, text = "", className = "") {
  const made = document.createElement(kind);
  made.textContent = text;
  made.className = className;
  return parent.appendChild(made);
}

function fillSelect(select, entries, value) {
  select.replaceChildren();
  for (const [key, text] of entries) element("option", select, text).value = key;
  select.value = value;
}

// `places` significant digits
function rounded(value, places) {
  if (value === 0) return "0";
  const size = Math.abs(value);
  return size >= 1e5 || size < 1e-3 ? value.toExponential(places - 1) : String(+value.toPrecision(places));
}

const digits = value => rounded(value, 3);

// digits in which values that are a tenth of their range apart differ
function digitsWithin(values) {
  const [low, high] = d3.extent(values), size = Math.max(Math.abs(low), Math.abs(high));
  const places = high > low ? 2 + Math.ceil(Math.log10(size / (high - low))) : 3;
  return value => rounded(Math.abs(value) < 1e-9 * size ? 0 : value, Math.min(15, Math.max(3, places)));
}

// inverse of `packed` of results/packing.py
async function inflate(text) {
  const bytes = Uint8Array.from(atob(text), letter => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Response(stream).arrayBuffer();
}

// D3 and Observable Plot, which the page contains
async function loadLibraries() {
  const code = await inflate(byId("libraries").textContent);
  element("script", document.head, new TextDecoder().decode(code));
}

// legend of a colour scale of Observable Plot
const colourBar = color => Plot.legend({
  color, width: 292, height: 50, marginLeft: 16, marginRight: 16, ticks: 4, tickFormat: digitsWithin(color.domain),
});

// colours of curves: those of the dark palette on a dark screen, never on paper
function usePalette() {
  const palette = darkScheme.matches && !onPaper.matches ? data.palette_dark : data.palette;
  palette.forEach((colour, k) => document.documentElement.style.setProperty(`--run${k}`, colour));
}
