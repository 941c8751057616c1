// The page: what the server is, a session where it asks for its token, and the panels.

import { get, post } from "./api.js";
import { say, time } from "./dom.js";
import { startForm } from "./forms.js";
import { loadKeys, startKeys } from "./keys.js";
import { loadRegistry, startRegistry } from "./registry.js";
import { startTabs } from "./tabs.js";
import { startTheme } from "./theme.js";

const login = document.getElementById("login");

async function begin() {
  const server = await get("/api/server");
  document.getElementById("version").textContent = server.version;
  document.getElementById("kept").textContent = time(server.kept_seconds);
  document.getElementById("tab-registry").hidden = !server.registry;
  for (const form of document.querySelectorAll("form[data-job]")) startForm(form, server);
  startKeys();
  startRegistry();
  startTabs((name) => { if (name === "registry") loadRegistry().catch(broken); });
  await loadKeys();
  document.querySelector(".tabs").hidden = false;
  document.body.dataset.state = "ready";
}

/** Ask for the token; one in the address, after #token=, is taken from there. */
async function enter() {
  const given = new URLSearchParams(location.hash.slice(1)).get("token");
  if (given) {
    history.replaceState(null, "", "/");
    if (await present(given)) return;
  }
  document.querySelector(".tabs").hidden = true;
  login.hidden = false;
  login.querySelector("form").addEventListener("submit", (event) => {
    event.preventDefault();
    present(login.querySelector("input").value.trim());
  });
  login.querySelector("input").focus();
}

async function present(token) {
  try {
    await post("/api/session", { token });
  } catch (error) {
    say(login.querySelector(".wrong"), error.status === 401 || error.status === 422 ? "This is not the token of this server." : `${error.message}.`);
    return false;
  }
  login.hidden = true;
  await begin();
  return true;
}

function broken(error) {
  const wrong = document.createElement("p");
  wrong.className = "wrong";
  wrong.setAttribute("role", "alert");
  wrong.textContent = `This page cannot go on: ${error.message}.`;
  document.getElementById("content").prepend(wrong);
}

startTheme();
begin().catch((error) => (error.status === 401 ? enter() : broken(error)));
