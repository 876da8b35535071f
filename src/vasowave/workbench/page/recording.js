// The Recording desk: hours of signals, beats with their fate, a stretch, the zero; the average beside changes at once.
import { act, ask, numbers, say } from "./ask.js";
import { choice, fill, h, shown } from "./dom.js";
import { plot, sheet, style, ticks, watched } from "./plot.js";

const NAMES = { pressure: "pressure [mmHg]", flow: "flow [ml/s]", ecg: "ECG" };
const INDICES = { HR: "1/min", mPAP: "mmHg", sPAP: "mmHg", dPAP: "mmHg", pPAP: "mmHg", CO: "ml/s", PVR: "mmHg s/ml" };
let told = null, view = null, chosen = null, beat = -1, kept = {}, whole = {}, parts = null, asking = null, undrawn = false, carried = null;

export async function show(place, rest) {
  const list = await ask("study");
  if (!place.isConnected) return;  // another desk or animal is wanted by now
  const names = (list.rows || []).map((row) => row.animal);
  if (!names.length) { fill(place, h("h1", {}, "Recording"), h("p", {}, "No animals yet: "), h("a", { href: "#study" }, "drop their files on the Study desk.")); return; }
  const animal = names.includes(rest[0]) ? rest[0] : names[0];
  kept = {}; whole = {}; chosen = null; beat = -1; view = null;
  const canvas = h("canvas", { class: "signals", tabindex: 0, role: "img", "aria-label": "signals; arrow keys scroll, + and − zoom" });
  const strip = h("canvas", { class: "overview", tabindex: 0, role: "img", "aria-label": "the whole recording; drag or arrow keys move the window" });
  const average = h("canvas", { class: "panel", role: "img", "aria-label": "averaged cycle of pressure" });
  const flow = h("canvas", { class: "panel", role: "img", "aria-label": "averaged cycle of flow" });
  parts = { canvas, strip, average, flow, tools: h("div"), numbers: h("div", { class: "numbers" }), found: h("div"), given: h("div"), error: h("div") };
  parts.side = h("section", { "aria-label": "average" }, parts.numbers, average, flow, parts.found);
  const at = names.indexOf(animal);
  const go = (name) => { location.hash = `recording/${encodeURIComponent(name)}`; };
  fill(place,
    h("div", { class: "row" }, h("h1", {}, "Recording of "), choice(names, animal, go, { "aria-label": "animal", data: { key: "animal" } }),
      h("button", { type: "button", disabled: at === 0, onclick: () => go(names[at - 1]) }, "‹ previous"),
      h("button", { type: "button", disabled: at === names.length - 1, onclick: () => go(names[at + 1]) }, "next ›")),
    parts.error,
    h("div", { class: "two" },
      h("section", { "aria-label": "signals" }, canvas, strip, parts.tools,
        h("p", { class: "keys" }, key("#00a7c4", "averaged"), key("", "good, not needed"), key("var(--alarm-edge)", "rejected"), key("var(--shade)", "outside the stretch"), key("var(--picked)", "picked")),
        h("p", { class: "keys" }, "Drag: a stretch, or the bold line where the picked beat begins. Click: a beat. Wheel: zoom, with Shift: scroll. Keys: ", ["←", "→", "+", "−", "n", "p", "x", "[", "]", "b", "e"].flatMap((key) => [h("kbd", {}, key), " "]),
          "scroll, zoom, next and previous beat, reject or restore, earlier and later by 1 ms, begin and end of a stretch at the middle.")),
      parts.side),
    parts.given);
  pointer(canvas, strip);
  watched(canvas, draw); watched(strip, draw); watched(average, drawAverage); watched(flow, drawAverage);
  await renew(place, [animal]);
}

export async function renew(place, rest) {
  const animal = rest[0] || told.animal;
  const found = await ask("recording", { animal });
  if (!place.isConnected) return;
  told = found;
  if (told.duration && !view) view = whole_();
  if (told.duration) { const before = JSON.stringify(told.cells); if (kept.of !== before) { kept = { of: before }; whole = {}; } }
  fill(parts.error, told.error ? h("div", { class: "finding bad" }, told.error) : null);
  drawAverage(); tools(); given(); findings();
  document.body.dataset.told = String(Number(document.body.dataset.told || 0) + 1);
  if (told.duration) { await overview(); draw(); }
}

