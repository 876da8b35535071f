// @ts-check
// The table of animals with what is wrong beside the cell.
/** @import { CheckAnswer, Child, Problem, Row, StudyAnswer } from "./answers.d.ts" */
import { act } from "./ask.js";
import { button, choice, h, hashOf, input, labelled, rowOf } from "./dom.js";
import { findingOf } from "./findings.js";

const NAMES = 3; // of animals beside a note
const LEAD = 2; // columns before what was read: the animal and its group

/**
 * @typedef {object} Table what is shown of the animals
 * @property {CheckAnswer | null} checked
 * @property {boolean} fresh
 * @property {boolean} more
 * @property {Problem[]} problems
 * @property {(animal: string) => Child} statusOf
 * @property {(more: boolean) => unknown} redraw
 */

/**
 * What is wrong or odd; while the recordings are read again, what was odd of them before stays.
 * @param {Pick<StudyAnswer, "problems">} study
 * @param {Pick<CheckAnswer, "problems"> | null} checked
 * @param {boolean} fresh
 */
export function problemsOf(study, checked, fresh) {
    if (fresh && checked) return checked.problems;
    const texts = new Set(study.problems.map(({ text }) => text));
    const odd = (checked?.problems || []).filter(({ animals, error, text }) =>
        animals.length && !error && !texts.has(text)
    );
    return [...study.problems, ...odd];
}

/**
 * Titles of the columns that are the lab's own.
 * @param {Pick<StudyAnswer, "titles" | "columns">} study
 */
export const ownTitles = ({ titles, columns }) => titles.filter((title) => !columns.some(([name]) => name === title));

/**
 * Titles of the columns that are shown: needed ones, those with a cell that is filled, or all; then the lab's own.
 * @param {Pick<StudyAnswer, "titles" | "columns" | "rows">} study
 * @param {boolean} more
 */
export function shownTitles(study, more) {
    const titles = study.columns.filter(([title, , needed]) => needed || more || study.rows.some((row) => row[title]));
    return [...titles.map(([title]) => title), ...ownTitles(study)];
}

/**
 * @param {StudyAnswer} study
 * @param {Table} table
 */
export function tableOf(study, table) {
    const { fresh, more, redraw } = table, { header } = study;
    if (!study.rows.length) return h("p", {}, "No animals yet: drop their files above.");
    const titles = shownTitles(study, more);
    const read = [...header.keys()].slice(2).filter((k) => header[k][0] !== "kind");
    const heads = read.map((k) => h("th", {}, header[k][0], header[k][1] ? ` [${header[k][1]}]` : ""));
    const named = titles.map((title) => headOf(study, title));
    const head = h("tr", {}, named.slice(0, LEAD), h("th", {}), heads, h("th", {}, "state"), named.slice(LEAD));
    const body = study.rows.map((row) => rowsOf(study, row, titles, read, table));
    const box = input({ type: "checkbox", checked: more, data: { key: "more" } }, (element) => redraw(element.checked));
    return [
        h(
            "div",
            { class: "table", data: { scrolls: 1 } },
            h("table", { class: "animals" }, h("thead", {}, head), h("tbody", {}, body)),
        ),
        h("label", { class: "note" }, box, " all columns"),
        newColumn(),
        h("p", { class: "note", role: "status", id: "checking" }, fresh ? "" : "Reading the recordings …"),
    ];
}

/**
 * The row of an animal, and below it what is wrong or odd.
 * @param {StudyAnswer} study
 * @param {Row} row
 * @param {string[]} titles
 * @param {number[]} read columns of what was read of the recordings
 * @param {Table} table
 */
