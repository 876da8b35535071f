// The Explorer: one animal's model under the hand, another beside it, and what the data allow.
import { ask, post, say } from "./ask.js";
import { choice, fill, h, shown, symbol } from "./dom.js";
import { groupPart } from "./groups.js";
import { knobsIn } from "./knobs.js";
import { plot, style, watched } from "./plot.js";
import { COLORS, MOMENTS, range, scaleOf, treeIn } from "./space.js";
import { walkPart } from "./walk.js";

const INDICES = { HR: "1/min", CO: "ml/s", mPAP: "mmHg", sPAP: "mmHg", dPAP: "mmHg", pPAP: "mmHg", PVR: "mmHg s/ml", RMSE: "mmHg" };
const PANELS = { pressure: "pressure [mmHg] at the inlet by time [ms]", flow: "flow [ml/s] at the inlet by time [ms]", loop: "pressure [mmHg] by flow [ml/s]", waves: "forward and backward pressure wave [mmHg]", modulus: "impedance modulus [mmHg s/ml] by harmonic" };
const DATA = "--ink", MODEL = "#00a7c4", BESIDE = "#d6259b", DRAWN = "#e69f00";
const how = { colored: COLORS[0], moment: 0 };
let told = null, now = null, fit = null, band = {}, drawn = null, beside = null, values = {}, parts = null, trees = [], busy = false, wanted = false;

export async function show(place, rest) {
  const all = await ask("results");
  if (!place.isConnected) return;  // another desk or animal is wanted by now
  const names = all.animals.map((one) => one.name), animal = names.includes(rest[0]) ? rest[0] : names[0];
  const model = await ask("model", { animal, law: rest[1] || "" });
  if (!place.isConnected) return;
  told = model;
  values = {}; now = fit = beside = drawn = null; band = {}; trees = [];
  const go = (name, wall = told.law) => { location.hash = `explorer/${encodeURIComponent(name)}/${encodeURIComponent(wall)}`; };
  const panels = Object.entries(PANELS).map(([name, text]) => [name, h("canvas", { class: "panel", role: "img", "aria-label": text, data: { panel: name } }), text]);
  const space = (name) => h("canvas", { class: "space", tabindex: 0, role: "img", "aria-label": `the tree of ${name}; drag or arrow keys turn it`, data: { tree: name } });
  parts = { ...Object.fromEntries(panels.map(([name, canvas]) => [name, canvas])), space: space(animal), other: h("div"),
    knobs: h("div"), numbers: h("div"), notes: h("div"), old: h("div"), scale: h("p", { class: "scale note" }), walk: h("div") };
  fill(place,
    h("div", { class: "row" }, h("h1", {}, "Model of "), choice(names, animal, (name) => go(name), { "aria-label": "animal", data: { key: "animal" } }),
      choice(told.laws.map((one) => [one, `${one} wall`]), told.law, (wall) => go(animal, wall), { "aria-label": "wall law", data: { key: "law" } }),
      h("button", { type: "button", data: { key: "back" }, onclick: back }, "Back to the fit"),
      h("label", {}, "beside it", choice(["", ...names.filter((one) => one !== animal)], "", compare, { "aria-label": "another animal beside it", data: { key: "beside" } }))),
    parts.old,
    h("p", { class: "note" }, told.formula, " ", key("--ink", "measured"), key(MODEL, "model, and backward wave dotted"), key(MODEL, "the fit, where the model was moved from it", "dotted"),
      key(BESIDE, "the fit of the other animal", "dashed"), key(DRAWN, "one of the models below"), "shade: where 95 % of the models lie that the data allow about the fit"), parts.notes,
    h("div", { class: "two" },
      h("section", { class: "panels", "aria-label": "waveforms" }, panels.map(([, canvas, text]) => h("figure", {}, canvas, h("figcaption", {}, text))),
        h("figure", {}, parts.space, coloring(), parts.scale), parts.other),
      h("section", { "aria-label": "parameters" }, parts.knobs, parts.numbers, parts.walk)),
    groupPart(all, told.law, go));
  knobs();
  for (const [name] of panels) watched(parts[name], draw);
  watched(parts.space, redrawTrees);
  await simulate();
  if (!place.isConnected) return;
  fit = now;
  trees = [treeIn(parts.space, told, () => ({ run: now, shown: how, scale: scale() }))];
  draw();
  outdated();
  const mine = told;
  ask("band", { animal, law: told.law }).then((found) => {
    if (mine !== told) return;
    band = found.band;
    walkPart(parts.walk, found.draws, told.knobs, (one) => { drawn = one; draw(); });
    draw();
  }, (error) => say(error.message, true));
}

