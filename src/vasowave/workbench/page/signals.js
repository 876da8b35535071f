// @ts-check
// Signals on a canvas with their beats, the strip of the whole recording, and the average.
/** @import { Beats, RecordingAnswer, Value } from "./answers.d.ts" */
/** @import { Span, Trace } from "./timeline.js" */
import { count, formatted } from "./dom.js";
import { caption, MODEL, plot, sheet, stroke, style, ticks } from "./plot.js";
import { clock, extremes, fates, lastNotAfter, spanOf } from "./timeline.js";

export const LEFT = 54, RIGHT = 6, FOOT = 18; // pixels
export const GRIP = { half: 5, height: 24 }; // pixels, of what an end of the stretch is moved by
const LINES_A_BEAT = 3; // pixels

/**
 * @typedef {object} SignalScene what is drawn of a recording
 * @property {RecordingAnswer} recording
 * @property {Span} view
 * @property {Span | null} stretch that is picked
 * @property {number} beat that is picked, -1: none
 * @property {number | null} carried where the picked beat is being moved to
 * @property {Span | null} ends of the stretch that is averaged, while one of them is being moved
 * @property {Record<string, Trace>} traces
 *
 * @typedef {object} Band where a signal is drawn
 * @property {number} top
 * @property {number} bottom
 * @property {number} width
 */

/**
 * Pixels of a time, and the time of pixels.
 * @param {Span} view
 * @param {number} width
 */
export const timeScale = ([start, end], width) => ({
    x: (/** @type {number} */ time) => LEFT + (time - start) / (end - start) * (width - LEFT - RIGHT),
    time: (/** @type {number} */ x) => start + (x - LEFT) / (width - LEFT - RIGHT) * (end - start),
});

/**
 * The stretch that is averaged; none where nothing is.
 * @param {Pick<SignalScene, "recording" | "ends">} scene
 * @returns {Span | null}
 */
export const averagedEnds = ({ recording: { from = 0, to }, ends }) => ends ?? (to === undefined ? null : [from, to]);

/**
 * The name of a signal with its unit.
 * @param {Pick<RecordingAnswer, "labels" | "channels">} recording
 * @param {string} signal
 */
export function labelOf({ labels, channels }, signal) {
    const unit = signal === "ecg" && channels?.find(([, , quantity]) => quantity === signal)?.[1];
    return unit ? `${labels[signal]} [${unit}]` : labels[signal];
}

/**
 * @param {HTMLCanvasElement} canvas
 * @param {SignalScene} scene
 */
export function drawSignals(canvas, scene) {
    const { pen, width, height } = sheet(canvas), { recording, view, stretch } = scene, bottom = height - FOOT;
    const signals = recording.signals || [], each = bottom / signals.length, { x } = timeScale(view, width);
    pen.save();
    pen.beginPath();
    pen.rect(LEFT, 0, width - LEFT - RIGHT, bottom);
    pen.clip();
    const ends = averagedEnds(scene);
    if (ends) { // what is not averaged is shaded
        pen.fillStyle = style("--shade");
        pen.globalAlpha = 0.35;
        pen.fillRect(LEFT, 0, x(ends[0]) - LEFT, bottom);
        pen.fillRect(x(ends[1]), 0, width - x(ends[1]), bottom);
        pen.globalAlpha = 1;
    }
    if (recording.beats) drawBeats(pen, scene, recording.beats, { width, bottom });
    if (stretch) {
        pen.fillStyle = style("--picked");
        pen.globalAlpha = 0.3;
        pen.fillRect(x(stretch[0]), 0, x(stretch[1]) - x(stretch[0]), bottom);
        pen.globalAlpha = 1;
    }
    pen.restore();
    signals.forEach((signal, row) => {
        const trace = scene.traces[signal], band = { top: row * each + 4, bottom: (row + 1) * each - 4, width };
        if (trace) drawSignal(pen, trace, view, labelOf(recording, signal), band);
    });
    for (const time of ends ?? []) {
        if (time >= view[0] && time <= view[1]) drawGrip(pen, x(time), bottom);
    }
    pen.fillStyle = style("--quiet");
    pen.textAlign = "center";
    pen.textBaseline = "bottom";
    for (const time of ticks(view[0], view[1], width / 90)) {
        pen.fillText(clock(time, view[1] - view[0]), x(time), height - 2);
    }
    count(canvas);
}

