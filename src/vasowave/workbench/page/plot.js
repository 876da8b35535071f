// Curves on a canvas: axes with round numbers, bands, points, in the colors of the page.

export const style = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

/** Make a canvas as sharp as its screen; returns its pen, width and height in CSS pixels. */
export function sheet(canvas) {
  const [width, height, ratio] = [canvas.clientWidth, canvas.clientHeight, devicePixelRatio || 1];
  if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
  }
  const pen = canvas.getContext("2d");
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  pen.clearRect(0, 0, width, height);
  pen.font = "11px system-ui, sans-serif";
  return { pen, width, height };
}

/** Round numbers between two, about so many. */
export function ticks(low, high, count) {
  const rough = (high - low) / Math.max(1, count), unit = 10 ** Math.floor(Math.log10(rough));
  const step = unit * ([1, 2, 5, 10].find((one) => one * unit >= rough) || 10);
  const found = [];
  for (let at = Math.ceil(low / step - 1e-9) * step; at <= high + step * 1e-9; at += step) found.push(Math.abs(at) < step * 1e-9 ? 0 : at);
  return found;
}

const label = (value) => String(Number(value.toPrecision(6)));
const decades = (low, high) => {
  const found = [];
  for (let k = Math.floor(Math.log10(low)); k <= Math.ceil(Math.log10(high)); k++)
    for (const digit of [1, 2, 5]) if (digit * 10 ** k >= low && digit * 10 ** k <= high) found.push(digit * 10 ** k);
  return found;
};

const finite = (list) => list.filter((one) => one !== null && Number.isFinite(one));

/**
 * Draw curves; returns where values stand.
 * series: [{x, y, color, dash, width, points, size, hollow, band: {low, high}}], `range` fixes the ordinate, `log` makes it logarithmic.
 */
export function plot(canvas, { series, x, y, range, across, log = false, foot = 32 }) {
  const { pen, width, height } = sheet(canvas), ink = style("--ink"), quiet = style("--quiet"), line = style("--faint");
  const left = 50, bottom = foot, top = 8, right = 8;
  const ys = finite(series.flatMap((one) => [...one.y, ...(one.band ? [...one.band.low, ...one.band.high] : [])]));
  const xs = finite(series.flatMap((one) => one.x));
  if (!ys.length || width < 80) return null;
  let [low, high] = range || [Math.min(...ys), Math.max(...ys)];
  if (log) low = Math.max(low, high * 1e-4);
  const pad = log ? 0 : (high - low || Math.abs(high) || 1) * 0.06;
  if (!range) { low = log ? low / 1.1 : low - pad; high = log ? high * 1.1 : high + pad; }
  const [from, to] = across || [Math.min(...xs), Math.max(...xs)];
  const scale = log ? Math.log : (value) => value;
  const px = (value) => left + (value - from) / (to - from || 1) * (width - left - right);
  const py = (value) => height - bottom - (scale(value) - scale(low)) / (scale(high) - scale(low) || 1) * (height - bottom - top);
  pen.fillStyle = quiet;
  pen.strokeStyle = line;
  pen.lineWidth = 1;
  pen.textAlign = "right";
  pen.textBaseline = "middle";
  for (const at of log ? decades(low, high) : ticks(low, high, (height - bottom) / 38)) {
    pen.beginPath(); pen.moveTo(left, py(at)); pen.lineTo(width - right, py(at)); pen.stroke();
    pen.fillText(label(at), left - 5, py(at));
  }
  pen.textAlign = "center";
  pen.textBaseline = "top";
  if (x !== undefined) for (const at of ticks(from, to, (width - left) / 70)) pen.fillText(label(at), px(at), height - bottom + 4);
  pen.fillStyle = ink;
  if (x) pen.fillText(x, (left + width) / 2, height - 14);
  pen.textAlign = "left";
  if (y) pen.fillText(y, left + 4, 0);
  pen.save();
  pen.beginPath();
  pen.rect(left, 0, width - left - right + 4, height - bottom + 2);
  pen.clip();
  for (const one of series) {
    if (one.band) {
      pen.fillStyle = one.color || ink;
      pen.globalAlpha = 0.18;
      pen.beginPath();
      one.x.forEach((at, k) => pen[k ? "lineTo" : "moveTo"](px(at), py(one.band.high[k])));
      [...one.x].reverse().forEach((at, k) => pen.lineTo(px(at), py(one.band.low[one.x.length - 1 - k])));
      pen.fill();
      pen.globalAlpha = 1;
    }
    pen.strokeStyle = pen.fillStyle = one.color || ink;
    pen.lineWidth = one.width || 1.6;
    if (one.width === 0) continue;
    pen.setLineDash(one.dash || []);
    pen.beginPath();
    let up = true;
    one.y.forEach((value, k) => {
      if (value === null || !Number.isFinite(value)) { up = true; return; }
      const size = one.size || 3.5;
      if (one.points) { pen.moveTo(px(one.x[k]) + size, py(value)); pen.arc(px(one.x[k]), py(value), size, 0, 7); return; }
      pen[up ? "moveTo" : "lineTo"](px(one.x[k]), py(value));
      up = false;
    });
    if (one.points && one.hollow) pen.fillStyle = style("--paper");
    if (one.points) pen.fill();
    if (!one.points || one.hollow) pen.stroke();
  }
  pen.restore();
  pen.setLineDash([]);
  return { px, py, left, right: width - right };
}

/** Draw again whenever a canvas changes its size, and when the page turns dark or light. */
export function watched(canvas, draw) {
  const seen = new ResizeObserver(() => canvas.isConnected && draw());
  seen.observe(canvas);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => canvas.isConnected && draw());
  return canvas;
}
