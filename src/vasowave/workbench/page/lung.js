// @ts-check
// The Lung desk: an image in three slices, the vessels found in it over them and in space, their doubts, and edits.
/** @import { LungAnswer, VesselsAnswer, Wishes } from "./answers.d.ts" */
/** @import { Image, Zoom } from "./slices.js" */
import { act, ask, bytes, messageOf, post } from "./ask.js";
import { choice, fill, formatted, h, rowOf, visit } from "./dom.js";
import { slidersIn, wishesIn } from "./extraction.js";
import { watched } from "./plot.js";
import { drawSlice, extent, listenToSlice, VIEWS, volume } from "./slices.js";
import { lungTree, nearestVessel, PICKED } from "./vessels.js";
import { doubtsIn, editsIn, pickedIn, summary, tableIn } from "./tree.js";

/**
 * @typedef {object} Parts elements of the desk
 * @property {HTMLCanvasElement[]} slices
 * @property {HTMLCanvasElement} space
 * @property {Record<"wishes" | "stage" | "sliders" | "picked" | "doubts" | "edits" | "table" | "notes" | "facts",
 *     HTMLElement>} boxes
 *
 * @typedef {object} LungState
 * @property {LungAnswer} lung
 * @property {Image | null} image
 * @property {VesselsAnswer | null} extraction
 * @property {Parts | null} parts
 * @property {number[]} place that is looked at, cm
 * @property {Zoom} zoom of the slices
 * @property {string} chosen vessel
 * @property {number[] | null} moving end that is being moved
 * @property {Wishes} wishes
 * @property {{ dark: number, bright: number }} window grey levels that are black and white
 * @property {SpaceView | null} space
 * @property {boolean} stale whether something was changed since the vessels were looked for
 * @property {number} turn
 * @property {boolean} drawing
 */

/** @type {LungState} */
const state = {
    lung: /** @type {LungAnswer} */ ({ images: /** @type {string[]} */ ([]), image: "" }),
    image: null,
    extraction: null,
    parts: null,
    place: [0, 0, 0],
    zoom: { factor: 1, center: [0, 0, 0] },
    chosen: "",
    moving: null,
    wishes: { threshold: null, cannula: null, pressure: null, voxel: null, species: "", open_loops: false },
    window: { dark: 0, bright: 1 },
    space: null,
    stale: false,
    turn: 0,
    drawing: false,
};
const LOOK_MS = 700;

/**
 * @param {HTMLElement} place
 * @param {string[]} path
 */
export async function show(place, path) {
    const lung = /** @type {LungAnswer} */ (await ask("lung", { image: path[0] || "" }));
    if (!place.isConnected) return; // another desk or image is wanted by now
    state.lung = lung;
    if (!lung.images.length) {
        fill(
            place,
            h("h1", {}, "Lung"),
            h("p", {}, "No images yet: "),
            h("a", { href: "#study" }, "drop a volume on the Study desk"),
            ", or open one: ",
            h("code", {}, "vasowave open scan.nrrd"),
        );
        return;
    }
    Object.assign(state, { extraction: null, image: null, chosen: "", moving: null, stale: false });
    state.wishes = { ...lung.wishes };
    const parts = state.parts = partsOf();
    layOut(place, parts, lung);
    wishes();
    edits();
    parts.boxes.stage.textContent = "Reading the image …";
    const { voxel } = state.wishes;
    const content = await bytes("volume", { image: lung.image, ...(voxel ? { voxel } : {}) });
    if (parts === state.parts) begin(parts, volume(content));
}

/** @returns {Parts} */
function partsOf() {
    const canvas = (/** @type {string} */ name, /** @type {string} */ text) =>
        h("canvas", { class: name, tabindex: 0, role: "img", "aria-label": text });
    return {
        slices: VIEWS.map(({ name }) =>
            canvas(
                "slice",
                `slice ${name}; click picks a place, arrow keys move it, wheel or page keys go through, Ctrl with wheel, or + and −, zoom`,
            )
        ),
        space: canvas("space", "the tree; drag or arrow keys turn it, a click picks a vessel"),
        boxes: {
            wishes: h("div"),
            stage: h("p", { class: "note", role: "status", id: "stage" }),
            sliders: h("div"),
            picked: h("div"),
            doubts: h("div", { class: "doubts" }),
            edits: h("div"),
            table: h("div"),
            notes: h("div"),
            facts: h("p", { class: "note" }),
        },
    };
}

/**
 * @param {HTMLElement} place
 * @param {Parts} parts
 * @param {LungAnswer} lung
 */
function layOut(place, { slices, space, boxes }, { images, image }) {
    const picker = choice(images, image, (name) => visit("lung", name), {
        "aria-label": "image",
        data: { key: "image" },
    });
    fill(
        place,
        rowOf(h("h1", {}, "Lung in "), picker),
        boxes.wishes,
        boxes.stage,
        boxes.notes,
        h(
            "div",
            { class: "two" },
            h(
                "section",
                { "aria-label": "image" },
                h("div", { class: "slices" }, slices, space),
                boxes.sliders,
                boxes.facts,
            ),
            h("section", { "aria-label": "vessels" }, boxes.picked, boxes.doubts, boxes.edits),
        ),
        boxes.table,
    );
}

/**
 * Show an image that was read.
 * @param {Parts} parts
 * @param {Image} image
 */
