// The registry: who got which copy, with a filter.

import { get } from "./api.js";
import { count, make } from "./dom.js";

const MOST_ROWS = 500;
const HEADS = ["Recipient", "Model", "Id", "Issued", "State"];
let records = [];

/** Ask the server for the copies and show them. */
export async function loadRegistry() {
  records = (await get("/api/registry/copies")).records;
  show();
}

function show() {
  const wanted = document.getElementById("registry-filter").value.trim().toLowerCase();
  const found = records.filter((row) => [row.recipient, row.original, row.id].some((text) => text?.toLowerCase().includes(wanted)));
  const said = document.querySelector("#registry .said");
  said.textContent = `${count(found.length)} ${found.length === 1 ? "copy" : "copies"}${found.length > MOST_ROWS ? `, of which the first ${MOST_ROWS} are shown` : ""}`;
  const rows = found.slice(0, MOST_ROWS).map((row) => {
    const values = [row.recipient || "nobody", row.original, make("code", {}, row.id), when(row.issued_at), row.state];
    return make("tr", {}, ...values.map((value, at) => make("td", { "data-name": HEADS[at] }, value)));
  });
  const head = make("tr", {}, ...HEADS.map((name) => make("th", { scope: "col" }, name)));
  const table = make("table", {}, make("thead", {}, head), make("tbody", {}, ...rows));
  document.getElementById("registry-table").replaceChildren(rows.length ? table : "");
}

const when = (text) => (text ? new Date(text).toLocaleString(undefined, { dateStyle: "medium", timeStyle: "short" }) : "not yet");

/** Make the filter work. */
export function startRegistry() {
  document.getElementById("registry-filter").addEventListener("input", show);
}
