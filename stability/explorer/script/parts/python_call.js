// Python calls that reproduce the page.

import {exactText} from "../drawing/elements.js";

/** The calls for the diagram, the point and the launch of a view. */
export function pythonCall(view) {
  const {subject} = view;
  return {disk: ofDisk, body: ofBody, own: ofOwn}[subject.call.kind](view);
}

function axis(view, which, count) {
  const name = view.state[which];
  const [low, high, spacing] = view.state.ranges[name];
  return `("${name}", ${exactText(low)}, ${exactText(high)}, ${count}${spacing ? `, "${spacing}"` : ""})`;
}

function ofDisk(view) {
  const {subject, state} = view, {values} = state, {family, law, class: name} = subject.call;
  const axes = [state.x, state.y], has = subject.names.includes("mu");
  const friction = law === "linear-viscous" ? `mu=${exactText(values.mu)}` : has ? exactText(values.mu) : "";
  const contact = `st.${name}(${friction})`, at = exactText(values.at);
  const held = [];
  if (!axes.includes("at")) held.push(`at=${at}`);
  held.push(axes.includes("mu") ? `contact="${law}"` : "contact=contact");
  if (!axes.includes("k")) held.push("disk=disk");
  return [
    "import stability as st", "",
    `disk, contact = st.Disk(k=${exactText(values.k)}), ${contact}`,
    `point = st.spectrum("${family}", at=${at}, contact=contact, disk=disk, certify=True)`,
    `diagram = st.stability_map("${family}", x=${axis(view, "x", 300)}, y=${axis(view, "y", 200)}, ${held.join(", ")})`,
    "figure = st.plot_map(diagram)",
    `start = st.launch("${family}", at=${at}, tilt=${exactText(state.tilt)}, disk=disk)`,
    `motion = st.simulate(disk, contact, start, ${exactText(state.until)})`,
    "print(point.verdict, point.eigenvalues, motion.attrs[\"outcome\"])", "",
  ].join("\n");
}

function ofBody(view) {
  const {subject, state} = view, {values} = state, {family, law, class: name, body, pole} = subject.call;
  const [first] = subject.names, at = exactText(values[first]), axes = [state.x, state.y];
  const made = body.replace(/\{(\w+)\}/g, (_, n) => exactText(values[n]));
  const shape = subject.names.filter((n) => n !== first && n !== "mu").map((n) => `${n}=${exactText(values[n])}`).join(", ");
  const contact = `st.${name}(${"mu" in values ? exactText(values.mu) : ""})`;
  const where = pole === undefined || pole === null ? "" : `, pole=${JSON.stringify(pole)}`;
  const held = [axes.includes("mu") ? `contact="${law}"` : "contact=contact", ...(axes.includes(first) ? [] : [`at=${at}`])];
  return [
    "import stability as st", "",
    made ? `body, contact = ${made}, ${contact}` : `contact = ${contact}  # body: your ${subject.call.name}${shape ? ` with ${shape}` : ""}`,
    `point = st.spectrum("${family}", at=${at}, body=body, contact=contact${where}, certify=True)`,
    `diagram = st.stability_map("${family}", x=${axis(view, "x", 300)}, y=${axis(view, "y", 200)}, body=body, ${held.join(", ")}${where})`,
    "figure = st.plot_map(diagram)",
    `start = st.launch("${family}", at=${at}, tilt=${exactText(state.tilt)}, body=body${where})`,
    `motion = st.simulate(body, contact, start, ${exactText(state.until)})`,
    "print(point.verdict, point.eigenvalues, motion.attrs[\"outcome\"])", "",
  ].join("\n");
}

function ofOwn(view) {
  const {subject, state} = view, {call} = subject, {values} = state;
  const named = (names) => names.map((n) => `${n}=${exactText(values[n])}`).join(", ");
  const at = call.at.length === 1 ? exactText(values[call.at[0]]) : `[${call.at.map((n) => exactText(values[n])).join(", ")}]`;
  const others = subject.names.filter((n) => n !== state.x && n !== state.y);
  const fixed = call.parameters.length ? `, ${named(call.parameters)}` : "";
  const held = others.length ? `, ${named(others)}` : "";
  return [
    "import stability as st", "", `# family: ${subject.family} of ${call.system}`,
    `point = st.spectrum(family, at=${at}${fixed}, certify=True)`,
    `diagram = st.stability_map(family, x=${axis(view, "x", 300)}, y=${axis(view, "y", 200)}${held})`,
    "figure = st.plot_map(diagram)", "print(point.verdict, point.eigenvalues)", "",
  ].join("\n");
}
