// A recording on the page: play, pause, speed, and a bar to jump anywhere; the same moment for all
// viewers. Nothing drives a robot here, and STOP gives way to a sign that says so: the page must not
// look as if it could stop one.

import { fill } from "./list.js";

const STEP_S = 5;
const FAR_S = 30;
const WORD = "RECORDING";
const NOTE = "stops no robot";

export class Replay {
  #recording = null;
  #state = null;
  #isHeld = false;

  constructor(connection, say) {
    Object.assign(this, { connection, say });
    this.bar = document.getElementById("replay");
    this.button = document.getElementById("replay-play");
    this.place = document.getElementById("replay-seek");
    this.time = document.getElementById("replay-time");
    this.speed = document.getElementById("replay-speed");
    this.button.addEventListener("click", () => this.#toggle());
    this.place.addEventListener("input", () => {
      this.#isHeld = true;
      this.#showTime(Number(this.place.value));
    });
    this.place.addEventListener("change", () => {
      this.#isHeld = false;
      this.#steer("seek", Number(this.place.value));
    });
    this.speed.addEventListener("change", () => this.#steer("speed", Number(this.speed.value)));
    connection.on("hello", (hello) => this.#greet(hello.replay));
    connection.on("state", (state) => this.#show(state.replay));
  }

  /** True if a key was for the recording. */
  key(event) {
    if (!this.#recording) return false;
    const step = event.shiftKey ? FAR_S : STEP_S;
    const name = event.key.toLowerCase();
    if (name === "p") this.#toggle();
    else if (name === "j") this.#steer("step", -step);
    else if (name === "l") this.#steer("step", step);
    else if (name === "<" || name === ">") this.#shift(name === "<" ? -1 : 1);
    else return false;
    return true;
  }

  #greet(recording) {
    this.#recording = recording ?? null;
    document.body.classList.toggle("is-replay", Boolean(recording));
    this.bar.hidden = !recording;
    if (!recording) return;
    this.place.max = recording.duration_s;
    fill(this.speed, recording.speeds, () => recording.speeds.map((value) => new Option(`${value}×`, value)));
    document.getElementById("stop-word").textContent = WORD;
    document.getElementById("stop-key").textContent = NOTE;
    document.getElementById("stop").removeAttribute("aria-keyshortcuts");
    const began = new Date(1000 * recording.began_s).toLocaleString([], { dateStyle: "medium", timeStyle: "short", hour12: false });
    document.getElementById("seat-text").textContent = `${recording.file}, ${began}${recording.cut ? ", its end is missing" : ""}`;
  }

  #show(state) {
    if (!state) return;
    this.#state = state;
    this.button.textContent = state.playing ? "Pause" : "Play";
    if (!this.#isHeld) {
      this.place.value = state.place_s;
      this.#showTime(state.place_s);
    }
    if (document.activeElement !== this.speed) this.speed.value = state.speed;
    document.title = `${state.playing ? "▶" : "Ⅱ"} Recording – Clearway`;
  }

  #showTime(seconds) {
    const text = `${clock(seconds)} of ${clock(this.#recording.duration_s)}`;
    if (this.time.textContent !== text) this.time.textContent = text;
    this.place.setAttribute("aria-valuetext", text);
  }

  #toggle() {
    this.#steer(this.#state?.playing ? "pause" : "play");
  }

  #shift(by) {
    const { speeds } = this.#recording;
    const value = speeds[speeds.indexOf(this.#state?.speed) + by];
    if (value !== undefined) this.#steer("speed", value);
  }

  async #steer(what, value = 0) {
    const answer = await this.connection.ask({ type: "replay", do: what, value });
    this.say(answer.ok ? "" : answer.error);
  }
}

function clock(seconds) {
  const whole = Math.floor(seconds);
  const [h, m, s] = [Math.floor(whole / 3600), Math.floor(whole / 60) % 60, String(whole % 60).padStart(2, "0")];
  return h ? `${h}:${String(m).padStart(2, "0")}:${s}` : `${m}:${s}`;
}
