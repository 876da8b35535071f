// @ts-check
import { deepEqual, equal } from "node:assert/strict";
import {
    all,
    button,
    choice,
    count,
    fill,
    formatted,
    h,
    hashOf,
    input,
    symbol,
    typedNumber,
} from "../../../src/vasowave/workbench/page/dom.js";
import { etaOf, routeOf } from "../../../src/vasowave/workbench/page/route.js";
import { fakeDocument } from "./fake.js";

/** @returns {any} */
const plain = (/** @type {unknown} */ element) => element;

Deno.test("numbers are shown in so many digits, a dash where there is none", () => {
    equal(formatted(1234.567), "1235");
    equal(formatted(0.00012346), "0.0001235");
    equal(formatted(20, 3), "20");
    deepEqual([null, undefined, NaN, Infinity].map((value) => formatted(value)), ["–", "–", "–", "–"]);
});

Deno.test("an empty field is not a number, and 0 is one", () => {
    deepEqual(["", "0", "4.5e1"].map(typedNumber), [null, 0, 45]);
});

Deno.test("an address of a desk is taken apart as it was made", () => {
    const desks = ["study", "explorer"], path = ["CTL 1/2", "linear"];
    equal(hashOf(["explorer", ...path]), "explorer/CTL%201%2F2/linear");
    deepEqual(routeOf(`#${hashOf(["explorer", ...path])}`, desks), { desk: "explorer", path });
    deepEqual(routeOf("", desks), { desk: "study", path: [] });
    deepEqual(routeOf("#elsewhere/x", desks), { desk: "study", path: ["x"] });
});

Deno.test("time left is in seconds, from a minute and a half on in minutes", () => {
    deepEqual([null, 0, 89.4, 90, 600].map(etaOf), [
        "",
        ", about 0 s left",
        ", about 89 s left",
        ", about 2 min left",
        ", about 10 min left",
    ]);
});

Deno.test("an element has properties, attributes, data and listeners; text is never markup", () => {
    fakeDocument();
    let clicks = 0;
    const attributes = { class: "a", value: "v", role: "img", hidden: false, title: null, data: { key: "k" } };
    const element = plain(h("p", { ...attributes, onclick: () => clicks++ }, "<b>", [1, [null, false, "x"]]));
    deepEqual([element.className, element.value, element.dataset.key], ["a", "v", "k"]);
    deepEqual(element.attributes, { role: "img" });
    deepEqual(element.children, ["<b>", "1", "x"]);
    element.dispatchEvent(new Event("click"));
    equal(clicks, 1);
});

Deno.test("subscripts stand below the line", () => {
    fakeDocument();
    const [before, subscript, after] = symbol("R_T of C_p");
    equal(before, "R");
    equal(plain(subscript).tag, "sub");
    equal(after, " of C");
});

Deno.test("a choice offers its options, and a value that is none of them", () => {
    fakeDocument();
    /** @type {string[]} */
    const chosen = [];
    const element = plain(choice(["", ["a", "first"]], "z", (value) => chosen.push(value)));
    deepEqual(element.children.map((/** @type {any} */ { value, textContent }) => [value, textContent]), [
        ["", "–"],
        ["a", "first"],
        ["z", "z"],
    ]);
    equal(element.value, "z");
    element.value = "a";
    element.dispatchEvent(new Event("change"));
    deepEqual(chosen, ["a"]);
});

Deno.test("an input hands itself on when it changes, a button when it is clicked", () => {
    fakeDocument();
    const heard = /** @type {string[]} */ ([]);
    input({ value: "5" }, ({ value }) => heard.push(value)).dispatchEvent(new Event("change"));
    input({ value: "6" }, ({ value }) => heard.push(value), "input").dispatchEvent(new Event("change"));
    button("Go", () => heard.push("go")).dispatchEvent(new Event("click"));
    deepEqual(heard, ["5", "go"]);
});

Deno.test("what is filled anew keeps the keyboard and how far it was scrolled", () => {
    const document = fakeDocument();
    const made = () => [h("i", { data: { key: "a" } }), h("div", { data: { scrolls: 1 } })];
    const place = h("main", {}, made());
    document.activeElement = all(place, "[data-key]")[0];
    all(place, "[data-scrolls]")[0].scrollLeft = 40;
    fill(place, made());
    const [key] = all(place, "[data-key]"), [scrolled] = all(place, "[data-scrolls]");
    equal(key === document.activeElement, false);
    equal(plain(key).focused, true);
    equal(scrolled.scrollLeft, 40);
});

Deno.test("drawings are counted", () => {
    fakeDocument();
    const element = h("i");
    count(element);
    count(element);
    deepEqual({ ...element.dataset }, { drawn: "2" });
});
