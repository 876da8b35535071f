// @ts-check
// The hand on a recording: pointer, wheel and keys over the signals and the strip.
/** @import { RecordingState } from "./recording.js" */
/** @import { Span } from "./timeline.js" */
import { averagedEnds, GRIP, timeScale } from "./signals.js";
import { centered, lastNotAfter, withEnd, zoomed } from "./timeline.js";

/**
 * @typedef {object} Acts what the hand does
 * @property {(from: number, to: number) => unknown} look
 * @property {(beat: number) => unknown} pick
 * @property {() => unknown} toggle
 * @property {(seconds: number) => Promise<unknown>} move
 * @property {(action: string, values: object) => Promise<unknown>} change
 * @property {() => unknown} later draw the signals
 * @property {() => unknown} tools draw what stands below them
 */

const SIDES = /** @type {(0 | 1)[]} */ ([0, 1]);
const LINE = 6, DRAG = 4, LEAST = 5e-4; // pixels; seconds that a beat is moved

/**
 * @param {HTMLCanvasElement} canvas
 * @param {HTMLCanvasElement} strip
 * @param {RecordingState} state
 * @param {Acts} acts
 */
export function listenToHand(canvas, strip, state, acts) {
    listenToPointer(canvas, state, acts);
    listenToStrip(strip, state, acts);
    canvas.addEventListener("wheel", (event) => {
        if (!state.recording.duration) return;
        event.preventDefault();
        const { view } = state, sideways = event.shiftKey || Math.abs(event.deltaX) > Math.abs(event.deltaY);
        if (sideways) scroll(state, acts, (event.deltaX || event.deltaY) / 800);
        else acts.look(...zoomed(view, 2 ** (event.deltaY / 400), timeAt(event, canvas, state)));
    }, { passive: false });
    const keys = keysOf(state, acts);
    for (const element of [canvas, strip]) {
        element.addEventListener("keydown", (event) => {
            const plain = !event.ctrlKey && !event.metaKey && !event.altKey;
            if (!state.recording.duration || !plain || !keys[event.key]) return;
            event.preventDefault();
            keys[event.key]();
        });
    }
}

/**
 * The time under the pointer.
 * @param {MouseEvent} event
 * @param {HTMLCanvasElement} canvas
 * @param {RecordingState} state
 */
function timeAt(event, canvas, { view, recording: { duration = 0 } }) {
    const { time } = timeScale(view, canvas.clientWidth);
    return Math.min(duration, Math.max(0, time(event.clientX - canvas.getBoundingClientRect().left)));
}

/**
 * @param {RecordingState} state
 * @param {Acts} acts
 * @param {number} share of the window
 */
function scroll({ view: [start, end] }, { look }, share) {
    look(start + share * (end - start), end + share * (end - start));
}

/**
 * @typedef {object} Drag what is being dragged
 * @property {(now: number) => void} move
 * @property {(now: number) => unknown} drop
 */

/**
 * Drag the line of the picked beat, an end of the stretch that is averaged, or a stretch; a click picks a beat.
 * @param {HTMLCanvasElement} canvas
 * @param {RecordingState} state
 * @param {Acts} acts
 */
function listenToPointer(canvas, state, acts) {
    /** @type {Drag | null} */
    let drag = null;
    const time = (/** @type {MouseEvent} */ event) => timeAt(event, canvas, state);
    const gap = (/** @type {number} */ a, /** @type {number} */ b) => {
        const { x } = timeScale(state.view, canvas.clientWidth);
        return Math.abs(x(a) - x(b));
    };
    const grabbed = (/** @type {MouseEvent} */ event) => {
        const now = time(event), start = startOf(state), ends = averagedEnds(state);
        const high = event.clientY - canvas.getBoundingClientRect().top < GRIP.height;
        const side = high && ends ? SIDES.find((side) => gap(now, ends[side]) <= GRIP.half) : undefined;
        if (ends && side !== undefined) return () => ofEnd(state, acts, ends, side);
        return start !== undefined && gap(now, start) < LINE ? () => ofBeat(state, acts, start) : null;
    };
    canvas.addEventListener("pointerdown", (event) => {
        if (!state.recording.duration || event.button !== 0) return;
        drag = grabbed(event)?.() ?? ofStretch(state, acts, time(event), gap);
        canvas.setPointerCapture(event.pointerId);
    });
    canvas.addEventListener("pointermove", (event) => {
        if (!state.recording.duration) return;
        state.pointer = time(event);
        canvas.style.cursor = state.ends || state.carried !== null || grabbed(event) ? "ew-resize" : "";
        drag?.move(state.pointer);
        acts.later();
    });
    canvas.addEventListener("pointerleave", () => {
        state.pointer = null;
        acts.later();
    });
    canvas.addEventListener("pointerup", async (event) => {
        const dropped = drag;
        drag = null;
        await dropped?.drop(time(event));
        acts.later();
    });
}

