// The motion: steady, in one mode, or launched from a tilt; played, stopped, and drawn over time.

import {before, launched, modeMotion, poseAt} from "../mathematics/launch.js";
import {components, modeCurves, modesAt, steadyCurves} from "../mathematics/modes.js";
import {clamp, element, text} from "../drawing/elements.js";
import {onceAFrame} from "../drawing/redrawn.js";
import {componentsText} from "./states/mode_words.js";
import {Traces} from "./traces.js";
import {placed, surface} from "./turned_view.js";

const PICTURES = {steady: "Steady", mode: "Mode", launch: "Launch"};
const TIMES = [20, 60, 200], REST = 90; // milliseconds without a change after which a launch is computed
const UNCHANGED = 5e-4; // share by which the size of a mode changes, too little to be printed
const SMALL = 0.02; // share of the largest component that the sentence on a body leaves out; states have units of their own
const SHOWING = 8; // seconds in which the curves of a mode are played
const NEAR = 0.02; // distance from a steady motion that is worth a word
const LEAST_TILT = 0.005, MOST_TILT = 0.8;
const FLOAT = "Float: modes and launches are computed here in double precision (launches by DOP853, tolerance 10⁻¹²). "
  + "The page does not decide whether a motion settles: simulate in Python does, with a proof.";
const ENDS = {
  "lift-off": "it leaves the plane: the normal force reaches zero",
  flat: "it falls flat, where its equations of motion end",
  "no-contact": "no contact force continues the motion (Painlevé's paradox)",
  moving: "the run ends",
  rest: "it rests, as far as this run shows",
  steady: "nothing changes any more, as far as this run shows: no state by 10⁻⁶ in a unit of time",
  absent: "the family has no member here",
  unresolved: "the page gave up; ask Python for the rest",
};

export class MotionPanel {
  constructor(view, look) {
    Object.assign(this, {view, look, time: 0, playing: !look.still(), stage: null});
    this.kind = element("div", {class: "segments", role: "radiogroup", "aria-label": "Motion that is shown"},
      ...Object.entries(PICTURES).map(([name, word]) => element("button", {role: "radio", "data-name": name,
        onclick: () => view.set({show: name}), onkeydown: (event) => this.roam(event)}, word)));
    this.box = element("div", {class: "stage motion-stage"}, element("p", {class: "small waiting"}, "3-D …"));
    this.play = element("button", {class: "play", "aria-label": "Play or pause", onclick: () => this.toggle()});
    this.slider = element("input", {type: "range", min: 0, max: 1000, step: "any", "aria-label": "Time",
      oninput: () => { this.playing = false; this.seek((this.slider.value / 1000) * this.span); }});
    this.clock = element("output", {class: "clock"});
    this.tilt = element("input", {type: "range", min: 0, max: 1000, "aria-label": "Size of the disturbance",
      oninput: () => view.set({tilt: tiltOf(this.tilt.value / 1000), show: !this.solid && view.state.show === "mode" ? "mode" : "launch"})});
    this.tiltSaid = element("output", {class: "clock"});
    this.kick = element("select", {"aria-label": "State that is disturbed", onchange: () => view.set({kick: Number(this.kick.value), show: "launch"})});
    this.until = element("select", {"aria-label": "Length of the run", onchange: () => view.set({until: Number(this.until.value), show: "launch"})});
    this.said = element("p", {class: "sentence outcome", role: "status"});
    this.traces = new Traces((t) => { this.playing = false; this.seek(t); }, (name) => view.curve(name));
    this.caption = element("p", {class: "small caption"});
    this.traces.root.prepend(this.caption);
    this.sized = element("label", {});
    this.length = element("label", {class: "small"}, "until t = ", this.until);
    this.start = element("div", {class: "slider tilt"}, this.sized, this.tilt, this.tiltSaid, this.length);
    this.root = element("div", {class: "motion"}, this.kind, this.box,
      element("div", {class: "transport"}, this.play, this.slider, this.clock), this.start, this.said, this.traces.root,
      element("p", {class: "small"}, FLOAT));
    this.compute = () => { // once the hand rests: a run takes longer than a frame
      this.waits = true;
      clearTimeout(this.later);
      this.later = setTimeout(() => { this.waits = false; this.run(); }, REST);
    };
    this.frame = onceAFrame(() => this.draw());
    view.on((changed) => {
      if (["subject", "values", "mode", "show", "tilt", "until", "kick", "si"].some((n) => changed.has(n))) this.compute();
      if (changed.has("show") || changed.has("mode") || changed.has("subject")) {
        this.time = 0;
        this.playing = !look.still();
      }
    });
    this.sight = new Map();
    const sight = new IntersectionObserver((entries) => {
      for (const {target, isIntersecting} of entries) this.sight.set(target, isIntersecting);
      this.frame();
    });
    for (const part of [this.box, this.traces.root]) sight.observe(part);
  }

