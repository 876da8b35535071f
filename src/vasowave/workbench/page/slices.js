// @ts-check
// Three slices through an image of 16 bits, with its window, what is above the threshold, and the tree over them.
/** @import { Vessel } from "./answers.d.ts" */
import { count } from "./dom.js";
import { sheet, stroke, style } from "./plot.js";

/**
 * @typedef {object} View which of x, y, z runs right, which down (up -1: upward), and which is looked along
 * @property {string} name
 * @property {number} right
 * @property {number} down
 * @property {1 | -1} up
 * @property {number} through
 *
 * @typedef {object} Image
 * @property {Uint16Array} levels x fastest
 * @property {number[]} shape
 * @property {number[]} spacing cm
 * @property {number[]} origin cm
 * @property {number} low grey level of the lowest of `levels`
 * @property {number} high
 * @property {number} threshold
 * @property {number[]} voxels
 * @property {number[]} voxel cm
 * @property {number[]} stride
 *
 * @typedef {object} Zoom
 * @property {number} factor 1: the whole slice
 * @property {number[]} center cm
 *
 * @typedef {object} Scene
 * @property {Zoom} zoom
 * @property {number[]} place cm
 * @property {number} dark grey level that is black
 * @property {number} bright
 * @property {number | null} threshold
 * @property {Vessel[]} vessels
 * @property {string} chosen
 * @property {[number[], string][]} marks places with colors
 */

/** @type {View[]} */
export const VIEWS = [
    { name: "along z", right: 0, down: 1, up: 1, through: 2 },
    { name: "along y", right: 0, down: 2, up: -1, through: 1 },
    { name: "along x", right: 1, down: 2, up: -1, through: 0 },
];
const LUMEN = [0, 167, 196], TINT = 0.35;
const LARGEST = 32; // factor of a zoom
/** @type {Zoom} */
const WHOLE = { factor: 1, center: [0, 0, 0] };

/**
 * Read what the server sends: a line about the image, then its grey levels, x fastest.
 * @param {ArrayBuffer} buffer
 * @returns {Image}
 */
export function volume(buffer) {
    const bytes = new Uint8Array(buffer), end = bytes.indexOf(10);
    const about = JSON.parse(new TextDecoder().decode(bytes.subarray(0, end)));
    const turned = (/** @type {number[]} */ list) => [...list].reverse(); // z, y, x on the wire; x, y, z here
    const shape = turned(about.shape);
    return {
        levels: new Uint16Array(buffer.slice(end + 1)),
        shape,
        spacing: turned(about.spacing),
        origin: turned(about.origin),
        low: about.low,
        high: about.high,
        threshold: about.threshold,
        voxels: turned(about.voxels),
        voxel: turned(about.voxel),
        stride: [1, shape[0], shape[0] * shape[1]],
    };
}

/**
 * The voxel of a place, the nearest of the image.
 * @param {Pick<Image, "shape" | "origin" | "spacing">} image
 * @param {number[]} place
 */
export const voxelOf = (image, place) =>
    place.map((value, k) =>
        Math.min(image.shape[k] - 1, Math.max(0, Math.round((value - image.origin[k]) / image.spacing[k])))
    );

/**
 * Where the image begins and ends along an axis.
 * @param {Pick<Image, "shape" | "origin" | "spacing">} image
 * @param {number} k
 */
export const extent = (image, k) => [
    image.origin[k] - image.spacing[k] / 2,
    image.origin[k] + (image.shape[k] - 0.5) * image.spacing[k],
];

/**
 * Where a view stands in its canvas: pixels of a place, and the place of pixels at the depth of another.
 * @param {{ clientWidth: number, clientHeight: number }} canvas
 * @param {Pick<Image, "shape" | "origin" | "spacing">} image
 * @param {View} view
 * @param {Zoom} [zoom]
 */
export function frame(canvas, image, view, { factor, center } = WHOLE) {
    const [left, right] = extent(image, view.right), [top, bottom] = extent(image, view.down);
    const scale = factor * Math.min(canvas.clientWidth / (right - left), canvas.clientHeight / (bottom - top));
    const x0 = edge(canvas.clientWidth, scale * (right - left), scale * (center[view.right] - left));
    const fall = view.up > 0 ? center[view.down] - top : bottom - center[view.down];
    const y0 = edge(canvas.clientHeight, scale * (bottom - top), scale * fall);
    /**
     * @param {number[]} place
     * @returns {Pixels}
     */
    const px = (place) => [
        x0 + scale * (place[view.right] - left),
        y0 + scale * (view.up > 0 ? place[view.down] - top : bottom - place[view.down]),
    ];
    /**
     * @param {number} x
     * @param {number} y
     * @param {number[]} depth
     */
    const placeAt = (x, y, depth) => {
        const place = [...depth], down = (y - y0) / scale;
        place[view.right] = Math.min(right, Math.max(left, left + (x - x0) / scale));
        place[view.down] = Math.min(bottom, Math.max(top, view.up > 0 ? top + down : bottom - down));
        return place;
    };
    /** @type {[number, number, number, number]} */
    const box = [x0, y0, scale * (right - left), scale * (bottom - top)];
    return { px, placeAt, box, scale };
}

