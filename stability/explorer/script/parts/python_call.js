// Python calls that reproduce the page.

import {exactText} from "../drawing/elements.js";

/** The calls for the diagram, the point and the launch of a view. */
export function pythonCall(view) {
  const {subject} = view;
  return subject.call.what === "system" ? ofSystem(view) : ofBody(view);
}

function axis(view, which, count) {
  const name = view.state[which], own = view.subject.quantity[name];
  const [low, high, spacing] = view.state.ranges[name], [a, b] = [low, high].map((v) => number(view, own, v));
  return `("${called(view, name)}", ${a}, ${b}, ${count}${spacing ? `, "${spacing}"` : ""})`;
}

/** What Python calls a quantity: c of the linear law is a force in SI units. */
function called(view, name) {
  return (view.state.si && view.subject.call.si[name]) || name;
}

/** A number in the units of the call; times a size it has one digit less, which rounding leaves right. */
function number(view, q, value) {
  return inUnits(value, view.shown(q).size);
}

function inUnits(value, size) {
  return exactText(size === 1 ? value : Number((value * size).toPrecision(15)));
}

/** Mass, length and gravity as arguments, where they are not 1. */
function scales(view) {
  return view.state.si ? Object.entries(view.data.si.given).map(([n, v]) => `${n}=${exactText(v)}`) : [];
}

/** `what` is disk or body, which names it in the calls; `made` says how it is made, with a place for each of its numbers. */
function ofBody(view) {
  const {subject, state} = view, {values} = state, {family, law, class: name, what, made, pole, theta} = subject.call;
  const [first] = subject.names, at = number(view, subject.quantity[first], values[first]), axes = [state.x, state.y];
  const more = scales(view).join(", "), until = inUnits(state.until, view.curve("time").size);
  const body = made.replace(/\{(\w+)\}/g, (_, n) => exactText(values[n])).replace(/\)$/, more ? `, ${more})` : ")").replace("(, ", "(");
  const shape = subject.names.filter((n) => n !== first && n !== "mu").map((n) => `${n}=${exactText(values[n])}`).join(", ");
  const mu = "mu" in values ? number(view, subject.quantity.mu, values.mu) : "", coefficient = called(view, "mu");
  const contact = `st.${name}(${law === "linear-viscous" ? `${coefficient}=` : ""}${mu})`;
  const where = pole === null ? "" : `, pole=${JSON.stringify(pole)}`;
  const placed = theta === null ? where : `, theta=${exactText(theta)}`;
  const held = [axes.includes("mu") ? `contact="${law}"` : "contact=contact", ...(axes.includes(first) ? [] : [`at=${at}`])];
  return [
    "import stability as st", "",
    made ? `${what}, contact = ${body}, ${contact}` : `contact = ${contact}  # body: your ${subject.call.name}${[shape, more].some((w) => w) ? ` with ${[shape, more].filter((w) => w).join(", ")}` : ""}`,
    `point = st.spectrum("${family}", at=${at}, ${what}=${what}, contact=contact${placed}, certify=True)`,
    `diagram = st.stability_map("${family}", x=${axis(view, "x", 300)}, y=${axis(view, "y", 200)}, ${what}=${what}, ${held.join(", ")}${placed})`,
    "figure = st.plot_map(diagram)",
    `start = st.launch("${family}", at=${at}, tilt=${exactText(state.tilt)}, ${what}=${what}${placed})`,
    `motion = st.simulate(${what}, contact, start, ${until})`,
    "print(point.verdict, point.eigenvalues, motion.attrs[\"outcome\"])", "",
  ].join("\n");
}

function ofSystem(view) {
  const {subject, state} = view, {call} = subject, {values} = state;
  const named = (names) => [...names.map((n) => `${n}=${exactText(values[n])}`), ...call.zeros.map((n) => `${n}=0`)].join(", ");
  const at = call.at.length === 1 ? exactText(values[call.at[0]]) : `[${call.at.map((n) => exactText(values[n])).join(", ")}]`;
  const others = subject.names.filter((n) => n !== state.x && n !== state.y);
  const fixed = named(call.parameters) && `, ${named(call.parameters)}`;
  const held = named(others) && `, ${named(others)}`, launch = launchOfSystem(view);
  return [
    "import stability as st", "",
    `# family is your own Family, "${subject.family}" of the system "${call.system}": define or import it first`,
    `point = st.spectrum(family, at=${at}${fixed}, certify=True)`,
    `diagram = st.stability_map(family, x=${axis(view, "x", 300)}, y=${axis(view, "y", 200)}${held})`,
    "figure = st.plot_map(diagram)", ...launch,
    `print(point.verdict, point.eigenvalues${launch.length ? ", motion.attrs[\"outcome\"]" : ""})`, "",
  ].join("\n");
}

/** The launch of a system of one's own: the steady states, one of them disturbed; nothing without a member. */
function launchOfSystem(view) {
  const {subject, state, motion} = view, q = view.point();
  if (!motion || !subject.exists(q)) return [];
  const steady = subject.steady(q), kick = state.kick || 0;
  const entries = (names, values) => names.map((n, i) => `${JSON.stringify(n)}: ${exactText(values[i])}`).join(", ");
  const start = entries(subject.states, subject.states.map((_, i) => steady[i] + (i === kick ? state.tilt : 0)));
  const {given: names, zeros} = subject.call;
  const given = entries([...names, ...zeros], [...subject.parameters.map((i) => q[i]), ...zeros.map(() => 0)]);
  return [`start = {${start}}`,
    `motion = st.simulate(family.system, {${given}}, start, ${exactText(state.until)}, families=family)`];
}
