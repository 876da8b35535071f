// @ts-check
// Things in space: the turntable of report and workbench, and the vessels of an image.
import { deepEqual, equal } from "node:assert/strict";
import { describe, placeOf, summary } from "../../../src/vasowave/workbench/page/tree.js";
import { middleOf, nearestVessel, shade } from "../../../src/vasowave/workbench/page/vessels.js";
/** @import { AxisPoint, Vessel } from "../../../src/vasowave/workbench/page/answers.d.ts" */

/**
 * The text of a file below a folder, wherever it stands.
 * @param {URL} folder
 * @param {string} name
 * @returns {string | undefined}
 */
function textOf(folder, name) {
    for (const entry of Deno.readDirSync(folder)) {
        if (entry.name === name) return Deno.readTextFileSync(new URL(name, folder));
        const text = entry.isDirectory ? textOf(new URL(`${entry.name}/`, folder), name) : undefined;
        if (text !== undefined) return text;
    }
    return undefined;
}

const SCRIPT = textOf(new URL("../../../src/vasowave/", import.meta.url), "turntable.js");
const turntable = /** @type {Turntable} */ (new Function(`${SCRIPT}\nreturn turntable;`)());

/** A cube of 2 cm about 1, 1, 1 on a canvas of 100 by 200 pixels: 44 pixels per cm. */
function cube() {
    const canvas = Object.assign(new EventTarget(), {
        clientWidth: 100,
        clientHeight: 200,
        getContext: () => ({ setTransform: () => {} }),
        setPointerCapture: () => {},
    });
    const picked = /** @type {number[][]} */ ([]);
    Object.assign(globalThis, { devicePixelRatio: 1 });
    /** @type {any} */
    const element = canvas;
    const view = turntable(element, [[0, 0, 0], [2, 2, 2]], () => {}, (x, y) => picked.push([x, y]));
    const seen = (/** @type {number[]} */ point) => view.project(point).map((value) => Number(value.toFixed(6)) + 0);
    const send = (/** @type {string} */ type, /** @type {object} */ values) =>
        canvas.dispatchEvent(Object.assign(new Event(type, { cancelable: true }), values));
    return { view, seen, send, picked };
}

Deno.test("at first x points right, z up and y away; the middle stands in the middle", () => {
    const { view, seen } = cube();
    equal(view.unit(), 44);
    deepEqual(seen([1, 1, 1]), [50, 100, 0.5]);
    deepEqual(seen([2, 1, 1]), [94, 100, 0.5]);
    deepEqual(seen([1, 1, 2]), [50, 56, 0.5]);
    deepEqual(seen([1, 2, 1]), [50, 100, 1]);
    deepEqual(seen([1, -9, 1]), [50, 100, 0]); // no nearer than near
});

Deno.test("a quarter turn brings what was right to the front or the back, and keeps up", () => {
    const { view, seen } = cube();
    view.rotate(Math.PI / 2, 0);
    deepEqual(seen([1, 1, 2]), [50, 56, 0.5]);
    deepEqual(seen([2, 1, 1]), [50, 100, 0]);
    deepEqual(seen([1, 2, 1]), [94, 100, 0.5]);
});

Deno.test("turning keeps lengths, and four quarters are a whole turn", () => {
    const { view, seen } = cube();
    view.rotate(0.7, 0.4);
    const [x, y, far] = seen([2, 1, 1]);
    equal(Number(Math.hypot((x - 50) / 44, (y - 100) / 44, 2 * far - 1).toFixed(5)), 1);
    view.rotate(0, -0.4);
    view.rotate(-0.7, 0);
    for (let k = 0; k < 4; k++) view.rotate(0, Math.PI / 2);
    deepEqual(seen([2, 1, 1]), [94, 100, 0.5]);
});

Deno.test("a click picks, a drag turns, keys and the wheel zoom", () => {
    const { view, seen, send, picked } = cube();
    send("pointerdown", { offsetX: 5, offsetY: 6 });
    send("pointermove", { offsetX: 7, offsetY: 6 }); // less than 4 pixels
    send("pointerup", { offsetX: 7, offsetY: 6 });
    deepEqual(picked, [[7, 6]]);
    send("pointerdown", { offsetX: 0, offsetY: 0 });
    send("pointermove", { offsetX: -50 * Math.PI, offsetY: 0 }); // 0.01 a pixel: a quarter turn
    send("pointerup", { offsetX: 0, offsetY: 0 });
    deepEqual(seen([2, 1, 1]), [50, 100, 0]);
    equal(picked.length, 1);
    send("keydown", { key: "+" });
    equal(view.unit().toFixed(6), "52.800000");
    send("keydown", { key: "-" });
    send("wheel", { deltaY: 1e6 }); // no smaller than half
    equal(view.unit().toFixed(6), "22.000000");
});

/** @returns {Vessel} */
const vessel = (/** @type {string} */ name, /** @type {AxisPoint[]} */ points, more = {}) => ({
    name,
    parent: "",
    terminal: true,
    length: 1.23456,
    radius: 0.04567,
    sd: 0.00123,
    reliable: true,
    points,
    doubts: [],
    ...more,
});
const WIDE = vessel("wide", [[0, 0, 0, 1], [1, 0, 0, 1], [2, 0, 0, 1]]);
const THIN = vessel("thin", [[0, 3, 0, 0.1]], { parent: "wide", reliable: false, doubts: ["radius"] });

Deno.test("the nearest vessel is that with the fewest of its own radii between", () => {
    equal(nearestVessel([WIDE, THIN], [0, 2.5, 0]), "wide"); // 2.5 against 5
    equal(nearestVessel([WIDE, THIN], [0, 2.9, 0]), "thin"); // 2.9 against 1
    equal(nearestVessel([WIDE], [0, 3, 0]), "");
    equal(nearestVessel([], [0, 0, 0]), "");
});

Deno.test("a doubt is looked at where it is, else in the middle of its vessel", () => {
    const doubt = { about: "", text: "", vessels: ["gone", "wide"], places: [] };
    deepEqual(middleOf(WIDE), [1, 0, 0, 1]);
    deepEqual(placeOf(doubt, [THIN, WIDE]), [1, 0, 0, 1]);
    deepEqual(placeOf({ ...doubt, places: [[7, 8, 9]] }, [WIDE]), [7, 8, 9]);
    equal(placeOf({ ...doubt, vessels: [] }, [WIDE]), undefined);
});

Deno.test("colors pale with the distance", () => {
    deepEqual([0, 0.5, 1].map(shade), ["rgb(0,120,150)", "rgb(45,141,165)", "rgb(90,162,180)"]);
});

Deno.test("a vessel and an extraction in one sentence", () => {
    equal(describe(WIDE), "Radius 0.0457 ± 0.0012 cm; length 1.23 cm; the root.");
    equal(
        describe(THIN),
        "Radius 0.0457 ± 0.0012 cm, not reliable; length 1.23 cm; daughter of wide; doubted: radius.",
    );
    const extraction = { vessels: [WIDE, { ...THIN, terminal: false }], generations: 2, total: 2.4691, scale: null };
    equal(summary(extraction), "2 vessels, 1 of them terminal, in 2 generations; 2.47 cm in all.");
    equal(summary({ ...extraction, scale: -1.234 }).split("; ")[2], "the cannula measures -1.2 % off its size.");
});
