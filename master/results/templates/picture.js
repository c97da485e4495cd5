// The view as one picture: canvases, drawings and captions where they are on the page.

const DENSITY = 2;   // pixels of the picture for one of the page
const BORDER = 12;   // around the view [px]
const PAGE_COLOURS = ["--ink", "--dim", "--line", "--paper", "--shade"];
const CAPTIONS = "figcaption, figcaption .values span, #place, #legend span";

async function picture() {
  const view = byId("view"), from = view.getBoundingClientRect();
  const canvas = document.createElement("canvas"), pen = canvas.getContext("2d");
  const size = [from.width + 2 * BORDER, from.height + 2 * BORDER];
  Object.assign(canvas, { width: DENSITY * size[0], height: DENSITY * size[1] });
  pen.scale(DENSITY, DENSITY);
  pen.fillStyle = colourOnPage("--paper");
  pen.fillRect(0, 0, ...size);
  pen.translate(BORDER, BORDER);
  const box = node => {
    const own = node.getBoundingClientRect();
    return [own.left - from.left, own.top - from.top, own.width, own.height];
  };
  const rules = rulesForDrawings();
  for (const node of view.querySelectorAll("canvas, svg")) {
    const image = node instanceof HTMLCanvasElement ? node : await imageOf(node, box(node), rules);
    pen.drawImage(image, ...box(node));
  }
  pen.textBaseline = "top";
  for (const node of view.querySelectorAll(CAPTIONS)) {
    const { fontWeight, fontSize, fontFamily, color } = getComputedStyle(node), [x, y, width] = box(node);
    Object.assign(pen, { font: `${fontWeight} ${fontSize} ${fontFamily}`, fillStyle: color });
    const text = ownText(node), sample = node.querySelector(".sample");
    pen.fillText(text, sample ? x + width - pen.measureText(text).width : x, y);
    if (sample) drawSample(pen, getComputedStyle(sample), box(sample));
  }
  return new Promise(done => canvas.toBlob(done));
}

// line of the legend
function drawSample(pen, { borderTopColor, borderTopStyle }, [x, y, width]) {
  pen.strokeStyle = borderTopColor;
  pen.setLineDash(borderTopStyle === "dashed" ? [4, 3] : []);
  pen.beginPath();
  pen.moveTo(x, y);
  pen.lineTo(x + width, y);
  pen.stroke();
}

const colourOnPage = name => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

// text of a caption without its values and button, which have places of their own
function ownText(node) {
  if (!node.matches("figcaption")) return node.textContent;
  const parts = [...node.childNodes].filter(part => !part.matches?.(".values, button"));
  return parts.map(part => part.textContent).join("");
}

// rules of the page and values of its colours, for drawings outside of it
function rulesForDrawings() {
  const rules = [...document.styleSheets].flatMap(sheet => [...sheet.cssRules]).map(rule => rule.cssText);
  const names = [...data.palette.map((_, k) => `--run${k}`), ...PAGE_COLOURS];
  const colours = names.map(name => `${name}:${colourOnPage(name)}`).join(";");
  const plain = rules.filter(text => !text.startsWith("@"));
  return [...plain, `svg{${colours};color:${colourOnPage("--ink")}}`].join("\n");
}

async function imageOf(svg, [, , width, height], rules) {
  const copy = svg.cloneNode(true), style = document.createElementNS(copy.namespaceURI, "style");
  style.textContent = rules;
  copy.setAttribute("width", width);
  copy.setAttribute("height", height);
  copy.prepend(style);
  const image = new Image();
  image.src = "data:image/svg+xml;charset=utf-8," + encodeURIComponent(new XMLSerializer().serializeToString(copy));
  await image.decode();
  return image;
}
