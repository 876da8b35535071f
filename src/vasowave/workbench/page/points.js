// @ts-check
// Numbers of animals and groups as points: which are shown, where they stand, and which of them is near.
/** @import { Estimate, Means, ResultsAnswer } from "./answers.d.ts" */
/** @import { Curve } from "./plot.js" */
import { formatted } from "./dom.js";

/**
 * @typedef {object} Column animals of a group, or its mean, from left to right
 * @property {string} name
 * @property {string | null} animal null: the mean
 * @property {string} color
 * @property {string} group
 * @property {[string, Estimate][]} values by source
 *
 * @typedef {object} Spot
 * @property {number} x
 * @property {number} y
 * @property {string | null} animal
 * @property {string} text
 */

const REACH = 14; // pixels from the pointer

/** @param {string} source */
export const sourceText = (source) => source === "measured" ? "measured" : `${source} wall`;

/**
 * Everything that is shown from left to right: animals of a group, then its mean, group after group.
 * @param {Pick<ResultsAnswer, "animals" | "groups">} results
 * @param {Means} means
 * @param {string} quantity
 * @param {{ sources: string[], hiddenGroups: Set<string> }} shown
 * @returns {Column[]}
 */
export function columnsOf({ animals, groups }, means, quantity, { sources, hiddenGroups }) {
    /** @param {(source: string) => Estimate | undefined} estimate */
    const values = (estimate) =>
        sources.flatMap((source) => {
            const value = estimate(source);
            return value && value[0] !== null ? [/** @type {[string, Estimate]} */ ([source, value])] : [];
        });
    return Object.entries(groups).filter(([group]) => !hiddenGroups.has(group)).flatMap(([group, color]) => {
        const members = animals.filter((animal) => animal.group === group);
        const columns = members.map(({ name, laws }) => ({
            name,
            animal: /** @type {string | null} */ (name),
            color,
            group,
            values: values((source) => laws[source]?.[quantity]),
        }));
        if (members.length > 1) {
            const mean = values((source) => means[source]?.[group]);
            columns.push({ name: `mean ${group}`, animal: null, color, group, values: mean });
        }
        return columns.filter((column) => column.values.length);
    });
}

/**
 * Points of columns with their intervals; sources stand beside one another.
 * @param {Column[]} columns
 * @param {{ sources: Record<string, boolean>, symbol: string, unit: string }} about
 */
export function pointsOf(columns, { sources, symbol, unit }) {
    const points = /** @type {Spot[]} */ ([]), series = /** @type {Curve[]} */ ([]);
    columns.forEach(({ name, animal, color, values }, k) =>
        values.forEach(([source, [value, low, high]], j) => {
            const x = k + 1 + (values.length > 1 ? 0.5 * (j / (values.length - 1) - 0.5) : 0);
            const style = { color, hollow: !sources[source] };
            if (low !== null && high !== null) {
                series.push({ x: [x, x], y: [low, high], ...style, width: animal ? 1.5 : 3 });
            }
            series.push({ x: [x], y: [value], ...style, points: true, size: animal ? 3.5 : 6 });
            const interval = low === null ? "" : ` (${formatted(low, 3)} to ${formatted(high, 3)})`;
            const text = `${name}, ${sourceText(source)}: ${symbol} = ${formatted(value)} ${unit}${interval}`;
            points.push({ x, y: Number(value), animal, text });
        })
    );
    return { points, series };
}

/**
 * The spot nearest to a pointer, null where none is near.
 * @param {Spot[]} spots
 * @param {number} x
 * @param {number} y
 */
export function nearest(spots, x, y) {
    let best = null, least = REACH;
    for (const spot of spots) {
        const gap = Math.hypot(spot.x - x, spot.y - y);
        if (gap < least) [least, best] = [gap, spot];
    }
    return best;
}

/**
 * A range that shows all values, and of endless intervals as much as helps.
 * @param {number[]} values
 * @param {number[]} ends
 * @returns {[number, number]}
 */
export function spread(values, ends) {
    const [low, high] = [Math.min(...values), Math.max(...values)], room = (high - low) || Math.abs(high) || 1;
    const near = ends.filter((end) => end > low - 2 * room && end < high + 2 * room);
    const [from, to] = [Math.min(low, ...near), Math.max(high, ...near)];
    return [from - 0.06 * (to - from || room), to + 0.06 * (to - from || room)];
}
