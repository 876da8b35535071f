// @ts-check
// The Explorer's curves: what was measured, the model, its fit, the fit of another animal, and what the data allow.
/** @import { BandAnswer, CurveName, Curves, ModelAnswer, Simulation, Value } from "./answers.d.ts" */
/** @import { Curve } from "./plot.js" */
import { MODEL } from "./plot.js";

export const BESIDE = "#d6259b", DRAWN = "#e69f00";

/** @typedef {Pick<Curve, "color" | "width" | "dash" | "points">} Look */
/** @typedef {(values: readonly Value[], look: Look, period?: number) => Curve} Layout how values become a curve */

/**
 * @typedef {object} Shown
 * @property {ModelAnswer["measured"]} measured
 * @property {Simulation} run
 * @property {Simulation | null} fit where the model was moved from it
 * @property {Simulation | null} compared
 * @property {Partial<Curves> | null} drawn
 * @property {BandAnswer["band"]} band
 * @property {string} ink
 */

/**
 * A cycle that ends where it begins.
 * @template Item
 * @param {readonly Item[]} list
 */
export const closed = (list) => [...list, list[0]];

/**
 * A cycle by time in ms, from its period in s.
 * @param {readonly Value[]} values
 * @param {Look} look
 * @param {number} period
 * @returns {Curve}
 */
export const overTime = (values, look, period) => ({
    x: closed(values).map((_, k) => k / values.length * period * 1000),
    y: closed(values),
    ...look,
});

/** @type {Layout} */
const byHarmonic = (values, look) => ({ x: values.map((_, k) => k), y: values, ...look });

/**
 * @param {{ flow: Value[], pressure: Value[] }} cycle
 * @param {Look} look
 * @returns {Curve}
 */
const loopOf = ({ flow, pressure }, look) => ({ x: closed(flow), y: closed(pressure), ...look });

/**
 * All series of every panel.
 * @param {Shown} shown
 * @returns {Record<string, Curve[]>}
 */
export function curvesOf(shown) {
    const { measured, run, fit, compared, ink } = shown;
    /** @type {Layout} */
    const overCycle = (values, look, period = measured.period) => overTime(values, look, period);
    const model = { color: MODEL, width: 2 };
    return {
        pressure: seriesOf(shown, "pressure", overCycle, measured.pressure, model),
        flow: seriesOf(shown, "flow", overCycle, measured.flow, model),
        loop: [
            loopOf(measured, { color: ink, width: 1.4 }),
            loopOf(run, model),
            ...(fit ? [loopOf(fit, { color: MODEL, width: 1, dash: [2, 3] })] : []),
            ...(compared ? [loopOf(compared, { color: BESIDE, dash: [7, 3] })] : []),
        ],
        waves: [
            ...seriesOf(shown, "forward", overCycle, null, model),
            ...seriesOf(shown, "backward", overCycle, null, { color: MODEL, width: 1.8, dash: [2, 2] }),
        ],
        modulus: seriesOf(shown, "modulus", byHarmonic, measured.modulus, model),
    };
}

/**
 * @param {Shown} shown
 * @param {CurveName} name
 * @param {Layout} layout
 * @param {Value[] | null} measured
 * @param {Look} model
 * @returns {Curve[]}
 */
function seriesOf({ band, run, fit, compared, drawn, ink }, name, layout, measured, model) {
    const limits = band[name]?.map((values) => layout(values, { color: MODEL, width: 0 }));
    const walked = drawn?.[name];
    return [
        ...(limits ? [{ ...limits[0], band: { low: limits[0].y, high: limits[1].y } }] : []),
        ...(measured ? [layout(measured, { color: ink, width: 1.4, points: name === "modulus" })] : []),
        layout(run[name], model),
        ...(fit ? [layout(fit[name], { color: MODEL, width: 1, dash: [2, 3] })] : []),
        ...(compared ? [layout(compared[name], { color: BESIDE, width: 1.4, dash: [7, 3] }, compared.period)] : []),
        ...(walked ? [layout(walked, { color: DRAWN, width: 1.6 })] : []),
    ];
}