/**
 * Where a slice begins, pixels: in the middle of what is wider, else so that a place stands there, and none is empty.
 * @param {number} room
 * @param {number} size of the slice
 * @param {number} middle of the slice that is to stand in the middle of the room
 */
const edge = (room, size, middle) =>
    size <= room ? (room - size) / 2 : Math.min(0, Math.max(room - size, room / 2 - middle));

/**
 * A zoom times a factor in which a place stays where it is; the whole slices where it would be smaller.
 * @param {Zoom} zoom
 * @param {number} factor
 * @param {number[]} place
 * @returns {Zoom}
 */
export function zoomedAt(zoom, factor, place) {
    const total = Math.min(LARGEST, Math.max(1, zoom.factor * factor));
    const share = zoom.factor / total;
    return { factor: total, center: place.map((value, k) => value + (zoom.center[k] - value) * share) };
}

/**
 * Draw one slice through a place; what is above the threshold is tinted.
 * @param {HTMLCanvasElement} canvas
 * @param {Image} image
 * @param {View} view
 * @param {Scene} scene
 */
export function drawSlice(canvas, image, view, scene) {
    const { pen, width, height } = sheet(canvas), { px, box } = frame(canvas, image, view, scene.zoom);
    const pixels = greyPixels(image, view, scene), buffer = new OffscreenCanvas(pixels.width, pixels.height);
    /** @type {OffscreenCanvasRenderingContext2D} */ (buffer.getContext("2d")).putImageData(
        new ImageData(pixels.data, pixels.width, pixels.height),
        0,
        0,
    );
    pen.fillStyle = "#000";
    pen.fillRect(0, 0, width, height);
    pen.imageSmoothingEnabled = false;
    pen.drawImage(buffer, ...box);
    drawVessels(pen, image, view, scene, px);
    for (const [place, color] of scene.marks) {
        pen.fillStyle = color;
        pen.beginPath();
        pen.arc(...px(place), 4, 0, 7);
        pen.fill();
    }
    const [x, y] = px(scene.place);
    pen.strokeStyle = "#ffffff";
    pen.lineWidth = 1;
    pen.globalAlpha = 0.55;
    pen.beginPath();
    pen.moveTo(x, 0);
    pen.lineTo(x, height);
    pen.moveTo(0, y);
    pen.lineTo(width, y);
    pen.stroke();
    pen.globalAlpha = 1;
    pen.fillStyle = "#fff";
    pen.textAlign = "left";
    pen.textBaseline = "top";
    pen.fillText(`${view.name}, ${"xyz"[view.through]} = ${scene.place[view.through].toFixed(3)} cm`, 5, 4);
    canvas.style.borderColor = style("--line");
    count(canvas);
}

/**
 * The grey levels of a slice as pixels, red, green, blue, opacity.
 * @param {Pick<Image, "levels" | "shape" | "spacing" | "origin" | "low" | "high" | "stride">} image
 * @param {View} view
 * @param {Pick<Scene, "place" | "dark" | "bright" | "threshold">} scene
 */
export function greyPixels(image, view, { place, dark, bright, threshold }) {
    const [width, height] = [image.shape[view.right], image.shape[view.down]];
    const depth = voxelOf(image, place)[view.through] * image.stride[view.through];
    const level = (/** @type {number | null} */ grey) =>
        (Number(grey) - image.low) / (image.high - image.low || 1) * 65535;
    const [from, to, wall] = [level(dark), level(bright), level(threshold)], gain = 255 / Math.max(1, to - from);
    const data = new Uint8ClampedArray(4 * width * height);
    for (let row = 0; row < height; row++) {
        const start = depth + (view.up > 0 ? row : height - 1 - row) * image.stride[view.down];
        for (let column = 0; column < width; column++) {
            const value = image.levels[start + column * image.stride[view.right]], k = 4 * (row * width + column);
            const grey = Math.min(255, Math.max(0, (value - from) * gain)), share = value >= wall ? TINT : 0;
            for (let c = 0; c < 3; c++) data[k + c] = (1 - share) * grey + share * LUMEN[c];
            data[k + 3] = 255;
        }
    }
    return { data, width, height };
}

