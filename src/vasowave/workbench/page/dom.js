// Elements made from values: what a file or a person wrote is always text, never markup.

/**
 * @param {string} tag
 * @param {Object<string, any>} given attributes; `on…` are listeners, `data` a dataset, others properties or attributes
 * @param {...any} children nodes, text, lists, or nothing
 */
export function h(tag, given = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(given)) {
    if (value === undefined || value === null || value === false) continue;
    if (name.startsWith("on")) made.addEventListener(name.slice(2), value);
    else if (name === "data") Object.assign(made.dataset, value);
    else if (name === "class") made.className = value;
    else if (name in made && name !== "list") made[name] = value;
    else made.setAttribute(name, value === true ? "" : value);
  }
  made.append(...children.flat(9).filter((one) => one !== null && one !== undefined && one !== false));
  return made;
}

/** A number in `digits` digits, a dash where there is none. */
export const shown = (value, digits = 4) =>
  value === null || value === undefined || !Number.isFinite(value) ? "–" : String(Number(value.toPrecision(digits)));

/** A symbol with its subscripts below the line: R_T, C_p. */
export const symbol = (text) => text.split(/_(\w+)/).map((part, k) => (k % 2 ? h("sub", {}, part) : part));

/** A choice; `said` is called with the value that is chosen. */
export function choice(options, value, said, given = {}) {
  const made = h("select", { ...given, onchange: () => said(made.value) },
    options.map((one) => (Array.isArray(one) ? h("option", { value: one[0] }, one[1]) : h("option", { value: one }, one || "–"))));
  if (value && !options.some((one) => (Array.isArray(one) ? one[0] : one) === value)) made.append(h("option", { value }, value));
  made.value = value;
  return made;
}

/** Replace what an element holds, and give the keyboard back to the control that had it. */
export function fill(place, ...children) {
  const at = document.activeElement, key = place.contains(at) ? at?.dataset?.key : null;
  const scrolled = [...place.querySelectorAll("[data-scrolls]")].map((one) => one.scrollLeft);
  place.replaceChildren(...children.flat(9).filter((one) => one !== null && one !== undefined && one !== false));
  [...place.querySelectorAll("[data-scrolls]")].forEach((one, k) => { one.scrollLeft = scrolled[k] || 0; });
  if (key) [...place.querySelectorAll("[data-key]")].find((one) => one.dataset.key === key)?.focus({ preventScroll: true });
}
