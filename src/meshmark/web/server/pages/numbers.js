// The numbers of an answer: the ones that matter as a list, regions as a table, all of them as JSON.

import { button, count, make, percent, superscript, time } from "./dom.js";

const chance = (log10) => (log10 === null || log10 === undefined ? null : log10 < -4 ? `below 10${superscript(Math.ceil(log10))}` : percent(10 ** log10));
const share = (value) => (value === null || value === undefined ? null : percent(value));
const number = (value) => (value === null || value === undefined ? null : count(value));

const PICKED = {
  embed: (r) => [["Id", code(r.id)], ["Vertices", number(r.vertices)], ["Triangles", number(r.faces)],
    ["Moved, root mean square", `${share(r.rms_over_diagonal)} of the diagonal`], ["Moved at most", `${share(r.max_over_diagonal)} of the diagonal`],
    ["PSNR", `${r.psnr_db.toFixed(1)} dB`], ["Marks that tell changes", number(r.mark_vertices)], ["Strength", r.strength], ["Time", time(r.seconds)]],
  authenticate: (r) => [["Altered surface", share(r.altered_area_fraction)], ["Altered vertices", number(r.altered_vertices)],
    ["Missing surface", r.missing_area_fraction ? share(r.missing_area_fraction) : null], ["Id", code(r.id)], ["Chance of such marks without the key", chance(r.log10_false_positive)],
    ["Payload", { recovered: "readable", partial: "in part", none: "none" }[r.payload]], ["Time", time(r.seconds)]],
  extract: (r) => [["Id", code(r.id)], ["Chance of a false alarm", r.presence === "present" ? chance(r.log10_false_positive) : null],
    ["Recipients", r.recipients?.join(", ") || null],
    ["Found by", { blind: "the key alone", certificate: "the certificate", original: "the original", registry: "the registry" }[r.mode] || r.mode], ["Time", time(r.seconds)]],
  trace: (r) => [["Mark of this key", r.presence], ["Originals of like shape", r.candidates.join(", ") || "none"], ["Time", time(r.seconds)]],
  recover: (r) => [["Altered surface", share(r.altered_area_fraction)], ["Vertices moved back", number(r.vertices_moved)],
    ["Vertices cut out", number(r.vertices_removed)], ["Triangles added", number(r.faces_added)], ["Time", time(r.seconds)]],
  unmark: (r) => [["Moved, root mean square", `${share(r.rms_over_diagonal)} of the diagonal`], ["Time", time(r.seconds)]],
};

function code(text) {
  return text ? make("code", {}, text) : null;
}

/** An element with the numbers of a job. */
export function numbersOf(job) {
  const { result, action } = job;
  const rows = PICKED[action](result).filter(([, value]) => value !== null && value !== undefined);
  const list = make("dl", { class: "numbers" }, ...rows.map(([name, value]) => make("div", {}, make("dt", {}, name), make("dd", {}, value))));
  const parts = [list];
  if (result.regions?.length) parts.push(regions(result.regions));
  if (result.matches?.length) parts.push(matches(result.matches));
  parts.push(whole(result));
  return make("div", { class: "card" }, make("h3", {}, "Numbers"), ...parts);
}

function table(heads, rows) {
  const cells = (row) => row.map((value, at) => make("td", { "data-name": heads[at] }, value));
  return make("table", {},
    make("thead", {}, make("tr", {}, ...heads.map((head) => make("th", { scope: "col" }, head)))),
    make("tbody", {}, ...rows.map((row) => make("tr", {}, ...cells(row)))));
}

const METHODS = { blind: "the key alone", authentication: "its authentication marks", registered: "the certificate of its original" };

function matches(list) {
  const rows = list.map((each) => [each.recipient || "none named", code(each.id), each.original, METHODS[each.method] || each.method, chance(each.log10_false_accusation)]);
  return make("div", { class: "table" }, table(["Recipient", "Id", "Original", "Read by", "Chance to name an innocent"], rows));
}

const VERDICTS = { altered: "altered", intact: "intact", unchecked: "not checked" };

function regions(list) {
  const sorted = [...list].sort((one, other) => other.probability - one.probability || other.failed - one.failed);
  const rows = sorted.map((each) => [
    each.where, make("span", { class: each.verdict === "altered" ? "bad" : "" }, VERDICTS[each.verdict] || each.verdict),
    each.checks ? `${count(each.failed)} of ${count(each.checks)}` : "none",
  ]);
  return make("details", { class: "more" }, make("summary", {}, `Regions of the model (${list.length})`),
    make("div", { class: "table" }, table(["Where", "Verdict", "Checks that failed"], rows)));
}

function whole(result) {
  const text = JSON.stringify(result, null, 2);
  const copy = button("Copy", async () => {
    await navigator.clipboard.writeText(text);
    copy.textContent = "Copied";
  }, { class: "button quiet" });
  return make("details", { class: "more" }, make("summary", {}, "Everything, as the command line prints it with --json"),
    make("div", { class: "json" }, make("pre", { tabindex: "0" }, text), copy));
}
