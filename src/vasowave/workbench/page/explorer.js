// @ts-check
// The Explorer: one animal's model under the hand, another beside it, and what the data allow.
/** @import { BandAnswer, Curves, ModelAnswer, PredictionAnswer, ResultsAnswer, Simulation } from "./answers.d.ts" */
/** @import { Parts } from "./bench.js" */
/** @import { Coloring } from "./space.js" */
import { coloringRow, legend, numbersIn, partsOf, predictionIn, treeCanvas } from "./bench.js";
import { ask, complain, notify, post } from "./ask.js";
import { curvesOf } from "./curves.js";
import { button, choice, count, fill, h, labelled, rowOf, visit } from "./dom.js";
import { groupSection } from "./groups.js";
import { knobsIn } from "./knobs.js";
import { plot, style, watched } from "./plot.js";
import { rangeOf, scaleIn, treeIn } from "./space.js";
import { walkIn } from "./walk.js";

/**
 * @typedef {object} ExplorerState
 * @property {ModelAnswer | null} model
 * @property {Simulation | null} run of the values that are wished
 * @property {Simulation | null} fit
 * @property {BandAnswer["band"]} band
 * @property {Partial<Curves> | null} drawn the model that is walked to
 * @property {{ model: ModelAnswer, run: Simulation } | null} compared the fit of another animal
 * @property {Record<string, number>} values that were moved
 * @property {Parts | null} parts
 * @property {SpaceView[]} trees
 * @property {boolean} busy
 * @property {boolean} wanted whether another simulation is wished
 * @property {Coloring} coloring
 */

/** @type {ExplorerState} */
const state = {
    model: null,
    run: null,
    fit: null,
    band: {},
    drawn: null,
    compared: null,
    values: {},
    parts: null,
    trees: [],
    busy: false,
    wanted: false,
    coloring: { color: "", moment: 0, moments: 1 },
};
const OUTDATED = "outdated: its row, its files or the settings changed since this was computed";

/**
 * @param {HTMLElement} place
 * @param {string[]} path
 */
export async function show(place, path) {
    const results = /** @type {ResultsAnswer} */ (await ask("results"));
    if (!place.isConnected) return; // another desk or animal is wanted by now
    const names = results.animals.map(({ name }) => name), animal = names.includes(path[0]) ? path[0] : names[0];
    const model = /** @type {ModelAnswer} */ (await ask("model", { animal, law: path[1] || "" }));
    if (!place.isConnected) return;
    Object.assign(state, { model, run: null, fit: null, band: {}, drawn: null, compared: null, values: {}, trees: [] });
    state.coloring.color ||= model.colors[0];
    state.coloring.moments = model.moments;
    const parts = state.parts = partsOf(model);
    layOut(place, parts, model, results);
    knobs();
    predictable();
    for (const canvas of Object.values(parts.panels)) watched(canvas, draw);
    watched(parts.space, redrawTrees);
    await simulate();
    if (!place.isConnected) return;
    state.fit = state.run;
    state.trees = [treeIn(parts.space, model, () => ({ run: state.run, ...colored() }))];
    draw();
    outdated();
    band(model, parts);
}

/**
 * @param {HTMLElement} place
 * @param {Parts} parts
 * @param {ModelAnswer} model
 * @param {ResultsAnswer} results
 */
function layOut(place, { panels, space, boxes }, model, results) {
    const { animal, law, laws } = model, names = results.animals.map(({ name }) => name);
    const go = (/** @type {string} */ name) => visit("explorer", name, law);
    const walls = laws.map((name) => /** @type {[string, string]} */ ([name, `${name} wall`]));
    const figures = Object.entries(model.panels).map(([name, text]) =>
        h("figure", {}, panels[name], h("figcaption", {}, text))
    );
    fill(
        place,
        rowOf(
            h("h1", {}, "Model of "),
            choice(names, animal, go, { "aria-label": "animal", data: { key: "animal" } }),
            choice(walls, law, (name) => visit("explorer", animal, name), {
                "aria-label": "wall law",
                data: { key: "law" },
            }),
            button("Back to the fit", back, { data: { key: "back" } }),
            labelled(
                "beside it",
                choice(["", ...names.filter((name) => name !== animal)], "", compare, {
                    "aria-label": "another animal beside it",
                    data: { key: "beside" },
                }),
            ),
        ),
        boxes.outdated,
        legend(model),
        boxes.notes,
        h(
            "div",
            { class: "two" },
            h(
                "section",
                { class: "panels", "aria-label": "waveforms" },
                figures,
                h("figure", {}, space, coloringRow(model, state.coloring, redrawTrees), boxes.scale),
                boxes.compared,
            ),
            h("section", { "aria-label": "parameters" }, boxes.knobs, boxes.prediction, boxes.numbers, boxes.walk),
        ),
        groupSection(results, law, go),
    );
}

/**
 * @param {ModelAnswer} model
 * @param {Parts} parts
 */
async function band(model, parts) {
    try {
        const answer = /** @type {BandAnswer} */ (await ask("band", { animal: model.animal, law: model.law }));
        if (model !== state.model) return;
        state.band = answer.band;
        walkIn(parts.boxes.walk, answer.draws, model.knobs, (curves) => {
            state.drawn = curves;
            draw();
        });
        draw();
    } catch (error) {
        complain(error);
    }
}

