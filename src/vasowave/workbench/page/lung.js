// The Lung desk: an image in three slices, the vessels found in it over them and in space, their doubts, and edits.
import { act, ask, bytes, post } from "./ask.js";
import { choice, fill, h, shown } from "./dom.js";
import { style, watched } from "./plot.js";
import { VIEWS, drawSlice, extent, frame, volume } from "./slices.js";

const SPECIES = ["mouse", "rat", "rabbit", "dog", "pig", "human", "other"], DOUBTED = "#d95f02", PICKED = "#d6259b";
let told = null, image = null, found = null, parts = null, at = [0, 0, 0], chosen = "", moving = null, wishes = {}, look = {}, space = null, stale = false, waiting = 0, drawing = false;

export async function show(place, rest) {
  const about = await ask("lung", { image: rest[0] || "" });
  if (!place.isConnected) return;  // another desk or image is wanted by now
  told = about;
  if (!told.images.length) { fill(place, h("h1", {}, "Lung"), h("p", {}, "No images yet: "), h("a", { href: "#study" }, "drop a volume on the Study desk"), ", or open one: ", h("code", {}, "vasowave open scan.nrrd")); return; }
  found = null; image = null; chosen = ""; moving = null; stale = false; wishes = { ...told.wishes };
  const slices = VIEWS.map((view) => h("canvas", { class: "slice", tabindex: 0, role: "img", "aria-label": `slice ${view.name}; click picks a place, arrow keys move it, wheel or page keys go through` }));
  parts = { slices, space: h("canvas", { class: "space", tabindex: 0, role: "img", "aria-label": "the tree; drag or arrow keys turn it, a click picks a vessel" }),
    wish: h("div"), stage: h("p", { class: "note", role: "status", id: "stage" }), sliders: h("div"), picked: h("div"), doubts: h("div", { class: "doubts" }), edits: h("div"), table: h("div"), notes: h("div"), facts: h("p", { class: "note" }) };
  const go = (name) => { location.hash = `lung/${encodeURIComponent(name)}`; };
  fill(place,
    h("div", { class: "row" }, h("h1", {}, "Lung in "), choice(told.images, told.image, go, { "aria-label": "image", data: { key: "image" } })),
    parts.wish, parts.stage, parts.notes,
    h("div", { class: "two" },
      h("section", { "aria-label": "image" }, h("div", { class: "slices" }, slices, parts.space), parts.sliders, parts.facts),
      h("section", { "aria-label": "vessels" }, parts.picked, parts.doubts, parts.edits)),
    parts.table);
  wish(); edits();
  parts.stage.textContent = "Reading the image …";
  const mine = parts;
  const content = await bytes("volume", { image: told.image, ...(wishes.voxel ? { voxel: wishes.voxel } : {}) });
  if (mine !== parts) return;
  image = volume(content);
  at = [0, 1, 2].map((k) => (extent(image, k)[0] + extent(image, k)[1]) / 2);
  look = { dark: image.low, bright: image.high };
  if (!told.written) { wishes.threshold = image.threshold; wish(); }  // as `vasowave look` proposes
  parts.facts.textContent = `${told.file}: ${image.voxels.join(" × ")} voxels of ${image.voxel.map((one) => shown(1e4 * one, 3)).join(" × ")} µm, shown as ${image.shape.join(" × ")}`;
  slices.forEach((canvas, k) => { pointer(canvas, VIEWS[k]); watched(canvas, draw); });
  begin(); sliders(); picked();
  parts.stage.textContent = "";
  draw();
  if (told.root) vessels();  // which may take a while; the page is there meanwhile
  else parts.stage.textContent = "Click the outer end of the cannula in a slice, then “Blood enters here”.";
}

export async function renew(place, rest) {
  if (!parts || !told?.image || !image) return;
  const mine = parts, now = await ask("lung", { image: told.image });
  if (mine !== parts) return;
  told = now;
  edits(); wish();
  if (found && !stale) await vessels();
}

