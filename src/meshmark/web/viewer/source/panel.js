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
  if (layer.kind === "heat") parts.push(scale(layer));
  if (layer.kind === "categories") parts.push(entries(layer.legend.entries.filter((entry) => entry.label)));
  if (layer.legend?.missing) parts.push(entries([layer.legend.missing]));
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
  const name = layer.unit ? `${layer.title}, ${layer.unit}` : layer.title;
  return make(
    "div", { class: "viewer-scale" },
    make("span", { class: "viewer-scale-name" }, name), bar, make("div", { class: "viewer-ticks" }, ...numbers),
  );
}

function entries(list) {
  const items = list.map(({ label, colour }) => {
    const swatch = make("span", { class: "viewer-swatch", "aria-hidden": "true" });
    swatch.style.background = colour;
    return make("li", {}, swatch, label);
  });
  return make("ul", { class: "viewer-entries" }, ...items);
}
