// @ts-check
import { deepEqual, equal } from "node:assert/strict";
import { decades, ordinate, plot, scalesOf, ticks } from "../../../src/vasowave/workbench/page/plot.js";

/** 100 pixels wide and high inside the margins: 50 to 150, and 108 up to 8. */
const FRAME = { width: 158, height: 140, foot: 32 };

Deno.test("ticks are multiples of 1, 2 or 5 times a power of ten", () => {
    deepEqual(ticks(0, 10, 5), [0, 2, 4, 6, 8, 10]);
    deepEqual(ticks(-1, 1, 4), [-1, -0.5, 0, 0.5, 1]);
    deepEqual(ticks(3, 17, 3), [5, 10, 15]);
    deepEqual(ticks(0.13, 0.37, 5).map((value) => value.toFixed(2)), ["0.15", "0.20", "0.25", "0.30", "0.35"]);
});

Deno.test("an end of the range that is a round number has its tick in spite of rounding", () => {
    equal(ticks(0, 0.3, 3).length, 4); // 3 * 0.1 is more than 0.3
});

Deno.test("a logarithmic axis has 1, 2 and 5 of every decade", () => {
    deepEqual(decades(1, 100), [1, 2, 5, 10, 20, 50, 100]);
    deepEqual(decades(0.3, 4), [0.5, 1, 2]);
    deepEqual(decades(2.1, 4.9), []);
});

Deno.test("an ordinate leaves 6 % of room, a logarithmic one a tenth", () => {
    deepEqual(ordinate([0, 10], undefined, false), [-0.6, 10.6]);
    deepEqual(ordinate([5, 5], undefined, false), [4.7, 5.3]);
    deepEqual(ordinate([0], undefined, false), [-0.06, 0.06]);
    deepEqual(ordinate([1.1, 100], undefined, true).map(Math.round), [1, 110]);
    deepEqual(ordinate([3, 4], [0, 8], false), [0, 8]);
});

Deno.test("a logarithmic ordinate reaches four decades down", () => {
    deepEqual(ordinate([1e-9, 100], [0, 100], true), [0.01, 100]);
});

Deno.test("values stand at their share of the axes", () => {
    const scales = scalesOf({ series: [{ x: [0, 4], y: [0, 10] }], range: [0, 10] }, FRAME);
    deepEqual([0, 1, 4].map((value) => scales?.px(value)), [50, 75, 150]);
    deepEqual([0, 5, 10].map((value) => scales?.py(value)), [108, 58, 8]);
});

Deno.test("on a logarithmic axis the geometric mean stands in the middle", () => {
    const scales = scalesOf({ series: [{ x: [0, 1], y: [1, 100] }], range: [1, 100], log: true }, FRAME);
    equal(Number(scales?.py(10).toFixed(9)), 58);
});

Deno.test("the range holds bands, and skips what is not a number", () => {
    const band = { low: [-10, null], high: [30, NaN] };
    const scales = scalesOf({ series: [{ x: [0, 1], y: [0, null], band }] }, FRAME);
    deepEqual([scales?.low, scales?.high].map((value) => Number(value?.toFixed(9))), [-12.4, 32.4]);
});

Deno.test("there is nothing to draw without a number or without room", () => {
    equal(scalesOf({ series: [{ x: [0], y: [null] }] }, FRAME), null);
    equal(scalesOf({ series: [{ x: [0], y: [1] }] }, { ...FRAME, width: 79 }), null);
});

Deno.test("a curve is lifted where there is no value, and a band is closed along its lower side", () => {
    const document = { documentElement: null }, getComputedStyle = () => ({ getPropertyValue: () => "black" });
    Object.assign(globalThis, { document, getComputedStyle, devicePixelRatio: 1 });
    /** @type {[string, number, number][]} */
    const lines = [];
    const note = (/** @type {string} */ name) => (/** @type {number} */ x, /** @type {number} */ y) => {
        if (curve) lines.push([name, Math.round(x), Math.round(y)]);
    };
    let curve = false; // the axes come first
    const pen = new Proxy({}, {
        get: (_, name) => {
            if (name === "clip") curve = true;
            return ["moveTo", "lineTo"].includes(String(name)) ? note(String(name)) : () => {};
        },
        set: () => true,
    });
    /** @type {any} */
    const canvas = { clientWidth: 158, clientHeight: 140, getContext: () => pen };
    plot(canvas, { series: [{ x: [0, 1, 3, 4], y: [0, null, 5, 10] }], range: [0, 10] });
    deepEqual(lines.splice(0), [["moveTo", 50, 108], ["moveTo", 125, 58], ["lineTo", 150, 8]]);
    curve = false;
    const band = { low: [0, 0], high: [10, 5] };
    plot(canvas, { series: [{ x: [0, 4], y: [5, 5], band, width: 0 }], range: [0, 10] });
    deepEqual(lines, [["moveTo", 50, 8], ["lineTo", 150, 58], ["lineTo", 150, 108], ["lineTo", 50, 108]]);
});
