// The tree of an extraction: a click names a vessel and the nearest place on its axis.
(() => {
  "use strict";
  const data = JSON.parse(document.getElementById("tree-data").textContent);
  const canvas = document.getElementById("tree");
  const said = document.getElementById("picked");
  let chosen = null;

  function shade(far, strong, doubted) {
    const mix = (near, away) => Math.round(near + (away - near) * 0.75 * far);
    if (doubted && !strong) return `rgb(${mix(217, 245)},${mix(95, 205)},${mix(2, 170)})`;
    return strong ? "rgb(214,37,155)" : `rgb(${mix(0, 205)},${mix(92, 225)},${mix(112, 230)})`;
  }

  function draw(view) {
    const pieces = [];
    data.vessels.forEach((vessel) => {
      const at = vessel.points.map(view.seen);
      for (let i = 1; i < at.length; i++) {
        const radius = (vessel.points[i - 1][3] + vessel.points[i][3]) / 2;
        pieces.push([(at[i - 1][2] + at[i][2]) / 2, at[i - 1], at[i], Math.max(1, 2 * radius * view.unit()), vessel]);
      }
    });
    pieces.sort((a, b) => b[0] - a[0]);
    for (const [far, a, b, width, vessel] of pieces) {
      view.line(a, b, width, shade(far, vessel === (chosen && chosen.vessel), vessel.marked));
    }
    const [outside, inlet] = [view.seen(data.root), view.seen(data.vessels[0].points[0])];
    view.line(outside, inlet, 1, "#d6259b", [4, 4]);
    view.spot(outside, "#d6259b", 5);
    data.vessels.filter((v) => v.terminal).forEach((v) => view.spot(view.seen(v.points[v.points.length - 1]), "#b26a00", 3));
    data.doubts.forEach((p) => cross(view, view.seen(p)));
    if (chosen) view.spot(view.seen(chosen.point), "#000000", 5);
    view.scaleBar("#37474f");
  }

  function cross(view, at) {
    for (const side of [-1, 1]) view.line([at[0] - 6, at[1] - 6 * side], [at[0] + 6, at[1] + 6 * side], 2, "#000000");
  }

  function nearest(x, y) {
    let best = null, least = 14;
    data.vessels.forEach((vessel) => vessel.points.forEach((point, i) => {
      const at = view.seen(point);
      const end = vessel.terminal && i === vessel.points.length - 1;
      const gap = Math.hypot(at[0] - x, at[1] - y) - (end ? 4 : 0);
      if (gap < least) { least = gap; best = { vessel, point, end }; }
    }));
    return best;
  }

  const number = (value) => String(Number((value / data.factor).toFixed(4)));
  const place = (p, between) => p.slice(0, 3).map(number).join(between);

  function pick(x, y) {
    chosen = nearest(x, y);
    const v = chosen && chosen.vessel;
    said.textContent = !chosen ? "Nothing there." :
      `Vessel ${v.name}: radius ${v.radius} cm, length ${v.length} cm. ` +
      `${chosen.end ? "Its outlet" : "Place on its axis"} (x,y,z, cm): ${place(chosen.point, ",")}` +
      (v.doubts ? `. Doubted: ${v.doubts}` : "");
    document.querySelectorAll("button[data-edit]").forEach((button) => { button.disabled = !chosen; });
    view.redraw();
  }

  document.querySelectorAll("button[data-edit]").forEach((button) => button.addEventListener("click", () => {
    const kind = button.dataset.edit;
    const text = document.getElementById(kind === "outlet" ? "outlets" : "edits");
    text.value += kind === "outlet" ? `${place(chosen.point, ",")}\n` : `${kind} ${place(chosen.point, " ")}\n`;
  }));
  document.getElementById("all-outlets").addEventListener("click", () => {
    const ends = data.vessels.filter((v) => v.terminal).map((v) => v.points[v.points.length - 1]);
    document.getElementById("outlets").value += ends.map((p) => `${place(p, ",")}\n`).join("");
  });
  const missing = document.getElementById("missing");
  if (missing) missing.addEventListener("click", () => {
    document.getElementById("outlets").value += data.missing.map((p) => `${place(p, ",")}\n`).join("");
  });
  const view = turntable(canvas, [data.root, ...data.vessels.flatMap((v) => v.points)], draw, pick);
  view.redraw();
})();