/**
 * What an end of the stretch that is averaged is moved by.
 * @param {CanvasRenderingContext2D} pen
 * @param {number} x pixels
 * @param {number} bottom pixels
 */
function drawGrip(pen, x, bottom) {
    pen.strokeStyle = style("--link");
    pen.lineWidth = 1.5;
    stroke(pen, [x, 0], [x, bottom]);
    pen.fillStyle = style("--link");
    pen.fillRect(x - GRIP.half, 0, 2 * GRIP.half, GRIP.height);
    pen.strokeStyle = style("--paper");
    for (const side of [-1.5, 1.5]) stroke(pen, [x + side, 6], [x + side, GRIP.height - 6]);
    pen.lineWidth = 1;
}

/**
 * @param {CanvasRenderingContext2D} pen
 * @param {Trace} trace
 * @param {Span} view
 * @param {string} label
 * @param {Band} band
 */
function drawSignal(pen, trace, view, label, { top, bottom, width }) {
    const { low, high } = extremes(trace, view);
    pen.textAlign = "left";
    pen.textBaseline = "top";
    if (!(high >= low)) {
        pen.fillStyle = style("--quiet");
        pen.fillText(`${label}: no samples here`, LEFT + 4, top);
        return;
    }
    const pad = 0.08 * (high - low) + 1e-9;
    const y = (/** @type {number} */ value) => bottom - (value - low + pad) / (high - low + 2 * pad) * (bottom - top);
    pen.fillStyle = style("--quiet");
    pen.strokeStyle = style("--faint");
    pen.lineWidth = 1;
    pen.textAlign = "right";
    pen.textBaseline = "middle";
    for (const value of ticks(low, high, (bottom - top + 8) / 32)) {
        stroke(pen, [LEFT, y(value)], [width - RIGHT, y(value)]);
        pen.fillText(String(Number(value.toPrecision(5))), LEFT - 5, y(value));
    }
    pen.save();
    pen.beginPath();
    pen.rect(LEFT, top - 4, width - LEFT - RIGHT, bottom - top + 8);
    pen.clip();
    drawTrace(pen, trace, view, timeScale(view, width).x, y);
    pen.restore();
    caption(pen, label, [LEFT + 4, top - 2]);
}

/**
 * @param {CanvasRenderingContext2D} pen
 * @param {Trace} trace
 * @param {Span} view
 * @param {(time: number) => number} x
 * @param {(value: number) => number} y
 */
function drawTrace(pen, trace, view, x, y) {
    const { first, last } = extremes(trace, view);
    pen.strokeStyle = style("--ink");
    pen.lineWidth = 1.1;
    pen.beginPath();
    let up = true;
    for (let k = first; k < last; k++) {
        const low = trace.values[k], high = trace.values[trace.count + k], gap = Number.isNaN(low);
        const px = x(trace.start + (k + 0.5) * trace.each);
        if (!gap) pen[up ? "moveTo" : "lineTo"](px, y(low));
        if (!gap && high !== low) pen.lineTo(px, y(high));
        up = gap;
    }
    pen.stroke();
}

/**
 * @param {CanvasRenderingContext2D} pen
 * @param {SignalScene} scene
 * @param {Beats} beats
 * @param {{ width: number, bottom: number }} size
 */
function drawBeats(pen, { view, beat, carried }, beats, { width, bottom }) {
    const { starts, rejected } = beats, averaged = new Set(beats.averaged), { x } = timeScale(view, width);
    const first = Math.max(0, lastNotAfter(view[0], starts));
    const last = Math.min(starts.length, lastNotAfter(view[1], starts) + 1);
    if (last - first > width / LINES_A_BEAT) return drawFates(pen, beats, view, { width, bottom });
    for (let k = first; k < last; k++) {
        const [start, end] = spanOf(beats, k), picked = k === beat;
        pen.fillStyle = rejected[k] ? style("--alarm-edge") : MODEL;
        pen.globalAlpha = picked ? 0.4 : rejected[k] ? 0.16 : averaged.has(k) ? 0.2 : 0;
        pen.fillRect(x(start), 0, x(end) - x(start), bottom);
        pen.globalAlpha = picked ? 0.9 : 0.5;
        pen.fillRect(x(picked ? carried ?? start : start) - (picked ? 1.5 : 0.5), 0, picked ? 3 : 1, bottom);
    }
    pen.globalAlpha = 1;
}

