// @ts-check
import { deepEqual, equal } from "node:assert/strict";
import { colorsOf, instantOf, mixed, rangeOf, vesselValues } from "../../../src/vasowave/workbench/page/space.js";

const MODEL = { colors: ["mean pressure [mmHg]"], moving: ["pressure [mmHg]", "flow [ml/s]"] };
const RUN = {
    vessels: { "mean pressure [mmHg]": [20, null, 14] },
    frames: { "pressure [mmHg]": [[10, 12], [30, 18], [20, 15], [11, 13]] },
};

Deno.test("colors are means and what moves", () => {
    deepEqual(colorsOf(MODEL), ["mean pressure [mmHg]", "pressure [mmHg] now", "flow [ml/s] now"]);
});

Deno.test("an instant is shown of what moves", () => {
    equal(instantOf("mean pressure [mmHg]", MODEL), "pressure [mmHg] now");
    equal(instantOf("flow [ml/s] now", MODEL), "flow [ml/s] now");
});

Deno.test("a moment is the frame at its share of the cycle", () => {
    const values = (/** @type {number} */ moment) =>
        vesselValues(RUN, { color: "pressure [mmHg] now", moment, moments: 8 });
    deepEqual([0, 1, 2, 7].map(values), [[10, 12], [10, 12], [30, 18], [11, 13]]);
    deepEqual(vesselValues(RUN, { color: "mean pressure [mmHg]", moment: 3, moments: 8 }), [20, null, 14]);
});

Deno.test("the range is that of all moments, or of all vessels with a value", () => {
    deepEqual(rangeOf([RUN], { color: "pressure [mmHg] now" }), [10, 30]);
    deepEqual(rangeOf([RUN], { color: "mean pressure [mmHg]" }), [14, 20]);
    const lower = { ...RUN, vessels: { "mean pressure [mmHg]": [5] } };
    deepEqual(rangeOf([RUN, lower], { color: "mean pressure [mmHg]" }), [5, 20]);
});

Deno.test("colors are mixed between the stops and end with the last", () => {
    /** @type {[number, number, number][]} */
    const stops = [[0, 0, 0], [100, 200, 50], [200, 200, 200]];
    equal(mixed(stops, 0), "rgb(0,0,0)");
    equal(mixed(stops, 0.25), "rgb(50,100,25)");
    equal(mixed(stops, 0.5), "rgb(100,200,50)");
    equal(mixed(stops, 7), "rgb(200,200,200)");
    equal(mixed(stops, -1), "rgb(0,0,0)");
});
