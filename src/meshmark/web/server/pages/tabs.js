// Tabs: one panel is shown; arrows, Home and End move between tabs, and the address remembers which one it is.

const tabs = () => [...document.querySelectorAll('[role="tab"]')].filter((tab) => !tab.hidden);
let opened = () => {};

function show(tab, focus = false) {
  for (const each of document.querySelectorAll('[role="tab"]')) {
    const chosen = each === tab;
    each.setAttribute("aria-selected", String(chosen));
    each.tabIndex = chosen ? 0 : -1;
    document.getElementById(each.getAttribute("aria-controls")).hidden = !chosen;
  }
  if (focus) tab.focus();
  const name = tab.getAttribute("aria-controls");
  if (location.hash !== `#${name}`) history.replaceState(null, "", `#${name}`);
  opened(name);
}

/** Show a panel by its name. */
export function openTab(name) {
  const tab = tabs().find((each) => each.getAttribute("aria-controls") === name) || tabs()[0];
  show(tab);
}

/** Make the tabs work; `told(name)` hears which panel is opened. */
export function startTabs(told) {
  opened = told;
  const list = document.querySelector('[role="tablist"]');
  list.addEventListener("click", (event) => {
    const tab = event.target.closest('[role="tab"]');
    if (tab) show(tab);
  });
  list.addEventListener("keydown", (event) => {
    const all = tabs(), at = all.indexOf(document.activeElement);
    const next = { ArrowRight: at + 1, ArrowLeft: at - 1, Home: 0, End: all.length - 1 }[event.key];
    if (next === undefined || at < 0) return;
    event.preventDefault();
    show(all[(next + all.length) % all.length], true);
  });
  addEventListener("hashchange", () => openTab(location.hash.slice(1)));
  openTab(location.hash.slice(1));
}
