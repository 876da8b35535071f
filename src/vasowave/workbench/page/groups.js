// @ts-check
// All animals of a study: one number of each, by group and by where it comes from, with the mean of every group.
/** @import { Child, Means, ResultsAnswer } from "./answers.d.ts" */
/** @import { Scales } from "./plot.js" */
/** @import { Column, Spot } from "./points.js" */
import { ask, complain } from "./ask.js";
import { button, choice, count, fill, formatted, h, input, labelled, rowOf } from "./dom.js";
import { columnsOf, nearest, pointsOf, sourceText, spread } from "./points.js";
import { plot, sheet, style, watched } from "./plot.js";

/**
 * @typedef {object} Parts elements of the section
 * @property {HTMLCanvasElement} canvas
 * @property {HTMLElement} table
 * @property {HTMLElement} caption
 * @property {(animal: string) => unknown} go
 */

const state = {
    results: /** @type {ResultsAnswer} */ (/** @type {unknown} */ (null)),
    parts: /** @type {Parts} */ (/** @type {unknown} */ (null)),
    means: /** @type {Means} */ ({}),
    scales: /** @type {Scales | null} */ (null),
    spots: /** @type {Spot[]} */ ([]),
    quantity: "",
    log: false,
    hiddenGroups: /** @type {Set<string>} */ (new Set()),
    hiddenSources: /** @type {Set<string> | null} */ (null),
};

/**
 * The section of the desk.
 * @param {ResultsAnswer} results
 * @param {string} law the source that is shown at first
 * @param {(animal: string) => unknown} go leads to the model of an animal
 */
export function groupSection(results, law, go) {
    const names = Object.keys(results.quantities);
    state.results = results;
    if (!names.includes(state.quantity)) state.quantity = names.includes("R_T") ? "R_T" : names[0];
    const hiddenSources = state.hiddenSources ??= new Set(
        Object.keys(results.sources).filter((source) => source !== law),
    );
    const canvas = h("canvas", {
        class: "panel",
        role: "img",
        "aria-label": "all animals by group, and the mean of each group; a click opens an animal",
    });
    const caption = h("p", { class: "note" }, "Point at an animal to read its name; a click opens its model.");
    state.parts = { canvas, table: h("div"), caption, go };
    canvas.addEventListener("pointermove", (event) => {
        const spot = nearest(state.spots, event.offsetX, event.offsetY);
        canvas.style.cursor = spot ? "pointer" : "default";
        if (spot) caption.textContent = spot.text;
    });
    canvas.addEventListener("click", (event) => {
        const spot = nearest(state.spots, event.offsetX, event.offsetY);
        if (spot?.animal) go(spot.animal);
    });
    watched(canvas, draw);
    choose(state.quantity);
    const quantities = names.map((name) => /** @type {[string, string]} */ ([
        name,
        `${results.quantities[name][0]}: ${results.quantities[name][2]}`,
    ]));
    return h(
        "section",
        { class: "points" },
        h("h2", {}, "All animals"),
        rowOf(
            choice(quantities, state.quantity, choose, { "aria-label": "quantity", data: { key: "quantity" } }),
            box("logarithmic", state.log, (on) => {
                state.log = on;
            }),
        ),
        rowOf("groups", groupBoxes(results), "sources", sourceBoxes(results, hiddenSources)),
        canvas,
        caption,
        h("details", {}, h("summary", {}, "As a table"), state.parts.table),
        results.failures.map((failure) => h("div", { class: "finding bad" }, failure)),
    );
}

/**
 * @param {string} text
 * @param {boolean} checked
 * @param {(on: boolean) => unknown} changed
 * @param {Child} [mark]
 */
function box(text, checked, changed, mark = null) {
    const element = input({ type: "checkbox", checked, data: { key: `show ${text}` } }, () => {
        changed(element.checked);
        draw();
    });
    return labelled(element, mark, text);
}

/**
 * @param {Set<string>} hidden
 * @param {string} name
 */
const toggle = (hidden, name) => (/** @type {boolean} */ on) => on ? hidden.delete(name) : hidden.add(name);

