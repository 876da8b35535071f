// @ts-check
// Windows of time, what is fetched of signals, and beats: numbers only, all times in s.
/** @import { Beats, RecordingAnswer } from "./answers.d.ts" */

/** @typedef {[number, number]} Span */

/**
 * @typedef {object} Trace a signal in `count` equal pieces of `start` to `end`
 * @property {number} start
 * @property {number} end
 * @property {number} each length of a piece
 * @property {number} count
 * @property {Float32Array} values lowest of every piece, then highest
 */

const MARGIN = 0.02, SHORTEST = 0.05, MOST_PIXELS = 4000, MS = 1e-3;

/**
 * The stretch that is averaged with a margin, within the recording.
 * @param {{ from?: number, to?: number, duration?: number }} recording
 * @returns {Span}
 */
export function averagedWindow({ duration = 0, from = 0, to = duration }) {
    const margin = MARGIN * (to - from);
    return [Math.max(0, from - margin), Math.min(duration, to + margin)];
}

/**
 * The stretch that is averaged with one of its ends moved to a time: to the millisecond, within the recording, and not
 * too short.
 * @param {Span} stretch
 * @param {0 | 1} side
 * @param {number} time
 * @param {number} duration
 * @returns {Span}
 */
export function withEnd([start, end], side, time, duration) {
    const round = (/** @type {number} */ value) => Math.round(value / MS) * MS;
    return side
        ? [start, Math.min(duration, Math.max(start + SHORTEST, round(time)))]
        : [Math.max(0, Math.min(end - SHORTEST, round(time))), end];
}

/**
 * A window within the recording that is not too short.
 * @param {number} from
 * @param {number} to
 * @param {number} duration
 * @returns {Span}
 */
export function clamped(from, to, duration) {
    const span = Math.min(duration, Math.max(SHORTEST, to - from));
    const start = Math.min(Math.max(0, from), duration - span);
    return [start, start + span];
}

/**
 * A window of the same length about a time.
 * @param {Span} view
 * @param {number} middle
 * @returns {Span}
 */
export function centered([start, end], middle) {
    const half = (end - start) / 2;
    return [middle - half, middle + half];
}

/**
 * A window with its length times a factor, in which a time stays where it is.
 * @param {Span} view
 * @param {number} factor
 * @param {number} [fixed]
 * @returns {Span}
 */
export const zoomed = ([start, end], factor, fixed = (start + end) / 2) => [
    fixed - (fixed - start) * factor,
    fixed + (end - fixed) * factor,
];

/**
 * Where in an ascending list the last value is that is not above another; -1 before all.
 * @param {number} value
 * @param {readonly number[]} list
 */
export function lastNotAfter(value, list) {
    let [low, high] = [0, list.length];
    while (low < high) {
        const middle = (low + high) >> 1;
        if (list[middle] <= value) low = middle + 1;
        else high = middle;
    }
    return low - 1;
}

/**
 * A time as text, as fine as a window of a length needs it.
 * @param {number} time
 * @param {number} span
 */
export function clock(time, span) {
    const digits = Math.max(0, Math.min(4, 2 - Math.floor(Math.log10(span))));
    if (time < 120 || span < 20) return `${Number(time.toFixed(digits))} s`;
    const seconds = Math.round(time);
    return `${Math.floor(seconds / 60)}:${String(seconds % 60).padStart(2, "0")}`;
}

/**
 * Whether a trace holds a window, about as fine as its pixels.
 * @param {Trace | undefined} trace
 * @param {Span} view
 * @param {number} duration
 * @param {number} width
 */
export function suffices(trace, [start, end], duration, width) {
    if (!trace || trace.start > Math.max(0, start) || trace.end < Math.min(duration, end)) return false;
    const pixel = (end - start) / width;
    return trace.each <= 1.6 * pixel && trace.each >= pixel / 1.6;
}

/**
 * What is fetched for a window: as much again on either side.
 * @param {Span} view
 * @param {number} duration
 * @param {number} width
 */
