// What came of a job, in plain words: {tone: "good" | "bad" | "unsure", title, text}.

import { count, percent, superscript } from "./dom.js";

const OPTION_NAMES = { strength: "Strength", tolerance: "What counts as a change", layers: "What to put in", bits: "Size of the id" };

/** The command line's sentences name its options and commands: here they are called otherwise. */
export function plain(sentence) {
  return sentence
    .replaceAll("`meshmark authenticate`", "The tab Check")
    .replace(/--(strength|tolerance|layers|bits) (\w+)/g, (_, option, value) => `the option “${OPTION_NAMES[option]}: ${value}”`)
    .replaceAll("--certificate", "the certificate")
    .replaceAll("--search wide", "“Search longer”");
}

const listed = (names) => `${names.slice(0, -1).join(", ")} and ${names.at(-1)}`;
const idsOf = ({ ids }) => (ids.length > 1 ? `It carries the ids ${ids.join(", ")}` : `It carries the id ${ids[0]}`);

const WORDS = {
  embed(result) {
    const upper = result.mark_vertices
      ? `Later changes will be found by ${count(result.mark_vertices)} small marks${result.payload_bytes ? ", and restored from a miniature of the model that they carry" : ""}.`
      : result.bits === 64
        ? "It carries the id alone: there was no room for marks that tell later changes."
        : "It carries no marks that tell later changes.";
    const told = result.id === null ? "says that it is marked with this key" : `carries the id ${result.id}`;
    return {
      tone: "good",
      title: "The model is marked",
      text: `Its shape ${told}; the surface moved by ${percent(result.rms_over_diagonal)} of the model's diagonal. ${upper} It was read back and verified. Keep the certificate: with it, the mark is found in badly damaged copies and can be taken off again.`,
    };
  },
  unmark(result) {
    const near = result.exact ? `the original within ${result.within_over_diagonal.toExponential(1)} of its diagonal` : "not quite the original, as the file was changed since it was marked";
    return { tone: result.exact ? "good" : "unsure", title: "The mark is off", text: `What you get is ${near}.` };
  },
  authenticate(result) {
    const [tone, title] = {
      authentic: ["good", "Authentic"],
      surface_intact: ["unsure", "The surface is intact, but the file shows something else"],
      altered: ["bad", "Altered since it was marked"],
      not_marked: ["unsure", "Not marked with this key"],
      inconclusive: ["unsure", "This cannot be told"],
    }[result.verdict];
    return { tone, title, text: result.advice };
  },
  extract(result) {
    const names = result.recipients || [];
    const copies = names.length > 1 ? `the copies of ${listed(names)}` : `the copy of ${names[0]}`;
    const title = { 0: "Your mark is in this model", 1: `This is ${copies}` }[names.length] || `This was made of ${copies}`;
    return {
      present: { tone: "good", title, text: `${result.ids.length ? `${idsOf(result)}. ` : ""}${result.advice}` },
      absent: { tone: "unsure", title: "No mark of this key was found", text: result.advice },
      inconclusive: { tone: "unsure", title: "This cannot be told", text: result.advice },
    }[result.presence];
  },
  trace(result) {
    const names = [...new Set(result.matches.map((each) => each.recipient || "a recipient without a name"))];
    if (!names.length) {
      return result.presence === "present"
        ? { tone: "unsure", title: "Your mark is in it, but it is no copy of this registry", text: `${idsOf(result)}. ${result.advice}` }
        : { tone: "unsure", title: "It names no recipient", text: result.advice };
    }
    const surest = Math.max(...result.matches.map((each) => each.log10_false_accusation));
    const text = `${idsOf({ ids: result.matches.map((each) => each.id) })}. The chance that an innocent recipient of this registry is named like this is below 10${superscript(Math.ceil(surest))}. This says whose copy it was made of, not who passed it on.`;
    return { tone: "good", title: names.length > 1 ? `This was made of the copies of ${listed(names)}` : `This is the copy of ${names[0]}`, text };
  },
  recover(result) {
    if (!result.recovered) return { tone: "bad", title: "It cannot be restored", text: result.advice };
    if (!result.altered_area_fraction) return { tone: "good", title: "Nothing had to be restored", text: result.advice };
    return { tone: "good", title: "The altered part is restored", text: `${percent(result.altered_area_fraction)} of the surface was altered. ${result.advice} All else is as it was signed.` };
  },
};

export function verdictOf(job) {
  const found = WORDS[job.action](job.result);
  return { ...found, text: plain(found.text) };
}

/** The sentence of an error, as the command line prints it; the name of a file at its start stays as it is. */
export function errorOf(error) {
  const sentence = plain(error.message);
  const first = error.file && sentence.startsWith(error.file) ? sentence[0] : sentence[0].toUpperCase();
  return first + sentence.slice(1) + (/[.!?]$/.test(sentence) ? "" : ".");
}