const key = (color, text) => { const one = h("i", { class: "beat" }); one.style.background = color; return [one, ` ${text} `]; };
const whole_ = () => {
  const [from, to] = [told.from ?? 0, told.to ?? told.duration];
  return [Math.max(0, from - 0.02 * (to - from)), Math.min(told.duration, to + 0.02 * (to - from))];
};
const signals = () => told.signals || [];
const called = (name) => {
  const unit = name === "ecg" && told.channels?.find(([, , quantity]) => quantity === name)?.[1];
  return unit ? `${NAMES[name]} [${unit}]` : NAMES[name];
};

// Signals: what is near is fetched once, and drawn while more is on its way.

async function overview() {
  const width = Math.max(200, parts.strip.clientWidth);
  if (!whole.pressure) whole.pressure = await numbers("trace", { animal: told.animal, signal: "pressure", start: 0, end: told.duration, width });
}

async function fetchNear() {
  const span = view[1] - view[0], width = Math.max(200, parts.canvas.clientWidth);
  const have = kept.pressure;
  if (have && have.start <= Math.max(0, view[0]) && have.end >= Math.min(told.duration, view[1]) && have.each <= 1.6 * span / width && have.each >= span / width / 1.6) return;
  asking?.abort();
  asking = new AbortController();
  const start = Math.max(0, view[0] - span), end = Math.min(told.duration, view[1] + span);
  const count = Math.max(2, Math.min(4000, Math.round((end - start) / span * width)));
  const ask = { animal: told.animal, start, end, width: count }, mine = asking, of = kept.of;
  try {
    const found = await Promise.all(signals().map((signal) => numbers("trace", { ...ask, signal }, mine.signal)));
    if (kept.of !== of) return;
    signals().forEach((signal, k) => { kept[signal] = { start, end, each: (end - start) / count, count, values: found[k] }; });
    later();
  } catch (error) {
    if (error.name !== "AbortError") say(error.message, true);
  }
}

function later() {
  if (undrawn) return;
  undrawn = true;
  requestAnimationFrame(() => { undrawn = false; if (parts.canvas.isConnected) paint(); });
}

export function draw() {
  if (!told?.duration || !view || parts.canvas.clientWidth < 80) return;
  later();
  fetchNear();
}

const LEFT = 54, RIGHT = 6, FOOT = 18;
const x = (time) => LEFT + (time - view[0]) / (view[1] - view[0]) * (parts.canvas.clientWidth - LEFT - RIGHT);
const time = (at) => view[0] + (at - LEFT) / (parts.canvas.clientWidth - LEFT - RIGHT) * (view[1] - view[0]);

function paint() {
  const { pen, width, height } = sheet(parts.canvas), names = signals(), each = (height - FOOT) / names.length;
  const ink = style("--ink"), quiet = style("--quiet"), faint = style("--faint");
  pen.save(); pen.beginPath(); pen.rect(LEFT, 0, width - LEFT - RIGHT, height - FOOT); pen.clip();
  if (told.to !== undefined) {  // what is not averaged is shaded
    pen.fillStyle = style("--shade");
    pen.globalAlpha = 0.35;
    pen.fillRect(LEFT, 0, x(told.from) - LEFT, height - FOOT);
    pen.fillRect(x(told.to), 0, width - x(told.to), height - FOOT);
    pen.globalAlpha = 1;
  }
  beats(pen, height - FOOT);
  if (chosen) {
    pen.fillStyle = style("--picked"); pen.globalAlpha = 0.3;
    pen.fillRect(x(chosen[0]), 0, x(chosen[1]) - x(chosen[0]), height - FOOT);
    pen.globalAlpha = 1;
  }
  pen.restore();
  names.forEach((name, row) => {
    const data = kept[name], top = row * each + 4, bottom = (row + 1) * each - 4;
    pen.fillStyle = quiet; pen.textAlign = "left"; pen.textBaseline = "top";
    if (!data) return;
    const first = Math.max(0, Math.floor((view[0] - data.start) / data.each)), last = Math.min(data.count, Math.ceil((view[1] - data.start) / data.each));
    let low = Infinity, high = -Infinity;
    for (let k = first; k < last; k++) {
      if (data.values[k] < low) low = data.values[k];
      if (data.values[data.count + k] > high) high = data.values[data.count + k];
    }
    if (!(high >= low)) { pen.fillText(`${called(name)}: no samples here`, LEFT + 4, top); return; }
    const pad = 0.08 * (high - low) + 1e-9, y = (value) => bottom - (value - low + pad) / (high - low + 2 * pad) * (bottom - top);
    pen.strokeStyle = faint; pen.lineWidth = 1; pen.textAlign = "right"; pen.textBaseline = "middle";
    for (const at of ticks(low, high, each / 32)) {
      pen.beginPath(); pen.moveTo(LEFT, y(at)); pen.lineTo(width - RIGHT, y(at)); pen.stroke();
      pen.fillText(String(Number(at.toPrecision(5))), LEFT - 5, y(at));
    }
    pen.save(); pen.beginPath(); pen.rect(LEFT, top - 4, width - LEFT - RIGHT, bottom - top + 8); pen.clip();
    pen.strokeStyle = ink; pen.lineWidth = 1.1; pen.beginPath();
    let up = true;
    for (let k = first; k < last; k++) {
      const [down, over] = [data.values[k], data.values[data.count + k]];
      if (Number.isNaN(down)) { up = true; continue; }
      const at = x(data.start + (k + 0.5) * data.each);
      pen[up ? "moveTo" : "lineTo"](at, y(down));
      if (over !== down) pen.lineTo(at, y(over));
      up = false;
    }
    pen.stroke(); pen.restore();
    pen.textAlign = "left"; pen.textBaseline = "top"; pen.fillStyle = ink;
    pen.fillText(called(name), LEFT + 4, top - 2);
  });
  pen.fillStyle = quiet; pen.textAlign = "center"; pen.textBaseline = "bottom";
  for (const at of ticks(view[0], view[1], width / 90)) pen.fillText(clock(at), x(at), height - 2);
  strip();
  parts.canvas.dataset.drawn = String(Number(parts.canvas.dataset.drawn || 0) + 1);
}

