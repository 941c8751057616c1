// What came of a job: the verdict in plain words, files to save, the view, the numbers.

import { get } from "./api.js";
import { button, make, size } from "./dom.js";
import { numbersOf } from "./numbers.js";
import { errorOf, plain, verdictOf } from "./verdicts.js";

const FILES = {
  model: { embed: "Save the marked model", recover: "Save the restored model", unmark: "Save the model" },
  certificate: "Save the certificate",
  report: "Save the report",
  map: "Save the map",
};
const SIGNS = { good: "✓", bad: "!", unsure: "?" };

/** Show an error in an element. */
export function showError(element, error) {
  element.append(make("div", { class: "card verdict bad", role: "alert" }, make("span", { class: "sign", "aria-hidden": "true" }, "!"),
    make("div", {}, make("h2", { tabindex: "-1" }, "This did not work"), make("p", {}, errorOf(error)))));
}

/** Show what came of a job; `restore()` begins the recovery of what was altered. */
export async function showOutcome(element, job, restore) {
  const { tone, title, text } = verdictOf(job);
  const heading = make("h2", { tabindex: "-1" }, title);
  const words = make("div", {}, heading, make("p", {}, text));
  if (job.remarks.length) words.append(make("ul", { class: "remarks" }, ...job.remarks.map((line) => make("li", {}, plain(line)))));
  const files = downloads(job);
  if (job.action === "authenticate" && job.result.verdict === "altered" && job.result.payload !== "none" && job.result.payload_kind !== "file") {
    const again = button("Restore the altered part", () => { again.disabled = true; restore(); }, { class: "button second" });
    files.prepend(again);
  }
  if (files.childElementCount) words.append(files);
  const card = make("div", { class: `card verdict ${tone}`, role: "status" }, make("span", { class: "sign", "aria-hidden": "true" }, SIGNS[tone]), words);
  const view = make("div", { class: "view" });
  element.append(card, view, numbersOf(job));
  heading.focus({ preventScroll: true });
  card.scrollIntoView({ block: "nearest", behavior: matchMedia("(prefers-reduced-motion: reduce)").matches ? "auto" : "smooth" });
  if (job.view) await showView(view, job.view);
  else view.remove();
}

function downloads(job) {
  const links = job.downloads.map((file) => {
    const label = FILES[file.kind]?.[job.action] || (typeof FILES[file.kind] === "string" ? FILES[file.kind] : `Save ${file.name}`);
    const main = file.kind === "model" ? "main" : "second";
    return make("a", { class: `button ${main}`, href: file.url, download: file.name, title: file.name }, label, make("span", { class: "size" }, size(file.bytes)));
  });
  return make("div", { class: "downloads" }, ...links);
}

async function showView(element, url) {
  try {
    const [{ createViewer }, view] = await Promise.all([import("/viewer/viewer.bundle.js"), get(url)]);
    createViewer(element, view);
  } catch (error) {
    element.replaceChildren(make("p", { class: "soft" }, `The view cannot be shown here: ${error.message}.`));
  }
}
