// Several robots on one page. Everything about one robot (its mission, a new goal, its link) is about
// the chosen one; the list and the picture show them all.
//
// What arrives is handed on as if the chosen robot were the only one, and orders go to it by name; STOP
// names no robot and stops all.

const KEPT = 240; // rows of the charts

export class Fleet {
  #hello = null;
  #state = null;
  #plans = null;
  #samples = new Map();

  constructor(connection) {
    this.connection = connection;
    /** As the program lists them; empty for a single robot, which has no name. */
    this.robots = [];
    this.name = null;
    connection.handOut = (message) => this.#handOut(message);
    connection.address = (message) => this.#address(message);
  }

  get areSeveral() {
    return this.robots.length > 0;
  }

  /** From 0, in the configuration's order: its colour, its key and, plus one, its number. */
  indexOf(name) {
    return this.robots.findIndex((robot) => robot.name === name);
  }

  choose(name) {
    const robot = this.robots[this.indexOf(name)];
    if (!robot || name === this.name) return;
    this.name = name;
    sessionStorage.setItem("clearway.robot", name);
    Object.assign(this.#hello.robot, robot);
    this.connection.emit("chosen", name);
    if (this.#plans) this.connection.emit("plan", this.#planOf(name));
    this.connection.emit("samples of another", this.#samples.get(name) ?? []);
    if (this.#state) this.connection.emit("state", this.#stateOf(name));
  }

  step(by) {
    const count = this.robots.length;
    this.choose(this.robots[(this.indexOf(this.name) + by + count) % count].name);
  }

  /** Numbers and brackets choose a robot; true if the key was one of these. */
  key(event) {
    if (!this.areSeveral) return false;
    const robot = event.shiftKey ? null : this.robots[Number(event.key) - 1];
    if (robot) this.choose(robot.name);
    else if (event.key === "]") this.step(1);
    else if (event.key === "[") this.step(-1);
    else return false;
    return true;
  }

  /** The messages that the page's parts get for one of the program's. */
  #handOut(message) {
    if (message.type === "hello") return [this.#greet(message)];
    if (!this.areSeveral) return [message];
    switch (message.type) {
      case "state":
        this.#state = message;
        return [this.#stateOf(this.name)];
      case "plans":
        this.#plans = message;
        return [message, this.#planOf(this.name)];
      case "track":
        return [{ ...message, type: "tracks" }];
      case "samples":
        this.#keep(message);
        return message.robot === this.name ? [message] : [];
      default:
        return [message];
    }
  }

  #greet(hello) {
    this.robots = hello.robots ?? [];
    this.#samples.clear();
    this.#hello = hello;
    if (this.areSeveral) {
      const before = this.name ?? sessionStorage.getItem("clearway.robot");
      const robot = this.robots[Math.max(0, this.indexOf(before))];
      this.name = robot.name;
      hello.robot = { ...robot };
    }
    return hello;
  }

  #stateOf(name) {
    const robot = this.#state.robots.find((one) => one.name === name);
    return { ...this.#state, ...robot };
  }

  #planOf(name) {
    const { plans, arrays } = this.#plans;
    const index = plans.findIndex((plan) => plan.name === name);
    const points = arrays.points.subarray(2 * arrays.first[index], 2 * arrays.first[index + 1]);
    return { ...plans[index], type: "plan", arrays: { points } };
  }

  #keep({ robot, items }) {
    this.#samples.set(robot, [...(this.#samples.get(robot) ?? []), ...items].slice(-KEPT));
  }

  /** An order without a name is the chosen robot's, except STOP; `robot: null` is for all. */
  #address(message) {
    const isMine = message.type === "preview" || (message.type === "order" && message.order !== "stop");
    return this.areSeveral && isMine && message.robot === undefined ? { ...message, robot: this.name } : message;
  }
}

/** Condition of a robot: [level, word, mark]; the mark is a sign beside its body. */
export function condition(robot) {
  const { mission, pose, link, waits, waits_for: other } = robot;
  if (mission.state === "stopped") return ["bad", "Stopped", "■"];
  if (link.reason) return ["bad", "Link lost", "?"];
  if (mission.state === "failed") return ["bad", "Failed", "×"];
  if (!pose) return ["warn", "Not seen", "?"];
  if (pose.age_ms === null || pose.age_ms > 1000) return ["warn", "Out of sight", "?"];
  if (robot.paused) return ["warn", "Paused", "!"];
  if (mission.state === "holding") return ["warn", "Holding", "!"];
  if (waits) return ["warn", other ? `Waits for ${other}` : "Waiting", "‖"];
  return { driving: ["good", "Driving", ""], done: ["good", "Arrived", ""], planning: ["calm", "Planning", ""], proving: ["calm", "Checking itself", ""] }[mission.state] ?? ["calm", "Ready", ""];
}