/** A result that was made anew is shown anew; one that its files have left behind says so. */
export async function renew(place) {
  if (!told) return;
  const mine = told;
  const fresh = await ask("model", { animal: told.animal, law: told.law });
  if (mine !== told || !place.isConnected) return;
  if (fresh.made !== told.made) await show(place, [told.animal, told.law]);
  else await outdated();
}

async function outdated() {
  const mine = parts, old = await ask("outdated");
  if (mine === parts) fill(parts.old, old.includes(told.animal) ? h("span", { class: "old" }, "outdated: its row, its files or the settings changed since this was computed") : null);
}

function key(color, text, look = "solid") {
  const one = h("span", { class: "key" });
  one.style.borderTop = `3px ${look} ${color.startsWith("--") ? `var(${color})` : color}`;
  return h("span", { class: "legend" }, one, text, " ");
}

// Sliders: one simulation at a time, always of what is wished last.

function knobs() {
  knobsIn(parts.knobs, told.knobs, values, beside?.told.knobs || [], move);
}

function back() {
  values = {};
  knobs();
  move();
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
  const mine = told;
  try {
    const found = await post("simulate", { animal: told.animal, law: told.law, values });
    if (mine !== told) return;
    now = found;
    fill(parts.notes, now.notes.map((one) => h("div", { class: "finding" }, one)));
    say("");
  } catch (error) {
    say(error.message, true);
  }
}

/** Put another animal's fit beside this one: curves, numbers, sliders and its tree. */
async function compare(name) {
  const mine = told;
  let other = null;
  if (name) {
    try {
      const about = await ask("model", { animal: name, law: "" }), law = about.laws.includes(told.law) ? told.law : about.law;
      const [model, run] = await Promise.all([law === about.law ? about : ask("model", { animal: name, law }), post("simulate", { animal: name, law, values: {} })]);
      other = { told: model, run };
    } catch (error) {
      say(error.message, true);
    }
  }
  if (mine !== told) return;
  beside = other;
  trees = trees.slice(0, 1);
  const canvas = other && h("canvas", { class: "space", tabindex: 0, role: "img", "aria-label": `the tree of ${name}; drag or arrow keys turn it`, data: { tree: name } });
  fill(parts.other, other ? h("figure", {}, canvas, h("figcaption", {}, `${name}, ${other.told.law} wall, in the same colors`)) : null);
  if (other) { trees.push(treeIn(canvas, other.told, () => ({ run: other.run, shown: how, scale: scale() }))); watched(canvas, redrawTrees); }
  knobs();
  draw();
}

// The trees and their scale.

const scale = () => range([now, ...(beside ? [beside.run] : [])], how);

function redrawTrees() {
  if (!now) return;
  trees.forEach((one) => one.redraw());
  scaleOf(parts.scale, told.stops, scale(), how);
}

