// The colour bar: the largest growth rate, what each colour means, in the scale of the diagram.

import {css, shade} from "../drawing/colours.js";
import {text} from "../drawing/elements.js";
import {part, show} from "../drawing/redrawn.js";
import {rateTicks} from "../drawing/scales.js";

const STRIPES = 80;

/** Draw the bar into its drawing, which has this box: growth above, decay below; rates are shown times `size`, in a unit. */
export function colourBar(drawing, box, scale, colours, even, {size, unit}) {
  const width = box.width || 54, height = box.height || 300;
  const top = 22, bottom = 38, tall = height - top - bottom, x = 6, wide = 12, parts = [];
  const first = even ? STRIPES / 2 : 0; // without friction nothing decays
  const place = (u) => top + tall * (1 - (even ? 2 * u - 1 : u));
  for (let i = first; i < STRIPES; i++) {
    parts.push(part("rect", {x, width: wide, y: place((i + 1) / STRIPES),
      height: tall / (STRIPES - first) + 0.6, fill: css(shade(colours.ramp, (i + 0.5) / STRIPES))}));
  }
  parts.push(part("rect", {class: "frame", x, y: top, width: wide, height: tall}));
  for (const v of rateTicks(scale, Math.max(2, Math.floor(tall / 60)), size)) {
    if (even && v < 0) continue;
    const y = place(scale.place(v / size));
    parts.push(part("path", {class: "tick", d: `M${x + wide} ${y}h3`}),
      part("text", {class: "number", x: x + wide + 5, y: y + 3.5}, text(v, 3)));
  }
  parts.push(part("text", {class: "number strong", x: 0, y: 12}, "grows"));
  parts.push(part("text", {class: "number strong", x: 0, y: height - 22}, even ? "persists" : "decays"));
  parts.push(part("text", {class: "title", "text-anchor": "middle",
    transform: `translate(${width - 5} ${top + tall / 2}) rotate(-90)`},
  "largest growth rate Re ", part("tspan", {"font-style": "italic"}, "λ"), unit ? ` [${unit}]` : ""));
  drawing.setAttribute("viewBox", `0 0 ${width} ${height}`);
  show(drawing, parts);
}
