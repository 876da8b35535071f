// @ts-check
import { deepEqual, equal, rejects } from "node:assert/strict";
import { ownTitles, problemsOf, shownTitles, wordsOf } from "../../../src/vasowave/workbench/page/animals.js";
import { filesOf, sorted } from "../../../src/vasowave/workbench/page/drop.js";
import { remedyIn } from "../../../src/vasowave/workbench/page/findings.js";
/** @import { Problem } from "../../../src/vasowave/workbench/page/answers.d.ts" */

/** @returns {Problem} */
const problem = (/** @type {string} */ text, error = false, animals = ["A"]) => ({
    text,
    error,
    animals,
    code: "",
    look: true,
    place: "",
    column: "",
    remedies: [],
});
const texts = (/** @type {Problem[]} */ problems) => problems.map(({ text }) => text);

Deno.test("while recordings are read again, what was odd of them stays", () => {
    const study = { problems: [problem("no group", true), problem("odd")] };
    const checked = { problems: [problem("odd"), problem("slow"), problem("broken", true), problem("all", false, [])] };
    deepEqual(texts(problemsOf(study, null, false)), ["no group", "odd"]);
    deepEqual(texts(problemsOf(study, checked, false)), ["no group", "odd", "slow"]);
    deepEqual(texts(problemsOf(study, checked, true)), ["odd", "slow", "broken", "all"]);
});

Deno.test("shown are needed columns, those that are filled, and the lab's own", () => {
    /** @type {[string, string, boolean][]} */
    const columns = [["animal", "", true], ["kind", "", false], ["flow", "", false]];
    const study = { columns, titles: ["animal", "flow", "sex"], rows: [{ animal: "A", flow: "a.csv", sex: "" }] };
    deepEqual(ownTitles(study), ["sex"]);
    deepEqual(shownTitles(study, false), ["animal", "flow", "sex"]);
    deepEqual(shownTitles(study, true), ["animal", "kind", "flow", "sex"]);
});

Deno.test("groups, networks and columns of words are chosen, with nothing first", () => {
    const study = { groups: ["CTL"], networks: ["a.csv"], words: { kind: ["cycle", "raw"] } };
    deepEqual(["group", "network", "kind", "flow"].map((title) => wordsOf(study, title)), [
        ["", "CTL"],
        ["", "a.csv"],
        ["", "cycle", "raw"],
        undefined,
    ]);
});

Deno.test("what is said of several animals opens the one in whose row it is pressed", () => {
    const remedy = { label: "Fill the cell", changes: "Type 'network' of A", open: "A", type: "network" };
    deepEqual(remedyIn(remedy, "B"), { ...remedy, changes: "Type 'network' of B", open: "B" });
    deepEqual(remedyIn(remedy), remedy);
    deepEqual(remedyIn({ label: "", changes: "", acts: [] }, "B"), { label: "", changes: "", acts: [] });
});

Deno.test("pictures, documents and what a system hides beside recordings stay behind", () => {
    const file = new File([], "");
    const names = ["lab/desktop.ini", "Thumbs.db", "plan.docx", "~$animals.xlsx", "a.txt", "lab/scan.nrrd", "b.xlsx"];
    const left = sorted(names.map((name) => [name, file]));
    deepEqual(left.map(([name]) => name), ["a.txt", "b.xlsx", "lab/scan.nrrd"]);
});

Deno.test("files go in the order of their names, hidden ones stay behind", () => {
    const file = new File([], "");
    const names = sorted([["b/2.txt", file], ["a.txt", file], ["b/.git/x", file], ["b/10.txt", file], [".x", file]]);
    deepEqual(names.map(([name]) => name), ["a.txt", "b/10.txt", "b/2.txt"]);
});

/** A dropped file. */
const entry = (/** @type {string} */ name) => ({
    name,
    isFile: true,
    file: (/** @type {(file: File) => void} */ done) => done(new File([name], name)),
});

/** A dropped folder, whose entries come in the parts of a browser. */
const folder = (/** @type {string} */ name, /** @type {object[][]} */ parts) => ({
    name,
    isFile: false,
    createReader: () => {
        const left = [...parts, []];
        return { readEntries: (/** @type {(list: object[]) => void} */ done) => done(left.shift() ?? []) };
    },
});

/** @returns {Promise<[string, File][]>} */
const dropped = (/** @type {any} */ item) => filesOf(item, "");

Deno.test("a dropped folder gives all of its files, however many parts it comes in", async () => {
    const tree = folder("lab", [[entry("a.txt"), folder("deep", [[entry("c.txt")]])], [entry("b.txt")]]);
    const files = await dropped(tree);
    deepEqual(files.map(([name]) => name), ["lab/a.txt", "lab/deep/c.txt", "lab/b.txt"]);
    equal(await (await dropped(entry("x")))[0][1].text(), "x");
});

Deno.test("a file that cannot be read fails the drop", async () => {
    const broken = {
        name: "x",
        isFile: true,
        file: (/** @type {unknown} */ _, /** @type {any} */ fail) => fail(Error("no")),
    };
    await rejects(dropped(broken), /no/);
});