function coloring() {
  let playing = 0;
  const slider = h("input", { type: "range", min: 0, max: MOMENTS - 1, value: how.moment, "aria-label": "time in the cycle", data: { key: "moment" }, oninput: () => at(Number(slider.value)) });
  const out = h("output", {}, ""), colors = choice(COLORS, how.colored, (name) => { how.colored = name; redrawTrees(); }, { "aria-label": "color of the tree", data: { key: "colored" } });
  const at = (moment) => {
    how.moment = moment;
    out.textContent = `${Math.round(moment / MOMENTS * told.measured.period * 1000)} ms`;
    if (!how.colored.endsWith(" now")) { how.colored = "pressure [mmHg] now"; colors.value = how.colored; }
    redrawTrees();
  };
  const button = h("button", { type: "button", data: { key: "play" }, onclick: () => {
    if (playing) { clearInterval(playing); playing = 0; button.textContent = "Play"; return; }
    button.textContent = "Stop";
    playing = setInterval(() => {
      if (!slider.isConnected) { clearInterval(playing); return; }
      slider.value = String((Number(slider.value) + 1) % MOMENTS);
      at(Number(slider.value));
    }, 80);
  } }, "Play");
  return h("div", { class: "row" }, h("label", {}, "color", colors), h("label", {}, "time", slider, out), button);
}

// The curves.

function draw() {
  if (!now || !parts.pressure.isConnected) return;
  const moved = fit && fit !== now, ink = style(DATA), other = beside?.run;
  const closed = (list) => [...list, list[0]];
  const over = (list, more, period = told.measured.period) => ({ x: closed(list).map((_, k) => k / list.length * period * 1000), y: closed(list), ...more });
  const harmonics = (list, more) => ({ x: list.map((_, k) => k), y: list, ...more });
  const loop = (one, more) => ({ x: closed(one.flow), y: closed(one.pressure), ...more });
  const shade = (name, as) => (band[name] ? [{ ...as(band[name][0], { color: MODEL, width: 0 }), band: { low: as(band[name][0]).y, high: as(band[name][1]).y } }] : []);
  const curves = (name, as, measured, model = { color: MODEL, width: 2 }) => [
    ...shade(name, as), ...(measured ? [as(measured, { color: ink, width: 1.4, points: name === "modulus" })] : []), as(now[name], model),
    ...(moved ? [as(fit[name], { color: MODEL, width: 1, dash: [2, 3] })] : []),
    ...(other ? [as(other[name], { color: BESIDE, width: 1.4, dash: [7, 3] }, other.period)] : []),
    ...(drawn?.[name] ? [as(drawn[name], { color: DRAWN, width: 1.6 })] : [])];
  for (const name of ["pressure", "flow"]) plot(parts[name], { series: curves(name, over, told.measured[name]), x: "" });
  plot(parts.loop, { series: [loop(told.measured, { color: ink, width: 1.4 }), loop(now, { color: MODEL, width: 2 }),
    ...(moved ? [loop(fit, { color: MODEL, width: 1, dash: [2, 3] })] : []), ...(other ? [loop(other, { color: BESIDE, dash: [7, 3] })] : [])], x: "" });
  plot(parts.waves, { series: [...curves("forward", over, null), ...curves("backward", over, null, { color: MODEL, width: 1.8, dash: [2, 2] })], x: "" });
  plot(parts.modulus, { series: curves("modulus", harmonics, told.measured.modulus), x: "", log: true });
  trees.forEach((one) => one.redraw());
  numbers(other);  // what is read of the page's layout is read before anything is written into it
  scaleOf(parts.scale, told.stops, scale(), how);
  parts.pressure.dataset.drawn = String(Number(parts.pressure.dataset.drawn || 0) + 1);
}

function numbers(other) {
  fill(parts.numbers, other ? h("p", { class: "keys" }, `${told.animal}, and ${beside.told.animal} beside it`) : null,
    h("div", { class: "numbers" }, Object.entries(now.indices).map(([name, value]) => h("div", {}, h("span", {}, symbol(name), " ", h("small", {}, INDICES[name] || "")),
      h("b", { data: { index: name } }, shown(value)), other ? h("b", { class: "other", data: { other: name } }, shown(other.indices[name])) : null))));
}
