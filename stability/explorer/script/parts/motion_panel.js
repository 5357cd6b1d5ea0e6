// The motion: steady, in one mode, or launched from a tilt; played, stopped, and drawn over time.

import {before, launched, modeMotion, poseAt} from "../mathematics/launch.js";
import {clamp, element, onceAFrame, text} from "../drawing/elements.js";
import {Traces} from "./traces.js";
import {placed, surface} from "./turned_view.js";

const PICTURES = {steady: "Steady", mode: "Mode", launch: "Launch"};
const TIMES = [20, 60, 200], REST = 90; // milliseconds without a change after which a launch is computed
const NEAR = 0.02; // distance from a steady motion that is worth a word
const LEAST_TILT = 0.005, MOST_TILT = 0.8;
const FLOAT = "Float: modes and launches are computed here in double precision (launches by DOP853, tolerance 10⁻¹²). "
  + "The page does not decide whether a motion settles: simulate in Python does, with a proof.";
const ENDS = {
  "lift-off": "it leaves the plane: the normal force reaches zero",
  flat: "it falls flat, where its equations of motion end",
  "no-contact": "no contact force continues the motion (Painlevé's paradox)",
  moving: "it still moves at the end of the run",
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
      oninput: () => view.set({tilt: tiltOf(this.tilt.value / 1000), show: "launch"})});
    this.tiltSaid = element("output", {class: "clock"});
    this.kick = element("select", {"aria-label": "State that is disturbed", onchange: () => view.set({kick: Number(this.kick.value), show: "launch"})});
    this.until = element("select", {"aria-label": "Length of the run", onchange: () => view.set({until: Number(this.until.value), show: "launch"})},
);
    this.said = element("p", {class: "sentence outcome", role: "status"});
    this.traces = new Traces((t) => { this.playing = false; this.seek(t); }, (name) => view.curve(name));
    this.traces.root.prepend(element("p", {class: "small"}, "Curves of the launch from this tilt"));
    this.start = element("div", {class: "slider tilt"}, element("label", {}, "tilt"), this.tilt, this.tiltSaid,
      element("label", {class: "small"}, "until t = ", this.until));
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
    this.visible = true;
    new IntersectionObserver(([entry]) => { this.visible = entry.isIntersecting; this.frame(); }).observe(this.box);
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
    const {view} = this, {subject, motion, state} = view, q = view.point(), solid = Boolean(subject.pose);
    const present = subject.exists(q);
    const modes = present ? subject.eigenvalues(q).filter((z) => z[1] >= 0).reverse() : [];
    const show = state.show === "mode" && (!solid || !modes.length) ? "launch" : state.show;
    for (const button of this.kind.children) {
      const own = button.dataset.name === show;
      button.setAttribute("aria-checked", String(own));
      button.tabIndex = own ? 0 : -1;
    }
    this.kind.hidden = !solid;
    this.box.hidden = !solid;
    if (!motion) { this.root.hidden = true; return; }
    this.root.hidden = false;
    const tilt = new Array(subject.states.length).fill(0), kick = solid ? 0 : (state.kick || 0);
    tilt[kick] = solid ? -state.tilt : state.tilt;
    const run = present ? launched(subject, motion, q, tilt, state.until) : {refused: true, outcome: "absent", times: [], states: [], until: 0};
    run.ended = !["moving", "unresolved"].includes(run.outcome);
    this.launch = run;
    if (!solid) run.series = {...this.statesOf(run), ...run.series};
    // a run that ended early has room behind its end, not more
    this.traces.show(run.refused ? null : run, run.ended ? Math.min(state.until, 1.4 * run.until) : state.until);
    if (show === "mode") {
      const eigenvalue = modes[Math.min(state.mode || 0, modes.length - 1)];
      this.shown = {...modeMotion(subject, q, eigenvalue), eigenvalue};
      this.shown.path = this.shown.poses.map((p) => placed(p).contact);
    } else if (!present) {
      this.shown = {times: [0], until: 0, path: [], poses: []};
    } else if (show === "steady" || run.refused) {
      this.shown = solid ? this.steady(subject, motion, q) : {times: [0], until: state.until, path: []};
    } else {
      this.shown = {times: run.times, until: run.until, path: solid ? run.times.map((t) => placed(poseAt(run, motion, t)).contact) : []};
    }
    this.kindShown = show;
    this.span = this.shown.until;
    this.time = Math.min(this.time, this.span);
    this.say(show, modes);
    this.frame();
  }

  statesOf(run) {
    const {states} = this.view.subject;
    return Object.fromEntries(states.slice(0, 4).map((name, i) => [name, run.states.map((y) => y[i])]));
  }

  steady(subject, motion, q) {
    const run = launched(subject, motion, q, [0], 20, {tolerance: 1e-9});
    return {times: run.times, until: 20, run, path: run.times.map((t) => placed(poseAt(run, motion, t)).contact)};
  }

  say(show, modes) {
    const {view} = this, {state, subject} = view, run = this.launch, solid = Boolean(subject.pose);
    this.tilt.value = String(1000 * sliderOf(state.tilt));
    this.tiltSaid.textContent = `${text(state.tilt, 3)}${solid ? " rad" : ""}`;
    const {size, unit} = view.curve("time"), seconds = (t, digits) => `${text(t * size, digits)}${state.si ? ` ${unit}` : ""}`;
    this.until.replaceChildren(...[...new Set([...TIMES, state.until])].map((t) => element("option", {value: t}, seconds(t, 3))));
    this.until.value = String(state.until);
    const label = this.start.firstChild;
    if (!solid) label.replaceChildren("disturb ", this.kick);
    if (solid) label.textContent = "tilt";
    this.start.classList.toggle("own", !solid);
    if (this.kicked !== subject.key) {
      this.kicked = subject.key;
      this.kick.replaceChildren(...subject.states.map((n, i) => element("option", {value: i}, n)));
    }
    this.kick.value = String(state.kick || 0);
    const shares = (vector) => {
      const all = vector.map((v, i) => [Math.hypot(...v), subject.symbols[subject.states[i]] || subject.states[i]]);
      const most = Math.max(...all.map((v) => v[0]));
      return all.filter(([size]) => size > 0.02 * most).sort((a, b) => b[0] - a[0])
        .map(([size, name]) => `${name} ${text(size / most, 2)}`).join(", ");
    };
    const words = ENDS[run.outcome] || `${(this.view.motion.words || {})[run.outcome] || run.outcome}`;
    if (show === "steady" && !(run.outcome === "absent")) this.said.textContent = "The steady motion itself, undisturbed.";
    else if (show === "mode") {
      this.said.textContent = `Mode ${Math.min(state.mode || 0, modes.length - 1) + 1} of the linear motion, enlarged. `
        + `Shares: ${shares(this.shown.vector)}.`;
    } else if (run.refused) this.said.textContent = `No launch from here: ${words}.`;
    else {
      const by = `${text(state.tilt, 3)}${solid ? " rad" : ""}`;
      this.said.textContent = `Launched ${solid ? "tilted" : "disturbed"} by ${by}: at t = ${seconds(run.until, 5)} ${words}${this.near(run)}.`;
      if (!solid && state.mode !== null && modes[state.mode]) {
        this.said.textContent += ` Mode ${state.mode + 1}: ${shares(subject.mode(view.point(), modes[state.mode]))}.`;
      }
    }
  }

  /** How near the end of a run is to a member of the family, in words; no proof that it stays. */
  near(run) {
    const {subject, motion} = this.view, index = subject.states.indexOf(subject.call.state);
    if (index < 0 || run.outcome !== "moving") return "";
    const q = this.view.point();
    q[subject.names.indexOf("at")] = run.final[index];
    const member = subject.steady(q), {size} = this.view.shown(subject.quantity.at);
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
    const {size, unit} = this.view.curve("time"), decimals = Math.max(0, 1 - Math.floor(Math.log10(size)));
    this.clock.textContent = `t = ${(this.time * size).toFixed(decimals)}${this.view.state.si ? ` ${unit}` : ""}`;
    this.play.textContent = this.playing ? "❚❚" : "▶";
    this.traces.mark(this.kindShown === "launch" ? this.time : 0);
    const {motion} = this.view;
    if (this.stage && this.visible && this.view.subject.pose) {
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
    return this.kindShown === "launch" ? Math.max(1.5, Math.min(6, this.span / 20)) : 1.5;
  }
}

function tiltOf(u) {
  return Number((LEAST_TILT * (MOST_TILT / LEAST_TILT) ** u).toPrecision(3));
}

function sliderOf(tilt) {
  return clamp(Math.log(tilt / LEAST_TILT) / Math.log(MOST_TILT / LEAST_TILT), 0, 1);
}
