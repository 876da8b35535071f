// @ts-check
// Findings with their code and a button for each cure, which says what it will change.
/** @import { Finding, Problem, Remedy } from "./answers.d.ts" */
import { act } from "./ask.js";
import { all, button, h, visit } from "./dom.js";

const LOOK_MS = 100, LOOKS = 50;

/** @param {Finding | Problem} finding */
export const findingOf = (finding) =>
    h(
        "div",
        { class: `finding${"error" in finding && finding.error ? " bad" : finding.look ? "" : " plain"}` },
        "column" in finding && finding.column ? `${finding.column}: ` : "",
        finding.text,
        finding.remedies.map(remedyOf),
        h("small", { class: "code" }, finding.code),
    );

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
