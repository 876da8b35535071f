// The tree in space: drag turns it, the wheel zooms, a click names a vessel and the nearest place on its axis.
(function () {
  "use strict";
  const data = JSON.parse(document.getElementById("tree-data").textContent);
  const canvas = document.getElementById("tree");
  const pen = canvas.getContext("2d");
  const said = document.getElementById("picked");
  const points = [data.root, ...data.vessels.flatMap((v) => v.points)];
  const low = [0, 1, 2].map((k) => Math.min(...points.map((p) => p[k])));
  const high = [0, 1, 2].map((k) => Math.max(...points.map((p) => p[k])));
  const middle = low.map((value, k) => (value + high[k]) / 2);
  const size = Math.max(...high.map((value, k) => value - low[k]));
  // Rows: right, down, away from the viewer. At first x points right and z up, as in the first projection.
  let turn = [[1, 0, 0], [0, 0, -1], [0, 1, 0]];
  let zoom = 1, chosen = null, drag = null, moved = false;

  const times = (a, b) => a.map((row) => [0, 1, 2].map((j) => row[0] * b[0][j] + row[1] * b[1][j] + row[2] * b[2][j]));
  function rotate(yaw, pitch) {
    const [a, b, c, d] = [Math.cos(yaw), Math.sin(yaw), Math.cos(pitch), Math.sin(pitch)];
    turn = times([[1, 0, 0], [0, c, -d], [0, d, c]], times([[a, 0, b], [0, 1, 0], [-b, 0, a]], turn));
  }

  function unit() { return (0.88 * Math.min(canvas.clientWidth, canvas.clientHeight) * zoom) / size; }

  function seen(p) {
    const d = [p[0] - middle[0], p[1] - middle[1], p[2] - middle[2]];
    const [x, y, z] = turn.map((row) => row[0] * d[0] + row[1] * d[1] + row[2] * d[2]);
    return [canvas.clientWidth / 2 + unit() * x, canvas.clientHeight / 2 + unit() * y, z];
  }

  function shade(depth, strong, doubted) {
    const far = Math.min(1, Math.max(0, depth / size + 0.5));
    const mix = (near, away) => Math.round(near + (away - near) * 0.75 * far);
    if (doubted && !strong) return `rgb(${mix(217, 245)},${mix(95, 205)},${mix(2, 170)})`;
    return strong ? "rgb(214,37,155)" : `rgb(${mix(0, 205)},${mix(92, 225)},${mix(112, 230)})`;
  }

  function draw() {
    const ratio = window.devicePixelRatio || 1;
    canvas.width = canvas.clientWidth * ratio;
    canvas.height = canvas.clientHeight * ratio;
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    pen.lineCap = "round";
    const pieces = [];
    data.vessels.forEach((vessel) => {
      const at = vessel.points.map(seen);
      for (let i = 1; i < at.length; i++) {
        const radius = (vessel.points[i - 1][3] + vessel.points[i][3]) / 2;
        pieces.push([(at[i - 1][2] + at[i][2]) / 2, at[i - 1], at[i], Math.max(1, 2 * radius * unit()), vessel]);
      }
    });
    pieces.sort((a, b) => b[0] - a[0]);
    for (const [depth, a, b, width, vessel] of pieces) {
      pen.strokeStyle = shade(depth, vessel === (chosen && chosen.vessel), vessel.doubts);
      pen.lineWidth = width;
      pen.beginPath();
      pen.moveTo(a[0], a[1]);
      pen.lineTo(b[0], b[1]);
      pen.stroke();
    }
    const [outside, inlet] = [seen(data.root), seen(data.vessels[0].points[0])];
    pen.strokeStyle = "#d6259b";
    pen.lineWidth = 1;
    pen.setLineDash([4, 4]);
    pen.beginPath();
    pen.moveTo(outside[0], outside[1]);
    pen.lineTo(inlet[0], inlet[1]);
    pen.stroke();
    pen.setLineDash([]);
    spot(outside, "#d6259b", 5);
    data.vessels.filter((v) => v.terminal).forEach((v) => spot(seen(v.points[v.points.length - 1]), "#b26a00", 3));
    data.doubts.forEach((p) => cross(seen(p)));
    if (chosen) spot(seen(chosen.point), "#000000", 5);
    pen.fillStyle = "#37474f";
    pen.font = "12px sans-serif";
    const bar = Math.pow(10, Math.floor(Math.log10(size / zoom / 2)));
    pen.fillRect(12, canvas.clientHeight - 14, bar * unit(), 2);
    pen.fillText(`${bar} cm`, 12, canvas.clientHeight - 20);
  }

  function spot(at, color, radius) {
    pen.fillStyle = color;
    pen.beginPath();
    pen.arc(at[0], at[1], radius, 0, 7);
    pen.fill();
  }

  function cross(at) {
    pen.strokeStyle = "#000000";
    pen.lineWidth = 2;
    pen.beginPath();
    for (const side of [-1, 1]) {
      pen.moveTo(at[0] - 6, at[1] - 6 * side);
      pen.lineTo(at[0] + 6, at[1] + 6 * side);
    }
    pen.stroke();
  }

  function nearest(x, y) {
    let best = null, least = 14;
    data.vessels.forEach((vessel) => vessel.points.forEach((point, i) => {
      const at = seen(point);
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
    draw();
  }

  canvas.addEventListener("pointerdown", (event) => {
    drag = [event.offsetX, event.offsetY];
    moved = false;
    canvas.setPointerCapture(event.pointerId);
  });
  canvas.addEventListener("pointermove", (event) => {
    if (!drag) return;
    const [dx, dy] = [event.offsetX - drag[0], event.offsetY - drag[1]];
    if (!moved && Math.hypot(dx, dy) < 4) return;
    moved = true;
    rotate(-dx * 0.01, -dy * 0.01);
    drag = [event.offsetX, event.offsetY];
    draw();
  });
  canvas.addEventListener("pointerup", (event) => {
    if (drag && !moved) pick(event.offsetX, event.offsetY);
    drag = null;
  });
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    zoom = Math.min(30, Math.max(0.5, zoom * Math.exp(-event.deltaY * 0.001)));
    draw();
  }, { passive: false });
  canvas.addEventListener("keydown", (event) => {
    const step = { ArrowLeft: [0.1, 0], ArrowRight: [-0.1, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1] }[event.key];
    if (step) rotate(...step);
    else if (event.key === "+" || event.key === "-") zoom *= event.key === "+" ? 1.2 : 1 / 1.2;
    else return;
    event.preventDefault();
    draw();
  });
  document.querySelectorAll("button[data-edit]").forEach((button) => button.addEventListener("click", () => {
    const kind = button.dataset.edit;
    const text = document.getElementById(kind === "outlet" ? "outlets" : "edits");
    text.value += kind === "outlet" ? `${place(chosen.point, ",")}\n` : `${kind} ${place(chosen.point, " ")}\n`;
  }));
  document.getElementById("all-outlets").addEventListener("click", () => {
    const ends = data.vessels.filter((v) => v.terminal).map((v) => v.points[v.points.length - 1]);
    document.getElementById("outlets").value += ends.map((p) => `${place(p, ",")}\n`).join("");
  });
  window.addEventListener("resize", draw);
  draw();
})();
