// @ts-check
// The Study desk: files in, the table with what is wrong beside the cell, the run and its report.
/** @import { CheckAnswer, EmptyFolder, StudyAnswer, WorkbenchState } from "./answers.d.ts" */
import { act, ask, complain } from "./ask.js";
import { all, button, choice, fill, h, input, labelled, rowOf } from "./dom.js";
import { dropZone } from "./drop.js";
import { generalFindings, notesOf, problemsOf, tableOf } from "./animals.js";

/**
 * @typedef {object} StudyState
 * @property {StudyAnswer | null} study
 * @property {CheckAnswer | null} checked what was read of the recordings last
 * @property {boolean} fresh whether that is of the study as it stands
 * @property {number} turn
 * @property {WorkbenchState | null} workbench
 * @property {boolean} more whether all columns are shown
 */

const NAMED = 4; // files that are named in a line

/** @type {StudyState} */
const state = { study: null, checked: null, fresh: false, turn: 0, workbench: null, more: false };

/**
 * @param {HTMLElement} place
 * @param {string[]} path
 * @param {WorkbenchState | null} workbench
 */
export async function show(place, path, workbench) {
    state.checked = null;
    await renew(place, path, workbench);
}

/**
 * @param {HTMLElement} place
 * @param {string[]} _
 * @param {WorkbenchState | null} workbench
 */
export async function renew(place, _, workbench) {
    state.workbench = workbench;
    const answer = /** @type {StudyAnswer | EmptyFolder} */ (await ask("study"));
    state.study = answer.study ? answer : null;
    state.fresh = false;
    if (!answer.study) {
        if (!isTyping(place)) fill(place, begin(answer));
        return;
    }
    draw(place);
    check(place);
}

/**
 * @param {HTMLElement} place
 * @param {WorkbenchState} workbench
 */
export function progress(place, workbench) {
    const { study } = state, section = place.querySelector("[data-part=run]");
    state.workbench = workbench;
    if (!section || !study) return;
    fill(section, run(study));
    for (const row of all(place, "tr[data-animal]")) {
        const cell = row.querySelector(".state");
        if (cell) fill(cell, status(study, row.dataset.animal ?? ""));
    }
}

/**
 * Read all recordings, without keeping the page waiting.
 * @param {HTMLElement} place
 */
async function check(place) {
    const turn = ++state.turn;
    try {
        const checked = /** @type {CheckAnswer} */ (await ask("check"));
        const away = document.body.dataset.ready !== "study" && location.hash.replace("#study", "");
        if (turn !== state.turn || away) return;
        Object.assign(state, { checked, fresh: true });
        draw(place);
    } catch (error) {
        if (turn !== state.turn) return;
        Object.assign(state, { checked: null, fresh: true });
        draw(place);
        complain(error);
    }
}

/**
 * Whether something is being typed that would be lost.
 * @param {HTMLElement} place
 */
function isTyping(place) {
    const field = document.activeElement;
    return field instanceof HTMLInputElement && place.contains(field) && field.type === "text" &&
        field.value !== field.defaultValue;
}

/** @param {HTMLElement} place */
function draw(place) {
    const { study } = state;
    if (!study || isTyping(place)) return;
    const redraw = (/** @type {boolean} */ more) => {
        state.more = more;
        draw(place);
    };
    const problems = problemsOf(study, state.checked, state.fresh);
    fill(
        place,
        h("h1", {}, study.title),
        h("p", { class: "note" }, study.folder),
        dropZone(),
        waiting(study),
        groups(study),
        programs(study),
        tableOf(study, { ...state, problems, statusOf: (name) => status(study, name), redraw }),
        generalFindings(study, problems),
        h("section", { data: { part: "run" } }, run(study)),
        settings(study),
        notesOf(state.checked),
    );
}

/** @param {EmptyFolder} folder */
function begin({ folder, species }) {
    const labels = h("input", {
        type: "text",
        value: "",
        placeholder: "CTL, HPH",
        "aria-label": "Groups, the reference first",
    });
    const animal = choice(species, "mouse", () => {}, { "aria-label": "Species" });
    const make = () =>
        act("new-study", { groups: (labels.value || labels.placeholder).split(","), species: animal.value });
    return [
        h("h1", {}, "A new study"),
        h("p", { class: "note" }, folder),
        h(
            "p",
            {},
            "Choose the species and drop the folder with your recordings and networks: groups are told by the names of " +
                "files and folders, or by a table of the animals (ID, treatment) among them.",
        ),
        rowOf(labelled("species", animal)),
        dropZone(() => ({ species: animal.value })),
        h("p", {}, "Or begin with an empty table:"),
        rowOf(labelled("groups, the reference first", labels), button("Make an empty study", make)),
    ];
}

/**
 * What becomes of files that are saved into the study's folder, and those there that are in no row.
 * @param {StudyAnswer} study
 */
