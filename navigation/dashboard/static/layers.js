// Drawings over the picture: obstacles, diagram, roadmap, plan, track, robots. Each layer is one SVG
// group that can be switched off; the choice is remembered.

import { CameraView, Heat } from "./camera.js";
import { clearanceSpan, obstaclePlaces } from "./world.js";
import { element } from "./stage.js";

/** With more obstacles numbers would hide the arena. */
const MOST_NUMBERED = 60;
export const LAYERS = ["picture", "obstacles", "diagram", "roadmap", "plan", "track", "robots", "clearance", "camera", "zones"];
const KEYS = 9; // of the first ones
const OFF_AT_FIRST = ["clearance", "camera"];
const TITLES = {
  picture: "Picture", obstacles: "Obstacles", diagram: "Diagram", roadmap: "Roadmap",
  plan: "Plan", track: "Track", robots: "Robots", clearance: "Clearance", camera: "Camera", zones: "Zones",
};
const STALE_MS = 200;
const TRACK_MOST = 6000;

export class Layers {
  #world = null;
  #plan = null;
  #track = [];
  #hello = null;
  #robots = new Map();

  constructor(stage, picture, connection) {
    this.stage = stage;
    this.picture = picture;
    const known = remembered();
    this.shown = new Set(LAYERS.filter((name) => known[name] ?? !OFF_AT_FIRST.includes(name)));
    for (const name of ["floor", "obstacles", "zones", "diagram", "roadmap", "corridor", "plan", "narrowest", "track", "zone-names", "mission", "robots", "draft", "zone-draft", "probe"]) {
      stage.group(name);
    }
    this.camera = new CameraView(stage, connection);
    this.heat = new Heat(stage, connection);
    this.#makeSwitches();
    connection.on("hello", (hello) => this.#greet(hello));
    connection.on("world", (world) => this.#keepWorld(world));
    connection.on("plan", (plan) => { this.#plan = plan; this.#drawPlan(); });
    connection.on("track", (piece) => this.#addTrack(piece));
    connection.on("state", (state) => this.#drawState(state));
    stage.onResize.push(() => this.#drawState(this.state));
  }

  toggle(name) {
    this.shown[this.shown.has(name) ? "delete" : "add"](name);
    localStorage.setItem("clearway.layers", JSON.stringify(Object.fromEntries(LAYERS.map((one) => [one, this.shown.has(one)]))));
    this.#applySwitches();
  }

  show(name) {
    if (!this.shown.has(name)) this.toggle(name);
  }

  clearTrack() {
    this.#track = [];
    this.#drawTrack();
  }

  get world() {
    return this.#world;
  }

  #makeSwitches() {
    const box = document.getElementById("layers");
    LAYERS.forEach((name, index) => {
      const label = document.createElement("label");
      const input = document.createElement("input");
      Object.assign(input, { type: "checkbox", id: `layer-${name}` });
      input.addEventListener("change", () => this.toggle(name));
      const words = document.createElement("span");
      words.textContent = TITLES[name];
      label.append(input, words, ...(index < KEYS ? [keyOf(index + 1)] : []));
      box.append(label);
    });
    this.#applySwitches();
  }

  #applySwitches() {
    for (const name of LAYERS) {
      const on = this.shown.has(name);
      document.getElementById(`layer-${name}`).checked = on;
      this.stage.svg.classList.toggle(`no-${name}`, !on);
    }
    document.getElementById("layers-count").textContent = `${this.shown.size} of ${LAYERS.length}`;
    this.stage.canvas.hidden = !this.shown.has("picture");
    this.camera.wanted = this.shown.has("camera");
    this.heat.wanted = this.shown.has("clearance");
    this.picture.wanted = this.shown.has("picture") || this.shown.has("camera");
    this.#showRamp();
  }

  #greet(hello) {
    this.#hello = hello;
    this.stage.fit(hello);
    this.#track = [];
    const [x0, y0, x1, y1] = hello.arena_m;
    const s = this.stage;
    s.group("floor").replaceChildren(
      element("rect", { class: "floor", x: s.x(x0), y: s.y(y1), width: s.x(x1) - s.x(x0), height: s.y(y0) - s.y(y1) }),
    );
  }

  #keepWorld(world) {
    this.#world = world;
    this.#drawObstacles(world);
    this.#drawChains(world);
    this.#showRamp();
  }

  #drawObstacles(world) {
    const { border, border_first: first, border_closed: closed } = world.arrays;
    const solid = [];
    const open = [];
    for (let b = 0; b < closed.length; b++) {
      const data = this.stage.line(border, first[b], first[b + 1]);
      if (closed[b]) solid.push(`${data}Z`);
      else open.push(data);
    }
    this.stage.group("obstacles").replaceChildren(
      element("path", { class: "obstacle", d: solid.join(""), "fill-rule": "evenodd" }),
      element("path", { class: "obstacle-line", d: open.join("") }),
      ...obstaclePlaces(world, MOST_NUMBERED).map(({ owner, x, y }) => element("text", { class: "label obstacle-number", x: this.stage.x(x), y: this.stage.y(y), "text-anchor": "middle", "dominant-baseline": "central" }, String(owner))),
    );
  }

  #drawChains(world) {
    const { chain, chain_first: first, chain_usable: usable, chain_clearance: rho } = world.arrays;
    const span = clearanceSpan(world);
    const steps = this.#hello.ramp_steps;
    const roads = Array.from({ length: steps }, () => "");
    const thin = Array.from({ length: steps }, () => "");
    const step = (k) => {
      const part = span && span[1] > span[0] ? (rho[k] - span[0]) / (span[1] - span[0]) : 1;
      return Math.min(steps - 1, Math.max(0, Math.round(part * (steps - 1))));
    };
    for (let c = 0; c < usable.length; c++) {
      const into = usable[c] ? roads : thin;
      for (let k = first[c]; k + 1 < first[c + 1];) {
        const colour = step(k);
        let end = k + 1;
        while (end + 1 < first[c + 1] && step(end) === colour) end++;
        into[colour] += this.stage.line(chain, k, end + 1);
        k = end;
      }
    }
    const paths = (lines, name) => lines.map((d, n) => d && element("path", { class: name, d, stroke: `var(--ramp-${n})` })).filter(Boolean);
    this.stage.group("roadmap").replaceChildren(...paths(roads, "road"));
    this.stage.group("diagram").replaceChildren(...paths(thin, "chain"), ...paths(roads, "chain"));
  }

  #showRamp() {
    const span = this.#world && clearanceSpan(this.#world);
    const box = document.getElementById("ramp");
    box.hidden = !span || !["roadmap", "diagram", "clearance"].some((name) => this.shown.has(name));
    if (!span) return;
    document.getElementById("ramp-low").textContent = span[0].toFixed(2);
    document.getElementById("ramp-high").textContent = span[1].toFixed(2);
  }

