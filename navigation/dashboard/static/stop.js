// STOP: immediate, without a question, for everybody with a token; by the button and the space bar.
//
// Only a hand fires it: nothing here runs because the page was loaded or the connection came back.
// Without a connection a plain request is tried at once, and it is said whether it arrived. Leaving the
// stop is another button, which waits a moment so that a second press of a hurried hand does not undo
// the first.

import { allow, onPress } from "./press.js";

const REARM_AFTER_MS = 1000;
const LINE_MS = 400;
const REQUEST_MS = 1500;
const AT_REST = ["idle", "done", "failed", "stopped"];
const TYPED = "input[type=text], input[type=search], input[type=password], textarea";

export class Stop {
  #stoppedSince = 0;
  #pressedAt = -Infinity;
  /** Every robot, as far as the page knows now: only then a space can be typed somewhere. */
  #isAtRest = false;

  constructor(connection, seat, say) {
    Object.assign(this, { connection, seat, say });
    this.button = document.getElementById("stop");
    this.rearm = document.getElementById("rearm");
    this.note = document.getElementById("stopped");
    this.button.addEventListener("pointerdown", (event) => {
      if (event.button === 0) this.fire();
    });
    this.button.addEventListener("click", (event) => {
      if (event.detail === 0) this.fire(); // by Enter or a screen reader: no pointer went down
    });
    addEventListener("keydown", (event) => this.#key(event), { capture: true });
    addEventListener("keyup", (event) => {
      if (event.code === "Space") event.preventDefault(); // else it would press a focused button
    }, { capture: true });
    onPress(this.rearm, say, () => this.#leave());
    connection.on("state", (state) => this.#follow(state));
    connection.on("down", () => {
      this.#isAtRest = false;
      allow(this.rearm, "there is no connection to the program");
    });
  }

  async fire() {
    if (this.seat.isRecording) {
      this.say(this.seat.mayNot);
      return;
    }
    this.#pressedAt = performance.now();
    this.button.classList.add("fired");
    setTimeout(() => this.button.classList.remove("fired"), 300);
    const answer = (await this.#byLine()) ?? (await this.#byRequest());
    if (answer === null) {
      this.say("STOP could not be delivered: use the switch on the robot. It stops by itself when the program does not reach it");
    } else if (!answer.ok) {
      this.say(answer.error);
      if (this.seat.isVisitor) this.connection.emit("token", 401);
    }
  }

  /** The answer over the websocket; null without one in time. */
  async #byLine() {
    const answer = await this.connection.ask({ type: "order", order: "stop" }, LINE_MS);
    return answer.type === "answer" ? answer : null; // else the program said nothing
  }

  async #byRequest() {
    try {
      const answer = await fetch("/api/stop", {
        method: "POST",
        headers: this.connection.authorization,
        signal: AbortSignal.timeout(REQUEST_MS), // an old STOP must not arrive later
      });
      if (answer.status === 401 || answer.status === 403) return { ok: false, error: (await answer.text()).trim() };
      return answer.ok ? await answer.json() : null;
    } catch {
      return null;
    }
  }

  #key(event) {
    if (event.code !== "Space" || event.ctrlKey || event.altKey || event.metaKey) return;
    if (this.#isAtRest && event.target.matches?.(TYPED)) return;
    event.preventDefault();
    event.stopPropagation();
    if (!event.repeat) this.fire();
  }

  async #leave() {
    const taken = await this.seat.takeIfFree();
    const answer = taken.ok ? await this.connection.ask({ type: "order", order: "rearm" }) : taken;
    this.say(answer.ok ? "" : answer.error);
  }

  #follow(state) {
    this.#isAtRest = (state.robots ?? [state]).every((one) => AT_REST.includes(one.mission.state));
    const stopped = state.mission.state === "stopped";
    if (stopped && this.note.hidden) this.#stoppedSince = performance.now();
    this.note.hidden = this.rearm.hidden = !stopped;
    document.body.classList.toggle("is-stopped", stopped);
    if (!stopped) return;
    document.getElementById("stopped-text").textContent = wheels(state.link);
    const since = Math.max(this.#stoppedSince, this.#pressedAt);
    const isSoon = performance.now() - since < REARM_AFTER_MS;
    allow(this.rearm, this.seat.mayNot ? this.seat.mayNot : isSoon ? "re-arm a second after STOP, not sooner" : "");
  }
}

/** Sentence on the robot's wheels, as the server judges them. */
function wheels(link) {
  if (!link.stop_doubt) return "The robot has confirmed; its wheels are off.";
  if (link.reason) return "It is not known whether the robot stands: the link to it is down.";
  return link.estopped ? "It has confirmed, but is not heard to stand yet." : "Waiting for the robot to confirm.";
}