const clock = (value) => {
  const digits = Math.max(0, Math.min(4, 2 - Math.floor(Math.log10(view[1] - view[0]))));
  return value < 120 || view[1] - view[0] < 20 ? `${Number(value.toFixed(digits))} s` : `${Math.floor(value / 60)}:${String(Math.round(value % 60)).padStart(2, "0")}`;
};

function near(value, list) {  // the last that is not after it
  let [low, high] = [0, list.length];
  while (low < high) { const middle = (low + high) >> 1; list[middle] <= value ? low = middle + 1 : high = middle; }
  return low - 1;
}

function beats(pen, height) {
  const list = told.beats;
  if (!list) return;
  const first = Math.max(0, near(view[0], list.starts)), last = Math.min(list.starts.length, near(view[1], list.starts) + 1);
  if (last - first > parts.canvas.clientWidth / 3) return;
  const averaged = new Set(list.averaged), end = (k) => list.starts[k + 1] ?? list.end;
  for (let k = first; k < last; k++) {
    const lost = list.rejected[k];
    pen.fillStyle = lost ? style("--alarm-edge") : "#00a7c4";
    pen.globalAlpha = k === beat ? 0.4 : lost ? 0.16 : averaged.has(k) ? 0.2 : 0;
    pen.fillRect(x(list.starts[k]), 0, x(end(k)) - x(list.starts[k]), height);
    pen.globalAlpha = k === beat ? 0.9 : 0.5;
    pen.fillRect(x(k === beat ? carried ?? list.starts[k] : list.starts[k]) - (k === beat ? 1.5 : 0.5), 0, k === beat ? 3 : 1, height);
  }
  pen.globalAlpha = 1;
}

function strip() {
  const { pen, width, height } = sheet(parts.strip), data = whole.pressure;
  if (!data) return;
  const count = data.length / 2, low = Math.min(...data.filter(Number.isFinite)), high = Math.max(...data.filter(Number.isFinite));
  pen.strokeStyle = style("--quiet"); pen.beginPath();
  for (let k = 0; k < count; k++) {
    if (Number.isNaN(data[k])) continue;
    const y = (value) => height - 3 - (value - low) / (high - low || 1) * (height - 6), at = k / count * width;
    pen.moveTo(at, y(data[k])); pen.lineTo(at, y(data[count + k]) - 0.5);
  }
  pen.stroke();
  pen.fillStyle = style("--picked"); pen.globalAlpha = 0.5;
  const [from, to] = view.map((at) => at / told.duration * width);
  pen.fillRect(from, 0, Math.max(2, to - from), height);
  const words = `pressure of all ${shown(told.duration, 4)} s`;
  pen.globalAlpha = 0.85; pen.fillStyle = style("--paper");
  pen.fillRect(0, height - 15, pen.measureText(words).width + 8, 15);
  pen.globalAlpha = 1; pen.fillStyle = style("--ink"); pen.textAlign = "left"; pen.textBaseline = "bottom";
  pen.fillText(words, 4, height - 2);
}

