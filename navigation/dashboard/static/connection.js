// The line to the program: connects, connects again, and reports at once when it is lost.
//
// - What arrives is handed out by its type: connection.on("state", (message) => ...).
// - An order that cannot be sent now is refused now, so that a connection that comes back never sends
//   an old order.
// - The token travels in the websocket's subprotocol; it comes from the address's fragment.

import { unpack } from "./wire.js";

const PROTOCOL = "clearway.1";
const SILENT_MS = 1500; // the program speaks ten times a second
const FIRST_PAUSE_MS = 400;
const LAST_PAUSE_MS = 4000;

export class Connection {
  #socket = null;
  #listeners = new Map();
  #heard = 0;
  /** Milliseconds of silence at the last check; 0 if something was heard since. */
  #silent = 0;
  #pause = FIRST_PAUSE_MS;
  #timer = 0;
  #number = 0;
  #waiting = new Map();
  #lostSince = performance.now();
  /** Viewed contents: a picture at all and how wide, the camera's own one, the clearances. */
  #watched = { on: true, width_px: 1, camera: false, heat: false };

  constructor() {
    this.isUp = false;
    /** Messages for the page's parts from one of the program's (fleet.js). */
    this.handOut = (message) => [message];
    /** An order or question as it is sent. */
    this.address = (message) => message;
    this.lostReason = ""; // what the program said when it hung up
    this.key = kept("clearway.key", newKey);
    this.token = readToken();
    setInterval(() => this.#check(), 250);
    addEventListener("online", () => this.#retryNow());
    document.addEventListener("visibilitychange", () => {
      if (!document.hidden) this.#retryNow();
      this.watch();
    });
  }

  on(type, listener) {
    if (!this.#listeners.has(type)) this.#listeners.set(type, []);
    this.#listeners.get(type).push(listener);
  }

  emit(type, message) {
    for (const listener of this.#listeners.get(type) ?? []) listener(message);
  }

  /** Whole seconds since the connection was lost; 0 while it is up. */
  get lostSeconds() {
    return this.isUp ? 0 : Math.floor((performance.now() - this.#lostSince) / 1000);
  }

  open() {
    clearTimeout(this.#timer);
    const protocols = this.token ? [PROTOCOL, `token.${this.token}`] : [PROTOCOL];
    const scheme = location.protocol === "https:" ? "wss" : "ws";
    const socket = new WebSocket(`${scheme}://${location.host}/live`, protocols);
    socket.binaryType = "arraybuffer";
    this.#socket = socket;
    this.#heard = performance.now();
    socket.onopen = () => this.#greet(socket);
    socket.onmessage = (event) => this.#hear(socket, event.data);
    socket.onclose = (event) => this.#drop(socket, event.reason);
  }

  /** Say what is viewed: nothing else is made and sent. */
  watch(change = {}) {
    Object.assign(this.#watched, change);
    const { on, heat } = this.#watched;
    this.send({ ...this.#watched, type: "watch", on: on && !document.hidden, heat: heat && !document.hidden });
  }

  /** Send a message now; false if that is impossible. */
  send(message) {
    if (this.#socket?.readyState !== WebSocket.OPEN) return false;
    this.#socket.send(JSON.stringify(message));
    return true;
  }

  /** Send a message and wait for its answer; else {ok: false, error}. */
  ask(message, patience = 4000) {
    const id = ++this.#number;
    return new Promise((resolve) => {
      const fail = (error) => {
        this.#waiting.delete(id);
        resolve({ ok: false, error });
      };
      if (!this.isUp || !this.send({ ...this.address(message), id })) {
        fail("there is no connection to the program");
        return;
      }
      const timer = setTimeout(() => fail("the program does not answer"), patience);
      this.#waiting.set(id, { resolve, fail, timer });
    });
  }

  useToken(token) {
    this.token = token;
    sessionStorage.setItem("clearway.token", token);
    if (this.#socket) this.#drop(this.#socket); // it was let in with another token, or none
    clearTimeout(this.#timer);
    this.#retryNow();
  }

  /** Give the key that a held arena is known by, and the name that others see. */
  join() {
    this.send({ type: "join", key: this.key, name: localStorage.getItem("clearway.name") ?? "" });
  }

  #greet(socket) {
    if (socket !== this.#socket) return;
    this.join();
    this.watch();
  }

  #hear(socket, data) {
    if (socket !== this.#socket) return;
    this.#heard = performance.now();
    this.#silent = 0;
    const message = typeof data === "string" ? JSON.parse(data) : unpack(data);
    if (!this.isUp && message.type === "hello") {
      this.isUp = true;
      this.#pause = FIRST_PAUSE_MS;
      this.emit("up");
    }
    if (message.type === "answer" || message.type === "preview") this.#answer(message);
    for (const one of this.handOut(message)) this.emit(one.type, one);
  }

  #answer(message) {
    const asked = this.#waiting.get(message.id);
    if (!asked) return;
    clearTimeout(asked.timer);
    this.#waiting.delete(message.id);
    asked.resolve(message);
  }

  /** A silent connection is lost, whatever the browser thinks of it; a page that was busy hears first. */
  #check() {
    const before = this.#silent;
    this.#silent = performance.now() - this.#heard;
    if (this.#socket && this.#silent > SILENT_MS && before > SILENT_MS / 2 && this.isUp) this.#drop(this.#socket);
    if (!this.isUp) this.emit("down");
  }

  #drop(socket, reason = "") {
    if (socket !== this.#socket) return;
    this.lostReason = reason;
    this.#socket = null;
    socket.close();
    if (this.isUp) {
      this.isUp = false;
      this.#lostSince = performance.now();
    }
    for (const asked of this.#waiting.values()) asked.fail("the connection was lost");
    this.emit("down");
    this.#timer = setTimeout(() => this.open(), this.#pause);
    this.#pause = Math.min(LAST_PAUSE_MS, this.#pause * 1.6);
    this.#askWhy();
  }

  /** Browsers do not say why a websocket was refused; a plain request does. */
  async #askWhy() {
    try {
      const answer = await fetch("/api/state", { headers: this.authorization });
      if (answer.status === 401 || answer.status === 403) this.emit("token", answer.status);
    } catch {
      // the program does not run: "down" says so
    }
  }

  get authorization() {
    return this.token ? { Authorization: `Bearer ${this.token}` } : {};
  }

  #retryNow() {
    if (this.#socket === null) {
      this.#pause = FIRST_PAUSE_MS;
      this.open();
    }
  }
}

/** From the fragment, which browsers do not send; then out of sight, and kept for a reload. */
function readToken() {
  const found = new URLSearchParams(location.hash.slice(1)).get("token");
  if (found) {
    sessionStorage.setItem("clearway.token", found);
    history.replaceState(null, "", location.pathname);
  }
  return found ?? sessionStorage.getItem("clearway.token");
}

function newKey() {
  const bytes = crypto.getRandomValues(new Uint8Array(16));
  return Array.from(bytes, (b) => b.toString(16).padStart(2, "0")).join("");
}

function kept(name, make) {
  const value = sessionStorage.getItem(name) ?? make();
  sessionStorage.setItem(name, value);
  return value;
}