function begin({ slices, space, boxes }, image) {
    const { lung } = state;
    state.image = image;
    state.place = [0, 1, 2].map((k) => (extent(image, k)[0] + extent(image, k)[1]) / 2);
    state.zoom = { factor: 1, center: state.place };
    state.window = { dark: image.low, bright: image.high };
    if (!lung.written) { // as `vasowave look` proposes
        state.wishes.threshold = image.threshold;
        wishes();
    }
    const size = image.voxel.map((length) => formatted(1e4 * length, 3)).join(" × ");
    boxes.facts.textContent = `${lung.file}: ${image.voxels.join(" × ")} voxels of ${size} µm, shown as ${
        image.shape.join(" × ")
    }`;
    slices.forEach((canvas, k) => {
        listenToSlice(canvas, image, VIEWS[k], state, { go, move, look });
        watched(canvas, draw);
    });
    state.space = lungTree(space, image, state, go);
    watched(space, draw);
    sliders();
    picked();
    boxes.stage.textContent = "";
    draw();
    if (lung.root) vessels(); // which may take a while; the page is there meanwhile
    else boxes.stage.textContent = "Click the outer end of the cannula in a slice, then “Blood enters here”.";
}

export async function renew() {
    const { parts, lung: { image } } = state;
    if (!parts || !image || !state.image) return;
    const lung = await ask("lung", { image });
    if (parts !== state.parts) return;
    state.lung = lung;
    edits();
    wishes();
    if (state.extraction && !state.stale) await vessels();
}

async function vessels() {
    const { parts, wishes: settings, lung } = state, turn = ++state.turn;
    if (!parts) return;
    const { stage, notes } = parts.boxes, current = () => turn === state.turn && parts === state.parts;
    const about = ask("lung", { image: lung.image }).catch(() => lung); // meanwhile
    const watching = setInterval(async () => {
        const progress = await ask("lung", { image: lung.image }).catch(() => ({}));
        if (turn === state.turn && progress.stage) stage.textContent = `Looking for the vessels: ${progress.stage} …`;
    }, LOOK_MS);
    try {
        const extraction = await post("vessels", { image: lung.image, wishes: settings });
        if (!current()) return;
        Object.assign(state, { extraction, stale: false });
        // An edit numbers the vessels anew, and the next one acts at the place.
        state.chosen = state.chosen && nearestVessel(extraction.vessels, state.place);
        stage.textContent = summary(extraction);
        fill(notes);
    } catch (error) {
        if (!current()) return;
        stage.textContent = "";
        fill(notes, h("div", { class: "finding bad" }, messageOf(error)));
    } finally {
        clearInterval(watching);
    }
    const answer = await about;
    if (parts !== state.parts) return;
    state.lung = answer;
    wishes();
    if (state.extraction) {
        doubtsIn(parts.boxes.doubts, state.extraction, go);
        tableIn(parts.boxes.table, state.extraction, go);
    }
    picked();
    edits();
    draw();
}

// What is wished for, and the window.

/** Something was changed since the vessels were looked for. */
function outdate() {
    state.stale = true;
    wishes();
}

function wishes() {
    if (!state.parts) return;
    wishesIn(state.parts.boxes.wishes, state, {
        changed: (name) => {
            outdate();
            if (name === "threshold") {
                sliders();
                draw();
            }
        },
        search: vessels,
        write,
    });
}

async function write() {
    const { parts, lung: { image } } = state;
    if (!parts) return;
    parts.boxes.stage.textContent = "Writing …";
    await act("write-lung", { image, wishes: state.wishes });
    parts.boxes.stage.textContent = "";
    state.lung = await ask("lung", { image });
    wishes();
}

function sliders() {
    const { parts, image } = state;
    if (parts && image) slidersIn(parts.boxes.sliders, state, image, { moved: draw, changed: outdate });
}

// The place that is looked at, and what can be done there.

/**
 * @param {readonly number[]} place
 * @param {string} [name] of the vessel there, else the nearest
 */
function go(place, name = "") {
    state.place = place.slice(0, 3);
    state.chosen = name || nearestVessel(state.extraction?.vessels ?? [], state.place);
    picked();
    draw();
}

/** @param {number[]} place */
function move(place) {
    state.place = place;
    draw();
}

/** @param {Zoom} zoom */
function look(zoom) {
    state.zoom = zoom;
    draw();
}

/**
 * @param {string} action
 * @param {object} [more]
 */
async function edit(action, more = {}) {
    const point = state.moving && action === "move" ? state.moving : state.place;
    state.moving = null;
    const done = await act("edit-tree", { image: state.lung.image, action, point, ...more });
    if (!done || (action !== "root" && action !== "outlet")) return;
    outdate();
    picked();
    if (action === "root") await vessels();
}

function picked() {
    if (!state.parts) return;
    pickedIn(state.parts.boxes.picked, state, edit, (moving) => {
        state.moving = moving;
        picked();
        if (!moving) draw();
    });
}

function edits() {
    if (state.parts) editsIn(state.parts.boxes.edits, state.lung);
}

function draw() {
    if (state.drawing || !state.image) return;
    state.drawing = true;
    requestAnimationFrame(() => {
        const { image, parts, extraction, moving, place, zoom, chosen, wishes: { threshold } } = state;
        state.drawing = false;
        if (!image || !parts?.space.isConnected) return;
        /** @type {[number[], string][]} */
        const marks = [
            ...(extraction ? [mark(extraction.root, PICKED)] : []),
            ...(moving ? [mark(moving, "#ffffff")] : []),
        ];
        const vessels = extraction?.vessels || [];
        const scene = { place, zoom, ...state.window, threshold, vessels, chosen, marks };
        parts.slices.forEach((canvas, k) => canvas.clientWidth > 40 && drawSlice(canvas, image, VIEWS[k], scene));
        state.space?.redraw();
    });
}

/**
 * @param {number[]} place
 * @param {string} color
 * @returns {[number[], string]}
 */
const mark = (place, color) => [place, color];
