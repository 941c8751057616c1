// Light or dark: as the system has it, until somebody chooses.

const KEPT = "meshmark-theme";
const root = document.documentElement;

const isDark = () => (root.dataset.theme ? root.dataset.theme === "dark" : matchMedia("(prefers-color-scheme: dark)").matches);

/** Make the button work that switches. */
export function startTheme() {
  const button = document.getElementById("theme");
  const kept = localStorage.getItem(KEPT);
  if (kept) root.dataset.theme = kept;
  const name = () => { button.textContent = isDark() ? "Light" : "Dark"; };
  button.addEventListener("click", () => {
    root.dataset.theme = isDark() ? "light" : "dark";
    localStorage.setItem(KEPT, root.dataset.theme);
    name();
  });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", name);
  name();
}