  /** Whether the body, or of a system of one's own the curves, can be seen. */
  get visible() {
    return this.sight.get(this.solid ? this.box : this.traces.root) !== false;
  }

  /** Whether there is a body to draw; of any other system its states are drawn. */
  get solid() {
    return Boolean(this.view.subject.pose);
  }

  /** The unit after a time: of a body in SI units, of any other system where it states one. */
  get second() {
    const {unit} = this.view.curve("time");
    return unit && (this.view.state.si || !this.solid) ? ` ${unit}` : "";
  }

  /** Whether the size of the disturbance is that of a picture of the states. */
  sizes(picture) {
    return !this.solid && this.kindShown === picture;
  }

  /** Take over the stage once its library is there. */
  show(stage) {
    this.stage = stage;
    stage.changed = () => this.frame();
    this.box.replaceChildren(stage.canvas);
    this.frame();
  }

  roam(event) {
    const step = {ArrowRight: 1, ArrowLeft: -1}[event.key], all = [...this.kind.children];
    if (!step) return;
    const next = all[(all.indexOf(event.currentTarget) + step + all.length) % all.length];
    next.click();
    next.focus();
    event.preventDefault();
  }

  toggle() {
    this.playing = !this.playing;
    if (this.playing && this.time >= this.span) this.time = 0;
    this.last = null;
    this.frame();
  }

  seek(time) {
    this.time = clamp(time, 0, this.span || 0);
    this.frame();
  }

  /** Compute what is shown, and the launch whose curves are drawn. */
  run() {
    const {view, solid} = this, {subject, motion, state} = view, q = view.point(), present = subject.exists(q);
    const modes = present ? modesAt(subject, q) : [];
    const show = state.show === "mode" && !modes.length ? "launch" : state.show;
    for (const button of this.kind.children) {
      const own = button.dataset.name === show;
      button.setAttribute("aria-checked", String(own));
      button.tabIndex = own ? 0 : -1;
    }
    this.box.hidden = !solid;
    this.root.hidden = !motion;
    if (!motion) return;
    const index = Math.min(state.mode || 0, modes.length - 1);
    this.chosen = {index, eigenvalue: modes[index]};
    this.shown = solid ? this.ofBody(show, present, q) : this.ofStates(show, present, q);
    this.kindShown = show;
    this.span = this.shown.until;
    this.time = Math.min(this.time, this.span);
    this.say(show);
    this.frame();
  }

  /** The launch from a disturbance of the states; a run that ended early has room behind its end, not more. */
  launchFrom(disturbance, q, present) {
    const {subject, motion, state} = this.view;
    const run = present ? launched(subject, motion, q, disturbance, state.until)
      : {refused: true, outcome: "absent", times: [], states: [], until: 0};
    run.ended = !["moving", "unresolved"].includes(run.outcome);
    this.launch = run;
    return run;
  }

  /** How the body is shown; the curves are those of the launch. */
  ofBody(show, present, q) {
    const {subject, motion, state} = this.view, run = this.launchFrom([-state.tilt], q, present);
    this.traces.show(run.refused ? null : run, run.ended ? Math.min(state.until, 1.4 * run.until) : state.until);
    if (show === "mode") {
      const {eigenvalue} = this.chosen, found = {...modeMotion(subject, q, eigenvalue), eigenvalue};
      return {...found, path: found.poses.map((p) => placed(p).contact)};
    }
    if (!present) return {times: [0], until: 0, path: [], poses: []};
    if (show === "steady" || run.refused) return this.steady(subject, motion, q);
    return {times: run.times, until: run.until, path: run.times.map((t) => placed(poseAt(run, motion, t)).contact)};
  }

