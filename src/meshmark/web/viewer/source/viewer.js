// A viewer of one surface with layers to choose from: createViewer(element, view).
//
// view: {vertices, faces, positions, box, triangles, layers, start, note, label}; `decode.js` reads the arrays.
// Layers: {name, title, kind, values, legend, unit, note}, of the kinds
//   surface     values: null, or sRGB of each vertex, or with `corners` of each corner of the triangles; skin: null, or
//               images by which the colours are multiplied (`skin.js`)
//   categories  values: a number a vertex, the place in legend.entries [{label, colour}]
//   heat        values: 0 to 254 (or 65534) a vertex, from the first of legend.colours to the last; the next number
//               means that a vertex has no value: legend.missing {label, colour}. legend.ticks [{at, label}], at 0 to 1.

import { cornerColours } from "./colours.js";
import { decodeSurface } from "./decode.js";
import { KEYS, keyboard } from "./keyboard.js";
import { buttons, layerChoice, make, showLegend } from "./panel.js";
import { decodeSkin } from "./skin.js";
import { Stage } from "./stage.js";

const HINT = "Drag to turn, right-drag or two fingers to move. Click, then scroll to zoom.";

/**
 * Fill `element` with a viewer of `view`.
 *
 * Returns {layer, setLayer(name), reset(), dispose()}. element.dataset.state becomes "ready" with the first picture,
 * element.dataset.layer names the layer that the last picture shows. Raises where the view is not as described, or
 * where the browser offers no WebGL; the element is left empty then.
 */
export function createViewer(element, view) {
  const surface = decodeSurface(view);
  let layer = find(view, view.start ?? view.layers[0].name);
  const stage = new Stage(surface, () => {
    element.dataset.layer = layer.name;
    element.dataset.state = "ready";
  });
  const dressed = view.layers.find((each) => each.skin);
  if (dressed) stage.wear(decodeSkin(dressed.skin, surface.triangles));
  const legend = make("div", { class: "viewer-legend" });
  const screen = make("div", { class: "viewer-screen", tabindex: "0", role: "application", "aria-label": label(view) });
  stage.canvas.setAttribute("aria-hidden", "true");
  const actions = [
    ["Zoom in", "+", () => stage.zoom(1)],
    ["Zoom out", "−", () => stage.zoom(-1)],
    ["Reset the view", "⟲", () => stage.reset()],
  ];
  screen.append(stage.canvas);
  const frame = make("div", { class: "viewer-frame" }, screen, buttons(actions));
  const help = make("p", { class: "viewer-help" }, [HINT, view.note].filter(Boolean).join(" "));
  const side = make("div", { class: "viewer-side" }, layerChoice(view.layers, layer.name, setLayer), legend, help);
  element.classList.add("viewer");
  element.replaceChildren(frame, side);

  function setLayer(name) {
    layer = find(view, name);
    for (const input of side.querySelectorAll("input")) input.checked = input.value === name;
    showLegend(legend, layer);
    stage.paint(cornerColours(layer, surface.triangles, view.vertices), Boolean(layer.skin));
  }

  // A page scrolls past the viewer until somebody has clicked into it.
  const wheel = (event) => { if (!screen.contains(document.activeElement)) event.stopImmediatePropagation(); };
  const touched = () => { stage.untouched = false; screen.focus({ preventScroll: true }); };
  const keys = keyboard(stage);
  screen.addEventListener("wheel", wheel, { capture: true });
  screen.addEventListener("pointerdown", touched);
  screen.addEventListener("keydown", keys);
  const watch = new ResizeObserver(([entry]) => stage.resize(entry.contentRect.width, entry.contentRect.height));
  watch.observe(screen);
  const box = screen.getBoundingClientRect();
  stage.resize(box.width, box.height);
  setLayer(layer.name);

  return {
    get layer() { return layer.name; },
    setLayer,
    reset: () => stage.reset(),
    dispose() {
      watch.disconnect();
      stage.dispose();
      element.replaceChildren();
      element.classList.remove("viewer");
      delete element.dataset.state;
      delete element.dataset.layer;
    },
  };
}

function find(view, name) {
  const found = view.layers.find((layer) => layer.name === name);
  if (!found) throw new Error(`there is no layer ${name}, expected one of ${view.layers.map((l) => l.name).join(", ")}`);
  return found;
}

function label(view) {
  return `${view.label || "Interactive view of the model"}. ${KEYS}`;
}
