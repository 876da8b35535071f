// A page is whole without this. With it, curves are read where the pointer is, and an animal picked is marked everywhere.
"use strict";
(() => {
  const all = (selector, at = document) => [...at.querySelectorAll(selector)];
  const reading = document.getElementById("reading");

  // Picking: one animal with all its recordings, kept in the address so that the other document marks it too.
  const picks = document.querySelector("[data-animals]"), animals = picks ? JSON.parse(picks.dataset.animals) : {};
  const owner = recording => animals[recording] || recording;
  const pick = name => {
    all("[data-animal]").forEach(one => {
      one.classList.toggle("picked", owner(one.dataset.animal) === name);
      one.classList.toggle("faded", name !== "" && owner(one.dataset.animal) !== name);
    });
    all("[data-pick]").forEach(one => one.setAttribute("aria-pressed", String(one.dataset.pick === name)));
    all("a[data-other]").forEach(one => { one.hash = name ? "pick=" + encodeURIComponent(name) : ""; });
    document.body.dataset.picked = name;
  };
  const toggled = name => document.body.dataset.picked === name ? "" : name;
  all(".picks").forEach(one => { one.hidden = false; });
  document.addEventListener("click", event => {
    const from = event.target.closest("[data-pick], svg [data-animal], tr[data-animal]");
    if (from) pick(toggled(from.dataset.pick || owner(from.dataset.animal)));
  });
  const asked = () => location.hash.startsWith("#pick=") ? decodeURIComponent(location.hash.slice(6)) : null;
  addEventListener("hashchange", () => { if (asked() !== null) pick(asked()); });
  pick(asked() || "");

  // Reading a curve: its path is a list of points in the drawing; the panel says what they are in its units.
  const points = path => {
    const numbers = path.getAttribute("d").match(/-?[\d.]+(e-?\d+)?/g).map(Number);
    return numbers.reduce((found, value, k) => (k % 2 ? found[found.length - 1].push(value) : found.push([value]), found), []);
  };
  const between = (value, from, to) => to[0] + (value - from[0]) / (from[1] - from[0]) * (to[1] - to[0]);
  const heightAt = (curve, x) => {
    const k = curve.findIndex((point, k) => k > 0 && (curve[k - 1][0] - x) * (point[0] - x) <= 0);
    return k < 1 ? null : between(x, [curve[k - 1][0], curve[k][0] + 1e-9], [curve[k - 1][1], curve[k][1]]);
  };
  const panels = all("svg [data-scale]").map(patch => {
    const box = patch.querySelector("path").getBBox(), scale = JSON.parse(patch.dataset.scale);
    const curves = all("g > path", patch.parentElement).filter(path => path.parentElement.querySelector("title"));
    return { patch, box, scale, curves: curves.map(path => ({ path, points: points(path), owner: path.parentElement })) };
  });
  const digits = (value, range) => value.toFixed(Math.max(0, 2 - Math.floor(Math.log10(Math.abs(range[1] - range[0])))));
  const nearest = (panel, at) => {
    let best = null;
    for (const curve of panel.curves) {
      const y = heightAt(curve.points, at.x);
      if (y !== null && (best === null || Math.abs(y - at.y) < Math.abs(best.y - at.y))) best = { curve, y };
    }
    return best;
  };
  const say = (text, event) => {
    reading.textContent = text;
    reading.hidden = text === "";
    const beyond = event.clientX > innerWidth / 2;
    reading.style.left = beyond ? "auto" : event.clientX + 14 + "px";
    reading.style.right = beyond ? innerWidth - event.clientX + 14 + "px" : "auto";
    reading.style.top = event.clientY + 14 + "px";
  };
  const read = event => {
    const tip = event.target.closest ? event.target.closest("svg g:has(> title)") : null;
    for (const panel of panels) {
      const matrix = panel.patch.getScreenCTM();
      if (!matrix) continue;
      const at = new DOMPoint(event.clientX, event.clientY).matrixTransform(matrix.inverse()), { box, scale } = panel;
      if (at.x < box.x || at.x > box.x + box.width || at.y < box.y || at.y > box.y + box.height) continue;
      const found = nearest(panel, at);
      if (!found) break;
      const x = between(at.x, [box.x, box.x + box.width], scale.x);
      const y = between(found.y, [box.y + box.height, box.y], scale.y);
      const [along, up] = scale.labels.map(label => (label.match(/\[(.*)\]/) || ["", ""])[1]);
      const name = found.curve.owner.querySelector("title").textContent;
      return say(`${name}: ${digits(y, scale.y)} ${up} at ${digits(x, scale.x)} ${along}`, event);
    }
    return say(tip ? tip.querySelector("title").textContent : "", event);
  };
  document.addEventListener("pointermove", read);

  // Below each figure: its layers on and off, and the drawing as a file, as it is seen.
  const button = (label, act) => {
    const made = document.createElement("button");
    made.type = "button";
    made.textContent = label;
    made.addEventListener("click", () => act(made));
    return made;
  };
  const seen = drawing => all("svg", drawing).find(svg => svg.getClientRects().length);
  const save = (link, name) => {
    const made = document.createElement("a");
    made.href = link;
    made.download = name;
    made.click();
  };
  const written = drawing => {
    const whole = seen(drawing).cloneNode(true), [, , width, height] = whole.getAttribute("viewBox").split(" ");
    all("[data-off]", whole).forEach(part => part.remove());
    whole.removeAttribute("style");
    whole.setAttribute("width", width + "pt");
    whole.setAttribute("height", height + "pt");
    const text = new XMLSerializer().serializeToString(whole);
    return { link: "data:image/svg+xml;charset=utf-8," + encodeURIComponent(text), width: +width, height: +height };
  };
  const painted = (drawing, name) => {
    const { link, width, height } = written(drawing), picture = new Image(), scale = 300 / 72;  // dots per point
    picture.onload = () => {
      const canvas = document.createElement("canvas");
      [canvas.width, canvas.height] = [width * scale, height * scale].map(Math.ceil);
      const paper = canvas.getContext("2d");
      paper.fillStyle = "white";
      paper.fillRect(0, 0, canvas.width, canvas.height);
      paper.drawImage(picture, 0, 0, canvas.width, canvas.height);
      save(canvas.toDataURL("image/png"), name + ".png");
    };
    picture.src = link;
  };
  all("figure > .drawing").forEach(drawing => {
    const name = drawing.parentElement.id.replace("figure-", "");
    const row = document.createElement("p");
    row.className = "tools";
    for (const layer of new Set(all("[data-layer]", drawing).map(part => part.dataset.layer))) {
      const made = button(layer, () => {
        const off = made.getAttribute("aria-pressed") === "true";
        made.setAttribute("aria-pressed", String(!off));
        all("[data-layer]", drawing).filter(part => part.dataset.layer === layer).forEach(part => part.toggleAttribute("data-off", off));
      });
      made.setAttribute("aria-pressed", "true");
      row.append(made);
    }
    row.append(button("SVG", () => save(written(drawing).link, name + ".svg")), button("PNG", () => painted(drawing, name)));
    drawing.after(row);
  });
})();
