// The Explorer: one animal's model under the hand, and the numbers of all of them.
import { ask, post, say } from "./ask.js";
import { choice, fill, h, shown, symbol } from "./dom.js";
import { plot, sheet, style, watched } from "./plot.js";

const INDICES = { HR: "1/min", CO: "ml/s", mPAP: "mmHg", sPAP: "mmHg", dPAP: "mmHg", pPAP: "mmHg", PVR: "mmHg s/ml", RMSE: "mmHg" };
const DATA = "--ink", MODEL = "#00a7c4", BACK = "#d6259b";
let all = null, told = null, now = null, fit = null, band = {}, values = {}, parts = null, busy = false, wanted = false, view = null, frame = 0, colored = "mean pressure [mmHg]";
let beside = [], measure = "", law = "", log = false, hidden = new Set();

export async function show(place, rest) {
  all = await ask("results");
  const names = all.animals.map((one) => one.name), animal = names.includes(rest[0]) ? rest[0] : names[0];
  told = await ask("model", { animal, law: rest[1] || "" });
  values = {}; beside = []; now = fit = view = null; band = {}; frame = 0;
  const go = (name, wall) => { location.hash = `explorer/${encodeURIComponent(name)}/${encodeURIComponent(wall)}`; };
  const panel = (name, text) => { const canvas = h("canvas", { class: "panel", role: "img", "aria-label": text, data: { panel: name } }); return [canvas, h("figure", {}, canvas, h("figcaption", {}, text))]; };
  const list = { pressure: "pressure [mmHg] at the inlet by time [ms]", flow: "flow [ml/s] at the inlet by time [ms]", loop: "pressure [mmHg] by flow [ml/s]", waves: "forward and backward pressure wave [mmHg]", modulus: "impedance modulus [mmHg s/ml] by harmonic" };
  const made = Object.fromEntries(Object.entries(list).map(([name, text]) => [name, panel(name, text)]));
  const space = h("canvas", { class: "space", tabindex: 0, role: "img", "aria-label": "the tree; drag or arrow keys turn it" });
  const points = h("canvas", { class: "panel", role: "img", "aria-label": "all animals by group" });
  parts = { ...Object.fromEntries(Object.entries(made).map(([name, [canvas]]) => [name, canvas])), space, points,
    knobs: h("div"), numbers: h("div", { class: "numbers" }), notes: h("div"), scale: h("p", { class: "scale note" }), table: h("div"), groups: h("div") };
  fill(place,
    h("div", { class: "row" }, h("h1", {}, "Model of "), choice(names, animal, (name) => go(name, told.law), { "aria-label": "animal", data: { key: "animal" } }),
      choice(told.laws.map((one) => [one, `${one} wall`]), told.law, (wall) => go(animal, wall), { "aria-label": "wall law", data: { key: "law" } }),
      h("button", { type: "button", onclick: back }, "Back to the fit"),
      h("label", {}, "beside it", choice(["", ...names.filter((one) => one !== animal)], "", compare, { "aria-label": "another animal beside it" }))),
    h("p", { class: "note" }, told.formula, " ", key("--ink", "measured"), key(MODEL, "model, and backward wave dotted"), key(MODEL, "the fit, where the model was moved from it", "dotted"),
      key(BACK, "beside it", "dashed"), "shade: where 95 % of the models lie that the data allow about the fit"), parts.notes,
    h("div", { class: "two" },
      h("section", { class: "panels", "aria-label": "waveforms" }, Object.values(made).map(([, figure]) => figure),
        h("figure", {}, space, tree(), parts.scale)),
      h("section", { "aria-label": "parameters" }, parts.knobs, parts.numbers)),
    groupPart());
  knobs();
  for (const name of Object.keys(list)) watched(parts[name], draw);
  watched(points, drawGroups);
  watched(space, () => view?.redraw());
  await simulate();
  fit = now;
  begin();
  draw();
  const mine = told;
  ask("band", { animal, law: told.law }).then((found) => { if (mine === told) { band = found; draw(); } }, () => {});
}

