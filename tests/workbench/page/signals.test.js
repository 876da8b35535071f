// @ts-check
import { deepEqual, equal } from "node:assert/strict";
import { listenToHand } from "../../../src/vasowave/workbench/page/hand.js";
import { readingOf } from "../../../src/vasowave/workbench/page/marks.js";
import { cycleCurve, labelOf, timeScale } from "../../../src/vasowave/workbench/page/signals.js";

Deno.test("times stand between the margins, and pixels have their times", () => {
    const { x, time } = timeScale([10, 20], 160); // 100 pixels from 54
    deepEqual([10, 15, 20].map(x), [54, 104, 154]);
    deepEqual([54, 104, 154].map(time), [10, 15, 20]);
});

Deno.test("an ECG has the unit of its channel, others that of the model", () => {
    /** @type {[string, string, string][]} */
    const channels = [["P", "mmHg", "pressure"], ["E", "mV", "ecg"]];
    const recording = { labels: { pressure: "pressure [mmHg]", ecg: "ECG" }, channels };
    equal(labelOf(recording, "pressure"), "pressure [mmHg]");
    equal(labelOf(recording, "ecg"), "ECG [mV]");
    equal(labelOf({ ...recording, channels: [] }, "ecg"), "ECG");
});

Deno.test("an average has a band of one SD where there is one", () => {
    const curve = cycleCurve([10, 20], [1, 2], 0.5, "red");
    deepEqual(curve.x, [0, 250]);
    deepEqual(curve.band, { low: [9, 18], high: [11, 22] });
    equal(cycleCurve([10, 20], undefined, 0.5, "red").band, undefined);
});

Deno.test("what is read at the pointer is told with its difference from the mark", () => {
    const trace = { start: 0, end: 4, each: 1, count: 4, values: new Float32Array([10, 12, 15, 15, 10, 14, 15, 15]) };
    const labels = { pressure: "pressure [mmHg]", "P 2 [V]": "P 2 [V]" };
    /** @type {any} */
    const scene = { recording: { labels, signals: Object.keys(labels) }, view: [0, 4], traces: { pressure: trace } };
    equal(readingOf({ ...scene, pointer: 1.5, mark: null }), "1.5000 s, pressure 12 to 14 mmHg, P 2 – V");
    equal(
        readingOf({ ...scene, pointer: null, mark: 0.5 }),
        "2.0000 s (+1.5000 s from the mark), pressure 15 (+5) mmHg, P 2 – V",
    );
});

/** A desk over 100 s, 10 pixels a second from 54 on, with four beats; what the hand did is noted. */
function desk() {
    const canvas = new EventTarget(), strip = new EventTarget(), notes = /** @type {unknown[][]} */ ([]);
    const box = {
        clientWidth: 160,
        getBoundingClientRect: () => ({ left: 0, top: 0 }),
        setPointerCapture: () => {},
        style: {},
    };
    for (const element of [canvas, strip]) Object.assign(element, box);
    const beats = { starts: [0, 2, 4, 6], end: 8, averaged: [], rejected: {}, causes: {} };
    /** @type {any} */
    const state = {
        recording: { duration: 100, beats, edits: [] },
        view: [0, 10],
        stretch: null,
        beat: -1,
        carried: null,
        ends: null,
        pointer: null,
        mark: null,
    };
    const note = (/** @type {string} */ name) => (/** @type {unknown[]} */ ...values) => {
        notes.push([name, ...values]);
        return Promise.resolve();
    };
    const acts = {
        look: note("look"),
        pick: note("pick"),
        toggle: note("toggle"),
        move: note("move"),
        change: note("change"),
        later: () => {},
    };
    /** @type {any[]} */
    const [signals, overview] = [canvas, strip];
    listenToHand(signals, overview, state, { ...acts, tools: note("tools") });
    const send = (/** @type {string} */ type, /** @type {object} */ values) =>
        canvas.dispatchEvent(Object.assign(new Event(type, { cancelable: true }), values));
    return { state, notes, send };
}