async function vessels() {
  const mine = ++waiting, of = parts, asked = ask("lung", { image: told.image }).catch(() => told);  // meanwhile
  const watching = setInterval(async () => { const now = await ask("lung", { image: told.image }).catch(() => ({})); if (mine === waiting && now.stage) of.stage.textContent = `Looking for the vessels: ${now.stage} …`; }, 700);
  try {
    const answer = await post("vessels", { image: told.image, wishes });
    if (mine !== waiting || of !== parts) return;
    found = answer; stale = false;
    chosen = chosen && nearest(at);  // an edit numbers the vessels anew, and the next one acts at the place
    of.stage.textContent = `${found.vessels.length} vessels, ${found.vessels.filter((one) => one.terminal).length} of them terminal, in ${found.generations} generations; ${shown(found.total, 3)} cm in all` +
      (found.scale === null ? "." : `; the cannula measures ${shown(found.scale, 2)} % off its size.`);
    fill(of.notes);
  } catch (error) {
    if (mine !== waiting || of !== parts) return;
    of.stage.textContent = "";
    fill(of.notes, h("div", { class: "finding bad" }, error.message));
  } finally {
    clearInterval(watching);
  }
  const about = await asked;
  if (of !== parts) return;
  told = about;
  wish(); doubts(); table(); picked(); edits(); draw();
}

// What is wished for, and the window.

function wish() {
  const number = (name, text, step) => {
    const input = h("input", { type: "number", value: wishes[name] ?? "", step, data: { key: name }, onchange: () => { wishes[name] = input.value === "" ? null : Number(input.value); stale = true; wish(); if (name === "threshold") { sliders(); draw(); } } });
    return h("label", {}, text, input);
  };
  fill(parts.wish, h("div", { class: "row" }, number("threshold", "wall at grey level", "any"), number("cannula", "cannula, inner ⌀ [cm]", 0.001), number("pressure", "filled at [mmHg]", "any"),
    h("label", {}, "species", choice(SPECIES, wishes.species, (value) => { wishes.species = value; stale = true; wish(); }, { data: { key: "species" } })),
    number("voxel", "voxel [cm], else the file's", "any"),
    h("label", {}, h("input", { type: "checkbox", checked: wishes.open_loops, data: { key: "loops" }, onchange: (event) => { wishes.open_loops = event.target.checked; stale = true; wish(); } }), "open loops"),
    h("button", { type: "button", id: "find", class: stale || !found ? "main" : "", disabled: !image, data: { key: "find" }, onclick: vessels }, stale && found ? "Find the vessels again" : "Find the vessels"),
    h("button", { type: "button", id: "write", disabled: !found || stale, data: { key: "write" }, onclick: async () => { parts.stage.textContent = "Writing …"; await act("write-lung", { image: told.image, wishes }); parts.stage.textContent = ""; told = await ask("lung", { image: told.image }); wish(); } }, "Write the network"),
    stale && found ? h("span", { class: "old" }, "outdated: something was changed since") : told.written ? (told.outdated ? h("span", { class: "old" }, "network.csv is older than the edits") : h("span", { class: "note" }, `lungs/${told.image}/network.csv is written`)) : null,
    told.written && !stale ? h("button", { type: "button", data: { key: "use" }, onclick: () => act("use-network", { network: `lungs/${told.image}/network.csv` }) }, "Use it for all animals that have none") : null));
}

function sliders() {
  const one = (name, text, get, set) => {
    const out = h("output", {}, shown(get(), 3));
    return h("label", {}, text, h("input", { type: "range", min: image.low, max: image.high, step: "any", value: get(), data: { key: `slide ${name}`, slide: name },
      oninput: (event) => { set(Number(event.target.value)); out.textContent = shown(get(), 3); draw(); }, onchange: () => { if (name === "threshold") { stale = true; wish(); } } }), out);
  };
  fill(parts.sliders, h("div", { class: "row" }, one("dark", "black at", () => look.dark, (value) => { look.dark = value; }), one("bright", "white at", () => look.bright, (value) => { look.bright = value; }),
    one("threshold", "wall at", () => wishes.threshold, (value) => { wishes.threshold = Number(value.toPrecision(4)); })),
    h("p", { class: "keys" }, "Blue tint: above the wall's grey level. Lines: axes of the vessels, strong where they run in the slice; orange: doubted, in space with crosses where; pink: the picked vessel, and the dot where the blood enters. Wheel or ", h("kbd", {}, "Page up"), " ", h("kbd", {}, "Page down"), " go through the slices, arrows move the place."));
}

// The place that is looked at, and what can be done there.

function go(place, name = "") {
  at = place.slice(0, 3);
  chosen = name || nearest(at);
  picked(); draw();
}

function nearest(place) {
  let best = "", least = Infinity;
  for (const vessel of found?.vessels || []) for (const point of vessel.points) {
    const gap = Math.hypot(...[0, 1, 2].map((k) => point[k] - place[k])) / Math.max(point[3], 1e-6);
    if (gap < 3 && gap < least) { least = gap; best = vessel.name; }
  }
  return best;
}