function key(color, text, look = "solid") {
  const one = h("span", { class: "key" });
  one.style.borderTop = `3px ${look} ${color.startsWith("--") ? `var(${color})` : color}`;
  return h("span", { class: "legend" }, one, text, " ");
}

function back() {
  values = {};
  knobs();
  move();
}

async function compare(name) {
  beside = name ? [await post("simulate", { animal: name, law: (await ask("model", { animal: name, law: "" })).law, values: {} })] : [];
  draw();
}

// Sliders: one simulation at a time, always of what is wished last.

function knobs() {
  fill(parts.knobs, told.knobs.map((one) => {
    const where = (value) => (Math.log(value) - Math.log(one.low)) / (Math.log(one.high) - Math.log(one.low));
    const out = h("output", {}, `${shown(values[one.name] ?? one.value)} ${one.unit}`);
    const input = h("input", { type: "range", min: 0, max: 1000, step: 1, value: 1000 * where(values[one.name] ?? one.value), "aria-label": `${one.symbol} ${one.meaning}`,
      data: { key: one.name, knob: one.name }, oninput: () => {
        values[one.name] = one.low * (one.high / one.low) ** (input.value / 1000);
        out.textContent = `${shown(values[one.name])} ${one.unit}`;
        input.setAttribute("aria-valuetext", out.textContent);
        move();
      } });
    const shade = h("i"), mark = h("b");
    mark.style.left = `calc(8px + (100% - 16px) * ${where(one.value)})`;
    if (one.interval) {
      const [low, high] = one.interval.map((value) => Math.min(1, Math.max(0, where(value))));
      shade.style.left = `calc(8px + (100% - 16px) * ${low})`;
      shade.style.width = `calc((100% - 16px) * ${Math.max(0.004, high - low)})`;
    }
    return h("div", { class: "knob", title: one.meaning }, h("label", {}, h("span", {}, symbol(one.symbol), " ", h("small", {}, one.meaning)), out),
      h("div", { class: "track" }, one.interval ? shade : null, mark, input));
  }), h("p", { class: "keys" }, "The line is the fit, the shade its 95 % interval."));
}

function move() {
  wanted = true;
  if (!busy) drain();
}

async function drain() {
  busy = true;
  while (wanted) { wanted = false; await simulate(); draw(); }
  busy = false;
}

async function simulate() {
  try {
    now = await post("simulate", { animal: told.animal, law: told.law, values });
    fill(parts.notes, now.notes.map((one) => h("div", { class: "finding" }, one)));
    say("");
  } catch (error) {
    say(error.message, true);
  }
}

function draw() {
  if (!now || !parts.pressure.isConnected) return;
  const ink = style(DATA), period = told.measured.period, moved = fit && fit !== now;
  const close = (list) => [...list, list[0]], times = (list) => close(list).map((_, k) => k / list.length * period * 1000);
  const over = (list, more) => ({ x: times(list), y: close(list), ...more });
  const harmonics = (list, more) => ({ x: list.map((_, k) => k), y: list, ...more });
  const loop = (one, more) => ({ x: close(one.flow), y: close(one.pressure), ...more });
  const shade = (name, how, color = MODEL) => (band[name] ? [{ ...how(band[name][0], { color, width: 0 }), band: { low: how(band[name][0]).y, high: how(band[name][1]).y } }] : []);
  const draws = (name, how, measured, model = { color: MODEL, width: 2 }) => [
    ...shade(name, how), ...(measured ? [how(measured, { color: ink, width: 1.4, points: name === "modulus" })] : []), how(now[name], model),
    ...(moved ? [how(fit[name], { color: MODEL, width: 1, dash: [2, 3] })] : []), ...beside.map((one) => how(one[name], { color: BACK, width: 1.4, dash: [7, 3] }))];
  for (const name of ["pressure", "flow"]) plot(parts[name], { series: draws(name, over, told.measured[name]), x: "" });
  plot(parts.loop, { series: [loop(told.measured, { color: ink, width: 1.4 }), loop(now, { color: MODEL, width: 2 }),
    ...(moved ? [loop(fit, { color: MODEL, width: 1, dash: [2, 3] })] : []), ...beside.map((one) => loop(one, { color: BACK, dash: [7, 3] }))], x: "" });
  plot(parts.waves, { series: [...draws("forward", over, null), ...draws("backward", over, null, { color: MODEL, width: 1.8, dash: [2, 2] })], x: "" });
  plot(parts.modulus, { series: draws("modulus", harmonics, told.measured.modulus), x: "", log: true });
  fill(parts.numbers, Object.entries(now.indices).map(([name, value]) => h("div", {}, h("span", {}, symbol(name), " ", h("small", {}, INDICES[name] || "")), h("b", { data: { index: name } }, shown(value)))));
  view?.redraw();
  parts.pressure.dataset.drawn = String(Number(parts.pressure.dataset.drawn || 0) + 1);
}