/**
 * Where the picked beat begins.
 * @param {RecordingState} state
 */
const startOf = ({ beat, recording }) => beat >= 0 ? recording.beats?.starts[beat] : undefined;

/**
 * @param {RecordingState} state
 * @param {Acts} acts
 * @param {number} start
 * @returns {Drag}
 */
function ofBeat(state, { move }, start) {
    state.carried = start;
    return {
        move: (now) => {
            state.carried = now;
        },
        drop: async (now) => {
            if (Math.abs(now - start) >= LEAST) await move(now - start);
            state.carried = null;
        },
    };
}

/**
 * @param {RecordingState} state
 * @param {Acts} acts
 * @param {Span} before
 * @param {0 | 1} side
 * @returns {Drag}
 */
function ofEnd(state, { change }, before, side) {
    const duration = state.recording.duration ?? 0;
    let ends = before;
    return {
        move: (now) => {
            state.ends = ends = withEnd(before, side, now, duration);
        },
        drop: async () => {
            const [start, end] = ends, all = start <= 0 && end >= duration;
            if (ends !== before) await change("set-stretch", all ? {} : { start, end });
            state.ends = null;
        },
    };
}

/**
 * @param {RecordingState} state
 * @param {Acts} acts
 * @param {number} from
 * @param {(a: number, b: number) => number} gap pixels between two times
 * @returns {Drag}
 */
const ofStretch = (state, { pick, tools }, from, gap) => ({
    move: (now) => {
        if (state.stretch || gap(now, from) >= DRAG) state.stretch = [Math.min(from, now), Math.max(from, now)];
    },
    drop: (now) => {
        const { beats } = state.recording, clicked = gap(now, from) < DRAG;
        if (clicked) state.stretch = null;
        return clicked ? pick(beats ? lastNotAfter(now, beats.starts) : -1) : tools();
    },
});

/**
 * @param {HTMLCanvasElement} strip
 * @param {RecordingState} state
 * @param {Acts} acts
 */
function listenToStrip(strip, state, { look }) {
    const center = (/** @type {MouseEvent} */ event) => {
        const share = (event.clientX - strip.getBoundingClientRect().left) / strip.clientWidth;
        look(...centered(state.view, share * (state.recording.duration ?? 0)));
    };
    strip.addEventListener("pointerdown", (event) => {
        if (!state.recording.duration) return;
        strip.setPointerCapture(event.pointerId);
        center(event);
    });
    strip.addEventListener("pointermove", (event) => {
        if (strip.hasPointerCapture(event.pointerId)) center(event);
    });
}

/**
 * What each key does.
 * @param {RecordingState} state
 * @param {Acts} acts
 * @returns {Record<string, () => unknown>}
 */
function keysOf(state, acts) {
    const { look, pick, toggle, move, later, tools } = acts;
    const zoom = (/** @type {number} */ factor) => look(...zoomed(state.view, factor));
    const duration = () => state.recording.duration ?? 0;
    const next = () => {
        const starts = state.recording.beats?.starts ?? [];
        pick(state.beat < 0 ? lastNotAfter(state.view[0], starts) + 1 : state.beat + 1);
    };
    const end = (/** @type {0 | 1} */ side) => {
        const middle = (state.view[0] + state.view[1]) / 2, rest = state.stretch?.[1 - side] ?? state.view[1 - side];
        state.stretch = side ? [Math.min(middle, rest), middle] : [middle, Math.max(middle, rest)];
        tools();
        later();
    };
    return {
        ArrowLeft: () => scroll(state, acts, -0.2),
        ArrowRight: () => scroll(state, acts, 0.2),
        PageUp: () => scroll(state, acts, -1),
        PageDown: () => scroll(state, acts, 1),
        Home: () => look(0, state.view[1] - state.view[0]),
        End: () => look(duration() - state.view[1] + state.view[0], duration()),
        "+": () => zoom(0.5),
        "=": () => zoom(0.5),
        "-": () => zoom(2),
        0: () => look(0, duration()),
        n: next,
        p: () => pick(state.beat - 1),
        x: toggle,
        m: () => {
            state.mark = state.mark === null ? state.pointer ?? (state.view[0] + state.view[1]) / 2 : null;
            later();
        },
        "[": () => move(-0.001),
        "]": () => move(0.001),
        b: () => end(0),
        e: () => end(1),
        Escape: () => {
            state.stretch = null;
            pick(-1);
        },
    };
}
