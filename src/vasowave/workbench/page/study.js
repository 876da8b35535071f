// The Study desk: files in, the table with what is wrong beside the cell, the run and its report.
import { act, ask, say, upload } from "./ask.js";
import { choice, fill, h } from "./dom.js";

const ALWAYS = ["animal", "group", "network", "recording"];
const FILES = ["network", "recording", "flow", "beat edits", "sites"];
let known = null, checked = null, fresh = false, asked = 0, state = null, more = false, room = null;

export async function show(place, rest, now) {
  checked = null;
  await renew(place, rest, now);
}

export async function renew(place, rest, now) {
  [state, room] = [now, place];
  known = await ask("study");
  fresh = false;
  draw(place);
  if (known.study) check(place);
}

export function progress(place, now) {
  state = now;
  const part = place.querySelector("[data-part=run]");
  if (!part || !known?.study) return;
  fill(part, run());
  for (const row of place.querySelectorAll("tr[data-animal]")) fill(row.querySelector(".state"), status(row.dataset.animal));
}

/** Read all recordings, without keeping the page waiting. */
async function check(place) {
  const mine = ++asked;
  try {
    const found = await ask("check");
    if (mine !== asked || document.body.dataset.ready !== "study" && location.hash.replace("#study", "")) return;
    [checked, fresh] = [found, true];
    draw(place);
  } catch (error) {
    if (mine === asked) say(error.message, true);
  }
}

function draw(place) {
  const typed = document.activeElement;
  if (place.contains(typed) && typed.matches("input[type=text]") && typed.value !== typed.defaultValue) return;
  fill(place, known.study ? [
    h("h1", {}, known.title), h("p", { class: "note" }, known.folder), drop(), groups(), programs(), table(), general(),
    h("section", { data: { part: "run" } }, run()), settings(),
  ] : begin());
}

function begin() {
  const labels = h("input", { type: "text", value: "", placeholder: "CTL, HPH", "aria-label": "Groups, the reference first" });
  const species = choice(known.species, "mouse", () => {}, { "aria-label": "Species" });
  const make = () => act("new-study", { groups: (labels.value || labels.placeholder).split(","), species: species.value });
  return [
    h("h1", {}, "A new study"), h("p", { class: "note" }, known.folder),
    h("p", {}, "Drop the folder with your recordings and networks: groups are told by the names of files and folders."),
    drop(),
    h("p", {}, "Or begin with an empty table:"),
    h("div", { class: "row" }, h("label", {}, "groups, the reference first", labels), h("label", {}, "species", species),
      h("button", { type: "button", onclick: make }, "Make an empty study")),
  ];
}

// Files: from a dialog or dropped, folders with all that is in them.

function drop() {
  const input = (given, text) => {
    const one = h("input", { type: "file", multiple: true, ...given, onchange: () => take([...one.files].map((file) => [file.webkitRelativePath || file.name, file])) });
    return h("label", {}, one, text);
  };
  return h("div", {
    class: "drop",
    ondragover: (event) => { event.preventDefault(); event.currentTarget.classList.add("over"); },
    ondragleave: (event) => event.currentTarget.classList.remove("over"),
    ondrop: async (event) => {
      event.preventDefault();
      event.currentTarget.classList.remove("over");
      const entries = [...event.dataTransfer.items].map((one) => one.webkitGetAsEntry?.()).filter(Boolean);
      take((await Promise.all(entries.map((entry) => walked(entry, "")))).flat());
    },
  }, "Drop recordings and networks here, or choose ", input({ webkitdirectory: true, id: "folder" }, "a folder"),
    input({ id: "files" }, "files"));
}

async function walked(entry, before) {
  const name = before + entry.name;
  if (entry.isFile) return new Promise((done, lost) => entry.file((file) => done([[name, file]]), lost));
  const reader = entry.createReader(), found = [];
  for (;;) {
    const some = await new Promise((done, lost) => reader.readEntries(done, lost));
    if (!some.length) return (await Promise.all(found.map((one) => walked(one, `${name}/`)))).flat();
    found.push(...some);
  }
}

async function take(files) {
  files.sort(([one], [other]) => (one < other ? -1 : 1));
  const names = [], lost = [];
  for (const [name, file] of files) {
    if (name.split("/").some((part) => part.startsWith("."))) continue;
    say(`Copying ${names.length + 1} of ${files.length}: ${name}`);
    try { names.push(await upload(name, file)); } catch (error) { lost.push(error.message); }
  }
  if (names.length) {
    const done = await act("add-files", { files: names });
    if (done && lost.length) say([...done.said, ...lost].join("\n"), true);
  } else say(lost.join("\n") || "There is no file among these.", true);
}