/**
 * A result that was made anew is shown anew; one that its files have left behind is marked.
 * @param {HTMLElement} place
 */
export async function renew(place) {
    const { model } = state;
    if (!model) return;
    const fresh = await ask("model", { animal: model.animal, law: model.law });
    if (model !== state.model || !place.isConnected) return;
    if (fresh.made !== model.made) await show(place, [model.animal, model.law]);
    else await outdated();
}

async function outdated() {
    const { parts } = state, animals = /** @type {string[]} */ (await ask("outdated"));
    if (!parts || parts !== state.parts || !state.model) return;
    fill(parts.boxes.outdated, animals.includes(state.model.animal) ? h("span", { class: "old" }, OUTDATED) : null);
}

// Sliders: one simulation at a time, always of what is wished last.

function knobs() {
    const { parts, model, values, compared } = state;
    if (parts && model) knobsIn(parts.boxes.knobs, model.knobs, values, compared?.model.knobs || [], move);
}

const sliders = () => ({ ask: predict, moved: Object.keys(state.values).length > 0 });

function predictable() {
    if (state.parts) predictionIn(state.parts.boxes.prediction, null, sliders());
}

async function predict() {
    const { model, parts, values } = state, asked = JSON.stringify(values);
    if (!model || !parts) return;
    fill(parts.boxes.prediction, h("p", { class: "note" }, "Simulating what the data allow, before and after …"));
    try {
        const { animal, law } = model;
        const answer = /** @type {PredictionAnswer} */ (await post("predict", { animal, law, values }));
        if (model !== state.model || asked !== JSON.stringify(state.values)) return;
        predictionIn(parts.boxes.prediction, answer, sliders());
    } catch (error) {
        predictable();
        complain(error);
    }
}

function back() {
    state.values = {};
    knobs();
    move();
}

function move() {
    predictable();
    state.wanted = true;
    if (!state.busy) drain();
}

async function drain() {
    state.busy = true;
    while (state.wanted) {
        state.wanted = false;
        await simulate();
        draw();
    }
    state.busy = false;
}

async function simulate() {
    const { model, values } = state;
    if (!model) return;
    try {
        const run =
            /** @type {Simulation} */ (await post("simulate", { animal: model.animal, law: model.law, values }));
        if (model !== state.model || !state.parts) return;
        state.run = run;
        fill(state.parts.boxes.notes, run.notes.map((note) => h("div", { class: "finding" }, note)));
        notify("");
    } catch (error) {
        complain(error);
    }
}

/**
 * The fit of an animal, with a wall law if it has that.
 * @param {string} animal
 * @param {string} wanted
 * @returns {Promise<{ model: ModelAnswer, run: Simulation }>}
 */
async function fitOf(animal, wanted) {
    const model = /** @type {ModelAnswer} */ (await ask("model", { animal, law: "" }));
    const law = model.laws.includes(wanted) ? wanted : model.law;
    const [fitted, run] = await Promise.all([
        law === model.law ? model : ask("model", { animal, law }),
        post("simulate", { animal, law, values: {} }),
    ]);
    return { model: fitted, run };
}

/**
 * Put another animal's fit beside this one: curves, numbers, sliders and its tree.
 * @param {string} animal
 */
async function compare(animal) {
    const { model, parts } = state;
    if (!model || !parts) return;
    const compared = animal ? await fitOf(animal, model.law).catch(complain) ?? null : null;
    if (model !== state.model) return;
    state.compared = compared;
    state.trees = state.trees.slice(0, 1);
    fill(parts.boxes.compared);
    if (compared) {
        const canvas = treeCanvas(animal);
        const caption = h("figcaption", {}, `${animal}, ${compared.model.law} wall, in the same colors`);
        fill(parts.boxes.compared, h("figure", {}, canvas, caption));
        state.trees.push(treeIn(canvas, compared.model, () => ({ run: compared.run, ...colored() })));
        watched(canvas, redrawTrees);
    }
    knobs();
    draw();
}

// The trees and their scale.

function colored() {
    const runs = [state.run, state.compared?.run].filter((run) => run !== null && run !== undefined);
    return { coloring: state.coloring, range: rangeOf(runs, state.coloring) };
}

function redrawTrees() {
    if (!state.run) return;
    for (const tree of state.trees) tree.redraw();
    scale();
}

function scale() {
    if (state.parts && state.model) {
        scaleIn(state.parts.boxes.scale, state.model.stops, colored().range, state.coloring);
    }
}

// The curves.

function draw() {
    const { model, run, parts } = state;
    if (!model || !run || !parts || !parts.panels.pressure.isConnected) return;
    const fit = state.fit !== run ? state.fit : null, compared = state.compared?.run ?? null;
    const curves = curvesOf({
        measured: model.measured,
        run,
        fit,
        compared,
        drawn: state.drawn,
        band: state.band,
        ink: style("--ink"),
    });
    for (const [name, series] of Object.entries(curves)) {
        plot(parts.panels[name], { series, x: "", log: name === "modulus" });
    }
    for (const tree of state.trees) tree.redraw();
    // What is read of the page's layout is read before anything is written into it.
    numbersIn(parts.boxes.numbers, { model, run }, state.compared);
    scale();
    count(parts.panels.pressure);
}
