// @ts-check
// The tree of an extraction: a click names a vessel and the nearest place on its axis.
(() => {
    "use strict";
    /**
     * @typedef {object} Vessel
     * @property {string} name
     * @property {boolean} terminal
     * @property {number[][]} points x, y, z and radius
     * @property {boolean} marked
     * @property {string} radius
     * @property {string} length
     * @property {string} doubts
     *
     * @typedef {object} Tree
     * @property {number} factor
     * @property {number[]} root
     * @property {Vessel[]} vessels
     * @property {number[][]} doubts
     * @property {number[][]} missing
     *
     * @typedef {object} Chosen
     * @property {Vessel} vessel
     * @property {number[]} point
     * @property {boolean} end whether the point is the vessel's outlet
     */
    const PICKED = "#d6259b", REACH = 14;
    const element = (/** @type {string} */ id) => /** @type {HTMLElement} */ (document.getElementById(id));
    const field = (/** @type {string} */ id) => /** @type {HTMLTextAreaElement} */ (element(id));
    const tree = /** @type {Tree} */ (JSON.parse(element("tree-data").textContent ?? ""));
    const { root, vessels, missing } = tree;
    const canvas = /** @type {HTMLCanvasElement} */ (element("tree"));
    const editors = /** @type {NodeListOf<HTMLButtonElement>} */ (document.querySelectorAll("button[data-edit]"));
    const state = { chosen: /** @type {Chosen | null} */ (null) };

    const shade = (/** @type {number} */ far, /** @type {boolean} */ strong, /** @type {boolean} */ doubted) => {
        const mix = (/** @type {number} */ near, /** @type {number} */ away) =>
            Math.round(near + (away - near) * 0.75 * far);
        if (strong) return "rgb(214,37,155)";
        if (doubted) return `rgb(${mix(217, 245)},${mix(95, 205)},${mix(2, 170)})`;
        return `rgb(${mix(0, 205)},${mix(92, 225)},${mix(112, 230)})`;
    };

    const endOf = (/** @type {Vessel} */ vessel) => vessel.points[vessel.points.length - 1];
    const ends = vessels.filter((vessel) => vessel.terminal).map(endOf);

    const draw = (/** @type {SpaceView} */ view) => {
        const pieces = vessels.flatMap((vessel) => {
            const places = vessel.points.map(view.project);
            return vessel.points.slice(1).map((point, i) => {
                const radius = (vessel.points[i][3] + point[3]) / 2, [from, to] = [places[i], places[i + 1]];
                return { far: (from[2] + to[2]) / 2, from, to, width: Math.max(1, 2 * radius * view.unit()), vessel };
            });
        });
        pieces.sort((a, b) => b.far - a.far);
        for (const { far, from, to, width, vessel } of pieces) {
            view.line(from, to, width, shade(far, vessel === state.chosen?.vessel, vessel.marked));
        }
        const [outside, inlet] = [view.project(root), view.project(vessels[0].points[0])];
        view.line(outside, inlet, 1, PICKED, [4, 4]);
        view.spot(outside, PICKED, 5);
        for (const end of ends) view.spot(view.project(end), "#b26a00", 3);
        for (const doubt of tree.doubts) cross(view, view.project(doubt));
        if (state.chosen) view.spot(view.project(state.chosen.point), "#000000", 5);
        view.scaleBar("#37474f");
    };

    const cross = (/** @type {SpaceView} */ view, /** @type {Vector} */ [x, y]) => {
        for (const side of [-1, 1]) view.line([x - 6, y - 6 * side], [x + 6, y + 6 * side], 2, "#000000");
    };

    const nearest = (/** @type {number} */ x, /** @type {number} */ y) => {
        let best = null, least = REACH;
        for (const vessel of vessels) {
            for (const point of vessel.points) {
                const [px, py] = view.project(point), end = vessel.terminal && point === endOf(vessel);
                const gap = Math.hypot(px - x, py - y) - (end ? 4 : 0);
                if (gap < least) [least, best] = [gap, { vessel, point, end }];
            }
        }
        return best;
    };

    const number = (/** @type {number} */ value) => String(Number((value / tree.factor).toFixed(4)));
    const place = (/** @type {number[]} */ point, /** @type {string} */ between) =>
        point.slice(0, 3).map(number).join(between);
    const lines = (/** @type {number[][]} */ points) => points.map((point) => `${place(point, ",")}\n`).join("");

    const pick = (/** @type {number} */ x, /** @type {number} */ y) => {
        const chosen = state.chosen = nearest(x, y), vessel = chosen?.vessel;
        element("picked").textContent = !chosen || !vessel
            ? "Nothing there."
            : `Vessel ${vessel.name}: radius ${vessel.radius} cm, length ${vessel.length} cm. ` +
                `${chosen.end ? "Its outlet" : "Place on its axis"} (x,y,z, cm): ${place(chosen.point, ",")}` +
                (vessel.doubts ? `. Doubted: ${vessel.doubts}` : "");
        for (const button of editors) button.disabled = !chosen;
        view.redraw();
    };

    for (const button of editors) {
        button.addEventListener("click", () => {
            const kind = button.dataset.edit, point = state.chosen?.point ?? [];
            if (kind === "outlet") field("outlets").value += lines([point]);
            else field("edits").value += `${kind} ${place(point, " ")}\n`;
        });
    }
    element("all-outlets").addEventListener("click", () => {
        field("outlets").value += lines(ends);
    });
    document.getElementById("missing")?.addEventListener("click", () => {
        field("outlets").value += lines(missing);
    });
    const view = turntable(canvas, [root, ...vessels.flatMap(({ points }) => points)], draw, pick);
    view.redraw();
})();
