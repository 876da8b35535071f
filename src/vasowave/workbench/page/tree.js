// @ts-check
// What stands beside an image: the picked place and its vessel, doubts, edits, and the table of vessels.
/** @import { Doubt, LungAnswer, Vessel, VesselsAnswer } from "./answers.d.ts" */
/** @import { LungState } from "./lung.js" */
import { act } from "./ask.js";
import { button, fill, formatted, h, labelled, rowOf } from "./dom.js";
import { middleOf } from "./vessels.js";

/** @typedef {(place: readonly number[], name?: string) => unknown} Go */
/** @typedef {(action: string, more?: object) => unknown} Edit */

/**
 * What is known of a vessel, in one sentence.
 * @param {Vessel} vessel
 */
export function describe({ radius, sd, reliable, length, parent, doubts }) {
    return `Radius ${formatted(radius, 3)} ± ${formatted(sd, 2)} cm${reliable ? "" : ", not reliable"}; ` +
        `length ${formatted(length, 3)} cm; ${parent ? `daughter of ${parent}` : "the root"}` +
        `${doubts.length ? `; doubted: ${doubts.join(", ")}` : ""}.`;
}

/**
 * What was found, in one sentence.
 * @param {Pick<VesselsAnswer, "vessels" | "generations" | "total" | "scale">} extraction
 */
export function summary({ vessels, generations, total, scale }) {
    const terminal = vessels.filter((vessel) => vessel.terminal).length;
    return `${vessels.length} vessels, ${terminal} of them terminal, in ${generations} generations; ` +
        `${formatted(total, 3)} cm in all` +
        (scale === null ? "." : `; the cannula measures ${formatted(scale, 2)} % off its size.`);
}

/**
 * The picked place, and what can be done there.
 * @param {HTMLElement} box
 * @param {LungState} state
 * @param {Edit} edit
 * @param {(place: number[] | null) => unknown} move begin to move the end at a place, or leave it
 */
export function pickedIn(box, { extraction, chosen, place, moving }, edit, move) {
    const vessel = extraction?.vessels.find(({ name }) => name === chosen);
    const text = vessel ? describe(vessel) : extraction ? "No vessel is near." : "";
    const position = place.map((value) => value.toFixed(4)).join(", ");
    const carry = () => [
        h("strong", {}, "Pick where the end goes, then"),
        button("move it here", () => edit("move", { to: place }), { class: "main" }),
        button("leave it", () => move(null)),
    ];
    fill(
        box,
        h("h2", {}, vessel ? `Vessel ${vessel.name}` : "Place"),
        h("p", { class: "note", id: "picked" }, `x, y, z: ${position} cm along the image's axes. `, text),
        moving ? rowOf(carry()) : [
            rowOf(editor("Blood enters here", "root", edit), editor("An outlet", "outlet", edit)),
            extraction && editRow(vessel, edit, () => move([...place])),
            vessel && radiusRow(vessel, edit),
        ],
    );
}

/**
 * @param {string} text
 * @param {string} action
 * @param {Edit} edit
 * @param {boolean} [disabled]
 */
const editor = (text, action, edit, disabled = false) =>
    button(text, () => edit(action), { disabled, data: { key: action, edit: action } });

/**
 * @param {Vessel | undefined} vessel
 * @param {Edit} edit
 * @param {() => unknown} move
 */
const editRow = (vessel, edit, move) =>
    rowOf(
        editor("Remove, and all beyond", "remove", edit, !vessel),
        editor("Cut here", "cut", edit, !vessel),
        editor("Merge to a point", "merge", edit, !vessel),
        button("Move this end …", move, { disabled: !vessel, data: { key: "move" } }),
    );

/**
 * @param {Vessel} vessel
 * @param {Edit} edit
 */
function radiusRow(vessel, edit) {
    const radius = h("input", {
        type: "number",
        min: 0,
        step: "any",
        value: vessel.radius ?? "",
        "aria-label": "radius, cm",
        data: { key: "radius" },
    });
    const set = () => edit("radius", { radius: Number(radius.value) });
    return rowOf(labelled("radius [cm]", radius), button("Set it", set, { data: { key: "set radius" } }));
}

/**
 * Where a doubt is looked at: its first place, else the middle of its first vessel.
 * @param {Doubt} doubt
 * @param {Pick<Vessel, "name" | "points">[]} vessels
 * @returns {readonly number[] | undefined}
 */
export function placeOf({ places, vessels: names }, vessels) {
    const middles = names.flatMap((name) => vessels.filter((vessel) => vessel.name === name).map(middleOf));
    return [...places, ...middles][0];
}

/**
 * @param {HTMLElement} box
 * @param {VesselsAnswer} extraction
 * @param {Go} go
 */
export function doubtsIn(box, { doubts, vessels, notes }, go) {
    const visit = (/** @type {Doubt} */ doubt) => {
        const place = placeOf(doubt, vessels);
        if (place) go(place, doubt.vessels[0]);
    };
    const rows = doubts.map((doubt, k) =>
        h(
            "div",
            { class: "finding" },
            `${doubt.about}: ${doubt.text}`,
            button("look", () => visit(doubt), { data: { key: `doubt ${k}`, doubt: k } }),
        )
    );
    fill(
        box,
        h("h2", {}, doubts.length ? `Doubts: ${doubts.length}` : "No doubts"),
        rows,
        notes.length > 0 && h(
            "details",
            {},
            h("summary", {}, "What was noted"),
            notes.map((note) => h("div", { class: "finding plain" }, note)),
        ),
    );
}

/**
 * @param {HTMLElement} box
 * @param {LungAnswer} lung
 */
export function editsIn(box, lung) {
    const file = `in edits/${lung["file of edits"]}, which vasowave extract --edits reads`;
    const rows = lung.edits.map(([line, text]) =>
        rowOf(
            h("code", {}, text),
            button("forget", () => act("forget-edit", { image: lung.image, line, text }), {
                data: { key: `forget ${line}` },
            }),
        )
    );
    fill(box, h("h2", {}, "Edits"), h("p", { class: "note" }, lung.edits.length ? file : "None yet."), rows);
}

/**
 * @param {HTMLElement} box
 * @param {VesselsAnswer} extraction
 * @param {Go} go
 */
export function tableIn(box, { vessels }, go) {
    const titles = ["vessel", "parent", "length [cm]", "radius [cm]", "SD [cm]", "reliable", "doubted", ""];
    const rows = vessels.map((vessel) => {
        const { name, parent, length, radius, sd, reliable, doubts } = vessel;
        const numbers = [formatted(length), formatted(radius), formatted(sd, 2)];
        const cells = [name, parent, ...numbers, reliable ? "yes" : "no", doubts.join(", ")];
        const look = button("look", () => go(middleOf(vessel), name), { data: { key: `look ${name}` } });
        return h("tr", { data: { vessel: name } }, [...cells, look].map((cell) => h("td", {}, cell)));
    });
    fill(
        box,
        h("h2", {}, "Vessels"),
        h(
            "div",
            { class: "table", data: { scrolls: 1 } },
            h(
                "table",
                { id: "vessels" },
                h("thead", {}, h("tr", {}, titles.map((title) => h("th", {}, title)))),
                h("tbody", {}, rows),
            ),
        ),
    );
}