  /** Curves of the states of a system of one's own: steady, in one mode, or launched. */
  ofStates(show, present, q) {
    const {subject, motion, state} = this.view;
    let run = null, span = null;
    if (!present || show === "launch") {
      const disturbance = subject.states.map((_, i) => (i === (state.kick || 0) ? state.tilt : 0));
      run = this.launchFrom(disturbance, q, present);
      span = run.ended ? Math.min(state.until, 1.4 * run.until) : state.until;
    } else {
      this.launch = {outcome: "", refused: false, until: 0};
      run = show === "mode" ? modeCurves(subject, q, this.chosen.eigenvalue, state.tilt, state.until)
        : steadyCurves(subject, motion, q, state.until);
      span = run.until;
    }
    const curves = subject.states.map((name, i) => [name, run.states.map((y) => y[i])]);
    run.series = {...Object.fromEntries(curves), ...run.series};
    this.traces.show(run.refused ? null : run, span);
    return {...run, path: []};
  }

  steady(subject, motion, q) {
    const run = launched(subject, motion, q, [0], 20, {tolerance: 1e-9});
    return {times: run.times, until: 20, run, path: run.times.map((t) => placed(poseAt(run, motion, t)).contact)};
  }

  say(show) {
    const {view, solid, launch: run, shown} = this, {state, subject} = view, {index, eigenvalue} = this.chosen;
    const {size} = view.curve("time"), seconds = (t, digits) => `${text(t * size, digits)}${this.second}`;
    this.tilt.value = String(1000 * sliderOf(state.tilt));
    this.tiltSaid.textContent = `${text(state.tilt, 3)}${solid ? " rad" : ""}`;
    this.until.replaceChildren(...[...new Set([...TIMES, state.until])].map((t) => element("option", {value: t}, seconds(t, 3))));
    this.until.value = String(state.until);
    this.offer(show);
    const words = ENDS[run.calm || run.outcome] || `${(view.motion.words || {})[run.outcome] || run.outcome}`;
    const named = subject.states.map((name) => subject.symbols[name] || name);
    if (show === "steady" && run.outcome !== "absent") this.said.textContent = "The steady motion itself, undisturbed.";
    else if (show === "mode") {
      const parts = solid ? components(subject.mode(view.point(), eigenvalue)) : shown.parts;
      this.said.textContent = `Mode ${index + 1} of the linear motion${solid ? ", enlarged" : ` (float): ${this.course()}`}. `
        + `Sizes and phases: ${componentsText(parts, named, solid ? SMALL : 0)}.`;
    } else if (run.refused) this.said.textContent = `No launch from here: ${words}.`;
    else {
      const name = subject.states[state.kick || 0], by = solid ? `${text(state.tilt, 3)} rad` : `${this.sizeOf(name)} in ${name}`;
      this.said.textContent = `Launched ${solid ? "tilted" : "disturbed"} by ${by}: at t = ${seconds(run.until, 5)} ${words}${this.near(run)}.`;
    }
  }

  /** The size of the disturbance of a state, in its unit. */
  sizeOf(name) {
    const {unit} = this.view.curve(name);
    return `${text(this.view.state.tilt, 3)}${unit ? ` ${unit}` : ""}`;
  }

  /** How the size of the mode of a system changes along its curves. */
  course() {
    const {parts, factor, count, each} = this.shown, largest = parts.findIndex((part) => part.phase === 0 && part.size === 1);
    const name = this.view.subject.states[largest], first = `${name} begins ${this.sizeOf(name)} from its steady value`;
    const change = Math.abs(factor - 1) < UNCHANGED ? "the size stays" : `the size is multiplied by ${text(factor, 3)}`;
    return `${first}; ${count ? `after ${count} ${each} ` : ""}${change}`;
  }