async function edit(action, more = {}) {
  const point = moving && action === "move" ? moving : at;
  moving = null;
  const done = await act("edit-tree", { image: told.image, action, point, ...more });
  if (done && (action === "root" || action === "outlet")) { stale = true; wish(); picked(); if (action === "root") await vessels(); }
}

function picked() {
  const vessel = found?.vessels.find((one) => one.name === chosen);
  const button = (text, action, usable = true) => h("button", { type: "button", disabled: !usable, data: { key: action, edit: action }, onclick: () => edit(action) }, text);
  const radius = h("input", { type: "number", min: 0, step: "any", value: vessel?.radius ?? "", "aria-label": "radius, cm", data: { key: "radius" } });
  fill(parts.picked, h("h2", {}, vessel ? `Vessel ${vessel.name}` : "Place"), h("p", { class: "note", id: "picked" }, `x, y, z: ${at.map((one) => one.toFixed(4)).join(", ")} cm along the image's axes. `,
    vessel ? `Radius ${shown(vessel.radius, 3)} ± ${shown(vessel.sd, 2)} cm${vessel.reliable ? "" : ", not reliable"}; length ${shown(vessel.length, 3)} cm; ${vessel.parent ? `daughter of ${vessel.parent}` : "the root"}${vessel.doubts.length ? `; doubted: ${vessel.doubts.join(", ")}` : ""}.` : found ? "No vessel is near." : ""),
    moving ? h("div", { class: "row" }, h("strong", {}, "Pick where the end goes, then"), h("button", { type: "button", class: "main", onclick: () => edit("move", { to: at }) }, "move it here"), h("button", { type: "button", onclick: () => { moving = null; picked(); draw(); } }, "leave it"))
      : [h("div", { class: "row" }, button("Blood enters here", "root"), button("An outlet", "outlet")),
        found ? h("div", { class: "row" }, button("Remove, and all beyond", "remove", vessel), button("Cut here", "cut", vessel), button("Merge to a point", "merge", vessel),
          h("button", { type: "button", disabled: !vessel, data: { key: "move" }, onclick: () => { moving = [...at]; picked(); } }, "Move this end …")) : null,
        vessel ? h("div", { class: "row" }, h("label", {}, "radius [cm]", radius), h("button", { type: "button", data: { key: "set radius" }, onclick: () => edit("radius", { radius: Number(radius.value) }) }, "Set it")) : null]);
}

function doubts() {
  if (!found) return;
  const middle = (name) => { const vessel = found.vessels.find((one) => one.name === name); return vessel?.points[vessel.points.length >> 1]; };
  const visit = (one) => { const places = [...one.places, ...one.vessels.map(middle).filter(Boolean)]; if (places.length) go(places[0], one.vessels[0]); };
  fill(parts.doubts, h("h2", {}, found.doubts.length ? `Doubts: ${found.doubts.length}` : "No doubts"),
    found.doubts.map((one, k) => h("div", { class: "finding" }, `${one.about}: ${one.text}`, h("button", { type: "button", data: { key: `doubt ${k}`, doubt: k }, onclick: () => visit(one) }, "look"))),
    found.notes.length ? h("details", {}, h("summary", {}, "What was noted"), found.notes.map((one) => h("div", { class: "finding plain" }, one))) : null);
}

function edits() {
  fill(parts.edits, h("h2", {}, "Edits"), told.edits.length ? h("p", { class: "note" }, `in edits/${told["file of edits"]}, which vasowave extract --edits reads`) : h("p", { class: "note" }, "None yet."),
    told.edits.map(([line, text]) => h("div", { class: "row" }, h("code", {}, text), h("button", { type: "button", data: { key: `forget ${line}` }, onclick: () => act("forget-edit", { image: told.image, line, text }) }, "forget"))));
}

function table() {
  if (!found) return;
  fill(parts.table, h("h2", {}, "Vessels"), h("div", { class: "table", data: { scrolls: 1 } }, h("table", { id: "vessels" },
    h("thead", {}, h("tr", {}, ["vessel", "parent", "length [cm]", "radius [cm]", "SD [cm]", "reliable", "doubted", ""].map((one) => h("th", {}, one)))),
    h("tbody", {}, found.vessels.map((one) => h("tr", { data: { vessel: one.name } }, [one.name, one.parent, shown(one.length), shown(one.radius), shown(one.sd, 2), one.reliable ? "yes" : "no", one.doubts.join(", ")].map((cell) => h("td", {}, cell)),
      h("td", {}, h("button", { type: "button", data: { key: `look ${one.name}` }, onclick: () => go(one.points[one.points.length >> 1], one.name) }, "look"))))))));
}