export function wider([from, to], duration, width) {
    const span = to - from, start = Math.max(0, from - span), end = Math.min(duration, to + span);
    const count = Math.max(2, Math.min(MOST_PIXELS, Math.round((end - start) / span * width)));
    return { start, end, count, each: (end - start) / count };
}

/**
 * The pieces of a trace in a window, from `first` until before `last`, with their lowest and highest value.
 * @param {Trace} trace
 * @param {Span} view
 */
export function extremes({ start, each, count, values }, view) {
    const first = Math.max(0, Math.floor((view[0] - start) / each));
    const last = Math.min(count, Math.ceil((view[1] - start) / each));
    let low = Infinity, high = -Infinity;
    for (let k = first; k < last; k++) {
        if (values[k] < low) low = values[k];
        if (values[count + k] > high) high = values[count + k];
    }
    return { first, last, low, high };
}

/**
 * Where a beat begins and ends.
 * @param {Beats} beats
 * @param {number} k
 * @returns {Span}
 */
export const spanOf = ({ starts, end }, k) => [starts[k], starts[k + 1] ?? end];

/**
 * @param {Beats} beats
 * @param {number} k
 */
export function middleOf(beats, k) {
    const [start, end] = spanOf(beats, k);
    return (start + end) / 2;
}

/**
 * Shares of the beats that are averaged and that are rejected in equal parts of a window; 0 where no beat is.
 * @param {Beats} beats
 * @param {Span} view
 * @param {number} parts
 */
export function fates(beats, [start, end], parts) {
    const averaged = new Float32Array(parts), rejected = new Float32Array(parts), all = new Uint32Array(parts);
    const accepted = new Set(beats.averaged), last = lastNotAfter(end, beats.starts);
    for (let k = Math.max(0, lastNotAfter(start, beats.starts)); k <= last; k++) {
        const part = Math.floor((middleOf(beats, k) - start) / (end - start) * parts);
        if (part < 0 || part >= parts) continue;
        all[part]++;
        if (beats.rejected[k]) rejected[part]++;
        else if (accepted.has(k)) averaged[part]++;
    }
    const share = (/** @type {number} */ beats, /** @type {number} */ part) => all[part] ? beats / all[part] : 0;
    return { averaged: averaged.map(share), rejected: rejected.map(share) };
}

/**
 * Lowest and highest value of a trace at a time; null where it has no sample.
 * @param {Trace | undefined} trace
 * @param {number} time
 * @returns {Span | null}
 */
export function valuesAt(trace, time) {
    const piece = trace ? Math.floor((time - trace.start) / trace.each) : -1;
    if (!trace || piece < 0 || piece >= trace.count || Number.isNaN(trace.values[piece])) return null;
    return [trace.values[piece], trace.values[trace.count + piece]];
}

/**
 * The edit that decides on a beat already, if there is one.
 * @param {Pick<RecordingAnswer, "edits">} recording
 * @param {Beats} beats
 * @param {number} k
 */
export function editOf({ edits }, beats, k) {
    const [start, end] = spanOf(beats, k);
    return edits.find(([action, time]) => action !== "move" && time >= start && time < end);
}

/**
 * Where the beat began that an edit moved to a time; the time itself where none did.
 * @param {Pick<RecordingAnswer, "edits">} recording
 * @param {number} start
 */
export const unmoved = ({ edits }, start) =>
    edits.find(([action, , to]) => action === "move" && Math.abs(Number(to) - start) < MS / 10)?.[1] ?? start;

/**
 * Beats with their middle in a stretch whose fate an action would change.
 * @param {Beats} beats
 * @param {Span} stretch
 * @param {string} action reject or keep
 */
export const undecided = (beats, [start, end], action) =>
    beats.starts.map((_, k) => k).filter((k) =>
        middleOf(beats, k) >= start && middleOf(beats, k) < end &&
        (action === "reject") !== Boolean(beats.rejected[k])
    );

/**
 * Rejected beats by reason.
 * @param {Record<number, string>} causes
 */
export function beatsByCause(causes) {
    /** @type {Map<string, number[]>} */
    const beats = new Map();
    for (const [k, cause] of Object.entries(causes)) beats.set(cause, [...(beats.get(cause) || []), Number(k)]);
    return beats;
}