function waiting({ watched, unlisted }) {
    const names = unlisted.slice(0, NAMED).map((file) => file.replace(`${watched}/`, ""));
    const more = unlisted.length > NAMED ? ` and ${unlisted.length - NAMED} more` : "";
    return rowOf(
        h("p", { class: "note" }, `What is saved in ${watched} while this page is open becomes a row.`),
        unlisted.length > 0 && h("span", { class: "note" }, `In no row: ${names.join(", ")}${more}`),
        unlisted.length > 0 && button("Add them", () => act("add-files", { files: unlisted }), {
            data: { key: "unlisted" },
        }),
    );
}

/**
 * Programs of the study that nobody has allowed to run, to be read first.
 * @param {StudyAnswer} study
 */
function programs({ programs }) {
    if (!programs.length) return null;
    const hashes = Object.fromEntries(programs.map(({ name, sha256 }) => [name, sha256]));
    return h(
        "section",
        { id: "programs" },
        h(
            "p",
            {},
            "This study brings programs along, which have not run. Read them: a program can do all that you " +
                "can do on this machine.",
        ),
        programs.map(({ path, text }) => h("details", { open: true }, h("summary", {}, path), h("pre", {}, text))),
        button("I have read them: let them run in this study", () => act("trust-programs", { programs: hashes }), {
            id: "trust",
        }),
    );
}

/** @param {StudyAnswer} study */
const groups = ({ groups }) =>
    rowOf(labelled(
        "Groups, the reference first",
        input(
            { type: "text", value: groups.join(", "), data: { key: "groups" } },
            (element) => act("set-groups", { groups: element.value.split(",") }),
        ),
    ));

/**
 * @param {StudyAnswer} study
 * @param {string} animal
 */
function status(study, animal) {
    const progress = state.workbench?.run;
    const now = progress?.runner ? progress.animals[animal] : study.status[animal];
    if (!now) return "";
    if (!study.outdated.includes(animal) || now.state === "done") return now.text;
    const title = "its row, its files, the settings or the program changed since it was run";
    return h("span", { class: "old", title }, "outdated");
}

// The run.

/** @param {StudyAnswer} study */
function run(study) {
    const { workbench } = state, progress = workbench?.run, runner = progress?.runner;
    const errors = problemsOf(study, state.checked, state.fresh).filter((problem) => problem.error).length;
    const old = study.outdated.length;
    const ended = progress?.ended === "finished" ? "note" : "finding bad";
    const atEnd = input(
        { type: "checkbox", checked: progress?.stops_with_us, data: { key: "at-end" } },
        (element) => act("at-end", { stop: element.checked }),
    );
    return [
        h("h2", {}, "Run"),
        rowOf(
            starter(study, Boolean(runner), errors),
            progress && runner && meter(progress),
            workbench?.report
                ? h("a", { href: "report/report.html", target: "_blank", rel: "noopener", id: "report" }, "The report")
                : null,
            workbench?.results ? h("a", { href: "#explorer" }, "Explore the results") : null,
            old > 0 && workbench?.results
                ? h("span", { class: "old" }, `outdated: ${old} of the results' animals changed since`)
                : null,
        ),
        !runner && !state.fresh && h("p", { class: "note" }, "It can run when its recordings have been read."),
        errors > 0 && h("p", { class: "note" }, `${errors} error${errors > 1 ? "s" : ""} to mend before it can run.`),
        progress?.said && !runner ? h("p", { id: "ended", class: ended }, progress.said) : null,
        progress && runner
            ? h("ul", {}, Object.entries(progress.animals).map(([name, { text }]) => h("li", {}, `${name}: ${text}`)))
            : null,
        h("label", { class: "note" }, atEnd, " stop a run when the workbench ends (else it goes on)"),
    ];
}

/**
 * The button that begins or stops a run.
 * @param {StudyAnswer} study
 * @param {boolean} running
 * @param {number} errors
 */
function starter({ rows, status }, running, errors) {
    if (running) return button("Stop", () => act("stop"), { id: "stop", data: { key: "run" } });
    const begun = Object.values(status).some(({ state }) => ["done", "begun"].includes(state));
    return button(begun ? "Run, or go on" : "Run", () => act("run"), {
        id: "run",
        class: "main",
        data: { key: "run" },
        disabled: !rows.length || errors > 0 || !state.fresh,
    });
}

/** @param {WorkbenchState["run"]} progress */
function meter({ animals, runner, said }) {
    const states = Object.values(animals), done = states.filter(({ state }) => state === "done").length;
    return [
        h("progress", { max: states.length || 1, value: done, "aria-label": "animals done" }),
        `${done} of ${states.length} animals; by ${runner}${said && `: ${said}`}`,
    ];
}

/** @param {StudyAnswer} study */
function settings({ settings }) {
    const details = /** @type {HTMLDetailsElement | null} */ (document.querySelector("#settings"));
    const rows = settings.map(({ key, value, meaning }) => {
        const attributes = { type: "text", value, defaultValue: value, data: { key: `setting ${key}` } };
        const field = input(attributes, (element) => act("set-setting", { key, value: element.value }));
        return rowOf(h("label", { title: meaning }, key, field), h("span", { class: "note" }, meaning));
    });
    return h("details", { id: "settings", open: details?.open }, h("summary", {}, "Settings (study.yaml)"), rows);
}
