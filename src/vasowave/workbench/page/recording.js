// @ts-check
// The Recording desk: hours of signals, beats with their fate, a stretch, the zero; the average beside changes at once.
/** @import { RecordingAnswer, StudyAnswer } from "./answers.d.ts" */
/** @import { Span, Trace } from "./timeline.js" */
import { act, ask, complain, notify, numbers } from "./ask.js";
import { button, choice, count, fill, h, rowOf, visit } from "./dom.js";
import { remedyOf } from "./findings.js";
import { listenToHand } from "./hand.js";
import { drawMarks, readingOf } from "./marks.js";
import { MODEL, watched } from "./plot.js";
import { drawAverage, drawSignals, drawStrip } from "./signals.js";
import {
    averagedWindow,
    centered,
    clamped,
    editOf,
    middleOf,
    spanOf,
    suffices,
    undecided,
    unmoved,
    wider,
} from "./timeline.js";
import { cellsIn, commentsIn, findingsIn, indicesIn, toolsIn } from "./tools.js";

/**
 * @typedef {object} Parts elements of the desk
 * @property {HTMLCanvasElement} canvas
 * @property {HTMLCanvasElement} strip
 * @property {{ pressure: HTMLCanvasElement, flow: HTMLCanvasElement }} average
 * @property {Record<"reading" | "tools" | "comments" | "numbers" | "findings" | "cells" | "error" | "side", HTMLElement>} boxes
 *
 * @typedef {object} RecordingState
 * @property {RecordingAnswer} recording
 * @property {Span} view window that is shown; it ends at 0 until there is one
 * @property {Span | null} stretch that is picked
 * @property {number} beat that is picked, -1: none
 * @property {number | null} carried where the picked beat is being moved to
 * @property {Span | null} ends of the stretch that is averaged, while one of them is being moved
 * @property {number | null} pointer time under the pointer
 * @property {number | null} mark time from which differences are read
 * @property {string} cells that `traces` were read with
 * @property {Record<string, Trace>} traces
 * @property {Float32Array | null} overview
 * @property {Parts | null} parts
 * @property {AbortController | null} asking
 * @property {boolean} undrawn
 */

/** @type {RecordingAnswer} */
const NONE = { animal: "", cells: {}, drift: "", kind: "", edits: [], error: "", labels: {}, units: {} };

/** @type {RecordingState} */
const state = {
    recording: NONE,
    view: [0, 0],
    stretch: null,
    beat: -1,
    carried: null,
    ends: null,
    pointer: null,
    mark: null,
    cells: "",
    traces: {},
    overview: null,
    parts: null,
    asking: null,
    undrawn: false,
};
const KEYS = ["←", "→", "+", "−", "n", "p", "x", "[", "]", "b", "e", "m"];

/**
 * @param {HTMLElement} place
 * @param {string[]} path
 */
export async function show(place, path) {
    const study = /** @type {Partial<StudyAnswer>} */ (await ask("study"));
    if (!place.isConnected) return; // another desk or animal is wanted by now
    const names = (study.rows || []).map((row) => row.animal);
    Object.assign(state, { traces: {}, cells: "", overview: null, stretch: null, beat: -1, mark: null, view: [0, 0] });
    if (!names.length) {
        Object.assign(state, { recording: NONE, parts: null });
        fill(
            place,
            h("h1", {}, "Recording"),
            h("p", {}, "No animals yet: "),
            h("a", { href: "#study" }, "drop their files on the Study desk."),
        );
        return;
    }
    const animal = names.includes(path[0]) ? path[0] : names[0];
    const recording = /** @type {RecordingAnswer} */ (await ask("recording", { animal }));
    if (!place.isConnected) return;
    const parts = state.parts = partsOf();
    layOut(place, parts, names, animal);
    listenToHand(parts.canvas, parts.strip, state, { look, pick, toggle, move, change, later, tools });
    watched(parts.canvas, draw);
    watched(parts.strip, draw);
    for (const canvas of Object.values(parts.average)) watched(canvas, average);
    await present(recording, parts);
}

