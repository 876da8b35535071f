// Sliders of a model's parameters, each with its fit, its interval, and where another animal's fit lies.
import { fill, h, shown, symbol } from "./dom.js";

/** Draw the sliders; `values` are those that were moved, and `moved` is called after each of them. */
export function knobsIn(place, knobs, values, others, moved) {
  const beside = new Map(others.map((one) => [one.name, one.value]));
  fill(place, knobs.map((one) => knob(one, values, beside.get(one.name), moved)),
    h("p", { class: "keys" }, "The line is the fit, the shade its 95 % interval", others.length ? ", the other line the other animal's fit." : "."));
}

function knob(one, values, other, moved) {
  const where = (value) => (Math.log(value) - Math.log(one.low)) / (Math.log(one.high) - Math.log(one.low));
  const left = (share) => `calc(8px + (100% - 16px) * ${share})`;
  const text = () => `${shown(values[one.name] ?? one.value)} ${one.unit}`;
  const out = h("output", {}, text());
  const input = h("input", { type: "range", min: 0, max: 1000, step: 1, value: 1000 * where(values[one.name] ?? one.value), "aria-label": `${one.symbol} ${one.meaning}`, "aria-valuetext": text(),
    data: { key: one.name, knob: one.name }, oninput: () => {
      values[one.name] = one.low * (one.high / one.low) ** (input.value / 1000);
      out.textContent = text();
      input.setAttribute("aria-valuetext", text());
      moved();
    } });
  const fit = h("b"), shade = one.interval ? h("i") : null, mark = other !== undefined && other >= one.low && other <= one.high ? h("b", { class: "other" }) : null;
  fit.style.left = left(where(one.value));
  if (mark) mark.style.left = left(where(other));
  if (shade) {
    const [low, high] = one.interval.map((value) => Math.min(1, Math.max(0, where(value))));
    shade.style.left = left(low);
    shade.style.width = `calc((100% - 16px) * ${Math.max(0.004, high - low)})`;
  }
  return h("div", { class: "knob", title: one.meaning }, h("label", {}, h("span", {}, symbol(one.symbol), " ", h("small", {}, symbol(one.meaning))), out),
    h("div", { class: "track" }, shade, fit, mark, input));
}
