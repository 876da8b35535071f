// @ts-check
// Walk through models that the data allow: one after another, each with its curves and its values.
/** @import { Curves, Draws, Knob } from "./answers.d.ts" */
import { fill, formatted, h, input, labelled, player, rowOf, symbol } from "./dom.js";

const STEP_MS = 400;

/**
 * The values of the k-th draw, counted from 1, with symbols and units; none for 0.
 * @param {Draws} draws
 * @param {Pick<Knob, "name" | "symbol" | "unit">[]} knobs
 * @param {number} k
 */
export function valuesOf(draws, knobs, k) {
    const named = new Map(knobs.map((knob) => [knob.name, knob]));
    return k === 0 ? [] : Object.entries(draws.values).map(([name, list]) => ({
        name,
        symbol: named.get(name)?.symbol || name,
        unit: named.get(name)?.unit || "",
        value: list[k - 1],
    }));
}

/**
 * The draw after another: 1 after the last.
 * @param {number} k
 * @param {number} count
 */
export const following = (k, count) => k % count + 1;

/**
 * The section of the desk for draws; `show` is called with the curves of a draw, or null.
 * @param {HTMLElement} place
 * @param {Draws} draws
 * @param {Knob[]} knobs
 * @param {(curves: Partial<Curves> | null) => unknown} show
 */
export function walkIn(place, draws, knobs, show) {
    if (!draws?.count) {
        fill(place);
        return;
    }
    const numbers = h("div", { class: "numbers" }), out = h("output", {}, "none");
    const slider = input(
        {
            type: "range",
            min: 0,
            max: draws.count,
            step: 1,
            value: 0,
            "aria-label": draws.kind,
            data: { key: "draw" },
        },
        () => step(Number(slider.value)),
        "input",
    );

    /** @param {number} k */
    function step(k) {
        out.textContent = k ? `${k} of ${draws.count}` : "none";
        slider.setAttribute("aria-valuetext", out.textContent);
        fill(
            numbers,
            valuesOf(draws, knobs, k).map((drawn) =>
                h(
                    "div",
                    {},
                    h("span", {}, symbol(drawn.symbol), " ", h("small", {}, drawn.unit)),
                    h("b", { data: { drawn: drawn.name } }, formatted(drawn.value)),
                )
            ),
        );
        show(k ? draws.curves[k - 1] : null);
    }

    const next = (/** @type {number} */ k) => following(k, draws.count);
    const play = player(slider, next, step, { key: "play draws", ms: STEP_MS });
    const row = rowOf(labelled(draws.kind, slider, out), play);
    fill(place, h("h2", {}, "One by one"), row, numbers);
}
