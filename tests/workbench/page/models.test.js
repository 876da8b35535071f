// @ts-check
// What the Explorer and the Figure desk draw: sliders, draws, curves, and the points of all animals.
import { deepEqual, equal } from "node:assert/strict";
import { closed, curvesOf, overTime } from "../../../src/vasowave/workbench/page/curves.js";
import { comparable } from "../../../src/vasowave/workbench/page/figures.js";

import { shareOf, valueAt } from "../../../src/vasowave/workbench/page/knobs.js";
import { columnsOf, nearest, pointsOf, spread } from "../../../src/vasowave/workbench/page/points.js";
import { following, valuesOf } from "../../../src/vasowave/workbench/page/walk.js";
/** @import { AnimalNumbers, Estimate } from "../../../src/vasowave/workbench/page/answers.d.ts" */

/** @type {Record<string, Estimate>} */
const VALUES = { low: [1, 0.5, 2], high: [3, null, null], none: [null, null, null] };
/** @type {AnimalNumbers[]} */
const ANIMALS = [
    { name: "A", group: "CTL", laws: { linear: { R_T: VALUES.low }, measured: { R_T: VALUES.high } } },
    { name: "B", group: "CTL", laws: { linear: { R_T: VALUES.none } } },
    { name: "C", group: "HPH", laws: { linear: { R_T: VALUES.high } } },
];
const RESULTS = { animals: ANIMALS, groups: { CTL: "blue", HPH: "red", SHAM: "grey" }, reference: "CTL" };
const SHOWN = { sources: ["linear", "measured"], hiddenGroups: /** @type {Set<string>} */ (new Set()) };

Deno.test("a slider is logarithmic: its middle is the geometric mean of its ends", () => {
    const knob = { low: 1, high: 9 };
    equal(valueAt(knob, 0.5), 3);
    equal(shareOf(knob, 3), 0.5);
    deepEqual([0, 1].map((share) => valueAt(knob, share)), [1, 9]);
    deepEqual([1, 9].map((value) => shareOf(knob, value)), [0, 1]);
});

Deno.test("draws are counted from 1, and the first follows the last", () => {
    deepEqual([0, 1, 3].map((k) => following(k, 3)), [1, 2, 1]);
});

Deno.test("a draw has the symbols and units of the sliders, or its own name", () => {
    const draws = { kind: "", count: 2, curves: [], values: { R_T: [1, 2], extra: [3, null] } };
    const knobs = [{ name: "R_T", symbol: "R", unit: "mmHg s/ml" }];
    deepEqual(valuesOf(draws, knobs, 0), []);
    deepEqual(valuesOf(draws, knobs, 2), [
        { name: "R_T", symbol: "R", unit: "mmHg s/ml", value: 2 },
        { name: "extra", symbol: "extra", unit: "", value: null },
    ]);
});

Deno.test("a cycle ends where it begins, a period after it", () => {
    deepEqual(closed([1, 2]), [1, 2, 1]);
    deepEqual(overTime([5, 6, 7, 8], { color: "red" }, 0.25), {
        x: [0, 62.5, 125, 187.5, 250],
        y: [5, 6, 7, 8, 5],
        color: "red",
    });
});

Deno.test("every panel has the measurement, the model, its fit and the fit of the other animal", () => {
    const cycle = { pressure: [1, 2], flow: [3, 4], forward: [5, 6], backward: [7, 8], modulus: [9, 10] };
    const run = { ...cycle, period: 0.1, indices: {}, vessels: {}, frames: {}, notes: [] };
    const measured = { pressure: [0, 0], flow: [0, 0], modulus: [0, 0], period: 0.1 };
    const shown = { measured, run, fit: null, compared: null, drawn: null, band: {}, ink: "black" };
    const counts = (/** @type {object} */ more) =>
        Object.values(curvesOf({ ...shown, ...more })).map((series) => series.length);
    deepEqual(counts({}), [2, 2, 2, 2, 2]);
    deepEqual(counts({ fit: run }), [3, 3, 3, 4, 3]);
    deepEqual(counts({ fit: run, compared: run }), [4, 4, 4, 6, 4]);
    deepEqual(counts({ drawn: { pressure: [1, 1] } }), [3, 2, 2, 2, 2]);
    /** @type {[number[], number[]]} */
    const band = [[0, 1], [2, 3]];
    const { pressure } = curvesOf({ ...shown, band: { pressure: band } });
    deepEqual(pressure[0].band, { low: [0, 1, 0], high: [2, 3, 2] });
    const slow = curvesOf({ ...shown, compared: { ...run, period: 0.2 } }).flow;
    deepEqual(slow[2].x, [0, 100, 200]); // by its own period
});

Deno.test("animals of a group are followed by its mean; what has no value is left out", () => {
    /** @type {Record<string, Record<string, Estimate>>} */
    const means = { linear: { CTL: [2, 1, 3], HPH: [4, 3, 5] } };
    const columns = columnsOf(RESULTS, means, "R_T", SHOWN);
    deepEqual(columns.map(({ name }) => name), ["A", "mean CTL", "C"]); // of one animal there is no mean
    deepEqual(columns[0].values, [["linear", VALUES.low], ["measured", VALUES.high]]);
    deepEqual(columns[1], {
        name: "mean CTL",
        animal: null,
        color: "blue",
        group: "CTL",
        values: [["linear", [2, 1, 3]]],
    });
    const fewer = { sources: ["measured"], hiddenGroups: new Set(["HPH"]) };
    deepEqual(columnsOf(RESULTS, means, "R_T", fewer).map(({ name }) => name), ["A"]);
});

Deno.test("sources stand beside one another in the column of an animal", () => {
    const columns = columnsOf(RESULTS, {}, "R_T", SHOWN);
    const about = { sources: { linear: true, measured: false }, symbol: "R_T", unit: "mmHg s/ml" };
    const { points, series } = pointsOf(columns, about);
    deepEqual(points.map(({ x, y }) => [x, y]), [[0.75, 1], [1.25, 3], [2, 3]]);
    equal(points[0].text, "A, linear wall: R_T = 1 mmHg s/ml (0.5 to 2)");
    equal(points[1].text, "A, measured: R_T = 3 mmHg s/ml");
    deepEqual(series.map(({ points, hollow }) => [Boolean(points), hollow]), [
        [false, false], // an interval, then its point
        [true, false],
        [true, true],
        [true, false],
    ]);
});

Deno.test("the nearest spot within 14 pixels", () => {
    const spots = [{ x: 0, y: 0, animal: "A", text: "" }, { x: 10, y: 0, animal: "B", text: "" }];
    equal(nearest(spots, 6, 0)?.animal, "B");
    equal(nearest(spots, 0, 13)?.animal, "A");
    equal(nearest(spots, 0, 14), null);
});

Deno.test("a range shows all values, and of intervals what lies within twice their spread", () => {
    deepEqual(spread([0, 10], [-100, 12, 1e9]), [-0.72, 12.72]);
    deepEqual(spread([5], []).map((value) => Number(value.toFixed(9))), [4.7, 5.3]);
});

Deno.test("groups with animals are compared with the reference", () => {
    deepEqual(comparable(RESULTS), ["HPH"]);
});
