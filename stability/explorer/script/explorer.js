// The explorer: its parts put together, as a page or as a widget.

import {isDark} from "./drawing/colours.js";
import {element} from "./drawing/elements.js";
import {Raster} from "./drawing/raster.js";
import {launched} from "./mathematics/launch.js";
import {polynomialRoots} from "./mathematics/roots.js";
import {Conditions} from "./parts/conditions.js";
import {Controls} from "./parts/controls.js";
import {Diagram} from "./parts/diagram.js";
import {EigenvaluePlane} from "./parts/eigenvalue_plane.js";
import {ExportMenu} from "./parts/export_menu.js";
import {MotionPanel} from "./parts/motion_panel.js";
import {PointPanel} from "./parts/point_panel.js";
import {FlatStage} from "./parts/flat_stage.js";
import {Stage} from "./parts/stage.js";
import {StateTable} from "./parts/states/state_table.js";
import {View} from "./parts/view.js";

let mounted = 0;

/** What depends on the browser: colours, motion, drawing. */
function browserLook(root, {tones}) {
  const number = mounted++;
  return {
    dark: isDark,
    tones: () => (isDark() ? tones.dark : tones.light),
    colour: (name) => getComputedStyle(root).getPropertyValue(`--${name}`).trim(),
    still: () => window.matchMedia("(prefers-reduced-motion: reduce)").matches,
    raster: (canvas) => new Raster(canvas),
    id: (name) => `stability-${name}-${number}`,
  };
}

/**
 * Build the explorer into an element; `library` gives the 3-D library when it is needed.
 * `link` is what the address says of the view, or null where there is no address.
 */
export function mount(root, data, library, link = null) {
  const view = new View(data, link || ""), look = browserLook(root, data.looks);
  const diagram = new Diagram(view, look), controls = new Controls(view, data.names);
  const point = new PointPanel(view), plane = new EigenvaluePlane(view), conditions = new Conditions(view);
  const states = new StateTable(view), motion = new MotionPanel(view, look), exports = new ExportMenu(view, diagram, link !== null);
  const title = element("h1", {}), under = element("p", {class: "small subtitle"});
  const card = (name, ...children) => element("section", {class: `card ${name}`}, ...children);
  const grows = element("p", {class: "small hint"});
  root.classList.add("explorer");
  root.replaceChildren(
    element("header", {}, element("div", {class: "name"}, title, under), controls.top, exports.root),
    element("main", {},
      element("div", {class: "column"},
        card("diagram-card", diagram.root, grows, controls.root),
        card("conditions-card", element("h2", {}, "Conditions of stability, with these numbers"), conditions.root)),
      element("div", {class: "column"},
        card("point-card", point.root, element("div", {class: "spectrum"}, plane.root, point.modes), states.root),
        card("motion-card", element("h2", {}, "Motion"), motion.root)),
      exports.python),
    element("footer", {class: "small"}, data.foot),
  );
  const head = () => {
    const {subject} = view;
    title.textContent = subject.title;
    under.textContent = data.names.says[subject.law] || data.names.says[""] || "";
    const blank = subject.members || subject.solver ? "Blank: no member found. " : "";
    grows.replaceChildren("Each point is one steady motion. Colour: largest growth rate ",
      `(float). ${subject.hatching} `, "Lines: boundaries (solid: static, dashed: flutter). All in double precision. ", blank, "Drag to move the point; wheel or pinch to zoom, double click for the whole.");
    motion.root.parentElement.hidden = !view.motion;
  };
  view.on((changed) => { if (changed.has("subject")) head(); });
  const all = [diagram, controls, point, plane, conditions, states];
  for (const part of all) part.render();
  motion.run();
  head();
  let stage = null;
  window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
    all.forEach((part) => part.render());
    if (stage) { stage.recolour(); motion.frame(); }
  });
  const afterPaint = () => requestAnimationFrame(() => setTimeout(() => {
    head();
    if (view.data.solid) {
      stage = diagram.raster.gl ? new Stage(library(), look) : new FlatStage(look);
      motion.show(stage);
    }
    view.stir(); // the first picture was a coarse one
    view.on(() => requestAnimationFrame(() => { if (!view.moving && !diagram.refining) root.dataset.ready = "true"; }));
  }, 60));
  requestAnimationFrame(afterPaint);
  return {view, diagram, motion, plane, exports, launched, polynomialRoots, stage: () => stage};
}

/** The data, with each text that occurs twice put back in its places. */
export function whole({texts, data}) {
  const put = (value) => {
    if (Array.isArray(value)) return value.map(put);
    if (value === null || typeof value !== "object") return value;
    if (typeof value.text === "number") return texts[value.text];
    return Object.fromEntries(Object.entries(value).map(([name, one]) => [name, put(one)]));
  };
  return put(data);
}

/** The page: the link is the part of the address after #. */
export function mountPage() {
  const data = whole(JSON.parse(document.getElementById("data").textContent));
  const library = () => new Function(`${document.getElementById("three").textContent}; return THREE;`)();
  const parts = mount(document.getElementById("explorer"), data, library, location.hash);
  let later = 0;
  parts.view.on(() => {
    clearTimeout(later);
    later = setTimeout(() => history.replaceState(null, "", `#${parts.view.write()}`), 150);
  });
  window.addEventListener("hashchange", () => parts.view.set(parts.view.read(location.hash)));
  window.stabilityExplorer = parts;
}

/** A widget: the same in an element of a notebook. */
export function mountWidget(el, data, threeText, styleText) {
  const style = element("style", {}, styleText), root = element("div", {});
  el.append(style, root);
  const library = () => new Function(`${threeText}; return THREE;`)();
  const parts = mount(root, whole(data), library);
  return () => { parts.motion.playing = false; root.remove(); style.remove(); };
}
