// What stands around the picture: the choice of layers, the legend, and buttons.

/** An element with attributes and children. */
export function make(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  element.append(...children);
  return element;
}

let viewers = 0;

/** Radio buttons, one a layer; `chosen(name)` is called with the one that is chosen. */
export function layerChoice(layers, current, chosen) {
  const group = `viewer-layer-${++viewers}`;
  const options = layers.map((layer) => {
    const input = make("input", { type: "radio", name: group, value: layer.name });
    input.checked = layer.name === current;
    input.addEventListener("change", () => chosen(layer.name));
    return make("label", {}, input, make("span", {}, layer.title));
  });
  return make("fieldset", { class: "viewer-layers" }, make("legend", {}, "Layer"), ...options);
}

/** The buttons at the picture's corner. */
export function buttons(actions) {
  const made = actions.map(([label, sign, act]) => {
    const button = make("button", { type: "button", "aria-label": label, title: label }, sign);
    button.addEventListener("click", act);
    return button;
  });
  return make("div", { class: "viewer-buttons" }, ...made);
}

/** Put the legend of a layer into an element. */
export function showLegend(element, layer) {
  const parts = [];
  const { ticks, entries: categories = [], missing } = layer.legend ?? {};
  const named = [...categories.filter((entry) => entry.label), ...(missing ? [missing] : [])];
  if (ticks) parts.push(scale(layer));
  if (named.length) parts.push(swatches(named));
  if (layer.note) parts.push(make("p", {}, layer.note));
  element.replaceChildren(...parts);
}

function scale(layer) {
  const { colours, ticks } = layer.legend;
  const bar = make("div", { class: "viewer-bar" });
  bar.style.background = `linear-gradient(to right, ${colours.join(", ")})`;
  const numbers = ticks.map(({ at, label }) => {
    const tick = make("span", {}, label);
    tick.style.left = `${100 * at}%`;
    return tick;
  });
  return make(
    "div", { class: "viewer-scale" },
    ...(layer.unit ? [make("span", { class: "viewer-scale-name" }, layer.unit)] : []), bar, make("div", { class: "viewer-ticks" }, ...numbers),
  );
}

function swatches(list) {
  const items = list.map(({ label, colour }) => {
    const swatch = make("span", { class: "viewer-swatch", "aria-hidden": "true" });
    swatch.style.background = colour;
    return make("li", {}, swatch, label);
  });
  return make("ul", { class: "viewer-entries" }, ...items);
}
