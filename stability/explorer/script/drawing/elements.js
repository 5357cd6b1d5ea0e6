// Elements of the page and numbers as text.

const SVG = "http://www.w3.org/2000/svg";

/** An element with attributes, listeners (`onclick`) and children. */
export function element(tag, attributes = {}, ...children) {
  return filled(document.createElement(tag), attributes, children);
}

/** The same for a drawing. */
export function shape(tag, attributes = {}, ...children) {
  return filled(document.createElementNS(SVG, tag), attributes, children);
}

function filled(made, attributes, children) {
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) made.addEventListener(name.slice(2), value);
    else if (name === "html") made.innerHTML = value;
    else if (value === true) made.setAttribute(name, "");
    else if (value !== false && value !== null && value !== undefined) made.setAttribute(name, value);
  }
  made.append(...children.flat().filter((c) => c !== null && c !== undefined));
  return made;
}

/** A symbol such as ω_Z as an element, with its index below the line. */
export function symbol(name) {
  const [letter, index] = name.split("_");
  return element("i", {}, letter, ...(index ? [element("sub", {}, index)] : []));
}

/** A quantity in words, or by its symbol where it has no words: text where nothing can be set below the line. */
export function spoken(q) {
  return (q.symbol.includes("_") && q.label ? q.label : `${q.label} ${q.symbol}`).trim();
}

const MINUS = "−";

/** A number with this many digits, a true minus, and powers of ten where these are shorter. */
export function text(value, digits = 4) {
  if (!Number.isFinite(value)) return value > 0 ? "∞" : value < 0 ? `${MINUS}∞` : "–";
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size >= 1e5 || size < 1e-3) {
    const [mantissa, power] = value.toExponential(Math.max(0, digits - 2)).split("e");
    return `${trimmed(mantissa)}·10${raised(Number(power))}`.replace(/-/g, MINUS);
  }
  return trimmed(value.toPrecision(digits)).replace("-", MINUS);
}

function trimmed(number) {
  return number.includes(".") && !number.includes("e") ? number.replace(/\.?0+$/, "") : number;
}

function raised(power) {
  const digits = "⁰¹²³⁴⁵⁶⁷⁸⁹";
  return (power < 0 ? "⁻" : "") + [...String(Math.abs(power))].map((d) => digits[d]).join("");
}

/** An eigenvalue, or a pair of them, as text. */
export function complexText([re, im], digits = 4) {
  const size = Math.hypot(re, im), real = Math.abs(re) < 1e-14 * size ? 0 : re;
  if (im === 0) return text(real, digits);
  const first = real === 0 ? "" : `${text(real, digits)} `;
  return `${first}± ${text(Math.abs(im), digits)} i`;
}

/** The shortest decimal that is this double, as Python writes it. */
export function exactText(value) {
  const found = String(value);
  return /^-?\d+$/.test(found) ? `${found}.0` : found.replace("e+", "e");
}

export function clamp(value, low, high) {
  return Math.min(Math.max(value, low), high);
}
