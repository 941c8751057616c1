// The viewer by keyboard: arrows turn, with Shift they move, + and - zoom, Home or 0 resets.

export const KEYS = "Arrow keys turn the model, with Shift they move it. Plus and minus zoom, Home resets the view.";

const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
const ZOOM = { "+": 1, "=": 1, "-": -1, _: -1 };

/** A listener for keydown. */
export function keyboard(stage) {
  return (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const { key } = event;
    if (key in ARROWS) {
      const [right, up] = ARROWS[key];
      if (event.shiftKey) stage.pan(right, up);
      else stage.turn(right, -up);
    } else if (key in ZOOM) stage.zoom(ZOOM[key]);
    else if (key === "Home" || key === "0") stage.reset();
    else return;
    event.preventDefault();
  };
}