  /** The controls that belong to a picture, and what the curves are. */
  offer(show) {
    const {solid} = this, {subject, state} = this.view, amplitude = this.sizes("mode");
    if (this.kicked !== subject.key) {
      this.kicked = subject.key;
      this.kick.replaceChildren(...subject.states.map((n, i) => element("option", {value: i}, n)));
    }
    this.kick.value = String(state.kick || 0);
    const label = solid ? "tilt" : amplitude ? "amplitude" : "disturb ";
    if (this.sized.dataset.says !== label) { // only then, since an element that moves loses the focus
      this.sized.dataset.says = label;
      this.sized.replaceChildren(label, ...(label === "disturb " ? [this.kick] : []));
      this.tilt.setAttribute("aria-label", amplitude ? "Amplitude of the mode" : "Size of the disturbance");
    }
    this.start.classList.toggle("own", !solid);
    this.start.classList.toggle("amplitude", amplitude);
    this.start.hidden = this.sizes("steady");
    this.length.hidden = amplitude;
    const formula = ["Linear motion in mode ", this.chosen.index + 1, " (float): steady value + amplitude · Re(", element("i", {}, "v"), " e", element("sup", {}, "λt"), ")"];
    const captions = {steady: ["The steady motion (float)"], mode: formula, launch: ["The nonlinear launch from this disturbance (float)"]};
    this.caption.replaceChildren(...(solid ? ["Curves of the launch from this tilt"] : captions[show]));
  }

  /** How near the end of a run is to a member of the family, in words; no proof that it stays. */
  near(run) {
    const {subject, motion} = this.view, index = subject.states.indexOf(subject.call.state);
    if (index < 0 || run.outcome !== "moving") return "";
    const q = this.view.point();
    q[0] = run.final[index]; // the quantity that names a member is the first
    const member = subject.steady(q), {size} = this.view.shown(subject.quantities[0]);
    const apart = Math.max(...member.slice(0, motion.states).map((v, i) => Math.abs(v - run.final[i])));
    if (!(apart < NEAR)) return "";
    return `, within ${text(apart, 2)}${this.view.state.si ? " (dimensionless)" : ""} of ${subject.family} with ${subject.symbols[subject.call.state]} = ${text(run.final[index] * size, 4)} (float; no proof that it stays there)`;
  }

  draw() {
    if (!this.shown || this.waits) return;
    const now = performance.now();
    if (this.playing && this.visible && this.span > 0) {
      if (this.last) this.time += Math.min(0.1, (now - this.last) / 1000) * this.pace();
      if (this.time >= this.span) { this.time = this.kindShown === "launch" ? this.span : 0; this.playing = this.kindShown !== "launch"; }
      this.last = now;
    } else this.last = null;
    this.slider.value = String((1000 * this.time) / (this.span || 1));
    const {size} = this.view.curve("time"), {solid} = this;
    const decimals = Math.max(0, solid ? 1 - Math.floor(Math.log10(size)) : Math.min(9, 2 - Math.floor(Math.log10(this.span || 1))));
    this.clock.textContent = `t = ${(this.time * size).toFixed(decimals)}${this.second}`;
    this.play.textContent = this.playing ? "❚❚" : "▶";
    this.traces.mark(solid && this.kindShown !== "launch" ? 0 : this.time);
    const {motion} = this.view;
    if (this.stage && this.visible && solid) {
      this.stage.shapeOf(...this.outline());
      const {times, poses, path} = this.shown, index = before(times, this.time) + 1;
      if (poses && !poses.length) return;
      const pose = poses ? poses[Math.min(index, poses.length - 1)] : poseAt(this.shown.run || this.launch, motion, this.time);
      this.stage.draw(pose, path.slice(0, index));
    }
    if (this.playing && this.visible) requestAnimationFrame(() => this.frame());
  }

  /** What the stage draws: the inertia factor of a disk, or the surface of a body; with a name. */
  outline() {
    const {subject, state} = this.view, {k} = state.values;
    if (!subject.meridian.point) return [`${k}`, {k}];
    const p = subject.parameters.map((i) => this.view.point()[i]), key = `${subject.key} ${p.join()}`;
    if (!this.surface || this.surface[0] !== key) this.surface = [key, {rows: surface(subject.meridian, p)}];
    return this.surface;
  }

  /** Seconds of the motion in one second: a run lasts about twenty. */
  pace() {
    if (!this.solid && this.kindShown !== "launch") return this.span / SHOWING;
    return this.kindShown === "launch" ? Math.max(1.5, Math.min(6, this.span / 20)) : 1.5;
  }
}

function tiltOf(u) {
  return Number((LEAST_TILT * (MOST_TILT / LEAST_TILT) ** u).toPrecision(3));
}

function sliderOf(tilt) {
  return clamp(Math.log(tilt / LEAST_TILT) / Math.log(MOST_TILT / LEAST_TILT), 0, 1);
}
