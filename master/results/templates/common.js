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

// three significant digits
function digits(value) {
  if (value === 0) return "0";
  const size = Math.abs(value);
  return size >= 1e5 || size < 1e-3 ? value.toExponential(2) : String(+value.toPrecision(3));
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
const colourBar = color => Plot.legend({ color, width: 260, height: 50, ticks: 4, tickFormat: digits });

// colours of curves: those of the dark palette on a dark screen, never on paper
function usePalette() {
  const palette = darkScheme.matches && !onPaper.matches ? data.palette_dark : data.palette;
  palette.forEach((colour, k) => document.documentElement.style.setProperty(`--run${k}`, colour));
}
