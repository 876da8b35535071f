// @ts-check
import { deepEqual, equal } from "node:assert/strict";
import {
    extent,
    frame,
    greyPixels,
    VIEWS,
    volume,
    voxelOf,
    zoomedAt,
} from "../../../src/vasowave/workbench/page/slices.js";

const ABOUT = {
    shape: [2, 2, 3],
    spacing: [1, 1, 0.5],
    origin: [30, 20, 10],
    low: 0,
    high: 65535,
    threshold: 500,
    voxels: [4, 4, 6],
    voxel: [0.5, 0.5, 0.25],
};

/** An image of 3 by 2 by 2 voxels whose grey levels count from 0. */
function image() {
    const line = new TextEncoder().encode(JSON.stringify(ABOUT) + "\n");
    const levels = new Uint8Array(Uint16Array.from({ length: 12 }, (_, k) => k).buffer);
    return volume(new Uint8Array([...line, ...levels]).buffer);
}

Deno.test("an image on the wire is z, y, x; here it is x, y, z", () => {
    const { shape, spacing, origin, stride, levels, voxels } = image();
    deepEqual([shape, spacing, origin], [[3, 2, 2], [0.5, 1, 1], [10, 20, 30]]);
    deepEqual([stride, voxels], [[1, 3, 6], [6, 4, 4]]);
    deepEqual([...levels], [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11]);
});

Deno.test("an image reaches half a voxel beyond the middles of its outer ones", () => {
    deepEqual([0, 1, 2].map((k) => extent(image(), k)), [[9.75, 11.25], [19.5, 21.5], [29.5, 31.5]]);
});

Deno.test("the voxel of a place is the nearest, also from outside", () => {
    deepEqual(voxelOf(image(), [10.6, 20.4, 30.6]), [1, 0, 1]);
    deepEqual(voxelOf(image(), [-5, 99, 30]), [0, 1, 0]);
});

Deno.test("places have their pixels, and pixels their places", () => {
    const canvas = { clientWidth: 300, clientHeight: 300 };
    for (const view of VIEWS) {
        const { px, placeAt } = frame(canvas, image(), view), place = [10.25, 20.5, 31];
        const back = placeAt(...px(place), place);
        deepEqual(back.map((value) => Number(value.toFixed(9))), place);
    }
});

Deno.test("a slice keeps its shape, stands in the middle, and is not left by the pointer", () => {
    const { px, placeAt, box } = frame({ clientWidth: 300, clientHeight: 200 }, image(), VIEWS[0]); // 1.5 by 2 cm
    deepEqual(box, [75, 0, 150, 200]);
    deepEqual(px([9.75, 19.5, 30]), [75, 0]);
    deepEqual(placeAt(0, 999, [0, 0, 30]), [9.75, 21.5, 30]);
});

Deno.test("a zoom keeps the place under the pointer, leaves no room empty, and ends at the whole slice", () => {
    const canvas = { clientWidth: 300, clientHeight: 200 }, place = [10.2, 20.3, 30.9];
    for (const view of VIEWS) {
        const zoom = { factor: 4, center: [10.4, 20.4, 30.6] }, before = frame(canvas, image(), view, zoom);
        const after = frame(canvas, image(), view, zoomedAt(zoom, 2, place));
        equal(after.scale, 2 * before.scale);
        const [old, now] = [before.px(place), after.px(place)];
        deepEqual(now.map((value) => Math.round(1e6 * value)), old.map((value) => Math.round(1e6 * value)));
        const [x0, y0, width, height] = frame(canvas, image(), view, { factor: 8, center: [-99, 99, 0] }).box;
        equal(x0 <= 0 && y0 <= 0 && x0 + width >= 300 - 1e-9 && y0 + height >= 200 - 1e-9, true);
    }
    equal(zoomedAt({ factor: 4, center: place }, 0, place).factor, 1);
    deepEqual(frame(canvas, image(), VIEWS[0], { factor: 1, center: [0, 0, 0] }).box, [75, 0, 150, 200]);
});

Deno.test("z runs up in the views along y and x", () => {
    const { px } = frame({ clientWidth: 300, clientHeight: 200 }, image(), VIEWS[1]);
    equal(px([10, 20, 31.5])[1], 0);
    equal(px([10, 20, 29.5])[1], 200);
});

Deno.test("grey levels become pixels between black and white, and what is above the wall is tinted", () => {
    const picture = { ...image(), high: 65535 };
    const scene = { place: [10, 20, 31], dark: 6, bright: 261, threshold: 1000 };
    const { data, width, height } = greyPixels(picture, VIEWS[0], scene);
    deepEqual([width, height], [3, 2]);
    deepEqual([...data].filter((_, k) => k % 4 === 0), [0, 1, 2, 3, 4, 5]); // levels 6 to 11 of the second plane
    deepEqual([...data].filter((_, k) => k % 4 === 3), Array(6).fill(255));
    const tinted = greyPixels(picture, VIEWS[0], { ...scene, dark: 11, threshold: 11 }).data;
    deepEqual([...tinted].slice(16), [0, 0, 0, 255, 0, 58, 69, 255]); // 0.35 of 0, 167, 196
});

Deno.test("the rows of a view along y begin above", () => {
    const { data } = greyPixels(image(), VIEWS[1], { place: [10, 20, 30], dark: 0, bright: 255, threshold: 1000 });
    deepEqual([...data].filter((_, k) => k % 4 === 0), [6, 7, 8, 0, 1, 2]);
});
