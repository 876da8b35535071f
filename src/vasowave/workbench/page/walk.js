// Walk through models that the data allow: one after another, each with its curves and its values.
import { fill, h, shown, symbol } from "./dom.js";

/** The part of the desk for draws as the server gives them; `show` is called with the curves of one, or null. */
export function walkPart(place, draws, knobs, show) {
  if (!draws?.count) { fill(place); return; }
  const told = new Map(knobs.map((one) => [one.name, one])), values = h("div", { class: "numbers" });
  const out = h("output", {}, "none"), slider = h("input", { type: "range", min: 0, max: draws.count, step: 1, value: 0, "aria-label": draws.kind, data: { key: "draw" }, oninput: () => at(Number(slider.value)) });
  let playing = 0;
  const button = h("button", { type: "button", data: { key: "play draws" }, onclick: () => (playing ? stop() : play()) }, "Play");

  function at(k) {
    out.textContent = k ? `${k} of ${draws.count}` : "none";
    slider.setAttribute("aria-valuetext", out.textContent);
    fill(values, k ? Object.entries(draws.values).map(([name, list]) => h("div", {}, h("span", {}, symbol(told.get(name)?.symbol || name), " ", h("small", {}, told.get(name)?.unit || "")), h("b", { data: { drawn: name } }, shown(list[k - 1])))) : []);
    show(k ? draws.curves[k - 1] : null);
  }

  function play() {
    button.textContent = "Stop";
    playing = setInterval(() => {
      if (!slider.isConnected) { stop(); return; }
      slider.value = String(Number(slider.value) % draws.count + 1);
      at(Number(slider.value));
    }, 400);
  }

  function stop() {
    clearInterval(playing);
    playing = 0;
    button.textContent = "Play";
  }

  fill(place, h("h2", {}, "One by one"), h("div", { class: "row" }, h("label", {}, draws.kind, slider, out), button), values);
}
