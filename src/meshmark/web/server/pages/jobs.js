// One job from its upload to its end: what it is at is drawn into an element, and it can be cancelled.

import { ApiError, get, remove, upload } from "./api.js";
import { button, make, time } from "./dom.js";

const WAIT = 10; // seconds after which the server answers though nothing has changed
const STAGES = {
  waiting: "Waiting for other jobs",
  starting: "Reading the model",
  marking: "Putting the mark in, and reading it back",
  "checking the marks": "Checking the marks",
  "looking for the mark": "Looking for the mark",
  recovering: "Restoring",
  "taking the mark off": "Taking the mark off",
  drawing: "Drawing",
};

const stageOf = (job) => {
  if (job.position) return `Waiting for ${job.position === 1 ? "one other job" : `${job.position} other jobs`}`;
  return STAGES[job.stage] || job.stage[0].toUpperCase() + job.stage.slice(1);
};

/** Run a job; `element` shows its progress. Returns the job when it is over, null where it was cancelled. */
export async function runJob(form, element) {
  const stop = new AbortController();
  const stage = make("p", { class: "stage", role: "status" }, "Uploading");
  const clock = make("span", { class: "clock" });
  const bar = make("progress", { max: "1", "aria-label": "Progress" });
  const cancel = button("Cancel", () => stop.abort());
  element.replaceChildren(make("div", { class: "card progress" }, make("div", {}, stage, clock), bar, cancel));
  const began = performance.now();
  const ticking = setInterval(() => { clock.textContent = time((performance.now() - began) / 1000); }, 1000);
  let job = null;
  try {
    job = await upload("/api/jobs", form, (share) => { bar.value = share; }, stop.signal);
    bar.removeAttribute("value"); // how long it takes is not known
    while (!["done", "failed", "cancelled"].includes(job.state)) {
      if (stageOf(job) !== stage.textContent) stage.textContent = stageOf(job);
      job = await unlessStopped(get(`/api/jobs/${job.id}?wait=${WAIT}`), stop.signal);
    }
    return job.state === "cancelled" ? null : job;
  } catch (error) {
    if (error.name !== "AbortError") throw error;
    if (job) await remove(`/api/jobs/${job.id}`).catch((failed) => { if (!(failed instanceof ApiError)) throw failed; });
    return null;
  } finally {
    clearInterval(ticking);
    element.replaceChildren();
  }
}

function unlessStopped(work, signal) {
  if (signal.aborted) return Promise.reject(new DOMException("cancelled", "AbortError"));
  return new Promise((resolve, reject) => {
    signal.addEventListener("abort", () => reject(new DOMException("cancelled", "AbortError")), { once: true });
    work.then(resolve, reject);
  });
}
