// The Figure desk: panels at a size, as a file, with the line of Python that draws the same.
import { ask, file, post, say } from "./ask.js";
import { choice, fill, h } from "./dom.js";

const PANELS = { pressure: "pressure", residuals: "residuals", autocorrelation: "their autocorrelation", pressure_area: "pressure and area", impedance: "impedance" };
const wish = { animal: "", panels: ["pressure", "impedance"], width: 170, height: 60, font: 8, format: "svg" };
let parts = null, before = "";

export async function show(place, rest) {
  const { animals } = await ask("results"), names = animals.map((one) => one.name);
  wish.animal = names.includes(rest[0]) ? rest[0] : names.includes(wish.animal) ? wish.animal : names[0];
  parts = { picture: h("img", { class: "preview", alt: "the figure" }), line: h("code", { class: "line" }) };
  const number = (name, text, low, high) => {
    const input = h("input", { type: "number", value: wish[name], min: low, max: high, step: "any", size: 5, data: { key: name }, onchange: () => { wish[name] = Number(input.value); draw(); } });
    return h("label", {}, text, input);
  };
  fill(place, h("div", { class: "row" }, h("h1", {}, "Figure of "), choice(names, wish.animal, (name) => { wish.animal = name; draw(); }, { "aria-label": "animal" })),
    h("div", { class: "row" }, Object.entries(PANELS).map(([name, text]) => h("label", {}, h("input", { type: "checkbox", checked: wish.panels.includes(name), onchange: (event) => {
      wish.panels = Object.keys(PANELS).filter((one) => (one === name ? event.target.checked : wish.panels.includes(one)));
      draw();
    } }), text))),
    h("div", { class: "row" }, number("width", "width [mm]", 20, 400), number("height", "height [mm]", 20, 400), number("font", "letters [pt]", 4, 24),
      ["svg", "pdf", "png"].map((kind) => h("button", { type: "button", onclick: () => save(kind) }, `Save as ${kind.toUpperCase()}`))),
    parts.picture, h("p", {}, "The same again in Python:"), parts.line);
  await draw();
}

async function draw() {
  if (!wish.panels.length) { say("Choose at least one panel.", true); return; }
  try {
    const content = await file("figure", { ...wish, format: "svg" });
    if (before) URL.revokeObjectURL(before);
    before = URL.createObjectURL(content);
    parts.picture.src = before;
    parts.picture.style.width = `${wish.width}mm`;
    parts.line.textContent = (await post("figure", { ...wish, only: "line" })).line;
    say("");
  } catch (error) {
    say(error.message, true);
  }
}

async function save(format) {
  try {
    const link = h("a", { href: URL.createObjectURL(await file("figure", { ...wish, format })), download: `${wish.animal}.${format}` });
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  } catch (error) {
    say(error.message, true);
  }
}