// Slices and space.

function pointer(canvas, view) {
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    go(frame(canvas, image, view).place(event.offsetX, event.offsetY, at));
  });
  canvas.addEventListener("pointermove", (event) => { if (event.buttons) { at = frame(canvas, image, view).place(event.offsetX, event.offsetY, at); draw(); } });
  canvas.addEventListener("pointerup", () => go(at));
  const step = (k, count) => { const [low, high] = extent(image, k); at[k] = Math.min(high, Math.max(low, at[k] + count * image.spacing[k])); go(at); };
  canvas.addEventListener("wheel", (event) => { event.preventDefault(); step(view.through, Math.sign(event.deltaY)); }, { passive: false });
  const keys = { ArrowLeft: [view.right, -1], ArrowRight: [view.right, 1], ArrowUp: [view.down, -view.up], ArrowDown: [view.down, view.up], PageUp: [view.through, 1], PageDown: [view.through, -1] };
  canvas.addEventListener("keydown", (event) => { if (keys[event.key]) { event.preventDefault(); step(...keys[event.key]); } });
}

function draw() {
  if (drawing || !image) return;
  drawing = true;
  requestAnimationFrame(() => {
    drawing = false;
    if (!image || !parts.space.isConnected) return;
    const marks = [...(found ? [[found.root, PICKED]] : []), ...(moving ? [[moving, "#ffffff"]] : [])];
    parts.slices.forEach((canvas, k) => canvas.clientWidth > 40 && drawSlice(canvas, image, VIEWS[k], { at, ...look, threshold: wishes.threshold, tint: true, vessels: found?.vessels || [], chosen, marks }));
    space?.redraw();
  });
}

function begin() {
  const corners = [0, 1, 2, 3, 4, 5, 6, 7].map((k) => [0, 1, 2].map((axis) => extent(image, axis)[k >> axis & 1]));
  // eslint-disable-next-line no-undef
  space = turntable(parts.space, corners, (view) => {
    const ink = style("--ink"), quiet = style("--quiet");
    for (const one of VIEWS) {  // where the slices lie
      const corner = (a, b) => { const place = [...at]; place[one.right] = extent(image, one.right)[a]; place[one.down] = extent(image, one.down)[b]; return view.seen(place); };
      [[0, 0, 1, 0], [1, 0, 1, 1], [1, 1, 0, 1], [0, 1, 0, 0]].forEach(([a, b, c, d]) => view.line(corner(a, b), corner(c, d), 0.6, quiet));
    }
    const pieces = (found?.vessels || []).flatMap((one) => one.points.slice(1).map((point, k) => [view.seen(one.points[k]), view.seen(point), Math.max(1.5, (one.points[k][3] + point[3]) * view.unit()), one]));
    pieces.sort((a, b) => b[0][2] + b[1][2] - a[0][2] - a[1][2]);
    for (const [from, to, width, one] of pieces) {
      const far = (from[2] + to[2]) / 2, mix = (near, away) => Math.round(near + (away - near) * 0.6 * far);
      view.line(from, to, width, one.name === chosen ? PICKED : one.doubts.length ? DOUBTED : `rgb(${mix(0, 150)},${mix(120, 190)},${mix(150, 200)})`);
    }
    for (const one of found?.doubts || []) for (const place of one.places) { const [x, y] = view.seen(place); view.line([x - 5, y - 5], [x + 5, y + 5], 2, ink); view.line([x - 5, y + 5], [x + 5, y - 5], 2, ink); }
    if (found) view.spot(view.seen(found.root), PICKED, 5);
    view.spot(view.seen(at), ink, 4);
    view.scaleBar(ink);
  }, (x, y) => {
    let best = null, least = 16;
    for (const one of found?.vessels || []) for (const point of one.points) {
      const seen = space.seen(point), gap = Math.hypot(seen[0] - x, seen[1] - y);
      if (gap < least) { least = gap; best = [point, one.name]; }
    }
    if (best) go(...best);
  });
  space.rotate(0.5, 0.3);
  watched(parts.space, draw);
}
