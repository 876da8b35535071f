// @ts-check
// Curves on a canvas: axes with round numbers, bands, points, in the colors of the page.
/** @import { Value } from "./answers.d.ts" */

/**
 * @typedef {object} Curve
 * @property {readonly Value[]} x
 * @property {readonly Value[]} y
 * @property {string} [color]
 * @property {number[]} [dash]
 * @property {number} [width] 0: only the band
 * @property {boolean} [points] marks instead of a line
 * @property {number} [size] of a mark
 * @property {boolean} [hollow]
 * @property {{ low: readonly Value[], high: readonly Value[] }} [band]
 *
 * @typedef {object} Frame what lies around the curves, in pixels
 * @property {number} width
 * @property {number} height
 * @property {number} foot
 *
 * @typedef {object} Plot
 * @property {readonly Curve[]} series
 * @property {string} [x] title; without it there are no numbers
 * @property {string} [y]
 * @property {[number, number]} [range] of the ordinate
 * @property {[number, number]} [across] of the abscissa
 * @property {boolean} [log]
 * @property {number} [foot] room below, pixels
 */

/** Color of models, and of what is averaged. */
export const MODEL = "#00a7c4";
const LEFT = 50, TOP = 8, RIGHT = 8, MARK = 3.5;

/** @param {string} name */
export const style = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

/**
 * Make a canvas as sharp as its screen; returns its pen, width and height in CSS pixels.
 * @param {HTMLCanvasElement} canvas
 */
export function sheet(canvas) {
    const [width, height, ratio] = [canvas.clientWidth, canvas.clientHeight, devicePixelRatio || 1];
    if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
        canvas.width = Math.round(width * ratio);
        canvas.height = Math.round(height * ratio);
    }
    const pen = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    pen.clearRect(0, 0, width, height);
    pen.font = "11px system-ui, sans-serif";
    return { pen, width, height };
}

/**
 * Round numbers between two, about so many.
 * @param {number} low
 * @param {number} high
 * @param {number} count
 */
export function ticks(low, high, count) {
    const rough = (high - low) / Math.max(1, count), unit = 10 ** Math.floor(Math.log10(rough));
    const step = unit * ([1, 2, 5, 10].find((digit) => digit * unit >= rough) || 10);
    const values = [];
    for (let value = Math.ceil(low / step - 1e-9) * step; value <= high + step * 1e-9; value += step) {
        values.push(Math.abs(value) < step * 1e-9 ? 0 : value);
    }
    return values;
}

/**
 * 1, 2 and 5 times the powers of ten between two numbers.
 * @param {number} low
 * @param {number} high
 */
export function decades(low, high) {
    const values = [];
    for (let k = Math.floor(Math.log10(low)); k <= Math.ceil(Math.log10(high)); k++) {
        values.push(...[1, 2, 5].map((digit) => digit * 10 ** k).filter((value) => value >= low && value <= high));
    }
    return values;
}

/** @param {number} value */
const label = (value) => String(Number(value.toPrecision(6)));

/** @param {readonly Value[]} list */
const finite = (list) => /** @type {number[]} */ (list.filter((value) => value !== null && Number.isFinite(value)));

/**
 * The range of the ordinate: what is asked for, or room around the values.
 * @param {number[]} values
 * @param {[number, number] | undefined} range
 * @param {boolean} log
 * @returns {[number, number]}
 */
export function ordinate(values, range, log) {
    const [low, high] = range || [Math.min(...values), Math.max(...values)];
    const bottom = log ? Math.max(low, high * 1e-4) : low;
    if (range) return [bottom, high];
    if (log) return [bottom / 1.1, high * 1.1];
    const pad = (high - low || Math.abs(high) || 1) * 0.06;
    return [low - pad, high + pad];
}

/**
 * Where values stand, in pixels; null where there is nothing to draw, or no room.
 * @param {Plot} plot
 * @param {Frame} frame
 */
export function scalesOf({ series, range, across, log = false }, { width, height, foot }) {
    const values = finite(series.flatMap(({ y, band }) => [...y, ...(band ? [...band.low, ...band.high] : [])]));
    const times = finite(series.flatMap(({ x }) => x));
    if (!values.length || width < 80) return null;
    const [low, high] = ordinate(values, range, log);
    const [from, to] = across || [Math.min(...times), Math.max(...times)];
    const scale = log ? Math.log : (/** @type {number} */ value) => value;
    const share = (/** @type {Value} */ value) => (scale(Number(value)) - scale(low)) / (scale(high) - scale(low) || 1);
    return {
        low,
        high,
        from,
        to,
        left: LEFT,
        right: width - RIGHT,
        px: (/** @type {Value} */ value) => LEFT + (Number(value) - from) / (to - from || 1) * (width - LEFT - RIGHT),
        py: (/** @type {Value} */ value) => height - foot - share(value) * (height - foot - TOP),
    };
}