/**
 * Where beats are too many to be drawn: how many of them are averaged, and how many rejected.
 * @param {CanvasRenderingContext2D} pen
 * @param {Beats} beats
 * @param {Span} view
 * @param {{ width: number, bottom: number }} size
 */
function drawFates(pen, beats, view, { width, bottom }) {
    const parts = Math.max(1, Math.round((width - LEFT - RIGHT) / LINES_A_BEAT)),
        { averaged, rejected } = fates(beats, view, parts);
    for (let part = 0; part < parts; part++) {
        const left = LEFT + part * LINES_A_BEAT;
        pen.fillStyle = MODEL;
        pen.globalAlpha = 0.2 * averaged[part];
        pen.fillRect(left, 0, LINES_A_BEAT, bottom);
        pen.fillStyle = style("--alarm-edge");
        pen.globalAlpha = 0.3 * rejected[part];
        pen.fillRect(left, 0, LINES_A_BEAT, bottom);
        pen.globalAlpha = rejected[part] && 1; // one rejected beat among hundreds is seen
        pen.fillRect(left, bottom - 4 * rejected[part] - 1, LINES_A_BEAT, 4 * rejected[part] + 1);
    }
    pen.globalAlpha = 1;
}

/**
 * The whole recording's first signal, with the window.
 * @param {HTMLCanvasElement} canvas
 * @param {Float32Array} values lowest, then highest
 * @param {Span} view
 * @param {RecordingAnswer} recording
 */
export function drawStrip(canvas, values, view, { duration = 0, signals = ["pressure"], comments = [] }) {
    const { pen, width, height } = sheet(canvas), half = values.length / 2, finite = values.filter(Number.isFinite);
    const low = Math.min(...finite), high = Math.max(...finite);
    const y = (/** @type {number} */ value) => height - 3 - (value - low) / (high - low || 1) * (height - 6);
    pen.strokeStyle = style("--quiet");
    pen.beginPath();
    for (let k = 0; k < half; k++) {
        if (Number.isNaN(values[k])) continue;
        pen.moveTo(k / half * width, y(values[k]));
        pen.lineTo(k / half * width, y(values[half + k]) - 0.5);
    }
    pen.stroke();
    pen.fillStyle = style("--picked");
    pen.globalAlpha = 0.5;
    const [from, to] = view.map((time) => time / duration * width);
    pen.fillRect(from, 0, Math.max(2, to - from), height);
    pen.fillStyle = style("--ink");
    for (const [time] of comments) pen.fillRect(time / duration * width, 0, 1.5, 7);
    pen.globalAlpha = 1;
    caption(pen, `${signals[0]} of all ${formatted(duration, 4)} s`, [4, height - 13]);
}

/**
 * A cycle by time in ms, with one SD of the beats about it.
 * @param {Value[]} values
 * @param {Value[] | undefined} sd
 * @param {number} period s
 * @param {string} color
 */
export function cycleCurve(values, sd, period, color) {
    const shifted = (/** @type {number} */ sign) =>
        values.map((value, k) => Number(value) + sign * Number(sd?.[k] ?? 0));
    const band = sd && { low: shifted(-1), high: shifted(1) };
    return { x: values.map((_, k) => k / values.length * period * 1000), y: values, color, band, width: 1.8 };
}

/**
 * @param {{ pressure: HTMLCanvasElement, flow: HTMLCanvasElement }} canvases
 * @param {RecordingAnswer} recording
 */
export function drawAverage(canvases, { pressure, flow, sd, period = 0 }) {
    if (!pressure || !flow) {
        sheet(canvases.pressure);
        sheet(canvases.flow);
        return;
    }
    plot(canvases.pressure, {
        series: [cycleCurve(pressure, sd?.pressure, period, style("--ink"))],
        y: "pressure [mmHg], ± 1 SD of the beats",
    });
    plot(canvases.flow, {
        series: [cycleCurve(flow, sd?.flow, period, MODEL)],
        y: "flow [ml/s]",
        x: "time [ms]",
    });
}
