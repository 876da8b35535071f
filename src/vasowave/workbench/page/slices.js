// Three slices through an image of 16 bits, with its window, what is above the threshold, and the tree over them.
import { sheet, style } from "./plot.js";

/** The axes of the three views: which of x, y, z runs right, which down (-1: up), and which is looked along. */
export const VIEWS = [
  { name: "along z", right: 0, down: 1, up: 1, through: 2 },
  { name: "along y", right: 0, down: 2, up: -1, through: 1 },
  { name: "along x", right: 1, down: 2, up: -1, through: 0 },
];
const LUMEN = [0, 167, 196];

/** Read what the server sends: a line about the image, then its grey levels, x fastest. */
export function volume(buffer) {
  const bytes = new Uint8Array(buffer), end = bytes.indexOf(10);
  const about = JSON.parse(new TextDecoder().decode(bytes.subarray(0, end)));
  const turned = (list) => [...list].reverse();  // z, y, x on the wire; x, y, z here
  const levels = new Uint16Array(buffer.slice(end + 1)), shape = turned(about.shape);
  return { levels, shape, spacing: turned(about.spacing), origin: turned(about.origin), low: about.low, high: about.high, threshold: about.threshold,
    voxels: turned(about.voxels), voxel: turned(about.voxel), stride: [1, shape[0], shape[0] * shape[1]] };
}

const inside = (image, place) => place.map((value, k) =>
  Math.min(image.shape[k] - 1, Math.max(0, Math.round((value - image.origin[k]) / image.spacing[k]))));
export const extent = (image, k) => [image.origin[k] - image.spacing[k] / 2, image.origin[k] + (image.shape[k] - 0.5) * image.spacing[k]];

/** Where a view stands in its canvas: pixels of a place, and the place of pixels at the depth of `at`. */
export function frame(canvas, image, view) {
  const [left, right] = extent(image, view.right), [top, bottom] = extent(image, view.down);
  const scale = Math.min(canvas.clientWidth / (right - left), canvas.clientHeight / (bottom - top));
  const x0 = (canvas.clientWidth - scale * (right - left)) / 2, y0 = (canvas.clientHeight - scale * (bottom - top)) / 2;
  const px = (place) => [x0 + scale * (place[view.right] - left),
    y0 + scale * (view.up > 0 ? place[view.down] - top : bottom - place[view.down])];
  const place = (x, y, at) => {
    const found = [...at];
    found[view.right] = Math.min(right, Math.max(left, left + (x - x0) / scale));
    found[view.down] = Math.min(bottom, Math.max(top, view.up > 0 ? top + (y - y0) / scale : bottom - (y - y0) / scale));
    return found;
  };
  return { px, place, scale, box: [x0, y0, scale * (right - left), scale * (bottom - top)] };
}

/** Draw one slice through `at`, grey levels from `dark` to `bright`; what is above the threshold is tinted. */
export function drawSlice(canvas, image, view, { at, dark, bright, threshold, tint, vessels, chosen, marks }) {
  const { pen, width, height } = sheet(canvas), seen = frame(canvas, image, view);
  const [columns, rows] = [image.shape[view.right], image.shape[view.down]];
  const depth = inside(image, at)[view.through] * image.stride[view.through];
  const level = (grey) => (grey - image.low) / (image.high - image.low || 1) * 65535;
  const [from, to, wall] = [level(dark), level(bright), level(threshold)], gain = 255 / Math.max(1, to - from);
  const pixels = new ImageData(columns, rows);
  for (let row = 0; row < rows; row++) {
    const start = depth + (view.up > 0 ? row : rows - 1 - row) * image.stride[view.down];
    for (let column = 0; column < columns; column++) {
      const value = image.levels[start + column * image.stride[view.right]], grey = (value - from) * gain, k = 4 * (row * columns + column);
      const share = tint && value >= wall ? 0.35 : 0;
      for (let c = 0; c < 3; c++) pixels.data[k + c] = (1 - share) * Math.min(255, Math.max(0, grey)) + share * LUMEN[c];
      pixels.data[k + 3] = 255;
    }
  }
  const whole = new OffscreenCanvas(columns, rows);
  whole.getContext("2d").putImageData(pixels, 0, 0);
  pen.fillStyle = "#000";
  pen.fillRect(0, 0, width, height);
  pen.imageSmoothingEnabled = false;
  pen.drawImage(whole, ...seen.box);
  pen.lineWidth = 1;
  for (const vessel of vessels) {
    pen.strokeStyle = vessel.name === chosen ? "#ff4fc3" : vessel.doubts.length ? "#ff9d2e" : "#ffe14d";
    for (let k = 1; k < vessel.points.length; k++) {
      const [a, b] = [vessel.points[k - 1], vessel.points[k]];
      const near = Math.abs((a[view.through] + b[view.through]) / 2 - at[view.through]) < Math.max(b[3], image.spacing[view.through]);
      pen.globalAlpha = near ? 1 : 0.5;
      pen.lineWidth = near ? 2.2 : 1;
      pen.beginPath(); pen.moveTo(...seen.px(a)); pen.lineTo(...seen.px(b)); pen.stroke();
    }
  }
  pen.globalAlpha = 1;
  for (const [place, color] of marks) { pen.fillStyle = color; pen.beginPath(); pen.arc(...seen.px(place), 4, 0, 7); pen.fill(); }
  const [x, y] = seen.px(at);
  pen.strokeStyle = "#ffffff"; pen.lineWidth = 1; pen.globalAlpha = 0.55;
  pen.beginPath(); pen.moveTo(x, 0); pen.lineTo(x, height); pen.moveTo(0, y); pen.lineTo(width, y); pen.stroke();
  pen.globalAlpha = 1;
  pen.fillStyle = "#fff"; pen.textAlign = "left"; pen.textBaseline = "top";
  pen.fillText(`${view.name}, ${"xyz"[view.through]} = ${at[view.through].toFixed(3)} cm`, 5, 4);
  canvas.style.borderColor = style("--line");
  canvas.dataset.drawn = String(Number(canvas.dataset.drawn || 0) + 1);
}