/** @returns {Parts} */
function partsOf() {
    const canvas = (/** @type {string} */ name, /** @type {string} */ text, more = {}) =>
        h("canvas", { class: name, ...more, role: "img", "aria-label": text });
    const average = {
        pressure: canvas("panel", "averaged cycle of pressure"),
        flow: canvas("panel", "averaged cycle of flow"),
    };
    const numbers = h("div", { class: "numbers" }), findings = h("div");
    return {
        canvas: canvas("signals", "signals; arrow keys scroll, + and − zoom", { tabindex: 0 }),
        strip: canvas("overview", "the whole recording; drag or arrow keys move the window", { tabindex: 0 }),
        average,
        boxes: {
            reading: h("p", { class: "reading", data: { key: "reading" } }),
            tools: h("div"),
            comments: h("div"),
            numbers,
            findings,
            cells: h("div"),
            error: h("div"),
            side: h("section", { "aria-label": "average" }, numbers, average.pressure, average.flow, findings),
        },
    };
}

/**
 * @param {HTMLElement} place
 * @param {Parts} parts
 * @param {string[]} names
 * @param {string} animal
 */
function layOut(place, { canvas, strip, boxes }, names, animal) {
    const row = names.indexOf(animal), go = (/** @type {string} */ name) => visit("recording", name);
    const key = (/** @type {string} */ color, /** @type {string} */ text) => {
        const mark = h("i", { class: "beat" });
        mark.style.background = color;
        return [mark, ` ${text} `];
    };
    fill(
        place,
        rowOf(
            h("h1", {}, "Recording of "),
            choice(names, animal, go, { "aria-label": "animal", data: { key: "animal" } }),
            button("‹ previous", () => go(names[row - 1]), { disabled: row === 0 }),
            button("next ›", () => go(names[row + 1]), { disabled: row === names.length - 1 }),
        ),
        boxes.error,
        h(
            "div",
            { class: "two" },
            h(
                "section",
                { "aria-label": "signals" },
                canvas,
                boxes.reading,
                strip,
                boxes.tools,
                boxes.comments,
                h(
                    "p",
                    { class: "keys" },
                    key(MODEL, "averaged"),
                    key("", "good, not needed"),
                    key("var(--alarm-edge)", "rejected"),
                    key("var(--shade)", "outside the stretch"),
                    key("var(--picked)", "picked"),
                ),
                h(
                    "p",
                    { class: "keys" },
                    "Drag: a stretch, a grip where the averaging begins or ends, or the bold line where the picked " +
                        "beat begins. Click: a beat. Wheel: zoom, with Shift: scroll. Keys: ",
                    KEYS.map((name) => [h("kbd", {}, name), " "]),
                    "scroll, zoom, next and previous beat, reject or restore, earlier and later by 1 ms, begin and " +
                        "end of a stretch at the middle, a mark from which differences are read.",
                ),
            ),
            boxes.side,
        ),
        boxes.cells,
    );
}

/**
 * @param {HTMLElement} place
 * @param {string[]} path
 */
export async function renew(place, path) {
    const animal = path[0] || state.recording.animal;
    if (!animal || !state.parts) return show(place, path);
    const recording = /** @type {RecordingAnswer} */ (await ask("recording", { animal }));
    if (place.isConnected && state.parts) await present(recording, state.parts);
}

/**
 * @param {RecordingAnswer} recording
 * @param {Parts} parts
 */
async function present(recording, { boxes }) {
    const cells = JSON.stringify(recording.cells);
    state.recording = recording;
    if (recording.duration && !state.view[1]) state.view = averagedWindow(recording);
    if (recording.duration && state.cells !== cells) Object.assign(state, { cells, traces: {}, overview: null });
    const remedies = (recording.remedies ?? []).map(remedyOf);
    fill(boxes.error, recording.error ? h("div", { class: "finding bad" }, recording.error, remedies) : null);
    average();
    tools();
    commentsIn(boxes.comments, recording, { look: (time) => look(...centered(state.view, time)), change });
    cellsIn(boxes.cells, recording);
    indicesIn(boxes.numbers, recording);
    findingsIn(boxes.findings, recording);
    count(document.body, "told");
    if (recording.duration) {
        await overview(recording.duration);
        draw();
    }
}

function average() {
    if (state.parts) drawAverage(state.parts.average, state.recording);
}

// Signals: what is near is fetched once, and drawn while more is on its way.

