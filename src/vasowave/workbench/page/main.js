// The desks, which of them is shown, and what changed meanwhile.
import { act, afterChange, ask, say } from "./ask.js";
import { h } from "./dom.js";
import * as explorer from "./explorer.js";
import * as figures from "./figures.js";
import * as lung from "./lung.js";
import * as recording from "./recording.js";
import * as study from "./study.js";

const DESKS = { study, recording, lung, explorer, figures };
const place = document.getElementById("desk"), running = document.getElementById("running");
let open = null, state = null, turn = 0, room = null;

const wanted = () => {
  const [desk, ...rest] = location.hash.slice(1).split("/");
  return { desk: desk in DESKS ? desk : "study", rest: rest.map(decodeURIComponent) };
};

/** Show a desk, or what changed on it; each stands in a room of its own, so that one that comes late covers no other. */
async function show(fresh) {
  const { desk, rest } = wanted(), mine = fresh ? ++turn : turn;
  document.querySelectorAll("[data-desk]").forEach((one) => {
    one.dataset.desk === desk ? one.setAttribute("aria-current", "page") : one.removeAttribute("aria-current");
  });
  try {
    if (fresh) {
      open = null;
      room = h("div", {}, h("p", { class: "note" }, "Reading …"));
      place.replaceChildren(room);
      await DESKS[desk].show(room, rest, state);
    } else await DESKS[desk].renew?.(room, rest, state);
  } catch (error) {
    if (mine !== turn) return;
    say(error.message, true);
    if (fresh) room.replaceChildren(h("p", {}, error.message), h("p", {}, h("a", { href: "#study" }, "To the Study desk")));
  }
  if (mine !== turn) return;
  open = desk;
  document.body.dataset.ready = desk;
}

function told(now) {
  const button = (id, what, name) => {
    const one = document.getElementById(id);
    one.disabled = !what;
    one.title = what ? `${name}: ${what}` : "";
  };
  button("undo", now.undo, "Undo (Ctrl+Z)");
  button("redo", now.redo, "Redo (Ctrl+Y)");
  const left = now.run.left === null ? "" : `, about ${now.run.left < 90 ? `${Math.round(now.run.left)} s` : `${Math.round(now.run.left / 60)} min`} left`;
  const done = Object.values(now.run.animals).filter((one) => one.state === "done").length;
  running.textContent = now.run.runner ? `Running: ${done} of ${Object.keys(now.run.animals).length} animals done${left}` : "";
}

let looking = null;

/** Look whether something changed, one look after another: what takes long is not asked for twice. */
async function look() {
  while (looking) await looking;
  looking = lookOnce();
  try { await looking; } finally { looking = null; }
}

async function lookOnce() {
  let now;
  try {
    now = await ask("state");
  } catch (error) {
    if (state !== null) say(error.message, true);
    state = null;
    return;
  }
  const changed = state === null || state.mark !== now.mark || state.run.runner !== now.run.runner;
  state = now;
  told(now);
  if (open !== null && changed) await show(false);
  else DESKS[open]?.progress?.(room, now);
}

addEventListener("hashchange", () => { say(""); show(true).then(() => place.focus({ preventScroll: true })); });
document.getElementById("undo").addEventListener("click", () => act("undo"));
document.getElementById("redo").addEventListener("click", () => act("redo"));
addEventListener("keydown", (event) => {
  const typing = event.target.matches?.("input:not([type=range], [type=checkbox]), textarea, select");
  if (!(event.ctrlKey || event.metaKey) || typing) return;
  if (event.key === "z" && !event.shiftKey) { event.preventDefault(); act("undo"); }
  else if (event.key === "y" || (event.key === "Z" && event.shiftKey)) { event.preventDefault(); act("redo"); }
});
afterChange(look);

(async () => {
  await look();
  await show(true);
  const again = async () => { if (!document.hidden && !looking) await look(); setTimeout(again, state?.run.runner ? 700 : 1000); };
  setTimeout(again, 1000);
})();