Deno.test("keys scroll by a fifth, zoom about the middle and pick beats", () => {
    const { notes, send } = desk();
    for (const key of ["ArrowRight", "PageUp", "+", "End", "n", "p", "x", "]", "?"]) send("keydown", { key });
    send("keydown", { key: "x", ctrlKey: true }); // the browser's
    deepEqual(notes, [
        ["look", 2, 12],
        ["look", -10, 0],
        ["look", 2.5, 7.5],
        ["look", 90, 100],
        ["pick", 1],
        ["pick", -2],
        ["toggle"],
        ["move", 0.001],
    ]);
});

Deno.test("b and e begin and end a stretch in the middle of the window", () => {
    const { state, send } = desk();
    send("keydown", { key: "b" });
    deepEqual(state.stretch, [5, 10]);
    state.view = [6, 10];
    send("keydown", { key: "e" });
    deepEqual(state.stretch, [5, 8]);
    state.stretch = [1, 3];
    send("keydown", { key: "b" }); // a stretch that would end before it begins
    deepEqual(state.stretch, [8, 8]);
    send("keydown", { key: "Escape" });
    equal(state.stretch, null);
});

Deno.test("a drag is a stretch, a click picks the beat under it", () => {
    const { state, notes, send } = desk();
    send("pointerdown", { button: 0, clientX: 104 });
    send("pointermove", { clientX: 74 });
    send("pointerup", { clientX: 74 });
    deepEqual(state.stretch, [2, 5]);
    send("pointerdown", { button: 0, clientX: 104 });
    send("pointerup", { clientX: 106 });
    equal(state.stretch, null);
    deepEqual(notes, [["tools"], ["pick", 2]]);
});

Deno.test("the line of the picked beat is carried", () => {
    const { state, notes, send } = desk();
    state.beat = 1; // which begins at 74 pixels
    send("pointerdown", { button: 0, clientX: 76 });
    equal(state.carried, 2);
    send("pointermove", { clientX: 84 });
    equal(state.carried, 3);
    send("pointerup", { clientX: 84 });
    deepEqual(notes, [["move", 1]]);
});

Deno.test("a grip moves where the averaging begins or ends, to the millisecond; both at the ends are the whole", () => {
    const { state, notes, send } = desk();
    Object.assign(state.recording, { from: 1, to: 9 }); // at 64 and 144 pixels
    send("pointerdown", { button: 0, clientX: 66, clientY: 30 }); // below the grip, a stretch begins
    send("pointerup", { clientX: 90 });
    send("pointerdown", { button: 0, clientX: 66, clientY: 10 });
    send("pointermove", { clientX: 84.004 });
    deepEqual(state.ends, [3, 9]);
    send("pointerup", { clientX: 84.004 });
    send("pointerdown", { button: 0, clientX: 142, clientY: 10 });
    send("pointerup", { clientX: 142 }); // nothing was moved
    deepEqual(notes, [["tools"], ["change", "set-stretch", { start: 3, end: 9 }]]);
    Object.assign(state, { ends: null, view: [0, 100] });
    Object.assign(state.recording, { from: 0, to: 60 });
    send("pointerdown", { button: 0, clientX: 114, clientY: 10 });
    send("pointermove", { clientX: 154 });
    send("pointerup", { clientX: 154 });
    deepEqual(notes.at(-1), ["change", "set-stretch", {}]);
});

Deno.test("the wheel zooms about the pointer, with Shift it scrolls", () => {
    const { notes, send } = desk();
    send("wheel", { clientX: 54, deltaX: 0, deltaY: -400 });
    send("wheel", { clientX: 54, deltaX: 0, deltaY: 400, shiftKey: true });
    deepEqual(notes, [["look", 0, 5], ["look", 5, 15]]);
});
