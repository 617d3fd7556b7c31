// Several robots in the picture: each with its number, name and colour, its path and goal, and a sign
// if it does not drive; an arrow from one that waits to the one it waits for.

import { condition } from "./fleet.js";
import { element } from "./stage.js";

const STALE_MS = 350;
const TRACK_MOST = 3000;
const COLOURS = 8;
const ARROW = 9;
const NEVER_SHOWN = ["done", "idle", "failed", "stopped"];

export class RobotsLayer {
  #radii = new Map();
  #tracks = new Map();
  #plans = null;
  #state = null;

  constructor(stage, connection, fleet) {
    Object.assign(this, { stage, fleet });
    this.groups = {};
    for (const [name, before] of [["tracks", "mission"], ["plans", "mission"], ["goals", "robots"], ["waits", "draft"], ["bodies", "draft"], ["labels", "draft"]]) {
      this.groups[name] = element("g", { "data-layer": `fleet-${name}` });
      stage.svg.insertBefore(this.groups[name], stage.group(before));
    }
    connection.on("hello", () => this.#greet());
    connection.on("plans", (plans) => { this.#plans = plans; this.#drawPlans(); });
    connection.on("tracks", (piece) => this.#addTrack(piece));
    connection.on("state", (state) => { if (state.robots) this.#draw(state); });
    connection.on("chosen", () => this.#choose());
    stage.onResize.push(() => { if (this.#state) this.#draw(this.#state); });
    // before anybody takes the press for a goal
    stage.element.addEventListener("pointerdown", (event) => this.#press(event), { capture: true });
  }

  #greet() {
    this.#tracks.clear();
    for (const robot of this.fleet.robots) this.#radii.set(robot.name, robot.radius_m);
    for (const group of Object.values(this.groups)) group.replaceChildren();
    this.#choose();
  }

  #choose() {
    const index = this.fleet.indexOf(this.fleet.name);
    if (index < 0) return;
    this.stage.svg.style.setProperty("--path", `var(--robot-${index % COLOURS})`);
    this.#drawPlans();
    if (this.#state) this.#draw(this.#state);
  }

  /** A press on a robot chooses it; with Shift, or on the chosen one, it sets a station there. */
  #press(event) {
    if (!this.#state || this.stage.tool || event.button !== 0 || !event.isPrimary || event.shiftKey) return;
    const [x, y] = this.stage.place(event);
    const near = this.#state.robots
      .filter(({ pose }) => pose)
      .map(({ name, pose }) => [Math.hypot(pose.x_m - x, pose.y_m - y) / Math.max(this.#radii.get(name), (14 * this.stage.k) / this.stage.scale), name])
      .sort(([a], [b]) => a - b)[0];
    if (!near || near[0] > 1 || near[1] === this.fleet.name) return;
    event.preventDefault();
    event.stopImmediatePropagation();
    this.stage.element.focus({ preventScroll: true });
    this.fleet.choose(near[1]);
  }

  /** An element's class with the robot's colour, its line's pattern, and if it is chosen. */
  #own(kind, name) {
    const index = this.fleet.indexOf(name);
    return `${kind} own-${index % COLOURS} round-${Math.floor(index / COLOURS)}${name === this.fleet.name ? " chosen" : ""}`;
  }

  #addTrack({ robot, items }) {
    const track = this.#tracks.get(robot) ?? [];
    for (const place of items) track.push(...(place ?? [NaN, NaN]));
    this.#tracks.set(robot, track.slice(-2 * TRACK_MOST));
    this.#drawTracks();
  }

  #drawTracks() {
    const lines = [...this.#tracks].map(([name, track]) => element("path", { class: this.#own("own-track", name), d: track.length > 2 ? this.stage.line(track) : "" }));
    this.groups.tracks.replaceChildren(...lines);
  }

  #drawPlans() {
    if (!this.#plans) return;
    const { plans, arrays } = this.#plans;
    const shapes = [];
    plans.forEach(({ name }, index) => {
      const data = this.stage.line(arrays.points, arrays.first[index], arrays.first[index + 1]);
      if (!data || name === this.fleet.name) return; // the chosen one's is drawn as a plan is
      const group = element("g", { class: this.#own("own-plan", name), "data-robot": name });
      group.append(element("path", { class: "halo", d: data }), element("path", { class: "own-path", d: data }));
      shapes.push(group);
    });
    this.groups.plans.replaceChildren(...shapes);
    this.#hideOver();
  }

  /** Hide paths that no robot drives any more. */
  #hideOver() {
    for (const group of this.groups.plans.children) {
      const robot = this.#state?.robots.find(({ name }) => name === group.dataset.robot);
      group.toggleAttribute("hidden", Boolean(robot) && NEVER_SHOWN.includes(robot.mission.state));
    }
  }

  #draw(state) {
    this.#state = state;
    if (!this.stage.window) return;
    this.#hideOver();
    const last = this.fleet.name; // on top of the others
    const robots = [...state.robots].sort((a, b) => (a.name === last) - (b.name === last));
    this.groups.goals.replaceChildren(...robots.flatMap((robot) => this.#goals(robot)));
    const placed = robots.filter(({ pose }) => pose);
    this.groups.bodies.replaceChildren(...placed.map((robot) => this.#body(robot)));
    this.groups.labels.replaceChildren(...placed.map((robot) => this.#label(robot))); // no body covers one
    const waits = robots.map((robot) => this.#arrow(robot, state.robots.find(({ name }) => name === robot.waits_for)));
    this.groups.waits.replaceChildren(...waits.filter(Boolean));
  }

  #goals({ name, mission }) {
    if (mission.state === "done" || mission.state === "idle") return [];
    const s = this.stage;
    const r = Math.max(7 * s.k, this.#radii.get(name) * s.scale);
    const number = this.fleet.indexOf(name) + 1;
    return mission.stations.slice(mission.visited).map((station, index, left) => {
      const group = element("g", { class: this.#own("own-goal", name) });
      const [x, y] = [s.x(station.x_m), s.y(station.y_m)];
      group.append(element("circle", { class: "ring", cx: x, cy: y, r }));
      if (station.heading_rad !== null) {
        const [c, i] = [Math.cos(station.heading_rad), Math.sin(station.heading_rad)];
        group.append(element("path", { class: "heading", d: `M${x + 0.55 * r * c} ${y - 0.55 * r * i}L${x + r * c} ${y - r * i}` }));
      }
      const text = left.length > 1 ? `${number}.${mission.visited + index + 1}` : String(number);
      group.append(element("text", { class: "label", x, y: y + 4.5 * s.k, "text-anchor": "middle" }, text));
      return group;
    });
  }

  #body(robot) {
    const { name, pose } = robot;
    const s = this.stage;
    const r = this.#radii.get(name) * s.scale;
    const [level, , sign] = condition(robot);
    const [x, y] = [s.x(pose.x_m), s.y(pose.y_m)];
    const group = element("g", { class: this.#own("own-robot", name), "data-robot": name, transform: `translate(${x.toFixed(1)} ${y.toFixed(1)})` });
    group.classList.toggle("stale", pose.age_ms === null || pose.age_ms > STALE_MS);
    group.dataset.level = level;
    const degrees = (-pose.heading_rad * 180) / Math.PI;
    if (name === this.fleet.name) group.append(element("circle", { class: "choice", r: r + 6 * s.k }));
    group.append(
      element("circle", { class: "body-halo", r }),
      element("circle", { class: "body", r }),
      element("path", { class: "nose", transform: `rotate(${degrees.toFixed(1)})`, d: `M${1.5 * r} 0L${0.98 * r} ${-0.5 * r}A${1.1 * r} ${1.1 * r} 0 0 1 ${0.98 * r} ${0.5 * r}Z` }),
      element("text", { class: "number", y: 5 * s.k, "text-anchor": "middle" }, String(this.fleet.indexOf(name) + 1)),
    );
    if (sign) {
      const [bx, by] = [0.8 * r, -0.8 * r];
      group.append(element("circle", { class: "badge", cx: bx, cy: by, r: 8 * s.k }), element("text", { class: "sign", x: bx, y: by + 4 * s.k, "text-anchor": "middle" }, sign));
    }
    return group;
  }

  /** The name, and what keeps the robot, below it or above; kept within the picture. */
  #label({ name, pose, waits_for: other, ...robot }) {
    const s = this.stage;
    const r = this.#radii.get(name) * s.scale;
    const [x, y] = [s.x(pose.x_m), s.y(pose.y_m)];
    const [, word, sign] = condition({ pose, waits_for: other, ...robot });
    const text = sign ? `${name}: ${word[0].toLowerCase()}${word.slice(1)}` : name;
    const half = (text.length * 3.9 + 4) * s.k;
    const shift = Math.max(half - x, 0) - Math.max(x + half - s.width, 0);
    const isLow = y + r + 20 * s.k > s.height;
    const group = element("g", { class: this.#own("own-robot", name) });
    group.append(element("text", { class: "label", x: x + shift, y: isLow ? y - r - 9 * s.k : y + r + 15 * s.k, "text-anchor": "middle" }, text));
    return group;
  }

  /** From the edge of one body to the edge of the other, with a head. */
  #arrow(robot, other) {
    if (!robot.pose || !other?.pose) return null;
    const s = this.stage;
    const [ax, ay, bx, by] = [s.x(robot.pose.x_m), s.y(robot.pose.y_m), s.x(other.pose.x_m), s.y(other.pose.y_m)];
    const long = Math.hypot(bx - ax, by - ay);
    const [ux, uy] = [(bx - ax) / long, (by - ay) / long];
    const [from, to] = [this.#radii.get(robot.name) * s.scale, long - this.#radii.get(other.name) * s.scale - 3 * s.k];
    if (to - from < 4 * s.k) return null;
    const head = Math.min(ARROW * s.k, to - from);
    const at = (along, aside) => `${(ax + ux * along - uy * aside).toFixed(1)} ${(ay + uy * along + ux * aside).toFixed(1)}`;
    const line = `M${at(from, 0)}L${at(to, 0)}`;
    const group = element("g", { class: this.#own("wait", robot.name), "data-robot": robot.name });
    group.append(
      element("path", { class: "halo", d: line }),
      element("path", { class: "wait-line", d: line }),
      element("path", { class: "wait-head", d: `M${at(to, 0)}L${at(to - head, 0.55 * head)}L${at(to - head, -0.55 * head)}Z` }),
    );
    return group;
  }
}
