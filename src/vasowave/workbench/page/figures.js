// The Figure desk: panels at a size, as a file, with the line of Python that draws the same.
import { ask, file, post, say } from "./ask.js";
import { choice, fill, h } from "./dom.js";

const PANELS = { pressure: "pressure", flow: "flow", residuals: "residuals", autocorrelation: "their autocorrelation", pressure_area: "pressure and area", impedance: "impedance" };
const FONTS = ["sans-serif", "serif", "monospace"];
const wish = { animal: "", group: "", panels: ["pressure", "impedance"], width: 170, height: 60, font: 8, family: "sans-serif", color: "", format: "svg" };
let parts = null, before = "", drawing = 0;

export async function show(place, rest) {
  const { animals, groups, reference } = await ask("results");
  if (!place.isConnected) return;  // another desk is wanted by now
  const names = animals.map((one) => one.name);
  const others = Object.keys(groups).filter((one) => one !== reference && animals.some((each) => each.group === one));
  const against = (group) => `${group} against ${reference}`;  // a name that no animal has is of two groups
  wish.animal = names.includes(rest[0]) ? rest[0] : names.includes(wish.animal) || others.includes(wish.group) ? wish.animal : names[0];
  if (wish.animal) wish.group = "";
  const own = () => groups[animals.find((one) => one.name === wish.animal)?.group ?? wish.group];  // as in the report
  const take = (name) => {
    wish.group = names.includes(name) ? "" : others.find((one) => against(one) === name);
    wish.animal = wish.group ? "" : name;
    wish.color = color.value = own();
    parts.choices.hidden = Boolean(wish.group);
    clear(); draw(); outdated();
  };
  wish.color = own();
  parts = { picture: h("img", { class: "preview", alt: "the figure" }), line: h("code", { class: "line" }), old: h("div") };
  const number = (name, text, low, high) => {
    const input = h("input", { type: "number", value: wish[name], min: low, max: high, step: "any", size: 5, data: { key: name }, onchange: () => { wish[name] = Number(input.value); draw(); } });
    return h("label", {}, text, input);
  };
  const color = h("input", { type: "color", value: wish.color, data: { key: "color" }, onchange: () => { wish.color = color.value; draw(); } });
  fill(place, h("div", { class: "row" }, h("h1", {}, "Figure of "), choice([...names, ...others.map(against)], wish.animal || against(wish.group), take, { "aria-label": "animal, or groups", data: { key: "animal" } })),
    parts.old,
    parts.choices = h("div", { hidden: Boolean(wish.group) }, h("div", { class: "row" }, Object.entries(PANELS).map(([name, text]) => h("label", {}, h("input", { type: "checkbox", checked: wish.panels.includes(name), data: { key: `panel ${name}` }, onchange: (event) => {
      wish.panels = Object.keys(PANELS).filter((one) => (one === name ? event.target.checked : wish.panels.includes(one)));
      draw();
    } }), text))),
    h("div", { class: "row" }, number("width", "width [mm]", 20, 400), number("height", "height [mm]", 20, 400), number("font", "letters [pt]", 4, 24),
      h("label", {}, "font", choice(FONTS, wish.family, (name) => { wish.family = name; draw(); }, { data: { key: "family" } })), h("label", {}, "color of the model", color))),
    h("div", { class: "row" }, ["svg", "pdf", "png"].map((kind) => h("button", { type: "button", data: { key: `save ${kind}` }, onclick: () => save(kind) }, `Save as ${kind.toUpperCase()}`))),
    parts.picture, parts.hollow = h("p", { class: "note" }, "Grey and hollow: harmonics whose flow is at noise level."), h("p", {}, "The same again in Python:"), parts.line);
  outdated();
  await draw();
}

/** Draw anew what may have been computed anew. */
export async function renew() {
  if (!parts?.picture.isConnected) return;
  await Promise.all([draw(), outdated()]);
}

async function outdated() {
  const mine = parts, old = await ask("outdated");
  if (mine === parts) fill(parts.old, (wish.animal ? old.includes(wish.animal) : old.length) ? h("span", { class: "old" }, "outdated: its row, its files or the settings changed since this was computed") : null);
}

async function draw() {
  if (!wish.panels.length) { say("Choose at least one panel.", true); return; }
  const mine = ++drawing;
  if (wish.group) say("Comparing the groups …");  // seconds, the first time
  try {
    const [content, { line }] = await Promise.all([file("figure", { ...wish, format: "svg" }), post("figure", { ...wish, only: "line" })]);
    if (mine !== drawing) return;
    if (before) URL.revokeObjectURL(before);
    before = URL.createObjectURL(content);
    parts.picture.src = before;
    parts.picture.hidden = false;
    parts.hollow.hidden = !wish.animal || !wish.panels.includes("impedance");
    parts.picture.style.width = wish.animal ? `${wish.width}mm` : "174mm";
    parts.line.textContent = line;
    parts.picture.dataset.drawn = String(Number(parts.picture.dataset.drawn || 0) + 1);
    say("");
  } catch (error) {
    if (mine !== drawing) return;
    clear();
    say(error.message, true);
  }
}

/** Take away what shows something else than what is chosen. */
function clear() {
  parts.picture.hidden = true;
  parts.line.textContent = "";
}

async function save(format) {
  try {
    const link = h("a", { href: URL.createObjectURL(await file("figure", { ...wish, format })), download: `${wish.animal || wish.group}.${format}` });
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  } catch (error) {
    say(error.message, true);
  }
}
