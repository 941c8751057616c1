// Keys: the list of them, the choice of one in each form, and the making of new ones.

import { get, post } from "./api.js";
import { button, make, say } from "./dom.js";

const CHOSEN = "meshmark-key";
let keys = [];

/** Ask the server for its keys and show them everywhere. */
export async function loadKeys() {
  keys = await get("/api/keys");
  document.querySelectorAll("[data-keys]").forEach(showChoice);
  showTable(document.getElementById("key-table"));
}

function showChoice(element) {
  const usable = keys.filter((key) => key.fingerprint);
  element.replaceChildren(usable.length ? choice(usable) : firstKey());
}

function choice(usable) {
  const options = usable.map((key) => make("option", { value: key.label }, key.label));
  const select = make("select", { name: "key" }, ...options);
  const kept = localStorage.getItem(CHOSEN);
  if (usable.some((key) => key.label === kept)) select.value = kept;
  const print = make("small", {});
  const tell = () => { print.textContent = `Public fingerprint ${keys.find((key) => key.label === select.value).fingerprint}`; };
  select.addEventListener("change", () => { localStorage.setItem(CHOSEN, select.value); tell(); });
  tell();
  return make("label", { class: "field" }, make("span", {}, "Key"), select, print);
}

/** What a form shows while there is no key. */
function firstKey() {
  const input = make("input", { value: "my-key", maxlength: "64", autocomplete: "off", spellcheck: "false" });
  const wrong = make("p", { class: "wrong", role: "alert", hidden: true });
  const label = make("label", { class: "field" }, make("span", {}, "There is no key yet. Name of the first one"), input,
    make("small", {}, "Marks are put in and found with a secret key, which stays on the server's computer."));
  const maker = button("Make the key", () => makeKey(input.value, wrong));
  return make("div", { class: "first-key" }, label, wrong, maker);
}

async function makeKey(label, wrong) {
  try {
    const key = await post("/api/keys", { label: label.trim() });
    say(wrong, "");
    localStorage.setItem(CHOSEN, key.label);
    await loadKeys();
    return key;
  } catch (error) {
    say(wrong, error.kind === "usage" ? "A name is of 1 to 64 letters, digits, dots, dashes and underscores, and begins with a letter or digit." : `${error.message}.`);
    return null;
  }
}

function showTable(element) {
  if (!keys.length) {
    element.replaceChildren(make("p", { class: "soft" }, "There are no keys yet."));
    return;
  }
  const rows = keys.map((key) => make("tr", {},
    make("td", { "data-name": "Name" }, key.label),
    make("td", { "data-name": "Public fingerprint" }, key.fingerprint ? make("code", {}, key.fingerprint) : make("span", { class: "bad" }, `cannot be used: ${key.problem}`))));
  const head = make("tr", {}, make("th", { scope: "col" }, "Name"), make("th", { scope: "col" }, "Public fingerprint"));
  element.replaceChildren(make("table", {}, make("thead", {}, head), make("tbody", {}, ...rows)));
}

/** Make the form for new keys work. */
export function startKeys() {
  const form = document.getElementById("new-key");
  const said = form.parentElement.querySelector(".said");
  form.addEventListener("submit", async (event) => {
    event.preventDefault();
    const key = await makeKey(form.elements.label.value, form.querySelector(".wrong"));
    said.textContent = key ? `The key ${key.label} was made. Its public fingerprint is ${key.fingerprint}.` : "";
    if (key) form.reset();
  });
}