// The hand: pointer and keys.

function look(from, to) {
  const span = Math.min(told.duration, Math.max(0.05, to - from));
  const start = Math.min(Math.max(0, from), told.duration - span);
  view = [start, start + span];
  draw();
}
const zoom = (factor, at = (view[0] + view[1]) / 2) => look(at - (at - view[0]) * factor, at + (view[1] - at) * factor);
const scroll = (share) => { const by = share * (view[1] - view[0]); look(view[0] + by, view[1] + by); };

function pointer(canvas, strip) {
  let from = null;
  const at = (event) => Math.min(told.duration, Math.max(0, time(event.clientX - canvas.getBoundingClientRect().left)));
  const onLine = (event) => beat >= 0 && Math.abs(x(at(event)) - x(told.beats.starts[beat])) < 6;
  canvas.addEventListener("pointerdown", (event) => {
    if (!told?.duration || event.button !== 0) return;
    if (onLine(event)) carried = told.beats.starts[beat]; else from = at(event);
    canvas.setPointerCapture(event.pointerId);
  });
  canvas.addEventListener("pointermove", (event) => {
    if (!told?.duration) return;
    canvas.style.cursor = carried !== null || onLine(event) ? "ew-resize" : "";
    if (carried !== null) { carried = at(event); later(); return; }
    if (from === null || Math.abs(x(at(event)) - x(from)) < 4 && !chosen) return;
    chosen = [Math.min(from, at(event)), Math.max(from, at(event))];
    later();
  });
  canvas.addEventListener("pointerup", async (event) => {
    if (carried !== null) {
      const by = at(event) - told.beats.starts[beat];
      if (Math.abs(by) >= 5e-4) await move(by);
      carried = null;
      later();
    }
    if (from === null) return;
    if (Math.abs(x(at(event)) - x(from)) < 4) { chosen = null; pick(told.beats ? near(at(event), told.beats.starts) : -1); } else tools();
    from = null;
  });
  canvas.addEventListener("wheel", (event) => {
    if (!told?.duration) return;
    event.preventDefault();
    const side = event.shiftKey || Math.abs(event.deltaX) > Math.abs(event.deltaY);
    side ? scroll((event.deltaX || event.deltaY) / 800) : zoom(2 ** (event.deltaY / 400), at(event));
  }, { passive: false });
  const keys = {
    ArrowLeft: () => scroll(-0.2), ArrowRight: () => scroll(0.2), PageUp: () => scroll(-1), PageDown: () => scroll(1),
    Home: () => look(0, view[1] - view[0]), End: () => look(told.duration - view[1] + view[0], told.duration),
    "+": () => zoom(0.5), "=": () => zoom(0.5), "-": () => zoom(2), 0: () => look(0, told.duration),
    n: () => pick(beat < 0 ? near(view[0], told.beats.starts) + 1 : beat + 1), p: () => pick(beat - 1), x: toggle,
    "[": () => move(-0.001), "]": () => move(0.001),
    b: () => { const middle = (view[0] + view[1]) / 2; chosen = [middle, Math.max(middle, chosen?.[1] ?? view[1])]; tools(); later(); },
    e: () => { const middle = (view[0] + view[1]) / 2; chosen = [Math.min(middle, chosen?.[0] ?? view[0]), middle]; tools(); later(); },
    Escape: () => { chosen = null; pick(-1); },
  };
  for (const one of [canvas, strip]) one.addEventListener("keydown", (event) => {
    if (!told?.duration || event.ctrlKey || event.metaKey || event.altKey || !keys[event.key]) return;
    event.preventDefault();
    keys[event.key]();
  });
  const centre = (event) => {
    const middle = (event.clientX - strip.getBoundingClientRect().left) / strip.clientWidth * told.duration, half = (view[1] - view[0]) / 2;
    look(middle - half, middle + half);
  };
  strip.addEventListener("pointerdown", (event) => { if (told?.duration) { strip.setPointerCapture(event.pointerId); centre(event); } });
  strip.addEventListener("pointermove", (event) => { if (strip.hasPointerCapture(event.pointerId)) centre(event); });
}

