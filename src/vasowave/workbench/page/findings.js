// @ts-check
// Findings with their code and a button for each cure, which says what it will change.
/** @import { Finding, Problem, Remedy } from "./answers.d.ts" */
import { act } from "./ask.js";
import { all, button, h, visit } from "./dom.js";

const LOOK_MS = 100, LOOKS = 50;

/**
 * @param {Finding | Problem} finding
 * @param {string} [animal] in whose row it stands
 */
export const findingOf = (finding, animal) =>
    h(
        "div",
        { class: `finding${"error" in finding && finding.error ? " bad" : finding.look ? "" : " plain"}` },
        "column" in finding && finding.column ? `${finding.column}: ` : "",
        finding.text,
        finding.remedies.map((remedy) => remedyOf(remedyIn(remedy, animal))),
        h("small", { class: "code" }, finding.code),
    );

/**
 * A remedy that opens something of the first of several animals, for the one in whose row it stands.
 * @param {Remedy} remedy
 * @param {string} [animal]
 * @returns {Remedy}
 */
export const remedyIn = (remedy, animal) =>
    animal && remedy.open && remedy.open !== animal
        ? { ...remedy, open: animal, changes: remedy.changes.replace(remedy.open, animal) }
        : remedy;

/** @param {Remedy} remedy */
export const remedyOf = (remedy) => button(remedy.label, () => mend(remedy), { title: remedy.changes });

/** @param {Remedy} remedy */
async function mend({ open, desk, type, acts = [] }) {
    for (const { do: action, ...values } of acts) await act(action, values);
    if (type && focused(open ? `${open}/${type}` : type)) return;
    if (open) visit("recording", open);
    if (desk) visit(desk);
    for (let k = 0; type && k < LOOKS && !focused(type); k++) await new Promise((done) => setTimeout(done, LOOK_MS));
}

/**
 * Give the keyboard to the field of a cell or a setting; returns whether it is on the page.
 * @param {string} key
 */
function focused(key) {
    const field = all(document, "[data-key]").find((element) => element.dataset.key === key);
    const details = field?.closest("details");
    if (details) details.open = true;
    field?.scrollIntoView({ block: "center" });
    field?.focus();
    return Boolean(field);
}
