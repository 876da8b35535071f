// @ts-check
// What stands beside the signals of a recording: tools, numbers, findings, and the cells of its row.
/** @import { Beats, Option, RecordingAnswer } from "./answers.d.ts" */
/** @import { RecordingState } from "./recording.js" */
/** @import { Span } from "./timeline.js" */
import { act } from "./ask.js";
import { button, choice, fill, formatted, h, input, labelled, rowOf } from "./dom.js";
import { findingOf } from "./findings.js";
import { beatsByCause, editOf, spanOf, zoomed } from "./timeline.js";

/**
 * @typedef {object} Acts what the tools do
 * @property {(from: number, to: number) => unknown} look
 * @property {(beat: number) => unknown} pick
 * @property {() => unknown} toggle
 * @property {(seconds: number) => unknown} move
 * @property {(action: "reject" | "keep") => unknown} judge
 * @property {(action: string, values: object) => unknown} change
 * @property {() => unknown} focus
 */

/** @type {Option[]} */
const DRIFT = [["remove", "removed"], ["warn", "left in"]];
const CHANNELS = ["pressure channel", "flow channel", "ecg channel"];
const CELLS = [
    "pressure unit",
    "flow unit",
    "zero [mmHg]",
    "pressure gain [1]",
    "flow zero [ml/s]",
    "flow gain [1]",
    "wedge [mmHg]",
];
const RAW_CELLS = ["start [s]", "end [s]", "sampling rate [1/s]"];

/**
 * @param {string} text
 * @param {() => unknown} clicked
 * @param {string} [key]
 */
const tool = (text, clicked, key = text) => button(text, clicked, { data: { key } });

/**
 * @param {HTMLElement} place
 * @param {RecordingState} state
 * @param {Acts} acts
 */
export function toolsIn(place, state, acts) {
    const { recording, stretch, beat } = state, { beats, edits } = recording;
    if (!recording.duration) {
        fill(place);
        return;
    }
    fill(
        place,
        viewRow(recording, state, acts),
        stretch && stretchRow(recording, stretch, acts),
        beats && causesRow(beats, beat, acts),
        beats && beat >= 0 && beatRow(recording, beats, beat, acts),
        edits.length > 0 &&
            rowOf(
                h("span", { class: "note" }, `${edits.length} beats edited, in ${recording.cells["beat edits"]}`),
                tool("Forget all edits", () => acts.change("edit-beats", { forget: edits.map(([, time]) => time) })),
            ),
    );
}

/**
 * @param {RecordingAnswer} recording
 * @param {RecordingState} state
 * @param {Acts} acts
 */
function viewRow({ cells, duration = 0, drift }, state, { look, change }) {
    const zoom = (/** @type {number} */ factor) => look(...zoomed(state.view, factor));
    const gains = ["pressure", "flow"].filter((signal) => cells[`${signal} gain [1]`]).map((signal) =>
        tool(
            `Take back the gain of the ${signal} (${cells[`${signal} gain [1]`]})`,
            () => change("set-gain", { signal }),
        )
    );
    const drifts = choice(DRIFT, drift, (value) => act("set-setting", { key: "averaging.drift", value }), {
        data: { key: "drift" },
    });
    return rowOf(
        tool("−", () => zoom(2), "out"),
        tool("+", () => zoom(0.5), "in"),
        tool("all", () => look(0, duration)),
        cells["start [s]"] || cells["end [s]"]
            ? tool("Average the whole recording", () => change("set-stretch", {}))
            : null,
        gains,
        cells["zero [mmHg]"]
            ? tool(`Take back the zero (${cells["zero [mmHg]"]} mmHg)`, () => change("set-zero", {}))
            : null,
        labelled("drift", drifts, h("span", {}, "(of all animals)")),
    );
}

/**
 * @param {RecordingAnswer} recording
 * @param {Span} stretch
 * @param {Acts} acts
 */
function stretchRow({ beats, signals = [] }, [start, end], { look, judge, change }) {
    const ends = { start, end };
    return rowOf(
        h("span", {}, `${start.toFixed(3)} to ${end.toFixed(3)} s:`),
        tool("Average this stretch", () => change("set-stretch", ends)),
        signals.includes("pressure") && [
            tool("This is zero pressure", () => change("set-zero", ends)),
            calibration(ends, change),
        ],
        beats && [
            tool("Reject its beats", () => judge("reject")),
            tool("Keep its beats", () => judge("keep")),
        ],
        tool("Zoom in", () => look(start, end)),
    );
}

/**
 * Comments of the recording, each with its place and the stretch that begins there.
 * @param {HTMLElement} place
 * @param {RecordingAnswer} recording
 * @param {{ look: (time: number) => unknown, change: Acts["change"] }} acts
 */
