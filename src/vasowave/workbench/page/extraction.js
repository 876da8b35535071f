// @ts-check
// What is wished for of an extraction: the row of settings, and the sliders of the window and the wall.
/** @import { Wishes } from "./answers.d.ts" */
/** @import { LungState } from "./lung.js" */
/** @import { Image } from "./slices.js" */
import { act } from "./ask.js";
import { button, choice, fill, formatted, h, input, labelled, rowOf, typedNumber } from "./dom.js";

/** @typedef {"threshold" | "cannula" | "pressure"} NumberWish */

/**
 * @typedef {object} Acts what the row does
 * @property {(name: keyof Wishes) => unknown} changed
 * @property {() => unknown} search
 * @property {() => unknown} write
 */

/**
 * @param {HTMLElement} place
 * @param {LungState} state
 * @param {Acts} acts
 */
export function wishesIn(place, state, { changed, search, write }) {
    const { wishes, stale, extraction, image, lung } = state;
    const number = (/** @type {NumberWish} */ name, /** @type {string} */ text, /** @type {number | "any"} */ step) => {
        const attributes = { type: "number", value: wishes[name] ?? "", step, data: { key: name } };
        return labelled(
            text,
            input(attributes, (element) => {
                wishes[name] = typedNumber(element.value);
                changed(name);
            }),
        );
    };
    const voxel = input({ type: "text", size: 9, value: wishes.voxel ?? "", data: { key: "voxel" } }, (element) => {
        wishes.voxel = element.value.trim() || null;
        changed("voxel");
    });
    const species = choice(lung.species, wishes.species, (value) => {
        wishes.species = value;
        changed("species");
    }, { data: { key: "species" } });
    const loops = input({ type: "checkbox", checked: wishes.open_loops, data: { key: "loops" } }, (element) => {
        wishes.open_loops = element.checked;
        changed("open_loops");
    });
    const finder = button(stale && extraction ? "Find the vessels again" : "Find the vessels", search, {
        id: "find",
        class: stale || !extraction ? "main" : "",
        disabled: !image,
        data: { key: "find" },
    });
    const disabled = !extraction || stale;
    fill(
        place,
        rowOf(
            number("threshold", "wall at grey level", "any"),
            number("cannula", "cannula, inner ⌀ [cm]", 0.001),
            number("pressure", "filled at [mmHg]", "any"),
            labelled("species", species),
            labelled("voxel [cm] (or x,y,z), else the file's", voxel),
            labelled(loops, "open loops"),
            finder,
            button("Write the network", write, { id: "write", disabled, data: { key: "write" } }),
            network(state),
        ),
    );
}

/**
 * How the network that is written stands to what is shown, and what can be done with it.
 * @param {LungState} state
 */
function network({ stale, extraction, lung }) {
    const file = `lungs/${lung.image}/network.csv`;
    const use = lung.written && !stale && button(
        "Use it for all animals that have none",
        () => act("use-network", { network: file }),
        { data: { key: "use" } },
    );
    if (stale && extraction) return h("span", { class: "old" }, "outdated: something was changed since");
    if (!lung.written) return null;
    const note = lung.outdated
        ? h("span", { class: "old" }, "network.csv is older than the edits")
        : h("span", { class: "note" }, `${file} is written`);
    return [note, use];
}

/**
 * @param {HTMLElement} place
 * @param {LungState} state
 * @param {Image} image
 * @param {{ moved: () => unknown, changed: () => unknown }} acts while a slider moves, and when the wall has moved
 */
export function slidersIn(place, state, image, { moved, changed }) {
    /**
     * @param {"dark" | "bright" | "threshold"} name
     * @param {string} text
     * @param {number | null} value
     * @param {(value: number) => number} set
     */
    const slider = (name, text, value, set) => {
        const out = h("output", {}, formatted(value, 3));
        const range = input({
            type: "range",
            min: image.low,
            max: image.high,
            step: "any",
            value,
            data: { key: `slide ${name}`, slide: name },
        }, (element) => {
            out.textContent = formatted(set(Number(element.value)), 3);
            moved();
        }, "input");
        if (name === "threshold") range.addEventListener("change", changed);
        return labelled(text, range, out);
    };
    fill(
        place,
        rowOf(
            slider("dark", "black at", state.window.dark, (value) => state.window.dark = value),
            slider("bright", "white at", state.window.bright, (value) => state.window.bright = value),
            slider(
                "threshold",
                "wall at",
                state.wishes.threshold,
                (value) => state.wishes.threshold = Number(value.toPrecision(4)),
            ),
        ),
        h(
            "p",
            { class: "keys" },
            "Blue tint: above the wall's grey level. Lines: axes of the vessels, strong where they run in the slice; " +
                "orange: doubted, in space with crosses where; pink: the picked vessel, and the dot where the blood " +
                "enters. Wheel or ",
            h("kbd", {}, "Page up"),
            " ",
            h("kbd", {}, "Page down"),
            " go through the slices, Ctrl with the wheel or ",
            h("kbd", {}, "+"),
            " ",
            h("kbd", {}, "−"),
            " zoom, Shift drags, arrows move the place.",
        ),
    );
}