// The table.

/** What is wrong or odd; while the recordings are read again, what was odd of them before stays. */
function problems() {
  if (fresh) return checked.problems;
  const now = new Set(known.problems.map((one) => one.text));
  return [...known.problems, ...(checked?.problems || []).filter((one) => one.animals.length && !one.error && !now.has(one.text))];
}

/** Programs of the study that nobody has allowed to run, to be read first. */
function programs() {
  if (!known.programs.length) return null;
  const named = Object.fromEntries(known.programs.map((one) => [one.name, one.sha256]));
  return h("section", { id: "programs" },
    h("p", {}, "This study brings programs along, which have not run. Read them: a program can do all that you can do on this machine."),
    known.programs.map((one) => h("details", { open: true }, h("summary", {}, one.path), h("pre", {}, one.text))),
    h("button", { type: "button", id: "trust", onclick: () => act("trust-programs", { programs: named }) }, "I have read them: let them run in this study"));
}

function groups() {
  const line = h("input", { type: "text", value: known.groups.join(", "), data: { key: "groups" },
    onchange: () => act("set-groups", { groups: line.value.split(",") }) });
  return h("div", { class: "row" }, h("label", {}, "Groups, the reference first", line));
}

function table() {
  if (!known.rows.length) return h("p", {}, "No animals yet: drop their files above.");
  const used = known.columns.map(([title]) => title).filter((title) =>
    ALWAYS.includes(title) || more || known.rows.some((row) => row[title]));
  used.push(...own());
  const read = checked ? [...checked.header.keys()].slice(2).filter((k) => checked.header[k][0] !== "kind") : [];
  const rows = known.rows.map((row) => {
    const mine = problems().filter((one) => one.animals.includes(row.animal));
    const numbers = checked?.read[row.animal];
    return [
      h("tr", { data: { animal: row.animal } },
        used.map((title) => cell(row, title, mine)),
        h("td", { class: "words state" }, status(row.animal)),
        h("td", {}, h("a", { href: `#recording/${encodeURIComponent(row.animal)}`, "aria-label": `Look at ${row.animal}` }, "look"), " ",
          h("button", { type: "button", title: `Take ${row.animal} out of the table`, "aria-label": `Remove ${row.animal}`,
            onclick: () => act("remove-animal", { animal: row.animal }) }, "×")),
        read.map((k) => h("td", { class: "words" }, numbers ? numbers[k] : ""))),
      mine.length ? h("tr", { class: "found" }, h("td", { colspan: used.length + read.length + 2 }, h("div", {}, mine.map(finding)))) : null,
    ];
  });
  return [
    h("div", { class: "table", data: { scrolls: 1 } }, h("table", { class: "animals" },
      h("thead", {}, h("tr", {}, used.map(head),
        h("th", {}, "state"), h("th", {}), read.map((k) => h("th", {}, checked.header[k][0], checked.header[k][1] ? ` [${checked.header[k][1]}]` : "")))),
      h("tbody", {}, rows))),
    h("label", { class: "note" }, h("input", { type: "checkbox", checked: more, data: { key: "more" },
      onchange: (event) => { more = event.target.checked; draw(room); } }), " all columns"),
    column(),
    h("p", { class: "note", role: "status", id: "checking" }, fresh ? "" : "Reading the recordings …"),
  ];
}

/** Titles of the columns that are the lab's own. */
const own = () => known.titles.filter((title) => !known.columns.some(([one]) => one === title));

const head = (title) => h("th", { title: known.columns.find(([one]) => one === title)?.[1] ?? "a column of your own" }, title,
  own().includes(title) ? [" ", h("button", { type: "button", title: `Take the column ${title} out of the table`, "aria-label": `Remove the column ${title}`,
    onclick: () => act("remove-column", { title }) }, "×")] : null);

function column() {
  const title = h("input", { type: "text", placeholder: "sex, weight [g], …", defaultValue: "", data: { key: "new column" } });
  return h("div", { class: "row" }, h("label", {}, "a column of your own", title),
    h("button", { type: "button", data: { key: "add column" }, onclick: () => title.value.trim() && act("add-column", { title: title.value }) }, "Add it"));
}

