// Small helpers for elements and numbers.

/** An element with attributes and children; an attribute that is null or false is left out. */
export function make(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value !== null && value !== false) element.setAttribute(name, value === true ? "" : value);
  }
  element.append(...children.filter((child) => child !== null && child !== undefined));
  return element;
}

/** A button with what it does. */
export function button(label, act, attributes = {}) {
  const element = make("button", { type: "button", class: "button", ...attributes }, label);
  element.addEventListener("click", act);
  return element;
}

/** Show a sentence in an element, or hide it without one. */
export function say(element, sentence) {
  element.textContent = sentence || "";
  element.hidden = !sentence;
}

/** 1536 is "1.5 kB". */
export function size(bytes) {
  if (bytes < 1000) return `${bytes} bytes`;
  const units = ["kB", "MB", "GB"];
  let value = bytes / 1000, unit = 0;
  while (value >= 999.5 && unit < 2) { value /= 1000; unit += 1; }
  return `${value < 9.95 ? value.toFixed(1) : Math.round(value)} ${units[unit]}`;
}

/** A share with two significant digits: 0.00078 is "0.078 %". */
export function percent(share) {
  if (share === 0) return "0 %";
  const value = 100 * share;
  return `${value >= 99.5 ? Math.round(value) : Number(value.toPrecision(2))} %`;
}

/** 83 is "1 min 23 s". */
export function time(seconds) {
  const whole = Math.round(seconds);
  const [large, small] = whole < 3600 ? [[60, "min"], [1, "s"]] : [[3600, "h"], [60, "min"]];
  const first = Math.floor(whole / large[0]), rest = Math.floor((whole % large[0]) / small[0]);
  return [first && `${first} ${large[1]}`, (rest || !first) && `${rest} ${small[1]}`].filter(Boolean).join(" ");
}

/** -30 is "⁻³⁰". */
export const superscript = (number) => [...String(number)].map((sign) => "⁰¹²³⁴⁵⁶⁷⁸⁹"["0123456789".indexOf(sign)] ?? "⁻").join("");

export const count = (number) => number.toLocaleString("en-US");