function pick(k) {
  const list = told.beats;
  beat = list && k >= 0 && k < list.starts.length ? k : -1;
  if (beat >= 0) {
    const [start, end] = span(beat);
    if (start < view[0] || end > view[1]) { const half = (view[1] - view[0]) / 2; look((start + end) / 2 - half, (start + end) / 2 + half); }
  }
  tools(); later();
}
const span = (k) => [told.beats.starts[k], told.beats.starts[k + 1] ?? told.beats.end];
const middle = (k) => { const [start, end] = span(k); return (start + end) / 2; };

/** The edit that decides on a beat already, if there is one. */
const edited = (k) => told.edits.find(([what, at]) => what !== "move" && at >= span(k)[0] && at < span(k)[1]);

/** Change something of this animal; until its average is computed anew the old numbers are pale. */
async function change(what, given, quiet = false) {
  parts.side.classList.add("old-numbers");
  await act(what, { animal: told.animal, ...given }, quiet);
  parts.side.classList.remove("old-numbers");
}

function toggle() {
  if (beat < 0) return;
  const own = edited(beat), lost = told.beats.rejected[beat];
  if (own) change("edit-beats", { forget: [own[1]] });
  else change("edit-beats", { edits: [[lost ? "keep" : "reject", middle(beat), null]] });
}

function move(by) {
  if (beat < 0) return;
  const start = told.beats.starts[beat], own = told.edits.find(([what, , to]) => what === "move" && Math.abs(to - start) < 1e-4);
  return change("edit-beats", { edits: [["move", own ? own[1] : start, start + by]] }, true);
}

async function judge(what) {
  const inside = told.beats.starts.map((_, k) => k).filter((k) => middle(k) >= chosen[0] && middle(k) < chosen[1]);
  const wanted = inside.filter((k) => (what === "reject") !== Boolean(told.beats.rejected[k]));
  if (wanted.length) await change("edit-beats", { edits: wanted.map((k) => [what, middle(k), null]) });
  else say(`No beat there is to ${what}.`);
}

// What stands beside the signals.

const button = (text, does, key) => h("button", { type: "button", data: { key: key || text }, onclick: does }, text);

function tools() {
  if (!told.duration) { fill(parts.tools); return; }
  const done = change;
  const both = chosen && { start: chosen[0], end: chosen[1] };
  fill(parts.tools,
    h("div", { class: "row" }, button("−", () => zoom(2), "out"), button("+", () => zoom(0.5), "in"), button("all", () => look(0, told.duration)),
      told.cells["start [s]"] || told.cells["end [s]"] ? button("Average the whole recording", () => done("set-stretch", {})) : null,
      ["pressure", "flow"].filter((one) => told.cells[`${one} gain [1]`]).map((one) => button(`Take back the gain of the ${one} (${told.cells[`${one} gain [1]`]})`, () => done("set-gain", { signal: one }))),
      told.cells["zero [mmHg]"] ? button(`Take back the zero (${told.cells["zero [mmHg]"]} mmHg)`, () => done("set-zero", {})) : null,
      h("label", {}, "drift", choice([["remove", "removed"], ["warn", "left in"]], told.drift, (value) => act("set-setting", { key: "averaging.drift", value }), { data: { key: "drift" } }), h("span", {}, "(of all animals)"))),
    chosen ? h("div", { class: "row" }, h("span", {}, `${chosen[0].toFixed(3)} to ${chosen[1].toFixed(3)} s:`),
      button("Average this stretch", () => done("set-stretch", both)), button("This is zero pressure", () => done("set-zero", both)), known(done, both),
      told.beats ? [button("Reject its beats", () => judge("reject")), button("Keep its beats", () => judge("keep"))] : null,
      button("Zoom in", () => look(...chosen))) : null,
    reasons(),
    beat >= 0 && told.beats ? h("div", { class: "row", data: { beat } }, h("span", {}, `Beat ${beat + 1} of ${told.beats.starts.length}, ${span(beat)[0].toFixed(3)} s: `,
      told.beats.rejected[beat] ? `rejected, ${told.beats.rejected[beat]}` : told.beats.averaged.includes(beat) ? "averaged" : "good"),
      button(edited(beat) ? "As the rules say" : told.beats.rejected[beat] ? "Keep it" : "Reject it", toggle, "judge"),
      button("1 ms earlier", () => move(-0.001)), button("1 ms later", () => move(0.001))) : null,
    told.edits.length ? h("div", { class: "row" }, h("span", { class: "note" }, `${told.edits.length} beats edited, in ${told.cells["beat edits"]}`),
      button("Forget all edits", () => done("edit-beats", { forget: told.edits.map(([, at]) => at) }))) : null);
}