// The tree in space.

const FRAMES = ["pressure [mmHg]", "flow [ml/s]"];

function tree() {
  const names = ["mean pressure [mmHg]", "pulse pressure [mmHg]", "mean flow [ml/s]", "wave speed [cm/s]", ...FRAMES.map((one) => `${one} now`)];
  const slider = h("input", { type: "range", min: 0, max: 31, value: 0, "aria-label": "time in the cycle", oninput: () => { frame = Number(slider.value); view?.redraw(); } });
  return h("div", { class: "row" }, h("label", {}, "color", choice(names, colored, (name) => { colored = name; view?.redraw(); }, { "aria-label": "color of the tree" })), h("label", {}, "time", slider));
}

function begin() {
  const canvas = parts.space, { axes, radius } = told.tree;
  // eslint-disable-next-line no-undef
  view = turntable(canvas, axes.flat(), (one) => {
    const moving = FRAMES.find((name) => colored === `${name} now`);
    const list = moving ? now.frames[moving][Math.min(frame, now.frames[moving].length - 1)] : now.vessels[colored];
    const every = moving ? now.frames[moving].flat() : list;
    const [low, high] = [Math.min(...every), Math.max(...every)], ink = style(DATA);
    const mix = (share) => { const at = Math.min(0.9999, Math.max(0, share)) * (told.stops.length - 1), k = Math.floor(at); return `rgb(${[0, 1, 2].map((i) => Math.round(told.stops[k][i] + (at - k) * (told.stops[k + 1][i] - told.stops[k][i])))})`; };
    const pieces = axes.map(([from, to], row) => [one.seen(from), one.seen(to), row]).sort((a, b) => b[0][2] + b[1][2] - a[0][2] - a[1][2]);
    for (const [from, to, row] of pieces) {
      const width = Math.max(2, 2 * radius[row] * one.unit());
      one.line(from, to, width + 1.5, ink);
      one.line(from, to, width, mix((list[row] - low) / (high - low || 1)));
    }
    one.scaleBar(ink);
    const bar = h("i");
    bar.style.background = `linear-gradient(to right, ${told.stops.map((stop) => `rgb(${stop})`).join(", ")})`;
    fill(parts.scale, `${shown(low, 3)} `, bar, ` ${shown(high, 3)}; directions are drawn, not measured`);
  }, () => {});
  view.rotate(0.5, 0.3);
  view.redraw();
}

// All animals.

