// @ts-check
// A page is whole without this. With it, curves are read where the pointer is, and an animal picked is marked
// everywhere.
(() => {
    "use strict";
    /**
     * @typedef {HTMLElement | SVGGraphicsElement} Markable
     * @typedef {[number, number]} Range
     *
     * @typedef {object} Scale what a panel says in its units
     * @property {Range} x
     * @property {Range} y
     * @property {[string, string]} labels
     *
     * @typedef {object} Line
     * @property {number[][]} points
     * @property {string} name
     *
     * @typedef {object} Panel
     * @property {SVGGraphicsElement} patch
     * @property {DOMRect} box
     * @property {Scale} scale
     * @property {Line[]} lines
     */

    /** @returns {Markable[]} */
    const all = (
        /** @type {string} */ selector,
        /** @type {ParentNode} */ place = document,
    ) => [.../** @type {NodeListOf<Markable>} */ (place.querySelectorAll(selector))];
    const reading = /** @type {HTMLElement} */ (document.getElementById("reading"));

    // Picking: one animal with all its recordings, kept in the address so that the other document marks it too.
    const picks = all("[data-animals]")[0];
    /** @type {Record<string, string>} */
    const animals = JSON.parse(picks?.dataset.animals ?? "{}");
    const owner = (/** @type {string} */ recording) => animals[recording] || recording;
    const pick = (/** @type {string} */ name) => {
        for (const mark of all("[data-animal]")) {
            const picked = owner(mark.dataset.animal ?? "") === name;
            mark.classList.toggle("picked", picked);
            mark.classList.toggle("faded", name !== "" && !picked);
        }
        for (const button of all("[data-pick]")) {
            button.setAttribute("aria-pressed", String(button.dataset.pick === name));
        }
        for (const link of all("a[data-other]")) {
            /** @type {HTMLAnchorElement} */ (link).hash = name ? "pick=" + encodeURIComponent(name) : "";
        }
        document.body.dataset.picked = name;
    };
    for (const row of all(".picks")) /** @type {HTMLElement} */ (row).hidden = false;
    document.addEventListener("click", (event) => {
        const target = /** @type {Element} */ (event.target);
        /** @type {Markable | null} */
        const mark = target.closest("[data-pick], svg [data-animal], tr[data-animal]");
        if (!mark) return;
        const name = mark.dataset.pick || owner(mark.dataset.animal ?? "");
        pick(document.body.dataset.picked === name ? "" : name);
    });
    const requested = () => location.hash.startsWith("#pick=") ? decodeURIComponent(location.hash.slice(6)) : null;
    addEventListener("hashchange", () => {
        const name = requested();
        if (name !== null) pick(name);
    });
    pick(requested() || "");

    // Reading a curve: its path is a list of points in the drawing; the panel says what they are in its units.
    const pointsOf = (/** @type {Element} */ path) => {
        const numbers = (path.getAttribute("d")?.match(/-?[\d.]+(e-?\d+)?/g) ?? []).map(Number);
        return numbers.flatMap((x, k) => k % 2 ? [] : [[x, numbers[k + 1]]]);
    };
    const between = (/** @type {number} */ value, /** @type {Range} */ from, /** @type {Range} */ to) =>
        to[0] + (value - from[0]) / (from[1] - from[0]) * (to[1] - to[0]);
    const heightAt = (/** @type {number[][]} */ points, /** @type {number} */ x) => {
        const k = points.findIndex((point, k) => k > 0 && (points[k - 1][0] - x) * (point[0] - x) <= 0);
        if (k < 1) return null;
        const [before, after] = [points[k - 1], points[k]];
        return between(x, [before[0], after[0] + 1e-9], [before[1], after[1]]);
    };
    const titleOf = (/** @type {Element | null} */ group) => group?.querySelector("title")?.textContent ?? "";
    /** @returns {Panel} */
    const panelOf = (/** @type {Markable} */ element) => {
        const patch = /** @type {SVGGraphicsElement} */ (element);
        const outline = /** @type {SVGPathElement} */ (patch.querySelector("path"));
        const paths = all("g > path", /** @type {Element} */ (patch.parentElement)).filter((path) =>
            path.parentElement?.querySelector("title")
        );
        const lines = paths.map((path) => ({ points: pointsOf(path), name: titleOf(path.parentElement) }));
        return { patch, box: outline.getBBox(), scale: JSON.parse(patch.dataset.scale ?? ""), lines };
    };
    const panels = all("svg [data-scale]").map(panelOf);
    const digits = (/** @type {number} */ value, /** @type {Range} */ range) =>
        value.toFixed(Math.max(0, 2 - Math.floor(Math.log10(Math.abs(range[1] - range[0])))));
    const nearest = (/** @type {Panel} */ { lines }, /** @type {DOMPoint} */ point) => {
        let best = null;
        for (const { points, name } of lines) {
            const y = heightAt(points, point.x);
            if (y !== null && (best === null || Math.abs(y - point.y) < Math.abs(best.y - point.y))) best = { name, y };
        }
        return best;
    };
    const show = (/** @type {string} */ text, /** @type {PointerEvent} */ { clientX, clientY }) => {
        const beyond = clientX > innerWidth / 2;
        reading.textContent = text;
        reading.hidden = text === "";
        reading.style.left = beyond ? "auto" : clientX + 14 + "px";
        reading.style.right = beyond ? innerWidth - clientX + 14 + "px" : "auto";
        reading.style.top = clientY + 14 + "px";
    };
    /** What a panel says under the pointer; null where it is not there. */
    const textOf = (/** @type {Panel} */ panel, /** @type {PointerEvent} */ { clientX, clientY }) => {
        const { patch, box, scale } = panel, matrix = patch.getScreenCTM();
        if (!matrix) return null;
        const point = new DOMPoint(clientX, clientY).matrixTransform(matrix.inverse());
        if (point.x < box.x || point.x > box.x + box.width || point.y < box.y || point.y > box.y + box.height) {
            return null;
        }
        const line = nearest(panel, point);
        if (!line) return "";
        const x = between(point.x, [box.x, box.x + box.width], scale.x);
        const y = between(line.y, [box.y + box.height, box.y], scale.y);
        const [along, up] = scale.labels.map((label) => (label.match(/\[(.*)\]/) || ["", ""])[1]);
        return `${line.name}: ${digits(y, scale.y)} ${up} at ${digits(x, scale.x)} ${along}`;
    };
    document.addEventListener("pointermove", (event) => {
        const target = /** @type {Element} */ (event.target);
        const tip = titleOf(target.closest ? target.closest("svg g:has(> title)") : null);
        const text = panels.map((panel) => textOf(panel, event)).find((text) => text !== null);
        show(text || tip, event);
    });

    // Below each figure: its layers on and off, and the drawing as a file, as it is seen.
    const button = (/** @type {string} */ label, /** @type {() => void} */ clicked) => {
        const element = document.createElement("button");
        element.type = "button";
        element.textContent = label;
        element.addEventListener("click", clicked);
        return element;
    };
    const save = (/** @type {string} */ href, /** @type {string} */ download) =>
        Object.assign(document.createElement("a"), { href, download }).click();
    const written = (/** @type {Markable} */ drawing) => {
        const shown = all("svg", drawing).find((svg) => svg.getClientRects().length);
        const copy = /** @type {SVGElement} */ (shown?.cloneNode(true));
        const [, , width, height] = copy.getAttribute("viewBox")?.split(" ") ?? [];
        for (const layer of all("[data-off]", copy)) layer.remove();
        copy.removeAttribute("style");
        copy.setAttribute("width", width + "pt");
        copy.setAttribute("height", height + "pt");
        const text = new XMLSerializer().serializeToString(copy);
        return { link: "data:image/svg+xml;charset=utf-8," + encodeURIComponent(text), width: +width, height: +height };
    };
    const painted = (/** @type {Markable} */ drawing, /** @type {string} */ name) => {
        const { link, width, height } = written(drawing), picture = new Image(), scale = 300 / 72; // dots per point
        picture.onload = () => {
            const canvas = document.createElement("canvas");
            [canvas.width, canvas.height] = [width * scale, height * scale].map(Math.ceil);
            const paper = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
            paper.fillStyle = "white";
            paper.fillRect(0, 0, canvas.width, canvas.height);
            paper.drawImage(picture, 0, 0, canvas.width, canvas.height);
            save(canvas.toDataURL("image/png"), name + ".png");
        };
        picture.src = link;
    };
    const layerButton = (/** @type {Markable} */ drawing, /** @type {string} */ layer) => {
        const element = button(layer, () => {
            const off = element.getAttribute("aria-pressed") === "true";
            element.setAttribute("aria-pressed", String(!off));
            for (const mark of all("[data-layer]", drawing)) {
                if (mark.dataset.layer === layer) mark.toggleAttribute("data-off", off);
            }
        });
        element.setAttribute("aria-pressed", "true");
        return element;
    };
    for (const drawing of all("figure > .drawing")) {
        const name = (drawing.parentElement?.id ?? "").replace("figure-", "");
        const layers = new Set(all("[data-layer]", drawing).map((mark) => mark.dataset.layer ?? ""));
        const row = document.createElement("p");
        row.className = "tools";
        row.append(
            ...[...layers].map((layer) => layerButton(drawing, layer)),
            button("SVG", () => save(written(drawing).link, name + ".svg")),
            button("PNG", () => painted(drawing, name)),
        );
        drawing.after(row);
    }
})();
