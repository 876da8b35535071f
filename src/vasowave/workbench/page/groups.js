// All animals of a study: one number of each, by group and by where it comes from, with the mean of every group.
import { ask, say } from "./ask.js";
import { choice, fill, h, shown } from "./dom.js";
import { plot, sheet, style, watched } from "./plot.js";

let all = null, means = {}, parts = null, scale = null, spots = [];
let measure = "", log = false, hidden = new Set(), off = null;

const sources = () => Object.keys(all.sources).filter((one) => !off.has(one));
const words = (source) => (source === "measured" ? "measured" : `${source} wall`);

/** The part of the desk; `law` is the source that is shown at first, `go` leads to the model of an animal. */
export function groupPart(results, law, go) {
  all = results;
  const names = Object.keys(all.quantities);
  measure = names.includes(measure) ? measure : names.includes("R_T") ? "R_T" : names[0];
  off ??= new Set(Object.keys(all.sources).filter((one) => one !== law));
  const canvas = h("canvas", { class: "panel", role: "img", "aria-label": "all animals by group, and the mean of each group; a click opens an animal" });
  parts = { canvas, table: h("div"), named: h("p", { class: "note" }, "Point at an animal to read its name; a click opens its model."), go };
  const box = (text, on, say, mark = null) => h("label", {}, h("input", { type: "checkbox", checked: on, onchange: (event) => { say(event.target.checked); draw(); }, data: { key: `show ${text}` } }), mark, text);
  const toggle = (set, one) => (on) => { on ? set.delete(one) : set.add(one); };
  canvas.addEventListener("pointermove", (event) => {
    const found = near(event);
    canvas.style.cursor = found ? "pointer" : "default";
    if (found) parts.named.textContent = found.text;
  });
  canvas.addEventListener("click", (event) => { const found = near(event); if (found?.animal) go(found.animal); });
  watched(canvas, draw);
  choose(measure);
  return h("section", { class: "points" }, h("h2", {}, "All animals"),
    h("div", { class: "row" },
      choice(names.map((name) => [name, `${all.quantities[name][0]}: ${all.quantities[name][2]}`]), measure, choose, { "aria-label": "quantity", data: { key: "quantity" } }),
      box("logarithmic", log, (on) => { log = on; })),
    h("div", { class: "row" }, "groups", Object.entries(all.groups).map(([group, color]) => {
      const key = h("span", { class: "key" });
      key.style.borderColor = color;
      return box(group, !hidden.has(group), toggle(hidden, group), key);
    }), "sources", Object.entries(all.sources).map(([one, filled]) => box(words(one), !off.has(one), toggle(off, one), filled ? "● " : "○ "))),
    canvas, parts.named, h("details", {}, h("summary", {}, "As a table"), parts.table),
    all.failures.map((one) => h("div", { class: "finding bad" }, one)));
}

async function choose(name) {
  measure = name;
  means = {};
  draw();
  try {
    const found = await ask("means", { quantity: name });
    if (name === measure) { means = found; draw(); }
  } catch (error) {
    say(error.message, true);
  }
}

/** Everything that is shown from left to right: animals of a group, then its mean, one after another for each source. */
function columns() {
  const found = [];
  for (const [group, color] of Object.entries(all.groups)) {
    if (hidden.has(group)) continue;
    const members = all.animals.filter((one) => one.group === group);
    for (const one of members) {
      const values = sources().map((source) => [source, one.laws[source]?.[measure]]).filter(([, value]) => value && value[0] !== null);
      if (values.length) found.push({ name: one.name, animal: one.name, color, group, values });
    }
    const mean = sources().map((source) => [source, means[source]?.[group]]).filter(([, value]) => value && value[0] !== null);
    if (mean.length && members.length > 1) found.push({ name: `mean ${group}`, animal: null, color, group, values: mean });
  }
  return found;
}

