// What is drawn again and again while a hand moves: once a frame, in a box that is known, as fine as time allows,
// and only where it has changed.

import {clamp} from "./elements.js";

const SVG = "http://www.w3.org/2000/svg";

/** Call a function once in the next frame, however often this is called. */
export function onceAFrame(call) {
  let waiting = false;
  return () => {
    if (waiting) return;
    waiting = true;
    requestAnimationFrame(() => { waiting = false; call(); });
  };
}

/**
 * A reader of the box of a node; `changed` is called when its size has changed. Only then is it measured again,
 * since the browser lays the whole page out for an answer.
 */
export function boxOf(node, changed) {
  let box = null;
  new ResizeObserver(() => { box = null; changed(); }).observe(node);
  return () => {
    if (!box || !box.width) box = node.getBoundingClientRect();
    return box;
  };
}

/** How finely something is computed while a hand moves: as finely as a share of a frame allows. */
export class Fineness {
  /** Milliseconds that it may take, its least share of the full fineness in motion, and its largest. */
  constructor(time, least, most = 1) {
    Object.assign(this, {time, least, most, share: Math.sqrt(least * most)});
  }

  /** The result of a computation, which gets its fineness: full at rest, adapted to the last times in motion. */
  spend(moving, compute) {
    if (!moving) return compute(1);
    const begun = performance.now(), found = compute(this.share), took = Math.max(0.5, performance.now() - begun);
    this.share = clamp(this.share * Math.sqrt(this.time / took), this.least, this.most);
    return found;
  }
}

/** Whether something is to be computed again: its content has changed, or it was coarse and nothing moves any more. */
export class Renewal {
  due(content, moving) {
    if (content === this.content && (moving || !this.coarse)) return false;
    Object.assign(this, {content, coarse: moving});
    return true;
  }
}

/** A part of a drawing in words: a tag, attributes, and parts or text inside. */
export function part(tag, attributes = {}, ...children) {
  const inside = children.flat().filter((c) => c !== null && c !== undefined && c !== "");
  return {tag, attributes, children: inside.map((c) => (typeof c === "object" ? c : String(c)))};
}

/** A symbol such as ω_Z as a part, with its index below the line. */
export function symbolPart(name) {
  const [letter, index] = name.split("_");
  return part("tspan", {"font-style": "italic"}, letter,
    index ? part("tspan", {"baseline-shift": "sub", "font-size": "75%"}, index) : null);
}

const drawnParts = new WeakMap(); // of each node, the parts that it shows

/** Make a node show these parts; nodes that show the same as before stay as they are. */
export function show(node, parts) {
  const before = drawnParts.get(node) || [];
  parts.forEach((now, i) => {
    const last = before[i], child = node.childNodes[i];
    if (typeof now === "string") {
      if (last === now) return;
      if (typeof last === "string") child.data = now;
      else place(node, child, document.createTextNode(now));
    } else if (last && last.tag === now.tag) {
      attributes(child, last.attributes, now.attributes);
      show(child, now.children);
    } else place(node, child, made(now));
  });
  while (node.childNodes.length > parts.length) node.lastChild.remove();
  drawnParts.set(node, parts);
}

function place(node, old, fresh) {
  if (old) old.replaceWith(fresh);
  else node.append(fresh);
}

function made({tag, attributes: given, children}) {
  const node = document.createElementNS(SVG, tag);
  attributes(node, {}, given);
  show(node, children);
  return node;
}

function attributes(node, before, now) {
  for (const name in before) if (!(name in now)) node.removeAttribute(name);
  for (const name in now) {
    const value = now[name];
    if (value === before[name]) continue;
    if (value === null || value === undefined || value === false) node.removeAttribute(name);
    else node.setAttribute(name, value);
  }
}
