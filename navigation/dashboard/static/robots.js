// The list of several robots: condition, whom each waits for and why; to choose one, to stop one alone
// and to re-arm it, and to pause, resume or re-arm all.

import { condition } from "./fleet.js";
import { fill } from "./list.js";
import { allow, onPress } from "./press.js";

const REARM_AFTER_MS = 1000; // a second press of a hurried hand does not undo the first
const STOP_MS = 800;

export class Robots {
  #rows = new Map();
  #stoppedSince = new Map();

  constructor(connection, fleet, seat, say) {
    Object.assign(this, { connection, fleet, seat, say });
    this.card = document.getElementById("robots");
    this.list = document.getElementById("robot-list");
    this.all = ["pause", "resume", "rearm"].map((order) => {
      const button = document.getElementById(`${order}-all`);
      onPress(button, say, () => this.#order({ order, robot: null }));
      return [order, button];
    });
    connection.on("hello", () => this.#make());
    connection.on("chosen", () => this.#showChosen());
    connection.on("state", (state) => { if (state.robots) this.#show(state.robots); });
  }

  /** Make the list; after a lost connection, if other robots are there. */
  #make() {
    const { robots, areSeveral: several } = this.fleet;
    const isNew = fill(this.list, robots.map(({ name }) => name), () => {
      this.#rows.clear();
      return robots.map((robot, index) => this.#row(robot, index));
    });
    if (!isNew) return;
    document.body.classList.toggle("has-fleet", several);
    this.card.hidden = !several;
    for (const part of document.querySelectorAll(".of-several")) part.hidden = !several;
    for (const part of document.querySelectorAll(".of-one")) part.hidden = several;
    if (several) tellOfKeys();
    // the list of robots has the place of Health, which is the chosen robot's
    const health = document.querySelector(".health");
    if (several) document.getElementById("beneath").prepend(health);
    else this.card.after(health);
    if (several) this.#showChosen();
  }

  #row(robot, index) {
    const row = made("li", "robot-row");
    const pick = made("button", "robot-pick");
    Object.assign(pick, { type: "button", id: `robot-${robot.name}` });
    if (index < 9) pick.setAttribute("aria-keyshortcuts", String(index + 1));
    pick.addEventListener("click", () => this.fleet.choose(robot.name));
    const parts = {
      chip: made("span", `chip own-${index % 8}`, String(index + 1)),
      name: made("span", "robot-name", robot.name),
      word: made("span", "word", "…"),
      figures: made("span", "robot-figures"),
      says: made("span", "robot-says"),
    };
    const line = made("span", "robot-line");
    line.append(parts.says, parts.figures);
    pick.append(parts.chip, parts.name, parts.word, line);
    const rearm = made("button", "quiet keeps-place", "Re-arm");
    const stop = made("button", "stop-one", "Stop");
    for (const [button, order] of [[rearm, "rearm"], [stop, "stop"]]) {
      Object.assign(button, { type: "button", id: `${order}-${robot.name}` });
      button.setAttribute("aria-label", `${button.textContent} ${robot.name}`);
    }
    rearm.hidden = true;
    onPress(rearm, this.say, () => this.#order({ order: "rearm", robot: robot.name }));
    stop.addEventListener("click", () => this.#stop(robot.name));
    row.append(pick, rearm, stop);
    this.#rows.set(robot.name, { row, pick, rearm, stop, ...parts });
    return row;
  }

  /** Stop one robot; every viewer who may stop can do so, even if another one is in control. */
  async #stop(robot) {
    const answer = await this.connection.ask({ type: "order", order: "stop", robot }, STOP_MS);
    if (answer.type !== "answer") this.say(`the stop of ${robot} was not answered: press STOP, which stops all`);
    else this.say(answer.ok ? "" : answer.error);
  }

  async #order(order) {
    const taken = await this.seat.takeIfFree();
    const answer = taken.ok ? await this.connection.ask({ type: "order", ...order }) : taken;
    this.say(answer.ok ? "" : answer.error);
  }

  #showChosen() {
    const { name } = this.fleet;
    for (const [other, { row, pick }] of this.#rows) {
      row.classList.toggle("chosen", other === name);
      pick.setAttribute("aria-pressed", String(other === name));
    }
    document.getElementById("send").textContent = `Send ${name}`;
    document.getElementById("health-of").textContent = `Link, clearance and speed are ${name}’s.`;
  }

  #show(robots) {
    for (const robot of robots) {
      const parts = this.#rows.get(robot.name);
      if (!parts) continue;
      const [level, word] = condition(robot);
      parts.row.dataset.level = level;
      parts.word.dataset.level = level;
      put(parts.word, word);
      put(parts.figures, figures(robot));
      const says = sentence(robot);
      put(parts.says, says);
      parts.says.title = says;
      this.#allowRearming(robot, parts);
    }
    this.#allowAll(robots);
  }

  #allowRearming({ name, mission }, { rearm }) {
    const stopped = mission.state === "stopped";
    if (stopped && !this.#stoppedSince.has(name)) this.#stoppedSince.set(name, performance.now());
    if (!stopped) this.#stoppedSince.delete(name);
    rearm.hidden = !stopped;
    allow(rearm, this.#whyNotRearm(stopped ? [name] : []));
  }

  #whyNotRearm(names) {
    if (this.seat.mayNot) return this.seat.mayNot;
    if (!names.length) return "nothing to re-arm: no robot is stopped";
    const soon = names.some((name) => performance.now() - this.#stoppedSince.get(name) < REARM_AFTER_MS);
    return soon ? "re-arm a second after the stop, not sooner" : "";
  }

  #allowAll(robots) {
    const can = (order) => robots.some(({ cannot }) => !cannot[order]);
    const whyNot = {
      pause: this.seat.mayNot || (can("pause") ? "" : "nothing to pause: no robot is under way"),
      resume: this.seat.mayNot || (can("resume") ? "" : "nothing to resume: no robot is paused or broken off"),
      rearm: this.#whyNotRearm(robots.filter(({ mission }) => mission.state === "stopped").map(({ name }) => name)),
    };
    for (const [order, button] of this.all) allow(button, whyNot[order]);
  }
}

function tellOfKeys() {
  const stage = document.getElementById("stage");
  const more = " Numbers choose a robot, brackets the one before and the next.";
  if (!stage.ariaLabel.endsWith(more)) stage.ariaLabel += more;
}

function figures({ link }) {
  return link.reason || link.round_trip_ms === null ? "" : `link ${link.round_trip_ms.toFixed(0)} ms`;
}

/** Reason why it does not drive, or how far it has still to go. */
function sentence({ waits, mission, link, to_go_m }) {
  if (waits) return upper(waits);
  if (mission.state === "driving" && !link.reason && to_go_m !== null) return `${to_go_m.toFixed(2)} m to go`;
  return upper(mission.state === "stopped" ? mission.sentence : link.reason ?? mission.sentence);
}

const upper = (text) => (text ? text[0].toUpperCase() + text.slice(1) : "");

function made(tag, className, textContent = "") {
  return Object.assign(document.createElement(tag), { className, textContent });
}

function put(element, text) {
  if (element.textContent !== text) element.textContent = text;
}
