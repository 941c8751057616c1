// The entry of the bundle: what a page that holds it gets without a script of its own.

import { createViewer } from "./viewer.js";

export { createViewer };

/** Start a viewer in each element with data-view, the id of the script element that holds its view. */
function startViewers() {
  for (const element of document.querySelectorAll("[data-view]")) {
    try {
      createViewer(element, JSON.parse(document.getElementById(element.dataset.view).textContent));
    } catch (error) {
      element.dataset.state = "failed";
      element.textContent = `The interactive view cannot be shown here (${error.message}).`;
    }
  }
}

/** Let buttons with data-theme-switch turn light into dark and back. */
function startSwitches() {
  const root = document.documentElement;
  const dark = () => (root.dataset.theme ? root.dataset.theme === "dark" : matchMedia("(prefers-color-scheme: dark)").matches);
  for (const button of document.querySelectorAll("[data-theme-switch]")) {
    const name = () => { button.textContent = dark() ? "Light" : "Dark"; };
    button.hidden = false;
    button.addEventListener("click", () => { root.dataset.theme = dark() ? "light" : "dark"; name(); });
    name();
  }
}

startSwitches();
startViewers();
