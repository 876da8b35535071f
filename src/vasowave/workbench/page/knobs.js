// @ts-check
// Sliders of a model's parameters, each with its fit, its interval, and where another animal's fit lies.
/** @import { Knob } from "./answers.d.ts" */
import { fill, formatted, h, input, labelled, symbol } from "./dom.js";

const STEPS = 1000;

/**
 * Where a value lies on its slider, by its logarithm: 0 at the left end, 1 at the right one.
 * @param {{ low: number, high: number }} knob
 * @param {number} value
 */
export const shareOf = ({ low, high }, value) => (Math.log(value) - Math.log(low)) / (Math.log(high) - Math.log(low));

/**
 * The value at a place of the slider.
 * @param {{ low: number, high: number }} knob
 * @param {number} share
 */
export const valueAt = ({ low, high }, share) => low * (high / low) ** share;

/**
 * Draw the sliders; `values` are those that were moved, and `moved` is called after each of them.
 * @param {HTMLElement} place
 * @param {Knob[]} knobs
 * @param {Record<string, number>} values
 * @param {Knob[]} compared of the other animal
 * @param {() => unknown} moved
 */
export function knobsIn(place, knobs, values, compared, moved) {
    const fits = new Map(compared.map((knob) => [knob.name, knob.value]));
    fill(
        place,
        knobs.map((knob) => slider(knob, values, fits.get(knob.name), moved)),
        h(
            "p",
            { class: "keys" },
            "The line is the fit, the shade its 95 % interval",
            compared.length ? ", the other line the other animal's fit." : ".",
        ),
    );
}

/**
 * @param {Knob} knob
 * @param {Record<string, number>} values
 * @param {number | undefined} compared
 * @param {() => unknown} moved
 */
function slider(knob, values, compared, moved) {
    const text = () => `${formatted(values[knob.name] ?? knob.value)} ${knob.unit}`;
    const out = h("output", {}, text());
    const range = input({
        type: "range",
        min: 0,
        max: STEPS,
        step: 1,
        value: STEPS * shareOf(knob, values[knob.name] ?? knob.value),
        "aria-label": `${knob.symbol} ${knob.meaning}`,
        "aria-valuetext": text(),
        data: { key: knob.name, knob: knob.name },
    }, (element) => {
        values[knob.name] = valueAt(knob, Number(element.value) / STEPS);
        out.textContent = text();
        element.setAttribute("aria-valuetext", text());
        moved();
    }, "input");
    const title = h("span", {}, symbol(knob.symbol), " ", h("small", {}, symbol(knob.meaning)));
    return h(
        "div",
        { class: "knob", title: knob.meaning },
        labelled(title, out),
        h("div", { class: "track" }, marks(knob, compared), range),
    );
}

/**
 * What stands on the track: the interval, the fit, and the fit of the other animal.
 * @param {Knob} knob
 * @param {number | undefined} compared
 */
function marks(knob, compared) {
    const position = (/** @type {number} */ share) => `calc(8px + (100% - 16px) * ${share})`;
    const fit = h("b"), shade = knob.interval && h("i");
    const mark = compared !== undefined && compared >= knob.low && compared <= knob.high && h("b", { class: "other" });
    fit.style.left = position(shareOf(knob, knob.value));
    if (mark) mark.style.left = position(shareOf(knob, Number(compared)));
    if (shade && knob.interval) {
        const [low, high] = knob.interval.map((value) => Math.min(1, Math.max(0, shareOf(knob, value))));
        shade.style.left = position(low);
        shade.style.width = `calc((100% - 16px) * ${Math.max(0.004, high - low)})`;
    }
    return [shade, fit, mark];
}
