// @ts-check
// The Figure desk: panels at a size, as a file, with the line of Python that draws the same.
/** @import { FigureChoices, ResultsAnswer } from "./answers.d.ts" */
import { ask, complain, file, notify, post } from "./ask.js";
import { button, choice, count, fill, h, input, labelled, rowOf } from "./dom.js";

/** @typedef {"width" | "height" | "font"} Size */
/** @typedef {Record<"line" | "outdated" | "choices" | "of groups" | "numbers" | "hollow", HTMLElement> & { picture: HTMLImageElement }} Parts */

const state = {
    /** What is wished for, as the server takes it. */
    wish: {
        animal: "",
        group: "",
        figure: "ratios",
        panels: ["pressure", "impedance"],
        width: 170,
        height: 60,
        font: 8,
        family: "sans-serif",
        color: "",
        format: "svg",
    },
    parts: /** @type {Parts | null} */ (null),
    /** Address of the picture that is shown. */
    picture: "",
    drawing: 0,
};

/**
 * The groups that can be compared with the reference.
 * @param {Pick<ResultsAnswer, "animals" | "groups" | "reference">} results
 */
export const comparable = ({ animals, groups, reference }) =>
    Object.keys(groups).filter((group) => group !== reference && animals.some((animal) => animal.group === group));

/**
 * @param {HTMLElement} place
 * @param {string[]} path
 */
export async function show(place, path) {
    const results = /** @type {ResultsAnswer} */ (await ask("results"));
    if (!place.isConnected) return; // another desk is wanted by now
    const { animals, groups, reference, figure } = results, { wish } = state;
    const names = animals.map(({ name }) => name), others = comparable(results);
    // A name that no animal has is of two groups.
    const against = (/** @type {string} */ group) => `${group} against ${reference}`;
    if (names.includes(path[0])) wish.animal = path[0];
    else if (!names.includes(wish.animal) && !others.includes(wish.group)) wish.animal = names[0];
    if (wish.animal) wish.group = "";
    // As in the report.
    const ownColor = () => groups[animals.find(({ name }) => name === wish.animal)?.group ?? wish.group];
    wish.color = ownColor();
    const color = input({ type: "color", value: wish.color, data: { key: "color" } }, () => {
        wish.color = color.value;
        draw();
    });
    const choices = h("div", { hidden: Boolean(wish.group) }, panelRow(figure), sizeRow(figure, color));
    const ofGroups = choice(Object.entries(figure.of_groups), wish.figure, (name) => {
        wish.figure = name;
        clear(parts);
        draw();
    }, { "aria-label": "what of the groups", hidden: !wish.group, data: { key: "of groups" } });
    const savers = figure.formats.map((format) =>
        button(`Save ${format === "csv" ? "numbers " : ""}as ${format.toUpperCase()}`, () => save(format), {
            data: { key: `save ${format}` },
            hidden: format === "csv" && !wish.group,
        })
    );
    const parts = state.parts = {
        picture: h("img", { class: "preview", alt: "the figure", hidden: true }),
        line: h("code", { class: "line" }),
        outdated: h("div"),
        choices,
        "of groups": ofGroups,
        numbers: savers[figure.formats.indexOf("csv")],
        hollow: h("p", { class: "note" }, "Grey and hollow: harmonics whose flow is at noise level."),
    };
    const take = (/** @type {string} */ name) => {
        wish.group = names.includes(name) ? "" : others.find((group) => against(group) === name) ?? "";
        wish.animal = wish.group ? "" : name;
        wish.color = color.value = ownColor();
        choices.hidden = Boolean(wish.group);
        ofGroups.hidden = parts.numbers.hidden = !wish.group;
        clear(parts);
        draw();
        outdated();
    };
    const chosen = wish.animal || against(wish.group);
    const picker = choice([...names, ...others.map(against)], chosen, take, {
        "aria-label": "animal, or groups",
        data: { key: "animal" },
    });
    fill(
        place,
        rowOf(h("h1", {}, "Figure of "), picker, ofGroups),
        parts.outdated,
        choices,
        rowOf(savers),
        h("p", {}, "The same again in Python:"),
        parts.line,
        parts.hollow,
        parts.picture,
    );
    outdated();
    await draw();
}

