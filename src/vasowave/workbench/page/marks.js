// @ts-check
// What stands on top of the signals: comments, the pointer, a mark, and what is read at them.
/** @import { SignalScene } from "./signals.js" */
/** @import { Span } from "./timeline.js" */
import { formatted } from "./dom.js";
import { caption, stroke, style } from "./plot.js";
import { FOOT, labelOf, RIGHT, timeScale } from "./signals.js";
import { valuesAt } from "./timeline.js";

const LETTERS = 28; // of a comment

/**
 * @typedef {object} Cursors
 * @property {number | null} pointer time under the pointer
 * @property {number | null} mark time from which differences are read
 */

/**
 * Draw comments, pointer and mark on signals that are drawn.
 * @param {HTMLCanvasElement} canvas
 * @param {SignalScene & Cursors} scene
 */
export function drawMarks(canvas, scene) {
    const pen = canvas.getContext("2d"), size = { width: canvas.clientWidth, bottom: canvas.clientHeight - FOOT };
    if (!pen) return;
    drawComments(pen, scene, size);
    drawCursors(pen, scene, size);
}

/**
 * A line and the text of each comment, where there is room for it.
 * @param {CanvasRenderingContext2D} pen
 * @param {SignalScene} scene
 * @param {{ width: number, bottom: number }} size
 */
function drawComments(pen, { recording: { comments = [] }, view }, { width, bottom }) {
    const { x } = timeScale(view, width);
    let free = -Infinity;
    pen.strokeStyle = style("--ink");
    pen.setLineDash([5, 4]);
    for (const [time, text] of comments) {
        if (time < view[0] || time > view[1]) continue;
        const left = x(time), words = text.length > LETTERS ? `${text.slice(0, LETTERS - 1)}…` : text;
        stroke(pen, [left, 0], [left, bottom]);
        const long = pen.measureText(words).width, start = Math.min(left + 4, width - RIGHT - long - 4);
        if (start < free) continue;
        caption(pen, words, [start, bottom - 19]);
        free = start + long + 8;
    }
    pen.setLineDash([]);
}

/**
 * The line under the pointer, and the mark.
 * @param {CanvasRenderingContext2D} pen
 * @param {SignalScene & Cursors} scene
 * @param {{ width: number, bottom: number }} size
 */
function drawCursors(pen, { view, pointer, mark }, { width, bottom }) {
    const { x } = timeScale(view, width);
    pen.strokeStyle = style("--ink");
    for (const [time, thickness] of [[pointer, 0.6], [mark, 1.6]]) {
        if (time === null || thickness === null || time < view[0] || time > view[1]) continue;
        pen.lineWidth = thickness;
        stroke(pen, [x(time), 0], [x(time), bottom]);
    }
    pen.lineWidth = 1;
}

/**
 * The values at the pointer, or at the middle of the window, and their differences from the mark; of a window in which
 * a pixel holds many samples, their ranges.
 * @param {SignalScene & Cursors} scene
 */
export function readingOf({ recording, view, pointer, mark, traces }) {
    const time = pointer ?? (view[0] + view[1]) / 2;
    const values = (recording.signals ?? []).map((signal) => {
        const label = labelOf(recording, signal);
        const [, name, unit = ""] = label.match(/^(.*?)(?: \[(.*)\])?$/) ?? ["", label];
        const here = valuesAt(traces[signal], time), there = mark === null ? null : valuesAt(traces[signal], mark);
        return `${name} ${rangeOf(here)}${differenceOf(here, there)} ${unit}`.trim();
    });
    const since = mark === null ? "" : ` (${time < mark ? "" : "+"}${(time - mark).toFixed(4)} s from the mark)`;
    return [`${time.toFixed(4)} s${since}`, ...values].join(", ");
}

/**
 * A value, or the lowest and highest where a pixel holds many samples.
 * @param {Span | null} ends
 */
const rangeOf = (ends) =>
    !ends || formatted(ends[0]) === formatted(ends[1])
        ? formatted(ends?.[0])
        : `${formatted(ends[0])} to ${formatted(ends[1])}`;

/**
 * The difference of two values; none where one of them is a range.
 * @param {Span | null} here
 * @param {Span | null} there
 */
function differenceOf(here, there) {
    if (!here || !there || [here, there].some(([low, high]) => formatted(low) !== formatted(high))) return "";
    const difference = here[0] - there[0];
    return ` (${difference < 0 ? "" : "+"}${formatted(difference, 3)})`;
}