  #drawPlan() {
    const { points } = this.#plan.arrays;
    const data = this.stage.line(points);
    const wide = 2 * (this.#plan.radius_m ?? 0) * this.stage.scale;
    this.stage.group("corridor").replaceChildren(...(data ? [element("path", { class: "corridor", d: data, "stroke-width": wide })] : []));
    this.stage.group("plan").replaceChildren(
      ...(data ? [element("path", { class: "halo", d: data }), element("path", { class: "path", d: data })] : []),
    );
    const at = this.#plan.narrowest_m;
    this.stage.group("narrowest").replaceChildren(
      ...(at ? [element("circle", { class: "narrowest", cx: this.stage.x(at[0]), cy: this.stage.y(at[1]), r: Math.max(3, this.#plan.clearance_m * this.stage.scale) })] : []),
    );
  }

  #addTrack(piece) {
    for (const place of piece.items) this.#track.push(...(place ?? [NaN, NaN]));
    if (this.#track.length > 2 * TRACK_MOST) this.#track = this.#track.slice(-2 * TRACK_MOST);
    this.#drawTrack();
  }

  #drawTrack() {
    const data = this.#track.length > 2 ? this.stage.line(this.#track) : "";
    this.stage.group("track").replaceChildren(...(data ? [element("path", { class: "track", d: data })] : []));
  }

  #drawState(state) {
    if (!state || !this.#hello) return;
    this.state = state;
    if (!state.robots) this.#drawMission(state.mission); // several are drawn by robots_layer.js
    const over = state.paused || !["driving", "proving", "planning", "holding"].includes(state.mission.state);
    for (const name of ["plan", "corridor", "narrowest"]) this.stage.group(name).classList.toggle("over", over);
    const seen = new Set();
    const { robot, others } = this.#hello;
    if (state.pose && !state.robots) this.#drawRobot(seen, state.pose, robot.radius_m, "robot");
    for (const pose of state.others) {
      const known = others.find((other) => other.marker_id === pose.id);
      this.#drawRobot(seen, pose, known?.radius_m ?? robot.radius_m, "other");
    }
    for (const [id, group] of this.#robots) {
      if (!seen.has(id)) {
        group.remove();
        this.#robots.delete(id);
      }
    }
  }

  #drawRobot(seen, pose, radius, kind) {
    seen.add(pose.id);
    const s = this.stage;
    let group = this.#robots.get(pose.id);
    if (!group) {
      group = element("g", { class: kind });
      const r = radius * s.scale;
      group.append(
        element("path", { class: "lean" }),
        element("circle", { class: "body-halo", r }),
        element("circle", { class: "body", r }),
        element("path", { class: "nose", d: `M${0.92 * r} 0L${0.2 * r} ${-0.5 * r}L${0.38 * r} 0L${0.2 * r} ${0.5 * r}Z` }),
        element("text", { class: "label", "text-anchor": "middle" }),
      );
      s.group("robots").append(group);
      this.#robots.set(pose.id, group);
    }
    const stale = pose.age_ms === null || pose.age_ms > STALE_MS + 150;
    group.classList.toggle("stale", stale);
    group.setAttribute("transform", `translate(${s.x(pose.x_m).toFixed(1)} ${s.y(pose.y_m).toFixed(1)})`);
    const degrees = (-pose.heading_rad * 180) / Math.PI;
    group.querySelector(".nose").setAttribute("transform", `rotate(${degrees.toFixed(1)})`);
    group.querySelector(".lean").setAttribute("d", lean(s, pose, radius * s.scale));
    const label = group.querySelector(".label");
    label.setAttribute("y", (radius * s.scale + 15 * s.k).toFixed(1));
    const age = pose.age_ms === null ? "not seen" : `seen ${(pose.age_ms / 1000).toFixed(1)} s ago`;
    label.textContent = stale ? age : kind === "other" ? `robot ${pose.id}` : "";
  }

  #drawMission(mission) {
    const over = mission.state === "done" || mission.state === "idle";
    const marks = mission.stations.map((station, index) => {
      const last = index === mission.stations.length - 1;
      const done = index < mission.visited;
      return stationMark(this.stage, station, last ? "goal" : String(index + 1), `station${done ? " done" : ""}`, this.#hello.robot.radius_m);
    });
    const key = JSON.stringify([mission.stations, mission.visited, over, this.stage.k]);
    if (key === this.missionKey) return;
    this.missionKey = key;
    this.stage.group("mission").replaceChildren(...marks);
  }
}

/** A layer's key; with several robots the numbers choose these, and with Shift the layers. */
function keyOf(number) {
  const made = Object.assign(document.createElement("span"), { className: "key" });
  const shift = Object.assign(document.createElement("kbd"), { className: "of-several", hidden: true, textContent: "Shift" });
  made.append(shift, Object.assign(document.createElement("kbd"), { textContent: String(number) }));
  made.setAttribute("aria-hidden", "true");
  return made;
}

/** From the robot's place to where the camera sees its top, which is above the floor. */
function lean(stage, pose, r) {
  const [x, y] = [stage.x(pose.seen_m[0]) - stage.x(pose.x_m), stage.y(pose.seen_m[1]) - stage.y(pose.y_m)];
  if (Math.hypot(x, y) < 5 * stage.k) return "";
  return `M0 0L${x.toFixed(1)} ${y.toFixed(1)}M${(x - r).toFixed(1)} ${y.toFixed(1)}a${r} ${r} 0 1 0 ${2 * r} 0a${r} ${r} 0 1 0 ${-2 * r} 0`;
}

/** A station's mark: a ring of the robot's size, its heading and its name. */
export function stationMark(stage, station, name, kind, radius) {
  const group = element("g", { class: kind });
  const r = Math.max(7 * stage.k, radius * stage.scale);
  const [x, y] = [stage.x(station.x_m), stage.y(station.y_m)];
  group.append(element("circle", { class: "ring", cx: x, cy: y, r }), element("circle", { class: "pin", cx: x, cy: y, r: 3.5 * stage.k }));
  if (station.heading_rad !== null && station.heading_rad !== undefined) {
    const [c, s] = [Math.cos(station.heading_rad), Math.sin(station.heading_rad)];
    group.append(element("path", { class: "heading", d: `M${x} ${y}L${x + r * c} ${y - r * s}` }));
  }
  const right = x + r + (10 + 9 * name.length) * stage.k < stage.width;
  const gap = r + 5 * stage.k;
  group.append(element("text", { class: "label", x: right ? x + gap : x - gap, y: y + 4.5 * stage.k, "text-anchor": right ? "start" : "end" }, name));
  return group;
}

/** True by name if a layer was on; nothing for a new one. */
function remembered() {
  try {
    return JSON.parse(localStorage.getItem("clearway.layers")) ?? {};
  } catch {
    return {};
  }
}
