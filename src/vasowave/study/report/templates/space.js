// Networks in space: choose a network and a quantity as color, turn it, pick a vessel and see its waveforms.
document.querySelectorAll("figure.space").forEach((figure) => {
  "use strict";
  const data = JSON.parse(figure.querySelector("script").textContent);
  const part = (name) => figure.querySelector(`[data-part="${name}"]`);
  const [which, colored, said, plot] = ["network", "quantity", "said", "waveforms"].map(part), moment = part("moment");
  figure.hidden = false;
  let shown = null, view = null, range = [0, 1], chosen = 0;

  const digits = (value) => (value === null ? "not known" : String(Number(value.toPrecision(3))));
  const mix = (share) => {
    const at = Math.min(0.9999, Math.max(0, share)) * (data.stops.length - 1), k = Math.floor(at);
    return `rgb(${[0, 1, 2].map((i) => Math.round(data.stops[k][i] + (at - k) * (data.stops[k + 1][i] - data.stops[k][i])))})`;
  };
  const WAVES = [["pressure over the cycle [mmHg]", "pressure"], ["flow over the cycle [ml/s]", "flow"]];
  const wave = () => WAVES[colored.selectedIndex - shown.quantities.length];
  const sample = () => Math.round(moment.value * (shown.pressure[0].length - 1));
  const values = () => (wave() ? shown[wave()[1]].map((row) => row[sample()]) : shown.quantities[colored.selectedIndex].values);
  const color = (row) => (values()[row] === null ? "#9e9e9e" : mix((values()[row] - range[0]) / (range[1] - range[0] || 1)));

  function draw(view) {
    const ink = getComputedStyle(figure).color;
    const pieces = shown.axes.map(([from, to], row) => [view.seen(from), view.seen(to), row]);
    pieces.sort((a, b) => b[0][2] + b[1][2] - a[0][2] - a[1][2]);
    for (const [from, to, row] of pieces) {
      const width = Math.max(2, 2 * shown.radius[row] * view.unit());
      view.line(from, to, width + (row === chosen ? 5 : 1.5), ink);
      view.line(from, to, width, color(row));
    }
    view.scaleBar(ink);
  }

  function nearest(x, y) {
    let best = -1, least = 16;
    shown.axes.forEach(([from, to], row) => {
      const [a, b] = [view.seen(from), view.seen(to)], d = [b[0] - a[0], b[1] - a[1]];
      const share = Math.min(1, Math.max(0, ((x - a[0]) * d[0] + (y - a[1]) * d[1]) / (d[0] ** 2 + d[1] ** 2 || 1)));
      const gap = Math.hypot(a[0] + share * d[0] - x, a[1] + share * d[1] - y);
      if (gap < least) { least = gap; best = row; }
    });
    return best;
  }

  function panel(rows, top, label) {
    const own = rows[chosen], both = [...own, ...rows[0]];
    const [low, high] = [Math.min(...both), Math.max(...both)];
    const path = (row) => [...row, row[0]].map((value, k) =>
      `${k ? "L" : "M"}${(56 + 240 * k / row.length).toFixed(1)},${(top + 92 - 84 * (value - low) / (high - low || 1)).toFixed(1)}`).join("");
    const step = 10 ** (Math.floor(Math.log10(high - low || 1)) - 2);  // long numbers would leave the panel
    const short = (value) => (value && Math.abs(value) < 0.01 ? value.toExponential(1) : digits(value));
    const end = (value) => short(Math.round(value / step) * step || 0);
    return `<path d="${path(rows[0])}" stroke="#9e9e9e"/><path d="${path(own)}" stroke="currentColor" stroke-width="2"/>` +
      `<text x="52" y="${top + 14}" text-anchor="end">${end(high)}</text><text x="52" y="${top + 94}" text-anchor="end">${end(low)}</text>` +
      `<text x="56" y="${top + 4}">${label}</text>`;
  }

  function tell() {
    said.textContent = `Vessel ${shown.names[chosen]}: radius ${digits(shown.radius[chosen])} cm; ` +
      shown.quantities.map((one) => `${one.label.replace(/ \[(.*)\]/, "")} ${digits(one.values[chosen])}` +
        (/\[1\]/.test(one.label) ? "" : ` ${one.label.match(/\[(.*)\]/)[1]}`)).join("; ");
    plot.innerHTML = panel(shown.pressure, 12, "pressure [mmHg]") + panel(shown.flow, 128, "flow [ml/s]") +
      `<text x="296" y="238" text-anchor="end">${digits(shown.period)} s</text><text x="56" y="238">0</text>`;
  }

  function repaint() {
    const known = (wave() ? shown[wave()[1]].flat() : values()).filter((value) => value !== null);
    moment.parentElement.hidden = !wave();
    part("when").textContent = `${digits(shown.period * sample() / shown.pressure[0].length)} s`;
    range = [Math.min(...known), Math.max(...known)];
    part("bar").style.background = `linear-gradient(to right, ${data.stops.map((stop) => `rgb(${stop})`).join(", ")})`;
    [part("low").textContent, part("high").textContent] = range.map(digits);
    view.redraw();
  }

  function pick(x, y) {
    const row = nearest(x, y);
    if (row >= 0) chosen = row;
    tell();
    view.redraw();
  }

  function show() {
    shown = data.networks[which.selectedIndex];
    chosen = 0;
    const before = colored.selectedIndex;
    colored.replaceChildren(...[...shown.quantities.map((one) => one.label), ...WAVES.map(([label]) => label)].map((label) => new Option(label)));
    colored.selectedIndex = Math.max(0, before);
    const fresh = part("canvas").cloneNode();  // without the listeners of the network before
    part("canvas").replaceWith(fresh);
    view = turntable(fresh, shown.axes.flat(), draw, pick);
    view.rotate(0.5, 0.3);  // so that it is seen to be no plane
    tell();
    repaint();
  }

  which.replaceChildren(...data.networks.map((one) => new Option(one.label)));
  which.parentElement.hidden = data.networks.length < 2;
  which.addEventListener("change", show);
  colored.addEventListener("change", repaint);
  moment.addEventListener("input", repaint);
  show();
});
