// The mission's state in words: what the robot does, or the plain sentence why it does not move.

const WORDS = {
  idle: "Ready", planning: "Planning", proving: "Proving itself", driving: "Driving", holding: "Holding",
  stopped: "Stopped", done: "Arrived", failed: "Failed",
};

export class MissionPanel {
  #state = null;

  constructor(connection, seat, say) {
    Object.assign(this, { connection, seat, say });
    this.pause = document.getElementById("pause");
    this.replan = document.getElementById("replan");
    this.replan.addEventListener("click", () => this.#order({ order: "replan" }));
    this.again = document.getElementById("again");
    this.pause.addEventListener("click", () => this.#order(this.#state?.paused ? { order: "resume" } : { order: "pause" }));
    this.again.addEventListener("click", () => this.#order({ order: "resume" }));
    connection.on("state", (state) => this.#show(state));
  }

  get #left() {
    const { stations, visited } = this.#state.mission;
    return stations.length - visited;
  }

  async #order(order) {
    const taken = await this.seat.takeIfFree();
    const answer = taken.ok ? await this.connection.ask({ type: "order", ...order }) : taken;
    this.say(answer.ok ? "" : answer.error);
  }

  #show(state) {
    this.#state = state;
    const { mission, pose, link } = state;
    const panel = document.querySelector(".mission");
    panel.dataset.state = state.paused ? "paused" : mission.state;
    put("mission-state", state.paused ? "Paused" : WORDS[mission.state] ?? mission.state);
    put("sentence", sentence(state));
    const list = document.getElementById("reasons");
    const more = mission.reasons.filter((reason) => !mission.sentence.includes(reason));
    list.hidden = more.length === 0 || ["driving", "stopped"].includes(mission.state);
    if (!list.hidden && list.textContent !== more.join("")) {
      list.replaceChildren(...more.map((reason) => Object.assign(document.createElement("li"), { textContent: reason })));
    }
    put("fact-stations", mission.stations.length ? `${mission.visited} of ${mission.stations.length}` : "–");
    put("fact-to-go", metres(mission.state === "driving" ? state.to_go_m : null, 2));
    put("fact-clearance", metres(state.clearance_m, 3));
    put("fact-speed", pose ? `${link.moving ? pose.speed_m_s.toFixed(2) : "0.00"} m/s` : "–");
    this.pause.textContent = state.paused ? "Go on" : "Pause";
    const underWay = ["planning", "proving", "driving", "holding"].includes(mission.state);
    this.pause.disabled = !this.seat.mayDrive || !(underWay || state.paused) || mission.state === "stopped";
    this.replan.hidden = mission.state !== "driving";
    this.again.hidden = !(["idle", "failed"].includes(mission.state) && this.#left > 0 && this.seat.mayDrive);
    document.title = `${state.paused ? "Paused" : WORDS[mission.state] ?? mission.state} – Clearway`;
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