/** A point of calibration: what the mean of the stretch was known to be. */
function known(done, both) {
  const value = h("input", { type: "number", step: "any", min: 0, data: { key: "known" }, "aria-label": "known mean of the stretch" });
  const signal = choice([["pressure", "mmHg"], ["flow", "ml/s"]], "pressure", () => {}, { "aria-label": "of pressure or flow", data: { key: "known of" } });
  return h("label", {}, "its mean is known:", value, signal, button("Calibrate", () => done("set-gain", { ...both, signal: signal.value, known: Number(value.value) })));
}

/** Rejected beats by reason; the next of them at a click. */
function reasons() {
  const found = new Map();
  for (const [k, why] of Object.entries(told.beats?.causes || {})) found.set(why, [...(found.get(why) || []), Number(k)]);
  if (!found.size) return null;
  const next = (list) => { pick(list.find((k) => k > beat) ?? list[0]); parts.canvas.focus({ preventScroll: true }); };
  return h("div", { class: "row" }, h("span", { class: "note" }, "rejected, to the next:"),
    [...found].map(([why, list]) => button(`${list.length} × ${why}`, () => next(list), `why ${why}`)));
}

function findings() {
  const list = told.indices || {}, used = told.beats ? `${told.beats.averaged.length} of ${told.beats.starts.length}` : null;
  fill(parts.numbers, Object.entries(INDICES).filter(([name]) => name in list).map(([name, unit]) =>
    h("div", {}, h("span", {}, `${name} [${unit}]`), h("b", { data: { index: name } }, shown(list[name])))),
    used ? h("div", {}, h("span", {}, "beats averaged"), h("b", { data: { index: "beats" } }, used)) : null);
  fill(parts.found, (told.findings || []).filter((one) => one.look).map((one) => h("div", { class: "finding" }, one.text)),
    told.findings?.length ? h("details", {}, h("summary", {}, "What was noted"), told.findings.filter((one) => !one.look).map((one) => h("div", { class: "finding plain" }, one.text))) : null);
}

function given() {
  const set = (title) => (text) => text !== told.cells[title] && act("set-cells", { animal: told.animal, cells: { [title]: text }, was: { [title]: told.cells[title] } }, true);
  const field = (title) => {
    const input = h("input", { type: "text", value: told.cells[title], size: 9, data: { key: title }, onchange: () => set(title)(input.value) });
    return h("label", {}, title, input);
  };
  const channels = (told.channels || []).map(([title, unit]) => [title, `${title} [${unit || "no unit"}]`]);
  const one = (title) => h("label", {}, title, choice([["", "by its title"], ...channels], told.cells[title], set(title), { data: { key: title } }));
  const raw = told.kind === "raw";
  fill(parts.given, h("h2", {}, "What the table says"), h("div", { class: "row" },
    raw ? ["pressure channel", "flow channel", "ecg channel"].map(one) : field("period [s]"),
    ["pressure unit", "flow unit", "zero [mmHg]", "pressure gain [1]", "flow gain [1]", "wedge [mmHg]", ...(raw ? ["start [s]", "end [s]", "sampling rate [1/s]"] : [])].map(field),
    raw && told.blocks > 1 ? field("block") : null));
}

function drawAverage() {
  if (!told?.pressure) { for (const one of [parts.average, parts.flow]) sheet(one); return; }
  const curve = (name, color) => {
    const values = told[name], count = values.length, sd = told.sd?.[name];
    const band = sd ? { low: values.map((one, k) => one - sd[k]), high: values.map((one, k) => one + sd[k]) } : undefined;
    return { x: values.map((_, k) => k / count * told.period * 1000), y: values, color, band, width: 1.8 };
  };
  plot(parts.average, { series: [curve("pressure", style("--ink"))], y: "pressure [mmHg], ± 1 SD of the beats" });
  plot(parts.flow, { series: [curve("flow", "#00a7c4")], y: "flow [ml/s]", x: "time [ms]" });
}

/** For measurements and tests: look at a part of the recording. */
export const lookAt = look;
