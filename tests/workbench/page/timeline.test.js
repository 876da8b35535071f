// @ts-check
import { deepEqual, equal } from "node:assert/strict";
import {
    averagedWindow,
    beatsByCause,
    centered,
    clamped,
    clock,
    editOf,
    extremes,
    fates,
    lastNotAfter,
    middleOf,
    spanOf,
    suffices,
    undecided,
    unmoved,
    valuesAt,
    wider,
    zoomed,
} from "../../../src/vasowave/workbench/page/timeline.js";

const BEATS = { starts: [1, 2, 4], end: 5, averaged: [0], rejected: { 1: "too long" }, causes: {} };

Deno.test("the first window is the stretch with 2 % on either side, within the recording", () => {
    deepEqual(averagedWindow({ from: 20, to: 30, duration: 100 }), [19.8, 30.2]);
    deepEqual(averagedWindow({ from: 0, to: 100, duration: 100 }), [0, 100]);
    deepEqual(averagedWindow({ duration: 8 }), [0, 8]);
});

Deno.test("a window keeps its length at the ends and is never shorter than 50 ms", () => {
    deepEqual(clamped(-3, 7, 100), [0, 10]);
    deepEqual(clamped(95, 105, 100), [90, 100]);
    deepEqual(clamped(10, 10, 100), [10, 10.05]);
    deepEqual(clamped(-50, 500, 100), [0, 100]);
    deepEqual(clamped(0, 1, 0.02), [0, 0.02]);
});

Deno.test("zooming keeps the time under the pointer", () => {
    deepEqual(zoomed([0, 8], 0.5), [2, 6]);
    deepEqual(zoomed([0, 8], 0.5, 2), [1, 5]);
    deepEqual(zoomed([2, 6], 2, 6), [-2, 6]);
    deepEqual(centered([2, 6], 10), [8, 12]);
});

Deno.test("the last value that is not above another", () => {
    deepEqual([0.5, 1, 3.9, 4, 9].map((value) => lastNotAfter(value, [1, 2, 4])), [-1, 0, 1, 2, 2]);
    equal(lastNotAfter(1, []), -1);
});

Deno.test("a time is as fine as its window", () => {
    equal(clock(65.4, 100), "65 s");
    equal(clock(3.14159, 1), "3.14 s");
    equal(clock(3.14159, 0.05), "3.1416 s");
    equal(clock(125, 60), "2:05");
    equal(clock(125.25, 1), "125.25 s");
    equal(clock(179.7, 60), "3:00");
});

Deno.test("of signals as much again is fetched on either side, at one pair a pixel", () => {
    deepEqual(wider([10, 20], 25, 100), { start: 0, end: 25, count: 250, each: 0.1 });
    equal(wider([100, 200], 1e4, 3000).count, 4000);
});

Deno.test("what was fetched suffices while the window is inside and about as fine", () => {
    const trace = { start: 0, end: 30, each: 0.1, count: 300, values: new Float32Array(600) };
    const width = 100;
    equal(suffices(trace, [10, 20], 40, width), true);
    equal(suffices(undefined, [10, 20], 40, width), false);
    equal(suffices(trace, [25, 35], 40, width), false); // beyond its end
    equal(suffices(trace, [25, 35], 30, width), true); // where there is no more
    equal(suffices(trace, [10, 15], 40, width), false); // 0.1 is coarse for 0.05 a pixel
    equal(suffices(trace, [0, 30], 40, width), false); // and needlessly fine for 0.3
});

Deno.test("extremes are those of the pieces in the window", () => {
    const values = new Float32Array([1, -5, 2, NaN, 3, 6, 9, NaN]); // lowest of four pieces, then highest
    const trace = { start: 10, end: 14, each: 1, count: 4, values };
    deepEqual(extremes(trace, [10.2, 11.5]), { first: 0, last: 2, low: -5, high: 6 });
    deepEqual(extremes(trace, [12, 99]), { first: 2, last: 4, low: 2, high: 9 });
    deepEqual(extremes(trace, [13, 14]), { first: 3, last: 4, low: Infinity, high: -Infinity });
});

Deno.test("a beat ends where the next begins, the last at the end", () => {
    deepEqual([0, 1, 2].map((k) => spanOf(BEATS, k)), [[1, 2], [2, 4], [4, 5]]);
    equal(middleOf(BEATS, 1), 3);
});

Deno.test("an edit of a beat is one inside it that moves nothing", () => {
    /** @type {[string, number, number | null][]} */
    const edits = [["move", 2.5, 2.6], ["reject", 4, null]];
    equal(editOf({ edits }, BEATS, 1), undefined);
    equal(editOf({ edits }, BEATS, 2), edits[1]);
});

Deno.test("a beat that was moved is moved again from where it first began", () => {
    equal(unmoved({ edits: [["move", 1.9, 2.00005]] }, 2), 1.9);
    equal(unmoved({ edits: [["move", 1.9, 2.001]] }, 2), 2);
    equal(unmoved({ edits: [["reject", 2, null]] }, 0), 0);
});

Deno.test("a stretch decides on beats with their middle inside whose fate would change", () => {
    deepEqual(undecided(BEATS, [0, 4], "reject"), [0]);
    deepEqual(undecided(BEATS, [0, 4], "keep"), [1]);
    deepEqual(undecided(BEATS, [1.5, 4.5], "reject"), [0]); // the last beat's middle is the end
});

Deno.test("beats are listed by the cause of their rejection", () => {
    const beats = beatsByCause({ 3: "arrhythmic", 7: "noisy", 9: "arrhythmic" });
    deepEqual([...beats], [["arrhythmic", [3, 9]], ["noisy", [7]]]);
});

Deno.test("many beats are shares of those averaged and rejected in each part of a window", () => {
    const beats = {
        starts: [0, 1, 2, 3, 9],
        end: 10,
        averaged: [0, 2, 3],
        rejected: { 1: "long", 4: "long" },
        causes: {},
    };
    const { averaged, rejected } = fates(beats, [0, 10], 5); // middles 0.5, 1.5 | 2.5 | | 6 | 9.5
    deepEqual([...averaged], [0.5, 1, 0, 1, 0]);
    deepEqual([...rejected], [0.5, 0, 0, 0, 1]);
});

Deno.test("a time has the lowest and highest value of its piece, and none where there is no sample", () => {
    const trace = { start: 10, end: 13, each: 1, count: 3, values: new Float32Array([1, NaN, 3, 2, NaN, 5]) };
    deepEqual(valuesAt(trace, 10.5), [1, 2]);
    deepEqual(valuesAt(trace, 12), [3, 5]);
    deepEqual([11.5, 9, 13].map((time) => valuesAt(trace, time)), [null, null, null]);
});
