// @ts-check
// The desks, which of them is shown, and what changed meanwhile.
/** @import { DeskModule, WorkbenchState } from "./answers.d.ts" */
import { act, afterChange, ask, complain, messageOf, notify } from "./ask.js";
import { all, h } from "./dom.js";
import * as explorer from "./explorer.js";
import * as figures from "./figures.js";
import * as lung from "./lung.js";
import * as recording from "./recording.js";
import { etaOf, routeOf } from "./route.js";
import * as study from "./study.js";

/** @type {Record<string, DeskModule>} */
const DESKS = { study, recording, lung, explorer, figures };
const RUNNING_MS = 700, RESTING_MS = 1000;
const place = /** @type {HTMLElement} */ (document.getElementById("desk"));

const state = {
    /** The desk that is shown. */
    open: /** @type {string | null} */ (null),
    answer: /** @type {WorkbenchState | null} */ (null),
    turn: 0,
    room: h("div"),
    /** The look at the server that is under way. */
    looking: /** @type {Promise<void> | null} */ (null),
};

/**
 * Show a desk, or what changed on it; each stands in a room of its own, so that one that comes late covers no other.
 * @param {boolean} fresh
 */
async function show(fresh) {
    const { desk, path } = routeOf(location.hash, Object.keys(DESKS)), turn = fresh ? ++state.turn : state.turn;
    for (const link of all(document, "[data-desk]")) {
        if (link.dataset.desk === desk) link.setAttribute("aria-current", "page");
        else link.removeAttribute("aria-current");
    }
    try {
        if (fresh) {
            state.open = null;
            state.room = h("div", {}, h("p", { class: "note" }, "Reading …"));
            place.replaceChildren(state.room);
            await DESKS[desk].show(state.room, path, state.answer);
        } else await DESKS[desk].renew(state.room, path, state.answer);
    } catch (error) {
        if (turn !== state.turn) return;
        const link = h("a", { href: "#study" }, "To the Study desk");
        if (fresh) state.room.replaceChildren(h("p", { role: "alert" }, messageOf(error)), h("p", {}, link));
        else complain(error);
    }
    if (turn !== state.turn) return;
    state.open = desk;
    document.body.dataset.ready = desk;
}

/** @param {WorkbenchState} answer */
function present({ undo, redo, run }) {
    const button = (/** @type {string} */ id, /** @type {string} */ change, /** @type {string} */ title) => {
        const element = /** @type {HTMLButtonElement} */ (document.getElementById(id));
        element.disabled = !change;
        element.title = change ? `${title}: ${change}` : "";
    };
    button("undo", undo, "Undo (Ctrl+Z)");
    button("redo", redo, "Redo (Ctrl+Y)");
    const animals = Object.values(run.animals), done = animals.filter((animal) => animal.state === "done").length;
    const line = /** @type {HTMLElement} */ (document.getElementById("running"));
    line.textContent = run.runner ? `Running: ${done} of ${animals.length} animals done${etaOf(run.left)}` : "";
}

/** Look whether something changed, one look after another: what takes long is not asked for twice. */
async function look() {
    while (state.looking) await state.looking;
    state.looking = lookOnce();
    try {
        await state.looking;
    } finally {
        state.looking = null;
    }
}

async function lookOnce() {
    const before = state.answer;
    /** @type {WorkbenchState} */
    let answer;
    try {
        answer = await ask("state");
    } catch (error) {
        if (before !== null) complain(error);
        state.answer = null;
        return;
    }
    const changed = before === null || before.mark !== answer.mark || before.run.runner !== answer.run.runner;
    state.answer = answer;
    present(answer);
    if (state.open !== null && changed) await show(false);
    else if (state.open !== null) DESKS[state.open].progress?.(state.room, answer);
}

/** @param {KeyboardEvent} event */
function key(event) {
    const target = /** @type {Element} */ (event.target);
    const typing = target.matches?.("input:not([type=range], [type=checkbox]), textarea, select");
    if (!(event.ctrlKey || event.metaKey) || typing) return;
    const undo = event.key === "z" && !event.shiftKey,
        redo = event.key === "y" || (event.key === "Z" && event.shiftKey);
    if (!undo && !redo) return;
    event.preventDefault();
    act(undo ? "undo" : "redo");
}

async function again() {
    if (!document.hidden && !state.looking) await look();
    if (state.answer?.arrived) await act("add-arrivals");
    setTimeout(again, state.answer?.run.runner ? RUNNING_MS : RESTING_MS);
}

addEventListener("hashchange", () => {
    notify("");
    show(true).then(() => place.focus({ preventScroll: true }));
});
document.getElementById("close")?.addEventListener("click", () => notify(""));
document.getElementById("undo")?.addEventListener("click", () => act("undo"));
document.getElementById("redo")?.addEventListener("click", () => act("redo"));
addEventListener("keydown", key);
afterChange(look);
await look();
await show(true);
setTimeout(again, RESTING_MS);