/** @param {ResultsAnswer} results */
const groupBoxes = ({ groups }) =>
    Object.entries(groups).map(([group, color]) => {
        const key = h("span", { class: "key" });
        key.style.borderColor = color;
        return box(group, !state.hiddenGroups.has(group), toggle(state.hiddenGroups, group), key);
    });

/**
 * @param {ResultsAnswer} results
 * @param {Set<string>} hidden
 */
const sourceBoxes = ({ sources }, hidden) =>
    Object.entries(sources).map(([source, filled]) =>
        box(sourceText(source), !hidden.has(source), toggle(hidden, source), filled ? "● " : "○ ")
    );

/** @param {string} quantity */
async function choose(quantity) {
    state.quantity = quantity;
    state.means = {};
    draw();
    try {
        const means = await ask("means", { quantity });
        if (quantity !== state.quantity) return;
        state.means = means;
        draw();
    } catch (error) {
        complain(error);
    }
}

function draw() {
    const { results, parts: { canvas }, quantity, log } = state, hiddenSources = state.hiddenSources ?? new Set();
    if (!canvas.isConnected && canvas.clientWidth === 0) return;
    const [symbol, unit] = results.quantities[quantity];
    const sources = Object.keys(results.sources).filter((source) => !hiddenSources.has(source));
    const columns = columnsOf(results, state.means, quantity, { sources, hiddenGroups: state.hiddenGroups });
    table(columns, symbol, unit);
    if (!columns.length) {
        sheet(canvas);
        state.scales = null;
        state.spots = [];
        return;
    }
    const { points, series } = pointsOf(columns, { sources: results.sources, symbol, unit });
    const values = points.map(({ y }) => y), positive = Math.min(...values) > 0;
    const ends = series.filter((curve) => !curve.points).flatMap(({ y }) => y.map(Number));
    const narrow = (canvas.clientWidth - 58) / (columns.length + 1) < 70, foot = narrow ? 62 : 32; // names stand aslant
    const scales = state.scales = plot(canvas, {
        series,
        foot,
        y: `${symbol} [${unit}]`,
        across: [0.3, columns.length + 0.7],
        log: log && positive,
        range: log && positive ? undefined : spread(values, ends),
    });
    if (!scales) return;
    state.spots = points.map((point) => ({ ...point, x: scales.px(point.x), y: scales.py(point.y) }));
    drawNames(columns, scales, narrow, foot);
    count(canvas);
}

/**
 * Names below the points, as many as there is room for.
 * @param {Column[]} columns
 * @param {Scales} scales
 * @param {boolean} narrow
 * @param {number} foot
 */
function drawNames(columns, scales, narrow, foot) {
    const { canvas } = state.parts, pen = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
    const room = (scales.right - scales.left) / (columns.length + 1), each = Math.ceil(13 / room);
    pen.fillStyle = style("--ink");
    pen.textBaseline = "top";
    pen.textAlign = narrow ? "right" : "center";
    columns.forEach(({ name, animal }, k) => {
        if (k % each && animal) return;
        pen.save();
        pen.translate(scales.px(k + 1), canvas.clientHeight - foot + 4);
        if (narrow) pen.rotate(-0.5);
        if (!animal) pen.font = `bold ${pen.font}`;
        pen.fillText(name.length > 14 ? `${name.slice(0, 13)}…` : name, 0, 0);
        pen.restore();
    });
}

/**
 * @param {Column[]} columns
 * @param {string} symbol
 * @param {string} unit
 */
function table(columns, symbol, unit) {
    const titles = ["animal", "group", "source", `${symbol} [${unit}]`, "95 %"].map((title) => h("th", {}, title));
    const rows = columns.flatMap(({ name, animal, group, values }) =>
        values.map(([source, [value, low, high]]) => {
            const link = animal ? button(animal, () => state.parts.go(animal), { class: "plain-link" }) : name;
            const interval = low === null ? "" : `${formatted(low, 3)} to ${formatted(high, 3)}`;
            const cells = [link, group, sourceText(source), formatted(value), interval];
            return h("tr", {}, cells.map((cell) => h("td", {}, cell)));
        })
    );
    const head = h("thead", {}, h("tr", {}, titles));
    fill(state.parts.table, h("div", { class: "table" }, h("table", {}, head, h("tbody", {}, rows))));
}