function groupPart() {
  const names = Object.keys(all.quantities), laws = [...new Set(all.animals.flatMap((one) => Object.keys(one.laws)))];
  measure = names.includes(measure) ? measure : names.includes("R_T") ? "R_T" : names[0];
  law = laws.includes(law) ? law : told.law;
  return h("section", { class: "points" }, h("h2", {}, "All animals"),
    h("div", { class: "row" },
      choice(names.map((name) => [name, `${all.quantities[name][0]}: ${all.quantities[name][2]}`]), measure, (name) => { measure = name; drawGroups(); }, { "aria-label": "quantity" }),
      choice(laws.map((one) => [one, one === "measured" ? "measured" : `${one} wall`]), law, (name) => { law = name; drawGroups(); }, { "aria-label": "source" }),
      Object.entries(all.groups).map(([group, color]) => {
        const key = h("span", { class: "key" });
        key.style.borderColor = color;
        return h("label", {}, h("input", { type: "checkbox", checked: !hidden.has(group), onchange: (event) => { event.target.checked ? hidden.delete(group) : hidden.add(group); drawGroups(); } }), key, group);
      }),
      h("label", {}, h("input", { type: "checkbox", checked: log, onchange: (event) => { log = event.target.checked; drawGroups(); } }), "logarithmic")),
    parts.points, h("details", {}, h("summary", {}, "As a table"), parts.table),
    all.failures.map((one) => h("div", { class: "finding bad" }, one)));
}

function drawGroups() {
  const shownAnimals = all.animals.filter((one) => !hidden.has(one.group) && one.laws[law]?.[measure]?.[0] !== undefined && one.laws[law][measure][0] !== null);
  const [symbol, unit] = all.quantities[measure];
  fill(parts.table, h("div", { class: "table" }, h("table", {}, h("thead", {}, h("tr", {}, ["animal", "group", `${symbol} [${unit}]`, "95 %"].map((one) => h("th", {}, one)))),
    h("tbody", {}, shownAnimals.map((one) => { const [value, low, high] = one.laws[law][measure]; return h("tr", {}, h("td", {}, one.name), h("td", {}, one.group), h("td", {}, shown(value)), h("td", {}, low === null ? "" : `${shown(low, 3)} to ${shown(high, 3)}`)); })))));
  if (!shownAnimals.length) { sheet(parts.points); return; }
  const at = new Map(shownAnimals.map((one, k) => [one.name, k + 1]));
  const points = shownAnimals.map((one) => ({ x: [at.get(one.name)], y: [one.laws[law][measure][0]], color: all.groups[one.group], points: true }));
  const spans = shownAnimals.filter((one) => one.laws[law][measure][1] !== null).map((one) => ({ x: [at.get(one.name), at.get(one.name)], y: one.laws[law][measure].slice(1), color: all.groups[one.group], width: 1.5 }));
  const values = shownAnimals.map((one) => one.laws[law][measure][0]);
  const range = log ? undefined : spread(values, spans.flatMap((one) => one.y));
  const scale = plot(parts.points, { series: [...spans, ...points], y: `${symbol} [${unit}]`, across: [0.3, shownAnimals.length + 0.7], log: log && Math.min(...values) > 0, range });
  if (!scale) return;
  const pen = parts.points.getContext("2d"), height = parts.points.clientHeight, room = (scale.right - scale.left) / (shownAnimals.length + 1);
  pen.fillStyle = style(DATA); pen.textAlign = room < 70 ? "right" : "center"; pen.textBaseline = "top";
  for (const one of shownAnimals) {
    pen.save();
    pen.translate(scale.px(at.get(one.name)), height - 28);
    if (room < 70) pen.rotate(-0.5);
    pen.fillText(one.name.length > 14 ? `${one.name.slice(0, 13)}…` : one.name, 0, 0);
    pen.restore();
  }
}

/** A range that shows all values, and of endless intervals as much as helps. */
function spread(values, ends) {
  const [low, high] = [Math.min(...values), Math.max(...values)], room = (high - low) || Math.abs(high) || 1;
  const far = ends.filter((one) => one > low - 2 * room && one < high + 2 * room);
  const [from, to] = [Math.min(low, ...far), Math.max(high, ...far)];
  return [from - 0.06 * (to - from || room), to + 0.06 * (to - from || room)];
}