function cell(row, title, mine) {
  const wrong = mine.filter((one) => one.column === title), value = row[title] || "";
  const set = (text) => text !== value && act("set-cells", { animal: row.animal, cells: { [title]: text }, was: { [title]: value } }, true);
  const given = { "aria-label": `${title} of ${row.animal}`, data: { key: `${row.animal}/${title}` }, title: wrong.map((one) => one.text).join("\n") };
  const words = { group: ["", ...known.groups], network: ["", ...known.networks], kind: ["", "cycle", "raw"], synthetic: ["", "yes", "no"], "shared recording": ["", "yes", "no"] };
  const control = words[title] ? choice(words[title], value, set, given)
    : h("input", { type: "text", value, defaultValue: value, ...given, onchange: (event) => set(event.target.value) });
  return h("td", { class: [wrong.some((one) => one.error) ? "bad" : wrong.length ? "doubt" : "", FILES.includes(title) ? "file" : ""].join(" ") }, control);
}

const finding = (one) => h("div", { class: one.error ? "finding bad" : "finding" },
  one.column ? `${one.column}: ` : "", one.text,
  one.remedies.map((remedy) => remedy.open
    ? h("button", { type: "button", onclick: () => { location.hash = `recording/${encodeURIComponent(remedy.open)}`; } }, remedy.label)
    : h("button", { type: "button", onclick: async () => { for (const one of remedy.acts) { const { do: what, ...given } = one; await act(what, given); } } }, remedy.label)));

function general() {
  const rest = problems().filter((one) => !one.animals.length);
  return rest.map((one) => h("div", { class: "row" }, h("span", { class: "note" }, one.place.replace(`${known.folder}/`, "")), finding(one)));
}

function status(animal) {
  const now = state?.run.runner ? state.run.animals[animal] : known.status[animal];
  if (!now) return "";
  return known.outdated.includes(animal) && now.state !== "done"
    ? h("span", { class: "old", title: "its row, its files, the settings or the program changed since it was run" }, "outdated") : now.text;
}

// The run.

function run() {
  const errors = problems().filter((one) => one.error).length, going = state?.run.runner, told = state?.run;
  const count = Object.values(told?.animals || {}), done = count.filter((one) => one.state === "done").length;
  const old = known.outdated.length;
  return [
    h("h2", {}, "Run"),
    h("div", { class: "row" },
      going ? h("button", { type: "button", id: "stop", data: { key: "run" }, onclick: () => act("stop") }, "Stop")
        : h("button", { type: "button", id: "run", class: "main", data: { key: "run" }, disabled: !known.rows.length || errors > 0, onclick: () => act("run") },
          Object.values(known.status).some((one) => ["done", "begun"].includes(one.state)) ? "Run, or go on" : "Run"),
      going ? [h("progress", { max: count.length || 1, value: done, "aria-label": "animals done" }), `${done} of ${count.length} animals; by ${going}${told.said && `: ${told.said}`}`] : null,
      state?.report ? h("a", { href: "report/report.html", target: "_blank", rel: "noopener", id: "report" }, "The report") : null,
      state?.results ? h("a", { href: "#explorer" }, "Explore the results") : null,
      old && state?.results ? h("span", { class: "old" }, `outdated: ${old} of the results' animals changed since`) : null),
    errors ? h("p", { class: "note" }, `${errors} error${errors > 1 ? "s" : ""} to mend before it can run.`) : null,
    told?.said && !going ? h("p", { id: "ended", class: told.ended === "finished" ? "note" : "finding bad" }, told.said) : null,
    going ? h("ul", {}, Object.entries(told.animals).map(([name, one]) => h("li", {}, `${name}: ${one.text}`))) : null,
    h("label", { class: "note" }, h("input", { type: "checkbox", checked: told?.stops_with_us, data: { key: "at-end" },
      onchange: (event) => act("at-end", { stop: event.target.checked }) }), " stop a run when the workbench ends (else it goes on)"),
  ];
}

function settings() {
  const open = document.querySelector("#settings")?.open;
  return h("details", { id: "settings", open }, h("summary", {}, "Settings (study.yaml)"), known.settings.map((one) => {
    const input = h("input", { type: "text", value: one.value, defaultValue: one.value, data: { key: `setting ${one.key}` },
      onchange: () => act("set-setting", { key: one.key, value: input.value }) });
    return h("div", { class: "row" }, h("label", { title: one.meaning }, one.key, input), h("span", { class: "note" }, one.meaning));
  }));
}
