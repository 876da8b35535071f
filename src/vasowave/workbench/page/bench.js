// @ts-check
// Elements of the Explorer: canvases and boxes, the legend, the row of colors, and the numbers.
/** @import { ModelAnswer, PredictionAnswer, Simulation } from "./answers.d.ts" */
/** @import { Coloring } from "./space.js" */
import { BESIDE, DRAWN } from "./curves.js";
import { button, choice, fill, formatted, h, input, labelled, player, rowOf, symbol } from "./dom.js";
import { MODEL } from "./plot.js";
import { colorsOf, instantOf } from "./space.js";

/**
 * @typedef {object} Parts elements of the desk
 * @property {Record<string, HTMLCanvasElement>} panels
 * @property {HTMLCanvasElement} space
 * @property {Record<"compared" | "knobs" | "numbers" | "notes" | "outdated" | "prediction" | "scale" | "walk", HTMLElement>} boxes
 */

const PLAY_MS = 80;

/**
 * @param {ModelAnswer} model
 * @returns {Parts}
 */
export function partsOf(model) {
    const panels = Object.entries(model.panels).map(([name, text]) => [
        name,
        h("canvas", { class: "panel", role: "img", "aria-label": text, data: { panel: name } }),
    ]);
    return {
        panels: Object.fromEntries(panels),
        space: treeCanvas(model.animal),
        boxes: {
            compared: h("div"),
            knobs: h("div"),
            numbers: h("div"),
            notes: h("div"),
            outdated: h("div"),
            prediction: h("div"),
            scale: h("p", { class: "scale note" }),
            walk: h("div"),
        },
    };
}

/** @param {string} animal */
export const treeCanvas = (animal) =>
    h("canvas", {
        class: "space",
        tabindex: 0,
        role: "img",
        "aria-label": `the tree of ${animal}; drag or arrow keys turn it`,
        data: { tree: animal },
    });

/** @param {ModelAnswer} model */
export function legend({ formula }) {
    const key = (/** @type {string} */ color, /** @type {string} */ text, look = "solid") => {
        const line = h("span", { class: "key" });
        line.style.borderTop = `3px ${look} ${color.startsWith("--") ? `var(${color})` : color}`;
        return h("span", { class: "legend" }, line, text, " ");
    };
    return h(
        "p",
        { class: "note" },
        formula,
        " ",
        key("--ink", "measured"),
        key(MODEL, "model, and backward wave dotted"),
        key(MODEL, "the fit, where the model was moved from it", "dotted"),
        key(BESIDE, "the fit of the other animal", "dashed"),
        key(DRAWN, "one of the models below"),
        "shade: where 95 % of the models lie that the data allow about the fit",
    );
}

/**
 * The choice of a color and a moment.
 * @param {ModelAnswer} model
 * @param {Coloring} shown
 * @param {() => unknown} redraw
 */
export function coloringRow(model, shown, redraw) {
    const out = h("output", {}, "");
    const colors = choice(colorsOf(model), shown.color, (name) => {
        shown.color = name;
        redraw();
    }, { "aria-label": "color of the tree", data: { key: "colored" } });
    const move = (/** @type {number} */ moment) => {
        shown.moment = moment;
        out.textContent = `${Math.round(moment / shown.moments * model.measured.period * 1000)} ms`;
        shown.color = colors.value = instantOf(shown.color, model);
        redraw();
    };
    const range = { type: "range", min: 0, max: shown.moments - 1, value: shown.moment };
    const attributes = { ...range, "aria-label": "time in the cycle", data: { key: "moment" } };
    const slider = input(attributes, (element) => move(Number(element.value)), "input");
    const next = (/** @type {number} */ moment) => (moment + 1) % shown.moments;
    const play = player(slider, next, move, { key: "play", ms: PLAY_MS });
    return rowOf(labelled("color", colors), labelled("time", slider, out), play);
}

/** @typedef {{ model: ModelAnswer, run: Simulation }} Fitted */

/**
 * @param {HTMLElement} place
 * @param {Fitted} fitted
 * @param {Fitted | null} compared
 */
export function numbersIn(place, { model, run }, compared) {
    const title = compared && h("p", { class: "keys" }, `${model.animal}, and ${compared.model.animal} beside it`);
    const rows = Object.entries(run.indices).map(([name, value]) => {
        const label = h("span", {}, symbol(name), " ", h("small", {}, model.units[name] || ""));
        const second = compared?.run.indices[name];
        return h(
            "div",
            {},
            label,
            h("b", { data: { index: name } }, formatted(value)),
            compared && h("b", { class: "other", data: { other: name } }, formatted(second)),
        );
    });
    fill(place, title, h("div", { class: "numbers" }, rows));
}

/**
 * What a change does, before and after, with intervals; nothing where none was asked for.
 * @param {HTMLElement} place
 * @param {PredictionAnswer | null} answer
 * @param {{ ask: () => void, moved: boolean }} sliders
 */
export function predictionIn(place, answer, { ask, moved }) {
    const asked = button("What would change?", ask, {
        disabled: !moved,
        data: { key: "predict" },
        title: "Move a slider: the cycle before and after, with 95 % intervals by what the recording leaves open",
    });
    if (!answer) return fill(place, asked);
    const titles = ["", "fit", "after", "change [95 %]"].map((title) => h("th", {}, title));
    const rows = Object.entries(answer.rows).map(([name, [before, after, ...changes]]) => {
        const [change, low, high] = changes.map((value) => formatted(value, 3));
        return h(
            "tr",
            { data: { predicted: name } },
            h("td", {}, answer.labels[name], " ", h("small", {}, answer.units[name])),
            h("td", {}, formatted(before)),
            h("td", {}, formatted(after)),
            h("td", {}, change, " ", h("small", {}, `[${low}, ${high}]`)),
        );
    });
    const remarks = answer.remarks.map((text) => h("p", { class: "note" }, text));
    fill(place, asked, h("table", { class: "prediction" }, h("tr", {}, titles), rows), remarks);
}
