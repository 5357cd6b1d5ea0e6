// Sizes and phases of the components of a mode as text.

import {text} from "../../drawing/elements.js";

const SIZE = 3; // digits of a size
const EQUAL = 1e-6; // sizes that differ by less count as equal

/** A phase in degrees with one decimal, above −180° and at most 180°. */
export function phaseText(phase) {
  const rounded = Number(phase.toFixed(1)), turned = rounded === -180 ? 180 : rounded === 0 ? 0 : rounded;
  return `${String(turned).replace("-", "−")}°`;
}

export function sizeText(size) {
  return text(size, SIZE);
}

/** The components of a mode that are larger than `least`, the largest first: name, size, and phase in brackets. */
export function componentsText(parts, names, least) {
  const all = parts.map((part, i) => ({...part, name: names[i]})).filter(({size}) => size > least);
  const order = ({size}) => Math.round(size / EQUAL); // equal ones stay in order: the first has phase 0
  return all.sort((a, b) => order(b) - order(a)).map(({name, size, phase}) => `${name} ${sizeText(size)} (${phaseText(phase)})`).join(", ");
}