export function commentsIn(place, { comments = [], duration = 0 }, { look, change }) {
    const average = (/** @type {string} */ text, /** @type {Span} */ [start, end], /** @type {number} */ k) =>
        end > start && tool(text, () => change("set-stretch", { start, end }), `${text} ${k}`);
    fill(
        place,
        comments.length > 0 && h("h2", {}, comments.length === 1 ? "A comment" : `${comments.length} comments`),
        h(
            "div",
            { class: "comments", data: { scrolls: "" } },
            comments.map(([time, text], k) =>
                rowOf(
                    tool(`${time.toFixed(2)} s: ${text}`, () => look(time), `comment ${k}`),
                    average("Average from here", [time, duration], k),
                    comments[k + 1] && average("to the next comment", [time, comments[k + 1][0]], k),
                )
            ),
        ),
    );
}

/**
 * A point of calibration: the true mean of the stretch.
 * @param {{ start: number, end: number }} ends
 * @param {Acts["change"]} change
 */
function calibration(ends, change) {
    const mean = h("input", {
        type: "number",
        step: "any",
        min: 0,
        data: { key: "known" },
        "aria-label": "known mean of the stretch",
    });
    const signal = choice([["pressure", "mmHg"], ["flow", "ml/s"]], "pressure", () => {}, {
        "aria-label": "of pressure or flow",
        data: { key: "known of" },
    });
    const calibrate = () => change("set-gain", { ...ends, signal: signal.value, known: Number(mean.value) });
    return labelled("its mean is known:", mean, signal, tool("Calibrate", calibrate));
}

/**
 * Rejected beats by reason; the next of them at a click.
 * @param {Beats} beats
 * @param {number} beat
 * @param {Acts} acts
 */
function causesRow({ causes }, beat, { pick, focus }) {
    const groups = [...beatsByCause(causes)];
    const next = (/** @type {number[]} */ list) => {
        pick(list.find((k) => k > beat) ?? list[0]);
        focus();
    };
    return groups.length > 0 &&
        rowOf(
            h("span", { class: "note" }, "rejected, to the next:"),
            groups.map(([cause, list]) => tool(`${list.length} × ${cause}`, () => next(list), `why ${cause}`)),
        );
}

/**
 * @param {RecordingAnswer} recording
 * @param {Beats} beats
 * @param {number} beat
 * @param {Acts} acts
 */
function beatRow(recording, beats, beat, { toggle, move }) {
    const rejected = beats.rejected[beat];
    const fate = rejected ? `rejected, ${rejected}` : beats.averaged.includes(beat) ? "averaged" : "good";
    const judgment = editOf(recording, beats, beat) ? "As the rules say" : rejected ? "Keep it" : "Reject it";
    const title = `Beat ${beat + 1} of ${beats.starts.length}, ${spanOf(beats, beat)[0].toFixed(3)} s: `;
    return h(
        "div",
        { class: "row", data: { beat } },
        h("span", {}, title, fate),
        tool(judgment, toggle, "judge"),
        tool("1 ms earlier", () => move(-0.001)),
        tool("1 ms later", () => move(0.001)),
    );
}

/**
 * @param {HTMLElement} place
 * @param {RecordingAnswer} recording
 */
export function indicesIn(place, { beats, indices = {}, units }) {
    const cell = (/** @type {string} */ title, /** @type {string} */ name, /** @type {string} */ value) =>
        h("div", {}, h("span", {}, title), h("b", { data: { index: name } }, value));
    fill(
        place,
        Object.entries(units).filter(([name]) => name in indices).map(([name, unit]) =>
            cell(`${name} [${unit}]`, name, formatted(indices[name]))
        ),
        beats && cell("beats averaged", "beats", `${beats.averaged.length} of ${beats.starts.length}`),
    );
}

/**
 * @param {HTMLElement} place
 * @param {RecordingAnswer} recording
 */
export function findingsIn(place, { findings = [] }) {
    const notes = findings.filter((finding) => !finding.look);
    fill(
        place,
        findings.filter((finding) => finding.look).map((finding) => findingOf(finding)),
        findings.length > 0 && h(
            "details",
            {},
            h("summary", {}, "What was noted"),
            notes.map((finding) => findingOf(finding)),
        ),
    );
}

/**
 * @param {HTMLElement} place
 * @param {RecordingAnswer} recording
 */
export function cellsIn(place, { animal, cells, channels = [], kind, blocks = 1 }) {
    const set = (/** @type {string} */ title) => (/** @type {string} */ text) =>
        text !== cells[title] &&
        act("set-cells", { animal, cells: { [title]: text }, was: { [title]: cells[title] } }, true);
    const field = (/** @type {string} */ title) =>
        labelled(
            title,
            input(
                { type: "text", value: cells[title], size: 9, data: { key: title } },
                (element) => set(title)(element.value),
            ),
        );
    const options = /** @type {Option[]} */ ([
        ["", "by its title"],
        ...channels.map(([title, unit]) => [title, `${title} [${unit || "no unit"}]`]),
    ]);
    const channel = (/** @type {string} */ title) =>
        labelled(title, choice(options, cells[title], set(title), { data: { key: title } }));
    const raw = kind === "raw";
    fill(
        place,
        h("h2", {}, "What the table says"),
        rowOf(
            raw ? CHANNELS.map(channel) : field("period [s]"),
            [...CELLS, ...(raw ? RAW_CELLS : [])].map(field),
            raw && blocks > 1 ? field("block") : null,
        ),
    );
}
