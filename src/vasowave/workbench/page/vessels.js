// @ts-check
// Vessels of an extraction in space, and which of them is near a place.
/** @import { Vessel } from "./answers.d.ts" */
/** @import { LungState } from "./lung.js" */
/** @import { Image } from "./slices.js" */
import { style } from "./plot.js";
import { extent, VIEWS } from "./slices.js";

export const PICKED = "#d6259b";
const DOUBTED = "#d95f02";
const REACH_RADII = 3, REACH_PIXELS = 16;

/**
 * The name of the vessel nearest to a place, by its radius; empty where none is near.
 * @param {Pick<Vessel, "name" | "points">[]} vessels
 * @param {readonly number[]} place
 */
export function nearestVessel(vessels, place) {
    let best = "", least = REACH_RADII;
    for (const { name, points } of vessels) {
        for (const point of points) {
            const gap = Math.hypot(...[0, 1, 2].map((k) => point[k] - place[k])) / Math.max(point[3], 1e-6);
            if (gap < least) [least, best] = [gap, name];
        }
    }
    return best;
}

/**
 * The point in the middle of a vessel's axis.
 * @param {Pick<Vessel, "points">} vessel
 */
export const middleOf = ({ points }) => points[points.length >> 1];

/**
 * A color that pales with the distance from the viewer, 0 to 1.
 * @param {number} distance
 */
export function shade(distance) {
    const mix = (/** @type {number} */ near, /** @type {number} */ far) =>
        Math.round(near + (far - near) * 0.6 * distance);
    return `rgb(${mix(0, 150)},${mix(120, 190)},${mix(150, 200)})`;
}

/**
 * The vessels in space, with the slices and the doubts; a click goes to the nearest vessel.
 * @param {HTMLCanvasElement} canvas
 * @param {Image} image
 * @param {LungState} state
 * @param {(place: readonly number[], name: string) => unknown} go
 */
export function lungTree(canvas, image, state, go) {
    const corners = [0, 1, 2, 3, 4, 5, 6, 7].map((k) => [0, 1, 2].map((axis) => extent(image, axis)[k >> axis & 1]));
    const view = turntable(canvas, corners, (view) => {
        const { extraction, place, chosen } = state, ink = style("--ink");
        drawSlices(view, image, place);
        drawVessels(view, extraction?.vessels || [], chosen);
        for (const [x, y] of (extraction?.doubts || []).flatMap(({ places }) => places.map(view.project))) {
            view.line([x - 5, y - 5], [x + 5, y + 5], 2, ink);
            view.line([x - 5, y + 5], [x + 5, y - 5], 2, ink);
        }
        if (extraction) view.spot(view.project(extraction.root), PICKED, 5);
        view.spot(view.project(place), ink, 4);
        view.scaleBar(ink);
    }, (x, y) => {
        let best = null, least = REACH_PIXELS;
        for (const { name, points } of state.extraction?.vessels || []) {
            for (const point of points) {
                const [px, py] = view.project(point), gap = Math.hypot(px - x, py - y);
                if (gap < least) [least, best] = [gap, { point, name }];
            }
        }
        if (best) go(best.point, best.name);
    });
    view.rotate(0.5, 0.3);
    return view;
}

/**
 * Where the slices lie.
 * @param {SpaceView} view
 * @param {Image} image
 * @param {number[]} place
 */
function drawSlices(view, image, place) {
    const quiet = style("--quiet");
    for (const { right, down } of VIEWS) {
        const corner = (/** @type {number} */ a, /** @type {number} */ b) => {
            const point = [...place];
            point[right] = extent(image, right)[a];
            point[down] = extent(image, down)[b];
            return view.project(point);
        };
        const corners = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
        corners.forEach((from, k) => view.line(from, corners[(k + 1) % 4], 0.6, quiet));
    }
}

/**
 * @param {SpaceView} view
 * @param {Vessel[]} vessels
 * @param {string} chosen
 */
function drawVessels(view, vessels, chosen) {
    const pieces = vessels.flatMap((vessel) =>
        vessel.points.slice(1).map((point, k) => ({
            from: view.project(vessel.points[k]),
            to: view.project(point),
            width: Math.max(1.5, (vessel.points[k][3] + point[3]) * view.unit()),
            vessel,
        }))
    );
    pieces.sort((a, b) => b.from[2] + b.to[2] - a.from[2] - a.to[2]);
    for (const { from, to, width, vessel } of pieces) {
        const plain = vessel.doubts.length ? DOUBTED : shade((from[2] + to[2]) / 2);
        view.line(from, to, width, vessel.name === chosen ? PICKED : plain);
    }
}
