// @ts-check
// Networks in space: choose a network and a quantity as color, turn it, pick a vessel and see its waveforms.
(() => {
    "use strict";
    /**
     * @typedef {object} Network
     * @property {string} label
     * @property {string[]} names
     * @property {number[]} radius cm
     * @property {[number[], number[]][]} axes
     * @property {number} period s
     * @property {number[][]} pressure by vessel
     * @property {number[][]} flow
     * @property {Quantity[]} quantities
     *
     * @typedef {object} Quantity
     * @property {string} label
     * @property {(number | null)[]} values by vessel
     *
     * @typedef {object} Controls
     * @property {HTMLSelectElement} picker of the network
     * @property {HTMLSelectElement} colored
     * @property {HTMLInputElement} moment
     *
     * @typedef {object} Scene a figure and what it shows
     * @property {HTMLElement} figure
     * @property {Networks} data
     * @property {Controls} controls
     * @property {Network} network
     * @property {SpaceView | null} view
     * @property {number[]} range
     * @property {number} chosen
     *
     * @typedef {object} Networks
     * @property {number[][]} stops colors
     * @property {Network[]} networks
     */
    /** @type {[string, "pressure" | "flow"][]} */
    const WAVES = [["pressure over the cycle [mmHg]", "pressure"], ["flow over the cycle [ml/s]", "flow"]];
    const UNKNOWN = "#9e9e9e", REACH = 16;

    const digits = (/** @type {number | null} */ value) =>
        value === null ? "not known" : String(Number(value.toPrecision(3)));

    /** The waves of a vessel over those of the root, in a box of the drawing, with their range. */
    const panel = (
        /** @type {number[]} */ wave,
        /** @type {number[]} */ root,
        /** @type {number} */ top,
        label = "",
    ) => {
        const [low, high] = [Math.min(...wave, ...root), Math.max(...wave, ...root)];
        const y = (/** @type {number} */ value) => top + 92 - 84 * (value - low) / (high - low || 1);
        const path = (/** @type {number[]} */ row) =>
            [...row, row[0]].map((value, k) =>
                `${k ? "L" : "M"}${(56 + 240 * k / row.length).toFixed(1)},${y(value).toFixed(1)}`
            ).join("");
        const step = 10 ** (Math.floor(Math.log10(high - low || 1)) - 2); // long numbers would leave the panel
        const short = (/** @type {number} */ value) =>
            value && Math.abs(value) < 0.01 ? value.toExponential(1) : digits(value);
        const end = (/** @type {number} */ value) => short(Math.round(value / step) * step || 0);
        return `<path d="${path(root)}" stroke="${UNKNOWN}"/>` +
            `<path d="${path(wave)}" stroke="currentColor" stroke-width="2"/>` +
            `<text x="52" y="${top + 14}" text-anchor="end">${end(high)}</text>` +
            `<text x="52" y="${top + 94}" text-anchor="end">${end(low)}</text>` +
            `<text x="56" y="${top + 4}">${label}</text>`;
    };

    const elementOf = (
        /** @type {Scene} */ { figure },
        /** @type {string} */ name,
    ) => /** @type {HTMLElement} */ (figure.querySelector(`[data-part="${name}"]`));
    const hide = (/** @type {HTMLElement} */ control, /** @type {boolean} */ hidden) => {
        if (control.parentElement) control.parentElement.hidden = hidden;
    };

    const mix = (/** @type {number[][]} */ stops, /** @type {number} */ share) => {
        const place = Math.min(0.9999, Math.max(0, share)) * (stops.length - 1), k = Math.floor(place);
        const channel = (/** @type {number} */ i) => stops[k][i] + (place - k) * (stops[k + 1][i] - stops[k][i]);
        return `rgb(${[0, 1, 2].map((i) => Math.round(channel(i)))})`;
    };
    const waveOf = (/** @type {Scene} */ { controls, network }) =>
        WAVES[controls.colored.selectedIndex - network.quantities.length]?.[1];
    const sampleOf = (/** @type {Scene} */ { controls, network }) =>
        Math.round(Number(controls.moment.value) * (network.pressure[0].length - 1));
    /** @returns {(number | null)[]} */
    const valuesOf = (/** @type {Scene} */ scene) => {
        const { network, controls } = scene, wave = waveOf(scene);
        if (wave) return network[wave].map((row) => row[sampleOf(scene)]);
        return network.quantities[controls.colored.selectedIndex].values;
    };

    const draw = (/** @type {Scene} */ scene, /** @type {SpaceView} */ view) => {
        const { figure, data, network: { axes, radius }, chosen, range: [low, high] } = scene;
        const ink = getComputedStyle(figure).color, values = valuesOf(scene);
        const pieces = axes.map(([from, to], row) => ({ from: view.project(from), to: view.project(to), row }));
        pieces.sort((a, b) => b.from[2] + b.to[2] - a.from[2] - a.to[2]);
        for (const { from, to, row } of pieces) {
            const width = Math.max(2, 2 * radius[row] * view.unit()), value = values[row];
            const color = value === null ? UNKNOWN : mix(data.stops, (value - low) / (high - low || 1));
            view.line(from, to, width + (row === chosen ? 5 : 1.5), ink);
            view.line(from, to, width, color);
        }
        view.scaleBar(ink);
    };

    /** The vessel under the pointer, -1 where there is none. */
    const nearest = (/** @type {Network} */ { axes }, /** @type {SpaceView} */ view, /** @type {Pixels} */ [x, y]) => {
        let best = -1, least = REACH;
        axes.forEach(([from, to], row) => {
            const [a, b] = [view.project(from), view.project(to)], [dx, dy] = [b[0] - a[0], b[1] - a[1]];
            const along = ((x - a[0]) * dx + (y - a[1]) * dy) / (dx ** 2 + dy ** 2 || 1);
            const share = Math.min(1, Math.max(0, along));
            const gap = Math.hypot(a[0] + share * dx - x, a[1] + share * dy - y);
            if (gap < least) [least, best] = [gap, row];
        });
        return best;
    };

    /** The picked vessel in words, and its waves. */
    const describe = (/** @type {Scene} */ scene) => {
        const { network, chosen } = scene, { pressure, flow } = network;
        const quantities = network.quantities.map(({ label, values }) => {
            const unit = label.match(/\[(.*)\]/)?.[1], name = label.replace(/ \[(.*)\]/, "");
            return `${name} ${digits(values[chosen])}${unit === "1" ? "" : ` ${unit}`}`;
        });
        elementOf(scene, "said").textContent =
            `Vessel ${network.names[chosen]}: radius ${digits(network.radius[chosen])} cm; ` + quantities.join("; ");
        elementOf(scene, "waveforms").innerHTML = panel(pressure[chosen], pressure[0], 12, "pressure [mmHg]") +
            panel(flow[chosen], flow[0], 128, "flow [ml/s]") +
            `<text x="296" y="238" text-anchor="end">${digits(network.period)} s</text>` +
            `<text x="56" y="238">0</text>`;
    };

    const repaint = (/** @type {Scene} */ scene) => {
        const { network, data, controls, view } = scene, wave = waveOf(scene);
        const values = wave ? network[wave].flat() : valuesOf(scene);
        const numbers = /** @type {number[]} */ (values.filter((value) => value !== null));
        const seconds = network.period * sampleOf(scene) / network.pressure[0].length;
        const colors = data.stops.map((stop) => `rgb(${stop})`).join(", ");
        hide(controls.moment, !wave);
        elementOf(scene, "when").textContent = `${digits(seconds)} s`;
        scene.range = [Math.min(...numbers), Math.max(...numbers)];
        elementOf(scene, "bar").style.background = `linear-gradient(to right, ${colors})`;
        elementOf(scene, "low").textContent = digits(scene.range[0]);
        elementOf(scene, "high").textContent = digits(scene.range[1]);
        view?.redraw();
    };

    const show = (/** @type {Scene} */ scene) => {
        const { data, controls: { picker, colored } } = scene, before = colored.selectedIndex;
        const network = scene.network = data.networks[picker.selectedIndex];
        const labels = [...network.quantities.map(({ label }) => label), ...WAVES.map(([label]) => label)];
        scene.chosen = 0;
        colored.replaceChildren(...labels.map((label) => new Option(label)));
        colored.selectedIndex = Math.max(0, before);
        // Without the listeners of the network before.
        const canvas = /** @type {HTMLCanvasElement} */ (elementOf(scene, "canvas").cloneNode());
        elementOf(scene, "canvas").replaceWith(canvas);
        const view = turntable(canvas, network.axes.flat(), (view) => draw(scene, view), (x, y) => {
            const row = nearest(network, view, [x, y]);
            if (row >= 0) scene.chosen = row;
            describe(scene);
            view.redraw();
        });
        scene.view = view;
        view.rotate(0.5, 0.3); // so that it is seen to be no plane
        describe(scene);
        repaint(scene);
    };

    for (const figure of /** @type {NodeListOf<HTMLElement>} */ (document.querySelectorAll("figure.space"))) {
        const data = /** @type {Networks} */ (JSON.parse(figure.querySelector("script")?.textContent ?? ""));
        const control = (
            /** @type {string} */ name,
        ) => /** @type {any} */ (figure.querySelector(`[data-part=${name}]`));
        const controls = { picker: control("network"), colored: control("quantity"), moment: control("moment") };
        /** @type {Scene} */
        const scene = { figure, data, controls, network: data.networks[0], view: null, range: [0, 1], chosen: 0 };
        figure.hidden = false;
        controls.picker.replaceChildren(...data.networks.map(({ label }) => new Option(label)));
        hide(controls.picker, data.networks.length < 2);
        controls.picker.addEventListener("change", () => show(scene));
        controls.colored.addEventListener("change", () => repaint(scene));
        controls.moment.addEventListener("input", () => repaint(scene));
        show(scene);
    }
})();
