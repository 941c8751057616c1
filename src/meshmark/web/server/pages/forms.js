// The forms that begin jobs.

import { say, size } from "./dom.js";
import { dropZone } from "./files.js";
import { runJob } from "./jobs.js";
import { showError, showOutcome } from "./outcome.js";

/** Make a form work. server: what GET /api/server says. */
export function startForm(form, server) {
  const wrong = form.querySelector(".wrong"), submit = form.querySelector("button.main");
  const outcome = form.parentElement.querySelector(".outcome");
  const zones = [...form.querySelectorAll("[data-drop]")].map((each) => dropZone(each, () => say(wrong, "")));
  let busy = false;

  const action = () => form.elements.action?.value || form.dataset.job;
  const counts = (element) => !element.closest("[data-only]") || element.closest("[data-only]").dataset.only === action();

  function adapt() {
    for (const each of form.querySelectorAll("[data-registry]")) each.hidden = !server.registry;
    for (const each of form.querySelectorAll("[data-only]")) {
      each.hidden = each.dataset.only !== action() || ("registry" in each.dataset && !server.registry);
    }
    submit.textContent = submit.dataset[`label${action()[0].toUpperCase()}${action().slice(1)}`] || submit.textContent;
  }

  function complaint() {
    for (const zone of zones) {
      if (zone.needed && !zone.files.length && counts(zone.element)) return `Choose ${zone.needed} first.`;
    }
    const bytes = zones.flatMap((zone) => zone.files).reduce((sum, file) => sum + file.size, 0);
    if (bytes > server.upload_bytes) return `These files are ${size(bytes)}, more than the ${size(server.upload_bytes)} that this server takes.`;
    if (!form.elements.key) return "Make a key first.";
    if (form.elements.id?.value && counts(form.elements.id) && !form.elements.id.checkValidity()) return "An id is of up to 16 hexadecimal digits.";
    return "";
  }

  function order(what) {
    const data = new FormData();
    data.set("action", what);
    data.set("key", form.elements.key.value);
    for (const zone of zones) {
      const takes = zone.name !== "original" || what === "extract" || what === "authenticate";
      if (takes && counts(zone.element)) zone.files.forEach((file) => data.append(zone.name, file, file.name));
    }
    for (const field of form.querySelectorAll("select, input:not([type=file]):not([type=radio])")) {
      const given = field.type === "checkbox" ? field.checked : field.value;
      if (given && field.name && field.name !== "key" && counts(field) && what !== "recover") data.set(field.name, field.value);
    }
    return data;
  }

  async function run(what) {
    if (busy) return;
    say(wrong, complaint());
    if (!wrong.hidden) return;
    busy = submit.disabled = true;
    const data = order(what);
    if (what !== "recover") outcome.replaceChildren();
    const place = outcome.appendChild(document.createElement("div"));
    place.className = "result";
    try {
      const job = await runJob(data, place);
      if (!job) place.remove();
      else if (job.state === "failed") showError(place, job.error);
      else await showOutcome(place, job, () => run("recover"));
    } catch (error) {
      showError(place, error);
    } finally {
      busy = submit.disabled = false;
    }
  }

  const whose = form.querySelector("[name=action][value=trace]");
  if (whose) whose.checked = server.registry; // the registry knows more than the key alone
  form.addEventListener("submit", (event) => { event.preventDefault(); run(action()); });
  form.addEventListener("change", adapt);
  adapt();
}
