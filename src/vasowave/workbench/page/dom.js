// @ts-check
// Elements made from values: what a file or a person wrote is always text, never markup.
/** @import { Attributes, Child, Option } from "./answers.d.ts" */

/**
 * @param {readonly Child[]} children
 * @returns {(Node | string)[]}
 */
const nodesOf = (children) =>
    children.flatMap((child) => {
        if (child === null || child === undefined || child === false) return [];
        if (Array.isArray(child)) return nodesOf(child);
        return [typeof child === "number" ? String(child) : /** @type {Node | string} */ (child)];
    });

/**
 * Make an element; of `attributes`, `on…` are listeners, `data` a dataset, others properties or attributes.
 * @template {keyof HTMLElementTagNameMap} Tag
 * @param {Tag} tag
 * @param {Attributes} [attributes]
 * @param {...Child} children
 */
export function h(tag, attributes = {}, ...children) {
    const element = document.createElement(tag), properties = /** @type {any} */ (element);
    for (const [name, value] of /** @type {[string, any][]} */ (Object.entries(attributes))) {
        if (value === undefined || value === null || value === false) continue;
        if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
        else if (name === "data") Object.assign(element.dataset, value);
        else if (name === "class") element.className = value;
        else if (name in element && name !== "list") properties[name] = value;
        else element.setAttribute(name, value === true ? "" : value);
    }
    element.append(...nodesOf(children));
    return element;
}

/**
 * A number in `digits` digits, a dash where there is none.
 * @param {number | null | undefined} value
 * @param {number} [digits]
 */
export const formatted = (value, digits = 4) =>
    value === null || value === undefined || !Number.isFinite(value) ? "–" : String(Number(value.toPrecision(digits)));

/**
 * A number that was typed, null for an empty field.
 * @param {string} text
 */
export const typedNumber = (text) => text === "" ? null : Number(text);

/**
 * A symbol with its subscripts below the line: R_T, C_p.
 * @param {string} text
 */
export const symbol = (text) => text.split(/_(\w+)/).map((piece, k) => (k % 2 ? h("sub", {}, piece) : piece));

/** @param {...Child} children */
export const rowOf = (...children) => h("div", { class: "row" }, ...children);

/** @param {...Child} children */
export const labelled = (...children) => h("label", {}, ...children);

/**
 * @param {string} text
 * @param {() => unknown} clicked
 * @param {Attributes} [attributes]
 */
export const button = (text, clicked, attributes = {}) =>
    h("button", { type: "button", ...attributes, onclick: clicked }, text);

/**
 * An input; `changed` is called with it.
 * @param {Attributes} attributes
 * @param {(element: HTMLInputElement) => unknown} changed
 * @param {string} [event]
 */
export function input(attributes, changed, event = "change") {
    const element = h("input", attributes);
    element.addEventListener(event, () => changed(element));
    return element;
}

/**
 * A button that moves a slider on, until it is pressed again or the slider is gone.
 * @param {HTMLInputElement} slider
 * @param {(value: number) => number} next
 * @param {(value: number) => unknown} moved
 * @param {{ key: string, ms: number }} about
 */
export function player(slider, next, moved, { key, ms }) {
    /** @type {ReturnType<typeof setInterval> | undefined} */
    let timer;
    const stop = () => {
        clearInterval(timer);
        timer = undefined;
        element.textContent = "Play";
    };
    const element = button("Play", () => {
        if (timer) return stop();
        element.textContent = "Stop";
        timer = setInterval(() => {
            if (!slider.isConnected) return stop();
            slider.value = String(next(Number(slider.value)));
            moved(Number(slider.value));
        }, ms);
    }, { data: { key } });
    return element;
}

/**
 * A choice; `chosen` is called with the value.
 * @param {readonly Option[]} options
 * @param {string} value
 * @param {(value: string) => unknown} chosen
 * @param {Attributes} [attributes]
 */
export function choice(options, value, chosen, attributes = {}) {
    const pairs = options.map((option) => Array.isArray(option) ? option : [option, option || "–"]);
    const element = h("select", attributes, pairs.map(([name, text]) => h("option", { value: name }, text)));
    element.addEventListener("change", () => chosen(element.value));
    if (value && !pairs.some(([name]) => name === value)) element.append(h("option", { value }, value));
    element.value = value;
    return element;
}

/**
 * Elements inside another.
 * @param {ParentNode} place
 * @param {string} selector
 */
export const all = (place, selector) => [.../** @type {NodeListOf<HTMLElement>} */ (place.querySelectorAll(selector))];

/**
 * Replace what an element holds, and give the keyboard back to the control that had it.
 * @param {Element} place
 * @param {...Child} children
 */
export function fill(place, ...children) {
    const focused = /** @type {HTMLElement | null} */ (document.activeElement);
    const key = place.contains(focused) ? focused?.dataset?.key : null;
    const scrolled = all(place, "[data-scrolls]").map((element) => element.scrollLeft);
    place.replaceChildren(...nodesOf(children));
    all(place, "[data-scrolls]").forEach((element, k) => {
        element.scrollLeft = scrolled[k] || 0;
    });
    if (key) all(place, "[data-key]").find((element) => element.dataset.key === key)?.focus({ preventScroll: true });
}

/**
 * Count in the dataset of an element that it was drawn.
 * @param {HTMLElement} element
 * @param {string} [name]
 */
export function count(element, name = "drawn") {
    element.dataset[name] = String(Number(element.dataset[name] || 0) + 1);
}

/**
 * Lead to a desk, and there to an animal or image.
 * @param {...string} path
 */
export function visit(...path) {
    location.hash = hashOf(path);
}

/**
 * The address of a desk.
 * @param {readonly string[]} path
 */
export const hashOf = ([desk, ...path]) => [desk, ...path.map(encodeURIComponent)].join("/");