/** @param {number} duration */
async function overview(duration) {
    const { parts, recording: { animal, signals = [] }, cells } = state;
    if (state.overview || !parts || !signals.length) return;
    const width = Math.max(200, parts.strip.clientWidth);
    const values = await numbers("trace", { animal, signal: signals[0], start: 0, end: duration, width });
    if (cells === state.cells && animal === state.recording.animal) state.overview = values;
}

async function fetchNear() {
    const { parts, view, cells, recording: { animal, duration = 0, signals = [] } } = state;
    if (!parts) return;
    const width = Math.max(200, parts.canvas.clientWidth);
    if (suffices(state.traces[signals[0]], view, duration, width)) return;
    state.asking?.abort();
    const { signal } = state.asking = new AbortController();
    const { start, end, count, each } = wider(view, duration, width);
    try {
        const answers = await Promise.all(
            signals.map((name) => numbers("trace", { animal, start, end, width: count, signal: name }, signal)),
        );
        if (state.cells !== cells) return;
        signals.forEach((name, k) => {
            state.traces[name] = { start, end, each, count, values: answers[k] };
        });
        later();
    } catch (error) {
        if (!(error instanceof DOMException && error.name === "AbortError")) complain(error);
    }
}

function later() {
    if (state.undrawn) return;
    state.undrawn = true;
    requestAnimationFrame(() => {
        const { parts, view, overview, recording } = state;
        state.undrawn = false;
        if (!parts?.canvas.isConnected) return;
        drawSignals(parts.canvas, state);
        drawMarks(parts.canvas, state);
        if (overview) drawStrip(parts.strip, overview, view, recording);
        parts.boxes.reading.textContent = readingOf(state);
    });
}

function draw() {
    if (!state.recording.duration || !state.view[1] || !state.parts || state.parts.canvas.clientWidth < 80) return;
    later();
    fetchNear();
}

/**
 * @param {number} from
 * @param {number} to
 */
function look(from, to) {
    state.view = clamped(from, to, state.recording.duration ?? 0);
    draw();
}

/** For measurements and tests: look at a stretch of the recording. */
export const lookAt = look;

/** @param {number} k */
function pick(k) {
    const { recording: { beats }, view } = state;
    state.beat = beats && k >= 0 && k < beats.starts.length ? k : -1;
    if (beats && state.beat >= 0) {
        const [start, end] = spanOf(beats, k);
        if (start < view[0] || end > view[1]) look(...centered(view, (start + end) / 2));
    }
    tools();
    later();
}

// Edits.

/**
 * Change something of this animal; until its average is computed anew the old numbers are pale.
 * @param {string} action
 * @param {object} values
 * @param {boolean} [quiet]
 */
async function change(action, values, quiet = false) {
    const { parts, recording: { animal } } = state;
    parts?.boxes.side.classList.add("old-numbers");
    await act(action, { animal, ...values }, quiet);
    parts?.boxes.side.classList.remove("old-numbers");
}

/** Reject the picked beat, keep it, or forget what was decided on it. */
function toggle() {
    const { recording, beat } = state, { beats } = recording;
    if (beat < 0 || !beats) return;
    const edit = editOf(recording, beats, beat), action = beats.rejected[beat] ? "keep" : "reject";
    change("edit-beats", edit ? { forget: [edit[1]] } : { edits: [[action, middleOf(beats, beat), null]] });
}

/**
 * Move the start of the picked beat.
 * @param {number} seconds
 */
function move(seconds) {
    const { recording, beat } = state, start = recording.beats?.starts[beat];
    if (beat < 0 || start === undefined) return Promise.resolve();
    return change("edit-beats", { edits: [["move", unmoved(recording, start), start + seconds]] }, true);
}

/**
 * Reject or keep the beats of the picked stretch.
 * @param {"reject" | "keep"} action
 */
async function judge(action) {
    const { recording: { beats }, stretch } = state;
    if (!beats || !stretch) return;
    const edits = undecided(beats, stretch, action).map((k) => [action, middleOf(beats, k), null]);
    if (edits.length) await change("edit-beats", { edits });
    else notify(`No beat there is to ${action}.`);
}

function tools() {
    if (state.parts) toolsIn(state.parts.boxes.tools, state, { look, pick, toggle, move, judge, change, focus });
}

function focus() {
    state.parts?.canvas.focus({ preventScroll: true });
}
