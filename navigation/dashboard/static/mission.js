// The mission's state in words: what the robot does, or why it does not move.

import { fill } from "./list.js";
import { allow, onPress } from "./press.js";

const WORDS = {
  idle: "Ready", planning: "Planning", proving: "Checking itself", driving: "Driving", holding: "Holding",
  stopped: "Stopped", done: "Arrived", failed: "Failed",
};

const UNDER_WAY = ["planning", "proving", "driving", "holding"];

export class MissionPanel {
  /** Doubts of the planner about the plan that is driven. */
  #remarks = [];

  constructor(connection, seat, say) {
    Object.assign(this, { connection, seat, say });
    /** From the program: navigation/orders/table.py. */
    this.buttons = [...document.querySelectorAll("#orders button")];
    for (const button of this.buttons) {
      onPress(button, say, () => this.#order({ order: button.id }));
      allow(button, "the program has said nothing yet");
    }
    connection.on("plan", (plan) => { this.#remarks = plan.remarks ?? []; });
    connection.on("down", () => {
      put("mission-state", "No connection");
      document.getElementById("now").dataset.state = "lost";
    });
    connection.on("state", (state) => this.#show(state));
  }

  async #order(order) {
    const taken = await this.seat.takeIfFree();
    const answer = taken.ok ? await this.connection.ask({ type: "order", ...order }) : taken;
    this.say(answer.ok ? "" : answer.error);
  }

  /** Further reasons, and the plan's remarks, where the sentence does not have them. */
  #list({ state, sentence: said, reasons }) {
    const more = ["driving", "stopped"].includes(state) ? [] : reasons;
    const remarks = UNDER_WAY.includes(state) ? this.#remarks.map((remark) => `This plan: ${remark}`) : [];
    const shown = [...more.filter((reason) => !said.includes(reason)), ...remarks.filter((_, n) => !said.includes(this.#remarks[n]))];
    const list = document.getElementById("reasons");
    list.hidden = shown.length === 0;
    fill(list, shown, () => shown.map((text) => Object.assign(document.createElement("li"), { textContent: text })));
  }

  #show(state) {
    const { mission, pose, link } = state;
    document.getElementById("now").dataset.state = state.paused ? "paused" : state.waits ? "holding" : mission.state;
    const word = `${state.name ? `${state.name}: ` : ""}${state.paused ? "Paused" : state.waits ? "Waiting" : WORDS[mission.state] ?? mission.state}`;
    put("mission-state", word);
    put("sentence", sentence(state));
    this.#list(mission);
    if (state.replay) put("fact-stations", mission.stations.length ? String(mission.stations.length) : "–");
    else put("fact-stations", mission.stations.length ? `${mission.visited} of ${mission.stations.length}` : "–");
    put("fact-to-go", metres(mission.state === "driving" ? state.to_go_m : null, 2));
    put("fact-clearance", metres(state.clearance_m, 3));
    put("fact-speed", pose ? `${link.moving ? pose.speed_m_s.toFixed(2) : "0.00"} m/s` : "–");
    for (const button of this.buttons) allow(button, this.seat.mayNot || (state.cannot[button.id] ?? ""));
    document.title = `${word} – Clearway`;
  }
}

function sentence({ mission }) {
  const text = mission.sentence;
  return text ? text[0].toUpperCase() + text.slice(1) + (/[.!?]$/.test(text) ? "" : ".") : "";
}

function metres(value, digits) {
  return value === null || value === undefined ? "–" : `${value.toFixed(digits)} m`;
}

function put(id, text) {
  const element = document.getElementById(id);
  if (element.textContent !== text) element.textContent = text;
}
