// A place to drop files on, or to choose them: each element with data-drop becomes one.

import { button, make, size } from "./dom.js";

const HINT = "PLY, OBJ, GLB, glTF, STL, OFF or 3MF. Add the files that the model refers to: .bin, .mtl, textures.";

/** Make an element a drop zone. Returns {files, name, needed, clear(), offer(files)}. */
export function dropZone(element, changed) {
  const { drop: name, title, needed } = element.dataset;
  const single = "single" in element.dataset, small = "small" in element.dataset;
  const input = make("input", { type: "file", multiple: !single, id: `${element.closest("section").id}-${name}` });
  const list = make("ul", { class: "files" });
  const words = make("span", { class: "drop-title" }, title);
  const hint = make("span", { class: "drop-hint" }, small ? "or choose a file" : "or choose files");
  const label = make("label", { class: small ? "drop small" : "drop", for: input.id }, words, hint);
  if (!small) label.append(make("span", { class: "drop-formats" }, HINT));
  const zone = make("div", { class: "drop-zone" }, input, label);
  element.replaceChildren(zone, list);
  let files = [];

  function offer(more) {
    const names = new Set(more.map((file) => file.name));
    files = single ? more.slice(0, 1) : [...files.filter((file) => !names.has(file.name)), ...more];
    input.value = "";
    show();
    changed();
  }

  function show() {
    label.classList.toggle("filled", files.length > 0);
    list.replaceChildren(...files.map((file) => {
      const remove = button("×", () => {
        files = files.filter((each) => each !== file);
        show();
        changed();
        input.focus();
      }, { class: "remove", "aria-label": `Remove ${file.name}` });
      return make("li", {}, make("span", { class: "file-name" }, file.name), make("span", { class: "soft" }, size(file.size)), remove);
    }));
  }

  input.addEventListener("change", () => offer([...input.files]));
  for (const kind of ["dragenter", "dragover"]) {
    zone.addEventListener(kind, (event) => { event.preventDefault(); label.classList.add("over"); });
  }
  for (const kind of ["dragleave", "drop"]) zone.addEventListener(kind, () => label.classList.remove("over"));
  zone.addEventListener("drop", async (event) => {
    event.preventDefault();
    offer(await dropped(event.dataTransfer));
  });
  return { get files() { return files; }, name, needed, element, offer, clear: () => { files = []; show(); } };
}

/** All files of a drop, those in folders too. */
async function dropped(transfer) {
  const entries = [...transfer.items].map((item) => item.webkitGetAsEntry?.()).filter(Boolean);
  if (!entries.length) return [...transfer.files];
  return (await Promise.all(entries.map(filesOf))).flat();
}

async function filesOf(entry) {
  if (entry.isFile) return [await new Promise((resolve, reject) => entry.file(resolve, reject))];
  const reader = entry.createReader(), found = [];
  for (;;) { // a folder is read in parts
    const part = await new Promise((resolve, reject) => reader.readEntries(resolve, reject));
    if (!part.length) return found;
    found.push(...(await Promise.all(part.map(filesOf))).flat());
  }
}

// A file that misses its place must not replace the page.
for (const kind of ["dragover", "drop"]) addEventListener(kind, (event) => event.preventDefault());