/** @typedef {NonNullable<ReturnType<typeof scalesOf>>} Scales */

/**
 * Draw curves; returns where values stand.
 * @param {HTMLCanvasElement} canvas
 * @param {Plot} wanted
 */
export function plot(canvas, wanted) {
    const { pen, width, height } = sheet(canvas), frame = { width, height, foot: wanted.foot ?? 32 };
    const scales = scalesOf(wanted, frame);
    if (!scales) return null;
    drawAxes(pen, wanted, scales, frame);
    pen.save();
    pen.beginPath();
    pen.rect(LEFT, 0, width - LEFT - RIGHT + 4, height - frame.foot + 2);
    pen.clip();
    for (const curve of wanted.series) {
        if (curve.band) drawBand(pen, curve, scales);
        if (curve.width !== 0) drawCurve(pen, curve, scales);
    }
    pen.restore();
    pen.setLineDash([]);
    return scales;
}

/**
 * @param {CanvasRenderingContext2D} pen
 * @param {Plot} wanted
 * @param {Scales} scales
 * @param {Frame} frame
 */
function drawAxes(pen, { x, y, log = false }, { low, high, from, to, px, py }, { width, height, foot }) {
    pen.fillStyle = style("--quiet");
    pen.strokeStyle = style("--faint");
    pen.lineWidth = 1;
    pen.textAlign = "right";
    pen.textBaseline = "middle";
    for (const value of log ? decades(low, high) : ticks(low, high, (height - foot) / 38)) {
        stroke(pen, [LEFT, py(value)], [width - RIGHT, py(value)]);
        pen.fillText(label(value), LEFT - 5, py(value));
    }
    pen.textAlign = "center";
    pen.textBaseline = "top";
    if (x !== undefined) {
        for (const value of ticks(from, to, (width - LEFT) / 70)) {
            pen.fillText(label(value), px(value), height - foot + 4);
        }
    }
    pen.fillStyle = style("--ink");
    if (x) pen.fillText(x, (LEFT + width) / 2, height - 14);
    pen.textAlign = "left";
    if (y) pen.fillText(y, LEFT + 4, 0);
}

/**
 * @param {CanvasRenderingContext2D} pen
 * @param {Pixels} from
 * @param {Pixels} to
 */
export function stroke(pen, from, to) {
    pen.beginPath();
    pen.moveTo(...from);
    pen.lineTo(...to);
    pen.stroke();
}

/**
 * @param {CanvasRenderingContext2D} pen
 * @param {Curve} curve
 * @param {Scales} scales
 */
function drawBand(pen, { x, band = { low: [], high: [] }, color }, { px, py }) {
    pen.fillStyle = color || style("--ink");
    pen.globalAlpha = 0.18;
    pen.beginPath();
    x.forEach((value, k) => pen[k ? "lineTo" : "moveTo"](px(value), py(band.high[k])));
    [...x].reverse().forEach((value, k) => pen.lineTo(px(value), py(band.low[x.length - 1 - k])));
    pen.fill();
    pen.globalAlpha = 1;
}

/**
 * @param {CanvasRenderingContext2D} pen
 * @param {Curve} curve
 * @param {Scales} scales
 */
function drawCurve(pen, { x, y, color, width, dash, points, hollow, size = MARK }, { px, py }) {
    pen.strokeStyle = pen.fillStyle = color || style("--ink");
    pen.lineWidth = width || 1.6;
    pen.setLineDash(dash || []);
    pen.beginPath();
    let up = true;
    y.forEach((value, k) => {
        const empty = value === null || !Number.isFinite(value);
        if (!empty && points) {
            pen.moveTo(px(x[k]) + size, py(value));
            pen.arc(px(x[k]), py(value), size, 0, 7);
        } else if (!empty) pen[up ? "moveTo" : "lineTo"](px(x[k]), py(value));
        up = empty;
    });
    if (points && hollow) pen.fillStyle = style("--paper");
    if (points) pen.fill();
    if (!points || hollow) pen.stroke();
}

/**
 * Draw again whenever a canvas changes its size, and when the page turns dark or light.
 * @param {HTMLCanvasElement} canvas
 * @param {() => unknown} draw
 */
export function watched(canvas, draw) {
    new ResizeObserver(() => canvas.isConnected && draw()).observe(canvas);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => canvas.isConnected && draw());
    return canvas;
}

/**
 * Write words on a patch of paper, so that they are read on whatever is drawn.
 * @param {CanvasRenderingContext2D} pen
 * @param {string} words
 * @param {[left: number, top: number]} place
 */
export function caption(pen, words, [left, top]) {
    pen.textAlign = "left";
    pen.textBaseline = "top";
    pen.globalAlpha = 0.85;
    pen.fillStyle = style("--paper");
    pen.fillRect(left - 2, top - 2, pen.measureText(words).width + 4, 15);
    pen.globalAlpha = 1;
    pen.fillStyle = style("--ink");
    pen.fillText(words, left, top);
}