/** @param {FigureChoices} choices */
const panelRow = ({ panels }) =>
    rowOf(
        Object.entries(panels).map(([name, text]) => {
            const box = input(
                { type: "checkbox", checked: state.wish.panels.includes(name), data: { key: `panel ${name}` } },
                () => {
                    const chosen = new Set(state.wish.panels);
                    if (box.checked) chosen.add(name);
                    else chosen.delete(name);
                    state.wish.panels = Object.keys(panels).filter((panel) => chosen.has(panel));
                    draw();
                },
            );
            return labelled(box, text);
        }),
    );

/**
 * @param {FigureChoices} choices
 * @param {HTMLElement} color
 */
function sizeRow({ families }, color) {
    const { wish } = state;
    const family = choice(families, wish.family, (name) => {
        wish.family = name;
        draw();
    }, { data: { key: "family" } });
    return rowOf(
        size("width", "width [mm]", 20, 400),
        size("height", "height [mm]", 20, 400),
        size("font", "letters [pt]", 4, 24),
        labelled("font", family),
        labelled("color of the model", color),
    );
}

/**
 * @param {Size} name
 * @param {string} text
 * @param {number} min
 * @param {number} max
 */
function size(name, text, min, max) {
    const value = state.wish[name];
    const field = input({ type: "number", value, min, max, step: "any", size: 5, data: { key: name } }, () => {
        state.wish[name] = Number(field.value);
        draw();
    });
    return labelled(text, field);
}

/** Draw anew what may have been computed anew. */
export async function renew() {
    if (!state.parts?.picture.isConnected) return;
    await Promise.all([draw(), outdated()]);
}

async function outdated() {
    const { parts, wish } = state, animals = /** @type {string[]} */ (await ask("outdated"));
    if (!parts || parts !== state.parts) return;
    const text = "outdated: its row, its files or the settings changed since this was computed";
    const old = wish.animal ? animals.includes(wish.animal) : animals.length > 0;
    fill(parts.outdated, old ? h("span", { class: "old" }, text) : null);
}

async function draw() {
    const { wish, parts } = state;
    if (!parts) return;
    if (!wish.panels.length) {
        notify("Choose at least one panel.", true);
        return;
    }
    const turn = ++state.drawing;
    if (wish.group) notify("Comparing the groups …"); // seconds, the first time
    try {
        const [content, { line }] = await Promise.all([
            file("figure", { ...wish, format: "svg" }),
            post("figure", { ...wish, only: "line" }),
        ]);
        if (turn === state.drawing) present(content, line);
    } catch (error) {
        if (turn !== state.drawing) return;
        clear(state.parts ?? parts);
        complain(error);
    }
}

/**
 * @param {Blob} content
 * @param {string} line
 */
function present(content, line) {
    const { wish, parts } = state;
    if (!parts) return;
    if (state.picture) URL.revokeObjectURL(state.picture);
    state.picture = URL.createObjectURL(content);
    parts.picture.src = state.picture;
    parts.picture.hidden = false;
    const impedance = wish.animal && wish.panels.includes("impedance");
    parts.hollow.style.visibility = impedance ? "" : "hidden"; // the picture stays where it is
    parts.picture.style.width = wish.animal ? `${wish.width}mm` : "";
    parts.line.textContent = line;
    count(parts.picture);
    notify("");
}

/**
 * Take away what shows something else than what is chosen.
 * @param {Parts} parts
 */
function clear(parts) {
    parts.picture.hidden = true;
    parts.line.textContent = "";
}

/** @param {string} format */
async function save(format) {
    const { wish } = state;
    try {
        const href = URL.createObjectURL(await file("figure", { ...wish, format }));
        h("a", { href, download: `${wish.animal || wish.group}.${format}` }).click();
        setTimeout(() => URL.revokeObjectURL(href), 1000);
    } catch (error) {
        complain(error);
    }
}
