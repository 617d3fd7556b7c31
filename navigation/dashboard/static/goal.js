// A new goal: click, drag for a heading, shift-click for more stations; the plan is shown with its
// length and clearance before anything is sent. The same with the keyboard.

import { stationMark } from "./layers.js";
import { fill } from "./list.js";
import { allow } from "./press.js";
import { element } from "./stage.js";
import { Clearance } from "./world.js";

const DRAG_PX = 14;
const HOLD_PX = 12;
const STEP_M = 0.02;
const FAR_M = 0.1;
const TURN_RAD = Math.PI / 12;

export class Goal {
  #hello = null;
  #clearance = null;
  #stations = [];
  /** The stations before each change, for undo. */
  #before = [];
  #preview = null;
  /** Settles when the seat is taken or refused: nothing is asked before. */
  #taking = Promise.resolve();
  #pressed = null;
  #cursor = null;
  #asked = 0;
  /** A preview is on its way; the world has changed since it was asked for. */
  #isAsking = false;
  #isOutdated = false;
  #isSending = false;
  #wasMine = false;
  #hint = "";

  constructor(stage, connection, seat, say) {
    Object.assign(this, { stage, connection, seat, say });
    this.send = document.getElementById("send");
    this.adding = document.getElementById("adding");
    this.probe = document.getElementById("probe");
    this.#hint = this.probe.textContent;
    connection.on("hello", (hello) => {
      this.#hello = hello;
      this.#clearance ??= new Clearance(hello.arena_m, null);
    });
    connection.on("world", (world) => {
      this.#clearance = new Clearance(this.#hello.arena_m, world);
      this.#askAgain();
    });
    connection.on("down", () => this.#allowSending());
    connection.on("state", (state) => this.#follow(state));
    stage.onResize.push(() => this.#draw());
    this.#listen();
  }

  /** The last station of the draft, as it is sent, if any. */
  get last() {
    return this.#stations.at(-1);
  }

  /** A goal, or one station more. */
  use({ x_m, y_m, heading_rad }) {
    this.#set(x_m, y_m, heading_rad, this.adding.checked);
  }

  clear() {
    this.#stations = [];
    this.#before = [];
    this.#forgetPreview();
  }

  undo() {
    if (!this.#before.length) return;
    this.#stations = this.#before.pop();
    this.#forgetPreview();
    if (this.#stations.length) this.#ask();
  }

  #remove(index) {
    this.#change(this.#stations.filter((_, n) => n !== index));
  }

  async submit() {
    const missing = this.#missing;
    if (missing) {
      this.say(`Not sent: ${missing}`);
      return;
    }
    this.#isSending = true;
    const taken = await this.seat.takeIfFree();
    const answer = !taken.ok ? taken : await this.connection.ask({ type: "order", order: "go", stations: this.#stations });
    this.#isSending = false;
    if (answer.ok) this.clear();
    else this.#show();
    this.say(answer.ok ? "" : answer.error);
  }

  #listen() {
    const area = this.stage.element;
    area.addEventListener("pointerdown", (event) => this.#press(event));
    area.addEventListener("pointermove", (event) => this.#move(event));
    area.addEventListener("pointerup", (event) => this.#lift(event));
    area.addEventListener("pointercancel", () => { this.#pressed = null; this.#draw(); });
    area.addEventListener("pointerleave", () => { if (!this.#pressed) this.#look(null); });
    area.addEventListener("keydown", (event) => this.#key(event));
    area.addEventListener("blur", () => this.#look(null));
    this.send.addEventListener("click", (event) => {
      if (event.detail < 2) this.submit(); // a double click is one press
    });
    document.getElementById("clear").addEventListener("click", () => this.clear());
    document.getElementById("undo").addEventListener("click", () => this.undo());
  }

  // The pointer.

  #press(event) {
    if (!event.isPrimary) { // a second finger: the first one did not mean a goal
      this.#pressed = null;
      this.#draw();
      return;
    }
    if (event.button !== 0 || !this.#hello || this.stage.tool) return;
    event.preventDefault();
    this.stage.element.focus({ preventScroll: true });
    this.stage.element.setPointerCapture(event.pointerId);
    const [x, y] = this.stage.place(event);
    const more = event.shiftKey || this.adding.checked;
    const held = this.#stationAt(x, y);
    this.#pressed = { x, y, more, held, from: [event.clientX, event.clientY], heading: null };
    this.#draw();
  }

  #move(event) {
    if (!this.#hello || this.stage.tool) return;
    const place = this.stage.place(event);
    const pressed = this.#pressed;
    if (!pressed) {
      this.#look(place);
      return;
    }
    const far = Math.hypot(event.clientX - pressed.from[0], event.clientY - pressed.from[1]) > DRAG_PX;
    if (pressed.held >= 0) {
      pressed.to = far || pressed.to ? place : null;
      this.#draw();
      return;
    }
    pressed.heading = far ? Math.atan2(place[1] - pressed.y, place[0] - pressed.x) : null;
    this.#draw();
  }

  #lift(event) {
    const pressed = this.#pressed;
    this.#pressed = null;
    if (!pressed || event.button !== 0) return;
    if (pressed.held >= 0) {
      if (pressed.to) this.#change(this.#moved(pressed));
      else this.#draw();
      return;
    }
    this.#set(pressed.x, pressed.y, pressed.heading, pressed.more);
  }

  /** Number of the draft's station under the pointer, or -1. */
  #stationAt(x, y) {
    const reach = Math.max(this.#hello.robot.radius_m, (HOLD_PX * this.stage.k) / this.stage.scale);
    return this.#stations.findLastIndex((station) => Math.hypot(station.x_m - x, station.y_m - y) < reach);
  }

  #moved({ held, to }) {
    return this.#stations.map((station, n) => (n === held ? { ...station, x_m: round(to[0]), y_m: round(to[1]) } : station));
  }

  // The keyboard.

  #key(event) {
    if (!this.#hello || this.stage.tool || event.ctrlKey || event.metaKey || event.altKey) return;
    const step = event.shiftKey ? FAR_M : STEP_M;
    const moves = { ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, step], ArrowDown: [0, -step] };
    const [x0, y0, x1, y1] = this.#hello.arena_m;
    const cursor = this.#cursor ?? [(x0 + x1) / 2, (y0 + y1) / 2];
    const last = this.#stations.at(-1);
    if (moves[event.key]) {
      const [dx, dy] = moves[event.key];
      const at = [clamp(cursor[0] + dx, x0, x1), clamp(cursor[1] + dy, y0, y1)];
      this.stage.reveal(...at);
      this.#look(at, true);
    } else if (event.key === "Enter" && !this.#isAtGoal(cursor)) {
      this.#set(...cursor, null, false);
    } else if (event.key === "a" || event.key === "A") {
      this.#set(...cursor, null, true);
    } else if ((event.key === "," || event.key === ".") && last) {
      const turn = event.key === "," ? TURN_RAD : -TURN_RAD;
      const turned = { ...last, heading_rad: wrap((last.heading_rad ?? 0) + turn) };
      this.#change([...this.#stations.slice(0, -1), turned]);
    } else if (event.key === "Backspace") {
      this.undo();
    } else {
      return;
    }
    event.preventDefault();
    event.stopPropagation();
  }

  #isAtGoal([x, y]) {
    const last = this.#stations.at(-1);
    return last && Math.hypot(last.x_m - x, last.y_m - y) < STEP_M / 2;
  }

  // The draft.

  async #set(x, y, heading, more) {
    const why = this.stage.element.classList.contains("shows-camera")
      ? "the camera's own picture is shown, where a place is not to scale: switch that layer off to set a goal"
      : this.seat.isRecording ? this.seat.mayNot : "";
    if (why) {
      this.say(why);
      return;
    }
    const station = { x_m: round(x), y_m: round(y), heading_rad: heading };
    this.#before.push(this.#stations);
    this.#stations = more ? [...this.#stations, station] : [station];
    this.#forgetPreview();
    this.say("");
    this.#taking = this.seat.takeIfFree();
    const taken = await this.#taking;
    if (taken.ok) {
      this.#ask();
    } else {
      this.undo();
      this.say(taken.error);
    }
  }

  /** Replace the draft's stations; undo brings them back. */
  #change(stations) {
    this.#before.push(this.#stations);
    this.#stations = stations;
    this.#forgetPreview();
    if (stations.length) this.#ask();
  }

  /** The stations have changed: a plan that is there, or on its way, is for others. */
  #forgetPreview() {
    this.#asked += 1;
    this.#isAsking = false;
    this.#preview = null;
    this.#draw();
    this.#show();
  }

  /** Ask for the plan to these stations, and again as long as the world changes meanwhile. */
  async #ask() {
    const number = ++this.#asked;
    this.#isAsking = true;
    await this.#taking;
    while (number === this.#asked) {
      this.#isOutdated = false;
      const answer = await this.connection.ask({ type: "preview", stations: this.#stations }, 15000);
      if (number !== this.#asked) return;
      this.#preview = answer;
      this.#draw();
      this.#show();
      if (!this.#isOutdated) break;
    }
    if (number === this.#asked) this.#isAsking = false;
  }

  /**
   * The world has changed. The last preview is shown, and can be sent, until the next one is here: the
   * program plans again in any case, and a press on its way must not meet a dead button.
   */
  #askAgain() {
    if (this.#isAsking) this.#isOutdated = true;
    else if (this.#preview) this.#ask();
  }

  #follow(state) {
    this.stopped = state.mission.state === "stopped";
    const isMine = this.seat.isMine;
    if (isMine && !this.#wasMine && this.#preview?.ok === false) this.#ask(); // it was asked without control
    this.#wasMine = isMine;
    this.#allowSending();
  }

  /** Reason why the goal cannot be sent now, or "". */
  get #missing() {
    if (!this.connection.isUp) return "there is no connection";
    if (this.seat.mayNot) return this.seat.mayNot;
    if (!this.#stations.length) return "there is no goal; click in the arena to set one";
    if (this.stopped) return "the robot is stopped; re-arm it first";
    if (!this.#preview) return "the plan is not there yet; look at it, then send again";
    if (!this.#preview.ok) return "there is no plan to this goal";
    if (this.seat.other) return `${this.seat.other} is in control`;
    return this.#isSending ? "the last order is still on its way" : "";
  }

  #allowSending() {
    allow(this.send, this.#missing);
  }

  // What is shown.

  #show() {
    const any = this.#stations.length > 0;
    this.#allowSending();
    document.getElementById("clear").hidden = !any;
    document.getElementById("undo").hidden = this.#before.length === 0;
    document.getElementById("goal-hint").hidden = any;
    const list = document.getElementById("goal-stations");
    list.hidden = !any;
    fill(list, this.#stations, () => this.#stations.map((station, index) => {
      const item = document.createElement("li");
      const turned = station.heading_rad === null ? "" : `, ${degrees(station.heading_rad)}°`;
      const remove = document.createElement("button");
      Object.assign(remove, { type: "button", id: `remove-${index + 1}`, className: "quiet remove", title: "Remove this station" });
      remove.setAttribute("aria-label", `Remove station ${index + 1}`);
      remove.addEventListener("click", () => this.#remove(index));
      item.append(`${station.x_m.toFixed(2)}, ${station.y_m.toFixed(2)} m${turned}`, remove);
      return item;
    }));
    const text = document.getElementById("goal-preview");
    text.hidden = !any;
    text.classList.toggle("bad", this.#preview?.ok === false);
    text.textContent = any ? previewText(this.#preview) : "";
    const remarks = (any && this.#preview?.remarks) || [];
    const said = document.getElementById("goal-remarks");
    said.hidden = remarks.length === 0;
    said.replaceChildren(...remarks.map((remark) => Object.assign(document.createElement("li"), { textContent: remark })));
  }

  #draw() {
    if (!this.#hello) return;
    const shapes = [];
    const s = this.stage;
    if (this.#preview?.ok && this.#stations.length) {
      const data = s.line(this.#preview.points.flat());
      shapes.push(
        element("path", { class: "draft-corridor", d: data, "stroke-width": 2 * this.#preview.radius_m * s.scale }),
        element("path", { class: "halo", d: data }),
        element("path", { class: "draft-path", d: data }),
      );
    }
    const gap = this.#preview?.ok === false ? this.#preview.bottleneck : null;
    if (gap) {
      shapes.push(element("circle", { class: "narrowest", cx: s.x(gap.x_m), cy: s.y(gap.y_m), r: Math.max(4 * s.k, (gap.width_m / 2) * s.scale) }));
    }
    const radius = this.#hello.robot.radius_m;
    const isHeld = this.#pressed?.held >= 0;
    const before = isHeld && this.#pressed.to ? this.#moved(this.#pressed)
      : this.#pressed && !isHeld && !this.#pressed.more ? [] : this.#stations;
    const pending = this.#pressed && !isHeld ? [{ x_m: this.#pressed.x, y_m: this.#pressed.y, heading_rad: this.#pressed.heading }] : [];
    const all = [...before, ...pending];
    all.forEach((station, index) => {
      const name = index === all.length - 1 ? "new goal" : String(index + 1);
      shapes.push(stationMark(s, station, name, "station draft", radius));
    });
    s.group("draft").replaceChildren(...shapes);
  }

  /** Clearance and radius under the cursor; `crosshair` if keys move it. */
  #look(place, crosshair = false) {
    this.#cursor = place ?? this.#cursor;
    const group = this.stage.group("probe");
    if (!place || !this.#clearance) {
      group.replaceChildren();
      this.probe.textContent = this.#hint;
      this.probe.classList.remove("bad");
      return;
    }
    const s = this.stage;
    const [x, y] = place;
    const { clearance, nearest, outside } = this.#clearance.at(x, y);
    const radius = this.#hello.robot.radius_m;
    const fits = clearance >= radius;
    const [cx, cy] = [s.x(x), s.y(y)];
    group.replaceChildren(
      ...(clearance > 0 ? [
        element("circle", { class: "probe-clear", cx, cy, r: clearance * s.scale }),
        element("path", { class: "probe-ray", d: `M${cx} ${cy}L${s.x(nearest[0])} ${s.y(nearest[1])}` }),
      ] : []),
      element("circle", { class: `probe-body ${fits ? "fits" : "blocked"}`, cx, cy, r: radius * s.scale }),
      ...(crosshair ? [element("path", { class: "cross", d: `M${cx - 12 * s.k} ${cy}h${24 * s.k}M${cx} ${cy - 12 * s.k}v${24 * s.k}` })] : []),
    );
    const where = `x ${x.toFixed(3)}  y ${y.toFixed(3)} m`;
    const what = outside ? "outside the arena"
      : clearance < 0 ? "inside an obstacle"
      : `clearance ${clearance.toFixed(3)} m, ${fits ? "the robot fits" : "too tight for the robot"} (radius ${radius.toFixed(3)} m)`;
    this.probe.textContent = `${where}: ${what}`;
    this.probe.classList.toggle("bad", !fits);
    this.probe.setAttribute("aria-live", crosshair ? "polite" : "off");
  }
}

function previewText(preview) {
  if (!preview) return "Planning…";
  if (!preview.ok) return `No plan: ${preview.reason ?? preview.error}.`;
  const seconds = preview.duration_s === null ? "" : `, about ${preview.duration_s.toFixed(0)} s`;
  return `${preview.length_m.toFixed(2)} m, clearance at least ${preview.clearance_m.toFixed(3)} m${seconds}.`;
}

const clamp = (value, low, high) => Math.min(high, Math.max(low, value));
const round = (value) => Math.round(value * 1e4) / 1e4;
const degrees = (radians) => Math.round((radians * 180) / Math.PI);
const wrap = (radians) => Math.atan2(Math.sin(radians), Math.cos(radians));