export function draw() {
  if (!parts?.canvas.isConnected && parts?.canvas.clientWidth === 0) return;
  const shownColumns = columns(), [symbol, unit] = all.quantities[measure];
  table(shownColumns, symbol, unit);
  if (!shownColumns.length) { sheet(parts.canvas); scale = null; spots = []; return; }
  const series = [], points = [];
  shownColumns.forEach((column, k) => column.values.forEach(([source, [value, low, high]], j) => {
    const x = k + 1 + (column.values.length > 1 ? 0.5 * (j / (column.values.length - 1) - 0.5) : 0), look = { color: column.color, hollow: !all.sources[source], mean: !column.animal };
    if (low !== null && high !== null) series.push({ x: [x, x], y: [low, high], ...look, width: column.animal ? 1.5 : 3 });
    series.push({ x: [x], y: [value], ...look, points: true, size: column.animal ? 3.5 : 6 });
    points.push({ x, value, animal: column.animal, text: `${column.name}, ${words(source)}: ${symbol} = ${shown(value)} ${unit}${low === null ? "" : ` (${shown(low, 3)} to ${shown(high, 3)})`}` });
  }));
  const values = points.map((one) => one.value), positive = Math.min(...values) > 0;
  const shownRange = log && positive ? undefined : spread(values, series.filter((one) => !one.points).flatMap((one) => one.y));
  const narrow = (parts.canvas.clientWidth - 58) / (shownColumns.length + 1) < 70, foot = narrow ? 62 : 32;  // names stand aslant
  scale = plot(parts.canvas, { series, foot, y: `${symbol} [${unit}]`, across: [0.3, shownColumns.length + 0.7], log: log && positive, range: shownRange });
  if (!scale) return;
  spots = points.map((one) => ({ ...one, x: scale.px(one.x), y: scale.py(one.value) }));
  named(shownColumns, narrow, foot);
  parts.canvas.dataset.drawn = String(Number(parts.canvas.dataset.drawn || 0) + 1);
}

/** Names below the points, as many as there is room for. */
function named(shownColumns, narrow, foot) {
  const pen = parts.canvas.getContext("2d"), height = parts.canvas.clientHeight, room = (scale.right - scale.left) / (shownColumns.length + 1);
  const each = Math.ceil(13 / room);
  pen.fillStyle = style("--ink"); pen.textBaseline = "top"; pen.textAlign = narrow ? "right" : "center";
  shownColumns.forEach((one, k) => {
    if (k % each && one.animal) return;
    pen.save();
    pen.translate(scale.px(k + 1), height - foot + 4);
    if (narrow) pen.rotate(-0.5);
    pen.font = one.animal ? pen.font : `bold ${pen.font}`;
    pen.fillText(one.name.length > 14 ? `${one.name.slice(0, 13)}…` : one.name, 0, 0);
    pen.restore();
  });
}

function near(event) {
  let best = null, least = 14;
  for (const one of spots) {
    const gap = Math.hypot(one.x - event.offsetX, one.y - event.offsetY);
    if (gap < least) { least = gap; best = one; }
  }
  return best;
}

function table(shownColumns, symbol, unit) {
  const open = (name) => h("button", { type: "button", class: "plain-link", onclick: () => parts.go(name) }, name);
  fill(parts.table, h("div", { class: "table" }, h("table", {}, h("thead", {}, h("tr", {}, ["animal", "group", "source", `${symbol} [${unit}]`, "95 %"].map((one) => h("th", {}, one)))),
    h("tbody", {}, shownColumns.flatMap((column) => column.values.map(([source, [value, low, high]]) => h("tr", {}, h("td", {}, column.animal ? open(column.animal) : column.name), h("td", {}, column.group), h("td", {}, words(source)),
      h("td", {}, shown(value)), h("td", {}, low === null ? "" : `${shown(low, 3)} to ${shown(high, 3)}`))))))));
}

/** A range that shows all values, and of endless intervals as much as helps. */
function spread(values, ends) {
  const [low, high] = [Math.min(...values), Math.max(...values)], room = (high - low) || Math.abs(high) || 1;
  const far = ends.filter((one) => one > low - 2 * room && one < high + 2 * room);
  const [from, to] = [Math.min(low, ...far), Math.max(high, ...far)];
  return [from - 0.06 * (to - from || room), to + 0.06 * (to - from || room)];
}
