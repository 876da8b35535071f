// Trees in space, colored by what happens in their vessels; trees beside one another share one scale of colors.
import { fill, h, shown } from "./dom.js";
import { style } from "./plot.js";

const MOVING = ["pressure [mmHg]", "flow [ml/s]"];
export const COLORS = ["mean pressure [mmHg]", "pulse pressure [mmHg]", "mean flow [ml/s]", "wave speed [cm/s]", ...MOVING.map((one) => `${one} now`)];
export const MOMENTS = 32;

const moving = (colored) => MOVING.find((name) => colored === `${name} now`);

/** What the vessels of a simulation show at a moment of the cycle. */
function values(run, { colored, moment }) {
  const name = moving(colored);
  return name ? run.frames[name][Math.floor(moment / MOMENTS * run.frames[name].length)] : run.vessels[colored];
}

/** Lowest and highest that any of the simulations shows at any moment. */
export function range(runs, { colored }) {
  const name = moving(colored), every = runs.flatMap((run) => (name ? run.frames[name].flat() : run.vessels[colored])).filter(Number.isFinite);
  return [Math.min(...every), Math.max(...every)];
}

function mixed(stops, share) {
  const at = Math.min(0.9999, Math.max(0, share)) * (stops.length - 1), k = Math.floor(at);
  return `rgb(${[0, 1, 2].map((i) => Math.round(stops[k][i] + (at - k) * (stops[k + 1][i] - stops[k][i])))})`;
}

/** A tree that can be turned; `told` is its model, `now` gives its simulation, how it is colored, and the scale. */
export function treeIn(canvas, told, now) {
  const { axes, radius } = told.tree;
  // eslint-disable-next-line no-undef
  const view = turntable(canvas, axes.flat(), (one) => {
    const { run, shown: how, scale: [low, high] } = now(), ink = style("--ink");
    if (!run) return;
    const list = values(run, how);
    const pieces = axes.map(([from, to], row) => [one.seen(from), one.seen(to), row]).sort((a, b) => b[0][2] + b[1][2] - a[0][2] - a[1][2]);
    for (const [from, to, row] of pieces) {
      const width = Math.max(2, 2 * radius[row] * one.unit());
      one.line(from, to, width + 1.5, ink);
      one.line(from, to, width, mixed(told.stops, (list[row] - low) / (high - low || 1)));
    }
    one.scaleBar(ink);
    canvas.dataset.drawn = String(Number(canvas.dataset.drawn || 0) + 1);
  }, () => {});
  view.rotate(0.5, 0.3);
  return view;
}

/** The scale of colors below the trees. */
export function scaleOf(place, stops, [low, high], { colored }) {
  const bar = h("i");
  bar.style.background = `linear-gradient(to right, ${stops.map((stop) => `rgb(${stop})`).join(", ")})`;
  fill(place, `${shown(low, 3)} `, bar, ` ${shown(high, 3)} ${colored.match(/\[(.*)\]/)?.[1] ?? ""}; directions are drawn, not measured`);
}
