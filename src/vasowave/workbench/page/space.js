// @ts-check
// Trees in space, colored by what happens in their vessels; trees beside one another share one scale of colors.
/** @import { Color, ModelAnswer, Simulation } from "./answers.d.ts" */
import { count, fill, formatted, h } from "./dom.js";
import { style } from "./plot.js";

/**
 * @typedef {object} Coloring
 * @property {string} color name of what is colored
 * @property {number} moment of the cycle, of `moments`
 * @property {number} moments
 */

const NOW = " now";

/**
 * Names of the colors of a model: means, and what moves in the cycle.
 * @param {Pick<ModelAnswer, "colors" | "moving">} model
 */
export const colorsOf = ({ colors, moving }) => [...colors, ...moving.map((name) => name + NOW)];

/**
 * The name of a color at an instant: one that does not move gives way to the first that does.
 * @param {string} color
 * @param {Pick<ModelAnswer, "moving">} model
 */
export const instantOf = (color, { moving }) => color.endsWith(NOW) ? color : moving[0] + NOW;

/** @param {string} color */
const movingOf = (color) => color.endsWith(NOW) ? color.slice(0, -NOW.length) : null;

/**
 * What the vessels of a simulation show at a moment of the cycle.
 * @param {Pick<Simulation, "frames" | "vessels">} run
 * @param {Coloring} coloring
 */
export function vesselValues(run, { color, moment, moments }) {
    const name = movingOf(color);
    return name ? run.frames[name][Math.floor(moment / moments * run.frames[name].length)] : run.vessels[color];
}

/**
 * Lowest and highest that any of the simulations shows at any moment.
 * @param {Pick<Simulation, "frames" | "vessels">[]} runs
 * @param {{ color: string }} coloring
 * @returns {[number, number]}
 */
export function rangeOf(runs, { color }) {
    const name = movingOf(color);
    const values = /** @type {number[]} */ (
        runs.flatMap((run) => name ? run.frames[name].flat() : run.vessels[color]).filter(Number.isFinite)
    );
    return [Math.min(...values), Math.max(...values)];
}

/**
 * The color at a share of the way through stops.
 * @param {Color[]} stops
 * @param {number} share
 */
export function mixed(stops, share) {
    const place = Math.min(0.9999, Math.max(0, share)) * (stops.length - 1), k = Math.floor(place);
    const channel = (/** @type {number} */ i) => stops[k][i] + (place - k) * (stops[k + 1][i] - stops[k][i]);
    return `rgb(${[0, 1, 2].map((i) => Math.round(channel(i)))})`;
}

/**
 * A tree that can be turned; `scene` gives its simulation, how it is colored, and the range.
 * @param {HTMLCanvasElement} canvas
 * @param {ModelAnswer} model
 * @param {() => { run: Simulation | null, coloring: Coloring, range: [number, number] }} scene
 */
export function treeIn(canvas, { tree: { axes, radius }, stops }, scene) {
    const view = turntable(canvas, axes.flat(), (view) => {
        const { run, coloring, range: [low, high] } = scene(), ink = style("--ink");
        if (!run) return;
        const values = vesselValues(run, coloring);
        const pieces = axes.map(([from, to], row) => ({ from: view.project(from), to: view.project(to), row }));
        pieces.sort((a, b) => b.from[2] + b.to[2] - a.from[2] - a.to[2]);
        for (const { from, to, row } of pieces) {
            const width = Math.max(2, 2 * radius[row] * view.unit());
            view.line(from, to, width + 1.5, ink);
            view.line(from, to, width, mixed(stops, (Number(values[row]) - low) / (high - low || 1)));
        }
        view.scaleBar(ink);
        count(canvas);
    }, () => {});
    view.rotate(0.5, 0.3);
    return view;
}

/**
 * The scale of colors below the trees.
 * @param {HTMLElement} place
 * @param {Color[]} stops
 * @param {[number, number]} range
 * @param {Coloring} coloring
 */
export function scaleIn(place, stops, [low, high], { color }) {
    const bar = h("i"), unit = color.match(/\[(.*)\]/)?.[1] ?? "";
    bar.style.background = `linear-gradient(to right, ${stops.map((stop) => `rgb(${stop})`).join(", ")})`;
    fill(place, `${formatted(low, 3)} `, bar, ` ${formatted(high, 3)} ${unit}; directions are drawn, not measured`);
}