function rowsOf(study, row, titles, read, { checked, problems, statusOf }) {
    const { animal } = row, numbers = checked?.read[animal];
    const wrong = problems.filter(({ animals }) => animals.includes(animal));
    const remove = button("×", () => act("remove-animal", { animal }), {
        title: `Take ${animal} out of the table`,
        "aria-label": `Remove ${animal}`,
    });
    const cells = titles.map((title) => cellOf(study, row, title, wrong));
    const link = h("a", { href: `#${hashOf(["recording", animal])}`, "aria-label": `Look at ${animal}` }, "look");
    return [
        h(
            "tr",
            { data: { animal } },
            cells.slice(0, LEAD),
            h("td", {}, link, " ", remove),
            read.map((k) => h("td", { class: "words" }, numbers ? numbers[k] : "")),
            h("td", { class: "words state" }, statusOf(animal)),
            cells.slice(LEAD),
        ),
        wrong.length > 0 &&
        h(
            "tr",
            { class: "found" },
            h(
                "td",
                { colspan: titles.length + read.length + 2 },
                h("div", {}, wrong.map((problem) => findingOf(problem, animal))),
            ),
        ),
    ];
}

/**
 * @param {StudyAnswer} study
 * @param {string} title
 */
function headOf(study, title) {
    const meaning = study.columns.find(([name]) => name === title)?.[1] ?? "a column of your own";
    const remove = ownTitles(study).includes(title) && button("×", () => act("remove-column", { title }), {
        title: `Take the column ${title} out of the table`,
        "aria-label": `Remove the column ${title}`,
    });
    return h("th", { title: meaning }, title, remove && [" ", remove]);
}

function newColumn() {
    const title = h("input", {
        type: "text",
        placeholder: "sex, weight [g], …",
        defaultValue: "",
        data: { key: "new column" },
    });
    const add = () => title.value.trim() && act("add-column", { title: title.value });
    return rowOf(labelled("a column of your own", title), button("Add it", add, { data: { key: "add column" } }));
}

/**
 * What a cell may hold, of columns of words; undefined for text.
 * @param {Pick<StudyAnswer, "groups" | "networks" | "words">} study
 * @param {string} title
 */
export function wordsOf({ groups, networks, words }, title) {
    const list = { group: groups, network: networks, ...words }[title];
    return list && ["", ...list];
}

/**
 * @param {StudyAnswer} study
 * @param {Row} row
 * @param {string} title
 * @param {Problem[]} problems of the animal
 */
function cellOf(study, row, title, problems) {
    const wrong = problems.filter(({ column }) => column === title), value = row[title] || "", { animal } = row;
    const set = (/** @type {string} */ text) =>
        text !== value && act("set-cells", { animal, cells: { [title]: text }, was: { [title]: value } }, true);
    const attributes = {
        "aria-label": `${title} of ${animal}`,
        data: { key: `${animal}/${title}` },
        title: wrong.map(({ text }) => text).join("\n"),
    };
    const words = wordsOf(study, title);
    const control = words
        ? choice(words, value, set, attributes)
        : input({ type: "text", value, defaultValue: value, ...attributes }, (element) => set(element.value));
    const grade = wrong.some(({ error }) => error) ? "bad" : wrong.length ? "doubt" : "";
    return h("td", { class: `${grade} ${study.files.includes(title) ? "file" : ""}` }, control);
}

/**
 * What is wrong of no animal.
 * @param {StudyAnswer} study
 * @param {Problem[]} problems
 */
export const generalFindings = ({ folder }, problems) =>
    problems.filter(({ animals }) => !animals.length).map((problem) =>
        rowOf(h("span", { class: "note" }, problem.place.replace(`${folder}/`, "")), findingOf(problem))
    );

/**
 * What was understood and assumed, and asks for nothing.
 * @param {CheckAnswer | null} checked
 */
export function notesOf(checked) {
    const notes = checked?.notes || [];
    if (!notes.length) return null;
    const names = (/** @type {string[]} */ animals) =>
        animals.slice(0, NAMES).join(", ") + (animals.length > NAMES ? ` and ${animals.length - NAMES} more` : "");
    const details = /** @type {HTMLDetailsElement | null} */ (document.querySelector("#notes"));
    return h(
        "details",
        { id: "notes", open: details?.open },
        h("summary", {}, `${notes.length} ${notes.length > 1 ? "notes" : "note"} of the check`),
        notes.map((note) => rowOf(h("span", { class: "note" }, names(note.animals)), findingOf(note))),
    );
}