/**
 * Axes of the vessels, strong where they run in the slice.
 * @param {CanvasRenderingContext2D} pen
 * @param {Image} image
 * @param {View} view
 * @param {Scene} scene
 * @param {(place: number[]) => Pixels} px
 */
function drawVessels(pen, image, { through }, { vessels, chosen, place }, px) {
    for (const vessel of vessels) {
        pen.strokeStyle = vessel.name === chosen ? "#ff4fc3" : vessel.doubts.length ? "#ff9d2e" : "#ffe14d";
        for (let k = 1; k < vessel.points.length; k++) {
            const [a, b] = [vessel.points[k - 1], vessel.points[k]];
            const gap = Math.abs((a[through] + b[through]) / 2 - place[through]);
            const near = gap < Math.max(b[3], image.spacing[through]);
            pen.globalAlpha = near ? 1 : 0.5;
            pen.lineWidth = near ? 2.2 : 1;
            stroke(pen, px(a), px(b));
        }
    }
    pen.globalAlpha = 1;
}

/**
 * Pick places of a slice with pointer, wheel and keys; `go` leads to one, `move` while the pointer is down. With Ctrl the
 * wheel zooms; Shift or the middle button drag the slice.
 * @param {HTMLCanvasElement} canvas
 * @param {Image} image
 * @param {View} view
 * @param {{ place: number[], zoom: Zoom }} state
 * @param {{ go: (place: number[]) => unknown, move: (place: number[]) => unknown, look: (zoom: Zoom) => unknown }} acts
 */
export function listenToSlice(canvas, image, view, state, { go, move, look }) {
    const placeAt = (/** @type {MouseEvent} */ event) =>
        frame(canvas, image, view, state.zoom).placeAt(event.offsetX, event.offsetY, state.place);
    const drags = (/** @type {PointerEvent} */ event) => event.shiftKey || Boolean(event.buttons & 4);
    /** The zoom with the place in the middle of the canvas, some pixels beside it. */
    const beside = (x = 0, y = 0) => {
        const { factor, center } = state.zoom, { placeAt } = frame(canvas, image, view, state.zoom);
        return { factor, center: placeAt(canvas.clientWidth / 2 + x, canvas.clientHeight / 2 + y, center) };
    };
    const zoom = (/** @type {number} */ factor, place = state.place) => look(zoomedAt(beside(), factor, place));
    const step = (/** @type {number} */ k, /** @type {number} */ count) => {
        const [low, high] = extent(image, k);
        const value = Math.min(high, Math.max(low, state.place[k] + count * image.spacing[k]));
        go(state.place.with(k, value));
    };
    canvas.addEventListener("pointerdown", (event) => {
        canvas.setPointerCapture(event.pointerId);
        event.preventDefault(); // the middle button would scroll
        if (!drags(event)) go(placeAt(event));
    });
    canvas.addEventListener("pointermove", (event) => {
        if (event.buttons) drags(event) ? look(beside(-event.movementX, -event.movementY)) : move(placeAt(event));
    });
    canvas.addEventListener("pointerup", () => go(state.place));
    canvas.addEventListener("wheel", (event) => {
        event.preventDefault();
        if (event.ctrlKey) zoom(2 ** (-event.deltaY / 300), placeAt(event));
        else step(view.through, Math.sign(event.deltaY));
    }, { passive: false });
    /** @type {Record<string, () => unknown>} */
    const zooms = {
        "+": () => zoom(2),
        "=": () => zoom(2),
        "-": () => zoom(0.5),
        0: () => zoom(0),
    };
    /** @type {Record<string, [number, number]>} */
    const keys = {
        ArrowLeft: [view.right, -1],
        ArrowRight: [view.right, 1],
        ArrowUp: [view.down, -view.up],
        ArrowDown: [view.down, view.up],
        PageUp: [view.through, 1],
        PageDown: [view.through, -1],
    };
    canvas.addEventListener("keydown", (event) => {
        const plain = !event.ctrlKey && !event.metaKey && !event.altKey;
        if (!plain || !keys[event.key] && !zooms[event.key]) return;
        event.preventDefault();
        if (zooms[event.key]) zooms[event.key]();
        else step(...keys[event.key]);
    });
}
